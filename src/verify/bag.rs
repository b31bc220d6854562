//! Bags of ROS 2: their contents, and verdicts on them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bags::{Bag, Contents, Definitions, Following, Listed, Mapping, Received, Source, Survey, Through};
use campaigns::Error;
use diagnostics::from_disk;
use serde_json::json;
use trials::replay::trajectory::trajectory;

use super::args::VerifyArgs;
use super::growing::STILL_WRITTEN;
use super::judge::{Verification, VerificationResult, name};
use super::mapped::{Mapped, await_topics, load_mapping};
use crate::interrupt::{self, pause};
use crate::output::note;

/// Checks a bag against properties, in constant memory.
pub(super) fn verify(args: &VerifyArgs, path: &Path, folder: Option<&Path>) -> Result<VerificationResult, Error> {
    let Some(mapping) = &args.map_channels else {
        if !args.follow {
            open(path)?;
        }
        let message = format!("there is no mapping from the messages of {} to channels", path.display());
        let help =
            format!("add `--map-channels FILE`; `steward verify --list {}` proposes such a file", path.display());
        return Err(Error::refused(message, help));
    };
    let robots = args.robots.spaces()?;
    let is_shown = folder.is_some() || args.results.have_stories() || args.board().is_some();
    let (mapping, text) = load_mapping(mapping, &args.robots)?;
    let mut damage: Vec<String> = Vec::new();
    let (survey, source, trajectory): (Survey, Box<dyn Source>, _) = if args.follow {
        let (survey, following) = follow(path, &mapping)?;
        (survey, Box::new(Through::new(following, receive_or_pause)), None)
    } else {
        let bag = open(path)?;
        let messages = bag.messages_on(mapping.topics());
        damage.extend(bag.damage().cloned());
        (
            bag.survey().clone(),
            Box::new(messages),
            if is_shown && robots.len() < 2 { trajectory(&bag, mapping.robot()) } else { None },
        )
    };
    let start = survey.span_ns.map_or_else(String::new, |(first, _)| format!(", since {}", bags::moment(first)));
    let verification = Verification {
        command: args.command(path),
        name: name(path),
        folder,
        stories: args.results.have_stories(),
        about: format!("A ROS 2 bag{start}"),
        mapping: text,
        inputs: &|| args.inputs(path),
        announcer: args.announcer(),
        board: args.board(),
    };
    let (properties, scenario) = (&args.properties, args.scenario.as_deref());
    let is_robot = false;
    let mapped = Mapped { verification, mapping: &mapping, properties, robots, scenario, trajectory, is_robot };
    let is_to_end = || args.follow && interrupt::flow().is_break();
    // Damage may be the reason why the bag is refused.
    let result = mapped.judge(&survey, source, &is_to_end);
    let mut result = result.inspect_err(|_| damage.iter().for_each(|what| note(what)))?;
    result.notes.extend(is_to_end().then(|| STILL_WRITTEN.to_owned()));
    result.notes.extend(part(&args.logs, path));
    Ok(result)
}

/// A note that a file is only a part of a recording, at the first of the parts.
fn part(logs: &[PathBuf], path: &Path) -> Option<String> {
    let (folder, count) = (path.parent()?, bags::parts(path)?);
    let is_part = |log: &&PathBuf| log.parent() == Some(folder) && bags::parts(log).is_some();
    let shown = if folder == Path::new("") { Path::new(".") } else { folder };
    let what = format!("is one of the {count} files of a recording; to check it as a whole, name the folder");
    let note = format!("{} {what}: {}", path.display(), shown.display());
    (logs.iter().find(is_part)? == path).then_some(note)
}

/// Receives a message, or pauses if nothing more has been written.
fn receive_or_pause(source: &mut Following, body: &mut Vec<u8>) -> Received {
    let received = source.receive(body);
    if received == Received::Idle {
        pause();
    }
    received
}

/// A recording that is still being written, from its beginning, and its survey. The survey contains every topic whose
/// type the channels depend on.
fn follow(path: &Path, mapping: &Mapping) -> Result<(Survey, Following), Error> {
    let following = Following::open(path, mapping.topics()).map_err(refused)?;
    let mut ahead = Through::new(following, receive_or_pause);
    await_topics(&mut ahead, mapping, &|| interrupt::flow().is_break());
    Ok((ahead.survey().clone(), ahead.source.restart().map_err(refused)?))
}

/// The contents of a bag.
pub(super) fn list(path: &Path) -> Result<Contents, Error> {
    let bag = open(path)?;
    let mut contents = contents(bag.survey());
    contents.lost.extend(bag.damage().cloned());
    Ok(contents)
}

/// The contents of a source.
pub(crate) fn contents(survey: &Survey) -> Contents {
    Contents::of(survey, &Definitions { survey, folders: &[], read: &from_disk })
}

pub(super) fn open(path: &Path) -> Result<Bag, Error> {
    Bag::open(path).map_err(refused)
}

fn refused(error: bags::Error) -> Error {
    Error::refused(error.to_string(), error.help())
}

/// The list as a comment, with the mapping below it. `publishers` are the publishers of topics, where they are known.
pub(crate) fn in_words(contents: &Contents, publishers: &BTreeMap<String, String>) -> String {
    let mut text = String::new();
    let width = |of: fn(&Listed) -> &str| contents.topics.iter().map(|topic| of(topic).len()).max().unwrap_or(0);
    let (names, kinds) = (width(|topic| &topic.name), width(|topic| &topic.kind));
    if let Some(start_ns) = contents.start_ns {
        text += &format!("# {:.3} s, since {}\n", contents.duration_s, bags::moment(start_ns));
    }
    for Listed { name, kind, messages, rate_hz, fields, .. } in &contents.topics {
        let rate = rate_hz.map_or_else(String::new, |rate_hz| format!("{rate_hz:.2} Hz"));
        let publishers = publishers.get(name).map_or_else(String::new, |publishers| format!("  {publishers}"));
        let missing =
            fields.as_ref().err().map_or_else(String::new, |why| format!("  {}", why.replace('\n', "\n#   ")));
        let line = format!("# {name:names$}  {kind:kinds$}  {messages:>8}  {rate:>10}{publishers}{missing}");
        text += &format!("{}\n", line.trim_end());
    }
    contents.lost.iter().chain(&contents.notes).for_each(|what| text += &format!("# {what}\n"));
    match contents.proposal() {
        Some(proposal) => text += &format!("\n# A mapping of everything: keep what the properties need.\n{proposal}"),
        None => text += "# there is nothing to map\n",
    }
    text
}

pub(crate) fn as_json(contents: &Contents, path: &Path) -> serde_json::Value {
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
        "notes": contents.notes,
        "mapping": contents.proposal(),
    })
}
