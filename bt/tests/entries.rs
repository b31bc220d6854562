//! Typing errors in the names of entries: arguments that a subtree does not use, entries that nothing writes.

use bt::{Loader, Tree};

const MODELS: &str = "<TreeNodesModel>\
    <Action ID=\"Say\"><input_port name=\"text\" type=\"std::string\"/></Action>\
    <Action ID=\"Ask\"><output_port name=\"answer\" type=\"std::string\"/></Action>\
    <Action ID=\"Move\"><inout_port name=\"pose\"/></Action>\
    </TreeNodesModel>";

fn load(trees: &[(&str, &str)]) -> Tree {
    load_as("4", trees)
}

fn load_as(format: &str, trees: &[(&str, &str)]) -> Tree {
    let tree = |(id, body): &(&str, &str)| format!("<BehaviorTree ID=\"{id}\">{body}</BehaviorTree>");
    let (main, trees) = (trees[0].0, trees.iter().map(tree).collect::<String>());
    let text = format!("<root BTCPP_format=\"{format}\" main_tree_to_execute=\"{main}\">{trees}{MODELS}</root>");
    Loader::default().load("tree.xml", &text).unwrap_or_else(|error| panic!("{error:?}"))
}

/// The warnings about the file, each with its help.
fn concerns(tree: &Tree) -> Vec<String> {
    let problems = tree.concerns().into_iter().flat_map(|concerns| concerns.problems());
    problems.map(|problem| format!("{problem}: {}", problem.help_text().unwrap_or_default())).collect()
}

/// The warnings that hold if no program writes entries.
fn unwritten(tree: &Tree, writes: bool) -> Vec<String> {
    tree.unwritten_entries(&|_, _| writes).iter().map(ToString::to_string).collect()
}

const SAY: (&str, &str) = ("Greet", "<Say text=\"{what}\"/>");

#[test]
fn an_argument_that_the_subtree_does_not_use_causes_a_warning() {
    let warned = concerns(&load(&[("Main", "<SubTree ID=\"Greet\" wat=\"hello\"/>"), SAY]));
    assert_eq!(warned[0], "nothing in the tree `Greet` uses `wat`: did you mean `what`?");
    assert!(
        warned[1].starts_with("nothing writes the entry `what`, which the port `text` of `Say` reads"),
        "{warned:?}"
    );
    assert_eq!(warned.len(), 2);
    assert!(concerns(&load(&[("Main", "<SubTree ID=\"Greet\" what=\"hello\"/>"), SAY])).is_empty());
    // In version 3 the value is the name of an entry.
    let old = load_as("3", &[("Main", "<SubTree ID=\"Greet\" wat=\"hello\"/>"), SAY]);
    assert!(concerns(&old)[0].starts_with("nothing in the tree `Greet` uses `wat`"));
}

#[test]
fn an_argument_is_used_by_any_node_that_names_it() {
    for (given, body) in [
        ("a=\"1\"", "<ScriptCondition code=\"a &gt; 0\"/>"),
        ("a=\"1\"", "<AlwaysSuccess _skipIf=\"a == 1\"/>"),
        ("a=\"{x}\"", "<Script code=\"a := 1\"/>"),
        ("a=\"{x}\"", "<SetBlackboard value=\"1\" output_key=\"a\"/>"),
        ("a=\"{x}\"", "<UnsetBlackboard key=\"a\"/>"),
        ("a=\"hello\"", "<SubTree ID=\"Greet\" what=\"{a}\"/>"),
        ("what=\"hello\"", "<SubTree ID=\"Greet\" _autoremap=\"true\"/>"),
        ("a=\"{x}\"", "<Move pose=\"{a}\"/>"),
        ("a=\"{x}\"", "<Ask answer=\"{a}\"/>"),
        (
            "a=\"1\"",
            "<Switch2 variable=\"{a}\" case_1=\"1\" case_2=\"2\"><AlwaysSuccess/><AlwaysSuccess/><AlwaysSuccess/></Switch2>",
        ),
        ("a=\"2\"", "<Repeat num_cycles=\"{a}\"><AlwaysSuccess/></Repeat>"),
        ("a=\"1;2\"", "<LoopInt queue=\"{a}\" value=\"{v}\"><AlwaysSuccess/></LoopInt>"),
        ("a=\"{x}\"", "<SkipUnlessUpdated entry=\"{a}\"><AlwaysSuccess/></SkipUnlessUpdated>"),
        // The entry whose key is computed may be any.
        ("a=\"{x}\"", "<SetBlackboard value=\"1\" output_key=\"{key}\"/>"),
    ] {
        let tree = load(&[("Main", &format!("<SubTree ID=\"S\" {given}/>")), ("S", body), SAY]);
        let warned = concerns(&tree);
        assert!(!warned.iter().any(|warning| warning.contains("uses `")), "{body}: {warned:?}");
    }
}

#[test]
fn an_argument_that_the_model_of_the_tree_declares_is_no_typing_error() {
    let text = "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\
        <BehaviorTree ID=\"Main\"><SubTree ID=\"S\" later=\"1\"/></BehaviorTree>\
        <BehaviorTree ID=\"S\"><AlwaysSuccess/></BehaviorTree>\
        <TreeNodesModel><SubTree ID=\"S\"><input_port name=\"later\"/></SubTree></TreeNodesModel></root>";
    assert!(concerns(&Loader::default().load("tree.xml", text).unwrap()).is_empty());
}

