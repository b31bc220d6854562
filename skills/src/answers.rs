//! How a machine answers the tree, as far as its file shows: whether it can be halted while it is running, confirms a
//! halt, and answers each request once.
//!
//! All states are visited in which the machine can be, each with what it owes the tree. Conditions and events of other
//! processes are taken to be possible, so what no path does cannot happen. A machine whose file does not show what it
//! sends to the tree is not judged: one with parallel states, history or invoked machines, or with computed or delayed
//! answers.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::Problem;

use crate::Concerns;
use crate::chart::{
    Action, ActionKind, Block, CHANNEL_PROCESSOR, Chart, Delay, EventClass, Send, StateKind, Transition,
    TransitionDomain, visit_actions,
};
use crate::ids::{StateId, TransitionId};
use crate::load::constant;
use crate::process::CLIENT;

/// What the machine and the tree await of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Owes {
    /// The tree may ask.
    Nothing,
    /// An answer to a tick.
    Answer,
    /// The tree may ask again, or halt the leaf.
    Running,
    /// The confirmation of a halt.
    Halted,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum TreeAnswer {
    Running,
    Final,
    Halted,
}

impl TreeAnswer {
    fn named(name: &str) -> Option<Self> {
        match name {
            "running" => Some(Self::Running),
            "success" | "failure" => Some(Self::Final),
            "halted" => Some(Self::Halted),
            _ => None,
        }
    }

    /// Whether this is what the machine owes.
    fn is_owed(self, owes: Owes) -> bool {
        match self {
            Self::Halted => owes == Owes::Halted,
            Self::Running | Self::Final => owes == Owes::Answer,
        }
    }

    fn after(self) -> Owes {
        if self == Self::Running { Owes::Running } else { Owes::Nothing }
    }
}

impl Chart {
    /// Whether it is made to answer a tree: it has transitions for its requests.
    #[must_use]
    pub fn is_skill(&self) -> bool {
        self.names(&request("tick"))
    }

    /// Warnings about its answers to the tree, as far as the file shows; `None` if there are none. A condition is never
    /// halted: `can_halt` is false if all leaves that use the machine are conditions.
    #[must_use]
    pub fn answer_concerns(&self, can_halt: bool) -> Option<Concerns> {
        if !self.is_skill() || !shows_its_answers(self) {
            return None;
        }
        let mut problems = Conversation::of(self, can_halt).problems();
        problems.sort_by_key(Problem::offset);
        Concerns::of(self.file(), problems)
    }

    /// Whether the machine may give the tree a value of the port with this name in an answer.
    #[must_use]
    pub fn answers_with(&self, port: &str) -> bool {
        let mut answers = self.inner().any(|inner| inner.answers_with(port));
        self.visit_sends(&mut |send| {
            let is_unclear = send.payload.content.is_some();
            answers |= to_tree(send) != Some(false) && (is_unclear || send.named().any(|(name, ..)| &**name == port));
        });
        answers
    }
}

/// An event of the tree.
fn request(name: &str) -> String {
    format!("{CLIENT}.{name}")
}

/// Whether a `<send>` goes to the tree; `None` if that is computed.
fn to_tree(send: &Send) -> Option<bool> {
    let Some(processor) = &send.processor else { return Some(false) };
    if &**processor.literal()? != CHANNEL_PROCESSOR {
        return Some(false);
    }
    send.target.as_ref().map_or(Some(false), |target| target.literal().map(|target| &**target == CLIENT))
}

/// Whether the file shows what the machine answers, and when.
fn shows_its_answers(chart: &Chart) -> bool {
    let is_simple = |id: StateId| {
        let state = chart.state(id);
        !matches!(state.kind, StateKind::Parallel | StateKind::History(_)) && state.invokes.is_empty()
    };
    let is_clear = |send: &Send| match to_tree(send) {
        Some(false) => true,
        Some(true) => {
            let event = send.event.as_ref().and_then(|event| event.literal());
            event.is_some() && matches!(send.delay, Delay::Literal(delay) if delay.is_zero())
        }
        None => false,
    };
    let mut is_shown = chart.states().all(is_simple);
    for block in chart.blocks() {
        visit_actions(block, &mut |action| match &action.kind {
            ActionKind::Send(send) => is_shown &= is_clear(send),
            ActionKind::Foreach(foreach) => visit_actions(&foreach.content, &mut |action| {
                is_shown &= !matches!(&action.kind, ActionKind::Send(send) if to_tree(send) == Some(true));
            }),
            _ => {}
        });
    }
    is_shown
}

/// Where the machine can be, and what it then owes.
type Moment = (StateId, Owes);

