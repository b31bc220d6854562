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
//! distance between 1 m and 2 m, so passing by is not docking. The rooms differ in shape, size and furniture, so a
//! laser scan identifies where it was taken.
//!
//! `cargo run -p steward-maps --example draw_house` draws the map's files; a test checks that they are up to date.

mod pen;
mod plan;

#[cfg(feature = "files")]
use std::{io, path::Path};

use crate::{Cell, OccupancyGrid};
#[cfg(feature = "files")]
use crate::{Places, PlacesFile};
use pen::{Pen, Rect};

/// File name of the map.
pub const YAML_NAME: &str = "house.yaml";

/// The map's files, name and content: the YAML, its picture and its places.
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
    places.expect("the places of the house are tested to be right").into_places()
}

/// Draws the map. The result equals the map loaded from [`FILES`].
#[must_use]
pub fn draw() -> OccupancyGrid {
    let mut pen = Pen::new(plan::SHEET, plan::RESOLUTION_M);
    for room in plan::ROOMS {
        pen.rect(walls_around(room), Cell::Occupied);
    }
    for room in plan::ROOMS.into_iter().chain(plan::DOORWAYS) {
        pen.rect(room, Cell::Free);
    }
    let (from, to) = plan::SLANTED_WALL;
    pen.beyond(from, to, Cell::Unknown);
    pen.stroke(from, to, plan::WALL_M, Cell::Occupied);
    for furniture in plan::BOXES {
        pen.rect(furniture, Cell::Occupied);
    }
    for (center, radius_m) in plan::ROUNDS {
        pen.disc(center, radius_m, Cell::Occupied);
    }
    for (from, to, width_m) in plan::STROKES {
        pen.stroke(from, to, width_m, Cell::Occupied);
    }
    pen.finish()
}

/// A room with its walls.
fn walls_around(Rect { x_m, y_m }: Rect) -> Rect {
    let grown = |(from, to): (f64, f64)| (from - plan::WALL_M, to + plan::WALL_M);
    Rect { x_m: grown(x_m), y_m: grown(y_m) }
}
