//! Why a simulation refuses a request.

use std::fmt;

/// Why a simulation cannot be built, or the robot cannot be placed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// Settings have invalid values: all of them, in the order of [`SimConfig`](crate::SimConfig).
    #[error("invalid settings of the simulation: {}", list(.0))]
    Settings(Vec<BadSetting>),
    /// The robot or the charging station would be outside the map.
    #[error("{what} ({x_m}, {y_m}) is outside the map, which is {width_m:.2} m × {height_m:.2} m")]
    OutsideMap {
        /// The thing that was to be placed there.
        what: Placement,
        /// x of the place in the `map` frame, in meters.
        x_m: f64,
        /// y of the place in the `map` frame, in meters.
        y_m: f64,
        /// Width of the map, in meters.
        width_m: f64,
        /// Height of the map, in meters.
        height_m: f64,
    },
    /// The robot's body would overlap a wall.
    #[error(
        "{what} ({x_m}, {y_m}) is {distance_m:.3} m from the wall at ({wall_x_m:.3}, {wall_y_m:.3}), \
         but the robot's radius is {radius_m} m"
    )]
    InWall {
        /// The thing that was to be placed there.
        what: Placement,
        /// x of the place in the `map` frame, in meters.
        x_m: f64,
        /// y of the place in the `map` frame, in meters.
        y_m: f64,
        /// Radius of the robot, in meters.
        radius_m: f64,
        /// Distance from the place to the nearest occupied cell, in meters.
        distance_m: f64,
        /// x of that cell's center in the `map` frame, in meters.
        wall_x_m: f64,
        /// y of that cell's center in the `map` frame, in meters.
        wall_y_m: f64,
    },
    /// The robot's body would overlap an obstacle.
    #[error(
        "{what} ({x_m}, {y_m}) is {distance_m:.3} m from the obstacle '{obstacle}', \
         but the robot's radius is {radius_m} m"
    )]
    InObstacle {
        /// The thing that was to be placed there.
        what: Placement,
        /// x of the place in the `map` frame, in meters.
        x_m: f64,
        /// y of the place in the `map` frame, in meters.
        y_m: f64,
        /// Radius of the robot, in meters.
        radius_m: f64,
        /// Distance from the place to the obstacle, in meters.
        distance_m: f64,
        /// Name of the obstacle.
        obstacle: String,
    },
}

/// Why a box cannot be picked up or put down.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoxError {
    /// No movable obstacle has this name.
    #[error("there is no box '{0}' that can be moved")]
    Unknown(String),
    /// It has been picked up already.
    #[error("the box '{0}' has been picked up already")]
    Lifted(String),
    /// It has not been picked up.
    #[error("the box '{0}' is on the floor")]
    OnFloor(String),
    /// It cannot be put down there.
    #[error("there is no room for the box '{name}' at ({x_m:.2}, {y_m:.2}): {obstruction}")]
    NoRoom {
        /// Name of the box.
        name: String,
        /// x of the place in the `map` frame, in meters.
        x_m: f64,
        /// y of the place in the `map` frame, in meters.
        y_m: f64,
        /// The first thing in the way.
        obstruction: Obstruction,
    },
}

/// The thing that leaves no room for a box.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Obstruction {
    /// The pose is not on the map.
    Edge,
    /// A wall.
    Wall,
    /// The robot.
    Robot,
    /// The obstacle with this name.
    Obstacle(String),
}

impl fmt::Display for Obstruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Edge => f.write_str("that is not on the map"),
            Self::Wall => f.write_str("a wall is in the way"),
            Self::Robot => f.write_str("the robot is in the way"),
            Self::Obstacle(name) => write!(f, "'{name}' is in the way"),
        }
    }
}

/// The thing that is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Placement {
    /// The robot at the start of a run.
    Start,
    /// The charging station.
    Station,
    /// The robot, moved elsewhere during a run.
    Kidnapping,
}

impl fmt::Display for Placement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "the start",
            Self::Station => "the charging station",
            Self::Kidnapping => "the pose to which the robot is moved",
        })
    }
}

/// A setting with an invalid value.
#[derive(Clone, Debug, PartialEq)]
pub struct BadSetting {
    /// Its path in [`SimConfig`](crate::SimConfig) or [`Faults`](crate::Faults), for example `battery.initial_pct` or
    /// `obstacles[2].motion.speed_mps`.
    pub setting: String,
    /// The value; durations in seconds.
    pub value: String,
    /// The accepted values, for example `greater than 0`.
    pub accepted: &'static str,
}

impl fmt::Display for BadSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, must be {}", self.setting, self.value, self.accepted)
    }
}

fn list(settings: &[BadSetting]) -> String {
    settings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
