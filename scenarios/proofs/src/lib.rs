//! Proofs: every schedule of a scenario's tree, skills and components, and everything that may happen around them.
//!
//! A [`Proof`] is a scenario that is ready to be explored. Everything that the scenario's `[prove]` allows takes the
//! place of the drivers of the built-in components and of the world behind them. Its
//! [`assumptions`](Proof::assumptions) list this in words.
//!
//! # Inside
//! `subject` refuses scenarios that cannot be explored, and `questions` are the properties to be proved. `environment`
//! has the moves of everything around the processes: trips and a `battery`, whose `levels` are divided into classes at
//! the `thresholds` with which machines and monitors compare them. `faults` is an environment around that one, in which
//! components crash, hang or have mistakes. `concrete` gives a run that was found the levels of a possible battery, or
//! refines the classes. `replayed` follows it in the channel system, `written` writes it as a schedule with its
//! scenario, and `physics` simulates it. `coverage` notes what is never reached. `mutants` are scenarios with a
//! mistake, and `fates` determines which property detects which.

mod assumptions;
mod battery;
mod concrete;
mod coverage;
mod environment;
mod fates;
mod faults;
mod levels;
mod mutants;
mod physics;
mod questions;
mod replayed;
mod subject;
mod texts;
mod thresholds;
mod written;

use std::collections::BTreeSet;
use std::sync::Arc;

use bt::{Kind, Node};
use channels::{ChannelId, ChannelSystem, Monitor};
use components::{BATTERY_READER, BatteryReader, LOCALIZATION, Localization, NAVIGATION, Navigation};
use explorer::{
    Environment, Exploration, Limit, Limits, MessageFaults, Model, Onlooker, Outcome, Progress, Reduction, Refused,
    Ticks,
};
use recording::TREE;
use robot::Streams;
use runs::{Ids, Switched, wire};
use scenarios::names::unknown;
use scenarios::scenario::schedule::process_of;
use scenarios::scenario::{BatteryAssumption, Drained, Fact, Monitoring, Passes, ProofOutcome, Scenario, Truths};
use scenarios::{Complaints, Error};

pub use self::assumptions::Assumption;
use self::battery::{BatteryModel, Bounds};
use self::concrete::Concretized;
use self::coverage::Coverage;
pub use self::coverage::{Mistake, Unreachable, Unreached};
use self::environment::{RobotEnvironment, Trips};
pub use self::fates::{Fate, OpenProperty};
use self::faults::WithFaults;
use self::levels::{Micros, Rates, micros};
pub use self::mutants::Mutant;
pub use self::physics::Physical;
pub use self::questions::{Question, Subject};
pub use self::replayed::{ReplayedEvent, ReplayedRun};
pub use self::written::{COUNTEREXAMPLE, PHYSICS, SCHEDULE};

/// A scenario whose properties can be proved.
#[derive(Debug)]
pub struct Proof {
    scenario: Arc<Scenario>,
    system: ChannelSystem,
    ids: Ids,
    monitoring: Arc<Monitoring>,
    /// The levels with which its machines compare the battery's.
    thresholds: BTreeSet<Micros>,
    damaged: Vec<ChannelId>,
    faults: Vec<Switched>,
    questions: Vec<Question>,
    /// What the world shows to monitors, if a property is about it.
    truths: Option<Truths>,
    /// The properties that cannot be proved and that are not named, each with the reason.
    left_out: Vec<(String, String)>,
}

/// The result for a property.
#[derive(Debug)]
pub struct Answer {
    /// What was explored.
    pub model: Model,
    /// What was found. If a run violates a property, its levels are possible for a battery.
    pub exploration: Exploration,
    /// All searches that led to the answer.
    pub rounds: Vec<Round>,
    /// Whether no battery can have the levels of the run, however finely they are distinguished.
    pub is_spurious: bool,
    /// What never happens, if everything was explored without a property.
    pub unreached: Option<Vec<Unreached>>,
    /// The errors in the runs that the last search explored, each once.
    pub mistakes: Vec<Mistake>,
    subject: Subject,
}