/// The whole conversation between the machine and the tree.
struct Conversation<'c> {
    chart: &'c Chart,
    can_halt: bool,
    tick: EventClass,
    halt: EventClass,
    /// Whether it sends anything to itself or to others than the tree, which may answer.
    gets_others: bool,
    /// The next moments of each. What is owed is settled in between if the machine owes it no more.
    next: BTreeMap<Moment, BTreeSet<Moment>>,
    /// By the position of an answer and the transition that sends it: whether it was ever owed, and the answer.
    answers: BTreeMap<(usize, Option<TransitionId>), (bool, &'c Send)>,
    /// The transition that is being taken.
    way: Option<TransitionId>,
    /// By transition for a halt that can be taken when the leaf is running: the moments after it.
    halts: BTreeMap<TransitionId, BTreeSet<Moment>>,
    /// The states in which the leaf can be running, and that no halt leaves.
    deaf: BTreeSet<StateId>,
}

impl<'c> Conversation<'c> {
    fn of(chart: &'c Chart, can_halt: bool) -> Self {
        let mut gets_others = false;
        chart.visit_sends(&mut |send| gets_others |= to_tree(send) != Some(true));
        let mut conversation = Self {
            chart,
            can_halt,
            tick: chart.events.class(&request("tick")),
            halt: chart.events.class(&request("halt")),
            gets_others,
            next: BTreeMap::new(),
            answers: BTreeMap::new(),
            way: None,
            halts: BTreeMap::new(),
            deaf: BTreeSet::new(),
        };
        let start = BTreeSet::from([Owes::Nothing]);
        let mut open: Vec<Moment> = conversation.enter(StateId::ROOT, StateId::ROOT, start).into_iter().collect();
        while let Some(moment) = open.pop() {
            if conversation.next.contains_key(&moment) {
                continue;
            }
            let next = conversation.step(moment);
            open.extend(&next);
            conversation.next.insert(moment, next);
        }
        conversation
    }

    /// The moments after this one.
    fn step(&mut self, (state, owes): Moment) -> BTreeSet<Moment> {
        let mut next = BTreeSet::new();
        let chart = self.chart;
        let ways: Vec<TransitionId> = std::iter::once(state)
            .chain(chart.ancestors(state))
            .flat_map(|state| chart.state(state).transitions().iter().copied())
            .filter(|way| constant(chart, chart.transition(*way)) != Some(false))
            .collect();
        let is_eventless = |way: &&TransitionId| chart.transition(**way).descriptors.is_empty();
        for way in ways.iter().filter(is_eventless) {
            next.extend(self.take(*way, state, owes));
            if is_certain(chart, *way) {
                // The machine is never at rest here.
                return next;
            }
        }
        let with_event = || ways.iter().copied().filter(|way| !is_eventless(&way));
        let of_others: Vec<TransitionId> = with_event().filter(|way| self.handles_others(*way)).collect();
        for way in of_others {
            next.extend(self.take(way, state, owes));
        }
        if matches!(owes, Owes::Nothing | Owes::Running) {
            for way in self.enabled(with_event(), self.tick) {
                next.extend(self.take(way, state, Owes::Answer));
            }
        }
        if owes == Owes::Running && self.can_halt {
            let enabled = self.enabled(with_event(), self.halt);
            if enabled.is_empty() && chart.state(state).kind != StateKind::Final {
                self.deaf.insert(state);
            }
            for way in enabled {
                let after = self.take(way, state, Owes::Halted);
                self.halts.entry(way).or_default().extend(&after);
                next.extend(after);
            }
        }
        next
    }

    /// The transitions that an event of this class can take: up to the first that it takes in any case.
    fn enabled(&self, ways: impl Iterator<Item = TransitionId>, class: EventClass) -> Vec<TransitionId> {
        let mut enabled = Vec::new();
        for way in ways {
            let matches = |way| self.chart.transition(way).descriptors.iter().any(|one| one.matches.contains(class));
            if matches(way) {
                enabled.push(way);
                if is_certain(self.chart, way) {
                    break;
                }
            }
        }
        enabled
    }

    /// Whether a transition handles events that are no requests of the tree. Whatever handles any event does so only if
    /// the machine gets others: those that it sends itself, and answers of components.
    fn handles_others(&self, way: TransitionId) -> bool {
        let [tick, halt] = [request("tick"), request("halt")];
        self.chart.transition(way).descriptors.iter().any(|descriptor| {
            let text = &*descriptor.text;
            match text.strip_suffix(".*").or_else(|| text.strip_suffix('.')).unwrap_or(text) {
                "*" | CLIENT => self.gets_others,
                name => name != tick && name != halt,
            }
        })
    }

    fn take(&mut self, way: TransitionId, state: StateId, owes: Owes) -> BTreeSet<Moment> {
        let chart = self.chart;
        let transition: &Transition = chart.transition(way);
        self.way = Some(way);
        let mut owed = BTreeSet::from([owes]);
        let TransitionDomain::State(domain) = transition.domain else {
            owed = self.run(&transition.content, owed);
            return owed.into_iter().map(|owes| (state, owes)).collect();
        };
        for exited in std::iter::once(state).chain(chart.ancestors(state)).take_while(|exited| *exited != domain) {
            owed = self.run_all(&chart.state(exited).on_exit, owed);
        }
        owed = self.run(&transition.content, owed);
        match transition.targets.first() {
            Some(target) => self.enter(domain, *target, owed),
            None => owed.into_iter().map(|owes| (state, owes)).collect(),
        }
    }

