//! Random systems: program graphs that communicate at random, a client that gives up on a server, and a sensor that an
//! environment drives; or a keeper, in which much waits.

use std::fmt;
use std::mem::discriminant;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use channels::{
    Action, Capacity, ChannelId, ChannelSystem, Domain, Envelope, Event, FieldKind, GraphMonitor, GraphProcess, Label,
    Message, Monitor, NoNormalForm, NormalForm, Offer, Pattern, Process, ProcessId, ProgramGraph, Random,
    RequestNumber, Role, Scheduler, Shape, Slot, TickGenerator, Topology, TransitionId, Use, Value, Verdict,
};
use explorer::{
    AnyEnvironment, Closed, Environment, Exploration, Instant, Limits, MessageFaults, Model, Move, Onlooker, Order,
    Outcome, Path, Progress, Reduction, Ticks, explore,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::keepers;
use crate::naive::{Counts, Findings, Locations, enumerate, location};

pub(crate) const PERIOD: Duration = Duration::from_secs(10);

/// A system, and what surrounds it.
pub(crate) struct Sample {
    pub(crate) system: ChannelSystem,
    pub(crate) ticks: Ticks,
    pub(crate) environment: Arc<AnyEnvironment>,
    pub(crate) monitor: Option<GraphMonitor>,
}

pub(crate) fn sample(seed: u64) -> Sample {
    varied(seed, |patience_s| patience_s, None)
}

/// The same, with a client that waits for this number of seconds, or forever if there is none, and with another
/// transition in the graph of process A.
fn varied(seed: u64, patience_s: impl Fn(u64) -> u64, another: Option<u64>) -> Sample {
    if keepers::is_one(seed) {
        return keepers::sample(seed, patience_s, another);
    }
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut topology = Topology::default();
    let mut process = |name: &str| topology.process(name).expect("a new name");
    let (generator, client, server, sensor) =
        (process("Ticks"), process("Client"), process("Server"), process("Sensor"));
    let graphs: Vec<ProcessId> = ["A", "B", "C"][..rng.random_range(1..=3)].iter().map(|name| process(name)).collect();
    let tick = Domain::new([TickGenerator::shape()]);
    let ticks = topology.channel(generator, client, Capacity::One, tick).expect("a new channel");
    let asked = topology.channel(client, server, Capacity::One, words(Role::Request)).expect("a new channel");
    let answered = topology.channel(server, client, Capacity::One, words(Role::Reply)).expect("a new channel");
    let level = Domain::new([Shape::new([("level", FieldKind::Int)]).with_role(Role::Topic)]);
    let sensed = topology.channel(sensor, graphs[0], Capacity::One, level).expect("a new channel");
    let notified = topology.channel(server, graphs[0], Capacity::One, words(Role::Request)).expect("a new channel");
    let mut lines = Vec::new();
    for from in &graphs {
        for to in graphs.iter().filter(|to| *to != from) {
            if rng.random_bool(0.7) {
                let capacity = if rng.random_bool(0.5) { Capacity::One } else { Capacity::Zero };
                let role = if rng.random_bool(0.2) && capacity == Capacity::One { Role::Topic } else { Role::Request };
                lines.push((*from, *to, topology.channel(*from, *to, capacity, words(role)).expect("a new channel")));
            }
        }
    }
    // Some environments also show the level to the monitor, which no process hears.
    let shown = rng.random_bool(0.2).then(|| {
        let [sky, eyes] = ["Sky", "Eyes"].map(|name| topology.outside(name).expect("a new name"));
        let level = Domain::new([Shape::new([("level", FieldKind::Int)])]);
        topology.channel(sky, eyes, Capacity::Zero, level).expect("a new channel")
    });
    let watched: Vec<ChannelId> = topology.channels().collect();
    let mut processes: Vec<(ProcessId, Box<dyn Process>)> = vec![
        (generator, Box::new(TickGenerator::new(ticks))),
        (client, Box::new(Client::new(ticks, asked, answered, patience_s(rng.random_range(3..=14))))),
        (
            server,
            Box::new(Server {
                asked,
                answered,
                notified,
                pending: None,
                announces: None,
                forgets: rng.random_bool(0.5),
            }),
        ),
        (sensor, Box::new(Sensor { sensed, level: 0, waits: false })),
    ];
    for (index, id) in graphs.iter().enumerate() {
        let sends: Vec<ChannelId> = lines.iter().filter(|line| line.0 == *id).map(|line| line.2).collect();
        let mut receives: Vec<ChannelId> = (index == 0).then_some([sensed, notified]).into_iter().flatten().collect();
        receives.extend(lines.iter().filter(|line| line.1 == *id).map(|line| line.2));
        let another = another.filter(|_| index == 0);
        processes.push((*id, Box::new(GraphProcess::new(graph(rng, &sends, &receives, another)))));
    }
    let system = ChannelSystem::new(Arc::new(topology), processes).expect("a sound system");
    let first = Duration::from_secs(rng.random_range(0..=3));
    Sample {
        monitor: rng.random_bool(0.7).then(|| monitor(rng, &watched)),
        system,
        ticks: Ticks { generator, period: PERIOD, first, step: Duration::ZERO },
        environment: Weather { sensor, shown }.erased(),
    }
}

/// The messages of one word.
pub(crate) fn words(role: Role) -> Domain {
    Domain::new([Shape::new([("word", FieldKind::symbols(["a", "b"]))]).with_role(role)])
}

fn word(rng: &mut (impl Rng + ?Sized)) -> Message {
    Message::symbols([if rng.random_bool(0.5) { "a" } else { "b" }])
}

/// Random locations and transitions; a variable keeps the last message.
pub(crate) fn graph(
    rng: &mut impl Rng,
    sends: &[ChannelId],
    receives: &[ChannelId],
    another: Option<u64>,
) -> Arc<ProgramGraph> {
    let mut graph = ProgramGraph::builder("graph");
    let locations: Vec<_> = (0..rng.random_range(2..=4)).map(|index| graph.location(&format!("l{index}"))).collect();
    let last = graph.variable("last");
    let mut add = |rng: &mut dyn Rng| {
        let [from, to] = [(); 2].map(|()| locations[rng.random_range(0..locations.len())]);
        match rng.random_range(0..5) {
            0 if from != to => _ = graph.transition(from, Label::Internal(Vec::new()), to),
            1 | 2 if !sends.is_empty() => {
                let channel = sends[rng.random_range(0..sends.len())];
                graph.send(from, channel, word(rng), to);
            }
            _ if !receives.is_empty() => {
                let channel = receives[rng.random_range(0..receives.len())];
                let slot = if channel == receives[0] || rng.random_bool(0.6) {
                    Slot::Variable(last)
                } else {
                    Slot::Given(word(rng))
                };
                graph.transition(from, Label::Receive(channel, slot), to);
            }
            _ => {}
        }
    };
    for _ in 0..rng.random_range(3..=7) {
        add(rng);
    }
    another.into_iter().for_each(|seed| add(&mut ChaCha8Rng::seed_from_u64(seed)));
    Arc::new(graph.initial(locations[0]).build().expect("a sound graph"))
}

/// Violated partway along a random sequence of messages and ticks.
fn monitor(rng: &mut impl Rng, channels: &[ChannelId]) -> GraphMonitor {
    let mut graph = ProgramGraph::builder("property");
    let locations: Vec<_> = (0..4).map(|index| graph.location(&format!("m{index}"))).collect();
    let seen = graph.variable("seen");
    for (from, to) in [(0, 1), (1, 2), (2, 3), (1, 0), (2, 1), (2, 0)] {
        let label = if rng.random_bool(0.3) {
            Label::Tick(seen)
        } else {
            Label::Receive(channels[rng.random_range(0..channels.len())], Slot::Variable(seen))
        };
        graph.transition(locations[from], label, locations[to]);
    }
    GraphMonitor::new(Arc::new(graph.initial(locations[0]).build().expect("a sound graph")), [locations[3]])
}

/// Asks the server at each tick, and gives up after a while.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Client {
    ticks: ChannelId,
    asked: ChannelId,
    answered: ChannelId,
    patience: Duration,
    number: RequestNumber,
    /// Whether the request has been sent.
    open: Option<bool>,
    deadline: Option<Duration>,
    ticked: u64,
}

