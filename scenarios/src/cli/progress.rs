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
