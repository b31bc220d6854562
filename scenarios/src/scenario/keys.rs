//! The keys of a scenario file: those that its reader [declares](Key::all), and descriptions of the others.

use devices::DeviceKind;
use serde_json::{Value, json};

use super::component_entry::{Form, forms};
use super::premises::ON_A_MAP;
use super::prove::{MEMORY_MB, STATES};
use super::robot::read_sim;
use crate::faults::KINDS;
use crate::schema::{
    Key, flag, json_schema, list, number, one_of, or, plain, point, points, pose, scalar, seconds, some_seconds, table,
    text, whole, with,
};

/// The triggers of a fault, of which it has exactly one.
const TRIGGERS: [&str; 5] = ["at_s", "at_tick", "near", "when", "in_state"];

/// The JSON schema of a scenario file.
#[must_use]
pub fn schema() -> Value {
    let needed = ON_A_MAP.map(|key| (key.to_owned(), json!(["map"])));
    let mut dependent: serde_json::Map<String, Value> = needed.into_iter().collect();
    dependent.insert("map".to_owned(), json!(["sites"]));
    let whole = json!({
        "required": ["tree", "skills"],
        "dependentRequired": dependent,
        "properties": {
            "sites": { "required": ["start"] },
            "components": { "additionalProperties": { "anyOf": COMPONENT_FORMS.map(|key| json!({ "required": [key] })) } },
        },
    });
    json_schema(
        "A scenario of steward",
        json!({ "anyOf": [{ "required": ["base"] }, { "required": ["model"] }, whole] }),
        &keys(),
    )
}

/// All keys of a scenario file except the parameters of its faults, which depend on their [kinds](KINDS).
#[must_use]
pub fn keys() -> Vec<Key> {
    let robot = Key::all(|root| drop(read_sim(root)));
    let parts = [files(), robot, execution(), world(), monitors(), faults(), ending(), prove()];
    parts.into_iter().flatten().collect()
}

fn names() -> Value {
    json!({ "title": "a name, or an array of names", "anyOf": [text(), { "type": "array", "items": text() }] })
}

fn name() -> Value {
    with(text(), json!({ "minLength": 1 }))
}

fn files() -> Vec<Key> {
    let start =
        json!({ "title": "the name of a point, or [x, y, heading] in meters and degrees", "anyOf": [text(), pose()] });
    vec![
        Key::new(
            "base",
            "Another scenario, as a file or by its name. This one inherits everything that it does not set itself. \
             An array is inherited as a whole or not at all. Inherited paths are relative to the file that \
             writes them, or to this one if there is nothing.",
            text(),
        ),
        Key::new("about", "What the scenario shows, on one line.", or(text(), "")),
        Key::new(
            "seed",
            "The root seed unless `--seed` gives one. All random numbers of a run are derived from it.",
            or(whole(0), 1),
        ),
        Key::new(
            "folder",
            "The folder in which the scenario's other files are looked up first, instead of its own. It does not apply to \
             the files of a base in another folder.",
            text(),
        ),
        Key::new(
            "map",
            "The map: a YAML file in the format of ROS's `map_server`. Without a map, there is no robot: tree, skills \
             and components run on their own.",
            text(),
        ),
        Key::new("places", "The places on the map: a TOML file, or a locations file of YARP (`.ini`).", text()),
        Key::new(
            "model",
            "A RoAML model: its main file. It replaces `tree`, `skills`, `leaves` and `components`, and has no map. \
             It also gives `execution.tick_s` and `execution.max_time_s`, unless they are set.",
            text(),
        ),
        Key::new(
            "tree",
            "The behavior tree: an XML file of BehaviorTree.CPP. Required unless there is a `base` or a `model`.",
            text(),
        ),
        Key::new(
            "skills",
            "The folder of the SCXML machines that carry out the tree's leaves. Required unless there is a `base` or a \
             `model`.",
            text(),
        ),
        Key::new(
            "properties",
            "The property files. Each of their properties is monitored.",
            list("an array of strings", &text()),
        ),
        Key::new("leaves", "Settings of the tree's leaves that differ from the defaults.", table(json!({}))),
        Key::new("leaves.NAME", "A leaf of the tree, by the name of its process.", table(json!({}))),
        Key::new(
            "leaves.NAME.machine",
            "The file of the leaf's machine, in the folder `skills`. If not given, `NAME.scxml` or `ID.scxml`.",
            text(),
        ),
        Key::new("leaves.NAME.data", "Initial values of the machine's data.", table(json!({}))),
        Key::new("leaves.NAME.data.ID", "The initial value of `<data id=\"ID\">`.", scalar()),
        Key::new("sites", "The places that the scenario needs. Required if there is a map.", table(json!({}))),
        Key::new("sites.start", "Where the robot starts. Required if there is a map.", start),
        Key::new(
            "sites.station",
            "The point at which the charging station stands. Without it, the battery is never charged.",
            text(),
        ),
        Key::new("sites.destination", "The place to which the robot is sent, for pictures.", text()),
    ]
}

