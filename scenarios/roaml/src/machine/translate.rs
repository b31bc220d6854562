//! Translates RoAML to SCXML: each element that RoAML adds becomes a transition or a `<send>`.

use std::collections::BTreeMap;
use std::ops::Range;

use diagnostics::markup::attribute;
use diagnostics::xml::name_span;
use diagnostics::{Problem, did_you_mean, nearest_or_all};
use roxmltree::{Attribute, Node};
use skills::Datum;

use super::declarations::{Declarations, PortDirection, required};
use super::expression::{self, mentions};
use super::kind::Kind;
use super::plain::Plain;
use super::port::{TREE, input_datum, output_datum};
use super::vocabulary::{GOAL_RESPONSE, Reaction, Role, Sending, Way, elements, event};
use super::xml::{is, value_span};

/// A translated machine.
#[derive(Debug, Default)]
pub(super) struct Translated {
    pub(super) plain: Plain,
    pub(super) sends: BTreeMap<String, Sent>,
}

/// An event that a machine sends.
#[derive(Clone, Debug)]
pub(crate) struct Sent {
    pub(crate) way: Way,
    /// The interface; none for an event without one.
    pub(crate) interface: Option<String>,
    /// Its fields and their kinds, in the order in which they first occur.
    pub(crate) fields: Vec<(String, Kind)>,
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

/// The attributes of RoAML that SCXML does not have.
const DROPPED: [&str; 2] = ["type", "model_src"];

pub(super) struct Translator<'p> {
    text: &'p str,
    declared: &'p Declarations,
    problems: &'p mut Vec<Problem>,
    out: Translated,
}

impl<'p> Translator<'p> {
    pub(super) fn new(text: &'p str, declared: &'p Declarations, problems: &'p mut Vec<Problem>) -> Self {
        Self { text, declared, problems, out: Translated::default() }
    }

    pub(super) fn machine(mut self, root: Node<'_, '_>) -> Translated {
        let name = name_span(root);
        self.write("<", &name);
        self.write("scxml", &name);
        self.write(
            " xmlns=\"http://www.w3.org/2005/07/scxml\" xmlns:steward=\"urn:steward:chance\" version=\"1.0\" \
             datamodel=\"ecmascript\"",
            &name,
        );
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
        self.write(">", &name);
        self.ports(&name);
        for child in root.children() {
            match child.tag_name().name() {
                "ros_action_thread" | "bt_declare_port_in" | "bt_declare_port_out" => {}
                declaration if Role::declared_by(declaration).is_some() => {}
                _ => self.node(child, root),
            }
        }
        self.write("</scxml>", &name);
        self.out
    }

    /// Writes data for the values of ports.
    fn ports(&mut self, place: &Range<usize>) {
        if self.declared.ports.is_empty() {
            return;
        }
        self.write("<datamodel>", place);
        for port in &self.declared.ports {
            let id = match port.direction {
                PortDirection::In => input_datum(&port.key),
                PortDirection::Out => output_datum(&port.key),
            };
            let value = port.value.as_ref().map_or_else(|| unset(port.kind).to_owned(), literal);
            let value = if port.direction == PortDirection::In { attribute(&value) } else { "undefined".to_owned() };
            self.write(&format!("<data id=\"{id}\" expr=\"{value}\"/>"), place);
        }
        self.write("</datamodel>", place);
    }

    fn node(&mut self, node: Node<'_, '_>, parent: Node<'_, '_>) {
        if node.is_text() {
            self.out.plain.copy(self.text, node.range());
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
                "bt_return_halted" => self.answer(node, "event=\"halted\"", None),
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
        self.write("/>", &name_span(node));
    }

    /// Writes the start tag without its end.
    fn open(&mut self, node: Node<'_, '_>, keeps: impl Fn(&str) -> bool) {
        self.write("<", &name_span(node));
        self.write(node.tag_name().name(), &name_span(node));
        for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
            if keeps(attribute.name()) {
                self.attribute(attribute);
            }
        }
    }

    /// Writes the end of the start tag, the children, and the end tag.
    fn close(&mut self, node: Node<'_, '_>) {
        self.write(">", &name_span(node));
        for child in node.children() {
            self.node(child, node);
        }
        self.write("</", &name_span(node));
        self.write(node.tag_name().name(), &name_span(node));
        self.write(">", &name_span(node));
    }

