//! The progress of runs, campaigns and proofs, on stderr.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use campaigns::statistics::{Confidence, Count};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use proofs::Round;
use recording::RunView;
use serde_json::json;

use crate::output::complain_of;

/// The progress line: time, battery, what the tree is doing, and monitors. Only on a terminal, and only on stderr.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(crate) fn new(silent: bool, max_time: Duration) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self { bar: None };
        }
        let bar = ProgressBar::with_draw_target(Some(max_time.as_secs()), ProgressDrawTarget::stderr_with_hz(10));
        // A fixed template can be parsed; if not, the default style is used.
        if let Ok(style) = ProgressStyle::with_template("{spinner} {pos:>4} s  {wide_msg}") {
            bar.set_style(style);
        }
        Self { bar: Some(bar) }
    }

    /// Shows the state of the run, once per simulated second.
    pub(crate) fn show(&self, view: &RunView) {
        let Some(bar) = &self.bar else { return };
        if view.time().as_secs() == bar.position() && !view.time().is_zero() {
            return;
        }
        let monitors = view.monitors().map(|monitor| format!("{}: {}", monitor.name(), monitor.state.location));
        let monitors: Vec<String> = monitors.collect();
        let level = view.robot().battery.map_or_else(String::new, |it| format!("battery {:.1} %  ", it.charge_pct));
        bar.set_position(view.time().as_secs());
        bar.set_message(format!("{level}{}  {}", view.doing(), monitors.join("  ")));
    }

    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// How many of many things are finished, on stderr. Without a terminal, only if [`or_lines`](Bar::or_lines) says so.
#[derive(Debug)]
pub(crate) struct Bar {
    things: &'static str,
    bar: Option<ProgressBar>,
    lines: Option<NowAndThen>,
}

impl Bar {
    /// A bar that counts such things.
    pub(crate) fn new(silent: bool, things: &'static str) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self { things, bar: None, lines: None };
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let template = format!("{{bar:40}} {{pos}} of {{len}} {things}, {{eta}} left");
        // A fixed template can be parsed; if not, the default style is used.
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        Self { things, bar: Some(bar), lines: None }
    }

    /// The same, with a line now and then where there is no terminal, unless it is silent.
    pub(crate) fn or_lines(self, silent: bool) -> Self {
        let lines = (!silent && self.bar.is_none()).then(|| NowAndThen::new(BETWEEN_LINES));
        Self { lines, ..self }
    }

    /// Shows how many are finished, of how many.
    pub(crate) fn show(&self, done: usize, all: usize) {
        if let Some(bar) = &self.bar {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }
        if self.lines.as_ref().is_some_and(NowAndThen::is_due) {
            complain_of(format!("{done} of {all} {}\n", self.things));
        }
    }

    /// Runs `write`, whose lines appear above the bar.
    pub(crate) fn above<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The time between two lines of progress for people, where there is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// The time between two lines of progress for programs.
const BETWEEN_OBJECTS: Duration = Duration::from_secs(1);

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
        Self { interval, begin: now(), done: AtomicU64::new(0) }
    }

    fn is_due(&self) -> bool {
        let current = now().duration_since(self.begin).as_secs() / self.interval.as_secs();
        self.done.fetch_max(current, Ordering::Relaxed) < current
    }
}

#[expect(clippy::disallowed_methods, reason = "progress is shown in real time")]
fn now() -> Instant {
    Instant::now()
}

/// The form in which a proof shows its progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressForm {
    Text,
    // An object at the beginning of each round, and then every second.
    Json,
}

/// The progress of a proof, on stderr.
#[derive(Debug)]
pub(crate) struct ProofProgress {
    property: String,
    shown: Shown,
    /// The number of the round that was shown last.
    round: usize,
}

#[derive(Debug)]
enum Shown {
    Nothing,
    Bar(ProgressBar),
    Lines(NowAndThen),
    Objects(NowAndThen),
}

impl ProofProgress {
    /// Of the proof of a property; not shown without a form.
    pub(crate) fn new(form: Option<ProgressForm>, property: &str) -> Self {
        let shown = match form {
            None => Shown::Nothing,
            Some(ProgressForm::Json) => Shown::Objects(NowAndThen::new(BETWEEN_OBJECTS)),
            Some(ProgressForm::Text) if std::io::stderr().is_terminal() => Shown::Bar(Self::bar(property)),
            Some(ProgressForm::Text) => Shown::Lines(NowAndThen::new(BETWEEN_LINES)),
        };
        Self { property: property.to_owned(), shown, round: 0 }
    }

