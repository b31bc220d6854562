//! Devices in runs: under every policy, with faults, and in a world. What they answer is tested beside their code.

use std::fmt::Write;
use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::{problems, report};

/// A leaf: its name, the component, the request, the text of the request, and the condition that the answer must meet.
type Asks<'a> = (&'a str, &'a str, &'a str, &'a str, &'a str);

/// A skill that asks a device at every tick, until the condition holds.
fn skill((name, component, request, text, condition): Asks<'_>) -> String {
    let param = if text.is_empty() { String::new() } else { format!("<param name=\"text\" expr=\"'{text}'\"/>") };
    format!(
        r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="{name}">
  <state id="idle">
    <transition event="BT.tick" target="asking"/>
    <transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition>
  </state>
  <state id="asking">
    <onentry><send type="channel" target="{component}" event="{request}">{param}</send></onentry>
    <transition event="BT.halt" target="idle"><send type="channel" target="BT" event="halted"/></transition>
    <transition event="{component}.ok" cond="{condition}" target="idle">
      <send type="channel" target="BT" event="success"/>
    </transition>
    <transition event="{component}.ok" target="idle"><send type="channel" target="BT" event="running"/></transition>
    <transition event="{component}.error" target="idle"><send type="channel" target="BT" event="failure"/></transition>
  </state>
</scxml>"#
    )
}