impl Client {
    pub(crate) fn new(ticks: ChannelId, asked: ChannelId, answered: ChannelId, patience_s: u64) -> Self {
        let patience = Duration::from_secs(patience_s);
        Self { ticks, asked, answered, patience, number: RequestNumber(0), open: None, deadline: None, ticked: 0 }
    }
}

impl Process for Client {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let receive = |number, channel| Offer {
            transition: TransitionId(number),
            action: Action::Receive(channel, Pattern::Any),
        };
        if self.open.is_none() {
            offers.push(receive(0, self.ticks));
        }
        if self.open == Some(false) {
            let envelope = Envelope { message: Message::symbols(["a"]), request: self.number };
            offers.push(Offer { transition: TransitionId(1), action: Action::Send(self.asked, envelope) });
        }
        offers.push(receive(2, self.answered));
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        match (transition.0, received) {
            (0, _) => {
                self.ticked += 1;
                self.number.0 += 1;
                self.open = Some(false);
                self.deadline = (!self.patience.is_zero()).then(|| now + self.patience);
            }
            (1, _) => self.open = Some(true),
            (_, Some(envelope)) if self.open == Some(true) && envelope.request == self.number => {
                self.open = None;
                self.deadline = None;
            }
            _ => {}
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.deadline
    }

    fn fire_timers(&mut self, _now: Duration) {
        self.open = None;
        self.deadline = None;
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Receives(self.ticks, None), Use::Sends(self.asked, None), Use::Receives(self.answered, None)]
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        requests.extend(self.open.map(|_| (self.asked, self.number)));
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        form.number(self.asked, &mut self.number);
        self.deadline.iter_mut().for_each(|deadline| form.time(deadline));
        self.ticked = 0;
        Ok(())
    }

    fn location(&self) -> String {
        format!("{:?}", self.open)
    }
}

