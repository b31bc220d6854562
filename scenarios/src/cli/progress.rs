//! The line that shows, on a terminal, how a run is going.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::conduct::doing;
use crate::live::Live;

/// The progress line: time, battery, what the tree is doing, monitors. Only on a terminal, and only on stderr.
#[derive(Debug)]
pub(super) struct Progress {
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(super) fn new(silent: bool, max_time: Duration) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self { bar: None };
        }
        let bar = ProgressBar::with_draw_target(Some(max_time.as_secs()), ProgressDrawTarget::stderr_with_hz(10));
        // A template that is fixed here can be parsed; if not, the default style serves.
        if let Ok(style) = ProgressStyle::with_template("{spinner} {pos:>4} s  {msg}") {
            bar.set_style(style);
        }
        Self { bar: Some(bar) }
    }

    pub(super) fn show(&self, live: &Live) {
        let Some(bar) = &self.bar else { return };
        let monitors = live.watched().iter().zip(live.system().monitors());
        let monitors: Vec<String> =
            monitors.map(|(watched, attached)| format!("{}: {}", watched.name, attached.monitor.location())).collect();
        let charge_pct = live.truth().battery().charge_pct;
        bar.set_position(live.time().as_secs());
        bar.set_message(format!("battery {charge_pct:.1} %  {}  {}", doing(live), monitors.join("  ")));
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// How many of many runs are done. Only on a terminal, and only on stderr.
#[derive(Debug)]
pub(super) struct Bar(Option<ProgressBar>);

impl Bar {
    /// A bar that counts such things.
    pub(super) fn new(silent: bool, things: &str) -> Self {
        if silent || !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let template = format!("{{bar:40}} {{pos}} of {{len}} {things}, {{eta}} to go");
        // A template that is fixed here can be parsed; if not, the default style serves.
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        Self(Some(bar))
    }

    /// Shows how many of how many are done.
    pub(super) fn show(&self, done: usize, all: usize) {
        if let Some(bar) = &self.0 {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
