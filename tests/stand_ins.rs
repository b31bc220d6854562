//! Components that may answer anything in a proof, and machines that choose.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

/// An arm, which is a program, and a bell.
const SCENARIO: &str = r#"
tree = "tree.xml"
[components.Arm]
program = ["python3", "arm.py"]
interface = "arm.toml"
asks = ["Bell"]
[components.Bell]
builtin = "button"
pressed_s = [3]
[leaves.Pick]
action = "Arm.pick"
arguments.what = "cup"
success_when = "result.grams > 20"
timeout_s = 5
[leaves.Rang]
topic = "Bell.pressed"
[expect.satisfied]
light = "always ((Arm, Pick, status = <pick.succeeded>) implies (Arm, Pick, grams < 1000))"
rung_first = "always ((Pick, Arm, request = <pick.goal>) implies once (Bell, Rang, topic = <pressed>))"
rung_twice = "always (Bell, Rang, false)"
[prove]
components.Arm.answers = "anything"
components.Bell.answers = "anything"
"#;

const ARM: &str = r#"
[actions.pick]
goal = { what = "text" }
feedback = { share = "real" }
result = { grams = "real", colour = ["red", "blue", "?"] }
[services.weigh]
reply = { grams = "real[]" }
"#;

const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Sequence><Condition ID="Rang"/><Action ID="Pick"/></Sequence></BehaviorTree>
</root>"#;

fn application(scenario: &str) -> TempDir {
    let folder = tempdir().expect("a folder");
    let arm = ARM.replace("real[]", "real");
    for (name, text) in [("arms.toml", scenario), ("arm.toml", &arm), ("tree.xml", TREE)] {
        fs::write(folder.path().join(name), text).expect("room for a file");
    }
    folder
}

