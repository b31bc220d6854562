//! Everything that is computed once: the states of processes and monitors, messages, spans of time, and the moves of
//! the environment.

mod fill;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, ChannelId, Envelope, Monitor, NoNormalForm, Process, ProcessId, RequestNumber, Role, Symbol,
    TickGenerator, Topology, Use,
};
use foldhash::fast::FixedState;
use smallvec::SmallVec;

use crate::environment::{AnyEnvironment, EnvironmentState, Instant, Move};
use crate::error::Refused;
use crate::interner::Interner;
use crate::local::{Local, Step, Watching};
use crate::model::{Model, Onlooker, Ticks};
use crate::path::PathStep;

/// The time, as far as a system's future depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ClockState {
    /// Whether there has been a tick.
    pub(crate) has_ticked: bool,
    pub(crate) until_tick: Duration,
}

/// What may still happen to messages, and which ones are held back.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Transit {
    pub(crate) losses: u8,
    pub(crate) repeats: u8,
    pub(crate) delays: u8,
    /// Channels, and the times until the messages in them may be received.
    pub(crate) held: Vec<(usize, Duration)>,
}

/// New numbers for the requests on some channels: the new number of request n is at index n - 1.
pub(crate) type Renaming = Vec<(usize, Vec<u64>)>;

/// A channel, with the messages that it may hold.
#[derive(Debug)]
pub(crate) struct Link {
    pub(crate) id: ChannelId,
    pub(crate) capacity: Capacity,
    pub(crate) is_internal: bool,
    pub(crate) has_topics: bool,
    pub(crate) may_fail: bool,
    /// The processes that receive from it.
    pub(crate) receivers: Vec<usize>,
    /// Whether only one process ever sends on it.
    pub(crate) has_sole_sender: bool,
    pub(crate) opposite: Option<usize>,
    /// Number 0 is no message.
    pub(crate) contents: Interner<Option<Envelope>>,
    /// By the number of the message: its first symbol, and whether it belongs to a topic.
    heads: Vec<(Option<Symbol>, bool)>,
    /// By renaming, and then by the number of the message.
    pub(crate) renamed: Vec<Vec<u32>>,
}

/// A move of the environment, by the numbers of its parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    pub(crate) state: u32,
    effect: u32,
    /// The message that monitors are shown: its channel, and its number there.
    pub(crate) shown: Option<(u32, u32)>,
}

/// What a move does to the driven processes: those that change, with their steps.
type MoveEffect = SmallVec<[(u32, Step); 3]>;

/// The moves of the environment in some state of it and of the processes that it drives.
#[derive(Debug)]
pub(crate) struct Situation {
    /// Whether a move may enable a process.
    pub(crate) may_stir: bool,
    /// By instant.
    moves: [Option<Vec<Moved>>; 2],
}

impl Situation {
    /// The moves at an instant, once they are listed.
    pub(crate) fn at(&self, instant: Instant) -> Option<&[Moved]> {
        self.moves[instant as usize].as_deref()
    }
}

/// Something that has not been computed yet.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Gap {
    /// The next state of a process after one of its own transitions.
    Own {
        process: usize,
        state: u32,
        own: usize,
    },
    /// Its next state after receiving a message.
    Receive {
        process: usize,
        state: u32,
        receive: usize,
        content: u32,
    },
    /// Its state after a span of time.
    Later {
        process: usize,
        state: u32,
        span: Duration,
    },
    /// Its state with other numbers.
    RenamedProcess {
        process: usize,
        state: u32,
        renaming: u32,
    },
    RenamedContent {
        channel: usize,
        content: u32,
        renaming: u32,
    },
    /// The state of a tick generator when a tick is due.
    Ticked {
        process: usize,
        state: u32,
    },
    /// The state of a monitor after a message, or after a tick.
    Observed {
        state: u32,
        channel: usize,
        content: u32,
    },
    ObservedTick {
        state: u32,
        has_ticked: bool,
    },
    Clock(ClockState),
    Transit(Transit),
    Moves {
        key: Vec<u32>,
        instant: Instant,
    },
}

