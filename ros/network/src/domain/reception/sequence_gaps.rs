//! Messages in the order of their sequence numbers, what is missing between them, and which of them were late.

use std::collections::{BTreeSet, VecDeque};

use bags::{Head, Received, Survey};

use super::discovery::Discovery;
use super::known_writer::LastSample;
use super::remarks::Remarks;
use crate::domain::absences::Absences;
use crate::domain::delays::Delays;
use crate::domain::exchange::Sample;
use crate::domain::names::RosName;

/// How long a publisher may take to discover a subscription. Until then, only latched messages count.
pub(super) const SETTLING_NS: i64 = 500_000_000;

/// How often it is reported that the clock has advanced.
const CLOCK_PERIOD_NS: i64 = 5_000_000;

/// A message that is received so long after it was due was held back, or had to be sent again.
const HELD_BACK_NS: i64 = 20_000_000;

/// Stamps that are farther in the future, or older, are noted.
const FUTURE_NS: i64 = 100_000_000;
const OLD_NS: i64 = 1_000_000_000;

/// Since when messages count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Phase {
    /// Nothing is subscribed to.
    #[default]
    Looking,
    /// Publishers may not have discovered the subscriptions yet. They will have by this time, once it is set.
    Settling(Option<i64>),
    Watching,
}

/// Messages and gaps, in the order in which they are returned.
#[derive(Default)]
pub(super) struct SequenceGaps {
    pub(super) phase: Phase,
    /// What is to be returned, with the bodies of messages.
    pub(super) ready: VecDeque<(Received, Vec<u8>)>,
    /// Latched messages that wait until publishers have settled.
    held: Vec<(usize, Sample)>,
    /// The topics whose stamps have been noted.
    odd: BTreeSet<usize>,
    /// The topics on which a message could not be read.
    unreadable: BTreeSet<usize>,
    /// The publishers whose messages are not received although they may go on publishing.
    pub(super) absences: Absences,
    delays: Delays,
    /// Since when messages count.
    pub(super) begun_ns: i64,
    /// The time of the newest message or of the clock, whichever is later.
    pub(super) newest_ns: i64,
    /// The writer of the newest message, and when that was received.
    newest: Option<([u8; 16], i64)>,
    /// The time that the clock had when it was last reported.
    clock_ns: i64,
}

impl SequenceGaps {
    pub(super) fn new(phase: Phase) -> Self {
        Self { phase, ..Self::default() }
    }

    /// Returns an unknown number of messages on a topic as lost.
    pub(super) fn lose_on(&mut self, topic: usize, since_ns: i64) {
        self.ready.push_back((Received::Lost { topic, count: None, since_ns }, Vec::new()));
    }

    /// Returns that nothing is missing on these topics any more.
    pub(super) fn resume(&mut self, topics: Vec<usize>, at_ns: i64) {
        for topic in topics {
            self.ready.push_back((Received::Resumed { topic, at_ns }, Vec::new()));
        }
    }

    /// Begins to count messages, if publishers have had the time to discover the subscriptions. Returns false until
    /// then.
    pub(super) fn settle(&mut self, now_ns: i64, survey: &mut Survey, remarks: &mut Remarks) -> bool {
        if let Phase::Settling(by_ns) = &mut self.phase {
            if now_ns < *by_ns.get_or_insert(now_ns.saturating_add(SETTLING_NS)) {
                return false;
            }
            (self.phase, self.begun_ns) = (Phase::Watching, self.newest_ns);
            for (topic, sample) in std::mem::take(&mut self.held) {
                self.deliver(topic, sample, true, survey, remarks);
            }
        }
        true
    }

    /// Returns the time, if that is due.
    pub(super) fn report_clock(&mut self, now_ns: i64) {
        if self.phase == Phase::Watching && now_ns >= self.clock_ns.saturating_add(CLOCK_PERIOD_NS) {
            self.clock_ns = now_ns;
            self.ready.push_back((Received::ClockAdvanced(now_ns), Vec::new()));
        }
    }

