//! Everything that is computed once: the states of processes and monitors, messages, spans of time, and the moves of
//! the environment.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, ChannelId, Envelope, Event, EventKind, Message, Monitor, NoNormalForm, NormalForm, Offer,
    Process, ProcessId, RequestNumber, Role, Symbol, TickGenerator, Topology, Use,
};

use foldhash::fast::FixedState;

use crate::error::Refused;
use crate::interner::{Interner, hash_by};
use crate::local::{Local, Own, Receive, Step, UNKNOWN, Watching, set};
use crate::model::{Instant, Model, Move, Onlooker, Ticks};

/// The maximum number of states of one process.
const MAX_LOCALS: usize = 1 << 16;

/// The time, as far as a system's future depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Clock {
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
pub(crate) struct Line {
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

/// A move of the environment: the slots that it changes.
#[derive(Debug)]
pub(crate) struct Moved {
    pub(crate) state: u32,
    /// The driven processes that change, with their new states.
    pub(crate) processes: Box<[(u32, Step)]>,
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
    Clock(Clock),
    Transit(Transit),
    Moves {
        key: Vec<u32>,
        instant: Instant,
    },
}

#[derive(Debug)]
pub(crate) struct Tables {
    pub(crate) topology: Arc<Topology>,
    pub(crate) ids: Vec<ProcessId>,
    pub(crate) names: Vec<String>,
    pub(crate) locals: Vec<Interner<Local>>,
    pub(crate) lines: Vec<Line>,
    pub(crate) renamings: Interner<Renaming>,
    pub(crate) spans: Interner<Duration>,
    pub(crate) clocks: Interner<Clock>,
    pub(crate) transits: Interner<Transit>,
    pub(crate) environments: Interner<Vec<i64>>,
    pub(crate) monitors: Interner<Watching>,
    pub(crate) moves: [HashMap<Vec<u32>, Vec<Moved>, FixedState>; 2],
    /// The total number of moves.
    move_count: usize,
    pub(crate) driven: Vec<usize>,
    /// The processes that send on channels of capacity 0.
    pub(crate) shakers: Vec<usize>,
    environment: Arc<dyn crate::Environment>,
    pub(crate) ticks: Option<Ticks>,
    /// The channel of the ticks.
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
        let receivers = |channel| {
            let target = topology.get(channel).target;
            topology.processes().filter(|&id| topology.is_part_of(id, target)).map(ProcessId::index).collect()
        };
        let has_sole_sender = |channel| {
            let source = topology.get(channel).source;
            let parts = topology.processes().filter(|&id| topology.is_part_of(id, source));
            let uses = parts.filter_map(|id| Some(model.start.clone_process(id)?.uses()));
            uses.filter(|uses| uses.iter().any(|used| matches!(used, Use::Sends(on, _) if *on == channel))).count() <= 1
        };
        let lines = topology.channels().map(|id| {
            let channel = topology.get(id);
            Line {
                id,
                capacity: channel.capacity,
                is_internal: topology.is_internal(id),
                has_topics: channel.domain.shapes().iter().any(|shape| shape.role() == Role::Topic),
                may_fail: model.faults.channels.contains(&id),
                receivers: receivers(id),
                has_sole_sender: has_sole_sender(id),
                opposite: topology.opposite(id).map(ChannelId::index),
                contents: Interner::default(),
                heads: Vec::new(),
                renamed: Vec::new(),
            }
        });
        let mut tables = Self {
            lines: lines.collect(),
            locals: names.iter().map(|_| Interner::default()).collect(),
            tick_channel: model.ticks.map_or(0, |ticks| output(model, ticks)),
            ids: topology.processes().collect(),
            names,
            renamings: Interner::default(),
            spans: Interner::default(),
            clocks: Interner::default(),
            transits: Interner::default(),
            environments: Interner::default(),
            monitors: Interner::default(),
            moves: [HashMap::default(), HashMap::default()],
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
        self.renamings.intern(Renaming::new());
        for channel in 0..self.lines.len() {
            self.content(channel, None);
        }
        let mut system = model.start.fork();
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
            clock: self.clocks.intern(Clock { has_ticked: false, until_tick }),
            transit: self.transits.intern(transit),
            environment: self.environments.intern(model.environment.start()),
            monitor: monitor.unwrap_or_default(),
        })
    }

    /// Computes what is missing.
    pub(crate) fn fill(&mut self, gap: &Gap) -> Result<(), Refused> {
        match *gap {
            Gap::Own { process, state, own } => {
                let step = self.take(process, state, |local| (local.own[own].transition, None))?;
                self.locals[process].get_mut(state).own[own].step = step;
            }
            Gap::Receive { process, state, receive, content } => {
                let Receive { channel, pattern, .. } = &self.locals[process].get(state).receives[receive];
                let envelope = self.lines[*channel].contents.get(content).clone();
                let accepts = envelope.as_ref().is_some_and(|envelope| pattern.accepts(&envelope.message));
                let step = match accepts {
                    true => self.take(process, state, |local| (local.receives[receive].transition, envelope))?,
                    false => Step::REFUSED,
                };
                let steps = &mut self.locals[process].get_mut(state).receives[receive].steps;
                set(steps, content, step, Step::UNKNOWN);
            }
            Gap::Later { process, state, span } => self.pass_time(process, state, span)?,
            Gap::RenamedProcess { process, state, renaming } => {
                let mut renamed = self.locals[process].get(state).process.clone();
                let changes = self.renamings.get(renaming).clone();
                let numbers = |channel: ChannelId, number| renumbered(&changes, channel, number);
                let form = NormalForm::new(&self.topology, NormalForm::NOW, &numbers);
                renamed.normalize(&form).map_err(|why| self.refused(process, why))?;
                let number = self.local(process, renamed)?;
                set(&mut self.locals[process].get_mut(state).renamed, renaming, number, UNKNOWN);
            }
            Gap::RenamedContent { channel, content, renaming } => {
                let mut envelope = self.lines[channel].contents.get(content).clone();
                let changes = self.renamings.get(renaming).clone();
                let numbers = |channel: ChannelId, number| renumbered(&changes, channel, number);
                let form = NormalForm::new(&self.topology, NormalForm::NOW, &numbers);
                let id = self.lines[channel].id;
                envelope.iter_mut().for_each(|envelope| form.envelope(id, envelope));
                let number = self.content(channel, envelope);
                let renamed = &mut self.lines[channel].renamed;
                if renamed.len() <= renaming as usize {
                    renamed.resize_with(renaming as usize + 1, Vec::new);
                }
                set(&mut renamed[renaming as usize], content, number, UNKNOWN);
            }
            Gap::Ticked { process, state } => {
                let mut generator = self.locals[process].get(state).process.clone();
                if let Some(generator) = generator.as_any_mut().downcast_mut::<TickGenerator>() {
                    generator.generate(0);
                }
                self.look(process, generator.as_ref());
                let number = self.local(process, generator)?;
                self.locals[process].get_mut(state).ticked = number;
            }
            Gap::Observed { state, channel, content } => {
                let line = &self.lines[channel];
                let message = line.contents.get(content).as_ref().map(|envelope| envelope.message.clone());
                let kind = message.map(|message| EventKind::Received { channel: line.id, message });
                let number = self.observe(state, 0, kind.unwrap_or(EventKind::Tick))?;
                let after = &mut self.monitors.get_mut(state).after;
                if after.len() <= channel {
                    after.resize_with(channel + 1, Vec::new);
                }
                set(&mut after[channel], content, number, UNKNOWN);
            }
            Gap::ObservedTick { state, has_ticked } => {
                let number = self.observe(state, u64::from(has_ticked), EventKind::Tick)?;
                self.monitors.get_mut(state).ticked[usize::from(has_ticked)] = number;
            }
            Gap::Clock(clock) => _ = self.clocks.intern(clock),
            Gap::Transit(ref transit) => _ = self.transits.intern(transit.clone()),
            Gap::Moves { ref key, instant } => self.list_moves(key, instant)?,
        }
        Ok(())
    }

    /// A process takes a transition in one of its states.
    fn take(
        &mut self,
        process: usize,
        state: u32,
        transition: impl FnOnce(&Local) -> (channels::TransitionId, Option<Envelope>),
    ) -> Result<Step, Refused> {
        let before = self.locals[process].get(state);
        let (transition, received) = transition(before);
        if let Some((channel, content)) =
            before.own.iter().find(|own| own.transition == transition).and_then(|own| own.sends)
        {
            self.check_domain(process, channel, content)?;
        }
        let mut after = before.process.clone();
        after.take(transition, received, NormalForm::NOW);
        self.settle(process, state, after)
    }

    fn check_domain(&self, process: usize, channel: usize, content: u32) -> Result<(), Refused> {
        let line = &self.lines[channel];
        let message = line.contents.get(content).as_ref().map(|envelope| &envelope.message);
        match message.filter(|message| !self.topology.carries(line.id, message)) {
            None => Ok(()),
            Some(message) => Err(Refused::OutsideDomain {
                process: self.names[process].clone(),
                message: message.clone(),
                channel: self.topology.describe(line.id),
                domain: self.topology.get(line.id).domain.to_string(),
            }),
        }
    }

    /// The state of a process after a span of time.
    fn pass_time(&mut self, process: usize, state: u32, span: Duration) -> Result<(), Refused> {
        let mut later = self.locals[process].get(state).process.clone();
        let form = NormalForm::new(&self.topology, NormalForm::NOW + span, &same_number);
        later.normalize(&form).map_err(|why| self.refused(process, why))?;
        let is_due = later.next_timer().is_some_and(|due| due <= NormalForm::NOW);
        if is_due {
            later.fire_timers(NormalForm::NOW);
        }
        let step = self.settle(process, state, later)?;
        let span = self.spans.intern(span);
        set(&mut self.locals[process].get_mut(state).later, span, step, Step::UNKNOWN);
        Ok(())
    }

    /// Brings a process that was in a state into normal form.
    fn settle(&mut self, process: usize, before: u32, mut after: Box<dyn Process>) -> Result<Step, Refused> {
        self.look(process, after.as_ref());
        let (mut awaited, mut awaits) = (Vec::new(), Vec::new());
        self.locals[process].get(before).process.awaits(&mut awaited);
        after.awaits(&mut awaits);
        let id = self.id(process);
        let topology = Arc::clone(&self.topology);
        let position = |channel: ChannelId, number: RequestNumber| {
            let mut on_channel = (1..).zip(awaits.iter().filter(|(on, _)| *on == channel));
            on_channel.find(|(_, (_, awaited))| *awaited == number).map_or(0, |(position, _)| position)
        };
        let numbers =
            |channel: ChannelId, number: RequestNumber| match topology.is_part_of(id, topology.get(channel).source) {
                true => RequestNumber(position(channel, number)),
                false => number,
            };
        match after.normalize(&NormalForm::new(&topology, NormalForm::NOW, &numbers)) {
            Err(NoNormalForm::Endless { .. }) => return Ok(Step { next: ENDLESS, renaming: 0 }),
            Err(why) => return Err(self.refused(process, why)),
            Ok(()) => {}
        }
        let mut changes = Renaming::new();
        for (channel, number) in awaited {
            let new = position(channel, number);
            match changes.iter_mut().find(|(on, _)| *on == channel.index()) {
                Some((_, numbers)) => numbers.push(new),
                None => changes.push((channel.index(), vec![new])),
            }
        }
        changes.retain(|(_, numbers)| !(1..).zip(numbers).all(|(old, new)| old == *new));
        let renaming = self.renamings.intern(changes);
        Ok(Step { next: self.local(process, after)?, renaming })
    }

    fn look(&self, process: usize, state: &dyn Process) {
        if let Some(onlooker) = &self.onlooker {
            onlooker.see(self.id(process), state);
        }
    }

    fn id(&self, process: usize) -> ProcessId {
        self.ids[process]
    }

    /// The number of a state of a process in normal form.
    pub(crate) fn local(&mut self, process: usize, state: Box<dyn Process>) -> Result<u32, Refused> {
        let hash = hash_by(|hasher| state.hash_state(hasher));
        if let Some(known) = self.locals[process].find(hash, |local| local.process.same_state(state.as_ref())) {
            return Ok(known);
        }
        let known = self.locals[process].len();
        if known >= MAX_LOCALS {
            let location = state.location();
            return Err(Refused::TooManyStates { process: self.names[process].clone(), states: known, location });
        }
        let local = self.describe(state);
        Ok(self.locals[process].add(hash, local))
    }

    /// A state of a process with what it offers.
    fn describe(&mut self, process: Box<dyn Process>) -> Local {
        let mut offers = Vec::new();
        process.offers(&mut offers);
        let (mut own, mut receives) = (Vec::new(), Vec::new());
        for Offer { transition, action } in offers {
            let mut by_itself = |sends| own.push(Own { transition, sends, step: Step::UNKNOWN });
            match action {
                Action::Internal => by_itself(None),
                Action::Send(channel, envelope) => {
                    by_itself(Some((channel.index(), self.content(channel.index(), Some(envelope)))));
                }
                Action::Receive(channel, pattern) => {
                    receives.push(Receive { transition, channel: channel.index(), pattern, steps: Vec::new() });
                }
            }
        }
        let timer = process.next_timer().map(|due| due.saturating_sub(NormalForm::NOW));
        let timer = timer.map(|timer| self.ticks.map_or(timer, |ticks| round_up(timer, ticks.step)));
        let is_timeless = timer.is_none() && {
            let mut later = process.clone();
            let a_moment_later = NormalForm::NOW + Duration::from_nanos(1);
            later.normalize(&NormalForm::new(&self.topology, a_moment_later, &same_number)).is_ok()
                && later.same_state(process.as_ref())
        };
        Local { process, timer, is_timeless, own, receives, later: Vec::new(), renamed: Vec::new(), ticked: UNKNOWN }
    }

    /// The number of a channel's contents.
    pub(crate) fn content(&mut self, channel: usize, envelope: Option<Envelope>) -> u32 {
        let Self { topology, lines, .. } = self;
        let line = &mut lines[channel];
        let message = envelope.as_ref().map(|envelope| &envelope.message);
        let head = message.and_then(Message::head).map(Symbol::new);
        let is_topic = message.is_some_and(|message| is_topic(topology, line.id, message));
        let number = line.contents.intern(envelope);
        if line.heads.len() < line.contents.len() {
            line.heads.push((head, is_topic));
        }
        number
    }

    /// The number of a state of the monitor.
    fn watching(&mut self, mut monitor: Box<dyn Monitor>) -> Result<u32, Refused> {
        let verdict = monitor.verdict();
        monitor.normalize().map_err(|why| {
            let (reason, help) = in_words(why);
            Refused::Property { property: monitor.name().to_owned(), reason, help }
        })?;
        let hash = hash_by(|hasher| monitor.hash_state(hasher));
        let same = |known: &Watching| known.verdict == verdict && known.monitor.same_state(monitor.as_ref());
        if let Some(known) = self.monitors.find(hash, same) {
            return Ok(known);
        }
        if self.monitors.len() >= MAX_LOCALS {
            let reason = format!("its monitor has more than {MAX_LOCALS} states");
            return Err(Refused::Property { property: monitor.name().to_owned(), reason, help: None });
        }
        Ok(self.monitors.add(hash, Watching { monitor, verdict, after: Vec::new(), ticked: [UNKNOWN; 2] }))
    }

    fn observe(&mut self, state: u32, tick: u64, kind: EventKind) -> Result<u32, Refused> {
        let mut monitor = self.monitors.get(state).monitor.clone();
        monitor.observe(&Event { step: 0, tick, time: Duration::ZERO, kind });
        self.watching(monitor)
    }

    /// The moves of the environment. The key is its state and the states of the processes that it drives.
    pub(crate) fn told(&self, key: &[u32], instant: Instant) -> Vec<Move> {
        self.environment.moves(self.environments.get(key[0]), &self.driven_in(&key[1..]), instant)
    }

    /// The same moves in words.
    pub(crate) fn words(&self, key: &[u32], instant: Instant) -> Vec<String> {
        self.environment.words(self.environments.get(key[0]), &self.driven_in(&key[1..]), instant)
    }

    /// Whether the environment may let a process move.
    pub(crate) fn may_stir(&self, key: &[u32]) -> bool {
        self.environment.may_stir(self.environments.get(key[0]), &self.driven_in(&key[1..]))
    }

    /// The processes that the environment drives, in these states.
    fn driven_in(&self, states: &[u32]) -> Vec<&dyn Process> {
        self.driven.iter().zip(states).map(|(p, state)| self.locals[*p].get(*state).process.as_ref()).collect()
    }

    /// Lists the moves of the environment.
    fn list_moves(&mut self, key: &[u32], instant: Instant) -> Result<(), Refused> {
        let driven = self.driven.clone();
        let moves = self.told(key, instant);
        let mut list = Vec::with_capacity(moves.len());
        for told in moves {
            let mut processes = Vec::new();
            for (process, state) in driven.iter().zip(&key[1..]) {
                let mut after = self.locals[*process].get(*state).process.clone();
                (told.update)(self.id(*process), after.as_mut(), NormalForm::NOW);
                if !after.same_state(self.locals[*process].get(*state).process.as_ref()) {
                    let step = self.settle(*process, *state, after)?;
                    processes.push((*process as u32, step));
                }
            }
            let state = self.environments.intern(told.state);
            list.push(Moved { state, processes: processes.into() });
        }
        self.move_count += list.len();
        self.moves[instant as usize].insert(key.to_vec(), list);
        Ok(())
    }

    /// The moves of the environment, in the order of their keys.
    pub(crate) fn sorted_moves(&self, instant: Instant) -> Vec<(&[u32], &[Moved])> {
        let moves = self.moves[instant as usize].iter().map(|(key, moves)| (key.as_slice(), moves.as_slice()));
        let mut moves: Vec<_> = moves.collect();
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
        let contents: usize = self.lines.iter().map(|line| line.contents.len()).sum();
        let environment = 64 * self.move_count + 256 * self.environments.len();
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

fn in_words(why: NoNormalForm) -> (String, Option<String>) {
    match why {
        NoNormalForm::Unsupported { reason, help } => (reason, help),
        NoNormalForm::Endless { what } => (what, None),
    }
}

pub(crate) fn same_number(_: ChannelId, number: RequestNumber) -> RequestNumber {
    number
}

/// The number of a request after a renaming.
fn renumbered(changes: &Renaming, channel: ChannelId, number: RequestNumber) -> RequestNumber {
    let Some((_, numbers)) = changes.iter().find(|(on, _)| *on == channel.index()) else { return number };
    let index = number.0.checked_sub(1).and_then(|index| usize::try_from(index).ok());
    RequestNumber(index.and_then(|index| numbers.get(index)).copied().unwrap_or(0))
}

fn is_topic(topology: &Topology, channel: ChannelId, message: &Message) -> bool {
    topology.get(channel).domain.shape_of(message).is_some_and(|shape| shape.role() == Role::Topic)
}

/// Whether a process sends on a channel of capacity 0.
fn shakes_hands(topology: &Topology, process: ProcessId) -> bool {
    let is_composed = topology.processes().any(|part| part != process && topology.whole(part) == process);
    let mut channels = topology.channels().map(|id| topology.get(id));
    !is_composed
        && channels.any(|channel| channel.capacity == Capacity::Zero && topology.is_part_of(process, channel.source))
}

/// The channel on which a generator sends its ticks.
fn output(model: &Model, ticks: Ticks) -> usize {
    let generator = model.start.process::<TickGenerator>(ticks.generator);
    generator.expect("ticks come from a TickGenerator").output().index()
}

impl Line {
    /// Whether a waiting message gives way to a newer one.
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

/// The next multiple of `step`.
fn round_up(time: Duration, step: Duration) -> Duration {
    match step.as_nanos() {
        0 => time,
        step => Duration::from_nanos((time.as_nanos().div_ceil(step) * step) as u64),
    }
}
