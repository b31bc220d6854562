//! All states of a model, by copying whole channel systems.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeSet, HashMap};
use std::hash::{Hash, Hasher};
use std::time::Duration;

use channels::{
    ChannelId, ChannelSystem, Disturbance, Effect, Enabled, EnabledKind, Event, EventKind, Monitor, NoNormalForm,
    NormalForm, Process, Verdict,
};
use explorer::{AnyEnvironment, EnvironmentState, Instant, MessageFaults, Ticks};

/// Which processes are in some state, by their indices.
pub(crate) type Locations = BTreeSet<(usize, String)>;

/// The location of a process, whether or not another process still waits for the answer to the request that it holds.
pub(crate) fn location(process: &dyn Process) -> String {
    process.location().replace("RequestNumber(0)", "RequestNumber(1)")
}

/// What a search without a property looks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Findings {
    /// Whether messages pile up in a process. What follows is not enumerated.
    pub(crate) endless: bool,
    pub(crate) deadlock: bool,
    pub(crate) livelock: bool,
    pub(crate) locations: Locations,
}

/// A transition to the state with this number.
#[derive(Clone, Copy)]
struct Edge {
    to: usize,
    /// A process communicates, the tree takes a tick, or a timer that will fire is set.
    is_alive: bool,
    /// It communicates.
    is_step: bool,
}

/// The counts that a search and a naive enumeration have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) states: u64,
    pub(crate) quiet: u64,
    pub(crate) transitions: u64,
    /// The number of the first layer in which the property is violated.
    pub(crate) violated: Option<u64>,
}

/// A state, with everything that is outside of the channel system.
struct State {
    system: ChannelSystem,
    environment: EnvironmentState,
    has_ticked: bool,
    until_tick: Duration,
    monitor: Option<Box<dyn Monitor>>,
    losses: u8,
    delays: u8,
    /// The remaining times for which messages are held back.
    held: Vec<Duration>,
}

impl State {
    fn fork(&self) -> Self {
        Self {
            system: self.system.fork(),
            environment: self.environment.clone(),
            has_ticked: self.has_ticked,
            until_tick: self.until_tick,
            monitor: self.monitor.clone(),
            losses: self.losses,
            delays: self.delays,
            held: self.held.clone(),
        }
    }

    fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.system.hash_state(&mut hasher);
        (&self.environment, self.has_ticked, self.until_tick, self.losses, self.delays).hash(&mut hasher);
        if let Some(monitor) = &self.monitor {
            monitor.hash_state(&mut hasher);
        }
        hasher.finish()
    }

    fn is(&self, other: &Self) -> bool {
        let same_monitor = match (&self.monitor, &other.monitor) {
            (Some(monitor), Some(other)) => monitor.same_state(other.as_ref()),
            _ => true,
        };
        same_monitor
            && self.system.same_state(&other.system)
            && self.environment == other.environment
            && self.has_ticked == other.has_ticked
            && self.until_tick == other.until_tick
            && (self.losses, self.delays) == (other.losses, other.delays)
    }

    fn observe(&mut self, kind: EventKind) {
        if let Some(monitor) = &mut self.monitor {
            let tick = u64::from(kind == EventKind::Tick && self.has_ticked);
            monitor.observe(&Event { step: 0, tick, time: Duration::ZERO, kind });
        }
    }

    fn verdict(&self) -> Verdict {
        self.monitor.as_ref().map_or(Verdict::Inconclusive, |monitor| monitor.verdict())
    }

    /// `None` if messages pile up in a process.
    fn normalize(mut self) -> Option<Self> {
        match self.system.normalize() {
            Err((_, NoNormalForm::Endless { .. })) => return None,
            normal => normal.expect("a normal form"),
        }
        if let Some(monitor) = &mut self.monitor {
            monitor.normalize().expect("a normal form");
        }
        Some(self)
    }

    fn is_endless(&self) -> bool {
        matches!(self.system.fork().normalize(), Err((_, NoNormalForm::Endless { .. })))
    }
}

