//! The settings of components in a scenario: its table `components`.

use std::path::PathBuf;

use devices::{DeviceKind, DeviceSettings};
use diagnostics::document::{Referent, Table};
use diagnostics::{Span, Spanned, did_you_mean};
use programs::Limits;
use serde_json::{Value, json};

use super::data::{Data, read_data};
use crate::files::path;

/// An array of texts, in words.
const STRINGS: &str = "an array of strings";

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
    /// The device that its machine replaces in a proof; the machine gets the device's interface.
    pub stands_for: Option<DeviceKind>,
}

impl ComponentEntry {
    /// Lets it do anything that its interface allows, as is set here.
    pub(super) fn do_anything(&mut self, place: &Span) {
        let asks = match &mut self.runs {
            RunsEntry::Program { asks, .. } => std::mem::take(asks),
            _ => Vec::new(),
        };
        self.runs = RunsEntry::Anything { place: place.clone(), asks };
    }

    pub(super) fn device(&self) -> Option<DeviceKind> {
        match &self.runs {
            RunsEntry::Device { settings, .. } => Some(settings.value.kind()),
            _ => None,
        }
    }
}

/// The form that the entry of a component selects.
#[derive(Clone, Debug)]
pub enum RunsEntry {
    /// The machine in this file.
    Machine(Spanned<PathBuf>),
    /// In a proof: anything that its interface allows.
    Anything {
        /// Where that is set.
        place: Span,
        /// The components whose topics it reads.
        asks: Vec<Spanned<String>>,
    },
    /// A program.
    Program {
        /// Its command.
        command: Spanned<Vec<String>>,
        /// Its limits.
        limits: Limits,
        /// The components that it asks, or whose topics it reads.
        asks: Vec<Spanned<String>>,
    },
    /// Nodes of ROS 2.
    Remote {
        /// Their namespace.
        namespace: Spanned<String>,
    },
    /// A device of the world.
    Device {
        /// What it is.
        settings: Spanned<DeviceSettings>,
        /// The doors or people of the world that it names.
        names: Vec<Spanned<String>>,
    },
}

pub(super) fn read_components(root: Table<'_>) -> Vec<ComponentEntry> {
    let about = "The components that skills ask, by the name of their process.";
    let Some(table) = root.table("components").about(about).optional() else { return Vec::new() };
    let mut entries = Vec::new();
    for (name, span) in table.names("NAME") {
        let about =
            "A component that answers others: an SCXML machine, a program, nodes of ROS 2, or a device of the world.";
        let entry = table.table(name).about(about).rules(one_form).named_after(Referent::Component);
        let Some(entry) = entry.optional() else { continue };
        let others = table.keys().map(|(other, _)| other).filter(|other| *other != name);
        let near = did_you_mean(name, others);
        let runs = read_runs(&entry, (name, span), near);
        let data = read_data(
            entry,
            "The initial value of `<data id=\"ID\">`; for a program, a value that it receives when it starts.",
        );
        let interface = path(
            entry,
            "interface",
            "The file with its interface: its services, topics and actions. Needed if others ask it \
             or read its topics.",
        );
        let interface = interface.refers_to(Referent::Interface);
        let name = Spanned { value: name.to_owned(), span: span.clone() };
        let entry = |runs| ComponentEntry { name, runs, data, interface: interface.optional(), stands_for: None };
        entries.extend(runs.map(entry));
    }
    entries
}

/// The keys that determine what a component runs.
pub(super) const FORMS: [&str; 4] = ["machine", "program", "builtin", "ros"];

/// A component has at most one form, the rest being in its base, and the keys of that form.
fn one_form() -> Value {
    let form = |(key, kind, _, keys): Form| {
        let is_kind = kind.map_or_else(|| json!(true), |kind| json!({ "const": kind.name() }));
        json!({
            "if": { "required": [key], "properties": { (key): is_kind } },
            "then": { "propertyNames": { "enum": keys } },
        })
    };
    let pairs = FORMS.iter().enumerate().flat_map(|(at, one)| FORMS[..at].iter().map(move |other| [other, one]));
    let both: Vec<Value> = pairs.map(|pair| json!({ "required": pair })).collect();
    json!({ "not": { "anyOf": both }, "allOf": forms().map(form).collect::<Vec<_>>() })
}

fn is_namespace(name: &str) -> bool {
    name == "/" || name.strip_prefix('/').is_some_and(|words| words.split('/').all(remote::is_name))
}

/// The forms of a component: the key that selects each, the kind of a device, its name, and its keys.
pub(super) type Form = (&'static str, Option<DeviceKind>, &'static str, &'static [&'static str]);

/// All possible forms of a component.
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
        ("builtin", Some(kind), kind.noun(), keys)
    };
    let remote: Form = ("ros", None, "component of ROS 2", &["ros", "interface"]);
    [machine, ("program", None, "program", program), remote].into_iter().chain(DeviceKind::ALL.into_iter().map(device))
}

