//! What files are read, and as what.

use bt::{Kind, Loader, NodeId, RECHARGE, Tree};

/// The paper's tree as Groot 1 writes it for version 3: every leaf spelled out, no format attribute.
const RECHARGE_V3: &str = r#"<?xml version="1.0"?>
<root main_tree_to_execute="BehaviorTree">
    <!-- ////////// -->
    <BehaviorTree ID="BehaviorTree">
        <ReactiveSequence>
            <ReactiveFallback>
                <ReactiveSequence>
                    <Condition ID="BatteryLevel"/>
                    <Condition ID="BatteryNotCharging"/>
                </ReactiveSequence>
                <ReactiveSequence>
                    <ReactiveFallback>
                        <Condition ID="AtRechargingStation"/>
                        <Action ID="GotoRechargingStation"/>
                    </ReactiveFallback>
                    <Action ID="WaitForUser"/>
                </ReactiveSequence>
            </ReactiveFallback>
            <ReactiveFallback>
                <Condition ID="AtDestination"/>
                <Action ID="GoToDestination"/>
            </ReactiveFallback>
        </ReactiveSequence>
    </BehaviorTree>
    <TreeNodesModel>
        <Condition ID="BatteryLevel"/>
    </TreeNodesModel>
</root>"#;

fn kinds(tree: &Tree) -> Vec<Kind> {
    tree.nodes().iter().map(bt::Node::kind).collect()
}

#[test]
fn the_papers_tree_is_read() {
    let tree = Tree::from_xml("trees/recharge.xml", RECHARGE).unwrap();
    insta::assert_snapshot!(tree, @"
    →
      ?
        →
          BatteryLevel
          BatteryNotCharging
        →
          ?
            AtRechargingStation
            GotoRechargingStation
          WaitForUser
      ?
        AtDestination
        GoToDestination
    ");
    assert_eq!(tree.name(), "Recharge");
    let actions: Vec<&str> = tree.leaves().filter(|leaf| leaf.kind() == Kind::Action).map(bt::Node::type_id).collect();
    assert_eq!(actions, ["GotoRechargingStation", "WaitForUser", "GoToDestination"]);
}

#[test]
fn the_papers_tree_in_version_3_is_the_same_tree() {
    let (old, new) = (Tree::from_xml("old.xml", RECHARGE_V3).unwrap(), Tree::from_xml("new.xml", RECHARGE).unwrap());
    assert_eq!(old.to_string(), new.to_string());
    assert_eq!(kinds(&old), kinds(&new));
}

#[test]
fn every_node_knows_its_place() {
    let tree = Tree::from_xml("trees/recharge.xml", RECHARGE).unwrap();
    for node in tree.nodes() {
        let tag = &RECHARGE[node.span().offset()..][..node.span().len()];
        assert!(tag.starts_with('<') && tag[1..].starts_with(node.type_id()), "{tag}");
        assert_eq!(tree.node(node.id()), node);
        let children: Vec<NodeId> = tree.children(node.id()).map(bt::Node::id).collect();
        let expected: Vec<NodeId> =
            tree.nodes().iter().filter(|other| other.parent() == Some(node.id())).map(bt::Node::id).collect();
        assert_eq!(children, expected);
        let depth = std::iter::successors(node.parent(), |above| tree.node(*above).parent()).count();
        assert_eq!(node.depth(), depth);
    }
}

#[test]
fn both_spellings_are_read() {
    let text = r#"<root BTCPP_format="4"><BehaviorTree ID="T">
        <Control ID="Sequence" name="all of it">
            <Decorator ID="Inverter"> <Wait msec="{delay}" note="kept"/> </Decorator>
            <Action ID="AlwaysSuccess"/>
            <Look/>
            <SequenceStar> <Action ID="Wave"/> </SequenceStar>
        </Control>
    </BehaviorTree>
    <TreeNodesModel> <Condition ID="Look"/> </TreeNodesModel></root>"#;
    let tree = Loader::default().leaves(["Wait"]).load("both.xml", text).unwrap();
    use Kind::{Action, AlwaysSuccess, Condition, Inverter, Sequence, SequenceWithMemory};
    assert_eq!(kinds(&tree), [Sequence, Inverter, Action, AlwaysSuccess, Condition, SequenceWithMemory, Action]);
    assert_eq!(tree.nodes()[0].label(), "all of it");
    assert_eq!(tree.nodes()[0].type_id(), "Sequence");
    let attribute = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    assert_eq!(tree.nodes()[2].attributes(), [attribute("msec", "{delay}"), attribute("note", "kept")]);
}

#[test]
fn the_main_tree_is_the_one_that_is_asked_for() {
    let trees =
        r#"<BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree><BehaviorTree ID="B"><AlwaysFailure/></BehaviorTree>"#;
    let file = |attributes: &str| format!("<root {attributes}>{trees}</root>");
    let tree = Tree::from_xml("f.xml", &file(r#"main_tree_to_execute="B""#)).unwrap();
    assert_eq!((tree.name(), tree.nodes()[0].kind()), ("B", Kind::AlwaysFailure));
    let tree = Loader::default().main_tree("A").load("f.xml", &file(r#"main_tree_to_execute="B""#)).unwrap();
    assert_eq!(tree.name(), "A");
}

#[test]
fn the_only_tree_needs_no_id() {
    let tree = Tree::from_xml("some/door.xml", "<root><BehaviorTree><AlwaysSuccess/></BehaviorTree></root>").unwrap();
    assert_eq!(tree.name(), "door");
}

#[test]
fn subtrees_are_read_into_their_places() {
    let text = r#"<root main_tree_to_execute="A">
        <BehaviorTree ID="C"><Action ID="c"/></BehaviorTree>
        <BehaviorTree ID="B"><Fallback><SubTree ID="C" goal="home"/><SubTree ID="C" name="again" goal="{x}" _autoremap="true"/></Fallback></BehaviorTree>
        <BehaviorTree ID="A"><Sequence><SubTree ID="B"/><Action ID="a"/></Sequence></BehaviorTree>
        <TreeNodesModel><SubTree ID="C"><input_port name="goal"/></SubTree></TreeNodesModel>
    </root>"#;
    let tree = Tree::from_xml("f.xml", text).unwrap();
    assert_eq!(tree.to_string(), "→*\n  ▸ B\n    ?*\n      ▸ C\n        c\n      ▸ again\n        c\n  a\n");
}
