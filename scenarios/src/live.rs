//! A running scenario: the world, the channel system and the monitors, step by step.

use std::any::Any;
use std::sync::Arc;
use std::time::Duration;

use bt::{Outcome, Status};
use channels::{ChannelSystem, Event, Monitor, ProcessId, Scheduler, Verdict};
use maps::Place;
use monitors::{ScopeMonitor, Warnings, scope_monitor};
use programs::ProgramProcess;
use recording::{
    Decision, Detail, Details, End, Ended, Happening, Header, MonitorEnd, MonitorState, Navigation, RobotBody,
    RobotState, Scene, SceneClock, Step, TraceHash, event_line,
};
use roaml::PropertyMonitor;
use robot::{RobotModel, Streams};

use crate::driven::DriverData;
use crate::error::{Complaints, Error, StepError};
use crate::faults::{self, Injector, SystemUnderTest};
use crate::machines;
use crate::monitoring::{MachineMonitor, Monitoring};
use crate::names::unknown;
use crate::scenario::{Premises, STEP, Scenario, settings};
use crate::schedule::{Part, Player};
use crate::skill_errors::SkillErrors;
use crate::tick_clock::{AFTER_THE_START, TickClock};
use crate::tree_errors::TreeErrors;
use crate::wiring::{Ids, TreeIds, start_programs, wire};
use crate::world::{SimulatedRobot, World};

/// A running scenario.
///
/// A [`step`](Self::step) consists of, in this order: faults that are due, physics, sensors and drivers if there is a
/// robot, timers that are due, the tick if it is due, and then the channel system until it is quiet. In a RoAML model,
/// each step happens at the time of an event. A run is described by its records: a [`header`](Self::header), a
/// [`record`](Self::record) before the first step and after each, and an [`end`](Self::end).
pub struct Live {
    scenario: Arc<Scenario>,
    seed: u64,
    world: World,
    system: ChannelSystem,
    scheduler: Box<dyn Scheduler>,
    ids: Ids,
    /// The schedule, if it follows one.
    player: Option<Player>,
    /// The events of the last step.
    events: Vec<Event>,
    /// Whether a timer or a fault moved a process in the last step.
    stirred: bool,
    /// `None` in a run without monitors.
    monitoring: Option<Arc<Monitoring>>,
    injector: Injector,
    /// The faults that were added since the last step.
    added: Vec<Arc<recording::Fault>>,
    /// The events of the last step.
    happenings: Vec<Happening>,
    tree_errors: TreeErrors,
    skill_errors: SkillErrors,
    /// Whether each monitor has reached its verdict.
    decided: Vec<bool>,
    overruns: u64,
    /// `None` if the tree gets no further ticks.
    tick_clock: Option<TickClock>,
    /// Whether the first step has been made.
    begun: bool,
    /// Whether no step may be longer than [`STEP`].
    is_fine: bool,
    hash: TraceHash,
    scene_clock: SceneClock,
    told: Told,
}

/// The contents of earlier records: only changes must be recorded again.
#[derive(Debug, Default)]
struct Told {
    outcomes: Vec<Option<bt::Outcome>>,
    /// The locations of skills and components, in the order of their names in the header.
    locations: Vec<Option<String>>,
    monitors: Vec<MonitorState>,
    navigation: Navigation,
    robot: RobotState,
    /// Whether the record of the last step had a scene.
    scene: bool,
}

impl Live {
    /// The scenario at its start, with this root seed. Without monitors if `watch` is false.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together.
    pub fn new(scenario: Arc<Scenario>, seed: u64, watch: bool) -> Result<Self, Error> {
        let mut live = Self::prepare(scenario, seed, watch)?;
        start_programs(&live.scenario, &mut live.system)?;
        Ok(live)
    }

