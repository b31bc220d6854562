//! The states in which a monitor may be if messages are missing from what it sees.

use std::collections::{HashSet, VecDeque};
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Verdict};

use super::ScopeMonitor;
use crate::engine::{Letter, Situation};
use crate::outcome::Outcome;
use crate::synthesis::{RunningMonitor, Synthesis};

/// So many states are kept, and at least so many steps of the run, to go back to where messages went missing.
const MOST_STATES: usize = 256;
const KEPT_STEPS: usize = 4096;

/// The states before every step with a number that this divides are kept, so as not to go back further.
const EVERY: usize = 64;

/// So many transitions of further states are worked out with each step, or later, but at most so many at once: a few
/// milliseconds.
const WORK: usize = 64;
const MOST_WORK: usize = 40_000;

/// The states in which a monitor may be if messages are missing: any number of messages, with any content, at any
/// moment of a gap.
///
/// That messages were missing is often known only when the next one arrives. So the recent part of the run is kept, and
/// judged again with its gaps. Without gaps, keeping it is all that this costs.
#[derive(Clone, Debug)]
pub struct PossibleStates {
    synthesis: Arc<Synthesis>,
    start: Option<u64>,
    steps: VecDeque<Step>,
    /// How many steps came before those.
    dropped: u64,
    /// The states before some of the steps, the first of those kept among them: all at once, or from the first gap on.
    marks: VecDeque<Mark>,
    /// Where messages may be missing before the next step, and before those after it.
    missing: Vec<ChannelId>,
    open: Vec<ChannelId>,
    /// The numbers of the steps whose messages may have been due earlier.
    late: VecDeque<u64>,
    now: Now,
    /// The step of the run at which every state had become violated.
    broken: Option<u64>,
    /// How many transitions may be worked out.
    left: usize,
}

/// What is possible after the last step.
#[derive(Clone, Debug)]
enum Now {
    /// The state of the monitor that has seen these events: there has been no gap.
    AsSeen,
    States(Vec<Candidate>),
    /// Too many to be worked out, for good.
    Unknown,
}

/// A state of the run: a tick, or a message on a channel that the formula mentions.
#[derive(Clone, Debug)]
struct Step {
    letter: Letter,
    channel: Option<ChannelId>,
    time: Duration,
    /// τ, counted from the first state.
    now: u64,
    /// Its number in the run.
    step: u64,
    /// The channels on which messages may be missing before it.
    missing: Vec<ChannelId>,
    /// The number of the first step before which its message may have been due, if it was late.
    due: Option<u64>,
}

/// The states before the step of this number, after what may be missing before it.
#[derive(Clone, Debug)]
struct Mark {
    number: u64,
    states: Vec<Candidate>,
}

/// A state of the machine. Two that continue alike are equal.
#[derive(Clone, Debug)]
struct Candidate {
    run: RunningMonitor,
    /// τ at the last step.
    now: u64,
    verdict: Verdict,
    /// How many of the next late messages it has read already.
    ahead: usize,
}

impl Candidate {
    fn situation(&self) -> (Verdict, usize, Option<Situation<'_>>) {
        (self.verdict, self.ahead, (self.verdict == Verdict::Inconclusive).then(|| self.run.situation()))
    }

    fn read(&mut self, letter: Letter, now: u64, synthesis: &Synthesis) {
        if self.verdict != Verdict::Inconclusive {
            return;
        }
        if now > self.now {
            self.now = now;
            if self.run.advance(now) {
                self.verdict = Verdict::False;
                return;
            }
        }
        self.verdict = self.run.read(letter, None, &synthesis.alphabet);
        self.run.forget();
    }

    fn outcome(&self) -> Outcome {
        match self.verdict {
            Verdict::False => Outcome::Violated,
            Verdict::Inconclusive if !self.run.holds() => Outcome::Inconclusive,
            Verdict::True | Verdict::Inconclusive => Outcome::Satisfied,
        }
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.situation() == other.situation()
    }
}

