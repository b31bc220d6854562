//! Very large files, or files made to be slow: each test would take minutes or hours, or exhaust the stack or the
//! memory, if the work grew faster than the file.

use std::fmt::Write;

use bt::{Tree, TreeError, table};

/// A file of format 4 with this tree, followed by `rest`.
fn file(body: &str, rest: &str) -> String {
    format!(
        "<root BTCPP_format=\"4\" main_tree_to_execute=\"T\"><BehaviorTree ID=\"T\">{body}</BehaviorTree>{rest}</root>"
    )
}

fn many(count: usize, piece: impl Fn(usize) -> String) -> String {
    (0..count).map(piece).collect()
}

fn sequence(inside: &str) -> String {
    format!("<Sequence>{inside}</Sequence>")
}

fn refused(text: &str) -> TreeError {
    Tree::from_xml("large.xml", text).unwrap_err()
}

#[test]
fn each_of_very_many_problems_is_found_once() {
    const COUNT: usize = 50_000;
    let bodies = [
        many(COUNT, |n| format!("<Unknown{n}/>")),
        many(COUNT, |n| format!("<SubTree ID=\"None{n}\"/>")),
        many(COUNT, |_| "<Script code=\"x :=\"/>".to_owned()),
        many(COUNT, |n| format!("<Action ID=\"A\" wrong{n}=\"1\"/>")),
    ];
    for body in bodies {
        let text = file(
            &sequence(&body),
            "<TreeNodesModel><Action ID=\"A\"><input_port name=\"p\"/></Action></TreeNodesModel>",
        );
        assert_eq!(refused(&text).problems().len(), COUNT);
    }
    let same = refused(&file(&sequence(&"<Unknown/>".repeat(COUNT)), ""));
    let reported: Vec<String> = same.problems().iter().map(ToString::to_string).collect();
    assert_eq!(reported, [format!("unknown node type <Unknown>, here and in {} other places", COUNT - 1)]);
    let again = many(COUNT, |_| "<BehaviorTree ID=\"T\"><AlwaysSuccess/></BehaviorTree>".to_owned());
    assert_eq!(refused(&file("<AlwaysSuccess/>", &again)).problems().len(), COUNT);
}

#[test]
fn the_number_of_attributes_of_an_element_is_limited() {
    let wide = |count| file(&format!("<Action ID=\"A\" {}/>", many(count, |n| format!("a{n}=\"&quot;'>\" "))), "");
    assert!(Tree::from_xml("wide.xml", &wide(999)).is_ok());
    let error = refused(&wide(1_000_000));
    assert_eq!(error.problems()[0].to_string(), "an element may have at most 1000 attributes");
    // Neither comments nor what looks like attributes elsewhere counts.
    let quotes = "'a' ".repeat(5000);
    let text = file(&format!("<Script code=\"x := 1\"/><!-- <a {quotes} -->"), &format!("<!-- <b {quotes} -->"));
    assert!(Tree::from_xml("comment.xml", &format!("<?xml version='1.0'?>{text}")).is_ok());
}

#[test]
fn the_number_of_ports_of_a_node_and_of_a_tree_is_limited() {
    let model = |count| {
        let ports = many(count, |n| format!("<input_port name=\"p{n}\" default=\"1\"/>"));
        format!("<TreeNodesModel><Action ID=\"A\">{ports}</Action></TreeNodesModel>")
    };
    let error = refused(&file("<Action ID=\"A\"/>", &model(100_000)));
    assert_eq!(error.problems()[0].to_string(), "there are more than 1000 ports");
    let error = refused(&file(&sequence(&"<A/>".repeat(50_000)), &model(1000)));
    assert_eq!(error.problems()[0].to_string(), "there are more than 2000000 ports in all");
}

#[test]
fn very_deep_nesting_is_refused_without_recursion() {
    let deep = "<Sequence>".repeat(1_000_000) + "<AlwaysSuccess/>" + &"</Sequence>".repeat(1_000_000);
    assert!(refused(&file(&deep, "")).problems()[0].to_string().contains("too large"));
    let deep = "<Sequence>".repeat(100_000) + "<AlwaysSuccess/>" + &"</Sequence>".repeat(100_000);
    assert_eq!(refused(&file(&deep, "")).problems()[0].to_string(), "nodes are nested more than 256 deep");
    let chain = many(100_000, |n| format!("<BehaviorTree ID=\"C{n}\"><SubTree ID=\"C{}\"/></BehaviorTree>", n + 1));
    let end = "<BehaviorTree ID=\"C100000\"><AlwaysSuccess/></BehaviorTree>";
    let error = refused(&file("<SubTree ID=\"C0\"/>", &format!("{chain}{end}")));
    assert_eq!(error.problems()[0].to_string(), "nodes are nested more than 256 deep");
}

#[test]
fn long_cycles_of_trees_are_reported_on_one_line_each() {
    const COUNT: usize = 20_000;
    let tree = |n| {
        format!(
            "<BehaviorTree ID=\"C{n}\"><Sequence><SubTree ID=\"C0\"/><SubTree ID=\"C{}\"/></Sequence></BehaviorTree>",
            n + 1
        )
    };
    let end = format!("<BehaviorTree ID=\"C{COUNT}\"><AlwaysSuccess/></BehaviorTree>");
    let error = refused(&file("<SubTree ID=\"C0\"/>", &(many(COUNT, tree) + &end)));
    assert_eq!(error.problems().len(), COUNT);
    let last = error.problems()[COUNT - 1].to_string();
    assert_eq!(
        last,
        "a tree would contain itself: C0 → C1 → C2 → C3 → C4 → … → C19995 → C19996 → C19997 → C19998 → C19999 → C0"
    );
}

#[test]
fn nearest_names_are_not_searched_among_very_long_ones() {
    let name = "n".repeat(200_000);
    let body = many(100, |n| format!("<{name}{n}/>"));
    let model = format!("<TreeNodesModel><Action ID=\"{name}\"/></TreeNodesModel>");
    assert_eq!(refused(&file(&sequence(&body), &model)).problems().len(), 100);
}

#[test]
fn a_tree_with_strange_names_is_shown_with_one_line_per_node() {
    let mut body = "<AlwaysSuccess name=\"a&#10;b&#9;&#x9b;\"/>".to_owned();
    write!(body, "<AlwaysSuccess name=\"{}\"/>", "long ".repeat(50_000)).unwrap();
    let tree = Tree::from_xml("names.xml", &file(&sequence(&body), "")).unwrap();
    assert_eq!(tree.to_string().lines().nth(1), Some("  AlwaysSuccess a\\nb\\t\\u{9b}"));
    assert!(tree.to_dot(None).contains("[label=\"a\\\\nb\\\\t\\\\u{9b}\""));
    let mut rehearsal = bt::Rehearsal::new(std::sync::Arc::new(tree), []);
    let moment = rehearsal.tick(std::time::Duration::ZERO);
    let table = table(rehearsal.execution().tree(), &[moment]);
    assert_eq!(table.lines().count(), 4);
    assert!(table.lines().all(|line| line.chars().count() < 200 && line.chars().all(|c| !c.is_control())), "{table}");
}
