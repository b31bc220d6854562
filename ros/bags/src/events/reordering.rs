//! Messages in the order of their times, which is nearly that in which they were recorded.

use std::collections::VecDeque;

use channels::{ChannelId, Gap, Message};

use super::times::EventTimes;

/// What waits for what may have to come before it.
pub(super) enum Waiting {
    /// A message that an entry of a topic has made.
    Message((usize, usize), Message),
    /// In a box, so that a message takes little memory: nearly everything that waits is one.
    Gap(Box<Gap>),
    Resumed(ChannelId),
}

fn is_message(waiting: &Waiting) -> bool {
    matches!(waiting, Waiting::Message(..))
}

/// A message of an entry of a topic, and its time.
pub(super) type Timed = (i64, (usize, usize), Message);

/// What has been read but not returned.
pub(super) struct Reordering {
    /// By time and order in the bag.
    waiting: VecDeque<(i64, Waiting)>,
    /// Before the first event: messages whose times are far from those that wait, until more agree with one than with
    /// the other.
    pub(super) odd: Vec<Timed>,
    reorder_ns: i64,
    /// The latest time read.
    newest_ns: i64,
    /// Until when time has passed, if messages have the times at which they were received: no earlier message follows.
    passed_ns: i64,
    /// Whether nothing follows.
    pub(super) is_over: bool,
}

impl Reordering {
    /// Nothing waits yet. A message is waited for this long.
    pub(super) fn within(reorder_ns: i64) -> Self {
        let (waiting, odd) = (VecDeque::new(), Vec::new());
        Self { waiting, odd, reorder_ns, newest_ns: i64::MIN, passed_ns: i64::MIN, is_over: false }
    }

    pub(super) fn put(&mut self, time_ns: i64, what: Waiting) {
        self.newest_ns = self.newest_ns.max(time_ns);
        // Messages are recorded nearly in the order of their times, so the place is searched from the end. It nearly
        // always is the end, where `insert` takes 40 instructions more than `push_back`.
        match self.waiting.iter().rev().take_while(|(later_ns, ..)| *later_ns > time_ns).count() {
            0 => self.waiting.push_back((time_ns, what)),
            later => self.waiting.insert(self.waiting.len() - later, (time_ns, what)),
        }
    }

    /// Puts a gap where it begins. Returns it if nothing waits before it.
    pub(super) fn put_gap(&mut self, mut gap: Gap, since_ns: i64, times: &EventTimes) -> Option<Gap> {
        // What waits after the last message before the gap has not been judged yet. An earlier gap of the channel
        // may end only after some of it, which is judged before this gap is returned.
        let is_end = |what: &Waiting| matches!(what, Waiting::Resumed(of) if Some(*of) == gap.channel);
        let place_after = |place: Option<usize>| place.map_or(0, |place| place + 1);
        let begins = place_after(self.waiting.iter().rposition(|(time_ns, _)| *time_ns <= since_ns));
        let place = begins.max(place_after(self.waiting.iter().rposition(|(_, what)| is_end(what))));
        let mut judged = self.waiting.range(begins..place);
        if judged.any(|(_, what)| is_message(what)) || place == 0 && times.start_ns.is_some() {
            gap.since = Some(times.since_start(since_ns));
        }
        let Some(last) = place.checked_sub(1) else { return Some(gap) };
        self.waiting.insert(place, (since_ns.max(self.waiting[last].0), Waiting::Gap(Box::new(gap))));
        None
    }

    /// No earlier message follows.
    pub(super) fn pass(&mut self, passed_ns: i64) {
        self.passed_ns = passed_ns;
        self.newest_ns = self.newest_ns.max(passed_ns);
    }

    /// Until when nothing can come any more, even late.
    pub(super) fn settled_ns(&self) -> i64 {
        self.passed_ns.saturating_sub(if self.is_over { 0 } else { self.reorder_ns })
    }

    /// The time of what comes next.
    pub(super) fn front_ns(&self) -> Option<i64> {
        self.waiting.front().map(|(time_ns, _)| *time_ns)
    }

    /// The same, and whether it is a message, if nothing earlier can come any more: `reorder_ns` after it, or at the
    /// end.
    pub(super) fn due(&self) -> Option<(i64, bool)> {
        let (time_ns, what) = self.waiting.front()?;
        let is_due = self.is_over || time_ns.saturating_add(self.reorder_ns) <= self.newest_ns;
        is_due.then(|| (*time_ns, is_message(what)))
    }

    pub(super) fn pop(&mut self) -> Option<Waiting> {
        self.waiting.pop_front().map(|(_, what)| what)
    }

    /// If more messages agree with the odd ones than wait, the times of those that wait are wrong: they become odd, and
    /// the others are returned. What else waits gets this time.
    pub(super) fn turn(&mut self, time_ns: i64) -> Option<Vec<Timed>> {
        if self.odd.len() <= self.waiting.iter().filter(|(_, what)| is_message(what)).count() {
            return None;
        }
        self.newest_ns = i64::MIN;
        let odd = std::mem::take(&mut self.odd);
        for (wrong_ns, what) in std::mem::take(&mut self.waiting) {
            match what {
                Waiting::Message(entry, message) => self.odd.push((wrong_ns, entry, message)),
                // Its time was that of a message.
                other => self.put(time_ns, other),
            }
        }
        Some(odd)
    }
}
