//! The results of a command, for machines and people who read them in files.
//!
//! Every command makes the same thing of what it has found: a [`Suite`] for each run, proof, log or file, with a
//! [`Case`] for each of its questions, and with [findings](FileFinding) in files. The writers, `junit`,
//! `sarif` and `markdown`, depend on no command, and no command depends on a format.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use monitors::{Outcome, Sighting, Witness};
use recording::{Expected, InputFile, Provenance, ShownVerdict};

use crate::WitnessReport;
use crate::file_place::FilePlace;
use crate::html;
use crate::report::{ExpectationReport, MonitorReport, Report};

/// What a command has found.
#[derive(Clone, Debug)]
pub struct Results {
    /// The command's name: `run`.
    pub command: &'static str,
    /// What it was about. No two have the same name.
    pub suites: Vec<Suite>,
}

impl Results {
    /// What a command has found. Suites with the same name are distinguished by their files, or else by numbers.
    #[must_use]
    pub fn new(command: &'static str, mut suites: Vec<Suite>) -> Self {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        suites.iter().for_each(|suite| *counts.entry(suite.name.clone()).or_default() += 1);
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        for Suite { name, file, .. } in suites.iter_mut().filter(|suite| counts[&suite.name] > 1) {
            let file = file.as_ref().map(ToString::to_string).filter(|file| file != name);
            name.extend(file.map(|file| format!(" ({file})")));
            let number = seen.entry(name.clone()).and_modify(|number| *number += 1).or_insert(1);
            name.extend((*number > 1).then(|| format!(" ({number})")));
        }
        Self { command, suites }
    }
}

/// What belongs together: the results of a run, of the proofs of a scenario, of a log or of a file.
#[derive(Clone, Debug, Default)]
pub struct Suite {
    /// Its name.
    pub name: String,
    /// What it was made from; none if the command names its files itself.
    pub provenance: Option<Provenance>,
    /// Further facts about it: what they are about, and what they are.
    pub facts: Vec<(&'static str, String)>,
    /// What the answers leave open: sentences without a full stop.
    pub notes: Vec<String>,
    /// The questions with their answers.
    pub cases: Vec<Case>,
    /// What was found in files besides.
    pub findings: Vec<FileFinding>,
    /// The file that it is about: the place of what has no other.
    pub file: Option<FilePlace>,
    /// The page that shows it.
    pub page: Option<PathBuf>,
    /// Further pictures, each with what it shows.
    pub pictures: Vec<(PathBuf, String)>,
}

/// A question and its answer.
#[derive(Clone, Debug, Default)]
pub struct Case {
    /// The subject: `properties`, `expectations`, `proofs`.
    pub group: &'static str,
    /// Its name.
    pub name: String,
    /// The result.
    pub result: CaseResult,
    /// What was found, in a few words: `violated`. Empty if the result is enough.
    pub found: String,
    /// What the question means; empty if that is clear from its name.
    pub about: String,
    /// Where its subject is written.
    pub place: Option<FilePlace>,
    /// What led to the result, in order.
    pub trail: Vec<TrailStep>,
    /// The same for people, in sentences; code is in backquotes.
    pub story: Vec<String>,
    /// The page that shows how it came to it, if that is not the page of its suite.
    pub page: Option<PathBuf>,
    /// A picture of it.
    pub picture: Option<PathBuf>,
    /// Whether another case of the suite has the same result in more detail.
    pub is_repeated: bool,
}

/// Whether an answer is the expected one.
#[derive(Clone, Debug, Default)]
pub enum CaseResult {
    /// It is.
    #[default]
    Passed,
    /// Nothing was expected, or nothing was found, and why.
    Skipped(String),
    /// There is none, because of an error.
    Error(String),
    /// It is not.
    Failed {
        /// What went wrong, in one line.
        message: String,
        /// Details, line by line; may be empty.
        details: String,
    },
}

/// A step on the way to a result.
#[derive(Clone, Debug)]
pub struct TrailStep {
    /// What happened.
    pub words: String,
    /// Where that which did it is written.
    pub place: Option<FilePlace>,
}

/// Something that was found in a file.
#[derive(Clone, Debug)]
pub struct FileFinding {
    /// Its kind.
    pub kind: FindingKind,
    /// What it is, in one sentence without a full stop.
    pub message: String,
    /// What would be accepted, or what to do.
    pub help: Option<String>,
    /// Where; none if it is about no file, such as an argument.
    pub place: Option<FilePlace>,
}

/// What kind of thing was found in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FindingKind {
    /// Something is wrong: the file is refused.
    Error,
    /// Something looks wrong.
    Warning,
    /// No explored run reaches it.
    Unreached,
    /// How often a property is violated in many runs.
    Rate,
}