/// A search for the answer. Another one follows if no battery can have the levels of the run that it found, with more
/// classes of levels; or if memory ran out, with fewer stored states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// Its number, from 1.
    pub number: usize,
    /// How many classes of the battery's levels it distinguishes.
    pub levels: Option<usize>,
    /// How far it got.
    pub progress: Progress,
}

impl Answer {
    /// The limit that kept it from being decided.
    #[must_use]
    pub fn limit(&self) -> Option<Limit> {
        match self.exploration.outcome {
            Outcome::Undecided(limit) => Some(limit),
            _ => None,
        }
    }

    /// The result as an outcome that can be expected; `None` if there is none.
    #[must_use]
    pub fn outcome(&self) -> Option<ProofOutcome> {
        let proved_if = |holds| if holds { ProofOutcome::Proved } else { ProofOutcome::Violated };
        match (self.subject, &self.exploration.outcome) {
            _ if self.is_spurious => None,
            (_, Outcome::Undecided(_)) => None,
            (Subject::AllReached, _) => self.unreached.as_ref().map(|unreached| proved_if(unreached.is_empty())),
            (Subject::Monitor(_), Outcome::Endless(_)) => None,
            (_, outcome) => Some(proved_if(matches!(outcome, Outcome::Proved))),
        }
    }
}

impl Proof {
    /// Prepares a scenario that was loaded by [`Scenario::load_for_proof`]. `only` names the properties to prove; if it
    /// is empty, they are those that the scenario names.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that prevents a proof.
    pub fn new(scenario: Arc<Scenario>, only: &[String]) -> Result<Self, Error> {
        subject::check(&scenario)?;
        let wired = wire(&scenario, &Streams::new(scenario.file.seed))?;
        let system = wired.system;
        let monitoring = scenario.monitoring(system.topology())?;
        let mut complaints = Complaints::default();
        subject::check_assumptions(&scenario, &mut complaints);
        let thresholds =
            if has_battery(&system) { thresholds::of_machines(&scenario, &mut complaints) } else { BTreeSet::new() };
        let damaged = damaged(&scenario, &system, &mut complaints);
        let faults = faults::of(&scenario, &system, &mut complaints);
        let truths = wired.truths;
        let questions = questions::of(&scenario, &monitoring, only, &mut complaints);
        complaints.check()?;
        let ids = wired.ids;
        let mut proof = Self {
            scenario,
            ids,
            monitoring,
            thresholds,
            damaged,
            faults,
            questions: Vec::new(),
            left_out: Vec::new(),
            truths,
            system,
        };
        if proof.ids.robot.is_some() {
            proof.battery(None)?;
        }
        // A search can take long: no property may be refused after that of another one.
        for question in questions {
            match proof.monitor(&question).map_or(Ok(()), |monitor| proof.check(monitor)) {
                Ok(()) => proof.questions.push(question),
                Err(error) if question.is_named => _ = complaints.take::<()>(Err(error)),
                Err(error) => {
                    let why = error.reasons().replace(&format!("the property {} ", question.property), "");
                    proof.left_out.push((question.property, why));
                }
            }
        }
        if proof.ids.robot.is_some() {
            for monitor in proof.questions.iter().filter_map(|question| proof.monitor(question)) {
                complaints.take(proof.battery(Some(monitor)));
            }
        }
        complaints.check()?;
        Ok(proof)
    }

    /// # Errors
    /// [`Error::BadInput`] with everything that prevents a proof of what a monitor requires.
    fn check(&self, monitor: &dyn Monitor) -> Result<(), Error> {
        let mut complaints = Complaints::default();
        complaints.note(subject::check_world(monitor, self.truths.as_ref(), has_battery(&self.system)));
        complaints.note(subject::check_time_limit(monitor));
        subject::check_numbers(&self.scenario, &self.system, monitor, &mut complaints);
        complaints.note(texts::check(&self.scenario, self.system.topology(), monitor));
        complaints.take(explorer::check(monitor).map_err(|error| self.refused(&error)));
        complaints.take(self.thresholds_for(Some(monitor)));
        complaints.check()
    }

