//! How fast a scan of 360 beams is cast against the walls of a furnished floor.

mod floor;

use divan::counter::ItemsCount;
use maps::{Cell, Pose, pose};
use robot::{LaserSpec, RobotModel};
use sim::{Beams, RayGrid};

fn main() {
    divan::main();
}

/// Poses all over the floor wherever it is free, with all sorts of headings.
fn poses() -> Vec<Pose> {
    let grid = floor::floor();
    let anywhere = (0..2000).map(|n| {
        let n = f64::from(n);
        pose((n * 0.618_033_988_75).fract() * 28.0, (n * 0.414_213_562_37).fract() * 22.0, n * 2.399_963)
    });
    let is_free =
        |at: &Pose| grid.index_of(&at.translation.vector.into()).and_then(|index| grid.cell(index)) == Some(Cell::Free);
    anywhere.filter(is_free).collect()
}

/// One call casts a scan from every pose.
#[divan::bench(sample_count = 20)]
fn scans_of_360_beams_within_10_m(bencher: divan::Bencher<'_, '_>) {
    let laser: &LaserSpec = &RobotModel::default().lasers[0];
    let (walls, beams, poses) = (RayGrid::new(&floor::floor()), Beams::new(laser), poses());
    let mut ranges_m = Vec::new();
    bencher.counter(ItemsCount::new(laser.beams * poses.len())).bench_local(|| {
        for base in &poses {
            walls.ranges(&beams, base, laser.range_max_m, &mut ranges_m);
            divan::black_box(&ranges_m);
        }
    });
}
