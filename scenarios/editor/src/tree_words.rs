//! Elements and attributes of trees, from the tables that their parser uses.

use std::collections::BTreeSet;
use std::ops::Range;

use bt::{Kind, PortForm, Tree, builtin_ports};
use diagnostics::markup::attribute as attribute_text;

use crate::expressions::word_in;
use crate::knowledge::Knowledge;
use crate::proposal::{Explanation, Proposal, ProposalKind};
use crate::xml_place::{Tag, XmlCursor, XmlPlace, elements, place};

/// What every node means. The page is written from the code.
const NODES: &str = include_str!("../../../docs/src/reference/nodes.md");

/// What may be written at a place of a tree.
pub(crate) fn proposals(text: &str, at: usize, known: &Knowledge) -> Vec<Proposal> {
    let Some(XmlCursor { place, around, word }) = place(text, at) else { return Vec::new() };
    match place {
        XmlPlace::Element => nodes(text, &around, known, "", &word),
        XmlPlace::Content => nodes(text, &around, known, "<", &word),
        XmlPlace::Attribute(tag) => {
            let every = is_node(&tag, &around).then(bt::node_attributes).into_iter().flatten();
            let own = bt::attributes_of(&tag.name).iter().copied().chain(every);
            let all = ports_of(&tag, text, known).into_iter().chain(own.map(|name| (name.to_owned(), String::new())));
            let missing = all.filter(|(name, _)| tag.get(name).is_none());
            missing.map(|(name, takes)| Proposal::attribute(&name, takes, &word)).collect()
        }
        XmlPlace::Value(tag, attribute) => values(text, at, &tag, &attribute, known, &word),
    }
}

/// What the element or attribute at a place of a tree is.
pub(crate) fn explanation(text: &str, at: usize, known: &Knowledge) -> Option<Explanation> {
    let XmlCursor { place, word: range, .. } = place(text, at)?;
    let word = text.get(range.clone()).filter(|word| !word.is_empty())?;
    let explained = match place {
        XmlPlace::Element => {
            let leaf = || {
                let ports = ports_of(&Tag { name: word.to_owned(), ..Tag::default() }, text, known).into_iter();
                let ports: Vec<String> = ports.map(|(name, takes)| format!("- `{name}`: {takes}")).collect();
                Some(format!("`{word}`: {}\n\n{}", known.processes().get(word)?, ports.join("\n")))
            };
            leaf().or_else(|| Some(format!("`{word}`\n\n{}", meaning(word)?)))?
        }
        XmlPlace::Attribute(mut tag) => {
            let named = |tag: &Tag| ports_of(tag, text, known).into_iter().find(|(name, _)| name == word);
            // Its ID may be the word.
            tag.attributes.retain(|(name, _)| name == "ID");
            let (name, takes) = named(&tag).or_else(|| hook(word))?;
            format!("`{name}` of `{}`: {takes}", tag.name)
        }
        XmlPlace::Value(..) => format!("`{word}`: {}", known.processes().get(word)?),
        XmlPlace::Content => return None,
    };
    Some(Explanation { range, text: explained })
}

/// The part of the reference about a node.
fn meaning(node: &str) -> Option<&'static str> {
    let (_, rest) = NODES.split_once(&format!("\n## `{node}`\n"))?;
    let end = rest.find("\n## ").or(rest.find("\n<!--")).unwrap_or(rest.len());
    Some(rest[..end].trim())
}

/// When the script in an attribute runs, from the reference's table.
fn hook(attribute: &str) -> Option<(String, String)> {
    let (_, rest) = NODES.split_once(&format!("\n| `{attribute}` | "))?;
    Some((attribute.to_owned(), rest.split_once(" |\n")?.0.to_owned()))
}

fn builtin(name: &str) -> Option<Kind> {
    Kind::BUILTIN.into_iter().find(|kind| kind.name() == name)
}

/// Whether an element is a node of a tree, not a part of a model.
fn is_node(tag: &Tag, around: &[Tag]) -> bool {
    tag.name != "BehaviorTree" && around.iter().any(|open| open.name == "BehaviorTree")
}

fn node_of(tag: &Tag) -> &str {
    tag.get("ID").unwrap_or(&tag.name)
}

/// The ports of a node, each with what it takes.
fn ports_of(tag: &Tag, text: &str, known: &Knowledge) -> Vec<(String, String)> {
    let node = node_of(tag);
    if let Some(kind) = builtin(node) {
        let takes = |port: &bt::BuiltinPort| match port.default {
            _ if port.required => format!("{}; required", port.takes),
            Some(default) => format!("{}; default {default}", port.takes),
            None => port.takes.to_owned(),
        };
        return builtin_ports(kind).map(|port| (port.name.to_owned(), takes(&port))).collect();
    }
    let of_leaves = known.trees().flat_map(|tree| {
        let leaves = tree.leaves().filter(|leaf| leaf.type_id() == node);
        leaves
            .flat_map(|leaf| tree.ports(leaf.id()))
            .map(|port| (port.name.to_owned(), port.direction.element().to_owned()))
    });
    let declared: BTreeSet<(String, String)> = of_leaves.chain(declared_ports(text, node)).collect();
    declared.into_iter().collect()
}

