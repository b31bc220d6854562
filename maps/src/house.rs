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
//! A test checks that the map's files are up to date; `STEWARD_BLESS=1 cargo test -p steward-maps` draws them.

mod plan;

#[cfg(feature = "files")]
use std::{io, path::Path};

use crate::OccupancyGrid;
#[cfg(feature = "files")]
use crate::{Places, PlacesFile};

/// File name of the map.
pub const YAML_NAME: &str = "house.yaml";

/// The map's files, name and content: the YAML, its image and its places.
pub const FILES: [(&str, &[u8]); 3] = [
    (YAML_NAME, include_bytes!("../house.yaml")),
    ("house.pgm", include_bytes!("../house.pgm")),
    ("house.places.toml", include_bytes!("../house.places.toml")),
];

/// Reads one of [`FILES`] by the last part of its path; a [`ReadFile`](diagnostics::ReadFile).
///
/// # Errors
/// [`io::ErrorKind::NotFound`] for any other name.
#[cfg(feature = "files")]
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let file = FILES.iter().find(|(name, _)| path.file_name().is_some_and(|last| last == *name));
    file.map(|(_, content)| content.to_vec()).ok_or_else(|| io::ErrorKind::NotFound.into())
}

/// The places of the house: `start`, `RechargingStation` and `Destination`.
#[cfg(feature = "files")]
#[must_use]
pub fn places() -> Places {
    let places = PlacesFile::load(Path::new("house.places.toml"), &read);
    places.expect("a test parses the places of the house").into_places()
}

/// Draws the map. The result equals the map loaded from [`FILES`].
#[must_use]
pub fn draw() -> OccupancyGrid {
    plan::HOUSE.draw()
}
