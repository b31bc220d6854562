//! Event logs and recordings, judged in one pass from start to end.

use std::cell::RefCell;
use std::collections::{BTreeSet, VecDeque};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read as _};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use bags::{Bag, Found};
use campaigns::Error;
use channels::{ChannelId, Event, EventKind, Flaw, Gap, Ground, Topology};
use checks::System;
use diagnostics::counted;
use monitors::{Channels, EventLog, GapMark, Property};
use recording::{Doubts, Header, Origin, Recording, RecordingError, RunView};

use crate::description::Description;
use crate::growing::{GrowingLog, STILL_WRITTEN};
use crate::host::Host;
use crate::judge::{self, NO_FORMULA, Subject, VerificationResult, load, recorded_properties, unreported_levels};
use crate::log_context::LogContext;
use crate::log_request::LogRequest;
use crate::logged_run::{LoggedLines, LoggedRun, RecordedTree};
use crate::node_places::node_places;
use crate::recorded_events::RecordedEvents;
use crate::ticks::Ticks;
use crate::tree_log;
use crate::wanted::Wanted;

/// The maximum number of gaps of a log that are listed. More would not be read.
const MOST_NOTES: usize = 5;

/// Checks an event log or a recording, in constant memory.
pub(crate) fn verify(
    request: &LogRequest<'_>,
    recording: Option<Recording>,
    wanted: Wanted<'_>,
) -> Result<VerificationResult, Error> {
    let host = wanted.host;
    verify_by(request, recording, wanted, |described, header| Specification::of(request, described, header, host))
}

/// The same, by the specification that follows from the description or the header of the log.
pub(crate) fn verify_by(
    request: &LogRequest<'_>,
    recording: Option<Recording>,
    wanted: Wanted<'_>,
    specification: impl FnOnce(&Description, Option<&Header>) -> Result<Specification, Error>,
) -> Result<VerificationResult, Error> {
    let LogRequest { path, mapping, is_followed, .. } = *request;
    let host = wanted.host;
    let is_foreign = path != Path::new("-") && !bags::is_bag(path);
    match is_foreign.then(|| Bag::open(path).err()).flatten() {
        Some(error @ (bags::Error::Ros1(_) | bags::Error::Read(_)))
            if mapping.is_some() || matches!(error, bags::Error::Ros1(_)) =>
        {
            return Err(Error::refused(error.to_string(), error.help()));
        }
        _ if mapping.is_some() => {
            let message = format!("{} is not a ROS 2 bag, so it needs no mapping", path.display());
            return Err(Error::refused(message, "leave out `--map-channels`"));
        }
        _ => {}
    }
    let start = match recording {
        Some(recording) => Start::of_recording(recording).map_err(|error| unreadable(path, &error))?,
        None => Start::of_lines(path, is_followed.then_some(host)).map_err(|error| unreadable(path, &error))?,
    };
    let described = start.description();
    described.check_version()?;
    let of_recording = start.header().cloned();
    let Specification { system, run, mut properties, unjudged } = specification(&described, of_recording.as_ref())?;
    let lacks_ticks = described.lacks_ticks;
    if lacks_ticks {
        tree_log::refuse_unknown(&properties)?;
    }
    let mut log = start.run(path, &system.topology, is_followed.then_some(host));
    let ground = described.ground();
    let ground = if lacks_ticks { ground.weaker(tree_log::ground()) } else { ground };
    let gaps = RefCell::default();
    let has_tree = wanted.has_records() && request.scenario.is_none();
    let tree_of_run = of_recording.as_ref().filter(|header| has_tree && !header.tree.is_empty());
    let recorded_tree = tree_of_run.map(|header| Rc::new(RecordedTree::new(header)));
    let events = events_of(log.as_mut(), (&system.topology, &ground), recorded_tree.as_deref(), (&gaps, host));
    let assumed = described.tick.is_none().then_some(system.tick);
    let ticks = RefCell::new((!lacks_ticks).then(|| Ticks::new(&properties, assumed)));
    let events = events.inspect(|found| ticks.borrow_mut().iter_mut().for_each(|ticks| ticks.note(found)));
    let unfit = std::iter::from_fn(|| {
        let why = ticks.take()?.unfit()?;
        gaps.borrow_mut().note(&why);
        Some(Ok(Found::LeftOut(Gap { flaw: Flaw::Ticks, since: Some(Duration::ZERO), ..Gap::of_anything(why) })))
    });
    let mut doubts = Doubts::of_run(&properties, &system.topology, &ground, &described.remote);
    if let Some(carried) = &described.carried {
        doubts = doubts.only(carried, &system.topology);
    }
    let about = match of_recording.as_ref().filter(|_| lacks_ticks) {
        Some(header) => header.about.clone(),
        None => format!("An event log of {}", described.scenario.as_deref().unwrap_or("a run")),
    };
    let context = &LogContext { tree: recorded_tree.clone(), lacks_ticks, ..LogContext::default() };
    let subject = Subject { name: judge::name(path), about, mapping: String::new(), system: &system, context };
    let monitoring = subject.judge(events.chain(unfit), &mut properties, doubts, wanted)?;
    let skipped = (log.skipped() > 0)
        .then(|| format!("left out {} on channels that the scenario does not have", counted(log.skipped(), "message")));
    let GapNotes { first, more } = gaps.into_inner();
    let missing = first.into_iter().chain((more > 0).then(|| format!("and {more} more like these")));
    let left = unjudged.iter().map(|name| format!("{name} is not judged: {NO_FORMULA}"));
    let unreported = log.view().map(|view| unreported_levels(view, &properties, &system.topology));
    let is_cut = is_followed && (host.is_interrupted)() && log.end().is_none();
    let stopped = is_cut.then(|| STILL_WRITTEN.to_owned());
    let left_open = lacks_ticks.then(|| tree_log::LEFT_OPEN.to_owned());
    let nodes = request.tree.into_iter().flat_map(|named| node_places(&named.tree));
    let processes = run.tree.iter().map(|node| node.process.clone()).zip(nodes).collect();
    let result = VerificationResult::of(properties, monitoring);
    let notes = skipped.into_iter().chain(missing).chain(left).chain(result.notes).chain(stopped).chain(left_open);
    Ok(VerificationResult {
        notes: notes.collect(),
        unjudged,
        unreported_levels: unreported.unwrap_or(result.unreported_levels),
        header: run,
        processes,
        knows_ticks: !lacks_ticks,
        ..result
    })
}

