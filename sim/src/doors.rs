//! Doors: leaves that swing or slide, open and close on schedule or on command, and never move onto the robot.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::{Point, Pose, Shape};
use nalgebra::UnitComplex;

use crate::clock::Clock;
use crate::config::{Door, Opening};
use crate::drive::Drive;
use crate::faults::Faults;
use crate::motion::RobotPose;
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::physics::{Body, Physics};
use crate::room::distance_to;

/// A leaf that moves keeps this far from the robot, in meters.
const ROBOT_GAP_M: f64 = 0.02;

/// A door's leaf.
#[derive(Component, Clone, Debug)]
pub(crate) struct Leaf {
    door: Door,
    /// The pose of its center when it is closed.
    closed: Pose,
    length_m: f64,
    /// How far it is open, from 0 to 1.
    open: f64,
    /// Whether it should be open, regardless of its schedule.
    commanded: Option<bool>,
}

impl Leaf {
    /// The leaf of a door in its initial state, given the shape and pose of the closed leaf.
    pub(crate) fn new(door: &Door, shape: &Shape, closed: Pose) -> Self {
        let length_m = match *shape {
            Shape::Box { length_m, .. } => length_m,
            Shape::Disc { radius_m } => 2.0 * radius_m,
        };
        let open = if door.is_closed_at(Duration::ZERO) { 0.0 } else { 1.0 };
        Self { door: door.clone(), closed, length_m, open, commanded: None }
    }

    /// How far it is open, from 0 to 1.
    pub(crate) fn opening(&self) -> f64 {
        self.open
    }

    /// How far its joint has moved from where it is closed: a leaf that swings in radians, counter-clockwise; one that
    /// slides in meters, along its length.
    pub(crate) fn joint(&self) -> f64 {
        match self.door.opening {
            Opening::Slide => self.open * self.length_m,
            Opening::Left => self.open * std::f64::consts::FRAC_PI_2,
            Opening::Right => -self.open * std::f64::consts::FRAC_PI_2,
        }
    }

    /// Opens or closes it, overriding its schedule.
    pub(crate) fn command(&mut self, open: bool) {
        self.commanded = Some(open);
    }

    /// The pose of the leaf's center.
    pub(crate) fn pose(&self) -> Pose {
        let along = |length_m: f64| Point::new(length_m, 0.0);
        let swung = |turn_rad: f64| {
            let hinge = self.closed * along(-0.5 * self.length_m);
            let rotation = self.closed.rotation * UnitComplex::new(turn_rad);
            Pose::from_parts((hinge + rotation * along(0.5 * self.length_m).coords).coords.into(), rotation)
        };
        match self.door.opening {
            Opening::Slide => {
                let middle = self.closed * along(self.joint());
                Pose::from_parts(middle.coords.into(), self.closed.rotation)
            }
            Opening::Left | Opening::Right => swung(self.joint()),
        }
    }

    /// Moves one step towards the state required at this time; false if it stays.
    fn advance(&mut self, now: Duration, dt_s: f64, keeps_clear: impl Fn(&Pose) -> bool) -> bool {
        let opens = self.commanded.unwrap_or_else(|| !self.door.is_closed_at(now));
        let wanted = if opens { 1.0 } else { 0.0 };
        if self.open == wanted {
            return false;
        }
        let moving_s = self.door.moving.as_secs_f64();
        let most = if moving_s > 0.0 { dt_s / moving_s } else { 1.0 };
        let before = self.open;
        self.open += (wanted - before).clamp(-most, most);
        let moves = keeps_clear(&self.pose());
        if !moves {
            self.open = before;
        }
        moves
    }
}

/// Moves all leaves that are not stuck by one step.
pub(crate) fn move_doors(
    clock: Res<Clock>,
    faults: Res<Faults>,
    mut physics: ResMut<Physics>,
    robot: Single<(&RobotPose, &Drive)>,
    mut leaves: Query<(&Body, &Obstacle, &mut ObstaclePose, &mut Leaf)>,
) {
    let (robot, needed_m) = (Point::from(robot.0.0.translation.vector), robot.1.robot_radius_m() + ROBOT_GAP_M);
    for (body, obstacle, mut pose, mut leaf) in &mut leaves {
        if faults.stuck_doors.contains(&obstacle.name) {
            continue;
        }
        let now_m = distance_to(&obstacle.shape, &pose.0, &robot);
        let keeps_clear = |pose: &Pose| distance_to(&obstacle.shape, pose, &robot) >= needed_m.min(now_m);
        if leaf.advance(clock.now, clock.dt_s(), keeps_clear) {
            pose.0 = leaf.pose();
            physics.carry(*body, &pose.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    const SHAPE: Shape = Shape::Box { length_m: 1.0, width_m: 0.05 };

    fn door(opening: Opening, closed_s: [u64; 2], every_s: Option<u64>) -> Leaf {
        let door = Door {
            opening,
            moving: Duration::from_secs(2),
            closed: vec![(Duration::from_secs(closed_s[0]), Duration::from_secs(closed_s[1]))],
            every: every_s.map(Duration::from_secs),
        };
        Leaf::new(&door, &SHAPE, pose(2.0, 1.0, 0.0))
    }

    /// How far it is open after each second.
    fn course(leaf: &mut Leaf, seconds: u64, keeps_clear: impl Fn(&Pose) -> bool) -> Vec<f64> {
        let mut second = |at: u64| {
            (0..50).for_each(|_| {
                leaf.advance(Duration::from_secs(at), 0.02, &keeps_clear);
            });
            (leaf.open * 100.0).round() / 100.0
        };
        (0..seconds).map(&mut second).collect()
    }

    #[test]
    fn a_door_keeps_its_schedule_repeatedly() {
        let mut leaf = door(Opening::Slide, [3, 6], Some(8));
        let opens = course(&mut leaf, 13, |_| true);
        assert_eq!(opens, [1.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 0.5, 0.0]);
        assert_eq!(door(Opening::Slide, [0, 6], None).open, 0.0);
    }

    #[test]
    fn a_command_replaces_the_schedule() {
        let mut leaf = door(Opening::Slide, [2, 4], Some(4));
        leaf.command(false);
        assert_eq!(course(&mut leaf, 5, |_| true), [0.5, 0.0, 0.0, 0.0, 0.0]);
        leaf.command(true);
        assert_eq!(course(&mut leaf, 5, |_| true), [0.5, 1.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn leaves_slide_into_the_wall_or_swing_about_their_hinge() {
        for (opening, middle) in
            [(Opening::Slide, (3.0, 1.0)), (Opening::Left, (1.5, 1.5)), (Opening::Right, (1.5, 0.5))]
        {
            let leaf = door(opening, [5, 6], None);
            assert!((leaf.pose().translation.vector - Point::new(middle.0, middle.1).coords).norm() < 1e-12);
        }
        let closed = door(Opening::Left, [0, 6], None);
        assert!((closed.pose().translation.vector - closed.closed.translation.vector).norm() < 1e-12);
    }

    #[test]
    fn a_leaf_waits_for_obstacles_in_its_way() {
        let mut leaf = door(Opening::Left, [0, 100], None);
        leaf.open = 1.0;
        let foot = Point::new(2.0, 1.3);
        let opens = course(&mut leaf, 4, |pose| distance_to(&SHAPE, pose, &foot) > 0.3);
        assert!(opens[3] > 0.2 && opens[3] == opens[2], "{opens:?}");
        assert_eq!(course(&mut leaf, 4, |_| true)[3], 0.0, "it continues when the way is free");
    }
}
