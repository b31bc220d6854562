//! Files with mistakes: every mistake is reported, with its location.

use std::fmt::Write;

use bt::{Kind, Loader, RECHARGE, Tree, TreeError};
use miette::Diagnostic;
use proptest::prelude::*;

/// The diagnostic in short form: for each problem its message, its marked text with line and column, and its help.
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
fn an_element_closed_by_another_name_is_reported_as_misspelled() {
    let reported =
        |body: &str| refused(&format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">{body}</BehaviorTree></root>"));
    let secuence = reported("<Secuence><A/></Sequence>");
    assert!(secuence.contains("help: <Secuence> ends as </Sequence>: did you mean <Sequence>?"), "{secuence}");
    let falback = reported("<Fallback><A/></Falback>");
    assert!(falback.contains("help: <Fallback> ends as </Falback>: did you mean <Fallback>?"), "{falback}");
    assert!(!reported("<Fallback><A/></Repeat>").contains("help:"));
}

#[test]
fn broken_1_unknown_nodes() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <Fallbck> <Action ID="Inside"/> </Fallbck>
      <GoThere/>
      <Main/>
      <Control ID="MyControl"> <AlwaysSuccess/> </Control>
      <YourDecorator> <AlwaysSuccess/> </YourDecorator>
      <Control ID="Sequense"> <AlwaysSuccess/> </Control>
      <BlackboardCheckInt value_A="{x}" value_B="1"> <AlwaysSuccess/> </BlackboardCheckInt>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Decorator ID="YourDecorator"/>
  </TreeNodesModel>
</root>"#;
    snapshot("broken_1", refused(text));
}

#[test]
fn broken_2_ids_and_categories() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <Action/>
      <Condition ID=""/>
      <Action ID="Sequence"/>
      <Action ID="A"/>
      <Condition ID="A"/>
      <Wait ID="Other"/>
      <Condition ID="Wait"/>
      <SubTree/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="Wait"/>
    <Action/>
    <Actoin ID="X"/>
    <Action ID="Inverter"/>
  </TreeNodesModel>
</root>"#;
    snapshot("broken_2", refused(text));
}

#[test]
fn broken_3_numbers_of_children() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <ReactiveFallback/>
      <Inverter> <Action ID="A"/> <Action ID="B"/> </Inverter>
      <Action ID="A"> <AlwaysSuccess/> </Action>
      <IfThenElse> <Action ID="A"/> </IfThenElse>
      <WhileDoElse> <AlwaysSuccess/> <AlwaysSuccess/> <AlwaysSuccess/> <AlwaysSuccess/> </WhileDoElse>
      <TryCatch> <Action ID="A"/> </TryCatch>
      <Switch3 variable="{x}" case_1="1" case_2="2" case_3="3"> <Action ID="A"/> </Switch3>
      <Script code="x := 1"> <AlwaysSuccess/> </Script>
    </Sequence>
  </BehaviorTree>
</root>"#;
    snapshot("broken_3", refused(text));
}

#[test]
fn broken_4_trees_and_subtrees() {
    let text = r#"<root BTCPP_format="5" main_tree_to_execute="Mian">
  <BehaviorTree ID="Main"> <SubTree ID="Chrage"/> </BehaviorTree>
  <BehaviorTree ID="Charge"> <Sequence> <SubTree ID="Drive"/> </Sequence> </BehaviorTree>
  <BehaviorTree ID="Drive"> <Sequence> <SubTree ID="Charge"/> <Charge/> </Sequence> </BehaviorTree>
  <BehaviorTree ID="Main"> <AlwaysSuccess/> <AlwaysFailure/> </BehaviorTree>
  <BehaviorTree> </BehaviorTree>
  <BehaviorTree ID="Fallback"> <AlwaysSuccess/> </BehaviorTree>
  <BehaviourTree ID="Spelled"> <AlwaysSuccess/> </BehaviourTree>
  <Remark/>
  <TreeNodesModel/>
  <TreeNodesModel/>
</root>"#;
    snapshot("broken_4", refused(text));
}