/// The ports that a tree's file declares in the model of a node or subtree, as far as it can be read.
fn declared_ports(text: &str, node: &str) -> impl Iterator<Item = (String, String)> {
    let models = elements(text).skip_while(|tag| tag.name != "TreeNodesModel");
    let model = models.skip_while(move |tag| is_port(tag) || tag.get("ID") != Some(node)).skip(1);
    model.take_while(is_port).filter_map(|tag| Some((tag.get("name")?.to_owned(), tag.name.clone())))
}

fn is_port(tag: &Tag) -> bool {
    tag.name.ends_with("_port")
}

fn nodes(text: &str, around: &[Tag], known: &Knowledge, before: &str, word: &Range<usize>) -> Vec<Proposal> {
    let names: Vec<&str> = around.iter().map(|tag| tag.name.as_str()).collect();
    let mut found: Vec<Proposal> = Vec::new();
    if names.contains(&"BehaviorTree") {
        let leaves = known.trees().flat_map(Tree::leaves).map(|leaf| leaf.type_id().to_owned());
        let leaves: BTreeSet<String> = declared_in(text).into_iter().chain(leaves).collect();
        found.extend(leaves.iter().map(|name| Proposal::element(name, "a leaf", before, word)));
    }
    found.extend(bt::elements_in(&names).into_iter().map(|name| {
        let what = builtin(name).map_or_else(String::new, |kind| kind.category().to_string());
        let about = meaning(name).unwrap_or_default().to_owned();
        Proposal { about, ..Proposal::element(name, &what, before, word) }
    }));
    found
}

/// The IDs that a tree's file declares in its models, as far as it can be read.
fn declared_in(text: &str) -> BTreeSet<String> {
    let models = elements(text).skip_while(|tag| tag.name != "TreeNodesModel");
    let nodes = models.filter(|tag| tag.name != "SubTree");
    nodes.filter_map(|tag| tag.get("ID").map(str::to_owned)).filter(|id| !id.is_empty()).collect()
}

fn values(text: &str, at: usize, tag: &Tag, attribute: &str, known: &Knowledge, word: &Range<usize>) -> Vec<Proposal> {
    let written = &text[word.start..at];
    let takes = ports_of(tag, text, known).into_iter().find(|(name, _)| name == attribute).map(|(_, takes)| takes);
    let takes = takes.as_deref().unwrap_or_default();
    let port = builtin(node_of(tag)).and_then(|kind| builtin_ports(kind).find(|port| port.name == attribute));
    let form = port.map(|port| port.form);
    let is_code = matches!(form, Some(PortForm::Script | PortForm::Entry)) || hook(attribute).is_some();
    if is_code || written.rfind('{') > written.rfind('}') {
        let word = word_in(text, word, at, |c| c.is_alphanumeric() || c == '_');
        let entry = |name: &String| Proposal::new(name, ProposalKind::Name, "an entry", &word);
        let others = entries(text, at);
        return others.iter().map(entry).collect();
    }
    let trees = || {
        let trees = elements(text).filter(|tag| tag.name == "BehaviorTree");
        trees.filter_map(|tag| tag.get("ID").map(str::to_owned)).collect::<BTreeSet<_>>()
    };
    let names = match (tag.name.as_str(), attribute) {
        ("root", "main_tree_to_execute") | ("SubTree", "ID") => trees(),
        ("root", "BTCPP_format") => ["3", "4"].map(str::to_owned).into(),
        (_, "_autoremap") => ["false", "true"].map(str::to_owned).into(),
        (_, "ID") => declared_in(text),
        _ if form == Some(PortForm::Truth) => ["false", "true"].map(str::to_owned).into(),
        // A leaf's port takes what its machine expects: often a place.
        _ if !takes.is_empty() && builtin(&tag.name).is_none() && !text[word.clone()].contains('{') => {
            known.places().map(attribute_text).collect()
        }
        _ => BTreeSet::new(),
    };
    names.iter().map(|name| Proposal::new(name, ProposalKind::Name, "", word)).collect()
}

/// The entries of blackboards that are named in braces, or to which a script assigns, except at this byte.
fn entries(text: &str, at: usize) -> BTreeSet<String> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let in_braces = text.match_indices('{').filter_map(|(open, _)| {
        let rest = &text[open + 1..];
        let name = &rest[..rest.find('}')?];
        (!(open..=open + 1 + name.len()).contains(&at) && !name.is_empty() && name.chars().all(is_word)).then_some(name)
    });
    let assigned = text.match_indices(":=").filter_map(|(sign, _)| {
        let before = text[..sign].trim_end();
        let name = &before[before.trim_end_matches(is_word).len()..];
        (!name.is_empty()).then_some(name)
    });
    in_braces.chain(assigned).map(str::to_owned).collect()
}
