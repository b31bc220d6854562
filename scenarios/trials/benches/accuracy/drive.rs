//! A simulated robot that follows a path exactly, regardless of its estimate, to test localization alone.

use maps::{OccupancyGrid, Point, Pose};
use nav::{Atlas, Costmap, CostmapParameters, PlanError, plan};
use robot::{Reading, Robot, RobotModel, Streams, VelocityCommand};
use sim::{SimConfig, SimError, Simulation};

/// How far ahead on its path the robot aims, in meters.
const AHEAD_M: f64 = 0.4;

/// The robot turns on the spot if its target is this far to the side, in radians.
const TURN_ON_THE_SPOT_RAD: f64 = 0.8;

/// A robot driving along a path.
pub(crate) struct Drive {
    pub(crate) sim: Simulation,
    path: Vec<Point>,
    next: usize,
}

impl Drive {
    /// A robot at rest at the beginning of a path, facing along it.
    ///
    /// # Errors
    /// [`SimError`] if the simulation cannot be set up.
    pub(crate) fn along(
        path: Vec<Point>,
        map: &OccupancyGrid,
        config: &SimConfig,
        streams: &Streams,
    ) -> Result<Self, SimError> {
        let first = path.first().copied().unwrap_or_default();
        let towards = path.iter().map(|point| point - first).find(|offset| offset.norm() > AHEAD_M).unwrap_or_default();
        let start = maps::pose(first.x, first.y, libm::atan2(towards.y, towards.x));
        Ok(Self { sim: Simulation::new(config, map, start, start, streams)?, path, next: 0 })
    }

    /// Simulates one step and appends its readings. Returns the true pose, or none at the end of the path.
    pub(crate) fn step(&mut self, readings: &mut Vec<Reading>) -> Option<Pose> {
        let at = self.sim.truth().pose();
        let is_near = |point: &Point| (point - Point::from(at.translation.vector)).norm() < AHEAD_M;
        while self.path.get(self.next).is_some_and(is_near) {
            self.next += 1;
        }
        let target = self.path.get(self.next)?;
        let command = steered(&at.inverse_transform_point(target), self.sim.model());
        self.sim.drive(command);
        self.sim.step();
        self.sim.read(readings);
        Some(self.sim.truth().pose())
    }
}

fn steered(target: &Point, model: &RobotModel) -> VelocityCommand {
    let bearing_rad = libm::atan2(target.y, target.x);
    let linear_mps = if bearing_rad.abs() > TURN_ON_THE_SPOT_RAD { 0.0 } else { model.max_linear_mps };
    let angular_radps = (2.0 * bearing_rad).clamp(-model.max_angular_radps, model.max_angular_radps);
    VelocityCommand { linear_mps, angular_radps }
}

/// A path through all the points, in the `map` frame.
///
/// # Errors
/// [`PlanError`] if there is none.
///
/// # Panics
/// If the radius of the atlas's robot is invalid.
pub(crate) fn route(atlas: &Atlas, by_way_of: &[Point]) -> Result<Vec<Point>, PlanError> {
    let costmap = Costmap::on(atlas, CostmapParameters::of(atlas.model())).expect("a robot has a radius");
    let legs = by_way_of.windows(2).map(|leg| plan(&costmap, &leg[0], &leg[1], 0.5));
    Ok(legs.collect::<Result<Vec<_>, _>>()?.concat())
}
