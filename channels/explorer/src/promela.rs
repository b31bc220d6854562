//! A model in Promela, so that SPIN can check the same properties.
//!
//! The text is generated from the tables of a search, not from the states that it found: SPIN composes those itself, by
//! the rules of channel systems. There is a variable for each process, each channel, the environment, the monitor and
//! the time; a `d_step` for each transition of a process in each of its states; and an `atomic` sequence that lets time
//! pass when no transition is enabled. Intermediate states are not stored, so SPIN stores exactly the states of a
//! search without reduction.

mod passing;
mod step;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use channels::{Envelope, Monitor, Verdict};

use crate::environment::Instant;
use crate::error::Refused;
use crate::local::{Local, Step, UNKNOWN, entry};
use crate::model::Model;
use crate::search::{Limit, Limits, Progress, find_all};
use crate::semantics::Semantics;
use crate::tables::{ENDLESS, Tables, Transit};

/// A model in Promela.
#[derive(Clone, Debug)]
pub struct Promela {
    /// The text.
    pub text: String,
    /// The number of states that SPIN stores if it continues after errors, as `pan -c0` does.
    pub states: u64,
}

/// Why a model cannot be written in Promela.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotExported {
    /// The model cannot be explored.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// Not all states were found.
    #[error("{limit} after {states} states, and an export needs all of them")]
    Incomplete {
        /// The number of states that were found.
        states: u64,
        /// What ended the search.
        limit: Limit,
    },
    /// The environment shows the monitor something that no process receives.
    #[error(
        "the property {property} also observes what the environment shows, and an export has only what is received"
    )]
    Shown {
        /// The property.
        property: String,
    },
    /// Promela counts with 32 bits.
    #[error("times of up to {longest:?} are multiples of no more than {unit:?}: too many for Promela's integers")]
    TimesTooFine {
        /// The longest time.
        longest: Duration,
        /// The unit of all times.
        unit: Duration,
    },
}

