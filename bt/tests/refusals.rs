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

/// The help of each warning about a tree of these nodes in order.
fn helps(nodes: &[&str]) -> Vec<String> {
    concerns(&in_order(nodes)).into_iter().map(|(_, help)| help).collect()
}

#[test]
fn a_string_that_is_set_before_a_script_assigns_another_is_no_problem() {
    let (set, script) = ("<SetBlackboard value=\"idle\" output_key=\"mode\"/>", "<Script code=\"mode := 'drive'\"/>");
    for first in
        [set, &format!("<Sequence><RunOnce>{set}</RunOnce></Sequence>"), &format!("<ForceSuccess>{set}</ForceSuccess>")]
    {
        assert!(helps(&[first, script]).is_empty(), "{first}");
    }
    let perhaps = format!("<Fallback><AlwaysSuccess/>{set}</Fallback>");
    let skipped = format!("<Sequence _skipIf=\"true\">{set}</Sequence>");
    let forgotten = [set, script, "<UnsetBlackboard key=\"mode\"/>"];
    for nodes in [&[script, set][..], &[&perhaps, script], &[&skipped, script], &forgotten] {
        assert!(helps(nodes)[0].contains("first, it has none and is emptied"), "{nodes:?}");
    }
}

#[test]
fn a_condition_that_assigns_where_it_seems_to_compare_is_a_warning() {
    let made = "<Script code=\"x := 1; y := 'a'\"/>";
    let help = "`==` compares; the value of an assignment is that of its right side";
    for condition in [
        "<ScriptCondition code=\"y = 'a'\"/>",
        "<ScriptCondition code=\"x += 1; x = 2\"/>",
        "<AlwaysSuccess _skipIf=\"x = 2\"/>",
        "<AlwaysSuccess _while=\"x = 2\"/>",
        "<Precondition if=\"x = 2\" else=\"FAILURE\"><AlwaysSuccess/></Precondition>",
    ] {
        assert_eq!(helps(&[made, condition]), [help], "{condition}");
    }
    for fine in [
        "<ScriptCondition code=\"y == 'a'\"/>",
        "<ScriptCondition code=\"x = 2; x > 1\"/>",
        "<ScriptCondition code=\"x += 1\"/>",
        "<Script code=\"x = 2\"/>",
        "<AlwaysSuccess _onSuccess=\"x = 2\"/>",
    ] {
        assert_eq!(helps(&[made, fine]), [""; 0], "{fine}");
    }
}

#[test]
fn a_child_of_a_reactive_sequence_in_explicit_form_is_a_warning() {
    let tree = |open: &str, close: &str, child: &str| {
        let models = "<Action ID=\"Go\"/><Condition ID=\"Near\"/>";
        file(&[("Main", &format!("<{open}>{child}</{close}>"))], models)
    };
    let reactive = |child: &str| tree("ReactiveSequence", "ReactiveSequence", child);
    for child in [
        "<Condition ID=\"Near\"/>",
        "<Action ID=\"Go\"/>",
        "<Control ID=\"Sequence\"><Go/></Control>",
        "<Decorator ID=\"Inverter\"><Go/></Decorator>",
    ] {
        let element = &child[1..child.find(' ').unwrap()];
        let theirs = format!("from 4.7.0 on refuses to load this tree: \"Unknown node type: {element}\"");
        for text in [reactive(child), tree("Control ID=\"ReactiveSequence\"", "Control", child)] {
            assert!(concerns(&text)[0].1.contains(&theirs), "{child}");
        }
        accepted(&tree("Sequence", "Sequence", child));
        accepted(&tree("ReactiveFallback", "ReactiveFallback", child));
        assert!(warned(&reactive(child)).is_empty(), "version 3 knows them");
    }
    accepted(&reactive("<Near/><Go/><Sequence><Action ID=\"Go\"/></Sequence>"));
}

#[test]
fn calculating_with_an_integer_of_more_than_53_bits_is_a_warning() {
    let script = |code: &str| format!("<Script code=\"{code}\"/>");
    let stamp = "stamp := 1700000000000000001";
    for code in [
        "stamp &gt; 0",
        "stamp == 1",
        "x := stamp + 1",
        "stamp += 1",
        "x := stamp ? 1 : 2",
        "x := -stamp",
        "x := stamp &amp; 1",
    ] {
        let theirs = "Loss of precision when converting a large integer number to floating point";
        assert!(helps(&[&script(stamp), &script(code)])[0].contains(theirs), "{code}");
        assert!(helps(&[&script(code), &script(stamp)])[0].contains(theirs), "{code}, in the next tick");
        assert!(helps(&[&script("stamp := 9007199254740991"), &script(code)]).is_empty(), "{code}");
    }
    assert_eq!(helps(&["<AlwaysSuccess _post=\"x := 1700000000000000001 + 1\"/>"]).len(), 1);
    assert_eq!(concerns(&in_order(&[&script(stamp), "<Measure in=\"{stamp}\"/>"])).len(), 1, "read as a double");
    for code in ["x := stamp", "x := stamp .. 's'", "x := true ? stamp : 1"] {
        assert!(helps(&[&script(stamp), &script(code)]).is_empty(), "{code}");
    }
    let given = "<SubTree ID=\"S\" d=\"1700000000000000001\"/>";
    assert_eq!(concerns(&file(&[("Main", given), ("S", "<ScriptCondition code=\"d &gt; 0\"/>")], "")).len(), 1);
}

