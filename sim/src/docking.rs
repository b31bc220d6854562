//! The charging station, and docking.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::Pose;

use crate::battery::Battery;
use crate::clock::Clock;
use crate::config::DockingConfig;
use crate::drive::Drive;
use crate::faults::Faults;
use crate::motion::{Motion, RobotPose};

/// The charging station: the pose of a docked robot, in the `map` frame, unless a fault has moved it; `None` if there
/// is no station. It is not solid.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Station(pub(crate) Option<Pose>);

/// Determines whether the robot is docked.
#[derive(Component, Clone, Debug)]
pub(crate) struct Dock {
    config: DockingConfig,
    rested: Duration,
    docked: bool,
}

impl Dock {
    pub(crate) fn new(config: &DockingConfig) -> Self {
        Self { config: *config, rested: Duration::ZERO, docked: false }
    }

    pub(crate) fn is_docked(&self) -> bool {
        self.docked
    }

    /// Takes the robot away from its resting place.
    pub(crate) fn leave(&mut self) {
        (self.rested, self.docked) = (Duration::ZERO, false);
    }

    /// Processes one step.
    pub(crate) fn update(&mut self, robot: &Pose, station: &Pose, at_rest: bool, dt: Duration) {
        self.rested = if at_rest { self.rested + dt } else { Duration::ZERO };
        let off = station.inv_mul(robot);
        let near = off.translation.vector.norm() <= self.config.distance_m;
        let aligned = off.rotation.angle().abs() <= self.config.angle_rad;
        self.docked = near && aligned && at_rest && self.rested >= self.config.rest;
    }
}

/// Docks, drains and charges.
pub(crate) fn update_battery(
    clock: Res<Clock>,
    faults: Res<Faults>,
    station: Single<&Station>,
    robot: Single<(&RobotPose, &Motion, &Drive, &mut Dock, &mut Battery)>,
) {
    let (pose, motion, drive, mut dock, mut battery) = robot.into_inner();
    match faults.station.as_ref().or(station.0.as_ref()) {
        Some(station) => dock.update(&pose.0, station, motion.at_rest, clock.dt),
        None => dock.leave(),
    }
    battery.update(dock.is_docked(), drive.is_powered(), &faults.battery, clock.dt_s());
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    const DT: Duration = Duration::from_millis(20);

    /// Whether a robot that rests at a pose for this many steps is docked to a station at (−7.5, 9.0, 180°).
    fn docked_after(steps: usize, at: Pose) -> bool {
        let mut dock = Dock::new(&DockingConfig::default());
        (0..steps).for_each(|_| dock.update(&at, &pose(-7.5, 9.0, std::f64::consts::PI), true, DT));
        dock.is_docked()
    }

    #[test]
    fn a_robot_is_docked_after_a_second_at_rest() {
        assert!(!docked_after(49, pose(-7.3, 9.1, 3.0)));
        assert!(docked_after(50, pose(-7.3, 9.1, 3.0)));
    }

    #[test]
    fn distance_and_heading_both_count_even_across_180_degrees() {
        assert!(docked_after(50, pose(-7.5, 9.49, -3.0)));
        assert!(!docked_after(50, pose(-7.5, 9.51, -3.0)));
        assert!(!docked_after(50, pose(-7.5, 9.0, 2.9)));
    }

    #[test]
    fn passing_by_is_not_docking_and_leaving_ends_it() {
        let station = pose(0.0, 0.0, 0.0);
        let mut dock = Dock::new(&DockingConfig::default());
        for step in 0..200 {
            dock.update(&station, &station, step % 40 != 0, DT);
            assert!(!dock.is_docked());
        }
        (0..50).for_each(|_| dock.update(&station, &station, true, DT));
        assert!(dock.is_docked());
        dock.update(&station, &station, false, DT);
        assert!(!dock.is_docked());
    }
}
