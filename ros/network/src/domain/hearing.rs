//! What is made of what is heard in a DDS domain: messages in the order of their numbers, what is missing between
//! them, and who publishes.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use bags::{Ground, Head, Received, Survey, Topic};

use super::heard::{self, Heard, NODES, Node, Offers, Prefix, Response, Sample, Served, Server, Writer, participant};
use super::names::{self, RosName};
use crate::robot::{Robot, is_of_action};

/// How long after subscribing a publisher may not have noticed it. What is not latched is not judged meanwhile.
const SETTLING_NS: i64 = 500_000_000;

/// How long a publisher's participant may take to say which nodes it has: longer than the period of its heartbeats.
const NAMING_NS: i64 = 4_000_000_000;

/// How often silence is reported.
const QUIET_NS: i64 = 5_000_000;

/// A message that was received so long before it is heard was held back, until one before it had come.
const HELD_BACK_NS: i64 = 20_000_000;

/// How long a message that has been received takes at most to be heard.
const HANDED_ON_NS: i64 = 100_000_000;

/// How long publishers may take to be found again after the participant has been replaced.
const FINDING_NS: i64 = 3_000_000_000;

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
    /// Until when publishers need not be there, as all are looked for again.
    finding_ns: i64,
    begun_ns: i64,
    newest_ns: i64,
    quiet_ns: i64,
}