/// Answers the client, after telling another process; or forgets to answer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Server {
    asked: ChannelId,
    answered: ChannelId,
    notified: ChannelId,
    pending: Option<RequestNumber>,
    announces: Option<RequestNumber>,
    forgets: bool,
}

impl Process for Server {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let mut offer = |number, action| offers.push(Offer { transition: TransitionId(number), action });
        if self.pending.is_none() && self.announces.is_none() {
            offer(0, Action::Receive(self.asked, Pattern::Any));
        }
        if self.pending.is_some() {
            offer(1, Action::Send(self.notified, Message::symbols(["b"]).into()));
            if self.forgets {
                offer(2, Action::Internal);
            }
        }
        if let Some(request) = self.announces {
            offer(3, Action::Send(self.answered, Envelope { message: Message::symbols(["b"]), request }));
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        match transition.0 {
            0 => self.pending = received.map(|envelope| envelope.request),
            1 => self.announces = self.pending.take(),
            2 => self.pending = None,
            _ => self.announces = None,
        }
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Receives(self.asked, None), Use::Sends(self.answered, None), Use::Sends(self.notified, None)]
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.pending.iter_mut().chain(&mut self.announces).for_each(|number| form.number(self.asked, number));
        Ok(())
    }

    fn location(&self) -> String {
        format!("{:?}", self.pending)
    }
}

/// Publishes its level when it changes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Sensor {
    sensed: ChannelId,
    level: i64,
    waits: bool,
}

