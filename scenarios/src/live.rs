//! A running scenario: the simulated robot, its software, the channel system and the monitors, step by step.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Event, GraphMonitor, Monitor, Scheduler, Verdict};
use components::{BATTERY_READER, LOCALIZATION, NAVIGATION, Processes, Software};
use maps::Place;
use monitors::{ScopeMonitor, Warnings, scope_monitor};
use nav::InitialPose;
use recording::{
    Body, BodyShape, Decision, Detail, Details, End, Ended, Happening, Header, MonitorEnd, MonitorState, Navigation,
    RobotState, Scene, SceneClock, Step, TraceHash, event_line,
};
use robot::{Reading, Streams};
use sim::Simulation;

use crate::error::{Complaints, Error, StepError};
use crate::faults::{self, Injector, SystemUnderTest};
use crate::given_up::GivenUps;
use crate::monitoring::{MachineMonitor, Monitoring};
use crate::names::unknown;
use crate::scenario::{Scenario, settings};
use crate::skill_errors::SkillErrors;
use crate::tick_clock::TickClock;
use crate::tree_errors::TreeErrors;
use crate::wiring::{Ids, wire};

/// A robot slower than this counts as at rest, in m/s and rad/s.
const AT_REST: f64 = 1e-3;

/// A running scenario.
///
/// A [`step`](Self::step) consists of, in this order: faults that are due, physics and sensors, drivers, timers that
/// are due, the tick if it is due, and then the channel system until it is quiet. A run is described by its records: a
/// [`header`](Self::header), a [`record`](Self::record) before the first step and after each, and an
/// [`end`](Self::end).
pub struct Live {
    scenario: Arc<Scenario>,
    seed: u64,
    sim: Simulation,
    software: Software,
    system: ChannelSystem,
    scheduler: Box<dyn Scheduler>,
    ids: Ids,
    /// The events of the last step.
    events: Vec<Event>,
    /// `None` in a run without monitors.
    monitoring: Option<Arc<Monitoring>>,
    injector: Injector,
    /// What happened in the last step.
    happenings: Vec<Happening>,
    tree_errors: TreeErrors,
    skill_errors: SkillErrors,
    given_up: GivenUps,
    /// Whether each monitor has given its verdict.
    decided: Vec<bool>,
    /// Whether the robot has been at each place.
    reached: Vec<bool>,
    overruns: u64,
    tick_clock: TickClock,
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
    /// Whether the last step had a scene.
    scene: bool,
}

