//! Trees that BehaviorTree.CPP 4 refuses to load, and similar ones that it accepts.

use bt::{Loader, Tree, TreeError};

/// A file of format 4 with these trees and models; the first tree is the main tree.
fn file(trees: &[(&str, &str)], models: &str) -> String {
    let tree = |(id, body): &(&str, &str)| format!("<BehaviorTree ID=\"{id}\">{body}</BehaviorTree>");
    let (main, trees) = (trees[0].0, trees.iter().map(tree).collect::<String>());
    format!(
        "<root BTCPP_format=\"4\" main_tree_to_execute=\"{main}\">{trees}<TreeNodesModel>{models}</TreeNodesModel></root>"
    )
}

fn load(text: &str) -> Result<Tree, TreeError> {
    Tree::from_xml("tree.xml", text)
}

/// The problems of a refused file.
fn refused(text: &str) -> Vec<String> {
    let error = load(text).expect_err(text);
    error.problems().iter().filter(|problem| problem.is_error()).map(ToString::to_string).collect()
}

#[track_caller]
fn accepted(text: &str) {
    let tree = load(text).unwrap_or_else(|error| panic!("{error:?}"));
    assert!(tree.concerns().is_none(), "{:?}", tree.concerns());
}

/// The warnings about the same file in version 3.
fn warned(text: &str) -> Vec<String> {
    let tree = load(&text.replace(" BTCPP_format=\"4\"", "")).unwrap_or_else(|error| panic!("{error:?}"));
    tree.concerns().map_or(Vec::new(), |concerns| concerns.problems().iter().map(ToString::to_string).collect())
}

#[test]
fn a_tree_id_with_a_space_is_refused() {
    let text = file(&[("Clean Up", "<AlwaysSuccess/>")], "");
    assert_eq!(refused(&text), ["`Clean Up` cannot be an ID: it contains a space"]);
}

#[test]
fn a_tree_id_with_a_dot_is_refused() {
    assert_eq!(
        refused(&file(&[("Clean.Up", "<AlwaysSuccess/>")], "")),
        ["`Clean.Up` cannot be an ID: it contains `.`"]
    );
}

#[test]
fn a_tree_named_root_is_refused() {
    for id in ["Root", "root"] {
        let text = file(&[(id, "<AlwaysSuccess/>")], "");
        assert_eq!(refused(&text), [format!("`{id}` cannot be an ID: BehaviorTree.CPP reserves it")]);
    }
}

#[test]
fn a_subtree_id_with_a_space_is_refused() {
    let text = file(&[("Main", "<SubTree ID=\"Clean Up\"/>"), ("Clean Up", "<AlwaysSuccess/>")], "");
    assert_eq!(
        refused(&text),
        ["`Clean Up` cannot be an ID: it contains a space"; 2],
        "where it is used, and where it is"
    );
}

#[test]
fn a_port_name_with_a_space_is_refused() {
    let model = "<SubTree ID=\"Arm\"><input_port name=\"how far\"/></SubTree>";
    assert_eq!(refused(&file(&[("Main", "<AlwaysSuccess/>")], model)), ["`how far` is not a valid name of a port"]);
}

#[test]
fn ids_with_forbidden_characters_are_refused() {
    for written in
        [" ", "\t", "&#10;", "&#13;", "&lt;", ">", "&amp;", "&quot;", "'", "/", "\\", ":", "*", "?", "|", ".", "\u{7f}"]
    {
        let id = format!("Clean{written}Up");
        let text = file(&[(&id, "<AlwaysSuccess/>")], "");
        assert_eq!(refused(&text).len(), 1, "{text}");
        let used = file(&[("Main", &format!("<SubTree ID=\"{id}\"/>")), (&id, "<AlwaysSuccess/>")], "");
        assert_eq!(refused(&used).len(), 2, "{used}");
    }
    assert_eq!(
        refused(&file(&[("Main", "<clean.up/>")], "<Action ID=\"clean.up\"/>")),
        ["`clean.up` cannot be an ID: it contains `.`"]
    );
}