impl Process for Sensor {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let message = Message::new([Value::Int(self.level)]);
        let action = Action::Send(self.sensed, message.into());
        offers.extend(self.waits.then_some(Offer { transition: TransitionId(0), action }));
    }

    fn take(&mut self, _transition: TransitionId, _received: Option<Envelope>, _now: Duration) {
        self.waits = false;
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Sends(self.sensed, None)]
    }

    fn normalize(&mut self, _form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        Ok(())
    }

    fn location(&self) -> String {
        self.level.to_string()
    }
}

/// Changes the level by one at a tick, and may make the sensor publish it at any moment.
#[derive(Debug)]
struct Weather {
    sensor: ProcessId,
    /// Where the monitor is shown the level.
    shown: Option<ChannelId>,
}

impl Environment for Weather {
    /// The level.
    type State = i64;

    fn driven(&self) -> &[ProcessId] {
        std::slice::from_ref(&self.sensor)
    }

    fn start(&self) -> i64 {
        0
    }

    fn moves(&self, state: &i64, driven: &[&dyn Process], instant: Instant) -> Vec<Move<i64>> {
        let sensor = driven[0].as_any().downcast_ref::<Sensor>().expect("a sensor");
        let to = |level: i64, waits: bool| Move {
            state: level,
            reports: [2 * level as u32 + u32::from(waits)].into_iter().collect(),
        };
        match instant {
            Instant::Between => vec![to(sensor.level, false), to(*state, true)],
            Instant::Tick => [-1, 0, 1].map(|by| to((state + by).clamp(0, 2), false)).to_vec(),
        }
    }

    fn report(&self, _id: ProcessId, report: u32, process: &mut dyn Process, _now: Duration) {
        let sensor = process.as_any_mut().downcast_mut::<Sensor>().expect("a sensor");
        (sensor.level, sensor.waits) = (i64::from(report / 2), sensor.waits || report % 2 == 1);
    }

    fn shown(&self, before: &i64, after: &i64) -> Option<(ChannelId, Message)> {
        let channel = self.shown.filter(|_| before != after)?;
        Some((channel, Message::new([Value::Int(*after)])))
    }

    fn words(&self, state: &i64, driven: &[&dyn Process], instant: Instant) -> Vec<String> {
        self.moves(state, driven, instant).iter().map(|to| format!("the level is {}", to.state)).collect()
    }
}

/// What may happen to the messages of some channels; in most systems, nothing.
pub(crate) fn message_faults(seed: u64, system: &ChannelSystem) -> MessageFaults {
    let rng = &mut ChaCha8Rng::seed_from_u64(!seed);
    let topology = system.topology();
    let has_room = |id: &ChannelId| topology.get(*id).capacity == Capacity::One;
    let channels = topology.channels().filter(has_room).skip(1).filter(|_| rng.random_bool(0.4)).collect();
    match seed % 4 {
        0 => MessageFaults { lost: rng.random_range(1..=2), channels, ..MessageFaults::default() },
        1 => MessageFaults {
            delayed: (1, Duration::from_secs(rng.random_range(1..=12))),
            channels,
            ..MessageFaults::default()
        },
        _ => MessageFaults::default(),
    }
}

/// Records the locations of processes.
#[derive(Debug, Default)]
struct Notes(Mutex<Locations>);

impl Onlooker for Notes {
    fn see(&self, id: ProcessId, process: &dyn Process) {
        self.0.lock().expect("no panic").insert((id.index(), location(process)));
    }
}

/// What a search without a property found, and where it saw processes.
fn findings(model: Model, limits: &Limits) -> Findings {
    let notes = Arc::new(Notes::default());
    let model = model.with_onlooker(Arc::clone(&notes) as Arc<dyn Onlooker>);
    let found = explore(&model, None, limits, &mut |_| ()).expect("a finite model");
    let (mut deadlock, mut livelock) = (false, false);
    match &found.outcome {
        Outcome::Proved => {}
        Outcome::Deadlock(path) => {
            deadlock = true;
            let mut end = path.replay(&model, None).expect("a run of the channel system").system;
            assert!(end.enabled().is_empty());
        }
        Outcome::Livelock(path) => {
            livelock = true;
            assert!(path.cycle() > 0 && path.replay(&model, None).expect("a run of the channel system").comes_back);
        }
        // The search ends there, and has not seen everything.
        Outcome::Endless(_) => {
            check_run(&found.outcome, &model, None, "no property");
            return Findings { endless: true, ..Findings::default() };
        }
        outcome => panic!("{outcome:?}"),
    }
    let locations = notes.0.lock().expect("no panic").clone();
    Findings { endless: false, deadlock, livelock, locations }
}