/// A folder with a scenario in this world whose tree runs these leaves one after the other. The property `done` holds
/// if the last one succeeds. `devices.toml` is the scenario with these additional lines.
fn folder(world: &str, leaves: &[Asks<'_>], more: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("skills")).unwrap();
    let (mut nodes, mut models) = (String::new(), String::new());
    for leaf in leaves {
        let name = leaf.0;
        fs::write(folder.path().join(format!("skills/{name}.scxml")), skill(*leaf)).unwrap();
        write!(nodes, "<{name}/>").unwrap();
        write!(models, "<Action ID=\"{name}\"/>").unwrap();
    }
    let tree = format!(
        "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\"><SequenceWithMemory>{nodes}</SequenceWithMemory>\
         </BehaviorTree><TreeNodesModel>{models}</TreeNodesModel></root>"
    );
    fs::write(folder.path().join("tree.xml"), tree).unwrap();
    let (last, ..) = leaves.last().unwrap();
    let property = format!("property done := eventually ({last}, BT, m[1] = <success>)");
    fs::write(folder.path().join("done.scope"), property).unwrap();
    let sound = format!("tree = \"tree.xml\"\nskills = \"skills\"\nproperties = [\"done.scope\"]\n{world}");
    fs::write(folder.path().join("sound.toml"), sound).unwrap();
    fs::write(folder.path().join("devices.toml"), format!("base = \"sound.toml\"\n{more}")).unwrap();
    folder
}

fn run(folder: &TempDir, set: &[&str]) -> Value {
    report(folder.path().join("devices.toml"), set)
}

/// Whether the last leaf has succeeded.
fn is_done(report: &Value) -> bool {
    report["monitors"][0]["verdict"] == "satisfied"
}

const CALLED: &[Asks<'_>] = &[
    ("AwaitCall", "CallButton", "get_press", "", "_event.data.pressed"),
    ("HearRequest", "Microphone", "get_request", "", "_event.data.text == 'to the exit'"),
    ("Say", "Speaker", "say", "Follow me.", "true"),
];

/// A guide without a world: a person presses a button, and asks for the exit.
fn called(more: &str) -> TempDir {
    let devices = r#"
execution.max_time_s = 30
[components.CallButton]
builtin = "button"
pressed_s = [4.5]
[components.Microphone]
builtin = "microphone"
hears = [{ at_s = 2, text = "hello" }, { at_s = 8.5, text = "to the exit" }]
[components.Speaker]
builtin = "speaker"
letters_per_s = 10
"#;
    folder(devices, CALLED, more)
}

#[test]
fn a_button_a_microphone_and_a_speaker_need_no_robot() {
    let folder = called("");
    for policy in ["policy=random", "policy=round-robin", "starve=Speaker", "tree=nodes"] {
        let report = run(&folder, &[&format!("execution.{policy}")]);
        assert!(is_done(&report), "{policy}: {report}");
        let [speech] = &report["said"].as_array().unwrap()[..] else { panic!("{report}") };
        assert_eq!((&speech["by"], &speech["text"]), (&"Speaker".into(), &"Follow me.".into()));
        // It records the request at 8.5 s, and the skill asks for it at the next tick.
        assert_eq!(speech["time_s"], 9.02, "{policy}");
    }
}

#[test]
fn faults_of_components_affect_devices() {
    for (fault, is_to_be_done) in [
        ("kind = \"component_crash\"\ncomponent = \"CallButton\"\nat_s = 4\nlasts_s = 2", false),
        ("kind = \"component_crash\"\ncomponent = \"CallButton\"\nat_s = 1\nlasts_s = 2", true),
        ("kind = \"component_frozen\"\ncomponent = \"Speaker\"\nat_s = 5", false),
        ("kind = \"component_slow\"\ncomponent = \"Microphone\"\nat_s = 5\ndelay_s = 0.5", true),
        // It is deaf when the button is pressed, and hangs when it could notice.
        (
            "kind = \"device_deaf\"\ncomponent = \"CallButton\"\nat_s = 4\nlasts_s = 2\n\
             [[faults]]\nkind = \"component_frozen\"\ncomponent = \"CallButton\"\nat_s = 4\nlasts_s = 4",
            false,
        ),
        ("kind = \"message_lost\"\nfrom = \"Speaker\"\nto = \"Say\"\nat_s = 0", false),
    ] {
        let report = run(&called(&format!("[[faults]]\n{fault}")), &[]);
        assert_eq!(is_done(&report), is_to_be_done, "{fault}: {report}");
    }
}

#[test]
fn each_spoken_text_is_reported_once() {
    let twice: &[Asks<'_>] =
        &[("Say", "Speaker", "say", "Hello", "true"), ("Again", "Speaker", "say", "Hello", "true")];
    let world = "execution.max_time_s = 4\n[components.Speaker]\nbuiltin = \"speaker\"\nletters_per_s = 10";
    let times = |more: &str| -> Vec<f64> {
        let report = run(&folder(world, twice, more), &[]);
        report["said"].as_array().unwrap().iter().map(|speech| speech["time_s"].as_f64().unwrap()).collect()
    };
    let sound = times("");
    assert!(sound.len() > 2, "{sound:?}");
    let muted = "[[faults]]\nkind = \"speaker_mute\"\ncomponent = \"Speaker\"\nat_s = 0.2\nlasts_s = 0.1";
    assert_eq!(times(muted), sound, "an interruption does not count as a second speech");
}

/// A robot that stands at the start in a world with a door, a box and two people, one of them behind a wall.
const WORLD: &str = r#"
base = "errand"
execution.max_time_s = 40
stop.at = []
[[doors]]
name = "gate"
at = [3.0, 0.0, 90]
moves_s = 4
closed_s = [[0]]
[[boxes]]
name = "parcel"
at = [0.7, 0.0, 0]
length_m = 0.3
width_m = 0.3
[[people]]
name = "Ann"
at = [0.0, 0.9]
[[people]]
name = "Ben"
at = [-12.0, 14.0]
[components.Gate]
builtin = "door"
door = "gate"
[components.Eyes]
builtin = "people"
within_m = 50
[components.Tray]
builtin = "tray"
"#;

#[test]
fn people_count_if_they_are_in_view() {
    let sees = |condition: &str, more: &str| {
        let leaves: &[Asks<'_>] = &[("Look", "Eyes", "get_people", "", condition)];
        is_done(&run(&folder(WORLD, leaves, more), &[]))
    };
    let ann = "_event.data.count == 1 &amp;&amp; Math.abs(_event.data.nearest_m - 0.9) &lt; 0.05";
    assert!(sees(ann, ""));
    assert!(!sees("_event.data.count == 2", ""));
    assert!(sees(
        "_event.data.count == 0 &amp;&amp; _event.data.nearest_m == 50",
        "[components.Eyes]\nonly = [\"Ben\"]"
    ));
    assert!(sees("_event.data.count == 0", "[[faults]]\nkind = \"device_deaf\"\ncomponent = \"Eyes\"\nat_s = 0"));
}

#[test]
fn a_tray_takes_what_is_in_reach_and_in_view() {
    let take: &[Asks<'_>] = &[("Take", "Tray", "take", "", "_event.data.box == 'parcel'")];
    assert!(is_done(&run(&folder(WORLD, take, ""), &[])));
    let far = "[components.Tray]\nreach_m = 0.1";
    assert!(!is_done(&run(&folder(WORLD, take, far), &[])));
    let closed = "[[doors]]\nname = \"gate\"\nat = [0.4, 0.0, 90]\nclosed_s = [[0]]";
    assert!(!is_done(&run(&folder(WORLD, take, closed), &[])), "a closed door is in between");
    let empty = "[[faults]]\nkind = \"box_dropped\"\ncomponent = \"Tray\"\nat_s = 0";
    let report = run(&folder(WORLD, take, empty), &[]);
    assert_eq!(report["undone_faults"][0]["reason"], "there is no box on the tray", "{report}");
}

fn has_one_problem(folder: &TempDir, message: &str) {
    let said = problems(folder.path().join("devices.toml"), &[]);
    assert_eq!(said.len(), 1, "{said:#?}");
    assert!(said[0].contains(message), "{message}: {said:#?}");
}

#[test]
fn each_mistake_has_one_message() {
    for (more, message) in [
        ("[components.Lamp]\nbuiltin = \"lamp\"", "`builtin` cannot be `lamp`"),
        ("[components.Gate]\nbuiltin = \"door\"\ndoor = \"gate\"", "a door needs a world with a robot"),
        ("[components.Horn]\nbuiltin = \"speaker\"\npressed_s = [1]", "`pressed_s` has no meaning for a speaker"),
        (
            "[components.Horn]\nbuiltin = \"speaker\"\ninterface = \"x.toml\"",
            "`interface` has no meaning for a speaker",
        ),
        ("[components.Horn]\nbuiltin = \"speaker\"\nmachine = \"x.scxml\"", "has both a `builtin` and a `machine`"),
        ("[components.Bell]\nbuiltin = \"button\"\npressed_s = [-1]", "a number of seconds from 0 to 1e9"),
        (
            "[components.Ear]\nbuiltin = \"microphone\"\nhears = [{ at_s = 1, text = \"\" }]",
            "`text` must have 1 to 1000 letters",
        ),
        ("[components.Ear]\nbuiltin = \"microphone\"\nhears = [{ at_s = 1 }]", "`text`"),
        (
            "[[faults]]\nkind = \"device_deaf\"\ncomponent = \"Speaker\"\nat_s = 1",
            "cannot have the fault `device_deaf`",
        ),
        ("[[faults]]\nkind = \"speaker_mute\"\ncomponent = \"Spaeker\"\nat_s = 1", "unknown component `Spaeker`"),
    ] {
        has_one_problem(&called(more), message);
    }
    for (more, message) in [
        ("[components.Gate]\ndoor = \"gaet\"", "unknown door `gaet`"),
        ("[components.Eyes]\nonly = [\"Anne\"]", "unknown person `Anne`"),
        ("[components.Door]\nbuiltin = \"door\"", "`door` is missing"),
        ("[[faults]]\nkind = \"door_stuck\"\ndoor = \"gaet\"\nat_s = 1", "gaet"),
    ] {
        let leaves: &[Asks<'_>] = &[("Look", "Eyes", "get_people", "", "true")];
        has_one_problem(&folder(WORLD, leaves, more), message);
    }
}
