//! The losses of DDS, in the time of a run.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use channels::Flaw;
use remote::{Loss, Lost};

/// The most steps whose ends are remembered: 20 minutes.
const MOST_STEPS: usize = 1 << 16;

/// The losses that have begun and ended since they were last taken.
#[derive(Debug, Default)]
pub(super) struct Losses {
    begun: Vec<Loss>,
    resumed: Vec<Lost>,
    /// The losses that have not ended, and since when.
    open: BTreeMap<Lost, Duration>,
    /// The ends of the last steps: by the clock that stamps received messages, and in the time of the run.
    steps: VecDeque<(i64, Duration)>,
}

impl Losses {
    /// The run begins. Losses that have ended before are not part of it.
    pub(super) fn begin_run(&mut self) {
        let Self { begun, open, .. } = self;
        begun.retain(|loss| open.contains_key(&loss.what));
        self.resumed.clear();
    }

    /// A step to time `now` of the run has ended at `at_ns`.
    pub(super) fn end_step(&mut self, now: Duration, at_ns: i64) {
        if self.steps.len() == MOST_STEPS {
            self.steps.pop_front();
        }
        self.steps.push_back((at_ns, now));
    }

    /// The time of the run at the end of the last step before `at_ns`. Whatever came later belongs to a later step.
    pub(super) fn step_before(&self, at_ns: i64) -> Duration {
        let later = self.steps.partition_point(|(over_ns, _)| *over_ns < at_ns);
        later.checked_sub(1).map_or(Duration::ZERO, |last| self.steps[last].1)
    }

    /// Records a loss since a time of the run. One that begins during another loss of the same is part of it.
    pub(super) fn lose(&mut self, what: Lost, flaw: Flaw, since: Duration, why: String) {
        self.resumed.retain(|resumed| *resumed != what);
        if self.open.get(&what).is_none_or(|open| since < *open) {
            self.open.insert(what.clone(), since);
            self.begun.push(Loss { what, flaw, since, why });
        }
    }

    /// Ends a loss: from here on, nothing more is missing.
    pub(super) fn resume(&mut self, what: &Lost) {
        if let Some((what, _)) = self.open.remove_entry(what) {
            self.resumed.push(what);
        }
    }

    pub(super) fn take(&mut self) -> (Vec<Loss>, Vec<Lost>) {
        (std::mem::take(&mut self.begun), std::mem::take(&mut self.resumed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    fn pose() -> Lost {
        Lost::Topic("/pose".to_owned())
    }

    fn lose(losses: &mut Losses, since: Duration) {
        losses.lose(pose(), Flaw::Missing, since, String::new());
    }

    #[test]
    fn a_loss_after_a_message_belongs_to_the_step_of_that_message_or_a_later_one() {
        let mut losses = Losses::default();
        assert_eq!(losses.step_before(i64::MAX), Duration::ZERO);
        (1..=3).for_each(|step| losses.end_step(ms(20 * step), 1_000 + 100 * step as i64));
        let before = [1_000, 1_100, 1_101, 1_250, 1_300, 9_000].map(|at_ns| losses.step_before(at_ns).as_millis());
        assert_eq!(before, [0, 0, 20, 40, 40, 60]);
        (0..MOST_STEPS as u64).for_each(|step| losses.end_step(ms(1_000 + step), 10_000));
        assert_eq!(losses.step_before(1_250), Duration::ZERO, "it is no longer known");
    }

    #[test]
    fn a_loss_lasts_until_the_next_message_and_one_that_begins_during_it_is_part_of_it() {
        let mut losses = Losses::default();
        losses.resume(&pose());
        assert_eq!(losses.take(), (vec![], vec![]));
        [40, 60, 20].into_iter().for_each(|since| lose(&mut losses, ms(since)));
        let (begun, resumed) = losses.take();
        assert_eq!((begun.iter().map(|loss| loss.since).collect::<Vec<_>>(), resumed), (vec![ms(40), ms(20)], vec![]));
        losses.resume(&pose());
        losses.resume(&pose());
        assert_eq!(losses.take(), (vec![], vec![pose()]));
        // The topic resumes, and is lost again before that is taken.
        lose(&mut losses, ms(80));
        losses.resume(&pose());
        lose(&mut losses, ms(100));
        let (begun, resumed) = losses.take();
        assert_eq!((begun.len(), resumed), (2, vec![]));
    }

    #[test]
    fn a_loss_before_the_run_counts_only_if_it_has_not_ended() {
        let mut losses = Losses::default();
        lose(&mut losses, Duration::ZERO);
        losses.resume(&pose());
        losses.begin_run();
        assert_eq!(losses.take(), (vec![], vec![]));
        lose(&mut losses, Duration::ZERO);
        losses.begin_run();
        assert_eq!(losses.take().0.len(), 1);
    }
}
