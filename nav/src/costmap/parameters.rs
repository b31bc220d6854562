//! The parameters of the costmap.

use robot::RobotModel;

use crate::{Error, error::check};

/// Parameters of a [`Costmap`](crate::Costmap); names as in Nav2's costmap where it has them.
#[derive(Clone, Debug, PartialEq)]
pub struct CostmapParameters {
    /// Radius of the robot's body, in metres. Default 0.30.
    pub robot_radius: f64,
    /// Up to this distance from an obstacle being there costs something, in metres. Default 0.80 (Nav2: 0.55): with
    /// the slower fall below, corridors are driven in their middle and doorways in theirs. At most 60 cells count.
    pub inflation_radius: f64,
    /// How fast the cost falls with the distance from the robot's radius, per metre. Default 5.0 (Nav2: 10.0).
    pub cost_scaling_factor: f64,
    /// Lasers mark obstacles up to this range, in metres. Default 3.0 (Nav2: 2.5): beyond, a degree of heading puts a
    /// wall into a cell that is free.
    pub obstacle_max_range: f64,
    /// Lasers clear what they see through up to this range, in metres. Default 3.5 (Nav2: 3.0).
    pub raytrace_max_range: f64,
    /// A hit this near to an obstacle of the map is that obstacle, in metres. Default 0.12: what pose and range are
    /// off by. Nav2 has no such parameter.
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

    /// Whether the values make sense.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first that does not.
    pub fn check(&self) -> Result<(), Error> {
        let positive = |name, value: f64| (name, value, value > 0.0 && value.is_finite(), "positive");
        let at_least_zero = |name, value: f64| (name, value, value >= 0.0 && value.is_finite(), "zero or positive");
        check(&[
            positive("robot_radius", self.robot_radius),
            (
                "inflation_radius",
                self.inflation_radius,
                self.inflation_radius >= self.robot_radius,
                "at least robot_radius",
            ),
            at_least_zero("cost_scaling_factor", self.cost_scaling_factor),
            at_least_zero("obstacle_max_range", self.obstacle_max_range),
            at_least_zero("raytrace_max_range", self.raytrace_max_range),
            at_least_zero("map_tolerance", self.map_tolerance),
        ])
    }
}
