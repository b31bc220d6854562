//! The cost of a recording: `cargo bench -p reports [-- ROUNDS]`.
//!
//! Each round runs `nominal` twice as `steward run` does, with report, page and pictures, one of them with a recording
//! in MCAP. These two take turns after each simulated second, so that whatever else the computer does affects both. The
//! round then runs `nominal` bare, with full details that are not used, and recorded; last, it reads the recording and
//! makes its report.
//!
//! Times are processor times, as Linux counts them for each thread. They are compared within a round, and the medians
//! are those of the rounds' ratios.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use recording::{Detail, Recording, RunView, conduct};
use reports::{Outputs, Presentation, report_recording};
use runs::Run;
use scenarios::scenario::{Scenario, find};

/// How long each part of a round took, in seconds.
struct Round {
    bare: f64,
    detailed: f64,
    recorded: f64,
    read: f64,
    reported: f64,
    shown: Shown,
    shown_and_mcap: Shown,
}

/// How long a run took, and then its report with page and pictures, in seconds.
struct Shown {
    run: f64,
    report: f64,
}

impl Shown {
    fn whole(&self) -> f64 {
        self.run + self.report
    }
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
    row("with unused details", |round| round.detailed, |round| round.detailed / round.bare);
    row("recorded", |round| round.recorded, |round| round.recorded / round.bare);
    row(
        "  of which is writing",
        |round| round.recorded - round.detailed,
        |round| (round.recorded - round.detailed) / round.bare,
    );
    row("reading the recording", |round| round.read, |round| round.read / round.bare);
    row("the report of the recording", |round| round.reported, |round| round.reported / round.bare);
    row("with page and pictures", |round| round.shown.whole(), |round| round.shown.whole() / round.bare);
    // Both make the same report.
    let added = median(|round| (round.shown_and_mcap.run - round.shown.run) / round.shown.whole());
    println!("so recording in MCAP adds {:.1} % to `steward run nominal`", 100.0 * added);
}

fn round(scenario: &Arc<Scenario>, path: &Path) -> Round {
    let mcap = path.with_extension("mcap");
    // Replacing a file takes longer than writing a new one.
    let _ = fs::remove_file(&mcap);
    let (shown, shown_and_mcap) = thread::scope(|scope| {
        let (first, second) = Turns::pair();
        let plain = scope.spawn(|| show(scenario, &path.with_extension("plain"), None, first));
        let recorded = scope.spawn(|| show(scenario, &path.with_extension("out"), Some(&mcap), second));
        (plain.join().expect("the run is shown"), recorded.join().expect("the run is shown"))
    });
    Round {
        bare: seconds(|| run(scenario, Detail::Verdicts, None)),
        detailed: seconds(|| run(scenario, Detail::Full, None)),
        recorded: seconds(|| run(scenario, Detail::Full, Some(path))),
        read: seconds(|| drop(go_through(path))),
        reported: seconds(|| {
            let recording = Recording::open(path).expect("the recording was written");
            drop(report_recording(recording, &Outputs::default(), None).expect("the recording is complete"))
        }),
        shown,
        shown_and_mcap,
    }
}

fn run(scenario: &Arc<Scenario>, detail: Detail, record: Option<&Path>) {
    let run = Run::new(Arc::clone(scenario), 1, true).expect("the scenario is valid");
    let begin = |_: &RunView| Ok::<_, scenarios::Error>(());
    conduct(run, detail, record, begin, |_| ControlFlow::Continue(())).expect("the run comes to its end");
}

/// Runs the scenario with report, page and pictures in a folder.
fn show(scenario: &Arc<Scenario>, folder: &Path, record: Option<&Path>, turns: Turns) -> Shown {
    let outputs = Outputs { folder: Some(folder.to_owned()), snapshots: true, ..Outputs::default() };
    let mut conducted = None;
    turns.wait();
    let run = seconds(|| {
        let run = Run::new(Arc::clone(scenario), 1, true).expect("the scenario is valid");
        let begin = |view: &RunView| Ok::<_, Box<dyn std::error::Error>>(Presentation::begin(view, &outputs)?);
        let goes_on = |view: &RunView| {
            if view.time().subsec_nanos() == 0 {
                turns.pass();
            }
            ControlFlow::Continue(())
        };
        conducted = Some(conduct(run, Detail::Full, record, begin, goes_on).expect("the run comes to its end"));
    });
    drop(turns);
    let (presentation, view) = conducted.expect("the run was conducted");
    Shown { run, report: seconds(|| drop(presentation.finish(&view).expect("there is room for a report"))) }
}

/// One of two threads that take turns, until one of them drops it.
struct Turns {
    other: SyncSender<()>,
    own: Receiver<()>,
}

impl Turns {
    /// The first begins.
    fn pair() -> (Self, Self) {
        let ((to_first, first), (to_second, second)) = (sync_channel(1), sync_channel(1));
        to_first.send(()).expect("both ends exist");
        (Self { other: to_second, own: first }, Self { other: to_first, own: second })
    }

    fn wait(&self) {
        let _ = self.own.recv();
    }

    fn pass(&self) {
        let _ = self.other.send(());
        self.wait();
    }
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

fn seconds(work: impl FnOnce()) -> f64 {
    let before = processor_seconds();
    work();
    processor_seconds() - before
}

/// The processor time of this thread so far.
fn processor_seconds() -> f64 {
    let schedstat = fs::read_to_string("/proc/thread-self/schedstat").expect("this computer runs Linux");
    let nanoseconds: f64 =
        schedstat.split(' ').next().and_then(|first| first.parse().ok()).expect("the first is a time");
    1e-9 * nanoseconds
}
