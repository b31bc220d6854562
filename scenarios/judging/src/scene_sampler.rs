//! The poses and scenes of a running robot, at intervals, for a live page.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use maps::{Point, Pose};
use recording::{Header, Scene};
use replay::live_pose::{LivePose, PoseSample};
use robot::LaserScan;

use crate::log_context::LogContext;

/// The shortest time between scenes: a page that is open for days keeps all of them.
const SCENE_PERIOD: Duration = Duration::from_millis(500);

pub(crate) struct SceneSampler {
    live_pose: Rc<RefCell<LivePose>>,
    /// Whether scans can be shown: the laser was known at the beginning.
    has_laser: bool,
    /// When the next scene is due, and the path in the last one.
    due: Duration,
    path: Vec<Point>,
}

impl SceneSampler {
    /// Begins at the beginning of a run with this header; none without a running robot and its map.
    pub(crate) fn begin(context: &LogContext, header: &Header) -> Option<Self> {
        let has_laser = header.robot.as_ref().is_some_and(|robot| !robot.lasers.is_empty());
        let live_pose = context.live_pose.as_ref()?;
        live_pose.borrow_mut().begin();
        header.premises.as_ref()?;
        Some(Self { live_pose: Rc::clone(live_pose), has_laser, due: Duration::ZERO, path: Vec::new() })
    }

    /// The pose of the robot at a time, if it is new, and a scene, if one is due.
    pub(crate) fn sample(&mut self, time: Duration, context: &LogContext) -> Option<(Pose, Option<Scene>)> {
        let ns = i64::try_from(time.as_nanos()).unwrap_or(i64::MAX);
        // Stamps are on another clock than the samples, so all samples are taken.
        let until_ns =
            context.start_ns.get().filter(|_| context.is_by_log).map_or(i64::MAX, |start| start.saturating_add(ns));
        let PoseSample { pose, scan, path, .. } = self.live_pose.borrow_mut().sample(until_ns)?;
        let scan = scan.filter(|_| self.has_laser);
        if time < self.due || scan.is_none() && path == self.path {
            return Some((pose, None));
        }
        (self.due, self.path) = (time + SCENE_PERIOD, path.clone());
        let scans = scan.map(|ranges_m| Arc::new(LaserScan { time, laser: 0, ranges_m })).into_iter().collect();
        Some((pose, Some(Scene { scans, path, ..Scene::default() })))
    }
}
