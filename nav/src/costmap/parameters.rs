//! The parameters of the costmap.

use robot::RobotModel;

use crate::Error;
use crate::error::{at_least_zero, check, positive, require};

/// Parameters of a [`Costmap`](crate::Costmap). Names are those of Nav2's costmap where it has the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct CostmapParameters {
    /// Radius of the robot's body, in meters. Default 0.30.
    pub robot_radius: f64,
    /// Up to this distance from an obstacle, cells have a cost, in meters. Default 0.80 (Nav2: 0.55): with the slower
    /// decay below, the robot drives in the middle of corridors and doorways. At most 60 cells.
    pub inflation_radius: f64,
    /// How fast the cost decays with the distance beyond the robot's radius, per meter. Default 5.0 (Nav2: 10.0).
    pub cost_scaling_factor: f64,
    /// Lasers mark obstacles up to this range, in meters. Default 3.0 (Nav2: 2.5): beyond it, an error of one degree in
    /// heading moves a wall into a free cell.
    pub obstacle_max_range: f64,
    /// Lasers clear marks up to this range, in meters. Default 3.5 (Nav2: 3.0).
    pub raytrace_max_range: f64,
    /// A hit this close to an obstacle of the map counts as that obstacle, in meters. Default 0.12: the typical error
    /// of pose and range. Nav2 has no such parameter.
    pub map_tolerance: f64,
}

impl Default for CostmapParameters {
    fn default() -> Self {
        Self {
            robot_radius: 0.30,
            inflation_radius: 0.80,
            cost_scaling_factor: 5.0,
            obstacle_max_range: 3.0,
            raytrace_max_range: 3.5,
            map_tolerance: 0.12,
        }
    }
}

impl CostmapParameters {
    /// The defaults for a robot.
    #[must_use]
    pub fn of(model: &RobotModel) -> Self {
        Self { robot_radius: model.radius_m, inflation_radius: model.radius_m + 0.5, ..Self::default() }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first invalid one.
    pub fn check(&self) -> Result<(), Error> {
        let is_wide = self.inflation_radius >= self.robot_radius;
        check(&[
            positive("robot_radius", self.robot_radius),
            require("inflation_radius", self.inflation_radius, is_wide, "at least robot_radius"),
            at_least_zero("cost_scaling_factor", self.cost_scaling_factor),
            at_least_zero("obstacle_max_range", self.obstacle_max_range),
            at_least_zero("raytrace_max_range", self.raytrace_max_range),
            at_least_zero("map_tolerance", self.map_tolerance),
        ])
    }
}