/// A model in Promela. All its states must be found first, even those that an ordinary search does not reach because it
/// ends when the property is violated.
///
/// A violated property becomes a violated assertion, and so do messages that pile up without bound. A step that decides
/// the property, either way, has no successor.
///
/// # Errors
/// [`NotExported`] if not all states are found, or if times do not fit into Promela's integers.
pub fn promela(
    model: &Model,
    property: Option<&dyn Monitor>,
    limits: &Limits,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Promela, NotExported> {
    let found = find_all(model, property, limits, progress)?;
    let states = found.states;
    if let Some(limit) = found.limit {
        return Err(NotExported::Incomplete { states, limit });
    }
    let moves = [Instant::Between, Instant::Tick].map(|instant| found.semantics.tables.sorted_moves(instant));
    if let Some(property) = property
        && moves.iter().flatten().flat_map(|(_, moves)| *moves).any(|moved| moved.shown.is_some())
    {
        return Err(NotExported::Shown { property: property.name().to_owned() });
    }
    let period = model.ticks.map(|ticks| ticks.period);
    let unit = unit(&found.semantics.tables, period.into_iter().chain([found.semantics.hold]))?;
    let mut writer = Writer {
        semantics: &found.semantics,
        start: &found.start,
        unit,
        renamings: BTreeSet::new(),
        rooms: BTreeMap::new(),
    };
    let property = property.map_or("no property", Monitor::name);
    let text = writer.write(&format!("{states} states, with {property}"));
    Ok(Promela { text, states })
}

/// The unit of all times.
fn unit(tables: &Tables, others: impl Iterator<Item = Duration>) -> Result<Duration, NotExported> {
    let timers = tables.locals.iter().flat_map(|locals| locals.iter()).filter_map(|local| local.timer);
    let clocks = tables.clocks.iter().map(|clock| clock.until_tick);
    let times: BTreeSet<Duration> = timers.chain(clocks).chain(others).collect();
    let divisor = |a: u128, b: u128| {
        let (mut a, mut b) = (a, b);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let nanoseconds = times.iter().map(Duration::as_nanos).fold(0, divisor).max(1);
    let unit = Duration::from_nanos(u64::try_from(nanoseconds).unwrap_or(u64::MAX));
    let longest = times.last().copied().unwrap_or_default();
    match longest.as_nanos() / nanoseconds < u128::from(FOREVER) {
        true => Ok(unit),
        false => Err(NotExported::TimesTooFine { longest, unit }),
    }
}

/// Promela's largest `int`.
const FOREVER: u32 = i32::MAX as u32;

/// The output and its sources.
struct Writer<'a> {
    semantics: &'a Semantics,
    start: &'a [u32],
    /// The time unit, which is 1 in Promela.
    unit: Duration,
    /// The renamings in use, each with the process whose step causes it.
    renamings: BTreeSet<(u32, usize)>,
    /// By channel and the first message that gives way: whether there is room for a newer one.
    rooms: BTreeMap<(usize, u32), String>,
}

impl Writer<'_> {
    fn tables(&self) -> &Tables {
        &self.semantics.tables
    }

    fn write(&mut self, title: &str) -> String {
        let steps = self.steps();
        let quiet = self.quiet(&steps);
        let always = if self.semantics.anywhere { self.drives(&steps) } else { Vec::new() };
        let mut lines = vec![
            format!("/* {}.", in_comment(title)),
            "   spin -a -o1 -o2 -o3 FILE && gcc -O2 -DSAFETY -DNOREDUCE -o pan pan.c && ./pan -m1000000".to_owned(),
            format!("   Times are in units of {:?}. */", self.unit),
        ];
        lines.extend(self.declarations());
        lines.extend(self.renaming_macros());
        lines.extend(self.observing_macros());
        lines.push("\nactive proctype System() {".to_owned());
        if self.semantics.has_monitor && self.tables().monitors.get(0).verdict == Verdict::False {
            lines.push("  assert(false);".to_owned());
        }
        lines.push("end:\n  do".to_owned());
        lines.extend(steps.iter().map(|step| option(&step.guard, &step.body, &step.words)));
        lines.extend(always);
        lines.extend(quiet);
        lines.push("  od\n}\n".to_owned());
        lines.join("\n")
    }

    /// The variables, with the meaning of their values.
    fn declarations(&self) -> Vec<String> {
        let (tables, slots) = (self.tables(), &self.semantics.slots);
        let mut lines = Vec::new();
        let mut declare = |name: String, slot: u32, meanings: Vec<String>| {
            let kind = kind(meanings.len() as u64 - 1);
            lines.push(format!("\n{kind} {name} = {};", self.start[slot as usize]));
            lines.extend((0..).zip(meanings).map(|(value, words)| format!("/* {value}: {} */", in_comment(&words))));
        };
        for process in self.semantics.populated() {
            let meanings = tables.locals[process].iter().map(|local| local.process.location()).collect();
            declare(self.process(process), slots.processes[process], meanings);
        }
        for (channel, line) in tables.links.iter().enumerate() {
            let words = |content: &Option<Envelope>| content.as_ref().map_or("empty".to_owned(), in_words);
            declare(self.channel(channel), slots.channels[channel], line.contents.iter().map(words).collect());
        }
        let environment = tables.environments.iter().map(|state| format!("{state:?}")).collect();
        declare(ENVIRONMENT.to_owned(), slots.environment, environment);
        if self.semantics.has_monitor {
            let verdicts = tables.monitors.iter().map(|watching| format!("{:?}", watching.verdict)).collect();
            declare(MONITOR.to_owned(), slots.monitor, verdicts);
        }
        lines.push(String::new());
        let Transit { losses, repeats, delays, .. } = tables.transits.get(0);
        let allowed = [("losses", losses), ("repeats", repeats), ("delays", delays)];
        lines.extend(
            allowed.iter().filter(|(_, count)| **count > 0).map(|(name, count)| format!("byte {name} = {count};")),
        );
        let holding = (0..tables.links.len()).filter(|channel| self.may_hold(*channel));
        lines.extend(holding.map(|channel| format!("int {} = -1;", self.held(channel))));
        lines.extend(self.clocks());
        lines
    }

    /// `RENAME_3_1`: the peers of process 1 learn the new numbers of its requests.
    fn renaming_macros(&self) -> Vec<String> {
        let tables = self.tables();
        let define = |(renaming, mover): &(u32, usize)| {
            let (mut changes, mut receivers) = (Vec::new(), BTreeSet::new());
            for (channel, _) in tables.renamings.get(*renaming) {
                let line = &tables.links[*channel];
                receivers.extend(line.receivers.iter().copied().filter(|process| process != mover));
                for channel in std::iter::once(*channel).chain(line.opposite) {
                    let renamed = tables.links[channel].renamed.get(*renaming as usize);
                    changes.extend(mapping(&self.channel(channel), renamed.into_iter().flatten().copied()));
                }
            }
            for process in receivers {
                let renamed = |local: &Local| entry(&local.renamed, *renaming, UNKNOWN);
                changes.extend(mapping(&self.process(process), tables.locals[process].iter().map(renamed)));
            }
            format!("#define RENAME_{renaming}_{mover} {}", or_skip(&changes.join("; ")))
        };
        self.renamings.iter().map(define).collect()
    }

    /// A process takes a step: assignments.
    fn follow(&mut self, process: usize, step: Step) -> Vec<String> {
        if step.next == ENDLESS {
            return vec![PILED_UP.to_owned()];
        }
        let mut changes = vec![format!("{} = {}", self.process(process), step.next)];
        if step.renaming != 0 {
            self.renamings.insert((step.renaming, process));
            changes.push(format!("RENAME_{}_{process}", step.renaming));
        }
        changes
    }

    /// The variable of a process.
    fn process(&self, process: usize) -> String {
        format!("p{process}_{}", identifier(&self.tables().names[process]))
    }

    /// The variable of a channel.
    fn channel(&self, channel: usize) -> String {
        let topology = &self.tables().topology;
        let ends = topology.get(self.tables().links[channel].id);
        format!("c{channel}_{}_{}", identifier(topology.name(ends.source)), identifier(topology.name(ends.target)))
    }

    /// The variable with the remaining time for which a channel holds its message back; -1 if it does not.
    fn held(&self, channel: usize) -> String {
        format!("held{channel}")
    }

    fn may_hold(&self, channel: usize) -> bool {
        self.tables().links[channel].may_fail && self.tables().transits.get(0).delays > 0
    }

    /// A time in these units.
    fn time(&self, time: Duration) -> u128 {
        time.as_nanos() / self.unit.as_nanos()
    }
}

