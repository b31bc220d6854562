//! Matching events with descriptors (SCXML 3.12.1), with only one lookup by name per event.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

/// The part of an event's name that the descriptors of a chart can distinguish: its longest initial sequence of tokens
/// that any of them mentions. Events of the same class match the same transitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub(crate) struct EventClass(u32);

/// The classes of the events that a descriptor matches. In sorted order, a descriptor comes before those that it
/// covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Matches {
    first: EventClass,
    last: EventClass,
}

impl Ord for Matches {
    fn cmp(&self, other: &Self) -> Ordering {
        self.first.cmp(&other.first).then(other.last.cmp(&self.last))
    }
}

impl PartialOrd for Matches {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Matches {
    /// Whether it begins where the other one does, or earlier.
    pub(crate) fn begins_before(self, other: Self) -> bool {
        self.first <= other.first
    }

    /// Whether this descriptor matches everything that the other one matches.
    pub(crate) fn covers(self, other: Self) -> bool {
        self.first <= other.first && other.last <= self.last
    }

    pub(crate) fn contains(self, class: EventClass) -> bool {
        self.first <= class && class <= self.last
    }

    pub(crate) fn meets(self, classes: &BTreeSet<EventClass>) -> bool {
        classes.range(self.first..=self.last).next().is_some()
    }
}

/// The descriptors of a chart as a tree of tokens. A class is a node, numbered so that the nodes below it follow it.
#[derive(Clone, Debug)]
pub(crate) struct EventTree {
    nodes: Vec<TokenNode>,
}

#[derive(Clone, Debug, Default)]
struct TokenNode {
    parent: usize,
    last: usize,
    /// Whether a transition has the descriptor that ends here.
    is_handled: bool,
    children: BTreeMap<Box<str>, usize>,
}

impl EventTree {
    pub(crate) fn of<'a>(descriptors: impl IntoIterator<Item = &'a str>) -> Self {
        let mut nodes = vec![TokenNode::default()];
        for descriptor in descriptors {
            let mut node = 0;
            for token in tokens(descriptor) {
                node = match nodes[node].children.get(token) {
                    Some(child) => *child,
                    None => {
                        let child = nodes.len();
                        nodes.push(TokenNode { parent: node, ..TokenNode::default() });
                        nodes[node].children.insert(token.into(), child);
                        child
                    }
                };
            }
        }
        Self { nodes: numbered(&nodes) }
    }

    pub(crate) fn class(&self, name: &str) -> EventClass {
        let mut node = 0;
        for token in name.split('.') {
            match self.nodes[node].children.get(token) {
                Some(child) => node = *child,
                None => break,
            }
        }
        EventClass(node as u32)
    }

    /// Whether a registered descriptor matches events with this name.
    pub(crate) fn handles(&self, name: &str) -> bool {
        self.nodes[0].is_handled || self.names(name)
    }

    /// Whether a descriptor other than `*` matches the event.
    pub(crate) fn names(&self, name: &str) -> bool {
        let step = |here: &TokenNode, token| here.children.get(token).map(|child| &self.nodes[*child]);
        let nodes = name.split('.').scan(&self.nodes[0], |here, token| {
            *here = step(here, token)?;
            Some(*here)
        });
        nodes.into_iter().any(|node| node.is_handled)
    }

    /// Registers one of the descriptors of this tree and returns the classes that it matches.
    pub(crate) fn register(&mut self, descriptor: &str) -> Matches {
        let node =
            tokens(descriptor).fold(0, |node, token| self.nodes[node].children.get(token).copied().unwrap_or(node));
        self.nodes[node].is_handled = true;
        Matches { first: EventClass(node as u32), last: EventClass(self.nodes[node].last as u32) }
    }
}

/// The same nodes, renumbered so that the nodes below a node follow it.
fn numbered(nodes: &[TokenNode]) -> Vec<TokenNode> {
    let mut order = Vec::with_capacity(nodes.len());
    let mut number = vec![0; nodes.len()];
    let mut open = vec![0];
    while let Some(node) = open.pop() {
        number[node] = order.len();
        order.push(node);
        open.extend(nodes[node].children.values().rev());
    }
    let moved = |(new, old): (usize, &usize)| TokenNode {
        parent: number[nodes[*old].parent],
        last: new,
        is_handled: nodes[*old].is_handled,
        children: nodes[*old].children.iter().map(|(token, child)| (token.clone(), number[*child])).collect(),
    };
    let mut sorted: Vec<TokenNode> = order.iter().enumerate().map(moved).collect();
    for node in (1..sorted.len()).rev() {
        let TokenNode { parent, last, .. } = sorted[node];
        sorted[parent].last = sorted[parent].last.max(last);
    }
    sorted
}

/// The tokens of a descriptor: `a.b`, `a.b.` and `a.b.*` are the same.
fn tokens(descriptor: &str) -> impl Iterator<Item = &str> {
    let prefix = descriptor.strip_suffix('*').unwrap_or(descriptor);
    let prefix = prefix.strip_suffix('.').unwrap_or(prefix);
    prefix.split('.').filter(|token| !token.is_empty())
}

/// Whether a word is an event descriptor: `*`, or tokens joined by dots, optionally with `.` or `.*` at the end.
pub(crate) fn is_descriptor(word: &str) -> bool {
    let stem = word.strip_suffix(".*").or_else(|| word.strip_suffix('.')).unwrap_or(word);
    word == "*" || is_event_name(stem)
}

/// Whether a word can be the name of an event: tokens joined by dots.
pub(crate) fn is_event_name(word: &str) -> bool {
    let is_token = |token: &str| !token.is_empty() && !token.contains(|c: char| c.is_whitespace() || c == '*');
    word.split('.').all(is_token)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_descriptor_matches_whole_tokens_at_the_beginning() {
        let matches = |descriptor: &str, name: &str| {
            let mut tree = EventTree::of(["door", "error.x.y", descriptor, "zoo"]);
            let matches = tree.register(descriptor).contains(tree.class(name));
            assert_eq!(tree.handles(name), matches, "{descriptor} {name}");
            matches
        };
        for descriptor in ["error", "error.", "error.*", "*"] {
            assert!(matches(descriptor, "error"), "{descriptor}");
            assert!(matches(descriptor, "error.x"), "{descriptor}");
            assert!(matches(descriptor, "error.x.y.z"), "{descriptor}");
        }
        assert!(!matches("error", "errors"));
        assert!(!matches("error.x", "error"));
        assert!(!matches("error", "door") && !matches("error", "zoo.error"));
        assert!(matches("*", "anything.at.all"));
    }

    #[test]
    fn event_forms() {
        assert!(["a", "a.b", "a.*", "a.", "*", "done.state.s-1"].iter().all(|word| is_descriptor(word)));
        assert!(!["", ".", ".a", "a..b", "a.*.b", "*a", "**", "a*"].iter().any(|word| is_descriptor(word)));
        assert!(!is_event_name("a.*"));
    }
}
