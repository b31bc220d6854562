//! A running scenario: the world, the channel system and the monitors, step by step.

mod judged;
mod losses;
mod partnership;
mod record;
mod recorded;
mod run_monitors;
mod trace;
mod with_partners;

use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use bt::{Outcome, Status};
use channels::{ChannelSystem, Event, Scheduler};
use monitors::Warnings;
use recording::{Ended, Happening, RunView, SceneClock};
use remote::Offered;
use roaml::{Model, PropertyMonitor};
use robot::Streams;
use scenarios::names::unknown;
use scenarios::scenario::{Behavior, STEP, Scenario, TreeIds};
use scenarios::{Complaints, Error};

use self::judged::Judged;
use self::partnership::Partnership;
use self::recorded::Recorded;
use self::run_monitors::RunMonitors;
use self::trace::StepTrace;
use crate::ending::Ending;
use crate::injector::{FaultHappening, Injector, SystemUnderTest};
use crate::schedule_replay::{ReplayedSteps, ScheduleReplay};
use crate::skill_errors::SkillErrors;
use crate::tick_clock::{AFTER_THE_START, TickClock};
use crate::tree_watch::TreeWatch;
use crate::truth::TruthShow;
use crate::wiring::{Ids, Wired, start_programs, wire_for};
use crate::world::{SimulatedRobot, World};

/// A running scenario.
///
/// A [`step`](Self::step) consists of, in this order: faults that are due, physics, sensors and drivers if there is a
/// robot, timers that are due, the tick if it is due, and then the channel system until it is quiet. In a RoAML model,
/// each step happens at the time of an event. A run is described by its records: a [`header`](Self::header), a
/// [`record`](Self::record) before the first step and after each, and an [`end`](Self::end).
pub struct Run {
    scenario: Arc<Scenario>,
    seed: u64,
    world: World,
    /// The truths about the world that monitors are shown, if any property needs them.
    truths: Option<TruthShow>,
    system: ChannelSystem,
    scheduler: Box<dyn Scheduler>,
    ids: Ids,
    kind: RunKind,
    partnership: Partnership,
    monitors: RunMonitors,
    injector: Injector,
    trace: StepTrace,
    tree_watch: TreeWatch,
    skill_errors: SkillErrors,
    overruns: u64,
    /// `None` if the tree gets no further ticks.
    tick_clock: Option<TickClock>,
    scene_clock: SceneClock,
    recorded: Recorded,
    ending: Ending,
}

/// What makes a run go on.
#[derive(Debug)]
enum RunKind {
    /// Physics, sensors and drivers, every [`Execution::step`](scenarios::scenario::Execution::step).
    Application,
    /// The timers and ticks of a RoAML model: each step happens at the time of one.
    Model {
        model: Arc<Model>,
        begun: bool,
        /// Whether no step may be longer than [`STEP`].
        is_fine: bool,
    },
    /// A schedule, which takes the place of scheduler, drivers and physics.
    Schedule(ScheduleReplay),
}

impl RunKind {
    fn of(scenario: &Scenario, wired: &Wired, complaints: &mut Complaints) -> Self {
        match (&scenario.schedule, &scenario.behavior) {
            (Some(schedule), _) => {
                let generator = wired.ids.tree.map(|ids| ids.tick_generator);
                Self::Schedule(ScheduleReplay::new(schedule, scenario, &wired.system, generator, complaints))
            }
            (None, Behavior::Model(model)) => {
                Self::Model { model: Arc::clone(model), begun: false, is_fine: !scenario.file.faults.is_empty() }
            }
            (None, Behavior::Tree(_)) => Self::Application,
        }
    }

    fn has_schedule(&self) -> bool {
        matches!(self, Self::Schedule(_))
    }

    fn is_model(&self) -> bool {
        matches!(self, Self::Model { .. })
    }

