//! What is known of a log besides its events.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use recording::{Header, Premises, RobotBody};
use replay::live_pose::LivePose;
use replay::trajectory::{Trajectory, TrajectoryPoint};

use crate::logged_run::RecordedTree;

/// What is known of a log besides its events.
#[derive(Default)]
pub struct LogContext {
    /// When the events begin, after the first has been read: in nanoseconds since 1970 if their clock counts from then.
    pub start_ns: Cell<Option<i64>>,
    /// When the last message read was recorded, in nanoseconds since 1970.
    pub newest_log_ns: Cell<Option<i64>>,
    /// The trajectory of the robot in a bag, if the bag has a map.
    pub(crate) trajectory: Option<Trajectory>,
    /// The pose of a running robot, if a page shows it.
    pub(crate) live_pose: Option<Rc<RefCell<LivePose>>>,
    /// The tree of a recording, with the outcomes of its nodes.
    pub(crate) tree: Option<Rc<RecordedTree>>,
    /// Whether the times of events are those at which the log received them, rather than stamps.
    pub(crate) is_by_log: bool,
    /// Whether the ticks of the tree are unknown.
    pub lacks_ticks: bool,
}

impl LogContext {
    /// The time of a point of the trajectory, on the clock of the events.
    pub(crate) fn time(&self, point: &TrajectoryPoint) -> Duration {
        let ns = point.stamp_ns.filter(|_| !self.is_by_log).unwrap_or(point.log_ns);
        let since = ns.saturating_sub(self.start_ns.get().unwrap_or(ns));
        Duration::from_nanos(since.max(0).unsigned_abs())
    }

    /// Adds the tree, the map and the robot to a header.
    pub(crate) fn describe(&self, header: &mut Header) {
        self.tree.iter().for_each(|tree| tree.describe(header));
        if let Some(live_pose) = &self.live_pose {
            let mut live_pose = live_pose.borrow_mut();
            let Some(map) = live_pose.map().cloned().map(Arc::new) else { return };
            let start = live_pose.pose().unwrap_or_else(|| map.origin());
            header.premises = Some(Premises { map, places: Vec::new(), start, station: None, destination: None });
            let lasers = live_pose.laser().cloned().into_iter().collect();
            header.robot = Some(RobotBody { radius_m: 0.0, lasers });
            return;
        }
        let Some(Trajectory { map, points }) = &self.trajectory else { return };
        let start = points[0].pose;
        header.premises =
            Some(Premises { map: Arc::new(map.clone()), places: Vec::new(), start, station: None, destination: None });
        // Its size is unknown, so it is drawn as a symbol.
        header.robot = Some(RobotBody { radius_m: 0.0, lasers: Vec::new() });
        let first = points.iter().find_map(|point| Some((point.pose, point.odometry?)));
        let Some((pose, odometry)) = first else { return };
        let onto_map = pose * odometry.inverse();
        let path = points.iter().filter_map(|point| Some((onto_map * point.odometry?).translation.vector.into()));
        header.origin.odometry = path.collect();
    }
}