    /// The properties to be proved.
    #[must_use]
    pub fn questions(&self) -> &[Question] {
        &self.questions
    }

    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// The assumptions.
    #[must_use]
    pub fn assumptions(&self) -> Vec<Assumption> {
        let mut all = assumptions::all(&self.scenario, &self.system, &self.faults);
        let asked = self.questions.iter().filter_map(|question| self.monitor(question));
        all.extend(asked.filter_map(|monitor| self.truths_for(Some(monitor))).next().map(|_| assumptions::received()));
        all.extend(assumptions::left_out(&self.left_out));
        all
    }

    /// An ordinary monitor of a property, at its start; `None` for those that have none.
    #[must_use]
    pub fn monitor(&self, question: &Question) -> Option<&dyn Monitor> {
        match question.subject {
            Subject::Monitor(monitor) => Some(self.monitoring.monitors()[monitor].1.as_ref()),
            Subject::Progress | Subject::AllReached => None,
        }
    }

    /// Explores everything until the property is decided. The limits hold for each search, but the limit of visits for
    /// all of them together.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the number of states has no bound, with the process that causes this.
    pub fn prove(
        &self,
        question: &Question,
        limits: &Limits,
        progress: &mut dyn FnMut(&Round),
    ) -> Result<Answer, Error> {
        let monitor = self.monitor(question);
        let mut battery = if self.ids.robot.is_some() { self.battery(monitor)? } else { None };
        let mut limits = limits.clone();
        let mut rounds: Vec<Round> = Vec::new();
        loop {
            let coverage = Arc::new(Coverage::new(self.scenario.tree(), &self.system));
            let model = self.model(monitor, battery.clone()).with_onlooker(Arc::clone(&coverage) as Arc<dyn Onlooker>);
            let levels = battery.as_ref().map(|battery| battery.levels.len());
            let first = rounds.len() + 1;
            let round = |progress: &Progress| {
                let is_second = limits.reduction == Reduction::WhenNeeded && progress.is_reduced;
                Round { number: first + usize::from(is_second), levels, progress: *progress }
            };
            let explored = explorer::explore(&model, monitor, &limits, &mut |now| progress(&round(now)));
            let mut exploration = explored.map_err(|error| self.refused(&error))?;
            rounds.extend(exploration.earlier.iter().chain([&exploration.progress]).map(round));
            let concretized = match (&mut exploration.outcome, &mut battery) {
                (Outcome::Violated(path), Some(BatteryModel { levels, bounds: Some(bounds), .. })) => {
                    let shown_as = self
                        .truths
                        .as_ref()
                        .and_then(|truths| truths.facts.iter().position(|fact| *fact == Fact::Level));
                    concrete::concretize(path, levels, bounds, shown_as)
                }
                _ => Concretized::Possible,
            };
            if concretized == Concretized::Refined {
                // The memory is free again, but the visits of all searches add up.
                let visited = exploration.earlier.map_or(0, |earlier| earlier.visited);
                limits.visits = limits.visits.saturating_sub(visited + exploration.progress.visited).max(1);
                continue;
            }
            let is_complete = !matches!(exploration.outcome, Outcome::Endless(_) | Outcome::Undecided(_));
            let unreached = (monitor.is_none() && is_complete).then(|| coverage.unreached());
            let is_spurious = concretized == Concretized::Spurious;
            let (mistakes, subject) = (coverage.mistakes(), question.subject);
            return Ok(Answer { model, exploration, rounds, is_spurious, unreached, mistakes, subject });
        }
    }

