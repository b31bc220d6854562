//! Mistakes that are no errors: `steward check` names each in an application of its own, and nothing in the same
//! application without it.

use std::fs;
use std::path::Path;

use tempfile::tempdir;

use crate::steward::{refusal, steward};

const SKILL: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">
  <datamodel><data id="text"/></datamodel>
  <state id="idle"><transition event="BT.tick" target="idle"><send type="channel" target="BT" event="success"/></transition>
    <transition event="BT.halt" target="idle"><send type="channel" target="BT" event="halted"/></transition></state>
</scxml>"#;

const SLOW: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">
  <datamodel><data id="text"/></datamodel>
  <state id="idle"><transition event="BT.tick" target="saying"><send type="channel" target="BT" event="running"/></transition>
    <transition event="BT.halt" target="idle"><send type="channel" target="BT" event="halted"/></transition></state>
  <state id="saying"><transition event="BT.tick" target="idle"><send type="channel" target="BT" event="success"/></transition>
  </state>
</scxml>"#;

/// The findings of `check` on an application with this tree and these lines of its scenario, each as its message.
fn findings(tree: &str, lines: &str, skill: &str) -> Vec<String> {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("tree.xml", &format!("<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">{tree}</root>"));
    fs::create_dir(folder.path().join("skills")).unwrap();
    write("skills/Say.scxml", skill);
    write("own.toml", &format!("tree = \"tree.xml\"\nskills = \"skills\"\nexecution.max_time_s = 600\n{lines}\n"));
    checked(&folder.path().join("own.toml"))
}

fn checked(file: &Path) -> Vec<String> {
    let output = steward(&["check", "--json", file.to_str().unwrap()]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report[0]["problems"], serde_json::json!([]), "{report}");
    let warnings = report[0]["warnings"].as_array().unwrap();
    warnings.iter().map(|warning| warning["message"].as_str().unwrap().to_owned()).collect()
}

const MAIN: &str = "<BehaviorTree ID=\"Main\"><Sequence><Action ID=\"Say\" text=\"hello\"/></Sequence></BehaviorTree>";

#[test]
fn an_application_without_mistakes_has_no_findings() {
    assert_eq!(findings(MAIN, "", SKILL), [""; 0]);
}

#[test]
fn a_misspelled_argument_and_an_entry_that_nothing_writes_are_named() {
    let tree = |argument: &str, entry: &str| {
        format!(
            "<BehaviorTree ID=\"Main\"><Sequence><SubTree ID=\"Greet\" {argument}=\"hello\"/>\
             <Action ID=\"Say\" text=\"{entry}\"/></Sequence></BehaviorTree>\
             <BehaviorTree ID=\"Greet\"><Action ID=\"Say\" text=\"{{what}}\"/></BehaviorTree>"
        )
    };
    assert_eq!(findings(&tree("what", "hi"), "", SKILL), [""; 0]);
    let found = findings(&tree("wat", "{waht}"), "", SKILL);
    assert!(found.iter().any(|one| one == "nothing in the tree `Greet` uses `wat`"), "{found:?}");
    assert!(found.iter().any(|one| one.starts_with("nothing writes the entry `waht`")), "{found:?}");
    assert!(found.iter().any(|one| one.starts_with("nothing writes the entry `what`")), "{found:?}");
}

#[test]
fn a_run_warns_of_an_entry_that_nothing_writes() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("Say.scxml", SKILL);
    write("own.toml", "tree = \"tree.xml\"\nskills = \".\"\nexecution.max_time_s = 3\n");
    let (file, out) = (folder.path().join("own.toml"), folder.path().join("out"));
    // One with a similar name exists, or not.
    for script in ["", "<Script code=\"what := 'x'\"/>"] {
        let say = MAIN.replace("hello", "{waht}").replace("<Sequence>", &format!("<Sequence>{script}"));
        write("tree.xml", &format!("<root BTCPP_format=\"4\">{say}</root>"));
        let output = steward(&["run", file.to_str().unwrap(), "--no-snapshots", "--out", out.to_str().unwrap()]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("nothing writes the entry `waht`"), "{script}: {said}");
    }
}

#[test]
fn a_port_that_a_machine_does_not_read_is_named() {
    let tree = MAIN.replace("text=", "speed=\"2\" text=")
        + "<TreeNodesModel><Action ID=\"Say\"><input_port name=\"text\"/><input_port name=\"speed\"/></Action>\
           </TreeNodesModel>";
    assert_eq!(findings(&tree, "", SKILL), ["the machine of `Say` does not read the port `speed`"]);
    let read = SKILL.replace("<data id=\"text\"/>", "<data id=\"text\"/><data id=\"speed\"/>");
    assert_eq!(findings(&tree, "", &read), [""; 0]);
}

#[test]
fn a_running_state_that_cannot_be_halted_is_named() {
    assert_eq!(findings(MAIN, "", SLOW), ["the state `saying` has no transition for `BT.halt`"]);
    let condition = MAIN.replace("Action", "Condition");
    assert_eq!(findings(&condition, "", SLOW), [""; 0]);
}

#[test]
fn a_number_in_the_name_of_a_leaf_is_named_with_the_leaf() {
    let tree = "<BehaviorTree ID=\"Main\"><Sequence>\n<Action ID=\"Say\" text=\"a\"/>\n<Action ID=\"Say\" text=\"b\"/>\n\
                <Action ID=\"Say\" name=\"Bye\" text=\"c\"/></Sequence></BehaviorTree>";
    let property = |leaf: &str| format!("[expect.satisfied]\nsaid = \"eventually (BT, {leaf}, true)\"");
    for lines in [
        property("Say_2"),
        "[leaves.Say_2]\ndata.text = \"d\"".to_owned(),
        "[[faults]]\nkind = \"halt_lost\"\nat_s = 1\nleaf = \"Say_2\"".to_owned(),
    ] {
        let found = findings(tree, &lines, SKILL);
        assert_eq!(found.len(), 1, "{lines}: {found:?}");
        assert!(found[0].contains("tree.xml:3, number 2 of 2 named `Say`"), "{found:?}");
    }
    for lines in [property("Bye"), "[leaves.Bye]\ndata.text = \"d\"".to_owned(), String::new()] {
        assert_eq!(findings(tree, &lines, SKILL), [""; 0], "{lines}");
    }
}

#[test]
fn a_fault_after_the_end_of_the_run_is_named() {
    let fault = |at: &str| format!("[[faults]]\nkind = \"halt_lost\"\n{at}\nleaf = \"Say\"");
    for (at, is_late) in
        [("at_s = 5000", true), ("at_s = 599", false), ("at_tick = 601", true), ("at_tick = 600", false)]
    {
        let found = findings(MAIN, &fault(at), SKILL);
        assert_eq!(found.len(), usize::from(is_late), "{at}: {found:?}");
    }
}

#[test]
fn a_share_instead_of_percent_and_a_zone_faster_than_the_robot_are_named() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    let places = fs::read_to_string("maps/house.places.toml").expect("it is shipped");
    let found = |initial_pct: &str, level_pct: &str, speed_mps: &str| {
        let zone = format!("[Narrow]\ncorners_m = [[-4, 5.6], [0, 5.6], [0, 8], [-4, 8]]\nspeed_mps = {speed_mps}\n");
        write("own.places.toml", format!("{places}\n{zone}"));
        let fault = format!("[[faults]]\nkind = \"battery_level\"\nat_s = 1\nlevel_pct = {level_pct}\n");
        let lines = format!("base = \"errand\"\nplaces = \"own.places.toml\"\nbattery.initial_pct = {initial_pct}\n");
        write("own.toml", lines + &fault);
        checked(&folder.path().join("own.toml"))
    };
    assert_eq!(found("80", "20", "0.2"), [""; 0]);
    assert_eq!(found("0.8", "20", "0.2"), ["`battery.initial_pct` is 0.8 %, less than one percent"]);
    assert_eq!(found("80", "0.2", "0.2"), ["`level_pct` is 0.2 %, less than one percent"]);
    let fast = "the zone `Narrow` allows 2 m/s, but the robot is never faster than 0.45 m/s";
    assert_eq!(found("80", "20", "2"), [fast]);
}

