//! Checks properties against events, and writes the report of the results.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use bags::Found;
use campaigns::Error;
use channels::Topology;
use checks::System;
use monitors::{LogEnd, Outcome, Property, ScopeMonitor};
use recording::{
    Certainty, Doubts, Evidence, Header, InputFile, Judge, Monitor, Origin, Provenance, RunView, ShownVerdict,
};
use reports::Presentation;
use reports::file_place::FilePlace;

use crate::host::Host;
use crate::judged_run::{JudgedRun, await_live_pose};
use crate::log_context::LogContext;
use crate::wanted::{VerdictObserver, Wanted};

/// Why a property of a recording is not judged again.
pub const NO_FORMULA: &str = "no formula describes it";

/// The result of checking a log: the verdicts of properties, and what they rest on.
pub struct VerificationResult {
    /// The properties, with their monitors at the end.
    pub properties: Vec<Property>,
    /// The end of the log.
    pub end: LogEnd,
    /// The names of the properties of a recording that cannot be judged again: no formula describes them.
    pub unjudged: Vec<String>,
    /// The evidence for the verdict of each property.
    pub evidence: Vec<Evidence>,
    /// For each property that a recording satisfies although the true level fell below the required one: a note that no
    /// message reported this.
    pub unreported_levels: Vec<Option<String>>,
    /// For each property the story of its violation, as on the page of its report; empty without a story.
    pub stories: Vec<Vec<String>>,
    /// The header of the run: for an event log only with the argument of its scenario, for a bag empty.
    pub header: Header,
    /// Where the processes of the tree of a bag are written, if the command line names the tree.
    pub processes: BTreeMap<String, FilePlace>,
    /// When a bag begins, in nanoseconds since 1970.
    pub start_ns: Option<i64>,
    /// Whether the ticks of the tree are known.
    pub knows_ticks: bool,
    /// What is missing in the log or was not judged, in words.
    pub notes: Vec<String>,
    /// The files with which it was judged, if results are wanted.
    pub inputs: Vec<InputFile>,
}

