//! What is made of what is heard in a DDS domain: messages in the order of their numbers, what is missing between
//! them, and who publishes.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use bags::{Head, Received, Survey, Topic};

use super::heard::{self, Heard, NODES, Prefix, Sample, Writer};
use super::names::{self, RosName};
use crate::robot::{Robot, is_of_action};

/// How long after subscribing a publisher may not have noticed it. What is not latched is not judged meanwhile.
const SETTLING_NS: i64 = 500_000_000;

/// How long a publisher's participant may take to say which nodes it has.
const NAMING_NS: i64 = 3_000_000_000;

/// How often silence is reported.
const QUIET_NS: i64 = 10_000_000;

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
    /// The names of the wanted topics; none for all.
    wanted: Option<BTreeSet<String>>,
    pub(super) survey: Survey,
    pub(super) lost: Vec<String>,
    pub(super) notes: Vec<String>,
    pub(super) robot: Robot,
    /// What is to be returned, and what waits until publishers have settled.
    ready: VecDeque<(Received, Vec<u8>)>,
    held: Vec<(usize, Sample)>,
    writers: BTreeMap<[u8; 16], Known>,
    /// What writers had reached when they left: they may come back.
    gone: BTreeMap<[u8; 16], (i64, i64)>,
    /// The publishers that are to be told of: since when, and on which topic.
    unnamed: Vec<(i64, [u8; 16], usize)>,
    /// The participants that were silent too long, and the nodes of all.
    silent: BTreeSet<Prefix>,
    nodes: BTreeMap<Prefix, Vec<String>>,
    /// The topics whose stamps have been mentioned.
    odd: BTreeSet<usize>,
    begun_ns: i64,
    newest_ns: i64,
    quiet_ns: i64,
}

/// What is known of a writer.
struct Known {
    writer: Writer,
    /// Its topic in the survey, if it is wanted and of the type that is read.
    topic: Option<usize>,
    /// The number that comes next, and when the one before it came; unknown before the first sample.
    next: Option<(i64, i64)>,
    /// Whether it came when messages counted already: then all that it has published counts.
    is_late: bool,
    /// Since when it is known.
    since_ns: i64,
}

impl Hearing {
    pub(super) fn new(wanted: Option<BTreeSet<String>>) -> Self {
        Self {
            phase: if wanted.is_some() { Phase::Looking } else { Phase::Watching },
            wanted,
            survey: Survey::default(),
            lost: Vec::new(),
            notes: Vec::new(),
            robot: Robot::default(),
            ready: VecDeque::new(),
            held: Vec::new(),
            writers: BTreeMap::new(),
            gone: BTreeMap::new(),
            unnamed: Vec::new(),
            silent: BTreeSet::new(),
            nodes: BTreeMap::new(),
            odd: BTreeSet::new(),
            begun_ns: 0,
            newest_ns: 0,
            quiet_ns: 0,
        }
    }

    /// From here on, the wanted topics are subscribed to.
    pub(super) fn begin(&mut self) {
        self.phase = Phase::Settling(None);
    }

    pub(super) fn is_looking(&self) -> bool {
        self.phase == Phase::Looking
    }

