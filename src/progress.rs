//! The progress of runs, campaigns and proofs, on stderr.

mod campaign;
mod proof;

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use recording::RunView;

pub(crate) use self::campaign::CampaignProgress;
pub(crate) use self::proof::{ProgressForm, ProofProgress};
use crate::moment::moment;
use crate::output::complain_of;

/// A line on a terminal that is drawn again and again, until it is dropped. It draws nothing if it is silent, or
/// without a terminal.
#[derive(Debug)]
struct ProgressLine(Option<ProgressBar>);

impl ProgressLine {
    /// The template is that of indicatif; its `{rate}` has this many decimals.
    fn new(silent: bool, template: &str, decimals: usize) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let rate = move |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{:.decimals$}", state.per_sec());
        };
        // A fixed template can be parsed; if not, the default style is used.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("rate", rate));
        }
        Self(Some(bar))
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.0.iter().for_each(ProgressBar::finish_and_clear);
    }
}

/// The state of each property while a log is being written: several lines, drawn again and again.
#[derive(Debug)]
pub(crate) struct FollowProgress(ProgressLine);

impl FollowProgress {
    pub(crate) fn new() -> Self {
        Self(ProgressLine::new(false, "{spinner} {msg}", 0))
    }

    /// Shows a text, at most ten times per second.
    pub(crate) fn show(&self, text: impl FnOnce() -> String) {
        let Some(bar) = &self.0.0 else { return };
        let tenths = bar.elapsed().as_millis() as u64 / 100;
        if tenths > bar.position() {
            bar.set_position(tenths);
            bar.set_message(text());
        }
    }

    /// Takes the lines away for as long as something else is printed.
    pub(crate) fn pause<T>(&self, print: impl FnOnce() -> T) -> T {
        match &self.0.0 {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }
}

/// The progress of a run: time, battery, what the tree is doing, and monitors.
#[derive(Debug)]
pub(crate) struct RunProgress(ProgressLine);

impl RunProgress {
    pub(crate) fn new(silent: bool) -> Self {
        Self(ProgressLine::new(silent, "{spinner} {pos:>4} s  {wide_msg}", 0))
    }

    /// Shows the state of the run, once per simulated second.
    pub(crate) fn show(&self, view: &RunView) {
        let Some(bar) = &self.0.0 else { return };
        if view.time().as_secs() == bar.position() && !view.time().is_zero() {
            return;
        }
        let monitors = view.monitors().map(|monitor| format!("{}: {}", monitor.name(), monitor.state.location));
        let monitors: Vec<String> = monitors.collect();
        let level = view.robot().battery.map_or_else(String::new, |it| format!("battery {:.1} %  ", it.charge_pct));
        bar.set_position(view.time().as_secs());
        bar.set_message(format!("{level}{}  {}", view.doing(), monitors.join("  ")));
    }
}

/// How many of many things are finished. Without a terminal, only with [`or_lines`](CountProgress::or_lines).
#[derive(Debug)]
pub(crate) struct CountProgress {
    things: &'static str,
    line: ProgressLine,
    now_and_then: Option<NowAndThen>,
}

impl CountProgress {
    /// The progress of such things.
    pub(crate) fn new(silent: bool, things: &'static str) -> Self {
        let template = format!("{{bar:40}} {{pos}} of {{len}} {things}, {{eta}} left");
        Self { things, line: ProgressLine::new(silent, &template, 0), now_and_then: None }
    }

    /// The same, with a line now and then where there is no terminal, unless it is silent.
    pub(crate) fn or_lines(self, silent: bool) -> Self {
        let now_and_then = (!silent && self.line.0.is_none()).then(|| NowAndThen::new(BETWEEN_LINES));
        Self { now_and_then, ..self }
    }

    /// Shows how many are finished, of how many.
    pub(crate) fn show(&self, done: usize, all: usize) {
        if let Some(bar) = &self.line.0 {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }
        if self.now_and_then.as_ref().is_some_and(NowAndThen::is_due) {
            complain_of(format!("{done} of {all} {}\n", self.things));
        }
    }

    /// Runs `write`, whose lines appear above this one.
    pub(crate) fn above<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.line.0 {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }
}

/// The time between two lines of progress for people, where there is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// Something to be done once in each interval of real time but the first, whichever thread notices it.
#[derive(Debug)]
struct NowAndThen {
    interval: Duration,
    begin: Instant,
    /// The number of the last interval in which it was done.
    done: AtomicU64,
}

impl NowAndThen {
    fn new(interval: Duration) -> Self {
        Self { interval, begin: moment(), done: AtomicU64::new(0) }
    }

    fn is_due(&self) -> bool {
        let current = self.begin.elapsed().as_secs() / self.interval.as_secs();
        self.done.fetch_max(current, Ordering::Relaxed) < current
    }
}
