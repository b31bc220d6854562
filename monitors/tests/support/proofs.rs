//! Proofs about random small systems, compared with an enumeration of their runs.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{
    ChannelId, ChannelSystem, Disturbance, Effect, Enabled, EnabledKind, Event, EventKind, GraphProcess, Label,
    Monitor, Process, ProcessId, ProgramGraph, Slot, TickGenerator, Verdict,
};
use explorer::{Closed, Environment, Limits, MessageFaults, Model, Order, Outcome, Reduction, Ticks, explore};
use monitors::{Choice, Formula, ScopeMonitor};

use super::classes::{Class, Topologies};
use super::definition::Definition;
use super::tally::{Why, why};
use super::{Dice, continued, next_states, numbers, random_continuation};

/// Nothing follows a run of this many steps.
const LONGEST: u64 = 24;
const PERIOD: Duration = Duration::from_secs(1);

/// The results of many proofs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Proofs {
    pub(crate) proved: u64,
    pub(crate) violated: u64,
    /// Formulas that no search can decide, or that would have to remember too much.
    pub(crate) refused: u64,
    /// Systems with too many states.
    pub(crate) undecided: u64,
    /// Searches that are not decided because there is less memory.
    pub(crate) cut_off: u64,
    /// Properties that were read from text.
    pub(crate) read: u64,
    /// Different beginnings of runs, each judged with a property.
    pub(crate) pairs: u64,
    /// Systems of which all runs were enumerated.
    pub(crate) complete: u64,
    /// Beginnings of runs that no continuation that was tried satisfies, although the proof goes on.
    pub(crate) late: BTreeMap<Why, u64>,
}

impl fmt::Display for Proofs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { proved, violated, refused, undecided, cut_off, read, pairs, complete, late } = self;
        write!(
            f,
            "{proved} properties proved, {violated} violated, {read} of them read from text, {refused} refused, {undecided} undecided, {cut_off} with less memory; "
        )?;
        write!(f, "{pairs} pairs of a property and a run, all runs of {complete} systems; ")?;
        write!(f, "{} verdicts late", late.values().sum::<u64>())?;
        for (why, count) in late {
            write!(f, ", because {why}: {:.3} %", 100.0 * *count as f64 / *pairs as f64)?;
        }
        Ok(())
    }
}

/// A system, what may happen to it, and a property.
struct Case {
    system: ChannelSystem,
    ticks: Option<Ticks>,
    faults: MessageFaults,
    formula: Formula,
    /// Messages for continuations.
    messages: Vec<EventKind>,
}

/// A beginning of a run.
struct Run {
    system: ChannelSystem,
    events: Vec<Event>,
    losses: u8,
    steps: u64,
}