    /// The DDS topics of those that are wanted.
    pub(super) fn wanted(&self) -> Option<BTreeSet<String>> {
        Some(self.wanted.as_ref()?.iter().map(|name| names::topic(name)).collect())
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
            Heard::Sample(sample) => self.take(sample),
            Heard::Writers { writers, requests, silent } => self.compare(writers, &requests, silent),
            Heard::Quiet(quiet_ns) => self.be_quiet(quiet_ns),
            Heard::Died(why) => {
                let when = bags::moment(self.newest_ns);
                self.lose(format!(
                    "DDS ended after {when}: {why}; it was joined again, and what came meanwhile is missing"
                ));
            }
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

    /// A sample, if its number is new.
    fn take(&mut self, sample: Sample) {
        let is_watching = self.phase == Phase::Watching;
        let is_counted = self.wanted.is_some();
        let Some(known) = self.writers.get_mut(&sample.writer) else { return };
        let is_late = known.is_late && is_watching;
        let first = if is_late { 1 } else { sample.number };
        // The first that is sent with best effort may be the first that arrives. It is not known which it was.
        let may_miss = known.next.is_none() && !is_late && sample.number > 1 && !known.writer.is_reliable && is_counted;
        let (expected, since_ns) = known.next.unwrap_or((first, known.since_ns.max(self.begun_ns)));
        if sample.number < expected {
            return;
        }
        known.next = Some((sample.number.saturating_add(1), sample.received_ns));
        let (Some(topic), is_latched) = (known.topic, known.writer.is_latched) else { return };
        let missing = sample.number.saturating_sub(expected).unsigned_abs();
        match self.phase {
            Phase::Watching => {
                if missing > 0 || may_miss {
                    let count = (!may_miss).then_some(missing);
                    self.ready.push_back((Received::Lost { topic, count, since_ns }, Vec::new()));
                }
                self.tell(topic, sample, is_latched);
            }
            Phase::Settling(_) if is_latched => self.held.push((topic, sample)),
            Phase::Settling(_) | Phase::Looking => {}
        }
    }

    fn tell(&mut self, topic: usize, sample: Sample, is_latched: bool) {
        let log_ns = sample.received_ns.max(self.newest_ns);
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

    fn know_nodes(&mut self, message: &[u8]) {
        if let Some((participant, nodes)) = heard::nodes(message)
            && self.nodes.len() < MOST_TOPICS
        {
            self.nodes.insert(participant, nodes);
            self.describe_nodes();
        }
    }

    fn describe_nodes(&mut self) {
        let nodes: Vec<String> = self.nodes.values().flatten().cloned().collect();
        self.robot.nodes.clear();
        self.robot.add_nodes(nodes);
    }

    /// Compares the writers with those that were there before.
    fn compare(&mut self, writers: Vec<Writer>, requests: &BTreeMap<String, String>, silent: BTreeSet<Prefix>) {
        self.silent.extend(silent);
        let now: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        let left: Vec<[u8; 16]> = self.writers.keys().filter(|guid| !now.contains(*guid)).copied().collect();
        for guid in left {
            self.leave(guid);
        }
        for writer in writers {
            if !self.writers.contains_key(&writer.guid) {
                self.arrive(writer);
            }
        }
        let is_there =
            |participant: &Prefix| self.writers.values().any(|known| known.writer.participant() == *participant);
        let absent: Vec<Prefix> = self.nodes.keys().filter(|participant| !is_there(participant)).copied().collect();
        for participant in absent {
            self.nodes.remove(&participant);
        }
        self.describe(requests);
    }

    fn leave(&mut self, guid: [u8; 16]) {
        let Some(Known { writer, topic, next, since_ns, .. }) = self.writers.remove(&guid) else { return };
        if self.gone.len() >= MOST_GONE {
            self.gone.clear();
        }
        self.gone.extend(next.map(|next| (guid, next)));
        let Some(topic) = topic.filter(|_| self.phase != Phase::Looking) else { return };
        let (name, when) = (&self.survey.topics[topic].name, bags::moment(self.newest_ns));
        if self.wanted.is_none() {
            return;
        }
        let who = self.who(&writer);
        if self.silent.contains(&writer.participant()) {
            self.note(format!(
                "{who}, which publishes on {name}, was given up at {when}: it has died, or is out of reach"
            ));
            // It may have gone on, unheard.
            let since_ns = next.map_or(since_ns, |(_, last_ns)| last_ns);
            self.lose_on(topic, since_ns);
        } else {
            self.note(format!("{who} stopped to publish on {name} at {when}"));
        }
    }

    fn arrive(&mut self, writer: Writer) {
        let topic = self.index(&writer);
        let is_late = self.phase == Phase::Watching && self.wanted.is_some();
        let is_of_the_type = |index: &usize| self.survey.topics[*index].kind == names::kind(&writer.kind);
        let is_read = topic.as_ref().is_some_and(is_of_the_type) && writer.unfit.is_none();
        if let Some(index) = topic.filter(|_| self.wanted.is_some()) {
            self.unnamed.push((self.newest_ns, writer.guid, index));
            if !is_read {
                self.lose_on(index, self.newest_ns);
            }
        }
        let (next, since_ns) = (self.gone.remove(&writer.guid), self.newest_ns);
        let known = Known { topic: topic.filter(|_| is_read), next, is_late, since_ns, writer };
        self.writers.insert(known.writer.guid, known);
    }

    /// Tells of the publishers that have come, once it is known which nodes they have, or long enough afterwards.
    fn introduce(&mut self, now_ns: i64) {
        let is_due = |(since_ns, guid, _): &(i64, [u8; 16], usize)| {
            now_ns.saturating_sub(*since_ns) > NAMING_NS || self.nodes.contains_key(&heard::prefix(guid))
        };
        let (due, rest) = std::mem::take(&mut self.unnamed).into_iter().partition(is_due);
        self.unnamed = rest;
        let due: Vec<(i64, [u8; 16], usize)> = due;
        for (since_ns, guid, topic) in due {
            let Some(known) = self.writers.get(&guid) else { continue };
            let (writer, name) = (&known.writer, &self.survey.topics[topic].name);
            let (who, kind) = (self.who(writer), names::kind(&writer.kind));
            let mut notes = Vec::new();
            if known.is_late {
                notes.push(format!("{who} publishes on {name} since {}", bags::moment(since_ns)));
            }
            if self.writers.values().filter(|known| known.topic == Some(topic)).count() > 1 {
                notes.push(format!("{name} has more than one publisher"));
            }
            if !writer.is_reliable {
                notes.push(format!(
                    "{who} publishes on {name} with best effort: that a message is missing shows when the next one comes; \
                     until then, it is as if there had been none"
                ));
            }
            if let Some(policy) = &writer.unfit {
                notes.push(format!("{who} publishes on {name} with a {policy} that cannot be subscribed to"));
            } else if known.topic.is_none() {
                notes.push(format!("{who} publishes messages of another type on {name}, {kind}, which are left out"));
            }
            notes.into_iter().for_each(|note| self.note(note));
        }
    }

    /// The topic of a writer in the survey, if it is wanted.
    fn index(&mut self, writer: &Writer) -> Option<usize> {
        let RosName::Topic(name) = RosName::of(&writer.topic)? else { return None };
        if self.wanted.as_ref().is_some_and(|wanted| !wanted.contains(&name)) {
            return None;
        }
        let known = self.survey.topics.iter().position(|topic| topic.name == name);
        if known.is_some() || self.survey.topics.len() >= MOST_TOPICS {
            return known;
        }
        let (kind, encoding, hash) = (names::kind(&writer.kind), "cdr".to_owned(), writer.hash.clone());
        Some(self.survey.add(Topic { name, kind, encoding, definition: None, hash }))
    }

    /// The nodes of a writer's participant, in words.
    fn who(&self, writer: &Writer) -> String {
        let nodes = self.nodes.get(&writer.participant()).map(|nodes| nodes.join(", "));
        nodes.filter(|nodes| !nodes.is_empty()).unwrap_or_else(|| "a participant without a node".to_owned())
    }

    /// Describes the robot anew.
    fn describe(&mut self, requests: &BTreeMap<String, String>) {
        let nodes = std::mem::take(&mut self.robot.nodes);
        self.robot = Robot { nodes, ..Robot::default() };
        self.describe_nodes();
        let mut offers: BTreeMap<&str, (usize, usize, usize)> = BTreeMap::new();
        let replies = self.writers.values().map(|known| (&known.writer.topic, &known.writer.kind));
        for (topic, kind) in replies.chain(requests) {
            match RosName::of(topic) {
                Some(RosName::Request(name) | RosName::Reply(name)) => {
                    let action = ["_SendGoal_Request", "_SendGoal_Response"];
                    let suffixes = if is_of_action(&name) { action } else { ["_Request", "_Response"] };
                    self.robot.name(&name, names::whole(kind, &suffixes));
                }
                Some(RosName::Topic(name)) if is_of_action(&name) => {
                    self.robot.name(&name, names::whole(kind, &["_FeedbackMessage"]));
                }
                _ => {}
            }
        }
        for Known { writer, topic, .. } in self.writers.values() {
            let Some(topic) = topic else { continue };
            let offer = offers.entry(&self.survey.topics[*topic].name).or_default();
            offer.0 += 1;
            offer.1 += usize::from(writer.is_reliable);
            offer.2 += usize::from(writer.is_latched);
        }
        let words = |(name, (all, reliable, latched)): (&str, (usize, usize, usize))| {
            let publishers = if all == 1 { "1 publisher".to_owned() } else { format!("{all} publishers") };
            let reliability = match reliable {
                0 => "best effort",
                _ if reliable == all => "reliable",
                _ => "some reliable",
            };
            (name.to_owned(), format!("{publishers}, {reliability}{}", if latched == 0 { "" } else { ", latched" }))
        };
        self.robot.publishers = offers.into_iter().map(words).collect();
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
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SECOND_NS: i64 = 1_000_000_000;

    fn writer(id: u8, topic: &str, is_latched: bool) -> Writer {
        let (guid, kind) = ([id; 16], "std_msgs::msg::dds_::Bool_".to_owned());
        Writer { guid, topic: topic.to_owned(), kind, hash: None, is_reliable: true, is_latched, unfit: None }
    }

    fn sample(id: u8, topic: &str, number: i64, received_ns: i64) -> Heard {
        let (topic, sent_ns, body) = (topic.into(), Some(received_ns - 1000), number.to_le_bytes().to_vec());
        Heard::Sample(Sample { topic, writer: [id; 16], number, received_ns, sent_ns, body })
    }

    fn writers(writers: &[Writer], silent: &[u8]) -> Heard {
        let silent = silent.iter().map(|id| [*id; 12]).collect();
        Heard::Writers { writers: writers.to_vec(), requests: BTreeMap::new(), silent }
    }

    /// What is told in turn: numbers of messages, and what is missing.
    fn told(hearing: &mut Hearing) -> Vec<String> {
        let (mut body, mut told) = (Vec::new(), Vec::new());
        while let Some(received) = hearing.next(&mut body) {
            match received {
                Received::Message(_) => {
                    told.push(i64::from_le_bytes(body[..].try_into().expect("a number")).to_string())
                }
                Received::Lost { count, .. } => told.push(count.map_or("?".to_owned(), |count| format!("-{count}"))),
                _ => {}
            }
        }
        told
    }

    /// Watches `/a` and `/b`, with these writers, from the first second on.
    fn watching(known: &[Writer]) -> Hearing {
        let mut hearing = Hearing::new(Some(["/a", "/b"].map(str::to_owned).into()));
        hearing.hear(writers(known, &[]));
        hearing.begin();
        hearing.hear(Heard::Quiet(0));
        hearing.hear(Heard::Quiet(SECOND_NS));
        assert!(told(&mut hearing).is_empty());
        hearing
    }

    #[test]
    fn messages_count_once_their_publishers_know_of_the_subscription() {
        let mut hearing = Hearing::new(Some(["/a", "/b"].map(str::to_owned).into()));
        hearing.hear(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", true)], &[]));
        hearing.hear(sample(1, "rt/a", 6, 1));
        hearing.begin();
        hearing.hear(Heard::Quiet(2));
        hearing.hear(sample(1, "rt/a", 7, 3));
        hearing.hear(sample(2, "rt/b", 9, 3));
        assert!(told(&mut hearing).is_empty());
        hearing.hear(Heard::Quiet(SECOND_NS));
        // What is latched was not said before.
        assert_eq!(told(&mut hearing), ["9"]);
        hearing.hear(sample(1, "rt/a", 10, SECOND_NS + 1));
        assert_eq!(told(&mut hearing), ["-2", "10"]);
    }

    #[test]
    fn whoever_comes_later_has_said_all_that_it_has_numbered() {
        let mut hearing = watching(&[]);
        hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
        hearing.hear(sample(1, "rt/a", 4, 2 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["-3", "4"]);
        hearing.hear(Heard::Quiet(9 * SECOND_NS));
        assert!(
            hearing.notes[0].starts_with("a participant without a node publishes on /a since 1.000 s"),
            "{:?}",
            hearing.notes
        );
    }

    #[test]
    fn the_first_message_with_best_effort_may_not_be_the_first() {
        let mut hearing = watching(&[Writer { is_reliable: false, ..writer(1, "rt/a", false) }]);
        hearing.hear(sample(1, "rt/a", 4, 2 * SECOND_NS));
        hearing.hear(sample(1, "rt/a", 6, 2 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["?", "4", "-1", "6"]);
    }

    #[test]
    fn a_publisher_that_is_given_up_may_have_gone_on() {
        let mut hearing = watching(&[writer(1, "rt/a", false), writer(2, "rt/b", false)]);
        hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(writers(&[], &[1]));
        assert_eq!(told(&mut hearing), ["1", "?"]);
        assert!(
            hearing.notes[0].contains("on /a, was given up") && hearing.notes[1].contains("stopped to publish on /b")
        );
        // It is back, and its numbers tell what it said meanwhile.
        hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
        hearing.hear(sample(1, "rt/a", 4, 3 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["-2", "4"]);
    }

    #[test]
    fn what_cannot_be_read_is_missing() {
        let other = Writer { kind: "std_msgs::msg::dds_::Int32_".to_owned(), ..writer(2, "rt/a", false) };
        let unfit = Writer { unfit: Some("Ownership".to_owned()), ..writer(3, "rt/b", false) };
        let mut hearing = watching(&[writer(1, "rt/a", false)]);
        hearing.hear(writers(&[writer(1, "rt/a", false), other, unfit], &[]));
        hearing.hear(sample(2, "rt/a", 1, 2 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["?", "?"]);
        hearing.hear(Heard::Quiet(9 * SECOND_NS));
        let notes = hearing.notes.join("\n");
        assert!(
            notes.contains("of another type on /a, std_msgs/msg/Int32") && notes.contains("on /b with a Ownership"),
            "{notes}"
        );
    }

    #[test]
    fn there_is_a_limit_to_what_is_remembered() {
        let mut hearing = Hearing::new(None);
        let many = |from: u32| -> Vec<Writer> {
            let writer = |number: u32| {
                let mut guid = [0; 16];
                guid[..4].copy_from_slice(&number.to_le_bytes());
                Writer { guid, ..writer(0, &format!("rt/t{number}"), false) }
            };
            (from..from + 20_000).map(writer).collect()
        };
        for from in [0, 20_000, 40_000] {
            hearing.hear(writers(&many(from), &[]));
        }
        assert_eq!((hearing.survey.topics.len(), hearing.writers.len()), (MOST_TOPICS, 20_000));
        assert!(hearing.gone.len() <= MOST_GONE && hearing.robot.publishers.len() <= MOST_TOPICS);
    }

    proptest! {
        #[test]
        fn exactly_the_messages_between_two_numbers_are_missing(
            arriving in prop::collection::vec((1..3_u8, 1..40_i64), 0..80),
        ) {
            let mut hearing = watching(&[writer(1, "rt/a", false), writer(2, "rt/a", false)]);
            let (mut last, mut expected) = ([0; 3], Vec::new());
            for (place, (id, number)) in (0_i64..).zip(arriving) {
                hearing.hear(sample(id, "rt/a", number, SECOND_NS + place));
                let last = &mut last[usize::from(id)];
                // What comes again, or too late, counts no more.
                if number > *last {
                    if *last > 0 && number > *last + 1 {
                        expected.push(format!("-{}", number - *last - 1));
                    }
                    expected.push(number.to_string());
                    *last = number;
                }
            }
            prop_assert_eq!(told(&mut hearing), expected);
        }
    }
}
