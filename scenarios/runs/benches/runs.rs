//! Whole runs, in simulated seconds per second ("items"): one core, no pictures, every scan computed.
//!
//! `nominal` is the whole scenario, most of which the robot spends at the charging station; `driving` is its first 45
//! s, during which the robot is under way.

use std::sync::Arc;
use std::time::Duration;

use divan::Bencher;
use divan::counter::ItemsCount;
use recording::{Detail, Happening, RunView};
use runs::Run;
use scenarios::scenario::{Scenario, find};

fn main() {
    divan::main();
}

fn nominal_scenario() -> Arc<Scenario> {
    let found = find::find("nominal").expect("the scenario comes with the program");
    Arc::new(Scenario::load(&found, &[]).expect("the scenario is valid"))
}

fn start(scenario: &Arc<Scenario>) -> Run {
    Run::new(Arc::clone(scenario), 1, true).expect("the scenario is valid")
}

/// Runs until the robot has come to rest at that place or the time is up; returns the time.
fn drive(mut run: Run, place: &str, limit: Duration) -> Duration {
    let start = run.record(Detail::Verdicts);
    let mut view = RunView::new(run.header(), start).expect("the records fit");
    let place = view.header().places().iter().position(|known| known.name == place);
    let arrived = |happening: &Happening| matches!(happening, Happening::Arrival { place: at } if Some(*at) == place);
    while view.time() < limit {
        run.step().expect("the processes continue");
        view.apply(run.record(Detail::Verdicts)).expect("the records fit");
        if view.happenings().iter().any(arrived) {
            break;
        }
    }
    view.time()
}

const HOUR: Duration = Duration::from_secs(3600);

#[divan::bench(sample_count = 10, sample_size = 1)]
fn nominal(bencher: Bencher) {
    let scenario = nominal_scenario();
    let simulated = drive(start(&scenario), "Destination", HOUR);
    bencher
        .with_inputs(|| start(&scenario))
        .input_counter(move |_| ItemsCount::new(simulated.as_secs()))
        .bench_local_values(|run| drive(run, "Destination", HOUR));
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn driving(bencher: Bencher) {
    let scenario = nominal_scenario();
    let limit = Duration::from_secs(45);
    bencher
        .with_inputs(|| start(&scenario))
        .input_counter(move |_| ItemsCount::new(limit.as_secs()))
        .bench_local_values(|run| drive(run, "nowhere", limit));
}

/// Setting up a run of a scenario that is already loaded.
#[divan::bench]
fn set_up(bencher: Bencher) {
    let scenario = nominal_scenario();
    bencher.bench_local(|| start(&scenario));
}
