//! What a system can do next: the rules of channel systems, on numbers.

use std::time::Duration;

use channels::{Capacity, Enabled, EnabledKind, Pattern, Verdict};

use crate::local::{Local, Own, REFUSED, Step, UNKNOWN, entry};
use crate::model::{Damage, Instant, Move};
use crate::path::PathStep;
use crate::store::Change;
use crate::tables::{Clock, ENDLESS, Gap, Moved, Start, Tables, Transit};

/// The position of each part of a system's state in a vector.
#[derive(Debug)]
pub(crate) struct Slots {
    pub(crate) processes: Vec<u32>,
    pub(crate) channels: Vec<u32>,
    pub(crate) clock: u32,
    pub(crate) transit: u32,
    pub(crate) environment: u32,
    pub(crate) monitor: u32,
    pub(crate) len: usize,
}

impl Slots {
    /// Each process is next to the channels on which it sends, since they often change together.
    pub(crate) fn new(tables: &Tables) -> Self {
        let mut next = 0..;
        let mut slot = || next.next().unwrap_or_default();
        let [monitor, clock, transit, environment] = [slot(), slot(), slot(), slot()];
        let mut processes = Vec::new();
        let mut channels = vec![0; tables.lines.len()];
        for process in tables.topology.processes() {
            processes.push(slot());
            for channel in tables.topology.channels().filter(|id| tables.topology.get(*id).source == process) {
                channels[channel.index()] = slot();
            }
        }
        Self { processes, channels, clock, transit, environment, monitor, len: slot() as usize }
    }

    /// The vector of the initial state.
    pub(crate) fn vector(&self, start: &Start) -> Vec<u32> {
        let mut vector = vec![0; self.len];
        let parts = self.processes.iter().zip(&start.processes).chain(self.channels.iter().zip(&start.contents));
        parts.for_each(|(slot, value)| vector[*slot as usize] = *value);
        let rest = [
            (self.clock, start.clock),
            (self.transit, start.transit),
            (self.environment, start.environment),
            (self.monitor, start.monitor),
        ];
        rest.into_iter().for_each(|(slot, value)| vector[slot as usize] = value);
        vector
    }
}

/// A step from one state to another. Indices are those of the steps that a process offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    Own {
        process: u32,
        own: u32,
        damage: Damage,
    },
    Receive {
        process: u32,
        receive: u32,
        damage: Damage,
    },
    Handshake {
        process: u32,
        own: u32,
        receiver: u32,
        receive: u32,
    },
    /// The environment moves while time stands still.
    Drive {
        index: u32,
    },
    /// The environment moves, time passes, timers that are due fire, and the tick arrives if it is due.
    Wait {
        index: u32,
        delivered: bool,
    },
}

/// How the search continues with a successor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    GoOn,
    /// The verdict is true, whatever follows.
    Settled,
    /// The verdict is false.
    Violated,
    /// Messages pile up without bound.
    Endless,
}

/// The successors of a state.
#[derive(Debug, Default)]
pub(crate) struct Successors {
    changes: Vec<Change>,
    /// Where the changes of each successor end.
    ends: Vec<usize>,
    labels: Vec<Label>,
    fates: Vec<Fate>,
    /// Nothing can happen before time passes.
    pub(crate) is_quiet: bool,
}

impl Successors {
    fn clear(&mut self) {
        self.changes.clear();
        self.ends.clear();
        self.labels.clear();
        self.fates.clear();
        self.is_quiet = false;
    }

    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    pub(crate) fn changes(&self, index: usize) -> &[Change] {
        let begin = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.changes[begin..self.ends[index]]
    }

    pub(crate) fn label(&self, index: usize) -> &Label {
        &self.labels[index]
    }

    pub(crate) fn fate(&self, index: usize) -> Fate {
        self.fates[index]
    }
}

/// The semantics of a model over its tables.
#[derive(Debug)]
pub(crate) struct Semantics {
    pub(crate) tables: Tables,
    pub(crate) slots: Slots,
    pub(crate) has_monitor: bool,
    /// Whether the environment also moves while processes communicate.
    pub(crate) anywhere: bool,
    pub(crate) hold: Duration,
    /// Whether a process that can only send does so before the others move.
    pub(crate) sends_first: bool,
}

