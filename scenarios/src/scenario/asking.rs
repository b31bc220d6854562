//! Leaves that only ask, do or wait: an entry of the table `leaves` from which their machine is written, as SCXML.

mod check;
mod machine;
mod success;

use std::time::Duration;

use bt::{Direction, Kind, Node, Tree};
use diagnostics::document::{Item, Own, Referent, Table};
use diagnostics::{Span, Spanned};
use serde_json::{Value, json};
use skills::Datum;

use self::success::SuccessWhen;
use super::data::{datum, scalar};
use super::offer::Subject;
use crate::error::Complaints;
use crate::names::unknown;

/// What a leaf does, of which its machine is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Asking {
    /// What it asks, begins or waits for.
    of: Subject,
    asked: Endpoint,
    /// The fields of the request or goal.
    arguments: Vec<(Spanned<String>, Spanned<Argument>)>,
    /// The condition under which an answer means success, as an ECMAScript expression.
    success_when: Option<SuccessWhen>,
    /// The ports that the fields of the answer, or of feedback, are written to.
    outputs: Vec<Written>,
    feedback: Vec<Written>,
    timeout: Option<Duration>,
    /// What is asked of a component when the tree halts the leaf.
    on_halt: Option<Endpoint>,
}

/// A component, and what it offers.
#[derive(Clone, Debug, PartialEq)]
struct Endpoint {
    component: Spanned<String>,
    name: Spanned<String>,
}

#[derive(Clone, Debug, PartialEq)]
struct Written {
    port: Spanned<String>,
    field: Spanned<String>,
}

#[derive(Clone, Debug, PartialEq)]
enum Argument {
    Constant(Datum),
    /// `{PORT}`: the value of the leaf's port.
    Port(String),
}

/// The keys that select what a leaf's machine is, of which an entry has at most one.
pub(super) const FORMS: [&str; 4] = ["machine", "request", "action", "topic"];

/// How long a service may take to answer, unless the entry has a timeout: as in the shipped skills.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn one_form() -> Value {
    let pairs = (0..FORMS.len()).flat_map(|a| (a + 1..FORMS.len()).map(move |b| [FORMS[a], FORMS[b]]));
    let both: Vec<Value> = pairs.map(|pair| json!({ "required": pair })).collect();
    json!({ "not": { "anyOf": both } })
}

impl Asking {
    /// Reads what an entry of the table `leaves` asks; `None` if it names nothing to ask.
    pub(super) fn read(entry: Table<'_>) -> Option<Self> {
        let about = "A field of the request or goal: a constant, or `{PORT}`, the value of the leaf's port.";
        let arguments = fields(entry, "arguments", about, argument);
        let about = "The port to which a field of the answer is written.";
        let outputs = fields(entry, "outputs", about, written(Own::AnswerField));
        let about = "The port to which a field of an action's feedback is written.";
        let feedback = fields(entry, "feedback", about, written(Own::FeedbackField));
        let (success_when, timeout) = (read_success(entry), read_timeout(entry));
        let about = "What is asked when the tree halts the leaf: `Door.close`, a service without fields.";
        let on_halt = endpoint(entry, "on_halt", Subject::Request, about);
        let (of, endpoint) = read_subject(entry)?;
        let asking = Self {
            of,
            asked: split(entry, &endpoint)?,
            arguments,
            success_when: success_when.map(|text| SuccessWhen::new(&text, of.answer())),
            outputs,
            feedback,
            timeout: timeout.or((of == Subject::Request).then_some(PATIENCE)),
            on_halt: on_halt.and_then(|asked| split(entry, &asked)),
        };
        if let Some(when) = &asking.success_when {
            when.problems(of.answer(), asking.data(false)).into_iter().for_each(|problem| entry.report(problem));
        }
        Some(asking)
    }

    /// What a problem of the machine is about: the only part that its author wrote as an expression, if there is one.
    pub(super) fn place(&self) -> &Span {
        self.success_when.as_ref().map_or(&self.asked.name.span, |when| &when.span)
    }

