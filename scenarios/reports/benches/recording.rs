//! The cost of a recording: `cargo bench -p reports [-- ROUNDS]`.
//!
//! Each round runs `nominal` bare, then with full details that nobody uses, then recorded in both formats; then it
//! reads the recording and makes its report. Other load on the computer affects consecutive measurements equally, so
//! times are compared within a round, and the medians are those of the rounds' ratios.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use recording::{Detail, Recording, RunView};
use reports::{Outputs, report_recording};
use scenarios::conduct::conduct;
use scenarios::live::Live;
use scenarios::scenario::{Scenario, find};

/// How long each part of a round took, in seconds.
struct Round {
    bare: f64,
    told: f64,
    recorded: f64,
    mcap: f64,
    read: f64,
    reported: f64,
}

#[expect(clippy::print_stdout, reason = "a program that measures")]
fn main() {
    // Cargo adds `--bench`.
    let rounds = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(15);
    let found = find::find("nominal").expect("the scenario comes with the program");
    let scenario = Arc::new(Scenario::load(&found, &[]).expect("the scenario is valid"));
    let folder = tempfile::tempdir().expect("there is room for a recording");
    let path = folder.path().join("nominal.rec");

    // The first run makes the data that all runs share.
    run(&scenario, Detail::Verdicts, Some(&path));
    let simulated = go_through(&path).time();
    let bytes = fs::metadata(&path).expect("the recording was written").len();
    let measured: Vec<Round> = (0..rounds).map(|_| round(&scenario, &path)).collect();

    let median = |of: fn(&Round) -> f64| {
        let mut values: Vec<f64> = measured.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let row = |what: &str, seconds: fn(&Round) -> f64, share: fn(&Round) -> f64| {
        println!("{what:<28}{:>9.1} ms  {:>6.1} % of the bare run", 1e3 * median(seconds), 100.0 * median(share));
    };
    let per_second = bytes as f64 / simulated.as_secs_f64();
    println!("nominal: {bytes} bytes for {:.1} s, {per_second:.0} bytes/s; {rounds} rounds", simulated.as_secs_f64());
    row("a bare run", |round| round.bare, |_| 1.0);
    row("with unused details", |round| round.told, |round| round.told / round.bare);
    row("recorded", |round| round.recorded, |round| round.recorded / round.bare);
    row(
        "  of which is writing",
        |round| round.recorded - round.told,
        |round| (round.recorded - round.told) / round.bare,
    );
    row("recorded in MCAP", |round| round.mcap, |round| round.mcap / round.bare);
    row("  of which is writing", |round| round.mcap - round.told, |round| (round.mcap - round.told) / round.bare);
    row("reading the recording", |round| round.read, |round| round.read / round.bare);
    row("the report of the recording", |round| round.reported, |round| round.reported / round.bare);
}

fn round(scenario: &Arc<Scenario>, path: &Path) -> Round {
    Round {
        bare: seconds(|| run(scenario, Detail::Verdicts, None)),
        told: seconds(|| run(scenario, Detail::Full, None)),
        recorded: seconds(|| run(scenario, Detail::Full, Some(path))),
        mcap: seconds(|| run(scenario, Detail::Full, Some(&path.with_extension("mcap")))),
        read: seconds(|| drop(go_through(path))),
        reported: seconds(|| {
            drop(report_recording(path, &Outputs::default(), None).expect("the recording is complete"))
        }),
    }
}

fn run(scenario: &Arc<Scenario>, detail: Detail, record: Option<&Path>) {
    let live = Live::new(Arc::clone(scenario), 1, true).expect("the scenario is valid");
    let follow = |_: &RunView| Ok::<_, scenarios::Error>(ControlFlow::Continue(()));
    conduct(live, detail, record, follow).expect("the run comes to its end");
}

/// Reads a recording to its end.
fn go_through(path: &Path) -> RunView {
    let mut recording = Recording::open(path).expect("the recording was written");
    let mut view = recording.begin().expect("the recording is complete");
    while view.end().is_none() {
        recording.advance(&mut view).expect("the recording is complete");
    }
    view
}

#[expect(clippy::disallowed_methods, reason = "this measures time")]
fn seconds(work: impl FnOnce()) -> f64 {
    let began = Instant::now();
    work();
    began.elapsed().as_secs_f64()
}
