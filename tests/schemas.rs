//! The JSON schemas of scenario, campaign, interface, mapping and places files, against the readers of these files.
//!
//! A schema may accept what only the reader knows to be wrong. It never refuses what the reader accepts.

mod validator;

use std::collections::BTreeMap;
use std::path::Path;
use std::thread;

use bags::Mapping;
use campaigns::CampaignFile;
use channels::Symbol;
use diagnostics::FileProblems;
use diagnostics::document::{Key, Written};
use interfaces::Interface;
use maps::PlacesFile;
use scenarios::faults::{KINDS, Parameter};
use scenarios::files::{Files, shipped_campaigns, shipped_paths};
use scenarios::scenario::ScenarioFile;
use serde_json::{Value, json};

use self::validator::problem;
use crate::steward::steward;

/// A kind of file: its schema, its keys, and its reader.
struct Kind {
    schema: Value,
    keys: Vec<Key>,
    read: fn(&str) -> Result<(), FileProblems>,
}

fn scenarios() -> Kind {
    let read = |text: &str| ScenarioFile::parse("a.toml", text, &Files::shipped(), []).map(|_| ());
    Kind { schema: ScenarioFile::schema(), keys: ScenarioFile::keys().to_vec(), read }
}

fn campaigns() -> Kind {
    let read = |text: &str| CampaignFile::parse("a.toml", text).map(|_| ());
    Kind { schema: CampaignFile::schema(), keys: CampaignFile::keys(), read }
}

fn interfaces() -> Kind {
    let read = |text: &str| {
        let file = |path: &Path| match path.extension().and_then(|ending| ending.to_str()) {
            Some("toml") => Ok(text.as_bytes().to_vec()),
            Some("msg") => Ok(b"float32 text".to_vec()),
            Some("srv") => Ok(b"bool text\n---\nbool text".to_vec()),
            Some("action") => Ok(b"bool text\n---\nbool text\n---\nbool text".to_vec()),
            _ => Err(std::io::ErrorKind::NotFound.into()),
        };
        problems_of(Interface::load(Path::new("a.toml"), &[Symbol::new("Dock")], &file))
    };
    Kind { schema: Interface::schema(), keys: Interface::keys(), read }
}

fn mappings() -> Kind {
    let read = |text: &str| problems_of(Mapping::load(Path::new("a.toml"), &|_| Ok(text.as_bytes().to_vec())));
    Kind { schema: Mapping::schema(), keys: Mapping::keys(), read }
}

fn places() -> Kind {
    let read = |text: &str| PlacesFile::parse("a.toml", text).map(|_| ());
    Kind { schema: PlacesFile::schema(), keys: PlacesFile::keys(), read }
}

fn problems_of<T>(loaded: Result<T, diagnostics::Error>) -> Result<(), FileProblems> {
    match loaded {
        Ok(_) => Ok(()),
        Err(diagnostics::Error::Problems(problems)) => Err(problems),
        Err(other) => panic!("{other}"),
    }
}

/// A file as the schema sees it.
fn as_json(text: &str) -> Value {
    serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap()
}

impl Kind {
    /// The verdicts of schema and reader on a file. The reader refuses everything that the schema refuses.
    fn judged(&self, file: &Value) -> Judged {
        let text = toml::to_string(file).unwrap();
        let read = (self.read)(&text);
        if let Some(error) = problem(&self.schema, file) {
            assert!(read.is_err(), "the schema alone refuses this: {error}\n{text}");
            return Judged::RefusedByBoth;
        }
        match read {
            Ok(()) => Judged::Accepted,
            Err(problems) => Judged::RefusedByReader(problems),
        }
    }
}

enum Judged {
    Accepted,
    RefusedByReader(FileProblems),
    RefusedByBoth,
}

