//! The writers in a DDS domain, with their topics and nodes, and what a robot offers.

use std::collections::{BTreeMap, BTreeSet};

use bags::{Ground, Survey, Topic};

use super::known_writer::KnownWriter;
use crate::domain::exchange::{NODES, Prefix, Server, Writer, participant, prefix};
use crate::domain::names::{self, RosName};
use crate::domain::nodes::{Node, decode_nodes};
use crate::robot::{Robot, is_of_action};

/// How long a publisher's participant may take to list its nodes: longer than the period of its heartbeats.
const NAMING_NS: i64 = 4_000_000_000;

/// The most topics, and the most writers that are remembered after they have left.
pub(super) const MOST_TOPICS: usize = 10_000;
pub(super) const MOST_GONE: usize = 10_000;

#[derive(Default)]
pub(in crate::domain) struct WantedTopics {
    /// Their names. None for all topics.
    pub(super) names: Option<BTreeSet<String>>,
    /// The types that some of them must have.
    pub(in crate::domain) kinds: BTreeMap<String, String>,
    /// The topics that are only shown: losses there do not matter.
    pub(in crate::domain) shown: BTreeSet<String>,
}

/// The writers and nodes of a domain, and the topics that they offer.
#[derive(Default)]
pub(in crate::domain) struct Discovery {
    pub(in crate::domain) wanted: WantedTopics,
    pub(in crate::domain) survey: Survey,
    pub(in crate::domain) robot: Robot,
    /// The topics that are published here and have a subscriber.
    pub(in crate::domain) read: BTreeSet<String>,
    pub(super) writers: BTreeMap<[u8; 16], KnownWriter>,
    /// Writers that have left. Their last messages may still arrive, and they may come back.
    pub(super) gone: BTreeMap<[u8; 16], KnownWriter>,
    /// The writers that have not been mentioned yet, as their nodes may not be known: since when, and on which topic.
    unnamed: Vec<(i64, [u8; 16], usize)>,
    /// The writers and participants that have announced their departure.
    goodbyes: BTreeSet<[u8; 16]>,
    nodes: BTreeMap<Prefix, Vec<Node>>,
    /// The topics that have had a publisher with best effort. They are read with best effort.
    pub(super) best_effort: BTreeSet<usize>,
    /// The topics that have had a publisher that does not latch. They are read without what is latched.
    pub(super) volatile: BTreeSet<usize>,
}

impl WantedTopics {
    /// The DDS topics, with their types if these are given. None for all topics.
    pub(super) fn dds_topics(&self) -> Option<BTreeMap<String, Option<String>>> {
        let kind = |name: &String| self.kinds.get(name).map(|kind| names::dds_kind(kind));
        Some(self.names.as_ref()?.iter().map(|name| (names::topic(name), kind(name))).collect())
    }
}

impl Discovery {
    pub(super) fn new(wanted: Option<BTreeSet<String>>) -> Self {
        Self { wanted: WantedTopics { names: wanted, ..WantedTopics::default() }, ..Self::default() }
    }

    /// Whether losses on a topic do not matter.
    pub(super) fn is_only_shown(&self, topic: usize) -> bool {
        self.wanted.shown.contains(&self.survey.topics[topic].name)
    }

    /// Adds the nodes that a message lists.
    pub(super) fn add_nodes(&mut self, message: &[u8]) {
        if let Some((participant, nodes)) = decode_nodes(message)
            && self.nodes.len() < MOST_TOPICS
        {
            self.nodes.insert(participant, nodes);
            self.describe_nodes();
        }
    }

    /// Forgets the nodes of participants that have no writers.
    pub(super) fn forget_absent_nodes(&mut self) {
        let is_there =
            |participant: &Prefix| self.writers.values().any(|known| known.writer.participant() == *participant);
        let absent: Vec<Prefix> = self.nodes.keys().filter(|participant| !is_there(participant)).copied().collect();
        for participant in absent {
            self.nodes.remove(&participant);
        }
    }

    /// Adds the writers and participants that have announced their departure.
    pub(super) fn add_goodbyes(&mut self, goodbyes: BTreeSet<[u8; 16]>) {
        if self.goodbyes.len() >= MOST_GONE {
            self.goodbyes.clear();
        }
        self.goodbyes.extend(goodbyes);
    }