/// What a search has met, by numbers: a table for each kind of part of a state, and the parts of the model that they
/// refer to.
#[derive(Debug)]
pub(crate) struct Tables {
    pub(crate) topology: Arc<Topology>,
    pub(crate) ids: Vec<ProcessId>,
    pub(crate) names: Vec<String>,
    pub(crate) locals: Vec<Interner<Local>>,
    pub(crate) links: Vec<Link>,
    pub(crate) renamings: Interner<Renaming>,
    pub(crate) spans: Interner<Duration>,
    pub(crate) clocks: Interner<ClockState>,
    pub(crate) transits: Interner<Transit>,
    pub(crate) environments: Interner<EnvironmentState>,
    effects: Interner<MoveEffect>,
    pub(crate) monitors: Interner<Watching>,
    pub(crate) situations: HashMap<Vec<u32>, Situation, FixedState>,
    /// The total number of moves.
    move_count: usize,
    pub(crate) driven: Vec<usize>,
    /// The processes that send on channels of capacity 0.
    pub(crate) shakers: Vec<usize>,
    environment: Arc<AnyEnvironment>,
    pub(crate) ticks: Option<Ticks>,
    pub(crate) tick_channel: usize,
    pub(crate) onlooker: Option<Arc<dyn Onlooker>>,
}

/// In place of a state: messages pile up in the process without bound.
pub(crate) const ENDLESS: u32 = u32::MAX - 2;

impl Tables {
    /// The tables of a model with nothing in them but its initial state: the states of processes and the contents of
    /// channels.
    pub(crate) fn new(model: &Model, monitor: Option<&dyn Monitor>) -> Result<(Self, Start), Refused> {
        let topology = Arc::clone(model.start.topology());
        let names: Vec<String> = topology.processes().map(|id| topology.name(id).to_owned()).collect();
        let mut tables = Self {
            links: topology.channels().map(|id| Link::new(id, model)).collect(),
            locals: names.iter().map(|_| Interner::default()).collect(),
            tick_channel: model.ticks.map_or(0, |ticks| output(model, ticks)),
            ids: topology.processes().collect(),
            names,
            renamings: Interner::default(),
            spans: Interner::default(),
            clocks: Interner::default(),
            transits: Interner::default(),
            environments: Interner::default(),
            effects: Interner::default(),
            monitors: Interner::default(),
            situations: HashMap::default(),
            move_count: 0,
            driven: model.environment.driven().iter().map(|id| id.index()).collect(),
            shakers: topology.processes().filter(|id| shakes_hands(&topology, *id)).map(ProcessId::index).collect(),
            environment: Arc::clone(&model.environment),
            ticks: model.ticks,
            onlooker: model.onlooker.clone(),
            topology,
        };
        let start = tables.start(model, monitor)?;
        Ok((tables, start))
    }

    fn start(&mut self, model: &Model, monitor: Option<&dyn Monitor>) -> Result<Start, Refused> {
        // Number 0 is nothing: no renaming, an empty channel.
        self.renamings.intern(Renaming::new());
        for channel in 0..self.links.len() {
            self.content(channel, None);
        }
        let mut system = model.start.fork();
        // Onlookers see what exists only for reporting, which the normal form forgets.
        for id in self.topology.processes() {
            system.clone_process(id).into_iter().for_each(|process| self.look(id.index(), process.as_ref()));
        }
        system.normalize().map_err(|(process, why)| self.refused(process.index(), why))?;
        let topology = Arc::clone(&self.topology);
        let mut processes = vec![0; self.locals.len()];
        for id in topology.processes() {
            if let Some(process) = system.clone_process(id) {
                processes[id.index()] = self.local(id.index(), process)?;
            }
        }
        let contents = topology.channels().map(|id| self.content(id.index(), system.content(id).cloned())).collect();
        let until_tick = model.ticks.map_or(Duration::ZERO, |ticks| ticks.first);
        let faults = &model.faults;
        let transit =
            Transit { losses: faults.lost, repeats: faults.repeated, delays: faults.delayed.0, held: Vec::new() };
        let monitor = monitor.map(|monitor| self.watching(monitor.boxed_clone())).transpose()?;
        Ok(Start {
            processes,
            contents,
            clock: self.clocks.intern(ClockState { has_ticked: false, until_tick }),
            transit: self.transits.intern(transit),
            environment: self.environments.intern(model.environment.start()),
            monitor: monitor.unwrap_or_default(),
        })
    }

