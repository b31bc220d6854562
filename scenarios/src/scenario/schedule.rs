//! Schedules: a run of tree, skills and components, step by step, with everything that happens around them.
//!
//! `steward prove` writes the runs that it finds as schedules, and `execution.schedule` follows one. The schedule
//! replaces the drivers of the built-in components and the physics behind them.

mod driven;

use std::time::Duration;

use channels::{ChannelSystem, Enabled, EnabledKind, Topology};
use components::TripStatus;
use diagnostics::document::{Document, Table};
use diagnostics::{FileProblems, Spanned};
use explorer::{Damage, PathStep};

use super::prove::AllowedFault;

pub use driven::{DriverData, driven, process_of};

/// A run, step by step.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// The steps, in order.
    pub steps: Vec<Spanned<ScheduleStep>>,
}

/// A step of a schedule.
#[derive(Clone, Debug, PartialEq)]
pub enum ScheduleStep {
    /// Something happens around the system.
    Environment(EnvironmentMove),
    /// Time passes; timers that are due fire.
    Wait(Duration),
    /// A tick is due; the flag is whether the tree takes it.
    Tick(bool),
    /// A process takes a transition.
    Take(Taken),
}

/// Something that happens around the system.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMove {
    /// What happens, in words.
    pub words: String,
    /// What the drivers give to the components.
    pub data: DriverData,
    /// A fault begins or ends.
    pub change: Option<FaultChange>,
}

/// A fault begins or ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultChange {
    /// Whether it begins.
    pub begins: bool,
    /// Its kind.
    pub kind: AllowedFault,
    /// The component, or the skill with its mistake.
    pub name: String,
}

/// A transition of the channel system, by the names of its processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Taken {
    /// The process.
    pub process: String,
    /// The process's own number for it.
    transition: u64,
    /// The receiver of the message, if one is sent.
    pub to: Option<String>,
    /// The sender of the message, if one is received.
    pub from: Option<String>,
    /// The number of the receiver's transition, if a message is handed over at once.
    receiving: Option<u64>,
    /// What happens to its message.
    pub damage: Damage,
    /// How long the message is held back, if it is.
    pub held: Duration,
}

impl Taken {
    /// A transition of a system, with what happens to its message.
    #[must_use]
    pub fn of(enabled: &Enabled, damage: Damage, held: Duration, topology: &Topology) -> Self {
        let name = |id| topology.name(id).to_owned();
        let (mut to, mut from, mut receiving) = (None, None, None);
        match enabled.kind {
            EnabledKind::Internal | EnabledKind::Disturb(_) => {}
            EnabledKind::Send(channel) => to = Some(topology.ends(channel).1.to_owned()),
            EnabledKind::Receive(channel) => from = Some(topology.ends(channel).0.to_owned()),
            EnabledKind::Handshake { receiver, receiving: transition, .. } => {
                (to, receiving) = (Some(name(receiver)), Some(transition.0.into()));
            }
        }
        let (process, transition) = (name(enabled.process), enabled.transition.0.into());
        Self { process, transition, to, from, receiving, damage, held }
    }

    /// Its action in words: `BatteryLevel sends to BT`.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { process, transition, .. } = self;
        match (&self.to, &self.from) {
            (Some(to), _) => format!("{process} sends to {to} (its transition {transition})"),
            (None, Some(from)) => format!("{process} receives from {from} (its transition {transition})"),
            (None, None) => format!("{process} takes its transition {transition}"),
        }
    }
}

/// The names of the statuses of trips.
const TRIPS: [(&str, TripStatus); 3] =
    [("running", TripStatus::Running), ("success", TripStatus::Success), ("failure", TripStatus::Failure)];

impl Schedule {
    /// Reads a schedule.
    ///
    /// # Errors
    /// Everything that is wrong with the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        Document::parse_toml(name, text)?.read(|root| {
            let _ = root.text("about").optional();
            let steps = root
                .tables("steps")
                .each(|table| Some(Spanned { value: read_step(table)?, span: table.span().clone() }));
            Some(Self { steps: steps.required()? })
        })
    }

    /// A run of a channel system as the text of a schedule: its steps, with the data of the drivers in each of
    /// them, and the fault that begins or ends. A message that is held back is held for the time `hold`.
    pub fn text<'p>(
        about: &str,
        steps: impl IntoIterator<Item = (&'p PathStep, DriverData, Option<FaultChange>)>,
        held: Duration,
        system: &ChannelSystem,
    ) -> String {
        let mut text = format!("about = {}\nsteps = [\n", quoted(about));
        let mut tick = 0;
        for (step, data, change) in steps {
            let step = match step {
                PathStep::Environment { words, .. } => {
                    ScheduleStep::Environment(EnvironmentMove { words: words.clone(), data, change })
                }
                PathStep::Wait(span) => ScheduleStep::Wait(*span),
                PathStep::Tick { delivered } => ScheduleStep::Tick(*delivered),
                PathStep::Take { enabled, damage } => {
                    ScheduleStep::Take(Taken::of(enabled, *damage, held, system.topology()))
                }
            };
            text += &format!("  {},", line(&step));
            if matches!(step, ScheduleStep::Tick(_)) {
                text += &format!(" # tick {tick}");
                tick += 1;
            }
            text.push('\n');
        }
        text + "]\n"
    }
}

