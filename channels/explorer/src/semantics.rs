//! What a system can do next: the rules of channel systems, on numbers.

mod slots;
mod successors;
mod time;

use std::time::Duration;

use channels::{Capacity, Enabled, EnabledKind, Pattern, Verdict};

pub(crate) use self::slots::Slots;
use self::successors::Draft;
pub(crate) use self::successors::{Fate, Label, Successors};
use crate::environment::Instant;
use crate::local::{Local, Own, REFUSED, Step, UNKNOWN, bit, entry};
use crate::model::{Damage, Model};
use crate::path::PathStep;
use crate::tables::{ENDLESS, Gap, Tables, Transit};

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

impl Semantics {
    pub(crate) fn new(tables: Tables, slots: Slots, model: &Model, has_monitor: bool, reduce: bool) -> Self {
        let (hold, anywhere) = (model.faults.delayed.1, model.anywhere);
        // An environment that moves anywhere may change a process that is about to send.
        let sends_first = reduce && !anywhere;
        Self { tables, slots, has_monitor, anywhere, hold, sends_first }
    }

    /// Lists the successors of a state, in an order that depends only on the state.
    pub(crate) fn expand(&self, state: &[u32], out: &mut Successors) -> Result<(), Gap> {
        out.clear();
        let transit = self.transit(state);
        if self.sends_first && self.send_first(state, transit, out)? {
            return Ok(());
        }
        let slots = self.slots.channels.iter().enumerate();
        let full =
            slots.fold(0, |all, (channel, slot)| all | if state[*slot as usize] == 0 { 0 } else { bit(channel) });
        for process in self.populated() {
            let actor = self.actor(state, transit, process);
            for own in 0..actor.local.own.len() {
                self.take_own(actor, own, out)?;
            }
            // Most processes wait on empty channels: one operation spares a look at each of their receives. Where
            // channels share a bit, `take_receive` finds the empty one.
            if actor.local.awaits & full != 0 {
                for receive in 0..actor.local.receives.len() {
                    self.take_receive(actor, receive, out)?;
                }
            }
        }
        out.is_quiet = out.len() == 0;
        if out.is_quiet {
            self.wait(state, transit, out)?;
        }
        self.drive(state, out)
    }

    /// Performs the send of the first process that can only send, and returns whether there is one. No process can
    /// prevent the send or depend on when it happened: the channel is empty, no other process sends on it, nothing
    /// happens to its messages, and no numbers change.
    fn send_first(&self, state: &[u32], transit: &Transit, out: &mut Successors) -> Result<bool, Gap> {
        for process in self.populated() {
            let actor = self.actor(state, transit, process);
            let Local { own, receives, .. } = actor.local;
            let ([Own { sends: Some((channel, _)), .. }], []) = (own.as_slice(), receives.as_slice()) else { continue };
            let link = &self.tables.links[*channel];
            let is_safe = !link.may_fail || (transit.losses == 0 && transit.delays == 0);
            let is_free = link.has_sole_sender && state[self.slots.channels[*channel] as usize] == 0;
            if link.capacity == Capacity::One && is_safe && is_free {
                let step = actor.own_step(0)?;
                if step.renaming == 0 && step.next != ENDLESS {
                    self.take_own(actor, 0, out)?;
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
            && successors.labels().all(is_lost)
            && self.populated().all(|process| self.local(state, process).timer.is_none())
    }

    /// The steps that a label stands for, in a state.
    pub(crate) fn path_steps(&self, state: &[u32], label: &Label) -> Vec<PathStep> {
        let moved =
            |instant, index: u32| self.tables.moved(&self.key(state).collect::<Vec<u32>>(), instant, index as usize);
        let local = |process: u32| self.local(state, process as usize);
        let channel = |channel: usize| self.tables.links[channel].id;
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
            Label::Drive { index } => vec![moved(Instant::Between, index)],
            Label::Wait { index, delivered } => {
                let (span, instant) = self.next_instant(state).expect("time passed from here");
                let tick = (instant == Instant::Tick).then_some(PathStep::Tick { delivered });
                [moved(instant, index), PathStep::Wait(span)].into_iter().chain(tick).collect()
            }
        }
    }

    fn transit<'a>(&'a self, state: &[u32]) -> &'a Transit {
        self.tables.transits.get(state[self.slots.transit as usize])
    }