    /// The attribute `name` from the child `<expr>`, if there is one.
    fn value_in_child(&mut self, node: Node<'_, '_>, name: &str) {
        for child in node.children().filter(Node::is_element) {
            if !is(&child, "expr") {
                self.unknown(child, node);
                continue;
            }
            let Some(input) = child.children().find(Node::is_element) else {
                self.write(&format!(" {name}=\""), &name_span(child));
                child.children().for_each(|text| self.out.plain.copy(self.text, text.range()));
                self.write("\"", &name_span(child));
                continue;
            };
            if let Some(datum) = self.input(input) {
                self.write(&format!(" {name}=\"{datum}\""), &name_span(input));
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
        self.out.plain.copy(self.text, name.clone());
        self.out.plain.write("=", &name);
        self.out.plain.write(quote, &name);
        if EXPRESSIONS.contains(&attribute.name()) {
            self.expression(value.clone());
        } else {
            self.out.plain.copy(self.text, value.clone());
        }
        self.out.plain.write(quote, &name);
    }

    fn expression(&mut self, range: Range<usize>) {
        let mut from = range.start;
        for found in mentions(&self.text[range.clone()]) {
            let found = range.start + found.start..range.start + found.end;
            self.out.plain.copy(self.text, from..found.start);
            self.out.plain.write("_event.data", &found);
            from = found.end;
        }
        self.out.plain.copy(self.text, from..range.end);
    }

    /// Writes an SCXML transition.
    fn transition(&mut self, node: Node<'_, '_>) {
        let event = node.attribute_node("event");
        let event = event.map(|event| (event.value().to_owned(), event.range_value()));
        self.known_attributes(node, &["event", "cond", "target", "type"]);
        self.branches(node, event, None);
    }

    /// Writes an element that reacts to an event.
    fn reaction(&mut self, node: Node<'_, '_>, reaction: &Reaction) {
        let known: &[&str] = if reaction.role.is_some() { &["name", "cond", "target"] } else { &["cond", "target"] };
        self.known_attributes(node, known);
        let name = match reaction.role {
            Some(role) => match self.interface(node, role) {
                Some(name) => event(reaction.event, &name),
                None => return,
            },
            None => reaction.event.to_owned(),
        };
        let code = reaction.code.map(|code| format!("_event.data.code == {code}"));
        self.branches(node, Some((name, name_span(node))), code.as_deref());
    }

    /// The interface that an element names.
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

    /// Writes one transition per target: all but the last are left to chance.
    fn branches(&mut self, node: Node<'_, '_>, event: Option<(String, Range<usize>)>, also: Option<&str>) {
        let targets: Vec<Node<'_, '_>> = node.children().filter(|child| is(child, "target")).collect();
        if targets.is_empty() {
            self.branch(node, node, &event, also, None);
            return;
        }
        if let Some(written) = node.attribute_node("target") {
            let problem = Problem::new("the targets are given twice").at(written.range_value(), "either here");
            self.problems.push(problem.at(name_span(targets[0]), "or here"));
        }
        for other in node.children().filter(|child| child.is_element() && !is(child, "target")) {
            let problem = Problem::new(format!("<{}> belongs in one of the targets", other.tag_name().name()));
            self.problems.push(problem.at(name_span(other), "beside targets"));
        }
        let mut rest = 1.0;
        for (index, target) in targets.iter().enumerate() {
            self.known_attributes(*target, &["id", "prob"]);
            let is_last = index + 1 == targets.len();
            let Some(chance) = self.probability(*target, is_last, rest) else { return };
            let of_rest = if rest > 0.0 { (chance / rest).min(1.0) } else { 0.0 };
            rest -= chance;
            self.branch(node, *target, &event, also, (!is_last).then_some(of_rest));
        }
        if rest.abs() > 1e-9 {
            let problem = Problem::new("the probabilities of the targets do not add up to 1");
            let message = if rest > 0.0 { format!("{rest:.3} is missing") } else { format!("{:.3} too much", -rest) };
            let help = "leave out `prob` of the last target: it gets the rest";
            self.problems.push(problem.at(name_span(node), message).with_help(help));
        }
    }

    fn probability(&mut self, target: Node<'_, '_>, is_last: bool, rest: f64) -> Option<f64> {
        let Some(written) = target.attribute("prob") else {
            if is_last {
                return Some(rest);
            }
            let problem = Problem::new("only the last target may leave out its probability");
            self.problems.push(problem.at(name_span(target), "`prob` is missing"));
            return None;
        };
        let number = written.trim().parse().ok().filter(|number| (0.0..=1.0).contains(number));
        if number.is_none() {
            let problem = Problem::new(format!("`{written}` is not a probability"));
            self.problems.push(problem.at(value_span(target, "prob"), "not a number from 0 to 1"));
        }
        number
    }

    /// Writes one transition. `branch` has the target and the content: `node` itself, or one of its targets.
    fn branch(
        &mut self,
        node: Node<'_, '_>,
        branch: Node<'_, '_>,
        event: &Option<(String, Range<usize>)>,
        also: Option<&str>,
        chance: Option<f64>,
    ) {
        self.write("<", &name_span(branch));
        self.write("transition", &name_span(branch));
        if let Some((name, place)) = event {
            self.write(&format!(" event=\"{name}\""), place);
        }
        let target = branch.attribute_node("target").or_else(|| branch.attribute_node("id"));
        if let Some(target) = target {
            self.write(" target=\"", &name_span(branch));
            self.out.plain.copy(self.text, target.range_value());
            self.write("\"", &name_span(branch));
        }
        let condition = node.attribute_node("cond");
        match (condition, also) {
            (Some(written), None) => self.attribute(written),
            (Some(written), Some(also)) => {
                let quote = &self.text[written.range_value().start - 1..written.range_value().start];
                self.write(&format!(" cond={quote}{also} &amp;&amp; ("), &name_span(node));
                self.expression(written.range_value());
                self.write(&format!("){quote}"), &name_span(node));
            }
            (None, Some(also)) => self.write(&format!(" cond=\"{also}\""), &name_span(node)),
            (None, None) => {}
        }
        if let Some(chance) = chance {
            self.write(&format!(" steward:chance=\"{chance}\""), &value_span(branch, "prob"));
        }
        // A transition without an event, a condition and a target would be rejected; this one explains itself in the
        // file.
        self.write(">", &name_span(branch));
        for child in branch.children() {
            self.node(child, branch);
        }
        self.write("</transition>", &name_span(branch));
    }

    /// Writes both outcomes of a goal request.
    fn goal_response(&mut self, node: Node<'_, '_>) {
        self.known_attributes(node, &["name", "accept", "reject"]);
        let Some(interface) = self.interface(node, Role::ActionClient) else { return };
        for (outcome, attribute) in [("accepted", "accept"), ("rejected", "reject")] {
            if required(node, attribute, self.problems).is_none() {
                continue;
            }
            let name = event(&format!("action_{{}}_goal_{outcome}"), &interface);
            self.write(&format!("<transition event=\"{name}\" target=\""), &name_span(node));
            self.out.plain.copy(self.text, value_span(node, attribute));
            self.write("\"/>", &name_span(node));
        }
    }

    /// Writes an element that sends an event.
    fn sending(&mut self, node: Node<'_, '_>, sending: &Sending) {
        let known: Vec<&str> = ["name"].into_iter().chain(sending.attributes.iter().copied()).collect();
        self.known_attributes(node, &known);
        let Some(alias) = required(node, "name", self.problems) else { return };
        let Some(interface) = self.declared.find(sending.role, alias) else {
            self.problems.push(self.declared.undeclared(node, sending.role, alias));
            return;
        };
        let name = event(sending.event, &interface.name);
        let mut fields = Vec::new();
        self.begin_send(node, &name);
        for attribute in sending.attributes {
            let Some(written) = node.attribute_node(*attribute) else {
                required(node, attribute, self.problems);
                continue;
            };
            self.write(&format!("<param name=\"{attribute}\" expr=\""), &written.range_qname());
            self.expression(written.range_value());
            self.write("\"/>", &written.range_qname());
            fields.push(((*attribute).to_owned(), Kind::Int));
        }
        if let Some(code) = sending.code {
            self.write(&format!("<param name=\"code\" expr=\"{code}\"/>"), &name_span(node));
            fields.push(("code".to_owned(), Kind::Int));
        }
        for field in node.children().filter(Node::is_element) {
            if is(&field, "field") {
                let Some(id) = required(field, "name", self.problems) else { continue };
                let of_ros = Kind::of_ros(&interface.of, id);
                fields.extend(self.param(field, of_ros).map(|kind| (id.to_owned(), kind)));
            } else {
                self.unknown(field, node);
            }
        }
        self.write("</send>", &name_span(node));
        self.sent(name, sending.way, Some(interface.name.clone()), fields);
    }

    /// Writes a `<send>` of SCXML: to every other machine that takes the event, unless it says otherwise.
    fn plain_send(&mut self, node: Node<'_, '_>) {
        let known = ["event", "target", "id", "delay", "delayexpr"];
        self.known_attributes(node, &known);
        let Some(name) = required(node, "event", self.problems) else { return };
        if let Some(target) = node.attribute_node("target") {
            let problem = Problem::new("in RoAML, an event goes to every machine that takes it").as_warning();
            self.problems.push(problem.at(target.range_value(), "this target has no effect"));
        }
        self.write(&format!("<send type=\"channel\" target=\"ros\" event=\"{name}\""), &name_span(node));
        for attribute in ["id", "delay", "delayexpr"] {
            node.attribute_node(attribute).into_iter().for_each(|attribute| self.attribute(attribute));
        }
        self.write(">", &name_span(node));
        let mut fields = Vec::new();
        for param in node.children().filter(Node::is_element) {
            if is(&param, "param") {
                let Some(id) = required(param, "name", self.problems) else { continue };
                fields.extend(self.param(param, None).map(|kind| (id.to_owned(), kind)));
            } else {
                self.unknown(param, node);
            }
        }
        self.write("</send>", &name_span(node));
        self.sent(name.to_owned(), Way::Everyone, None, fields);
    }

    fn begin_send(&mut self, node: Node<'_, '_>, event: &str) {
        self.write("<", &name_span(node));
        self.write("send", &name_span(node));
        self.write(&format!(" type=\"channel\" target=\"ros\" event=\"{event}\">"), &name_span(node));
    }

    /// A field of an event, and its kind.
    fn param(&mut self, node: Node<'_, '_>, of_ros: Option<Kind>) -> Option<Kind> {
        self.known_attributes(node, &["name", "expr", "location"]);
        self.write("<param name=\"", &name_span(node));
        self.out.plain.copy(self.text, value_span(node, "name"));
        self.write("\"", &name_span(node));
        let written = node.attribute_node("expr").or_else(|| node.attribute_node("location"));
        let input = node.descendants().find(|inner| is(inner, "bt_get_input"));
        let kind = match (written, input) {
            (Some(written), _) => {
                self.attribute(written);
                Some(expression::kind(written.value(), &self.declared.data))
            }
            (None, Some(input)) => {
                self.value_in_child(node, "expr");
                let key = input.attribute("key").unwrap_or_default();
                self.declared.data.get(&input_datum(key)).copied()
            }
            (None, None) => {
                let problem = Problem::new("this field has no value").at(name_span(node), "`expr` is missing");
                self.problems.push(problem);
                None
            }
        };
        self.write("/>", &name_span(node));
        kind.map(|kind| of_ros.unwrap_or(kind))
    }

    fn sent(&mut self, event: String, way: Way, interface: Option<String>, fields: Vec<(String, Kind)>) {
        let sent = self.out.sends.entry(event).or_insert(Sent { way, interface, fields: Vec::new() });
        for (name, kind) in fields {
            match sent.fields.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) => *known = known.or(kind),
                None => sent.fields.push((name, kind)),
            }
        }
    }

