//! Several recordings beside each other: how they are aligned, and where they first differ.

use std::time::Duration;

use recording::{Agreement, Difference, RunComparison, RunView};
use serde_json::{Value, json};

/// Recordings beside each other. Each is compared with the first one.
pub(crate) struct Beside {
    /// The names of the files.
    files: Vec<String>,
    /// For each recording but the first.
    comparisons: Vec<RunComparison>,
    /// Whether they are aligned, if they can be.
    pub(crate) aligns: bool,
}

impl Beside {
    /// Recordings of which only the start has been read. They are aligned as soon as they agree.
    pub(crate) fn new(files: Vec<String>, runs: &[&RunView]) -> Self {
        let comparison = |run: &&RunView| RunComparison::new([runs[0].header(), run.header()]);
        Self { files, comparisons: runs.iter().skip(1).map(comparison).collect(), aligns: true }
    }

    /// Takes note of the last step of a recording.
    pub(crate) fn note(&mut self, run: usize, view: &RunView) {
        match run.checked_sub(1) {
            None => self.comparisons.iter_mut().for_each(|comparison| comparison.note(0, view)),
            Some(other) => self.comparisons[other].note(1, view),
        }
    }

    /// How long after the start of the page each run begins, so that all agree at the same time.
    pub(crate) fn delays(&self) -> Vec<Duration> {
        // How long after the first run each one begins, in nanoseconds.
        let offset = |comparison: &RunComparison| {
            let [first, other] =
                comparison.agreement().filter(|_| self.aligns)?.times.map(|time| time.as_nanos() as i128);
            Some(first - other)
        };
        let others = self.comparisons.iter().map(|comparison| offset(comparison).unwrap_or(0));
        let offsets: Vec<i128> = std::iter::once(0).chain(others).collect();
        let earliest = offsets.iter().copied().min().unwrap_or(0);
        let delay = |offset: i128| Duration::from_nanos(u64::try_from(offset - earliest).unwrap_or(u64::MAX));
        offsets.into_iter().map(delay).collect()
    }

    /// The node of a run, by its index, that first gave another result than in another run.
    pub(crate) fn differing(&self, run: usize) -> Option<usize> {
        match run.checked_sub(1) {
            None => self.first_difference().map(|(_, difference)| difference.nodes[0]),
            Some(other) => self.comparisons[other].difference().map(|difference| difference.nodes[1]),
        }
    }

    /// The difference that comes first in the first run, and in which of the others it is.
    fn first_difference(&self) -> Option<(usize, &Difference)> {
        let differences = self.comparisons.iter().enumerate();
        let differences = differences.filter_map(|(other, comparison)| Some((other + 1, comparison.difference()?)));
        differences.min_by_key(|(_, difference)| difference.times[0])
    }

    /// The comparison for the page; `over` is whether everything has been read. `difference_s` is the time of the
    /// first difference on the page, in seconds.
    pub(crate) fn describe(&self, over: bool) -> Value {
        let can_align = self.comparisons.iter().any(|comparison| comparison.agreement().is_some());
        let words = self.comparisons.iter().enumerate().flat_map(|(index, comparison)| {
            [self.difference(index + 1, comparison, over), self.alignment(index + 1, comparison)]
        });
        let delays = self.delays();
        // When both have answered.
        let shown = |(other, difference): (usize, &Difference)| {
            (difference.times[0] + delays[0]).max(difference.times[1] + delays[other]).as_secs_f64()
        };
        json!({
            "can_align": can_align,
            "aligns": self.aligns,
            "words": words.collect::<Vec<_>>().join(" "),
            "difference_s": self.first_difference().map(shown),
        })
    }

    fn alignment(&self, other: usize, comparison: &RunComparison) -> String {
        let (one, another) = (&self.files[0], &self.files[other]);
        match comparison.agreement() {
            _ if !self.aligns => format!("{another} is not aligned with {one}: each is shown from its own start."),
            Some(Agreement { name, answer, times }) => {
                let [here, there] = times.map(seconds);
                let answer = answer.name();
                format!("Aligned where {name} first answered {answer}: {here} in {one}, {there} in {another}.")
            }
            None => format!("{another} is not aligned with {one}: no node has given the same first answer in both."),
        }
    }

    fn difference(&self, other: usize, comparison: &RunComparison, over: bool) -> String {
        let (one, another) = (&self.files[0], &self.files[other]);
        let mut words = match comparison.difference() {
            Some(Difference { name, results, times, .. }) => {
                let ([here, there], [was, instead]) = (times.map(seconds), results.map(|result| result.name()));
                format!("First different result: {name}, {was} at {here} in {one}, {instead} at {there} in {another}.")
            }
            None if !comparison.has_common_nodes() => format!("{one} and {another} have no nodes in common."),
            None if over => format!("All results that are in both {one} and {another} are the same."),
            None => format!("All results so far that are in both {one} and {another} are the same."),
        };
        if comparison.has_common_nodes() && comparison.others() > 0 {
            words += &format!(" Nodes of which one tree has none, or fewer: {}.", comparison.others());
        }
        words
    }
}

fn seconds(time: Duration) -> String {
    format!("{:.2} s", time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use recording::{Details, Header, Node, Step};

    use super::*;

    /// A log of a tree with one node, which answers at these seconds.
    fn log(answers: &[(u64, bt::Outcome)]) -> (RunView, Vec<Step>) {
        let node = Node { parent: None, process: "main".to_owned(), symbol: None, is_leaf: true };
        let header = Header { tree: vec![node], ..Header::default() };
        let step = |&(second, outcome): &(u64, bt::Outcome)| Step {
            time: Duration::from_secs(second),
            details: Some(Box::new(Details { outcomes: vec![(0, Some(outcome))], ..Details::default() })),
            ..Step::default()
        };
        (RunView::new(header, Step::default()).unwrap(), answers.iter().map(step).collect())
    }

    #[test]
    fn runs_begin_late_where_they_agree_and_from_their_own_start_otherwise() {
        let [running, good, bad] =
            [bt::Status::Running, bt::Status::Success, bt::Status::Failure].map(bt::Outcome::Answered);
        let mut logs =
            [log(&[(2, running), (5, good)]), log(&[(7, running), (9, bad)]), log(&[(1, running), (2, good)])];
        let starts: Vec<&RunView> = logs.iter().map(|(start, _)| start).collect();
        let mut beside = Beside::new(["a", "b", "c"].map(str::to_owned).to_vec(), &starts);
        assert_eq!(beside.describe(false)["can_align"], false);
        for (run, (view, steps)) in logs.iter_mut().enumerate() {
            for step in steps.drain(..) {
                view.apply(step).unwrap();
                beside.note(run, view);
            }
        }
        assert_eq!(beside.delays(), [5, 0, 6].map(Duration::from_secs));
        assert_eq!([0, 1, 2].map(|run| beside.differing(run)), [Some(0), Some(0), None]);
        let described = beside.describe(true);
        // The first run gives its result at 10 s of the page, the second at 9 s.
        assert_eq!(described["difference_s"], 10.0);
        let words = described["words"].as_str().unwrap();
        for part in [
            "First different result: main, success at 5.00 s in a, failure at 9.00 s in b.",
            "Aligned where main first answered running: 2.00 s in a, 7.00 s in b.",
            "All results that are in both a and c are the same.",
        ] {
            assert!(words.contains(part), "{words}");
        }
        beside.aligns = false;
        assert_eq!(beside.delays(), [Duration::ZERO; 3]);
        assert!(beside.describe(true)["words"].as_str().unwrap().contains("b is not aligned with a"));
    }
}
