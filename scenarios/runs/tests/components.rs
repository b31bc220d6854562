//! Components from files: a speaker, and a skill that asks it.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::{problems, report};

const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Tour">
  <BehaviorTree ID="Tour">
    <SequenceWithMemory><GoToDestination/><AnnounceArrival/><WaitForUser/></SequenceWithMemory>
  </BehaviorTree>
  <TreeNodesModel><Action ID="GoToDestination"/><Action ID="AnnounceArrival"/><Action ID="WaitForUser"/></TreeNodesModel>
</root>"#;

const SCENARIO: &str = r#"base = "nominal"
tree = "tour.xml"
properties = ["announced.scope"]
battery.initial_pct = 90
execution.max_time_s = 90
stop.at = []

[components.Speaker]
machine = "Speaker.scxml"
interface = "speaker.toml"
data.seconds_per_letter = 0.03

[expect]
announced = "satisfied"
reached = ["Destination"]
"#;

const PROPERTY: &str = "property announced := always (
    (GoToDestination, BT, m[1] = <success>) implies time_until (Speaker, AnnounceArrival, m[1] = <ok>) <= 3)";

/// A folder with the example files, and a scenario that adds these lines to the correct one.
fn folder(more: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../skills/examples");
    fs::create_dir(folder.path().join("skills")).unwrap();
    for (from, to) in [
        ("AnnounceArrival.scxml", "skills/AnnounceArrival.scxml"),
        ("Speaker.scxml", "Speaker.scxml"),
        ("speaker.toml", "speaker.toml"),
    ] {
        fs::copy(examples.join(from), folder.path().join(to)).unwrap();
    }
    for (name, text) in [("tour.xml", TREE), ("tour.toml", SCENARIO), ("announced.scope", PROPERTY)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    fs::write(folder.path().join("variant.toml"), format!("base = \"tour.toml\"\n{more}")).unwrap();
    folder
}

/// The report of a run, which must be as expected.
fn run(folder: &TempDir, scenario: &str, set: &[&str]) -> Value {
    let report = report(folder.path().join(scenario), set);
    let is_met = |expectation: &Value| expectation["difference"].is_null();
    assert!(report["expectations"].as_array().unwrap().iter().all(is_met), "{set:?}: {report}");
    report
}

#[test]
fn a_speaker_runs_by_adding_files_under_every_policy() {
    let folder = folder("");
    for policy in ["policy=random", "policy=round-robin", "starve=Speaker", "starve=AnnounceArrival", "tree=nodes"] {
        for seed in ["seed=1", "seed=2"] {
            run(&folder, "tour.toml", &[&format!("execution.{policy}"), seed]);
        }
    }
}

#[test]
fn faults_of_components_channels_and_skills_affect_a_speaker() {
    let arrives = "when = \"(GoToDestination, BT, m[1] = <success>)\"";
    let speaks = "when = \"(AnnounceArrival, Speaker, m[1] = <say>)\"";
    let outcome = |fault: &str, expected: &str| {
        // The leaf waits for the answer, and does not answer its tick in time.
        let errors = if expected == "violated" { "errors = [\"AnnounceArrival\"]\n" } else { "" };
        let folder = folder(&format!("[[faults]]\n{fault}\n[expect]\nannounced = \"{expected}\"\n{errors}"));
        run(&folder, "variant.toml", &[])
    };
    outcome(&format!("kind = \"component_frozen\"\ncomponent = \"Speaker\"\n{arrives}"), "violated");
    outcome(&format!("kind = \"component_crash\"\ncomponent = \"Speaker\"\n{speaks}\nlasts_s = 5"), "violated");
    // A crash before the first request loses nothing that matters.
    outcome("kind = \"component_crash\"\ncomponent = \"Speaker\"\nat_s = 10\nlasts_s = 5", "satisfied");
    outcome("kind = \"component_no_reply\"\ncomponent = \"Speaker\"\nat_s = 0", "violated");
    outcome("kind = \"component_slow\"\ncomponent = \"Speaker\"\nat_s = 0\ndelay_s = 0.5", "satisfied");
    let lost = "kind = \"message_lost\"\nat_s = 0\nfrom = \"Speaker\"\nto = \"AnnounceArrival\"";
    outcome(lost, "violated");
    outcome("kind = \"skill_state_stuck\"\nskill = \"Speaker\"\nstate = \"speaking\"\nat_s = 0", "violated");
}

#[test]
fn each_mistake_has_one_message() {
    for (more, message) in [
        ("[components.Buzzer]\ninterface = \"speaker.toml\"", "machine"),
        ("[components.Speaker]\nmachine = \"Speeker.scxml\"", "cannot read the machine Speeker.scxml"),
        ("[components.Speaker]\ninterface = \"none.toml\"", "cannot read the interface none.toml"),
        ("[components.Speaker]\nvolume = 3", "`volume`"),
        ("[components.Speaker.data]\nvolume = 3", "unknown datum of Speaker.scxml `volume`"),
        ("[components.Speeker.data]\nseconds_per_letter = 3", "did you mean `Speaker`?"),
        ("prove.properties = [\"aonnounced\"]", "unknown property `aonnounced`"),
        ("[components.BT]\nmachine = \"Speaker.scxml\"", "a component cannot be named `BT`"),
        (
            "[components.WaitForUser]\nmachine = \"Speaker.scxml\"\ninterface = \"speaker.toml\"",
            "a leaf cannot be named `WaitForUser`",
        ),
        ("[[faults]]\nkind = \"component_crash\"\nat_s = 1\ncomponent = \"Speeker\"", "unknown component `Speeker`"),
    ] {
        let said = problems(folder(more).path().join("variant.toml"), &[]);
        assert_eq!(said.len(), 1, "{more}: {said:#?}");
        assert!(said[0].contains(message), "{more}: {said:#?}");
    }
    // The interface must contain the requests that others send and the topics that the component publishes.
    let folder = folder("");
    let speaker = folder.path().join("Speaker.scxml");
    let said = "<send type=\"channel\" targetexpr=\"listener\" event=\"ok\"/>";
    let published = format!("{said}<send type=\"channel\" event=\"spoken\"/>");
    fs::write(&speaker, fs::read_to_string(&speaker).unwrap().replace(said, &published)).unwrap();
    fs::write(folder.path().join("speaker.toml"), "[services.shout]\nrequest = { text = \"text\" }\n").unwrap();
    let said = problems(folder.path().join("tour.toml"), &[]).concat();
    assert!(said.contains("the channel AnnounceArrival → Speaker carries no <say>"), "{said}");
    assert!(said.contains("Speaker does not publish <spoken>"), "{said}");
    let without = SCENARIO.replace("interface = \"speaker.toml\"\n", "");
    fs::write(folder.path().join("tour.toml"), without).unwrap();
    let said = problems(folder.path().join("tour.toml"), &[]).concat();
    assert!(said.contains("Speaker cannot be asked anything: its `interface` has what it can be asked"), "{said}");
    assert!(said.contains("Speaker publishes nothing: its `interface` has what it publishes"), "{said}");
}

/// The client waits in vain, and properties see no message.
#[test]
fn a_component_whose_machine_cannot_send_its_answer_fails_the_run() {
    let folder = tempdir().unwrap();
    let machine = |content: &str| {
        format!("<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0' datamodel='ecmascript'>{content}</scxml>")
    };
    let to_tree = |event: &str| format!("<send type='channel' target='BT' event='{event}'/>");
    let [running, halted] = ["running", "halted"].map(to_tree);
    let ask = format!(
        "<state id='ask'><transition event='BT.tick' target='wait'>
            <send type='channel' target='Arm' event='pose'/>{running}</transition></state>
        <state id='wait'><transition event='BT.tick'>{running}</transition><transition event='BT.halt'>{halted}</transition>
            <transition event='Arm.ok'/><transition event='Arm.error'/></state>"
    );
    let answer = |n: &str| {
        let answer =
            format!("<send type='channel' targetexpr='_event.origin' event='ok'><param name='n' expr='{n}'/></send>");
        machine(&format!("<state id='s'><transition event='pose'>{answer}</transition></state>"))
    };
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("tree.xml", "<root BTCPP_format='4'><BehaviorTree ID='Main'><Action ID='Ask'/></BehaviorTree></root>");
    write("Ask.scxml", &machine(&ask));
    write("arm.toml", "[services.pose]\nreply = { n = 'int' }\n");
    let scenario = "tree = 'tree.xml'\nskills = '.'\nproperties = []\n[components.Arm]\nmachine = 'Arm.scxml'\n\
        interface = 'arm.toml'\n[execution]\nmax_time_s = 3\n";
    write("arm_run.toml", scenario);
    let scenario = folder.path().join("arm_run.toml");
    for (n, set, fails) in [("1", &[][..], false), ("0.5", &[], true), ("0.5", &["expect.errors=['Arm']"], false)] {
        write("Arm.scxml", &answer(n));
        let report = report(&scenario, set);
        assert_eq!(report["outcome"], if fails { "not_as_expected" } else { "as_expected" }, "{n}: {report}");
        let said = report["differences"].to_string();
        assert_eq!(said.contains("there was an error in the component Arm: <ok> cannot be sent"), fails, "{said}");
    }
}