#[test]
fn broken_5_ports_that_are_missing_or_misspelled() {
    let text = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence>
      <Repeat> <AlwaysSuccess/> </Repeat>
      <Repeat num_cycle="3"> <AlwaysSuccess/> </Repeat>
      <Parallel sucess_count="1"> <AlwaysSuccess/> </Parallel>
      <Delay> <Timeout> <Sleep/> </Timeout> </Delay>
      <SetBlackboard output_key="x"/>
      <UnsetBlackboard/>
      <SkipUnlessUpdated> <Script/> </SkipUnlessUpdated>
      <LoopInt> <Precondition> <ScriptCondition/> </Precondition> </LoopInt>
      <GoTo gaol="home"/>
      <Sequence color="red"> <AlwaysSuccess/> </Sequence>
      <Repeat num_cycles="2" foo="3" onSuccess="x := 1"> <AlwaysSuccess _skipIff="x" _secret="7" _uid="4"/> </Repeat>
      <GoTo goal="home" color="red"/>
      <SubTree ID="Other" color="red" _description="any name may be remapped" _autoremp="true"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="GoTo"> <input_port name="goal"/> <input_port/> <output_port name="ID"/> </Action>
  </TreeNodesModel>
  <BehaviorTree ID="Other"> <AlwaysSuccess/> </BehaviorTree>
</root>"#;
    snapshot("broken_5", refused(text));
}

#[test]
fn an_unknown_script_attribute_is_a_warning() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence _skipIff="x" _onsuccess="x := 1" _secret="7" _description="a" _fullpath="b" _uid="1" _skipIf="false">
      <Action ID="Undeclared" color="red" _while="true"/>
    </Sequence>
  </BehaviorTree>
</root>"#;
    let tree = Tree::from_xml("odd.xml", text).unwrap();
    let concerns = tree.concerns().unwrap();
    assert!(!concerns.is_error());
    insta::assert_snapshot!(report(text, concerns), @r#"
    odd.xml can be used, with warnings
    unknown attribute `_skipIff`
      3:15 "_skipIff=\"x\"" has no effect
      help: did you mean `_skipIf`?
    unknown attribute `_onsuccess`
      3:28 "_onsuccess=\"x := 1\"" has no effect
      help: did you mean `_onSuccess`?
    unknown attribute `_secret`
      3:48 "_secret=\"7\"" has no effect
      help: the scripts are `_failureIf`, `_successIf`, `_skipIf`, `_while`, `_onHalted`, `_onFailure`, `_onSuccess`, `_post`
    "#);
    assert!(Tree::from_xml("recharge.xml", RECHARGE).unwrap().concerns().is_none());
}

