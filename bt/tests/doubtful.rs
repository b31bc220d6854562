//! What the library reads otherwise than it looks: numbers that are read in part, output ports without braces, ports of
//! unknown types, scripts without semicolons.

use std::sync::Arc;

use bt::{Execution, Leaf, Leaves, Loader, Status, Tree, Value};

use crate::NOW;

const MODELS: &str = "<Action ID=\"Wait\"><input_port name=\"seconds\" type=\"double\"/><input_port name=\"times\" type=\"int\"/>\
    <input_port name=\"note\"/><input_port name=\"points\" type=\"std::vector&lt;double&gt;\"/></Action>\
    <Action ID=\"Look\"><output_port name=\"level\" type=\"std::string\"/></Action>\
    <Action ID=\"Groot1\"><input_port name=\"text\"/></Action>";

fn text(format: u8, body: &str, models: &str) -> String {
    format!(
        "<root BTCPP_format=\"{format}\"><BehaviorTree ID=\"T\">{body}</BehaviorTree>\
         <TreeNodesModel>{MODELS}{models}</TreeNodesModel></root>"
    )
}

fn load(format: u8, body: &str) -> Tree {
    let text = text(format, body, "");
    Loader::default().load("tree.xml", &text).unwrap_or_else(|error| panic!("{error:?}"))
}

fn concerns(tree: &Tree) -> Vec<String> {
    let problems = tree.concerns().into_iter().flat_map(|concerns| concerns.problems());
    problems.map(ToString::to_string).collect()
}

#[test]
fn a_number_that_is_read_in_part_causes_a_warning() {
    for (port, read) in [
        ("seconds=\"0,5\"", "`0,5` is read as 0"),
        ("seconds=\"2 min\"", "`2 min` is read as 2"),
        ("seconds=\"9.5.1\"", "`9.5.1` is read as 9.5"),
        ("times=\"3,5\"", "`3,5` is read as 3"),
        ("times=\"2.9\"", "`2.9` is read as 2"),
        ("points=\"1;2,5;3\"", "`2,5` is read as 2"),
    ] {
        let name = port.split('=').next().unwrap();
        let warned = concerns(&load(4, &format!("<Wait {port}/>")));
        assert_eq!(warned, [format!("the port `{name}`: {read}")], "{port}");
    }
    let warned =
        concerns(&load(4, "<RetryUntilSuccessful num_attempts=\"3,5\"><AlwaysSuccess/></RetryUntilSuccessful>"));
    assert_eq!(warned, ["the port `num_attempts`: `3,5` is read as 3"]);
    for port in [
        "seconds=\"0.5\"",
        "seconds=\"-1e3\"",
        "seconds=\"7\"",
        "times=\"-3\"",
        "points=\"1;2.5\"",
        "note=\"0,5\"",
        "seconds=\"{x}\"",
    ] {
        assert!(concerns(&load(4, &format!("<Wait {port}/>"))).is_empty(), "{port}");
    }
}

#[test]
fn an_output_port_without_braces_causes_a_warning_and_names_an_entry_in_version_3() {
    for format in [3, 4] {
        let tree = load(format, "<Look level=\"charge\"/>");
        assert_eq!(concerns(&tree), ["the output port `level` names no entry"], "{format}");
        let leaf = tree.leaves().next().unwrap().id();
        let is_entry = tree.ports(leaf).any(|port| port.source == bt::Source::Entry("charge"));
        assert_eq!(is_entry, format == 3);
        for level in ["{charge}", "{=}", "="] {
            assert!(concerns(&load(format, &format!("<Look level=\"{level}\"/>"))).is_empty(), "{level}");
        }
    }
}

/// A leaf that keeps what it reads.
#[derive(Default)]
struct Reader(Vec<Option<Value>>);

impl Leaves for Reader {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        self.0.push(leaf.input("text").ok());
        Status::Success
    }

    fn halt(&mut self, _: Leaf<'_>) {}
}

#[test]
fn a_text_reaches_a_port_whose_type_is_unknown() {
    let set = "<SetBlackboard value=\"hello\" output_key=\"x\"/>";
    for leaf in ["<Groot1 text=\"{x}\"/>", "<Action ID=\"Undeclared\" text=\"{x}\"/>"] {
        for body in [format!("{set}{leaf}"), format!("{leaf}{set}{leaf}"), format!("{set}{set}{leaf}")] {
            let tree = load(4, &format!("<Sequence>{body}</Sequence>"));
            assert!(concerns(&tree).is_empty(), "{body}: {:?}", concerns(&tree));
            let (mut execution, mut reader) = (Execution::new(Arc::new(tree)), Reader::default());
            assert_eq!(execution.tick(NOW, &mut reader), Status::Success);
            assert_eq!(reader.0.last(), Some(&Some(Value::from("hello"))), "{body}");
            assert!(execution.faults().is_empty(), "{body}");
        }
    }
    // One that takes any type cannot parse a string.
    let any = "<Action ID=\"Any\"><input_port name=\"text\" type=\"BT::AnyTypeAllowed\"/></Action>";
    let body = format!("<Sequence>{set}<Any text=\"{{x}}\"/></Sequence>");
    let tree = Loader::default().load("tree.xml", &text(4, &body, any)).unwrap();
    assert_eq!(concerns(&tree), ["the entry `x` cannot take what SetBlackboard writes"]);
}

#[test]
fn statements_need_no_semicolon_since_4_9() {
    let tree = load(4, "<Script code=\"a := 1\n   b := 2\n   c := 3\"/>");
    assert_eq!(concerns(&tree), ["there is no `;` before this statement"]);
    let mut execution = Execution::new(Arc::new(tree));
    assert_eq!(execution.tick(NOW, &mut Reader::default()), Status::Success);
    assert_eq!(execution.blackboard().get("c"), Some(&Value::Int(3)));
    assert!(concerns(&load(4, "<Script code=\"a := 1;\n   b := 2;\n   c := 3;\"/>")).is_empty());
}

#[test]
fn an_error_in_a_script_of_several_lines_is_marked_where_it_is() {
    let text = text(4, "<Script code=\"a := 1;\n   b := := 2;\n   c := 3\"/>", "");
    let error = Loader::default().load("tree.xml", &text).unwrap_err();
    assert!(text[error.problems()[0].offset()..].starts_with(":= 2;"), "{error:?}");
}

#[test]
fn an_empty_script_does_nothing() {
    let tree = load(4, "<Script code=\"\"/>");
    let mut execution = Execution::new(Arc::new(tree));
    assert_eq!(execution.tick(NOW, &mut Reader::default()), Status::Success);
    for body in ["<Script code=\" \"/>", "<ScriptCondition code=\"\"/>", "<AlwaysSuccess _onSuccess=\"\"/>"] {
        assert!(Loader::default().load("tree.xml", &text(4, body, "")).is_err(), "{body}");
    }
}

#[test]
fn a_tree_without_an_id_is_refused_beside_models() {
    let text = |format: u8, rest: &str| {
        format!("<root BTCPP_format=\"{format}\"><BehaviorTree><AlwaysSuccess/></BehaviorTree>{rest}</root>")
    };
    assert!(Loader::default().load("tree.xml", &text(4, "")).is_ok());
    assert!(Loader::default().load("tree.xml", &text(4, "<TreeNodesModel/>")).is_err());
    assert!(Loader::default().load("tree.xml", &text(3, "<TreeNodesModel/>")).is_ok());
}