    fn id(&self, process: usize) -> ProcessId {
        self.ids[process]
    }

    /// The moves of the environment. The key is its state and the states of the processes that it drives.
    pub(crate) fn possible(&self, key: &[u32], instant: Instant) -> Vec<Move<EnvironmentState>> {
        self.environment.moves(self.environments.get(key[0]), &self.driven_in(&key[1..]), instant)
    }

    /// The same moves in words.
    pub(crate) fn words(&self, key: &[u32], instant: Instant) -> Vec<String> {
        self.environment.words(self.environments.get(key[0]), &self.driven_in(&key[1..]), instant)
    }

    /// A move of the environment as a step of a run.
    pub(crate) fn moved(&self, key: &[u32], instant: Instant, index: usize) -> PathStep {
        let Move { state, reports } = self.possible(key, instant).swap_remove(index);
        let shown = self.environment.shown(self.environments.get(key[0]), &state);
        let words = self.words(key, instant).swap_remove(index);
        let environment = Arc::clone(&self.environment);
        let update = move |id: ProcessId, process: &mut dyn Process, now: Duration| {
            let index = environment.driven().iter().position(|driven| *driven == id);
            index.into_iter().for_each(|index| environment.report(id, reports[index], process, now));
        };
        PathStep::Environment { words, update: Arc::new(update), state, shown }
    }

    /// The driven processes that a move changes, with their steps.
    pub(crate) fn effect(&self, moved: Moved) -> &[(u32, Step)] {
        self.effects.get(moved.effect)
    }

    /// Whether the environment may let a process move.
    fn may_stir(&self, key: &[u32]) -> bool {
        self.environment.may_stir(self.environments.get(key[0]), &self.driven_in(&key[1..]))
    }

    /// The processes that the environment drives, in these states.
    fn driven_in(&self, states: &[u32]) -> Vec<&dyn Process> {
        self.driven.iter().zip(states).map(|(p, state)| self.locals[*p].get(*state).process.as_ref()).collect()
    }

    /// The moves of the environment, in the order of their keys.
    pub(crate) fn sorted_moves(&self, instant: Instant) -> Vec<(&[u32], &[Moved])> {
        let situations = self.situations.iter();
        let mut moves: Vec<_> =
            situations.filter_map(|(key, known)| Some((key.as_slice(), known.at(instant)?))).collect();
        moves.sort_unstable_by_key(|(key, _)| *key);
        moves
    }

    pub(crate) fn refused(&self, process: usize, why: NoNormalForm) -> Refused {
        let (reason, help) = in_words(why);
        Refused::Process { process: self.names[process].clone(), reason, help }
    }

    /// The approximate memory used by the tables.
    pub(crate) fn bytes(&self) -> usize {
        let locals: usize = self.locals.iter().map(Interner::len).sum();
        let contents: usize = self.links.iter().map(|link| link.contents.len()).sum();
        let environment = 8 * self.move_count + 128 * (self.situations.len() + self.environments.len());
        2048 * locals + 512 * contents + environment + 1024 * self.monitors.len()
    }
}

