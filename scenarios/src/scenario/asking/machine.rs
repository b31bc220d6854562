//! The machine of a leaf that asks, written as SCXML.

use bt::{Kind, Node};
use diagnostics::markup::attribute;
use serde_json::Value;
use skills::Datum;
use std::collections::BTreeSet;

use super::success::DATA;
use super::{Argument, Asking, Endpoint, PATIENCE, Written};
use crate::scenario::offer::Subject;
use crate::scenario::scxml_text::Text;

/// The datum that says whether the last message of a topic means success.
const HOLDS: &str = "holds__";

impl Asking {
    /// The machine of a leaf, as SCXML.
    pub fn scxml(&self, leaf: &Node) -> String {
        let mut text = Text::default();
        text.open_machine(leaf.label());
        let is_condition = leaf.kind() == Kind::Condition;
        text.element("datamodel", |text| {
            self.data(is_condition).iter().for_each(|datum| text.line(&format!("<data id=\"{}\"/>", attribute(datum))));
        });
        match (self.of, is_condition) {
            (Subject::Topic, true) => self.watch(&mut text),
            (_, true) => self.ask_at_once(&mut text),
            (_, false) => self.ask_and_go_on(&mut text),
        }
        text.finish()
    }

    /// The machine's data: the ports that it reads, and the values of those that it writes.
    pub(super) fn data(&self, is_condition: bool) -> BTreeSet<String> {
        let ports = self.arguments.iter().filter_map(|(_, argument)| match &argument.value {
            Argument::Port(port) => Some(port.clone()),
            Argument::Constant(_) => None,
        });
        let ports = ports.chain(self.success_when.iter().flat_map(|when| when.ports.iter().cloned()));
        let written = self.outputs.iter().chain(&self.feedback).map(Written::datum);
        let holds = (is_condition && self.of == Subject::Topic).then(|| HOLDS.to_owned());
        ports.chain(written).chain(holds).collect()
    }

    /// A condition answers the tick with the reply.
    fn ask_at_once(&self, text: &mut Text) {
        text.state("idle", |text| {
            text.line("<transition event=\"BT.tick\" target=\"asking\"/>");
            text.answered("BT.halt", None, "halted", &[]);
        });
        text.state("asking", |text| {
            text.element("onentry", |text| {
                self.begin(text);
                self.start_timer(text);
            });
            self.stop_timer(text);
            text.element(&self.transition("idle"), |text| {
                text.send_to_tree("success", &self.outputs, |written| format!("{DATA}.{}", written.field.value));
            });
            text.answered(&format!("{} {} timeout", self.success(), self.refusals()), Some("idle"), "failure", &[]);
            text.answered("BT.halt", Some("idle"), "halted", &[]);
        });
    }

    /// A condition on a topic says what its last message said.
    fn watch(&self, text: &mut Text) {
        let holds = self.condition().unwrap_or("true");
        text.state("watching", |text| {
            text.element(&format!("transition event=\"{}\"", self.event("")), |text| {
                text.line(&format!("<assign location=\"{HOLDS}\" expr=\"{}\"/>", attribute(holds)));
                self.keep(text, &self.outputs);
            });
            text.element(&format!("transition event=\"BT.tick\" cond=\"{HOLDS}\""), |text| {
                text.send_to_tree("success", &self.outputs, Written::datum);
            });
            text.answered("BT.tick", None, "failure", &[]);
            text.answered("BT.halt", None, "halted", &[]);
        });
    }