#[test]
fn ids_may_have_letters_of_all_languages_and_hyphens_and_names_anything() {
    accepted(&file(&[("检查门", "<SubTree ID=\"Türöffner-2_b\"/>"), ("Türöffner-2_b", "<AlwaysSuccess/>")], ""));
    accepted(&file(&[("Main", "<AlwaysSuccess name=\"Clean up, root: 1/2 done? *\"/>")], ""));
    accepted(&file(&[("Main", "<Action ID=\"Clean Up\"/>")], ""));
}

#[test]
fn two_subtrees_of_a_parallel_node_need_different_names() {
    let pair = "<ParallelAll><SubTree ID=\"Arm\" name=\"left\"/><SubTree ID=\"Arm\" name=\"left\"/></ParallelAll>";
    let text = file(&[("Main", pair), ("Arm", "<AlwaysSuccess name=\"lift\"/>")], "");
    assert_eq!(refused(&text), ["there are two subtrees named `left` in this tree"]);
}

#[test]
fn two_subtrees_of_a_sequence_need_different_names() {
    let pair = "<Sequence><SubTree ID=\"Arm\" name=\"one\"/><SubTree ID=\"Leg\" name=\"one\"/></Sequence>";
    let trees = [("Main", pair), ("Arm", "<AlwaysSuccess/>"), ("Leg", "<AlwaysSuccess/>")];
    assert_eq!(refused(&file(&trees, "")), ["there are two subtrees named `one` in this tree"]);
}

#[test]
fn two_subtrees_anywhere_in_a_tree_need_different_names() {
    let pair = "<Sequence><SubTree ID=\"Arm\" name=\"one\"/><Inverter><SubTree ID=\"Arm\" name=\"one\"/></Inverter></Sequence>";
    let trees = [("Main", "<SubTree ID=\"Body\" name=\"one\"/>"), ("Body", pair), ("Arm", "<AlwaysSuccess/>")];
    assert_eq!(refused(&file(&trees, "")), ["there are two subtrees named `one` in this tree"]);
}

#[test]
fn subtrees_without_names_and_leaves_with_equal_names_are_accepted() {
    let others = "<Sequence><SubTree ID=\"Arm\" name=\"left\"/><SubTree ID=\"Arm\" name=\"right\"/>\
                  <SubTree ID=\"Arm\"/><SubTree ID=\"Arm\"/></Sequence>";
    let leaves = "<Sequence><AlwaysSuccess name=\"left\"/><AlwaysSuccess name=\"left\"/></Sequence>";
    accepted(&file(&[("Main", others), ("Arm", leaves)], ""));
}

#[test]
fn a_tree_with_the_id_of_a_node_is_refused() {
    let say = "<Action ID=\"Say\"><input_port name=\"text\"/></Action>";
    let trees =
        [("Main", "<Sequence><Say text=\"hi\"/><SubTree ID=\"Say\"/></Sequence>"), ("Say", "<Say text=\"there\"/>")];
    assert_eq!(refused(&file(&trees, say)), ["`Say` is an <Action>, not a <SubTree>"]);
    let spelled_out =
        [("Main", "<Sequence><Condition ID=\"Say\"/><SubTree ID=\"Say\"/></Sequence>"), ("Say", "<AlwaysSuccess/>")];
    assert_eq!(refused(&file(&spelled_out, "")), ["`Say` is a <Condition>, not a <SubTree>"]);
    let error =
        Loader::default().leaves(["Say"]).load("tree.xml", &file(&[("Say", "<AlwaysSuccess/>")], "")).unwrap_err();
    assert_eq!(error.problems()[0].to_string(), "`Say` is an <Action>, not a <SubTree>");
}

#[test]
fn a_reactive_sequence_with_two_asynchronous_children_is_refused() {
    let child = "<AsyncSequence><AlwaysSuccess/><AlwaysSuccess/></AsyncSequence>";
    let reactive = |inside: &str| file(&[("Main", &format!("<ReactiveSequence>{inside}</ReactiveSequence>"))], "");
    assert_eq!(refused(&reactive(&child.repeat(2))), ["a <ReactiveSequence> cannot have two <AsyncSequence>"]);
    let spelled_out =
        child.replace("<AsyncSequence>", "<Control ID=\"AsyncSequence\">").replace("</AsyncSequence>", "</Control>");
    assert_eq!(refused(&reactive(&format!("{child}{spelled_out}"))).len(), 1);
    accepted(&reactive(child));
    accepted(&file(&[("Main", &format!("<Sequence>{}</Sequence>", child.repeat(2)))], ""));
}