    /// From now on, no step is longer than [`STEP`].
    fn refine(&mut self) {
        if let Self::Model { is_fine, .. } = self {
            *is_fine = true;
        }
    }
}

impl Run {
    /// The scenario at its start, with this root seed. Without monitors if `watch` is false.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together.
    pub fn new(scenario: Arc<Scenario>, seed: u64, watch: bool) -> Result<Self, Error> {
        Self::offering(scenario, seed, watch, &Arc::default())
    }

    /// The same, with these components offered to nodes of ROS 2.
    fn offering(scenario: Arc<Scenario>, seed: u64, watch: bool, offered: &Arc<[Offered]>) -> Result<Self, Error> {
        if let Some((name, namespace)) = scenario.remote_components().next() {
            let problem = namespace.span.problem(format!("the component {name} consists of nodes of ROS 2"));
            let help = "`steward run` and `steward live` run a scenario with such a component, alone";
            return Err(Error::bad_input(problem.with_label("which are not part of this run").with_help(help)));
        }
        let mut run = Self::prepare_for(scenario, seed, watch, offered)?;
        start_programs(&run.scenario, &mut run.system)?;
        Ok(run)
    }

    /// The same, but the programs of its components are not started: for everything short of a run.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together.
    pub fn prepare(scenario: Arc<Scenario>, seed: u64, watch: bool) -> Result<Self, Error> {
        Self::prepare_for(scenario, seed, watch, &Arc::default())
    }

    fn prepare_for(scenario: Arc<Scenario>, seed: u64, watch: bool, offered: &Arc<[Offered]>) -> Result<Self, Error> {
        let streams = Streams::new(seed);
        let mut wired = wire_for(&scenario, &streams, offered)?;
        let mut complaints = Complaints::default();
        let kind = RunKind::of(&scenario, &wired, &mut complaints);
        // A schedule takes the place of the robot's physics and drivers.
        let robot = scenario.premises.as_ref().zip(wired.ids.robot).filter(|_| !kind.has_schedule());
        let world = World::new(robot, &wired.system, &streams)?;
        let monitors = RunMonitors::attach(&scenario, &mut wired.system, watch)?;
        let injector = Injector::new(&scenario, &world, &wired.system, &streams, &mut complaints);
        check_expected_errors(&scenario, &mut complaints);
        complaints.check()?;
        let tick = scenario.file.execution.tick;
        let first_tick = if kind.is_model() { tick } else { AFTER_THE_START };
        Ok(Self {
            recorded: Recorded::of(monitors.count(), scenario.skills.len() + scenario.component_names().count()),
            skill_errors: SkillErrors::of(&wired.system),
            tree_watch: TreeWatch::new(scenario.tree().cloned().zip(wired.ids.tree.map(|ids| ids.tree))),
            tick_clock: wired.ids.tree.map(|_| TickClock::new(tick, first_tick)),
            scene_clock: SceneClock::new(&scenario.file.snapshots),
            scenario,
            seed,
            world,
            truths: wired.truths.map(TruthShow::new),
            partnership: Partnership::of(&wired.system, wired.ids.clients),
            monitors,
            system: wired.system,
            scheduler: wired.scheduler,
            ids: wired.ids,
            kind,
            injector,
            trace: StepTrace::default(),
            overruns: 0,
            ending: Ending::default(),
        })
    }

    /// Performs one step, and waits for partners as long as it takes. The events of a failed step can still be
    /// recorded.
    ///
    /// # Errors
    /// If the processes cannot continue, or a schedule that it follows requires something impossible.
    pub fn step(&mut self) -> Result<(), Error> {
        while !self.advance(true)? {}
        Ok(())
    }