/// The keys that say what a component runs.
const COMPONENT_FORMS: [&str; 3] = ["machine", "program", "builtin"];

/// A component has at most one form, the rest being in its base, and the keys of that form.
fn component_forms() -> Value {
    let form = |(key, kind, _, keys): Form| {
        let is_kind = kind.map_or_else(|| json!(true), |kind| json!({ "const": kind.name() }));
        json!({
            "if": { "required": [key], "properties": { (key): is_kind } },
            "then": { "propertyNames": { "enum": keys } },
        })
    };
    let both = [[0, 1], [0, 2], [1, 2]].map(|pair| json!({ "required": pair.map(|form| COMPONENT_FORMS[form]) }));
    json!({ "not": { "anyOf": both }, "allOf": forms().map(form).collect::<Vec<_>>() })
}

fn execution() -> Vec<Key> {
    let least_tick = json!({ "type": "number", "minimum": 0.02, "maximum": 1_000_000_000 });
    vec![
        Key::new("components", "The components that skills ask, by the name of their process.", table(json!({}))),
        Key::new(
            "components.NAME",
            "A component that answers others: an SCXML machine, a program, or a device of the world.",
            table(component_forms()),
        ),
        Key::new("components.NAME.machine", "The file of its machine.", text()),
        Key::new(
            "components.NAME.program",
            "A program instead of a machine: a path relative to the folder of the file that sets it or a name on the \
             `PATH`, followed by its arguments.",
            list("an array of strings", &text()),
        ),
        Key::new(
            "components.NAME.answer_within_s",
            "How long a program may take to answer, in seconds of real time.",
            or(some_seconds(), 10),
        ),
        Key::new(
            "components.NAME.memory_mb",
            "The address space that each process of a program may use, in MiB.",
            or(json!({ "type": "integer", "minimum": 1, "maximum": 1 << 20 }), 1024),
        ),
        Key::new(
            "components.NAME.asks",
            "The components that a program asks, or whose topics it reads.",
            list("an array of strings", &text()),
        ),
        Key::new(
            "components.NAME.builtin",
            "A device of the world instead of a machine. Its interface is fixed.",
            one_of(&DeviceKind::ALL.map(DeviceKind::name)),
        ),
        Key::new("components.NAME.door", "For a door: its name in the world.", text()),
        Key::new(
            "components.NAME.within_m",
            "For a people sensor: its range from the robot's center, in meters.",
            or(number(0.1, 100.0), 5),
        ),
        Key::new(
            "components.NAME.only",
            "For a people sensor: the people that it detects; everyone if empty.",
            or(list("an array of strings", &text()), json!([])),
        ),
        Key::new(
            "components.NAME.letters_per_s",
            "For a speaker: how fast it speaks, in letters per second.",
            or(number(0.1, 1000.0), 15),
        ),
        Key::new(
            "components.NAME.pressed_s",
            "For a button: the times at which it is pressed, in seconds.",
            or(list("an array of times in seconds", &seconds()), json!([])),
        ),
        Key::new("components.NAME.hears[]", "For a microphone: a request that it hears.", table(json!({}))),
        Key::new("components.NAME.hears[].at_s", "When, in seconds.", seconds()).required(),
        Key::new("components.NAME.hears[].text", "What somebody says.", with(name(), json!({ "maxLength": 1000 })))
            .required(),
        Key::new(
            "components.NAME.reach_m",
            "For a tray: the maximum distance of a box from the robot's edge, in meters.",
            or(number(0.0, 5.0), 0.8),
        ),
        Key::new("components.NAME.data", "Initial values of the machine's data.", table(json!({}))),
        Key::new(
            "components.NAME.data.ID",
            "The initial value of `<data id=\"ID\">`; for a program, a value that it receives when it starts.",
            scalar(),
        ),
        Key::new(
            "components.NAME.interface",
            "The file with its interface: its services, topics and actions. Needed if others ask it \
             or read its topics.",
            text(),
        ),
        Key::new("execution", "How tree, skills and components run.", table(json!({}))),
        Key::new("execution.tick_s", "Time between ticks of the tree, in seconds.", or(least_tick, 1)),
        Key::new(
            "execution.tree",
            "The tree as one process (`whole`), or one process per node with handshakes (`nodes`), as in the paper.",
            or(one_of(&["whole", "nodes"]), "whole"),
        ),
        Key::new(
            "execution.schedule",
            "A file with a schedule, as `steward prove --out` writes it. The run follows the schedule step by step, \
             without drivers and physics.",
            text(),
        ),
        Key::new(
            "execution.policy",
            "How the next enabled transition is chosen: at random (`random`), or from each process in turn \
             (`round-robin`).",
            or(one_of(&["random", "round-robin"]), "random"),
        ),
        Key::new(
            "execution.stops",
            "What a stop request to the built-in Navigation ends: the trip to its own place (`own-trip`), or any trip, \
             as in the paper's published system (`any-trip`).",
            or(one_of(&["own-trip", "any-trip"]), "own-trip"),
        ),
        Key::new("execution.starve", "This process moves only when no other can.", text()),
        Key::new("execution.order[]", "A message is received only after another one.", table(json!({}))),
        Key::new(
            "execution.order[].first",
            "The message that comes first: an event of the SCOPE language, or several joined by `or`.",
            text(),
        )
        .required(),
        Key::new("execution.order[].then", "The message that waits for it.", text()).required(),
        Key::new(
            "execution.leaf_timeout_s",
            "The time, in seconds, after which a leaf that has not answered the tree counts as failed or, if it was \
             told to halt, as halted.",
            or(some_seconds(), 2),
        ),
        Key::new("execution.max_time_s", "The latest end of the run, in simulated seconds.", or(some_seconds(), 3600)),
        Key::new(
            "execution.step_budget",
            "The maximum number of transitions in one step. Beyond it, the run ends because the system never becomes \
             quiet.",
            or(whole(1), 100_000),
        ),
        Key::new(
            "execution.run_budget",
            "The maximum number of messages in a run, which is then stopped.",
            or(whole(1), 10_000_000),
        ),
    ]
}

