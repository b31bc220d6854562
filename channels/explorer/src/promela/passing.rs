//! What happens when no transition is enabled: the environment moves, and time passes until the next timer or tick.

use std::collections::{BTreeMap, BTreeSet};

use channels::Verdict;

use super::step::GuardedStep;
use super::{ENVIRONMENT, FOREVER, MONITOR, Writer, any, choice, either, mapping, option, or_skip};
use crate::environment::Instant;
use crate::local::{Local, Step, UNKNOWN};
use crate::tables::{ENDLESS, Moved};

/// The values of the variable `next`, which determines the next step. It is `NOTHING` in every stored state.
const INSTANTS: &str = "#define NOTHING 0\n#define TIMER 1\n#define TICK 2\n#define VIOLATION 3";

impl Writer<'_> {
    /// The variables of time.
    pub(super) fn clocks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.tables().ticks.is_some() {
            let first = self.time(self.tables().clocks.get(0).until_tick);
            lines.push(format!("int until_tick = {first};\nbit has_ticked = 0;"));
        }
        if self.has_time() || self.drives_when_quiet() {
            lines.push(format!("int span = 0;\nbyte next = 0;\n{INSTANTS}"));
        }
        if self.drives_when_quiet() {
            let variables = self.variables_of_moves();
            let copies = variables.iter().map(|variable| format!("hidden int was_{variable};"));
            lines.extend(copies);
            let save: Vec<String> = variables.iter().map(|variable| format!("was_{variable} = {variable}")).collect();
            let undo: Vec<String> = variables.iter().map(|variable| format!("{variable} = was_{variable}")).collect();
            lines.push(format!("#define SAVE {}\n#define UNDO {}", save.join("; "), undo.join("; ")));
        }
        lines
    }

    fn has_time(&self) -> bool {
        let mut locals = self.tables().locals.iter().flat_map(|locals| locals.iter());
        self.tables().ticks.is_some()
            || self.tables().transits.get(0).delays > 0
            || locals.any(|local| local.timer.is_some())
    }

    fn drives_when_quiet(&self) -> bool {
        !self.semantics.anywhere && !self.tables().driven.is_empty()
    }

    /// The option that is taken when no transition is enabled.
    pub(super) fn quiet(&mut self, steps: &[GuardedStep]) -> Vec<String> {
        if !self.has_time() && !self.drives_when_quiet() {
            return Vec::new();
        }
        let is_quiet = match self.semantics.anywhere {
            true => format!("!({})", either(steps.iter().map(|step| format!("({})", step.guard)).collect())),
            false => "else".to_owned(),
        };
        let mut lines = vec![format!("  :: atomic {{ {is_quiet} ->"), "  d_step {".to_owned()];
        lines.extend(self.next_instant().into_iter().map(|line| format!("    {line};")));
        lines.push("  };\n  if".to_owned());
        lines.extend(self.waits());
        if self.drives_when_quiet() {
            lines.extend(self.drives(steps));
        }
        lines.push("  :: else -> next = NOTHING\n  fi;\n  d_step {\n    if\n    :: next != NOTHING ->".to_owned());
        lines.extend(self.time_passes().into_iter().map(|line| format!("      {line};")));
        lines.push("    :: else\n    fi;\n    span = 0; next = NOTHING\n  } }".to_owned());
        lines
    }

    /// Computes the time until the next instant, and whether that is a timer or a tick.
    fn next_instant(&self) -> Vec<String> {
        let mut lines = vec![match self.tables().ticks {
            Some(_) => "span = until_tick; next = TICK".to_owned(),
            None => format!("span = {FOREVER}; next = NOTHING"),
        }];
        for process in self.semantics.populated() {
            let mut timers: BTreeMap<u128, Vec<u32>> = BTreeMap::new();
            for (state, local) in (0..).zip(self.tables().locals[process].iter()) {
                if let Some(timer) = local.timer {
                    timers.entry(self.time(timer)).or_default().push(state);
                }
            }
            // A process in one state has one timer, so no two options of this `if` are enabled at once.
            let is_set = |(timer, states)| {
                let here = any(&self.process(process), states);
                format!(":: {here} && {timer} < span -> span = {timer}; next = TIMER")
            };
            lines.extend(choice(&timers.into_iter().map(is_set).collect::<Vec<_>>()));
        }
        for channel in (0..self.tables().links.len()).filter(|channel| self.may_hold(*channel)) {
            let held = self.held(channel);
            lines.push(format!("if :: {held} >= 0 && {held} < span -> span = {held}; next = TIMER :: else fi"));
        }
        let decided = [(Verdict::False, "VIOLATION"), (Verdict::True, "NOTHING")];
        let decided = decided.map(|(verdict, next)| {
            let before = self.ticked(|_, after| self.tables().monitors.get(after).verdict == verdict);
            before.map(|(before, _)| format!(":: next == TICK && {before} -> next = {next}")).collect::<Vec<_>>()
        });
        lines.extend(choice(&decided.concat()));
        lines
    }

    /// The effect of a tick on the monitor: its state before, as a condition, and its state afterwards.
    fn ticked(&self, which: impl Fn(u32, u32) -> bool) -> impl Iterator<Item = (String, u32)> {
        let monitors = self.semantics.has_monitor.then(|| (0..).zip(self.tables().monitors.iter()));
        let both = monitors.into_iter().flatten().flat_map(|(before, watching)| {
            [0, 1].map(|has_ticked: usize| (before, has_ticked, watching.ticked[has_ticked]))
        });
        let known = both.filter(move |(before, _, after)| *after != UNKNOWN && which(*before, *after));
        known.map(|(before, has_ticked, after)| (format!("{MONITOR} == {before} && has_ticked == {has_ticked}"), after))
    }

    /// The moves of the environment before the next instant.
    fn waits(&mut self) -> Vec<String> {
        let semantics = self.semantics;
        let mut lines = Vec::new();
        let mut before_tick = Vec::new();
        for (instant, name) in [(Instant::Between, "TIMER"), (Instant::Tick, "TICK")] {
            for (key, moves) in semantics.tables.sorted_moves(instant) {
                let here = self.driven_in(key);
                for (moved, words) in moves.iter().zip(semantics.tables.words(key, instant)) {
                    let body = self.moved(key[0], *moved);
                    lines.push(option(&format!("next == {name} && {here}"), &body, &words));
                }
                if instant == Instant::Tick && !moves.is_empty() {
                    before_tick.push(format!("({here})"));
                }
            }
        }
        if self.ticked(|_, after| semantics.tables.monitors.get(after).verdict == Verdict::False).next().is_some() {
            let guard = format!("next == VIOLATION && {}", either(before_tick));
            lines.push(option(&guard, "assert(false); next = NOTHING", "the tick violates the property"));
        }
        lines
    }

    /// The moves of the environment while time stands still. In a quiet system, only those count after which a process
    /// can move.
    pub(super) fn drives(&mut self, steps: &[GuardedStep]) -> Vec<String> {
        let semantics = self.semantics;
        let mut steps_of = StepsOf::new();
        for step in steps {
            step.of.iter().for_each(|of| steps_of.entry(*of).or_default().push(&step.guard));
        }
        let mut lines = Vec::new();
        for (key, moves) in semantics.tables.sorted_moves(Instant::Between) {
            let here = self.driven_in(key);
            for (moved, words) in moves.iter().zip(semantics.tables.words(key, Instant::Between)) {
                let body = self.moved(key[0], *moved);
                if semantics.anywhere {
                    lines.push(option(&here, &body, &words));
                } else if let Some(is_busy) = busy(semantics.tables.effect(*moved), steps, &steps_of) {
                    let body = format!("SAVE; {}; if :: {is_busy} :: else -> UNDO fi; next = NOTHING", or_skip(&body));
                    lines.push(option(&here, &body, &words));
                }
            }
        }
        lines
    }

    /// Whether the environment and its driven processes are in these states.
    fn driven_in(&self, key: &[u32]) -> String {
        let driven = self.tables().driven.iter().map(|process| self.process(*process));
        let variables = std::iter::once(ENVIRONMENT.to_owned()).chain(driven);
        let here: Vec<String> = variables.zip(key).map(|(variable, value)| format!("{variable} == {value}")).collect();
        here.join(" && ")
    }

    fn moved(&mut self, environment: u32, moved: Moved) -> String {
        let state = (moved.state != environment).then(|| format!("{ENVIRONMENT} = {}", moved.state));
        let mut changes: Vec<String> = state.into_iter().collect();
        let semantics = self.semantics;
        for (process, step) in semantics.tables.effect(moved) {
            changes.extend(self.follow(*process as usize, *step));
        }
        changes.join("; ")
    }

    fn variables_of_moves(&self) -> Vec<String> {
        let moves = self.tables().sorted_moves(Instant::Between).into_iter().flat_map(|(_, moves)| moves);
        let renames = moves.flat_map(|moved| self.tables().effect(*moved)).any(|(_, step)| step.renaming != 0);
        let environment = std::iter::once(ENVIRONMENT.to_owned());
        match renames {
            true => {
                let processes = self.semantics.populated().map(|process| self.process(process));
                let channels = (0..self.tables().links.len()).map(|channel| self.channel(channel));
                environment.chain(processes).chain(channels).collect()
            }
            false => environment.chain(self.tables().driven.iter().map(|process| self.process(*process))).collect(),
        }
    }

    /// Time passes in all processes and for messages held back; then the tick arrives if it is due.
    fn time_passes(&mut self) -> Vec<String> {
        let semantics = self.semantics;
        let mut lines = Vec::new();
        for process in semantics.populated() {
            let mut options = Vec::new();
            for (state, local) in (0..).zip(semantics.tables.locals[process].iter()) {
                let later = semantics.tables.spans.iter().zip(&local.later);
                let changes =
                    later.filter(|(_, step)| **step != Step::UNKNOWN && **step != Step { next: state, renaming: 0 });
                for (span, step) in changes {
                    let here = format!("{} == {state} && span == {}", self.process(process), self.time(*span));
                    options.push(format!(":: {here} -> {}", self.follow(process, *step).join("; ")));
                }
            }
            lines.extend(choice(&options));
        }
        for channel in (0..semantics.tables.links.len()).filter(|channel| self.may_hold(*channel)) {
            let held = self.held(channel);
            lines.push(format!("if :: {held} > span -> {held} = {held} - span :: else -> {held} = -1 fi"));
        }
        lines.extend(self.tick());
        lines
    }

    fn tick(&self) -> Option<String> {
        let ticks = self.tables().ticks?;
        let (generator, output) = (ticks.generator.index(), self.tables().tick_channel);
        let states_of = |process: usize, which: &dyn Fn(&Local) -> bool| {
            let states = (0..).zip(self.tables().locals[process].iter()).filter(|(_, local)| which(local));
            any(&self.process(process), states.map(|(state, _)| state))
        };
        let is_idle = states_of(generator, &|local| local.own.is_empty());
        let awaits = |process| states_of(process, &|local| local.awaits_any(output));
        let awaited = either(self.semantics.populated().map(awaits).filter(|awaits| awaits != "false").collect());
        let generates =
            mapping(&self.process(generator), self.tables().locals[generator].iter().map(|local| local.ticked));
        let delivered = format!(
            "if :: {is_idle} && {} == 0 && {awaited} -> {} :: else fi",
            self.channel(output),
            or_skip(&generates.unwrap_or_default())
        );
        // A tick that decides the property has been dealt with: `next_instant` has set `next` to something else.
        let changes = self.ticked(|before, after| {
            before != after && self.tables().monitors.get(after).verdict == Verdict::Inconclusive
        });
        let changes: Vec<String> = changes.map(|(here, after)| format!(":: {here} -> {MONITOR} = {after}")).collect();
        let tick = [Some(delivered), choice(&changes)].into_iter().flatten().collect::<Vec<_>>().join("; ");
        let period = self.time(ticks.period);
        Some(format!(
            "if :: next == TICK -> {tick}; has_ticked = 1; until_tick = {period} \
             :: else -> until_tick = until_tick - span fi"
        ))
    }
}

/// By process and its state: the guards of the steps that it can take there.
type StepsOf<'a> = BTreeMap<(usize, u32), Vec<&'a str>>;

/// Whether a process can move after a move of the environment with this effect; `None` if none ever can.
///
/// The system was quiet, so only a process that has changed can move, alone or with a partner. But if requests are
/// renumbered, the move also changes processes that it does not drive: then all steps are asked.
fn busy(effect: &[(u32, Step)], steps: &[GuardedStep], steps_of: &StepsOf<'_>) -> Option<String> {
    let guards: BTreeSet<&str> = match effect.iter().all(|(_, step)| step.renaming == 0) {
        true => {
            let changed = effect.iter().filter_map(|(process, step)| steps_of.get(&(*process as usize, step.next)));
            changed.flatten().copied().collect()
        }
        false => steps.iter().map(|step| step.guard.as_str()).collect(),
    };
    let is_endless = effect.iter().any(|(_, step)| step.next == ENDLESS);
    (is_endless || !guards.is_empty()).then(|| either(guards.iter().map(|guard| format!("({guard})")).collect()))
}
