//! The line that shows the progress of a run on a terminal.

use std::fmt::Write;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use campaigns::statistics::{Confidence, Count};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use recording::RunView;

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

/// How many of many runs are finished. Only on a terminal, and only on stderr.
#[derive(Debug)]
pub(crate) struct Bar(Option<ProgressBar>);

impl Bar {
    /// A bar that counts such things.
    pub(crate) fn new(silent: bool, things: &str) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let template = format!("{{bar:40}} {{pos}} of {{len}} {things}, {{eta}} left");
        // A fixed template can be parsed; if not, the default style is used.
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        Self(Some(bar))
    }

    /// Shows how many are finished, of how many.
    pub(crate) fn show(&self, done: usize, all: usize) {
        if let Some(bar) = &self.0 {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }
    }

    /// Runs `write`, whose lines appear above the bar.
    pub(crate) fn above<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.0 {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// The progress of a search. Only on a terminal, and only on stderr.
#[derive(Debug)]
pub(crate) struct ProofBar(Option<ProgressBar>);

impl ProofBar {
    /// A line for the proof of a property.
    pub(crate) fn new(silent: bool, property: &str) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let rate = |state: &ProgressState, text: &mut dyn Write| {
            let _ = write!(text, "{:.0}", state.per_sec());
        };
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {prefix}: {pos} states, {rate} per second, {wide_msg}")
        {
            bar.set_style(style.with_key("rate", rate));
        }
        bar.set_prefix(property.to_owned());
        Self(Some(bar))
    }

    pub(crate) fn show(&self, progress: &explorer::Progress) {
        if let Some(bar) = &self.0 {
            bar.set_position(progress.states);
            bar.set_message(format!("depth {}, {} MiB", progress.depth, progress.memory >> 20));
        }
    }

    /// Removes the line.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
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
        #[expect(clippy::disallowed_methods, reason = "a progress bar shows real time")]
        let now = Instant::now();
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
