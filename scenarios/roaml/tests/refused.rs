//! Problems in a model are reported with their locations.

use std::collections::BTreeMap;
use std::fs;

use roaml::Machine;

use crate::load;

/// The problems of a machine with this content, each as `line:column: message`.
fn problems(content: &str) -> Vec<String> {
    let text =
        format!("<ascxml name=\"M\" initial=\"a\" xmlns=\"http://www.w3.org/2005/07/scxml\">\n{content}\n</ascxml>");
    let problems = Machine::load("m.ascxml", &text, &BTreeMap::new(), &[]).expect_err("a problem");
    problems.iter().map(|problem| problem.one_line().replacen("m.ascxml:", "", 1)).collect()
}

#[test]
fn problems_are_located_in_the_original_text() {
    let reported = problems(
        "<ros_topic_subscriber topic=\"level\" type=\"std_msgs/Int32\"/>
<state id=\"a\">
  <ros_topic_callback name=\"levle\" target=\"a\"/>
  <ros_topic_callbak name=\"level\" target=\"a\"/>
  <bt_tick target=\"a\"><bt_return_status status=\"SUCESS\"/></bt_tick>
</state>",
    );
    assert_eq!(
        reported,
        [
            "4:29: no <ros_topic_subscriber> is named `levle` (did you mean `level`?)",
            "5:4: RoAML has no element <ros_topic_callbak> (did you mean `ros_topic_callback`?)",
            "6:49: unknown status `SUCESS` (did you mean `SUCCESS`?)",
        ]
    );
}

#[test]
fn problems_in_the_translation_are_located_there_too() {
    let reported = problems(
        "<ros_topic_subscriber topic=\"level\" type=\"std_msgs/Int32\"/>
<datamodel><data id=\"low\" type=\"bool\" expr=\"false\"/></datamodel>
<state id=\"a\">
  <ros_topic_callback name=\"level\" target=\"b\" cond=\"_msg.data &lt; 3 &amp;&amp; lwo\"/>
</state>",
    );
    assert_eq!(
        reported,
        ["5:44: unknown state `b` (did you mean `a`?)", "5:81: unknown name `lwo` (did you mean `low`?)"]
    );
}

#[test]
fn probabilities_add_up_to_one() {
    let of = |targets: &str| problems(&format!("<state id=\"a\"><transition>{targets}</transition></state>"));
    let reported = of("<target id=\"a\" prob=\"0.5\"/><target id=\"a\" prob=\"0.4\"/>");
    assert!(reported[0].contains("do not add up to 1"), "{reported:?}");
    let reported = of("<target id=\"a\" prob=\"TODO\"/><target id=\"a\"/>");
    assert!(reported[0].starts_with("2:48: `TODO` is not a probability"), "{reported:?}");
    let reported = of("<target id=\"a\"/><target id=\"a\" prob=\"0.4\"/>");
    assert!(reported[0].contains("only the last target may leave out"), "{reported:?}");
}

#[test]
fn errors_name_what_is_not_roaml() {
    let reported = problems("<state id=\"a\"><bt_tick_child id=\"0\"/></state>");
    assert!(reported[0].contains("control nodes cannot be machines"), "{reported:?}");
    let reported = problems("<datamodel><data id=\"x\" type=\"int23\" expr=\"0\"/></datamodel><state id=\"a\"/>");
    assert!(reported[0].contains("unknown type `int23` (did you mean `int"), "{reported:?}");
}

#[test]
fn a_model_says_what_is_wrong_with_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let reported = |main: &str| {
        let path = folder.path().join("main.xml");
        fs::write(&path, main).expect("a file");
        load(&path).expect_err("a problem").replace(&*folder.path().to_string_lossy(), "")
    };
    let none = reported("<roaml><parameters><max_time value=\"1\" unit=\"m\"/></parameters></roaml>");
    assert!(none.contains("unknown unit `m`"), "{none}");
    let missing = reported(
        "<roaml><parameters><max_time value=\"1\"/></parameters>
<node_models><input type=\"node-ascxml\" src=\"gone.ascxml\"/></node_models></roaml>",
    );
    assert!(missing.starts_with("/main.xml:2:45: cannot read /gone.ascxml"), "{missing}");
    fs::write(folder.path().join("p.jani"), PROPERTY).expect("a file");
    let property = reported(
        "<roaml><parameters><max_time value=\"1\"/></parameters>
<properties><input type=\"jani\" src=\"p.jani\"/></properties></roaml>",
    );
    assert!(property.contains("no machine sends `topic_x_msg.valid`"), "{property}");
    assert!(property.contains("the property `q` cannot be checked: only `Pmin` and `Pmax`"), "{property}");
}

#[test]
fn a_machine_with_a_warning_is_part_of_the_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write(
        "door.ascxml",
        "<ascxml name=\"Door\" initial=\"a\" xmlns=\"http://www.w3.org/2005/07/scxml\">
<state id=\"a\"><onentry><send event=\"open\" target=\"Hall\"/></onentry></state></ascxml>",
    );
    write(
        "main.xml",
        "<roaml><parameters><max_time value=\"1\"/></parameters>
<node_models><input type=\"node-ascxml\" src=\"door.ascxml\"/></node_models></roaml>",
    );
    let model = load(&folder.path().join("main.xml")).expect("a model");
    assert_eq!(model.processes().map(|process| process.name).collect::<Vec<_>>(), ["Door"]);
    let warnings: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings, ["in RoAML, an event goes to every machine that takes it"]);
}

const PROPERTY: &str = r#"{"properties": [
  {"name": "p", "expression": {"op": "filter", "fun": "values", "states": {"op": "initial"},
    "values": {"op": "Pmin", "exp": {"op": "F", "exp": "topic_x_msg.valid"}}}},
  {"name": "q", "expression": {"op": "filter", "fun": "values", "states": {"op": "initial"},
    "values": {"op": "Emin", "exp": 1}}}
]}"#;
