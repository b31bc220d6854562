//! What may be written, and what is written there.

use serde_json::Value;

use super::Editor;
use super::client::{SCENARIO, SCOPE, TREE, application};

/// An editor with the files of an application, all open.
fn opened() -> Editor {
    let mut editor = Editor::new();
    application(&editor);
    for (file, text) in [("hospital.toml", SCENARIO), ("tree.xml", TREE), ("said.scope", SCOPE)] {
        editor.open(file, text);
    }
    let machine = std::fs::read_to_string(editor.path("skills/AnnounceArrival.scxml")).unwrap();
    editor.open("skills/AnnounceArrival.scxml", &machine);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor
}

/// The names that are proposed after a text.
fn proposed(editor: &mut Editor, file: &str, after: &str) -> Vec<String> {
    let items = editor.ask_after("textDocument/completion", file, after);
    items.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap().to_owned()).collect()
}

/// The explanation of the text before a place.
fn explained(editor: &mut Editor, file: &str, after: &str) -> String {
    let hover = editor.ask_after("textDocument/hover", file, after);
    hover["contents"]["value"].as_str().unwrap_or_else(|| panic!("{hover}")).to_owned()
}

fn has(names: &[String], wanted: &[&str]) {
    for name in wanted {
        assert!(names.iter().any(|known| known == name), "no {name} in {names:?}");
    }
}

#[test]
fn a_key_that_has_its_value_is_completed_without_another() {
    let mut editor = Editor::new();
    editor.open("a.toml", "[battery]\ninit = 80\n");
    let keys = editor.ask_after("textDocument/completion", "a.toml", "init");
    let key = keys.as_array().unwrap().iter().find(|item| item["label"] == "initial_pct").unwrap();
    assert_eq!(key["textEdit"]["newText"], "initial_pct");
    // A fault has the parameters of its kind, in either form.
    for text in
        ["[[faults]]\nlevel_p\nkind = \"battery_level\"\n", "faults = [{ kind = \"battery_level\", level_p }]\n"]
    {
        editor.open("c.toml", text);
        let keys = editor.ask_after("textDocument/completion", "c.toml", "level_p");
        assert!(keys.as_array().unwrap().iter().any(|item| item["label"] == "level_pct"), "{keys}");
        editor.close("c.toml");
    }
    editor.open("d.scope", "const theta := 30\nproperty low := always (BatteryReader, BatteryLevel, m[2] > th)\n");
    let constants = editor.ask_after("textDocument/completion", "d.scope", "m[2] > th");
    assert!(constants.as_array().unwrap().iter().any(|item| item["label"] == "theta"), "{constants}");
    editor.open("b.toml", "[expect]\nreached = []\n");
    let hover = editor.ask_after("textDocument/hover", "b.toml", "reac").to_string();
    assert!(!hover.contains("verdict") && hover.contains("reached"), "{hover}");
}

#[test]
fn keys_and_values_of_scenarios_are_proposed() {
    let mut editor = opened();
    editor.replace(
        "hospital.toml",
        "initial_pct = 80\n",
        "initial_pct = 80\n\n[execution]\ntree = \"\"\n[sites]\nstart = ",
    );
    let of_battery = proposed(&mut editor, "hospital.toml", "initial_pct = 80\n");
    has(&of_battery, &["drain_pct_per_s"]);
    assert!(!of_battery.contains(&"initial_pct".to_owned()));
    has(&proposed(&mut editor, "hospital.toml", "[execution]\ntree = \""), &["whole", "nodes"]);
    assert_eq!(proposed(&mut editor, "hospital.toml", "start = "), ["RechargingStation", "start"]);
    let item = editor.ask_after("textDocument/completion", "hospital.toml", "initial_pct = 80\n");
    let drain = item.as_array().unwrap().iter().find(|item| item["label"] == "drain_pct_per_s").unwrap();
    assert_eq!(drain["textEdit"]["newText"], "drain_pct_per_s = ");
    assert!(drain["documentation"]["value"].as_str().unwrap().contains("default"), "{drain}");
}

#[test]
fn a_key_is_explained_with_its_range_and_default() {
    let mut editor = opened();
    let text = explained(&mut editor, "hospital.toml", "initial_pct");
    assert!(text.starts_with("`battery.initial_pct`") && text.contains("from 0 to 100; default"), "{text}");
}

