//! What is made of what is heard in a DDS domain: messages in the order of their numbers, what is missing between
//! them, and who publishes.

mod publishers;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use bags::{Head, Received, Survey};

use super::absences::Absences;
use super::delays::Delays;
use super::heard::{Heard, NODES, Node, Offers, Prefix, Response, Sample, Served, Server, Writer, participant};
use super::names::{self, RosName};
use crate::robot::Robot;

/// How long after subscribing a publisher may not have noticed it. What is not latched is not judged meanwhile.
const SETTLING_NS: i64 = 500_000_000;

/// How long a publisher's participant may take to say which nodes it has: longer than the period of its heartbeats.
const NAMING_NS: i64 = 4_000_000_000;

/// How often silence is reported.
const QUIET_NS: i64 = 5_000_000;

/// A message that is heard so long after it was due was held back, or had to be sent again.
const HELD_BACK_NS: i64 = 20_000_000;

/// How long publishers may take to be found again after the participant has been replaced.
const FINDING_NS: i64 = 3_000_000_000;

/// A number that falls by more than this is no message that comes late: its publisher has begun anew.
const LATEST: i64 = 1000;

/// Stamps that are so far in the future, or so old, are mentioned.
const FUTURE_NS: i64 = 100_000_000;
const OLD_NS: i64 = 1_000_000_000;

/// The most notes, losses and topics, and the most writers that are remembered after they left.
const MOST_NOTES: usize = 1000;
const MOST_TOPICS: usize = 10_000;
const MOST_GONE: usize = 10_000;

/// Since when messages count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing is subscribed to.
    Looking,
    /// What has been subscribed to may still be unknown to its publishers, until this time at the latest, if it is set.
    Settling(Option<i64>),
    Watching,
}

/// What has been heard, and what is to be told of it.
pub(super) struct Hearing {
    phase: Phase,
    /// The names of the wanted topics; none for all. And the types that some of them must have.
    wanted: Option<BTreeSet<String>>,
    pub(super) kinds: BTreeMap<String, String>,
    /// Those of them of which it does not matter what is missing.
    pub(super) shown: BTreeSet<String>,
    pub(super) survey: Survey,
    pub(super) lost: Vec<String>,
    pub(super) notes: Vec<String>,
    pub(super) robot: Robot,
    /// The topics of what is published here that somebody reads.
    pub(super) read: BTreeSet<String>,
    /// Who takes requests, by the DDS topics; the types of the services that are asked, and what they have responded;
    /// and how often DDS has failed.
    pub(super) requests: BTreeMap<String, Vec<Server>>,
    pub(super) asked: BTreeMap<String, String>,
    pub(super) responses: VecDeque<Response>,
    /// What the services that are offered here are asked, of which there are these, with their types.
    pub(super) offered: BTreeMap<String, String>,
    pub(super) served: VecDeque<Served>,
    pub(super) failures: usize,
    /// What is to be returned, and what waits until publishers have settled.
    ready: VecDeque<(Received, Vec<u8>)>,
    held: Vec<(usize, Sample)>,
    writers: BTreeMap<[u8; 16], Known>,
    /// Writers that have left: what they said last may come after that, and they may come back.
    gone: BTreeMap<[u8; 16], Known>,
    /// The publishers that are to be told of: since when, and on which topic.
    unnamed: Vec<(i64, [u8; 16], usize)>,
    /// The writers and participants that said goodbye, and the nodes of all participants.
    goodbyes: BTreeSet<[u8; 16]>,
    nodes: BTreeMap<Prefix, Vec<Node>>,
    /// The topics whose stamps have been mentioned.
    odd: BTreeSet<usize>,
    /// The topics on which a message could not be read.
    unreadable: BTreeSet<usize>,
    /// The topics that had a publisher with best effort, or one that does not latch: they are read likewise.
    best_effort: BTreeSet<usize>,
    volatile: BTreeSet<usize>,
    /// The publishers that are not heard though they may go on; and since when a topic may have had messages for
    /// which there was no publisher when DDS failed.
    absences: Absences,
    delays: Delays,
    unseen_since_ns: Option<i64>,
    /// Whether DDS has failed, and its publishers are looked for; which writers the participant knows that has taken
    /// over; and until when the others need not be there, as all are looked for again.
    has_failed: bool,
    present: BTreeSet<[u8; 16]>,
    finding_ns: i64,
    begun_ns: i64,
    newest_ns: i64,
    /// The writer of the last message that was told, and when that was received.
    newest: Option<([u8; 16], i64)>,
    quiet_ns: i64,
    /// Until when it is known that messages could be received.
    alive_ns: i64,
}

