//! Checks properties against events, and writes the report of the results.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bags::Found;
use campaigns::{Error, refuse_campaign};
use channels::Topology;
use editor::System;
use monitors::{LogEnd, Outcome, Property, ScopeMonitor};
use recording::{
    Certainty, Detail, Doubts, Evidence, Header, InputFile, Judge, Monitor, Origin, Provenance, RunView, ShownVerdict,
    conduct,
};
use reports::file_place::FilePlace;
use reports::{Outputs, Presentation};

use super::announcer::Announcer;
use super::judged_run::{JudgedRun, await_live_pose};
use super::log_context::LogContext;
use crate::live::BoardArgs;
use crate::output::warn;

/// Why a property of a recording is not judged again.
pub(super) const NO_FORMULA: &str = "no formula describes it";

/// The result of checking a log: the verdicts of properties, and what they rest on.
pub(crate) struct VerificationResult {
    pub(crate) properties: Vec<Property>,
    pub(crate) end: LogEnd,
    /// The names of the properties of a recording that cannot be judged again: no formula describes them.
    pub(crate) unjudged: Vec<String>,
    /// The evidence for the verdict of each property.
    pub(crate) evidence: Vec<Evidence>,
    /// For each property that a recording satisfies although the true level fell below the required one: a note that no
    /// message reported this.
    pub(crate) unreported_levels: Vec<Option<String>>,
    /// For each property the story of its violation, as on the page of its report; empty without a story.
    pub(crate) stories: Vec<Vec<String>>,
    /// The header of the run: for an event log only with the argument of its scenario, for a bag empty.
    pub(crate) header: Header,
    /// Where the processes of the tree of a bag are written, if the command line names the tree.
    pub(crate) processes: BTreeMap<String, FilePlace>,
    /// When a bag begins, in nanoseconds since 1970.
    pub(crate) start_ns: Option<i64>,
    /// Whether the ticks of the tree are known.
    pub(crate) knows_ticks: bool,
    /// What is missing in the log or was not judged, in words.
    pub(crate) notes: Vec<String>,
    /// The files with which it was judged, if results are wanted.
    pub(crate) inputs: Vec<InputFile>,
}

/// The properties that were monitored in a recorded run, and the names of those that cannot be judged again because no
/// formula describes them.
pub(super) fn recorded_properties(header: &Header) -> Result<(Vec<Property>, Vec<String>), Error> {
    let (mut properties, mut others) = (Vec::new(), Vec::new());
    for Monitor { name, property, summary, formula, .. } in header.monitors.iter() {
        let Some(formula) = formula else {
            others.push(name.clone());
            continue;
        };
        let monitor = ScopeMonitor::new(name, formula.clone(), &header.topology).map_err(|error| {
            let help = "name a file with the properties: `--property FILE`";
            Error::refused(format!("the recording's property `{name}` cannot be monitored: {error}"), help)
        })?;
        let (name, formula, summary) = (name.clone(), property.clone(), summary.clone());
        properties.push(Property { name, formula, summary, place: None, monitor: Box::new(monitor) });
    }
    Ok((properties, others))
}

impl VerificationResult {
    /// The result for events until `end`, with `left_open` among its notes.
    pub(crate) fn of(properties: Vec<Property>, end: LogEnd, doubts: &Doubts, left_open: String) -> Self {
        let monitoring = MonitoringResult::of(end, doubts, &properties);
        let notes = monitoring.notes(&properties).into_iter().chain([left_open]).collect();
        Self::of_monitoring(properties, monitoring, notes)
    }

    /// The result for a log of which nothing else is known.
    pub(super) fn of_monitoring(properties: Vec<Property>, monitoring: MonitoringResult, notes: Vec<String>) -> Self {
        let MonitoringResult { end, evidence, stories, inputs, .. } = monitoring;
        Self {
            unreported_levels: vec![None; properties.len()],
            properties,
            unjudged: Vec::new(),
            end,
            evidence,
            stories,
            header: Header::default(),
            processes: BTreeMap::new(),
            start_ns: None,
            knows_ticks: false,
            notes,
            inputs,
        }
    }

    /// The open obligations of a monitor, in words.
    pub(super) fn open(&self, monitor: &ScopeMonitor) -> Vec<String> {
        let open = monitor.open_obligations().into_iter();
        open.map(|obligation| if self.knows_ticks { obligation.to_string() } else { format!("{obligation:#}") })
            .collect()
    }

    /// When the log ends.
    pub(super) fn end_time(&self) -> Duration {
        self.end.time()
    }

    /// The verdict of a property.
    pub(super) fn verdict(&self, index: usize) -> ShownVerdict {
        self.evidence[index].certainty().verdict(self.outcome(index))
    }

    /// Whether a property has a verdict.
    pub(super) fn has_verdict(&self, index: usize) -> bool {
        self.evidence[index].has_verdict()
    }