    /// An action of the tree answers `running` until it knows.
    fn ask_and_go_on(&self, text: &mut Text) {
        text.state("idle", |text| {
            text.line("<transition event=\"BT.tick\" target=\"asking\"/>");
            text.answered("BT.halt", None, "halted", &[]);
        });
        text.state("asking", |text| {
            text.element("onentry", |text| {
                text.send_to_tree("running", &[], Written::datum);
                for written in &self.feedback {
                    text.line(&format!("<assign location=\"{}\" expr=\"undefined\"/>", attribute(&written.datum())));
                }
                self.begin(text);
                self.start_timer(text);
            });
            self.stop_timer(text);
            text.answered("BT.tick", None, "running", &self.feedback);
            self.known(text);
        });
        if self.of == Subject::Action {
            self.cancel(text);
        }
        // Who waits for a topic as long as it takes cannot fail.
        let fails = self.of != Subject::Topic || self.timeout.is_some();
        let answers = [("succeeded", "success", &self.outputs[..]), ("failed", "failure", &[])];
        for (state, answer, outputs) in answers.into_iter().take(1 + usize::from(fails)) {
            text.state(state, |text| {
                text.answered("BT.tick", Some("idle"), answer, outputs);
                self.halted(text);
            });
        }
    }

    /// The transitions of an action of the tree that learns how it goes on.
    fn known(&self, text: &mut Text) {
        let is_action = self.of == Subject::Action;
        if is_action {
            text.line("<transition event=\"BT.halt\" target=\"halting\"/>");
            text.element(&format!("transition event=\"{}\"", self.event(".feedback")), |text| {
                self.keep(text, &self.feedback);
            });
        } else {
            self.halted(text);
        }
        text.element(&self.transition("succeeded"), |text| self.keep(text, &self.outputs));
        // A message of a topic that is not awaited changes nothing.
        if self.success_when.is_some() && self.of != Subject::Topic {
            text.line(&format!("<transition event=\"{}\" target=\"failed\"/>", self.success()));
        }
        let refusals = self.refusals();
        if !refusals.is_empty() {
            text.line(&format!("<transition event=\"{refusals}\" target=\"failed\"/>"));
        }
        if self.timeout.is_some() {
            let target = if is_action { "canceling" } else { "failed" };
            text.line(&format!("<transition event=\"timeout\" target=\"{target}\"/>"));
        }
    }

    /// The states in which an action is called off: too late, or because the tree halts the leaf. A component that does
    /// not confirm it is not waited for.
    fn cancel(&self, text: &mut Text) {
        let over = format!("{} {} timeout", self.success(), self.ends());
        let begin = |text: &mut Text| {
            text.element("onentry", |text| {
                text.line(&format!(
                    "<send type=\"channel\" target=\"{0}\" event=\"{1}.cancel\"/>",
                    attribute(&self.asked.component.value),
                    attribute(&self.asked.name.value)
                ));
                text.line(&format!("<send event=\"timeout\" id=\"patience\" delay=\"{}ms\"/>", PATIENCE.as_millis()));
            });
            text.element("onexit", |text| text.line("<cancel sendid=\"patience\"/>"));
        };
        if self.timeout.is_some() {
            text.state("canceling", |text| {
                begin(text);
                text.answered("BT.tick", None, "running", &[]);
                text.line("<transition event=\"BT.halt\" target=\"halting\"/>");
                text.line(&format!("<transition event=\"{over}\" target=\"failed\"/>"));
            });
        }
        text.state("halting", |text| {
            begin(text);
            text.element(&format!("transition event=\"{over}\" target=\"idle\""), |text| self.leave(text));
        });
    }

    /// The transition of a halt that needs no answer.
    fn halted(&self, text: &mut Text) {
        text.element("transition event=\"BT.halt\" target=\"idle\"", |text| self.leave(text));
    }

    fn leave(&self, text: &mut Text) {
        if let Some(Endpoint { component, name }) = &self.on_halt {
            text.line(&format!(
                "<send type=\"channel\" target=\"{}\" event=\"{}\"/>",
                attribute(&component.value),
                attribute(&name.value)
            ));
        }
        text.send_to_tree("halted", &[], Written::datum);
    }