/// Enumerates all states. Every timer fires exactly when it is due.
pub(crate) fn enumerate(
    start: &ChannelSystem,
    ticks: Option<Ticks>,
    environment: &AnyEnvironment,
    faults: &MessageFaults,
    monitor: Option<&dyn Monitor>,
) -> (Counts, Findings) {
    let first = State {
        system: start.fork(),
        environment: environment.start(),
        has_ticked: false,
        until_tick: ticks.map_or(Duration::ZERO, |ticks| ticks.first),
        monitor: monitor.map(Monitor::boxed_clone),
        losses: faults.lost,
        delays: faults.delayed.0,
        held: Vec::new(),
    };
    let mut counts = Counts { states: 0, quiet: 0, transitions: 0, violated: None };
    let mut known: HashMap<u64, Vec<usize>> = HashMap::new();
    let mut states: Vec<(State, u64)> = Vec::new();
    let mut findings = Findings::default();
    let mut edges: Vec<Vec<Edge>> = Vec::new();
    let mut add = |state: State, layer: u64, states: &mut Vec<(State, u64)>| {
        let topology = state.system.topology();
        for id in topology.processes().filter(|id| !topology.is_outside(*id)) {
            let process = state.system.clone_process(id).expect("a process");
            findings.locations.insert((id.index(), location(process.as_ref())));
        }
        let state = state.normalize()?;
        let alike = known.entry(state.hash()).or_default();
        Some(alike.iter().copied().find(|other| states[*other].0.is(&state)).unwrap_or_else(|| {
            alike.push(states.len());
            states.push((state, layer));
            states.len() - 1
        }))
    };
    add(first, 0, &mut states);
    let mut next = 0;
    while next < states.len() {
        let (mut state, layer) = (states[next].0.fork(), states[next].1);
        next += 1;
        if counts.violated.is_some_and(|violated| layer >= violated) {
            break;
        }
        let (successors, is_quiet) = successors(&mut state, ticks, environment, faults);
        counts.quiet += u64::from(is_quiet);
        counts.transitions += successors.len() as u64;
        let mut leading = Vec::new();
        for (successor, is_alive) in successors {
            match successor.verdict() {
                Verdict::Inconclusive => match add(successor, layer + 1, &mut states) {
                    Some(to) => leading.push(Edge { to, is_alive, is_step: !is_quiet }),
                    None => findings.endless = true,
                },
                Verdict::True => {}
                Verdict::False => counts.violated = Some(counts.violated.unwrap_or(layer + 1)),
            }
        }
        edges.push(leading);
    }
    counts.states = states.len() as u64;
    if counts.violated.is_some() {
        return (counts, findings); // not all states were visited
    }
    let leads_on = fixed_point(&edges, |edge, leads_on| edge.is_alive || leads_on[edge.to], false);
    let goes_around = fixed_point(&edges, |edge, goes_around| edge.is_step && goes_around[edge.to], true);
    findings.deadlock = leads_on.contains(&false);
    findings.livelock = goes_around.contains(&true);
    (counts, findings)
}

/// The states with an edge that is `good`, which may itself depend on the set: the least such set, or the greatest if
/// `first` holds all states.
fn fixed_point(edges: &[Vec<Edge>], good: impl Fn(&Edge, &[bool]) -> bool, first: bool) -> Vec<bool> {
    let mut states = vec![first; edges.len()];
    loop {
        let next: Vec<bool> = edges.iter().map(|edges| edges.iter().any(|edge| good(edge, &states))).collect();
        if next == states {
            return states;
        }
        states = next;
    }
}

