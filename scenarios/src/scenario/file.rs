//! The scenario file, read and checked.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use components::StopRule;
use diagnostics::document::{Document, Table};
use diagnostics::{FileProblems, Source, Span, Spanned, nearest_or_all};
use monitors::Outcome;
use recording::{Expected, SnapshotOccasion, Snapshots};

use super::base::Base;
use super::component_entry::{ComponentEntry, read_components};
use super::find::Found;
use super::leaves::{LeafEntry, read_leaves};
use super::model_entry::ModelEntry;
use super::premises::PremisesEntry;
use super::prove::ProveEntry;
use super::ready_made::ReadyMade;
use super::robot::STEP;
use super::stop::Stop;
use crate::faults::Fault;
use crate::files::{Files, named};

/// A scenario file, read and checked as far as possible without the files that it names.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    /// The subject of the scenario, on one line.
    pub about: String,
    /// The default of the root seed.
    pub seed: u64,
    /// The folder in which the other files are looked up first, if it is not the scenario's own.
    pub folder: Option<Spanned<PathBuf>>,
    /// The map and the robot on it; without one, tree, skills and components run alone.
    pub premises: Option<PremisesEntry>,
    /// Where tree and machines come from.
    pub behavior: BehaviorEntry,
    /// Leaves whose machines are in other files, or start with other data.
    pub leaves: Vec<LeafEntry>,
    /// Components from files.
    pub components: Vec<ComponentEntry>,
    /// The property files; all their properties are monitored.
    pub properties: Vec<Spanned<PathBuf>>,
    /// Where the property files are set: in the file, in a base or on the command line.
    properties_said: Option<Span>,
    /// The scenario's own file, its base, the base of that, and so on.
    sources: Vec<String>,
    /// The folders to which the paths of its bases are relative.
    pub(super) base_folders: Vec<PathBuf>,
    /// The ready-made monitors.
    pub monitors: Vec<ReadyMade>,
    /// How tree, skills and components are run.
    pub execution: Execution,
    /// The faults.
    pub faults: Vec<Arc<Fault>>,
    /// When the run ends.
    pub stop: Stop,
    /// When pictures are taken.
    pub snapshots: Snapshots,
    /// The expected results of the run.
    pub expect: Expectations,
    /// The assumptions and questions of a proof.
    pub prove: ProveEntry,
}

/// Where the tree and the machines of a scenario come from.
#[derive(Clone, Debug)]
pub enum BehaviorEntry {
    /// Files of its own.
    Files(BehaviorFiles),
    /// A RoAML model, which has its own tree, skills and components.
    Model(ModelEntry),
}

/// The files of a scenario's tree and of its leaves.
#[derive(Clone, Debug)]
pub struct BehaviorFiles {
    /// The file with the behavior tree.
    pub tree: Spanned<PathBuf>,
    /// The folder with the machines of the tree's leaves: `<Leaf>.scxml`.
    pub skills: Spanned<PathBuf>,
}

impl BehaviorEntry {
    /// The file to begin with: that of the tree, or of the model.
    #[must_use]
    pub fn main_file(&self) -> &Spanned<PathBuf> {
        match self {
            Self::Files(files) => &files.tree,
            Self::Model(model) => &model.path,
        }
    }

    /// The model, if it is one.
    #[must_use]
    pub fn model(&self) -> Option<&ModelEntry> {
        match self {
            Self::Files(_) => None,
            Self::Model(model) => Some(model),
        }
    }

    /// The files, if it is no model.
    #[must_use]
    pub fn files(&self) -> Option<&BehaviorFiles> {
        match self {
            Self::Files(files) => Some(files),
            Self::Model(_) => None,
        }
    }
}

/// The form of the tree's process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeForm {
    /// One process for the whole tree.
    Whole,
    /// One process per node, with handshakes, as in the paper.
    Nodes,
}

/// The scheduling policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// Each enabled transition is equally likely.
    Random,
    /// Each process takes its turn.
    RoundRobin,
}

/// An order among messages, as in [`channels::Precedence`]: two events in the SCOPE language.
#[derive(Clone, Debug)]
pub struct Order {
    /// What comes first.
    pub first: Spanned<String>,
    /// The message that waits for it.
    pub then: Spanned<String>,
}

