//! Files with mistakes: every mistake is reported, at its place.

use std::fmt::Write;

use bt::{Loader, RECHARGE, Tree, TreeError};
use miette::Diagnostic;
use proptest::prelude::*;

/// The diagnostic in short: for each problem what it says, what it points at with line and column, and its help.
fn report(text: &str, error: &TreeError) -> String {
    let mut out = format!("{error}\n");
    for problem in error.problems() {
        writeln!(out, "{problem}").unwrap();
        for label in problem.labels().into_iter().flatten() {
            let before = &text[..label.offset()];
            let (line, start) = (before.matches('\n').count() + 1, before.rfind('\n').map_or(0, |end| end + 1));
            let (column, pointed_at) = (before[start..].chars().count() + 1, &text[label.offset()..][..label.len()]);
            writeln!(out, "  {line}:{column} {pointed_at:?} {}", label.label().unwrap_or_default()).unwrap();
        }
        if let Some(help) = problem.help() {
            writeln!(out, "  help: {help}").unwrap();
        }
    }
    out
}

fn refused(text: &str) -> String {
    report(text, &Tree::from_xml("broken.xml", text).unwrap_err())
}

fn snapshot(name: &str, report: String) {
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!(name, report);
    });
}

#[test]
fn mistakes_in_nodes() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <Fallbck> <Action ID="Inside"/> </Fallbck>
      <ReactiveFallback/>
      <Inverter> <Action ID="A"/> <Action ID="B"/> </Inverter>
      <Action/>
      <Condition ID=""/>
      <Action ID="Sequence"/>
      <Action ID="A"> <AlwaysSuccess/> </Action>
      <Condition ID="A"/>
      <Parallel success_count="2"> <Sleep msec="5"/> </Parallel>
      <Action ID="C" _skipIf="battery &lt; 30"/>
      <GoThere/>
      <Wait ID="Other"/>
      <Control ID="MyControl"> <AlwaysSuccess/> </Control>
      <YourDecorator> <AlwaysSuccess/> </YourDecorator>
      <Control ID="Sequense"> <AlwaysSuccess/> </Control>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="Wait"/>
    <Action/>
    <Actoin ID="X"/>
    <Decorator ID="YourDecorator"/>
  </TreeNodesModel>
</root>"#;
    snapshot("nodes", refused(text));
}

#[test]
fn mistakes_in_trees() {
    let text = r#"<root BTCPP_format="5" main_tree_to_execute="Mian">
  <include path="other.xml"/>
  <BehaviorTree ID="Main"> <SubTree ID="Chrage"/> </BehaviorTree>
  <BehaviorTree ID="Charge"> <Sequence> <SubTree ID="Drive"/> </Sequence> </BehaviorTree>
  <BehaviorTree ID="Drive"> <Sequence> <SubTree ID="Charge"/> <Charge/> </Sequence> </BehaviorTree>
  <BehaviorTree ID="Main"> <AlwaysSuccess/> <AlwaysFailure/> </BehaviorTree>
  <BehaviorTree> </BehaviorTree>
  <BehaviourTree ID="Spelled"> <AlwaysSuccess/> </BehaviourTree>
  <Remark/>
  <TreeNodesModel/>
  <TreeNodesModel/>
</root>"#;
    snapshot("trees", refused(text));
}

#[test]
fn mistakes_in_files() {
    let two = r#"<root><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree><BehaviorTree ID="B"><AlwaysSuccess/></BehaviorTree></root>"#;
    let files = [
        "",
        "<root>\n  <BehaviorTree>",
        "<root>\n  <Bäume>\n    <Sequence></Fallback>\n  </Bäume>\n</root>",
        "<root>\n  <!-- ü --> <BehaviorTree ID=Main/>\n</root>",
        "<!DOCTYPE root [<!ENTITY a \"b\">]><root/>",
        "<scxml/>",
        "<root main_tree_to_execute=\"Main\"/>",
        two,
    ];
    snapshot("files", files.map(refused).join("\n"));
}

#[test]
fn a_problem_that_the_surroundings_find_is_shown_at_its_place() {
    let tree = Tree::from_xml("recharge.xml", RECHARGE).unwrap();
    let leaf = tree.leaves().find(|leaf| leaf.type_id() == "WaitForUser").unwrap();
    let problem =
        tree.problem_at(leaf.id(), "there is no skill `WaitForUser`", "no skill", "did you mean `WaitForUsers`?");
    snapshot("surroundings", report(RECHARGE, &tree.error(vec![problem])));
}

