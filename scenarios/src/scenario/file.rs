//! The scenario file: what a user writes, read and checked.

use std::path::PathBuf;
use std::time::Duration;

use maps::document::{Document, Table};
use maps::{FileProblems, Spanned};
use monitors::Outcome;
use sim::{DriftNoise, SimConfig};

/// A scenario file, read and checked as far as it can be without the files that it names.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    /// What the scenario shows, in a line.
    pub about: String,
    /// The root seed where the command line gives none.
    pub seed: u64,
    /// The map's YAML file.
    pub map: Spanned<PathBuf>,
    /// The places file.
    pub places: Spanned<PathBuf>,
    /// The behavior tree.
    pub tree: Spanned<PathBuf>,
    /// The folder that holds a machine for each leaf of the tree: `<Leaf>.scxml`.
    pub skills: Spanned<PathBuf>,
    /// The property files; all their properties are watched.
    pub properties: Vec<Spanned<PathBuf>>,
    /// The places that the scenario needs.
    pub sites: Sites,
    /// The simulated robot and its world.
    pub sim: SimConfig,
    /// How tree, skills and components are run.
    pub execution: Execution,
    /// What goes wrong, and when.
    pub faults: Vec<Fault>,
    /// When the run ends.
    pub stop: Stop,
    /// When pictures are taken.
    pub snapshots: Moments,
    /// What the run must come to.
    pub expect: Expectations,
}

/// The names of the places that a scenario needs.
#[derive(Clone, Debug)]
pub struct Sites {
    /// Where the robot starts: a point.
    pub start: Spanned<String>,
    /// Where the charging station stands: a point.
    pub station: Spanned<String>,
    /// Where the robot is sent, for pictures.
    pub destination: Spanned<String>,
}

/// How the tree's process is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeForm {
    /// One process for the whole tree.
    Whole,
    /// A process for each node, with handshakes, as in the paper.
    Nodes,
}

/// Who chooses among the enabled transitions.
#[derive(Clone, Debug)]
pub enum Policy {
    /// Each is as likely as the others.
    Random,
    /// Each process in its turn.
    RoundRobin,
    /// At random, but this process moves only when no other can.
    Starve(Spanned<String>),
}

/// How tree, skills and components are run.
#[derive(Clone, Debug)]
pub struct Execution {
    /// Time between ticks.
    pub tick: Duration,
    /// Who chooses among the enabled transitions.
    pub policy: Policy,
    /// How the tree's process is made.
    pub tree: TreeForm,
    /// The run ends then, whatever has happened.
    pub max_time: Duration,
    /// How many transitions the system may take in one step of the simulation before it counts as never quiet.
    pub step_budget: u64,
}

/// Something that goes wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// When it takes hold.
    pub at: Duration,
    /// What it does.
    pub kind: FaultKind,
}

/// What a fault does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// The battery's charge is set to this level, in percent.
    BatteryLevel(f64),
}

impl FaultKind {
    /// The kind as scenario files and reports write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::BatteryLevel(_) => "battery_level",
        }
    }

    /// What the fault does, in words.
    #[must_use]
    pub fn effect(self) -> String {
        match self {
            Self::BatteryLevel(level_pct) => format!("battery level set to {level_pct} %"),
        }
    }
}

/// When a run ends, besides at its limit of time.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// When the robot has come to rest at this place.
    pub at: Option<Spanned<String>>,
    /// How long it goes on after that.
    pub after: Duration,
}

/// An occasion for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Moment {
    /// The first step.
    Start,
    /// A fault takes hold.
    Fault,
    /// A monitor gives its verdict.
    Verdict,
    /// The robot comes to rest at a place.
    Arrival,
    /// The last step.
    End,
}

/// When pictures are taken.
#[derive(Clone, Debug, Default)]
pub struct Moments {
    /// On these occasions.
    pub at: Vec<Moment>,
    /// At these times.
    pub at_times: Vec<Duration>,
    /// Every so often.
    pub every: Option<Duration>,
}