    /// Performs one step, or the rest of it. Returns whether it is done: if it `waits` for partners, it may not be
    /// after a moment, and continues with the next call.
    pub(crate) fn advance(&mut self, waits: bool) -> Result<bool, Error> {
        if !self.partnership.is_waiting {
            self.trace.happenings.clear();
            self.tree_watch.begin_step();
            self.trace.happenings.extend(self.injector.added.drain(..).map(Happening::FaultAdded));
        }
        match &mut self.kind {
            RunKind::Schedule(replay) => {
                let mut replayed = ReplayedSteps::default();
                let performed = replay.advance(&mut self.system, &mut self.tree_watch, &mut replayed);
                let now = replay.now();
                self.enter(replayed, now);
                self.monitors.observe(&self.trace.events);
                performed?;
            }
            RunKind::Application | RunKind::Model { .. } => {
                let acted = self.act(waits);
                if matches!(acted, Ok(false)) {
                    return acted;
                }
                self.monitors.observe(&self.trace.events);
                acted?;
            }
        }
        let now = self.time();
        if self.trace.stirred || !self.trace.events.is_empty() {
            self.tree_watch.look(&self.system);
        }
        self.trace.happenings.extend(self.tree_watch.take_new());
        self.skill_errors.note(&self.system, now);
        let given_up = self.world.robot.as_mut().and_then(SimulatedRobot::note_given_up);
        self.trace.happenings.extend(given_up.map(|reason| Happening::GivenUp { reason: reason.to_string() }));
        let speeches = self.world.new_speeches(&self.system);
        self.trace.happenings.extend(speeches.into_iter().map(|(by, text)| Happening::Said { by: by.index(), text }));
        self.note_verdicts();
        self.note_arrivals();
        Ok(true)
    }

    /// Adds the steps of a schedule, including those before an error, to the run.
    fn enter(&mut self, replayed: ReplayedSteps, now: Duration) {
        let Self { system, world, trace, .. } = self;
        world.step(now, system, false);
        trace.events.clear();
        replayed.events.into_iter().for_each(|event| trace.enter(event, system.topology()));
        trace.note_moves(replayed.words);
        trace.stirred = true;
        self.overruns += replayed.overruns;
    }

    /// Performs a step with faults, physics and drivers. Returns whether it is done, or waits for partners.
    fn act(&mut self, waits: bool) -> Result<bool, Error> {
        if !std::mem::replace(&mut self.partnership.is_waiting, true) {
            self.apply_faults();
            let now = self.next_time();
            if let RunKind::Model { begun, .. } = &mut self.kind {
                *begun = true;
            }
            self.world.step(now, &mut self.system, self.partnership.has_controller());
        }
        let now = self.time();
        let Some(notes) = self.receive_from_partners(now).or((!waits).then(Vec::new)) else { return Ok(false) };
        self.partnership.is_waiting = false;
        self.trace.note_moves(notes);
        self.world.move_devices(&mut self.system);
        if let Some(robot) = &self.world.robot {
            robot.enter_into_trace(&mut self.trace.hash);
        }
        self.trace.events.clear();
        self.show_truths();
        self.happen(now)?;
        // In a model, everything that is due at the same time happens one by one, and the tick comes last.
        while self.kind.is_model() && self.next_event().is_some_and(|next| next <= now) {
            self.happen(now)?;
        }
        self.partnership.send(&mut self.system);
        Ok(true)
    }

    /// Shows the monitors what is true. It is no communication, and does not enter the trace hash: properties that
    /// about the world change no run.
    fn show_truths(&mut self) {
        let Self { truths: Some(truths), world, scenario, system, trace, .. } = self else { return };
        if let Some((robot, premises)) = world.robot.as_ref().zip(scenario.premises.as_ref()) {
            trace.events.extend(truths.show(robot, premises, system));
        }
    }

