//! What happened in a run besides messages, in words.

use std::time::Duration;

use channels::Gap;

/// A trip that navigation gave up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GivenUp {
    /// Since the start of the run.
    pub time: Duration,
    /// Why, in words.
    pub reason: String,
}

/// Something that happened around the processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moved {
    /// When.
    pub time: Duration,
    /// What, in words.
    pub words: String,
}

/// The text of a speaker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    /// When it began, since the start of the run.
    pub time: Duration,
    /// The speaker's process.
    pub by: String,
    /// The text.
    pub text: String,
}

/// What has happened so far, in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Incidents {
    pub(super) lost: Vec<String>,
    pub(super) given_up: Vec<GivenUp>,
    pub(super) said: Vec<Said>,
    pub(super) moves: Vec<Moved>,
}

impl Incidents {
    pub(super) fn lose(&mut self, gap: &Gap, now: Duration) {
        let moved = Moved { time: now, words: gap.why.clone() };
        // One loss may leave gaps in several channels.
        if self.moves.last() != Some(&moved) {
            self.lost.push(gap.why.clone());
            self.moves.push(moved);
        }
    }
}
