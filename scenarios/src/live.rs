//! A scenario at work: the simulated robot, its software, the channel system and the monitors, step by step.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Event, Scheduler};
use components::{Processes, Software};
use monitors::Warnings;
use nav::InitialPose;
use robot::{Reading, Streams};
use sim::Simulation;

use crate::Error;
use crate::error::Complaints;
use crate::faults::{Fault, Happening, Injector, Run};
use crate::given_up::{GivenUp, GivenUps};
use crate::monitoring::Monitoring;
use crate::scenario::{Scenario, unknown};
use crate::tick_clock::TickClock;
use crate::trace::{Recorder, TraceHash, event_line};
use crate::tree_errors::{TreeError, TreeErrors};
use crate::wiring::{Ids, wire};

/// A robot slower than this is at rest, in m/s and rad/s.
const AT_REST: f64 = 1e-3;

/// What a step of a run brought, besides the passing of time.
#[derive(Clone, Debug)]
pub enum News {
    /// A fault took hold: its place in [`Live::faults`].
    Fault(usize),
    /// A fault let go: its place in [`Live::faults`].
    FaultOver(usize),
    /// A monitor gave its verdict: the property of this position.
    Verdict(usize),
    /// The robot came to rest at this place for the first time.
    Arrival(String),
}

/// A fault that took hold, and where.
#[derive(Clone, Debug)]
pub struct FaultRecord {
    /// When.
    pub time: Duration,
    /// When it let go; none if it still holds, or happened at one instant.
    pub until: Option<Duration>,
    /// The last tick that had been generated; none if none had.
    pub tick: Option<u64>,
    /// What.
    pub fault: Arc<Fault>,
    /// Its place in the scenario.
    pub index: usize,
    /// Where the robot was, in the `map` frame.
    pub position: maps::Point,
}

/// A fault that was due and could not be done.
#[derive(Clone, Debug)]
pub struct UndoneFault {
    /// When.
    pub time: Duration,
    /// What.
    pub fault: Arc<Fault>,
    /// Why it could not be done, in words.
    pub reason: String,
}

/// A fault of the scenario with every time that it took hold.
#[derive(Clone, Debug)]
pub struct FaultCourse<'a> {
    /// What.
    pub fault: &'a Fault,
    /// Each time, in order; at least one.
    pub records: Vec<&'a FaultRecord>,
}

impl FaultCourse<'_> {
    /// The first time.
    #[must_use]
    pub fn first(&self) -> &FaultRecord {
        self.records[0]
    }

    /// What the fault did, in words, and how often if more than once.
    #[must_use]
    pub fn words(&self) -> String {
        let words = self.fault.words();
        match self.records.len() {
            1 => words,
            times => format!("{words} ({times} times)"),
        }
    }
}

/// A property that is being watched, with what its monitor has said.
#[derive(Clone, Debug)]
pub struct Watched {
    /// The property's name.
    pub name: String,
    /// Its formula.
    pub formula: String,
    /// What it asks for, in a few words.
    pub summary: String,
    /// The event at which the verdict fell.
    pub decided: Option<Event>,
}

/// A place and when the robot first came to rest there.
#[derive(Clone, Debug)]
pub struct Visit {
    /// The place's name.
    pub place: String,
    /// When.
    pub at: Option<Duration>,
}

/// Sums over the steps of a run.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// The least charge there was, in percent.
    pub minimum_pct: f64,
    /// Ticks that could not be delivered.
    pub overruns: u64,
    steps: u64,
    squared_m2: f64,
    max_m: f64,
    squared_rad2: f64,
}

impl Tally {
    /// Root mean square and maximum of localization's error of position, in metres, and root mean square of its error
    /// of heading, in radians.
    #[must_use]
    pub fn localization_error(&self) -> (f64, f64, f64) {
        let steps = self.steps.max(1) as f64;
        ((self.squared_m2 / steps).sqrt(), self.max_m, (self.squared_rad2 / steps).sqrt())
    }
}