/// Replays the run that an outcome shows: it violates the property, or messages pile up at its end.
fn check_run(outcome: &Outcome, model: &Model, property: Option<&dyn Monitor>, what: &str) {
    let replay = |path: &Path| path.replay(model, property).expect("a run of the channel system");
    match outcome {
        Outcome::Violated(path) => assert_eq!(replay(path).verdict(), Verdict::False, "{what}: {path:#?}"),
        Outcome::Endless(path) => assert!(keepers::is_piled_up(&replay(path).system), "{what}: {path:#?}"),
        _ => {}
    }
}

#[test]
fn without_a_property_the_search_finds_what_a_naive_enumeration_finds() {
    let (mut endless, mut deadlocks, mut livelocks, mut neither) = (0, 0, 0, 0);
    for seed in 0..165 {
        let Sample { system, ticks, environment, .. } = varied(seed, |patience_s| patience_s * (seed % 2), None);
        // A state from which the environment can always wake the system is no deadlock.
        let environment = if seed % 2 == 0 { Closed.erased() } else { environment };
        let faults = message_faults(seed, &system);
        let (_, mut expected) = enumerate(&system, Some(ticks), environment.as_ref(), &faults, None);
        // Where messages pile up, the search ends.
        if expected.endless {
            expected = Findings { endless: true, ..Findings::default() };
        }
        endless += usize::from(expected.endless);
        deadlocks += usize::from(expected.deadlock);
        livelocks += usize::from(expected.livelock);
        neither += usize::from(!expected.endless && !expected.deadlock && !expected.livelock);
        // It reports only one of the two.
        expected.livelock &= !expected.deadlock;
        for reduction in [Reduction::Off, Reduction::On] {
            let model = Model::new(&system, Some(ticks), Arc::clone(&environment)).with_message_faults(faults.clone());
            let found = findings(model, &Limits { reduction, ..Limits::default() });
            assert_eq!(found, expected, "seed {seed}, {reduction:?}");
        }
    }
    let tally = format!("endless {endless}, deadlocks {deadlocks}, livelocks {livelocks}, neither {neither}");
    assert!(endless > 0 && deadlocks > 10 && livelocks > 10 && neither > 10, "{tally}");
}

