//! A plan of a floor: rooms, doorways and furniture, in meters in the `map` frame.

use std::path::Path;

use diagnostics::from_disk;
use maps::{Cell, ImageFormat, OccupancyGrid, load_map, map_files, save_map};

use crate::pen::{Pen, Rect};

/// Side of a cell.
const RESOLUTION_M: f64 = 0.05;

/// Thickness of a wall. Rooms that share a wall are this far apart; rooms that touch are one room.
const WALL_M: f64 = 0.15;

/// A point: x, y.
pub(crate) type Position = (f64, f64);

/// A floor. Later shapes are drawn over earlier ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// The area that the map covers: the floor and a meter of unknown space around it.
    pub(crate) sheet: Rect,
    pub(crate) rooms: &'static [Rect],
    pub(crate) doorways: &'static [Rect],
    /// A wall from one point to another. Everything to its left is unknown.
    pub(crate) slanted_wall: Option<(Position, Position)>,
    /// Furniture with straight sides.
    pub(crate) boxes: &'static [Rect],
    /// Round furniture: center and radius.
    pub(crate) rounds: &'static [(Position, f64)],
    /// Slanted furniture: a stroke from one point to the other and its width.
    pub(crate) strokes: &'static [(Position, Position, f64)],
}

impl Plan {
    /// Fails if the files of the map with this name are not what the plan draws; with `STEWARD_BLESS`, writes them
    /// instead.
    pub(crate) fn compare_files(&self, name: &str) {
        let (drawn, path) = (self.draw(), Path::new(env!("CARGO_MANIFEST_DIR")).join(name));
        let (yaml, image) = (path.with_extension("yaml"), path.with_extension("pgm"));
        if std::env::var_os("STEWARD_BLESS").is_some() {
            return save_map(&drawn, &yaml, ImageFormat::Pgm).expect("the folder can be written");
        }
        let files = map_files(&drawn, &format!("{name}.pgm"), ImageFormat::Pgm).expect("a map has files");
        let is_committed = |path: &Path, content: &[u8]| std::fs::read(path).is_ok_and(|bytes| bytes == content);
        let are_up_to_date = is_committed(&yaml, files.yaml.as_bytes()) && is_committed(&image, &files.image);
        let advice = "run `STEWARD_BLESS=1 cargo test -p steward-maps`";
        assert!(are_up_to_date, "the map's files are out of date: {advice}");
        assert_eq!(load_map(&yaml, &from_disk).expect("the map is complete"), drawn);
    }

    pub(crate) fn draw(&self) -> OccupancyGrid {
        let mut pen = Pen::new(self.sheet, RESOLUTION_M);
        for &room in self.rooms {
            pen.rect(walls_around(room), Cell::Occupied);
        }
        for &room in self.rooms.iter().chain(self.doorways) {
            pen.rect(room, Cell::Free);
        }
        if let Some((from, to)) = self.slanted_wall {
            pen.beyond(from, to, Cell::Unknown);
            pen.stroke(from, to, WALL_M, Cell::Occupied);
        }
        for &furniture in self.boxes {
            pen.rect(furniture, Cell::Occupied);
        }
        for &(center, radius_m) in self.rounds {
            pen.disc(center, radius_m, Cell::Occupied);
        }
        for &(from, to, width_m) in self.strokes {
            pen.stroke(from, to, width_m, Cell::Occupied);
        }
        pen.finish()
    }
}

/// A room with its walls.
fn walls_around(Rect { x_m, y_m }: Rect) -> Rect {
    let grown = |(from, to): (f64, f64)| (from - WALL_M, to + WALL_M);
    Rect { x_m: grown(x_m), y_m: grown(y_m) }
}
