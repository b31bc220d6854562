//! Which files are read, and with which result.

use bt::{Kind, Loader, NodeId, RECHARGE, Tree};

/// The paper's tree as Groot 1 writes it for version 3: leaves in explicit form, no format attribute.
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
fn every_node_knows_its_location_in_the_file() {
    let tree = Tree::from_xml("trees/recharge.xml", RECHARGE).unwrap();
    let outline = tree.to_string();
    for (node, line) in tree.nodes().iter().zip(outline.lines()) {
        let tag = &RECHARGE[node.span().offset()..][..node.span().len()];
        assert!(tag.starts_with('<') && tag[1..].starts_with(node.type_id()), "{tag}");
        assert_eq!(tree.node(node.id()), node);
        let children: Vec<NodeId> = tree.children(node.id()).map(bt::Node::id).collect();
        let expected: Vec<NodeId> =
            tree.nodes().iter().filter(|other| other.parent() == Some(node.id())).map(bt::Node::id).collect();
        assert_eq!(children, expected);
        let depth = std::iter::successors(node.parent(), |above| tree.node(*above).parent()).count();
        assert_eq!(line.len() - line.trim_start().len(), 2 * depth, "{line}");
    }
}

#[test]
fn both_forms_of_nodes_are_read() {
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
fn the_requested_main_tree_is_used() {
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
fn subtrees_are_inserted_in_their_places() {
    let text = r#"<root main_tree_to_execute="A">
        <BehaviorTree ID="C"><Action ID="c"/></BehaviorTree>
        <BehaviorTree ID="B"><Fallback><SubTree ID="C" goal="home"/><SubTree ID="C" name="again" goal="{x}" _autoremap="true"/></Fallback></BehaviorTree>
        <BehaviorTree ID="A"><Sequence><SubTree ID="B"/><Action ID="a"/></Sequence></BehaviorTree>
        <TreeNodesModel><SubTree ID="C"><input_port name="goal"/></SubTree></TreeNodesModel>
    </root>"#;
    let tree = Tree::from_xml("f.xml", text).unwrap();
    assert_eq!(tree.to_string(), "→*\n  ▸ B\n    ?*\n      ▸ C\n        c\n      ▸ again\n        c_2 (c)\n  a\n");
}

/// Files by their paths.
fn reader<'a>(files: &'a [(&str, &str)]) -> impl Fn(&std::path::Path) -> std::io::Result<String> + 'a {
    move |path| {
        let found = files.iter().find(|(name, _)| std::path::Path::new(name) == path);
        found.map(|(_, text)| (*text).to_owned()).ok_or_else(|| std::io::Error::other("no such file"))
    }
}

#[test]
fn included_files_are_read_relative_to_the_file_that_includes_them() {
    let main = r#"<root main_tree_to_execute="Main" BTCPP_format="4"><include path="parts/arm.xml"/>
        <BehaviorTree ID="Main"><Sequence><SubTree ID="Arm"/><SubTree ID="Hand"/></Sequence></BehaviorTree></root>"#;
    let arm = r#"<root BTCPP_format="4"><include path="./../hands/hand.xml"/><include path="../main.xml"/>
        <BehaviorTree ID="Arm"><Lift/></BehaviorTree><TreeNodesModel><Action ID="Lift"/></TreeNodesModel></root>"#;
    let hand = r#"<root BTCPP_format="4"><BehaviorTree ID="Hand"><Condition ID="Open"/></BehaviorTree></root>"#;
    let files = [("trees/parts/arm.xml", arm), ("trees/hands/hand.xml", hand)];
    let tree = Loader::default().load_with("trees/main.xml", main, reader(&files)).unwrap();
    assert_eq!(tree.to_string(), "→*\n  ▸ Arm\n    Lift\n  ▸ Hand\n    Open\n");
    assert_eq!(tree.sources().len(), 3);
    let lift = tree.leaves().next().unwrap();
    assert_eq!(tree.sources()[lift.file()].name(), "trees/parts/arm.xml");
    let error = tree.error(&[tree.problem_at(lift.id(), "no skill", "here", "write one")]);
    assert_eq!((error.problems().len(), error.included().len()), (0, 1));
    assert_eq!(error.included()[0].file(), "trees/parts/arm.xml");
}