const NODES: &str = "<Action ID=\"Count\"><output_port name=\"out\" type=\"int\"/></Action>\
    <Action ID=\"Say\"><input_port name=\"in\" type=\"std::string\"/><output_port name=\"out\" type=\"std::string\"/></Action>\
    <Action ID=\"Measure\"><input_port name=\"in\" type=\"double\"/></Action>\
    <Action ID=\"Any\"><inout_port name=\"both\"/></Action>";

fn in_order(nodes: &[&str]) -> String {
    file(&[("Main", &format!("<Sequence>{}</Sequence>", nodes.concat()))], NODES)
}

#[test]
fn an_integer_cannot_be_used_as_a_text() {
    assert_eq!(
        refused(&in_order(&["<Count out=\"{x}\"/>", "<Say in=\"{x}\"/>"])),
        ["the entry `x` already has the type int and cannot be used as std::string"]
    );
}

#[test]
fn an_integer_cannot_be_used_as_a_real_number() {
    assert_eq!(
        refused(&in_order(&["<Count out=\"{x}\"/>", "<Measure in=\"{x}\"/>"])),
        ["the entry `x` already has the type int and cannot be used as double"]
    );
}

#[test]
fn a_text_can_be_used_as_anything_and_so_can_an_untyped_entry() {
    accepted(&in_order(&["<Say out=\"{x}\"/>", "<Measure in=\"{x}\"/>", "<Count out=\"{x}\"/>"]));
    // The first port to name an entry determines its type.
    accepted(&in_order(&["<Any both=\"{x}\"/>", "<Count out=\"{x}\"/>", "<Say in=\"{x}\"/>"]));
    let given = "<SubTree ID=\"Arm\" x=\"two\"/>";
    let inside = "<Sequence><Measure in=\"{x}\"/><Say in=\"{x}\"/></Sequence>";
    accepted(&file(&[("Main", given), ("Arm", inside)], NODES));
}

#[test]
fn a_port_that_no_model_declares_is_refused() {
    assert_eq!(refused(&in_order(&["<Measure volume=\"3\"/>"])), ["Measure has no port `volume`"]);
    let text = in_order(&["<Measure volume=\"3\"/>"]);
    assert_eq!(warned(&text), ["Measure declares no port `volume`"]);
    let without_ports = file(&[("Main", "<Action ID=\"Wait\" how_long=\"3\"/>")], "<Action ID=\"Wait\"/>");
    assert_eq!(refused(&without_ports), ["Wait has no port `how_long`"]);
    assert!(warned(&without_ports).is_empty(), "an annotation by Groot that does not mention ports");
    accepted(&file(&[("Main", "<Action ID=\"Wait\" how_long=\"3\"/>")], ""));
}

#[test]
fn a_misspelled_port_is_refused_in_both_versions() {
    let text = in_order(&["<Say inn=\"{x}\"/>"]);
    assert_eq!(refused(&text), ["Say has no port `inn`"]);
    assert_eq!(refused(&text.replace(" BTCPP_format=\"4\"", "")), ["Say has no port `inn`"]);
}

/// The warnings about a file that is accepted.
fn concerns(text: &str) -> Vec<(String, String)> {
    let tree = load(text).unwrap_or_else(|error| panic!("{error:?}"));
    let problems = tree.concerns().into_iter().flat_map(|concerns| concerns.problems().to_vec());
    problems.map(|problem| (problem.to_string(), problem.help_text().unwrap_or_default().to_owned())).collect()
}