fn world() -> Vec<Key> {
    let side = |default| or(number(0.05, 20.0), default);
    let span = json!({ "type": "array", "items": { "type": "number", "minimum": 0 }, "minItems": 1, "maxItems": 2 });
    let spans = || or(list("[[from, to], …] in seconds", &span), json!([]));
    let following = ["distance_m", "meets_within_m", "stands_s"];
    let of_followers = [&["name", "at", "radius_m", "speed_mps", "follows"], &following[..]].concat();
    let kinds = json!({
        "if": { "required": ["follows"], "properties": { "follows": { "const": true } } },
        "then": { "propertyNames": { "enum": of_followers } },
        "else": { "propertyNames": { "not": { "enum": following } } },
    });
    let meters = |default| or(number(0.1, 20.0), plain(default));
    vec![
        Key::new(
            "people[]",
            "Somebody who stands, walks along a route, or with `follows` follows the robot.",
            table(kinds),
        ),
        Key::new("people[].name", "The name in reports. If not given, `person 1`, `person 2`, …", name()),
        Key::new("people[].at", "The person's initial position.", point()).required(),
        Key::new("people[].radius_m", "Radius of the body, in meters.", or(number(0.05, 1.0), 0.25)),
        Key::new(
            "people[].route",
            "The points to which the person walks, each in a straight line. Without any, the person stands still.",
            or(points(), json!([])),
        ),
        Key::new(
            "people[].then",
            "At the end of the route: walk it `back`, go `around` to its beginning, or `stop`.",
            or(one_of(&["back", "around", "stop"]), "back"),
        ),
        Key::new(
            "people[].speed_mps",
            "Walking speed, in meters per second; the maximum speed of somebody who follows the robot.",
            or(number(0.05, 3.0), 0.8),
        ),
        Key::new("people[].sets_out_s", "The time at which the person sets out, in seconds.", or(seconds(), 0)),
        Key::new("people[].pause_s", "How long the person pauses, in seconds.", or(seconds(), 0)),
        Key::new(
            "people[].pauses",
            "Where the person pauses: at every point of the route, or only at its `ends`.",
            or(one_of(&["waypoints", "ends"]), "waypoints"),
        ),
        Key::new("people[].gives_way", "Whether the person waits for the robot, or walks into it.", or(flag(), true)),
        Key::new(
            "people[].patience_s",
            "After this time, in seconds, a blocked person steps aside to clear the robot's path, or turns back.",
            or(seconds(), 3),
        ),
        Key::new(
            "people[].follows",
            "Whether the person follows the robot after meeting it. Such a person has no `route`.",
            or(flag(), false),
        ),
        Key::new(
            "people[].distance_m",
            "With `follows`: the distance that the person keeps from the robot's center, in meters.",
            meters(1.2),
        ),
        Key::new(
            "people[].meets_within_m",
            "With `follows`: the maximum distance from the robot's center at which they meet, in meters. Nothing may \
             be between them.",
            meters(2.0),
        ),
        Key::new(
            "people[].stands_s",
            "With `follows`: when the person stands still and falls behind, in seconds. `[from]` lasts to the end of \
             the run.",
            spans(),
        ),
        Key::new("doors[]", "A door, which never closes onto the robot.", table(json!({}))),
        Key::new("doors[].name", "The name in reports. If not given, `door 1`, `door 2`, …", name()),
        Key::new("doors[].at", "The middle of the closed door.", pose()).required(),
        Key::new("doors[].width_m", "Its width, in meters.", or(number(0.1, 20.0), 1)),
        Key::new(
            "doors[].opens",
            "How it opens: it slides, or swings to one side.",
            or(one_of(&["slide", "left", "right"]), "slide"),
        ),
        Key::new("doors[].moves_s", "How long it takes to open or close, in seconds.", or(seconds(), 2)),
        Key::new("doors[].closed_s", "When it is closed, in seconds. `[from]` lasts to the end of the run.", spans()),
        Key::new(
            "doors[].every_s",
            "The time after which `closed_s` repeats, in seconds. Without it, it never does.",
            some_seconds(),
        ),
        Key::new("boxes[]", "A box that is not on the map.", table(json!({}))),
        Key::new("boxes[].name", "The name in reports. If not given, `box 1`, `box 2`, …", name()),
        Key::new("boxes[].at", "The middle of the box.", pose()).required(),
        Key::new("boxes[].length_m", "Length, in meters.", side(0.6)),
        Key::new("boxes[].width_m", "Width, in meters.", side(0.4)),
        Key::new("boxes[].mass_kg", "Mass, in kilograms.", or(number(0.1, 1000.0), 10)),
        Key::new("boxes[].fixed", "Whether it stays where it is. Otherwise, the robot can push it.", or(flag(), false)),
    ]
}