#[test]
fn the_search_finds_what_a_naive_enumeration_finds() {
    const SYSTEMS: u64 = 440;
    let limits = |threads| Limits { threads, reduction: Reduction::Off, ..Limits::default() };
    let (mut proved, mut violated, mut largest, mut passed_through) = (0, 0, 0, 0);
    let (mut keepers, mut piled_up) = (0, 0);
    for seed in 0..SYSTEMS {
        let Sample { system, ticks, environment, monitor } = sample(seed);
        let property = monitor.as_ref().map(|monitor| monitor as &dyn Monitor);
        let faults = message_faults(seed, &system);
        let (expected, others) = enumerate(&system, Some(ticks), environment.as_ref(), &faults, property);
        let model = Model::new(&system, Some(ticks), environment).with_message_faults(faults);
        let check = |it: &Exploration| check_run(&it.outcome, &model, property, &format!("seed {seed}"));
        let found = explore(&model, property, &limits(1), &mut |_| ()).expect("a finite model");
        check(&found);
        let shown = format!("{:?}", found.outcome);
        let is_endless = matches!(found.outcome, Outcome::Endless(_));
        keepers += u64::from(keepers::is_one(seed));
        piled_up += u64::from(is_endless);
        match &found.outcome {
            Outcome::Violated(_) => {
                violated += 1;
                assert_eq!(expected.violated, Some(found.progress.depth + 1), "seed {seed}");
            }
            // Without a property, the search ends there.
            Outcome::Endless(_) if property.is_none() => {}
            Outcome::Proved | Outcome::Deadlock(_) | Outcome::Livelock(_) | Outcome::Endless(_) => {
                proved += usize::from(!is_endless);
                let Progress { states, quiet, .. } = found.progress;
                let counts = Counts { states, quiet, transitions: found.transitions, violated: None };
                assert_eq!(counts, expected, "seed {seed}");
                largest = largest.max(states);
            }
            outcome => panic!("seed {seed}: {outcome:?}"),
        }
        assert!(expected.violated.is_some() || others.endless == is_endless, "seed {seed}: {shown}");
        let reduced = explore(&model, property, &Limits { reduction: Reduction::On, ..limits(1) }, &mut |_| ())
            .expect("a finite model");
        assert_eq!(discriminant(&reduced.outcome), discriminant(&found.outcome), "seed {seed}");
        check(&reduced);
        if matches!(reduced.outcome, Outcome::Proved) {
            assert_eq!(reduced.progress.quiet, found.progress.quiet, "seed {seed}");
            passed_through += found.progress.states - reduced.progress.states;
        }
        let deep = explore(&model, property, &Limits { order: Order::Depth, ..limits(1) }, &mut |_| ());
        let deep = deep.expect("a finite model");
        assert_eq!(discriminant(&deep.outcome), discriminant(&found.outcome), "seed {seed}");
        check(&deep);
        // Without a violation, all that can be reached is searched.
        if matches!(deep.outcome, Outcome::Proved) || is_endless {
            assert_eq!((deep.progress.states, deep.transitions), (found.progress.states, found.transitions));
        }
        let in_parallel = explore(&model, property, &limits(2), &mut |_| ()).expect("a finite model");
        assert_eq!((in_parallel.progress, in_parallel.transitions), (found.progress, found.transitions), "seed {seed}");
        assert_eq!(format!("{:?}", in_parallel.outcome), shown, "seed {seed}");
    }
    eprintln!(
        "{violated} runs that violate a property, all of them replayed; {keepers} of {SYSTEMS} systems with a keeper, \
        and in {piled_up} of them, more waits than is searched"
    );
    assert!(passed_through > 1000, "{passed_through}");
    assert!(proved > 50 && violated > 50 && largest > 1000, "{proved} proved, {violated} violated, {largest} states");
    assert!(keepers * 20 >= SYSTEMS, "5 % of the systems have a keeper, not {keepers} of {SYSTEMS}");
    assert!(piled_up > 2 && keepers - piled_up > 5, "too much waits in {piled_up} of {keepers} keepers");
}

#[test]
fn a_process_that_is_allowed_in_place_of_another_changes_nothing() {
    let limits = Limits { reduction: Reduction::Off, ..Limits::default() };
    let (mut allowed, mut refused) = (0, 0);
    for seed in 0..440 {
        let Sample { system, ticks, environment, monitor } = sample(seed);
        let property = monitor.as_ref().map(|monitor| monitor as &dyn Monitor);
        let explored = |system: &ChannelSystem| {
            let model = Model::new(system, Some(ticks), Arc::clone(&environment));
            let model = model.with_message_faults(message_faults(seed, system));
            explore(&model, property, &limits, &mut |_| ()).expect("a finite model")
        };
        let (mut found, other) = (explored(&system), varied(seed, |patience_s| patience_s, Some(!seed)).system);
        if !matches!(found.outcome, Outcome::Proved) {
            continue;
        }
        let results = |it: &Exploration| {
            (discriminant(&it.outcome), it.progress.states, it.progress.quiet, it.progress.depth, it.transitions)
        };
        let a = system.topology().find_process("A").expect("a process");
        let mut allows = |system: &ChannelSystem| found.allows(a, system.clone_process(a).expect("a process"));
        assert!(allows(&system), "seed {seed}: it may take its own place");
        if allows(&other) {
            allowed += 1;
            assert_eq!(results(&explored(&other)), results(&found), "seed {seed}");
        } else {
            refused += 1;
        }
    }
    assert!(allowed > 30 && refused > 30, "{allowed} allowed, {refused} refused");
}