    /// The same, but the programs of its components are not started: for everything short of a run.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together.
    pub fn prepare(scenario: Arc<Scenario>, seed: u64, watch: bool) -> Result<Self, Error> {
        let streams = Streams::new(seed);
        let mut wired = wire(&scenario, &streams)?;
        let mut complaints = Complaints::default();
        let player = scenario.schedule.as_ref().map(|schedule| {
            let generator = wired.ids.tree.map(|ids| ids.tick_generator);
            Player::new(schedule, &scenario, &wired.system, generator, &mut complaints)
        });
        let robot = scenario.premises.as_ref().zip(wired.ids.robot).filter(|_| player.is_none());
        let world = World::new(robot, &wired.system, &streams)?;
        let monitoring = watch.then(|| attach(&scenario, &mut wired.system)).transpose()?;
        let injector = Injector::new(&scenario, &world, &wired.system, &streams, &mut complaints);
        complaints.check()?;
        let tick = scenario.file.execution.tick;
        let first_tick = if scenario.model.is_some() { tick } else { AFTER_THE_START };
        Ok(Self {
            decided: vec![false; wired.system.monitors().len()],
            skill_errors: SkillErrors::of(&wired.system),
            tick_clock: wired.ids.tree.map(|_| TickClock::new(tick, first_tick)),
            begun: false,
            is_fine: !scenario.file.faults.is_empty(),
            scene_clock: SceneClock::new(&scenario.file.snapshots),
            scenario,
            seed,
            world,
            system: wired.system,
            scheduler: wired.scheduler,
            ids: wired.ids,
            player,
            events: Vec::new(),
            stirred: false,
            monitoring,
            injector,
            added: Vec::new(),
            happenings: Vec::new(),
            tree_errors: TreeErrors::default(),
            overruns: 0,
            hash: TraceHash::default(),
            told: Told::default(),
        })
    }

    /// Performs one step. The events of a failed step can still be recorded.
    ///
    /// # Errors
    /// [`StepError`] if the processes cannot continue.
    pub fn step(&mut self) -> Result<(), StepError> {
        self.happenings.clear();
        self.happenings.extend(self.added.drain(..).map(Happening::FaultAdded));
        match self.player {
            Some(_) => self.follow_schedule()?,
            None => self.act()?,
        }
        let now = self.time();
        self.note_tree_errors();
        self.skill_errors.note(&self.system, now);
        let given_up = self.world.robot_mut().and_then(SimulatedRobot::note_given_up);
        self.happenings.extend(given_up.map(|reason| Happening::GivenUp { reason: reason.to_string() }));
        let speeches = self.world.new_speeches(&self.system);
        self.happenings.extend(speeches.into_iter().map(|(by, text)| Happening::Said { by: by.index(), text }));
        self.note_verdicts();
        self.note_arrivals();
        Ok(())
    }

    /// Performs a step of the schedule.
    fn follow_schedule(&mut self) -> Result<(), StepError> {
        let Self { player: Some(player), system, world, events, hash, .. } = self else { return Ok(()) };
        let mut part = Part::default();
        let performed = player.perform_part(system, &mut part);
        world.step(player.now(), system);
        part.events.iter().for_each(|event| hash.line(&event_line(event, system.topology())));
        *events = part.events;
        self.overruns += part.overruns;
        self.happenings.extend(part.words.into_iter().map(|words| Happening::Moved { words }));
        (self.begun, self.stirred) = (true, true);
        performed
    }

    /// Performs a step with faults, physics and drivers.
    fn act(&mut self) -> Result<(), StepError> {
        self.apply_faults();
        let now = self.next_time();
        self.begun = true;
        self.world.step(now, &mut self.system);
        if let Some(robot) = self.world.robot() {
            robot.enter_into_trace(&mut self.hash);
        }
        self.events.clear();
        self.happen(now)?;
        // In a model, everything that is due at the same time happens one by one, and the tick comes last.
        while self.scenario.model.is_some() && self.next_event().is_some_and(|next| next <= now) {
            self.happen(now)?;
        }
        Ok(())
    }

