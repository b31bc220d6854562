//! Queries a map and its places. In the crate's folder: `cargo run --example ask_map -- house.yaml house.places.toml`.

use std::error::Error;
use std::path::Path;

use diagnostics::from_disk;
use maps::{Cell, PlacesFile, load_map};

/// The radius of the robot that must fit.
const RADIUS_M: f64 = 0.30;

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [map, places] = arguments.as_slice() else { return Err("usage: ask_map MAP.yaml PLACES.toml".into()) };
    let map = load_map(Path::new(map), &from_disk)?;
    let file = PlacesFile::load(Path::new(places), &from_disk)?;

    let side_m = |cells: usize| cells as f64 * map.resolution_m();
    let free = map.cells().iter().filter(|cell| **cell == Cell::Free).count();
    let free_m2 = free as f64 * map.resolution_m() * map.resolution_m();
    println!("{:.1} m × {:.1} m, {free_m2:.0} m² of it free", side_m(map.width()), side_m(map.height()));
    for (name, place) in file.places().iter() {
        let goal = place.goal_position();
        let room = if map.has_room(&goal, RADIUS_M) { "room" } else { "no room" };
        let facing = place.goal_heading().map_or(String::new(), |rad| format!(", facing {:.0}°", rad.to_degrees()));
        println!("{name}: at {:.2} m, {:.2} m{facing}: {room} for the robot", goal.x, goal.y);
    }
    Ok(())
}
