//! Where messages come from, and which of them are wanted.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use channels::Ground;
use ros_messages::RosType as _;
use serde::{Deserialize, Serialize};

use super::survey::{Head, Survey, Topic};

/// Where messages come from: a [bag](super::Messages), a recording that is [still being written](super::Following), or
/// a robot.
pub trait Source {
    /// Reads the next message into `body`.
    fn receive(&mut self, body: &mut Vec<u8>) -> Received;
    /// No further message will be requested.
    fn end(&mut self) {}
    /// What it reports beside its messages.
    fn account(&self) -> Account<'_>;
    /// What is known of all messages. Topics may be added.
    fn survey(&self) -> &Survey {
        self.account().survey
    }
    /// Damaged or missing parts so far, in words.
    fn lost(&self) -> &[String] {
        self.account().lost
    }
    /// What else is to be known of the messages so far, in words.
    fn notes(&self) -> &[String] {
        self.account().notes
    }
    /// Whether it may report which messages are missing. Otherwise, it is unknown whether any are.
    fn counts_losses(&self) -> bool {
        self.account().counts_losses
    }
}

/// What a [`Source`] reports beside its messages.
#[derive(Clone, Copy, Debug)]
pub struct Account<'s> {
    /// As [`Source::survey`].
    pub survey: &'s Survey,
    /// As [`Source::lost`].
    pub lost: &'s [String],
    /// As [`Source::notes`].
    pub notes: &'s [String],
    /// As [`Source::counts_losses`].
    pub counts_losses: bool,
}

impl<S: Source + ?Sized> Source for Box<S> {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        (**self).receive(body)
    }

    fn end(&mut self) {
        (**self).end();
    }

    fn account(&self) -> Account<'_> {
        (**self).account()
    }
}

/// A source of which each call passes through a function.
pub struct Through<S, F> {
    /// The source itself.
    pub source: S,
    receive: F,
}

impl<S: Source, F: FnMut(&mut S, &mut Vec<u8>) -> Received> Through<S, F> {
    /// The function receives from the source.
    pub fn new(source: S, receive: F) -> Self {
        Self { source, receive }
    }
}

impl<S: Source, F: FnMut(&mut S, &mut Vec<u8>) -> Received> Source for Through<S, F> {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        (self.receive)(&mut self.source, body)
    }

    fn end(&mut self) {
        self.source.end();
    }

    fn account(&self) -> Account<'_> {
        self.source.account()
    }
}

/// What comes next from a [`Source`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A message.
    Message(Head),
    /// Nothing yet: more may come later.
    Idle,
    /// Time has passed without a message, until this time, in nanoseconds since 1970: every message received before it
    /// has been returned. This does not vouch for any topic.
    ClockAdvanced(i64),
    /// Messages on a topic are missing, after the last one on it, and before the next, or until they are
    /// [resumed](Self::Resumed).
    Lost {
        /// The topic's index in the [`Survey`].
        topic: usize,
        /// How many; `None` if that is unknown.
        count: Option<u64>,
        /// When the last message before them was received, in nanoseconds since 1970.
        since_ns: i64,
    },
    /// The last message on a topic was delayed: it may have been due at any time since then.
    Late {
        /// The topic's index in the [`Survey`].
        topic: usize,
        /// The first such time, in nanoseconds since 1970.
        since_ns: i64,
    },
    /// Nothing more is missing on a topic from this time on, in nanoseconds since 1970: its messages can be received
    /// again, though none has come since.
    Resumed {
        /// The topic's index in the [`Survey`].
        topic: usize,
        /// Since when.
        at_ns: i64,
    },
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
    /// Compares how many messages a file counts on its wanted channels with how many have been read.
    pub(super) fn compare(
        &self,
        file: &Path,
        topics: &BTreeMap<u16, Topic>,
        [stated, found]: [&BTreeMap<u16, u64>; 2],
        survey: &mut Survey,
    ) {
        for (channel, topic) in topics {
            let [stated, found] = [stated, found].map(|counts| counts.get(channel).copied().unwrap_or_default());
            if stated != found
                && let Some(index) = self.index(topic, survey)
            {
                let what =
                    format!("{} counts {stated} messages on {}, and {found} are there", file.display(), topic.name);
                survey.missing.push((index, what));
            }
        }
    }

    /// Whether a topic is wanted that has not appeared.
    fn awaits(&self, name: &str) -> bool {
        matches!(self, Self::Named(names) if names.contains(name))
    }

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

