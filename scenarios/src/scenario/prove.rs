//! The assumptions and questions of a proof: the `[prove]` of a scenario file.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

use devices::DeviceKind;
use diagnostics::document::{FromItem, Item, Referent, Table};
use diagnostics::{Problem, Span, Spanned};
use serde_json::{Value, json};

use super::component_entry::{ComponentEntry, RunsEntry};
use super::stop::Names;
use super::world::MAP;
use crate::error::{Complaints, Error};
use crate::files::path;
use crate::names::unknown;

/// A proof's assumptions about everything around tree, skills and components, and its subject.
#[derive(Clone, Debug)]
pub struct ProveEntry {
    /// The properties to be proved; all if empty. [`PROGRESS`] is always among them.
    pub properties: Vec<Spanned<String>>,
    /// Their expected results; `Proved` where none is given.
    pub expect: Vec<(Spanned<String>, ProofOutcome)>,
    /// How much memory the proof of a property may take, in bytes.
    pub memory_bytes: u64,
    /// How many states the proof of a property may visit.
    pub states: u64,
    /// How many threads explore; if not given, one per core.
    pub threads: Option<u64>,
    /// The battery.
    pub battery: BatteryAssumption,
    /// The trips of Navigation.
    pub trips: TripAssumption,
    /// The disturbances of messages.
    pub messages: MessageAssumption,
    /// The faults that may occur.
    pub faults: FaultAssumption,
    /// Whether drivers may also act while processes communicate, not only between steps.
    pub drivers_anywhere: bool,
    /// Machines that replace components, by the name of the component.
    pub components: Vec<StandIn>,
}

/// The property of every scenario that there is no deadlock and no livelock, and that no messages pile up.
pub const PROGRESS: &str = "progress";
/// The property that every node of the tree is ticked, succeeds and fails in some run, and that every state and
/// transition of every machine is reached. It is proved only if `[prove]` names it.
pub const ALL_REACHED: &str = "all_reached";
/// The properties that no file describes.
pub const GENERAL: [&str; 2] = [PROGRESS, ALL_REACHED];

/// The result of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProofOutcome {
    /// It holds in every run.
    Proved,
    /// It is violated in some run.
    Violated,
}

impl ProofOutcome {
    /// All outcomes.
    pub const ALL: [Self; 2] = [Self::Proved, Self::Violated];

    /// The outcome in one word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Violated => "violated",
        }
    }
}

/// The possible changes of the battery's level.
#[derive(Clone, Debug)]
pub enum BatteryAssumption {
    /// It may jump to any value at any time.
    Free,
    /// It falls slowly, and rises only at the charging station.
    Drained(Drained),
}

/// A battery that is drained and charged.
#[derive(Clone, Debug)]
pub struct Drained {
    /// The maximum fall per tick, in percent.
    pub drain_pct: f64,
    /// The position of the table that sets it.
    pub place: Span,
    /// The minimum rise in a tick throughout which it is charged, in percent.
    pub charge_pct: f64,
    /// Its level at the start, in percent; the scenario's `battery.initial_pct` if not given.
    pub start_pct: Option<RangeInclusive<f64>>,
}

/// The possible trips of Navigation.
#[derive(Clone, Debug)]
pub struct TripAssumption {
    /// A trip ends before this number of ticks; if not given, it may take any time.
    pub ticks: Option<u64>,
    /// Whether trips may fail.
    pub fail: bool,
    /// The places that the robot may pass on a trip.
    pub passes: Passes,
}

/// The places that a robot may pass on a trip.
#[derive(Clone, Debug)]
pub enum Passes {
    /// Any.
    Any,
    /// These.
    These(Vec<Spanned<String>>),
}

/// The disturbances of messages in a run.
#[derive(Clone, Debug, Default)]
pub struct MessageAssumption {
    /// How many may be lost.
    pub lose: u8,
    /// How many may be delivered twice.
    pub repeat: u8,
    /// How many may be delayed.
    pub delay: u8,
    /// How long a delayed message is held.
    pub hold: Duration,
    /// The channels on which this may happen, by sender and receiver; all if empty.
    pub on: Vec<[Spanned<String>; 2]>,
}