/// What is known of a writer.
struct Known {
    writer: Writer,
    /// Its topic in the survey, if it is wanted; and whether it is read: it is of the type that the first had.
    topic: Option<usize>,
    is_read: bool,
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
            finding_ns: i64::MIN,
            begun_ns: 0,
            newest_ns: 0,
            quiet_ns: 0,
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
            Heard::Unsent(topic) => {
                self.note(format!("{topic} has a reader that does not answer: messages are left out"))
            }
            Heard::Died(why) => self.fail(&why),
        }
    }

    /// What comes until the participant has been replaced is missing on every topic, each until its next message.
    fn fail(&mut self, why: &str) {
        self.failures += 1;
        let when = if self.newest_ns > 0 { bags::moment(self.newest_ns) } else { "the beginning".to_owned() };
        let what = format!("DDS failed after {when}: {why}; it is tried again, and what comes meanwhile is missing");
        self.finding_ns = self.newest_ns.saturating_add(FINDING_NS);
        // Of several publishers on a topic, the next message of one does not tell that all are heard again; and of a
        // topic that is not known, nothing does.
        let publishers = |name: &String| {
            let topic = self.survey.topics.iter().position(|topic| topic.name == *name);
            topic.map(|topic| self.writers.values().filter(|known| known.topic == Some(topic)).count())
        };
        let is_told = |name: &String| self.shown.contains(name) || publishers(name).is_some_and(|count| count < 2);
        if self.wanted.as_ref().is_none_or(|wanted| !wanted.iter().all(is_told)) {
            return self.lose(what);
        }
        self.note(what);
        for topic in 0..self.survey.topics.len() {
            let of_it = self.writers.values().filter(|known| known.topic == Some(topic));
            let last_ns = of_it.filter_map(|known| Some(known.next?.1)).max().unwrap_or(i64::MIN);
            if self.phase != Phase::Looking && !self.is_only_shown(topic) {
                self.lose_on(topic, last_ns.max(self.newest_ns.saturating_sub(HANDED_ON_NS)));
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

    /// A sample, if its number is new; or that there was no room for it.
    fn take(&mut self, sample: Sample, is_there: bool) {
        let is_watching = self.phase == Phase::Watching;
        let Some(known) = self.writers.get_mut(&sample.writer).or_else(|| self.gone.get_mut(&sample.writer)) else {
            // It came and went too fast to be known.
            return self.lose_unknown(&sample.topic);
        };
        let is_late = known.is_late && is_watching;
        let is_first = known.next.is_none();
        let (expected, since_ns) =
            known.next.unwrap_or(if is_late { (1, self.begun_ns) } else { (sample.number, self.begun_ns) });
        if sample.number < expected {
            return;
        }
        known.next = Some((sample.number.saturating_add(1), sample.received_ns));
        let is_latched = known.writer.is_latched;
        let Some(topic) = known.topic.filter(|_| known.is_read) else { return };
        // The first that is sent with best effort, or to a reader of which its publisher may not have known, may be
        // lost. It is not known which number it had.
        let is_unsure = self.best_effort.contains(&topic) || known.since_ns.saturating_add(SETTLING_NS) > self.begun_ns;
        let may_miss = is_first && !is_late && sample.number > 1 && is_unsure && self.wanted.is_some();
        // Time has passed without what was held back.
        let is_held_back = is_watching && sample.received_ns < self.newest_ns.saturating_sub(HELD_BACK_NS);
        let since_ns = if is_held_back { since_ns.min(sample.received_ns) } else { since_ns };
        let missing = sample.number.saturating_sub(expected).saturating_add(i64::from(!is_there)).unsigned_abs();
        match self.phase {
            Phase::Watching => {
                if missing > 0 || may_miss || is_held_back {
                    // All that somebody numbered who came late need not have been said since then.
                    let is_counted = !(may_miss || is_first && is_late || is_held_back);
                    let count = is_counted.then_some(missing);
                    self.ready.push_back((Received::Lost { topic, count, since_ns }, Vec::new()));
                }
                if is_there {
                    self.tell(topic, sample, is_latched);
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

    fn know_nodes(&mut self, message: &[u8]) {
        if let Some((participant, nodes)) = heard::nodes(message)
            && self.nodes.len() < MOST_TOPICS
        {
            self.nodes.insert(participant, nodes);
            self.describe_nodes();
        }
    }

    fn describe_nodes(&mut self) {
        let nodes: Vec<String> = self.nodes.values().flatten().map(|node| node.name.clone()).collect();
        self.robot.nodes.clear();
        self.robot.add_nodes(nodes);
        let with_nodes = self.writers.values().map(|known| &known.writer).filter(|writer| writer.topic == *NODES);
        let unnamed = with_nodes.map(Writer::participant).filter(|participant| !self.nodes.contains_key(participant));
        self.robot.unnamed = unnamed.collect::<BTreeSet<Prefix>>().len();
    }

    /// Compares the writers with those that were there before.
    fn compare(
        &mut self,
        writers: Vec<Writer>,
        requests: &BTreeMap<String, Vec<Server>>,
        goodbyes: BTreeSet<[u8; 16]>,
    ) {
        if self.goodbyes.len() >= MOST_GONE {
            self.goodbyes.clear();
        }
        self.goodbyes.extend(goodbyes);
        let now: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        let left: Vec<[u8; 16]> = self.writers.keys().filter(|guid| !now.contains(*guid)).copied().collect();
        if self.newest_ns >= self.finding_ns {
            left.into_iter().for_each(|guid| self.leave(guid));
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
        let Some(known) = self.writers.remove(&guid) else { return };
        let is_told = self.phase != Phase::Looking && self.wanted.is_some();
        if let Some(topic) = known.topic.filter(|topic| is_told && !self.is_only_shown(*topic)) {
            let (name, when) = (&self.survey.topics[topic].name, bags::moment(self.newest_ns));
            let who = self.who(&known.writer);
            if [guid, participant(&guid)].iter().any(|guid| self.goodbyes.contains(guid)) {
                self.note(format!("{who} stopped publishing on {name} at {when}"));
            } else if self.writers.values().any(|other| other.topic == Some(topic)) {
                self.lose(format!("{who}, which publishes on {name}, was given up at {when}: it may go on, unheard"));
            } else {
                self.note(format!(
                    "{who}, which publishes on {name}, was given up at {when}: it has died, or is out of reach"
                ));
                // It may have gone on, unheard.
                self.lose_on(topic, known.next.map_or(known.since_ns, |(_, last_ns)| last_ns));
            }
        }
        if self.gone.len() >= MOST_GONE {
            self.gone.clear();
        }
        self.gone.insert(guid, known);
    }

    fn arrive(&mut self, writer: Writer) {
        let (topic, guid) = (self.index(&writer), writer.guid);
        let is_late = self.phase == Phase::Watching && self.wanted.is_some();
        let is_of_the_type = |index: usize| self.survey.topics[index].kind == names::kind(&writer.kind);
        let is_read = topic.is_some_and(is_of_the_type) && writer.unfit.is_none();
        if let Some(topic) = topic.filter(|_| is_read) {
            self.unnamed.push((self.newest_ns, guid, topic));
            self.best_effort.extend((!writer.is_reliable).then_some(topic));
            self.volatile.extend((!writer.is_latched).then_some(topic));
        }
        self.goodbyes.remove(&guid);
        let next = self.gone.remove(&guid).and_then(|known| known.next);
        self.writers.insert(guid, Known { topic, is_read, next, is_late, since_ns: self.newest_ns, writer });
        if let Some(topic) = topic.filter(|_| is_read) {
            self.survey.vouch(topic, self.ground(topic));
        }
        if self.phase != Phase::Looking {
            self.miss(&guid);
        }
    }

    /// What vouches for the messages on a topic, if each publisher's numbers are consecutive. Reliable ones send again
    /// what is lost; of others, the loss of the newest message shows only when the next one comes.
    fn ground(&self, topic: usize) -> Ground {
        let several = self.writers.values().filter(|known| known.topic == Some(topic) && known.is_read).count() > 1;
        match (self.best_effort.contains(&topic), several) {
            (false, _) => Ground::Assumed("DDS delivers every message of a reliable publisher".to_owned()),
            (true, false) => Ground::Numbered,
            (true, true) => Ground::NumberedApart,
        }
    }

    /// Tells of the publishers that have come, once it is known which nodes they have, or long enough afterwards.
    fn introduce(&mut self, now_ns: i64) {
        if self.wanted.is_none() {
            return self.unnamed.clear();
        }
        let is_due = |(since_ns, guid, _): &(i64, [u8; 16], usize)| {
            now_ns.saturating_sub(*since_ns) > NAMING_NS || self.node_of(guid).is_some()
        };
        let (due, rest): (Vec<_>, Vec<_>) = self.unnamed.iter().copied().partition(is_due);
        self.unnamed = rest;
        for (since_ns, guid, topic) in due {
            let Some(known) = self.writers.get(&guid).filter(|_| !self.is_only_shown(topic)) else { continue };
            let (writer, name) = (&known.writer, &self.survey.topics[topic].name);
            let who = self.who(writer);
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
        let offered = names::kind(&writer.kind);
        let kind = self.kinds.get(&name).cloned().unwrap_or_else(|| offered.clone());
        let (encoding, hash) = ("cdr".to_owned(), writer.hash.clone().filter(|_| kind == offered));
        Some(self.survey.add(Topic { name, kind, encoding, definition: None, hash }))
    }

    fn node_of(&self, writer: &[u8; 16]) -> Option<&Node> {
        self.nodes.get(&heard::prefix(writer))?.iter().find(|node| node.writers.contains(writer))
    }

    /// The node of a writer, or those of its participant, in words.
    fn who(&self, writer: &Writer) -> String {
        if let Some(node) = self.node_of(&writer.guid) {
            return node.name.clone();
        }
        let nodes = self.nodes.get(&writer.participant()).map(Vec::as_slice).unwrap_or_default();
        match nodes.iter().map(|node| node.name.as_str()).collect::<Vec<_>>().as_slice() {
            [] => "a participant without a node".to_owned(),
            [node] => (*node).to_owned(),
            nodes => format!("one of {}", nodes.join(", ")),
        }
    }

    /// Describes the robot anew.
    fn describe(&mut self, requests: &BTreeMap<String, Vec<Server>>) {
        let nodes = std::mem::take(&mut self.robot.nodes);
        self.robot = Robot { nodes, ..Robot::default() };
        self.describe_nodes();
        let mut offers: BTreeMap<&str, (usize, usize, usize)> = BTreeMap::new();
        let replies = self.writers.values().map(|known| (&known.writer.topic, &known.writer.kind));
        let servers = requests.iter().flat_map(|(topic, servers)| servers.iter().map(move |one| (topic, &one.kind)));
        for (topic, kind) in replies.chain(servers) {
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

    fn writers(writers: &[Writer], goodbyes: &[u8]) -> Heard {
        let goodbyes = goodbyes.iter().map(|id| [*id; 16]).collect();
        Heard::Others { offers: Offers { writers: writers.to_vec(), ..Offers::default() }, goodbyes }
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
        hearing.hear(Heard::Quiet(SETTLING_NS));
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
        assert_eq!(told(&mut hearing), ["?", "4"]);
        hearing.hear(sample(1, "rt/a", 7, 2 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["-2", "7"]);
        hearing.hear(Heard::Quiet(9 * SECOND_NS));
        assert!(
            hearing.notes[0].starts_with("a participant without a node publishes on /a since 1.000 s"),
            "{:?}",
            hearing.notes
        );
    }

    #[test]
    fn whoever_has_nodes_and_has_not_said_which_is_counted() {
        let mut hearing = Hearing::new(None);
        let known = [writer(1, NODES, true), writer(2, NODES, true), writer(3, "rt/a", false)];
        hearing.hear(writers(&known, &[]));
        assert_eq!(hearing.robot.unnamed, 2);
        let Heard::Sample(said) = sample(1, NODES, 1, 1) else { unreachable!() };
        let body = heard::introduction::<16>(&[1; 16], &[("/base", [vec![], vec![]])]);
        hearing.hear(Heard::Sample(Sample { body, ..said }));
        assert_eq!((hearing.robot.unnamed, &hearing.robot.nodes), (1, &["/base".to_owned()].into()));
        hearing.hear(writers(&known[..1], &[]));
        assert_eq!((hearing.robot.unnamed, hearing.robot.nodes.len()), (0, 1));
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
        hearing.hear(writers(&[], &[2]));
        assert_eq!(told(&mut hearing), ["1", "?"]);
        assert!(
            hearing.notes[0].contains("on /a, was given up") && hearing.notes[1].contains("stopped publishing on /b")
        );
        // What it had said is heard, and its numbers tell what it says until it is back.
        hearing.hear(sample(2, "rt/b", 1, 2 * SECOND_NS));
        hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
        hearing.hear(sample(1, "rt/a", 4, 3 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["1", "-2", "4"]);
        assert!(hearing.lost.is_empty());
        // Beside another publisher, nothing tells when that ends.
        hearing.hear(writers(&[writer(1, "rt/a", false), writer(3, "rt/a", false)], &[]));
        hearing.hear(writers(&[writer(3, "rt/a", false)], &[]));
        assert!(hearing.lost[0].contains("it may go on, unheard"), "{:?}", hearing.lost);
    }

    #[test]
    fn when_dds_fails_every_topic_has_a_gap_whose_size_its_publishers_tell() {
        let known = [writer(1, "rt/a", false), writer(2, "rt/b", false)];
        let mut hearing = watching(&known);
        hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(Heard::Died("why".to_owned()));
        assert_eq!(told(&mut hearing), ["1", "?", "?"]);
        hearing.hear(writers(&known, &[]));
        hearing.hear(sample(1, "rt/a", 5, 3 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["-3", "5"]);
        assert!(hearing.lost.is_empty() && hearing.notes[0].contains("DDS failed"), "{:?}", hearing.notes);
        // Of a topic on which nobody has published yet, nothing tells.
        let mut hearing = watching(&known[..1]);
        hearing.hear(Heard::Died("why".to_owned()));
        assert!(told(&mut hearing).is_empty() && hearing.lost[0].contains("DDS failed"), "{:?}", hearing.lost);
        // And nothing tells that all of several publishers are heard again.
        let mut hearing = watching(&[writer(1, "rt/a", false), writer(2, "rt/b", false), writer(3, "rt/b", false)]);
        hearing.hear(Heard::Died("why".to_owned()));
        assert!(told(&mut hearing).is_empty() && hearing.lost[0].contains("DDS failed"), "{:?}", hearing.lost);
    }

    #[test]
    fn what_cannot_be_read_is_missing() {
        let other = Writer { kind: "std_msgs::msg::dds_::Int32_".to_owned(), ..writer(2, "rt/a", false) };
        let unfit = Writer { unfit: Some("Ownership".to_owned()), ..writer(3, "rt/b", false) };
        let known = [writer(1, "rt/a", false), other, unfit];
        // Whether it was there from the beginning or not.
        for begun in [0, 3] {
            let mut hearing = watching(&known[..begun]);
            hearing.hear(writers(&known, &[]));
            hearing.hear(sample(2, "rt/a", 1, 2 * SECOND_NS));
            assert!(told(&mut hearing).is_empty());
            let lost = hearing.lost.join("\n");
            assert!(
                lost.contains("of another type on /a, std_msgs/msg/Int32") && lost.contains("on /b with a Ownership"),
                "{lost}"
            );
        }
        let mut hearing = watching(&[writer(2, "rt/a", false)]);
        hearing.hear(writers(&[writer(1, "rt/a", true), writer(2, "rt/a", false)], &[]));
        hearing.hear(sample(2, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(Heard::Unreadable("rt/a".into(), "an encoding".to_owned()));
        assert_eq!(told(&mut hearing), ["?", "1", "?"]);
        assert!(hearing.notes[0].contains("what was latched is not heard"), "{:?}", hearing.notes);
    }

    #[test]
    fn time_that_passed_without_a_message_passed_without_it() {
        let mut hearing = watching(&[writer(1, "rt/a", false)]);
        hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(Heard::Quiet(4 * SECOND_NS));
        // It was held back until another had come.
        hearing.hear(sample(1, "rt/a", 2, 3 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["1", "?", "2"]);
        // One that had to be sent again comes before the next, which had been there.
        hearing.hear(sample(1, "rt/a", 3, 4 * SECOND_NS + 500_000_000));
        hearing.hear(sample(1, "rt/a", 4, 4 * SECOND_NS + 100_000_000));
        assert_eq!(told(&mut hearing), ["3", "?", "4"]);
        let no_room = sample(1, "rt/a", 5, 5 * SECOND_NS);
        let Heard::Sample(no_room) = no_room else { unreachable!() };
        hearing.hear(Heard::Dropped(no_room));
        hearing.hear(sample(1, "rt/a", 6, 5 * SECOND_NS));
        hearing.hear(sample(9, "rt/a", 1, 5 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["-1", "6", "?"]);
    }

    #[test]
    fn another_participant_finds_the_publishers_again() {
        let mut hearing = watching(&[writer(1, "rt/a", false)]);
        hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(Heard::Died("a defect".to_owned()));
        hearing.hear(writers(&[], &[]));
        hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
        hearing.hear(sample(1, "rt/a", 3, 3 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["1", "-1", "3"]);
        assert!(hearing.notes.is_empty() && hearing.lost[0].contains("a defect"), "{:?}", hearing.notes);
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