/// How tree, skills and components are run.
#[derive(Clone, Debug)]
pub struct Execution {
    /// Time between ticks.
    pub tick: Duration,
    /// The file with the schedule that runs follow, if they follow one.
    pub schedule: Option<Spanned<PathBuf>>,
    /// The scheduling policy.
    pub policy: Policy,
    /// This process moves only when no other can.
    pub starved: Option<Spanned<String>>,
    /// Orders among messages that the scheduler must enforce.
    pub orders: Vec<Order>,
    /// The effect of a stop request to Navigation.
    pub stops: StopRule,
    /// The form of the tree's process.
    pub tree: TreeForm,
    /// How long the tree waits for a leaf's answer.
    pub leaf_timeout: Duration,
    /// The latest time at which the run ends.
    pub max_time: Duration,
    /// The maximum number of transitions of the system in one step of the simulation. Beyond it, the system is
    /// considered never to become quiet.
    pub step_budget: u64,
    /// The maximum number of communications in a run.
    pub run_budget: u64,
}

/// The expected results of a run.
#[derive(Clone, Debug, Default)]
pub struct Expectations {
    /// The expected outcome of each property.
    pub outcomes: Vec<(Spanned<String>, Outcome)>,
    /// Places that must have been reached.
    pub reached: Vec<Spanned<String>>,
    /// Places that must not have been reached.
    pub not_reached: Vec<Spanned<String>>,
    /// Components whose program must fail; no other program may.
    pub failed_programs: Vec<Spanned<String>>,
    /// The maximum number of collisions.
    pub max_collisions: Option<u64>,
    /// The minimum charge of the battery, in percent.
    pub min_battery_pct: Option<f64>,
    /// The maximum error of localization, in meters.
    pub max_localization_m: Option<f64>,
}

impl Expectations {
    /// Their record.
    pub fn record(&self) -> Expected {
        let names = |names: &[Spanned<String>]| names.iter().map(|name| name.value.clone()).collect();
        Expected {
            outcomes: self.outcomes.iter().map(|(name, outcome)| (name.value.clone(), *outcome)).collect(),
            reached: names(&self.reached),
            not_reached: names(&self.not_reached),
            failed_programs: names(&self.failed_programs),
            max_collisions: self.max_collisions,
            min_battery_pct: self.min_battery_pct,
            max_localization_m: self.max_localization_m,
        }
    }
}

impl ScenarioFile {
    /// Reads a scenario. `name` is the file's name in diagnostics; `overrides` are assignments as for `--set`. Missing
    /// keys are inherited from the scenario that it names as its `base`, which is looked up in `files`.
    ///
    /// # Errors
    /// Everything that is wrong with the text, its base or the overrides.
    pub fn parse<'a>(
        name: &str,
        text: &str,
        files: &Files,
        overrides: impl IntoIterator<Item = &'a str>,
    ) -> Result<Self, FileProblems> {
        let (document, bases) = document(name, text, files, overrides)?;
        let mut file = document.read(read_file)?;
        let of_bases = bases.iter().map(|base| base.name().to_owned());
        file.sources = std::iter::once(name.to_owned()).chain(of_bases).collect();
        file.base_folders = bases.iter().map(|base| base.folder().to_owned()).collect();
        Ok(file)
    }

    /// The values of those of these top-level keys that the scenario has, including what it inherits and `overrides` as
    /// for `--set`.
    ///
    /// # Errors
    /// Syntax errors in the text, its bases or the overrides.
    pub fn values<'k>(
        found: &Found,
        overrides: &[String],
        keys: impl IntoIterator<Item = &'k str>,
    ) -> Result<toml::Table, FileProblems> {
        let (document, _) = document(&found.path, &found.text, &found.files, overrides.iter().map(String::as_str))?;
        Ok(keys.into_iter().filter_map(|key| Some((key.to_owned(), document.value(key)?))).collect())
    }
}

/// A scenario's text with everything that it inherits and with `overrides`, and the files from which it inherits.
fn document<'a>(
    name: &str,
    text: &str,
    files: &Files,
    overrides: impl IntoIterator<Item = &'a str>,
) -> Result<(Document, Vec<Source>), FileProblems> {
    let overrides: Vec<&str> = overrides.into_iter().collect();
    let mut document = Document::parse_toml(name, text)?;
    // Inherited keys can be overridden only after the base is read; the base itself only before.
    let sets_base = |set: &&str| set.split_once('=').is_some_and(|(key, _)| key.trim() == "base");
    document.override_with(overrides.iter().copied().filter(sets_base))?;
    let bases = Base::all(&document, files)?;
    let (sources, documents): (Vec<Source>, Vec<Document>) =
        bases.into_iter().map(|base| (base.source, base.document)).unzip();
    let inherited = documents.into_iter().rev().reduce(|base, mut document| {
        document.inherit(base);
        document
    });
    if let Some(inherited) = inherited {
        document.inherit(inherited);
    }
    document.override_with(overrides)?;
    Ok((document, sources))
}

