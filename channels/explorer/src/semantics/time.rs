//! The passing of time, and the moves of the environment.

use std::mem;
use std::time::Duration;

use super::{Draft, Fate, Label, Semantics, Successors};
use crate::environment::Instant;
use crate::local::{Step, UNKNOWN, bit, entry};
use crate::tables::{ClockState, Gap, Moved, Situation, Transit};

impl Semantics {
    /// The time until the next timer or tick, and which of the two it is.
    pub(super) fn next_instant(&self, state: &[u32]) -> Option<(Duration, Instant)> {
        let clock = self.tables.clocks.get(state[self.slots.clock as usize]);
        let timers = self.populated().filter_map(|process| self.local(state, process).timer);
        let held = self.transit(state).held.iter().map(|(_, until)| *until);
        let timer = timers.chain(held).min();
        let tick = self.tables.ticks.map(|_| clock.until_tick);
        let span = timer.into_iter().chain(tick).min()?;
        Some((span, if tick == Some(span) { Instant::Tick } else { Instant::Between }))
    }

    /// Nothing more happens at this time: the environment moves, and time passes until the next timer or tick.
    pub(super) fn wait(&self, state: &[u32], transit: &Transit, out: &mut Successors) -> Result<(), Gap> {
        let Some((span, instant)) = self.next_instant(state) else { return Ok(()) };
        let clock = *self.tables.clocks.get(state[self.slots.clock as usize]);
        let is_tick = instant == Instant::Tick;
        let until_tick = match self.tables.ticks {
            Some(ticks) if is_tick => ticks.period,
            _ => clock.until_tick.saturating_sub(span),
        };
        let next = ClockState { has_ticked: clock.has_ticked || is_tick, until_tick };
        let next = self.tables.clocks.find_value(&next).ok_or(Gap::Clock(next))?;
        // Most processes are timeless. Those that are not are found once here and not for each move, which may only add
        // the processes that it changes.
        let is_aware = |process: &usize| !self.local(state, *process).is_timeless;
        let aware = self.populated().filter(is_aware).fold(0, |all, process| all | bit(process));
        for (index, moved) in self.moves(state, instant, out)?.iter().enumerate() {
            let begin = out.changes.len();
            let mut draft = Draft { from: state, changes: &mut out.changes, begin };
            let mut fate = self.apply(&mut draft, *moved)?;
            fate = fate.and(self.pass_time(&mut draft, span, aware)?);
            if !transit.held.is_empty() {
                self.set_transit(&mut draft, transit.after(span))?;
            }
            let (delivered, judged) = if is_tick { self.tick(&mut draft, clock)? } else { (false, Fate::GoOn) };
            draft.set(self.slots.clock, next);
            out.finish(Label::Wait { index: index as u32, delivered }, fate.and(judged));
        }
        Ok(())
    }

    /// Lets time pass in all processes; timers that are due fire. `aware` is the set of processes on which time had an
    /// effect before the first change.
    fn pass_time(&self, draft: &mut Draft<'_>, span: Duration, aware: u64) -> Result<Fate, Gap> {
        let mut fate = Fate::GoOn;
        if span.is_zero() && self.populated().all(|process| self.local_of(draft, process).timer.is_none()) {
            return Ok(fate);
        }
        let number = self.tables.spans.find_value(&span);
        let with_changed =
            |draft: &Draft<'_>| draft.changed().fold(aware, |all, slot| all | self.slots.owners[slot as usize]);
        let mut candidates = with_changed(draft);
        for process in self.populated() {
            if candidates & bit(process) == 0 {
                continue;
            }
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
            // Its peers have changed with it, and time may have an effect on their new states.
            if step.renaming != 0 {
                candidates = with_changed(draft);
            }
        }
        Ok(fate)
    }