impl Eq for Candidate {}

impl Hash for Candidate {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.situation().hash(hasher);
    }
}

impl PossibleStates {
    /// Before a run. `None` if the formula measures time, compares values, or has too many conditions: what a message
    /// can do to the monitor is then not known.
    #[must_use]
    pub fn of(monitor: &ScopeMonitor) -> Option<Self> {
        let synthesis = &monitor.synthesis;
        if !monitor.has_letters() {
            return None;
        }
        let run = synthesis.start();
        Some(Self {
            synthesis: Arc::clone(synthesis),
            start: None,
            steps: VecDeque::new(),
            dropped: 0,
            marks: [Mark { number: 0, states: vec![Candidate { verdict: run.verdict(), run, now: 0, ahead: 0 }] }]
                .into(),
            missing: Vec::new(),
            open: Vec::new(),
            late: VecDeque::new(),
            now: Now::AsSeen,
            broken: None,
            left: MOST_WORK,
        })
    }

    /// Processes an event.
    pub fn observe(&mut self, event: &Event) {
        if self.are_unknown() {
            return;
        }
        let (letter, channel) = match &event.kind {
            EventKind::Tick => (Letter::TICK, None),
            EventKind::Received { channel, message } => match self.synthesis.alphabet.read(*channel, message) {
                Some(letter) => (letter, Some(*channel)),
                None => return,
            },
        };
        self.left = (self.left + WORK).min(MOST_WORK);
        let start = *self.start.get_or_insert(event.tick);
        let now = event.tick.saturating_sub(start);
        let missing = std::mem::replace(&mut self.missing, self.open.clone());
        self.steps.push_back(Step { letter, channel, time: event.time, now, step: event.step, missing, due: None });
        if let Now::States(states) = &mut self.now {
            let states = std::mem::take(states);
            self.judge(self.end() - 1, states);
        }
        if self.steps.len() == KEPT_STEPS + EVERY {
            self.drop_oldest();
        }
    }

    /// Messages on this channel may be missing from here on, or have been since its message at a time.
    pub fn miss(&mut self, channel: ChannelId, since: Option<Duration>) {
        let first = since.map_or(Some(self.end()), |since| self.number_after(channel, since));
        let known = (!self.are_unknown()).then_some(first).flatten();
        self.now = Now::Unknown;
        let Some(first) = known else { return };
        let kept = usize::try_from(first - self.dropped).unwrap_or(usize::MAX);
        let lists = self.steps.iter_mut().skip(kept).map(|step| &mut step.missing);
        for list in lists.chain([&mut self.missing, &mut self.open]).filter(|list| !list.contains(&channel)) {
            list.push(channel);
        }
        self.judge_again(first);
    }

    /// The last message on this channel may have been due at any time since then, after those before it on the channel.
    pub fn delay(&mut self, channel: ChannelId, since: Duration) {
        let is_known = !self.are_unknown();
        let place = self.steps.iter().rposition(|step| step.channel == Some(channel));
        // One that the formula does not distinguish changes nothing.
        let Some(place) = place.filter(|_| is_known) else { return };
        let before = self.steps.iter().take(place).rposition(|step| step.channel == Some(channel));
        let after = self.dropped + self.steps.partition_point(|step| step.time < since) as u64;
        let next = before.map(|before| self.steps[before].due.unwrap_or(self.dropped + before as u64 + 1));
        let (first, number) = (after.max(next.unwrap_or_default()), self.dropped + place as u64);
        if first >= number {
            return;
        }
        self.now = Now::Unknown;
        let is_kept = after > self.dropped || self.dropped == 0 || before.is_some();
        // Late messages are followed in the order in which they came, which is that of their channel.
        let mut others = self.late.iter().filter(|of| **of >= first);
        let is_alone = others.all(|of| self.steps[(of - self.dropped) as usize].channel == Some(channel));
        if is_kept && is_alone {
            self.steps[place].due = Some(first);
            self.late.push_back(number);
            self.judge_again(first);
        }
    }