/// Compares the proof of one property about one system with an enumeration of up to `most` beginnings of its runs.
///
/// # Errors
/// What is wrong.
pub(crate) fn check_proof(topologies: &Topologies, seed: u64, most: usize, proofs: &mut Proofs) -> Result<(), String> {
    let case = Case::new(topologies, seed);
    let Some(monitor) = case.monitor(seed.is_multiple_of(2), proofs) else {
        proofs.refused += 1;
        return Ok(());
    };
    let model = || {
        let model = Model::new(&case.system, case.ticks, Closed.erased());
        model.with_message_faults(case.faults.clone())
    };
    let judge = Judge::new(&case, &monitor);
    let wrong = |what: String| Err(format!("seed {seed}: {what}\n{}", case.formula.text(monitor.topology())));
    let mut found = None;
    const MEMORY: usize = 1 << 22;
    // The last one runs out of memory now and then.
    for (reduction, order, memory) in [
        (Reduction::Off, Order::Breadth, MEMORY),
        (Reduction::On, Order::Breadth, MEMORY),
        (Reduction::Off, Order::Depth, MEMORY),
        (Reduction::WhenNeeded, Order::Breadth, 1 << (14 + seed % 4)),
    ] {
        let limits = Limits { reduction, order, memory, ..Limits::default() };
        let result = explore(&model(), Some(&monitor), &limits, &mut |_| ());
        let Ok(result) = result else {
            proofs.refused += 1;
            return Ok(());
        };
        let path = match result.outcome {
            Outcome::Proved => None,
            Outcome::Violated(path) => Some(path),
            Outcome::Undecided(_) if memory < MEMORY => {
                proofs.cut_off += 1;
                continue;
            }
            // The property makes too many states.
            Outcome::Undecided(_) => {
                proofs.undecided += 1;
                return Ok(());
            }
            outcome => return wrong(format!("{outcome:?}")),
        };
        if let Some(path) = &path {
            let replay = path.replay(&model(), Some(&monitor)).map_err(|error| format!("seed {seed}: {error}"))?;
            let events: Vec<Event> = replay.events.into_iter().map(|(_, event)| event).collect();
            if judge.can_be_satisfied(&events, 100) {
                return wrong(format!("this run does not violate the property: {events:#?}"));
            }
        }
        // Some properties are violated before the first step.
        let steps = path.map(|path| if path.steps().is_empty() { 0 } else { result.progress.depth + 1 });
        if (reduction, order) == (Reduction::Off, Order::Breadth) {
            found = steps;
        } else if steps.is_some() != found.is_some() {
            return wrong("the searches do not agree".to_owned());
        }
    }
    *if found.is_some() { &mut proofs.violated } else { &mut proofs.proved } += 1;
    case.enumerate(most, found, &judge, proofs).or_else(wrong)
}

impl Case {
    fn new(topologies: &Topologies, seed: u64) -> Self {
        let mut dice = Dice(seed.wrapping_mul(0x1000_0001));
        let dice = &mut dice;
        let class = if dice.roll(5) == 0 { Class::Sums } else { Class::Numbers };
        let topology = topologies.of(class);
        let formulas = std::iter::repeat_with(|| topologies.formula(class, dice, 1 + (seed % 3) as u32));
        let formula = formulas.take(50).find(|formula| formula.is_safety() && *formula != Formula::True);
        let formula = formula.unwrap_or(Formula::True);
        // In a file, every event is inside a temporal operator.
        let formula = if seed.is_multiple_of(2) { formula.always() } else { formula };
        let [a, b, c, d, generator] =
            ["A", "B", "C", "D", "Ticks"].map(|name| topology.find_process(name).expect("a process"));
        let channels: Vec<ChannelId> = topology.channels().collect();
        let mut messages = Vec::new();
        let mut processes: Vec<(ProcessId, Box<dyn Process>)> =
            vec![(generator, Box::new(TickGenerator::new(channels[4])))];
        for (process, sends, receives) in [(a, 0, [3, 4].as_slice()), (b, 1, &[0]), (c, 2, &[1]), (d, 3, &[2])] {
            let graph = graph(dice, (sends, receives), &channels, &mut messages);
            processes.push((process, Box::new(GraphProcess::new(graph))));
        }
        messages.extend((0..3).map(|_| numbers::received(dice, topology)));
        let system = ChannelSystem::new(Arc::clone(topology), processes).expect("a sound system");
        let ticks = Ticks { generator, period: PERIOD, first: Duration::ZERO, step: Duration::ZERO };
        let lost = u8::from(dice.roll(4) == 0);
        Self {
            system,
            ticks: (dice.roll(4) > 0).then_some(ticks),
            faults: MessageFaults { lost, channels: channels[..4].to_vec(), ..MessageFaults::default() },
            formula,
            messages,
        }
    }

    /// The monitor of the property: read from text, if it can be written down.
    fn monitor(&self, from_text: bool, proofs: &mut Proofs) -> Option<ScopeMonitor> {
        let topology = self.system.topology();
        if !self.formula.is_safety() {
            return None;
        }
        if from_text {
            let text = format!("property p := {}", self.formula.text(topology));
            // What is never true, or has no order, is refused in a file.
            if let Ok(file) = monitors::load("p.scope", &text, topology, PERIOD) {
                proofs.read += 1;
                return file.properties[0].scope_monitor().cloned();
            }
        }
        ScopeMonitor::new("p", self.formula.clone(), topology).ok()
    }

