//! Leaves are instances: each node has its own process, a machine that the scenario may choose, and ports.

use std::path::{Path, PathBuf};

use bt::Loader;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::{concerns, load, problems, reached, recorded, report};

/// Two kinds of leaves, distinguished by name, in a file of version 3; `carrier` is a port that no model declares.
const TOLD_APART_BY_NAME: &str = r#"<root main_tree_to_execute="Errand">
  <BehaviorTree ID="Errand">
    <ReactiveSequence>
      <ReactiveFallback>
        <Condition ID="Ask" name="BatteryLevel" carrier="tcp"/>
        <ReactiveSequence>
          <ReactiveFallback>
            <Condition ID="Ask" name="IsInDock" carrier="tcp"/>
            <Action ID="Do" name="GoToDock" carrier="tcp"/>
          </ReactiveFallback>
          <Action ID="Stay" name="Charge"/>
        </ReactiveSequence>
      </ReactiveFallback>
      <ReactiveFallback>
        <Condition ID="Ask" name="IsInLounge"/>
        <Action ID="Do" name="GoToLounge"/>
      </ReactiveFallback>
    </ReactiveSequence>
  </BehaviorTree>
  <TreeNodesModel> <Condition ID="Ask"/> <Action ID="Do"> <input_port name="place"/> </Action> <Action ID="Stay"/> </TreeNodesModel>
</root>"#;

const PLACES: &str = "
[start]
position_m = [0.0, 0.0]
heading_deg = 0
[dock]
position_m = [-7.5, 9.0]
heading_deg = 180
position_tolerance_m = 0.3
heading_tolerance_deg = 6
[lounge]
corners_m = [[-13.2, 15.6], [-10.0, 15.4], [-10.2, 12.6], [-13.4, 13.0]]
";

const TABLE: &str = r#"
leaves.IsInDock = { machine = "AtDestination.scxml", data.place = "dock" }
leaves.GoToDock = { machine = "GoToDestination.scxml", data.place = "dock" }
leaves.Charge.machine = "WaitForUser.scxml"
leaves.IsInLounge = { machine = "AtDestination.scxml", data.place = "lounge" }
leaves.GoToLounge = { machine = "GoToDestination.scxml", data.place = "lounge" }
"#;

/// A folder with a scenario: this tree, and these lines.
fn scenario(tree: &str, lines: &str) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    std::fs::create_dir(folder.path().join("skills")).unwrap();
    write("tree.xml", tree);
    write("places.toml", PLACES);
    let sites = "sites = { start = \"start\", station = \"dock\", destination = \"lounge\" }";
    let files = "map = \"maps/house.yaml\"\nplaces = \"places.toml\"\ntree = \"tree.xml\"\nskills = \"skills\"";
    write("errand.toml", &format!("{files}\n{sites}\n{lines}"));
    let path = folder.path().join("errand.toml");
    (folder, path)
}

/// The problems of a scenario.
fn refusal(scenario: &Path) -> String {
    problems(scenario, &[]).concat()
}

#[test]
fn leaves_with_the_same_id_are_distinguished_by_name_and_configured_by_the_scenario() {
    let lines = "battery = { initial_pct = 30.8, charge_pct_per_s = 5 }\nstop = { at = \"lounge\", after_s = 2 }";
    // The entry of an ID is for the leaves that have none by their names.
    let table = TABLE.replace("leaves.GoToLounge", "leaves.Do");
    let files = scenario(TOLD_APART_BY_NAME, &format!("{lines}\n{table}"));
    let log = files.0.path().join("events.jsonl");
    let report = recorded(&files.1, &[], &log);
    let (dock, lounge) = (reached(&report, "dock"), reached(&report, "lounge"));
    assert!(dock.is_some() && dock < lounge, "first it charges: {dock:?}, {lounge:?}");
    let log = std::fs::read_to_string(log).unwrap();
    for (process, place) in [("GoToDock", "dock"), ("GoToLounge", "lounge")] {
        let starts =
            log.lines().filter(|line| line.contains(&format!("\"{process}\"")) && line.contains("start_navigation"));
        let starts: Vec<&str> = starts.collect();
        assert!(!starts.is_empty() && starts.iter().all(|line| line.contains(place)), "{process}: {starts:?}");
    }
}

/// The machine of a leaf that drives: the shipped one, under another name.
fn go_to(folder: &Path) {
    let text = include_str!("../../../skills/machines/GoToDestination.scxml");
    let text = text.replace("name=\"GoToDestination\"", "name=\"GoTo\"");
    std::fs::write(folder.join("skills/GoTo.scxml"), text).unwrap();
}