/// A vector with changes that are being made.
struct Draft<'a> {
    from: &'a [u32],
    changes: &'a mut Vec<Change>,
    begin: usize,
}

impl Draft<'_> {
    fn get(&self, slot: u32) -> u32 {
        let changed = self.changes[self.begin..].iter().find(|(changed, _)| *changed == slot);
        changed.map_or(self.from[slot as usize], |(_, value)| *value)
    }

    fn set(&mut self, slot: u32, value: u32) {
        match self.changes[self.begin..].iter_mut().find(|(changed, _)| *changed == slot) {
            Some((_, old)) => *old = value,
            None => self.changes.push((slot, value)),
        }
    }
}

impl Semantics {
    /// Lists the successors of a state, in an order that depends only on the state.
    pub(crate) fn expand(&self, state: &[u32], out: &mut Successors) -> Result<(), Gap> {
        out.clear();
        let transit = self.transit(state);
        if self.sends_first && self.send_first(state, transit, out)? {
            return Ok(());
        }
        for (index, line) in self.tables.locals.iter().enumerate() {
            if line.len() == 0 {
                continue; // it is composed of others
            }
            let number = state[self.slots.processes[index] as usize];
            let local = line.get(number);
            for own in 0..local.own.len() {
                self.take_own(state, transit, index, (number, local), own, out)?;
            }
            for receive in 0..local.receives.len() {
                self.take_receive(state, transit, index, (number, local), receive, out)?;
            }
        }
        out.is_quiet = out.len() == 0;
        if out.is_quiet {
            self.wait(state, transit, out)?;
        }
        self.drive(state, out)
    }

