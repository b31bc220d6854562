//! Publishers that are not heard, though they may go on: until each is heard again, or known to be, messages on their
//! topics may be missing.

use std::collections::BTreeMap;

/// How long a publisher that is known again may not have noticed that it is subscribed to.
const SETTLING_NS: i64 = 500_000_000;

/// How long it may take a new participant to find publishers that were not known before.
const FINDING_NS: i64 = 1_000_000_000;

/// What stands for publishers that are not known.
const UNKNOWN: [u8; 16] = [0; 16];

/// The publishers that are absent, by the indices of their topics.
#[derive(Debug, Default)]
pub(super) struct Absences(BTreeMap<usize, BTreeMap<[u8; 16], AbsenceState>>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AbsenceState {
    Missing,
    /// It is known again; but not since when, as no time has been told since.
    Found,
    /// Until then, it may not have noticed the subscription.
    SettledBy(i64),
}

impl Absences {
    /// A publisher on a topic is not heard.
    pub(super) fn miss(&mut self, topic: usize, guid: [u8; 16]) {
        self.0.entry(topic).or_default().insert(guid, AbsenceState::Missing);
    }

    /// No publisher on a topic is heard, known or not, until another participant has taken over.
    pub(super) fn miss_all(&mut self, topic: usize, known: impl Iterator<Item = [u8; 16]>) {
        let known = known.map(|guid| (guid, AbsenceState::Missing));
        self.0.entry(topic).or_default().extend(known.chain([(UNKNOWN, AbsenceState::Found)]));
    }

    /// A publisher is known again.
    pub(super) fn find(&mut self, guid: &[u8; 16]) {
        for state in
            self.0.values_mut().filter_map(|of| of.get_mut(guid)).filter(|state| **state == AbsenceState::Missing)
        {
            *state = AbsenceState::Found;
        }
    }

    /// A publisher was heard: its numbers tell what is missing of it. Returns whether another on the topic still is.
    pub(super) fn hear(&mut self, topic: usize, guid: &[u8; 16]) -> bool {
        let Some(of) = self.0.get_mut(&topic) else { return false };
        of.remove(guid);
        // Publishers that are not known are found while the others are.
        let is_over = of.keys().all(|guid| *guid == UNKNOWN);
        if is_over {
            self.0.remove(&topic);
        }
        !is_over
    }

    /// A publisher does not go on: another has taken its place. Returns the topics on which no publisher is absent now.
    pub(super) fn give_up(&mut self, guid: &[u8; 16]) -> Vec<usize> {
        self.0.values_mut().for_each(|of| _ = of.remove(guid));
        self.end()
    }

    /// The topics on which everybody is heard again, now that this time is told.
    pub(super) fn settle(&mut self, now_ns: i64) -> Vec<usize> {
        for of in self.0.values_mut() {
            for (guid, state) in of.iter_mut().filter(|(_, state)| **state == AbsenceState::Found) {
                let by_ns = if *guid == UNKNOWN { FINDING_NS } else { SETTLING_NS };
                *state = AbsenceState::SettledBy(now_ns.saturating_add(by_ns));
            }
            of.retain(|_, state| !matches!(state, AbsenceState::SettledBy(by_ns) if *by_ns <= now_ns));
        }
        self.end()
    }

    fn end(&mut self) -> Vec<usize> {
        let over = self.0.extract_if(.., |_, of| of.is_empty());
        over.map(|(topic, _)| topic).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn a_topic_is_whole_again_once_each_publisher_is_heard_or_has_settled() {
        let mut absences = Absences::default();
        absences.miss_all(0, [[1; 16], [2; 16]].into_iter());
        absences.miss_all(1, std::iter::empty());
        assert_eq!(absences.settle(0), [0; 0]);
        absences.find(&[1; 16]);
        assert!(absences.hear(0, &[2; 16]));
        assert_eq!(absences.settle(800 * MS), [0; 0]);
        // Its time begins when time is told again.
        assert_eq!((absences.settle(1200 * MS), absences.settle(1300 * MS)), (vec![1], vec![0]));
        assert!(absences.0.is_empty() && !absences.hear(0, &[1; 16]));
    }

    #[test]
    fn one_that_was_given_up_is_absent_until_it_returns_or_is_replaced() {
        let mut absences = Absences::default();
        absences.miss(0, [1; 16]);
        absences.miss(1, [2; 16]);
        assert!(absences.hear(0, &[3; 16]));
        assert_eq!((absences.settle(i64::MAX), absences.give_up(&[1; 16])), (vec![], vec![0]));
        assert!(!absences.hear(1, &[2; 16]) && absences.0.is_empty());
    }
}