#[test]
fn nodes_ports_and_leaves_of_trees_are_proposed_and_explained() {
    let mut editor = opened();
    editor.replace("tree.xml", "      <GoToDestination/>\n", "      <\n      <GoToDestination/>\n      <Repeat />\n");
    has(
        &proposed(&mut editor, "tree.xml", "      <"),
        &["Sequence", "RetryUntilSuccessful", "AnnounceArrival", "SubTree"],
    );
    has(&proposed(&mut editor, "tree.xml", "<Repeat "), &["num_cycles", "name", "_skipIf"]);
    has(&proposed(&mut editor, "tree.xml", "<"), &["root"]);
    editor.replace("tree.xml", "main_tree_to_execute", " main_tree_to_execute");
    assert_eq!(proposed(&mut editor, "tree.xml", "<root BTCPP_format=\"4\" "), [""; 0]);
    editor.replace("tree.xml", " main_tree_to_execute=\"Tour\"", "");
    assert_eq!(proposed(&mut editor, "tree.xml", "<root BTCPP_format=\"4\" "), ["main_tree_to_execute"]);
    editor.replace("tree.xml", "<Repeat />", "<Repeat num_cycles=\"1\" _skipIf=\"\"/>");
    assert!(explained(&mut editor, "tree.xml", "_skip").contains("If it holds, the node is skipped"));
    assert!(explained(&mut editor, "tree.xml", "<SequenceWith").contains("are not ticked again"));
    assert!(explained(&mut editor, "tree.xml", "<Repeat").contains("| `num_cycles` | an integer | required |"));
    assert!(explained(&mut editor, "tree.xml", "<GoToDest").contains("a leaf"));
}

#[test]
fn elements_attributes_and_targets_of_machines_are_proposed() {
    let mut editor = opened();
    let file = "skills/AnnounceArrival.scxml";
    editor.replace(file, "    <state id=\"idle\"/>", "    <state id=\"idle\"/>\n    <\n    <send  target=\"\"/>");
    has(&proposed(&mut editor, file, "    <state id=\"idle\"/>\n    <"), &["transition", "onentry"]);
    has(&proposed(&mut editor, file, "<send "), &["delay", "id"]);
    has(&proposed(&mut editor, file, "<send  target=\""), &["Speaker", "BT", "Navigation"]);
    has(&proposed(&mut editor, file, "event=\"BT.tick\" target=\""), &["idle", "saying"]);
}

#[test]
fn messages_and_fields_of_machines_are_proposed_and_explained() {
    let mut editor = opened();
    let file = "skills/AnnounceArrival.scxml";
    let exactly = |names: Vec<String>, wanted: &[&str]| assert_eq!(names, wanted);
    // What a component offers is known before the machine asks for it.
    editor.replace(
        file,
        "<state id=\"idle\"/>",
        "<state id=\"idle\"><transition event=\"BT.tick B\" cond=\"_event.data.\"/><transition event=\"BatteryReader.ok\" \
         cond=\"_event.data.l &gt; 3 &amp;&amp; te\"><send type=\"channel\" target=\"Navigation\" event=\"start_navigation\"><param \
         name=\"\"/></send></transition></state>",
    );
    has(
        &proposed(&mut editor, file, "BT.tick B"),
        &["BT.tick", "BT.halt", "BatteryReader.ok", "Speaker.error", "timeout"],
    );
    has(&proposed(&mut editor, file, "cond=\"_event.data.l"), &["level", "status"]);
    has(&proposed(&mut editor, file, "&amp;&amp; te"), &["text", "_event"]);
    has(&proposed(&mut editor, file, "cond=\"_event."), &["data", "origin"]);
    exactly(proposed(&mut editor, file, "event=\"start_navigation\"><param name=\""), &["place"]);
    exactly(proposed(&mut editor, file, "target=\"Speaker\" event=\""), &["say"]);
    exactly(
        proposed(&mut editor, file, "<send type=\"channel\" target=\""),
        &["BT", "BatteryReader", "Localization", "Navigation", "Speaker"],
    );
    exactly(proposed(&mut editor, file, "target=\"BT\" event=\"hal"), &["failure", "halted", "running", "success"]);
    exactly(proposed(&mut editor, file, "cancel sendid=\""), &["timeout"]);
    assert!(explained(&mut editor, file, "event=\"Speaker.o").contains("Speaker"));
    // A component is asked by the names of its services, and answers whoever asks.
    let file = "parts/Speaker.scxml";
    let text = std::fs::read_to_string(editor.path(file)).unwrap();
    editor.open(file, &text);
    assert_eq!(editor.with_problems(), ["skills/AnnounceArrival.scxml"]);
    editor.replace(file, "length)", "length + _event.data.te)");
    has(&proposed(&mut editor, file, "<transition event=\""), &["say", "said"]);
    has(&proposed(&mut editor, file, "targetexpr=\"listener\" event=\""), &["ok", "error"]);
    has(&proposed(&mut editor, file, "_event.data.te"), &["text"]);
    assert!(explained(&mut editor, file, "<transition event=\"say").contains("text: "));
}