    /// The request or goal.
    fn begin(&self, text: &mut Text) {
        let event = match self.of {
            Subject::Request => self.asked.name.value.clone(),
            Subject::Action => format!("{}.goal", self.asked.name.value),
            Subject::Topic => return,
        };
        let send = format!(
            "send type=\"channel\" target=\"{}\" event=\"{}\"",
            attribute(&self.asked.component.value),
            attribute(&event)
        );
        text.filled(&send, &self.arguments, |(field, argument)| {
            let value = match &argument.value {
                Argument::Port(port) => port.clone(),
                Argument::Constant(value) => literal(value),
            };
            format!("<param name=\"{}\" expr=\"{}\"/>", attribute(&field.value), attribute(&value))
        });
    }

    fn start_timer(&self, text: &mut Text) {
        if let Some(timeout) = self.timeout {
            text.line(&format!("<send event=\"timeout\" id=\"timeout\" delay=\"{}s\"/>", timeout.as_secs_f64()));
        }
    }

    fn stop_timer(&self, text: &mut Text) {
        if self.timeout.is_some() {
            text.element("onexit", |text| text.line("<cancel sendid=\"timeout\"/>"));
        }
    }

    /// Keeps fields of a message until they are written to ports.
    fn keep(&self, text: &mut Text, fields: &[Written]) {
        for written in fields {
            let (datum, field) = (attribute(&written.datum()), attribute(&written.field.value));
            text.line(&format!("<assign location=\"{datum}\" expr=\"{DATA}.{field}\"/>"));
        }
    }

    /// An event of the component about the action or topic.
    fn event(&self, what: &str) -> String {
        attribute(&format!("{}.{}{what}", self.asked.component.value, self.asked.name.value))
    }

    /// The event that may mean success.
    fn success(&self) -> String {
        match self.of {
            Subject::Request => attribute(&format!("{}.ok", self.asked.component.value)),
            Subject::Action => self.event(".succeeded"),
            Subject::Topic => self.event(""),
        }
    }

    /// The events with which an action ends in vain.
    fn ends(&self) -> String {
        format!("{} {}", self.event(".aborted"), self.event(".canceled"))
    }

    /// The events that mean failure, without the timeout.
    fn refusals(&self) -> String {
        match self.of {
            Subject::Request => attribute(&format!("{}.error", self.asked.component.value)),
            Subject::Action => format!("{} {}", self.event(".rejected"), self.ends()),
            Subject::Topic => String::new(),
        }
    }

    /// The transition of the event that may mean success.
    fn transition(&self, target: &str) -> String {
        let when = self.condition().map_or_else(String::new, |when| format!(" cond=\"{}\"", attribute(when)));
        format!("transition event=\"{}\"{when} target=\"{target}\"", self.success())
    }

    fn condition(&self) -> Option<&str> {
        self.success_when.as_ref().map(|when| when.expression.as_str())
    }
}

impl Written {
    /// The datum that keeps the value: a port of the same name may be an argument.
    fn datum(&self) -> String {
        format!("{}__", self.port.value)
    }
}

impl Text {
    /// An answer to the tree, with the values of output ports.
    fn send_to_tree(&mut self, answer: &str, outputs: &[Written], value: impl Fn(&Written) -> String) {
        self.filled(&format!("send type=\"channel\" target=\"BT\" event=\"{answer}\""), outputs, |written| {
            format!("<param name=\"{}\" expr=\"{}\"/>", attribute(&written.port.value), attribute(&value(written)))
        });
    }

    /// A transition that answers the tree.
    fn answered(&mut self, event: &str, target: Option<&str>, answer: &str, outputs: &[Written]) {
        let target = target.map_or_else(String::new, |target| format!(" target=\"{target}\""));
        self.element(&format!("transition event=\"{event}\"{target}"), |text| {
            text.send_to_tree(answer, outputs, Written::datum);
        });
    }
}

/// A constant in ECMAScript.
fn literal(value: &Datum) -> String {
    match value {
        Datum::Text(text) => Value::from(&**text).to_string(),
        other => other.to_string(),
    }
}