/// A scenario at work.
///
/// A [`step`](Self::step) does, in this order: faults that are due, physics and sensors, drivers, timers that are due,
/// the tick if it is time for one, and then the channel system until it is quiet.
pub struct Live {
    scenario: Arc<Scenario>,
    sim: Simulation,
    software: Software,
    system: ChannelSystem,
    scheduler: Box<dyn Scheduler>,
    ids: Ids,
    /// The events of the last step.
    events: Vec<Event>,
    watched: Vec<Watched>,
    /// None in a run without monitors.
    monitoring: Option<Arc<Monitoring>>,
    injector: Injector,
    faults: Vec<FaultRecord>,
    undone: Vec<UndoneFault>,
    tree_errors: TreeErrors,
    given_up: GivenUps,
    visits: Vec<Visit>,
    tick_clock: TickClock,
    tally: Tally,
    hash: TraceHash,
}

impl Live {
    /// The scenario at its start, with that root seed; without monitors if `watch` is false.
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
        let watched = monitoring.iter().flat_map(|monitoring| monitoring.properties());
        let watched = watched.map(|(watched, _)| watched.clone()).collect();
        let mut complaints = Complaints::default();
        let injector = Injector::new(&scenario, &sim, &wired.system, wired.ids, &streams, &mut complaints);
        complaints.check()?;
        let visits = scenario.places.iter().map(|(name, _)| Visit { place: name.to_owned(), at: None }).collect();
        Ok(Self {
            tally: Tally { minimum_pct: sim.truth().battery().charge_pct, ..Tally::default() },
            tick_clock: TickClock::new(scenario.file.execution.tick),
            scenario,
            sim,
            software,
            system: wired.system,
            scheduler: wired.scheduler,
            ids: wired.ids,
            events: Vec::new(),
            watched,
            monitoring,
            injector,
            faults: Vec::new(),
            undone: Vec::new(),
            tree_errors: TreeErrors::default(),
            given_up: GivenUps::default(),
            visits,
            hash: TraceHash::default(),
        })
    }

    /// Lets one step pass. Events go to `recorder` as well, if there is one.
    ///
    /// # Errors
    /// [`StepError::Run`] if the processes cannot go on, [`StepError::Record`] if the recorder cannot.
    pub fn step(&mut self, recorder: Option<&mut Recorder>) -> Result<Vec<News>, StepError> {
        let mut news = Vec::new();
        self.apply_faults(&mut news);
        self.sim.step();
        let now = self.sim.time();
        self.software.step(&mut self.sim, &mut self.system, now);
        self.enter_step_into_trace();
        self.system.advance(now);
        self.communicate(now, recorder)?;
        self.note_tree_errors(now);
        self.given_up.note(&self.software, now);
        self.note_verdicts(&mut news);
        self.note_arrivals(now, &mut news);
        self.add_to_tally();
        Ok(news)
    }

    fn apply_faults(&mut self, news: &mut Vec<News>) {
        let Self { sim, software, system, events, injector, .. } = self;
        let happenings = injector.act(&mut Run { sim, software, system, events });
        let (time, tick) = (self.sim.time(), self.system.ticks().checked_sub(1));
        for happening in happenings {
            match happening {
                Happening::Begun(index) => {
                    let position = self.sim.truth().pose().translation.vector.into();
                    let fault = Arc::clone(self.injector.fault(index));
                    news.push(News::Fault(self.faults.len()));
                    self.faults.push(FaultRecord { time, until: None, tick, fault, index, position });
                }
                Happening::LeftUndone(index, error) => {
                    let fault = Arc::clone(self.injector.fault(index));
                    self.undone.push(UndoneFault { time, fault, reason: error.to_string() });
                }
                Happening::Ended(index) => {
                    let latest = self.faults.iter().rposition(|record| record.index == index);
                    let latest = latest.expect("a fault that ends has begun");
                    self.faults[latest].until = Some(time);
                    news.push(News::FaultOver(latest));
                }
            }
        }
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

    /// Generates a tick if it is time for one and runs the channel system until it is quiet. What happens is recorded as it
    /// does, so that a run that cannot go on leaves behind all that led to that.
    fn communicate(&mut self, now: Duration, mut recorder: Option<&mut Recorder>) -> Result<(), StepError> {
        let topology = Arc::clone(self.system.topology());
        let Self { system, scheduler, events, hash, .. } = self;
        events.clear();
        let mut enter = |event: Event| -> std::io::Result<()> {
            let line = event_line(&event, &topology);
            hash.line(&line);
            events.push(event);
            recorder.as_deref_mut().map_or(Ok(()), |recorder| recorder.line(&line))
        };
        if self.tick_clock.is_due(now, || self.injector.delay_of_tick()) {
            let (event, delivered) = system.generate_tick(self.ids.tick_generator);
            self.tally.overruns += u64::from(!delivered);
            enter(event)?;
        }
        let budget = self.scenario.file.execution.step_budget;
        let mut failure = None;
        for event in system.run(scheduler.as_mut(), budget) {
            match event {
                Ok(event) => enter(event)?,
                Err(error) => failure = Some(error),
            }
        }
        if let Some(recorder) = recorder.filter(|_| !self.events.is_empty()) {
            recorder.statuses(self.system.ticks().saturating_sub(1), now, self.statuses_json())?;
        }
        let limit = self.scenario.file.execution.run_budget;
        match failure {
            Some(error) => Err(error.into()),
            None if self.system.steps() > limit => Err(StepError::Budget(limit)),
            None => Ok(()),
        }
    }

    /// The tree's statuses as the event log writes them: by the node's number and label.
    fn statuses_json(&self) -> serde_json::Value {
        let states = self.tree_states();
        let named = self.scenario.tree.nodes().iter().zip(&states).map(|(node, state)| {
            let name = format!("{} {}", node.id(), node.label());
            (name, state.outcome.map_or(serde_json::Value::Null, |outcome| outcome.name().into()))
        });
        serde_json::Value::Object(named.collect())
    }

    fn note_tree_errors(&mut self, now: Duration) {
        if !self.events.is_empty() {
            let tick = self.system.ticks().saturating_sub(1);
            self.tree_errors.note(bt::faults_in(&self.system, self.ids.tree), tick, now);
        }
    }

    fn note_verdicts(&mut self, news: &mut Vec<News>) {
        for (index, (watched, attached)) in self.watched.iter_mut().zip(self.system.monitors()).enumerate() {
            if watched.decided.is_none() && attached.decided.is_some() {
                watched.decided.clone_from(&attached.decided);
                news.push(News::Verdict(index));
            }
        }
    }

    fn note_arrivals(&mut self, now: Duration, news: &mut Vec<News>) {
        let truth = self.sim.truth();
        if truth.linear_mps().abs() > AT_REST || truth.angular_radps().abs() > AT_REST {
            return;
        }
        let pose = truth.pose();
        for visit in self.visits.iter_mut().filter(|visit| visit.at.is_none()) {
            if self.scenario.places.get(&visit.place).is_some_and(|place| place.contains(&pose)) {
                visit.at = Some(now);
                news.push(News::Arrival(visit.place.clone()));
            }
        }
    }

    fn add_to_tally(&mut self) {
        let (truth, tally) = (self.sim.truth(), &mut self.tally);
        tally.minimum_pct = tally.minimum_pct.min(truth.battery().charge_pct);
        let (really, believed) = (truth.pose(), self.software.estimate().pose);
        let squared_m2 = (really.translation.vector - believed.translation.vector).norm_squared();
        let turn_rad = maps::wrap_angle(maps::heading(&really) - maps::heading(&believed));
        tally.steps += 1;
        tally.squared_m2 += squared_m2;
        tally.squared_rad2 += turn_rad * turn_rad;
        tally.max_m = tally.max_m.max(squared_m2.sqrt());
    }

    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// Time since the start of the run.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.sim.time()
    }

    /// The simulated world as it really is.
    #[must_use]
    pub fn truth(&self) -> sim::Truth<'_> {
        self.sim.truth()
    }

    /// The software that drives the robot.
    #[must_use]
    pub fn software(&self) -> &Software {
        &self.software
    }

    /// The channel system.
    #[must_use]
    pub fn system(&self) -> &ChannelSystem {
        &self.system
    }

    /// The events of the last step, in order.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// How the nodes of the tree stand, in document order.
    #[must_use]
    pub fn tree_states(&self) -> Vec<bt::NodeState> {
        bt::states_in(&self.scenario.tree, &self.system, self.ids.tree)
    }

    /// The properties that are watched, in the order of the scenario.
    #[must_use]
    pub fn watched(&self) -> &[Watched] {
        &self.watched
    }

    /// What looks wrong with the property files, though they are accepted.
    #[must_use]
    pub fn warnings(&self) -> &[Warnings] {
        self.monitoring.as_ref().map_or(&[], |monitoring| monitoring.warnings())
    }

    /// The faults that have taken hold so far.
    #[must_use]
    pub fn faults(&self) -> &[FaultRecord] {
        &self.faults
    }

    /// The faults that were due so far and could not be done.
    #[must_use]
    pub fn undone_faults(&self) -> &[UndoneFault] {
        &self.undone
    }

    /// The trips that navigation has given up so far.
    #[must_use]
    pub fn given_up(&self) -> &[GivenUp] {
        self.given_up.all()
    }

    /// What has gone wrong in the tree so far.
    #[must_use]
    pub fn tree_errors(&self) -> &[TreeError] {
        self.tree_errors.all()
    }

    /// Whether the fault of this position in [`faults`](Self::faults) took hold then for the first time.
    #[must_use]
    pub fn is_first_time(&self, position: usize) -> bool {
        let index = self.faults[position].index;
        self.faults[..position].iter().all(|record| record.index != index)
    }

    /// The faults that have taken hold so far, each with all its times, in the order of the first.
    #[must_use]
    pub fn fault_courses(&self) -> Vec<FaultCourse<'_>> {
        courses(&self.faults)
    }

    /// How many messages a fault of the scenario has damaged so far; nothing for a fault that damages none.
    #[must_use]
    pub fn messages_hit(&self, record: &FaultRecord) -> Option<u64> {
        self.injector.messages_hit(record.index, &self.system)
    }

    /// The places, with when each was reached.
    #[must_use]
    pub fn visits(&self) -> &[Visit] {
        &self.visits
    }

    /// Sums over the steps so far.
    #[must_use]
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The hash of the trace so far.
    #[must_use]
    pub fn trace_hash(&self) -> String {
        self.hash.finish()
    }
}

