//! The layout of tree files changes nothing, and is that of its result.

use std::path::Path;

use bt::layout;
use proptest::prelude::*;

use crate::disturbed::disturbed;
use crate::forest::{spec, wild_tree};

/// The layout of a text, which includes nothing; its layout must be itself.
fn laid_out(text: &str) -> String {
    let alone = |_: &Path| Err(std::io::Error::other("no other file"));
    let once = layout("tree.xml", text, alone).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    assert_eq!(layout("tree.xml", &once, alone).unwrap(), once, "{text}");
    once
}

#[test]
fn groot2s_models_comments_and_unknown_parts_are_kept() {
    let text = r#"<?xml version='1.0'?><!-- before -->
<root  BTCPP_format = "4" project="a"><include path='other.xml'/>
<BehaviorTree ID='T' _fullpath=""><!-- what
          it does --><Fallback><Foo  x="{y}&#10;&gt;" _z='"'/> <!-- same line -->

<!-- above -->


<Script code="a := 1;
  b := 2" name="set"/></Fallback></BehaviorTree>
<TreeNodesModel><Action ID="Foo" editable="true"><input_port name="x" type="int">  how
   much </input_port><MetadataFields><Metadata  a="b"/></MetadataFields></Action></TreeNodesModel>
<Unknown/><?keep  it?></root>"#;
    let expected = r#"<?xml version='1.0'?>
<!-- before -->
<root BTCPP_format="4" project="a">
  <include path="other.xml"/>
  <BehaviorTree ID="T" _fullpath=""> <!-- what
             it does -->
    <Fallback>
      <Foo x="{y}&#10;&gt;" _z='"'/> <!-- same line -->

      <!-- above -->

      <Script code="a := 1;
  b := 2"
              name="set"/>
    </Fallback>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="Foo" editable="true">
      <input_port name="x" type="int">  how
   much </input_port>
      <MetadataFields>
        <Metadata a="b"/>
      </MetadataFields>
    </Action>
  </TreeNodesModel>
  <Unknown/>
  <?keep  it?>
</root>
"#;
    assert_eq!(laid_out(text), expected);
}

#[test]
fn a_file_that_is_only_a_part_of_others_is_laid_out() {
    let tree = |id: &str, node: &str| format!("<BehaviorTree ID='{id}'>{node}</BehaviorTree>");
    let text = &format!("<root>{}{}</root>", tree("A", "<Undeclared/>"), tree("B", "<SubTree ID='C'/>"));
    assert!(bt::Tree::from_xml("part.xml", text).is_err());
    assert_eq!(laid_out(text).lines().count(), 8);
}

#[test]
fn a_text_that_is_no_tree_file_is_refused() {
    for text in ["", "<root>", "<root a=1/>", "<scxml/>", "property p := true"] {
        assert!(layout("tree.xml", text, |_| Err(std::io::Error::other("no"))).is_err(), "{text}");
    }
}

#[test]
fn line_ends_are_kept_and_a_byte_order_mark_is_not() {
    let text = "<root><BehaviorTree ID='A'>\n<Action ID='B'/></BehaviorTree></root>";
    let windows = format!("\u{feff}{}", text.replace('\n', "\r\n"));
    assert_eq!(laid_out(&windows), laid_out(text).replace('\n', "\r\n"));
}

#[test]
fn every_tree_of_this_repository_keeps_its_meaning() {
    let folders =
        ["trees", "trees/nav2", "models", "tests/answers", "tests/nav2", "groot/tests/captured", "logs/tests/captured"];
    let mut count = 0;
    for folder in folders {
        for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            if diagnostics::xml::root_name(&text) == Some("root") {
                laid_out(&text);
                count += 1;
            }
        }
    }
    assert_eq!(count, 12, "the number of trees here");
}

/// How many random files.
fn cases() -> u32 {
    std::env::var("LAYOUTS").ok().and_then(|number| number.parse().ok()).unwrap_or(100)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn random_trees_keep_their_meaning(
        tree in wild_tree(),
        plain in spec(),
        numbers in prop::collection::vec(any::<u8>(), 1..200),
    ) {
        for tree in [&tree, &plain.tree()] {
            for text in [tree.source().text(), &tree.to_xml()] {
                laid_out(&disturbed(text, &numbers));
            }
        }
    }
}
