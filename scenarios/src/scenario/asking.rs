//! Leaves that only ask, do or wait: an entry of the table `leaves` from which their machine is written, as SCXML.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::time::Duration;

use bt::{Direction, Kind, Node, Tree};
use channels::{Shape, Topology};
use diagnostics::document::{Item, Table};
use diagnostics::markup::attribute;
use diagnostics::{Span, Spanned};
use serde_json::{Value, json};
use skills::Datum;

use super::data::{datum, scalar};
use crate::error::Complaints;
use crate::names::unknown;

/// What a leaf does, of which its machine is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Asking {
    /// What it asks, begins or waits for.
    of: Subject,
    component: String,
    /// The name of the service, action or topic.
    name: String,
    /// The fields of the request or goal.
    arguments: Vec<(String, Argument)>,
    /// The condition under which an answer means success, as an ECMAScript expression.
    success_when: Option<SuccessWhen>,
    /// The ports that the fields of the answer, or of feedback, are written to.
    outputs: Vec<Written>,
    feedback: Vec<Written>,
    timeout: Option<Duration>,
    /// What is asked of a component when the tree halts the leaf.
    on_halt: Option<(String, String)>,
}

/// A field that is written to a port.
#[derive(Clone, Debug)]
struct Written {
    port: Spanned<String>,
    field: Spanned<String>,
}

impl PartialEq for Written {
    fn eq(&self, other: &Self) -> bool {
        (&self.port.value, &self.field.value) == (&other.port.value, &other.field.value)
    }
}

/// A condition on the fields of an answer.
#[derive(Clone, Debug)]
struct SuccessWhen {
    /// The expression, about the data of the event.
    expression: String,
    /// The fields and the ports that it names.
    fields: Vec<String>,
    ports: Vec<String>,
    span: Span,
}

impl PartialEq for SuccessWhen {
    fn eq(&self, other: &Self) -> bool {
        self.expression == other.expression
    }
}

/// The value of a field of a request.
#[derive(Clone, Debug)]
enum Argument {
    Constant(Datum),
    /// `{PORT}`: the value of the leaf's port.
    Port(Spanned<String>),
}

impl PartialEq for Argument {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => a == b,
            (Self::Port(a), Self::Port(b)) => a.value == b.value,
            _ => false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subject {
    Request,
    Action,
    Topic,
}

/// The keys that select what a leaf's machine is, of which an entry has at most one.
pub(super) const FORMS: [&str; 4] = ["machine", "request", "action", "topic"];

/// How long a service may take to answer, unless the entry says otherwise: as in the shipped skills.
const PATIENCE: Duration = Duration::from_secs(5);

/// The data of an event, in a machine.
const DATA: &str = "_event.data";

/// The datum that says whether the last message of a topic means success.
const HOLDS: &str = "holds__";

impl Subject {
    /// The key, and the word by which `success_when` calls the message whose fields it compares.
    const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Request => ("request", "reply"),
            Self::Action => ("action", "result"),
            Self::Topic => ("topic", "message"),
        }
    }
}

/// An entry has at most one form.
pub(super) fn one_form() -> Value {
    let pairs = (0..FORMS.len()).flat_map(|a| (a + 1..FORMS.len()).map(move |b| [FORMS[a], FORMS[b]]));
    let both: Vec<Value> = pairs.map(|pair| json!({ "required": pair })).collect();
    json!({ "not": { "anyOf": both } })
}