#[test]
fn a_constant_of_a_subtree_has_its_own_type_from_version_4_9_1_on() {
    let inside = |port: &str, constant: &str| {
        let main = format!("<SubTree ID=\"S\" d=\"{constant}\"/>");
        file(&[("Main", &main), ("S", port)], NODES)
    };
    let warned = concerns(&inside("<Delay delay_msec=\"{d}\"><AlwaysSuccess/></Delay>", "2000"));
    assert_eq!(warned.len(), 1);
    assert_eq!(warned[0].0, "the entry `d` already has the type int and cannot be used as unsigned int");
    let theirs = "initially created with type [int] and, later type [unsigned int] was used somewhere else";
    assert!(warned[0].1.contains("from 4.9.1 on refuses") && warned[0].1.contains(theirs), "{}", warned[0].1);
    for (port, constant) in [("<Say in=\"{d}\"/>", "3"), ("<Measure in=\"{d}\"/>", "3"), ("<Say in=\"{d}\"/>", "2.5")] {
        assert_eq!(concerns(&inside(port, constant)).len(), 1, "{port} {constant}");
    }
    accepted(&inside("<Repeat num_cycles=\"{d}\"><AlwaysSuccess/></Repeat>", "2"));
    accepted(&inside("<Measure in=\"{d}\"/>", "2.5"));
    accepted(&inside("<Say in=\"{d}\"/>", "home"));
}

#[test]
fn a_default_entry_is_not_declared() {
    let models = "<Action ID=\"Go\"><input_port name=\"to\" type=\"Pose2D\" default=\"{x}\"/></Action>\
        <Action ID=\"Count\"><output_port name=\"out\" type=\"int\"/></Action>";
    accepted(&file(&[("Main", "<Sequence><Go/><Count out=\"{x}\"/></Sequence>")], models));
}

#[test]
fn two_custom_types_may_be_related_if_the_second_is_read() {
    let models = "<Action ID=\"Find\"><output_port name=\"out\" type=\"Cat\"/></Action>\
        <Action ID=\"Feed\"><input_port name=\"in\" type=\"Animal\"/></Action>\
        <Action ID=\"Buy\"><output_port name=\"out\" type=\"Animal\"/></Action>";
    let text = |nodes: &str| file(&[("Main", &format!("<Sequence>{nodes}</Sequence>"))], models);
    let warned = concerns(&text("<Find out=\"{x}\"/><Feed in=\"{x}\"/>"));
    assert_eq!(warned[0].0, "the entry `x` already has the type Cat and cannot be used as Animal");
    assert!(warned[0].1.contains("registers a cast"), "{}", warned[0].1);
    assert_eq!(refused(&text("<Find out=\"{x}\"/><Buy out=\"{x}\"/>")).len(), 1, "no cast helps one that writes");
}

#[test]
fn a_copy_that_the_library_refuses_or_loses_is_a_warning() {
    let helps = |nodes: &[&str]| concerns(&in_order(nodes)).into_iter().map(|(_, help)| help).collect::<Vec<_>>();
    let set = |value: &str| format!("<SetBlackboard value=\"{value}\" output_key=\"x\"/>");
    let (count, script) = ("<Count out=\"{x}\"/>", "<Script code=\"y := 1\"/>");
    assert!(helps(&[count, &set("many")])[0].contains("Can't convert string [many] to type [int]"));
    assert!(helps(&[count, "<Measure in=\"{y}\"/>", &set("{y}")])[0].contains("set(x): once declared"));
    assert!(helps(&[count, script, &set("{y}")])[0].contains("int64_t"));
    let (made, string) = ("<Script code=\"x := 1\"/>", "<Script code=\"z := 'a'; y := true ? z : z\"/>");
    for nodes in [vec![made, &set("2")], vec![made, "<Say out=\"{y}\"/>", &set("{y}")], vec![string, &set("{y}")]] {
        assert!(helps(&nodes)[0].contains("is emptied"), "{nodes:?}");
    }
    assert!(helps(&[made, script, &set("{y}")]).is_empty(), "a number is copied as it is");
    let accepted = [vec![count, "<Say out=\"{y}\"/>"], vec!["<Say out=\"{x}\"/>"], vec![count]];
    for (nodes, value) in accepted.into_iter().zip(["{y}", "2", "2"]) {
        let set = set(value);
        assert!(helps(&[nodes, vec![set.as_str()]].concat()).is_empty(), "{value}");
    }
}
