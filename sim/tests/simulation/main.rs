//! The simulation from its users' point of view.

mod determinism;
mod devices;
mod docking;
mod driving;
mod faults;
mod followers;
mod lasers;
mod obstacles;
mod refusals;
mod walls;

use maps::{Cell, CellIndex, OccupancyGrid, Pose, pose};
use robot::{LaserScan, Reading, Robot, Streams, VelocityCommand};
use sim::{SimConfig, Simulation};

/// Thickness of the room's walls, in meters.
const WALL_M: f64 = 0.1;

/// An empty room with the interior from (0, 0) to (`length_m`, `width_m`), surrounded by walls.
fn room(length_m: f64, width_m: f64) -> OccupancyGrid {
    let cells = |extent_m: f64| ((extent_m + 2.0 * WALL_M) / 0.05).round() as usize;
    let (width, height) = (cells(length_m), cells(width_m));
    let mut grid = OccupancyGrid::new(width, height, 0.05, pose(-WALL_M, -WALL_M, 0.0));
    for index in (0..height).flat_map(|row| (0..width).map(move |column| CellIndex { column, row })) {
        let inside = (2..width - 2).contains(&index.column) && (2..height - 2).contains(&index.row);
        grid.set(index, if inside { Cell::Free } else { Cell::Occupied });
    }
    grid
}

/// A simulation in a room of 8 m × 6 m with the station in a far corner.
fn in_a_room(config: &SimConfig, start: Pose) -> Simulation {
    Simulation::new(config, &room(8.0, 6.0), start, pose(7.0, 5.0, 0.0), &Streams::new(1)).expect("a good start")
}

/// Drives for this many steps and returns the readings.
fn drive(sim: &mut Simulation, linear_mps: f64, angular_radps: f64, steps: usize) -> Vec<Reading> {
    sim.drive(VelocityCommand { linear_mps, angular_radps });
    let mut readings = Vec::new();
    for _ in 0..steps {
        sim.step();
        sim.read(&mut readings);
    }
    readings
}

/// The scans among readings.
fn scans(readings: &[Reading]) -> impl Iterator<Item = &LaserScan> {
    readings.iter().filter_map(|reading| if let Reading::Scan(scan) = reading { Some(&**scan) } else { None })
}