/// A step as an inline table.
fn line(step: &ScheduleStep) -> String {
    let mut parts = Vec::new();
    match step {
        ScheduleStep::Environment(EnvironmentMove { words, data: DriverData { battery, place, trip }, change }) => {
            parts.push(format!("environment = {}", quoted(words)));
            if let Some(FaultChange { begins, kind, name }) = change {
                let happens = if *begins { "begins" } else { "ends" };
                parts.push(format!("{happens} = {{ {} = {} }}", kind.name(), quoted(name)));
            }
            if let Some((level_pct, charging)) = battery {
                parts.push(format!("level_pct = {level_pct}, charging = {charging}"));
            }
            parts.extend(place.as_ref().map(|place| format!("place = {}", quoted(place))));
            let name = |trip| TRIPS.iter().find(|(_, status)| *status == trip).map_or("", |(name, _)| name);
            parts.extend(trip.map(|trip| format!("trip = {}", quoted(name(trip)))));
        }
        ScheduleStep::Wait(span) => parts.push(format!("wait_s = {}", span.as_secs_f64())),
        ScheduleStep::Tick(delivered) => {
            parts.push(format!("tick = {}", quoted(if *delivered { "taken" } else { "lost" })));
        }
        ScheduleStep::Take(Taken { process, transition, to, from, receiving, damage, held }) => {
            parts.push(format!("process = {}, transition = {transition}", quoted(process)));
            parts.extend(to.as_ref().map(|to| format!("to = {}", quoted(to))));
            parts.extend(from.as_ref().map(|from| format!("from = {}", quoted(from))));
            parts.extend(receiving.map(|receiving| format!("receiving = {receiving}")));
            match damage {
                Damage::None => {}
                Damage::Lost => parts.push("lost = true".to_owned()),
                Damage::Repeated => parts.push("repeated = true".to_owned()),
                Damage::Held => parts.push(format!("held_s = {}", held.as_secs_f64())),
            }
        }
    }
    format!("{{ {} }}", parts.join(", "))
}

/// JSON writes strings as TOML does.
pub fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn read_step(table: Table<'_>) -> Option<ScheduleStep> {
    if table.has("environment") {
        return read_move(table).map(ScheduleStep::Environment);
    }
    if table.has("wait_s") {
        return Some(ScheduleStep::Wait(table.seconds("wait_s").required()?));
    }
    if table.has("tick") {
        return Some(ScheduleStep::Tick(table.one_of("tick", &[("taken", true), ("lost", false)]).required()?));
    }
    read_taken(table).map(ScheduleStep::Take)
}

fn read_move(table: Table<'_>) -> Option<EnvironmentMove> {
    let words = table.text("environment").required();
    let level = table.number("level_pct").within(0.0..=100.0).optional();
    let charging = table.boolean("charging").or(false);
    let place = table.text("place").optional();
    let trip = table.one_of("trip", &TRIPS).optional();
    let battery = level.map(|level| (level, charging));
    let change = read_change(table, "begins").or_else(|| read_change(table, "ends"));
    Some(EnvironmentMove { words: words?, data: DriverData { battery, place, trip }, change })
}

fn read_taken(table: Table<'_>) -> Option<Taken> {
    let help = "a step has `environment`, `wait_s`, `tick`, or `process` and `transition`";
    let process = table.text("process").required_or(help);
    let transition = table.get::<u64>("transition").required();
    let (to, from) = (table.text("to").optional(), table.text("from").optional());
    let receiving = table.get::<u64>("receiving").optional();
    let (damage, held) = read_damage(table)?;
    if damage != Damage::None && to.is_none() {
        let problem = table.span().problem("only a message that is sent can be lost, repeated or held");
        table.report(problem.with_label("this step").with_help("set it on the step that sends the message"));
        return None;
    }
    Some(Taken { process: process?, transition: transition?, to, from, receiving, damage, held })
}

/// What happens to a message, and how long it is held back.
fn read_damage(table: Table<'_>) -> Option<(Damage, Duration)> {
    let [lost, repeated] = ["lost", "repeated"].map(|key| table.boolean(key).or(false));
    match (lost, repeated, table.seconds("held_s").optional()) {
        (false, false, None) => Some((Damage::None, Duration::ZERO)),
        (true, false, None) => Some((Damage::Lost, Duration::ZERO)),
        (false, true, None) => Some((Damage::Repeated, Duration::ZERO)),
        (false, false, Some(held)) => Some((Damage::Held, held)),
        _ => {
            let problem = table.span().problem("a message cannot be lost, repeated and held at once");
            table.report(problem.with_label("this step").with_help("keep one of `lost`, `repeated` and `held_s`"));
            None
        }
    }
}

/// The fault that begins or ends, as `[prove.faults]` names it.
fn read_change(table: Table<'_>, key: &str) -> Option<FaultChange> {
    let fault = table.table(key).optional()?;
    let mut named = AllowedFault::ALL.into_iter().filter_map(|kind| Some((kind, fault.text(kind.name()).optional()?)));
    if let (Some((kind, name)), None) = (named.next(), named.next()) {
        return Some(FaultChange { begins: key == "begins", kind, name });
    }
    let kinds = AllowedFault::ALL.map(AllowedFault::name).join(", ");
    let problem = fault.span().problem("this names no fault, or more than one").with_label("this fault");
    fault.report(problem.with_help(format!("give one of {kinds}")));
    None
}

#[cfg(test)]
mod tests;