fn successors(
    state: &mut State,
    ticks: Option<Ticks>,
    environment: &AnyEnvironment,
    faults: &MessageFaults,
) -> (Vec<(State, bool)>, bool) {
    let mut successors = Vec::new();
    let enabled = state.system.enabled();
    for transition in &enabled {
        let mut next = state.fork();
        next.system.enabled();
        if let Some(event) = next.system.take(transition).expect("a message within its domain") {
            next.observe(event.kind);
        }
        successors.push((next, true));
        let EnabledKind::Send(channel) = transition.kind else { continue };
        if faults.channels.contains(&channel) && state.losses > 0 {
            let losses = state.losses - 1;
            let system = damaged(state, transition, channel, Effect::Lose);
            successors.push((State { system, losses, ..state.fork() }, true));
        }
        if faults.channels.contains(&channel) && state.delays > 0 {
            let system = damaged(state, transition, channel, Effect::Hold(faults.delayed.1));
            let held = state.held.iter().copied().chain([faults.delayed.1]).collect();
            successors.push((State { system, delays: state.delays - 1, held, ..state.fork() }, true));
        }
    }
    if !enabled.is_empty() {
        return (successors, false);
    }
    let timer = state.system.next_timer().map(|due| due.saturating_sub(NormalForm::NOW));
    let tick = ticks.map(|_| state.until_tick);
    let Some(span) = timer.into_iter().chain(tick).chain(state.held.iter().copied()).min() else {
        return (successors, true);
    };
    let is_tick = tick == Some(span);
    for mut next in moves(state, environment, if is_tick { Instant::Tick } else { Instant::Between }) {
        next.system.advance(NormalForm::NOW + span);
        next.until_tick = next.until_tick.saturating_sub(span);
        next.held.iter_mut().for_each(|until| *until = until.saturating_sub(span));
        next.held.retain(|until| !until.is_zero());
        let mut is_alive = timer.is_some();
        if let Some(ticks) = ticks.filter(|_| is_tick) {
            is_alive |= next.system.generate_tick(ticks.generator).1;
            next.observe(EventKind::Tick);
            next.has_ticked = true;
            next.until_tick = ticks.period;
        }
        successors.push((next, is_alive));
    }
    for mut next in moves(state, environment, Instant::Between) {
        let after = next.monitor.clone().map(|mut monitor| {
            monitor.normalize().expect("a normal form");
            monitor
        });
        let is_seen = state
            .monitor
            .iter()
            .zip(&after)
            .any(|(before, after)| before.verdict() != after.verdict() || !before.same_state(after.as_ref()));
        if is_seen || !next.system.enabled().is_empty() || next.is_endless() {
            successors.push((next, true));
        }
    }
    (successors, true)
}

/// The system after a send whose message is damaged at once.
fn damaged(state: &State, send: &Enabled, channel: ChannelId, effect: Effect) -> ChannelSystem {
    let mut system = state.system.fork();
    system.enabled();
    let disturbance = system.disturb(Disturbance::all(channel, effect));
    system.take(send).expect("a message within its domain");
    let acts = system.enabled().into_iter().find(|enabled| enabled.kind == EnabledKind::Disturb(channel));
    system.take(&acts.expect("the message is hit")).expect("nothing is sent");
    system.calm(disturbance);
    system
}

/// The states after the environment's moves, which may have shown the monitor something.
fn moves(state: &State, environment: &AnyEnvironment, instant: Instant) -> Vec<State> {
    let driven: Vec<Box<dyn Process>> =
        environment.driven().iter().map(|id| state.system.clone_process(*id).expect("a process")).collect();
    let driven: Vec<&dyn Process> = driven.iter().map(AsRef::as_ref).collect();
    let moves = environment.moves(&state.environment, &driven, instant);
    let apply = |choice: explorer::Move<EnvironmentState>| {
        let mut system = state.system.fork();
        for (id, report) in environment.driven().iter().zip(choice.reports) {
            let mut process = system.clone_process(*id).expect("a process");
            environment.report(*id, report, process.as_mut(), NormalForm::NOW);
            system.replace(*id, process).expect("the same channels");
        }
        let shown = environment.shown(&state.environment, &choice.state);
        let mut next = State { environment: choice.state, system, ..state.fork() };
        shown.into_iter().for_each(|(channel, message)| next.observe(EventKind::Received { channel, message }));
        next
    };
    moves.into_iter().map(apply).collect()
}