/// What a run must come to.
#[derive(Clone, Debug, Default)]
pub struct Expectations {
    /// What each property must turn out to be.
    pub outcomes: Vec<(Spanned<String>, Outcome)>,
    /// Places that must have been reached.
    pub reached: Vec<Spanned<String>>,
    /// How many collisions there may be.
    pub max_collisions: Option<u64>,
    /// What the battery must not have gone below, in percent.
    pub min_battery_pct: Option<f64>,
}

impl ScenarioFile {
    /// Reads a scenario; `name` is what diagnostics call it, `overrides` are assignments as `--set` takes them.
    ///
    /// # Errors
    /// Everything that is wrong with the text or the overrides.
    pub fn parse<'a>(
        name: &str,
        text: &str,
        overrides: impl IntoIterator<Item = &'a str>,
    ) -> Result<Self, FileProblems> {
        let mut document = Document::parse_toml(name, text)?;
        document.override_with(overrides)?;
        document.read(read_file)
    }
}

fn read_file(root: Table<'_>) -> Option<ScenarioFile> {
    let path = |key| root.text(key).map(PathBuf::from).spanned().required();
    let about = root.text("about").or(String::new());
    let seed = root.get::<u64>("seed").or(1);
    let (map, places, tree, skills) = (path("map"), path("places"), path("tree"), path("skills"));
    let properties = root.get::<Vec<Spanned<String>>>("properties").or(Vec::new());
    let properties = properties.into_iter().map(|Spanned { value, span }| Spanned { value: value.into(), span });
    let sites = root.table("sites").required().and_then(read_sites);
    let sim = read_sim(root);
    let execution = read_execution(root);
    let faults: Option<Vec<Fault>> = root.tables("faults").or(Vec::new()).into_iter().map(read_fault).collect();
    let stop = root.table("stop").optional().map_or_else(Stop::default, read_stop);
    let snapshots = root.table("snapshots").optional().map_or_else(Moments::default, read_moments);
    let expect = root.table("expect").optional().map_or_else(|| Some(Expectations::default()), read_expectations);
    Some(ScenarioFile {
        about,
        seed,
        map: map?,
        places: places?,
        tree: tree?,
        skills: skills?,
        properties: properties.collect(),
        sites: sites?,
        sim,
        execution: execution?,
        faults: faults?,
        stop,
        snapshots,
        expect: expect?,
    })
}

fn read_sites(table: Table<'_>) -> Option<Sites> {
    let site = |key| table.text(key).spanned().required();
    let (start, station, destination) = (site("start"), site("station"), site("destination"));
    Some(Sites { start: start?, station: station?, destination: destination? })
}

fn read_sim(root: Table<'_>) -> SimConfig {
    let mut sim = SimConfig::default();
    if let Some(battery) = root.table("battery").optional() {
        let defaults = sim.battery;
        let rate = |key, default| battery.number(key).within(0.0..=100.0).or(default);
        sim.battery.initial_pct = rate("initial_pct", defaults.initial_pct);
        sim.battery.drain_pct_per_s = rate("drain_pct_per_s", defaults.drain_pct_per_s);
        sim.battery.standstill_drain_pct_per_s =
            rate("standstill_drain_pct_per_s", defaults.standstill_drain_pct_per_s);
        sim.battery.charge_pct_per_s = rate("charge_pct_per_s", defaults.charge_pct_per_s);
    }
    if let Some(noise) = root.table("noise").optional() {
        sim.lasers.range_sigma_m = noise.number("laser_sigma_m").within(0.0..=1.0).or(0.0);
        sim.odometry.noise = noise.table("odometry").optional().map_or(DriftNoise::NONE, read_drift);
        sim.drive.noise = noise.table("motion").optional().map_or(DriftNoise::NONE, read_drift);
    }
    sim
}