    fn actor<'a>(&'a self, state: &'a [u32], transit: &'a Transit, process: usize) -> Actor<'a> {
        let number = state[self.slots.processes[process] as usize];
        Actor { state, transit, process, number, local: self.tables.locals[process].get(number) }
    }

    /// Takes a step that a process can take alone: an internal action or a send.
    fn take_own(&self, actor: Actor<'_>, own: usize, out: &mut Successors) -> Result<(), Gap> {
        match actor.local.own[own].sends {
            None => self.push(actor.state, out, actor.takes(own, Damage::None), |draft| {
                self.follow(draft, actor.process, actor.own_step(own)?)
            }),
            Some(sent) => match self.tables.links[sent.0].capacity {
                Capacity::One => self.send(actor, own, sent, out),
                Capacity::Zero => self.shake_hands(actor, own, sent, out),
            },
        }
    }

    /// Puts a message into a channel that is empty, or holds a message that gives way to it. What may happen to the
    /// message are steps of their own.
    fn send(
        &self,
        actor: Actor<'_>,
        own: usize,
        (channel, content): (usize, u32),
        out: &mut Successors,
    ) -> Result<(), Gap> {
        let Actor { state, transit, process, .. } = actor;
        let link = &self.tables.links[channel];
        let slot = self.slots.channels[channel];
        let waiting = state[slot as usize];
        if waiting != 0 && (transit.holds(channel) || !link.gives_way(waiting, content)) {
            return Ok(());
        }
        // Asked for only now: a send for which there is never room has no step to compute.
        let step = actor.own_step(own)?;
        let mut put = |content, damage, after: Option<Transit>| {
            self.push(state, out, actor.takes(own, damage), |draft| {
                draft.set(slot, content);
                after.map_or(Ok(()), |after| self.set_transit(draft, after))?;
                self.follow(draft, process, step)
            })
        };
        put(content, Damage::None, None)?;
        if link.may_fail && transit.losses > 0 {
            put(0, Damage::Lost, Some(Transit { losses: transit.losses - 1, ..transit.clone() }))?;
        }
        if link.may_fail && transit.delays > 0 {
            put(content, Damage::Held, Some(transit.holding(channel, self.hold)))?;
        }
        Ok(())
    }

    /// Passes a message to each process that accepts it. On a channel of capacity 0, send and receive are one step.
    fn shake_hands(
        &self,
        actor: Actor<'_>,
        own: usize,
        (channel, content): (usize, u32),
        out: &mut Successors,
    ) -> Result<(), Gap> {
        let Actor { state, transit, process, .. } = actor;
        let receivers = self.tables.links[channel].receivers.iter().copied();
        for receiver in receivers.filter(|receiver| *receiver != process) {
            let peer = self.actor(state, transit, receiver);
            let on_channel = |receive: &usize| peer.local.receives[*receive].channel == channel;
            for receive in (0..peer.local.receives.len()).filter(on_channel) {
                let Some(receiving) = peer.receive_step(receive, content)? else { continue };
                let label = Label::Handshake {
                    process: process as u32,
                    own: own as u32,
                    receiver: receiver as u32,
                    receive: receive as u32,
                };
                self.push(state, out, label, |draft| {
                    let sent = self.follow(draft, process, actor.own_step(own)?)?;
                    let received = self.follow(draft, receiver, receiving)?;
                    Ok(sent.and(received).and(self.observe(draft, channel, content)?))
                })?;
            }
        }
        Ok(())
    }

    /// Takes a message out of a channel, or a copy of it.
    fn take_receive(&self, actor: Actor<'_>, receive: usize, out: &mut Successors) -> Result<(), Gap> {
        let Actor { state, transit, process, .. } = actor;
        let channel = actor.local.receives[receive].channel;
        let slot = self.slots.channels[channel];
        let content = state[slot as usize];
        if content == 0 || transit.holds(channel) {
            return Ok(());
        }
        let Some(step) = actor.receive_step(receive, content)? else { return Ok(()) };
        let label = |damage| Label::Receive { process: process as u32, receive: receive as u32, damage };
        self.push(state, out, label(Damage::None), |draft| {
            draft.set(slot, 0);
            let fate = self.follow(draft, process, step)?;
            Ok(fate.and(self.observe(draft, channel, content)?))
        })?;
        if self.tables.links[channel].may_fail && transit.repeats > 0 {
            // A message is repeated when it is received and not when it is sent: until then, there is nothing to
            // distinguish, and so there are fewer states.
            self.push(state, out, label(Damage::Repeated), |draft| {
                self.set_transit(draft, Transit { repeats: transit.repeats - 1, ..transit.clone() })?;
                let fate = self.follow(draft, process, step)?;
                Ok(fate.and(self.observe(draft, channel, content)?))
            })?;
        }
        Ok(())
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

    /// A process takes a step, and its peers learn which of its requests are still open. If messages pile up in it, it
    /// has no next state and stays as it is: then its fate must not get lost, since nothing that follows is a run.
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
        let changes = self.tables.renamings.get(renaming);
        // Answers have the numbers of their requests, so both directions are renamed.
        for (channel, _) in changes {
            let link = &self.tables.links[*channel];
            for channel in std::iter::once(*channel).chain(link.opposite) {
                let slot = self.slots.channels[channel];
                let content = draft.get(slot);
                if content == 0 {
                    continue;
                }
                let renamed = self.tables.links[channel].renamed.get(renaming as usize);
                match renamed.map_or(UNKNOWN, |renamed| entry(renamed, content, UNKNOWN)) {
                    UNKNOWN => return Err(Gap::RenamedContent { channel, content, renaming }),
                    renamed => draft.set(slot, renamed),
                }
            }
        }
        let receives = |process| changes.iter().any(|(on, _)| self.tables.links[*on].receivers.contains(&process));
        for process in self.populated().filter(|process| *process != mover && receives(*process)) {
            let slot = self.slots.processes[process];
            let state = draft.get(slot);
            match entry(&self.tables.locals[process].get(state).renamed, renaming, UNKNOWN) {
                UNKNOWN => return Err(Gap::RenamedProcess { process, state, renaming }),
                renamed => draft.set(slot, renamed),
            }
        }
        Ok(())
    }

    /// The monitor observes a message as it is received, or shown.
    fn observe(&self, draft: &mut Draft<'_>, channel: usize, content: u32) -> Result<Fate, Gap> {
        if !self.has_monitor || self.tables.links[channel].is_internal {
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
        self.slots.populated.iter().copied()
    }

    fn local(&self, state: &[u32], process: usize) -> &Local {
        self.tables.locals[process].get(state[self.slots.processes[process] as usize])
    }

    fn local_of(&self, draft: &Draft<'_>, process: usize) -> &Local {
        self.tables.locals[process].get(draft.get(self.slots.processes[process]))
    }
}

