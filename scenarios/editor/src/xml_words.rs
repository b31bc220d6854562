//! Elements and attributes of trees and machines, from the tables that their parsers use.

use std::collections::BTreeSet;
use std::ops::Range;

use bt::{Kind, Tree, builtin_ports};

use crate::knowledge::Knowledge;
use crate::proposal::{Explanation, Proposal, ProposalKind};
use crate::xml_place::{XmlPlace, place};

/// What may be written at a place of a tree.
pub(crate) fn in_tree(text: &str, at: usize, known: &Knowledge) -> Vec<Proposal> {
    let Some((place, word)) = place(text, at) else { return Vec::new() };
    match place {
        XmlPlace::Element { around } => tree_elements(text, &around, known, "", &word),
        XmlPlace::Content { around } => tree_elements(text, &around, known, "<", &word),
        XmlPlace::Attribute { element, present, .. } => {
            let ports = ports_of(&element, known);
            let explicit = ["Action", "Condition", "Control", "Decorator", "SubTree", "BehaviorTree"];
            let id = explicit.contains(&element.as_str()).then(|| ("ID".to_owned(), String::new()));
            let every = bt::node_attributes().map(|name| (name.to_owned(), String::new()));
            let all = id.into_iter().chain(ports).chain(every);
            all.filter(|(name, _)| !present.contains(name))
                .map(|(name, takes)| attribute(&name, takes, &word))
                .collect()
        }
        XmlPlace::Value { element, attribute } => values_in_tree(text, &element, &attribute, known, &word),
    }
}

/// What the element or attribute at a place of a tree is.
pub(crate) fn explained_in_tree(text: &str, at: usize, known: &Knowledge) -> Option<Explanation> {
    let (place, range) = place(text, at)?;
    let word = text.get(range.clone()).filter(|word| !word.is_empty())?;
    let explained = match place {
        XmlPlace::Element { .. } => {
            let what = builtin(word).map(|kind| kind.category().to_string());
            let leaf = || known.processes().get(word).cloned();
            let ports: Vec<String> =
                ports_of(word, known).into_iter().map(|(name, takes)| format!("- `{name}`: {takes}")).collect();
            format!("`{word}`: {}\n\n{}", what.or_else(leaf)?, ports.join("\n"))
        }
        XmlPlace::Attribute { element, .. } => {
            let (name, takes) = ports_of(&element, known).into_iter().find(|(name, _)| name == word)?;
            format!("`{name}` of `{element}`: {takes}")
        }
        XmlPlace::Value { .. } => format!("`{word}`: {}", known.processes().get(word)?),
        XmlPlace::Content { .. } => return None,
    };
    Some(Explanation { range, text: explained })
}

/// What may be written at a place of a machine.
pub(crate) fn in_machine(text: &str, at: usize, known: &Knowledge) -> Vec<Proposal> {
    let Some((place, word)) = place(text, at) else { return Vec::new() };
    let elements = |around: &[String], before: &str| {
        let parent = around.last().map(String::as_str);
        skills::elements_in(parent).into_iter().map(|name| element(name, "SCXML", before, &word)).collect()
    };
    match place {
        XmlPlace::Element { around } => elements(&around, ""),
        XmlPlace::Content { around } => elements(&around, "<"),
        XmlPlace::Attribute { element, present, .. } => {
            let attributes =
                skills::attributes_of(&element).filter(|(name, _)| !present.iter().any(|known| known == name));
            let what = |is_required| if is_required { "required" } else { "" };
            attributes.map(|(name, is_required)| attribute(name, what(is_required).to_owned(), &word)).collect()
        }
        XmlPlace::Value { element, attribute } => values_in_machine(text, &element, &attribute, known, &word),
    }
}

/// What the element or attribute at a place of a machine is.
pub(crate) fn explained_in_machine(text: &str, at: usize, known: &Knowledge) -> Option<Explanation> {
    let (place, range) = place(text, at)?;
    let word = text.get(range.clone()).filter(|word| !word.is_empty())?;
    let list = |names: Vec<String>| if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
    let explained = match place {
        XmlPlace::Element { .. } => {
            let attributes = skills::attributes_of(word).map(|(name, is_required)| {
                if is_required { format!("`{name}` (required)") } else { format!("`{name}`") }
            });
            let contents = skills::elements_in(Some(word)).into_iter().map(|name| format!("`<{name}>`"));
            let (attributes, contents) = (list(attributes.collect()), list(contents.collect()));
            format!("`<{word}>` of SCXML\n\nattributes: {attributes}\n\ncontains: {contents}")
        }
        XmlPlace::Value { .. } => format!("`{word}`: {}", known.processes().get(word)?),
        _ => return None,
    };
    Some(Explanation { range, text: explained })
}

