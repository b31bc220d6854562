//! The progress of a campaign.

use std::time::{Duration, Instant};

use campaigns::statistics::{Confidence, Count};

use super::ProgressLine;
use crate::moment::moment;

/// How long the bar of a campaign shows the same estimates of probabilities.
const ESTIMATES_STAY: Duration = Duration::from_millis(500);

/// The progress of a campaign: runs per second, the remaining time, and the estimates so far.
#[derive(Debug)]
pub(crate) struct CampaignProgress {
    line: ProgressLine,
    /// When the estimates were last computed.
    estimated: Option<Instant>,
}

impl CampaignProgress {
    pub(crate) fn new(silent: bool) -> Self {
        let template = "{bar:24} {pos} of {len} runs, {rate} per second, {eta} left\n{wide_msg}";
        Self { line: ProgressLine::new(silent, template, 1), estimated: None }
    }

    pub(crate) fn show(&mut self, progress: &campaigns::Progress<'_>) {
        let Some(bar) = &self.line.0 else { return };
        let now = moment();
        bar.set_length(progress.all);
        bar.set_position(progress.done);
        let Some(estimated) = self.estimated else {
            // Runs of earlier sessions do not count for the speed of this one.
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
}

/// How often each property was violated and a run was not as expected so far, with exact 95 % intervals.
fn estimates(progress: &campaigns::Progress<'_>) -> String {
    let estimate = |name: &str, count: Count| {
        let (rate, interval) = (count.rate()?, count.interval(Confidence::OF_RESULTS));
        Some(format!("{name} {rate:.3} ({interval:.3})  "))
    };
    let violated = progress.properties.iter().zip(progress.violated);
    let violated = violated.filter_map(|(name, count)| estimate(name, *count));
    violated.chain(estimate("unexpected", progress.unexpected)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_include_what_has_been_counted() {
        let properties = ["phi1".to_owned(), "phi2".to_owned()];
        let violated = [Count::new(5, 10), Count::default()];
        let unexpected = Count::new(10, 20);
        let progress = campaigns::Progress {
            done: 20,
            all: 100,
            properties: &properties,
            violated: &violated,
            unexpected,
            run: None,
        };
        assert_eq!(estimates(&progress), "phi1 0.500 (0.187 to 0.813)  unexpected 0.500 (0.272 to 0.728)  ");
    }
}