    /// The time of the next step. The first step of a model is at the start, and each later one at the time of the next
    /// event. If there are faults, or if somebody sees the details of the run, there is also a step at every multiple
    /// of [`STEP`].
    fn next_time(&self) -> Duration {
        let now = self.world.time();
        if self.scenario.model.is_none() {
            return now + STEP;
        }
        if !self.begun {
            return now;
        }
        let steps = u32::try_from(now.as_nanos() / STEP.as_nanos()).unwrap_or(u32::MAX).saturating_add(1);
        let regular = self.is_fine.then(|| STEP.saturating_mul(steps));
        let end = self.scenario.file.execution.max_time;
        self.next_event().into_iter().chain(regular).fold(end, Duration::min).max(now)
    }

    /// The time of the next timer or tick.
    fn next_event(&self) -> Option<Duration> {
        self.system.next_timer().into_iter().chain(self.tick_clock.as_ref().map(TickClock::next)).min()
    }

    /// Lets everything happen that is due now; in a model, timers come before the tick.
    fn happen(&mut self, now: Duration) -> Result<(), StepError> {
        let fired = self.system.advance(now);
        self.stirred |= fired;
        if self.communicate(now, !fired || self.scenario.model.is_none())? {
            self.follow_tree();
        }
        Ok(())
    }

    fn apply_faults(&mut self) {
        let Self { world, system, events, injector, .. } = self;
        let changes = injector.act(&mut SystemUnderTest { world, system, events });
        self.stirred = !changes.is_empty();
        let (time, tick) = (self.world.time(), self.system.ticks().checked_sub(1));
        let position = self.world.robot().map(|robot| robot.sim.truth().pose().translation.vector.into());
        self.happenings.extend(changes.into_iter().map(|change| match change {
            faults::Happening::Begun(fault) => Happening::FaultBegan { fault, time, tick, position },
            faults::Happening::Ended(fault) => Happening::FaultEnded { fault, time },
            faults::Happening::LeftUndone(fault, reason) => Happening::FaultLeftUndone { fault, time, reason },
        }));
    }

    /// Generates a tick if one is due and `may` come, and runs the channel system until it is quiet. Returns whether
    /// there was a tick.
    fn communicate(&mut self, now: Duration, may: bool) -> Result<bool, StepError> {
        let topology = Arc::clone(self.system.topology());
        let Self { system, scheduler, events, hash, .. } = self;
        let mut enter = |event: Event| {
            hash.line(&event_line(&event, &topology));
            events.push(event);
        };
        let clock = self.tick_clock.as_mut().filter(|_| may);
        let is_due = clock.is_some_and(|clock| clock.is_due(now, || self.injector.delay_of_tick()));
        let ticked = self.ids.tree.filter(|_| is_due);
        if let Some(TreeIds { tick_generator, tree }) = ticked {
            if let (Some(robot), Some(of)) = (self.world.robot(), &self.scenario.tree) {
                robot.tell(of, system, tree);
            }
            let (event, delivered) = system.generate_tick(tick_generator);
            self.overruns += u64::from(!delivered);
            enter(event);
        }
        let budget = self.scenario.file.execution.step_budget;
        let mut failure = None;
        for event in system.run(scheduler.as_mut(), budget) {
            match event {
                Ok(event) => enter(event),
                Err(error) => failure = Some(error),
            }
        }
        let limit = self.scenario.file.execution.run_budget;
        match failure {
            Some(error) => Err(error.into()),
            None if self.system.steps() > limit => Err(StepError::Budget(limit)),
            None => Ok(ticked.is_some()),
        }
    }

