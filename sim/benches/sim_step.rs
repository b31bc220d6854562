//! The speed of simulation steps on a furnished floor.

mod floor;

use divan::counter::ItemsCount;
use maps::{Point, Shape, pose};
use robot::{Robot, Streams, VelocityCommand};
use sim::{ObstacleConfig, ObstacleMotion, RouteEnd, SimConfig, Simulation};

fn main() {
    divan::main();
}

/// Steps that one call takes: a second of simulated time.
const STEPS: usize = 50;

/// A robot that drives back and forth along the corridor.
fn bench_second(bencher: divan::Bencher<'_, '_>, config: &SimConfig) {
    let start = pose(14.0, 11.0, 0.0);
    let mut sim =
        Simulation::new(config, &floor::floor(), start, start, &Streams::new(1)).expect("the corridor is free");
    let (mut readings, mut seconds) = (Vec::new(), 0_u32);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let backward = seconds / 20 % 2 == 1;
        seconds += 1;
        sim.drive(VelocityCommand { linear_mps: if backward { -0.4 } else { 0.4 }, angular_radps: 0.0 });
        for _ in 0..STEPS {
            sim.step();
            readings.clear();
            sim.read(&mut readings);
        }
        readings.len()
    });
}

#[divan::bench]
fn steps_with_scans(bencher: divan::Bencher<'_, '_>) {
    bench_second(bencher, &SimConfig::default());
}

#[divan::bench]
fn steps_without_scans(bencher: divan::Bencher<'_, '_>) {
    let mut config = SimConfig::default();
    config.model.lasers.clear();
    bench_second(bencher, &config);
}

#[divan::bench]
fn steps_with_scans_among_ten_people(bencher: divan::Bencher<'_, '_>) {
    let person = |n: u32| {
        let x_m = 3.0 + f64::from(n) * 0.8;
        ObstacleConfig {
            name: format!("person {n}"),
            shape: Shape::Disc { radius_m: 0.25 },
            pose: pose(x_m, 11.0, 0.0),
            motion: ObstacleMotion::Route {
                waypoints: vec![Point::new(x_m + 1.0, 11.0), Point::new(x_m, 11.0)],
                speed_mps: 0.8,
                end: RouteEnd::Loop,
            },
        }
    };
    bench_second(bencher, &SimConfig { obstacles: (0..10).map(person).collect(), ..SimConfig::default() });
}
