//! Occupancy grids, places, frames and poses; loading and saving.
//!
//! A robot and its user must agree on three things, which this crate defines.
//!
//! **Where things are.** A [`Pose`] is a position and a heading in meters and radians; everything on a map is in the
//! `map` frame (in an image: x to the right, y up, angles counter-clockwise).
//!
//! **What is there.** An [`OccupancyGrid`] divides a floor into cells that are free, occupied or
//! [unknown](Cell::Unknown). [`load_map`] reads what ROS's `map_server` reads, YAML with a PGM, PNG or
//! BMP, and [`save_map`] writes it.
//!
//! **Names of places.** [`Places`] are named points ("RechargingStation") and areas ("Destination"), listed in a
//! [`PlacesFile`] beside the map.
//!
//! ```
//! use maps::{Place, house, pose};
//!
//! let map = house::map();
//! let (pose_of_station, position_tolerance_m, heading_tolerance_rad) = (pose(-7.5, 9.0, 3.14), 0.3, 0.1);
//! let station = Place::Point { pose: pose_of_station, position_tolerance_m, heading_tolerance_rad };
//! assert!(map.has_room(&station.goal_position(), 0.30));
//! assert!(station.contains(&pose(-7.4, 9.1, 3.10)));
//! ```
//!
//! People write these files by hand, so a reader never stops at the first mistake: it collects
//! [`diagnostics::FileProblems`], each with its location and what is accepted there.
//!
//! [`house`] is one of the project's own maps. [`load_map`] explains the meaning of pixels.
//!
//! Files are read and written with the feature `files`, which is on by default. Without it the crate has geometry and
//! cells only, and depends only on nalgebra.

#[cfg(feature = "files")]
mod error;
mod grid;
#[cfg(feature = "files")]
pub mod house;
#[cfg(feature = "files")]
mod map_file;
mod places;
#[cfg(feature = "files")]
mod places_file;
#[cfg(feature = "files")]
mod polygon;
mod pose;
mod shape;

#[cfg(feature = "files")]
pub use error::Error;
pub use grid::{Cell, CellIndex, MAX_CELLS, OccupancyGrid};
#[cfg(feature = "files")]
pub use map_file::{ImageFormat, MapFiles, load_map, load_map_with_concerns, map_files, save_map};
pub use places::{Place, Places, Zone, distance_to_area_m, is_inside};
#[cfg(feature = "files")]
pub use places_file::{DEFAULT_HEADING_TOLERANCE_DEG, DEFAULT_POSITION_TOLERANCE_M, PlacesFile, heading_concern};
pub use pose::{Point, Pose, heading, pose, seen_from_above, wrap_angle};
pub use shape::Shape;