fn nested(depth: usize) -> String {
    let (open, close) = ("<Sequence>".repeat(depth), "</Sequence>".repeat(depth));
    format!("<root><BehaviorTree>{open}<AlwaysSuccess/>{close}</BehaviorTree></root>")
}

#[test]
fn deep_nesting_is_refused() {
    assert!(Tree::from_xml("deep.xml", &nested(255)).is_ok());
    for depth in [256, 1000, 200_000] {
        let error = Tree::from_xml("deep.xml", &nested(depth)).unwrap_err();
        assert_eq!(error.problems().len(), 1);
        assert_eq!(error.problems()[0].to_string(), "nodes are nested more than 256 deep");
    }
}

#[test]
fn deep_nesting_by_subtrees_is_refused() {
    let tree =
        |n: usize| format!(r#"<BehaviorTree ID="T{n}"><Inverter><SubTree ID="T{}"/></Inverter></BehaviorTree>"#, n + 1);
    let trees: String = (0..200).map(tree).collect();
    let text = format!(
        r#"<root main_tree_to_execute="T0">{trees}<BehaviorTree ID="T200"><AlwaysSuccess/></BehaviorTree></root>"#
    );
    let error = Tree::from_xml("deep.xml", &text).unwrap_err();
    assert_eq!(error.problems()[0].to_string(), "nodes are nested more than 256 deep");
    assert!(Loader::default().max_depth(500).load("deep.xml", &text).is_ok());
}

#[test]
fn a_tree_that_doubles_with_every_subtree_is_refused() {
    let twice = |n: usize| {
        let sub = format!(r#"<SubTree ID="T{}"/>"#, n + 1);
        format!(r#"<BehaviorTree ID="T{n}"><Sequence>{sub}{sub}</Sequence></BehaviorTree>"#)
    };
    let trees: String = (0..60).map(twice).collect();
    let text = format!(
        r#"<root main_tree_to_execute="T0">{trees}<BehaviorTree ID="T60"><AlwaysSuccess/></BehaviorTree></root>"#
    );
    let error = Tree::from_xml("bomb.xml", &text).unwrap_err();
    assert_eq!(error.problems()[0].to_string(), "this is too large: more than 100000 nodes");
}

#[test]
fn a_file_of_nothing_but_mistakes_is_refused_in_good_time() {
    let mistakes: String = (0..50_000).map(|n| format!(r#"<Sequenc{n}/><SubTree ID="T{n}"/>"#)).collect();
    let trees: String =
        (0..20_000).map(|n| format!(r#"<BehaviorTree ID="Tree{n}"><AlwaysSuccess/></BehaviorTree>"#)).collect();
    let text = format!(r#"<root><BehaviorTree ID="Main"><Sequence>{mistakes}</Sequence></BehaviorTree>{trees}</root>"#);
    let error = Tree::from_xml("mistakes.xml", &text).unwrap_err();
    assert_eq!(error.problems().len(), 100_001);
}

/// Elements, attributes and scraps of text that make many kinds of nonsense.
fn scrap() -> impl Strategy<Value = String> {
    let names = [
        "root",
        "BehaviorTree",
        "TreeNodesModel",
        "Sequence",
        "Inverter",
        "SubTree",
        "Action",
        "Condition",
        "Control",
        "AlwaysSuccess",
        "Parallel",
        "Foo",
        "include",
    ];
    let attributes = [
        "",
        " ID=\"A\"",
        " ID=\"Sequence\"",
        " ID=\"\"",
        " name=\"n\"",
        " _while=\"x\"",
        " main_tree_to_execute=\"A\"",
        " ID='B' BTCPP_format='4'",
    ];
    let element = (prop::sample::select(names.to_vec()), prop::sample::select(attributes.to_vec()));
    let leaf = element.clone().prop_map(|(name, attributes)| format!("<{name}{attributes}/>"));
    leaf.prop_recursive(6, 40, 4, move |inner| {
        (element.clone(), prop::collection::vec(inner, 0..4))
            .prop_map(|((name, attributes), inside)| format!("<{name}{attributes}>{}</{name}>", inside.concat()))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_file_makes_the_loader_panic(inside in prop::collection::vec(scrap(), 0..4), cut in any::<prop::sample::Index>()) {
        let text = format!("<root>{}</root>", inside.concat());
        for text in [text.as_str(), &text[..cut.index(text.len())]] {
            if let Err(error) = Tree::from_xml("fuzz.xml", text) {
                prop_assert!(!error.problems().is_empty());
                report(text, &error);
            }
        }
    }

    #[test]
    fn no_text_makes_the_loader_panic(text in "\\PC*") {
        if let Err(error) = Tree::from_xml("fuzz.xml", &text) {
            report(&text, &error);
        }
    }
}
