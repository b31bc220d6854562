//! The settings of components in a scenario: its table `components`.

use std::path::PathBuf;
use std::time::Duration;

use devices::{DeviceKind, DeviceSettings};
use diagnostics::document::Table;
use diagnostics::{Problem, Span, Spanned};
use programs::Limits;

use super::leaves::{Data, read_data};
use crate::files::named;

/// The settings of a component from files: an entry of the table `components`.
#[derive(Clone, Debug)]
pub struct ComponentEntry {
    /// The name of its process.
    pub name: Spanned<String>,
    /// What it runs.
    pub runs: RunsEntry,
    /// The initial values of its data.
    pub data: Data,
    /// The file with its interface, if others ask it or read its topics.
    pub interface: Option<Spanned<PathBuf>>,
}

impl ComponentEntry {
    /// Which kind of device it is, if it is one.
    pub(super) fn device(&self) -> Option<DeviceKind> {
        match &self.runs {
            RunsEntry::Device(device) => Some(device.value.kind()),
            _ => None,
        }
    }
}

/// What the entry of a component says that it runs.
#[derive(Clone, Debug)]
pub enum RunsEntry {
    /// The machine in this file.
    Machine(Spanned<PathBuf>),
    /// A program.
    Program {
        /// Its command.
        command: Spanned<Vec<String>>,
        /// What it may take.
        limits: Limits,
        /// The components that it asks, and whose topics it reads.
        asks: Vec<Spanned<String>>,
    },
    /// A device of the world.
    Device(Spanned<DeviceSettings>),
}

/// Reads the table `components`.
pub(super) fn read_components(table: Table<'_>) -> Vec<ComponentEntry> {
    let mut entries = Vec::new();
    for (name, span) in table.keys() {
        let Some(entry) = table.table(name).required() else { continue };
        let runs = read_runs(&entry, name, span);
        let data = entry.table("data").optional().map_or_else(Vec::new, read_data);
        let interface = entry.text("interface").try_map(|path, span| Ok(named(path, span))).spanned().optional();
        let name = Spanned { value: name.to_owned(), span: span.clone() };
        entries.extend(runs.map(|runs| ComponentEntry { name, runs, data, interface }));
    }
    entries
}

/// What a component may be: the key that says so, the kind of a device, what it is called, and its keys.
pub(super) type Form = (&'static str, Option<DeviceKind>, &'static str, &'static [&'static str]);

/// All that a component may be.
pub(super) fn forms() -> impl Iterator<Item = Form> {
    let machine: Form = ("machine", None, "machine", &["machine", "interface", "data"]);
    let program: &[&str] = &["program", "answer_within_s", "memory_mb", "asks", "interface", "data"];
    let device = |kind: DeviceKind| {
        let keys: &[&str] = match kind {
            DeviceKind::Door => &["builtin", "door"],
            DeviceKind::People => &["builtin", "within_m", "only"],
            DeviceKind::Speaker => &["builtin", "letters_per_s"],
            DeviceKind::Button => &["builtin", "pressed_s"],
            DeviceKind::Microphone => &["builtin", "hears"],
            DeviceKind::Tray => &["builtin", "reach_m"],
        };
        ("builtin", Some(kind), kind.name(), keys)
    };
    [machine, ("program", None, "program", program)].into_iter().chain(DeviceKind::ALL.into_iter().map(device))
}