#[test]
fn two_leaves_with_the_same_id_drive_to_the_places_of_their_ports() {
    let tree = r#"<root BTCPP_format="4"> <BehaviorTree ID="T">
        <Sequence> <GoTo place="dock"/> <GoTo place="lounge"/> </Sequence>
    </BehaviorTree> <TreeNodesModel> <Action ID="GoTo"> <input_port name="place" type="std::string"/> </Action> </TreeNodesModel> </root>"#;
    let files = scenario(tree, "stop = { at = \"lounge\", after_s = 2 }");
    go_to(files.0.path());
    let report = report(&files.1, &[]);
    assert!(reached(&report, "dock").is_some() && reached(&report, "dock") < reached(&report, "lounge"), "{report}");
}

const CHOSEN: &str = r#"<root BTCPP_format="4"> <BehaviorTree ID="T">
        <Sequence> <Choose chosen="{goal}"/> <GoTo place="{goal}"/> </Sequence>
    </BehaviorTree> <TreeNodesModel>
        <Action ID="GoTo"> <input_port name="place" type="std::string"/> </Action>
        <Condition ID="Choose"> <output_port name="chosen" type="std::string"/> </Condition>
    </TreeNodesModel> </root>"#;

/// A scenario with a tree like [`CHOSEN`].
fn choosing(tree: &str, lines: &str) -> (TempDir, PathBuf) {
    let choose = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Choose">
        <state id="asked"> <transition event="BT.tick">
            <send type="channel" target="BT" event="success"> <param name="chosen" expr="'dock'"/> </send>
        </transition> </state>
    </scxml>"#;
    let files = scenario(tree, lines);
    go_to(files.0.path());
    std::fs::write(files.0.path().join("skills/Choose.scxml"), choose).unwrap();
    files
}

#[test]
fn ports_are_read_with_the_tick_and_written_with_the_answer() {
    for form in ["whole", "nodes"] {
        let lines =
            format!("execution = {{ tree = \"{form}\", max_time_s = 90 }}\nstop = {{ at = \"dock\", after_s = 1 }}");
        let report = report(&choosing(CHOSEN, &lines).1, &[]);
        assert!(reached(&report, "dock").is_some(), "{form}: {report}");
    }
}

#[test]
fn a_tree_that_asks_for_the_pose_of_the_robot_gets_it_before_each_tick() {
    let tree = r#"<root BTCPP_format="4"> <BehaviorTree ID="T"> <PipelineSequence>
        <DistanceController distance="3.0"> <Condition ID="BatteryLevel"/> </DistanceController>
        <GoTo place="lounge"/>
    </PipelineSequence> </BehaviorTree> <TreeNodesModel>
        <Action ID="GoTo"> <input_port name="place" type="std::string"/> </Action>
    </TreeNodesModel> </root>"#;
    let asked = |form: &str| {
        let lines = format!("execution.tree = \"{form}\"\nstop = {{ at = \"lounge\", after_s = 2 }}");
        let files = scenario(tree, &lines);
        go_to(files.0.path());
        let log = files.0.path().join("events.jsonl");
        let report = recorded(&files.1, &[], &log);
        assert!(reached(&report, "lounge").is_some(), "{report}");
        let log = std::fs::read_to_string(log).unwrap();
        let events: Vec<Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let count = |from, to| events.iter().filter(|event| event["from"] == from && event["to"] == to).count();
        (count("BT", "BatteryLevel"), count("BT", "GoTo"))
    };
    let (checks, ticks) = asked("whole");
    assert!(checks >= 3 && checks < ticks / 3, "{checks} checks in {ticks} ticks");
    assert_eq!(asked("nodes"), (checks, ticks));
}

#[test]
fn inputs_that_a_machine_does_not_read_give_a_warning() {
    let more = |name: &str| format!("<input_port name=\"{name}\" type=\"std::string\"/> </Action>");
    let tree = CHOSEN.replace("place=\"{goal}\"/>", "place=\"{goal}\" speed=\"2\" pace=\"{goal}\"/>");
    let tree = tree.replace("</Action>", &more("speed")).replace("</Action>", &more("pace"));
    let files = choosing(&tree, "");
    let warns_of = |ports: &[&str]| {
        let warned = concerns(&load(&files.1, &[]).unwrap());
        assert_eq!(warned.len(), ports.len(), "{warned:#?}");
        for (warning, port) in warned.iter().zip(ports) {
            let unread = format!("the machine of `GoTo` does not read the port `{port}`");
            assert!(warning.lines().any(|line| line == unread), "{warning}");
        }
    };
    warns_of(&["pace", "speed"]);
    let machine = files.0.path().join("skills/GoTo.scxml");
    let text = std::fs::read_to_string(&machine).unwrap();
    let tick = "<transition event=\"BT.tick\" target=\"trip\"/>";
    assert!(text.contains(tick), "{text}");
    let read = tick.replace(" target", " cond=\"_event.data.pace != ''\" target");
    std::fs::write(machine, text.replace(tick, &read)).unwrap();
    // What comes with the tick can be read as its data, too.
    warns_of(&["speed"]);
}