#[test]
fn a_tree_that_is_used_twice_is_warned_of_once_or_where_it_lacks_an_entry() {
    let twice = |one: &str, other: &str| {
        let main = format!("<Sequence><SubTree ID=\"Greet\" {one}/><SubTree ID=\"Greet\" {other}/></Sequence>");
        concerns(&load(&[("Main", &main), SAY]))
    };
    let warned = twice("", "");
    assert_eq!(warned.len(), 1, "{warned:?}");
    let warned = twice("what=\"hello\"", "");
    assert_eq!(warned.len(), 1, "{warned:?}");
    assert!(warned[0].ends_with("write what=\"…\" here, as where `Greet` is used elsewhere"), "{warned:?}");
}

#[test]
fn in_the_main_tree_an_entry_may_come_from_the_program_unless_it_is_nearly_the_name_of_another_one() {
    let tree = load(&[("Main", "<Sequence><Script code=\"what := 'hello'\"/><Say text=\"{waht}\"/></Sequence>")]);
    assert_eq!(
        concerns(&tree),
        ["nothing writes the entry `waht`, which the port `text` of `Say` reads: did you mean `what`?"]
    );
    assert!(unwritten(&tree, false).is_empty(), "it is known already");
    for written in ["waht", "greeting", "wahts", "x"] {
        let tree = load(&[(
            "Main",
            &format!("<Sequence><Script code=\"{written} := 'hello'\"/><Say text=\"{{waht}}\"/></Sequence>"),
        )]);
        assert!(concerns(&tree).is_empty(), "{written}");
        assert_eq!(unwritten(&tree, false).len(), usize::from(written != "waht"), "{written}");
    }
}

#[test]
fn without_a_program_every_entry_has_to_be_written_by_the_tree() {
    let main = |body: &str| load(&[("Main", &format!("<Sequence>{body}</Sequence>")), SAY]);
    let warned = unwritten(&main("<Say text=\"{a}\"/><ScriptCondition code=\"b &gt; 0\"/>"), false);
    assert_eq!(
        warned,
        [
            "nothing writes the entry `a`, which the port `text` of `Say` reads",
            "nothing writes the entry `b`, which a script reads"
        ]
    );
    for body in [
        "<Ask answer=\"{a}\"/><Say text=\"{a}\"/>",
        "<Say text=\"{a}\"/><Ask answer=\"{a}\"/>",
        "<Move pose=\"{a}\"/>",
        "<SetBlackboard value=\"1\" output_key=\"a\"/><Say text=\"{a}\"/>",
        "<SetBlackboard value=\"1\" output_key=\"@a\"/><SubTree ID=\"Greet\" what=\"{a}\"/>",
        "<LoopString queue=\"a;b\" value=\"{a}\"><Say text=\"{a}\"/></LoopString>",
        "<Say text=\"{robot_pose}\"/>",
        "<AlwaysSuccess _onSuccess=\"a := 1\"/><ScriptCondition code=\"a &gt; 0\"/>",
        "<Action ID=\"Own\" at=\"7\"/>",
    ] {
        assert!(unwritten(&main(body), false).is_empty(), "{body}");
    }
    // A leaf without a model may write to its ports, or not.
    let own = main("<Action ID=\"Own\" at=\"{a}\"/>");
    assert!(unwritten(&own, true).is_empty());
    assert_eq!(unwritten(&own, false).len(), 1);
}

#[test]
fn a_name_that_looks_like_an_enumerator_is_asked_for() {
    let tree =
        load(&[("Main", "<Sequence><Script code=\"color := 1\"/><ScriptCondition code=\"color == RED\"/></Sequence>")]);
    let warned = concerns(&tree);
    assert_eq!(warned.len(), 1);
    assert!(warned[0].starts_with("nothing writes the entry `RED`, which a script reads: "), "{warned:?}");
    assert!(warned[0].contains("enumerator"), "{warned:?}");
}

#[test]
fn a_case_that_is_no_number_is_never_chosen_where_the_entry_is_one() {
    let switch = |variable: &str, case: &str| {
        format!(
            "<Switch2 variable=\"{variable}\" case_1=\"{case}\" case_2=\"7\"><AlwaysSuccess/><AlwaysSuccess/>\
             <AlwaysFailure/></Switch2>"
        )
    };
    let after = |before: &str, case: &str| format!("<Sequence>{before}{}</Sequence>", switch("{color}", case));
    let warned = |tree: &str| concerns(&load(&[("Main", tree)]));
    let [warning] = &warned(&after("<Script code=\"color := 1\"/>", "RED"))[..] else { panic!("one warning") };
    assert!(warning.starts_with("the case `RED` is never chosen: the entry `color` is a number"), "{warning}");
    assert!(warning.contains("`constants`: `RED = 1`"), "{warning}");
    for (before, case) in [
        ("<Script code=\"color := 1\"/>", "1"),
        ("<Script code=\"color := 1\"/>", "1.5"),
        ("<Script code=\"color := 'RED'\"/>", "RED"),
        ("<Script code=\"color := 1\"/><Script code=\"color := 'RED'\"/>", "RED"),
        ("<Script code=\"color := 1\"/><SetBlackboard value=\"RED\" output_key=\"color\"/>", "RED"),
        ("<Script code=\"color := 1\"/><Action ID=\"Own\" at=\"{color}\"/>", "RED"),
        ("<Script code=\"other := 'RED'; color := other\"/>", "RED"),
        ("<Ask answer=\"{color}\"/>", "RED"),
    ] {
        let found = warned(&after(before, case));
        assert!(!found.iter().any(|one| one.contains("never chosen")), "{before}: {found:?}");
    }
    // The program that ticks the tree may set it to anything.
    let found = warned(&switch("{color}", "RED"));
    assert!(!found.iter().any(|one| one.contains("never chosen")), "{found:?}");
}
