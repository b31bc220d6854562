//! Translates RoAML to SCXML: each element that RoAML adds becomes a transition or a `<send>`.

mod sends;
mod transitions;

use std::collections::BTreeMap;
use std::ops::Range;

use diagnostics::xml::name_span;
use diagnostics::{Problem, did_you_mean, nearest_or_all};
use roxmltree::{Attribute, Node};
use skills::Datum;

use super::declarations::{Declarations, PortDirection, required};
use super::expression::mentions;
use super::kind::DataKind;
use super::plain::Plain;
use super::port::{input_datum, output_datum};
use super::vocabulary::{GOAL_RESPONSE, Reaction, Role, Sending, Way, elements};
use super::xml::{is, value_span};

#[derive(Debug)]
pub(super) struct Translated<'f> {
    pub(super) plain: Plain<'f>,
    pub(super) sends: BTreeMap<String, Sent>,
}

#[derive(Clone, Debug)]
pub(crate) struct Sent {
    pub(crate) way: Way,
    /// The interface; none for an event without one.
    pub(crate) interface: Option<String>,
    /// Its fields and their kinds, in the order in which they first occur.
    pub(crate) fields: Vec<(String, DataKind)>,
}

/// The SCXML elements that stay unchanged.
const KEPT: [&str; 14] = [
    "state",
    "final",
    "initial",
    "history",
    "onentry",
    "onexit",
    "if",
    "elseif",
    "else",
    "foreach",
    "log",
    "raise",
    "script",
    "datamodel",
];

/// The attributes that contain expressions or locations.
const EXPRESSIONS: [&str; 6] = ["expr", "cond", "location", "array", "delayexpr", "eventexpr"];

/// The attributes of every translated machine.
const HEAD: [(&str, &str); 4] = [
    ("xmlns", "http://www.w3.org/2005/07/scxml"),
    ("xmlns:steward", "urn:steward:chance"),
    ("version", "1.0"),
    ("datamodel", "ecmascript"),
];

/// The attributes of RoAML that SCXML does not have.
const DROPPED: [&str; 2] = ["type", "model_src"];

pub(super) struct Translator<'f, 'p> {
    text: &'f str,
    declared: &'p Declarations,
    problems: &'p mut Vec<Problem>,
    out: Translated<'f>,
}

impl<'f, 'p> Translator<'f, 'p> {
    pub(super) fn new(text: &'f str, declared: &'p Declarations, problems: &'p mut Vec<Problem>) -> Self {
        let out = Translated { plain: Plain::of(text), sends: BTreeMap::new() };
        Self { text, declared, problems, out }
    }