    /// Lets the properties of a model see its tree if it has finished the tick, and ends the ticks if the model
    /// requires it.
    fn follow_tree(&mut self) {
        let Self { scenario, system, ids: Ids { tree, .. }, .. } = self;
        let (Some(model), Some(of), Some(ids), Some(last)) =
            (&scenario.model, &scenario.tree, tree, self.events.last())
        else {
            return;
        };
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

    fn note_tree_errors(&mut self) {
        if let Some(TreeIds { tree, .. }) = self.ids.tree.filter(|_| !self.events.is_empty()) {
            let tick = self.system.ticks().saturating_sub(1);
            let new = self.tree_errors.note(bt::faults_in(&self.system, tree));
            self.happenings.extend(new.into_iter().map(|error| Happening::TreeError {
                node: error.node.index(),
                message: error.message,
                tick,
            }));
        }
    }

    fn note_verdicts(&mut self) {
        for (monitor, (decided, attached)) in self.decided.iter_mut().zip(self.system.monitors()).enumerate() {
            if let Some(event) = attached.decided.as_ref().filter(|_| !*decided) {
                let verdict = attached.monitor.verdict();
                let witness = scope_monitor(attached.monitor.as_ref()).and_then(ScopeMonitor::witness);
                let witness = witness.filter(|_| verdict == Verdict::False).cloned();
                let decision = Decision { verdict, event: event.clone(), witness };
                self.happenings.push(Happening::Verdict { monitor, decision });
                *decided = true;
            }
        }
    }

    fn note_arrivals(&mut self) {
        let Some((robot, premises)) = self.world.robot_mut().zip(self.scenario.premises.as_ref()) else { return };
        let arrivals = robot.note_arrivals(premises);
        self.happenings.extend(arrivals.into_iter().map(|place| Happening::Arrival { place }));
    }

    /// Continues with a scenario that differs from the present one only in its faults: there are more at its end, which
    /// are due now or later, or active ones have other durations. The rest of the run is then the same as in a run of
    /// this scenario from the start. After an error, nothing has changed.
    ///
    /// # Errors
    /// [`Error::BadInput`] if a new fault does not fit the run.
    pub fn adopt(&mut self, scenario: Arc<Scenario>) -> Result<(), Error> {
        self.injector.extend(&scenario, &self.world, &self.system, &Streams::new(self.seed))?;
        let known = self.scenario.file.faults.len();
        self.added.extend(scenario.file.faults[known..].iter().map(|fault| Arc::new(fault.told())));
        self.is_fine = true;
        self.scenario = scenario;
        Ok(())
    }

    /// Whether the schedule that it follows has ended.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.player.as_ref().is_some_and(Player::is_over)
    }

    /// The channel system.
    pub(crate) fn system(&self) -> &ChannelSystem {
        &self.system
    }

    /// The events of the last step.
    pub(crate) fn events(&self) -> &[Event] {
        &self.events
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
        let monitors = self.monitoring.iter().flat_map(|monitoring| monitoring.monitors());
        monitors.map(|(watched, _)| watched.name.as_str())
    }

    /// The warnings about the property files.
    #[must_use]
    pub fn warnings(&self) -> &[Warnings] {
        self.monitoring.as_ref().map_or(&[], |monitoring| monitoring.warnings())
    }
}

/// The records of a run.
impl Live {
    /// The constant data of the run.
    #[must_use]
    pub fn header(&self) -> Header {
        let Scenario { name, file, origin, premises, tree, .. } = &*self.scenario;
        // A schedule has no map.
        let premises = premises.as_ref().filter(|_| self.player.is_none());
        Header {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scenario: name.clone(),
            about: file.about.clone(),
            origin: origin.clone(),
            settings: settings::in_effect(
                file.premises.as_ref().map(|entry| &entry.sim),
                file.model.is_some(),
                &file.execution,
            ),
            seed: self.seed,
            tick: file.execution.tick,
            dt: if file.model.is_some() { Duration::ZERO } else { STEP },
            unwatched: self.decided.is_empty() && !file.properties.is_empty(),
            topology: Arc::clone(self.system.topology()),
            tree: tree.iter().flat_map(|tree| tree.nodes()).map(recording::Node::from).collect(),
            skills: self.scenario.skills.keys().cloned().collect(),
            components: self.scenario.component_names().map(str::to_owned).collect(),
            machines: self
                .scenario
                .machine_processes()
                .map(|(name, skill)| machines::record(name, &skill.machine))
                .collect(),
            monitors: self.monitoring.as_ref().map_or_else(|| Arc::from([]), |monitoring| monitoring.told()),
            faults: file.faults.iter().map(|fault| Arc::new(fault.told())).collect(),
            premises: premises.map(premises_record),
            robot: premises.map(|premises| robot_record(&premises.entry.sim.model)),
            snapshots: file.snapshots.clone(),
            expected: file.expect.told(),
        }
    }

