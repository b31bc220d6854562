//! `steward verify LOG… [--property FILE.scope]`: checks recorded runs and robots against properties.

pub(crate) mod announcer;
mod answers;
pub(crate) mod args;
pub(crate) mod around;
pub(crate) mod bag;
#[cfg(test)]
mod beside;
mod description;
#[cfg(test)]
mod disorder;
#[cfg(test)]
mod formats;
pub(crate) mod growing;
pub(crate) mod inputs;
pub(crate) mod judge;
#[cfg(test)]
mod lines;
pub(crate) mod live_page;
mod logs;
#[cfg(test)]
mod loss;
pub(crate) mod mapped;
#[cfg(test)]
mod random;
mod ticks;
pub(crate) mod tree_log;

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use bags::{Bag, Contents, Found};
use campaigns::Error;
use channels::{ChannelId, Event, EventKind, Flaw, Gap, Ground, Topology};
use editor::counted;
use monitors::{Channels, EventLog, GapMark, LogError, Property};
use recording::{BagTree, Carried, Certainty, Doubts, Header, LoggedRecording, Origin, Recording, RecordingError};
use reports::report::ViolationsReport;
use serde_json::json;

use crate::interrupt;
use crate::output::{complain, note, print, print_json, print_json_line, print_wrapped};
use crate::results::node_places;
use answers::Answers;
use around::Around;
use description::Description;
use editor::System;
use growing::{Growing, STILL_WRITTEN};
use judge::{Judged, NO_FORMULA, Verified, load, recorded, unheard};
use logs::Line;
use ticks::Ticks;

pub(crate) use args::VerifyArgs;

/// No more gaps of a log than this are listed: nobody would read them.
const MOST_NOTES: usize = 5;

/// Checks each log. Status 2 if one cannot be checked, or a property has no verdict, otherwise 1 if a property is
/// violated, or its verdict is unsure.
pub(crate) fn verify(args: &VerifyArgs) -> Result<ExitCode, Error> {
    args.results.begin()?;
    let folders = folders(args);
    let names: Vec<String> = args.logs.iter().map(|log| log.display().to_string()).collect();
    args.results.or_refused("verify", &names, logs::check_outputs(args, &folders))?;
    let (mut bad, mut refused, mut reports, mut lines) = (false, false, Vec::new(), Vec::new());
    let several = args.logs.len() > 1;
    if args.follow {
        if several {
            return Err(Error::refused("several logs cannot be followed at once", "follow each with its own command"));
        }
        interrupt::listen();
    }
    for (log, folder) in args.logs.iter().zip(folders) {
        let inspected = if args.list {
            bag::list(log).map(Inspected::Contents)
        } else {
            verify_log(args, log, folder.as_deref()).map(|verified| Inspected::Verdicts(Box::new(verified)))
        };
        let inspected = match inspected {
            Ok(inspected) => inspected,
            Err(error) => {
                complain(&error);
                refused = true;
                reports.push(Line::refused(log, &error));
                lines.push(Line::of(args, log, folder, Err(&error)));
                continue;
            }
        };
        if let Inspected::Verdicts(verified) = &inspected {
            lines.push(Line::of(args, log, folder, Ok(verified)));
        }
        let status = inspected.status();
        bad |= status == 1;
        refused |= status == 2;
        if args.json {
            reports.push(inspected.as_json(log));
            continue;
        }
        if several {
            print_wrapped(format!("{}:\n", log.display()))?;
        }
        match inspected {
            Inspected::Verdicts(verified) => print_wrapped(in_words(&verified))?,
            // It is meant to be pasted, so its lines are not wrapped.
            Inspected::Contents(contents) => print(&bag::in_words(&contents, &BTreeMap::new()))?,
        }
    }
    logs::sort(&mut lines);
    args.results.write("verify", || lines.iter().map(Line::suite).collect())?;
    match reports.as_slice() {
        [report] if args.json && args.follow => print_json_line(report)?,
        [report] if args.json && !several => print_json(report)?,
        reports if args.json => print_json(&reports)?,
        _ if several && !args.list => print(&logs::in_words(&lines))?,
        _ => {}
    }
    if let Some(out) = args.out.as_ref().filter(|_| several) {
        logs::write_index(&lines, out)?;
    }
    Ok(ExitCode::from(if refused { 2 } else { u8::from(bad) }))
}

