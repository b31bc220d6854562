//! `steward tree`: trees checked, shown and ticked without a robot.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

const TREE: &str = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Door">
    <ReactiveSequence>
      <Safe/>
      <Fallback> <Condition ID="IsOpen"/> <Push name="push it" strength="{strength}"/> </Fallback>
    </ReactiveSequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Condition ID="Safe"/>
    <Action ID="Push"> <inout_port name="strength" type="double"/> </Action>
  </TreeNodesModel>
</root>"#;

const LEAVES: &str = r#"
halt_after = [5]
[leaves]
Safe = "success success failure success"
IsOpen = { answers = ["failure", "failure", "success"], repeat = true }
"push it" = ["running", { answer = "success", outputs = { strength = 2.5 } }, "running", "running", "running"]
[blackboard]
strength = 1
"#;

/// The files of a test and their folder.
fn files(tree: &str, leaves: &str) -> (TempDir, PathBuf, PathBuf) {
    let folder = tempdir().unwrap();
    let (tree_file, leaves_file) = (folder.path().join("door.xml"), folder.path().join("leaves.toml"));
    std::fs::write(&tree_file, tree).unwrap();
    std::fs::write(&leaves_file, leaves).unwrap();
    (folder, tree_file, leaves_file)
}

fn said(arguments: &[&str], status: i32) -> String {
    let output = steward(arguments);
    assert_eq!(output.status.code(), Some(status), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_correct_tree_is_accepted() {
    let (_folder, tree, _) = files(TREE, "");
    let fine = format!("{}: 5 nodes, 3 of them leaves; no problems found\n", text(&tree));
    assert_eq!(said(&["tree", "check", text(&tree)], 0), fine);
}

#[test]
fn an_incorrect_tree_is_refused_with_all_errors() {
    let (_folder, tree, _) =
        files(&TREE.replace("ReactiveSequence>", "ReactiveSequenz>").replace("<Push", "<Pull"), "");
    let said = refusal(&["tree", "check", text(&tree)]);
    for part in [
        "unknown node type <ReactiveSequenz>",
        "did you mean <ReactiveSequence>?",
        "unknown node type <Pull>",
        "door.xml:3:5",
    ] {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
}

#[test]
fn a_tree_is_shown_in_four_ways() {
    let (_folder, tree, _) = files(TREE, "");
    let show = |format: &str| said(&["tree", "show", text(&tree), "--format", format], 0);
    assert_eq!(said(&["tree", "show", text(&tree)], 0), "→\n  Safe\n  ?*\n    IsOpen\n    push it (Push)\n");
    assert!(show("dot").starts_with("digraph \"Door\" {"));
    assert!(show("svg").starts_with("<svg ") && show("svg").contains("push it"));
    assert!(show("xml").contains("<Push name=\"push it\" strength=\"{strength}\"/>"));
}

#[test]
fn the_status_of_every_node_is_printed_at_every_tick() {
    let (_folder, tree, leaves) = files(TREE, LEAVES);
    let table = said(&["tree", "run", text(&tree), "--leaves", text(&leaves)], 0);
    let lines = [
        "                1    2    3    4    5 halt",
        "→               R    S    F    R    R    H",
        "  Safe          S    S    F    S    S    ·",
        "  ?*            R    S    ·    R    R    H",
        "    IsOpen      F    ·    ·    F    ·    ·",
        "    push it (Push)  R    S    ·    R    R    H",
    ];
    let letters = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let found: Vec<Vec<String>> = table.lines().map(letters).collect();
    let (found, legend) = found.split_at(lines.len());
    assert_eq!(found, lines.map(letters), "{table}");
    assert_eq!(legend.concat().join(" "), "S success, F failure, R running, H halted, · not reached");
}

#[test]
fn leaves_that_the_file_of_leaves_names_need_not_be_declared() {
    let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence><Look/><Find pose="{p}"/></Sequence></BehaviorTree></root>"#;
    let (_folder, tree, leaves) = files(tree, "[leaves]\nLook = \"success\"\nFind = \"failure\"\n");
    let table = said(&["tree", "run", text(&tree), "--leaves", text(&leaves)], 0);
    assert!(table.contains("Look") && table.contains("F failure"), "{table}");
    std::fs::write(&leaves, "[leaves]\nLook = \"success\"\n").unwrap();
    let refused = refusal(&["tree", "run", text(&tree), "--leaves", text(&leaves)]);
    assert!(refused.contains("unknown node type <Find>") && !refused.contains("<Look>"), "{refused}");
}

#[test]
fn other_leaves_may_have_a_common_answer_and_entries_may_be_written_later() {
    let leaves = "ticks = 3\notherwise = \"success\"\n[leaves]\nIsOpen = \"failure\"\n[blackboard]\nstrength = 1\n\
                  [[writes]]\nbefore_tick = 2\nentries = { strength = 2.5 }\n";
    let (_folder, tree, leaves) = files(TREE, leaves);
    let report = said(&["tree", "run", text(&tree), "--leaves", text(&leaves), "--json"], 0);
    let report: Value = serde_json::from_str(&report).unwrap();
    let strengths: Vec<&Value> =
        report["ticks"].as_array().unwrap().iter().map(|tick| &tick["calls"][2]["inputs"]["strength"]).collect();
    assert_eq!(strengths, [&json!(1.0), &json!(2.5), &json!(2.5)]);
}

#[test]
fn check_names_the_leaves_that_only_the_model_of_nav2_declares_and_warns_about_differences_between_releases() {
    let tree = r#"<root BTCPP_format="4">
        <BehaviorTree ID="Recover"><RoundRobin> <Spin/> <Push strength="1"/> </RoundRobin></BehaviorTree>
        <TreeNodesModel> <Action ID="Push"> <input_port name="strength"/> </Action> </TreeNodesModel> </root>"#;
    let (_folder, tree, _) = files(tree, "");
    let output = steward(&["tree", "check", text(&tree)]);
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.contains("3 nodes, 2 of them leaves (1 declared by Nav2's model)"), "{printed}");
    let warned = String::from_utf8(output.stderr).unwrap();
    assert!(warned.contains("Nav2's RoundRobin wraps around up to Kilted, but not since Lyrical"), "{warned}");
}

#[test]
fn json_has_calls_times_and_statuses() {
    let (_folder, tree, leaves) = files(TREE, LEAVES);
    let arguments = ["tree", "run", text(&tree), "--leaves", text(&leaves), "--ticks", "2", "--json"];
    let report: Value = serde_json::from_str(&said(&arguments, 0)).unwrap();
    assert_eq!(report["tree"], "Door");
    let push = json!({
        "node": 4, "parent": 2, "kind": "Action", "id": "Push", "label": "push it", "process": "push it"
    });
    assert_eq!(report["nodes"][4], push);
    assert_eq!(report["ticks"].as_array().unwrap().len(), 2);
    let second = &report["ticks"][1];
    assert_eq!((&second["tick"], &second["time_s"], &second["status"]), (&json!(2), &json!(1.0), &json!("success")));
    assert_eq!(second["nodes"], json!(["success", "success", "success", null, "success"]));
    let calls = json!([
        {"node": 1, "request": "tick", "inputs": {}},
        {"node": 4, "request": "tick", "inputs": {"strength": 1.0}},
    ]);
    assert_eq!(second["calls"], calls);
    assert_eq!(second["blackboard"], json!([{"subtree": null, "key": "strength", "value": 2.5}]));
}

#[test]
fn json_has_the_entries_of_subtrees_and_ports_without_a_value() {
    let tree = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
        <BehaviorTree ID="Main"> <Sequence> <AlwaysSuccess/> <SubTree ID="Open" door="front"/> </Sequence> </BehaviorTree>
        <BehaviorTree ID="Open"> <Push door="{door}" speed="{speed}" tries="3" done="{done}"/> </BehaviorTree>
        <TreeNodesModel> <Action ID="Push">
            <input_port name="door"/> <input_port name="speed"/> <input_port name="tries" type="int"/> <output_port name="done"/>
        </Action> </TreeNodesModel> </root>"#;
    let leaves = "[leaves]\nPush = [{ answer = \"running\", outputs = { done = \"a little\" } }]\n";
    let (_folder, tree, leaves) = files(tree, leaves);
    let arguments = ["tree", "run", text(&tree), "--leaves", text(&leaves), "--json"];
    let report: Value = serde_json::from_str(&said(&arguments, 0)).unwrap();
    let tick = &report["ticks"][0];
    let inputs = json!({"door": "front", "speed": null, "tries": 3});
    assert_eq!(tick["calls"], json!([{"node": 3, "request": "tick", "inputs": inputs}]));
    let entries = json!([
        {"subtree": 2, "key": "door", "value": "front"},
        {"subtree": 2, "key": "done", "value": "a little"},
    ]);
    assert_eq!(tick["blackboard"], entries);
}

#[test]
fn a_name_with_a_line_break_is_one_line_wherever_it_is_printed() {
    let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="T"> <Sequence>
        <AlwaysSuccess name="a&#10;b"/> <ScriptCondition name="c&#9;d" code="missing == 1"/> </Sequence> </BehaviorTree></root>"#;
    let (_folder, tree, leaves) = files(tree, "[leaves]\n");
    let table = said(&["tree", "run", text(&tree), "--leaves", text(&leaves)], 1);
    assert!(table.lines().any(|line| line.starts_with("  AlwaysSuccess a\\nb ") && line.ends_with('S')), "{table}");
    assert!(table.contains("\ntick 1: c\\td (node 2): "), "{table}");
    assert!(said(&["tree", "show", text(&tree)], 0).contains("  AlwaysSuccess a\\nb\n"));
    for format in ["dot", "svg"] {
        let shown = said(&["tree", "show", text(&tree), "--format", format], 0);
        assert!(!shown.contains("a\nb") && shown.contains("b"), "{shown}");
    }
}

#[test]
fn a_name_of_any_length_is_printed() {
    let long = "n".repeat(100_000);
    let (_folder, tree, leaves) = files(&TREE.replace("push it", &long), &LEAVES.replace("push it", &long));
    let table = said(&["tree", "run", text(&tree), "--leaves", text(&leaves)], 0);
    assert!(table.lines().all(|line| line.chars().count() < 200), "{table}");
    assert!(said(&["tree", "show", text(&tree)], 0).contains(&long));
    assert!(said(&["tree", "show", text(&tree), "--format", "svg"], 0).contains("nnn…"));
}

#[test]
fn an_invalid_script_is_refused_with_all_errors() {
    let wrong = "ticks = -1\n[leaves]\nSafe = \"perhaps\"\nIsOpen = []\nNobody = \"success\"\n";
    let (_folder, tree, leaves) = files(TREE, wrong);
    let said = refusal(&["tree", "run", text(&tree), "--leaves", text(&leaves)]);
    for part in ["ticks", "`Safe` must be an answer", "`IsOpen` must be an answer", "the leaf `push it`", "Nobody"] {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
}

#[test]
fn errors_in_a_node_are_printed_and_give_exit_status_1() {
    let tree = TREE.replace("<Safe/>", "<ScriptCondition code=\"missing == 1\"/>");
    let leaves = LEAVES.replace("Safe = \"success success failure success\"\n", "");
    let (_folder, tree, leaves) = files(&tree, &leaves);
    let table = said(&["tree", "run", text(&tree), "--leaves", text(&leaves), "--ticks", "1"], 1);
    assert!(table.contains("tick 1: ScriptCondition (node 1): the blackboard has no entry `missing`"), "{table}");
}