/// Where the subjects of results are written.
#[derive(Clone, Debug, Default)]
pub struct WrittenPlaces {
    /// The file that names everything else.
    pub file: Option<FilePlace>,
    /// Properties, by name.
    pub properties: BTreeMap<String, FilePlace>,
    /// The leaf or machine that is a process, by its name.
    pub processes: BTreeMap<String, FilePlace>,
}

impl WrittenPlaces {
    /// The same with paths, as in [`Suite::with_paths`].
    #[must_use]
    pub fn with_paths(mut self, path: impl Fn(&str) -> Option<String>) -> Self {
        let places = self.file.iter_mut().chain(self.properties.values_mut()).chain(self.processes.values_mut());
        places.for_each(|place| place.find(&path));
        self
    }
}

impl CaseResult {
    /// It in a word.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Skipped(_) => "skipped",
            Self::Error(_) => "error",
            Self::Failed { .. } => "failed",
        }
    }

    /// Whether something went wrong.
    #[must_use]
    pub fn is_bad(&self) -> bool {
        matches!(self, Self::Error(_) | Self::Failed { .. })
    }

    /// What is wrong with a verdict, with all that its monitor reports.
    #[must_use]
    pub fn failed(message: String, monitor: &MonitorReport) -> Self {
        Self::Failed { message, details: details(monitor) }
    }

    /// Why it is so, in a line; none if it passed.
    #[must_use]
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Passed => None,
            Self::Skipped(reason) | Self::Error(reason) | Self::Failed { message: reason, .. } => Some(reason),
        }
    }
}

impl Case {
    /// The verdict of a property in a run: see [`Suite::of_run`].
    #[must_use]
    pub fn of_property(monitor: &MonitorReport, expected: &Expected, places: &WrittenPlaces) -> Self {
        let failed = |message: String| CaseResult::failed(message, monitor);
        let is_as_expected = expected.admits(&monitor.name, monitor.verdict);
        let why = monitor.unsure.as_deref().unwrap_or_default();
        let result = match (monitor.found(), expected.of(&monitor.name)) {
            (ShownVerdict::Groundless, _) => CaseResult::Error(format!("{} has no verdict: {why}", monitor.name)),
            (ShownVerdict::Unsure, _) => match expected.is_open(&monitor.name) {
                true => CaseResult::Skipped(format!("it is unsure, and nothing is expected of it: {why}")),
                false => failed(format!("{} is unsure: {why}", monitor.name)),
            },
            (ShownVerdict::Of(_), Some(_)) if is_as_expected => CaseResult::Passed,
            (ShownVerdict::Of(found), Some(expected)) => {
                failed(format!("{} was expected to be {expected} and is {found}", monitor.name))
            }
            (ShownVerdict::Of(Outcome::Violated), None) if is_as_expected => {
                CaseResult::Skipped("it is violated, and nothing is expected of it".to_owned())
            }
            (ShownVerdict::Of(Outcome::Violated), None) => failed(format!("{} is violated", monitor.name)),
            (ShownVerdict::Of(Outcome::Inconclusive), None) => {
                CaseResult::Skipped("something was still pending when the run ended".to_owned())
            }
            (ShownVerdict::Of(Outcome::Satisfied), None) => {
                match monitor.unsure.iter().chain(&monitor.vacuous).chain(&monitor.unheard).next() {
                    Some(open) => CaseResult::Skipped(open.clone()),
                    None => CaseResult::Passed,
                }
            }
        };
        let trail = |witness: &WitnessReport| {
            let why = witness.why.as_ref()?;
            Some(trail(&monitor.name, why, witness.knows_ticks, places))
        };
        Self {
            group: "properties",
            name: monitor.name.clone(),
            result,
            found: monitor.found().to_string(),
            about: monitor.property.clone(),
            place: places.properties.get(&monitor.name).cloned(),
            trail: monitor.witness.as_ref().and_then(trail).unwrap_or_default(),
            story: monitor.story.clone(),
            ..Self::default()
        }
    }