/// Groups what faults did by fault.
pub(crate) fn courses(records: &[FaultRecord]) -> Vec<FaultCourse<'_>> {
    let mut courses: Vec<FaultCourse<'_>> = Vec::new();
    for record in records {
        match courses.iter_mut().find(|course| course.first().index == record.index) {
            Some(course) => course.records.push(record),
            None => courses.push(FaultCourse { fault: &record.fault, records: vec![record] }),
        }
    }
    courses
}

/// Why a run cannot go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The processes cannot go on.
    #[error(transparent)]
    Run(#[from] channels::RunError),
    /// There have been more communications than this, as many as the scenario allows.
    #[error("there have been more than {0} communications")]
    Budget(u64),
    /// The event log cannot be written.
    #[error(transparent)]
    Record(#[from] std::io::Error),
}

fn simulate(scenario: &Scenario, streams: &Streams) -> Result<Simulation, Error> {
    let file = &scenario.file;
    Simulation::within(scenario.building(), &file.sim, scenario.start, scenario.station, streams).map_err(|error| {
        let problem = file.sites.start.span.problem(format!("the world cannot be set up: {error}"));
        Error::bad_input(
            problem.with_label("the start").with_help("the robot starts with its whole body on free floor"),
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
    let known = || monitoring.properties().iter().map(|(watched, _)| watched.name.as_str());
    let expected = scenario.file.expect.outcomes.iter().map(|(name, _)| name);
    let named = expected.chain(scenario.file.stop.on_violation.names());
    for name in named.filter(|name| !known().any(|other| other == name.value)) {
        complaints.push(unknown("property", name, known()));
    }
    complaints.check()?;
    for (_, monitor) in monitoring.properties() {
        system.attach(Box::new(monitor.clone()));
    }
    Ok(monitoring)
}
