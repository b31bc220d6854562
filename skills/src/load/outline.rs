//! The first pass: all states, data and event descriptors.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use diagnostics::Problem;

use super::origin::Origin;
use super::xml::{Element, Written, elements, elements_named, name_span, own_elements};
use crate::chart::{DataItem, EventClass, HistoryKind, Payload, State, StateKind, is_descriptor};
use crate::expression::scan::{Declarations, declarations};
use crate::expression::{Names, is_identifier};
use crate::ids::{DataId, StateId};

const STATES: [&str; 4] = ["state", "parallel", "final", "history"];

/// The results of the first pass; states and data with their elements.
pub(super) struct Outline<'a> {
    pub(super) states: Vec<(Element<'a>, State)>,
    /// Data without an element are declared by `<foreach>` or a script.
    pub(super) data: Vec<(Option<Element<'a>>, DataItem)>,
    pub(super) names: Names,
    defined: BTreeMap<String, Range<usize>>,
    /// A position in the file, in bytes, and its line. States are visited in order.
    line: (usize, usize),
}

impl<'a> Outline<'a> {
    pub(super) fn of(root: Element<'a>, origin: &Origin, problems: &mut Vec<Problem>) -> Self {
        let names = Names::default();
        let mut outline = Self { states: Vec::new(), data: Vec::new(), names, defined: BTreeMap::new(), line: (0, 1) };
        outline.state(root, None, problems);
        for node in own_elements(root) {
            outline.declared_in_passing(node, origin);
        }
        if outline.states.len() == 1 {
            let problem = Problem::new("the machine has no states").at(name_span(root), "it contains no state");
            problems.push(problem.with_help("for example <state id=\"idle\"/>"));
        }
        outline
    }

    fn state(&mut self, node: Element<'a>, parent: Option<StateId>, problems: &mut Vec<Problem>) -> StateId {
        let id = StateId::new(self.states.len());
        let state = skeleton(node, self.state_name(node, id, problems), kind(node, parent.is_none(), problems), parent);
        self.states.push((node, state));
        for child in elements(node) {
            let name = child.tag_name().name();
            if STATES.contains(&name) {
                let child = self.state(child, Some(id), problems);
                let parent = &mut self.states[id.index()].1;
                let siblings = if name == "history" { &mut parent.histories } else { &mut parent.children };
                siblings.push(child);
            } else if name == "datamodel" {
                elements_named(child, "data").for_each(|data| self.data(data, id, problems));
            }
        }
        self.states[id.index()].1.last = StateId::new(self.states.len() - 1);
        id
    }

    /// The state's id; if the file gives none, it is generated from the line.
    fn state_name(&mut self, node: Element<'a>, id: StateId, problems: &mut Vec<Problem>) -> Arc<str> {
        if id == StateId::ROOT {
            return "scxml".into();
        }
        let Some(written) = Written::attribute(node, "id") else {
            let (start, (before, line)) = (node.range().start, self.line);
            let between = node.document().input_text().get(before..start).unwrap_or_default();
            self.line = (start, line + between.matches('\n').count());
            return format!("{}@{}", node.tag_name().name(), self.line.1).into();
        };
        let name = written.value;
        if name.is_empty() || name.contains(char::is_whitespace) {
            let problem = Problem::new("a state's id must be one word").at(written.span(), "not one word");
            problems.push(problem.with_help("transitions name their targets by id, separated by spaces"));
        } else if let Some(first) = self.defined.get(name) {
            let problem = Problem::new(format!("there are two states named `{name}`"));
            problems.push(problem.at(written.span(), "once more").at(first.clone(), "the first"));
        } else {
            self.defined.insert(name.to_owned(), written.span());
            self.names.states.insert(name.to_owned(), id);
        }
        name.into()
    }

    fn data(&mut self, node: Element<'a>, state: StateId, problems: &mut Vec<Problem>) {
        let Some(written) = Written::attribute(node, "id") else {
            return;
        };
        let (name, span) = (written.value, written.span());
        if !is_identifier(name) {
            let problem =
                Problem::new(format!("`{name}` cannot be the name of a datum")).at(span.clone(), "not a name");
            problems.push(
                problem.with_help("use letters, digits, `_` and `$`, but no reserved word of ECMAScript or SCXML"),
            );
        }
        if let Some(first) = self.names.data.get(name) {
            let first = self.data[first.index()].1.span;
            let problem = Problem::new(format!("there are two data named `{name}`"));
            problems.push(
                problem.at(span, "once more").at(first, "the first").with_help("all data of a machine share one scope"),
            );
            return;
        }
        let id = self.add_data(name, Some(node), span, state == StateId::ROOT);
        self.states[state.index()].1.data.push(id);
    }

    fn add_data(&mut self, name: &str, node: Option<Element<'a>>, span: Range<usize>, top_level: bool) -> DataId {
        let id = DataId::new(self.data.len());
        self.data.push((node, DataItem { id: name.into(), init: None, span: span.into(), top_level }));
        self.names.data.insert(name.to_owned(), id);
        id
    }

    /// `<foreach>` declares its item and index, a script its variables (SCXML 4.6, 5.8).
    fn declared_in_passing(&mut self, node: Element<'a>, origin: &Origin) {
        let names: Vec<String> = match node.tag_name().name() {
            "foreach" => {
                ["item", "index"].into_iter().filter_map(|name| node.attribute(name)).map(str::to_owned).collect()
            }
            "script" => {
                // Problems of the file are reported when the script is compiled.
                let file = Written::attribute(node, "src").and_then(|src| origin.read(src.value).ok());
                let text = Written::text(node).map(|text| text.value.to_owned()).or(file).unwrap_or_default();
                let Declarations { variables, functions, .. } = declarations(&text);
                [variables, functions].concat()
            }
            _ => return,
        };
        for name in names {
            if is_identifier(&name) && !self.names.data.contains_key(&name) {
                self.add_data(&name, None, name_span(node), false);
            }
        }
    }
}

pub(super) fn descriptors<'a>(root: Element<'a>) -> impl Iterator<Item = &'a str> {
    let transitions = own_elements(root).into_iter().filter(|node| node.tag_name().name() == "transition");
    let words = transitions.flat_map(|transition| transition.attribute("event").unwrap_or_default().split_whitespace());
    words.filter(|word| is_descriptor(word))
}