    /// Writes the answer to a tick.
    fn status(&mut self, node: Node<'_, '_>) {
        self.known_attributes(node, &["status"]);
        let Some(status) = required(node, "status", self.problems) else { return };
        match status {
            "SUCCESS" | "FAILURE" | "RUNNING" => {
                self.answer(node, &format!("event=\"{}\"", status.to_lowercase()), None);
            }
            name if self.declared.data.contains_key(name) => {
                // These are AS2FM's numbers.
                let words = format!("eventexpr=\"['', 'success', 'failure', 'running'][{name}]\"");
                self.answer(node, &words, Some(value_span(node, "status")));
            }
            _ => {
                let known: Vec<&str> = ["SUCCESS", "FAILURE", "RUNNING"].to_vec();
                let problem = Problem::new(format!("unknown status `{status}`"));
                let problem = problem.at(value_span(node, "status"), "neither a status nor a datum");
                self.problems.push(problem.with_help(nearest_or_all(status, "statuses", &known)));
            }
        }
    }

    fn answer(&mut self, node: Node<'_, '_>, event: &str, place: Option<Range<usize>>) {
        let place = place.unwrap_or_else(|| name_span(node));
        self.write("<", &name_span(node));
        self.write("send", &name_span(node));
        self.write(&format!(" type=\"channel\" target=\"{TREE}\" "), &name_span(node));
        self.write(event, &place);
        self.write("/>", &name_span(node));
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
        self.write("<", &name_span(node));
        self.write("assign", &name_span(node));
        self.write(&format!(" location=\"{}\"", output_datum(key)), &value_span(node, "key"));
        match node.attribute_node("expr") {
            Some(expr) => self.attribute(expr),
            None => self.value_in_child(node, "expr"),
        }
        self.write("/>", &name_span(node));
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

    fn write(&mut self, words: &str, place: &Range<usize>) {
        self.out.plain.write(words, place);
    }
}

/// A datum as an expression.
fn literal(datum: &Datum) -> String {
    datum.to_json()
}

/// The value of a port before anything has arrived.
fn unset(kind: Kind) -> &'static str {
    match kind {
        Kind::Bool => "false",
        Kind::Int | Kind::Real => "0",
        Kind::Text => "''",
        Kind::Any => "undefined",
    }
}