/// The initial state of a system, by the numbers of its parts.
#[derive(Debug)]
pub(crate) struct Start {
    pub(crate) processes: Vec<u32>,
    pub(crate) contents: Vec<u32>,
    pub(crate) clock: u32,
    pub(crate) transit: u32,
    pub(crate) environment: u32,
    pub(crate) monitor: u32,
}

/// Refuses a monitor that has no normal form.
///
/// # Errors
/// [`Refused::Property`] with the reason.
pub fn check(monitor: &dyn Monitor) -> Result<(), Refused> {
    normalize(monitor.boxed_clone().as_mut())
}

fn normalize(monitor: &mut dyn Monitor) -> Result<(), Refused> {
    monitor.normalize().map_err(|why| {
        let (reason, help) = in_words(why);
        Refused::Property { property: monitor.name().to_owned(), reason, help }
    })
}

fn in_words(why: NoNormalForm) -> (String, Option<String>) {
    match why {
        NoNormalForm::Unsupported { reason, help } => (reason, help),
        NoNormalForm::Endless { what } => (what, None),
    }
}

pub(crate) fn same_number(_: ChannelId, number: RequestNumber) -> RequestNumber {
    number
}

/// Whether a process sends on a channel of capacity 0.
fn shakes_hands(topology: &Topology, process: ProcessId) -> bool {
    let is_composed = topology.processes().any(|part| part != process && topology.whole(part) == process);
    let mut channels = topology.channels().map(|id| topology.get(id));
    // One outside the system never moves.
    !is_composed
        && !topology.is_outside(process)
        && channels.any(|channel| channel.capacity == Capacity::Zero && topology.is_part_of(process, channel.source))
}

/// The channel on which a generator sends its ticks.
fn output(model: &Model, ticks: Ticks) -> usize {
    let generator = model.start.process::<TickGenerator>(ticks.generator);
    generator.expect("ticks come from a TickGenerator").output().index()
}

impl Link {
    fn new(id: ChannelId, model: &Model) -> Self {
        let topology = model.start.topology();
        let channel = topology.get(id);
        let parts = |of: ProcessId| topology.processes().filter(move |&part| topology.is_part_of(part, of));
        let uses = parts(channel.source).filter_map(|part| Some(model.start.clone_process(part)?.uses()));
        let senders = uses.filter(|uses| uses.iter().any(|used| matches!(used, Use::Sends(on, _) if *on == id)));
        Self {
            id,
            capacity: channel.capacity,
            is_internal: topology.is_internal(id),
            has_topics: channel.domain.shapes().iter().any(|shape| shape.role() == Role::Topic),
            may_fail: model.faults.channels.contains(&id),
            receivers: parts(channel.target).map(ProcessId::index).collect(),
            has_sole_sender: senders.count() <= 1,
            opposite: topology.opposite(id).map(ChannelId::index),
            contents: Interner::default(),
            heads: Vec::new(),
            renamed: Vec::new(),
        }
    }

    pub(crate) fn gives_way(&self, waiting: u32, newer: u32) -> bool {
        let (waiting, newer) = (&self.heads[waiting as usize], &self.heads[newer as usize]);
        self.has_topics && newer.1 && waiting.0 == newer.0
    }
}

impl Transit {
    /// Whether the message in the channel cannot be received yet.
    pub(crate) fn holds(&self, channel: usize) -> bool {
        self.held.iter().any(|(held, _)| *held == channel)
    }

    /// The same, with another message held back.
    pub(crate) fn holding(&self, channel: usize, time: Duration) -> Self {
        let mut held = self.held.clone();
        held.push((channel, time));
        held.sort_unstable();
        Self { delays: self.delays - 1, held, ..*self }
    }

    /// The same after a span of time.
    pub(crate) fn after(&self, span: Duration) -> Self {
        let held = self.held.iter().map(|(channel, until)| (*channel, until.saturating_sub(span)));
        Self { held: held.filter(|(_, until)| !until.is_zero()).collect(), ..*self }
    }
}