fn read_drift(table: Table<'_>) -> DriftNoise {
    let sigma = |key| table.number(key).within(0.0..=1.0).or(0.0);
    DriftNoise {
        angle_per_sqrt_rad: sigma("angle_per_sqrt_rad"),
        angle_per_sqrt_m: sigma("angle_per_sqrt_m"),
        distance_per_sqrt_m: sigma("distance_per_sqrt_m"),
        distance_per_sqrt_rad: sigma("distance_per_sqrt_rad"),
    }
}

fn read_execution(root: Table<'_>) -> Option<Execution> {
    let mut execution = Execution {
        tick: Duration::from_secs(1),
        policy: Policy::Random,
        tree: TreeForm::Whole,
        max_time: Duration::from_secs(3600),
        step_budget: 100_000,
    };
    let Some(table) = root.table("execution").optional() else { return Some(execution) };
    execution.tick =
        table.seconds("tick_s").check(|tick| *tick >= Duration::from_millis(20), "be at least 0.02").or(execution.tick);
    execution.max_time = table.seconds("max_time_s").check(|time| !time.is_zero(), "be above 0").or(execution.max_time);
    execution.step_budget = table.get::<u64>("step_budget").within(1..=u64::MAX).or(execution.step_budget);
    execution.tree = table.one_of("tree", &[("whole", TreeForm::Whole), ("nodes", TreeForm::Nodes)]).or(execution.tree);
    let starve = table.text("starve").spanned();
    let policies = [("random", Policy::Random), ("round-robin", Policy::RoundRobin)];
    execution.policy = table.one_of("policy", &policies).or(Policy::Random);
    if let Some(victim) = starve.optional() {
        execution.policy = Policy::Starve(victim);
    }
    Some(execution)
}

fn read_fault(table: Table<'_>) -> Option<Fault> {
    let at = table.seconds("at_s").required();
    let kind = table.one_of("kind", &[("battery_level", ())]).required();
    let level = table.number("level_pct").within(0.0..=100.0).required();
    kind?;
    Some(Fault { at: at?, kind: FaultKind::BatteryLevel(level?) })
}

fn read_stop(table: Table<'_>) -> Stop {
    let at = table.text("at").spanned().optional();
    Stop { at, after: table.seconds("after_s").or(Duration::ZERO) }
}

fn read_moments(table: Table<'_>) -> Moments {
    const MOMENTS: [(&str, Moment); 5] = [
        ("start", Moment::Start),
        ("fault", Moment::Fault),
        ("verdict", Moment::Verdict),
        ("arrival", Moment::Arrival),
        ("end", Moment::End),
    ];
    let at = table.get::<Vec<Spanned<String>>>("at").try_map(|names, _| {
        let moment = |name: Spanned<String>| {
            let found = MOMENTS.iter().find(|(known, _)| *known == name.value).map(|(_, moment)| *moment);
            found.ok_or_else(|| {
                let problem = name.span.problem(format!("unknown moment `{}`", name.value));
                problem.with_help("one of `start`, `fault`, `verdict`, `arrival`, `end`")
            })
        };
        names.into_iter().map(moment).collect::<Result<Vec<_>, _>>()
    });
    let every = table.seconds("every_s").check(|every| *every >= Duration::from_millis(20), "be at least 0.02");
    Moments { at: at.or(Vec::new()), at_times: table.get("at_s").or(Vec::new()), every: every.optional() }
}

fn read_expectations(table: Table<'_>) -> Option<Expectations> {
    let outcomes = Outcome::ALL.map(|outcome| (outcome.name(), outcome));
    let mut expect = Expectations {
        reached: table.get("reached").or(Vec::new()),
        max_collisions: table.get("max_collisions").optional(),
        min_battery_pct: table.number("min_battery_pct").within(0.0..=100.0).optional(),
        outcomes: Vec::new(),
    };
    let known = ["reached", "max_collisions", "min_battery_pct"];
    let properties = table.keys().filter(|(key, _)| !known.contains(key));
    for (property, span) in properties {
        let outcome = table.one_of(property, &outcomes).required();
        let name = Spanned { value: property.to_owned(), span: span.clone() };
        expect.outcomes.extend(outcome.map(|outcome| (name, outcome)));
    }
    Some(expect)
}