/// The folder of each log's report; none if none is asked for.
fn folders(args: &VerifyArgs) -> Vec<Option<PathBuf>> {
    match &args.out {
        None => vec![None; args.logs.len()],
        Some(out) if args.logs.len() == 1 => vec![Some(out.clone())],
        Some(out) => logs::folders(&args.logs, out).into_iter().map(Some).collect(),
    }
}

/// What was asked about a log.
enum Inspected {
    Verdicts(Box<Verified>),
    Contents(Contents),
}

impl Inspected {
    fn status(&self) -> u8 {
        if let Self::Verdicts(verified) = self { verified.status() } else { 0 }
    }

    fn as_json(&self, log: &Path) -> serde_json::Value {
        match self {
            Self::Verdicts(verified) => as_json(verified, log),
            Self::Contents(contents) => bag::as_json(contents, log),
        }
    }
}

/// Checks a log, and writes its report to the folder, if there is one.
fn verify_log(args: &VerifyArgs, path: &Path, folder: Option<&Path>) -> Result<Verified, Error> {
    let tree = args.tree.load(std::slice::from_ref(&path.to_owned()))?;
    if let Some(tree) = &tree {
        Recording::of_bag(path, tree).map_err(reports::Error::from)?;
    }
    // A recording of a run is also a bag. It needs no mapping, but accepts one.
    let is_recording = || matches!(Recording::open(path), Ok(_) | Err(RecordingError::Version { .. }));
    let is_bag = tree.is_none() && bags::is_bag(path) && (args.map_channels.is_some() || !is_recording());
    if args.follow && !is_bag && path != Path::new("-") && is_recording() {
        let message = format!("{} is a recording by steward, which cannot be followed", path.display());
        return Err(Error::refused(message, "check it when the run is over, without `--follow`"));
    }
    let verified =
        if is_bag { bag::verify(args, path, folder) } else { verify_event_log(args, path, folder, tree.as_ref()) }?;
    verified.notes.iter().for_each(|text| note(text));
    Ok(verified)
}

/// Reads a log once, from start to end, in constant memory.
fn verify_event_log(
    args: &VerifyArgs,
    path: &Path,
    folder: Option<&Path>,
    tree: Option<&BagTree>,
) -> Result<Verified, Error> {
    verify_events(args, path, folder, tree, |described, header| Subject::of(args, described, header))
}