    /// The moments after entering a state from one around it, or from itself, and what is below it by default.
    fn enter(&mut self, around: StateId, target: StateId, owed: BTreeSet<Owes>) -> BTreeSet<Moment> {
        let chart = self.chart;
        let (mut state, mut owed) = (target, self.descend(around, target, owed));
        while chart.state(state).kind == StateKind::Compound {
            let Some(initial) = chart.state(state).initial.as_ref() else { break };
            owed = self.run(&initial.content, owed);
            let Some(first) = initial.targets.first() else { break };
            owed = self.descend(state, *first, owed);
            state = *first;
        }
        owed.into_iter().map(|owes| (state, owes)).collect()
    }

    /// What the machine may owe after entering the states inside `around`, down to `target`.
    fn descend(&mut self, around: StateId, target: StateId, owed: BTreeSet<Owes>) -> BTreeSet<Owes> {
        let chart = self.chart;
        let way = std::iter::once(target).chain(chart.ancestors(target)).take_while(|state| *state != around);
        let way: Vec<StateId> = way.collect();
        way.iter().rev().fold(owed, |owed, entered| self.run_all(&chart.state(*entered).on_entry, owed))
    }

    fn run_all(&mut self, blocks: &'c [Block], owed: BTreeSet<Owes>) -> BTreeSet<Owes> {
        blocks.iter().fold(owed, |owed, block| self.run(block, owed))
    }

    /// What the machine may owe after these actions.
    fn run(&mut self, block: &'c [Action], mut owed: BTreeSet<Owes>) -> BTreeSet<Owes> {
        for action in block {
            owed = match &action.kind {
                ActionKind::Send(send) if to_tree(send) == Some(true) => self.answer(send, &owed),
                ActionKind::If(branches) => {
                    let mut after = BTreeSet::new();
                    for branch in branches {
                        after.extend(self.run(&branch.content, owed.clone()));
                    }
                    if branches.iter().all(|branch| branch.condition.is_some()) {
                        after.extend(&owed);
                    }
                    after
                }
                _ => owed,
            };
        }
        owed
    }

    fn answer(&mut self, send: &'c Send, owed: &BTreeSet<Owes>) -> BTreeSet<Owes> {
        let name = send.event.as_ref().and_then(|event| event.literal());
        let Some(answer) = name.and_then(|name| TreeAnswer::named(name)) else { return owed.clone() };
        let is_owed = owed.iter().any(|owes| answer.is_owed(*owes));
        let known = self.answers.entry((send.span.offset(), self.way)).or_insert((false, send));
        known.0 |= is_owed;
        // An answer that is not owed is dropped, and changes nothing.
        owed.iter().map(|owes| if answer.is_owed(*owes) { answer.after() } else { *owes }).collect()
    }

    fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        for state in &self.deaf {
            let state = self.chart.state(*state);
            let message = format!("the state `{}` has no transition for `{}`", state.id(), request("halt"));
            let problem = Problem::new(message).as_warning().at(state.span(), "the leaf can be running here");
            problems.push(problem.with_help(format!(
                "when the tree halts the leaf, it waits for `halted`: add a transition for `{}` that ends what the \
                 skill does and sends `halted` to {CLIENT}",
                request("halt")
            )));
        }
        for (way, after) in &self.halts {
            if !self.can_settle(after, Owes::Halted) {
                let problem = Problem::new("this halt is never confirmed").as_warning();
                let problem = problem.at(self.chart.transition(*way).span(), "nothing after it sends `halted`");
                problems.push(problem.with_help(format!(
                    "the tree waits for the answer: <send type=\"{CHANNEL_PROCESSOR}\" target=\"{CLIENT}\" \
                     event=\"halted\"/>"
                )));
            }
        }
        let not_owed = self.answers.values().filter(|(is_owed, _)| !is_owed).map(|(_, send)| *send);
        let not_owed: BTreeMap<usize, &Send> = not_owed.map(|send| (send.span.offset(), send)).collect();
        for send in not_owed.values() {
            let problem = Problem::new("the tree does not wait for this answer").as_warning();
            let problem = problem.at(send.span, "a request is answered already, or there is none");
            problems.push(problem.with_help(
                "each `BT.tick` is answered once, and each `BT.halt` by one `halted`; what is known later is kept until \
                 the next tick asks for it",
            ));
        }
        problems
    }

    /// Whether the machine can reach a moment in which it does not owe this.
    fn can_settle(&self, from: &BTreeSet<Moment>, owes: Owes) -> bool {
        let (mut open, mut seen): (Vec<Moment>, _) = (from.iter().copied().collect(), BTreeSet::new());
        while let Some(moment) = open.pop() {
            if moment.1 != owes {
                return true;
            }
            if seen.insert(moment) {
                open.extend(self.next.get(&moment).into_iter().flatten());
            }
        }
        false
    }
}

/// Whether a transition is taken whenever its event comes.
fn is_certain(chart: &Chart, way: TransitionId) -> bool {
    let transition = chart.transition(way);
    transition.chance.is_none() && constant(chart, transition) == Some(true)
}
