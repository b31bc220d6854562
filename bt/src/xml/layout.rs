//! The canonical layout of tree files.

use std::io;
use std::path::Path;

use diagnostics::{LineEnds, Problem, Source, xml};
use miette::SourceSpan;
use roxmltree::{Document, Node as Element};

use super::document::parse;
use super::loader::Loader;
use crate::{Node, Tree, TreeError};

/// White space is a value nowhere in a tree file but in elements with text, such as the description of a port.
const HAS_VALUE: xml::HasValue<'static> = &|_: Element<'_, '_>| false;

/// The text of a tree file in its canonical layout: comments, Groot2's models and everything unknown are kept. Only
/// white space between tags and attributes, quotes, and the form of empty elements change. The layout of the result is
/// the result.
///
/// The file need not be complete: it may be included by others, or use leaves that are declared elsewhere. What follows
/// from it does not change: both texts, with the files that they include by way of `read`, load as equal trees, or are
/// refused with equally many problems.
///
/// ```
/// let text = r#"<root BTCPP_format="4"><BehaviorTree ID="Wave"> <Action ID = 'Wave'/> </BehaviorTree></root>"#;
/// let refuse = |_: &std::path::Path| Err(std::io::Error::other("no other file"));
/// assert_eq!(bt::layout("wave.xml", text, refuse)?, r#"<root BTCPP_format="4">
///   <BehaviorTree ID="Wave">
///     <Action ID="Wave"/>
///   </BehaviorTree>
/// </root>
/// "#);
/// # Ok::<(), bt::TreeError>(())
/// ```
///
/// # Errors
/// A [`TreeError`] if the text is not well-formed XML, or its outermost element is not `<root>`.
pub fn layout(
    file: impl AsRef<Path>,
    text: &str,
    read: impl Fn(&Path) -> io::Result<String>,
) -> Result<String, TreeError> {
    let (file, loader) = (file.as_ref(), Loader::default());
    let refused = |problem| TreeError::new(Source::new(&file.display().to_string(), text), vec![problem]);
    parse(text, &loader).map_err(refused)?;
    let plain = LineEnds::plain(text);
    let before = parse(&plain, &loader).map_err(refused)?;
    let laid_out = xml::layout(&before, HAS_VALUE).map_err(refused)?;
    let after = parse(&laid_out, &loader).map_err(refused)?;
    let [old, new] = [&*plain, &laid_out].map(|text| loader.load_with(file, text, &read));
    if xml::is_same(&before, &after, HAS_VALUE) && is_alike(&old, &new) {
        Ok(LineEnds::of(text).write(laid_out))
    } else {
        Err(refused(Problem::of_layout()))
    }
}

/// Whether both are the same tree, wherever its nodes are written, or are refused alike.
fn is_alike(one: &Result<Tree, TreeError>, other: &Result<Tree, TreeError>) -> bool {
    let count = |error: &TreeError| {
        error.problems().len() + error.included().iter().map(|file| file.problems().len()).sum::<usize>()
    };
    match (one, other) {
        (Ok(one), Ok(other)) => {
            let nodes = |tree: &Tree| -> Vec<Node> {
                tree.nodes.iter().map(|node| Node { span: SourceSpan::from(0..0), ..node.clone() }).collect()
            };
            // What is kept to be written back may contain white space between tags.
            let [written, others] = [one, other].map(Tree::to_xml);
            let contents = |text| Document::parse(text).ok();
            one.name == other.name
                && nodes(one) == nodes(other)
                && one.program == other.program
                && one.concerns.as_ref().map(count) == other.concerns.as_ref().map(count)
                && match (contents(&written), contents(&others)) {
                    (Some(written), Some(others)) => xml::is_same(&written, &others, HAS_VALUE),
                    // With a prefix that no element declares, for example.
                    _ => written == others,
                }
        }
        (Err(one), Err(other)) => count(one) == count(other),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_is_like_itself_alone() {
        let load = |body: &str| {
            let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">{body}</BehaviorTree></root>");
            Tree::from_xml("tree.xml", &text)
        };
        let bodies = [
            "<Action ID=\"A\"/>",
            "<Action ID=\"A\" x=\"1\"/>",
            "<Action ID=\"B\"/>",
            "<Sleep msec=\"1\"/>",
            "<Nope/>",
        ];
        for (place, one) in bodies.iter().enumerate() {
            for (other_place, other) in bodies.iter().enumerate() {
                assert_eq!(is_alike(&load(one), &load(&format!(" {other}"))), place == other_place, "{one} {other}");
            }
        }
    }
}