    /// A property that was not judged, and why.
    #[must_use]
    pub fn not_judged(name: &str, why: &str, places: &WrittenPlaces) -> Self {
        Self {
            group: "properties",
            name: name.to_owned(),
            result: CaseResult::Skipped(format!("not judged: {why}")),
            place: places.properties.get(name).cloned(),
            ..Self::default()
        }
    }
}

impl Suite {
    /// Something that could not be carried out, with the reason.
    #[must_use]
    pub fn of_error(name: &str, reason: String) -> Self {
        let case = Case { group: "runs", name: name.to_owned(), result: CaseResult::Error(reason), ..Case::default() };
        Self { name: name.to_owned(), cases: vec![case], ..Self::default() }
    }

    /// The properties and expectations of a run. Its page and pictures are in `folder`.
    ///
    /// A property with an expectation passes if it is met; any other property fails if it is violated. One whose
    /// verdict is unsure fails, whatever is expected. (One that is only a question is skipped.) A property is skipped
    /// if it is inconclusive, or satisfied only because a condition in it never occurred, because no message carried a
    /// level, or unless a message was lost. No case fails if and only if the run was as expected.
    #[must_use]
    pub fn of_run(expected: &Expected, report: &Report, folder: &Path, places: &WrittenPlaces) -> Self {
        let properties = report.monitors.iter().map(|monitor| Case {
            picture: picture_of(&monitor.name, report).map(|file| folder.join(file)),
            ..Case::of_property(monitor, expected, places)
        });
        // The monitors were off.
        let is_judged = |name: &String| report.monitors.iter().any(|monitor| monitor.name == *name);
        let unjudged = expected.outcomes.iter().map(|(name, _)| name).filter(|name| !is_judged(name));
        let unjudged = unjudged.map(|name| Case::not_judged(name, "monitors were off", places));
        let others = report.snapshots.iter().filter(|picture| picture.violated.is_none() && !picture.by_clock);
        Self {
            name: report.scenario.clone(),
            provenance: Some(report.provenance.clone()),
            facts: vec![
                ("seed", report.seed.to_string()),
                ("sim_time_s", report.sim_time_s.to_string()),
                ("ticks", report.ticks.to_string()),
                ("trace_hash", report.trace_hash.clone()),
                ("ended", report.ended_because.clone()),
            ],
            notes: open_questions(report),
            cases: properties.chain(unjudged).chain(report.expectations.iter().map(of_expectation)).collect(),
            findings: Vec::new(),
            file: places.file.clone(),
            page: Some(folder.join(html::FILE)),
            pictures: others.map(|picture| (folder.join(&picture.file), picture.why.clone())).collect(),
        }
    }

    /// The same with the paths of its files instead of their names in diagnostics, which may be relative to the file
    /// that names them; those for which `path` has none come with the program.
    #[must_use]
    pub fn with_paths(mut self, path: impl Fn(&str) -> Option<String>) -> Self {
        let trails = self
            .cases
            .iter_mut()
            .flat_map(|case| case.trail.iter_mut().filter_map(|step| step.place.as_mut()).chain(&mut case.place));
        let findings = self.findings.iter_mut().filter_map(|finding| finding.place.as_mut());
        trails.chain(findings).chain(&mut self.file).for_each(|place| place.find(&path));
        for input in self.provenance.iter_mut().flat_map(|made| &mut made.inputs).filter(|input| !input.shipped) {
            input.path = path(&input.path).unwrap_or_else(|| std::mem::take(&mut input.path));
        }
        self
    }

    /// Everything that is known of it: version, commit and settings come first.
    pub(crate) fn all_facts(&self) -> Vec<(&'static str, String)> {
        let made = self.provenance.clone().unwrap_or_else(|| Provenance::of_files(Vec::new()));
        made.facts().into_iter().chain(self.facts.iter().cloned()).collect()
    }

    /// The files that it was made from.
    pub(crate) fn inputs(&self) -> &[InputFile] {
        self.provenance.as_ref().map_or(&[], |made| &made.inputs)
    }

