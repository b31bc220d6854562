//! Publishers whose messages are not received although they may go on publishing. Messages on a topic may be missing
//! until each of its publishers is received again, or has been subscribed to again.

use std::collections::BTreeMap;

/// How long a publisher that was found again may take to discover the subscription.
const SETTLING_NS: i64 = 500_000_000;

/// How long a new participant may take to find publishers that were not known before.
const FINDING_NS: i64 = 1_000_000_000;

/// Stands for publishers that are not known.
const UNKNOWN: [u8; 16] = [0; 16];

/// The publishers that are absent, by the indices of their topics.
#[derive(Debug, Default)]
pub(super) struct Absences(BTreeMap<usize, BTreeMap<[u8; 16], AbsenceState>>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AbsenceState {
    Missing,
    /// It was found again, and the clock has not advanced since.
    Found,
    /// It was found again, and will have discovered the subscription by this time.
    SettledBy(i64),
}

impl Absences {
    /// A publisher on a topic is absent.
    pub(super) fn add(&mut self, topic: usize, guid: [u8; 16]) {
        self.0.entry(topic).or_default().insert(guid, AbsenceState::Missing);
    }

    /// All publishers on a topic are absent, known or not, as a new participant has to find them.
    pub(super) fn add_all(&mut self, topic: usize, known: impl Iterator<Item = [u8; 16]>) {
        let known = known.map(|guid| (guid, AbsenceState::Missing));
        self.0.entry(topic).or_default().extend(known.chain([(UNKNOWN, AbsenceState::Found)]));
    }

    /// A publisher was found again.
    pub(super) fn mark_found(&mut self, guid: &[u8; 16]) {
        for state in
            self.0.values_mut().filter_map(|of| of.get_mut(guid)).filter(|state| **state == AbsenceState::Missing)
        {
            *state = AbsenceState::Found;
        }
    }

    /// A message of a publisher was received: its number shows what is missing. Returns whether another publisher on
    /// the topic is still absent.
    pub(super) fn mark_received(&mut self, topic: usize, guid: &[u8; 16]) -> bool {
        let Some(of) = self.0.get_mut(&topic) else { return false };
        of.remove(guid);
        // A participant that has found the known publishers has found the unknown ones as well.
        let is_over = of.keys().all(|guid| *guid == UNKNOWN);
        if is_over {
            self.0.remove(&topic);
        }
        !is_over
    }

    /// A publisher is not absent any more: it has left, or another has replaced it. Returns the topics on which no
    /// publisher is absent now.
    pub(super) fn remove(&mut self, guid: &[u8; 16]) -> Vec<usize> {
        self.0.values_mut().for_each(|of| _ = of.remove(guid));
        self.remove_complete()
    }

    /// The clock has advanced. Returns the topics on which no publisher is absent any more.
    pub(super) fn settle(&mut self, now_ns: i64) -> Vec<usize> {
        for of in self.0.values_mut() {
            for (guid, state) in of.iter_mut().filter(|(_, state)| **state == AbsenceState::Found) {
                let by_ns = if *guid == UNKNOWN { FINDING_NS } else { SETTLING_NS };
                *state = AbsenceState::SettledBy(now_ns.saturating_add(by_ns));
            }
            of.retain(|_, state| !matches!(state, AbsenceState::SettledBy(by_ns) if *by_ns <= now_ns));
        }
        self.remove_complete()
    }

    /// Removes the topics without absent publishers, and returns them.
    fn remove_complete(&mut self) -> Vec<usize> {
        let over = self.0.extract_if(.., |_, of| of.is_empty());
        over.map(|(topic, _)| topic).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn a_topic_is_complete_once_each_publisher_is_received_or_has_settled() {
        let mut absences = Absences::default();
        absences.add_all(0, [[1; 16], [2; 16]].into_iter());
        absences.add_all(1, std::iter::empty());
        assert_eq!(absences.settle(0), [0; 0]);
        absences.mark_found(&[1; 16]);
        assert!(absences.mark_received(0, &[2; 16]));
        assert_eq!(absences.settle(800 * MS), [0; 0]);
        // Its time to settle begins when the clock advances.
        assert_eq!((absences.settle(1200 * MS), absences.settle(1300 * MS)), (vec![1], vec![0]));
        assert!(absences.0.is_empty() && !absences.mark_received(0, &[1; 16]));
    }

    #[test]
    fn a_publisher_that_was_given_up_is_absent_until_it_returns_or_is_replaced() {
        let mut absences = Absences::default();
        absences.add(0, [1; 16]);
        absences.add(1, [2; 16]);
        assert!(absences.mark_received(0, &[3; 16]));
        assert_eq!((absences.settle(i64::MAX), absences.remove(&[1; 16])), (vec![], vec![0]));
        assert!(!absences.mark_received(1, &[2; 16]) && absences.0.is_empty());
    }
}