impl ScenarioFile {
    /// Whether an expectation applies to this property. A file's settings for its own properties do not apply if a
    /// scenario based on it names other property files, since the properties may be gone.
    pub fn means(&self, property: &Spanned<String>) -> bool {
        // How far away a value is set: on the command line, in the scenario itself, in its base, in the base of that.
        let distance =
            |span: &Span| self.sources.iter().position(|file| file == span.source().name()).map_or(0, |at| at + 1);
        self.properties_said.as_ref().is_none_or(|said| distance(&property.span) <= distance(said))
    }

    /// The files from which a scenario inherits: its base, the base of that, and so on.
    ///
    /// # Errors
    /// The problems of one of them.
    pub fn bases(found: &Found) -> Result<Vec<PathBuf>, FileProblems> {
        let bases = Base::all(&Document::parse_toml(&found.path, &found.text)?, &found.files)?;
        Ok(bases.into_iter().map(|base| base.path).collect())
    }
}

fn read_file(root: Table<'_>) -> Option<ScenarioFile> {
    let _ = root.text("base").optional();
    let path = |key| root.text(key).try_map(|path, span| Ok(named(path, span))).spanned().required();
    let about = root.text("about").or(String::new());
    let seed = root.get::<u64>("seed").or(1);
    let folder = root.text("folder").map(PathBuf::from).spanned().optional();
    let premises = PremisesEntry::read(root);
    let behavior = match ModelEntry::read(root) {
        Some(model) => Some(BehaviorEntry::Model(model)),
        None => {
            let (tree, skills) = (path("tree"), path("skills"));
            tree.zip(skills).map(|(tree, skills)| BehaviorEntry::Files(BehaviorFiles { tree, skills }))
        }
    };
    let properties = root.get::<Vec<Spanned<String>>>("properties").spanned().optional();
    let (properties, said) = properties.map_or_else(Default::default, |said| (said.value, Some(said.span)));
    let properties = properties.into_iter().map(|Spanned { value, span }| Spanned { value: named(value, &span), span });
    let monitors = root.tables("monitors").each(ReadyMade::read).or(Vec::new());
    let leaves = root.table("leaves").optional().map_or_else(Vec::new, read_leaves);
    let components = root.table("components").optional().map_or_else(Vec::new, read_components);
    let execution = read_execution(root);
    let faults = root.tables("faults").each(|table| Fault::read(table).map(Arc::new)).or(Vec::new());
    let schedule = execution.as_ref().and_then(|execution| execution.schedule.as_ref());
    if let (Some(schedule), false) = (schedule, faults.is_empty()) {
        let problem = schedule.span.problem("a run that follows a schedule has no faults, but this scenario has some");
        let help = "remove them: `faults = []`; a schedule itself determines which messages are lost";
        root.report(problem.with_label("this schedule").with_help(help));
    }
    if matches!(premises, Ok(None)) {
        PremisesEntry::report_missing(root, &faults);
    }
    let stop = root.table("stop").optional().map_or_else(Stop::default, Stop::read);
    let snapshots = root.table("snapshots").optional().map_or_else(Snapshots::default, read_snapshots);
    let expect = root.table("expect").optional().map_or_else(|| Some(Expectations::default()), read_expectations);
    let prove = root.table("prove").optional().map_or_else(|| Some(ProveEntry::default()), ProveEntry::read);
    Some(ScenarioFile {
        about,
        seed,
        folder,
        premises: premises.ok()?,
        behavior: behavior?,
        leaves,
        components,
        properties: properties.collect(),
        properties_said: said,
        sources: Vec::new(),
        base_folders: Vec::new(),
        monitors,
        execution: execution?,
        faults,
        stop,
        snapshots,
        expect: expect?,
        prove: prove?,
    })
}