    /// Receives a sample, if its number is new. One that is not there was dropped: it is lost itself.
    pub(super) fn receive(&mut self, sample: Sample, is_there: bool, discovery: &mut Discovery, remarks: &mut Remarks) {
        if !(1..i64::MAX).contains(&sample.number) {
            // Numbers begin with 1, and after the last one, the count would wrap. This message cannot be placed.
            return self.lose_unplaced(&sample.topic, &discovery.survey);
        }
        let is_watching = self.phase == Phase::Watching;
        let Some(known) = discovery.writers.get_mut(&sample.writer).or_else(|| discovery.gone.get_mut(&sample.writer))
        else {
            // The writer left before it was discovered.
            return self.lose_unplaced(&sample.topic, &discovery.survey);
        };
        let is_late = known.is_late && is_watching;
        let is_first = known.last.is_none();
        let (mut expected, since_ns) = known.last.map_or_else(
            || if is_late { (1, self.begun_ns) } else { (sample.number, self.begun_ns) },
            |last| (last.next, last.due_ns),
        );
        let has_restarted = sample.number < expected && known.last.is_some_and(|last| last.is_before_restart(&sample));
        if has_restarted {
            expected = 1;
        } else if sample.number < expected {
            return;
        }
        let next = sample.number.saturating_add(1);
        let due_ns = self.delays.due_ns(&sample, since_ns, known.writer.is_reliable);
        known.last = Some(LastSample { next, at_ns: sample.received_ns, due_ns, sent_ns: sample.sent_ns });
        let is_latched = known.writer.is_latched;
        let Some(topic) = known.topic.filter(|_| known.is_read) else { return };
        let is_filtered = discovery.wanted.names.is_some();
        // Before the first message, others may be lost if it was sent with best effort, or before its publisher had
        // discovered the subscription. The number of the first message proves nothing then.
        let is_unsure =
            discovery.best_effort.contains(&topic) || known.since_ns.saturating_add(SETTLING_NS) > self.begun_ns;
        let may_miss = is_first && !is_late && sample.number > 1 && is_unsure && is_filtered;
        let due_ns = Some(due_ns).filter(|_| is_watching && is_there && !is_latched && is_filtered);
        let since_ns = since_ns.min(sample.received_ns);
        let missing = sample.number.saturating_sub(expected).saturating_add(i64::from(!is_there)).unsigned_abs();
        match self.phase {
            Phase::Watching => {
                if missing > 0 || may_miss || has_restarted {
                    // A publisher that came late need not have sent everything that it has numbered since then.
                    let is_counted = !(may_miss || is_first && is_late || has_restarted);
                    let count = is_counted.then_some(missing);
                    self.ready.push_back((Received::Lost { topic, count, since_ns }, Vec::new()));
                }
                let (guid, was_sent_again, received_ns) = (sample.writer, sample.by_ns.is_some(), sample.received_ns);
                let (before_ns, newest) = (self.newest_ns, self.newest.replace((guid, received_ns)));
                if is_there {
                    self.deliver(topic, sample, is_latched, &mut discovery.survey, remarks);
                    let at_ns = self.newest_ns;
                    let of = discovery.writers.get_mut(&guid).or_else(|| discovery.gone.get_mut(&guid));
                    // A message is late if the clock has passed its due time: it was held back, had to be sent again,
                    // or came after others. The order of messages from one datagram is not known either.
                    let soonest_ns =
                        if was_sent_again { at_ns } else { before_ns.max(at_ns.saturating_sub(HELD_BACK_NS)) };
                    let came_together = newest.is_some_and(|(other, at_ns)| other != guid && at_ns == received_ns);
                    let is_late = |due_ns: &i64| came_together || *due_ns < soonest_ns;
                    let late_ns = due_ns.filter(is_late).map(|due_ns| due_ns - i64::from(came_together));
                    if let Some(last) = of.and_then(|known| known.last.as_mut()) {
                        (last.at_ns, last.due_ns) = (at_ns, late_ns.unwrap_or(at_ns));
                    }
                    if let Some(since_ns) = late_ns {
                        self.ready.push_back((Received::Late { topic, since_ns }, Vec::new()));
                    }
                }
                if self.absences.mark_received(topic, &guid) {
                    // The messages of other publishers are still missing.
                    self.lose_on(topic, self.newest_ns);
                }
            }
            Phase::Settling(_) if is_latched && is_there => self.held.push((topic, sample)),
            Phase::Settling(_) | Phase::Looking => {}
        }
    }

    /// A message on this DDS topic could not be read.
    pub(super) fn receive_unreadable(&mut self, topic: &str, why: &str, survey: &Survey, remarks: &mut Remarks) {
        let Some(topic) = self.watched(topic, survey) else { return };
        if self.unreadable.insert(topic) {
            let name = &survey.topics[topic].name;
            remarks.note(format!("messages on {name} cannot be read: {why}"));
        }
        self.lose_on(topic, self.newest_ns);
    }

    /// A message on this DDS topic is lost, and it is not known between which others.
    fn lose_unplaced(&mut self, topic: &str, survey: &Survey) {
        if let Some(topic) = self.watched(topic, survey) {
            self.lose_on(topic, self.newest_ns);
        }
    }

    /// The index of a DDS topic, if it is known and messages count.
    fn watched(&self, topic: &str, survey: &Survey) -> Option<usize> {
        let RosName::Topic(name) = RosName::of(topic)? else { return None };
        let known = survey.topics.iter().position(|topic| topic.name == name);
        known.filter(|_| self.phase == Phase::Watching)
    }

    /// Returns a message.
    fn deliver(&mut self, topic: usize, sample: Sample, is_latched: bool, survey: &mut Survey, remarks: &mut Remarks) {
        // No two messages have the same time: so it is known which of them came after a gap.
        let log_ns = sample.received_ns.max(self.newest_ns.saturating_add(1));
        self.newest_ns = log_ns;
        let sent_ns = sample.sent_ns.unwrap_or(log_ns);
        // What was latched before messages counted, counts from then on.
        let publish_ns = if is_latched { sent_ns.max(self.begun_ns) } else { sent_ns };
        let ahead_ns = publish_ns.saturating_sub(log_ns);
        let is_old = ahead_ns < -OLD_NS && !is_latched;
        if (ahead_ns > FUTURE_NS || is_old) && self.odd.insert(topic) {
            let name = &survey.topics[topic].name;
            let (by_s, way) =
                (ahead_ns.saturating_abs() as f64 * 1e-9, if ahead_ns > 0 { "in the future" } else { "old" });
            remarks.note(format!("stamps of messages on {name} are {by_s:.3} s {way} when they are received"));
        }
        survey.count(topic, log_ns);
        self.ready.push_back((Received::Message(Head { topic, log_ns, publish_ns }), sample.body));
    }
}