const SCENARIO: &str = r#"
map = "maps/house.yaml"
places = "maps/house.places.toml"
tree = "trees/recharge.xml"
skills = "skills"
properties = []
[components.NAME]
program = ["program", "argument"]
asks = ["Navigation"]
[leaves.NAME]
data = { ID = 1 }
[sites]
start = "start"
[[robot.lasers]]
name = "front"
[robot.docking]
[battery]
[noise]
odometry = {}
motion = {}
[components]
[[execution.order]]
first = "(BatteryReader, BatteryLevel, true)"
then = "(Navigation, GoToDestination, true)"
[[people]]
at = [1, 2]
[[doors]]
at = [1, 2, 0]
[[boxes]]
at = [1, 2, 0]
[[monitors]]
machine = "a.scxml"
violated_in = "failure"
events = [{ event = "e", when = "(BatteryReader, BatteryLevel, true)", data = { NAME = "m[1]" } }]
[stop]
[snapshots]
[expect]
[prove.battery]
drain_pct_per_tick = 1
[prove.trips]
[prove.messages]
delay = 1
delay_s = 2
[prove.faults]
component_crash = "BatteryReader"
component_frozen = "Navigation"
count = 2
[prove.components.NAME]
machine = "b.scxml"
[prove.expect]
PROPERTY = "proved"
"#;

/// One campaign for each form that its tables may have.
const CAMPAIGNS: [&str; 4] = [
    "scenario = \"errand\"\nsampling = \"sobol\"\nruns = 9\n\
     [[parameters]]\nkey = \"seed\"\nname = \"a\"\nfrom = 1\nto = 7\n\
     [goal]\nestimate = \"phi1\"\nhalf_width = 0.1\nconfidence = 0.9\n\
     [model]\nof = \"phi1\"\nquantity = \"a\"\nbound = 3",
    "scenario = \"errand\"\nsampling = \"random\"\nruns = 9\n[[parameters]]\nkey = \"seed\"\n\
     normal = { mean = 1, sd = 2 }\n[goal]\ntest = \"phi1\"\nbound = 0.3\nindifference = 0.1\nerror = 0.1",
    "scenario = \"errand\"\nsampling = \"latin_hypercube\"\nruns = 9\n\
     [[parameters]]\nkey = \"seed\"\nexponential = { mean = 1 }",
    "scenario = \"errand\"\nsampling = \"grid\"\n[[parameters]]\nkey = \"seed\"\nvalues = [1, 2]",
];

/// One interface with its own fields, and one with fields from definitions.
const INTERFACES: [&str; 2] = [
    "packages = []\nservices.NAME = { request = { a = \"text\" }, reply = {} }\n\
     topics.NAME = { fields = { a = [\"open\", \"closed\"] } }\n\
     actions.NAME = { goal = { at = \"place?\" }, feedback = {}, result = {} }",
    "services.NAME = { ros = \"p/srv/S.srv\", request = { a = \"text\" } }\n\
     topics.NAME = { ros = \"p/msg/M.msg\", fields = [\"text\"] }\n\
     actions.NAME = { ros = \"p/action/A.action\" }",
];

/// A mapping with every form that a field can have.
const MAPPING: &str = "tick_s = 0.5\ntime = \"header.stamp\"\n[[messages]]\ntopic = \"/a\"\nfrom = \"source\"\nto = \"target\"\n\
     fields = { a = \"b\", c = { path = \"d\", symbols = { 1 = \"open\" } }, e = { path = \"f\", scale = 2 }, \
     g = { symbol = \"ok\" }, h = { value = 3 } }\nwhere = { i = [1, 2], j = \"k\" }";

/// A point, and an area.
const PLACES: [&str; 2] =
    ["NAME = { position_m = [0, 0], heading_deg = 0 }", "NAME = { corners_m = [[0, 0], [2, 0], [2, 2]] }"];

/// Every kind of file, with examples that together have all of its tables, except faults.
fn examples() -> [(Kind, Vec<Value>); 5] {
    let figure =
        SCENARIO.split_inclusive('\n').filter(|line| !line.starts_with("violated_in") && !line.starts_with("events"));
    let figure = figure.collect::<String>().replace("machine = \"a.scxml\"", "figure = \"5 (a)\"");
    let figure = figure.replace("[[people]]", "[[people]]\nfollows = true");
    let figure = figure.replace("delay = 1\ndelay_s = 2", "lose = 1");
    let component = "program = [\"program\", \"argument\"]\nasks = [\"Navigation\"]\n";
    assert!(SCENARIO.contains(component));
    let with_component = |other: &str| as_json(&SCENARIO.replace(component, &format!("{other}\n")));
    let others = [
        "machine = \"a.scxml\"\ndata = { ID = 1 }",
        "builtin = \"door\"\ndoor = \"a\"",
        "builtin = \"people\"",
        "builtin = \"speaker\"",
        "builtin = \"button\"",
        "builtin = \"microphone\"\nhears = [{ at_s = 1, text = \"a\" }]",
        "builtin = \"tray\"",
    ];
    let mapless = "tree = \"trees/pick.xml\"\nskills = \"skills/pick\"";
    [
        (
            scenarios(),
            [as_json(SCENARIO), as_json(&figure), as_json(mapless)]
                .into_iter()
                .chain(others.map(with_component))
                .collect(),
        ),
        (campaigns(), CAMPAIGNS.map(as_json).to_vec()),
        (interfaces(), INTERFACES.map(as_json).to_vec()),
        (mappings(), vec![as_json(MAPPING)]),
        (places(), PLACES.map(as_json).to_vec()),
    ]
}