    /// Judges the steps from that of this number on, before which other things may have happened than was known.
    fn judge_again(&mut self, first: u64) {
        while self.marks.len() > 1 && self.marks.back().is_some_and(|mark| mark.number >= first) {
            self.marks.pop_back();
        }
        let Some(Mark { number, states }) = self.marks.pop_back() else { return };
        if let Some(states) = self.closed(states, number) {
            if !is_broken(&states) {
                self.broken = None;
            }
            self.marks.push_back(Mark { number, states: states.clone() });
            self.judge(number, states);
        }
    }

    /// All gaps in the messages of this channel are over.
    pub fn resume(&mut self, channel: ChannelId) {
        self.open.retain(|open| *open != channel);
    }

    /// Whether a state may be possible besides that of the monitor that has seen these events, which is always among
    /// them.
    #[must_use]
    pub fn are_several(&self) -> bool {
        match &self.now {
            Now::AsSeen => false,
            Now::States(states) => states.len() > 1 || !self.missing.is_empty(),
            Now::Unknown => true,
        }
    }

    /// Whether the states are too many to be worked out.
    #[must_use]
    pub fn are_unknown(&self) -> bool {
        matches!(self.now, Now::Unknown)
    }

    /// The verdict in all of several states, and the outcome if the run ends now; `None` if they differ, or are too
    /// many.
    #[must_use]
    pub fn agreed(&self) -> Option<(Verdict, Outcome)> {
        let Now::States(states) = &self.now else { return None };
        let of = |state: &Candidate| (state.verdict, state.outcome());
        let first = of(states.first()?);
        states.iter().all(|state| of(state) == first).then_some(first)
    }

    /// The step of the run at which every state had become violated, if that was within what is kept.
    #[must_use]
    pub fn broken(&self) -> Option<u64> {
        self.broken
    }

    /// The number of the next step.
    fn end(&self) -> u64 {
        self.dropped + self.steps.len() as u64
    }

    /// The number of the step after a channel's message at this time; `None` if it is not kept any more.
    fn number_after(&self, channel: ChannelId, time: Duration) -> Option<u64> {
        let at = self.steps.partition_point(|step| step.time < time);
        let mut same = self.steps.iter().skip(at).take_while(|step| step.time == time);
        match same.position(|step| step.channel == Some(channel)) {
            Some(place) => Some(self.dropped + (at + place + 1) as u64),
            None => (at > 0 || self.dropped == 0).then_some(self.dropped + at as u64),
        }
    }

    /// Gives up the oldest steps.
    fn drop_oldest(&mut self) {
        if self.marks.len() == 1 {
            // There has been no gap, so there is one state.
            let oldest = self.steps.iter().take(EVERY);
            for state in self.marks.iter_mut().flat_map(|mark| &mut mark.states) {
                oldest.clone().for_each(|step| state.read(step.letter, step.now, &self.synthesis));
            }
            self.marks.iter_mut().for_each(|mark| mark.number += EVERY as u64);
        } else {
            self.marks.pop_front();
        }
        self.steps.drain(..EVERY);
        self.dropped += EVERY as u64;
        self.late.retain(|number| *number >= self.dropped);
    }

    /// Judges the steps from that of this number on, and notes the states before some of them.
    fn judge(&mut self, from: u64, mut states: Vec<Candidate>) {
        self.now = Now::Unknown;
        for number in from..self.end() {
            let Some(after) = self.after(states, number) else { return };
            states = after;
            if (number + 1).is_multiple_of(EVERY as u64) {
                self.marks.push_back(Mark { number: number + 1, states: states.clone() });
            }
        }
        self.now = Now::States(states);
    }