    /// Enumerates beginnings of runs, the shortest first, and compares each with what the search has found: the number
    /// of steps after which a run violates the property first.
    fn enumerate(&self, most: usize, found: Option<u64>, judge: &Judge, proofs: &mut Proofs) -> Result<(), String> {
        let first = Run { system: self.system.fork(), events: Vec::new(), losses: self.faults.lost, steps: 0 };
        let mut runs = VecDeque::from([first]);
        let (mut known, mut seen, mut enumerated) = (BTreeSet::new(), BTreeSet::new(), 0);
        let (mut is_violated, mut is_cut) = (false, false);
        while let Some(mut run) = runs.pop_front() {
            if enumerated == most || found.is_some_and(|found| run.steps > found) {
                break;
            }
            let recorded: Vec<_> = run.events.iter().map(|event| (&event.kind, event.tick)).collect();
            let recorded = format!("{recorded:?}");
            let mut hasher = DefaultHasher::new();
            run.system.hash_state(&mut hasher);
            if !known.insert((recorded.clone(), run.losses, hasher.finish())) {
                continue;
            }
            enumerated += 1;
            if seen.insert(recorded) {
                proofs.pairs += 1;
                let is_first = found == Some(run.steps);
                match judge.verdict(&run.events)? {
                    Judged::Open => {}
                    Judged::Violated if is_first => is_violated = true,
                    Judged::Violated => {
                        return Err(format!("the search finds {found:?}, but this is violated: {:#?}", run.events));
                    }
                    Judged::Late if found.is_none_or(|found| run.steps < found) => {
                        *proofs.late.entry(judge.why).or_default() += 1;
                    }
                    Judged::Late => is_violated |= is_first,
                }
            }
            if run.steps == LONGEST {
                is_cut = true;
            } else {
                self.successors(&mut run, &mut runs)?;
            }
        }
        let is_complete = runs.is_empty() && !is_cut;
        proofs.complete += u64::from(is_complete);
        let reached = is_complete || runs.front().is_some_and(|run| found.is_some_and(|found| run.steps > found));
        if found.is_some() && reached && !is_violated {
            return Err(format!("no run of {found:?} steps violates the property"));
        }
        Ok(())
    }

    fn successors(&self, run: &mut Run, runs: &mut VecDeque<Run>) -> Result<(), String> {
        let enabled = run.system.enabled();
        for transition in &enabled {
            let mut system = run.system.fork();
            system.enabled();
            let event = system.take(transition).map_err(|error| error.to_string())?;
            let events = run.events.iter().cloned().chain(event).collect();
            runs.push_back(Run { system, events, steps: run.steps + 1, ..*run });
            let EnabledKind::Send(channel) = transition.kind else { continue };
            if run.losses > 0 && self.faults.channels.contains(&channel) {
                let system = lost(&run.system, transition, channel).map_err(|error| error.to_string())?;
                runs.push_back(Run {
                    system,
                    events: run.events.clone(),
                    losses: run.losses - 1,
                    steps: run.steps + 1,
                });
            }
        }
        if let (Some(ticks), true) = (self.ticks, enabled.is_empty()) {
            let mut system = run.system.fork();
            let (event, _) = system.generate_tick(ticks.generator);
            let events = run.events.iter().cloned().chain([event]).collect();
            runs.push_back(Run { system, events, steps: run.steps + 1, ..*run });
        }
        Ok(())
    }
}

/// The system after a message is sent and lost.
fn lost(system: &ChannelSystem, send: &Enabled, channel: ChannelId) -> Result<ChannelSystem, channels::RunError> {
    let mut system = system.fork();
    system.enabled();
    let disturbance = system.disturb(Disturbance::all(channel, Effect::Lose));
    system.take(send)?;
    let acts = system.enabled().into_iter().find(|enabled| enabled.kind == EnabledKind::Disturb(channel));
    system.take(&acts.expect("the message is hit"))?;
    system.calm(disturbance);
    Ok(system)
}

