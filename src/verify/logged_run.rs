//! Runs that are judged again: from their event log, or from their recording.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read as _};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::{Event, Gap, Topology};
use monitors::{Channels, EventLog, GapMark, LogError};
use recording::{Header, Node, RecordedEvents, RecordedEventsError, Recording, RecordingError, RunView, Step};

use super::description::Description;
use super::growing::GrowingLog;
use crate::interrupt;
use crate::output::note;

/// The outcome of a node of the tree, by the index of the node.
type NodeOutcome = (usize, Option<bt::Outcome>);

/// The tree of a recording, with the outcomes of its nodes up to the last event that was read.
pub(super) struct RecordedTree {
    nodes: Vec<Node>,
    outcomes: RefCell<Vec<NodeOutcome>>,
}

impl RecordedTree {
    pub(super) fn new(header: &Header) -> Self {
        Self { nodes: header.tree.clone(), outcomes: RefCell::default() }
    }

    /// Adds the tree to a header.
    pub(super) fn describe(&self, header: &mut Header) {
        header.tree.clone_from(&self.nodes);
    }

    /// Takes the outcomes up to the next event.
    pub(super) fn note(&self, outcomes: Vec<NodeOutcome>) {
        self.outcomes.borrow_mut().extend(outcomes);
    }

    /// Adds the outcomes up to an event to its record.
    pub(super) fn add(&self, step: &mut Step) {
        step.details.get_or_insert_default().outcomes.append(&mut self.outcomes.borrow_mut());
    }
}

/// The start of a run that is judged again: what is known before its system.
pub(super) enum Start {
    /// The first line of an event log, and the rest of it.
    Lines(Vec<u8>, Box<dyn BufRead>),
    Recording(Box<(Recording, RunView)>),
}

impl Start {
    /// The start of an event log: a file, a pipe or standard input.
    pub(super) fn of_lines(log: &Path, follow: bool) -> io::Result<Self> {
        let mut input: Box<dyn BufRead> = if follow {
            Box::new(BufReader::new(GrowingLog::open(log)?))
        } else if log == Path::new("-") {
            Box::new(io::stdin().lock())
        } else {
            diagnostics::reading(log)?;
            Box::new(BufReader::with_capacity(1 << 18, File::open(log)?))
        };
        let mut first = Vec::new();
        // A longer line is refused later.
        input.by_ref().take(1 << 20).read_until(b'\n', &mut first)?;
        Ok(Self::Lines(first, input))
    }

    pub(super) fn of_recording(mut recording: Recording) -> Result<Self, RecordingError> {
        let view = recording.begin()?;
        Ok(Self::Recording(Box::new((recording, view))))
    }

    pub(super) fn description(&self) -> Description {
        match self {
            Self::Lines(first, _) => Description::of(first),
            Self::Recording(begun) => Description::of_recording(begun.1.header()),
        }
    }

    /// The header of a recording; none for an event log.
    pub(super) fn header(&self) -> Option<&Header> {
        if let Self::Recording(begun) = self { Some(begun.1.header()) } else { None }
    }

    /// The run, whose messages are those of this system.
    pub(super) fn run(self, path: &Path, topology: &Arc<Topology>, follow: bool) -> Box<dyn LoggedRun> {
        match self {
            Self::Lines(first, input) => {
                let log = EventLog::new(Cursor::new(first).chain(input), topology, Channels::Known);
                Box::new((path.to_owned(), if follow { log.until_end() } else { log }))
            }
            Self::Recording(begun) => {
                let (recording, view) = *begun;
                Box::new(RecordedEvents::new(recording, view, topology))
            }
        }
    }
}

/// A run that is judged again, event by event.
pub(super) trait LoggedRun {
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

    /// The gap from there on, with a note about it for the result, unless there has been one.
    fn rest(&self) -> (Gap, Option<&'static str>);

    /// When the run ended, if that has been read.
    fn end(&self) -> Option<Duration>;

    /// What is known of the run besides its events.
    fn view(&self) -> Option<&RunView> {
        None
    }
}

/// An event log, and its path.
impl<R: BufRead> LoggedRun for (std::path::PathBuf, EventLog<R>) {
    fn next_event(&mut self) -> Result<Option<Event>, Error> {
        self.1.next_event().map_err(|error| {
            let help = match error {
                LogError::Foreign { .. } => {
                    "correct the message; or name the scenario that the log is from: `--scenario NAME|FILE`"
                }
                LogError::AfterEnd { .. } | LogError::Backwards { .. } => {
                    "check logs of several runs each in a file of its own"
                }
                _ => "each line of a log is one JSON object",
            };
            Error::refused(format!("{}: {error}", self.0.display()), help)
        })
    }

    fn next_gap_mark(&mut self) -> Option<GapMark> {
        self.1.next_gap_mark()
    }

    fn skipped(&self) -> u64 {
        self.1.skipped()
    }

    fn is_foreign(&self) -> bool {
        self.1.is_foreign()
    }

    /// The end of a followed log may not have been written yet.
    fn breaks_off(&self) -> bool {
        self.1.lacks_end() && interrupt::flow().is_continue()
    }

    fn rest(&self) -> (Gap, Option<&'static str>) {
        let why = "the log breaks off: its last line, which says how its run ended, is missing";
        (self.1.rest(why), Some(why))
    }

    fn end(&self) -> Option<Duration> {
        self.1.end()
    }
}

impl LoggedRun for RecordedEvents {
    fn next_event(&mut self) -> Result<Option<Event>, Error> {
        Self::next_event(self).map_err(|error| {
            let help = match error {
                RecordedEventsError::Foreign { .. } => {
                    "name the scenario that the recording is from: `--scenario NAME|FILE`"
                }
                _ => "the recording was changed after it was written: record the run again",
            };
            Error::refused(error.to_string(), help)
        })
    }

    fn next_gap_mark(&mut self) -> Option<GapMark> {
        Self::next_gap_mark(self)
    }

    fn take_outcomes(&mut self) -> Vec<NodeOutcome> {
        Self::take_outcomes(self)
    }

    fn skipped(&self) -> u64 {
        Self::skipped(self)
    }

    fn is_foreign(&self) -> bool {
        Self::is_foreign(self)
    }

    fn breaks_off(&self) -> bool {
        self.truncated().is_some()
    }

    /// Any message may be missing from there on.
    fn rest(&self) -> (Gap, Option<&'static str>) {
        let why = self.truncated().map(ToString::to_string).unwrap_or_default();
        note(&why);
        (Gap::of_anything(why), None)
    }

    fn end(&self) -> Option<Duration> {
        Self::end(self)
    }

    fn view(&self) -> Option<&RunView> {
        Some(Self::view(self))
    }
}
