//! What DDS loses, in the time of a run.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use channels::Flaw;
use remote::{Loss, Lost};

/// The most steps of which it is known when they were over: 20 minutes.
const MOST_STEPS: usize = 1 << 16;

/// What has been lost, and what is complete again, since it was last told.
#[derive(Debug, Default)]
pub(super) struct Losses {
    begun: Vec<Loss>,
    resumed: Vec<Lost>,
    /// What is missing, and since when.
    open: BTreeMap<Lost, Duration>,
    /// When the last steps were over, by the clock that gives messages their times.
    steps: VecDeque<(i64, Duration)>,
}

impl Losses {
    /// The run begins. What was lost before and is complete again is no part of it.
    pub(super) fn begin_run(&mut self) {
        let Self { begun, open, .. } = self;
        begun.retain(|loss| open.contains_key(&loss.what));
        self.resumed.clear();
    }

    /// A step of the run, to this time, is over at another time.
    pub(super) fn end_step(&mut self, now: Duration, at_ns: i64) {
        if self.steps.len() == MOST_STEPS {
            self.steps.pop_front();
        }
        self.steps.push_back((at_ns, now));
    }

    /// The time of the last step that was over at a time: what came later belongs to a later step.
    pub(super) fn step_before(&self, at_ns: i64) -> Duration {
        let later = self.steps.partition_point(|(over_ns, _)| *over_ns < at_ns);
        later.checked_sub(1).map_or(Duration::ZERO, |last| self.steps[last].1)
    }

    /// This may be missing since a time of the run. What begins later than a loss that goes on is part of it.
    pub(super) fn lose(&mut self, what: Lost, flaw: Flaw, since: Duration, why: String) {
        self.resumed.retain(|resumed| *resumed != what);
        if self.open.get(&what).is_none_or(|open| since < *open) {
            self.open.insert(what.clone(), since);
            self.begun.push(Loss { what, flaw, since, why });
        }
    }

    /// From here on, this is complete.
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
    fn what_was_lost_after_a_message_belongs_to_the_step_in_which_that_came_or_to_a_later_one() {
        let mut losses = Losses::default();
        assert_eq!(losses.step_before(i64::MAX), Duration::ZERO);
        (1..=3).for_each(|step| losses.end_step(ms(20 * step), 1_000 + 100 * step as i64));
        let before = [1_000, 1_100, 1_101, 1_250, 1_300, 9_000].map(|at_ns| losses.step_before(at_ns).as_millis());
        assert_eq!(before, [0, 0, 20, 40, 40, 60]);
        (0..MOST_STEPS as u64).for_each(|step| losses.end_step(ms(1_000 + step), 10_000));
        assert_eq!(losses.step_before(1_250), Duration::ZERO, "it is no longer known");
    }

    #[test]
    fn a_loss_goes_on_until_something_comes_and_one_that_begins_later_is_part_of_it() {
        let mut losses = Losses::default();
        losses.resume(&pose());
        assert_eq!(losses.take(), (vec![], vec![]));
        [40, 60, 20].into_iter().for_each(|since| lose(&mut losses, ms(since)));
        let (begun, resumed) = losses.take();
        assert_eq!((begun.iter().map(|loss| loss.since).collect::<Vec<_>>(), resumed), (vec![ms(40), ms(20)], vec![]));
        losses.resume(&pose());
        losses.resume(&pose());
        assert_eq!(losses.take(), (vec![], vec![pose()]));
        // It comes back, and is lost again before that is told.
        lose(&mut losses, ms(80));
        losses.resume(&pose());
        lose(&mut losses, ms(100));
        let (begun, resumed) = losses.take();
        assert_eq!((begun.len(), resumed), (2, vec![]));
    }

    #[test]
    fn what_was_lost_before_the_run_matters_only_if_it_is_still_missing() {
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
