//! Computing what is missing.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Event, EventKind, Message, Monitor, NoNormalForm, NormalForm, Offer, Process,
    RequestNumber, Role, Symbol, TickGenerator, Topology,
};

use super::{ENDLESS, Gap, MoveEffect, Moved, Renaming, Situation, Tables, normalize, same_number};
use crate::environment::Instant;
use crate::error::Refused;
use crate::interner::hash_by;
use crate::local::{Local, Own, Receive, Step, UNKNOWN, Watching, bit, entry, set};

/// The maximum number of states of one process, or of the monitor. Something that grows forever reaches it soon, and is
/// refused by name. Chosen, not measured.
const MAX_LOCALS: usize = 1 << 16;

impl Tables {
    pub(crate) fn fill(&mut self, gap: &Gap) -> Result<(), Refused> {
        match *gap {
            Gap::Own { process, state, own } => {
                let step = self.take(process, state, |local| (local.own[own].transition, None))?;
                self.locals[process].get_mut(state).own[own].step = step;
            }
            Gap::Receive { process, state, receive, content } => self.receive(process, state, receive, content)?,
            Gap::Later { process, state, span } => self.pass_time(process, state, span)?,
            Gap::RenamedProcess { process, state, renaming } => self.rename_process(process, state, renaming)?,
            Gap::RenamedContent { channel, content, renaming } => self.rename_content(channel, content, renaming),
            Gap::Ticked { process, state } => self.generate_tick(process, state)?,
            Gap::Observed { state, channel, content } => self.observe_message(state, channel, content)?,
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

    fn receive(&mut self, process: usize, state: u32, receive: usize, content: u32) -> Result<(), Refused> {
        let Receive { channel, pattern, .. } = &self.locals[process].get(state).receives[receive];
        let envelope = self.links[*channel].contents.get(content).clone();
        let accepts = envelope.as_ref().is_some_and(|envelope| pattern.accepts(&envelope.message));
        let step = match accepts {
            true => self.take(process, state, |local| (local.receives[receive].transition, envelope))?,
            false => Step::REFUSED,
        };
        set(&mut self.locals[process].get_mut(state).receives[receive].steps, content, step, Step::UNKNOWN);
        Ok(())
    }

    fn rename_process(&mut self, process: usize, state: u32, renaming: u32) -> Result<(), Refused> {
        let mut renamed = self.locals[process].get(state).process.clone();
        let normal = self.in_renamed_form(renaming, |form| renamed.normalize(form));
        normal.map_err(|why| self.refused(process, why))?;
        let number = self.local(process, renamed)?;
        set(&mut self.locals[process].get_mut(state).renamed, renaming, number, UNKNOWN);
        Ok(())
    }

    fn rename_content(&mut self, channel: usize, content: u32, renaming: u32) {
        let link = &self.links[channel];
        let mut envelope = link.contents.get(content).clone();
        self.in_renamed_form(renaming, |form| {
            envelope.iter_mut().for_each(|envelope| form.envelope(link.id, envelope))
        });
        let number = self.content(channel, envelope);
        set_in(&mut self.links[channel].renamed, renaming as usize, content, number);
    }

    /// Calls `normalize` with the normal form that gives requests the numbers of a renaming.
    fn in_renamed_form<R>(&self, renaming: u32, normalize: impl FnOnce(&NormalForm<'_>) -> R) -> R {
        let changes = self.renamings.get(renaming);
        let numbers = |channel, number| renumbered(changes, channel, number);
        normalize(&NormalForm::new(&self.topology, NormalForm::NOW, &numbers))
    }

    fn generate_tick(&mut self, process: usize, state: u32) -> Result<(), Refused> {
        let mut generator = self.locals[process].get(state).process.clone();
        if let Some(generator) = generator.as_any_mut().downcast_mut::<TickGenerator>() {
            generator.generate(0);
        }
        self.look(process, generator.as_ref());
        let number = self.local(process, generator)?;
        self.locals[process].get_mut(state).ticked = number;
        Ok(())
    }

    fn observe_message(&mut self, state: u32, channel: usize, content: u32) -> Result<(), Refused> {
        let link = &self.links[channel];
        let message = link.contents.get(content).as_ref().map(|envelope| envelope.message.clone());
        let kind = message.map(|message| EventKind::Received { channel: link.id, message });
        let number = self.observe(state, 0, kind.unwrap_or(EventKind::Tick))?;
        set_in(&mut self.monitors.get_mut(state).after, channel, content, number);
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
        let link = &self.links[channel];
        let message = link.contents.get(content).as_ref().map(|envelope| &envelope.message);
        match message.filter(|message| !self.topology.carries(link.id, message)) {
            None => Ok(()),
            Some(message) => Err(Refused::OutsideDomain {
                process: self.names[process].clone(),
                message: message.clone(),
                channel: self.topology.describe(link.id),
                domain: self.topology.get(link.id).domain.to_string(),
            }),
        }
    }

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
    ///
    /// A request that a process still awaits gets its position among those on its channel as its number, whatever
    /// number it was sent with: otherwise, every request would lead to new states. Its peers know the request by the
    /// old number, so the step carries the new ones.
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

    pub(super) fn look(&self, process: usize, state: &dyn Process) {
        if let Some(onlooker) = &self.onlooker {
            onlooker.see(self.id(process), state);
        }
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
        // A process may keep points in time without a timer. What stays the same for a nanosecond does not depend on
        // them, so it stays the same for any time.
        let is_timeless = timer.is_none() && {
            let mut later = process.clone();
            let a_moment_later = NormalForm::NOW + Duration::from_nanos(1);
            later.normalize(&NormalForm::new(&self.topology, a_moment_later, &same_number)).is_ok()
                && later.same_state(process.as_ref())
        };
        let awaits = receives.iter().fold(0, |all, receive| all | bit(receive.channel));
        let (later, reported, renamed) = (Vec::new(), Vec::new(), Vec::new());
        Local { process, timer, is_timeless, own, receives, awaits, later, reported, renamed, ticked: UNKNOWN }
    }

    /// The number of a channel's contents.
    pub(crate) fn content(&mut self, channel: usize, envelope: Option<Envelope>) -> u32 {
        let Self { topology, links, .. } = self;
        let link = &mut links[channel];
        let message = envelope.as_ref().map(|envelope| &envelope.message);
        let head = message.and_then(Message::head).map(Symbol::new);
        let is_topic = message.is_some_and(|message| is_topic(topology, link.id, message));
        let number = link.contents.intern(envelope);
        if link.heads.len() < link.contents.len() {
            link.heads.push((head, is_topic));
        }
        number
    }

    /// The number of a state of the monitor.
    pub(super) fn watching(&mut self, mut monitor: Box<dyn Monitor>) -> Result<u32, Refused> {
        let verdict = monitor.verdict();
        normalize(monitor.as_mut())?;
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

    fn list_moves(&mut self, key: &[u32], instant: Instant) -> Result<(), Refused> {
        let moves = self.possible(key, instant);
        let mut list = Vec::with_capacity(moves.len());
        for choice in moves {
            let mut effect = MoveEffect::new();
            for (index, (state, report)) in key[1..].iter().zip(&choice.reports).enumerate() {
                let process = self.driven[index];
                let step = self.report(process, *state, *report)?;
                let is_same = step == Step { next: *state, renaming: 0 };
                effect.extend((!is_same).then_some((process as u32, step)));
            }
            let shown = self.environment.shown(self.environments.get(key[0]), &choice.state);
            let shown = shown.map(|(channel, message)| {
                (channel.index() as u32, self.content(channel.index(), Some(message.into())))
            });
            let state = self.environments.intern(choice.state);
            list.push(Moved { state, effect: self.effects.intern(effect), shown });
        }
        self.move_count += list.len();
        let may_stir = self.may_stir(key);
        let situation =
            self.situations.entry(key.to_vec()).or_insert_with(|| Situation { may_stir, moves: [None, None] });
        situation.moves[instant as usize] = Some(list);
        Ok(())
    }

    /// The step of a driven process when the environment reports a number to it.
    fn report(&mut self, process: usize, state: u32, report: u32) -> Result<Step, Refused> {
        let local = self.locals[process].get(state);
        let known = entry(&local.reported, report, Step::UNKNOWN);
        if known != Step::UNKNOWN {
            return Ok(known);
        }
        let mut after = local.process.clone();
        self.environment.report(self.id(process), report, after.as_mut(), NormalForm::NOW);
        let step = match after.same_state(local.process.as_ref()) {
            true => Step { next: state, renaming: 0 },
            false => self.settle(process, state, after)?,
        };
        set(&mut self.locals[process].get_mut(state).reported, report, step, Step::UNKNOWN);
        Ok(step)
    }
}

/// Sets the entry at an index in one of several lists, each of which may still be missing.
fn set_in(lists: &mut Vec<Vec<u32>>, list: usize, index: u32, value: u32) {
    if lists.len() <= list {
        lists.resize_with(list + 1, Vec::new);
    }
    set(&mut lists[list], index, value, UNKNOWN);
}

fn renumbered(changes: &Renaming, channel: ChannelId, number: RequestNumber) -> RequestNumber {
    let Some((_, numbers)) = changes.iter().find(|(on, _)| *on == channel.index()) else { return number };
    let index = number.0.checked_sub(1).and_then(|index| usize::try_from(index).ok());
    RequestNumber(index.and_then(|index| numbers.get(index)).copied().unwrap_or(0))
}

fn is_topic(topology: &Topology, channel: ChannelId, message: &Message) -> bool {
    topology.get(channel).domain.shape_of(message).is_some_and(|shape| shape.role() == Role::Topic)
}

/// The next multiple of `step`.
fn round_up(time: Duration, step: Duration) -> Duration {
    match step.as_nanos() {
        0 => time,
        step => Duration::from_nanos((time.as_nanos().div_ceil(step) * step) as u64),
    }
}
