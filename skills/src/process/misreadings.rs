//! What a machine expects of messages that no message has.

use std::collections::BTreeSet;

use channels::{FieldKind, Symbol};
use diagnostics::{Problem, nearest_or_all};
use miette::SourceSpan;

use super::check::own_events;
use super::wiring::Wiring;
use crate::chart::{Action, ActionKind, EventClass, Transition, visit_actions};
use crate::expression::{EventField, Expr, Statement};
use crate::{Chart, Datum};

/// The fields of a message that becomes an event of a machine.
#[derive(Clone, Copy, Debug)]
pub struct EventFields<'m> {
    /// The name of the event.
    pub event: &'m str,
    /// What `_event.data` has.
    pub fields: &'m [(String, FieldKind)],
}

/// Every message that a process may receive. A component may be made for more clients than those of one system.
pub(super) fn received(wiring: &Wiring) -> Vec<EventFields<'_>> {
    let mut received = Vec::new();
    for incoming in &wiring.incoming {
        for shape in incoming.domain.shapes() {
            let heads: BTreeSet<&Symbol> = shape.heads().iter().collect();
            let named = incoming.events.iter().filter(|(head, ..)| heads.contains(head));
            let unnamed = heads.is_empty().then_some(&incoming.peer);
            let events = named.map(|(_, event, _)| event).chain(unnamed);
            received.extend(events.map(|event| EventFields { event, fields: shape.fields() }));
        }
    }
    for shape in wiring.understood.shapes() {
        received.extend(shape.heads().iter().map(|head| EventFields { event: head.name(), fields: shape.fields() }));
    }
    received
}