    /// The record of the last step, or of the initial state, with the given detail. Call it once before the first step
    /// and once after each.
    pub fn record(&mut self, detail: Detail) -> Step {
        self.is_fine |= detail > Detail::Verdicts;
        let mut robot = self.world.robot_state();
        if self.player.is_some() {
            let told = DriverData::of(&self.system).battery;
            robot.battery = told.map(|(charge_pct, charging)| recording::Battery { charge_pct, charging });
        }
        let (time, happenings) = (self.time(), std::mem::take(&mut self.happenings));
        let is_start = time.is_zero();
        let wants_scene = match detail {
            Detail::Verdicts => false,
            // The clock advances even if a scene is recorded anyway.
            Detail::Full => (!is_start && self.scene_clock.is_any(time, robot.is_charging())) || !happenings.is_empty(),
            Detail::Scenes => true,
        };
        let details = (detail > Detail::Verdicts || is_start).then(|| self.details(wants_scene));
        self.told.scene = wants_scene;
        let changes = robot.since(&self.told.robot);
        self.told.robot = robot;
        Step {
            time,
            ticks: self.system.ticks(),
            overruns: self.overruns,
            communications: self.system.steps(),
            robot: changes,
            happenings,
            details: details.filter(|details| !details.is_empty()).map(Box::new),
        }
    }

    /// The changes since the last record.
    fn details(&mut self, with_scene: bool) -> Details {
        let mut details = Details {
            events: self.events.clone(),
            navigation: self.new_navigation(),
            scene: if with_scene { self.scene() } else { None },
            ..Details::default()
        };
        let is_quiet = self.events.is_empty() && !self.time().is_zero();
        // Messages, timers and faults move any process. The world also moves devices and the robot's own components.
        let (stirs, drives) = (!is_quiet || self.stirred, details.navigation.is_some());
        let Scenario { tree, skills, components, .. } = &*self.scenario;
        if let Some((tree, ids)) = tree.as_ref().zip(self.ids.tree).filter(|_| stirs) {
            let states = bt::states_in(tree, &self.system, ids.tree);
            let outcomes: Vec<_> = states.iter().map(|state| state.outcome).collect();
            if self.told.outcomes != outcomes {
                self.told.outcomes.clone_from(&outcomes);
                details.outcomes = Some(outcomes);
            }
        }
        let is_device = |name: &str| components.get(name).is_some_and(|component| component.runs.is_device());
        let moves = |name: &str| stirs || is_device(name) || drives && !components.contains_key(name);
        let names = skills.keys().map(String::as_str).chain(self.scenario.component_names()).enumerate();
        self.told.locations.resize(skills.len() + self.scenario.component_names().count(), None);
        for (index, name) in names.filter(|(_, name)| moves(name)) {
            let told = &mut self.told.locations[index];
            let Some(process) = self.system.topology().find_process(name) else { continue };
            let Some(location) = self.system.location(process) else { continue };
            if told.as_ref() != Some(&location) {
                details.locations.push((process.index(), location.clone()));
                *told = Some(location);
            }
        }
        // Monitors move only when a message is received or a tick is generated.
        if is_quiet {
            return details;
        }
        let is_start = self.told.monitors.is_empty();
        self.told.monitors.resize(self.decided.len(), MonitorState::default());
        for (index, (attached, told)) in self.system.monitors().iter().zip(&mut self.told.monitors).enumerate() {
            let state = MonitorState::of(attached.monitor.as_ref());
            if is_start || *told != state {
                details.monitors.push((index, state.clone()));
                *told = state;
            }
        }
        details
    }