fn kind(node: Element<'_>, is_root: bool, problems: &mut Vec<Problem>) -> StateKind {
    let has_children = || elements(node).any(|child| ["state", "parallel", "final"].contains(&child.tag_name().name()));
    match node.tag_name().name() {
        "parallel" => StateKind::Parallel,
        "final" => StateKind::Final,
        "history" => StateKind::History(match Written::attribute(node, "type") {
            Some(written) if written.value == "deep" => HistoryKind::Deep,
            Some(written) if written.value != "shallow" => {
                let problem = Problem::new(format!("unknown history type `{}`", written.value));
                problems.push(problem.at(written.span(), "unknown type").with_help("use `shallow` or `deep`"));
                HistoryKind::Shallow
            }
            _ => HistoryKind::Shallow,
        }),
        _ if is_root || has_children() => StateKind::Compound,
        _ => StateKind::Atomic,
    }
}

fn skeleton(node: Element<'_>, id: Arc<str>, kind: StateKind, parent: Option<StateId>) -> State {
    State {
        id,
        kind,
        parent,
        last: StateId::ROOT,
        children: Vec::new(),
        histories: Vec::new(),
        initial: None,
        transitions: Vec::new(),
        on_entry: Vec::new(),
        on_exit: Vec::new(),
        invokes: Vec::new(),
        data: Vec::new(),
        done_data: Payload::default(),
        done_event: ("".into(), EventClass::default()),
        span: name_span(node).into(),
        extent: node.written(node.range()).into(),
    }
}