fn read_execution(root: Table<'_>) -> Option<Execution> {
    let mut execution = Execution {
        tick: Duration::from_secs(1),
        schedule: None,
        policy: Policy::Random,
        starved: None,
        orders: Vec::new(),
        stops: StopRule::OwnTrip,
        tree: TreeForm::Whole,
        leaf_timeout: bt::LEAF_TIMEOUT,
        max_time: Duration::from_secs(3600),
        step_budget: 100_000,
        run_budget: 10_000_000,
    };
    let Some(table) = root.table("execution").optional() else { return Some(execution) };
    execution.tick = table.seconds("tick_s").check(|tick| *tick >= STEP, "be at least 0.02").or(execution.tick);
    let schedule = table.text("schedule").try_map(|path, span| Ok(named(path, span))).spanned();
    execution.schedule = schedule.optional();
    let leaf_timeout = table.seconds("leaf_timeout_s").check(|time| !time.is_zero(), "be above 0");
    execution.leaf_timeout = leaf_timeout.or(execution.leaf_timeout);
    execution.max_time = table.seconds("max_time_s").check(|time| !time.is_zero(), "be above 0").or(execution.max_time);
    execution.step_budget = table.get::<u64>("step_budget").within(1..=u64::MAX).or(execution.step_budget);
    execution.run_budget = table.get::<u64>("run_budget").within(1..=u64::MAX).or(execution.run_budget);
    execution.tree = table.one_of("tree", &[("whole", TreeForm::Whole), ("nodes", TreeForm::Nodes)]).or(execution.tree);
    let policies = [("random", Policy::Random), ("round-robin", Policy::RoundRobin)];
    execution.policy = table.one_of("policy", &policies).or(Policy::Random);
    let rules = [("own-trip", StopRule::OwnTrip), ("any-trip", StopRule::AnyTrip)];
    execution.stops = table.one_of("stops", &rules).or(StopRule::OwnTrip);
    execution.starved = table.text("starve").spanned().optional();
    execution.orders = table.tables("order").each(read_order).or(Vec::new());
    Some(execution)
}

fn read_order(table: Table<'_>) -> Option<Order> {
    let event = |key| table.text(key).spanned().required();
    let (first, then) = (event("first"), event("then"));
    Some(Order { first: first?, then: then? })
}

fn read_snapshots(table: Table<'_>) -> Snapshots {
    const MOMENTS: [(&str, SnapshotOccasion); 5] = [
        ("start", SnapshotOccasion::Start),
        ("fault", SnapshotOccasion::Fault),
        ("verdict", SnapshotOccasion::Verdict),
        ("arrival", SnapshotOccasion::Arrival),
        ("end", SnapshotOccasion::End),
    ];
    let at = table.get::<Vec<Spanned<String>>>("at").try_map(|names, _| {
        let moment = |name: Spanned<String>| {
            let found = MOMENTS.iter().find(|(known, _)| *known == name.value).map(|(_, moment)| *moment);
            found.ok_or_else(|| {
                let problem = name.span.problem(format!("unknown moment `{}`", name.value));
                let help = nearest_or_all(&name.value, "the moments", &MOMENTS.map(|(known, _)| known));
                problem.with_label("no such moment").with_help(help)
            })
        };
        names.into_iter().map(moment).collect::<Result<Vec<_>, _>>()
    });
    let every = table.seconds("every_s").check(|every| *every >= STEP, "be at least 0.02");
    Snapshots { at: at.or(Vec::new()), at_times: table.get("at_s").or(Vec::new()), every: every.optional() }
}

fn read_expectations(table: Table<'_>) -> Option<Expectations> {
    let outcomes = Outcome::ALL.map(|outcome| (outcome.name(), outcome));
    let mut expect = Expectations {
        reached: table.get("reached").or(Vec::new()),
        not_reached: table.get("not_reached").or(Vec::new()),
        failed_programs: table.get("failed_programs").or(Vec::new()),
        max_collisions: table.get("max_collisions").optional(),
        min_battery_pct: table.number("min_battery_pct").within(0.0..=100.0).optional(),
        max_localization_m: table.number("max_localization_m").within(0.0..=1e6).optional(),
        outcomes: Vec::new(),
    };
    let known =
        ["reached", "not_reached", "failed_programs", "max_collisions", "min_battery_pct", "max_localization_m"];
    let properties = table.keys().filter(|(key, _)| !known.contains(key));
    for (property, span) in properties {
        let outcome = table.one_of(property, &outcomes).required();
        let name = Spanned { value: property.to_owned(), span: span.clone() };
        expect.outcomes.extend(outcome.map(|outcome| (name, outcome)));
    }
    Some(expect)
}