    /// What cannot be done by a leaf of this kind, if it cannot.
    pub(super) fn misfit(&self, leaf: &Node) -> Option<&'static str> {
        let is_misfit = leaf.kind() == Kind::Condition && self.of == Subject::Action;
        is_misfit.then_some("a condition cannot begin an action: it is decided at once")
    }

    /// Reports ports that the leaf does not have. Returns whether there is nothing to report.
    pub(super) fn check_ports(&self, tree: &Tree, leaf: &Node, complaints: &mut Complaints) -> bool {
        let known = |inputs: bool| {
            let unfit = if inputs { Direction::Output } else { Direction::Input };
            tree.ports(leaf.id()).filter(move |port| port.direction != unfit).map(|port| port.name)
        };
        let mut fits = true;
        let mut check = |port: &Spanned<String>, inputs: bool| {
            if !known(inputs).any(|name| name == port.value) {
                let what = format!("{} port of `{}`", if inputs { "input" } else { "output" }, leaf.process());
                complaints.push(unknown(&what, port, known(inputs)));
                fits = false;
            }
        };
        for (_, argument) in &self.arguments {
            if let Argument::Port(port) = &argument.value {
                check(&Spanned { value: port.clone(), span: argument.span.clone() }, true);
            }
        }
        if let Some(SuccessWhen { ports, span, .. }) = &self.success_when {
            let named = ports.iter().map(|port| Spanned { value: port.clone(), span: span.clone() });
            named.for_each(|port| check(&port, true));
        }
        self.outputs.iter().chain(&self.feedback).for_each(|written| check(&written.port, false));
        fits
    }
}

fn endpoint(entry: Table<'_>, key: &str, of: Subject, about: &str) -> Option<Spanned<String>> {
    let endpoint = entry.text(key).about(about).words("`COMPONENT.NAME`");
    endpoint.refers_to(Referent::Offer(of.noun())).spanned().optional()
}

/// What the leaf asks, begins or waits for.
fn read_subject(entry: Table<'_>) -> Option<(Subject, Spanned<String>)> {
    let about = "The leaf asks this service once: `Door.open`. It succeeds with the reply.";
    let request = endpoint(entry, "request", Subject::Request, about);
    let about = "The leaf begins this action: `Arm.pick`. It succeeds with the result, and a halt cancels it.";
    let action = endpoint(entry, "action", Subject::Action, about);
    let topic = endpoint(entry, "topic", Subject::Topic, "The leaf waits for a message of this topic: `Sensor.seen`.");
    let of = [(Subject::Request, request), (Subject::Action, action), (Subject::Topic, topic)];
    of.into_iter().find_map(|(of, endpoint)| Some((of, endpoint?)))
}

fn read_success(entry: Table<'_>) -> Option<Spanned<String>> {
    let about = "When the answer means success, as an expression of its fields: `reply.level > 30` of a request, \
                 `result.…` of an action, `message.…` of a topic; `{PORT}` is the value of the leaf's port. If not \
                 given, always.";
    let when = entry.text("success_when").about(about).refers_to(Referent::Own(Own::AnswerCondition));
    when.filled("not be empty").spanned().optional()
}

fn read_timeout(entry: Table<'_>) -> Option<Duration> {
    let about = "The time after which the leaf fails, in seconds. If not given, 5 for a request, and none for an \
                 action or a topic.";
    entry.seconds("timeout_s").about(about).above_0().optional()
}

/// The component and the name after the dot; reports a text without both.
fn split(entry: Table<'_>, endpoint: &Spanned<String>) -> Option<Endpoint> {
    let parts = endpoint.value.split_once('.').filter(|(component, name)| !component.is_empty() && !name.is_empty());
    if parts.is_none() {
        let problem = endpoint.span.problem(format!("`{}` names no component and what it offers", endpoint.value));
        entry.report(problem.with_label("here").with_help("write COMPONENT.NAME, as in `Door.open`"));
    }
    let placed = |part: &str| Spanned { value: part.to_owned(), span: endpoint.span.clone() };
    parts.map(|(component, name)| Endpoint { component: placed(component), name: placed(name) })
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

fn argument(table: Table<'_>, field: &str, span: &Span, about: &str) -> Option<(Spanned<String>, Spanned<Argument>)> {
    let item = table.get::<Item<'_>>(field).about(about).rules(scalar);
    let item = item.named_after(Referent::Own(Own::Argument)).refers_to(Referent::Own(Own::InputPort)).optional()?;
    let port = item.as_text().and_then(|text| text.strip_prefix('{')?.strip_suffix('}').map(str::to_owned));
    let value = port.map(Argument::Port).or_else(|| datum(&item).map(Argument::Constant));
    if value.is_none() {
        table.report(item.wrong("a string, a number, true or false"));
    }
    let field = Spanned { value: field.to_owned(), span: span.clone() };
    Some((field, Spanned { value: value?, span: item.span().clone() }))
}

fn written(field: Own) -> impl Fn(Table<'_>, &str, &Span, &str) -> Option<Written> {
    move |table, port, span, about| {
        let text =
            table.text(port).about(about).named_after(Referent::Own(Own::OutputPort)).refers_to(Referent::Own(field));
        let field = text.filled("not be empty").spanned().optional()?;
        Some(Written { port: Spanned { value: port.to_owned(), span: span.clone() }, field })
    }
}
