//! The transitions of processes, and the effect of messages on the monitor.

use std::collections::BTreeMap;

use channels::{Capacity, Verdict};

use super::{MONITOR, PILED_UP, Writer, any, choice, either, in_words};
use crate::local::{Own, REFUSED, Step, UNKNOWN, Watching, entry};
use crate::tables::ENDLESS;

/// A transition of the system.
pub(super) struct GuardedStep {
    /// The processes that take part, each in one of its states.
    pub(super) of: Vec<(usize, u32)>,
    pub(super) guard: String,
    pub(super) body: String,
    pub(super) words: String,
}

/// By channel and message: the receiving processes, each in one of its states.
type Receivers = BTreeMap<(usize, u32), Vec<(usize, u32, Step)>>;

impl Writer<'_> {
    /// All transitions of the processes.
    pub(super) fn steps(&mut self) -> Vec<GuardedStep> {
        let semantics = self.semantics;
        let receivers = self.receivers();
        let mut steps = Vec::new();
        for process in semantics.populated() {
            for (state, local) in (0..).zip(semantics.tables.locals[process].iter()) {
                for own in local.own.iter().filter(|own| own.step != Step::UNKNOWN) {
                    steps.extend(self.own(process, state, own, &receivers));
                }
            }
        }
        for ((channel, content), receivers) in &receivers {
            if semantics.tables.links[*channel].capacity == Capacity::One {
                for (process, state, step) in receivers {
                    steps.extend(self.receive(*channel, *content, (*process, *state, *step)));
                }
            }
        }
        steps
    }

    fn receivers(&self) -> Receivers {
        let mut receivers = Receivers::new();
        for process in self.semantics.populated() {
            for (state, local) in (0..).zip(self.tables().locals[process].iter()) {
                for receive in &local.receives {
                    let known = (0..).zip(&receive.steps).filter(|(_, step)| ![UNKNOWN, REFUSED].contains(&step.next));
                    for (content, step) in known {
                        receivers.entry((receive.channel, content)).or_default().push((process, state, *step));
                    }
                }
            }
        }
        receivers
    }

    /// An internal action or a send.
    fn own(&mut self, process: usize, state: u32, own: &Own, receivers: &Receivers) -> Vec<GuardedStep> {
        match own.sends {
            None => {
                let guard = format!("{} == {state}", self.process(process));
                let words = format!("{} acts", self.semantics.tables.names[process]);
                let body = self.follow(process, own.step).join("; ");
                vec![GuardedStep { of: vec![(process, state)], guard, body, words }]
            }
            Some(sent) => match self.semantics.tables.links[sent.0].capacity {
                Capacity::Zero => self.handshakes((process, state), sent, own.step, receivers),
                Capacity::One => self.sends((process, state), sent, own.step),
            },
        }
    }

    /// A send on a channel of capacity 0: a step for each receiver that accepts the message.
    fn handshakes(
        &mut self,
        (process, state): (usize, u32),
        (channel, content): (usize, u32),
        step: Step,
        receivers: &Receivers,
    ) -> Vec<GuardedStep> {
        let names = &self.semantics.tables.names;
        let peers = receivers.get(&(channel, content)).into_iter().flatten();
        let handshake = |(receiver, on, receiving): &(usize, u32, Step)| {
            let guard = format!("{} == {state} && {} == {on}", self.process(process), self.process(*receiver));
            let changes = [self.follow(process, step), self.follow(*receiver, *receiving)].concat();
            let sent = self.message(channel, content);
            let words = format!("{} sends {sent} to {}", names[process], names[*receiver]);
            let of = vec![(process, state), (*receiver, *on)];
            GuardedStep { of, guard, body: self.observed(channel, content, changes), words }
        };
        peers.filter(|(receiver, ..)| *receiver != process).map(handshake).collect()
    }

    /// A send on a channel of capacity 1: a step for each thing that may happen to the message.
    fn sends(
        &mut self,
        (process, state): (usize, u32),
        (channel, content): (usize, u32),
        step: Step,
    ) -> Vec<GuardedStep> {
        let semantics = self.semantics;
        let variable = self.channel(channel);
        let is_possible = format!("{} == {state} && {}", self.process(process), self.has_room(channel, content));
        let words = format!("{} sends {}", semantics.tables.names[process], self.message(channel, content));
        let follow = self.follow(process, step);
        let put = |guard: &str, change: String, fate: &str| {
            // What piles up has no next state, so the step has none either.
            let change = (step.next != ENDLESS).then_some(change);
            let body = change.into_iter().chain(follow.clone()).collect::<Vec<_>>().join("; ");
            let (guard, words) = (format!("{is_possible}{guard}"), format!("{words}{fate}"));
            GuardedStep { of: vec![(process, state)], guard, body, words }
        };
        let mut steps = vec![put("", format!("{variable} = {content}"), "")];
        if semantics.tables.links[channel].may_fail && semantics.tables.transits.get(0).losses > 0 {
            steps.push(put(" && losses > 0", format!("{variable} = 0; losses--"), ", which is lost"));
        }
        if self.may_hold(channel) {
            let (held, time) = (self.held(channel), self.time(semantics.hold));
            let hold = format!("{variable} = {content}; delays--; {held} = {time}");
            steps.push(put(" && delays > 0", hold, ", which is held back"));
        }
        steps
    }

    /// Whether a channel is empty, or holds a message that gives way to this one.
    fn has_room(&mut self, channel: usize, content: u32) -> String {
        let (line, variable) = (&self.semantics.tables.links[channel], self.channel(channel));
        let is_empty = format!("{variable} == 0");
        let messages = 1..line.contents.len() as u32;
        let mut older = messages.filter(|waiting| line.gives_way(*waiting, content));
        let Some(first) = older.next() else { return is_empty };
        if let Some(known) = self.rooms.get(&(channel, first)) {
            return known.clone();
        }
        let gives_way = any(&variable, std::iter::once(first).chain(older));
        let room = match self.may_hold(channel) {
            true => format!("({is_empty} || ({gives_way} && {} < 0))", self.held(channel)),
            false => either(vec![is_empty, gives_way]),
        };
        self.rooms.insert((channel, first), room.clone());
        room
    }

    fn receive(
        &mut self,
        channel: usize,
        content: u32,
        (process, state, step): (usize, u32, Step),
    ) -> Vec<GuardedStep> {
        let tables = &self.semantics.tables;
        let variable = self.channel(channel);
        let is_held = if self.may_hold(channel) { format!(" && {} < 0", self.held(channel)) } else { String::new() };
        let guard = format!("{} == {state} && {variable} == {content}{is_held}", self.process(process));
        let words = format!("{} receives {}", tables.names[process], self.message(channel, content));
        let follow = self.follow(process, step);
        let take = |guard: String, change: String, words: String| {
            let body = self.observed(channel, content, [vec![change], follow.clone()].concat());
            GuardedStep { of: vec![(process, state)], guard, body, words }
        };
        let mut steps = vec![take(guard.clone(), format!("{variable} = 0"), words.clone())];
        if tables.links[channel].may_fail && tables.transits.get(0).repeats > 0 {
            let words = format!("{words}, which will be repeated");
            steps.push(take(format!("{guard} && repeats > 0"), "repeats--".to_owned(), words));
        }
        steps
    }

    fn message(&self, channel: usize, content: u32) -> String {
        self.tables().links[channel].contents.get(content).as_ref().map(in_words).unwrap_or_default()
    }

    /// The effect of a message on each state of the monitor: the states with each verdict afterwards.
    fn after(&self, channel: usize, content: u32) -> Vec<(u32, u32, Verdict)> {
        if !self.semantics.has_monitor || self.tables().links[channel].is_internal {
            return Vec::new();
        }
        let monitors = &self.tables().monitors;
        let after =
            |watching: &Watching| watching.after.get(channel).map_or(UNKNOWN, |after| entry(after, content, UNKNOWN));
        let known = (0..).zip(monitors.iter().map(after)).filter(|(_, after)| *after != UNKNOWN);
        known.map(|(before, after)| (before, after, monitors.get(after).verdict)).collect()
    }

    /// The changes of a step whose message the monitor observes; none in the states in which it decides the property,
    /// and none if messages pile up.
    fn observed(&self, channel: usize, content: u32, mut changes: Vec<String>) -> String {
        let after = self.after(channel, content);
        if changes.iter().any(|change| change == PILED_UP) {
            changes = vec![PILED_UP.to_owned()];
        } else if after.iter().any(|(before, after, verdict)| *verdict == Verdict::Inconclusive && before != after) {
            changes.push(format!("OBSERVE_{channel}_{content}"));
        }
        let before = |verdict| after.iter().filter(move |after| after.2 == verdict).map(|(before, ..)| *before);
        let decided = [(Verdict::False, "assert(false)"), (Verdict::True, "skip")];
        let decided = decided.into_iter().filter(|(verdict, _)| before(*verdict).next().is_some());
        let options: Vec<String> =
            decided.map(|(verdict, body)| format!(":: {} -> {body}", any(MONITOR, before(verdict)))).collect();
        match options.is_empty() {
            true => changes.join("; "),
            false => format!("if {} :: else -> {} fi", options.join(" "), changes.join("; ")),
        }
    }

    /// `OBSERVE_2_5`: the monitor observes message 5 of channel 2.
    pub(super) fn observing_macros(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (channel, line) in self.tables().links.iter().enumerate() {
            for content in 1..line.contents.len() as u32 {
                let after = self.after(channel, content).into_iter();
                let changes =
                    after.filter(|(before, after, verdict)| *verdict == Verdict::Inconclusive && before != after);
                let options: Vec<String> = changes
                    .map(|(before, after, _)| format!(":: {MONITOR} == {before} -> {MONITOR} = {after}"))
                    .collect();
                lines.extend(choice(&options).map(|choice| format!("#define OBSERVE_{channel}_{content} {choice}")));
            }
        }
        lines
    }
}