/// What a process does instead of a step if messages pile up in it.
const PILED_UP: &str = "assert(false)";
/// The variable of the environment.
const ENVIRONMENT: &str = "environment";
/// The variable of the monitor.
const MONITOR: &str = "monitor";

/// The type of a variable with this largest value.
fn kind(largest: u64) -> &'static str {
    match largest {
        0..=1 => "bit",
        2..=255 => "byte",
        256..=32767 => "short",
        _ => "int",
    }
}

/// An option that is executed as one step.
fn option(guard: &str, body: &str, words: &str) -> String {
    format!("  :: d_step {{ {guard} -> {} }} /* {} */", or_skip(body), in_comment(words))
}

/// Assigns to a variable depending on its value; `None` if no value changes.
fn mapping(variable: &str, images: impl Iterator<Item = u32>) -> Option<String> {
    let changes = (0..).zip(images).filter(|(value, image)| *image != UNKNOWN && *image != *value);
    let options: Vec<String> =
        changes.map(|(value, image)| format!(":: {variable} == {value} -> {variable} = {image}")).collect();
    choice(&options)
}

/// An `if` with these options; `None` without options.
fn choice(options: &[String]) -> Option<String> {
    (!options.is_empty()).then(|| format!("if {} :: else fi", options.join(" ")))
}

/// Whether a variable has one of these values, in ascending order.
fn any(variable: &str, values: impl IntoIterator<Item = u32>) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for value in values {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == value => *last = value,
            _ => runs.push((value, value)),
        }
    }
    let is_in = |(first, last): &(u32, u32)| match first == last {
        true => format!("{variable} == {first}"),
        false => format!("({variable} >= {first} && {variable} <= {last})"),
    };
    either(runs.iter().map(is_in).collect())
}

/// A disjunction.
fn either(conditions: Vec<String>) -> String {
    match conditions.as_slice() {
        [] => "false".to_owned(),
        [one] => one.clone(),
        several => format!("({})", several.join(" || ")),
    }
}

fn or_skip(body: &str) -> &str {
    if body.is_empty() { "skip" } else { body }
}

fn in_words(envelope: &Envelope) -> String {
    match envelope.request.0 {
        0 => envelope.message.to_string(),
        number => format!("{} (request {number})", envelope.message),
    }
}

/// A name without what Promela does not allow in one.
fn identifier(name: &str) -> String {
    name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect()
}

/// Text that ends neither a comment nor a line.
fn in_comment(words: &str) -> String {
    words.replace("*/", "* /").replace(['\n', '\r', '\\'], " ")
}
