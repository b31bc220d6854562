//! What reaches a machine from outside, and what becomes of the texts in it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use channels::{Choice, Comparisons, Possible};
use diagnostics::Problem;

use crate::Datum;

/// An event that a machine may receive, with the fields that it may carry.
#[derive(Clone, Debug)]
pub struct ReceivedEvent {
    /// The names that the event may have; any, if there are none.
    pub names: Vec<String>,
    /// The fields of its data.
    pub fields: BTreeMap<String, Possible>,
    /// Anything that may be in fields whose names are not known.
    pub others: Possible,
}

/// Everything that reaches a machine from outside.
#[derive(Clone, Copy, Debug)]
pub struct TextSources<'a> {
    /// The initial values of its data that its caller sets.
    pub given: &'a [(&'a str, Datum)],
    /// The data whose values its caller sets while it runs.
    pub ports: &'a BTreeMap<String, Possible>,
    /// The events that it may receive.
    pub received: &'a [ReceivedEvent],
    /// The chosen texts, in words, by number.
    pub choices: &'a [String],
}

/// A field of a message that a machine may send over a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassedText {
    /// The process that it is sent to; `None` if that is computed, or the message is published.
    pub target: Option<Arc<str>>,
    /// The symbol with which the message begins; `None` if it is computed.
    pub head: Option<Arc<str>>,
    /// The name of the field; `None` if it is computed.
    pub field: Option<Arc<str>>,
    /// Its value.
    pub value: Possible,
}

/// What a machine does with texts.
#[derive(Clone, Debug, Default)]
pub struct TextUse {
    /// What it sends.
    pub passed: Vec<PassedText>,
    /// What it compares chosen texts with.
    pub comparisons: Comparisons,
    /// Each place that keeps chosen texts, with these.
    pub kept: Vec<BTreeSet<Choice>>,
    /// The chosen texts that lists and objects keep, of which one may have any number.
    pub in_structures: BTreeSet<Choice>,
    /// Everything that it does with a chosen text that tells more texts apart, each at its position.
    pub problems: Vec<Problem>,
}
