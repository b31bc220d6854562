//! Properties judged on messages of ROS 2 from any source: a bag, a bag that is being written, or a robot.

use std::cell::RefCell;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use bags::{Events, Mapping, Received, Remapping, Source, Survey, Through};
use campaigns::Error;
use checks::System;
use diagnostics::from_disk;
use monitors::{Property, Violation};
use recording::{Doubts, Header, Origin};
use replay::live_pose::LivePose;
use replay::trajectory::Trajectory;

use crate::host::Host;
use crate::judge::{Subject, VerificationResult, load};
use crate::log_context::LogContext;
use crate::log_request::Robots;
use crate::wanted::Wanted;

/// The name of the file with the violations, beside the report.
const VIOLATIONS: &str = "violations.mcap";
/// What describes a bag in its folder.
const METADATA: &str = "metadata.yaml";

/// Messages with their mapping, and the properties to check.
pub struct Mapped<'m> {
    /// The name of the source, for the report.
    pub name: String,
    /// A description of the source, for the report.
    pub about: String,
    /// What the messages are on channels.
    pub mapping: &'m Mapping,
    /// The text of the mapping.
    pub text: String,
    /// The files with properties.
    pub properties: &'m [PathBuf],
    /// The namespaces of the robots, if the mapping is for several.
    pub robots: &'m [String],
    /// The scenario that has the channels, if one is named.
    pub scenario: Option<&'m str>,
    /// The trajectory of the robot, if there is a map.
    pub trajectory: Option<Trajectory>,
    /// Whether the source delivers what shows the robot on the page.
    pub is_robot: bool,
}

impl Mapped<'_> {
    /// Judges the messages of a source until its end, or until `is_to_end`. `survey` is what was known of the source
    /// before the first message.
    ///
    /// # Errors
    /// If mapping or properties are wrong, or what is wanted cannot be written.
    pub fn judge(
        self,
        survey: &Survey,
        source: Box<dyn Source>,
        is_to_end: &dyn Fn() -> bool,
        wanted: Wanted<'_>,
    ) -> Result<VerificationResult, Error> {
        let source = Through::new(source, |source: &mut Box<dyn Source>, body: &mut Vec<u8>| match is_to_end() {
            true => {
                source.end();
                Received::Over
            }
            false => source.receive(body),
        });
        let mapping = self.mapping;
        let (folder, host) = (wanted.folder, wanted.host);
        folder.map_or(Ok(()), check_violations)?;
        let scenario = self.scenario.map(System::of).transpose()?.map(|system| system.topology);
        let compiled = mapping.compile(survey, scenario.as_ref(), &from_disk).map_err(scenarios::Error::bad_input)?;
        let system = System::new(compiled.topology.clone(), mapping.tick);
        let mut properties = match self.robots {
            [] => load(self.properties, &system, host)?,
            robots => load_for_each(robots, self.properties, &system, host)?,
        };
        // Messages are often left out because their channels cannot carry them.
        let doubts = match source.counts_losses() {
            true => Doubts::about_losses(&properties, &system.topology),
            false => Doubts::about_any_messages(&properties, &system.topology),
        };
        let shown = wanted.page.filter(|_| self.is_robot).and(mapping.robot());
        let live_pose = shown.map(|topics| LivePose::new(topics.clone()));
        let live_pose = live_pose.map(|live_pose| Rc::new(RefCell::new(live_pose)));
        let source = Through::new(source, |source: &mut _, body: &mut Vec<u8>| {
            let received = Source::receive(source, body);
            if let (Some(live_pose), Received::Message(head)) = (&live_pose, received) {
                live_pose.borrow_mut().take(head, body, source.survey());
            }
            received
        });
        let mut events = Events::new(Box::new(source), mapping, compiled, &from_disk);
        let context = &LogContext {
            trajectory: self.trajectory,
            live_pose: live_pose.clone(),
            is_by_log: mapping.is_by_log(),
            ..LogContext::default()
        };
        let found = std::iter::from_fn(|| {
            let found = events.next();
            context.start_ns.set(events.start_ns());
            context.newest_log_ns.set(events.newest_log_ns());
            found.map(Ok)
        });
        let subject = Subject { name: self.name, about: self.about, mapping: self.text, system: &system, context };
        let monitoring = subject.judge(found, &mut properties, doubts, wanted)?;
        if let Some((folder, start_ns)) = folder.zip(events.start_ns()) {
            write_violations(&properties, start_ns, folder)?;
        }
        let result = VerificationResult::of(properties, monitoring);
        let notes = survey.lost.iter().cloned().chain(events.notes()).chain(result.notes).collect();
        let origin = Origin { argument: self.scenario.unwrap_or_default().to_owned(), ..Origin::default() };
        Ok(VerificationResult {
            header: Header { origin, ..Header::default() },
            start_ns: events.start_ns(),
            knows_ticks: true,
            notes,
            ..result
        })
    }
}

