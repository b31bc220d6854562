//! Mutations: trees with one additional mistake.
//!
//! A mutation is a small change of a tree's main file, of the kind that people make by accident: another control node,
//! children in the wrong order, a missing node, an inverted leaf.

use std::ops::Range;

use roxmltree::{Document, Node as Element};

use crate::{Kind, Tree};

/// A tree with one additional mistake.
#[derive(Debug)]
pub struct Mutant {
    /// The mistake in words: `ReactiveFallback on line 9 is a Fallback`.
    pub words: String,
    /// The tree.
    pub tree: Tree,
}

/// All mutations of a tree's main file after which it can still be loaded, in the order of the file.
///
/// - Every sequence becomes a fallback and vice versa; reactive nodes stay reactive. Every reactive node becomes an
///   ordinary one and vice versa.
/// - Every child of a control node is removed, or swapped with the next one.
/// - Every leaf is inverted.
///
/// ```
/// let tree = bt::Tree::from_xml("recharge.xml", bt::RECHARGE)?;
/// let mutants = bt::mutants(&tree);
/// assert!(mutants.iter().any(|mutant| mutant.words == "BatteryLevel on line 13 is inverted"));
/// assert!(mutants.iter().all(|mutant| mutant.tree.name() == tree.name()));
/// # Ok::<(), bt::TreeError>(())
/// ```
#[must_use]
pub fn mutants(tree: &Tree) -> Vec<Mutant> {
    let source = tree.source();
    let Ok(document) = Document::parse(source.text()) else { return Vec::new() };
    let is_definition = |element: Element<'_, '_>| element.has_tag_name("BehaviorTree");
    let is_node = |element: &Element<'_, '_>| element.is_element() && element.ancestors().skip(1).any(is_definition);
    let sound = shape(tree);
    let changes = document.descendants().filter(is_node).flat_map(|element| changes(source.text(), element));
    let mutant = |(words, edits): (String, Vec<Edit>)| {
        let tree = Tree::from_xml(source.name(), &edited(source.text(), edits)).ok()?;
        // Changing a leaf that no used tree contains would change nothing.
        (shape(&tree) != sound).then_some(Mutant { words, tree })
    };
    changes.filter_map(mutant).collect()
}

/// A range of the text, and its replacement.
type Edit = (Range<usize>, String);

/// What distinguishes trees with the same leaves: the nodes and their parents.
fn shape(tree: &Tree) -> Vec<(Kind, &str, Option<usize>)> {
    tree.nodes().iter().map(|node| (node.kind(), node.label(), node.parent().map(crate::NodeId::index))).collect()
}

/// The changes of a node, in words and as edits.
fn changes(text: &str, element: Element<'_, '_>) -> Vec<(String, Vec<Edit>)> {
    let mut changes = Vec::new();
    let name = name_of(text, element);
    for other in others(element.tag_name().name()) {
        changes.push((format!("{name} is a {other}"), renamed(text, element, other)));
    }
    if element.first_element_child().is_none() {
        let range = element.range();
        let inverted = format!("<Inverter>{}</Inverter>", &text[range.clone()]);
        changes.push((format!("{name} is inverted"), vec![(range, inverted)]));
    }
    let siblings = element.parent_element().map_or(0, |parent| parent.children().filter(Element::is_element).count());
    if siblings > 1 {
        changes.push((format!("{name} is missing"), vec![(element.range(), String::new())]));
    }
    if let Some(next) = element.next_sibling_element() {
        let [here, there] = [element.range(), next.range()];
        let edits = vec![(here.clone(), text[there.clone()].to_owned()), (there, text[here].to_owned())];
        changes.push((format!("{name} and {} swap places", name_of(text, next)), edits));
    }
    changes
}

/// The kinds with which a kind is easily confused.
fn others(kind: &str) -> &'static [&'static str] {
    match kind {
        "Sequence" => &["Fallback", "ReactiveSequence"],
        "Fallback" => &["Sequence", "ReactiveFallback"],
        "ReactiveSequence" => &["ReactiveFallback", "Sequence"],
        "ReactiveFallback" => &["ReactiveSequence", "Fallback"],
        _ => &[],
    }
}

/// A node by its name, its ID or its kind, and its line.
fn name_of(text: &str, element: Element<'_, '_>) -> String {
    let named = ["name", "ID"].into_iter().find_map(|attribute| element.attribute(attribute));
    let line = 1 + text[..element.range().start].matches('\n').count();
    format!("{} on line {line}", named.unwrap_or(element.tag_name().name()))
}

fn renamed(text: &str, element: Element<'_, '_>, other: &str) -> Vec<Edit> {
    let (range, length) = (element.range(), element.tag_name().name().len());
    let begin = range.start + 1;
    let mut edits = vec![(begin..begin + length, other.to_owned())];
    if !text[range.clone()].ends_with("/>") {
        let end = text[range.clone()].rfind("</").map_or(range.end, |offset| range.start + offset + 2);
        edits.push((end..end + length, other.to_owned()));
    }
    edits
}

/// The text with these edits, which do not overlap and are in order.
fn edited(text: &str, edits: Vec<Edit>) -> String {
    let mut edited = text.to_owned();
    edits.into_iter().rev().for_each(|(range, replacement)| edited.replace_range(range, &replacement));
    edited
}
