//! Bags of ROS 2: their contents, and the verdicts of properties on them.

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use bags::{Bag, Contents, Definitions, Events, Following, Found, Listed, Mapping, Received, Source, Survey};
use campaigns::Error;
use diagnostics::from_disk;
use monitors::{Property, Violation};
use recording::Doubts;
use serde_json::json;
use trials::replay::way::way;

use super::args::VerifyArgs;
use super::around::Around;
use super::growing::{PAUSE, STILL_WRITTEN};
use super::judge::{Judged, Verified, load};
use crate::interrupt;
use crate::monitor::System;
use crate::output::note;

/// The file with the violations, beside the report.
const VIOLATIONS: &str = "violations.mcap";

/// Checks a bag against properties, in constant memory.
pub(super) fn verify(args: &VerifyArgs, path: &Path, folder: Option<&Path>) -> Result<Verified, Error> {
    let Some(mapping) = &args.map_channels else {
        if !args.follow {
            open(path)?;
        }
        let message = format!("there is no mapping from the messages of {} to channels", path.display());
        let help =
            format!("add `--map-channels FILE`; `steward verify --list {}` proposes such a file", path.display());
        return Err(Error::refused(message, help));
    };
    let text = diagnostics::text_from_disk(mapping).unwrap_or_default();
    let mapping = Mapping::load(mapping, &from_disk).map_err(scenarios::Error::bad_input)?;
    let (survey, source, way): (Survey, Box<dyn Source>, _) = if args.follow {
        let (survey, following) = follow(path, &mapping)?;
        (survey, Box::new(following), None)
    } else {
        let bag = open(path)?;
        let messages = bag.messages_on(mapping.topics());
        (bag.survey().clone(), Box::new(messages), folder.and_then(|_| way(&bag)))
    };
    let scenario = args.scenario.as_deref().map(System::of).transpose()?.map(|system| system.topology);
    let compiled = mapping.compile(&survey, scenario.as_ref(), &from_disk).map_err(scenarios::Error::bad_input)?;
    let system = System { topology: compiled.topology.clone(), tick: mapping.tick };
    let mut properties = load(args, &system)?;
    let mut events = Events::new(source, &mapping, compiled, &from_disk);
    let start = survey.span_ns.map_or_else(String::new, |(first, _)| format!(", since {}", bags::moment(first)));
    let about = format!("A ROS 2 bag{start}");
    // What the mapping leaves out is often what its channels cannot carry.
    let doubts = Doubts::about_any_messages(&properties, &system.topology);
    let around = Around { way, is_by_log: mapping.is_by_log(), ..Around::default() };
    let mut stopped = None;
    let found = std::iter::from_fn(|| {
        if args.follow && stopped.is_none() && interrupt::flow().is_break() {
            events.end();
            stopped = Some(STILL_WRITTEN.to_owned());
        }
        let found = events.next()?;
        if found == Found::Idle {
            std::thread::sleep(PAUSE);
        }
        around.start_ns.set(events.start_ns());
        around.newest_log_ns.set(events.newest_log_ns());
        Some(Ok(found))
    });
    let log = Judged { args, path, folder, about, mapping: text, system: &system, around: &around };
    let (end, unsure) = log.judge(found, &mut properties, doubts)?;
    let notes = survey.lost.iter().cloned().chain(events.notes()).chain(stopped).collect();
    if let Some((folder, start_ns)) = folder.zip(events.start_ns()) {
        write_violations(&properties, start_ns, folder)?;
    }
    let unheard = vec![None; properties.len()];
    Ok(Verified { properties, end, unsure, unheard, start_ns: events.start_ns(), notes })
}

/// A recording that is still being written, from its beginning, and what is known of it: it has every topic whose type
/// must be known before the channels are.
fn follow(path: &Path, mapping: &Mapping) -> Result<(Survey, Following), Error> {
    let (mut ahead, mut body) = (Following::open(path, mapping.topics()).map_err(refused)?, Vec::new());
    let mut said: Option<String> = None;
    while let Some(topic) = mapping.awaited(ahead.survey()) {
        match ahead.receive(&mut body) {
            Received::Message(_) => continue,
            Received::Over => break,
            Received::Idle if interrupt::flow().is_break() => break,
            Received::Idle => {}
        }
        if said.as_deref() != Some(topic) {
            note(&format!("waiting for the first message on {topic}, unless the mapping names its `type`"));
            said = Some(topic.to_owned());
        }
        std::thread::sleep(PAUSE);
    }
    Ok((ahead.survey().clone(), ahead.restart().map_err(refused)?))
}