/// A random run of a model in the channel system.
struct RandomRun {
    system: ChannelSystem,
    monitor: Option<GraphMonitor>,
    /// Whether more waits, or has waited, than a search follows.
    piled_up: bool,
    /// If the property is violated, whether that was so before.
    violated: Option<bool>,
}

impl RandomRun {
    /// Looks at the system after a step.
    fn see(&mut self, event: Option<&Event>) {
        for (monitor, event) in self.monitor.iter_mut().zip(event) {
            monitor.observe(event);
            if monitor.verdict() == Verdict::False {
                self.violated = self.violated.or(Some(self.piled_up));
            }
        }
        self.piled_up |= keepers::is_piled_up(&self.system);
    }

    /// Lets processes move until none can. Returns whether they ever stop.
    fn until_quiet(&mut self, scheduler: &mut Random) -> bool {
        for _ in 0..10_000 {
            let enabled = self.system.enabled();
            if enabled.is_empty() {
                return true;
            }
            let taken = self.system.take(&enabled[scheduler.choose(&enabled)]);
            self.see(taken.expect("a message within its domain").as_ref());
        }
        false
    }

    /// Whether there is no such run if this is the outcome of a search.
    fn contradicts(&self, outcome: &Outcome) -> bool {
        match outcome {
            Outcome::Proved => self.violated.is_some() || self.piled_up,
            // A run is followed until something piles up.
            Outcome::Endless(_) => self.violated == Some(false),
            _ => false,
        }
    }
}

/// A random run until the property is violated or, without one, until messages pile up.
fn random_run(sample: &Sample, property: Option<&GraphMonitor>, rng: &mut ChaCha8Rng) -> RandomRun {
    let Sample { system, ticks, environment, .. } = sample;
    let mut run = RandomRun { system: system.fork(), monitor: property.cloned(), piled_up: false, violated: None };
    let mut scheduler = Random::new(ChaCha8Rng::seed_from_u64(rng.random()));
    let (mut now, mut next_tick, mut state) = (Duration::ZERO, ticks.first, environment.start());
    // In a keeper, a little may pile up over many ticks.
    let steps = if keepers::has_keeper(system) { 30 } else { 6 };
    for _ in 0..steps {
        if !run.until_quiet(&mut scheduler) {
            break; // a livelock
        }
        let until = run.system.next_timer().into_iter().chain([next_tick]).min().expect("the next tick");
        let instant = if until == next_tick { Instant::Tick } else { Instant::Between };
        let instant = if rng.random_bool(0.2) { Instant::Between } else { instant };
        let driven: Vec<Box<dyn Process>> =
            environment.driven().iter().map(|id| run.system.clone_process(*id).expect("a process")).collect();
        let views: Vec<&dyn Process> = driven.iter().map(AsRef::as_ref).collect();
        let mut moves = environment.moves(&state, &views, instant);
        let choice = moves.swap_remove(rng.random_range(0..moves.len()));
        state = choice.state;
        for ((id, mut process), report) in environment.driven().iter().zip(driven).zip(choice.reports) {
            environment.report(*id, report, process.as_mut(), now);
            run.system.replace(*id, process).expect("the same channels");
        }
        if instant == Instant::Tick || until != next_tick {
            run.system.advance(until);
            now = until;
        }
        run.see(None);
        if instant == Instant::Tick {
            next_tick += ticks.period;
            let (event, _) = run.system.generate_tick(ticks.generator);
            run.see(Some(&event));
        }
        if run.violated.is_some() || property.is_none() && run.piled_up {
            break;
        }
    }
    run
}

