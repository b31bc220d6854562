//! People who follow the robot.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::Pose;

use super::aside::{Aside, Meeting, WayOut};
use super::trail::Trail;
use crate::building::Building;
use crate::clock::Clock;
use crate::config::{Follow, Manners};
use crate::drive::Drive;
use crate::floor::{Floor, Opaque};
use crate::motion::RobotPose;
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::physics::{Body, Physics};

/// They keep at least this far from the robot's body, in meters.
const ROBOT_GAP_M: f64 = 0.02;

/// How wide they are on the robot's trail, as a share of the robot: they pass where it did, and cut its bends a little.
const SLIM: f64 = 0.9;

/// A person who follows the robot.
#[derive(Component, Clone, Debug)]
pub(crate) struct Follower {
    follow: Follow,
    /// Where the robot went since they met it.
    trail: Option<Trail>,
    /// Since when it has faced them from nearby.
    faced_since: Option<Duration>,
    /// They have left the trail to let it pass.
    aside: Option<Aside>,
}

impl Follower {
    pub(crate) fn new(follow: &Follow) -> Self {
        Self { follow: follow.clone(), trail: None, faced_since: None, aside: None }
    }

    /// The pose after one step.
    fn advance(&mut self, meeting: &Meeting, floor: &Floor<'_>, clock: &Clock) -> Pose {
        self.notice(meeting, floor);
        if self.trail.is_none() || self.follow.stands_at(clock.now) {
            self.faced_since = None;
            return meeting.at;
        }
        self.make_way(meeting, floor, clock.now);
        self.go(meeting, floor, clock)
    }

    /// Meets the robot, remembers where it goes, or loses it.
    fn notice(&mut self, meeting: &Meeting, floor: &Floor<'_>) {
        let robot = meeting.robot_place();
        if self.trail.as_ref().is_some_and(|trail| !trail.leads_to(&robot)) {
            (self.trail, self.aside) = (None, None);
        }
        let is_news = self.trail.as_mut().is_none_or(|trail| trail.record(robot));
        let is_near = meeting.distance_m() <= self.follow.meets_within_m;
        if is_news && is_near && self.aside.is_none() && floor.is_walkable(&meeting.place(), &robot, meeting.radius_m) {
            self.trail = Some(Trail::new(robot));
        }
    }

    /// Steps aside for a robot that has faced them for long enough.
    fn make_way(&mut self, meeting: &Meeting, floor: &Floor<'_>, now: Duration) {
        let manners = Manners::default();
        let is_faced =
            meeting.is_faced_within(manners.slow_within_m) && floor.sees(&meeting.robot_place(), &meeting.place());
        if !is_faced {
            self.faced_since = None;
            return;
        }
        let since = *self.faced_since.get_or_insert(now);
        if now.saturating_sub(since) < manners.patience {
            return;
        }
        self.faced_since = None;
        if let Some(way_out) = WayOut::find(meeting, floor) {
            self.aside.get_or_insert_default().leave(&meeting.at, way_out);
        }
    }

    /// Walks aside and back, or along the trail.
    fn go(&mut self, meeting: &Meeting, floor: &Floor<'_>, clock: &Clock) -> Pose {
        let step_m = self.follow.speed_mps * clock.dt_s();
        if let Some(aside) = &mut self.aside {
            if aside.stands(meeting, clock.now, Duration::MAX) {
                return meeting.at;
            }
            let mut next = aside.clone();
            let (to, is_back) = next.go(&meeting.at, step_m, clock.now);
            if !is_free(&to, meeting, floor) {
                return meeting.at;
            }
            self.aside = (!is_back).then_some(next);
            return to;
        }
        let way_m = self.way_m(meeting, floor, step_m);
        let Some(trail) = self.trail.as_mut().filter(|_| way_m > 0.0) else { return meeting.at };
        let (to, passed) = trail.walk(&meeting.at, way_m);
        if !is_free(&to, meeting, floor) {
            return meeting.at;
        }
        trail.pass(passed);
        to
    }

    /// How far they walk in a step to keep their distance: from a robot that they do not see, along its trail.
    fn way_m(&self, meeting: &Meeting, floor: &Floor<'_>, step_m: f64) -> f64 {
        let keeps_m = self.follow.distance_m.max(meeting.apart_m + ROBOT_GAP_M);
        let (place, robot) = (meeting.place(), meeting.robot_place());
        let mut away_m = meeting.distance_m();
        if let Some(trail) = self.trail.as_ref().filter(|_| away_m < keeps_m + step_m && !floor.sees(&place, &robot)) {
            away_m = trail.length_m(&place, &robot);
        }
        (away_m - keeps_m).min(step_m)
    }
}

/// Whether a step to a pose leads neither into the robot nor into a leaf or a fixed body, or at least no farther into
/// it.
fn is_free(to: &Pose, meeting: &Meeting, floor: &Floor<'_>) -> bool {
    let from_robot_m = (to.translation.vector - meeting.robot.translation.vector).norm();
    let slim_m = meeting.radius_m.min(SLIM * (meeting.apart_m - meeting.radius_m));
    from_robot_m >= (meeting.apart_m + ROBOT_GAP_M).min(meeting.distance_m())
        && floor.is_passable(&meeting.place(), &to.translation.vector.into(), slim_m)
}

/// Moves all followers by one step.
pub(crate) fn follow(
    clock: Res<Clock>,
    building: Res<Building>,
    mut physics: ResMut<Physics>,
    robot: Single<(&RobotPose, &Drive)>,
    opaque: Query<(&Obstacle, &ObstaclePose), With<Opaque>>,
    mut people: Query<(&Body, &Obstacle, &mut ObstaclePose, &mut Follower), Without<Opaque>>,
) {
    if people.is_empty() {
        return;
    }
    let floor = Floor::new(&building, opaque);
    for (body, obstacle, mut pose, mut follower) in &mut people {
        let at = follower.advance(&Meeting::new(&pose, obstacle, *robot), &floor, &clock);
        if at != pose.0 {
            pose.0 = at;
            physics.carry(*body, &at);
        }
    }
}