pub(crate) fn unreadable(path: &Path, error: &dyn std::error::Error) -> Error {
    let message = format!("cannot read the log {}: {error}", path.display());
    let help = "a log is what `steward run … --record FILE` writes: an event log, `.jsonl`, or a recording; or a log of \
                BehaviorTree.CPP";
    Error::refused(message, help)
}

/// The start of a run that is judged again: what is known before its system.
enum Start {
    /// The first line of an event log, and the rest of it.
    Lines(Vec<u8>, Box<dyn BufRead>),
    Recording(Box<(Recording, RunView)>),
}

impl Start {
    /// The start of an event log: a file, a pipe or standard input.
    fn of_lines(log: &Path, followed_by: Option<Host>) -> io::Result<Self> {
        let mut input: Box<dyn BufRead> = if let Some(host) = followed_by {
            Box::new(BufReader::new(GrowingLog::open(log, host)?))
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

    fn of_recording(mut recording: Recording) -> Result<Self, RecordingError> {
        let view = recording.begin()?;
        Ok(Self::Recording(Box::new((recording, view))))
    }

    fn description(&self) -> Description {
        match self {
            Self::Lines(first, _) => Description::of(first),
            Self::Recording(begun) => Description::of_recording(begun.1.header()),
        }
    }

    /// The header of a recording; none for an event log.
    fn header(&self) -> Option<&Header> {
        if let Self::Recording(begun) = self { Some(begun.1.header()) } else { None }
    }

    /// The run, whose messages are those of this system.
    fn run(self, path: &Path, topology: &Arc<Topology>, followed_by: Option<Host>) -> Box<dyn LoggedRun> {
        match self {
            Self::Lines(first, input) => {
                let log = EventLog::new(Cursor::new(first).chain(input), topology, Channels::Known);
                let log = if followed_by.is_some() { log.until_end() } else { log };
                Box::new(LoggedLines { path: path.to_owned(), log, followed_by })
            }
            Self::Recording(begun) => {
                let (recording, view) = *begun;
                Box::new(RecordedEvents::new(path, recording, view, topology))
            }
        }
    }
}

/// Notes about the gaps of a log: the first few, and the number of further ones.
#[derive(Default)]
struct GapNotes {
    first: Vec<String>,
    more: u64,
}

impl GapNotes {
    fn note(&mut self, why: &str) {
        if self.first.len() < MOST_NOTES { self.first.push(why.to_owned()) } else { self.more += 1 }
    }
}

/// The events of a log, and its gaps, for which notes are added; the outcomes of the nodes go to the tree.
///
/// If the log has messages on channels that the topology does not have, it is of another system. Then the log vouches
/// only for channels on which a message has been received: the others may not have been in it.
fn events_of(
    log: &mut dyn LoggedRun,
    (topology, ground): (&Topology, &Ground),
    tree: Option<&RecordedTree>,
    (gaps, host): (&RefCell<GapNotes>, Host),
) -> impl Iterator<Item = Result<Found, Error>> {
    let (mut ahead, mut is_over, mut is_ended) = (None, false, false);
    let mut without_message: BTreeSet<ChannelId> = topology.channels().collect();
    let (mut is_foreign, mut vouched) = (false, VecDeque::new());
    std::iter::from_fn(move || {
        if ahead.is_none() && !is_over {
            match log.next_event() {
                Ok(event) => (is_over, ahead) = (event.is_none(), event),
                Err(error) => {
                    is_over = true;
                    return Some(Err(error));
                }
            }
            // Those up to an event are noted when it is read ahead, and taken with its record.
            let outcomes = log.take_outcomes();
            tree.iter().for_each(|tree| tree.note(&outcomes));
            if log.is_foreign() && !std::mem::replace(&mut is_foreign, true) {
                let why = "none is in the log, which has messages on channels that the scenario does not have";
                vouched.extend(without_message.iter().map(|channel| (*channel, Ground::Missing(why.to_owned()))));
            }
            if let Some(Event { kind: EventKind::Received { channel, .. }, .. }) = &ahead {
                let is_first = without_message.remove(channel);
                vouched.extend((is_first && is_foreign).then(|| (*channel, ground.clone())));
            }
        }
        if let Some((channel, ground)) = vouched.pop_front() {
            return Some(Ok(Found::Vouched(channel, ground)));
        }
        if let Some(mark) = log.next_gap_mark() {
            return Some(Ok(match mark {
                GapMark::Begins(gap) => {
                    gaps.borrow_mut().note(&gap.why);
                    Found::LeftOut(gap)
                }
                GapMark::Ends(channel) => Found::Resumed(channel),
            }));
        }
        if ahead.is_none() && log.breaks_off() {
            return (!std::mem::replace(&mut is_ended, true)).then(|| {
                let (rest, is_listed) = log.rest();
                if is_listed {
                    gaps.borrow_mut().note(&rest.why)
                } else {
                    (host.note)(&rest.why)
                }
                Ok(Found::LeftOut(rest))
            });
        }
        let end = || log.end().filter(|_| !std::mem::replace(&mut is_ended, true)).map(Found::Ended);
        ahead.take().map(Found::Event).or_else(end).map(Ok)
    })
}

/// The system and the properties with which a log is judged.
pub(crate) struct Specification {
    pub(crate) system: System,
    /// The header of the run. For an event log, only the argument of its scenario is known.
    pub(crate) run: Header,
    pub(crate) properties: Vec<Property>,
    /// The names of the properties of a recording that no formula describes.
    pub(crate) unjudged: Vec<String>,
}

impl Specification {
    /// The system and the properties of the arguments, or else those of the recording.
    fn of(
        request: &LogRequest<'_>,
        described: &Description,
        header: Option<&Header>,
        host: Host,
    ) -> Result<Self, Error> {
        let header = header.filter(|_| request.scenario.is_none());
        let (mut system, run) = match header {
            Some(header) => (System::new(Arc::clone(&header.topology), header.tick), header.clone()),
            None => {
                let argument = described.scenario(request.scenario, host)?;
                let origin = Origin { argument: argument.to_owned(), ..Origin::default() };
                (System::of_runs(argument)?, Header { origin, ..Header::default() })
            }
        };
        system.tick = described.tick.unwrap_or(system.tick);
        let (properties, unjudged) = match header {
            Some(header) if request.properties.is_empty() => recorded_properties(header)?,
            _ => (load(request.properties, &system, host)?, Vec::new()),
        };
        Ok(Self { system, run, properties, unjudged })
    }
}