impl Asking {
    /// Reads what an entry of the table `leaves` asks; `None` if it names nothing to ask.
    pub(super) fn read(entry: Table<'_>) -> Option<Self> {
        let endpoint = |key, about| entry.text(key).about(about).words("`COMPONENT.NAME`").spanned().optional();
        let request = endpoint("request", "The leaf asks this service once: `Door.open`. It succeeds with the reply.");
        let action = endpoint(
            "action",
            "The leaf begins this action: `Arm.pick`. It succeeds with the result, and a halt cancels it.",
        );
        let topic = endpoint("topic", "The leaf waits for a message of this topic: `Sensor.seen`.");
        let arguments = fields(
            entry,
            "arguments",
            "A field of the request or goal: a constant, or `{PORT}`, the value of the leaf's port.",
            argument,
        );
        let success_when = entry
            .text("success_when")
            .about(
                "When the answer means success, as an expression of its fields: `reply.level > 30` of a request, \
                 `result.…` of an action, `message.…` of a topic; `{PORT}` is the value of the leaf's port. If not given, \
                 always.",
            )
            .filled("not be empty")
            .spanned()
            .optional();
        let outputs = fields(entry, "outputs", "The port to which a field of the answer is written.", written);
        let feedback =
            fields(entry, "feedback", "The port to which a field of an action's feedback is written.", written);
        let timeout = entry
            .seconds("timeout_s")
            .about(
                "The time after which the leaf fails, in seconds. If not given, 5 for a request, and none for an action or \
                 a topic.",
            )
            .above_0()
            .optional();
        let on_halt = entry
            .text("on_halt")
            .about("What is asked when the tree halts the leaf: `Door.close`, a service without fields.")
            .words("`COMPONENT.NAME`")
            .spanned()
            .optional();
        let of = [(Subject::Request, request), (Subject::Action, action), (Subject::Topic, topic)];
        let (of, endpoint) = of.into_iter().find_map(|(of, endpoint)| Some((of, endpoint?)))?;
        let (component, name) = split(entry, &endpoint)?;
        let on_halt = on_halt.and_then(|asked| split(entry, &asked));
        let timeout = timeout.or((of == Subject::Request).then_some(PATIENCE));
        let success_when = success_when.map(|text| SuccessWhen::new(&text, of.words().1));
        Some(Self { of, component, name, arguments, success_when, outputs, feedback, timeout, on_halt })
    }

    /// Reports fields that the answer does not have. What is asked is checked with the machine, as that of any other.
    pub(super) fn check_fields(&self, process: &str, topology: &Topology, complaints: &mut Complaints) {
        let Some(channel) = topology.find_channel(&self.component, process) else { return };
        let shapes = topology.get(channel).domain.shapes();
        let mut check = |head: &str, field: &str, span: &Span| {
            let says = |shape: &&Shape| shape.heads().iter().any(|symbol| symbol.name() == head);
            let known = shapes.iter().filter(says).flat_map(|shape| shape.fields().iter().skip(1));
            let known: Vec<&str> = known.map(|(name, _)| &**name).collect();
            if !known.contains(&field) {
                let field = Spanned { value: field.to_owned(), span: span.clone() };
                complaints.push(unknown(&format!("field of <{head}> from {}", self.component), &field, known));
            }
        };
        let success = match self.of {
            Subject::Request => "ok".to_owned(),
            Subject::Action => format!("{}.succeeded", self.name),
            Subject::Topic => self.name.clone(),
        };
        for Written { field, .. } in &self.outputs {
            check(&success, &field.value, &field.span);
        }
        for Written { field, .. } in &self.feedback {
            check(&format!("{}.feedback", self.name), &field.value, &field.span);
        }
        if let Some(SuccessWhen { fields, span, .. }) = &self.success_when {
            fields.iter().for_each(|field| check(&success, field, span));
        }
    }

    /// Reports ports that the leaf does not have.
    pub(super) fn check_ports(&self, tree: &Tree, leaf: &Node, complaints: &mut Complaints) {
        let known = |inputs: bool| {
            let unfit = if inputs { Direction::Output } else { Direction::Input };
            tree.ports(leaf.id()).filter(move |port| port.direction != unfit).map(|port| port.name)
        };
        let mut check = |port: &Spanned<String>, inputs: bool| {
            if !known(inputs).any(|name| name == port.value) {
                let what = format!("{} port of `{}`", if inputs { "input" } else { "output" }, leaf.process());
                complaints.push(unknown(&what, port, known(inputs)));
            }
        };
        for (_, argument) in &self.arguments {
            if let Argument::Port(port) = argument {
                check(port, true);
            }
        }
        if let Some(SuccessWhen { ports, span, .. }) = &self.success_when {
            let named = ports.iter().map(|port| Spanned { value: port.clone(), span: span.clone() });
            named.for_each(|port| check(&port, true));
        }
        self.outputs.iter().chain(&self.feedback).for_each(|written| check(&written.port, false));
    }

    /// The machine of a leaf, as SCXML.
    pub fn scxml(&self, leaf: &Node) -> String {
        let mut text = Text::default();
        text.open(&format!(
            "scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\" name=\"{}\"",
            attribute(leaf.label())
        ));
        let is_condition = leaf.kind() == Kind::Condition;
        text.element("datamodel", |text| {
            self.data(is_condition).iter().for_each(|datum| text.line(&format!("<data id=\"{}\"/>", attribute(datum))));
        });
        match (self.of, is_condition) {
            (Subject::Topic, true) => self.watch(&mut text),
            (_, true) => self.ask_at_once(&mut text),
            (_, false) => self.ask_and_go_on(&mut text),
        }
        text.close("scxml");
        text.written
    }