    fn new_navigation(&mut self) -> Option<Navigation> {
        let new = self.world.robot()?.new_navigation(&self.told.navigation)?;
        self.told.navigation.clone_from(&new);
        Some(new)
    }

    fn scene(&self) -> Option<Scene> {
        self.world.scene()
    }

    /// Ends the run, and with it the programs of its components. Returns the end record with the given detail.
    #[must_use]
    pub fn end(&mut self, ended: Ended, detail: Detail) -> End {
        let processes: Vec<ProcessId> = self.system.topology().processes().collect();
        for id in processes {
            if let Some(program) = self.system.process_mut::<ProgramProcess>(id) {
                program.conclude();
            }
        }
        self.skill_errors.note(&self.system, self.time());
        // Faults that were added since the last step are not part of the run.
        let faults = 0..self.scenario.file.faults.len() - self.added.len();
        End {
            ended,
            trace_hash: self.hash.finish(),
            monitors: self.system.monitors().iter().map(|attached| monitor_end(attached.monitor.as_ref())).collect(),
            skill_errors: self.skill_errors.all(&self.system),
            messages_hit: faults.map(|fault| self.injector.messages_hit(fault, &self.system)).collect(),
            scene: if detail > Detail::Verdicts && !self.told.scene { self.scene() } else { None },
        }
    }
}

fn monitor_end(monitor: &dyn Monitor) -> MonitorEnd {
    let errors = MachineMonitor::of(monitor).map_or_else(Vec::new, |machine| machine.errors().to_vec());
    MonitorEnd { errors, ..MonitorEnd::of(monitor) }
}

fn premises_record(Premises { entry, map, places, start, station, .. }: &Premises) -> recording::Premises {
    recording::Premises {
        map: Arc::clone(map),
        places: places.iter().map(place_record).collect(),
        start: *start,
        station: *station,
        destination: entry.sites.destination.as_ref().map(|name| name.value.clone()),
    }
}

fn robot_record(model: &RobotModel) -> RobotBody {
    RobotBody { radius_m: model.radius_m, lasers: model.lasers.clone() }
}

fn place_record((name, place): (&str, &Place)) -> recording::Place {
    let (corners, tolerance_m) = match place {
        Place::Area { corners } => (corners.clone(), 0.0),
        Place::Point { position_tolerance_m, .. } => (vec![place.goal_position()], *position_tolerance_m),
    };
    recording::Place { name: name.to_owned(), corners, tolerance_m }
}

/// Attaches the monitors of the scenario's properties.
fn attach(scenario: &Scenario, system: &mut ChannelSystem) -> Result<Arc<Monitoring>, Error> {
    let monitoring = scenario.monitoring(system.topology())?;
    let mut complaints = Complaints::default();
    let known = || monitoring.monitors().iter().map(|(watched, _)| watched.name.as_str());
    let expected = scenario.file.expect.outcomes.iter().map(|(name, _)| name);
    let named = expected.chain(scenario.file.stop.on_violation.names());
    let is_missing =
        |name: &&diagnostics::Spanned<String>| !known().any(|other| other == name.value) && scenario.file.means(name);
    for name in named.filter(is_missing) {
        complaints.push(unknown("property", name, known()));
    }
    complaints.check()?;
    for (_, monitor) in monitoring.monitors() {
        system.attach(monitor.clone());
    }
    Ok(monitoring)
}