    /// Adds a writer that has been discovered now. Returns its topic if that is new, and whether the writer has left
    /// the domain before, after it had published something.
    pub(super) fn add(&mut self, writer: Writer, is_late: bool, now_ns: i64) -> (Option<usize>, bool) {
        let topics = self.survey.topics.len();
        let (topic, guid) = (self.index(&writer), writer.guid);
        let is_new = self.survey.topics.len() > topics;
        let is_of_the_type = |index: usize| self.survey.topics[index].kind == names::kind(&writer.kind);
        let is_read = topic.is_some_and(is_of_the_type) && writer.unfit.is_none();
        if let Some(topic) = topic.filter(|_| is_read) {
            self.unnamed.push((now_ns, guid, topic));
            self.best_effort.extend((!writer.is_reliable).then_some(topic));
            self.volatile.extend((!writer.is_latched).then_some(topic));
        }
        self.goodbyes.retain(|of| *of != guid && *of != participant(&guid));
        let gone = self.gone.remove(&guid);
        let has_left = gone.as_ref().is_some_and(|gone| gone.has_left && gone.last.is_some());
        let (last, since_ns) = (gone.and_then(|gone| gone.last), now_ns);
        let (left_ns, node) = (0, None);
        let known = KnownWriter { topic, is_read, last, is_late, since_ns, has_left: false, left_ns, node, writer };
        self.writers.insert(guid, known);
        if let Some(topic) = topic.filter(|_| is_read) {
            self.survey.vouch(topic, self.ground(topic));
        }
        (topic.filter(|_| is_new), has_left)
    }

    /// Removes a writer that is not discovered any more.
    pub(super) fn remove(&mut self, guid: &[u8; 16], now_ns: i64) -> Option<KnownWriter> {
        let mut known = self.writers.remove(guid)?;
        known.has_left = [*guid, participant(guid)].iter().any(|guid| self.goodbyes.contains(guid));
        (known.node, known.left_ns) = (self.node_of(guid).map(|node| node.name.clone()), now_ns);
        Some(known)
    }

    /// Keeps a writer that has left.
    pub(super) fn remember(&mut self, guid: [u8; 16], known: KnownWriter) {
        if self.gone.len() >= MOST_GONE {
            self.gone.clear();
        }
        self.gone.insert(guid, known);
    }

    /// Writers have restarted: they number their messages from 1 again. Returns the topics of those that are read, the
    /// writers, and the time of the newest message of each.
    pub(super) fn restart(&mut self, of: &[u8; 16], is_late: bool) -> Vec<(usize, [u8; 16], i64)> {
        let is_meant = |guid: &[u8; 16]| guid == of || participant(guid) == *of;
        let mut topics = Vec::new();
        for (guid, known) in self.writers.iter_mut().chain(&mut self.gone).filter(|(guid, _)| is_meant(guid)) {
            known.is_late = is_late;
            let since_ns = known.last.as_mut().map_or(known.since_ns, |last| {
                (last.next, last.sent_ns) = (1, None);
                last.at_ns
            });
            topics.extend(known.topic.filter(|_| known.is_read).map(|topic| (topic, *guid, since_ns)));
        }
        topics
    }

    /// Whether a writer replaces one that was given up. It publishes on the same topic. Either both belong to nodes of
    /// the same name, and it was discovered after the last message of the other. Or neither belongs to a node, and it
    /// was discovered after the other had left.
    pub(super) fn replaces(&self, successor: &[u8; 16], gone: &KnownWriter) -> bool {
        let is_unnamed = self.unnamed.iter().any(|(_, guid, _)| guid == successor);
        let node = self.node_of(successor).map(|node| &node.name);
        let last_ns = gone.last.map_or(gone.since_ns, |last| last.at_ns);
        let since_ns = if node.is_some() { last_ns } else { gone.left_ns };
        let is_later = |known: &KnownWriter| known.topic == gone.topic && known.is_read && known.since_ns >= since_ns;
        !is_unnamed && node == gone.node.as_ref() && self.writers.get(successor).is_some_and(is_later)
    }

    /// The writers that a writer replaces.
    pub(super) fn replaced_by(&self, successor: &[u8; 16]) -> Vec<[u8; 16]> {
        self.gone.iter().filter(|(_, gone)| self.replaces(successor, gone)).map(|(guid, _)| *guid).collect()
    }