/// A scenario with a fault of each kind.
fn faults() -> Vec<(&'static [Parameter], Value)> {
    let with = |kind: &scenarios::faults::FaultKind| {
        as_json(&format!("{SCENARIO}\n[[faults]]\nkind = \"{}\"\n{}", kind.name, kind.example))
    };
    KINDS.iter().map(|kind| (kind.parameters, with(kind))).collect()
}

/// The place of a key in a file, in the first entry of each array of tables. `None` if the table does not exist.
fn place<'f>(file: &'f mut Value, key: &Key) -> Option<(&'f mut serde_json::Map<String, Value>, String)> {
    let mut table = file;
    let mut parts: Vec<&str> = key.path.split('.').collect();
    let last = parts.pop()?;
    for part in parts {
        table = match part.strip_suffix("[]") {
            Some(part) => table.get_mut(part)?.get_mut(0)?,
            None => table.get_mut(part)?,
        };
    }
    Some((table.as_object_mut()?, last.trim_end_matches("[]").to_owned()))
}

/// A file with another value of a key.
fn with(file: &Value, key: &Key, value: Value) -> Option<Value> {
    let mut file = file.clone();
    let (table, name) = place(&mut file, key)?;
    table.insert(name, value);
    Some(file)
}

/// Values of all types, and those at the ends of a key's range and beyond them.
fn probes(key: &Key) -> Vec<Value> {
    let mut probes = vec![
        json!(""),
        json!("text"),
        json!("a.b"),
        json!("start"),
        json!(true),
        json!(false),
        json!(0),
        json!(1),
        json!(-1),
        json!(0.25),
        json!(2.5),
        json!(1_000_000_000_000_i64),
        json!([]),
        json!(["text"]),
        json!(["start"]),
        json!([1]),
        json!([1, 2]),
        json!([1.5, 2, 3]),
        json!([[1, 2]]),
        json!([[2, 1]]),
        json!([[1, 2, 3]]),
        json!([[]]),
        json!({}),
        json!({ "a": 1 }),
        json!([{}]),
        json!([{ "a": 1 }]),
    ];
    for end in ["minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"] {
        let Some(end) = key.takes.get(end).and_then(Value::as_f64) else { continue };
        let step = if key.takes["type"] == "integer" { 1.0 } else { 1e-3 * end.abs().max(0.01) };
        probes.extend([-step, 0.0, step].map(|step| (end + step).written()));
    }
    probes.extend(key.takes["enum"].as_array().cloned().unwrap_or_default());
    probes
}

/// Mistakes that only a reader can detect: a missing file, the contents of another file, a rule about two keys, a
/// language inside a string.
const ONLY_THE_READER: [&str; 34] = [
    "actions.NAME.feedback",
    "actions.NAME.goal",
    "actions.NAME.result",
    "actions.NAME.ros",
    "base",
    "doors[].closed_s",
    "faults[].in_state",
    "faults[].times",
    "goal.bound",
    "goal.indifference",
    "leaves.NAME.action",
    "leaves.NAME.request",
    "leaves.NAME.topic",
    "model",
    "model.quantity",
    "parameters[]",
    "parameters[].from",
    "parameters[].key",
    "parameters[].name",
    "parameters[].normal.min",
    "parameters[].to",
    "people[].stands_s",
    "prove.messages.delay",
    "prove.messages.delay_s",
    "prove.properties",
    "repeats",
    "robot.lasers[]",
    "robot.lasers[].at",
    "services.NAME.reply",
    "services.NAME.request",
    "services.NAME.ros",
    "stop.after_s",
    "topics.NAME.fields",
    "topics.NAME.ros",
];