/// The faults that may occur in a run.
#[derive(Clone, Debug, Default)]
pub struct FaultAssumption {
    /// How many may begin.
    pub count: u8,
    /// The faults: what happens, and to which component, or with which mistake.
    pub allowed: Vec<(AllowedFault, Spanned<String>)>,
}

/// A kind of fault from the catalogue that can be part of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AllowedFault {
    /// A component crashes, and may restart.
    Crash,
    /// A component hangs, and may continue.
    Frozen,
    /// A component reports the opposite.
    WrongReply,
    /// A skill has a mistake.
    Mutant,
}

impl AllowedFault {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Crash, Self::Frozen, Self::WrongReply, Self::Mutant];

    /// The name of the kind in the catalogue.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Crash => "component_crash",
            Self::Frozen => "component_frozen",
            Self::WrongReply => "component_wrong_reply",
            Self::Mutant => "skill_mutant",
        }
    }

    /// What its key names.
    fn refers_to(self) -> Referent {
        if self == Self::Mutant { Referent::Mutant } else { Referent::Component }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Crash => "Components that may crash, and restart.",
            Self::Frozen => "Components that may hang, and continue later.",
            Self::WrongReply => "Components that may report the opposite of the truth.",
            Self::Mutant => "Mistakes that skills may have, as `steward skill mutants` lists them.",
        }
    }
}

/// What takes the place of a component in a proof.
#[derive(Clone, Debug)]
pub struct StandIn {
    /// The component.
    pub component: Spanned<String>,
    /// What it does instead.
    pub conduct: Conduct,
}

/// How a component behaves in a proof.
#[derive(Clone, Debug)]
pub enum Conduct {
    /// As the machine in this file allows.
    Machine(Spanned<PathBuf>),
    /// It answers and publishes anything that its interface allows; this is set here.
    Anything(Span),
}

/// How much memory the proof of a property may use by default, in MiB.
const MEMORY_MB: u64 = 2048;

/// How many states the proof of a property may visit by default. This takes about a minute on two cores, and at most
/// half of [`MEMORY_MB`].
const STATES: u64 = 20_000_000;

impl Default for ProveEntry {
    fn default() -> Self {
        Self {
            properties: Vec::new(),
            expect: Vec::new(),
            memory_bytes: MEMORY_MB << 20,
            states: STATES,
            threads: None,
            battery: BatteryAssumption::Free,
            trips: TripAssumption::default(),
            messages: MessageAssumption::default(),
            faults: FaultAssumption::default(),
            drivers_anywhere: false,
            components: Vec::new(),
        }
    }
}

impl Default for TripAssumption {
    fn default() -> Self {
        Self { ticks: None, fail: true, passes: Passes::These(Vec::new()) }
    }
}

impl ProveEntry {
    /// Reads the table `prove`. `None` after recording problems.
    pub(super) fn read(root: Table<'_>) -> Option<Self> {
        let table = root.table("prove").about("What `steward prove` assumes and proves.").optional();
        let Some(table) = table else { return Some(Self::default()) };
        let properties = table.get("properties").about(
            "The properties to prove. If not given, all of them. `progress` (no deadlock and no livelock) is always \
             among them.",
        );
        let Names(properties) = properties.refers_to(Referent::Property).or(Names(Vec::new()));
        let count = |key, about, range| table.get::<u64>(key).about(about).within(range);
        let about = "How much memory the proof of a property may take, in MiB.";
        let memory_mb = count("memory_mb", about, 1..=1 << 20).default(MEMORY_MB);
        let about = "How many states the proof of a property may visit, over all its rounds. Then it is not decided.";
        let states = count("states", about, 1..=1 << 40).default(STATES);
        let about = "How many threads explore. If not given, one per core. The result does not depend on it.";
        let threads = count("threads", about, 1..=1024).optional();
        let battery = read_battery(table);
        let trips = read_trips(table);
        let messages = read_messages(table);
        let faults = read_faults(table);
        let drivers = [("between-steps", false), ("anywhere", true)];
        let anywhere = table.one_of("drivers", &drivers).about(
            "When the drivers of the built-in components exchange data with them: between the steps of a run \
             (`between-steps`), as in the simulation, or also while processes communicate (`anywhere`).",
        );
        let drivers_anywhere = anywhere.or_first(&drivers);
        let components = read_stand_ins(table);
        let expect = read_expect(table);
        // The expectations of a base do not matter if its properties are not used.
        let is_asked = |name: &Spanned<String>| {
            let here: Vec<_> =
                properties.iter().filter(|asked| asked.span.source().name() == name.span.source().name()).collect();
            GENERAL.contains(&name.value.as_str())
                || here.is_empty()
                || here.iter().any(|asked| asked.value == name.value)
        };
        for (name, _) in expect.iter().filter(|(name, _)| !is_asked(name)) {
            let problem = name.span.problem(format!("`{}` is not among `prove.properties`", name.value));
            table.report(problem.with_label("this expectation").with_help("add it there, or remove it here"));
        }
        let memory_bytes = memory_mb << 20;
        Some(Self {
            properties,
            expect,
            memory_bytes,
            states,
            threads,
            battery: battery?,
            trips,
            messages,
            faults,
            drivers_anywhere,
            components,
        })
    }