/// A mapping file, for these robots, and its text.
///
/// # Errors
/// If the file is wrong, or names none of the topics that have other names.
pub fn load_mapping(path: &Path, robots: Robots<'_>) -> Result<(Mapping, String), Error> {
    let text = diagnostics::text_from_disk(path).unwrap_or_default();
    let mapping = Mapping::load(path, &from_disk).map_err(scenarios::Error::bad_input)?;
    let mapping = mapping.of_robots(robots.spaces, robots.remapped).map_err(|Remapping { from, .. }| {
        let message = format!("`--remap`: {} names no topic `{from}`, or an earlier one is about it", path.display());
        Error::refused(message, "give the name of a topic, service or action as it is in the mapping")
    })?;
    Ok((mapping, text))
}

/// Reads and discards messages until every mapped topic without a `type` exists, or until `is_to_end`.
pub fn await_topics(
    source: &mut (impl Source + ?Sized),
    mapping: &Mapping,
    is_to_end: &dyn Fn() -> bool,
    note: fn(&str),
) {
    let (mut body, mut noted, mut lost) = (Vec::new(), None, 0);
    while let Some(topic) = mapping.awaited(source.survey()) {
        source.lost().iter().skip(lost).for_each(|what| note(what));
        lost = source.lost().len();
        match source.receive(&mut body) {
            Received::Over => break,
            _ if is_to_end() => break,
            Received::Message(_) | Received::Lost { .. } | Received::Late { .. } | Received::Resumed { .. } => {}
            Received::Idle | Received::ClockAdvanced(_) if noted.as_deref() != Some(topic) => {
                note(&format!("waiting for the topic {topic}; with its `type` in the mapping, it need not exist yet"));
                noted = Some(topic.to_owned());
            }
            Received::Idle | Received::ClockAdvanced(_) => {}
        }
    }
}

/// The properties of each robot, about its own processes. The namespace of the robot is the prefix of their names.
fn load_for_each(robots: &[String], paths: &[PathBuf], system: &System, host: Host) -> Result<Vec<Property>, Error> {
    let mut all = Vec::new();
    for space in robots {
        let prefix = bags::prefix(space);
        let part = System::new(Arc::new(system.topology.part(&prefix)), system.tick);
        let mut properties = load(paths, &part, host)?;
        properties.iter_mut().for_each(|property| property.rename(format!("{prefix}{}", property.name)));
        all.append(&mut properties);
    }
    Ok(all)
}

/// Checks, before the messages are read, that an existing file with violations may be replaced: this program has
/// written it, and the command does not read it.
///
/// # Errors
/// If it may not be replaced.
pub fn check_violations(folder: &Path) -> Result<(), Error> {
    let path = folder.join(VIOLATIONS);
    if path.exists() && !recording::are_violations(&path) {
        let message = format!("{} exists and contains no violations by steward", path.display());
        return Err(Error::refused(message, "name another folder, or remove the file first"));
    }
    Ok(diagnostics::check_unread(&path)?)
}

/// Refuses the folder of a bag that is not judged: the next reader of that bag would read the file with the violations
/// as a part of it.
///
/// Files are recognized by their names: a file that this command has opened, such as an earlier report, could not be
/// replaced.
///
/// # Errors
/// If it is one.
pub fn check_no_bag(folder: &Path) -> Result<(), Error> {
    let paths = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    paths.filter(|path| is_part_of_a_bag(path)).min().map_or(Ok(()), |part| Err(in_bag(&part)))
}

/// The same for a command that may have written recordings of its own into the folder.
///
/// # Errors
/// If it is one.
pub fn check_no_metadata(folder: &Path) -> Result<(), Error> {
    let metadata = folder.join(METADATA);
    if metadata.exists() { Err(in_bag(&metadata)) } else { Ok(()) }
}

fn in_bag(part: &Path) -> Error {
    let message = format!("the report would be written into the folder of a bag: {} is a part of it", part.display());
    Error::refused(message, "name another folder with `--out`")
}

/// Whether a file is, by its name, a part of a bag or its metadata. Files with violations by steward are not.
fn is_part_of_a_bag(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let plain = name.strip_suffix(".zstd").unwrap_or(&name);
    let is_named = name == METADATA || plain.ends_with(".mcap") || plain.ends_with(".db3");
    // A named pipe must not be opened.
    let is_own = || name == VIOLATIONS || path.is_file() && recording::are_violations(path);
    is_named && !path.is_dir() && !is_own()
}

/// Writes the violations at their times in the bag, for tools that show the bag.
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
    check_violations(folder)?;
    if violations.is_empty() {
        // A file of an earlier check would contain other verdicts.
        return match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(unwritten(error)),
            _ => Ok(()),
        };
    }
    let file = recording::write_violations(Vec::new(), start, &violations);
    Ok(diagnostics::write_whole(&path, file.map_err(unwritten)?)?)
}
