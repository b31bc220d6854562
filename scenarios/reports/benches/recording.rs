//! The cost of a recording: `cargo bench -p reports [-- ROUNDS]`.
//!
//! Each round runs `nominal` bare, then with full details that nobody uses, then recorded in both formats; then it
//! reads the recording and makes its report. Last, it runs `nominal` as `steward run` does, with report, page and
//! pictures, first without and then with a recording in MCAP.
//!
//! Times are processor times where Linux tells them. Other load on the computer affects consecutive measurements
//! equally, so times are compared within a round, and the medians are those of the rounds' ratios.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use recording::{Detail, Recording, RunView};
use reports::{Outputs, Presentation, report_recording};
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
    shown: f64,
    shown_and_mcap: f64,
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
    row("with page and pictures", |round| round.shown, |round| round.shown / round.bare);
    row("  and recorded in MCAP", |round| round.shown_and_mcap, |round| round.shown_and_mcap / round.bare);
    let added = median(|round| round.shown_and_mcap / round.shown - 1.0);
    println!("so recording in MCAP adds {:.1} % to `steward run nominal`", 100.0 * added);
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
        shown: seconds(|| show(scenario, path, None)),
        shown_and_mcap: seconds(|| show(scenario, path, Some(&path.with_extension("mcap")))),
    }
}

fn run(scenario: &Arc<Scenario>, detail: Detail, record: Option<&Path>) {
    let live = Live::new(Arc::clone(scenario), 1, true).expect("the scenario is valid");
    let follow = |_: &RunView| Ok::<_, scenarios::Error>(ControlFlow::Continue(()));
    conduct(live, detail, record, follow).expect("the run comes to its end");
}

/// Runs the scenario with report, page and pictures, beside the recording at `path`.
fn show(scenario: &Arc<Scenario>, path: &Path, record: Option<&Path>) {
    let outputs = Outputs { folder: Some(path.with_extension("out")), snapshots: true, ..Outputs::default() };
    let live = Live::new(Arc::clone(scenario), 1, true).expect("the scenario is valid");
    let mut begun = None;
    let view = conduct(live, Detail::Full, record, |view| {
        match &mut begun {
            None => begun = Some(Presentation::begin(view, &outputs).expect("there is room for a report")),
            Some(presentation) => presentation.follow(view).expect("there is room for a report"),
        }
        Ok::<_, scenarios::Error>(ControlFlow::Continue(()))
    });
    let presentation = begun.expect("a run is followed from its start");
    presentation.finish(&view.expect("the run comes to its end")).expect("there is room for a report");
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
    let (began, used) = (Instant::now(), processor_seconds());
    work();
    match (used, processor_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => began.elapsed().as_secs_f64(),
    }
}

/// The processor time of this thread so far.
fn processor_seconds() -> Option<f64> {
    let told = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    told.split(' ').next()?.parse::<f64>().ok().map(|ns| ns * 1e-9)
}