#[test]
#[ignore = "long: .ci/run runs it"]
fn schema_and_reader_agree_on_every_value_of_every_key() {
    let (kinds, scenarios) = (examples(), scenarios());
    let mut cases: Vec<(&Kind, Value, Key)> = Vec::new();
    for (kind, files) in &kinds {
        let mut tried = Vec::new();
        for file in files {
            assert!(matches!(kind.judged(file), Judged::Accepted), "{file}");
            // A file like one before, but for its component: the other keys have been tried.
            let mut others = file.clone();
            others.as_object_mut().unwrap().remove("components");
            let differs = |key: &&Key| key.path.starts_with("components.") || !tried.contains(&others);
            cases.extend(kind.keys.iter().filter(differs).map(|key| (kind, file.clone(), key.clone())));
            tried.push(others);
        }
    }
    for (parameters, file) in faults() {
        let own = parameters.iter().map(|parameter| in_fault(parameter.key()));
        let timing = scenarios.keys.iter().filter(|key| key.split().0 == "faults[]").cloned();
        for key in own.chain(timing) {
            let mut file = file.clone();
            if key.about.starts_with("Trigger") {
                let fault = file["faults"][0].as_object_mut().unwrap();
                fault.retain(|name, _| parameters.iter().any(|parameter| parameter.name == name) || name == "kind");
            }
            cases.push((&scenarios, file, key));
        }
    }
    let (mut tried, mut only_the_reader) = (0, BTreeMap::new());
    let threads = thread::available_parallelism().unwrap().get();
    thread::scope(|scope| {
        let part = |first: usize| cases.iter().skip(first).step_by(threads);
        let parts: Vec<_> = (0..threads).map(|first| scope.spawn(move || try_out(part(first)))).collect();
        for part in parts {
            let (more, refused) = part.join().unwrap();
            tried += more;
            only_the_reader.extend(refused);
        }
    });
    assert!(tried > 20_000, "{tried}");
    assert_eq!(only_the_reader.keys().collect::<Vec<_>>(), ONLY_THE_READER, "{only_the_reader:#?}");
}

/// Tries out each key with all [`probes`]. Returns how many files that were, and a problem of each key of which only
/// the reader knows that something is wrong.
fn try_out<'c>(cases: impl Iterator<Item = &'c (&'c Kind, Value, Key)>) -> (usize, BTreeMap<String, String>) {
    let (mut tried, mut only_the_reader) = (0, BTreeMap::new());
    for (kind, file, key) in cases {
        for file in probes(key).into_iter().filter_map(|probe| with(file, key, probe)) {
            tried += 1;
            if let Judged::RefusedByReader(problems) = kind.judged(&file) {
                only_the_reader.entry(key.path.clone()).or_insert_with(|| problems.plain());
            }
        }
    }
    (tried, only_the_reader)
}

fn in_fault(key: Key) -> Key {
    Key { path: format!("faults[].{}", key.path), ..key }
}

#[test]
fn a_scenario_with_a_base_may_change_part_of_a_component() {
    let changed = as_json("base = \"parcel\"\n[components.CallButton]\npressed_s = [9]");
    assert_eq!(problem(&scenarios().schema, &changed), None);
    let [_, _, whole, ..] = &examples()[0].1[..] else { panic!("there are examples") };
    let mut nothing = whole.clone();
    nothing["components"] = json!({ "A": { "pressed_s": [9] } });
    assert!(problem(&scenarios().schema, &nothing).is_some());
}

#[test]
fn every_shipped_file_is_valid() {
    let kind = scenarios();
    let paths: Vec<&str> = shipped_paths().filter(|path| path.starts_with("scenarios/")).collect();
    assert!(paths.len() > 60);
    for path in paths {
        let text = Files::shipped().read_text(Path::new(path)).unwrap();
        if let Some(error) = problem(&kind.schema, &as_json(&text)) {
            panic!("{path}: {error}");
        }
    }
    let kind = places();
    for path in shipped_paths().filter(|path| path.ends_with(".places.toml")) {
        let text = Files::shipped().read_text(Path::new(path)).unwrap();
        assert_eq!(problem(&kind.schema, &as_json(&text)), None, "{path}");
    }
    let kind = campaigns();
    for (name, text) in shipped_campaigns() {
        if let Some(error) = problem(&kind.schema, &as_json(text)) {
            panic!("{name}: {error}");
        }
    }
}