    /// The assumptions about the messages, without duplicates.
    pub(super) fn assumptions(&self) -> BTreeSet<&str> {
        self.evidence.iter().flat_map(Evidence::assumptions).map(String::as_str).collect()
    }

    /// The outcome of a property if no message is missing.
    pub(super) fn outcome(&self, index: usize) -> Outcome {
        Outcome::of(self.properties[index].monitor.as_ref())
    }

    /// Notes that there were no events or no properties, which the verdicts alone would not show.
    pub(super) fn empty_inputs(&self) -> impl Iterator<Item = &'static str> {
        let no_events = (self.end.messages + self.end.ticks == 0).then_some("the log contains no events");
        let no_property = self.properties.is_empty().then_some("there is no property to check the log against");
        no_events.into_iter().chain(no_property)
    }

    /// The files and the scenario from which the verdicts follow.
    pub(super) fn provenance(&self) -> Provenance {
        let scenario = self.header.origin.argument.clone();
        Provenance { scenario, ..Provenance::of_files(self.inputs.clone()) }
    }

    /// The exit status: 2 if a property has no verdict, 1 if one is violated, or its verdict is unsure.
    pub(crate) fn status(&self) -> u8 {
        let of = |(index, evidence): (usize, &Evidence)| match evidence.certainty() {
            Certainty::Groundless(_) => 2,
            Certainty::Unsure(_) => 1,
            Certainty::Sure | Certainty::Unless(_) => u8::from(self.outcome(index) == Outcome::Violated),
        };
        self.evidence.iter().enumerate().map(of).max().unwrap_or(0)
    }
}

/// For each property that is satisfied although the true level in this recorded run fell below the required one: a note
/// that no message reported this. Levels in the missing part of a truncated recording are unknown.
pub(super) fn unreported_levels(view: &RunView, properties: &[Property], topology: &Topology) -> Vec<Option<String>> {
    let unreported = |property: &Property| {
        let outcome = Outcome::of(property.monitor.as_ref());
        reports::unheard_level(&Monitor::of(property, topology), outcome, view)
    };
    properties.iter().map(unreported).collect()
}

/// The result of the monitors at the end of a log: the end, and the evidence for the verdicts. Also why violations
/// after the first, and the number and the length of violations, are unsure.
pub(super) struct MonitoringResult {
    pub(super) end: LogEnd,
    pub(super) evidence: Vec<Evidence>,
    /// The stories of violations, if they are wanted.
    pub(super) stories: Vec<Vec<String>>,
    inputs: Vec<InputFile>,
    later: Vec<Option<String>>,
    extents: Vec<Option<String>>,
}

impl MonitoringResult {
    fn of(end: LogEnd, doubts: &Doubts, properties: &[Property]) -> Self {
        let evidence = properties.iter().enumerate().map(|(index, property)| doubts.evidence(index, property));
        let owned = |why: Option<&str>| why.map(str::to_owned);
        Self {
            end,
            evidence: evidence.collect(),
            stories: vec![Vec::new(); properties.len()],
            inputs: Vec::new(),
            later: doubts.later().map(owned).collect(),
            extents: doubts.extents().map(owned).collect(),
        }
    }

    /// What is unsure about violations although the first is sure, in words.
    pub(super) fn notes(&self, properties: &[Property]) -> Vec<String> {
        let of = |(Property { name, .. }, (later, extent)): (&Property, (&Option<String>, &Option<String>))| {
            let again = later.as_ref().map(|why| format!("whether {name} was violated again is unsure: {why}"));
            let extent = extent.as_ref();
            again.or(extent.map(|why| format!("how often and how long {name} was violated is unsure: {why}")))
        };
        properties.iter().zip(self.later.iter().zip(&self.extents)).filter_map(of).collect()
    }
}

/// The properties in these files.
pub(crate) fn load(files: &[PathBuf], system: &System) -> Result<Vec<Property>, Error> {
    if files.is_empty() {
        let help = "name a file with properties: `--property FILE`; only recordings by steward have properties of \
                    their own";
        return Err(Error::refused("no property to check the log against is given".to_owned(), help));
    }
    let mut properties: Vec<Property> = Vec::new();
    for path in files {
        let file = system.load(path)?;
        if !file.warnings.is_empty() {
            warn(&file.warnings);
        }
        let known = |name: &str| properties.iter().any(|property| property.name == name);
        if let Some(again) = file.properties.iter().find(|property| known(&property.name)) {
            let message = format!("there are two properties `{}`, one in {}", again.name, path.display());
            return Err(Error::refused(message, "give each property a different name"));
        }
        properties.extend(file.properties);
    }
    Ok(properties)
}