#[test]
fn fields_of_interfaces_and_mappings_are_completed() {
    let mut editor = Editor::new();
    editor.open("i.toml", "[services.say]\nrequest = { text = \"\" }\n");
    has(&proposed(&mut editor, "i.toml", "text = \""), &["text", "real", "place", "int?"]);
    let text =
        "[[messages]]\ntopic = \"/a\"\ntype = \"\"\nfrom = \"A\"\nto = \"B\"\nlossy = \n[messages.fields]\nx = { }\n";
    editor.open("m.toml", text);
    has(&proposed(&mut editor, "m.toml", "x = { "), &["path", "symbols", "scale", "symbol", "value"]);
    has(&proposed(&mut editor, "m.toml", "type = \""), &["sensor_msgs/msg/LaserScan", "nav2_msgs/action/Wait_Goal"]);
    has(&proposed(&mut editor, "m.toml", "lossy = "), &["true", "false"]);
}

#[test]
fn a_text_is_completed_by_what_it_stands_for() {
    let mut editor = opened();
    editor.replace("hospital.toml", "expect = {}\n", "expect = {}\nabout = \"\"\nstop.at = ''\nleaves.AnnounceArrival.machine = \"\"\nfaults = [{ kind = \"component_crash\", component = \"\", in_state = \"\", when = \"(Speaker, \" }]\n");
    assert_eq!(proposed(&mut editor, "hospital.toml", "about = \""), [""; 0]);
    let places = proposed(&mut editor, "hospital.toml", "stop.at = '");
    has(&proposed(&mut editor, "hospital.toml", "AnnounceArrival.machine = \""), &["AnnounceArrival.scxml"]);
    has(&places, &["Destination"]);
    assert!(!places.contains(&"Speaker".to_owned()), "{places:?}");
    has(&proposed(&mut editor, "hospital.toml", "component = \""), &["Speaker", "Navigation"]);
    has(&proposed(&mut editor, "hospital.toml", "in_state = \""), &["AnnounceArrival.saying"]);
    assert_eq!(proposed(&mut editor, "hospital.toml", "when = \"(Speaker, "), ["AnnounceArrival"]);
    assert_eq!(proposed(&mut editor, "hospital.toml", "tree = \"")[..3], ["parts/", "skills/", "tree.xml"]);
    has(&proposed(&mut editor, "hospital.toml", "machine = \"parts/"), &["parts/Speaker.scxml"]);
}

