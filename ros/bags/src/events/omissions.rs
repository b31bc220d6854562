//! What does not become an event, counted.

use std::collections::BTreeMap;
use std::fmt;

use ros_messages::Mismatch;

use crate::mapping::CLOCK;

/// Why a message does not become an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reason {
    /// The mapping does not fit its topic, which appeared only later.
    Topic,
    /// It is not a message of its type.
    Mismatch(Mismatch),
    /// It has no stamp, or one that is far from the others.
    Stamp,
    /// There is no time of the clock yet.
    Clock,
    /// Its time is the first or the last that there is, which also stand for others.
    Time,
    /// A value has no symbol.
    Symbol,
    /// An integer that no value can be without being rounded.
    Range,
    /// The channel does not carry it.
    Channel,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Topic => f.write_str("the mapping does not fit the topic"),
            Self::Mismatch(mismatch) => write!(f, "the bytes do not fit the definition: {mismatch}"),
            Self::Stamp => f.write_str("the stamp is 0, or far from those of other messages"),
            Self::Clock => write!(f, "there is no time on {CLOCK} yet"),
            Self::Time => f.write_str("the time is the first or the last that fits into 64 bits, or later"),
            Self::Symbol => f.write_str("the mapping has no symbol for the value"),
            Self::Range => f.write_str("the integer does not fit into 64 bits, or not exactly into a real number"),
            Self::Channel => f.write_str("the channel does not carry such a message"),
        }
    }
}

/// How many messages on a topic are missing.
struct Missing {
    count: u64,
    /// Whether there may be more.
    is_unknown: bool,
    /// After what the first of them are missing.
    first: String,
}

/// What is left out, missing or late.
#[derive(Default)]
pub(super) struct Omissions {
    /// How many messages of which topic did not become events, or items of which array in them, and the first of them.
    left_out: BTreeMap<(usize, Option<String>, Reason), (u64, String)>,
    missing: BTreeMap<usize, Missing>,
    /// How many messages came too late, and the greatest delay.
    late: (u64, i64),
}

impl Omissions {
    pub(super) fn leave_out(&mut self, topic: usize, each: Option<String>, reason: Reason, first: String) {
        self.left_out.entry((topic, each, reason)).or_insert_with(|| (0, first)).0 += 1;
    }

    /// Messages are missing, an unknown number without a `count`, `after` the last one.
    pub(super) fn miss(&mut self, topic: usize, count: Option<u64>, after: String) {
        let all = self.missing.entry(topic).or_insert(Missing { count: 0, is_unknown: false, first: after });
        all.count = all.count.saturating_add(count.unwrap_or_default());
        all.is_unknown |= count.is_none();
    }

    pub(super) fn delay(&mut self, delay_ns: i64) {
        self.late = (self.late.0 + 1, self.late.1.max(delay_ns));
    }

    /// All of it, in words, by the names of topics.
    pub(super) fn notes<'n>(&'n self, topic: impl Fn(usize) -> &'n str) -> Vec<String> {
        let missing = self.missing.iter().map(|(index, Missing { count, is_unknown, first })| {
            let count = (!is_unknown).then_some(*count);
            format!("{}, the first {first}", missing(count, topic(*index)))
        });
        let left_out = self.left_out.iter().map(|((index, each, reason), (count, first))| {
            let one = *count == 1;
            let (what, are) = (items(each.as_deref(), one), if one { "is" } else { "are" });
            format!("{count} {what} on {} {are} left out: {reason}; the first: {first}", topic(*index))
        });
        let late = (self.late.0 > 0).then(|| {
            format!(
                "{} up to {:.3} s too late and {} the time of what has come before; what this could change is unsure; \
                 `reorder_s` sets how long to wait",
                if self.late.0 == 1 { "1 message comes".to_owned() } else { format!("{} messages come", self.late.0) },
                self.late.1 as f64 * 1e-9,
                if self.late.0 == 1 { "gets" } else { "get" }
            )
        });
        missing.chain(left_out).chain(late).collect()
    }
}

/// What may become an event, in words: a message, or an item of this array in it; or several.
pub(super) fn items(each: Option<&str>, one: bool) -> String {
    match (each, one) {
        (None, true) => "message".to_owned(),
        (None, false) => "messages".to_owned(),
        (Some(each), true) => format!("item of `{each}` in messages"),
        (Some(each), false) => format!("items of `{each}` in messages"),
    }
}

/// That messages on a topic are missing, in words.
pub(super) fn missing(count: Option<u64>, topic: &str) -> String {
    match count {
        Some(1) => format!("1 message on {topic} is missing"),
        Some(count) => format!("{count} messages on {topic} are missing"),
        None => format!("messages on {topic} may be missing"),
    }
}
