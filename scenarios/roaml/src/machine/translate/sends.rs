//! What a machine sends, as `<send>`.

use std::ops::Range;

use diagnostics::xml::name_span;
use diagnostics::{Problem, nearest_or_all};
use roxmltree::Node;

use super::super::declarations::required;
use super::super::expression;
use super::super::kind::DataKind;
use super::super::port::{TREE, input_datum};
use super::super::vocabulary::{Sending, Way, event};
use super::super::xml::{is, value_span};
use super::{Sent, Translator};

impl Translator<'_, '_> {
    pub(super) fn sending(&mut self, node: Node<'_, '_>, sending: &Sending) {
        let known: Vec<&str> = ["name"].into_iter().chain(sending.attributes.iter().copied()).collect();
        self.known_attributes(node, &known);
        let Some(alias) = required(node, "name", self.problems) else { return };
        let Some(interface) = self.declared.find(sending.role, alias) else {
            self.problems.push(self.declared.undeclared(node, sending.role, alias));
            return;
        };
        let name = event(sending.event, &interface.name);
        self.begin_send(node, "ros", ("event", &name), &name_span(node));
        self.out.plain.begin_content(&name_span(node));
        let mut fields = self.attribute_params(node, sending);
        for field in node.children().filter(Node::is_element) {
            if is(&field, "field") {
                let Some(id) = required(field, "name", self.problems) else { continue };
                let of_ros = DataKind::of_ros(&interface.of, id);
                fields.extend(self.param(field, of_ros).map(|kind| (id.to_owned(), kind)));
            } else {
                self.unknown(field, node);
            }
        }
        self.out.plain.close("send", &name_span(node));
        self.sent(name, sending.way, Some(interface.name.clone()), fields);
    }

    /// Writes the fields that RoAML has as attributes or by the choice of the element, and returns them. All are the
    /// numbers of goals, threads and results.
    fn attribute_params(&mut self, node: Node<'_, '_>, sending: &Sending) -> Vec<(String, DataKind)> {
        let mut names = Vec::new();
        for attribute in sending.attributes {
            let Some(written) = node.attribute_node(*attribute) else {
                required(node, attribute, self.problems);
                continue;
            };
            let place = written.range_qname();
            self.out.plain.open("param", &place, &[("name", attribute)]);
            self.out.plain.write(" expr=\"", &place);
            self.expression(written.range_value());
            self.out.plain.write("\"", &place);
            self.out.plain.close_empty(&place);
            names.push(*attribute);
        }
        if let Some(code) = sending.code {
            self.out.plain.open("param", &name_span(node), &[("name", "code"), ("expr", &code.to_string())]);
            self.out.plain.close_empty(&name_span(node));
            names.push("code");
        }
        names.into_iter().map(|name| (name.to_owned(), DataKind::Int)).collect()
    }

    /// Writes a `<send>` of SCXML: to every other machine that takes the event.
    pub(super) fn plain_send(&mut self, node: Node<'_, '_>) {
        let known = ["event", "target", "id", "delay", "delayexpr"];
        self.known_attributes(node, &known);
        let Some(name) = required(node, "event", self.problems) else { return };
        if let Some(target) = node.attribute_node("target") {
            let problem = Problem::new("in RoAML, an event goes to every machine that takes it").as_warning();
            self.problems.push(problem.at(target.range_value(), "this target has no effect"));
        }
        self.begin_send(node, "ros", ("event", name), &name_span(node));
        for attribute in ["id", "delay", "delayexpr"] {
            node.attribute_node(attribute).into_iter().for_each(|attribute| self.attribute(attribute));
        }
        self.out.plain.begin_content(&name_span(node));
        let mut fields = Vec::new();
        for param in node.children().filter(Node::is_element) {
            if is(&param, "param") {
                let Some(id) = required(param, "name", self.problems) else { continue };
                fields.extend(self.param(param, None).map(|kind| (id.to_owned(), kind)));
            } else {
                self.unknown(param, node);
            }
        }
        self.out.plain.close("send", &name_span(node));
        self.sent(name.to_owned(), Way::Everyone, None, fields);
    }

    /// Writes the start tag of a `<send>` without its end. `event` is an attribute with its value, from `place`.
    fn begin_send(&mut self, node: Node<'_, '_>, target: &str, event: (&str, &str), place: &Range<usize>) {
        self.out.plain.open("send", &name_span(node), &[("type", "channel"), ("target", target)]);
        self.out.plain.attribute(event.0, event.1, place);
    }

    /// A field of an event, and its kind.
    fn param(&mut self, node: Node<'_, '_>, of_ros: Option<DataKind>) -> Option<DataKind> {
        self.known_attributes(node, &["name", "expr", "location"]);
        self.out.plain.open("param", &name_span(node), &[]);
        self.out.plain.copied_attribute("name", value_span(node, "name"), &name_span(node));
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
        self.out.plain.close_empty(&name_span(node));
        // The type of a ROS message is certain; the kind of an expression is concluded from its words.
        kind.map(|kind| of_ros.unwrap_or(kind))
    }

    fn sent(&mut self, event: String, way: Way, interface: Option<String>, fields: Vec<(String, DataKind)>) {
        let sent = self.out.sends.entry(event).or_insert(Sent { way, interface, fields: Vec::new() });
        for (name, kind) in fields {
            match sent.fields.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) => *known = known.or(kind),
                None => sent.fields.push((name, kind)),
            }
        }
    }

    /// Writes the answer to a tick.
    pub(super) fn status(&mut self, node: Node<'_, '_>) {
        self.known_attributes(node, &["status"]);
        let Some(status) = required(node, "status", self.problems) else { return };
        match status {
            "SUCCESS" | "FAILURE" | "RUNNING" => {
                self.answer(node, ("event", &status.to_lowercase()), &name_span(node));
            }
            name if self.declared.data.contains_key(name) => {
                // These are AS2FM's numbers.
                let event = format!("['', 'success', 'failure', 'running'][{name}]");
                self.answer(node, ("eventexpr", &event), &value_span(node, "status"));
            }
            _ => {
                let known: Vec<&str> = ["SUCCESS", "FAILURE", "RUNNING"].to_vec();
                let problem = Problem::new(format!("unknown status `{status}`"));
                let problem = problem.at(value_span(node, "status"), "neither a status nor a datum");
                self.problems.push(problem.with_help(nearest_or_all(status, "statuses", &known)));
            }
        }
    }

    pub(super) fn answer(&mut self, node: Node<'_, '_>, event: (&str, &str), place: &Range<usize>) {
        self.begin_send(node, TREE, event, place);
        self.out.plain.close_empty(&name_span(node));
    }
}