impl Chart {
    /// Reports the fields that a transition reads from its event although no message that becomes this event has them,
    /// and values with which it compares a field that can have none like it. `received` are all messages that the
    /// machine may receive.
    ///
    /// Such a field is `undefined`, so a condition about it is always false, or always true.
    #[must_use]
    pub fn misreadings(&self, received: &[EventFields<'_>]) -> Vec<Problem> {
        let Some(own) = own_events(self) else { return Vec::new() };
        let own: BTreeSet<EventClass> = own.iter().map(|event| self.events.class(event)).collect();
        let received: Vec<(EventClass, EventFields<'_>)> =
            received.iter().map(|message| (self.events.class(message.event), *message)).collect();
        let transitions = self.transitions().map(|id| self.transition(id));
        transitions.flat_map(|transition| misread_by(transition, &received, &own)).collect()
    }
}

fn misread_by(
    transition: &Transition,
    received: &[(EventClass, EventFields<'_>)],
    own: &BTreeSet<EventClass>,
) -> Vec<Problem> {
    let mut reads: Vec<(&Expr, SourceSpan)> = Vec::new();
    visit_expressions(transition, &mut |part, span| {
        if field(part).is_some() || compared(part).is_some() {
            reads.push((part, span));
        }
    });
    let takes = |class: EventClass| transition.descriptors.iter().any(|descriptor| descriptor.matches.contains(class));
    // What comes with the machine's own events is not known here.
    if reads.is_empty() || own.iter().any(|class| takes(*class)) {
        return Vec::new();
    }
    let messages: Vec<EventFields<'_>> =
        received.iter().filter(|(class, _)| takes(*class)).map(|(_, message)| *message).collect();
    if messages.is_empty() {
        return Vec::new();
    }
    let misread = |(part, span): (&Expr, SourceSpan)| {
        let found = unknown_field(part, &messages).or_else(|| unlike(part, &messages));
        found.map(|found| found.at(span, "here"))
    };
    reads.into_iter().filter_map(misread).collect()
}

/// Visits every part of a transition's expressions.
fn visit_expressions<'t>(transition: &'t Transition, visit: &mut dyn FnMut(&'t Expr, SourceSpan)) {
    if let Some(condition) = &transition.condition {
        condition.test.visit(&mut |part| visit(part, condition.span));
    }
    visit_actions(&transition.content, &mut |action| {
        for (whole, span) in expressions(action) {
            whole.visit(&mut |part| visit(part, span));
        }
    });
}

/// The expressions of an action, without those of the actions inside it.
fn expressions(Action { kind, span }: &Action) -> Vec<(&Expr, SourceSpan)> {
    match kind {
        ActionKind::Assign(_, value) | ActionKind::Log { value: Some(value), .. } => vec![(value, *span)],
        ActionKind::Foreach(foreach) => vec![(&foreach.array, *span)],
        ActionKind::Send(send) => send.named().map(|(_, value, span)| (value, span)).collect(),
        ActionKind::If(branches) => {
            let conditions = branches.iter().filter_map(|branch| branch.condition.as_ref());
            conditions.map(|condition| (&condition.test, condition.span)).collect()
        }
        ActionKind::Script(statements) => {
            let values = statements.iter().map(|statement| match statement {
                Statement::Assign(_, value) | Statement::Update(_, _, value) | Statement::Evaluate(value) => value,
            });
            values.map(|value| (value, *span)).collect()
        }
        _ => Vec::new(),
    }
}

/// The name in `_event.data.NAME`.
fn field(expr: &Expr) -> Option<&str> {
    let (whole, name) = match expr {
        Expr::Member(whole, name) => (&**whole, &**name),
        Expr::Index(parts) => match &**parts {
            [whole, Expr::Constant(Datum::Text(name))] => (whole, &**name),
            _ => return None,
        },
        _ => return None,
    };
    matches!(whole, Expr::EventField(EventField::Data)).then_some(name)
}

fn kinds<'m>(messages: &'m [EventFields<'m>], field: &'m str) -> impl Iterator<Item = &'m FieldKind> {
    let fields = messages.iter().flat_map(|message| message.fields);
    fields.filter(move |(name, _)| name == field).map(|(_, kind)| kind)
}

fn unknown_field(expr: &Expr, messages: &[EventFields<'_>]) -> Option<Problem> {
    let name = field(expr).filter(|name| kinds(messages, name).next().is_none())?;
    let events: BTreeSet<&str> = messages.iter().map(|message| message.event).collect();
    let known: BTreeSet<&str> = messages.iter().flat_map(|message| message.fields).map(|(name, _)| &**name).collect();
    let events = events.into_iter().map(|event| format!("`{event}`")).collect::<Vec<_>>().join(" or ");
    let problem = Problem::new(format!("{events} has no field `{name}`"));
    Some(problem.with_help(nearest_or_all(name, "fields", &known.into_iter().collect::<Vec<_>>())))
}

/// The field and the constant of a comparison.
fn compared(expr: &Expr) -> Option<(&str, &Datum)> {
    let Expr::Binary(op, operands) = expr else { return None };
    match &**operands {
        _ if !op.compares() => None,
        [one, Expr::Constant(value)] | [Expr::Constant(value), one] => Some((field(one)?, value)),
        _ => None,
    }
}

/// A comparison with a constant that no value of the field can be like.
fn unlike(expr: &Expr, messages: &[EventFields<'_>]) -> Option<Problem> {
    let (name, value) = compared(expr)?;
    let kind = kinds(messages, name).next()?;
    if kinds(messages, name).any(|kind| may_be_like(kind, value)) {
        return None;
    }
    let problem = match (kind, value) {
        (FieldKind::Symbol(_), Datum::Text(text)) => Problem::new(format!("the field `{name}` is never `{text}`")),
        _ => Problem::new(format!("the field `{name}` cannot be compared with {value}")),
    };
    Some(problem.with_help(format!("it is {kind}")))
}

/// Whether a field of this kind can have a value that is like this one, or is compared with it for another reason.
fn may_be_like(kind: &FieldKind, value: &Datum) -> bool {
    match (kind, value) {
        (FieldKind::Optional(kind), _) => may_be_like(kind, value),
        (FieldKind::Symbol(symbols), Datum::Text(text)) => symbols.iter().any(|symbol| symbol.name() == &**text),
        (FieldKind::Symbol(symbols), Datum::Number(_)) => symbols.iter().any(|symbol| is_numeric(symbol.name())),
        (FieldKind::Text, Datum::Number(_)) => false,
        (FieldKind::Int | FieldKind::Real | FieldKind::Bool, Datum::Text(text)) => is_numeric(text),
        _ => true,
    }
}

/// Whether ECMAScript takes the text for a number where it is compared with one.
fn is_numeric(text: &str) -> bool {
    text.trim().parse::<f64>().is_ok()
}