fn monitors() -> Vec<Key> {
    let kinds = json!({
        "if": { "required": ["figure"] },
        "then": { "propertyNames": { "enum": ["name", "figure"] } },
        "else": { "required": ["machine", "violated_in", "events"] },
    });
    vec![
        Key::new(
            "monitors[]",
            "A monitor that is not made from a property: an SCXML machine or, with `figure`, one of the paper's.",
            table(kinds),
        ),
        Key::new("monitors[].name", "The monitor's name. If not given, that of the machine or figure.", text()),
        Key::new("monitors[].figure", "The monitor of the paper's Figure 5 (a) or (b).", one_of(&["5 (a)", "5 (b)"])),
        Key::new("monitors[].machine", "The SCXML file. Required without `figure`.", text()),
        Key::new(
            "monitors[].violated_in",
            "The states that indicate a violation, which is final even if the machine leaves them at once. Required \
             with `machine`.",
            names(),
        ),
        Key::new(
            "monitors[].pending_in",
            "The states in which the verdict is inconclusive if the run ends there.",
            names(),
        ),
        Key::new(
            "monitors[].events[]",
            "The messages that become events of the machine. Required with `machine`.",
            table(json!({})),
        ),
        Key::new("monitors[].events[].event", "The event's name.", text()).required(),
        Key::new(
            "monitors[].events[].when",
            "The messages: an event of the SCOPE language, or several joined by `or`.",
            text(),
        )
        .required(),
        Key::new("monitors[].events[].data", "The values of `_event.data`.", table(json!({}))),
        Key::new(
            "monitors[].events[].data.NAME",
            "The value of `_event.data.NAME`. `m[1]`, `m[2]`, … are fields of the message.",
            scalar(),
        ),
    ]
}