/// What is known of a writer.
struct Known {
    writer: Writer,
    /// Its topic in the survey, if it is wanted; and whether it is read: it is of the type that the first had.
    topic: Option<usize>,
    is_read: bool,
    /// What it said last; unknown before the first sample.
    last: Option<Last>,
    /// Whether it came when messages counted already: then all that it has published counts.
    is_late: bool,
    /// Since when it is known.
    since_ns: i64,
    /// Of one that has left: whether it said goodbye, when it was missed, and the name of its node, if that is known.
    has_left: bool,
    left_ns: i64,
    node: Option<String>,
}

/// The last message of a writer.
#[derive(Clone, Copy, Debug)]
struct Last {
    /// The number that comes next.
    next: i64,
    /// When it came, or was missed, when it was due at the earliest, and when it was sent.
    at_ns: i64,
    due_ns: i64,
    sent_ns: Option<i64>,
}

impl Last {
    /// Whether a sample with a smaller number is not one that comes late, or again, but of a writer that has begun
    /// anew.
    fn precedes(&self, sample: &Sample) -> bool {
        let is_newer = sample.sent_ns.zip(self.sent_ns).is_some_and(|(sent, last)| sent > last);
        is_newer || self.next.saturating_sub(sample.number) > LATEST
    }
}

impl Hearing {
    pub(super) fn new(wanted: Option<BTreeSet<String>>) -> Self {
        Self {
            phase: if wanted.is_some() { Phase::Looking } else { Phase::Watching },
            wanted,
            kinds: BTreeMap::new(),
            shown: BTreeSet::new(),
            survey: Survey::default(),
            lost: Vec::new(),
            notes: Vec::new(),
            robot: Robot::default(),
            read: BTreeSet::new(),
            requests: BTreeMap::new(),
            asked: BTreeMap::new(),
            responses: VecDeque::new(),
            offered: BTreeMap::new(),
            served: VecDeque::new(),
            failures: 0,
            ready: VecDeque::new(),
            held: Vec::new(),
            writers: BTreeMap::new(),
            gone: BTreeMap::new(),
            unnamed: Vec::new(),
            goodbyes: BTreeSet::new(),
            nodes: BTreeMap::new(),
            odd: BTreeSet::new(),
            unreadable: BTreeSet::new(),
            best_effort: BTreeSet::new(),
            volatile: BTreeSet::new(),
            absences: Absences::default(),
            delays: Delays::default(),
            unseen_since_ns: None,
            has_failed: false,
            present: BTreeSet::new(),
            finding_ns: i64::MIN,
            begun_ns: 0,
            newest_ns: 0,
            newest: None,
            quiet_ns: 0,
            alive_ns: 0,
        }
    }

    /// From here on, the wanted topics are subscribed to.
    pub(super) fn begin(&mut self) {
        self.phase = Phase::Settling(None);
        self.lost.clear();
        let guids: Vec<[u8; 16]> = self.writers.keys().copied().collect();
        guids.iter().for_each(|guid| self.miss(guid));
    }

    fn is_only_shown(&self, topic: usize) -> bool {
        self.shown.contains(&self.survey.topics[topic].name)
    }

    /// Tells of what cannot be heard of a writer.
    fn miss(&mut self, guid: &[u8; 16]) {
        let Some(known) = self.writers.get(guid).filter(|_| self.wanted.is_some()) else { return };
        let Some(topic) = known.topic.filter(|topic| !self.is_only_shown(*topic)) else { return };
        let (name, who) = (&self.survey.topics[topic].name, self.who(&known.writer));
        let (writer, kind) = (&known.writer, names::kind(&known.writer.kind));
        if let Some(policy) = &writer.unfit {
            self.lose(format!("{who} publishes on {name} with a {policy} that cannot be subscribed to"));
        } else if !known.is_read {
            self.lose(format!("{who} publishes messages of another type on {name}, {kind}, which are left out"));
        } else if writer.is_latched && self.volatile.contains(&topic) {
            self.note(format!(
                "{who} latches on {name}, and another publisher does not: what was latched is not heard"
            ));
            self.lose_on(topic, self.begun_ns);
        }
    }