/// A process in a state of the system.
#[derive(Clone, Copy)]
struct Actor<'a> {
    state: &'a [u32],
    transit: &'a Transit,
    process: usize,
    /// The number of the process's own state.
    number: u32,
    local: &'a Local,
}

impl Actor<'_> {
    fn takes(&self, own: usize, damage: Damage) -> Label {
        Label::Own { process: self.process as u32, own: own as u32, damage }
    }

    fn own_step(&self, own: usize) -> Result<Step, Gap> {
        match self.local.own[own].step {
            Step::UNKNOWN => Err(Gap::Own { process: self.process, state: self.number, own }),
            step => Ok(step),
        }
    }

    /// The step with which it receives a message; `None` if it does not accept the message.
    fn receive_step(&self, receive: usize, content: u32) -> Result<Option<Step>, Gap> {
        match entry(&self.local.receives[receive].steps, content, Step::UNKNOWN) {
            Step::UNKNOWN => Err(Gap::Receive { process: self.process, state: self.number, receive, content }),
            Step::REFUSED => Ok(None),
            step => Ok(Some(step)),
        }
    }
}

impl Local {
    /// Whether it waits for a tick on this channel.
    pub(crate) fn awaits_any(&self, channel: usize) -> bool {
        let mut receives = self.receives.iter();
        self.awaits & bit(channel) != 0
            && receives.any(|receive| receive.channel == channel && receive.pattern == Pattern::Any)
    }
}