fn faults() -> Vec<Key> {
    let mut keys = vec![
        Key::new(
            "faults[].kind",
            "What goes wrong. `steward faults` lists the kinds, and `steward faults KIND` the parameters of one.",
            with(
                one_of(&KINDS.iter().map(|kind| kind.name).collect::<Vec<_>>()),
                json!({ "title": "the name of a kind" }),
            ),
        )
        .required(),
        Key::new("faults[].at_s", "Trigger: the fault takes effect at this time, in seconds.", seconds()),
        Key::new("faults[].at_tick", "Trigger: when this tick has been generated.", whole(0)),
        Key::new("faults[].near", "Trigger: when the robot comes near this place.", text()),
        Key::new(
            "faults[].when",
            "Trigger: when such a message has been received: an event of the SCOPE language, or several joined by \
             `or`.",
            text(),
        ),
        Key::new(
            "faults[].in_state",
            "Trigger: when a skill enters a state.",
            with(text(), json!({ "title": "`SKILL.STATE`" })),
        ),
        Key::new("faults[].within_m", "With `near`: how near, in meters.", or(number(0.0, 1e6), 1)),
        Key::new(
            "faults[].probability",
            "The probability that the fault takes effect when it is triggered.",
            or(number(0.0, 1.0), 1),
        ),
        Key::new(
            "faults[].lasts_s",
            "How long it lasts, in seconds. Without it, the fault lasts to the end of the run. A momentary fault \
             cannot last.",
            some_seconds(),
        ),
        Key::new("faults[].every_s", "With `at_s`: the fault repeats after this time, in seconds.", some_seconds()),
        Key::new(
            "faults[].times",
            "The maximum number of times that it takes effect. By default once; with `every_s`, without limit.",
            with(whole(1), json!({ "maximum": 1_000_000_000 })),
        ),
    ];
    let timing: Vec<&str> = keys.iter().map(|key| key.split().1).collect();
    let kinds = KINDS.iter().map(|kind| {
        let shared = timing
            .iter()
            .filter(|key| !(kind.momentary && **key == "lasts_s"))
            .map(|key| ((*key).to_owned(), json!(true)));
        let own = kind.parameters.iter().map(|parameter| {
            let key = parameter.key();
            (key.path, with(key.takes, json!({ "description": key.about })))
        });
        let needed =
            kind.parameters.iter().filter(|parameter| parameter.key().required).map(|parameter| parameter.name);
        json!({
            "if": { "properties": { "kind": { "const": kind.name } } },
            "then": {
                "description": kind.about,
                "properties": shared.chain(own).collect::<Value>(),
                "required": needed.collect::<Vec<_>>(),
                "additionalProperties": false,
            },
        })
    });
    let fault = json!({
        "type": "object",
        "oneOf": TRIGGERS.map(|trigger| json!({ "required": [trigger] })),
        "dependentRequired": { "every_s": ["at_s"], "within_m": ["near"] },
        "allOf": kinds.collect::<Vec<_>>(),
    });
    keys.insert(
        0,
        Key::new(
            "faults[]",
            "Something that goes wrong: its kind with the parameters of that kind, and one trigger.",
            fault,
        ),
    );
    keys
}

