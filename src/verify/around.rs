//! What is known of a log beyond its events.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use maps::{Point, Pose};
use recording::{Header, Premises, RobotBody, Scene};
use robot::LaserScan;
use trials::replay::sight::{Glance, Sight};
use trials::replay::way::{Way, WayPlace};

use super::answers::Answers;

/// How often a page shows what a robot sees: a page that is open for days keeps it all.
const OFTEN: Duration = Duration::from_millis(500);

/// What is known of a log beyond its events.
#[derive(Default)]
pub(crate) struct Around {
    /// When the events begin, once the first has been read: in nanoseconds since 1970 if their times are.
    pub(super) start_ns: Cell<Option<i64>>,
    /// When the message read last was recorded, in nanoseconds since 1970.
    pub(super) newest_log_ns: Cell<Option<i64>>,
    /// Where the robot was, if there is a map.
    pub(super) way: Option<Way>,
    /// Where the robot is, if it runs and is shown.
    pub(super) sight: Option<Rc<RefCell<Sight>>>,
    /// What the nodes of a tree answered, if that is recorded.
    pub(super) answers: Option<Answers>,
    /// Whether the events have the times of the log, and not stamps.
    pub(super) is_by_log: bool,
    /// Whether it is not known when the tree was ticked.
    pub(super) lacks_ticks: bool,
}

impl Around {
    /// Around a tree of which it is not known when it was ticked.
    pub(crate) fn without_ticks() -> Self {
        Self { lacks_ticks: true, ..Self::default() }
    }

    /// The time of a place, in that of the events.
    pub(super) fn time(&self, place: &WayPlace) -> Duration {
        let ns = place.stamp_ns.filter(|_| !self.is_by_log).unwrap_or(place.log_ns);
        let since = ns.saturating_sub(self.start_ns.get().unwrap_or(ns));
        Duration::from_nanos(since.max(0).unsigned_abs())
    }

    pub(super) fn describe(&self, header: &mut Header) {
        self.answers.iter().for_each(|answers| answers.describe(header));
        if let Some(sight) = &self.sight {
            let mut sight = sight.borrow_mut();
            let Some(map) = sight.map().cloned().map(Arc::new) else { return };
            let start = sight.pose().unwrap_or_else(|| map.origin());
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
    /// When its surroundings are shown again, and with which path they were.
    due: Duration,
    path: Vec<Point>,
}

impl Looking {
    /// At the beginning of a run with this header.
    pub(super) fn begin(around: &Around, header: &Header) -> Option<Self> {
        let has_laser = header.robot.as_ref().is_some_and(|robot| !robot.lasers.is_empty());
        let sight = around.sight.as_ref()?;
        sight.borrow_mut().begin();
        header.premises.as_ref()?;
        Some(Self { sight: Rc::clone(sight), has_laser, due: Duration::ZERO, path: Vec::new() })
    }

    /// Where the robot was at a time, and what it saw, if that is new and due.
    pub(super) fn look(&mut self, time: Duration, around: &Around) -> Option<(Pose, Option<Scene>)> {
        let ns = i64::try_from(time.as_nanos()).unwrap_or(i64::MAX);
        // Stamps have another clock.
        let until_ns =
            around.start_ns.get().filter(|_| around.is_by_log).map_or(i64::MAX, |start| start.saturating_add(ns));
        let Glance { pose, scan, path, .. } = self.sight.borrow_mut().look(until_ns)?;
        let scan = scan.filter(|_| self.has_laser);
        if time < self.due || scan.is_none() && path == self.path {
            return Some((pose, None));
        }
        (self.due, self.path) = (time + OFTEN, path.clone());
        let scans = scan.map(|ranges_m| Arc::new(LaserScan { time, laser: 0, ranges_m })).into_iter().collect();
        Some((pose, Some(Scene { scans, path, ..Scene::default() })))
    }
}