/// How many systems were compared with random runs.
#[derive(Clone, Debug, Default)]
struct Tally {
    systems: u64,
    proved: u64,
    violated: u64,
    /// Violations that were seen in a random run.
    seen: u64,
    /// Properties that are not decided, since messages pile up.
    undecided: u64,
    keepers: u64,
    /// Keepers in which messages pile up.
    piled_up: u64,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { systems, proved, violated, seen, undecided, keepers, piled_up } = self;
        write!(f, "{systems} systems, {keepers} with a keeper; more waits in {piled_up} of these than is searched; ")?;
        write!(f, "{proved} properties proved, {undecided} undecided, {violated} violated, {seen} of them in a run")
    }
}

impl Tally {
    /// Compares what is said of a property with this number of random runs.
    fn compare(&mut self, seed: u64, sample: &Sample, property: &GraphMonitor, runs: usize) {
        let model = Model::new(&sample.system, Some(sample.ticks), Arc::clone(&sample.environment));
        let found = explore(&model, Some(property), &Limits::default(), &mut |_| ()).expect("a finite model");
        check_run(&found.outcome, &model, Some(property), &format!("seed {seed}"));
        let count = match &found.outcome {
            Outcome::Proved => &mut self.proved,
            Outcome::Endless(_) => &mut self.undecided,
            Outcome::Violated(_) => &mut self.violated,
            outcome => panic!("seed {seed}: {outcome:?}"),
        };
        if *count >= 50 {
            return;
        }
        *count += 1;
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..runs {
            let run = random_run(sample, Some(property), rng);
            assert!(!run.contradicts(&found.outcome), "seed {seed}: a run contradicts {:?}", found.outcome);
            if matches!(found.outcome, Outcome::Violated(_)) && run.violated.is_some() {
                self.seen += 1;
                break;
            }
        }
    }

    /// In no run do messages pile up unless the search says so.
    fn compare_progress(&mut self, seed: u64, sample: &Sample, runs: usize) {
        let model = Model::new(&sample.system, Some(sample.ticks), Arc::clone(&sample.environment));
        let found = explore(&model, None, &Limits::default(), &mut |_| ()).expect("a finite model");
        check_run(&found.outcome, &model, None, &format!("seed {seed}"));
        self.keepers += 1;
        if matches!(found.outcome, Outcome::Endless(_)) {
            self.piled_up += 1;
            return;
        }
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let piles_up = (0..runs).any(|_| random_run(sample, None, rng).piled_up);
        assert!(!piles_up, "seed {seed}: messages pile up in a run, in spite of {:?}", found.outcome);
    }
}

#[test]
fn random_runs_do_not_contradict_a_proof() {
    no_contradiction(100);
}

#[test]
#[ignore = "takes minutes: on demand"]
fn ten_thousand_random_runs_do_not_contradict_a_proof_on_demand() {
    no_contradiction(10_000);
}

/// This number of runs for each of 50 properties that are proved, and runs until the violation for each of 50 that are
/// not; and of each system with a keeper among them.
fn no_contradiction(runs: usize) {
    let mut tally = Tally::default();
    for seed in 1000.. {
        if tally.proved >= 50 && tally.violated >= 50 {
            break;
        }
        let sample = sample(seed);
        tally.systems += 1;
        if keepers::is_one(seed) {
            tally.compare_progress(seed, &sample, runs);
        }
        if let Some(property) = &sample.monitor {
            tally.compare(seed, &sample, property, runs);
        }
    }
    eprintln!("{tally}");
    // Most violations that are possible happen sooner or later.
    assert!(tally.seen > 30, "{tally}");
    assert!(tally.keepers * 20 >= tally.systems, "5 % have a keeper: {tally}");
    assert!(tally.piled_up > 0 && tally.keepers > tally.piled_up, "{tally}");
}