/// The same, judged by what a log's description or its header makes the subject.
fn verify_events(
    args: &VerifyArgs,
    path: &Path,
    folder: Option<&Path>,
    tree: Option<&BagTree>,
    subject: impl FnOnce(&Description, Option<&Header>) -> Result<Subject, Error>,
) -> Result<Verified, Error> {
    let is_foreign = path != Path::new("-") && !bags::is_bag(path);
    match is_foreign.then(|| Bag::open(path).err()).flatten() {
        Some(error @ (bags::Error::Ros1(_) | bags::Error::Read(_)))
            if args.map_channels.is_some() || matches!(error, bags::Error::Ros1(_)) =>
        {
            return Err(Error::refused(error.to_string(), error.help()));
        }
        _ if args.map_channels.is_some() => {
            let message = format!("{} is not a ROS 2 bag, so it needs no mapping", path.display());
            return Err(Error::refused(message, "leave out `--map-channels`"));
        }
        _ => {}
    }
    let unreadable = |error: std::io::Error| {
        let message = format!("cannot read the log {}: {error}", path.display());
        let help = "a log is what `steward run … --record FILE` writes: an event log, `.jsonl`, or a recording; or a \
                    log of BehaviorTree.CPP";
        Error::refused(message, help)
    };
    let truncated = Truncated::default();
    let mut input = open(path, tree, args.follow, &truncated).map_err(unreadable)?;
    let mut first = Vec::new();
    // A longer line is refused below.
    input.by_ref().take(1 << 20).read_until(b'\n', &mut first).map_err(unreadable)?;
    let described = Description::of(&first);
    described.check_version()?;
    let of_recording = header(path, tree);
    let Subject { system, run, mut properties, unjudged } = subject(&described, of_recording.as_ref())?;
    let lacks_ticks = of_recording.as_ref().map_or(described.lacks_ticks, |header| !header.knows_ticks());
    if lacks_ticks {
        tree_log::refuse_unknown(&properties)?;
    }
    let log = EventLog::new(Cursor::new(first).chain(input), &system.topology, Channels::Known);
    let mut log = if args.follow { log.until_end() } else { log };
    let help = |error: &LogError| match (&of_recording, error) {
        (Some(_), _) => "the recording was changed after it was written: record the run again",
        (None, LogError::Foreign { .. }) => {
            "correct the message; or name the scenario that the log is from: `--scenario NAME|FILE`"
        }
        (None, LogError::AfterEnd { .. } | LogError::Backwards { .. }) => {
            "check logs of several runs each in a file of its own"
        }
        (None, _) => "each line of a log is one JSON object",
    };
    let refused = |error: LogError| Error::refused(format!("{}: {error}", path.display()), help(&error));
    let ground = if of_recording.is_some() { Ground::Complete } else { described.ground() };
    let ground = if lacks_ticks { ground.weaker(tree_log::ground()) } else { ground };
    let gaps = RefCell::default();
    // Of a recording that was cut off, this is told otherwise.
    let breaks_off = "the log breaks off: its last line, which says how its run ended, is missing";
    let breaks_off = of_recording.is_none().then_some(breaks_off);
    let events = events_of(&mut log, (&system.topology, &ground), breaks_off, refused, &gaps);
    let is_stated = of_recording.is_some() || described.tick.is_some();
    let ticks = RefCell::new((!lacks_ticks).then(|| Ticks::new(&properties, (!is_stated).then_some(system.tick))));
    let events = events.inspect(|found| ticks.borrow_mut().iter_mut().for_each(|ticks| ticks.note(found)));
    let unfit = std::iter::from_fn(|| {
        let why = ticks.take()?.unfit()?;
        gaps.borrow_mut().note(&why);
        Some(Ok(Found::LeftOut(Gap { flaw: Flaw::Ticks, since: Some(Duration::ZERO), ..Gap::of_anything(why) })))
    });
    // Known only at the end of a recording that was cut off: from there on, anything may be missing.
    let rest = std::iter::from_fn(|| truncated.take().map(|why| Ok(Found::LeftOut(Gap::of_anything(why)))));
    let nodes = of_recording.as_ref().map_or(&described.remote, |header| &header.remote);
    let mut doubts = Doubts::of_run(&properties, &system.topology, &ground, nodes);
    let carried = of_recording.as_ref().map(|header| Carried::by(&header.topology)).or(described.carried.clone());
    if let Some(carried) = carried {
        doubts = doubts.only(&carried, &system.topology);
    }
    let about = match of_recording.as_ref().filter(|_| lacks_ticks) {
        Some(header) => header.about.clone(),
        None => format!("An event log of {}", described.scenario.as_deref().unwrap_or("a run")),
    };
    let stories = args.results.have_stories();
    let has_tree = of_recording.is_some() && (folder.is_some() || stories) && args.scenario.is_none();
    let answers = if has_tree { Answers::of(path) } else { None };
    let judged = Judged {
        command: args.command(path),
        name: judge::name(path),
        folder,
        stories,
        about,
        mapping: String::new(),
        inputs: args.inputs(path),
        system: &system,
        around: &Around { answers, lacks_ticks, ..Around::default() },
        announcer: args.announcer(),
        board: None,
    };
    let judgment = judged.judge(events.chain(unfit).chain(rest), &mut properties, doubts)?;
    let later = judgment.notes(&properties);
    let skipped = (log.skipped() > 0)
        .then(|| format!("left out {} on channels that the scenario does not have", counted(log.skipped(), "message")));
    let Gaps { first, more } = gaps.into_inner();
    let missing = first.into_iter().chain((more > 0).then(|| format!("and {more} more like these")));
    let left = unjudged.iter().map(|name| format!("{name} is not judged: {NO_FORMULA}"));
    let unheard = of_recording.as_ref().map(|_| unheard(path, &properties, &system.topology));
    let is_cut = args.follow && interrupt::flow().is_break() && log.end().is_none();
    let stopped = is_cut.then(|| STILL_WRITTEN.to_owned());
    let left_open = lacks_ticks.then(|| tree_log::LEFT_OPEN.to_owned());
    let notes = skipped.into_iter().chain(missing).chain(left).chain(later).chain(stopped).chain(left_open);
    let nodes = tree.iter().flat_map(|named| node_places(&named.tree));
    let processes = run.tree.iter().map(|node| node.process.clone()).zip(nodes).collect();
    let verified = Verified::judged(properties, judgment, notes.collect());
    Ok(Verified {
        unjudged,
        unheard: unheard.unwrap_or(verified.unheard),
        header: run,
        processes,
        knows_ticks: !lacks_ticks,
        ..verified
    })
}