    /// What vouches for the messages on a topic, if each publisher's numbers are consecutive. Reliable publishers send
    /// lost messages again. With best effort, the loss of the newest message shows only when the next one arrives.
    fn ground(&self, topic: usize) -> Ground {
        let several = self.writers.values().filter(|known| known.topic == Some(topic) && known.is_read).count() > 1;
        match (self.best_effort.contains(&topic), several) {
            (false, _) => Ground::Assumed("DDS delivers every message of a reliable publisher".to_owned()),
            (true, false) => Ground::Numbered,
            (true, true) => Ground::NumberedApart,
        }
    }

    /// The writers that can be mentioned now, each with when it was discovered and with its topic: their nodes are
    /// known, or have not been listed for long.
    pub(super) fn take_named(&mut self, now_ns: i64) -> Vec<(i64, [u8; 16], usize)> {
        if self.wanted.names.is_none() {
            self.unnamed.clear();
            return Vec::new();
        }
        let is_due = |(since_ns, guid, _): &(i64, [u8; 16], usize)| {
            now_ns.saturating_sub(*since_ns) > NAMING_NS || self.node_of(guid).is_some()
        };
        let (due, rest): (Vec<_>, Vec<_>) = self.unnamed.iter().copied().partition(is_due);
        self.unnamed = rest;
        due
    }

    /// What is to be noted of a writer that was discovered at this time.
    pub(super) fn notes_on(&self, guid: &[u8; 16], topic: usize, since_ns: i64) -> Vec<String> {
        let mut notes = Vec::new();
        let Some(known) = self.writers.get(guid).filter(|_| !self.is_only_shown(topic)) else { return notes };
        let (writer, name) = (&known.writer, &self.survey.topics[topic].name);
        let publisher = self.name_of(writer);
        if known.is_late {
            notes.push(format!("{publisher} publishes on {name} since {}", bags::moment(since_ns)));
        }
        if self.writers.values().filter(|known| known.topic == Some(topic)).count() > 1 {
            notes.push(format!("{name} has more than one publisher"));
        }
        if !writer.is_reliable {
            notes.push(format!(
                "{publisher} publishes on {name} with best effort: that a message is missing shows when the next one comes; \
                 until then, it is as if there had been none"
            ));
        }
        notes
    }

    /// The topic of a writer in the survey, if it is wanted.
    fn index(&mut self, writer: &Writer) -> Option<usize> {
        let RosName::Topic(name) = RosName::of(&writer.topic)? else { return None };
        if self.wanted.names.as_ref().is_some_and(|wanted| !wanted.contains(&name)) {
            return None;
        }
        let known = self.survey.topics.iter().position(|topic| topic.name == name);
        if known.is_some() || self.survey.topics.len() >= MOST_TOPICS {
            return known;
        }
        let offered = names::kind(&writer.kind);
        let kind = self.wanted.kinds.get(&name).cloned().unwrap_or_else(|| offered.clone());
        let (encoding, hash) = ("cdr".to_owned(), writer.hash.clone().filter(|_| kind == offered));
        Some(self.survey.add(Topic { name, kind, encoding, definition: None, hash }))
    }

    fn node_of(&self, writer: &[u8; 16]) -> Option<&Node> {
        self.nodes.get(&prefix(writer))?.iter().find(|node| node.writers.contains(writer))
    }

    /// The node of a writer, or those of its participant, in words.
    pub(super) fn name_of(&self, writer: &Writer) -> String {
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

    fn describe_nodes(&mut self) {
        let nodes: Vec<String> = self.nodes.values().flatten().map(|node| node.name.clone()).collect();
        self.robot.nodes.clear();
        self.robot.add_nodes(nodes);
        let with_nodes = self.writers.values().map(|known| &known.writer).filter(|writer| writer.topic == *NODES);
        let unnamed = with_nodes.map(Writer::participant).filter(|participant| !self.nodes.contains_key(participant));
        self.robot.unnamed = unnamed.collect::<BTreeSet<Prefix>>().len();
    }

    /// Describes the robot: its nodes, services, actions and publishers.
    pub(super) fn describe(&mut self, requests: &BTreeMap<String, Vec<Server>>) {
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
                    self.robot.add_name(&name, names::whole(kind, &suffixes));
                }
                Some(RosName::Topic(name)) if is_of_action(&name) => {
                    self.robot.add_name(&name, names::whole(kind, &["_FeedbackMessage"]));
                }
                _ => {}
            }
        }
        for KnownWriter { writer, topic, .. } in self.writers.values() {
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
