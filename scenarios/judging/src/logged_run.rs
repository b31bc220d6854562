//! Runs that are judged again: from their event log, or from their recording.

use std::cell::RefCell;
use std::io::BufRead;
use std::path::PathBuf;
use std::time::Duration;

use campaigns::Error;
use channels::{Event, Gap};
use monitors::{EventLog, GapMark, LogError};
use recording::{Header, Node, RunView, Step};

use crate::host::Host;

/// The outcome of a node of the tree, by the index of the node.
pub(crate) type NodeOutcome = (usize, Option<bt::Outcome>);

/// The tree of a recording, with the outcomes of its nodes up to the last event that was read.
pub(crate) struct RecordedTree {
    nodes: Vec<Node>,
    outcomes: RefCell<Vec<NodeOutcome>>,
}

impl RecordedTree {
    pub(crate) fn new(header: &Header) -> Self {
        Self { nodes: header.tree.clone(), outcomes: RefCell::default() }
    }

    pub(crate) fn describe(&self, header: &mut Header) {
        header.tree.clone_from(&self.nodes);
    }

    /// Takes the outcomes up to the next event.
    pub(crate) fn note(&self, outcomes: &[NodeOutcome]) {
        self.outcomes.borrow_mut().extend_from_slice(outcomes);
    }

    /// Adds the outcomes up to an event to its record.
    pub(crate) fn add(&self, step: &mut Step) {
        step.details.get_or_insert_default().outcomes.append(&mut self.outcomes.borrow_mut());
    }
}

/// A run that is judged again, event by event.
pub(crate) trait LoggedRun {
    /// The next event; none at the end.
    fn next_event(&mut self) -> Result<Option<Event>, Error>;

    /// Where the next gap before the last event, or at the end, begins or ends.
    fn next_gap_mark(&mut self) -> Option<GapMark>;

    /// The outcomes of the nodes of the tree up to the last event, since the last call.
    fn take_outcomes(&mut self) -> Vec<NodeOutcome> {
        Vec::new()
    }

    /// The number of messages skipped because the system does not have their channels.
    fn skipped(&self) -> u64;

    /// Whether one of these shows that it is a run of another system.
    fn is_foreign(&self) -> bool;

    /// Whether the log ends before its run does.
    fn breaks_off(&self) -> bool;

    /// The gap from there on, and whether it is one of the gaps that the result lists. Otherwise it is reported at
    /// once.
    fn rest(&self) -> (Gap, bool);

    /// When the run ended, if that has been read.
    fn end(&self) -> Option<Duration>;

    /// What is known of the run besides its events.
    fn view(&self) -> Option<&RunView> {
        None
    }
}

/// A run from its event log.
pub(crate) struct LoggedLines<R> {
    pub(crate) path: PathBuf,
    pub(crate) log: EventLog<R>,
    /// The program that follows the log, which may still be written.
    pub(crate) followed_by: Option<Host>,
}

impl<R: BufRead> LoggedRun for LoggedLines<R> {
    fn next_event(&mut self) -> Result<Option<Event>, Error> {
        self.log.next_event().map_err(|error| {
            let help = match error {
                LogError::Foreign { .. } => {
                    "correct the message; or name the scenario that the log is from: `--scenario NAME|FILE`"
                }
                LogError::AfterEnd { .. } | LogError::Backwards { .. } => {
                    "check logs of several runs each in a file of its own"
                }
                _ => "each line of a log is one JSON object",
            };
            Error::refused(format!("{}: {error}", self.path.display()), help)
        })
    }

    fn next_gap_mark(&mut self) -> Option<GapMark> {
        self.log.next_gap_mark()
    }

    fn skipped(&self) -> u64 {
        self.log.skipped()
    }

    fn is_foreign(&self) -> bool {
        self.log.is_foreign()
    }

    /// The end of a followed log may not have been written yet when the program is interrupted.
    fn breaks_off(&self) -> bool {
        self.log.lacks_end() && !self.followed_by.is_some_and(|host| (host.is_interrupted)())
    }

    fn rest(&self) -> (Gap, bool) {
        (self.log.rest("the log breaks off: its last line, with the end of its run, is missing"), true)
    }

    fn end(&self) -> Option<Duration> {
        self.log.end()
    }
}