    /// Whether the scenario sets anything for proofs of its own properties.
    pub(super) fn is_used(&self) -> bool {
        !self.properties.is_empty() || !self.expect.is_empty() || !self.components.is_empty()
    }

    /// Replaces components by machines.
    pub(super) fn put_stand_ins(&self, components: &mut [ComponentEntry]) -> Result<(), Error> {
        let mut complaints = Complaints::default();
        for StandIn { component, conduct } in &self.components {
            match components.iter_mut().find(|entry| entry.name.value == component.value) {
                Some(entry) => {
                    entry.stands_for = entry.stands_for.or(entry.device());
                    match conduct {
                        Conduct::Machine(machine) => entry.runs = RunsEntry::Machine(machine.clone()),
                        Conduct::Anything(place) => entry.do_anything(place),
                    }
                    entry.data.clear();
                }
                None => {
                    let known = components.iter().map(|entry| entry.name.value.as_str());
                    complaints.push(unknown("component", component, known));
                }
            }
        }
        // These sense and change the world, which does not exist in a proof.
        for entry in components.iter_mut().filter(|entry| entry.device().is_some_and(DeviceKind::needs_robot)) {
            entry.stands_for = entry.device();
            let place = entry.name.span.clone();
            entry.do_anything(&place);
        }
        complaints.check()
    }
}

fn read_battery(prove: Table<'_>) -> Option<BatteryAssumption> {
    let table = prove.table("battery").about("How the battery's level may change.").needs(MAP).optional();
    let Some(table) = table else { return Some(BatteryAssumption::Free) };
    let drain = table.number("drain_pct_per_tick").rules(percent).about(
        "The maximum fall of the level per tick, in percent; it rises only at the charging station. Without it, \
         the level may jump to any value at any time.",
    );
    let drain = drain.try_map(|pct, span| match (0.0..=100.0).contains(&pct) {
        true => Ok(pct),
        false => {
            let problem = span.problem("`drain_pct_per_tick` must lie between 0 and 100").with_label("this value");
            Err(problem.with_help("0 is a battery that never drains; without the key, its level may jump to any value"))
        }
    });
    let drain_pct = drain.optional();
    let charge_pct = table
        .number("charge_pct_per_tick")
        .within(0.0..=100.0)
        .about("The minimum rise of the level, in percent, in a tick throughout which the battery is charging.");
    let charge_pct = charge_pct.default(0.0);
    let start_pct = table.get::<Range>("start_pct");
    let start_pct = start_pct.about("The level at the start, in percent. If not given, `battery.initial_pct`.");
    let start_pct = start_pct.optional();
    if drain_pct.is_none() && !table.has("drain_pct_per_tick") {
        for (key, span) in table.keys().filter(|(key, _)| ["charge_pct_per_tick", "start_pct"].contains(key)) {
            let problem = span.problem(format!("`{key}` contradicts a battery whose level may jump to any value"));
            let help = "add `drain_pct_per_tick`, which bounds how fast the level falls";
            table.report_missing("drain_pct_per_tick", problem.with_label("this assumption").with_help(help));
        }
        return Some(BatteryAssumption::Free);
    }
    Some(BatteryAssumption::Drained(Drained {
        drain_pct: drain_pct?,
        place: table.span().clone(),
        charge_pct,
        start_pct: start_pct.map(|Range(range)| range),
    }))
}