    pub(super) fn is_looking(&self) -> bool {
        self.phase == Phase::Looking
    }

    /// The DDS topics of those that are wanted, and of requests and responses, with their types if these are known.
    pub(super) fn wanted(&self) -> Option<BTreeMap<String, Option<String>>> {
        let kind = |name: &String| self.kinds.get(name).map(|kind| names::dds_kind(kind));
        let topics = self.wanted.as_ref()?.iter().map(|name| (names::topic(name), kind(name)));
        let responses = self.asked.iter().map(|(name, kind)| (names::reply(name), Some(names::response_kind(kind))));
        let requests = self.offered.iter().map(|(name, kind)| (names::request(name), Some(names::request_kind(kind))));
        Some(topics.chain(responses).chain(requests).collect())
    }

    /// What is to be returned next, if there is anything.
    pub(super) fn next(&mut self, body: &mut Vec<u8>) -> Option<Received> {
        let (received, bytes) = self.ready.pop_front()?;
        if let Received::Message(_) = received {
            *body = bytes;
        }
        Some(received)
    }

    pub(super) fn hear(&mut self, heard: Heard) {
        match heard {
            Heard::Sample(sample) if *sample.topic == *NODES => self.know_nodes(&sample.body),
            Heard::Sample(sample) => self.take(sample, true),
            Heard::Dropped(sample) => self.take(sample, false),
            Heard::Unreadable(topic, why) => self.take_note_of(&topic, &why),
            Heard::Others { offers: Offers { writers, requests, read }, goodbyes } => {
                let topic = |topic: &String| match RosName::of(topic) {
                    Some(RosName::Topic(name)) => Some(name),
                    _ => None,
                };
                self.read = read.iter().filter_map(topic).collect();
                self.compare(writers, &requests, goodbyes);
                self.requests = requests;
            }
            Heard::Response(response) => self.responses.push_back(response),
            Heard::Served(served) => self.served.push_back(served),
            Heard::Quiet(quiet_ns) => self.be_quiet(quiet_ns),
            Heard::Alive(alive_ns) => self.be_alive(alive_ns),
            Heard::Anew(guid) => self.begin_anew(&guid),
            Heard::Unsent(topic) => {
                self.note(format!("{topic} has a reader that does not answer: messages are left out"))
            }
            Heard::Died(why) => self.fail(&why),
        }
    }

    /// What comes until the participant has been replaced is missing on every topic: since it was last known that
    /// messages could be received, and until each publisher is heard again.
    fn fail(&mut self, why: &str) {
        self.failures += 1;
        let when = if self.alive_ns > 0 { bags::moment(self.alive_ns) } else { "the beginning".to_owned() };
        self.note(format!("DDS failed after {when}: {why}; it is tried again, and what comes meanwhile is missing"));
        (self.has_failed, self.finding_ns) = (true, i64::MAX);
        self.present.clear();
        if let Phase::Settling(by_ns) = &mut self.phase {
            *by_ns = None;
        }
        if self.phase == Phase::Looking || self.wanted.is_none() {
            return;
        }
        self.unseen_since_ns.get_or_insert(self.alive_ns);
        for topic in (0..self.survey.topics.len()).filter(|topic| !self.is_only_shown(*topic)).collect::<Vec<_>>() {
            let of_it = self.writers.iter().filter(|(_, known)| known.topic == Some(topic) && known.is_read);
            let last_ns = of_it.clone().filter_map(|(_, known)| Some(known.last?.at_ns)).max().unwrap_or(i64::MIN);
            self.absences.miss_all(topic, of_it.map(|(guid, _)| *guid));
            self.lose_on(topic, last_ns.max(self.alive_ns));
        }
    }

    /// Writers have begun anew: they number from 1 again, and it is not known how far the earlier ones came.
    fn begin_anew(&mut self, of: &[u8; 16]) {
        let is_meant = |guid: &[u8; 16]| guid == of || participant(guid) == *of;
        let is_watching = self.phase == Phase::Watching;
        let mut topics = Vec::new();
        for (guid, known) in self.writers.iter_mut().chain(&mut self.gone).filter(|(guid, _)| is_meant(guid)) {
            known.is_late = is_watching;
            let since_ns = known.last.as_mut().map_or(known.since_ns, |last| {
                (last.next, last.sent_ns) = (1, None);
                last.at_ns
            });
            topics.extend(known.topic.filter(|_| known.is_read).map(|topic| (topic, *guid, since_ns)));
        }
        topics.retain(|(topic, guid, _)| {
            is_watching && self.wanted.is_some() && !self.is_only_shown(*topic) && self.writers.contains_key(guid)
        });
        for (topic, guid, since_ns) in topics {
            let name = &self.survey.topics[topic].name;
            self.note(format!("a publisher on {name} has begun anew after {}", bags::moment(since_ns)));
            self.absences.miss(topic, guid);
            self.lose_on(topic, since_ns);
        }
    }