fn read_runs(entry: &Table<'_>, name: &str, span: &Span) -> Option<RunsEntry> {
    let machine = entry.text("machine").try_map(|path, span| Ok(named(path, span))).spanned().optional();
    let command = entry.get("program").spanned().optional();
    let default = Limits::default();
    let answer_within = entry.seconds("answer_within_s").check(|time| !time.is_zero(), "be above 0");
    let memory_mb = entry.get::<u64>("memory_mb").within(1..=1 << 20).or(default.memory_bytes >> 20);
    let limits = Limits { answer_within: answer_within.or(default.answer_within), memory_bytes: memory_mb << 20 };
    let asks = entry.get("asks").or(Vec::new());
    let device = read_device(entry);
    let given = ["machine", "program", "builtin"].map(|key| entry.keys().any(|(given, _)| given == key));
    if given.into_iter().filter(|is_given| *is_given).count() != 1 {
        let problem = span.problem(format!("the component `{name}` does not say what it runs"));
        let help = "a component has either a `machine`, a `program` or a `builtin` device";
        entry.report(problem.with_label("this component").with_help(help));
        return None;
    }
    let (key, kind, runs) = match (machine, command, device) {
        (Some(machine), ..) => ("machine", None, RunsEntry::Machine(machine)),
        (_, Some(command), _) => ("program", None, RunsEntry::Program { command, limits, asks }),
        (.., Some(device)) => ("builtin", Some(device.value.kind()), RunsEntry::Device(device)),
        _ => return None,
    };
    let form = forms().find(|form| (form.0, form.1) == (key, kind));
    let (_, _, what, known) = form.expect("there is a form for each");
    for (key, span) in entry.keys().filter(|(key, _)| !known.contains(key)) {
        // Keys that are unknown altogether are reported elsewhere.
        if forms().any(|(.., keys)| keys.contains(&key)) {
            let problem = span.problem(format!("`{key}` means nothing to a {what}")).with_label("this key");
            entry.report(problem.with_help(format!("a {what} has `{}`", known.join("`, `"))));
        }
    }
    Some(runs)
}

fn read_device(entry: &Table<'_>) -> Option<Spanned<DeviceSettings>> {
    let kinds = DeviceKind::ALL.map(|kind| (kind.name(), kind));
    let kind = entry.one_of("builtin", &kinds).spanned().optional();
    let door = entry.text("door").optional();
    let within_m = entry.number("within_m").within(0.1..=100.0).or(5.0);
    let only = entry.get::<Vec<String>>("only").or(Vec::new());
    let letters_per_s = entry.number("letters_per_s").within(0.1..=1000.0).or(15.0);
    let pressed = entry.get::<Vec<Spanned<f64>>>("pressed_s");
    let pressed = pressed.try_map(|times, _| times.iter().map(read_moment).collect()).or(Vec::new());
    let hears = entry.tables("hears").each(|heard| {
        let (at, text) = (heard.seconds("at_s").required(), heard.text("text").required());
        Some((at?, text?))
    });
    let hears = hears.or(Vec::new());
    let reach_m = entry.number("reach_m").within(0.0..=5.0).or(0.8);
    let Spanned { value: kind, span } = kind?;
    let value = match kind {
        DeviceKind::Door => DeviceSettings::Door { door: door.unwrap_or_default() },
        DeviceKind::People => DeviceSettings::People { within_m, only },
        DeviceKind::Speaker => DeviceSettings::Speaker { letters_per_s },
        DeviceKind::Button => DeviceSettings::Button { pressed },
        DeviceKind::Microphone => DeviceSettings::Microphone { hears },
        DeviceKind::Tray => DeviceSettings::Tray { reach_m },
    };
    Some(Spanned { value, span })
}

/// A time of the run.
fn read_moment(seconds: &Spanned<f64>) -> Result<Duration, Problem> {
    let wrong = || seconds.span.problem("this is not a time of the run").with_help("write seconds, 0 or more");
    Duration::try_from_secs_f64(seconds.value).map_err(|_| wrong())
}

/// Whether two scenarios have the same components.
pub(super) fn same_components(these: &[ComponentEntry], those: &[ComponentEntry]) -> bool {
    let said = |entry: &ComponentEntry| {
        let data: Vec<_> = entry.data.iter().map(|(id, value)| (id.value.clone(), value.clone())).collect();
        let interface = entry.interface.as_ref().map(|interface| interface.value.clone());
        let runs = match &entry.runs {
            RunsEntry::Machine(machine) => (Some(machine.value.clone()), None, None),
            RunsEntry::Device(device) => (None, None, Some(device.value.clone())),
            RunsEntry::Program { command, limits, asks } => {
                let asks: Vec<String> = asks.iter().map(|name| name.value.clone()).collect();
                (None, Some((command.value.clone(), *limits, asks)), None)
            }
        };
        (entry.name.value.clone(), runs, data, interface)
    };
    these.iter().map(said).eq(those.iter().map(said))
}
