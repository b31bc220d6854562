//! A state that changes now and then.

use std::time::Duration;

/// A state over time, as a list of changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<S> {
    changes: Vec<(Duration, S)>,
}

impl<S> Default for Track<S> {
    fn default() -> Self {
        Self { changes: Vec::new() }
    }
}

/// A stretch of time in which the state does not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<'a, S> {
    /// When it began.
    pub from: Duration,
    /// When it ended.
    pub to: Duration,
    /// The state.
    pub state: &'a S,
}

impl<S: PartialEq + Clone> Track<S> {
    /// Notes the present state. Times must not decrease; of two states at the same time, the later one counts.
    pub fn note(&mut self, now: Duration, state: &S) {
        if self.changes.last().is_some_and(|(_, last)| last == state) {
            return;
        }
        if self.changes.last().is_some_and(|(since, _)| *since == now) {
            self.changes.pop();
            // The state may be the same as before that moment.
            return self.note(now, state);
        }
        self.changes.push((now, state.clone()));
    }
}

impl<S: Clone> Track<S> {
    pub(super) fn until(&self, time: Duration) -> Self {
        Self { changes: self.changes.iter().take_while(|(since, _)| *since <= time).cloned().collect() }
    }
}

impl<S> Track<S> {
    /// The stretches of time, one after the other; the last one ends at `end`.
    pub fn spans(&self, end: Duration) -> impl Iterator<Item = Interval<'_, S>> {
        let ends = self.changes.iter().skip(1).map(|(time, _)| *time).chain([end]);
        self.changes.iter().zip(ends).map(|((from, state), to)| Interval { from: *from, to, state })
    }

    /// When it changed, without its beginning.
    pub fn changes(&self) -> impl Iterator<Item = Duration> + '_ {
        self.changes.iter().skip(1).map(|(time, _)| *time)
    }

    /// The state at a time; `None` before the first one.
    #[must_use]
    pub fn at(&self, time: Duration) -> Option<&S> {
        let after = self.changes.partition_point(|(since, _)| *since <= time);
        Some(&self.changes[after.checked_sub(1)?].1)
    }
}

/// A named track.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane<S> {
    /// Whose state it is.
    pub name: String,
    /// The state over time.
    pub track: Track<S>,
}

impl<S> Lane<S> {
    pub(super) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), track: Track::default() }
    }
}

impl<S: Clone> Lane<S> {
    pub(super) fn all_until(lanes: &[Self], time: Duration) -> Vec<Self> {
        lanes.iter().map(|lane| Self { name: lane.name.clone(), track: lane.track.until(time) }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: u64) -> Duration {
        Duration::from_secs(time_s)
    }

    #[test]
    fn only_changes_are_kept() {
        let mut track = Track::default();
        for (time_s, state) in [(0, 'a'), (1, 'a'), (2, 'b'), (2, 'c'), (3, 'c'), (5, 'd'), (5, 'c'), (7, 'a')] {
            track.note(at(time_s), &state);
        }
        let spans: Vec<_> = track.spans(at(9)).map(|span| (span.from, span.to, *span.state)).collect();
        assert_eq!(spans, [(at(0), at(2), 'a'), (at(2), at(7), 'c'), (at(7), at(9), 'a')]);
        assert_eq!(track.changes().collect::<Vec<_>>(), [at(2), at(7)]);
    }

    #[test]
    fn a_state_holds_until_the_next_one() {
        let mut track = Track::default();
        assert_eq!(track.at(at(4)), None);
        track.note(at(1), &'a');
        track.note(at(3), &'b');
        assert_eq!(
            [0, 1, 2, 3, 4].map(|time_s| track.at(at(time_s)).copied()),
            [None, Some('a'), Some('a'), Some('b'), Some('b')]
        );
    }
}