    /// The time of the next step. The first step of a model is at the start, and each later one at the time of the next
    /// event. If there are faults, or if details of the run are recorded, there is also a step at every multiple of
    /// [`STEP`].
    fn next_time(&self) -> Duration {
        let now = self.world.time();
        let is_fine = match self.kind {
            RunKind::Application | RunKind::Schedule(_) => return now + self.scenario.file.execution.step(),
            RunKind::Model { begun: false, .. } => return now,
            RunKind::Model { is_fine, .. } => is_fine,
        };
        let steps = u32::try_from(now.as_nanos() / STEP.as_nanos()).unwrap_or(u32::MAX).saturating_add(1);
        let regular = is_fine.then(|| STEP.saturating_mul(steps));
        let end = self.scenario.file.execution.max_time;
        self.next_event().into_iter().chain(regular).fold(end, Duration::min).max(now)
    }

    /// The time of the next timer or tick.
    fn next_event(&self) -> Option<Duration> {
        self.system.next_timer().into_iter().chain(self.tick_clock.as_ref().map(TickClock::next)).min()
    }

    /// Lets everything happen that is due now; in a model, timers come before the tick.
    fn happen(&mut self, now: Duration) -> Result<(), Error> {
        let fired = self.system.advance(now);
        self.trace.stirred |= fired;
        if self.communicate(now, !fired || !self.kind.is_model())? {
            self.follow_tree();
        }
        Ok(())
    }

    fn apply_faults(&mut self) {
        let Self { world, system, trace, injector, .. } = self;
        let changes = injector.act(&mut SystemUnderTest { world, system, events: &trace.events });
        self.trace.stirred = !changes.is_empty();
        let (time, tick) = (self.world.time(), self.system.ticks().checked_sub(1));
        let position = self.world.robot.as_ref().map(|robot| robot.sim.truth().pose().translation.vector.into());
        self.trace.happenings.extend(changes.into_iter().map(|change| match change {
            FaultHappening::Begun(fault) => Happening::FaultBegan { fault, time, tick, position },
            FaultHappening::Ended(fault) => Happening::FaultEnded { fault, time },
            FaultHappening::LeftUndone(fault, reason) => Happening::FaultLeftUndone { fault, time, reason },
        }));
    }

    /// Generates a tick if one is due and `may` come, and runs the channel system until it is quiet. Returns whether
    /// there was a tick.
    fn communicate(&mut self, now: Duration, may: bool) -> Result<bool, Error> {
        let topology = Arc::clone(self.system.topology());
        let Self { system, scheduler, trace, tree_watch, .. } = self;
        let clock = self.tick_clock.as_mut().filter(|_| may);
        let is_due = clock.is_some_and(|clock| clock.is_due(now, || self.injector.delay_of_tick()));
        let ticked = self.ids.tree.filter(|_| is_due);
        if let Some(TreeIds { tick_generator, tree }) = ticked {
            if let (Some(robot), Some(of)) = (&self.world.robot, self.scenario.tree()) {
                robot.write_to_blackboard(of, system, tree);
            }
            tree_watch.tick_begins(system);
            let (event, delivered) = system.generate_tick(tick_generator);
            self.overruns += u64::from(!delivered && !self.partnership.has_controller());
            trace.enter(event, &topology);
        }
        let budget = self.scenario.file.execution.step_budget;
        // The events before an error belong to the run: they are recorded and hashed, and may show its reason.
        let mut failure = None;
        for event in system.run(scheduler.as_mut(), budget) {
            match event {
                Ok(event) => trace.enter(event, &topology),
                Err(error) => failure = Some(error),
            }
        }
        let limit = self.scenario.file.execution.run_budget;
        match failure {
            Some(error) => Err(error.into()),
            None if self.system.steps() > limit => Err(Error::Budget(limit)),
            None => Ok(ticked.is_some()),
        }
    }