    /// Whether the findings list what its cases only count: what is wrong in files.
    #[must_use]
    pub(crate) fn is_about_files(&self) -> bool {
        self.findings.iter().any(|finding| finding.kind == FindingKind::Error)
    }
}

impl FileFinding {
    /// The same with the path of its file, as in [`Suite::with_paths`].
    #[must_use]
    pub fn with_path(mut self, path: impl Fn(&str) -> Option<String>) -> Self {
        if let Some(place) = &mut self.place {
            place.find(path);
        }
        self
    }

    /// It on one line: `a.toml:2:1: message (help)`.
    #[must_use]
    pub fn one_line(&self) -> String {
        let place = self.place.as_ref().map_or_else(String::new, |place| format!("{place}: "));
        let help = self.help.as_ref().map_or_else(String::new, |help| format!(" ({help})"));
        format!("{place}{}{help}", self.message)
    }
}

/// The steps that led to a violation. `knows_ticks` is whether it is known when the tree was ticked.
#[must_use]
pub fn trail(property: &str, witness: &Witness, knows_ticks: bool, places: &WrittenPlaces) -> Vec<TrailStep> {
    let message = |seen: &Sighting| TrailStep {
        words: if knows_ticks { seen.to_string() } else { format!("{seen:#}") },
        place: places.processes.get(&seen.from).or_else(|| places.processes.get(&seen.to)).cloned(),
    };
    let missing = witness.missing.as_ref().map_or_else(String::new, |missing| format!(", without {missing}"));
    let settled = &witness.settled;
    let when = if knows_ticks { settled.to_string() } else { format!("{settled:#}") };
    let end = TrailStep {
        words: format!("{property} is violated{missing} ({when})"),
        place: places.properties.get(property).cloned(),
    };
    witness.messages.iter().map(message).chain([end]).collect()
}

/// What the results of a run leave open.
fn open_questions(report: &Report) -> Vec<String> {
    let unjudged = report.monitors.is_empty().then(|| "no property was judged".to_owned());
    let unexpected = report.expectations.is_empty().then(|| "nothing was expected".to_owned());
    let undone = report.undone_faults.iter().map(|fault| format!("not done: {} ({})", fault.effect, fault.reason));
    let absent = report.absent_effects().into_iter().map(|effect| format!("never came: {effect}"));
    let of_monitor = |monitor: &MonitorReport| {
        let open = monitor.unsure.iter().chain(&monitor.open).chain(&monitor.vacuous).chain(&monitor.unheard).cloned();
        let silent = monitor.silent.iter().map(|channel| format!("no message {channel} in the whole run"));
        let assumed = monitor.assumptions.iter().map(|what| format!("it is assumed that {what}"));
        open.chain(silent).chain(assumed).map(|words| format!("{}: {words}", monitor.name)).collect::<Vec<_>>()
    };
    let lost = report.lost.iter().chain(&report.remarks).cloned();
    let of_monitors = report.monitors.iter().flat_map(of_monitor);
    unjudged.into_iter().chain(unexpected).chain(undone).chain(absent).chain(lost).chain(of_monitors).collect()
}

/// The picture of a property's violation.
fn picture_of<'r>(property: &str, report: &'r Report) -> Option<&'r str> {
    let is_of = |violated: &Option<String>| violated.as_deref() == Some(property);
    report.snapshots.iter().find(|picture| is_of(&picture.violated)).map(|picture| picture.file.as_str())
}

fn of_expectation(expectation: &ExpectationReport) -> Case {
    let failed = |message: &String| CaseResult::Failed { message: message.clone(), details: String::new() };
    let result = expectation.difference.as_ref().map_or(CaseResult::Passed, failed);
    let (name, is_repeated) = (expectation.expected.clone(), expectation.is_of_verdict);
    Case { group: "expectations", name, result, is_repeated, ..Case::default() }
}

/// When and why it happened, for readers of a build log.
fn details(monitor: &MonitorReport) -> String {
    let mut details = format!("{}\nmonitor in state {}", monitor.property, monitor.state);
    details.extend(monitor.moment().map(|moment| format!("\nat {moment}")));
    details.extend(monitor.witness.as_ref().map(|witness| format!("\n{}", witness.in_words().trim_end())));
    details
}