fn builtin(name: &str) -> Option<Kind> {
    Kind::BUILTIN.into_iter().find(|kind| kind.name() == name)
}

/// The ports of a node with this name, each with what it takes.
fn ports_of(node: &str, known: &Knowledge) -> Vec<(String, String)> {
    if let Some(kind) = builtin(node) {
        let takes = |port: &bt::BuiltinPort| match port.default {
            _ if port.required => format!("{}; required", port.takes),
            Some(default) => format!("{}; default {default}", port.takes),
            None => port.takes.to_owned(),
        };
        return builtin_ports(kind).map(|port| (port.name.to_owned(), takes(&port))).collect();
    }
    let declared = known.trees().flat_map(|tree| {
        let leaves = tree.leaves().filter(|leaf| leaf.type_id() == node);
        leaves
            .flat_map(|leaf| tree.ports(leaf.id()))
            .map(|port| (port.name.to_owned(), port.direction.element().to_owned()))
    });
    let declared: BTreeSet<(String, String)> = declared.collect();
    declared.into_iter().collect()
}

fn tree_elements(text: &str, around: &[String], known: &Knowledge, before: &str, word: &Range<usize>) -> Vec<Proposal> {
    let parent = around.last().map(String::as_str);
    let mut found: Vec<Proposal> = Vec::new();
    if around.iter().any(|name| name == "BehaviorTree") {
        let leaves: BTreeSet<String> =
            known.trees().flat_map(Tree::leaves).map(|leaf| leaf.type_id().to_owned()).collect();
        let declared = declared_in(text).into_iter().chain(leaves);
        found.extend(declared.collect::<BTreeSet<_>>().iter().map(|name| element(name, "a leaf", before, word)));
    }
    found.extend(bt::elements_in(parent).into_iter().map(|name| {
        let what = builtin(name).map_or_else(String::new, |kind| kind.category().to_string());
        element(name, &what, before, word)
    }));
    found
}

/// The IDs that a tree's file declares in its models, as far as it can be read.
fn declared_in(text: &str) -> Vec<String> {
    let models = text.split_once("<TreeNodesModel").map_or("", |(_, models)| models);
    let ids = models.split("ID=\"").skip(1).filter_map(|rest| rest.split_once('"'));
    ids.map(|(id, _)| id.to_owned()).collect()
}

fn values_in_tree(text: &str, of: &str, attribute: &str, known: &Knowledge, word: &Range<usize>) -> Vec<Proposal> {
    let trees = || {
        let ids = text.split("<BehaviorTree").skip(1).filter_map(|rest| rest.split_once("ID=\"")?.1.split_once('"'));
        ids.map(|(id, _)| id.to_owned()).collect::<BTreeSet<_>>()
    };
    let names = match (of, attribute) {
        ("root", "main_tree_to_execute") | ("SubTree", "ID") => trees(),
        (_, "ID") => declared_in(text).into_iter().collect(),
        (_, "name") => BTreeSet::new(),
        _ => known.places().map(str::to_owned).collect(),
    };
    names.iter().map(|name| value(name, "", word)).collect()
}

fn values_in_machine(text: &str, of: &str, attribute: &str, known: &Knowledge, word: &Range<usize>) -> Vec<Proposal> {
    match (of, attribute) {
        ("send", "target") => known.processes().iter().map(|(name, what)| value(name, what, word)).collect(),
        ("transition", "target") | (_, "initial") => {
            let is_state = |tag: &&str| {
                let (element, _) = tag.split_once(char::is_whitespace).unwrap_or_default();
                ["state", "parallel", "final", "history"].contains(&element)
            };
            let ids = text.split('<').filter(is_state).filter_map(|tag| tag.split_once(" id=\"")?.1.split_once('"'));
            ids.map(|(id, _)| value(id, "a state", word)).collect()
        }
        ("send", "type") => vec![value("channel", "to another process", word)],
        _ => Vec::new(),
    }
}

fn element(name: &str, what: &str, before: &str, replaces: &Range<usize>) -> Proposal {
    let (detail, insert) = (what.to_owned(), format!("{before}{name}"));
    let (kind, about) = (ProposalKind::Element, String::new());
    Proposal { name: name.to_owned(), kind, detail, about, insert, replaces: replaces.clone() }
}

fn attribute(name: &str, detail: String, replaces: &Range<usize>) -> Proposal {
    let (kind, about) = (ProposalKind::Key, String::new());
    Proposal { name: name.to_owned(), kind, detail, about, insert: format!("{name}=\"\""), replaces: replaces.clone() }
}

fn value(name: &str, what: &str, replaces: &Range<usize>) -> Proposal {
    let (kind, detail, about) = (ProposalKind::Name, what.to_owned(), String::new());
    Proposal { name: name.to_owned(), kind, detail, about, insert: name.to_owned(), replaces: replaces.clone() }
}