fn ending() -> Vec<Key> {
    let violation = json!({
        "title": "true, false, the name of a property, or an array of names",
        "anyOf": [flag(), text(), { "type": "array", "items": text() }],
    });
    let moments = ["start", "fault", "verdict", "arrival", "end"];
    let snapshots = json!({ "type": "number", "minimum": 0.02, "maximum": 1_000_000_000 });
    let places = || list("an array of names", &text());
    vec![
        Key::new("stop", "When the run ends before `execution.max_time_s`: at the first of these.", table(json!({}))),
        Key::new("stop.at", "When the robot has come to rest at this place, or at one of several.", names()),
        Key::new(
            "stop.on_violation",
            "When a property is violated: any (`true`), or one of those named. Without monitors, the run continues.",
            or(violation, false),
        ),
        Key::new("stop.when_settled", "When every property has a final verdict.", or(flag(), false)),
        Key::new("stop.after_s", "How long the run continues after that, in seconds.", or(seconds(), 0)),
        Key::new("snapshots", "When pictures are taken.", table(json!({}))),
        Key::new(
            "snapshots.at",
            "On these occasions.",
            or(list("an array of start, fault, verdict, arrival, end", &one_of(&moments)), json!([])),
        ),
        Key::new(
            "snapshots.at_s",
            "At these times, in seconds.",
            or(list("an array of numbers", &seconds()), json!([])),
        ),
        Key::new("snapshots.every_s", "Repeatedly, at intervals of this many seconds.", snapshots),
        Key::new(
            "expect",
            "The expected outcome of the run. The exit status says whether the run met it.",
            table(json!({})),
        ),
        Key::new(
            "expect.PROPERTY",
            "The expected verdict of a property.",
            one_of(&["satisfied", "violated", "inconclusive"]),
        ),
        Key::new("expect.reached", "Places where the robot must have come to rest.", or(places(), json!([]))),
        Key::new(
            "expect.not_reached",
            "Places where the robot must never have been, not even on its way: in no step was its true position within \
             the area, or within the tolerance of the point (with any heading).",
            or(places(), json!([])),
        ),
        Key::new(
            "expect.failed_programs",
            "Components whose program must fail. If another program fails, the run is not as expected.",
            or(list("an array of names", &text()), json!([])),
        ),
        Key::new("expect.max_collisions", "The maximum number of collisions.", whole(0)),
        Key::new("expect.min_battery_pct", "The minimum charge of the battery, in percent.", number(0.0, 100.0)),
        Key::new("expect.max_localization_m", "The maximum localization error, in meters.", number(0.0, 1e6)),
    ]
}