/// As in BehaviorTree.CPP, which says "a port with name [foo] is found in the XML but not in the providedPorts()".
#[test]
fn built_in_nodes_accept_only_their_own_ports() {
    for kind in Kind::BUILTIN {
        let element = kind.category().element();
        let node = format!(r#"<{element} ID="{kind}" zzz="1"/>"#);
        let reported = refused(&format!(r#"<root><BehaviorTree ID="T">{node}</BehaviorTree></root>"#));
        assert!(reported.contains(&format!("{kind} has no port `zzz`\n")), "{reported}");
    }
}

#[test]
fn broken_6_values_of_ports() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <Repeat num_cycles="often"> <AlwaysSuccess/> </Repeat>
      <Delay delay_msec="-5"> <AlwaysSuccess/> </Delay>
      <RunOnce then_skip="maybe"> <AlwaysSuccess/> </RunOnce>
      <Parallel success_count="3" failure_count="99999999999"> <AlwaysSuccess/> </Parallel>
      <ParallelAll max_failures="2"> <AlwaysSuccess/> </ParallelAll>
      <Precondition if="true" else="failure"> <AlwaysSuccess/> </Precondition>
      <LoopInt queue="1;two;3"> <AlwaysSuccess/> </LoopInt>
      <LoopDouble queue="1.5;2" if_empty="NOTHING"> <AlwaysSuccess/> </LoopDouble>
      <GoTo speed="fast" tries="1.5"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="GoTo">
      <input_port name="speed" type="double" default="quick"/>
      <input_port name="tries" type="int"/>
    </Action>
  </TreeNodesModel>
</root>"#;
    snapshot("broken_6", refused(text));
}

#[test]
fn broken_7_scripts() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <Script code="x := "/>
      <Script code=""/>
      <Script code="1 + 2 = x"/>
      <Script code="x := (1 + 2; y := 3"/>
      <ScriptCondition code="x == 'open"/>
      <ScriptCondition code="x # 3"/>
      <ScriptCondition code="12abc &lt; 3"/>
      <Script code="{script}"/>
      <Precondition if="x ? 1"> <AlwaysSuccess/> </Precondition>
      <AlwaysSuccess _skipIf="x ==" _while="&amp;&amp; x" _onSuccess="y = 1 2" _post="0x := 3"/>
    </Sequence>
  </BehaviorTree>
</root>"#;
    snapshot("broken_7", refused(text));
}

#[test]
fn broken_8_types_of_entries() {
    let text = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>
      <Find pose="{goal}" found="{yes}"/>
      <GoTo goal="{goal}"/>
      <Repeat num_cycles="{goal}"> <GoTo goal="{yes}"/> </Repeat>
      <Delay delay_msec="{yes}"> <AlwaysSuccess/> </Delay>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="Find"> <output_port name="pose" type="Pose2D"/> <output_port name="found" type="bool"/> </Action>
    <Action ID="GoTo"> <input_port name="goal" type="geometry_msgs::Pose"/> </Action>
  </TreeNodesModel>
</root>"#;
    snapshot("broken_8", refused(text));
}

#[test]
fn broken_9_subtrees_without_required_ports() {
    let text = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence>
      <SubTree ID="Drive"/>
      <SubTree ID="Drive" goal="home"/>
      <SubTree ID="Drive" _autoremap="perhaps"/>
      <SubTree ID="Drive" goal="{x}" _skipIf="x =="> <AlwaysSuccess/> </SubTree>
      <SubTree ID="Main"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Drive"> <Action ID="Go" goal="{goal}"/> </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Drive"> <input_port name="goal"/> <input_port name="speed" default="1"/> </SubTree>
  </TreeNodesModel>
</root>"#;
    snapshot("broken_9", refused(text));
}

#[test]
fn broken_10_files_that_include_others() {
    let main = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
  <include path="parts/arm.xml"/>
  <include path="parts/missing.xml"/>
  <include ros_pkg="robot" path="tree.xml"/>
  <include/>
  <BehaviorTree ID="Main"> <Sequence> <SubTree ID="Arm"/> <SubTree ID="Leg"/> </Sequence> </BehaviorTree>
</root>"#;
    let arm = r#"<root BTCPP_format="4">
  <include path="hand.xml"/>
  <BehaviorTree ID="Arm"> <Sequence> <Lift/> <SubTree ID="Hand"/> </Sequence> </BehaviorTree>
</root>"#;
    let hand = "<root BTCPP_format=\"4\">\n  <BehaviorTree ID=\"Hand\"> <Repeat/> </BehaviorTree>\n</rot>";
    let files = [("parts/arm.xml", arm), ("parts/hand.xml", hand)];
    let read = |path: &std::path::Path| {
        let found = files.iter().find(|(name, _)| std::path::Path::new(name) == path);
        found.map(|(_, text)| (*text).to_owned()).ok_or_else(|| std::io::Error::other("no such file"))
    };
    let error = Loader::default().load_with("main.xml", main, read).unwrap_err();
    let mut all = report(main, &error);
    for included in error.included() {
        let text = files.iter().find(|(name, _)| *name == included.file()).unwrap().1;
        all.push_str(&report(text, included));
    }
    snapshot("broken_10", all);
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
fn a_problem_of_the_environment_is_shown_with_its_location() {
    let tree = Tree::from_xml("recharge.xml", RECHARGE).unwrap();
    let leaf = tree.leaves().find(|leaf| leaf.type_id() == "WaitForUser").unwrap();
    let problem =
        tree.problem_at(leaf.id(), "there is no skill `WaitForUser`", "no skill", "did you mean `WaitForUsers`?");
    snapshot("surroundings", report(RECHARGE, &tree.error(&[problem])));
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
fn a_file_with_nothing_but_mistakes_is_refused_quickly() {
    let mistakes: String = (0..50_000).map(|n| format!(r#"<Sequenc{n}/><SubTree ID="T{n}"/>"#)).collect();
    let trees: String =
        (0..20_000).map(|n| format!(r#"<BehaviorTree ID="Tree{n}"><AlwaysSuccess/></BehaviorTree>"#)).collect();
    let text = format!(r#"<root><BehaviorTree ID="Main"><Sequence>{mistakes}</Sequence></BehaviorTree>{trees}</root>"#);
    let error = Tree::from_xml("mistakes.xml", &text).unwrap_err();
    assert_eq!(error.problems().len(), 100_001);
}

/// Elements, attributes and pieces of text that combine to many kinds of nonsense.
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