#[test]
fn all_errors_in_the_table_of_leaves_are_reported_at_once() {
    let lines = format!(
        "{TABLE}\nleaves.GoToDok.machine = \"GoToDestination.scxml\"\nleaves.Do.data.place = \"dock\"\n\
         leaves.BatteryLevel = {{ machine = \"Nowhere.scxml\", data.at = [1] }}"
    );
    let lines = lines.replace("leaves.Charge", "leaves.Charge.data.patience = 3\nleaves.Charge");
    let files = scenario(TOLD_APART_BY_NAME, &lines);
    let said = refusal(&files.1);
    assert!(said.contains("must be a string, a number, true or false"), "{said}");

    let files = scenario(TOLD_APART_BY_NAME, &lines.replace(", data.at = [1]", ""));
    let said = refusal(&files.1);
    for part in [
        "unknown leaf `GoToDok`",
        "did you mean `GoToDock`?",
        "no leaf uses the entry of the ID `Do`",
        "each leaf with this ID has an entry of its own",
        "cannot read the machine skills/Nowhere.scxml",
        "unknown datum of skills/WaitForUser.scxml `patience`",
    ] {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
}

#[test]
fn a_leaf_without_a_machine_is_refused_with_the_paths_searched() {
    let files = scenario(TOLD_APART_BY_NAME, &TABLE.replace("leaves.Charge.machine = \"WaitForUser.scxml\"", ""));
    let said = refusal(&files.1);
    assert!(
        said.contains("the leaf `Charge` has no machine: there is no skills/Charge.scxml and no skills/Stay.scxml"),
        "{said}"
    );
    assert!(said.contains("[leaves.Charge] machine = \"…\""), "{said}");
}

#[test]
fn a_leaf_cannot_have_the_name_of_a_component() {
    let tree = TOLD_APART_BY_NAME.replace("name=\"Charge\"", "name=\"Navigation\"");
    let files = scenario(&tree, &TABLE.replace("leaves.Charge", "leaves.Navigation"));
    let said = refusal(&files.1);
    assert!(said.contains("a leaf cannot be named `Navigation`"), "{said}");
}

#[test]
fn tree_commands_name_the_processes_of_leaves() {
    let tree = TOLD_APART_BY_NAME.replace("IsInLounge", "IsInDock");
    let shown = Loader::default().load("tree.xml", &tree).unwrap().to_string();
    for line in ["BatteryLevel (Ask)", "IsInDock (Ask)", "IsInDock_2 (Ask)", "GoToDock (Do)"] {
        assert!(shown.lines().any(|shown| shown.trim() == line), "no {line}: {shown}");
    }
}

#[test]
fn a_scenario_without_properties_drops_the_expectations_of_its_base() {
    let folder = tempdir().unwrap();
    let scenario = folder.path().join("quiet.toml");
    let text = "base = \"errand\"\nproperties = []\nexecution = { max_time_s = 1 }\nexpect.reached = []\n";
    std::fs::write(&scenario, text).unwrap();
    let report = report(&scenario, &[]);
    assert_eq!((&report["outcome"], report["monitors"].as_array().map(Vec::len)), (&"as_expected".into(), Some(0)));

    // So does a scenario whose properties are replaced on the command line.
    let report = crate::report("errand", &["properties=[]", "execution.max_time_s=1", "expect.reached=[]"]);
    assert_eq!((&report["outcome"], report["monitors"].as_array().map(Vec::len)), (&"as_expected".into(), Some(0)));

    // It is still a mistake if the scenario itself mentions a property that does not exist.
    std::fs::write(&scenario, format!("{text}expect.phi9 = \"satisfied\"\n")).unwrap();
    let said = refusal(&scenario);
    assert!(said.contains("unknown property `phi9`"), "{said}");
}

/// A machine that answers the tree and asks a process that exists in no shipped system.
const ASKS_A_SPEAKER: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Charge">
  <state id="asked">
    <transition event="BT.tick"> <send type="channel" target="Speaker" event="say"/> <send type="channel" target="BT" event="running"/> </transition>
    <transition event="BT.halt"> <send type="channel" target="BT" event="halted"/> </transition>
  </state>
</scxml>"#;

#[test]
fn an_unknown_process_is_refused_with_the_processes_that_a_skill_may_send_to() {
    let files = scenario(TOLD_APART_BY_NAME, &TABLE.replace("leaves.Charge.machine = \"WaitForUser.scxml\"", ""));
    let machine = files.0.path().join("skills/Charge.scxml");
    std::fs::write(&machine, ASKS_A_SPEAKER).unwrap();
    let said = refusal(&files.1);
    for part in
        ["there is no process Speaker", "BT, BatteryReader, Localization, Navigation", "the scenario determines"]
    {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
    assert!(!said.contains("skills::"), "no internal names: {said}");
}
