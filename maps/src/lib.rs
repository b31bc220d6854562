//! Occupancy grids, places, frames and poses; loading and saving.
//!
//! A robot that finds its way needs to agree with its user on three things, and this crate is about them.
//!
//! **Where things are.** A [`Pose`] is a position and a heading in metres and radians; everything on a map is in the
//! `map` frame (x right, y up as a picture shows it, angles counter-clockwise).
//!
//! **What is there.** An [`OccupancyGrid`] cuts a floor into cells that are free, occupied or [unknown](Cell::Unknown).
//! [`load_map`] reads what ROS's `map_server` reads, YAML with a PGM or PNG, and [`save_map`] writes it.
//!
//! **What places are called.** [`Places`] are named points ("RechargingStation") and areas ("Destination"), written
//! down in a [`PlacesFile`] beside the map.
//!
//! ```
//! use maps::{Place, house};
//!
//! let map = house::draw();
//! let places = house::places();
//! let station = places.get("RechargingStation").expect("the house has a charging station");
//! assert!(map.has_room(&station.goal_position(), 0.30));
//! assert!(matches!(places.get("Destination"), Some(Place::Area { .. })));
//! ```
//!
//! People write these files by hand, and so a reader never stops at the first mistake: it collects [`FileProblems`],
//! each at its place and with what would have been right. The [`document`] module that makes this easy is public,
//! because a scenario's TOML deserves the same care.
//!
//! [`house`] is the project's own map. Read [`load_map`] for what pixels mean, [`document`] for how to read a file.

mod diagnostics;
pub mod document;
mod error;
mod files;
mod grid;
pub mod house;
mod map_file;
mod places;
mod places_file;
mod polygon;
mod pose;
mod raster;

pub use diagnostics::{FileProblems, Problem, Source, Span, Spanned, nearest};
pub use error::Error;
pub use files::{ReadFile, from_disk};
pub use grid::{Cell, CellIndex, OccupancyGrid};
pub use map_file::{ImageFormat, MapFiles, load_map, map_files, save_map};
pub use places::{Place, Places};
pub use places_file::{DEFAULT_HEADING_TOLERANCE_DEG, DEFAULT_POSITION_TOLERANCE_M, PlacesFile};
pub use pose::{Point, Pose, heading, pose, wrap_angle};
pub use raster::MAX_CELLS;