#[test]
fn an_enumerator_of_a_script_can_be_declared() {
    let tree = "<BehaviorTree ID=\"Main\"><Sequence><Script code=\"color := RED\"/><Action ID=\"Say\" text=\"a\"/></Sequence>\
                </BehaviorTree>";
    assert_eq!(findings(tree, "", SKILL), ["nothing writes the entry `RED`, which a script reads"]);
    assert_eq!(findings(tree, "[constants]\nRED = 1", SKILL), [""; 0]);
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).unwrap();
        folder.path().join(name).to_str().unwrap().to_owned()
    };
    let tree = write("tree.xml", &format!("<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">{tree}</root>"));
    let leaves = write("leaves.toml", "[constants]\nRED = 7\n[leaves]\nSay = \"success\"\n");
    let output = steward(&["tree", "run", &tree, "--leaves", &leaves, "--json"]);
    let shown = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    assert!(shown.contains("\"color\"") && shown.contains('7'), "{shown}");
    let unknown = write("leaves.toml", "[leaves]\nSay = \"success\"\n");
    assert_eq!(steward(&["tree", "run", &tree, "--leaves", &unknown]).status.code(), Some(1));
}

#[test]
fn a_case_of_a_switch_that_is_declared_nowhere_is_named() {
    let tree = "<BehaviorTree ID=\"Main\"><Sequence><Script code=\"color := 1\"/>\
                <Switch2 variable=\"{color}\" case_1=\"RED\" case_2=\"2\"><Action ID=\"Say\" text=\"a\"/>\
                <AlwaysSuccess/><AlwaysSuccess/></Switch2></Sequence></BehaviorTree>";
    assert_eq!(findings(tree, "", SKILL), ["the case `RED` is never chosen: the entry `color` is a number"]);
    assert_eq!(findings(tree, "[constants]\nRED = 1", SKILL), [""; 0]);
    assert_eq!(findings(&tree.replace("color := 1", "color := 'RED'"), "", SKILL), [""; 0]);
}

#[test]
fn a_halt_is_lost_on_a_leaf_with_an_output_port() {
    let tree = "<BehaviorTree ID=\"Main\"><Sequence><Action ID=\"Say\" text=\"hello\" heard=\"{heard}\"/></Sequence></BehaviorTree>\
                <TreeNodesModel><Action ID=\"Say\"><input_port name=\"text\"/><output_port name=\"heard\" type=\"double\"/></Action>\
                </TreeNodesModel>";
    assert_eq!(findings(tree, "[[faults]]\nkind = \"halt_lost\"\nat_s = 1\nleaf = \"Say\"", SKILL), [""; 0]);
}

#[test]
fn a_property_can_be_about_a_topic_that_nothing_reads() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("tree.xml", &format!("<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">{MAIN}</root>"));
    fs::create_dir(folder.path().join("skills")).unwrap();
    write("skills/Say.scxml", SKILL);
    write("meter.toml", "[topics.charge]\nfields = { pct = \"real\" }\n[services.ask]\n");
    write(
        "Meter.scxml",
        r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript"><state id="on"><onentry><send event="s" delay="1s"/></onentry>
        <transition event="s" target="on"><send type="channel" event="charge"><param name="pct" expr="50"/></send>
        <send type="channel" event="charge"><param name="pct" expr="70"/></send></transition></state></scxml>"#,
    );
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (path, log) = (&*at("own.toml"), &*at("events.jsonl"));
    let scenario = |event: &str, more: &str| {
        write("enough.scope", &format!("property enough := always ({event})\n"));
        let own = "tree = \"tree.xml\"\nskills = \"skills\"\nproperties = [\"enough.scope\"]\nexecution.max_time_s = 10\n\
                   components.Meter.machine = \"Meter.scxml\"\ncomponents.Meter.interface = \"meter.toml\"\n";
        write("own.toml", &format!("{own}{more}"));
    };
    let run = || {
        let ran = steward(&["run", path, "--out", &at("out"), "--record", log]);
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        fs::read_to_string(log).unwrap()
    };
    // A run, its log, a proof: each judges all messages, which no other process gets; a warning changes nothing.
    let events = ["Meter, *, pct > 20", "Meter, *, pct > 60", "Meter, *, pct > 60 m"];
    for (verdict, event) in ["satisfied", "violated", "violated"].into_iter().zip(events) {
        scenario(event, &format!("[expect]\nenough = \"{verdict}\"\n"));
        let events = run();
        assert!((18..=20).contains(&events.matches(r#""to":"Subscriber""#).count()), "{events}");
        let judged = steward(&["verify", log, "--scenario", path, "--property", &at("enough.scope")]);
        assert_eq!(judged.status.code(), Some(i32::from(verdict == "violated")), "{judged:?}");
        scenario(event, "[prove]\ncomponents.Meter.answers = \"anything\"\nexpect.enough = \"violated\"\n");
        let proved = steward(&["prove", path, "--property", "enough"]);
        assert!(proved.status.success(), "any value may come: {proved:?}");
    }
    scenario("Meter, Say, pct > 20", "");
    let said = refusal(&["check", path]).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        said.contains("Say does not read the topic `charge` of Meter: `(Meter, *, …)` means whatever reads"),
        "{said}"
    );
    // Without such a property, there is no such process, and nothing is known of the topic later.
    scenario("TickGenerator, BT, m[1] = <tick>", "");
    assert!(!run().contains("Subscriber"));
    scenario("Meter, *, pct > 60", "");
    let judged = steward(&["verify", log, "--scenario", path, "--property", &at("enough.scope")]);
    assert_eq!(judged.status.code(), Some(2), "{judged:?}");
    let judged = String::from_utf8_lossy(&judged.stdout).into_owned();
    assert!(
        judged.contains("messages from Meter to Subscriber: when this was recorded, there was no such"),
        "{judged}"
    );
}
