//! Where messages come from, and which of them are wanted.

use std::collections::BTreeSet;

use ros_messages::CdrReader;

use super::survey::{Head, Survey, Topic};

/// Where messages come from: a [bag](super::Messages), a recording that is [still being written](super::Following), or
/// a robot.
pub trait Source {
    /// Reads the next message into `body`.
    fn receive(&mut self, body: &mut Vec<u8>) -> Received;
    /// No further message will be asked for.
    fn end(&mut self) {}
    /// What is known of all messages. Topics may be added.
    fn survey(&self) -> &Survey;
    /// Damaged or missing parts so far, in words.
    fn lost(&self) -> &[String];
}

/// What comes next from a [`Source`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A message.
    Message(Head),
    /// Nothing yet: more may come later.
    Idle,
    /// Nothing now: every message received before this time, in nanoseconds since 1970, has been returned.
    Quiet(i64),
    /// Nothing more.
    Over,
}

/// Which topics are read.
pub(super) enum Wanted {
    /// For each topic of the survey, whether it is; there are no others.
    Known(Vec<bool>),
    /// Those with these names, whenever they appear.
    Named(BTreeSet<String>),
}

impl Wanted {
    /// The index of a topic in the survey, if it is wanted.
    pub(super) fn index(&self, topic: &Topic, survey: &mut Survey) -> Option<usize> {
        match self {
            Self::Known(wanted) => survey.topics.iter().position(|known| known == topic).filter(|index| wanted[*index]),
            Self::Named(names) => {
                let is_wanted = names.contains(&topic.name) || is_note(topic);
                is_wanted.then(|| survey.add(topic.clone()))
            }
        }
    }
}

/// The topic of a [`BagWriter`](super::BagWriter)'s note that everything has come which was received before it.
pub(super) const QUIET: &str = "/steward/quiet";

/// The topic of its note that something is lost: a string that says what.
pub(super) const LOST: &str = "/steward/lost";

/// Whether a topic has such notes.
pub(crate) fn is_note(topic: &Topic) -> bool {
    [QUIET, LOST].contains(&topic.name.as_str())
}

/// What has been read from a file: a message, or one of these notes. What is lost is added to `lost`.
pub(super) fn received(head: Head, survey: &Survey, body: &[u8], lost: &mut Vec<String>) -> Option<Received> {
    match survey.topics[head.topic].name.as_str() {
        QUIET => Some(Received::Quiet(head.log_ns)),
        LOST => {
            let text = CdrReader::new(body).and_then(|mut reader| Ok(reader.string(None)?.to_vec()));
            let text =
                text.map_or_else(|_| "something is lost".to_owned(), |text| String::from_utf8_lossy(&text).into());
            lost.push(text);
            None
        }
        _ => Some(Received::Message(head)),
    }
}