#[test]
fn of_two_trees_with_one_id_the_one_in_the_including_file_wins() {
    let main = r#"<root main_tree_to_execute="Main" BTCPP_format="4"><include path="a.xml"/>
        <BehaviorTree ID="Main"><SubTree ID="S"/></BehaviorTree><BehaviorTree ID="S"><AlwaysFailure/></BehaviorTree></root>"#;
    let files = [("a.xml", r#"<root BTCPP_format="4"><BehaviorTree ID="S"><AlwaysSuccess/></BehaviorTree></root>"#)];
    let tree = Loader::default().load_with("main.xml", main, reader(&files)).unwrap();
    assert_eq!(tree.to_string(), "▸ S\n  AlwaysFailure\n");
}

#[test]
fn a_file_is_opened_with_its_includes() {
    let folder = std::env::temp_dir().join(format!("bt-loading-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let main = r#"<root main_tree_to_execute="M" BTCPP_format="4"><include path="part.xml"/><BehaviorTree ID="M"><SubTree ID="P"/></BehaviorTree></root>"#;
    std::fs::write(folder.join("main.xml"), main).unwrap();
    let part = r#"<root BTCPP_format="4"><BehaviorTree ID="P"><AlwaysSuccess/></BehaviorTree></root>"#;
    std::fs::write(folder.join("part.xml"), part).unwrap();
    let tree = Loader::default().load_file(folder.join("main.xml"));
    let missing = Loader::default().load_file(folder.join("other.xml"));
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(tree.unwrap().to_string(), "▸ P\n  AlwaysSuccess\n");
    assert!(missing.unwrap_err().problems()[0].message().starts_with("the file cannot be read: "));
}

#[test]
fn a_written_tree_reads_back_as_the_same_tree() {
    let tree = Tree::from_xml("recharge.xml", RECHARGE).unwrap();
    let again = Tree::from_xml("again.xml", &tree.to_xml()).unwrap();
    assert_eq!(again.to_string(), tree.to_string());
    assert_eq!(again.to_xml(), tree.to_xml());
    let old = Tree::from_xml("old.xml", RECHARGE_V3).unwrap().to_xml();
    assert!(
        old.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<root BTCPP_format=\"4\" main_tree_to_execute=")
    );
    assert!(old.contains("<Condition ID=\"AtDestination\" editable=\"true\"/>"), "leaves are declared: {old}");
    assert_eq!(kinds(&Tree::from_xml("new.xml", &old).unwrap()), kinds(&tree));
}

#[test]
fn attributes_and_ports_are_written_unchanged() {
    let text = r#"<root BTCPP_format="4" main_tree_to_execute="A"><BehaviorTree ID="A">
        <Parallel failure_count="2" _x="12" _description="&lt;red&gt;"><Action ID="not a name" goal="{x}" name="a &quot;b&quot;&#10;c"/>
        <SubTree ID="B" in="{x}" _autoremap="true"/></Parallel></BehaviorTree>
        <BehaviorTree ID="B"><Script code="x := 1 &amp;&amp; y &lt; 3" _skipIf="z"/></BehaviorTree>
        <BehaviorTree ID="Unused"><AlwaysFailure/></BehaviorTree>
        <TreeNodesModel><SubTree ID="B"><input_port name="in" default="7">what goes &lt;in&gt;</input_port></SubTree></TreeNodesModel></root>"#;
    let tree = Tree::from_xml("a.xml", text).unwrap();
    insta::assert_snapshot!(tree.to_xml(), @r#"
    <?xml version="1.0" encoding="UTF-8"?>
    <root BTCPP_format="4" main_tree_to_execute="A">
      <BehaviorTree ID="A">
        <Parallel failure_count="2" _x="12" _description="&lt;red&gt;">
          <Action ID="not a name" goal="{x}" name="a &quot;b&quot;&#10;c"/>
          <SubTree ID="B" in="{x}" _autoremap="true"/>
        </Parallel>
      </BehaviorTree>
      <BehaviorTree ID="B">
        <Script code="x := 1 &amp;&amp; y &lt; 3" _skipIf="z"/>
      </BehaviorTree>
      <BehaviorTree ID="Unused">
        <AlwaysFailure/>
      </BehaviorTree>
      <TreeNodesModel>
        <SubTree ID="B" editable="true">
          <input_port name="in" default="7">what goes &lt;in&gt;</input_port>
        </SubTree>
        <Action ID="not a name" editable="true">
          <inout_port name="goal"/>
        </Action>
      </TreeNodesModel>
    </root>
    "#);
    let again = Tree::from_xml("b.xml", &tree.to_xml()).unwrap();
    let attributes = |tree: &Tree| tree.nodes().iter().map(|node| node.attributes().to_vec()).collect::<Vec<_>>();
    assert_eq!(attributes(&again), attributes(&tree));
}

#[test]
fn annotations_of_tools_are_written_unchanged() {
    let text = r#"<root BTCPP_format="4" project_name="Door" xmlns:my="urn:mine" my:author="Ann"><BehaviorTree ID="A" _fullpath="" _description="opens">
        <Sequence my:color="red"><Condition ID="C1" msg="hi" my:color="blue"/><C2 there="{x}"/></Sequence></BehaviorTree>
        <TreeNodesModel><Condition ID="C2" editable="false"><description>looks &lt;twice&gt;</description><output_port name="there" type="bool" my:unit="1"/>
            <MetadataFields><Metadata color="red"/></MetadataFields></Condition>
          <Control ID="Sequence"><description>one after the other</description></Control><Control ID="Fallback"/>
          <SubTree ID="A"><description>the door</description></SubTree></TreeNodesModel></root>"#;
    let tree = Tree::from_xml("a.xml", text).unwrap();
    insta::assert_snapshot!(tree.to_xml(), @r#"
    <?xml version="1.0" encoding="UTF-8"?>
    <root BTCPP_format="4" main_tree_to_execute="A" xmlns:my="urn:mine" project_name="Door" my:author="Ann">
      <BehaviorTree ID="A" _fullpath="" _description="opens">
        <Sequence my:color="red">
          <C1 msg="hi" my:color="blue"/>
          <C2 there="{x}"/>
        </Sequence>
      </BehaviorTree>
      <TreeNodesModel>
        <SubTree ID="A" editable="true">
          <description>the door</description>
        </SubTree>
        <Condition ID="C1" editable="true">
          <inout_port name="msg"/>
        </Condition>
        <Condition ID="C2" editable="false">
          <output_port name="there" type="bool" my:unit="1"/>
          <description>looks &lt;twice&gt;</description>
          <MetadataFields><Metadata color="red"/></MetadataFields>
        </Condition>
        <Control ID="Sequence">
          <description>one after the other</description>
        </Control>
      </TreeNodesModel>
    </root>
    "#);
    let again = Tree::from_xml("b.xml", &tree.to_xml()).unwrap();
    assert_eq!(again.to_xml(), tree.to_xml());
    assert!(again.concerns().is_none(), "all ports are declared now: {:?}", again.concerns());
}

/// BehaviorTree.CPP refuses an attribute that is not among a node's ports.
#[test]
fn a_written_file_declares_every_port_that_a_leaf_uses() {
    let text = r#"<root BTCPP_format="4" main_tree_to_execute="A">
        <BehaviorTree ID="A"><Sequence><Action ID="Say" msg="hi"/><SubTree ID="B"/></Sequence></BehaviorTree>
        <BehaviorTree ID="B"><Action ID="Say" msg="ho" volume="{v}" name="louder"/></BehaviorTree></root>"#;
    let written = Tree::from_xml("a.xml", text).unwrap().to_xml();
    let ports: Vec<&str> = written.lines().filter(|line| line.contains("_port")).map(str::trim).collect();
    assert_eq!(ports, [r#"<inout_port name="msg"/>"#, r#"<inout_port name="volume"/>"#]);
}

#[test]
fn a_written_file_declares_the_namespaces_of_all_files() {
    let main = r#"<root BTCPP_format="4" main_tree_to_execute="M"><include path="part.xml"/>
        <BehaviorTree ID="M"><SubTree ID="P"/></BehaviorTree></root>"#;
    let part = r#"<root BTCPP_format="4" project_name="Part"><BehaviorTree ID="P">
        <AlwaysSuccess xmlns:my="urn:mine" my:color="red"/></BehaviorTree></root>"#;
    let tree = Loader::default().load_with("main.xml", main, reader(&[("part.xml", part)])).unwrap();
    let written = tree.to_xml();
    assert!(written.contains(r#"main_tree_to_execute="M" xmlns:my="urn:mine">"#), "{written}");
    assert_eq!(Tree::from_xml("again.xml", &written).unwrap().to_xml(), written);
}

#[test]
fn version_3_ports_have_their_new_names() {
    let text = r#"<root><BehaviorTree ID="T"><Parallel success_threshold="1" failure_threshold="2"><AlwaysSuccess/><AlwaysFailure/></Parallel></BehaviorTree></root>"#;
    let tree = Tree::from_xml("old.xml", text).unwrap();
    assert_eq!(tree.nodes()[0].attribute("success_count"), Some("1"));
    assert_eq!(tree.nodes()[0].attribute("failure_count"), Some("2"));
}

#[test]
fn messages_use_the_port_names_of_the_file() {
    for port in ["success_threshold", "failure_threshold", "success_count"] {
        let node = format!("<Parallel {port}=\"\"><AlwaysSuccess/></Parallel>");
        let text = format!("<root><BehaviorTree ID=\"T\">{node}</BehaviorTree></root>");
        let error = Tree::from_xml("t.xml", &text).unwrap_err();
        let reported = error.problems()[0].to_string();
        assert!(reported.starts_with(&format!("the port `{port}`")), "{reported}");
    }
}

#[test]
fn a_blank_line_before_the_xml_declaration_is_reported_as_such() {
    let text = "\n<?xml version=\"1.0\"?><root><BehaviorTree ID=\"T\"><AlwaysSuccess/></BehaviorTree></root>";
    let error = Tree::from_xml("t.xml", text).unwrap_err();
    assert!(
        error.problems()[0].to_string().contains("`<?xml …?>` must be at the very beginning of the file"),
        "{:?}",
        error.problems()
    );
}
