//! Where messages come from, and which of them are wanted.

use std::collections::BTreeSet;

use super::survey::{Head, Survey, Topic};

/// Where messages come from: a [bag](super::Messages), or a recording that is [still being written](super::Following).
pub trait Source {
    /// Reads the next message into `body`.
    fn receive(&mut self, body: &mut Vec<u8>) -> Received;
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
            Self::Named(names) => names.contains(&topic.name).then(|| survey.topic(topic.clone())),
        }
    }
}