/// `near` is advice in case that the name of another component was meant.
fn read_runs(entry: &Table<'_>, (name, span): (&str, &Span), near: Option<String>) -> Option<RunsEntry> {
    let machine = path(*entry, "machine", "The file of its machine.").refers_to(Referent::File(&["scxml"])).optional();
    let command = entry.get("program").words(STRINGS).spanned().about(
        "A program instead of a machine: a path relative to the folder of the file that sets it or a name on the \
         `PATH`, followed by its arguments.",
    );
    let command = command.optional();
    let default = Limits::default();
    let answer_within = entry.seconds("answer_within_s").above_0();
    let answer_within = answer_within.about("How long a program may take to answer, in seconds of real time.");
    let memory_mb = entry.get::<u64>("memory_mb").within(1..=1 << 20);
    let memory_mb = memory_mb.about("The address space that each process of a program may use, in MiB.");
    let limits = Limits {
        answer_within: answer_within.default(default.answer_within),
        memory_bytes: memory_mb.default(default.memory_bytes >> 20) << 20,
    };
    let asks = entry.get("asks").about("The components that a program asks, or whose topics it reads.");
    let asks = asks.words(STRINGS).refers_to(Referent::Component).or(Vec::new());
    let namespace = entry.text("ros").about(
        "The namespace of nodes of ROS 2 that are this component, such as `/robot` or `/`. Its services, topics and \
         actions have the names of the interface there, and the types of their `ros` definitions.",
    );
    let namespace = namespace.check(|name| is_namespace(name), "be `/`, or names such as `/robot`").spanned();
    let namespace = namespace.optional();
    let device = read_device(entry);
    let given: Vec<(&str, &Span)> = entry.keys().filter(|(key, _)| FORMS.contains(key)).collect();
    match given[..] {
        [_] => {}
        [(first, _), (second, span), ..] => {
            let problem = span.problem(format!("the component `{name}` has both a `{first}` and a `{second}`"));
            let help = "a component has one of `machine`, `program`, `ros` and `builtin`";
            entry.report(problem.with_label("the second one").with_help(help));
            return None;
        }
        [] => {
            let problem = span.problem(format!("the component `{name}` has nothing to run"));
            let help = || "give it a `machine`, a `program`, a `ros` namespace or a `builtin` device".to_owned();
            entry.report(problem.with_label("this component").with_help(near.unwrap_or_else(help)));
            return None;
        }
    }
    let (key, kind, runs) = match (machine, command, namespace, device) {
        (Some(machine), ..) => ("machine", None, RunsEntry::Machine(machine)),
        (_, Some(command), ..) => ("program", None, RunsEntry::Program { command, limits, asks }),
        (_, _, Some(namespace), _) => ("ros", None, RunsEntry::Remote { namespace }),
        (.., Some((settings, names))) => {
            ("builtin", Some(settings.value.kind()), RunsEntry::Device { settings, names })
        }
        _ => return None,
    };
    let form = forms().find(|form| (form.0, form.1) == (key, kind));
    let (_, _, what, known) = form.expect("there is a form for each");
    for (key, span) in entry.keys().filter(|(key, _)| !known.contains(key)) {
        // Entirely unknown keys are reported elsewhere.
        if forms().any(|(.., keys)| keys.contains(&key)) {
            let problem = span.problem(format!("`{key}` has no meaning for a {what}")).with_label("this key");
            entry.report(problem.with_help(format!("a {what} has `{}`", known.join("`, `"))));
        }
    }
    Some(runs)
}

fn read_device(entry: &Table<'_>) -> Option<(Spanned<DeviceSettings>, Vec<Spanned<String>>)> {
    let kinds = DeviceKind::ALL.map(|kind| (kind.name(), kind));
    let kind = entry.one_of("builtin", &kinds).spanned();
    let kind = kind.about("A device of the world instead of a machine. Its interface is fixed.").optional();
    let door =
        entry.text("door").about("For a door: its name in the world.").refers_to(Referent::Door).spanned().optional();
    let number = |key, about, range, default| entry.number(key).about(about).within(range).default(default);
    let about = "For a people sensor: its range from the robot's center, in meters.";
    let within_m = number("within_m", about, 0.1..=100.0, 5.0);
    let only = entry.get::<Vec<Spanned<String>>>("only").words(STRINGS);
    let only = only.about("For a people sensor: the people that it detects; everyone if empty.");
    let only = only.refers_to(Referent::Person).or_empty();
    let about = "For a speaker: how fast it speaks, in letters per second.";
    let letters_per_s = number("letters_per_s", about, 0.1..=1000.0, 15.0);
    let pressed = entry.get("pressed_s").words("an array of times in seconds");
    let pressed = pressed.about("For a button: the times at which it is pressed, in seconds.").or_empty();
    let hears = entry.tables("hears").about("For a microphone: a request that it hears.").each(|heard| {
        let at = heard.seconds("at_s").about("When, in seconds.").required();
        let text = heard.text("text").about("The spoken text.");
        let text = text.rules(|| json!({ "minLength": 1, "maxLength": 1000 }));
        let text = text.check(|text| (1..=1000).contains(&text.chars().count()), "have 1 to 1000 letters").required();
        Some((at?, text?))
    });
    let hears = hears.or(Vec::new());
    let about = "For a tray: the maximum distance of a box from the robot's edge, in meters.";
    let reach_m = number("reach_m", about, 0.0..=5.0, 0.8);
    let Spanned { value: kind, span } = kind?;
    let name = |name: &Spanned<String>| name.value.clone();
    let (value, names) = match kind {
        DeviceKind::Door => {
            (DeviceSettings::Door { door: door.as_ref().map(name).unwrap_or_default() }, door.into_iter().collect())
        }
        DeviceKind::People => (DeviceSettings::People { within_m, only: only.iter().map(name).collect() }, only),
        DeviceKind::Speaker => (DeviceSettings::Speaker { letters_per_s }, Vec::new()),
        DeviceKind::Button => (DeviceSettings::Button { pressed }, Vec::new()),
        DeviceKind::Microphone => (DeviceSettings::Microphone { hears }, Vec::new()),
        DeviceKind::Tray => (DeviceSettings::Tray { reach_m }, Vec::new()),
    };
    Some((Spanned { value, span }, names))
}