/// Numbers from 0 to 100, as JSON Schema.
fn percent() -> Value {
    json!({ "minimum": 0, "maximum": 100 })
}

/// A level, or the lowest and the highest.
struct Range(RangeInclusive<f64>);

impl FromItem<'_> for Range {
    fn wanted() -> String {
        "a number from 0 to 100, or [lowest, highest]".into()
    }

    fn takes() -> Value {
        let mut level = percent();
        level["type"] = json!("number");
        let both = json!({ "type": "array", "items": level, "minItems": 2, "maxItems": 2 });
        json!({ "title": Self::wanted(), "anyOf": [level, both] })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        let (low, high) = match (item.as_number(), item.get::<[f64; 2]>()) {
            (Some(level), _) => (level, level),
            (None, Ok([low, high])) => (low, high),
            (None, Err(_)) => return Err(vec![item.wrong(&Self::wanted())]),
        };
        if !(0.0..=100.0).contains(&low) || !(0.0..=100.0).contains(&high) || low > high {
            return Err(vec![item.wrong(&Self::wanted())]);
        }
        Ok(Self(low..=high))
    }
}

fn read_trips(prove: Table<'_>) -> TripAssumption {
    let table = prove.table("trips").about("What the trips of the built-in Navigation may do.").needs(MAP).optional();
    let Some(table) = table else { return TripAssumption::default() };
    let ticks = table.get::<u64>("ticks").about(
        "A trip ends before this number of ticks has passed since its start. Without it, a trip may take forever.",
    );
    let fail = table.boolean("fail").about("Whether trips may fail.");
    let passes = table.get("passes").rules(|| json!({ "default": [] }));
    let passes = passes.about("The places that the robot may pass during a trip, besides its start and its goal.");
    let passes = passes.refers_to(Referent::Place);
    TripAssumption {
        ticks: ticks.within(1..=10_000).optional(),
        fail: fail.default(true),
        passes: passes.or(Passes::These(Vec::new())),
    }
}

impl FromItem<'_> for Passes {
    fn wanted() -> String {
        "\"any\", the name of a place, or an array of names".into()
    }

    fn takes() -> Value {
        let mut names = Names::takes();
        names["title"] = json!("`\"any\"`, a name, or an array of names");
        names
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        if item.as_text() == Some("any") {
            return Ok(Self::Any);
        }
        if item.as_text().is_none() && item.as_array().is_none() {
            return Err(vec![item.wrong(&Self::wanted())]);
        }
        item.get().map(|Names(names)| Self::These(names))
    }
}

fn read_messages(prove: Table<'_>) -> MessageAssumption {
    let table = prove.table("messages").about("What may happen to messages in transit.").optional();
    let Some(table) = table else { return MessageAssumption::default() };
    let count = |key, what: &str| {
        let about = format!("The maximum number of messages of a run that may be {what}.");
        let count = table.get::<u64>(key).about(&about).within(0..=9).default(0);
        u8::try_from(count).unwrap_or(u8::MAX)
    };
    let lose = count("lose", "lost");
    let repeat = count("repeat", "delivered twice");
    let delay = count("delay", "delayed");
    let hold = table.seconds("delay_s").about("How long a delayed message is held back, in seconds.").above_0();
    let hold = hold.default(Duration::from_secs(1));
    let on = table.get("on").words("[[from, to], …]");
    let on = on.about("The channels on which this may happen, by sender and receiver. If not given, all of them.");
    let on = on.refers_to(Referent::Process).or_empty();
    let report = |key: &str, needs: &str| {
        for (_, span) in table.keys().filter(|(known, _)| *known == key) {
            let problem = span.problem(format!("`{key}` has no effect if no message may be {needs}"));
            table.report(
                problem.with_label("this assumption").with_help(format!("remove it, or say how many may be {needs}")),
            );
        }
    };
    if delay == 0 {
        report("delay_s", "delayed");
    }
    if lose + repeat + delay == 0 {
        report("on", "lost, repeated or delayed");
    }
    MessageAssumption { lose, repeat, delay, hold, on }
}

