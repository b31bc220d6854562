//! The machine of a leaf that asks, written as SCXML.

use bt::{Kind, Node};
use serde_json::Value;
use skills::Datum;
use std::collections::BTreeSet;

use super::success::DATA;
use super::{Argument, Asking, Endpoint, PATIENCE, Written};
use crate::scenario::offer::Subject;
use crate::scenario::scxml_text::Text;

/// The datum for whether the last message of a topic means success.
const HOLDS: &str = "holds__";

impl Asking {
    /// The machine of a leaf, as SCXML.
    pub fn scxml(&self, leaf: &Node) -> String {
        let is_condition = leaf.kind() == Kind::Condition;
        Text::machine(leaf.label(), |text| {
            text.element("datamodel", &[], |text| {
                self.data(is_condition).iter().for_each(|datum| text.empty("data", &[("id", datum)]));
            });
            match (self.of, is_condition) {
                (Subject::Topic, true) => self.watch(text),
                (_, true) => self.ask_at_once(text),
                (_, false) => self.ask_and_go_on(text),
            }
        })
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
        text.idle();
        text.state("asking", |text| {
            text.element("onentry", &[], |text| {
                self.begin(text);
                self.start_timer(text);
            });
            self.stop_timer(text);
            text.transition(&self.success(), self.condition(), Some("idle"), |text| {
                text.send_to_tree("success", &self.outputs, |written| format!("{DATA}.{}", written.field.value));
            });
            text.answered(&format!("{} {} timeout", self.success(), self.refusals()), Some("idle"), "failure", &[]);
            text.answered("BT.halt", Some("idle"), "halted", &[]);
        });
    }

    /// A condition on a topic has the outcome of the last message.
    fn watch(&self, text: &mut Text) {
        text.state("watching", |text| {
            text.transition(&self.event(""), None, None, |text| {
                text.assign(HOLDS, self.condition().unwrap_or("true"));
                text.keep(&self.outputs);
            });
            text.transition("BT.tick", Some(HOLDS), None, |text| {
                text.send_to_tree("success", &self.outputs, Written::datum);
            });
            text.answered("BT.tick", None, "failure", &[]);
            text.answered("BT.halt", None, "halted", &[]);
        });
    }