fn prove() -> Vec<Key> {
    let names = || list("an array of names", &text());
    let per_tick = || number(0.0, 100.0);
    let level = json!({
        "title": "a number from 0 to 100, or [lowest, highest]",
        "anyOf": [per_tick(), { "type": "array", "items": per_tick(), "minItems": 2, "maxItems": 2 }],
    });
    let count = || or(with(whole(0), json!({ "maximum": 9 })), 0);
    let one_or_more = || json!({ "title": "a name, or an array of names", "anyOf": [text(), names()] });
    let ends = json!({ "type": "array", "items": text(), "minItems": 2, "maxItems": 2 });
    let passes = json!({ "title": "`\"any\"`, a name, or an array of names", "anyOf": [text(), names()] });
    vec![
        Key::new("prove", "What `steward prove` assumes and proves.", table(json!({}))),
        Key::new(
            "prove.properties",
            "The properties to prove. If not given, all of them. `progress` (no deadlock and no livelock) is always \
             among them.",
            one_or_more(),
        ),
        Key::new(
            "prove.memory_mb",
            "How much memory the proof of a property may take, in MiB.",
            or(with(whole(1), json!({ "maximum": 1 << 20 })), MEMORY_MB),
        ),
        Key::new(
            "prove.states",
            "How many states the proof of a property may visit, over all its rounds. Then it is not decided.",
            or(with(whole(1), json!({ "maximum": 1_u64 << 40 })), STATES),
        ),
        Key::new(
            "prove.threads",
            "How many threads explore. If not given, one per core. The result does not depend on it.",
            with(whole(1), json!({ "maximum": 1024 })),
        ),
        Key::new("prove.battery", "How the battery's level may change.", table(json!({}))),
        Key::new(
            "prove.battery.drain_pct_per_tick",
            "The maximum fall of the level per tick, in percent; it rises only at the charging station. Without it, \
             the level may jump to any value at any time.",
            per_tick(),
        ),
        Key::new(
            "prove.battery.charge_pct_per_tick",
            "The minimum rise of the level, in percent, in a tick throughout which the battery is charging.",
            or(per_tick(), 0),
        ),
        Key::new(
            "prove.battery.start_pct",
            "The level at the start, in percent. If not given, `battery.initial_pct`.",
            level,
        ),
        Key::new("prove.trips", "What the trips of the built-in Navigation may do.", table(json!({}))),
        Key::new(
            "prove.trips.ticks",
            "A trip ends before this number of ticks has passed since its start. Without it, a trip may take forever.",
            with(whole(1), json!({ "maximum": 10_000 })),
        ),
        Key::new("prove.trips.fail", "Whether trips may fail.", or(flag(), true)),
        Key::new(
            "prove.trips.passes",
            "The places that the robot may pass during a trip, besides its start and its goal.",
            or(passes, json!([])),
        ),
        Key::new("prove.messages", "What may happen to messages in transit.", table(json!({}))),
        Key::new("prove.messages.lose", "The maximum number of messages of a run that may be lost.", count()),
        Key::new(
            "prove.messages.repeat",
            "The maximum number of messages of a run that may be delivered twice.",
            count(),
        ),
        Key::new("prove.messages.delay", "The maximum number of messages of a run that may be delayed.", count()),
        Key::new(
            "prove.messages.delay_s",
            "How long a delayed message is held back, in seconds.",
            or(some_seconds(), 1),
        ),
        Key::new(
            "prove.messages.on",
            "The channels on which this may happen, by sender and receiver. If not given, all of them.",
            or(list("[[from, to], …]", &ends), json!([])),
        ),
        Key::new("prove.faults", "Faults that may begin and end at any time.", table(json!({}))),
        Key::new(
            "prove.faults.count",
            "The maximum number of faults in a run.",
            or(with(whole(1), json!({ "maximum": 9 })), 1),
        ),
        Key::new(
            "prove.faults.component_crash",
            "Components that may crash, and restart.",
            or(one_or_more(), json!([])),
        ),
        Key::new(
            "prove.faults.component_frozen",
            "Components that may hang, and continue later.",
            or(one_or_more(), json!([])),
        ),
        Key::new(
            "prove.faults.component_wrong_reply",
            "Components that may report the opposite of the truth.",
            or(one_or_more(), json!([])),
        ),
        Key::new(
            "prove.faults.skill_mutant",
            "Mistakes that skills may have, as `steward skill mutants` lists them.",
            or(one_or_more(), json!([])),
        ),
        Key::new(
            "prove.drivers",
            "When the drivers of the built-in components exchange data with them: between the steps of a run \
             (`between-steps`), as in the simulation, or also while processes communicate (`anywhere`).",
            or(one_of(&["between-steps", "anywhere"]), "between-steps"),
        ),
        Key::new(
            "prove.components",
            "Machines that replace components, by the name of the component.",
            table(json!({})),
        ),
        Key::new("prove.components.NAME", "A component that a proof replaces by a machine.", table(json!({}))),
        Key::new(
            "prove.components.NAME.machine",
            "The file of the machine. It has the component's interface, and may do everything that the component may \
             do.",
            text(),
        )
        .required(),
        Key::new("prove.expect", "The expected results of the properties; `proved` by default.", table(json!({}))),
        Key::new(
            "prove.expect.PROPERTY",
            "The expected result of a property, of `progress` (no deadlock and no livelock), or of `all_reached` \
             (every node is ticked, succeeds and fails in some run, and every state and transition of every machine \
             is reached). \
             `all_reached` counts only if it is named.",
            one_of(&["proved", "violated"]),
        ),
    ]
}
