//! The speed of casting scans against walls: the sweep and, in the same run, its alternatives.
//!
//! `cargo bench -p steward-sim --bench laser_scan`; divan's filter selects benchmarks, for example `-- sweep`. With
//! `STEWARD_BENCH_MAP=path/to/map.yaml` the map in that file is added to the built-in ones.

mod dda;
#[path = "../floor/mod.rs"]
mod floor;
mod parry;
mod places;
// The rectangles from which the simulation makes its solid walls.
#[path = "../../src/rectangles.rs"]
#[expect(unused_imports, reason = "its tests are not run here")]
mod rectangles;

use std::f64::consts::{PI, TAU};

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use maps::Pose;
use parry2d::query::RayCast;
use places::{Place, places};
use robot::{LaserSpec, RobotModel};
use sim::{Beams, RayGrid, ScanMemory, Walls};

fn main() {
    divan::main();
}

/// This many beams all around, up to 30 m.
fn all_around(beams: usize) -> LaserSpec {
    let laser = RobotModel::default().lasers[0].clone();
    LaserSpec { angle_min_rad: -PI, angle_increment_rad: TAU / beams as f64, beams, range_max_m: 30.0, ..laser }
}

/// Times `scan` from every pose of a place.
fn bench_scans(bencher: Bencher<'_, '_>, place: &Place, laser: &LaserSpec, mut scan: impl FnMut(&Pose)) {
    let beams = ItemsCount::new(laser.beams * place.poses.len());
    bencher.counter(beams).bench_local(|| place.poses.iter().for_each(&mut scan));
}

fn bench_sweep(bencher: Bencher<'_, '_>, place: &Place, laser: &LaserSpec) {
    let (walls, beams) = (Walls::new(&place.grid), Beams::new(laser));
    let (mut memory, mut ranges_m) = (ScanMemory::default(), Vec::new());
    bench_scans(bencher, place, laser, |base| {
        walls.ranges(&beams, base, laser.range_max_m, &mut memory, &mut ranges_m);
        divan::black_box(&ranges_m);
    });
}

fn bench_plain_traversal(bencher: Bencher<'_, '_>, place: &Place, laser: &LaserSpec) {
    let (walls, beams, mut ranges_m) = (RayGrid::new(&place.grid), Beams::new(laser), Vec::new());
    bench_scans(bencher, place, laser, |base| {
        walls.ranges(&beams, base, laser.range_max_m, &mut ranges_m);
        divan::black_box(&ranges_m);
    });
}

/// Times another method that scans into a buffer, after checking that it sees the same walls.
fn bench_rival(
    bencher: Bencher<'_, '_>,
    place: &Place,
    laser: &LaserSpec,
    mut scan: impl FnMut(&Pose, &Beams, f32, &mut Vec<f32>),
) {
    let (walls, beams, max_m) = (RayGrid::new(&place.grid), Beams::new(laser), laser.range_max_m as f32);
    let (mut exact_m, mut ranges_m, mut wrong) = (Vec::new(), Vec::new(), 0);
    for base in &place.poses {
        walls.ranges(&beams, base, laser.range_max_m, &mut exact_m);
        scan(base, &beams, max_m, &mut ranges_m);
        // Two infinities differ by NaN, which does not exceed the limit.
        let differences_m = exact_m.iter().zip(&ranges_m).map(|(exact_m, range_m)| exact_m - f64::from(*range_m));
        wrong += differences_m.filter(|difference_m| difference_m.abs() > 0.5).count();
    }
    assert!(wrong * 50 < laser.beams * place.poses.len(), "{wrong} beams see different walls");
    bench_scans(bencher, place, laser, |base| {
        scan(base, &beams, max_m, &mut ranges_m);
        divan::black_box(&ranges_m);
    });
}

/// 720 beams over 360°, 30 m.
#[divan::bench_group(sample_count = 100, max_time = 3)]
mod all_around_30_m {
    use super::*;

    #[divan::bench(args = places())]
    fn sweep(bencher: Bencher<'_, '_>, place: &Place) {
        bench_sweep(bencher, place, &all_around(720));
    }

    #[divan::bench(args = places())]
    fn plain_traversal(bencher: Bencher<'_, '_>, place: &Place) {
        bench_plain_traversal(bencher, place, &all_around(720));
    }

    #[divan::bench(args = places())]
    fn branchless_dda_f32(bencher: Bencher<'_, '_>, place: &Place) {
        let dda = dda::Dda::new(&place.grid);
        bench_rival(bencher, place, &all_around(720), |base, beams, max, out| dda.ranges(beams, base, max, out));
    }

    fn bench_parry(bencher: Bencher<'_, '_>, place: &Place, shape: &impl RayCast) {
        bench_rival(bencher, place, &all_around(720), |base, beams, max, out| {
            parry::ranges(shape, beams, base, max, out);
        });
    }

    #[divan::bench(args = places())]
    fn parry_compound(bencher: Bencher<'_, '_>, place: &Place) {
        bench_parry(bencher, place, &parry::compound(&place.grid));
    }

    #[divan::bench(args = places())]
    fn parry_polyline(bencher: Bencher<'_, '_>, place: &Place) {
        bench_parry(bencher, place, &parry::polyline(&place.grid));
    }

    #[divan::bench(args = places())]
    fn parry_trimesh(bencher: Bencher<'_, '_>, place: &Place) {
        bench_parry(bencher, place, &parry::trimesh(&place.grid));
    }
}

/// A default scanner of the robot: 360 beams over 270°, 10 m.
#[divan::bench_group(sample_count = 100, max_time = 3)]
mod default_laser {
    use super::*;

    #[divan::bench(args = places())]
    fn sweep(bencher: Bencher<'_, '_>, place: &Place) {
        bench_sweep(bencher, place, &RobotModel::default().lasers[0]);
    }

    #[divan::bench(args = places())]
    fn plain_traversal(bencher: Bencher<'_, '_>, place: &Place) {
        bench_plain_traversal(bencher, place, &RobotModel::default().lasers[0]);
    }
}

/// All around, up to 30 m, on the last of the places.
#[divan::bench_group(sample_count = 100, max_time = 3)]
mod by_number_of_beams {
    use super::*;

    const BEAMS: [usize; 7] = [4, 8, 16, 60, 180, 720, 2880];

    #[divan::bench(args = BEAMS)]
    fn sweep(bencher: Bencher<'_, '_>, beams: usize) {
        bench_sweep(bencher, places().last().expect("there are places"), &all_around(beams));
    }

    #[divan::bench(args = BEAMS)]
    fn plain_traversal(bencher: Bencher<'_, '_>, beams: usize) {
        bench_plain_traversal(bencher, places().last().expect("there are places"), &all_around(beams));
    }
}

/// Building the walls, once per run.
#[divan::bench(args = places(), sample_count = 100, max_time = 3)]
fn laying_out(bencher: Bencher<'_, '_>, place: &Place) {
    bencher.counter(BytesCount::new(place.grid.cells().len())).bench(|| Walls::new(&place.grid));
}