    /// The tick arrives. Returns whether it is delivered.
    fn tick(&self, draft: &mut Draft<'_>, clock: ClockState) -> Result<(bool, Fate), Gap> {
        let Some(ticks) = self.tables.ticks else { return Ok((false, Fate::GoOn)) };
        let generator = ticks.generator.index();
        let state = draft.get(self.slots.processes[generator]);
        let local = self.tables.locals[generator].get(state);
        let output = self.tables.tick_channel;
        let is_idle = local.own.is_empty() && draft.get(self.slots.channels[output]) == 0;
        // A tick is delivered or lost at once and never waits, as `ChannelSystem::generate_tick` has it.
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
    pub(super) fn drive(&self, state: &[u32], out: &mut Successors) -> Result<(), Gap> {
        if self.tables.driven.is_empty() || !(out.is_quiet || self.anywhere) {
            return Ok(());
        }
        if !self.anywhere && self.situation(state, out).is_some_and(|situation| !situation.may_stir) {
            return Ok(());
        }
        // The state after each move is made in one vector, and taken back: a state has many moves, of which each
        // changes a few slots.
        let mut vector = mem::take(&mut out.moved);
        state.clone_into(&mut vector);
        for (index, moved) in self.moves(state, Instant::Between, out)?.iter().enumerate() {
            if self.tables.effect(*moved).is_empty() && moved.shown.is_none() && !self.anywhere {
                continue;
            }
            let begin = out.changes.len();
            let mut draft = Draft { from: state, changes: &mut out.changes, begin };
            let fate = self.apply(&mut draft, *moved)?;
            let changes = &out.changes[begin..];
            changes.iter().for_each(|(slot, value)| vector[*slot as usize] = *value);
            let is_seen = vector[self.slots.monitor as usize] != state[self.slots.monitor as usize];
            // A process in which messages pile up is not changed in the vector, although the move acts on it.
            let counts = fate == Fate::Endless
                || if self.anywhere { vector != state } else { is_seen || self.is_busy(&vector, *moved, out)? };
            for (slot, _) in &out.changes[begin..] {
                vector[*slot as usize] = state[*slot as usize];
            }
            if counts {
                out.finish(Label::Drive { index: index as u32 }, fate);
            } else {
                out.changes.truncate(begin);
            }
        }
        out.moved = vector;
        Ok(())
    }

    /// Whether a move of the environment enables a process of a quiet system: one that has changed, or one that waits
    /// for it in a handshake.
    fn is_busy(&self, vector: &[u32], moved: Moved, out: &mut Successors) -> Result<bool, Gap> {
        let transit = self.transit(vector);
        let (before, changes) = (out.len(), out.changes.len());
        let changed = self.tables.effect(moved).iter().map(|(process, _)| *process as usize);
        for process in changed.chain(self.tables.shakers.iter().copied()) {
            let actor = self.actor(vector, transit, process);
            for own in 0..actor.local.own.len() {
                self.take_own(actor, own, out)?;
            }
            for receive in 0..actor.local.receives.len() {
                self.take_receive(actor, receive, out)?;
            }
            if out.len() > before {
                out.truncate(before, changes);
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn moves(&self, state: &[u32], instant: Instant, out: &mut Successors) -> Result<&[Moved], Gap> {
        let moves = self.situation(state, out).and_then(|situation| situation.at(instant));
        moves.ok_or_else(|| Gap::Moves { key: self.key(state).collect(), instant })
    }

    fn situation(&self, state: &[u32], out: &mut Successors) -> Option<&Situation> {
        out.key.clear();
        out.key.extend(self.key(state));
        self.tables.situations.get(&out.key)
    }

    /// Everything on which the moves of the environment depend: its state, and those of the processes that it drives.
    pub(super) fn key<'a>(&'a self, state: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
        let driven = self.tables.driven.iter().map(|process| state[self.slots.processes[*process] as usize]);
        std::iter::once(state[self.slots.environment as usize]).chain(driven)
    }

    fn apply(&self, draft: &mut Draft<'_>, moved: Moved) -> Result<Fate, Gap> {
        draft.set(self.slots.environment, moved.state);
        let steps = self.tables.effect(moved).iter();
        let fate = steps
            .map(|(process, step)| self.follow(draft, *process as usize, *step))
            .try_fold(Fate::GoOn, |fate, next| Ok(fate.and(next?)))?;
        match moved.shown {
            Some((channel, content)) => Ok(fate.and(self.observe(draft, channel as usize, content)?)),
            None => Ok(fate),
        }
    }
}