    /// Lets the properties of a model see its tree if it has finished the tick, and ends the ticks if the model
    /// requires it.
    fn follow_tree(&mut self) {
        let Self { kind: RunKind::Model { model, .. }, system, ids: Ids { tree: Some(ids), .. }, .. } = self else {
            return;
        };
        let (Some(of), Some(last)) = (&model.tree, self.trace.events.last()) else { return };
        if !system.is_ready_for_tick(ids.tick_generator) {
            return;
        }
        let (states, step) = (bt::states_in(of, system, ids.tree), system.steps());
        system.inform_monitors(last, |monitor| {
            if let Some(property) = (monitor as &mut dyn Any).downcast_mut::<PropertyMonitor>() {
                property.see_tree(&states, step);
            }
        });
        let is_running = states.first().is_some_and(|root| root.outcome == Some(Outcome::Answered(Status::Running)));
        if !is_running && !model.parameters.tick_if_not_running {
            self.tick_clock = None;
        }
    }

    fn note_verdicts(&mut self) {
        for (index, attached) in self.system.monitors().iter().enumerate() {
            if let Some(event) = &attached.decided {
                let verdict = self.recorded.monitors.verdict(index, attached.monitor.as_ref(), event);
                self.trace.happenings.extend(verdict);
            }
        }
        self.trace.happenings.extend(self.monitors.judged.iter_mut().flat_map(Judged::take_verdicts));
    }

    fn note_arrivals(&mut self) {
        let is_start = self.time() <= self.scenario.file.execution.step();
        let Some((robot, premises)) = self.world.robot.as_mut().zip(self.scenario.premises.as_ref()) else { return };
        let arrivals = robot.note_arrivals(premises, is_start);
        self.trace.happenings.extend(arrivals.into_iter().map(|place| Happening::Arrival { place }));
    }

    /// Continues with a scenario that differs from the present one only in its faults: there are more at its end, which
    /// are due now or later, or active ones have other durations. The rest of the run is then the same as in a run of
    /// this scenario from the start. After an error, nothing has changed.
    ///
    /// # Errors
    /// [`Error::BadInput`] if a new fault does not fit the run.
    pub fn adopt(&mut self, scenario: Arc<Scenario>) -> Result<(), Error> {
        self.injector.extend(&scenario, &self.world, &self.system, &Streams::new(self.seed))?;
        self.kind.refine();
        self.scenario = scenario;
        Ok(())
    }

    /// The reason why its scenario ends the run now, if it does.
    pub(crate) fn reached(&mut self, view: &RunView) -> Option<Ended> {
        self.ending.reached(&self.scenario.file, view)
    }

    /// Whether the schedule that it follows has ended.
    #[must_use]
    pub fn is_over(&self) -> bool {
        matches!(&self.kind, RunKind::Schedule(replay) if replay.is_over())
    }

    /// The channel system.
    #[must_use]
    pub fn system(&self) -> &ChannelSystem {
        &self.system
    }

    /// The events of the last step.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.trace.events
    }

    /// Time since the start of the run.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.world.time()
    }

    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// The names of the monitored properties, in the order of the scenario.
    pub fn properties(&self) -> impl Iterator<Item = &str> {
        let monitors = self.monitors.monitoring.iter().flat_map(|monitoring| monitoring.monitors());
        monitors.map(|(watched, _)| watched.name.as_str())
    }

    /// The warnings about the property files.
    #[must_use]
    pub fn warnings(&self) -> &[Warnings] {
        self.monitors.monitoring.as_ref().map_or(&[], |monitoring| monitoring.warnings())
    }
}

/// Reports names of errors that cannot occur, since nothing has that name.
fn check_expected_errors(scenario: &Scenario, complaints: &mut Complaints) {
    let skills = scenario.skills.keys().map(String::as_str);
    let nodes = scenario.tree().into_iter().flat_map(|tree| tree.nodes()).map(bt::Node::process);
    let known: BTreeSet<&str> = skills.chain(scenario.component_names()).chain(nodes).collect();
    for name in scenario.file.expect.errors.iter().filter(|name| !known.contains(name.value.as_str())) {
        complaints.push(unknown("skill, component or tree node", name, known.iter().copied()));
    }
}