#[test]
fn a_watched_entry_takes_no_string() {
    let theirs = "You didn't implement the template specialization of convertFromString for this type: BT::Any";
    let (script, set) = ("<Script code=\"x := 'a'\"/>", "<SetBlackboard value=\"a\" output_key=\"x\"/>");
    for watch in [
        "<SkipUnlessUpdated entry=\"{x}\"><AlwaysSuccess/></SkipUnlessUpdated>",
        "<WaitValueUpdate entry=\"{x}\"><AlwaysSuccess/></WaitValueUpdate>",
        "<WasEntryUpdated entry=\"{x}\"/>",
    ] {
        assert!(helps(&[script, watch])[0].contains(theirs), "{watch}");
        assert!(helps(&[set, watch])[0].contains("Can't convert string"), "{watch}");
        assert!(helps(&["<Script code=\"x := 1\"/>", watch]).is_empty(), "{watch}");
        assert!(helps(&[script, &watch.replace("{x}", "x")]).is_empty(), "the port does not declare the entry");
        assert!(helps(&["<Say out=\"{x}\"/>", script, watch]).is_empty(), "the first port is of a string");
    }
}

#[test]
fn an_entry_of_a_status_takes_no_string() {
    let precondition = "<Precondition if=\"false\" else=\"{x}\"><AlwaysSuccess/></Precondition>";
    let set = "<SetBlackboard value=\"SUCCESS\" output_key=\"x\"/>";
    for reader in [precondition, "<LoopInt queue=\"1\" if_empty=\"{x}\"><AlwaysSuccess/></LoopInt>"] {
        assert!(helps(&[set, reader])[0].contains("once declared"), "{reader}");
        assert!(helps(&["<Script code=\"x := 'SUCCESS'\"/>", reader])[0].contains("BT::NodeStatus"), "{reader}");
        assert!(helps(&["<Say out=\"{x}\"/>", set, reader]).is_empty(), "{reader}");
    }
}

#[test]
fn a_float_is_not_a_double() {
    let models = "<Action ID=\"Double\"><output_port name=\"out\" type=\"double\"/></Action>\
        <Action ID=\"Float\"><input_port name=\"in\" type=\"float\"/></Action>";
    let text = file(&[("Main", "<Sequence><Double out=\"{x}\"/><Float in=\"{x}\"/></Sequence>")], models);
    assert_eq!(refused(&text), ["the entry `x` already has the type double and cannot be used as float"]);
}

#[test]
fn an_entry_of_the_main_tree_that_a_subtree_gets_is_a_warning() {
    let text = |key: &str| {
        file(&[("Main", &format!("<SubTree ID=\"S\" d=\"{{{key}}}\"/>")), ("S", "<Script code=\"d := 3\"/>")], "")
    };
    assert!(concerns(&text("@a"))[0].1.contains("\"Bug: report\"; write @a in the tree itself"));
    accepted(&text("a"));
}

#[test]
fn a_key_with_spaces_around_it_is_a_warning_for_a_number() {
    for value in [" {x}", "{x} ", "="] {
        let warned = helps(&[&format!("<Delay delay_msec=\"{value}\"><AlwaysSuccess/></Delay>")]);
        assert!(warned.len() == 1 && warned[0].contains("can not be converted to unsigned int"), "{value}");
        assert!(helps(&[&format!("<Say in=\"{value}\"/>")]).is_empty(), "{value}");
    }
    assert!(helps(&["<Delay delay_msec=\"{=}\"><AlwaysSuccess/></Delay>"]).is_empty());
}

#[test]
fn names_of_version_3_are_warnings_in_format_4() {
    let trees = |body: &str| file(&[("Main", body), ("S", "<AlwaysSuccess/>")], "");
    for body in [
        "<SequenceStar><AlwaysSuccess/></SequenceStar>",
        "<Control ID=\"SequenceStar\"><AlwaysSuccess/></Control>",
        "<RetryUntilSuccesful num_attempts=\"2\"><AlwaysSuccess/></RetryUntilSuccesful>",
        "<SubTreePlus ID=\"S\"/>",
    ] {
        assert!(concerns(&trees(body))[0].1.contains("Node not recognized"), "{body}");
        assert!(warned(&trees(body)).is_empty(), "{body}");
    }
}