    /// Performs the send of the first process that can only send, and returns whether there is one. No process can
    /// prevent the send or tell when it happened: the channel is empty, no other process sends on it, nothing happens
    /// to its messages, and no numbers change.
    fn send_first(&self, state: &[u32], transit: &Transit, out: &mut Successors) -> Result<bool, Gap> {
        for (process, line) in self.tables.locals.iter().enumerate().filter(|(_, line)| line.len() > 0) {
            let number = state[self.slots.processes[process] as usize];
            let local = line.get(number);
            let ([Own { sends: Some((channel, _)), step, .. }], []) = (local.own.as_slice(), local.receives.as_slice())
            else {
                continue;
            };
            let line = &self.tables.lines[*channel];
            let is_safe = !line.may_fail || (transit.losses == 0 && transit.delays == 0);
            let is_free = line.has_sole_sender && state[self.slots.channels[*channel] as usize] == 0;
            if line.capacity == Capacity::One && is_safe && is_free {
                if *step == Step::UNKNOWN {
                    return Err(Gap::Own { process, state: number, own: 0 });
                }
                if step.renaming == 0 && step.next != ENDLESS {
                    self.take_own(state, transit, process, (number, local), 0, out)?;
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Whether only the environment can change anything: no timer is set, and the tick is lost.
    pub(crate) fn is_stuck(&self, state: &[u32], successors: &Successors) -> bool {
        let is_lost = |label: &Label| matches!(label, Label::Wait { delivered: false, .. });
        successors.is_quiet
            && self.tables.ticks.is_some()
            && successors.labels.iter().all(is_lost)
            && self.populated().all(|process| self.local(state, process).timer.is_none())
    }

    /// The steps that a label stands for, in a state.
    pub(crate) fn path_steps(&self, state: &[u32], label: &Label) -> Vec<PathStep> {
        let moved = |instant, index: usize| {
            let Move { state, update, words } = self.tables.told(&self.key(state), instant).swap_remove(index);
            PathStep::Environment { words, update, state }
        };
        let local = |process: u32| self.local(state, process as usize);
        let channel = |channel: usize| self.tables.lines[channel].id;
        let take = |process: u32, transition, kind, damage| {
            let enabled = Enabled { process: self.tables.ids[process as usize], transition, kind };
            vec![PathStep::Take { enabled, damage }]
        };
        match *label {
            Label::Own { process, own, damage } => {
                let own = &local(process).own[own as usize];
                let kind = own.sends.map_or(EnabledKind::Internal, |(on, _)| EnabledKind::Send(channel(on)));
                take(process, own.transition, kind, damage)
            }
            Label::Receive { process, receive, damage } => {
                let receive = &local(process).receives[receive as usize];
                take(process, receive.transition, EnabledKind::Receive(channel(receive.channel)), damage)
            }
            Label::Handshake { process, own, receiver, receive } => {
                let receive = &local(receiver).receives[receive as usize];
                let kind = EnabledKind::Handshake {
                    channel: channel(receive.channel),
                    receiver: self.tables.ids[receiver as usize],
                    receiving: receive.transition,
                };
                take(process, local(process).own[own as usize].transition, kind, Damage::None)
            }
            Label::Drive { index } => vec![moved(Instant::Between, index as usize)],
            Label::Wait { index, delivered } => {
                let (span, instant) = self.next_instant(state).expect("time passed from here");
                let tick = (instant == Instant::Tick).then_some(PathStep::Tick { delivered });
                [moved(instant, index as usize), PathStep::Wait(span)].into_iter().chain(tick).collect()
            }
        }
    }

    /// The time until the next timer or tick, and which of the two it is.
    fn next_instant(&self, state: &[u32]) -> Option<(Duration, Instant)> {
        let clock = self.tables.clocks.get(state[self.slots.clock as usize]);
        let timers = self.populated().filter_map(|process| self.local(state, process).timer);
        let held = self.transit(state).held.iter().map(|(_, until)| *until);
        let timer = timers.chain(held).min();
        let tick = self.tables.ticks.map(|_| clock.until_tick);
        let span = timer.into_iter().chain(tick).min()?;
        Some((span, if tick == Some(span) { Instant::Tick } else { Instant::Between }))
    }

    fn transit<'a>(&'a self, state: &[u32]) -> &'a Transit {
        self.tables.transits.get(state[self.slots.transit as usize])
    }

    fn take_own(
        &self,
        state: &[u32],
        transit: &Transit,
        process: usize,
        (number, local): (u32, &Local),
        own: usize,
        out: &mut Successors,
    ) -> Result<(), Gap> {
        let offer = &local.own[own];
        let step = || match offer.step {
            Step::UNKNOWN => Err(Gap::Own { process, state: number, own }),
            step => Ok(step),
        };
        let label = |damage| Label::Own { process: process as u32, own: own as u32, damage };
        let Some((channel, content)) = offer.sends else {
            return self.push(state, out, label(Damage::None), |draft| self.follow(draft, process, step()?));
        };
        let line = &self.tables.lines[channel];
        let slot = self.slots.channels[channel];
        match line.capacity {
            Capacity::One => {
                let waiting = state[slot as usize];
                let may_replace = line.gives_way(waiting, content) && !transit.holds(channel);
                if waiting != 0 && !may_replace {
                    return Ok(());
                }
                self.push(state, out, label(Damage::None), |draft| {
                    draft.set(slot, content);
                    self.follow(draft, process, step()?)
                })?;
                if line.may_fail && transit.losses > 0 {
                    self.push(state, out, label(Damage::Lost), |draft| {
                        draft.set(slot, 0);
                        self.set_transit(draft, Transit { losses: transit.losses - 1, ..transit.clone() })?;
                        self.follow(draft, process, step()?)
                    })?;
                }
                if line.may_fail && transit.delays > 0 {
                    self.push(state, out, label(Damage::Held), |draft| {
                        draft.set(slot, content);
                        self.set_transit(draft, transit.holding(channel, self.hold))?;
                        self.follow(draft, process, step()?)
                    })?;
                }
                Ok(())
            }
            Capacity::Zero => {
                for receiver in line.receivers.iter().copied().filter(|receiver| *receiver != process) {
                    let on = state[self.slots.processes[receiver] as usize];
                    let other = self.tables.locals[receiver].get(on);
                    for (receive, taken) in
                        other.receives.iter().enumerate().filter(|(_, taken)| taken.channel == channel)
                    {
                        let receiving = match entry(&taken.steps, content, Step::UNKNOWN) {
                            Step::UNKNOWN => {
                                return Err(Gap::Receive { process: receiver, state: on, receive, content });
                            }
                            Step::REFUSED => continue,
                            step => step,
                        };
                        let label = Label::Handshake {
                            process: process as u32,
                            own: own as u32,
                            receiver: receiver as u32,
                            receive: receive as u32,
                        };
                        self.push(state, out, label, |draft| {
                            self.follow(draft, process, step()?)?;
                            self.follow(draft, receiver, receiving)?;
                            self.observe(draft, channel, content)
                        })?;
                    }
                }
                Ok(())
            }
        }
    }

    fn take_receive(
        &self,
        state: &[u32],
        transit: &Transit,
        process: usize,
        (number, local): (u32, &Local),
        receive: usize,
        out: &mut Successors,
    ) -> Result<(), Gap> {
        let taken = &local.receives[receive];
        let channel = taken.channel;
        let slot = self.slots.channels[channel];
        let content = state[slot as usize];
        if content == 0 || transit.holds(channel) {
            return Ok(());
        }
        let step = match entry(&taken.steps, content, Step::UNKNOWN) {
            Step::UNKNOWN => return Err(Gap::Receive { process, state: number, receive, content }),
            Step::REFUSED => return Ok(()),
            step => step,
        };
        let line = &self.tables.lines[channel];
        let label = |damage| Label::Receive { process: process as u32, receive: receive as u32, damage };
        self.push(state, out, label(Damage::None), |draft| {
            draft.set(slot, 0);
            self.follow(draft, process, step)?;
            self.observe(draft, channel, content)
        })?;
        if line.may_fail && transit.repeats > 0 {
            self.push(state, out, label(Damage::Repeated), |draft| {
                self.set_transit(draft, Transit { repeats: transit.repeats - 1, ..transit.clone() })?;
                self.follow(draft, process, step)?;
                self.observe(draft, channel, content)
            })?;
        }
        Ok(())
    }

    /// Nothing more happens at this time: the environment moves, and time passes until the next timer or tick.
    fn wait(&self, state: &[u32], transit: &Transit, out: &mut Successors) -> Result<(), Gap> {
        let Some((span, instant)) = self.next_instant(state) else { return Ok(()) };
        let clock = *self.tables.clocks.get(state[self.slots.clock as usize]);
        let is_tick = instant == Instant::Tick;
        let until_tick = match self.tables.ticks {
            Some(ticks) if is_tick => ticks.period,
            _ => clock.until_tick.saturating_sub(span),
        };
        let next = Clock { has_ticked: clock.has_ticked || is_tick, until_tick };
        let next = self.tables.clocks.find_value(&next).ok_or(Gap::Clock(next))?;
        for (index, moved) in self.moves(state, instant)?.iter().enumerate() {
            let begin = out.changes.len();
            let mut draft = Draft { from: state, changes: &mut out.changes, begin };
            let mut fate = self.apply(&mut draft, moved)?;
            fate = fate.and(self.pass_time(&mut draft, span)?);
            if !transit.held.is_empty() {
                self.set_transit(&mut draft, transit.after(span))?;
            }
            let (delivered, told) = if is_tick { self.tick(&mut draft, clock)? } else { (false, Fate::GoOn) };
            draft.set(self.slots.clock, next);
            out.finish(Label::Wait { index: index as u32, delivered }, fate.and(told));
        }
        Ok(())
    }

    /// Lets time pass in all processes; timers that are due fire.
    fn pass_time(&self, draft: &mut Draft<'_>, span: Duration) -> Result<Fate, Gap> {
        let mut fate = Fate::GoOn;
        if span.is_zero() && self.populated().all(|process| self.local_of(draft, process).timer.is_none()) {
            return Ok(fate);
        }
        let number = self.tables.spans.find_value(&span);
        for process in self.populated() {
            let local = self.local_of(draft, process);
            if local.is_timeless {
                continue;
            }
            let step = number.map_or(Step::UNKNOWN, |number| entry(&local.later, number, Step::UNKNOWN));
            if step == Step::UNKNOWN {
                let state = draft.get(self.slots.processes[process]);
                return Err(Gap::Later { process, state, span });
            }
            fate = fate.and(self.follow(draft, process, step)?);
        }
        Ok(fate)
    }

    /// The tick arrives. Returns whether it is delivered.
    fn tick(&self, draft: &mut Draft<'_>, clock: Clock) -> Result<(bool, Fate), Gap> {
        let Some(ticks) = self.tables.ticks else { return Ok((false, Fate::GoOn)) };
        let generator = ticks.generator.index();
        let state = draft.get(self.slots.processes[generator]);
        let local = self.tables.locals[generator].get(state);
        let output = self.tables.tick_channel;
        let is_idle = local.own.is_empty() && draft.get(self.slots.channels[output]) == 0;
        let delivered = is_idle && self.populated().any(|process| self.local_of(draft, process).awaits_any(output));
        if delivered {
            match local.ticked {
                UNKNOWN => return Err(Gap::Ticked { process: generator, state }),
                ticked => draft.set(self.slots.processes[generator], ticked),
            }
        }
        if !self.has_monitor {
            return Ok((delivered, Fate::GoOn));
        }
        let number = draft.get(self.slots.monitor);
        let next = self.tables.monitors.get(number).ticked[usize::from(clock.has_ticked)];
        if next == UNKNOWN {
            return Err(Gap::ObservedTick { state: number, has_ticked: clock.has_ticked });
        }
        draft.set(self.slots.monitor, next);
        Ok((delivered, self.judged(next)))
    }

    /// The environment moves while time stands still: in any state if `anywhere`, otherwise in quiet states if a
    /// process can move then.
    fn drive(&self, state: &[u32], out: &mut Successors) -> Result<(), Gap> {
        if self.tables.driven.is_empty() || !(out.is_quiet || self.anywhere) {
            return Ok(());
        }
        if !self.anywhere && !self.tables.may_stir(&self.key(state)) {
            return Ok(());
        }
        let mut vector = state.to_vec();
        for (index, moved) in self.moves(state, Instant::Between)?.iter().enumerate() {
            if moved.processes.is_empty() && !self.anywhere {
                continue;
            }
            let begin = out.changes.len();
            let mut draft = Draft { from: state, changes: &mut out.changes, begin };
            let fate = self.apply(&mut draft, moved)?;
            let changes = &out.changes[begin..];
            changes.iter().for_each(|(slot, value)| vector[*slot as usize] = *value);
            let is_told = if self.anywhere { vector != state } else { self.is_busy(&vector, moved)? };
            changes.iter().for_each(|(slot, _)| vector[*slot as usize] = state[*slot as usize]);
            if is_told {
                out.finish(Label::Drive { index: index as u32 }, fate);
            } else {
                out.changes.truncate(begin);
            }
        }
        Ok(())
    }

    /// Whether a move of the environment enables a process of a quiet system: one that has changed, or one that waits
    /// for it in a handshake.
    fn is_busy(&self, vector: &[u32], moved: &Moved) -> Result<bool, Gap> {
        let transit = self.transit(vector);
        let mut out = Successors::default();
        let changed = moved.processes.iter().map(|(process, _)| *process as usize);
        for process in changed.chain(self.tables.shakers.iter().copied()) {
            let number = vector[self.slots.processes[process] as usize];
            let local = self.tables.locals[process].get(number);
            for own in 0..local.own.len() {
                self.take_own(vector, transit, process, (number, local), own, &mut out)?;
            }
            for receive in 0..local.receives.len() {
                self.take_receive(vector, transit, process, (number, local), receive, &mut out)?;
            }
            if out.len() > 0 {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn moves(&self, state: &[u32], instant: Instant) -> Result<&[Moved], Gap> {
        let key = self.key(state);
        match self.tables.moves[instant as usize].get(&key) {
            Some(moves) => Ok(moves),
            None => Err(Gap::Moves { key, instant }),
        }
    }

    /// Everything on which the moves of the environment depend: its state, and those of the processes that it drives.
    fn key(&self, state: &[u32]) -> Vec<u32> {
        let driven = self.tables.driven.iter().map(|process| state[self.slots.processes[*process] as usize]);
        std::iter::once(state[self.slots.environment as usize]).chain(driven).collect()
    }

    fn apply(&self, draft: &mut Draft<'_>, moved: &Moved) -> Result<Fate, Gap> {
        draft.set(self.slots.environment, moved.state);
        let steps = moved.processes.iter();
        steps
            .map(|(process, step)| self.follow(draft, *process as usize, *step))
            .try_fold(Fate::GoOn, |fate, next| Ok(fate.and(next?)))
    }

    /// Adds a successor.
    fn push(
        &self,
        state: &[u32],
        out: &mut Successors,
        label: Label,
        change: impl FnOnce(&mut Draft<'_>) -> Result<Fate, Gap>,
    ) -> Result<(), Gap> {
        let begin = out.changes.len();
        let fate = change(&mut Draft { from: state, changes: &mut out.changes, begin })?;
        out.finish(label, fate);
        Ok(())
    }

    /// A process takes a step, and its peers learn which of its requests are still open.
    fn follow(&self, draft: &mut Draft<'_>, process: usize, step: Step) -> Result<Fate, Gap> {
        if step.next == ENDLESS {
            return Ok(Fate::Endless);
        }
        debug_assert!(step.next != UNKNOWN && step.next != REFUSED, "a step is computed before it is taken");
        draft.set(self.slots.processes[process], step.next);
        if step.renaming != 0 {
            self.rename(draft, process, step.renaming)?;
        }
        Ok(Fate::GoOn)
    }

    fn rename(&self, draft: &mut Draft<'_>, mover: usize, renaming: u32) -> Result<(), Gap> {
        let mut receivers = Vec::new();
        for (channel, _) in self.tables.renamings.get(renaming) {
            let line = &self.tables.lines[*channel];
            receivers.extend(line.receivers.iter().copied().filter(|process| *process != mover));
            for channel in std::iter::once(*channel).chain(line.opposite) {
                let slot = self.slots.channels[channel];
                let content = draft.get(slot);
                if content == 0 {
                    continue;
                }
                let renamed = self.tables.lines[channel].renamed.get(renaming as usize);
                match renamed.map_or(UNKNOWN, |renamed| entry(renamed, content, UNKNOWN)) {
                    UNKNOWN => return Err(Gap::RenamedContent { channel, content, renaming }),
                    renamed => draft.set(slot, renamed),
                }
            }
        }
        // Each process once, whichever of these channels it receives from.
        receivers.sort_unstable();
        receivers.dedup();
        for process in receivers {
            let slot = self.slots.processes[process];
            let state = draft.get(slot);
            match entry(&self.tables.locals[process].get(state).renamed, renaming, UNKNOWN) {
                UNKNOWN => return Err(Gap::RenamedProcess { process, state, renaming }),
                renamed => draft.set(slot, renamed),
            }
        }
        Ok(())
    }

    /// The monitor observes a message as it is received.
    fn observe(&self, draft: &mut Draft<'_>, channel: usize, content: u32) -> Result<Fate, Gap> {
        if !self.has_monitor || self.tables.lines[channel].is_internal {
            return Ok(Fate::GoOn);
        }
        let state = draft.get(self.slots.monitor);
        let after = self.tables.monitors.get(state).after.get(channel);
        match after.map_or(UNKNOWN, |after| entry(after, content, UNKNOWN)) {
            UNKNOWN => Err(Gap::Observed { state, channel, content }),
            next => {
                draft.set(self.slots.monitor, next);
                Ok(self.judged(next))
            }
        }
    }

    fn judged(&self, monitor: u32) -> Fate {
        match self.tables.monitors.get(monitor).verdict {
            Verdict::Inconclusive => Fate::GoOn,
            Verdict::True => Fate::Settled,
            Verdict::False => Fate::Violated,
        }
    }

    fn set_transit(&self, draft: &mut Draft<'_>, transit: Transit) -> Result<(), Gap> {
        let number = self.tables.transits.find_value(&transit).ok_or(Gap::Transit(transit))?;
        draft.set(self.slots.transit, number);
        Ok(())
    }

    /// The processes that are not composed of others.
    pub(crate) fn populated(&self) -> impl Iterator<Item = usize> {
        (0..self.tables.locals.len()).filter(|process| self.tables.locals[*process].len() > 0)
    }

    fn local(&self, state: &[u32], process: usize) -> &Local {
        self.tables.locals[process].get(state[self.slots.processes[process] as usize])
    }

    fn local_of(&self, draft: &Draft<'_>, process: usize) -> &Local {
        self.tables.locals[process].get(draft.get(self.slots.processes[process]))
    }
}

impl Local {
    /// Whether it waits for a tick on this channel.
    pub(crate) fn awaits_any(&self, channel: usize) -> bool {
        self.receives.iter().any(|receive| receive.channel == channel && receive.pattern == Pattern::Any)
    }
}

impl Successors {
    fn finish(&mut self, label: Label, fate: Fate) {
        self.ends.push(self.changes.len());
        self.labels.push(label);
        self.fates.push(fate);
    }
}

impl Fate {
    /// The worse one.
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::GoOn, other) => other,
            (first, _) => first,
        }
    }
}
