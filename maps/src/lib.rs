//! Occupancy grids, places, frames and poses; loading and saving.

mod grid;
mod places;
mod pose;

pub use grid::{Cell, CellIndex, OccupancyGrid};
pub use places::{Place, Places};
pub use pose::{Point, Pose, heading, pose, wrap_angle};
