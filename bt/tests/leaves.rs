//! Leaves are instances: each has its own process and its own ports.

use std::sync::Arc;

use bt::{Outcome, RECHARGE, Source, Status, Tree, Value, blackboard_in, faults_in};

use crate::forest::Script;
use crate::processes::{Form, Stage};

fn tree(trees: &str) -> Arc<Tree> {
    Arc::new(
        Tree::from_xml("t.xml", &format!("<root BTCPP_format=\"4\" main_tree_to_execute=\"T\">{trees}</root>"))
            .unwrap(),
    )
}

fn processes(tree: &Tree) -> Vec<&str> {
    tree.leaves().map(|leaf| leaf.process()).collect()
}

/// Every leaf with one of these IDs succeeds.
fn succeeding(ids: &[&str]) -> Script {
    ids.iter().map(|id| ((*id).to_owned(), vec![Status::Success])).collect()
}

#[test]
fn every_leaf_is_a_process_named_after_its_name_or_else_its_id() {
    let tree = tree(
        r#"<BehaviorTree ID="T"> <Sequence>
            <Action ID="GoTo"/> <Action ID="GoTo" name="ToDock"/> <Action ID="GoTo"/> <Action ID="GoTo" name=""/>
            <Action ID="Wait" name="GoTo_2"/> <Action ID="Wait" name="ToDock"/>
        </Sequence> </BehaviorTree>"#,
    );
    assert_eq!(processes(&tree), ["GoTo", "ToDock", "GoTo_3", "GoTo_4", "GoTo_2", "ToDock_2"]);
    let outline = tree.to_string();
    let leaves: Vec<&str> = outline.lines().skip(1).map(str::trim).collect();
    assert_eq!(leaves, ["GoTo", "ToDock (GoTo)", "GoTo_3 (GoTo)", "GoTo_4 (GoTo)", "GoTo_2 (Wait)", "ToDock_2 (Wait)"]);
}

#[test]
fn every_instance_of_a_subtree_has_its_own_leaves() {
    let tree = tree(
        r#"<BehaviorTree ID="T"> <Sequence> <SubTree ID="Visit"/> <SubTree ID="Visit"/> </Sequence> </BehaviorTree>
        <BehaviorTree ID="Visit"> <Sequence> <Action ID="Go"/> <Action ID="Look" name="around"/> </Sequence> </BehaviorTree>"#,
    );
    assert_eq!(processes(&tree), ["Go", "around", "Go_2", "around_2"]);
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = Stage::new(&tree, form, &succeeding(&["Go", "Look"]), 0, 1);
        let asked: Vec<String> =
            stage.tick().into_iter().filter(|(from, ..)| from == "BT").map(|(_, to, _)| to).collect();
        assert_eq!(asked, ["Go", "around", "Go_2", "around_2"]);
    }
}

#[test]
fn the_leaves_of_the_shipped_tree_have_the_names_of_the_paper() {
    let tree = Tree::from_xml("recharge.xml", RECHARGE).unwrap();
    assert!(tree.leaves().all(|leaf| leaf.process() == leaf.type_id()));
}

const ERRAND: &str = r#"<BehaviorTree ID="T"> <Sequence>
        <Script code="place := 'kitchen'; tries := 2"/>
        <Action ID="Find" what="cup" room="{place}" tries="{tries}" where="{goal}" shelf="{unheard_of}"/>
        <Action ID="GoTo" place="{goal}"/>
    </Sequence> </BehaviorTree>
    <TreeNodesModel> <Action ID="Find">
        <input_port name="what" type="std::string"/> <input_port name="room" type="std::string"/>
        <input_port name="tries" type="int"/> <output_port name="where" type="std::string"/>
        <output_port name="height" type="double"/> <inout_port name="shelf" type="int"/>
    </Action> </TreeNodesModel>"#;

#[test]
fn ports_are_constants_entries_or_unconnected() {
    let tree = tree(ERRAND);
    let find = tree.leaves().next().unwrap();
    let ports: Vec<(&str, Source<'_>)> = tree.ports(find.id()).map(|port| (port.name, port.source)).collect();
    let cup = Value::from("cup");
    let expected = [
        ("height", Source::Nothing),
        ("room", Source::Entry("place")),
        ("shelf", Source::Entry("unheard_of")),
        ("tries", Source::Entry("tries")),
        ("what", Source::Constant(&cup)),
        ("where", Source::Entry("goal")),
    ];
    assert_eq!(ports, expected);
}

#[test]
fn inputs_come_with_the_tick_and_outputs_with_the_answer() {
    let tree = tree(ERRAND);
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = Stage::new(&tree, form, &succeeding(&["Find", "GoTo"]), 0, 1);
        stage.writes("Find", &[0.75.into(), 3.into(), "table".into()]);
        let sent: Vec<String> =
            stage.tick().iter().map(|(from, to, message)| format!("{from} → {to} {message}")).collect();
        let expected = [
            "BT → Find [<tick>, \"kitchen\", <none>, 2]",
            "Find → BT [<success>, 0.75, 3, \"table\"]",
            "BT → GoTo [<tick>, \"table\"]",
            "GoTo → BT [<success>, <none>]",
        ];
        let right: Vec<&String> = sent.iter().filter(|line| expected.contains(&line.as_str())).collect();
        assert_eq!(right, expected, "{form:?}: {sent:?}");
        let board = blackboard_in(&stage.system, stage.bt).unwrap();
        assert_eq!((board.get("goal"), board.get("unheard_of")), (Some(&Value::from("table")), Some(&Value::Int(3))));
    }
}

#[test]
fn a_value_that_does_not_fit_its_port_fails_the_leaf_and_is_a_fault() {
    let tree = tree(
        r#"<BehaviorTree ID="T"> <Sequence> <Action ID="Guess" n="{n}"/> <Action ID="Count" n="{n}"/> </Sequence> </BehaviorTree>
        <TreeNodesModel> <Action ID="Count"> <input_port name="n" type="int"/> </Action> </TreeNodesModel>"#,
    );
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = Stage::new(&tree, form, &succeeding(&["Guess", "Count"]), 0, 1);
        stage.writes("Guess", &["many".into()]);
        let sent = stage.tick();
        assert!(sent.iter().all(|(_, to, _)| to != "Count"), "{form:?}: it is not even asked: {sent:?}");
        let faults = faults_in(&stage.system, stage.bt);
        let messages: Vec<&str> = faults.iter().map(|fault| fault.message.as_str()).collect();
        assert_eq!(messages, ["the port `n` of `Count`: `many` is not a whole number in range"], "{form:?}");
        assert_eq!(stage.states()[0].outcome, Some(Outcome::Answered(Status::Failure)));
    }
}
