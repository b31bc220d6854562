//! Who publishes in a DDS domain: who has come, who has gone, and who takes whose place.

use std::collections::{BTreeMap, BTreeSet};

use bags::{Ground, Topic};

use super::{Hearing, Known, MOST_GONE, MOST_TOPICS, NAMING_NS, Phase};
use crate::domain::heard::{self, NODES, Node, Prefix, Server, Writer, participant};
use crate::domain::names::{self, RosName};
use crate::robot::{Robot, is_of_action};

impl Hearing {
    pub(super) fn know_nodes(&mut self, message: &[u8]) {
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
    pub(super) fn compare(
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
        if !self.has_failed {
            left.into_iter().for_each(|guid| self.leave(guid));
        }
        for writer in writers {
            self.absences.find(&writer.guid);
            if !self.writers.contains_key(&writer.guid) {
                self.arrive(writer);
            }
        }
        self.present = now;
        let is_there =
            |participant: &Prefix| self.writers.values().any(|known| known.writer.participant() == *participant);
        let absent: Vec<Prefix> = self.nodes.keys().filter(|participant| !is_there(participant)).copied().collect();
        for participant in absent {
            self.nodes.remove(&participant);
        }
        self.describe(requests);
    }

    pub(super) fn leave(&mut self, guid: [u8; 16]) {
        let Some(mut known) = self.writers.remove(&guid) else { return };
        known.has_left = [guid, participant(&guid)].iter().any(|guid| self.goodbyes.contains(guid));
        (known.node, known.left_ns) = (self.node_of(&guid).map(|node| node.name.clone()), self.newest_ns);
        let is_told = self.phase != Phase::Looking && self.wanted.is_some();
        if let Some(topic) = known.topic.filter(|topic| is_told && !self.is_only_shown(*topic)) {
            let (name, when) = (&self.survey.topics[topic].name, bags::moment(self.newest_ns));
            let who = self.who(&known.writer);
            if known.has_left {
                self.note(format!("{who} stopped publishing on {name} at {when}"));
                let whole = self.absences.give_up(&guid);
                self.resume(whole, self.newest_ns);
            } else {
                self.note(format!(
                    "{who}, which publishes on {name}, was given up at {when}: it has died, or is out of reach"
                ));
                // It may have gone on, unheard, until another takes its place.
                self.lose_on(topic, known.last.map_or(known.since_ns, |last| last.at_ns));
                self.absences.miss(topic, guid);
                let heir = self.writers.iter().find(|(heir, _)| self.succeeds(heir, &known)).map(|(heir, _)| *heir);
                self.gone.insert(guid, known);
                return heir.into_iter().for_each(|heir| self.succeed(&heir));
            }
        }
        if self.gone.len() >= MOST_GONE {
            self.gone.clear();
        }
        self.gone.insert(guid, known);
    }

    /// Whether a writer takes the place of one that was given up: it came to the same topic after all that this one has
    /// said, and belongs to a node of the same name; or it came after this one had gone, and both belong to none.
    fn succeeds(&self, heir: &[u8; 16], gone: &Known) -> bool {
        let is_unnamed = self.unnamed.iter().any(|(_, guid, _)| guid == heir);
        let node = self.node_of(heir).map(|node| &node.name);
        let last_ns = gone.last.map_or(gone.since_ns, |last| last.at_ns);
        let since_ns = if node.is_some() { last_ns } else { gone.left_ns };
        let is_later = |known: &Known| known.topic == gone.topic && known.is_read && known.since_ns >= since_ns;
        !is_unnamed && node == gone.node.as_ref() && self.writers.get(heir).is_some_and(is_later)
    }

    /// Those whose place a writer takes are not awaited any more.
    fn succeed(&mut self, heir: &[u8; 16]) {
        let gone: Vec<_> =
            self.gone.iter().filter(|(_, gone)| self.succeeds(heir, gone)).map(|(guid, _)| *guid).collect();
        for guid in gone {
            let whole = self.absences.give_up(&guid);
            self.resume(whole, self.newest_ns);
        }
    }

    fn arrive(&mut self, writer: Writer) {
        let topics = self.survey.topics.len();
        let (topic, guid) = (self.index(&writer), writer.guid);
        let is_new = self.survey.topics.len() > topics;
        let is_late = self.phase == Phase::Watching && self.wanted.is_some();
        let is_of_the_type = |index: usize| self.survey.topics[index].kind == names::kind(&writer.kind);
        let is_read = topic.is_some_and(is_of_the_type) && writer.unfit.is_none();
        if let Some(topic) = topic.filter(|_| is_read) {
            self.unnamed.push((self.newest_ns, guid, topic));
            self.best_effort.extend((!writer.is_reliable).then_some(topic));
            self.volatile.extend((!writer.is_latched).then_some(topic));
        }
        self.goodbyes.retain(|of| *of != guid && *of != participant(&guid));
        let gone = self.gone.remove(&guid);
        let has_left = gone.as_ref().is_some_and(|gone| gone.has_left && gone.last.is_some());
        let (last, since_ns) = (gone.and_then(|gone| gone.last), self.newest_ns);
        let known = Known { topic, is_read, last, is_late, since_ns, has_left: false, left_ns: 0, node: None, writer };
        self.writers.insert(guid, known);
        if let Some(topic) = topic.filter(|_| is_read) {
            self.survey.vouch(topic, self.ground(topic));
        }
        if has_left {
            self.begin_anew(&guid);
        }
        if let (Some(topic), Some(unseen_ns)) = (topic.filter(|_| is_new && is_late), self.unseen_since_ns) {
            // It may have had a publisher, and messages, while nothing could be received.
            self.lose_on(topic, unseen_ns);
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
    pub(super) fn introduce(&mut self, now_ns: i64) {
        if self.wanted.is_none() {
            return self.unnamed.clear();
        }
        let is_due = |(since_ns, guid, _): &(i64, [u8; 16], usize)| {
            now_ns.saturating_sub(*since_ns) > NAMING_NS || self.node_of(guid).is_some()
        };
        let (due, rest): (Vec<_>, Vec<_>) = self.unnamed.iter().copied().partition(is_due);
        self.unnamed = rest;
        for (since_ns, guid, topic) in due {
            self.succeed(&guid);
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
    pub(super) fn who(&self, writer: &Writer) -> String {
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