fn at(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

fn prove(folder: &Path, arguments: &[&str]) -> Value {
    let output = steward(&[&["prove", "--json", &at(folder, "arms.toml")], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_ne!(output.status.code(), Some(2), "{said}");
    serde_json::from_slice(&output.stdout).expect("the results are JSON")
}

fn outcome(results: &Value, property: &str) -> String {
    let properties = results["properties"].as_array().expect("there are properties");
    let found =
        properties.iter().find(|it| it["property"] == property).unwrap_or_else(|| panic!("{property}: {results}"));
    found["result"].as_str().unwrap_or_default().to_owned()
}

#[test]
fn a_component_may_answer_anything_at_any_tick() {
    let folder = application(SCENARIO);
    let results = prove(folder.path(), &[]);
    let outcomes = ["light", "rung_first", "rung_twice", "progress"].map(|property| outcome(&results, property));
    assert_eq!(outcomes, ["violated", "proved", "violated", "proved"]);
    let run = &results["properties"][0]["run"];
    assert_eq!(run["replayed"], true);
    let steps = run["steps"].to_string();
    assert!(steps.contains("Arm chooses `choice.turn.0.") && steps.contains("pick.succeeded_1000"), "{steps}");
    assert_eq!(
        run["rests_on"],
        serde_json::json!([
            "Arm answers every request at once, with anything, does anything with one goal of each action at a time, just \
             before a tick, and ends it when it is canceled.",
            "Bell answers every request at once, with anything, publishes anything or nothing once per tick, just before the \
             next one.",
        ])
    );
    // The run can be followed: its scenario has the same stand-ins.
    let out = at(folder.path(), "out");
    prove(folder.path(), &["--property", "light", "--out", &out]);
    let output = steward(&["run", &format!("{out}/light/counterexample.toml"), "--no-snapshots", "--out", &out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

/// A proof of one property says nothing about another one.
#[test]
fn a_property_that_compares_a_text_that_is_not_known_is_refused_alone() {
    let same = "same = \"always ((Pick, Arm, request = <pick.goal> and what as w) \
                implies eventually (Arm, Pick, label = w))\"\n";
    let folder =
        application(&SCENARIO.replace("\"cup\"", "\"{what}\"").replace("[prove]\n", &format!("{same}[prove]\n")));
    let arm = ARM.replace("real[]", "real").replace("colour =", "label = \"text\", colour =");
    let pick = "<Script code=\"cup := 'cup' .. 5\"/><Action ID=\"Pick\" what=\"{cup}\"/>";
    let tree = TREE.replace("<Action ID=\"Pick\"/>", pick);
    assert_ne!(tree, TREE);
    for (name, text) in [("arm.toml", &arm), ("tree.xml", &tree)] {
        fs::write(folder.path().join(name), text).expect("room for a file");
    }
    assert_eq!(outcome(&prove(folder.path(), &["--property", "light"]), "light"), "violated");
    let said = refusal(&["prove", &at(folder.path(), "arms.toml"), "--property", "same"]);
    let flat = said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
    assert!(flat.contains("the property same compares `label` of Arm with a text that is not known"), "{said}");
}

/// The stand-in as a component of its own: what is proved of it holds in its runs, and what is violated is in some.
#[test]
fn in_runs_the_scheduler_chooses() {
    let folder = application(SCENARIO);
    let scenario = at(folder.path(), "arms.toml");
    let mut own = SCENARIO.to_owned();
    for name in ["Arm", "Bell"] {
        let output = steward(&["prove", &scenario, "--stand-in", name]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::write(folder.path().join(format!("{name}.scxml")), output.stdout).expect("room for a file");
    }
    own = own
        .replace("program = [\"python3\", \"arm.py\"]", "machine = \"Arm.scxml\"")
        .replace("asks = [\"Bell\"]\n", "");
    own = own.replace("builtin = \"button\"\npressed_s = [3]", "machine = \"Bell.scxml\"\ninterface = \"bell.toml\"");
    fs::write(
        folder.path().join("bell.toml"),
        "[topics.pressed]\n[services.get_press]\nreply = { pressed = 'bool' }\n",
    )
    .expect("room for a file");
    fs::write(folder.path().join("own.toml"), own + "[execution]\nmax_time_s = 6\n").expect("room for a file");
    let violated = |seed: u64, property: &str| {
        let arguments = [
            "run",
            &at(folder.path(), "own.toml"),
            "--no-snapshots",
            "--out",
            &at(folder.path(), "out"),
            "--json",
            "--seed",
            &seed.to_string(),
        ];
        let output = steward(&arguments);
        let results: Value = serde_json::from_slice(&output.stdout).expect("the results are JSON");
        results["monitors"]
            .as_array()
            .is_some_and(|monitors| monitors.iter().any(|it| it["name"] == property && it["verdict"] == "violated"))
    };
    let light: Vec<bool> = (1..=12).map(|seed| violated(seed, "light")).collect();
    assert!(light.contains(&true) && light.contains(&false), "{light:?}");
    assert!(!(1..=8).any(|seed| violated(seed, "rung_first")));
}

#[test]
fn numbers_that_cannot_be_followed_are_refused() {
    let refused = |from: &str, to: &str| {
        let folder = application(&SCENARIO.replace(from, to));
        refusal(&["prove", &at(folder.path(), "arms.toml"), "--property", "light"])
    };
    for computed in ["grams < 500 + 500", "grams as g) implies (Arm, Pick, grams < g + 1"] {
        let said = refused("grams < 1000", computed);
        assert!(said.contains("the property light does more with values of Arm than compare them"), "{said}");
    }
    let said = refused("result.grams > 20", "result.grams * 2 > 20");
    assert!(said.contains("Arm cannot answer anything: of its field `grams`, the machine computes with"), "{said}");
    let said = refused("components.Arm.answers = \"anything\"\n", "");
    assert!(said.contains("prove.components.Arm.answers = \"anything\""), "{said}");
    let said = refused("components.Arm.answers", "components.Arm.machine = \"arm.scxml\"\ncomponents.Arm.answers");
    assert!(said.contains("what takes the place of `Arm` must be one thing"), "{said}");
    let folder = application(SCENARIO);
    fs::write(folder.path().join("arm.toml"), ARM).expect("room for a file");
    let said = refusal(&["prove", &at(folder.path(), "arms.toml")]);
    assert!(said.contains("its field `grams` is a list of real"), "{said}");
}

/// A machine tells 0 from other numbers without comparing it.
#[test]
fn a_number_may_be_0() {
    let folder = application(&SCENARIO.replace("result.grams > 20", "!result.grams"));
    let output = steward(&["prove", &at(folder.path(), "arms.toml"), "--stand-in", "Arm"]);
    let machine = String::from_utf8_lossy(&output.stdout);
    assert!(machine.contains("<param name=\"grams\" expr=\"0.0\"/>"), "{machine}");
}

#[test]
fn a_door_may_stick_and_a_visitor_may_be_anywhere() {
    let machine = |component: &str| {
        let output = steward(&["prove", "guide", "--stand-in", component]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let door = machine("Door");
    for answer in ["open.0.ok", "open.1.error", "get_state.0.ok_open", "get_state.1.ok_closed", "get_state.2.ok_moving"]
    {
        assert!(door.contains(&format!("event=\"choice.{answer}")), "{answer}: {door}");
    }
    let sensor = machine("VisitorSensor");
    assert!(sensor.contains("<param name=\"count\" expr=\"0\"/>") && sensor.contains("nearest_m"), "{sensor}");
}

/// Takes no goal, and has a state too many.
const REFUSING: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">
  <state id="here">
    <transition event="follow_path.goal">
      <send type="channel" targetexpr="_event.origin" event="follow_path.rejected"/>
    </transition>
    <transition event="follow_path.cancel"/>
  </state>
  <state id="lost"/>
</scxml>"#;

#[test]
fn a_machine_that_stands_in_is_checked_and_copied_with_its_scenario() {
    let folder = tempdir().expect("a folder");
    let [mine, copy] = ["mine", "copy"].map(|name| folder.path().join(name));
    fs::create_dir(&mine).expect("a new folder");
    let scenario = "base = \"nav2/halted_early\"\n[prove]\ncomponents.ControllerServer.machine = \"Refusing.scxml\"\n";
    for (name, text) in [("own.toml", scenario), ("Refusing.scxml", REFUSING)] {
        fs::write(mine.join(name), text).expect("room for a file");
    }
    let check = |folder: &Path| {
        let output = steward(&["check", "--json", &at(folder, "own.toml")]);
        let report: Value = serde_json::from_slice(&output.stdout).expect("the report is JSON");
        assert_eq!(report[0]["problems"], serde_json::json!([]), "{report}");
        let mut warnings = report[0]["warnings"].as_array().expect("warnings").iter();
        assert!(warnings.any(|one| one["message"] == "the state `lost` is never entered"), "{report}");
    };
    check(&mine);
    let output = steward(&["init", &at(folder.path(), "copy"), "--scenario", &at(&mine, "own.toml")]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::remove_dir_all(&mine).expect("it is not needed");
    assert!(copy.join("Refusing.scxml").is_file());
    check(&copy);
}

#[test]
fn where_a_navigation_of_ones_own_drives_nobody_knows() {
    let folder = tempdir().expect("a folder");
    let state = "state = ['running', 'success', 'failure', 'stopped', 'idle']";
    let services = ["start_navigation", "get_status", "stop_navigation"]
        .map(|name| format!("services.{name} = {{ request = {{ place = 'place' }}, reply = {{ {state} }} }}\n"));
    fs::write(folder.path().join("nav.toml"), services.concat()).expect("room for a file");
    let scenario = "base = 'nominal'\n[components.Navigation]\nprogram = ['nav']\ninterface = 'nav.toml'\n\
                    [prove]\ncomponents.Navigation.answers = 'anything'\nproperties = ['phi1']\n\
                    expect = { phi1 = 'violated' }\n";
    fs::write(folder.path().join("arms.toml"), scenario).expect("room for a file");
    let results = prove(folder.path(), &[]);
    assert_eq!(["phi1", "progress"].map(|property| outcome(&results, property)), ["violated", "proved"]);
    let rests_on = results["properties"][0]["run"]["rests_on"].to_string();
    assert!(rests_on.contains("The robot may be anywhere at any time."), "{rests_on}");
}