#[test]
fn interface_files_of_the_examples_are_valid() {
    let kind = interfaces();
    for text in [include_str!("../skills/examples/speaker.toml"), INTERFACES[0], INTERFACES[1]] {
        assert!(matches!(kind.judged(&as_json(text)), Judged::Accepted), "{text}");
    }
}

/// Files that other tests expect to be refused, as far as a schema can tell.
#[test]
fn broken_files_are_refused_by_both() {
    let refused = |kind: &Kind, file: &str| matches!(kind.judged(&as_json(file)), Judged::RefusedByBoth);
    let broken = |text: &str| refused(&scenarios(), &format!("base = \"nominal\"\n{text}"));
    for text in [
        "baterry = {}",
        "battery = { intial_pct = 80 }",
        "battery = { initial_pct = 180 }",
        "execution = { policy = \"fair\" }",
        "execution = { step_budget = 0 }",
        "expect = { phi1 = \"broken\" }",
        "faults = [{ kind = \"joipad\", at_s = 1 }]",
        "faults = [{ kind = \"joypad\" }]",
        "faults = [{ kind = \"joypad\", at_s = 1, near = \"start\" }]",
        "faults = [{ kind = \"joypad\", at_tick = 1, every_s = 3 }]",
        "faults = [{ kind = \"battery_level\", at_s = 1, level_pct = 10, lasts_s = 3 }]",
        "faults = [{ kind = \"battery_level\", at_s = 1 }]",
        "people = [{ at = [1, 2], speed_mps = 9 }]",
        "people = [{ at = [1, 2], follows = true, route = [[3, 4]] }]",
        "people = [{ at = [1, 2], distance_m = 2 }]",
        "seed = -1",
        "stop = { at = 3 }",
    ] {
        assert!(broken(text), "{text}");
    }
    assert!(refused(&scenarios(), "map = \"maps/house.yaml\""));
    let campaign = |text: &str| refused(&campaigns(), &format!("scenario = \"errand\"\n{text}"));
    for text in [
        "",
        "runs = 0",
        "runs = 10\nrepeats = 3",
        "sampling = \"grid\"\nruns = 10",
        "sampling = \"halton\"\nruns = 10",
        "runs = 10\nparameters = [{ key = \"seed\", from = 1, to = 2 }]",
        "sampling = \"random\"\nruns = 10\nparameters = [{ key = \"seed\", from = 1 }]",
        "sampling = \"random\"\nruns = 10\nparameters = [{ key = \"seed\", values = [] }]",
        "sampling = \"random\"\nruns = 10\nparameters = [{ key = \"seed\", from = 0, to = 2, scale = \"log\" }]",
        "goal = { estimate = \"phi1\", test = \"phi1\" }",
        "goal = { estimate = \"phi1\", half_width = 0.3, confidence = 0.9 }",
        "runs = 10\nmeasures = [\"speed\"]",
    ] {
        assert!(campaign(text), "{text}");
    }
    for text in [
        "service = {}",
        "services.say = { requests = {} }",
        "services.say.request.text = \"txet\"",
        "services.say.request.text = []",
        "services.say = { ros = \"p/srv/S.srv\", request = { a = [\"open\"] } }",
        "topics.said = { reply = {} }",
        "actions.go.goal = [\"place\"]",
        "packages = \"/opt\"",
    ] {
        assert!(refused(&interfaces(), text), "{text}");
    }
    for text in ["a = {}", "a.position_m = [0, 0]", "a = { corners_m = [[0, 0], [2, 0], [2, 2]], heading_deg = 0 }"] {
        assert!(refused(&places(), text), "{text}");
    }
}

#[test]
fn the_program_prints_the_schemas_that_the_repository_has() {
    for (name, file) in [
        ("scenario", "scenarios/scenario.schema.json"),
        ("campaign", "scenarios/campaigns/campaign.schema.json"),
        ("interface", "components/interfaces/interface.schema.json"),
        ("mapping", "ros/bags/mapping.schema.json"),
        ("places", "maps/places.schema.json"),
    ] {
        let printed = String::from_utf8(steward(&["schema", name]).stdout).unwrap();
        crate::reference::compare(file, &printed);
    }
}