    fn lose(&mut self, what: String) {
        keep(&mut self.lost, what, "more was lost later");
    }

    /// Nobody knows how many messages on a topic are missing.
    fn lose_on(&mut self, topic: usize, since_ns: i64) {
        self.ready.push_back((Received::Lost { topic, count: None, since_ns }, Vec::new()));
    }

    fn note(&mut self, what: String) {
        keep(&mut self.notes, what, "more happened later");
    }

    fn be_quiet(&mut self, quiet_ns: i64) {
        self.newest_ns = self.newest_ns.max(quiet_ns);
        self.be_alive(quiet_ns);
        if let Phase::Settling(by_ns) = &mut self.phase {
            if quiet_ns < *by_ns.get_or_insert(quiet_ns.saturating_add(SETTLING_NS)) {
                return;
            }
            (self.phase, self.begun_ns) = (Phase::Watching, self.newest_ns);
            for (topic, sample) in std::mem::take(&mut self.held) {
                self.tell(topic, sample, true);
            }
        }
        self.introduce(quiet_ns);
        if self.phase == Phase::Watching && quiet_ns >= self.quiet_ns.saturating_add(QUIET_NS) {
            self.quiet_ns = quiet_ns;
            self.ready.push_back((Received::Quiet(quiet_ns), Vec::new()));
        }
    }

    /// Messages could be received until then.
    fn be_alive(&mut self, alive_ns: i64) {
        self.alive_ns = self.alive_ns.max(alive_ns);
        if self.finding_ns == i64::MAX {
            self.finding_ns = alive_ns.saturating_add(FINDING_NS);
        }
        if self.has_failed && alive_ns >= self.finding_ns {
            let left: Vec<_> = self.writers.keys().filter(|guid| !self.present.contains(*guid)).copied().collect();
            left.into_iter().for_each(|guid| self.leave(guid));
            self.has_failed = false;
        }
        let whole = self.absences.settle(alive_ns);
        self.resume(whole, alive_ns);
    }

    /// Nothing is missing on these topics any more.
    fn resume(&mut self, topics: Vec<usize>, at_ns: i64) {
        for topic in topics {
            self.ready.push_back((Received::Resumed { topic, at_ns }, Vec::new()));
        }
    }