    /// The states after the step of this number, and after what may be missing between it and the next; `None` if they
    /// are too many.
    fn after(&mut self, mut states: Vec<Candidate>, number: u64) -> Option<Vec<Candidate>> {
        self.left = self.left.checked_sub(states.len().saturating_sub(1))?;
        let step = &self.steps[usize::try_from(number - self.dropped).ok()?];
        for state in &mut states {
            if step.due.is_some() && state.ahead > 0 {
                state.ahead -= 1;
            } else {
                state.read(step.letter, step.now, &self.synthesis);
            }
        }
        let step = step.step;
        if states.len() > 1 {
            states = HashSet::<Candidate>::from_iter(states).into_iter().collect();
        }
        let states = self.closed(states, number + 1)?;
        if self.broken.is_none() && is_broken(&states) {
            self.broken = Some(step);
        }
        Some(states)
    }

    /// With the states after messages that may be missing before the step of this number.
    fn closed(&mut self, mut states: Vec<Candidate>, number: u64) -> Option<Vec<Candidate>> {
        let kept = usize::try_from(number - self.dropped).ok()?;
        let missing = self.steps.get(kept).map_or(&self.missing, |step| &step.missing);
        let of_late = |of: &u64| self.steps.get(usize::try_from(of - self.dropped).ok()?);
        let late = self.late.iter().filter(|of| **of >= number).filter_map(of_late);
        let late: Vec<Letter> =
            late.take_while(|step| step.due.is_some_and(|due| due <= number)).map(|step| step.letter).collect();
        if missing.is_empty() && late.is_empty() {
            return Some(states);
        }
        let letters = self.synthesis.alphabet.letters().filter(|(_, of, _)| missing.contains(of));
        let letters: Vec<Letter> = letters.map(|(letter, ..)| letter).collect();
        let mut known: HashSet<Candidate> = states.iter().cloned().collect();
        let mut at = 0;
        while at < states.len() {
            // Whatever comes, a final state remains.
            let is_final = states[at].verdict != Verdict::Inconclusive;
            let due = late.get(states[at].ahead).map(|letter| (letter, 1));
            let lost = letters.iter().filter(|_| !is_final).map(|letter| (letter, 0));
            for (letter, ahead) in due.into_iter().chain(lost) {
                self.left = self.left.checked_sub(1)?;
                let mut state = states[at].clone();
                state.read(*letter, state.now, &self.synthesis);
                state.ahead += ahead;
                if known.insert(state.clone()) {
                    states.push(state);
                }
            }
            at += 1;
        }
        (states.len() <= MOST_STATES).then_some(states)
    }
}