/// The gaps of a log, in words: the first few, and how many more there are.
#[derive(Default)]
struct Gaps {
    first: Vec<String>,
    more: u64,
}

impl Gaps {
    fn note(&mut self, why: &str) {
        if self.first.len() < MOST_NOTES { self.first.push(why.to_owned()) } else { self.more += 1 }
    }
}

/// The events of a log, and its gaps, which are also noted.
///
/// Messages on channels that the topology does not have show that the log is of another system. So nothing vouches that
/// this one's other channels were in it, except those of which a message has come.
fn events_of<R: BufRead>(
    log: &mut EventLog<R>,
    (topology, ground): (&Topology, &Ground),
    mut breaks_off: Option<&'static str>,
    refused: impl Fn(LogError) -> Error,
    gaps: &RefCell<Gaps>,
) -> impl Iterator<Item = Result<Found, Error>> {
    let (mut ahead, mut is_over, mut is_ended) = (None, false, false);
    let mut unheard: BTreeSet<ChannelId> = topology.channels().collect();
    let (mut is_foreign, mut vouched) = (false, VecDeque::new());
    std::iter::from_fn(move || {
        if ahead.is_none() && !is_over {
            match log.next_event() {
                Ok(event) => (is_over, ahead) = (event.is_none(), event),
                Err(error) => {
                    is_over = true;
                    return Some(Err(refused(error)));
                }
            }
            if log.is_foreign() && !std::mem::replace(&mut is_foreign, true) {
                let why = "none is in the log, which has messages on channels that the scenario does not have";
                vouched.extend(unheard.iter().map(|channel| (*channel, Ground::Missing(why.to_owned()))));
            }
            if let Some(Event { kind: EventKind::Received { channel, .. }, .. }) = &ahead {
                let is_first = unheard.remove(channel);
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
        // One that is followed may only not have been written yet.
        if ahead.is_none() && log.lacks_end() && interrupt::flow().is_continue() {
            return breaks_off.take().map(|why| {
                gaps.borrow_mut().note(why);
                Ok(Found::LeftOut(log.rest(why)))
            });
        }
        let end = || log.end().filter(|_| !std::mem::replace(&mut is_ended, true)).map(Found::Ended);
        ahead.take().map(Found::Event).or_else(end).map(Ok)
    })
}

/// What a log is judged by.
struct Subject {
    system: System,
    /// What is known of the run.
    run: Header,
    properties: Vec<Property>,
    /// The properties of a recording that no formula describes.
    unjudged: Vec<String>,
}

impl Subject {
    /// A recording brings its own system and properties; arguments that name others come first.
    fn of(args: &VerifyArgs, described: &Description, header: Option<&Header>) -> Result<Self, Error> {
        let header = header.filter(|_| args.scenario.is_none());
        let (mut system, run) = match header {
            Some(header) => (System::new(Arc::clone(&header.topology), header.tick), header.clone()),
            None => {
                let argument = described.scenario(args.scenario.as_deref())?;
                let origin = Origin { argument: argument.to_owned(), ..Origin::default() };
                (System::of_runs(argument)?, Header { origin, ..Header::default() })
            }
        };
        system.tick = described.tick.unwrap_or(system.tick);
        let (properties, unjudged) = match header {
            Some(header) if args.properties.is_empty() => recorded(header)?,
            _ => (load(&args.properties, &system)?, Vec::new()),
        };
        Ok(Self { system, run, properties, unjudged })
    }
}

/// The header of a recording, which says everything about its system; none of other logs.
fn header(log: &Path, tree: Option<&BagTree>) -> Option<Header> {
    let is_whole = tree.is_some() || !is_pipe(log);
    let view =
        is_whole.then(|| Recording::open_with(log, tree).and_then(|mut recording| recording.begin()).ok()).flatten();
    view.map(|view| view.header().clone())
}

/// Whether it can be read only once, as standard input can. There may be no file of that name: a part of one has a
/// name.
fn is_pipe(log: &Path) -> bool {
    std::fs::metadata(log).is_ok_and(|about| !about.is_file())
}

/// Why a recording ends before its run does, in words, if it does.
type Truncated = Rc<Cell<Option<String>>>;

/// The log's bytes: a file's, a pipe's, or those of standard input. A recording is read as its log.
fn open(log: &Path, tree: Option<&BagTree>, follow: bool, truncated: &Truncated) -> std::io::Result<Box<dyn BufRead>> {
    if follow {
        return Ok(Box::new(BufReader::new(Growing::open(log)?)));
    }
    if log == Path::new("-") {
        return Ok(Box::new(std::io::stdin().lock()));
    }
    let recording = (tree.is_some() || !is_pipe(log)).then(|| Recording::open_with(log, tree));
    match recording {
        None | Some(Err(RecordingError::Foreign(_) | RecordingError::Read { .. })) => {
            diagnostics::reading(log)?;
            Ok(Box::new(BufReader::with_capacity(1 << 18, File::open(log)?)))
        }
        Some(recording) => {
            let truncated = Rc::clone(truncated);
            let note_end = move |error: &RecordingError| {
                note(&error.to_string());
                truncated.set(Some(error.to_string()));
            };
            let logged = recording.and_then(|recording| LoggedRecording::begin(recording, note_end));
            Ok(Box::new(logged.map_err(std::io::Error::other)?))
        }
    }
}

pub(crate) fn in_words(verified: &Verified) -> String {
    let Verified { properties, end, start_ns, knows_ticks, .. } = verified;
    let mut text = String::new();
    let since = start_ns.map_or_else(String::new, |ns| format!(" since {}", bags::moment(ns)));
    // Writing to a string cannot fail.
    let ticks = if *knows_ticks { format!(", {}", counted(end.ticks, "tick")) } else { String::new() };
    let _ = writeln!(text, "{}{ticks}{since}", counted(end.messages, "message"));
    for nothing in verified.nothing() {
        let _ = writeln!(text, "{nothing}");
    }
    for assumption in verified.assumptions() {
        let _ = writeln!(text, "it is assumed that {assumption}");
    }
    let widest = properties.iter().map(|property| property.name.chars().count()).fold(12, usize::max);
    for (index, property) in properties.iter().enumerate() {
        let _ = writeln!(text, "{:<widest$} {}", property.name, verified.verdict(index));
        match verified.evidence[index].certainty() {
            Certainty::Sure => {}
            Certainty::Unless(why) => text += &format!("  unless {why}\n"),
            Certainty::Unsure(why) => {
                text += &format!("  {why}\n  without what is missing: {}\n", verified.outcome(index));
            }
            Certainty::Groundless(why) => {
                text += &format!("  {why}\n");
                continue;
            }
        }
        for channel in verified.evidence[index].silent() {
            let _ = writeln!(text, "  no message {channel} in the whole run");
        }
        if let Some(unheard) = &verified.unheard[index] {
            let _ = writeln!(text, "  {unheard}");
        }
        let Some(monitor) = property.scope_monitor() else { continue };
        if let Some(witness) = monitor.witness() {
            text += &reports::witness_in_words(witness, *knows_ticks);
            if let Some(start_ns) = start_ns {
                let ns = i64::try_from(witness.settled.time.as_nanos()).unwrap_or(i64::MAX);
                let _ = writeln!(text, "  at {}", bags::moment(start_ns.saturating_add(ns)));
            }
        }
        if let Some(words) = monitor.violations().and_then(|violations| violations.in_words(verified.end_time())) {
            let _ = writeln!(text, "  {words}");
        }
        for open in verified.open(monitor) {
            let _ = writeln!(text, "  {open}");
        }
        for vacuity in monitor.vacuous() {
            let _ = writeln!(text, "  {vacuity}");
        }
    }
    text
}

pub(crate) fn as_json(verified: &Verified, log: &Path) -> serde_json::Value {
    let Verified { properties, evidence, unheard, start_ns, notes, .. } = verified;
    let of = |(index, property): (usize, &Property)| {
        let evidence = &evidence[index];
        let monitor = property.scope_monitor().filter(|_| !matches!(evidence.certainty(), Certainty::Groundless(_)));
        let vacuous = monitor.map(|monitor| monitor.vacuous()).unwrap_or_default();
        let open = monitor.map(|monitor| verified.open(monitor)).unwrap_or_default();
        let witness = monitor.and_then(|monitor| monitor.witness());
        let violations = monitor.and_then(|monitor| monitor.violations());
        json!({
            "name": property.name,
            "property": property.formula,
            "timed": property.scope_monitor().is_some_and(|monitor| monitor.formula().is_timed()),
            "verdict": verified.verdict(index),
            "certainty": evidence.certainty().name(),
            "unsure": evidence.certainty().why(),
            "assumptions": evidence.assumptions(),
            "silent": evidence.silent(),
            "state": property.monitor.location(),
            "witness": witness.map(|witness| reports::witness(witness, verified.knows_ticks)),
            "violations": violations.map(|violations| ViolationsReport::of(violations, verified.end_time())),
            "open": open,
            "vacuous": vacuous.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "unheard": unheard[index],
        })
    };
    let mut inspected = json!({
        "log": log.display().to_string(),
        "version": env!("CARGO_PKG_VERSION"),
        "provenance": verified.provenance(),
        "monitors": properties.iter().enumerate().map(of).collect::<Vec<_>>(),
    });
    inspected["notes"] = verified.nothing().map(str::to_owned).chain(notes.iter().cloned()).collect();
    if let Some(start_ns) = start_ns {
        inspected["start_s"] = bags::seconds(*start_ns).into();
    }
    inspected
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::path::PathBuf;

    use super::*;
    use crate::results::ResultsArgs;

    fn args(log: &Path, property: &str) -> VerifyArgs {
        let (logs, properties) = (vec![log.to_owned()], vec![PathBuf::from(property)]);
        VerifyArgs {
            logs,
            properties,
            robots: args::RobotsArgs::default(),
            scenario: None,
            map_channels: None,
            tree: crate::bag_tree::BagTreeArgs::default(),
            out: None,
            results: ResultsArgs::default(),
            follow: false,
            list: false,
            json: true,
        }
    }

    /// A line of a log: a message about the battery's level.
    fn level(step: u64, to: &str, level: f64) -> String {
        let ends = format!(r#""from":"BatteryReader","to":"{to}""#);
        format!(r#"{{"step":{step},"tick":0,"time_s":0,{ends},"message":[{{"sym":"ok"}},{level}]}}"#)
    }

    #[test]
    fn a_result_about_nothing_says_so() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        for text in ["", "{}\n"] {
            write!(file, "{text}").expect("room for a line");
            let verified = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
            assert!(in_words(&verified).starts_with("0 messages, 0 ticks\nthe log contains no events\n"), "{text}");
            assert_eq!((verified.verdict(0), verified.status()), ("no verdict", 2), "{text}");
            let notes = &as_json(&verified, file.path())["notes"];
            assert!(notes[0].as_str().is_some_and(|note| note.contains("no events")), "{notes}");
        }
    }

    #[test]
    fn verdicts_that_missing_lines_could_change_are_unsure() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first = [r#"{"scenario":"nominal"}"#, r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#];
        writeln!(file, "{}\n{}\n{}", first.join("\n"), level(1, "BatteryLevel", 50.0), level(9, "BatteryLevel", 40.0))
            .expect("room for four lines");
        let verified = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
        assert_eq!((verified.verdict(0), verified.outcome(0)), ("unsure", monitors::Outcome::Satisfied));
        let missing = "lines are missing before line 4 of the log: step 9 comes where 2 should";
        assert_eq!(
            (verified.evidence[0].certainty().why(), &verified.notes),
            (Some(missing), &vec![missing.to_owned()])
        );
        writeln!(file, "{}", level(11, "BatteryLevel", 10.0)).expect("room for a line");
        let verified = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
        let extent = format!("how often and how long phi1 was violated is unsure: {missing}");
        assert_eq!((verified.verdict(0), &verified.notes), ("violated", &vec![missing.to_owned(), extent]));
    }

    #[test]
    fn a_log_that_breaks_off_is_unsure_of_what_more_could_change() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first =
            [r#"{"scenario":"nominal","has_end":true}"#, r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#];
        let judged = |file: &Path| verify_log(&args(file, "phi1"), file, None).expect("a readable log").verdict(0);
        writeln!(file, "{}\n{}", first.join("\n"), level(1, "BatteryLevel", 50.0)).expect("room for three lines");
        assert_eq!(judged(file.path()), "unsure");
        writeln!(file, r#"{{"end":"arrival","step":1,"tick":0,"time_s":99.5}}"#).expect("room for a line");
        assert_eq!(judged(file.path()), "satisfied");
        let verified = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
        assert_eq!(
            verified.end_time(),
            std::time::Duration::from_secs_f64(99.5),
            "what lasts to the end lasts until then"
        );
        let mut cut = tempfile::NamedTempFile::new().expect("a file");
        writeln!(cut, "{}\n{}", first.join("\n"), level(1, "BatteryLevel", 9.0)).expect("room for three lines");
        assert_eq!(judged(cut.path()), "violated", "whatever came after it");
    }

    /// Such as one of a log of BehaviorTree.CPP, converted.
    #[test]
    fn a_log_without_ticks_is_refused_where_they_are_counted() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first = r#"{"scenario":"nominal","tick_s":0.0}"#;
        writeln!(file, "{first}\n{}", level(1, "BatteryLevel", 50.0)).expect("room for two lines");
        let judged = |property: &str| verify_log(&args(file.path(), property), file.path(), None);
        let refused = judged("phi2").err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("counts ticks"), "{refused}");
        let verified = judged("phi1").expect("a readable log");
        let assumed =
            "the log has every message of the scenario's channels, and that the program logged every change of status";
        assert!(verified.assumptions().contains(assumed), "{:?}", verified.assumptions());
    }

    #[test]
    fn a_property_that_counts_ticks_is_unsure_on_a_log_that_has_none() {
        let mut log = tempfile::NamedTempFile::new().expect("a file");
        let lines = [level(1, "BatteryLevel", 50.0), level(2, "BatteryLevel", 9.0)];
        writeln!(log, "{}\n{}", lines[0], lines[1]).expect("room for two lines");
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("p.scope");
        let verdict = |formula: &str| {
            let text = format!("property p := {formula}\nproperty other := eventually (LEVEL = 50)\n");
            std::fs::write(&file, text.replace("LEVEL", "BatteryReader, BatteryLevel, m[2]")).expect("room for both");
            let args = args(log.path(), file.to_str().expect("a path in UTF-8"));
            let verified = verify_log(&args, log.path(), None).expect("a readable log");
            assert_eq!(verified.verdict(1), "satisfied", "it counts no ticks");
            verified.verdict(0)
        };
        assert_eq!(verdict("always ((LEVEL = 50) implies time_until (LEVEL < 10) < 3)"), "unsure");
        assert_eq!(verdict("always ((LEVEL < 10) implies once[<= 3] (LEVEL = 50))"), "unsure");
        assert_eq!(verdict("always (LEVEL > 1)"), "satisfied");
    }

    /// Such as those of a scenario that names a process otherwise.
    #[test]
    fn messages_on_other_channels_leave_no_verdict_about_channels_that_may_not_have_been_in_the_log() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first =
            [r#"{"scenario":"nominal","version":"0.1.0"}"#, r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#];
        let judged = |file: &Path| {
            let verified = verify_log(&args(file, "phi1"), file, None).expect("a readable log");
            (verified.verdict(0), verified.evidence[0].certainty().why().unwrap_or_default().to_owned())
        };
        writeln!(file, "{}\n{}", first.join("\n"), level(1, "BatLevel", 10.0)).expect("room for three lines");
        let (verdict, why) = judged(file.path());
        assert!(
            verdict == "no verdict" && why.contains("from BatteryReader to BatteryLevel: none is in the log"),
            "{why}"
        );
        // With a message on it, the channel was in the log.
        writeln!(file, "{}", level(2, "BatteryLevel", 50.0)).expect("room for a line");
        assert_eq!(judged(file.path()), ("satisfied", String::new()));
    }

    #[test]
    fn a_log_is_checked_against_the_shipped_properties() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let lines = [
            r#"{"scenario":"battery_fault","seed":1}"#,
            r#"{"step":0,"tick":0,"time_s":0.0,"generated":"tick"}"#,
            r#"{"step":1,"tick":0,"time_s":0.1,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},10.0]}"#,
        ];
        writeln!(file, "{}", lines.join("\n")).expect("room for three lines");
        let verdict = |name: &str| format!("{:?}", verify(&args(file.path(), name)).expect("a readable log"));
        assert_eq!(verdict("phi1"), format!("{:?}", ExitCode::from(1)));
        assert_eq!(verdict("phi2"), format!("{:?}", ExitCode::SUCCESS));
    }

    #[test]
    fn bounds_in_seconds_are_counted_in_the_ticks_of_the_log() {
        let folder = tempfile::tempdir().expect("a folder");
        let property = folder.path().join("soon.scope");
        let text = "property soon := always ((BatteryReader, BatteryLevel, m[2] < 20) implies\n\
                    time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation>) < 2 s)\n";
        std::fs::write(&property, text).expect("room for a property");
        let log = folder.path().join("log.jsonl");
        let ticks = |from: u64, to: u64| {
            let step = from.min(1);
            (from..to)
                .map(move |tick| format!(r#"{{"step":{step},"tick":{tick},"time_s":{tick}.0,"generated":"tick"}}"#))
        };
        let low = r#"{"step":1,"tick":0,"time_s":0.1,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},10.0]}"#;
        let status = |tick_s: f64| {
            // As long as that of a system with many channels.
            let about = "x".repeat(100_000);
            let mut lines = vec![format!(r#"{{"about":"{about}","scenario":"nominal","tick_s":{tick_s}}}"#)];
            lines.extend(ticks(0, 1).chain([low.to_owned()]).chain(ticks(1, 4)));
            std::fs::write(&log, lines.join("\n")).expect("room for a log");
            let property = property.to_str().expect("its name is text");
            format!("{:?}", verify(&args(&log, property)).expect("a readable log"))
        };
        assert_eq!(status(1.0), format!("{:?}", ExitCode::from(1)), "two ticks are two seconds");
        assert_eq!(status(0.5), format!("{:?}", ExitCode::SUCCESS), "there are two ticks per second");
    }
}
