//! What is known of a log beyond its events.

use std::cell::Cell;
use std::sync::Arc;
use std::time::Duration;

use recording::{Header, Premises, RobotBody};
use trials::replay::way::{Way, WayPlace};

/// What is known of a log beyond its events.
#[derive(Default)]
pub(super) struct Around {
    /// When the events begin, once the first has been read: in nanoseconds since 1970 if their times are.
    pub(super) start_ns: Cell<Option<i64>>,
    /// When the message read last was recorded, in nanoseconds since 1970.
    pub(super) newest_log_ns: Cell<Option<i64>>,
    /// Where the robot was, if there is a map.
    pub(super) way: Option<Way>,
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
