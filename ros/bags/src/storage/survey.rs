//! The contents of a bag, and the heads of its messages.

use std::collections::{BTreeMap, BTreeSet};

use channels::Ground;

/// A topic as described in a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name: `/cmd_vel`.
    pub name: String,
    /// The type of its messages: `geometry_msgs/msg/Twist`.
    pub kind: String,
    /// How its messages are encoded: `cdr`.
    pub encoding: String,
    /// The definition of the type, if the bag has it.
    pub definition: Option<Definition>,
    /// The [hash](ros_messages::Layout::type_hash) of the type, if the bag has it.
    pub hash: Option<String>,
}

/// A hash as rosbag2 writes it: empty if none is known.
pub(super) fn hash(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

/// The definition of a type, with those of all types that it uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Its language: `ros2msg` or `ros2idl`.
    pub language: String,
    /// The text.
    pub text: String,
}

/// What a bag contains.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The topics.
    pub topics: Vec<Topic>,
    /// The number of messages on each.
    pub counts: Vec<u64>,
    /// When the first and the last message on topics were recorded, in nanoseconds since 1970, as far as it is known,
    /// by the indices of the topics.
    pub spans_ns: BTreeMap<usize, (i64, i64)>,
    /// When the first and the last message were recorded, in nanoseconds since 1970, if there are any.
    pub span_ns: Option<(i64, i64)>,
    /// The distributions of ROS 2 in which it was recorded, such as `humble`, if it names any.
    pub distributions: BTreeSet<String>,
    /// Damaged or missing parts, in words.
    pub lost: Vec<String>,
    /// The indices of topics on which there are not the messages that the files count, and how many are, in words.
    pub missing: Vec<(usize, String)>,
    /// Whether topics bring the definitions of their types.
    pub has_definitions: bool,
    /// What vouches for the messages on all topics.
    pub ground: Ground,
    /// That of single topics, by their indices, where it is another.
    pub grounds: BTreeMap<usize, Ground>,
    /// What else is to be known of its files, in words.
    pub notes: Vec<String>,
}

impl Survey {
    /// That of a recording: nothing in it shows what its recorder did not receive.
    pub(super) fn of_recorder() -> Self {
        let what = "the recorder wrote every message that was sent, once";
        Self { ground: Ground::Assumed(what.to_owned()), has_definitions: true, ..Self::default() }
    }

    /// The index of a topic. Adds it if it is new.
    pub fn add(&mut self, topic: Topic) -> usize {
        let known = self.topics.iter().position(|known| *known == topic);
        known.unwrap_or_else(|| {
            self.topics.push(topic);
            self.counts.push(0);
            self.topics.len() - 1
        })
    }

    /// What vouches for the messages on this topic is something else than for those on others.
    pub fn vouch(&mut self, topic: usize, ground: Ground) {
        self.grounds.insert(topic, ground);
    }

    /// What vouches for the messages on a topic.
    #[must_use]
    pub fn ground(&self, topic: usize) -> &Ground {
        self.grounds.get(&topic).unwrap_or(&self.ground)
    }

    /// When the first message was recorded; 0 without any.
    pub(crate) fn first_ns(&self) -> i64 {
        self.span_ns.map_or(0, |(first, _)| first)
    }

    /// Counts a message on a topic, and when it was received, in nanoseconds since 1970.
    pub fn count(&mut self, topic: usize, log_ns: i64) {
        self.counts[topic] += 1;
        self.note_times_on(topic, (log_ns, log_ns));
        self.note_times(log_ns, log_ns);
    }

    /// On each topic, there may be other messages than those that have been read: of any time.
    pub(super) fn doubt(&mut self, what: &str) {
        self.missing.extend((0..self.topics.len()).map(|topic| (topic, what.to_owned())));
    }

    /// Adds what another file contains.
    pub(super) fn merge(&mut self, other: Self) {
        for (index, (topic, count)) in other.topics.into_iter().zip(other.counts).enumerate() {
            let topic = self.add(topic);
            let span_ns = other.spans_ns.get(&index);
            if count > 0 && self.counts[topic] > 0 && span_ns.is_some() != self.spans_ns.contains_key(&topic) {
                self.spans_ns.remove(&topic);
            } else {
                span_ns.into_iter().for_each(|span_ns| self.note_times_on(topic, *span_ns));
            }
            self.counts[topic] = self.counts[topic].saturating_add(count);
        }
        other.span_ns.into_iter().for_each(|(first, last)| self.note_times(first, last));
        self.distributions.extend(other.distributions);
        self.lost.extend(other.lost);
        self.notes.extend(other.notes);
    }

    pub(super) fn note_times_on(&mut self, topic: usize, (first_ns, last_ns): (i64, i64)) {
        let span_ns = self.spans_ns.entry(topic).or_insert((first_ns, last_ns));
        *span_ns = (span_ns.0.min(first_ns), span_ns.1.max(last_ns));
    }

    pub(super) fn note_times(&mut self, first_ns: i64, last_ns: i64) {
        let (first, last) = self.span_ns.unwrap_or((first_ns, last_ns));
        self.span_ns = Some((first.min(first_ns), last.max(last_ns)));
    }
}

/// When a message was recorded and sent, and its topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// The topic's index in the [`Survey`].
    pub topic: usize,
    /// When it was received and recorded, in nanoseconds since 1970.
    pub log_ns: i64,
    /// When it was sent, if the bag has that; otherwise the same as `log_ns`.
    pub publish_ns: i64,
}