    /// An action of the tree answers `running` until the result is known.
    fn ask_and_go_on(&self, text: &mut Text) {
        text.idle();
        text.state("asking", |text| {
            text.element("onentry", &[], |text| {
                text.send_to_tree("running", &[], Written::datum);
                self.feedback.iter().for_each(|written| text.assign(&written.datum(), "undefined"));
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
        // A leaf that waits for a topic without a timeout cannot fail.
        let fails = self.of != Subject::Topic || self.timeout.is_some();
        let answers = [("succeeded", "success", &self.outputs[..]), ("failed", "failure", &[])];
        for (state, answer, outputs) in answers.into_iter().take(1 + usize::from(fails)) {
            text.state(state, |text| {
                text.answered("BT.tick", Some("idle"), answer, outputs);
                self.halted(text, "BT.halt");
            });
        }
    }

    /// The transitions of an action of the tree that learns how it goes on.
    fn known(&self, text: &mut Text) {
        let is_action = self.of == Subject::Action;
        if is_action {
            text.go_to("halting", "BT.halt");
            text.transition(&self.event(".feedback"), None, None, |text| text.keep(&self.feedback));
        } else {
            self.halted(text, "BT.halt");
        }
        let when = self.condition();
        text.transition(&self.success(), when, Some("succeeded"), |text| text.keep(&self.outputs));
        // A message of a topic that is not awaited changes nothing.
        if when.is_some() && self.of != Subject::Topic {
            text.go_to("failed", &self.success());
        }
        let refusals = self.refusals();
        if !refusals.is_empty() {
            text.go_to("failed", &refusals);
        }
        if self.timeout.is_some() {
            text.go_to(if is_action { "canceling" } else { "failed" }, "timeout");
        }
    }

    /// The states in which an action is called off: too late, or because the tree halts the leaf. A component that does
    /// not confirm it is not waited for.
    fn cancel(&self, text: &mut Text) {
        let over = format!("{} {} timeout", self.success(), self.ends());
        let begin = |text: &mut Text| {
            text.element("onentry", &[], |text| {
                let cancel = format!("{}.cancel", self.asked.name.value);
                text.message(&self.asked.component.value, &cancel, []);
                text.start_timer("patience", &format!("{}ms", PATIENCE.as_millis()));
            });
            text.stop_timer("patience");
        };
        if self.timeout.is_some() {
            text.state("canceling", |text| {
                begin(text);
                text.answered("BT.tick", None, "running", &[]);
                text.go_to("halting", "BT.halt");
                text.go_to("failed", &over);
            });
        }
        text.state("halting", |text| {
            begin(text);
            self.halted(text, &over);
        });
    }

    /// The transition that ends a halt with this event.
    fn halted(&self, text: &mut Text, event: &str) {
        text.transition(event, None, Some("idle"), |text| {
            if let Some(Endpoint { component, name }) = &self.on_halt {
                text.message(&component.value, &name.value, []);
            }
            text.send_to_tree("halted", &[], Written::datum);
        });
    }

    /// The request or goal.
    fn begin(&self, text: &mut Text) {
        let Endpoint { component, name } = &self.asked;
        let event = match self.of {
            Subject::Request => name.value.clone(),
            Subject::Action => format!("{}.goal", name.value),
            Subject::Topic => return,
        };
        let fields = self.arguments.iter().map(|(field, argument)| match &argument.value {
            Argument::Port(port) => (&*field.value, port.clone()),
            Argument::Constant(value) => (&*field.value, literal(value)),
        });
        text.message(&component.value, &event, fields);
    }

    fn start_timer(&self, text: &mut Text) {
        if let Some(timeout) = self.timeout {
            text.start_timer("timeout", &format!("{}s", timeout.as_secs_f64()));
        }
    }

    fn stop_timer(&self, text: &mut Text) {
        if self.timeout.is_some() {
            text.stop_timer("timeout");
        }
    }

    /// An event of the component about the action or topic.
    fn event(&self, what: &str) -> String {
        format!("{}.{}{what}", self.asked.component.value, self.asked.name.value)
    }

    /// The event that may mean success.
    fn success(&self) -> String {
        match self.of {
            Subject::Request => format!("{}.ok", self.asked.component.value),
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
            Subject::Request => format!("{}.error", self.asked.component.value),
            Subject::Action => format!("{} {}", self.event(".rejected"), self.ends()),
            Subject::Topic => String::new(),
        }
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
    /// The state of a leaf that is not active.
    fn idle(&mut self) {
        self.state("idle", |text| {
            text.go_to("asking", "BT.tick");
            text.answered("BT.halt", None, "halted", &[]);
        });
    }

    fn go_to(&mut self, state: &str, event: &str) {
        self.transition(event, None, Some(state), |_| {});
    }

    /// A message to a process, with the expressions of its fields.
    fn message<'f>(&mut self, target: &str, event: &str, fields: impl IntoIterator<Item = (&'f str, String)>) {
        self.send(&[("type", "channel"), ("target", target), ("event", event)], fields);
    }

    /// An answer to the tree, with the values of output ports.
    fn send_to_tree(&mut self, answer: &str, outputs: &[Written], value: impl Fn(&Written) -> String) {
        let fields = outputs.iter().map(|written| (&*written.port.value, value(written)));
        self.message("BT", answer, fields);
    }

    fn answered(&mut self, event: &str, target: Option<&str>, answer: &str, outputs: &[Written]) {
        self.transition(event, None, target, |text| text.send_to_tree(answer, outputs, Written::datum));
    }

    /// Keeps fields of a message until they are written to ports.
    fn keep(&mut self, fields: &[Written]) {
        fields.iter().for_each(|written| self.assign(&written.datum(), &format!("{DATA}.{}", written.field.value)));
    }

    /// Sends the event `timeout` after this time.
    fn start_timer(&mut self, id: &str, delay: &str) {
        self.empty("send", &[("event", "timeout"), ("id", id), ("delay", delay)]);
    }

    /// Stops the timer when the state is left.
    fn stop_timer(&mut self, id: &str) {
        self.element("onexit", &[], |text| text.empty("cancel", &[("sendid", id)]));
    }
}

/// A constant in ECMAScript.
fn literal(value: &Datum) -> String {
    match value {
        Datum::Text(text) => Value::from(&**text).to_string(),
        other => other.to_string(),
    }
}
