//! Bags of ROS 2: their contents, and the verdicts of properties on them.

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use bags::{Bag, Contents, Definitions, Events, Listed, Mapping};
use campaigns::Error;
use diagnostics::from_disk;
use monitors::{Property, Violation};
use recording::Doubts;
use serde_json::json;
use trials::replay::way::way;

use super::args::VerifyArgs;
use super::judge::{Around, Verified, judge, load};
use crate::monitor::System;

/// The file with the violations, beside the report.
const VIOLATIONS: &str = "violations.mcap";

/// Checks a bag against properties, in constant memory.
pub(super) fn verify(args: &VerifyArgs, path: &Path, folder: Option<&Path>) -> Result<Verified, Error> {
    let Some(mapping) = &args.map_channels else {
        open(path)?;
        let message = format!("there is no mapping from the messages of {} to channels", path.display());
        let help =
            format!("add `--map-channels FILE`; `steward verify --list {}` proposes such a file", path.display());
        return Err(Error::refused(message, help));
    };
    let text = diagnostics::text_from_disk(mapping).unwrap_or_default();
    let mapping = Mapping::load(mapping, &from_disk).map_err(scenarios::Error::bad_input)?;
    let bag = open(path)?;
    let scenario = args.scenario.as_deref().map(System::of).transpose()?.map(|system| system.topology);
    let compiled = mapping.compile(bag.survey(), scenario.as_ref(), &from_disk).map_err(scenarios::Error::bad_input)?;
    let system = System { topology: compiled.topology.clone(), tick: mapping.tick };
    let mut properties = load(args, &system)?;
    let mut events = Events::new(&bag, &mapping, compiled);
    let start = bag.survey().span_ns.map_or_else(String::new, |(first, _)| format!(", since {}", bags::moment(first)));
    let about = format!("A ROS 2 bag{start}");
    // What the mapping leaves out is often what its channels cannot carry.
    let doubts = Doubts::about_any_messages(&properties, &system.topology);
    let way = folder.and_then(|_| way(&bag));
    let around = Around { way, is_by_log: mapping.is_by_log(), ..Around::default() };
    let found = std::iter::from_fn(|| {
        let found = events.next();
        around.start_ns.set(events.start_ns());
        found.map(Ok)
    });
    let (end, unsure) = judge(args, (path, folder), [about, text], &system, &mut properties, doubts, (found, &around))?;
    let notes = bag.survey().lost.iter().cloned().chain(events.notes()).collect();
    if let Some((folder, start_ns)) = folder.zip(events.start_ns()) {
        write_violations(&properties, start_ns, folder)?;
    }
    let unheard = vec![None; properties.len()];
    Ok(Verified { properties, end, unsure, unheard, start_ns: events.start_ns(), notes })
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
    Bag::open(path).map_err(|error| Error::refused(error.to_string(), error.help()))
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