impl Live {
    /// The scenario at its start, with this root seed; without monitors if `watch` is false.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together.
    pub fn new(scenario: Arc<Scenario>, seed: u64, watch: bool) -> Result<Self, Error> {
        let streams = Streams::new(seed);
        let sim = simulate(&scenario, &streams)?;
        let mut wired = wire(&scenario, &streams)?;
        let processes = Processes {
            battery_reader: wired.ids.battery_reader,
            localization: wired.ids.localization,
            navigation: wired.ids.navigation,
        };
        let software = software(&scenario, &sim, processes, &streams)?;
        let monitoring = watch.then(|| attach(&scenario, &mut wired.system)).transpose()?;
        let mut complaints = Complaints::default();
        let injector = Injector::new(&scenario, &sim, &wired.system, wired.ids, &streams, &mut complaints);
        complaints.check()?;
        Ok(Self {
            decided: vec![false; wired.system.monitors().len()],
            reached: vec![false; scenario.places.iter().count()],
            skill_errors: SkillErrors::of(&wired.system),
            tick_clock: TickClock::new(scenario.file.execution.tick),
            scene_clock: SceneClock::new(&scenario.file.snapshots),
            scenario,
            seed,
            sim,
            software,
            system: wired.system,
            scheduler: wired.scheduler,
            ids: wired.ids,
            events: Vec::new(),
            monitoring,
            injector,
            happenings: Vec::new(),
            tree_errors: TreeErrors::default(),
            given_up: GivenUps::default(),
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
        self.apply_faults();
        self.sim.step();
        let now = self.sim.time();
        self.software.step(&mut self.sim, &mut self.system, now);
        self.enter_step_into_trace();
        self.system.advance(now);
        self.communicate(now)?;
        self.note_tree_errors();
        self.skill_errors.note(&self.system, now);
        let given_up = self.given_up.note(&self.software);
        self.happenings.extend(given_up.map(|reason| Happening::GivenUp { reason: reason.to_string() }));
        self.note_verdicts();
        self.note_arrivals();
        Ok(())
    }

    fn apply_faults(&mut self) {
        let Self { sim, software, system, events, injector, .. } = self;
        let changes = injector.act(&mut SystemUnderTest { sim, software, system, events });
        let (time, tick) = (self.sim.time(), self.system.ticks().checked_sub(1));
        let position = self.sim.truth().pose().translation.vector.into();
        self.happenings.extend(changes.into_iter().map(|change| match change {
            faults::Happening::Begun(fault) => Happening::FaultBegan { fault, time, tick, position },
            faults::Happening::Ended(fault) => Happening::FaultEnded { fault, time },
            faults::Happening::LeftUndone(fault, error) => {
                Happening::FaultLeftUndone { fault, time, reason: error.to_string() }
            }
        }));
    }

    fn enter_step_into_trace(&mut self) {
        let truth = self.sim.truth();
        self.hash.pose(&truth.pose());
        self.hash.odometry(&truth.odometry());
        self.hash.battery(&truth.battery());
        for reading in self.software.readings() {
            if let Reading::Scan(scan) = reading {
                self.hash.scan(scan);
            }
        }
    }

    /// Generates a tick if it is due and runs the channel system until it is quiet.
    fn communicate(&mut self, now: Duration) -> Result<(), StepError> {
        let topology = Arc::clone(self.system.topology());
        let Self { system, scheduler, events, hash, .. } = self;
        events.clear();
        let mut enter = |event: Event| {
            hash.line(&event_line(&event, &topology));
            events.push(event);
        };
        if self.tick_clock.is_due(now, || self.injector.delay_of_tick()) {
            let (event, delivered) = system.generate_tick(self.ids.tick_generator);
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
            None => Ok(()),
        }
    }

    fn note_tree_errors(&mut self) {
        if !self.events.is_empty() {
            let tick = self.system.ticks().saturating_sub(1);
            let new = self.tree_errors.note(bt::faults_in(&self.system, self.ids.tree));
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
        let truth = self.sim.truth();
        if truth.linear_mps().abs() > AT_REST || truth.angular_radps().abs() > AT_REST {
            return;
        }
        let pose = truth.pose();
        for (place, ((_, there), reached)) in self.scenario.places.iter().zip(&mut self.reached).enumerate() {
            if !*reached && there.contains(&pose) {
                *reached = true;
                self.happenings.push(Happening::Arrival { place });
            }
        }
    }

    /// Time since the start of the run.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.sim.time()
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
        let Scenario { name, file, origin, map, places, tree, start, station, .. } = &*self.scenario;
        let model = self.software.model();
        Header {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scenario: name.clone(),
            about: file.about.clone(),
            origin: origin.clone(),
            settings: settings::in_effect(&file.sim, &file.execution),
            seed: self.seed,
            tick: file.execution.tick,
            dt: file.sim.dt,
            unwatched: self.decided.is_empty() && !file.properties.is_empty(),
            topology: Arc::clone(self.system.topology()),
            tree: tree.nodes().iter().map(recording::Node::from).collect(),
            skills: self.scenario.skills.keys().cloned().collect(),
            components: COMPONENTS.map(str::to_owned).to_vec(),
            monitors: self.monitoring.as_ref().map_or_else(|| Arc::from([]), |monitoring| monitoring.told()),
            faults: file.faults.iter().map(|fault| Arc::new(fault.told())).collect(),
            map: Arc::clone(map),
            places: places.iter().map(place_record).collect(),
            start: *start,
            station: *station,
            destination: file.sites.destination.as_ref().map(|name| name.value.clone()),
            robot_radius_m: model.radius_m,
            lasers: model.lasers.clone(),
            snapshots: file.snapshots.clone(),
            expected: file.expect.told(),
        }
    }

    /// The record of the last step, or of the initial state, with the given detail. Call it once before the first step
    /// and once after each.
    pub fn record(&mut self, detail: Detail) -> Step {
        let truth = self.sim.truth();
        let battery = truth.battery();
        let robot = RobotState {
            pose: truth.pose(),
            estimate: self.software.estimate().pose,
            charge_pct: battery.charge_pct,
            charging: battery.charging,
            distance_m: truth.distance_m(),
            collisions: truth.collisions(),
        };
        let (time, happenings) = (self.time(), std::mem::take(&mut self.happenings));
        let is_start = time.is_zero();
        let wants_scene = match detail {
            Detail::Verdicts => false,
            // The clock advances even if a scene is recorded anyway.
            Detail::Full => (!is_start && self.scene_clock.is_any(time, battery.charging)) || !happenings.is_empty(),
            Detail::Scenes => true,
        };
        let details = (detail > Detail::Verdicts || is_start).then(|| Box::new(self.details(wants_scene)));
        self.told.scene = wants_scene;
        Step {
            time,
            ticks: self.system.ticks(),
            overruns: self.overruns,
            communications: self.system.steps(),
            robot,
            happenings,
            details,
        }
    }

    /// The changes since the last record.
    fn details(&mut self, with_scene: bool) -> Details {
        let mut details = Details {
            events: self.events.clone(),
            navigation: self.new_navigation(),
            scene: with_scene.then(|| self.scene()),
            ..Details::default()
        };
        let states = bt::states_in(&self.scenario.tree, &self.system, self.ids.tree);
        let outcomes: Vec<_> = states.iter().map(|state| state.outcome).collect();
        if self.told.outcomes != outcomes {
            self.told.outcomes.clone_from(&outcomes);
            details.outcomes = Some(outcomes);
        }
        // Everything else changes only when a message is received or a tick is generated.
        if self.events.is_empty() && !self.time().is_zero() {
            return details;
        }
        let names = self.scenario.skills.keys().map(String::as_str).chain(COMPONENTS);
        self.told.locations.resize(self.scenario.skills.len() + COMPONENTS.len(), None);
        for (name, told) in names.zip(&mut self.told.locations) {
            let Some(process) = self.system.topology().find_process(name) else { continue };
            let Some(location) = self.system.location(process) else { continue };
            if told.as_ref() != Some(&location) {
                details.locations.push((process.index(), location.clone()));
                *told = Some(location);
            }
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
        let software = &self.software;
        let (status, reason, recovery) =
            (software.navigation_status().name(), software.navigation_reason(), software.recovery());
        let told = &self.told.navigation;
        let same = told.status == status
            && told.recovery.as_deref() == recovery.map(nav::Recovery::name)
            && told.reason == reason.map(|reason| reason.to_string());
        (!same).then(|| {
            let recovery = recovery.map(|recovery| recovery.name().to_owned());
            let reason = reason.map(|reason| reason.to_string());
            self.told.navigation = Navigation { status: status.to_owned(), reason, recovery };
            self.told.navigation.clone()
        })
    }

    fn scene(&self) -> Scene {
        let (truth, software) = (self.sim.truth(), &self.software);
        let stride = software.particle_count().div_ceil(Scene::MAX_PARTICLES).max(1);
        Scene {
            scans: truth.scans().cloned().collect(),
            particles: software.particles().step_by(stride).map(|pose| pose.translation.vector.into()).collect(),
            path: software.path().to_vec(),
            bodies: truth.obstacles().map(|obstacle| body_record(&obstacle)).collect(),
        }
    }

    /// The end record of the run if it ends here, with the given detail.
    #[must_use]
    pub fn end(&self, ended: Ended, detail: Detail) -> End {
        let faults = 0..self.scenario.file.faults.len();
        End {
            ended,
            trace_hash: self.hash.finish(),
            monitors: self.system.monitors().iter().map(|attached| monitor_end(attached.monitor.as_ref())).collect(),
            skill_errors: self.skill_errors.all(&self.system),
            messages_hit: faults.map(|fault| self.injector.messages_hit(fault, &self.system)).collect(),
            scene: (detail > Detail::Verdicts && !self.told.scene).then(|| self.scene()),
        }
    }
}

/// The components in records, by name.
const COMPONENTS: [&str; 3] = [BATTERY_READER, LOCALIZATION, NAVIGATION];

fn monitor_end(monitor: &dyn Monitor) -> MonitorEnd {
    let scope = scope_monitor(monitor);
    let graph = (monitor as &dyn std::any::Any).downcast_ref::<GraphMonitor>();
    let visits = |graph: &GraphMonitor| {
        let locations = monitor.graph().map_or(&[][..], |(graph, _)| graph.locations());
        locations.iter().map(|location| graph.visits(location)).collect()
    };
    MonitorEnd {
        state: MonitorState::of(monitor),
        open: scope.map(ScopeMonitor::open_obligations).unwrap_or_default(),
        vacuous: scope.map(ScopeMonitor::vacuous).unwrap_or_default(),
        errors: MachineMonitor::of(monitor).map_or_else(Vec::new, |machine| machine.errors().to_vec()),
        visits: graph.map(visits).unwrap_or_default(),
    }
}

fn place_record((name, place): (&str, &Place)) -> recording::Place {
    let corners = match place {
        Place::Area { corners } => corners.clone(),
        Place::Point { .. } => vec![place.goal_position()],
    };
    recording::Place { name: name.to_owned(), corners }
}

/// The record of a body.
fn body_record(obstacle: &sim::ObstacleTruth<'_>) -> Body {
    let shape = match obstacle.shape {
        sim::Shape::Disc { radius_m } => BodyShape::Disc { radius_m },
        sim::Shape::Box { length_m, width_m } => BodyShape::Box { length_m, width_m },
    };
    Body { name: obstacle.name.to_owned(), shape, pose: obstacle.pose }
}

fn simulate(scenario: &Scenario, streams: &Streams) -> Result<Simulation, Error> {
    let file = &scenario.file;
    Simulation::within(scenario.building(), &file.sim, scenario.start, scenario.station, streams).map_err(|error| {
        let problem = file.sites.start.span.problem(format!("the world cannot be set up: {error}"));
        Error::bad_input(
            problem.with_label("the start").with_help("the whole body of the robot must be on free floor at the start"),
        )
    })
}

fn software(scenario: &Scenario, sim: &Simulation, processes: Processes, streams: &Streams) -> Result<Software, Error> {
    use robot::Robot as _;
    let refused =
        |error: nav::Error| Error::bad_input(scenario.file.map.span.problem(error.to_string()).with_label("this map"));
    let atlas = scenario.atlas(sim.model()).map_err(refused)?;
    let software = Software::new(
        &atlas,
        &scenario.places,
        &InitialPose::at(scenario.start),
        processes,
        streams.stream("nav/localization"),
    );
    software.map_err(refused)
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
