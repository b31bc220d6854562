//! The project's own map: one floor of about 28 m × 22 m with rooms along a corridor.
//!
//! ```text
//!  ┌─────────┬───────────┬───────┬───────────┐
//!  │ kitchen │  bedroom  │ study │           │      17 m
//!  │ (goal)  │           ├───────┤   store   │
//!  ├──┬─  ─┬─┴─┬─────┐   │meeting│           │
//!  │  │    │   │niche│   │ room  │           │
//!  ├──┘    └───┘     └───┴──  ───┴──    ─────┤       8 m
//!  │ ◂ ◂ ◂ corridor ◂ ◂ ◂ ◂ ◂ ◂ ◂ ◂ ┐        │
//!  ├────  ────┬──  ──┬───────────  ─┼────  ──┤     5.5 m
//!  │ workshop │office│              │ guests │
//!  ├──  ──────┴┬─  ──┤ living room  ├─────  ─┤       0 m
//!  │  cellar   │bath │  ▸ start     │ dining │
//!  └───────────┴─────┴──────────────┴────────┘      −5 m
//! ```
//!
//! The robot starts in the living room and is sent to the kitchen. It passes the niche with the charging station at a
//! distance of 1 m to 2 m, so it does not dock in passing. The rooms differ in shape, size and furniture, so a laser
//! scan identifies where it was taken.
//!
//! The image is drawn from a plan in meters, `tests/house/plan.rs`, by a test: `STEWARD_BLESS=1 cargo test -p
//! steward-maps`.

use std::io;
use std::path::Path;

use crate::{OccupancyGrid, Places, PlacesFile, load_map};

/// The map.
#[must_use]
pub fn map() -> OccupancyGrid {
    load_map(Path::new("house.yaml"), &read).expect("a test loads the map of the house")
}

/// The places of the house: `start`, `RechargingStation` and `Destination`.
#[must_use]
pub fn places() -> Places {
    let places = PlacesFile::load(Path::new("house.places.toml"), &read);
    places.expect("a test parses the places of the house").into_places()
}

/// Reads a file of the house, which is part of the crate.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let content: &[u8] = match path.to_str() {
        Some("house.yaml") => include_bytes!("../house.yaml"),
        Some("house.pgm") => include_bytes!("../house.pgm"),
        Some("house.places.toml") => include_bytes!("../house.places.toml"),
        _ => return Err(io::ErrorKind::NotFound.into()),
    };
    Ok(content.to_vec())
}