/// The topic of a [`BagWriter`](super::BagWriter)'s note that time has passed without a message.
pub(super) const CLOCK_ADVANCED: &str = "/steward/quiet";

/// The topic of its note that something is lost: a string with what it is.
pub(super) const LOST: &str = "/steward/lost";

/// The topic of its note that messages on a topic are missing: a [`Missing`] in JSON.
pub(super) const MISSING: &str = "/steward/missing";

/// The topic of its note on what vouches for the messages on a topic: a [`Vouched`] in JSON.
pub(super) const GROUND: &str = "/steward/ground";

/// The topic of what else it notes: a string.
pub(super) const NOTE: &str = "/steward/note";

/// The topic of its violations: a string with the verdict, in JSON.
pub(super) const VIOLATION: &str = "/steward/violation";

/// Messages that are missing; or that none is from a time on; or that the last one was late.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Missing<'m> {
    pub(super) topic: Cow<'m, str>,
    pub(super) count: Option<u64>,
    pub(super) since_ns: i64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) until_ns: Option<i64>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) is_late: bool,
}

/// What vouches for the messages on a topic.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Vouched<'v> {
    pub(super) topic: Cow<'v, str>,
    pub(super) ground: Ground,
}

/// Whether a topic has such notes.
pub(crate) fn is_note(topic: &Topic) -> bool {
    [CLOCK_ADVANCED, LOST, MISSING, GROUND, NOTE, VIOLATION].contains(&topic.name.as_str())
}

/// What a file contains beside its messages.
#[derive(Debug, Default)]
pub(super) struct Aside {
    /// Damaged or missing parts, in words.
    pub(super) lost: Vec<String>,
    pub(super) notes: Vec<String>,
}

impl Aside {
    pub(super) fn account<'s>(&'s self, survey: &'s Survey, counts_losses: bool) -> Account<'s> {
        Account { survey, lost: &self.lost, notes: &self.notes, counts_losses }
    }
}

/// What has been read from a file: a message, or one of these notes. What is lost is added to `aside`.
pub(super) fn received(
    head: Head,
    survey: &mut Survey,
    wanted: &Wanted,
    body: &[u8],
    aside: &mut Aside,
) -> Option<Received> {
    let text = || String::decode(body).unwrap_or_else(|_| "something is lost".to_owned());
    match survey.topics[head.topic].name.as_str() {
        CLOCK_ADVANCED => Some(Received::ClockAdvanced(head.log_ns)),
        LOST => {
            aside.lost.push(text());
            None
        }
        NOTE => {
            aside.notes.push(text());
            None
        }
        VIOLATION => None,
        GROUND => {
            let text = text();
            let Ok(Vouched { topic, ground }) = serde_json::from_str(&text) else {
                aside.lost.push(text);
                return None;
            };
            let topics = survey.topics.iter().enumerate().filter(|(_, known)| known.name == topic);
            let topics: Vec<usize> = topics.map(|(index, _)| index).collect();
            topics.into_iter().for_each(|index| survey.vouch(index, ground.clone()));
            None
        }
        MISSING => {
            let text = text();
            let Ok(Missing { topic, count, since_ns, until_ns, is_late }) = serde_json::from_str(&text) else {
                aside.lost.push(text);
                return None;
            };
            match survey.topics.iter().position(|known| known.name == topic) {
                Some(topic) => {
                    return Some(match until_ns {
                        Some(at_ns) => Received::Resumed { topic, at_ns },
                        None if is_late => Received::Late { topic, since_ns },
                        None => Received::Lost { topic, count, since_ns },
                    });
                }
                None if until_ns.is_none() && wanted.awaits(&topic) => {
                    aside.lost.push(format!("messages on {topic} may be missing"))
                }
                None => {}
            }
            None
        }
        _ => Some(Received::Message(head)),
    }
}