    fn model(&self, monitor: Option<&dyn Monitor>, battery: Option<BatteryModel>) -> Model {
        let environment = match self.ids.robot {
            Some(_) => self.environment(monitor, battery).erased(),
            None => explorer::Closed.erased(),
        };
        let execution = &self.scenario.file.execution;
        let ticks = self.ids.tree.map(|ids| Ticks {
            generator: ids.tick_generator,
            period: execution.tick,
            first: execution.step(),
            step: execution.step(),
        });
        // Faults act on drivers as well, so the environment with faults is around the one without.
        let mut system = self.system.fork();
        faults::prepare(&mut system, &self.faults);
        let environment = match self.faults.as_slice() {
            [] => environment,
            faults => WithFaults::new(environment, faults.to_vec(), self.scenario.file.prove.faults.count).erased(),
        };
        let model = Model::new(&system, ticks, environment);
        let messages = &self.scenario.file.prove.messages;
        let model = model.with_message_faults(MessageFaults {
            lost: messages.lose,
            repeated: messages.repeat,
            delayed: (messages.delay, messages.hold),
            channels: self.damaged.clone(),
        });
        if self.scenario.file.prove.drivers_anywhere { model.with_interleaved_drivers() } else { model }
    }

    /// What the world shows to a monitor that receives it.
    fn truths_for(&self, monitor: Option<&dyn Monitor>) -> Option<&Truths> {
        let truths = self.truths.as_ref()?;
        subject::watches(monitor?, truths.channel).then_some(truths)
    }

    fn environment(&self, monitor: Option<&dyn Monitor>, battery: Option<BatteryModel>) -> RobotEnvironment {
        let Self { scenario, system, .. } = self;
        let prove = &scenario.file.prove;
        let truths = self.truths_for(monitor);
        let ground = subject::ground(scenario, system, truths);
        let spot = |name: &str| ground.places.iter().position(|place| place == name);
        let passes = match &prove.trips.passes {
            Passes::Any => (0..ground.places.len()).collect(),
            Passes::These(names) => names.iter().filter_map(|name| spot(&name.value)).collect(),
        };
        let trips = Trips {
            process: process_of::<Navigation>(system, NAVIGATION),
            ticks: prove.trips.ticks.map(|ticks| i64::try_from(ticks).unwrap_or(i64::MAX)),
            may_fail: prove.trips.fail,
            passes,
        };
        let localization = process_of::<Localization>(system, LOCALIZATION);
        RobotEnvironment::new(battery, localization, trips, ground).with_world(truths.cloned())
    }

    /// The battery, if there is one, with levels divided as finely as the machines and the monitor distinguish them.
    fn battery(&self, monitor: Option<&dyn Monitor>) -> Result<Option<BatteryModel>, Error> {
        let Some(process) = process_of::<BatteryReader>(&self.system, BATTERY_READER) else { return Ok(None) };
        let thresholds = self.thresholds_for(monitor)?;
        let many = "the compared levels and the drain give too many classes of levels";
        let drained = match &self.scenario.file.prove.battery {
            BatteryAssumption::Free => {
                let battery = BatteryModel::free(process, &thresholds);
                return battery.map(Some).ok_or_else(|| Error::refused(many, "compare levels with fewer constants"));
            }
            BatteryAssumption::Drained(drained) => drained,
        };
        let battery = BatteryModel::bounded(process, &thresholds, self.bounds(drained)?);
        battery.map(Some).ok_or_else(|| {
            let problem = drained.place.problem(many).with_label("this battery");
            Error::bad_input(problem.with_help("make the drain or the charge per tick larger"))
        })
    }

    /// Reports why a system cannot be explored as bad input.
    fn refused(&self, error: &Refused) -> Error {
        let help = match error {
            Refused::Process { help, .. } | Refused::Property { help, .. } => help.clone(),
            Refused::TooManyStates { process, .. } if process == TREE => self.timed_nodes(),
            _ => None,
        };
        Error::refused(error.to_string(), help.unwrap_or_else(|| "see `steward help prove`".into()))
    }