/// A few locations and transitions. The last message is kept, and one from C to D may be passed on.
fn graph(
    dice: &mut Dice,
    (sends, receives): (usize, &[usize]),
    channels: &[ChannelId],
    messages: &mut Vec<EventKind>,
) -> Arc<ProgramGraph> {
    let mut graph = ProgramGraph::builder("graph");
    let locations: Vec<_> = (0..2 + dice.roll(2)).map(|index| graph.location(&format!("l{index}"))).collect();
    let last = graph.variable("last");
    for number in 0..3 + dice.roll(3) {
        // It can begin with two of them.
        let from = if number < 2 { locations[0] } else { *dice.pick(&locations) };
        let to = *dice.pick(&locations);
        // Each graph sends something, and receives something.
        if number == 0 || number > 1 && dice.roll(2) == 0 {
            let message = numbers::message(dice, sends);
            messages.push(EventKind::Received { channel: channels[sends], message: message.clone() });
            graph.transition(from, Label::Send(channels[sends], Slot::Given(message)), to);
        } else {
            let on = channels[*dice.pick(receives)];
            let passed_on = sends == 3 && dice.roll(2) == 0;
            let middle = if passed_on { graph.location("passes on") } else { to };
            graph.transition(from, Label::Receive(on, Slot::Variable(last)), middle);
            if passed_on {
                graph.transition(middle, Label::Send(channels[sends], Slot::Variable(last)), to);
            }
        }
    }
    Arc::new(graph.initial(locations[0]).build().expect("a sound graph"))
}

/// Judges beginnings of runs by the definition.
struct Judge {
    definition: Definition,
    /// An automaton, if there is one.
    automaton: ScopeMonitor,
    alphabet: Vec<EventKind>,
    why: Why,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Judged {
    /// Some continuation satisfies the property.
    Open,
    /// None does.
    Violated,
    /// None that was tried does, and no automaton knows that none can.
    Late,
}

impl Judge {
    fn new(case: &Case, monitor: &ScopeMonitor) -> Self {
        let topology = case.system.topology();
        let automaton = ScopeMonitor::with("p", case.formula.clone(), topology, Choice::Automaton);
        let automaton = automaton.expect("it is not refused");
        let alphabet = monitor.samples().chain(case.messages.iter().cloned()).chain([EventKind::Tick]).collect();
        Self { definition: Definition::new(&case.formula, topology), automaton, alphabet, why: why(&case.formula) }
    }

    fn verdict(&self, events: &[Event]) -> Result<Judged, String> {
        if self.definition.holds(events) || self.can_be_satisfied(events, 20) {
            return Ok(Judged::Open);
        }
        let mut automaton = self.automaton.clone();
        events.iter().for_each(|event| automaton.observe(event));
        if automaton.verdict() == Verdict::False {
            return Ok(Judged::Violated);
        }
        let Some(word) = automaton.continuation(true) else {
            return if automaton.method().anticipates() { Ok(Judged::Violated) } else { Ok(Judged::Late) };
        };
        // The automaton's continuation is only a proposal: the definition judges it.
        if self.definition.holds_endlessly(&continued(events, &word.stem), &word.cycle) {
            Ok(Judged::Open)
        } else {
            Err(format!("{word:?} does not satisfy the property after {events:#?}"))
        }
    }

    /// Whether one of this many continuations satisfies the property.
    fn can_be_satisfied(&self, events: &[Event], words: u64) -> bool {
        let mut dice = Dice(events.len() as u64);
        let mut continuations = (0..words).map(|_| random_continuation(&mut dice, events, &self.alphabet));
        self.definition.holds(events)
            || next_states(events, &self.alphabet)
                .into_iter()
                .any(|next| self.definition.holds(&continued(events, &[next])))
            || continuations.any(|word| self.definition.holds_endlessly(&continued(events, &word.stem), &word.cycle))
    }
}