/// Writes the violations, at their times in the bag, for tools that show the bag.
fn write_violations(properties: &[Property], start_ns: i64, folder: &Path) -> Result<(), Error> {
    let start = Duration::from_nanos(u64::try_from(start_ns).unwrap_or_default());
    let monitors = properties.iter().filter_map(|property| Some((&*property.name, property.scope_monitor()?)));
    let violations = monitors.flat_map(|(name, monitor)| {
        let all = monitor.violations().into_iter().flat_map(|all| all.first.clone());
        all.map(move |violation| (name, violation)).collect::<Vec<_>>()
    });
    let violations: Vec<(&str, Violation)> = violations.collect();
    let path = folder.join(VIOLATIONS);
    let unwritten = |source| Error::from(diagnostics::Error::Write { path: path.clone(), source });
    if violations.is_empty() {
        // One of an earlier call would speak of other verdicts.
        return match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(unwritten(error)),
            _ => Ok(()),
        };
    }
    let file = recording::write_violations(Vec::new(), start, &violations);
    Ok(diagnostics::write_whole(&path, file.map_err(unwritten)?)?)
}

/// The contents of a bag.
pub(super) fn list(path: &Path) -> Result<Contents, Error> {
    let bag = open(path)?;
    let definitions = Definitions { survey: bag.survey(), folders: &[], read: &from_disk };
    Ok(Contents::of(&bag, &definitions))
}

pub(super) fn open(path: &Path) -> Result<Bag, Error> {
    Bag::open(path).map_err(refused)
}

fn refused(error: bags::Error) -> Error {
    Error::refused(error.to_string(), error.help())
}

/// The list as a comment, and the mapping below it.
pub(super) fn in_words(contents: &Contents) -> String {
    let mut text = String::new();
    let width = |of: fn(&Listed) -> &str| contents.topics.iter().map(|topic| of(topic).len()).max().unwrap_or(0);
    let (names, kinds) = (width(|topic| &topic.name), width(|topic| &topic.kind));
    // Writing to a string cannot fail.
    if let Some(start_ns) = contents.start_ns {
        let _ = writeln!(text, "# {:.3} s, since {}", contents.duration_s, bags::moment(start_ns));
    }
    for Listed { name, kind, messages, rate_hz, fields, .. } in &contents.topics {
        let rate = rate_hz.map_or_else(String::new, |rate_hz| format!("{rate_hz:.2} Hz"));
        let missing =
            fields.as_ref().err().map_or_else(String::new, |why| format!("  {}", why.replace('\n', "\n#   ")));
        let line = format!("# {name:names$}  {kind:kinds$}  {messages:>8}  {rate:>10}{missing}");
        let _ = writeln!(text, "{}", line.trim_end());
    }
    contents.lost.iter().for_each(|lost| text += &format!("# {lost}\n"));
    match contents.proposal() {
        Some(proposal) => text += &format!("\n# A mapping of everything: keep what the properties need.\n{proposal}"),
        None => text += "# there is nothing to map\n",
    }
    text
}

pub(super) fn as_json(contents: &Contents, path: &Path) -> serde_json::Value {
    let topic = |Listed { name, kind, messages, rate_hz, fields, .. }: &Listed| {
        let (fields, missing) = match fields {
            Ok(fields) => (fields.iter().map(|(path, what)| json!({ "path": path, "holds": what })).collect(), None),
            Err(why) => (Vec::new(), Some(why)),
        };
        json!({ "name": name, "type": kind, "messages": messages, "rate_hz": rate_hz, "fields": fields, "missing": missing })
    };
    json!({
        "bag": path.display().to_string(),
        "start_s": contents.start_ns.map(bags::seconds),
        "duration_s": contents.duration_s,
        "topics": contents.topics.iter().map(topic).collect::<Vec<_>>(),
        "lost": contents.lost,
        "mapping": contents.proposal(),
    })
}