    /// Which nodes of the tree count time, in words: each multiplies its states by the number of ticks that it counts.
    fn timed_nodes(&self) -> Option<String> {
        let is_timed = |node: &&Node| {
            matches!(
                node.kind(),
                Kind::Delay | Kind::Timeout | Kind::Sleep | Kind::RateController | Kind::SpeedController
            )
        };
        let name = |node: &Node| match ["msec", "delay_msec", "hz"].map(|key| node.attribute(key)) {
            [Some(value), ..] | [_, Some(value), _] => format!("`{}` of {value} ms", node.label()),
            [.., Some(value)] => format!("`{}` of {value} Hz", node.label()),
            _ => format!("`{}`", node.label()),
        };
        let nodes: Vec<String> = self.scenario.tree()?.nodes().iter().filter(is_timed).map(name).collect();
        let help = "these nodes count time, each tick is another state, and together they have the product of them: ";
        (!nodes.is_empty())
            .then(|| format!("{help}{}. Shorten them, or make `execution.tick_s` longer", nodes.join(", ")))
    }

    /// The levels with which machines, and the monitor, compare the battery's.
    fn thresholds_for(&self, monitor: Option<&dyn Monitor>) -> Result<BTreeSet<Micros>, Error> {
        let (mut thresholds, mut complaints) = (self.thresholds.clone(), Complaints::default());
        let process = process_of::<BatteryReader>(&self.system, BATTERY_READER);
        if let Some((monitor, process)) = monitor.zip(process) {
            let shown = self.truths.as_ref().map(|truths| truths.channel);
            thresholds::of_monitor(monitor, &self.system, (process, shown), &mut thresholds, &mut complaints);
        }
        complaints.check()?;
        Ok(thresholds)
    }

    /// The bounds of the battery's level. Levels are exact: a run that a proof finds has levels that add up.
    fn bounds(&self, drained: &Drained) -> Result<Bounds, Error> {
        let exact = |percent: f64| {
            micros(percent).ok_or_else(|| {
                let problem = drained.place.problem(format!("{percent} % has more than six decimals"));
                Error::bad_input(problem.with_label("of this battery").with_help("levels are exact to six decimals"))
            })
        };
        let sim = &self.scenario.file.premises.as_ref().expect("only a robot has a battery").sim.battery;
        let rates = Rates { drain: exact(drained.drain_pct)?, charge: exact(drained.charge_pct)? };
        let start = drained.start_pct.clone().unwrap_or(sim.initial_pct..=sim.initial_pct);
        let start = (exact(*start.start())?, exact(*start.end())?);
        Ok(Bounds { rates, start, is_full_from: exact(sim.recharge_below_pct)? })
    }
}

fn has_battery(system: &ChannelSystem) -> bool {
    process_of::<BatteryReader>(system, BATTERY_READER).is_some()
}

/// The channels on which messages may be damaged.
fn damaged(scenario: &Scenario, system: &ChannelSystem, complaints: &mut Complaints) -> Vec<ChannelId> {
    let topology = system.topology();
    // Only a message that waits in a channel can be lost, repeated or held: a channel of capacity 0 has none.
    let holds = |channel: &ChannelId| topology.get(*channel).capacity == channels::Capacity::One;
    let named = &scenario.file.prove.messages.on;
    if named.is_empty() {
        return topology.channels().filter(holds).collect();
    }
    let mut damaged = Vec::new();
    for [from, to] in named {
        let names = || topology.processes().map(|id| topology.name(id));
        let [source, target] = [from, to].map(|name| {
            let found = topology.find_process(&name.value);
            if found.is_none() {
                complaints.push(unknown("process", name, names()));
            }
            found
        });
        let Some((source, target)) = source.zip(target) else { continue };
        match topology.channels().find(|id| (topology.get(*id).source, topology.get(*id).target) == (source, target)) {
            Some(channel) if holds(&channel) => damaged.push(channel),
            Some(_) => {
                let problem =
                    from.span.problem(format!("the channel from {} to {} holds no message", from.value, to.value));
                complaints.push(problem.with_label("this channel").with_help("its messages are handed over at once"));
            }
            None => {
                let problem = from.span.problem(format!("there is no channel from {} to {}", from.value, to.value));
                let help =
                    "name a sender and a receiver whose channel holds messages: [\"Navigation\", \"GoToDestination\"]";
                complaints.push(problem.with_label("these processes").with_help(help));
            }
        }
    }
    damaged
}

#[cfg(test)]
mod tests;