fn read_faults(prove: Table<'_>) -> FaultAssumption {
    let table = prove.table("faults").about("Faults that may begin and end at any time.").optional();
    let Some(table) = table else { return FaultAssumption::default() };
    let count = table.get::<u64>("count").about("The maximum number of faults in a run.").within(1..=9).default(1);
    let count = u8::try_from(count).unwrap_or(u8::MAX);
    let named = |kind: AllowedFault| {
        let names = table.get(kind.name()).about(kind.about()).rules(|| json!({ "default": [] }));
        let Names(names) = names.refers_to(kind.refers_to()).or(Names(Vec::new()));
        names.into_iter().map(move |name| (kind, name))
    };
    let allowed: Vec<_> = AllowedFault::ALL.into_iter().flat_map(named).collect();
    for (_, span) in table.keys().filter(|(key, _)| *key == "count" && allowed.is_empty()) {
        let problem = span.problem("`count` has no effect if no fault may occur");
        table
            .report(problem.with_label("this assumption").with_help("name faults: `component_crash = \"Navigation\"`"));
    }
    FaultAssumption { count, allowed }
}

fn read_stand_ins(prove: Table<'_>) -> Vec<StandIn> {
    let about = "What takes the place of components, by the name of the component.";
    let Some(table) = prove.table("components").about(about).optional() else { return Vec::new() };
    let read = |(name, span): (&str, &Span)| {
        let about = "What takes the place of a component. Doors, people sensors and trays answer anything by default.";
        let stand_in = table.table(name).about(about).rules(one_conduct);
        let stand_in = stand_in.named_after(Referent::Component).optional()?;
        let machine = path(
            stand_in,
            "machine",
            "The file of a machine. It has the component's interface, and may do everything that the component may do.",
        );
        let anything = stand_in.one_of("answers", &[("anything", ())]).about(
            "Every request is answered at once with anything that the interface allows; once per tick, just \
             before the next one, anything or nothing is published. Numbers and texts are those that machines and properties distinguish.",
        );
        let machine = machine.refers_to(Referent::File(&["scxml"])).optional();
        let anything = anything.spanned().optional();
        let conduct = match (machine, anything) {
            (Some(machine), None) => Conduct::Machine(machine),
            (None, Some(Spanned { span, .. })) => Conduct::Anything(span),
            _ => {
                let problem = span.problem(format!("what takes the place of `{name}` must be one thing"));
                let help = "give it a `machine`, or `answers = \"anything\"`";
                table.report(problem.with_label("this component").with_help(help));
                return None;
            }
        };
        Some(StandIn { component: Spanned { value: name.to_owned(), span: span.clone() }, conduct })
    };
    table.names("NAME").filter_map(read).collect()
}

/// What takes the place of a component is a machine or anything, not both.
fn one_conduct() -> Value {
    let has = |key: &str| json!({ "required": [key] });
    json!({ "anyOf": [has("machine"), has("answers")], "not": { "required": ["machine", "answers"] } })
}

fn read_expect(prove: Table<'_>) -> Vec<(Spanned<String>, ProofOutcome)> {
    let about = "The expected results of the properties; `proved` by default.";
    let Some(table) = prove.table("expect").about(about).optional() else { return Vec::new() };
    let outcomes = ProofOutcome::ALL.map(|outcome| (outcome.name(), outcome));
    let read = |(name, span): (&str, &Span)| {
        let outcome = table.one_of(name, &outcomes).about(
            "The expected result of a property, of `progress` (no deadlock and no livelock), or of `all_reached` \
             (every node is ticked, succeeds and fails in some run, and every state and transition of every machine \
             is reached). \
             `all_reached` counts only if it is named.",
        );
        let outcome = outcome.named_after(Referent::Property).optional()?;
        Some((Spanned { value: name.to_owned(), span: span.clone() }, outcome))
    };
    table.names("PROPERTY").filter_map(read).collect()
}
