//! The objects besides data that the expressions of a chart read.

use crate::expression::scan::words;

/// What the expressions of a machine can read of the things that differ from run to run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mentions {
    /// `_event`, or code for the engine, which may call a function that does.
    pub(crate) event: bool,
    /// The time of the run.
    pub(crate) clock: bool,
    /// The id of a machine or of a `<send>`.
    pub(crate) sessions: bool,
}

/// Words that reveal the id of a machine or of a `<send>`.
const SESSIONS: [&str; 5] = ["_sessionid", "_ioprocessors", "sendid", "invokeid", "raw"];
/// The beginning of a machine's address: `_event.origin`, if a machine has sent the event.
pub(crate) const ADDRESS: &str = "#_scxml_";

impl Mentions {
    /// Notes what an expression or a script mentions.
    pub(crate) fn note(&mut self, source: &str) {
        self.event |= words(source).any(|word| word == "_event");
        self.sessions |= source.contains(ADDRESS) || words(source).any(|word| SESSIONS.contains(&word));
    }

    pub(crate) fn note_code(&mut self, source: &str) {
        self.event = true;
        self.clock |= words(source).any(|word| word == "Date");
    }
}