/// The properties that were monitored in a recorded run, and the names of those that cannot be judged again because no
/// formula describes them.
pub(crate) fn recorded_properties(header: &Header) -> Result<(Vec<Property>, Vec<String>), Error> {
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
    /// The result for a log of which nothing else is known.
    pub(crate) fn of(properties: Vec<Property>, monitoring: MonitoringResult) -> Self {
        let MonitoringResult { end, evidence, stories, notes, inputs } = monitoring;
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
    #[must_use]
    pub fn open(&self, monitor: &ScopeMonitor) -> Vec<String> {
        let open = monitor.open_obligations().into_iter();
        open.map(|obligation| if self.knows_ticks { obligation.to_string() } else { format!("{obligation:#}") })
            .collect()
    }

    /// When the log ends.
    #[must_use]
    pub fn end_time(&self) -> Duration {
        self.end.time()
    }

    /// The verdict of a property.
    #[must_use]
    pub fn verdict(&self, index: usize) -> ShownVerdict {
        self.evidence[index].certainty().verdict(self.outcome(index))
    }

    /// Whether a property has a verdict.
    #[must_use]
    pub fn has_verdict(&self, index: usize) -> bool {
        self.evidence[index].has_verdict()
    }

    /// The assumptions about the messages, without duplicates.
    #[must_use]
    pub fn assumptions(&self) -> BTreeSet<&str> {
        self.evidence.iter().flat_map(Evidence::assumptions).map(String::as_str).collect()
    }

    /// The outcome of a property if no message is missing.
    #[must_use]
    pub fn outcome(&self, index: usize) -> Outcome {
        Outcome::of(self.properties[index].monitor.as_ref())
    }

    /// Notes that there were no events or no properties, which the verdicts alone would not show.
    pub fn empty_inputs(&self) -> impl Iterator<Item = &'static str> {
        let no_events = (self.end.messages + self.end.ticks == 0).then_some("the log contains no events");
        let no_property = self.properties.is_empty().then_some("there is no property to check the log against");
        no_events.into_iter().chain(no_property)
    }

    /// The files and the scenario from which the verdicts follow.
    #[must_use]
    pub fn provenance(&self) -> Provenance {
        let scenario = self.header.origin.argument.clone();
        Provenance { scenario, ..Provenance::of_files(self.inputs.clone()) }
    }

    /// The exit status: 2 if a property has no verdict, 1 if one is violated, or its verdict is unsure.
    #[must_use]
    pub fn status(&self) -> u8 {
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
pub(crate) fn unreported_levels(view: &RunView, properties: &[Property], topology: &Topology) -> Vec<Option<String>> {
    let unreported = |property: &Property| {
        let outcome = Outcome::of(property.monitor.as_ref());
        reports::unheard_level(&Monitor::of(property, topology), outcome, view)
    };
    properties.iter().map(unreported).collect()
}

/// The result of the monitors at the end of a log.
pub(crate) struct MonitoringResult {
    pub(crate) end: LogEnd,
    pub(crate) evidence: Vec<Evidence>,
    /// The stories of violations, if they are wanted.
    pub(crate) stories: Vec<Vec<String>>,
    /// What is unsure about violations although the first is sure, in words.
    notes: Vec<String>,
    inputs: Vec<InputFile>,
}

impl MonitoringResult {
    pub(crate) fn of(end: LogEnd, doubts: &Doubts, properties: &[Property]) -> Self {
        let evidence = properties.iter().enumerate().map(|(index, property)| doubts.evidence(index, property));
        let note = |(index, Property { name, .. }): (usize, &Property)| {
            let again = |why| format!("whether {name} was violated again is unsure: {why}");
            let extent = |why| format!("how often and how long {name} was violated is unsure: {why}");
            doubts.why_later(index).map(again).or_else(|| doubts.why_extent(index).map(extent))
        };
        Self {
            end,
            evidence: evidence.collect(),
            stories: vec![Vec::new(); properties.len()],
            notes: properties.iter().enumerate().filter_map(note).collect(),
            inputs: Vec::new(),
        }
    }
}

/// The properties in these files.
///
/// # Errors
/// If there is no file, one is wrong, or two properties have the same name.
pub fn load(files: &[PathBuf], system: &System, host: Host) -> Result<Vec<Property>, Error> {
    if files.is_empty() {
        let help = "name a file with properties: `--property FILE`; only recordings by steward have properties of \
                    their own";
        return Err(Error::refused("no property to check the log against is given".to_owned(), help));
    }
    let mut properties: Vec<Property> = Vec::new();
    for path in files {
        let file = system.load(path)?;
        if !file.warnings.is_empty() {
            (host.warn)(&file.warnings);
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

pub(crate) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// What is judged, besides its events.
pub(crate) struct Subject<'s> {
    pub(crate) name: String,
    pub(crate) about: String,
    /// The text of its mapping.
    pub(crate) mapping: String,
    pub(crate) system: &'s System,
    pub(crate) context: &'s LogContext,
}

impl Subject<'_> {
    /// Runs the monitors on the events, and makes what is wanted. The `doubts` are about messages that may be missing.
    pub(crate) fn judge(
        self,
        events: impl Iterator<Item = Result<Found, Error>>,
        properties: &mut [Property],
        doubts: Doubts,
        wanted: Wanted<'_>,
    ) -> Result<MonitoringResult, Error> {
        let inputs = (wanted.inputs)();
        let result = match wanted.has_records() {
            false => judge_without_records(events, properties, doubts, self.context, wanted.observer),
            true => self.judge_with_records(events, properties, doubts, wanted, &inputs),
        }?;
        Ok(MonitoringResult { inputs, ..result })
    }

    /// Makes all records, for the report and the live page.
    fn judge_with_records(
        self,
        mut events: impl Iterator<Item = Result<Found, Error>>,
        properties: &mut [Property],
        doubts: Doubts,
        mut wanted: Wanted<'_>,
        inputs: &[InputFile],
    ) -> Result<MonitoringResult, Error> {
        let Self { system, context, .. } = self;
        let observer = &mut wanted.observer;
        let mut idle = || observer.iter_mut().for_each(|observer| observer.idle(properties, context));
        let live_pose = context.live_pose.iter();
        let first =
            live_pose.flat_map(|live_pose| await_live_pose(live_pose, &mut events, &mut idle, wanted.host.note));
        let first: Vec<_> = first.collect();
        let (text, recorded) = (self.mapping, Some(wanted.command.clone()));
        let origin = Origin { text, recorded, inputs: inputs.to_vec(), ..Origin::default() };
        let begun = Judge::begin([self.name, self.about], origin, &system.topology, system.tick, properties, doubts);
        let observer = wanted.observer.take();
        let mut run = JudgedRun::new(first.into_iter().chain(events), properties, begun, context, observer);
        let (presentation, mut view) = wanted.conduct(&mut run)?;
        view.set_began(context.start_ns.get().and_then(bags::date));
        let stories = stories(presentation, &view)?;
        let (judge, properties) = run.finish();
        let result = MonitoringResult::of(judge.end(), judge.doubts(), properties);
        Ok(MonitoringResult { stories: stories.unwrap_or(result.stories), ..result })
    }
}

/// The stories of violations, if there is a report, which is written.
pub(crate) fn stories(report: Option<Presentation>, view: &RunView) -> Result<Option<Vec<Vec<String>>>, Error> {
    let Some(presentation) = report else { return Ok(None) };
    let report = presentation.finish(view)?;
    Ok(Some(report.monitors.into_iter().map(|monitor| monitor.story).collect()))
}

/// Runs the monitors on the events without making records, which is faster.
pub(crate) fn judge_without_records(
    events: impl Iterator<Item = Result<Found, Error>>,
    properties: &mut [Property],
    mut doubts: Doubts,
    context: &LogContext,
    mut observer: Option<Box<dyn VerdictObserver>>,
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
            Found::Noted(note) => observer.iter().for_each(|observer| observer.note(&note)),
            Found::Idle => {
                observer.iter_mut().for_each(|observer| observer.idle(properties, context));
                continue;
            }
        }
        if let Some(observer) = &mut observer {
            observer.follow(end.time(), properties, &doubts, context)?;
        }
    }
    Ok(MonitoringResult::of(end, &doubts, properties))
}
