//! What is known of a log beyond its events.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use maps::{Point, Pose};
use recording::{Header, Premises, RobotBody, Scene};
use robot::LaserScan;
use trials::replay::sight::Sight;
use trials::replay::way::{Way, WayPlace};

/// How often a page shows where a robot is.
const OFTEN: Duration = Duration::from_millis(100);

/// What is known of a log beyond its events.
#[derive(Default)]
pub(super) struct Around {
    /// When the events begin, once the first has been read: in nanoseconds since 1970 if their times are.
    pub(super) start_ns: Cell<Option<i64>>,
    /// When the message read last was recorded, in nanoseconds since 1970.
    pub(super) newest_log_ns: Cell<Option<i64>>,
    /// Where the robot was, if there is a map.
    pub(super) way: Option<Way>,
    /// Where the robot is, if it runs and is shown.
    pub(super) sight: Option<Rc<RefCell<Sight>>>,
    /// Whether the events have the times of the log, and not stamps.
    pub(super) is_by_log: bool,
}

impl Around {
    /// The time of a place, in that of the events.
    pub(super) fn time(&self, place: &WayPlace) -> Duration {
        let ns = place.stamp_ns.filter(|_| !self.is_by_log).unwrap_or(place.log_ns);
        let since = ns.saturating_sub(self.start_ns.get().unwrap_or(ns));
        Duration::from_nanos(since.max(0).unsigned_abs())
    }

    pub(super) fn describe(&self, header: &mut Header) {
        if let Some(sight) = &self.sight {
            let mut sight = sight.borrow_mut();
            let start = sight.pose().unwrap_or_default();
            let Some(map) = sight.map().cloned().map(Arc::new) else { return };
            header.premises = Some(Premises { map, places: Vec::new(), start, station: None, destination: None });
            header.robot = Some(RobotBody { radius_m: 0.0, lasers: sight.laser().cloned().into_iter().collect() });
            return;
        }
        let Some(Way { map, places }) = &self.way else { return };
        let start = places[0].pose;
        header.premises =
            Some(Premises { map: Arc::new(map.clone()), places: Vec::new(), start, station: None, destination: None });
        // Its size is unknown: it is drawn as a sign.
        header.robot = Some(RobotBody { radius_m: 0.0, lasers: Vec::new() });
        let first = places.iter().find_map(|place| Some((place.pose, place.odometry?)));
        let Some((pose, odometry)) = first else { return };
        let onto_map = pose * odometry.inverse();
        let path = places.iter().filter_map(|place| Some((onto_map * place.odometry?).translation.vector.into()));
        header.origin.odometry = path.collect();
    }
}

/// What a page shows of a robot that runs, now and then.
pub(super) struct Looking {
    sight: Rc<RefCell<Sight>>,
    /// Whether its scans can be shown: its laser was known at the beginning.
    has_laser: bool,
    due: Duration,
    /// The path that is shown.
    path: Vec<Point>,
}

impl Looking {
    /// At the beginning of a run with this header.
    pub(super) fn begin(around: &Around, header: &Header) -> Option<Self> {
        let has_laser = header.robot.as_ref().is_some_and(|robot| !robot.lasers.is_empty());
        let sight = around.sight.as_ref().filter(|_| header.premises.is_some())?;
        Some(Self { sight: Rc::clone(sight), has_laser, due: Duration::ZERO, path: Vec::new() })
    }

    /// Where the robot is, if that is due, and what it sees, if that is new.
    pub(super) fn look(&mut self, time: Duration) -> Option<(Pose, Option<Scene>)> {
        if time < self.due {
            return None;
        }
        self.due = time + OFTEN;
        let mut sight = self.sight.borrow_mut();
        let pose = sight.pose()?;
        let scan = sight.next_scan().filter(|_| self.has_laser);
        if scan.is_none() && sight.path() == self.path {
            return Some((pose, None));
        }
        self.path = sight.path().to_vec();
        let scans = scan.map(|ranges_m| Arc::new(LaserScan { time, laser: 0, ranges_m })).into_iter().collect();
        Some((pose, Some(Scene { scans, path: self.path.clone(), ..Scene::default() })))
    }
}