    fn bar(property: &str) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let rate = |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{:.0}", state.per_sec());
        };
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {prefix}: {pos} states visited, {rate} per second, {wide_msg}")
        {
            bar.set_style(style.with_key("rate", rate));
        }
        bar.set_prefix(property.to_owned());
        bar
    }

    pub(crate) fn show(&mut self, round: &Round) {
        let is_new = std::mem::replace(&mut self.round, round.number) != round.number;
        let explorer::Progress { states, visited, quiet, depth, memory, is_reduced, is_complete } = round.progress;
        match &self.shown {
            Shown::Bar(bar) => {
                bar.set_position(visited);
                bar.set_message(in_words(round));
            }
            Shown::Lines(lines) if lines.is_due() => {
                complain_of(format!("{}: {visited} states visited, {}\n", self.property, in_words(round)));
            }
            Shown::Objects(objects) if objects.is_due() || is_new => {
                let object = json!({
                    "property": self.property,
                    "round": round.number,
                    "levels": round.levels,
                    "reduced": is_reduced,
                    "states": states,
                    "visited_states": visited,
                    "quiet_states": quiet,
                    "depth": depth,
                    "memory_bytes": memory,
                    "complete": is_complete,
                });
                complain_of(format!("{object}\n"));
            }
            Shown::Nothing | Shown::Lines(_) | Shown::Objects(_) => {}
        }
    }

    /// Removes the line.
    pub(crate) fn finish(&self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish_and_clear();
        }
    }
}

/// How far a round of a proof is, without the states.
fn in_words(Round { number, levels, progress }: &Round) -> String {
    let mut text = format!("depth {}, {} MiB", progress.depth, progress.memory >> 20);
    if *number > 1 {
        text += &format!(", round {number}");
        // The first round says nothing about its levels, which are the coarsest.
        if let Some(levels) = levels {
            text += &format!(" with {levels} classes of levels");
        }
    }
    if progress.is_complete {
        text += ", looking for cycles";
    }
    text
}

/// How long the bar of a campaign shows the same estimates of probabilities.
const ESTIMATES_STAY: Duration = Duration::from_millis(500);

/// The progress of a campaign: runs per second, the remaining time, and the estimates so far. Only on a terminal, and
/// only on stderr.
#[derive(Debug)]
pub(crate) struct CampaignBar {
    bar: Option<ProgressBar>,
    /// When the estimates were last computed.
    estimated: Option<Instant>,
}

impl CampaignBar {
    pub(crate) fn new(silent: bool) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self { bar: None, estimated: None };
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        // A fixed template can be parsed; if not, the default style is used.
        let template = "{bar:24} {pos} of {len} runs, {rate} per second, {eta} left\n{wide_msg}";
        let rate = |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{:.1}", state.per_sec());
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("rate", rate));
        }
        Self { bar: Some(bar), estimated: None }
    }

    pub(crate) fn show(&mut self, progress: &campaigns::Progress<'_>) {
        let Some(bar) = &self.bar else { return };
        let now = now();
        bar.set_length(progress.all);
        bar.set_position(progress.done);
        let Some(estimated) = self.estimated else {
            // Runs of earlier sessions say nothing about the speed of this one.
            bar.reset_elapsed();
            bar.reset_eta();
            bar.set_message(estimates(progress));
            self.estimated = Some(now);
            return;
        };
        if now.duration_since(estimated) >= ESTIMATES_STAY {
            bar.set_message(estimates(progress));
            self.estimated = Some(now);
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// How often each property was violated and a run was not as expected so far, with exact 95 % intervals.
fn estimates(progress: &campaigns::Progress<'_>) -> String {
    let mut text = String::new();
    let Ok(confidence) = Confidence::new(0.95) else { return text };
    let happened = |count: &Count| Some((count.rate()?, count.interval(confidence)));
    for (name, (rate, interval)) in
        progress.asked.iter().zip(progress.counts).filter_map(|(name, count)| Some((name, happened(count)?)))
    {
        let name = if name == "expectation" { "unexpected" } else { name };
        // Writing to a string cannot fail.
        let _ = write!(text, "{name} {rate:.3} ({interval:.3})  ");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_include_what_has_been_counted() {
        let asked = ["phi1".to_owned(), "phi2".to_owned(), "expectation".to_owned()];
        let counts = [Count::new(5, 10), Count::default(), Count::new(10, 20)];
        let progress = campaigns::Progress { done: 20, all: 100, asked: &asked, counts: &counts, run: None };
        assert_eq!(estimates(&progress), "phi1 0.500 (0.187 to 0.813)  unexpected 0.500 (0.272 to 0.728)  ");
    }
}