    /// The machine's data: the ports that it reads, and the values of those that it writes.
    fn data(&self, is_condition: bool) -> BTreeSet<String> {
        let ports = self.arguments.iter().filter_map(|(_, argument)| match argument {
            Argument::Port(port) => Some(port.value.clone()),
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
            let outputs: Vec<Written> = self.outputs.clone();
            text.element(&self.transition("idle"), |text| {
                text.send_to_tree("success", &outputs, |written| format!("{DATA}.{}", written.field.value));
            });
            text.answered(&self.failures(), Some("idle"), "failure", &[]);
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
        let is_action = self.of == Subject::Action;
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
            if is_action {
                text.line("<transition event=\"BT.halt\" target=\"halting\"/>");
                text.element(&format!("transition event=\"{}\"", self.event(".feedback")), |text| {
                    self.keep(text, &self.feedback);
                });
            } else {
                self.halted(text);
            }
            text.element(&self.transition("succeeded"), |text| self.keep(text, &self.outputs));
            if self.success_when.is_some() && self.of != Subject::Topic {
                text.line(&format!("<transition event=\"{}\" target=\"failed\"/>", self.success()));
            }
            let failures =
                if is_action { format!("{} {}", self.event(".rejected"), self.ends()) } else { self.refusals() };
            if !failures.is_empty() {
                text.line(&format!("<transition event=\"{failures}\" target=\"failed\"/>"));
            }
            if self.timeout.is_some() {
                let target = if is_action { "canceling" } else { "failed" };
                text.line(&format!("<transition event=\"timeout\" target=\"{target}\"/>"));
            }
        });
        if is_action {
            self.cancel(text);
        }
        for (state, answer, outputs) in [("succeeded", "success", &self.outputs[..]), ("failed", "failure", &[])] {
            text.state(state, |text| {
                text.answered("BT.tick", Some("idle"), answer, outputs);
                self.halted(text);
            });
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
                    attribute(&self.component),
                    attribute(&self.name)
                ));
                text.line(&format!("<send event=\"timeout\" id=\"patience\" delay=\"{}ms\"/>", PATIENCE.as_millis()));
            });
            text.element("onexit", |text| text.line("<cancel sendid=\"patience\"/>"));
        };
        text.state("canceling", |text| {
            begin(text);
            text.answered("BT.tick", None, "running", &[]);
            text.line("<transition event=\"BT.halt\" target=\"halting\"/>");
            text.line(&format!("<transition event=\"{over}\" target=\"failed\"/>"));
        });
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
        if let Some((component, service)) = &self.on_halt {
            text.line(&format!(
                "<send type=\"channel\" target=\"{}\" event=\"{}\"/>",
                attribute(component),
                attribute(service)
            ));
        }
        text.send_to_tree("halted", &[], Written::datum);
    }

    /// The request or goal.
    fn begin(&self, text: &mut Text) {
        let event = match self.of {
            Subject::Request => self.name.clone(),
            Subject::Action => format!("{}.goal", self.name),
            Subject::Topic => return,
        };
        let send =
            format!("send type=\"channel\" target=\"{}\" event=\"{}\"", attribute(&self.component), attribute(&event));
        text.filled(&send, &self.arguments, |(field, argument)| {
            let value = match argument {
                Argument::Port(port) => port.value.clone(),
                Argument::Constant(value) => literal(value),
            };
            format!("<param name=\"{}\" expr=\"{}\"/>", attribute(field), attribute(&value))
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
        attribute(&format!("{}.{}{what}", self.component, self.name))
    }

    /// The event that may mean success.
    fn success(&self) -> String {
        match self.of {
            Subject::Request => attribute(&format!("{}.ok", self.component)),
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
            Subject::Request => attribute(&format!("{}.error", self.component)),
            Subject::Action | Subject::Topic => String::new(),
        }
    }

    /// All events that mean failure, of a condition that asks.
    fn failures(&self) -> String {
        let timeout = if self.timeout.is_some() { " timeout" } else { "" };
        format!("{}{timeout}", attribute(&self.component))
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

impl SuccessWhen {
    /// The condition. Except inside texts, `answer` stands in it for the event's data, and `{PORT}` for a port's value.
    fn new(text: &Spanned<String>, answer: &str) -> Self {
        let span = text.span.clone();
        let mut condition = Self { expression: String::new(), fields: Vec::new(), ports: Vec::new(), span };
        let (mut quote, mut word, mut is_port) = (None, String::new(), false);
        for sign in text.value.chars().chain([' ']) {
            if quote.is_none() && (sign.is_alphanumeric() || matches!(sign, '_' | '$')) {
                word.push(sign);
                continue;
            }
            if is_port {
                condition.ports.push(word.clone());
            }
            condition.push(&std::mem::take(&mut word), answer);
            is_port = quote.is_none() && sign == '{';
            if quote.is_some() || !matches!(sign, '{' | '}') {
                condition.expression.push(sign);
            }
            quote = match quote {
                Some(begun) if begun == sign => None,
                None if matches!(sign, '\'' | '"' | '`') => Some(sign),
                same => same,
            };
        }
        condition.expression.pop();
        condition
    }

    fn push(&mut self, word: &str, answer: &str) {
        let before = self.expression.trim_end();
        if word == answer && !before.ends_with('.') {
            self.expression.push_str(DATA);
            return;
        }
        if !word.is_empty() && before.strip_suffix('.').is_some_and(|before| before.trim_end().ends_with(DATA)) {
            self.fields.push(word.to_owned());
        }
        self.expression.push_str(word);
    }
}

impl Written {
    /// The datum that keeps the value: a port of the same name may be an argument.
    fn datum(&self) -> String {
        format!("{}__", self.port.value)
    }
}

/// The text of a machine.
#[derive(Default)]
struct Text {
    written: String,
    depth: usize,
}

impl Text {
    fn line(&mut self, line: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.written, "{:1$}{line}", "", 2 * self.depth);
    }

    fn open(&mut self, tag: &str) {
        self.line(&format!("<{tag}>"));
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }

    /// An element with this content, if there is any.
    fn element(&mut self, tag: &str, content: impl FnOnce(&mut Self)) {
        let before = self.written.len();
        self.open(tag);
        let inside = self.written.len();
        content(self);
        if self.written.len() > inside {
            self.close(tag.split(' ').next().unwrap_or_default());
        } else {
            self.written.truncate(before);
            self.depth -= 1;
            self.line(&format!("<{tag}/>"));
        }
    }

    fn state(&mut self, id: &str, content: impl FnOnce(&mut Self)) {
        self.element(&format!("state id=\"{id}\""), content);
    }

    /// An element with a line for each item.
    fn filled<T>(&mut self, tag: &str, items: &[T], line: impl Fn(&T) -> String) {
        self.element(tag, |text| items.iter().for_each(|item| text.line(&line(item))));
    }

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

/// The component and the name after the dot; reports a text without both.
fn split(entry: Table<'_>, endpoint: &Spanned<String>) -> Option<(String, String)> {
    let parts = endpoint.value.split_once('.').filter(|(component, name)| !component.is_empty() && !name.is_empty());
    if parts.is_none() {
        let problem = endpoint.span.problem(format!("`{}` names no component and what it offers", endpoint.value));
        entry.report(problem.with_label("here").with_help("write COMPONENT.NAME, as in `Door.open`"));
    }
    parts.map(|(component, name)| (component.to_owned(), name.to_owned()))
}

/// Reads a table whose keys are names.
fn fields<T>(
    entry: Table<'_>,
    key: &str,
    about: &str,
    read: impl Fn(Table<'_>, &str, &Span, &str) -> Option<T>,
) -> Vec<T> {
    let Some(table) = entry.table(key).about(about).optional() else { return Vec::new() };
    let name = if key == "arguments" { "FIELD" } else { "PORT" };
    table.names(name).filter_map(|(name, span)| read(table, name, span, about)).collect()
}

fn argument(table: Table<'_>, field: &str, _: &Span, about: &str) -> Option<(String, Argument)> {
    let item = table.get::<Item<'_>>(field).about(about).rules(scalar).optional()?;
    let port = item.as_text().and_then(|text| text.strip_prefix('{')?.strip_suffix('}').map(str::to_owned));
    if let Some(port) = port {
        let span = item.span().clone();
        return Some((field.to_owned(), Argument::Port(Spanned { value: port, span })));
    }
    let value = datum(&item);
    if value.is_none() {
        table.report(item.wrong("a string, a number, true or false"));
    }
    Some((field.to_owned(), Argument::Constant(value?)))
}

fn written(table: Table<'_>, port: &str, span: &Span, about: &str) -> Option<Written> {
    let field = table.text(port).about(about).filled("not be empty").spanned().optional()?;
    Some(Written { port: Spanned { value: port.to_owned(), span: span.clone() }, field })
}