    pub(super) fn machine(mut self, root: Node<'_, '_>) -> Translated<'f> {
        let name = name_span(root);
        self.out.plain.open("scxml", &name, &HEAD);
        for attribute in root.attributes().filter(|attribute| attribute.namespace().is_none()) {
            let known = match root.tag_name().name() {
                "ros_action_thread" => ["name", "n_threads", "initial"].contains(&attribute.name()),
                _ => ["name", "initial", "version", "datamodel", "model_src"].contains(&attribute.name()),
            };
            if !known {
                self.unknown_attribute(root, attribute, &["name", "initial", "version", "datamodel", "model_src"]);
            } else if ["name", "initial"].contains(&attribute.name()) {
                self.attribute(attribute);
            }
        }
        self.out.plain.begin_content(&name);
        self.ports(&name);
        for child in root.children() {
            match child.tag_name().name() {
                // Declarations have been read, and SCXML has nothing in their place.
                "ros_action_thread" | "bt_declare_port_in" | "bt_declare_port_out" => {}
                declaration if Role::declared_by(declaration).is_some() => {}
                _ => self.node(child, root),
            }
        }
        self.out.plain.close("scxml", &name);
        self.out
    }

    /// Writes data for the values of ports.
    fn ports(&mut self, place: &Range<usize>) {
        if self.declared.ports.is_empty() {
            return;
        }
        self.out.plain.open("datamodel", place, &[]);
        self.out.plain.begin_content(place);
        for port in &self.declared.ports {
            let id = match port.direction {
                PortDirection::In => input_datum(&port.key),
                PortDirection::Out => output_datum(&port.key),
            };
            let value = port.value.as_ref().map_or_else(|| unset(port.kind).to_owned(), Datum::to_json);
            let value = if port.direction == PortDirection::In { &value } else { "undefined" };
            self.out.plain.open("data", place, &[("id", &id), ("expr", value)]);
            self.out.plain.close_empty(place);
        }
        self.out.plain.close("datamodel", place);
    }

    fn node(&mut self, node: Node<'_, '_>, parent: Node<'_, '_>) {
        if node.is_text() {
            self.out.plain.copy(node.range());
        }
        if !node.is_element() {
            return;
        }
        let name = node.tag_name().name();
        if name == GOAL_RESPONSE {
            self.goal_response(node);
        } else if let Some(reaction) = Reaction::of(name) {
            self.reaction(node, reaction);
        } else if let Some(sending) = Sending::of(name) {
            self.sending(node, sending);
        } else {
            match name {
                "transition" => self.transition(node),
                "send" => self.plain_send(node),
                "assign" | "data" => self.valued(node),
                "bt_return_status" => self.status(node),
                "bt_return_halted" => self.answer(node, ("event", "halted"), &name_span(node)),
                "bt_set_output" => self.output(node),
                _ if KEPT.contains(&name) => self.kept(node),
                _ => self.unknown(node, parent),
            }
        }
    }

    fn unknown(&mut self, node: Node<'_, '_>, parent: Node<'_, '_>) {
        let name = node.tag_name().name();
        let (message, help) = match name {
            "parallel" | "invoke" => {
                (format!("<{name}> is not part of RoAML"), Some("write one machine per file".to_owned()))
            }
            "bt_tick_child" | "bt_halt_child" | "bt_child_status" | "bt_child_halted" => {
                let help = "the tree's control nodes and decorators are built in: remove this plugin";
                (format!("<{name}>: control nodes cannot be machines"), Some(help.to_owned()))
            }
            "field" | "target" | "expr" | "param" => {
                (format!("<{name}> is not allowed in <{}>", parent.tag_name().name()), None)
            }
            _ => {
                let kept = KEPT.into_iter().chain(["transition", "send", "assign", "data"]);
                (format!("RoAML has no element <{name}>"), did_you_mean(name, elements().chain(kept)))
            }
        };
        self.problems.push(Problem::new(message).at(name_span(node), "not here").with_help_if(help));
    }

    /// Writes an SCXML element, with its expressions translated.
    fn kept(&mut self, node: Node<'_, '_>) {
        self.open(node, |name| !DROPPED.contains(&name));
        self.close(node);
    }

    /// `<assign>` or `<data>`: its value may be a child.
    fn valued(&mut self, node: Node<'_, '_>) {
        self.open(node, |name| !DROPPED.contains(&name));
        self.value_in_child(node, "expr");
        self.out.plain.close_empty(&name_span(node));
    }

    /// Writes the start tag without its end.
    fn open(&mut self, node: Node<'_, '_>, keeps: impl Fn(&str) -> bool) {
        self.out.plain.open(node.tag_name().name(), &name_span(node), &[]);
        for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
            if keeps(attribute.name()) {
                self.attribute(attribute);
            }
        }
    }

    /// Writes the end of the start tag, the children, and the end tag.
    fn close(&mut self, node: Node<'_, '_>) {
        self.out.plain.begin_content(&name_span(node));
        for child in node.children() {
            self.node(child, node);
        }
        self.out.plain.close(node.tag_name().name(), &name_span(node));
    }

    /// The attribute `name` from the child `<expr>`, if there is one.
    fn value_in_child(&mut self, node: Node<'_, '_>, name: &str) {
        for child in node.children().filter(Node::is_element) {
            if !is(&child, "expr") {
                self.unknown(child, node);
                continue;
            }
            let Some(input) = child.children().find(Node::is_element) else {
                self.out.plain.write(&format!(" {name}=\""), &name_span(child));
                child.children().for_each(|text| self.out.plain.copy(text.range()));
                self.out.plain.write("\"", &name_span(child));
                continue;
            };
            if let Some(datum) = self.input(input) {
                self.out.plain.attribute(name, &datum, &name_span(input));
            }
        }
    }

    /// The datum with the value of `<bt_get_input>`.
    fn input(&mut self, node: Node<'_, '_>) -> Option<String> {
        if !is(&node, "bt_get_input") {
            let problem = Problem::new(format!("<{}> is not a value", node.tag_name().name()));
            self.problems.push(problem.at(name_span(node), "not here").with_help("<bt_get_input key=\"…\"/>"));
            return None;
        }
        let key = required(node, "key", self.problems)?;
        let is_input = self.declared.ports.iter().any(|port| port.key == key && port.direction == PortDirection::In);
        if !is_input {
            self.problems.push(self.declared.unknown_port(node, key));
            return None;
        }
        Some(input_datum(key))
    }

    /// Writes an attribute, with its expression translated.
    fn attribute(&mut self, attribute: Attribute<'_, '_>) {
        let (name, value) = (attribute.range_qname(), attribute.range_value());
        let quote = &self.text[value.start - 1..value.start];
        self.out.plain.write(" ", &name);
        self.out.plain.copy(name.clone());
        self.out.plain.write(&format!("={quote}"), &name);
        if EXPRESSIONS.contains(&attribute.name()) {
            self.expression(value.clone());
        } else {
            self.out.plain.copy(value.clone());
        }
        self.out.plain.write(quote, &name);
    }

    fn expression(&mut self, range: Range<usize>) {
        let mut from = range.start;
        for found in mentions(&self.text[range.clone()]) {
            let found = range.start + found.start..range.start + found.end;
            self.out.plain.copy(from..found.start);
            self.out.plain.write("_event.data", &found);
            from = found.end;
        }
        self.out.plain.copy(from..range.end);
    }

    fn interface(&mut self, node: Node<'_, '_>, role: Role) -> Option<String> {
        let alias = required(node, "name", self.problems)?;
        match self.declared.find(role, alias) {
            Some(known) => Some(known.name.clone()),
            None => {
                self.problems.push(self.declared.undeclared(node, role, alias));
                None
            }
        }
    }

    /// Writes the assignment of an output port: its value is kept until the answer.
    fn output(&mut self, node: Node<'_, '_>) {
        self.known_attributes(node, &["key", "expr"]);
        let Some(key) = required(node, "key", self.problems) else { return };
        let is_output = self.declared.ports.iter().any(|port| port.key == key && port.direction == PortDirection::Out);
        if !is_output {
            self.problems.push(self.declared.unknown_port(node, key));
            return;
        }
        self.out.plain.open("assign", &name_span(node), &[]);
        self.out.plain.attribute("location", &output_datum(key), &value_span(node, "key"));
        match node.attribute_node("expr") {
            Some(expr) => self.attribute(expr),
            None => self.value_in_child(node, "expr"),
        }
        self.out.plain.close_empty(&name_span(node));
    }

    fn known_attributes(&mut self, node: Node<'_, '_>, known: &[&str]) {
        for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
            if !known.contains(&attribute.name()) {
                self.unknown_attribute(node, attribute, known);
            }
        }
    }

    fn unknown_attribute(&mut self, node: Node<'_, '_>, attribute: Attribute<'_, '_>, known: &[&str]) {
        let (element, name) = (node.tag_name().name(), attribute.name());
        let problem = Problem::new(format!("<{element}> has no attribute `{name}`"));
        let problem = problem.at(attribute.range_qname(), "unknown attribute");
        self.problems.push(problem.with_help(nearest_or_all(name, "its attributes", known)));
    }
}

/// The value of a port before anything has arrived.
fn unset(kind: DataKind) -> &'static str {
    match kind {
        DataKind::Bool => "false",
        DataKind::Int | DataKind::Real => "0",
        DataKind::Text => "''",
        DataKind::Any => "undefined",
    }
}