/// The name of a log.
pub(super) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The check of a log, before its events are read.
pub(crate) struct Verification<'l> {
    /// The command that repeats the check.
    pub(crate) command: String,
    pub(crate) name: String,
    /// The folder of its report, if there is one.
    pub(crate) folder: Option<&'l Path>,
    /// Whether the stories of violations are wanted even without a report.
    pub(crate) stories: bool,
    /// A description of the log, in words.
    pub(crate) about: String,
    /// The text of its mapping.
    pub(crate) mapping: String,
    /// Returns the files with which it is judged, if results are wanted. It is called after the files have been read.
    pub(crate) inputs: &'l dyn Fn() -> Vec<InputFile>,
    /// Reports verdicts as they are reached, if this is wanted.
    pub(crate) announcer: Option<Announcer>,
    /// Shows the events on a live page, if this is wanted.
    pub(crate) board: Option<&'l BoardArgs>,
}

impl Verification<'_> {
    /// Runs the monitors on the events, and writes the report to the folder, if there is one. `doubts` knows which
    /// messages may be missing.
    pub(super) fn judge(
        self,
        system: &System,
        context: &LogContext,
        events: impl Iterator<Item = Result<Found, Error>>,
        properties: &mut [Property],
        doubts: Doubts,
    ) -> Result<MonitoringResult, Error> {
        let inputs = (self.inputs)();
        let result = match (self.folder, self.board) {
            (None, None) if !self.stories => judge_without_report(events, properties, doubts, context, self.announcer),
            _ => self.judge_with_report(system, context, events, properties, doubts, &inputs),
        }?;
        Ok(MonitoringResult { inputs, ..result })
    }

    /// Makes all records, for the report and the live page.
    fn judge_with_report(
        self,
        system: &System,
        context: &LogContext,
        mut events: impl Iterator<Item = Result<Found, Error>>,
        properties: &mut [Property],
        doubts: Doubts,
        inputs: &[InputFile],
    ) -> Result<MonitoringResult, Error> {
        let mut announcer = self.announcer;
        let mut idle = || announcer.iter_mut().for_each(|announcer| announcer.idle(properties, context));
        let live_pose = context.live_pose.iter();
        let first = live_pose.flat_map(|live_pose| await_live_pose(live_pose, &mut events, &mut idle));
        let first: Vec<_> = first.collect();
        let folder = self.folder.map(Path::to_owned);
        let outputs = Outputs { folder, stories: self.stories, ..Outputs::default() };
        refuse_campaign(&outputs)?;
        let (text, recorded) = (self.mapping, Some(self.command));
        let origin = Origin { text, recorded, inputs: inputs.to_vec(), ..Origin::default() };
        let begun = Judge::begin([self.name, self.about], origin, &system.topology, system.tick, properties, doubts);
        let mut run = JudgedRun::new(first.into_iter().chain(events), properties, begun, context, announcer);
        let begin = |view: &RunView| {
            let presentation = Presentation::begin(view, &outputs)?;
            Ok::<_, Error>((presentation, self.board.map(|board| board.feed(view)).transpose()?))
        };
        let conducted = conduct(&mut run, Detail::Full, None, begin, |_| ControlFlow::Continue(()))?;
        let ((presentation, _), mut view) = conducted;
        let (judge, properties) = run.finish();
        view.set_began(context.start_ns.get().and_then(bags::date));
        let report = presentation.finish(&view)?;
        let stories = report.monitors.into_iter().map(|monitor| monitor.story).collect();
        Ok(MonitoringResult { stories, ..MonitoringResult::of(judge.end(), judge.doubts(), properties) })
    }
}

/// Runs the monitors on the events without making records, which is faster.
pub(super) fn judge_without_report(
    events: impl Iterator<Item = Result<Found, Error>>,
    properties: &mut [Property],
    mut doubts: Doubts,
    context: &LogContext,
    mut announcer: Option<Announcer>,
) -> Result<MonitoringResult, Error> {
    let mut end = LogEnd::default();
    for found in events {
        match found? {
            Found::Event(event) => {
                end.count(&event);
                properties.iter_mut().for_each(|property| property.monitor.observe(&event));
                doubts.observe(&event, properties);
            }
            Found::LeftOut(gap) => doubts.miss(&gap, properties),
            Found::Resumed(channel) => doubts.resume(channel, properties),
            Found::Ended(time) => end.ended = Some(time),
            Found::Vouched(channel, ground) => doubts.vouch(channel, ground),
            Found::Noted(note) => announcer.iter().for_each(|announcer| announcer.note(&note)),
            Found::Idle => {
                announcer.iter_mut().for_each(|announcer| announcer.idle(properties, context));
                continue;
            }
        }
        if let Some(announcer) = &mut announcer {
            announcer.follow(end.time(), properties, &doubts, context)?;
        }
    }
    Ok(MonitoringResult::of(end, &doubts, properties))
}