fn is_broken(states: &[Candidate]) -> bool {
    states.iter().all(|state| state.verdict == Verdict::False)
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, Message, Monitor as _, Topology, Value};

    use super::*;

    /// A monitor over the channels `a` and `b`, and what it may have come to.
    struct Watched {
        channels: [ChannelId; 2],
        monitor: ScopeMonitor,
        possible: PossibleStates,
        ticks: u64,
    }

    impl Watched {
        fn new(formula: &str) -> Self {
            let mut topology = Topology::default();
            let [a, b, monitor] = ["a", "b", "monitor"].map(|name| topology.process(name).expect("a new name"));
            let channels = [a, b]
                .map(|from| topology.channel(from, monitor, Capacity::One, Domain::new([])).expect("a new channel"));
            let text = format!("property p := {formula}");
            let file = crate::load("p.scope", &text, &Arc::new(topology), Duration::from_secs(1)).expect("correct");
            let monitor = file.properties[0].scope_monitor().expect("a formula").clone();
            let possible = PossibleStates::of(&monitor).expect("it has letters");
            Self { channels, monitor, possible, ticks: 0 }
        }

        fn tick(&mut self) {
            self.see(EventKind::Tick);
            self.ticks += 1;
        }

        fn hear(&mut self, channel: usize, x: i64) {
            let message = Message::new([Value::Int(x)]);
            self.see(EventKind::Received { channel: self.channels[channel], message });
        }

        fn see(&mut self, kind: EventKind) {
            let time = Duration::from_secs(self.ticks);
            let event = Event { step: 0, tick: self.ticks, time, kind };
            self.monitor.observe(&event);
            self.possible.observe(&event);
        }

        fn lose(&mut self, channel: usize, since_s: u64) {
            self.possible.miss(self.channels[channel], Some(Duration::from_secs(since_s)));
            self.possible.resume(self.channels[channel]);
        }

        /// The outcome in all states that are possible.
        fn outcome(&self) -> Option<Outcome> {
            if self.possible.are_several() {
                self.possible.agreed().map(|(_, outcome)| outcome)
            } else {
                Some(self.monitor.outcome())
            }
        }
    }

    const ANSWERED: &str = "always ((a, monitor, m[1] > 0) implies time_until (b, monitor, true) < 3 s)";

    #[test]
    fn what_a_missing_message_asked_for_is_open_until_it_is_answered() {
        let mut watched = Watched::new(ANSWERED);
        watched.hear(0, 0);
        watched.tick();
        watched.lose(0, 0);
        assert_eq!(watched.outcome(), None);
        watched.hear(1, 0);
        assert_eq!((watched.possible.are_several(), watched.outcome()), (false, Some(Outcome::Satisfied)));
        // Nothing came in between: it may have been violated, or not.
        watched.hear(0, 0);
        (0..5).for_each(|_| watched.tick());
        watched.lose(0, 1);
        watched.hear(1, 0);
        assert_eq!((watched.monitor.outcome(), watched.outcome()), (Outcome::Satisfied, None));
    }

    #[test]
    fn a_late_message_may_have_been_due_before_others() {
        let delayed = |formula: &str, since_s: u64| {
            let mut watched = Watched::new(formula);
            watched.tick();
            watched.hear(1, 0);
            watched.tick();
            // Both come late, in this order.
            for x in [1, 2] {
                watched.hear(0, x);
                watched.possible.delay(watched.channels[0], Duration::from_secs(since_s));
            }
            (0..5).for_each(|_| watched.tick());
            (watched.monitor.outcome(), watched.outcome())
        };
        assert_eq!(delayed(ANSWERED, 0), (Outcome::Violated, None));
        // It was due after the answer, and it was there.
        assert_eq!(delayed(ANSWERED, 2), (Outcome::Violated, Some(Outcome::Violated)));
        let came = "eventually (a, monitor, m[1] = 2)";
        assert_eq!(delayed(came, 0), (Outcome::Satisfied, Some(Outcome::Satisfied)));
        let in_order = "always ((a, monitor, m[1] = 2) implies previous once (a, monitor, m[1] = 1))";
        assert_eq!(delayed(in_order, 0), (Outcome::Satisfied, Some(Outcome::Satisfied)));
    }

    #[test]
    fn a_violation_that_no_missing_message_prevents_is_one() {
        let mut watched = Watched::new(ANSWERED);
        watched.hear(0, 1);
        (0..2).for_each(|_| watched.tick());
        watched.lose(0, 0);
        (0..2).for_each(|_| watched.tick());
        assert_eq!(watched.outcome(), Some(Outcome::Violated));
        // Of answers, one may be missing.
        let mut watched = Watched::new(ANSWERED);
        watched.hear(0, 1);
        (0..4).for_each(|_| watched.tick());
        watched.lose(1, 0);
        assert_eq!((watched.monitor.outcome(), watched.outcome()), (Outcome::Violated, None));
    }

    #[test]
    fn a_gap_that_began_before_what_is_kept_leaves_everything_open() {
        for (ticks, is_known) in [(KEPT_STEPS - 1, true), (KEPT_STEPS + 2 * EVERY, false)] {
            let mut watched = Watched::new("always ((a, monitor, m[1] > 0) implies not (b, monitor, m[1] > 0))");
            watched.hear(1, 0);
            (0..ticks).for_each(|_| watched.tick());
            watched.lose(0, 0);
            // Whatever is missing, there was no request with an answer above zero.
            assert_eq!(watched.outcome().is_some(), is_known, "{ticks}");
        }
    }

    #[test]
    fn time_and_values_have_no_letters() {
        let mut topology = Topology::default();
        let [a, monitor] = ["a", "monitor"].map(|name| topology.process(name).expect("a new name"));
        topology.channel(a, monitor, Capacity::One, Domain::new([])).expect("a new channel");
        let text = "timed property soon := always ((a, monitor, m[1] > 0) implies time_until (a, monitor, true) < 1 s)
            property same := always ((a, monitor, m[1] as x) implies next (a, monitor, m[1] = x))";
        let file = crate::load("p.scope", text, &Arc::new(topology), Duration::from_secs(1)).expect("correct");
        let mut monitors = file.properties.iter().filter_map(|property| property.scope_monitor());
        assert!(monitors.all(|monitor| PossibleStates::of(monitor).is_none()));
    }

    /// All orders in which messages may have been due: each late one at its place, or at an earlier one that is
    /// allowed, after those before it on its channel.
    fn orders(arrived: &[(usize, i64, usize)]) -> Vec<Vec<(usize, usize)>> {
        let mut orders: Vec<Vec<(usize, usize)>> = vec![Vec::new()];
        for (index, (channel, _, early)) in arrived.iter().enumerate() {
            let mut longer: Vec<Vec<(usize, usize)>> = Vec::new();
            for order in &orders {
                // At the earliest after the last one on its channel, wherever that was.
                let last = order.iter().rev().find(|(_, of)| arrived[*of].0 == *channel);
                let before = last.map_or(0, |(due, of)| if due < of { *due } else { of + 1 });
                for due in before.max(index - early)..=index {
                    let mut order = order.clone();
                    order.push((due, index));
                    longer.push(order);
                }
            }
            orders = longer;
        }
        orders
    }

    #[test]
    fn late_messages_lead_to_what_they_would_have_led_to_whenever_they_were_due() {
        let formulas = [
            ANSWERED,
            "always ((a, monitor, m[1] = 1) implies next (b, monitor, m[1] = 1))",
            "always ((b, monitor, true) implies once (a, monitor, m[1] = 2))",
            "eventually ((a, monitor, m[1] = 2) and previous (b, monitor, true))",
            "(not (b, monitor, m[1] = 2)) until (a, monitor, m[1] = 1)",
        ];
        let (mut seed, mut several) = (1_u64, 0);
        let mut draw = |below: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        };
        for round in 0..400 {
            // Each message: its channel, what it says, and before how many of the last messages it may have been due.
            let mut arrived: Vec<(usize, i64, usize)> = Vec::new();
            for index in 0..6 {
                let early = if draw(3) == 0 { draw(4).min(index) } else { 0 };
                arrived.push((draw(2) as usize, draw(3) as i64, early as usize));
            }
            let formula = formulas[round % formulas.len()];
            let mut watched = Watched::new(formula);
            // A tick comes after each message, so that the places are told apart by their times.
            for (index, (channel, x, early)) in arrived.iter().enumerate() {
                watched.hear(*channel, *x);
                if *early > 0 {
                    watched.possible.delay(watched.channels[*channel], Duration::from_secs((index - early) as u64));
                }
                watched.tick();
            }
            let outcomes: HashSet<Outcome> = orders(&arrived)
                .into_iter()
                .map(|order| {
                    let mut watched = Watched::new(formula);
                    for place in 0..arrived.len() {
                        // Those that are due before a message are there before it.
                        let mut due: Vec<usize> =
                            order.iter().filter(|(due, of)| *due == place && *of != place).map(|(_, of)| *of).collect();
                        due.extend(order.iter().filter(|(due, of)| *due == place && *of == place).map(|(_, of)| *of));
                        due.into_iter().for_each(|of| watched.hear(arrived[of].0, arrived[of].1));
                        watched.tick();
                    }
                    watched.monitor.outcome()
                })
                .collect();
            several += usize::from(outcomes.len() > 1);
            if let Some(sure) = watched.outcome() {
                assert_eq!(outcomes, [sure].into(), "{formula}: {arrived:?}");
            }
        }
        assert!(several > 20, "{several}");
    }
}