    /// A sample, if its number is new; or that there was no room for it.
    fn take(&mut self, sample: Sample, is_there: bool) {
        if !(1..i64::MAX).contains(&sample.number) {
            // Numbers begin with 1, and one after the last would begin anew: it is not known which one this is.
            return self.lose_unknown(&sample.topic);
        }
        let is_watching = self.phase == Phase::Watching;
        let Some(known) = self.writers.get_mut(&sample.writer).or_else(|| self.gone.get_mut(&sample.writer)) else {
            // It came and went too fast to be known.
            return self.lose_unknown(&sample.topic);
        };
        let is_late = known.is_late && is_watching;
        let is_first = known.last.is_none();
        let (mut expected, since_ns) = known.last.map_or_else(
            || if is_late { (1, self.begun_ns) } else { (sample.number, self.begun_ns) },
            |last| (last.next, last.due_ns),
        );
        let is_anew = sample.number < expected && known.last.is_some_and(|last| last.precedes(&sample));
        if is_anew {
            expected = 1;
        } else if sample.number < expected {
            return;
        }
        let next = sample.number.saturating_add(1);
        let due_ns = self.delays.due_ns(&sample, since_ns, known.writer.is_reliable);
        known.last = Some(Last { next, at_ns: sample.received_ns, due_ns, sent_ns: sample.sent_ns });
        let is_latched = known.writer.is_latched;
        let Some(topic) = known.topic.filter(|_| known.is_read) else { return };
        // The first that is sent with best effort, or to a reader of which its publisher may not have known, may be
        // lost. It is not known which number it had.
        let is_unsure = self.best_effort.contains(&topic) || known.since_ns.saturating_add(SETTLING_NS) > self.begun_ns;
        let may_miss = is_first && !is_late && sample.number > 1 && is_unsure && self.wanted.is_some();
        let due_ns = Some(due_ns).filter(|_| is_watching && is_there && !is_latched && self.wanted.is_some());
        let since_ns = since_ns.min(sample.received_ns);
        let missing = sample.number.saturating_sub(expected).saturating_add(i64::from(!is_there)).unsigned_abs();
        match self.phase {
            Phase::Watching => {
                if missing > 0 || may_miss || is_anew {
                    // All that somebody numbered who came late need not have been said since then.
                    let is_counted = !(may_miss || is_first && is_late || is_anew);
                    let count = is_counted.then_some(missing);
                    self.ready.push_back((Received::Lost { topic, count, since_ns }, Vec::new()));
                }
                let (guid, was_sent_again, received_ns) = (sample.writer, sample.by_ns.is_some(), sample.received_ns);
                let (told_ns, newest) = (self.newest_ns, self.newest.replace((guid, received_ns)));
                if is_there {
                    self.tell(topic, sample, is_latched);
                    let at_ns = self.newest_ns;
                    let of = self.writers.get_mut(&guid).or_else(|| self.gone.get_mut(&guid));
                    // Time has passed without what was held back, or had to be sent again, or others came before it; of
                    // those in one datagram, it is not known which was sent first.
                    let soonest_ns =
                        if was_sent_again { at_ns } else { told_ns.max(at_ns.saturating_sub(HELD_BACK_NS)) };
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
                if self.absences.hear(topic, &guid) {
                    // Others are still missing.
                    self.lose_on(topic, self.newest_ns);
                }
            }
            Phase::Settling(_) if is_latched && is_there => self.held.push((topic, sample)),
            Phase::Settling(_) | Phase::Looking => {}
        }
    }

    fn lose_unknown(&mut self, topic: &str) {
        let Some(RosName::Topic(name)) = RosName::of(topic) else { return };
        let known = self.survey.topics.iter().position(|topic| topic.name == name);
        if let Some(topic) = known.filter(|_| self.phase == Phase::Watching) {
            self.lose_on(topic, self.newest_ns);
        }
    }

    fn take_note_of(&mut self, topic: &str, why: &str) {
        let Some(RosName::Topic(name)) = RosName::of(topic) else { return };
        let known = self.survey.topics.iter().position(|topic| topic.name == name);
        let Some(topic) = known.filter(|_| self.phase == Phase::Watching) else { return };
        if self.unreadable.insert(topic) {
            self.note(format!("messages on {name} cannot be read: {why}"));
        }
        self.lose_on(topic, self.newest_ns);
    }

    fn tell(&mut self, topic: usize, sample: Sample, is_latched: bool) {
        // No two have the same time: then it is known which of them came after a gap.
        let log_ns = sample.received_ns.max(self.newest_ns.saturating_add(1));
        self.newest_ns = log_ns;
        let sent_ns = sample.sent_ns.unwrap_or(log_ns);
        // What was latched before the watch began counts from its beginning.
        let publish_ns = if is_latched { sent_ns.max(self.begun_ns) } else { sent_ns };
        let ahead_ns = publish_ns.saturating_sub(log_ns);
        let is_old = ahead_ns < -OLD_NS && !is_latched;
        if (ahead_ns > FUTURE_NS || is_old) && self.odd.insert(topic) {
            let name = &self.survey.topics[topic].name;
            let (by_s, way) =
                (ahead_ns.saturating_abs() as f64 * 1e-9, if ahead_ns > 0 { "in the future" } else { "old" });
            self.note(format!("stamps of messages on {name} are {by_s:.3} s {way} when they are received"));
        }
        self.survey.count(topic, log_ns);
        self.ready.push_back((Received::Message(Head { topic, log_ns, publish_ns }), sample.body));
    }
}

/// Keeps a line, if there is room, and no other like it.
fn keep(lines: &mut Vec<String>, line: String, more: &str) {
    match lines.len() {
        ..MOST_NOTES if !lines.contains(&line) => lines.push(line),
        MOST_NOTES => lines.push(more.to_owned()),
        _ => {}
    }
}

#[cfg(test)]
mod tests;