/// Nothing of it can be run before the leaf is described.
#[test]
fn what_a_leaf_asks_is_completed_before_its_scenario_is_complete() {
    let mut editor = Editor::new();
    let tree = "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><Sequence>\
        <Weigh what=\"{it}\" grams=\"{weight}\"/><SubTree ID=\"Later\" when=\"now\"/></Sequence></BehaviorTree>\
        <BehaviorTree ID=\"Later\"><AlwaysSuccess/></BehaviorTree><TreeNodesModel>\
        <Action ID=\"Weigh\"><input_port name=\"what\"/><output_port name=\"grams\"/><output_port name=\"left\"/></Action>\
        <SubTree ID=\"Later\"><input_port name=\"when\"/><input_port name=\"how\" default=\"fast\"/></SubTree></TreeNodesModel></root>";
    let machine = "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\" initial=\"idle\">\
        <state id=\"idle\"><transition event=\"weigh\"><send type=\"channel\" targetexpr=\"_event.origin\" event=\"ok\">\
        <param name=\"load\" expr=\"1\"/><param name=\"scale\" expr=\"'good'\"/></send></transition></state></scxml>";
    editor.write("Arm.scxml", machine);
    editor.write("tree.xml", tree);
    editor.write(
        "arm.toml",
        "[services.weigh]\nrequest = { item = \"text\" }\nreply = { load = \"real\", scale = [\"good\", \"bad\"] }\n",
    );
    editor.write("rooms.toml", "[kitchen]\nposition_m = [1, 2]\n");
    editor.open(
        "main.toml",
        "tree = \"tree.xml\"\n[components.Arm]\nmachine = \"Arm.scxml\"\ninterface = \"arm.toml\"\n",
    );
    let problems = editor.problems("tree.xml");
    assert!(problems.len() == 1 && problems[0].contains("has no machine"), "{problems:?}");
    let leaf = "[leaves.Weigh]\nrequest = \"Arm.weigh\"\nsuccess_when = \"reply. && reply.scale == '' && {} > \"\n\
        outputs = { grams = \"\", }\n[leaves.Weigh.arguments]\nx = \"\"\n\n";
    editor.replace("main.toml", "\"arm.toml\"\n", &format!("\"arm.toml\"\n{leaf}"));
    let mut at = |after: &str| proposed(&mut editor, "main.toml", after);
    assert_eq!(at("request = \""), ["Arm.weigh"]);
    assert_eq!(at("success_when = \""), ["reply"]);
    assert_eq!(at("success_when = \"reply."), ["load", "scale"]);
    assert_eq!(at("scale == '"), ["bad", "good"]);
    assert_eq!(at("&& {"), ["what"]);
    assert_eq!(at("outputs = { grams = \""), ["load", "scale"]);
    assert_eq!(at("outputs = { grams = \"\", "), ["left"]);
    assert_eq!(at("x = \"\"\n"), ["item"]);
    assert_eq!(at("x = \""), ["{what}"]);
    let interfaces = at("interface = \"");
    has(&interfaces, &["arm.toml", "components/devices/door.toml"]);
    assert!(!interfaces.iter().any(|file| ["main.toml", "rooms.toml"].contains(&file.as_str())), "{interfaces:?}");
    editor.open("tree.xml", tree);
    assert_eq!(proposed(&mut editor, "tree.xml", "grams=\"{"), ["it"]);
    assert_eq!(proposed(&mut editor, "tree.xml", "ID=\"Later\" ")[0], "how");
}

#[test]
fn processes_fields_and_words_of_properties_are_proposed_and_explained() {
    let mut editor = opened();
    has(&proposed(&mut editor, "said.scope", "said := alw"), &["always", "eventually"]);
    has(&proposed(&mut editor, "said.scope", "not ("), &["Speaker", "BT", "AnnounceArrival"]);
    assert_eq!(proposed(&mut editor, "said.scope", "Speaker, "), ["AnnounceArrival"]);
    has(&proposed(&mut editor, "said.scope", "m[1] = <"), &["ok", "error"]);
    let meaning = explained(&mut editor, "said.scope", "property sai");
    assert!(meaning.contains("Speaker") && !meaning.contains(":="), "{meaning}");
    assert!(explained(&mut editor, "said.scope", "always").contains("```\n"));
}

#[test]
fn broken_texts_are_answered() {
    let mut editor = opened();
    for file in ["hospital.toml", "tree.xml", "said.scope", "skills/AnnounceArrival.scxml"] {
        let text = editor.text(file).to_owned();
        for end in (0..text.len()).step_by(37).filter(|end| text.is_char_boundary(*end)) {
            editor.edit(file, 0..editor.text(file).len(), &text[..end]);
            for method in ["completion", "hover", "definition", "references"] {
                let mut params = serde_json::json!({ "textDocument": { "uri": editor.address(file) } });
                params["position"] = super::client::position(&text, end);
                if method == "references" {
                    params["context"] = serde_json::json!({ "includeDeclaration": true });
                }
                let _: Value = editor.request(&format!("textDocument/{method}"), params);
            }
        }
        editor.edit(file, 0..editor.text(file).len(), &text);
    }
    assert_eq!(editor.with_problems(), [""; 0]);
}
