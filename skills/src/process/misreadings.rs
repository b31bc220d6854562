//! What a machine expects of messages that no message has.

use std::collections::BTreeSet;
use std::sync::Arc;

use channels::{FieldKind, Shape};
use diagnostics::{Problem, nearest_or_all};
use miette::SourceSpan;

use super::check::own_events;
use super::vocabulary::MessageForm;
use super::wiring::Wiring;
use crate::chart::{Action, ActionKind, Transition, visit_actions};
use crate::expression::{BinaryOp, EventField, Expr, Statement};
use crate::{Chart, Datum};

/// Every message of a process, one for each shape. A component may be made for more clients than those of one system.
pub(super) fn heard(wiring: &Wiring) -> Vec<MessageForm> {
    let form = |peer: Option<&Arc<str>>, event: &str, shape: &Shape| MessageForm {
        peer: peer.map(|peer| peer.to_string()),
        event: event.to_owned(),
        fields: shape.fields().to_vec(),
    };
    let received = wiring.incoming.iter().flat_map(|incoming| {
        incoming.domain.shapes().iter().flat_map(move |shape| {
            let heads = incoming.events.iter().filter(|(head, ..)| shape.heads().contains(head));
            let named = heads.map(move |(_, event, _)| form(Some(&incoming.peer), event, shape));
            let unnamed = shape.heads().is_empty().then(|| form(Some(&incoming.peer), &incoming.peer, shape));
            named.chain(unnamed)
        })
    });
    let understood = wiring.understood.shapes().iter();
    let understood = understood.flat_map(|shape| shape.heads().iter().map(move |head| form(None, head.name(), shape)));
    received.chain(understood).collect()
}

impl Chart {
    /// Reports the fields that a transition reads from its event although no message that becomes this event has them,
    /// and values with which it compares a field that can have none like it. `heard` are all messages of the machine.
    ///
    /// Such a field is `undefined`, so a condition about it is always false, or always true.
    #[must_use]
    pub fn misreadings(&self, heard: &[MessageForm]) -> Vec<Problem> {
        let Some(own) = own_events(self) else { return Vec::new() };
        let transitions = self.transitions().map(|id| self.transition(id));
        transitions.flat_map(|transition| self.misread_by(transition, heard, &own)).collect()
    }

    fn misread_by(&self, transition: &Transition, heard: &[MessageForm], own: &BTreeSet<String>) -> Vec<Problem> {
        let takes = |event: &str| {
            let class = self.events.class(event);
            transition.descriptors.iter().any(|descriptor| descriptor.matches.contains(class))
        };
        let messages: Vec<&MessageForm> = heard.iter().filter(|message| takes(&message.event)).collect();
        // What comes with the machine's own events is not known here.
        if messages.is_empty() || own.iter().any(|event| takes(event)) {
            return Vec::new();
        }
        let mut problems = Vec::new();
        let mut read = |whole: &Expr, span: SourceSpan| {
            whole.visit(&mut |part| {
                let found = unknown_field(part, &messages).or_else(|| unlike(part, &messages));
                problems.extend(found.map(|found| found.at(span, "here")));
            });
        };
        if let Some(condition) = &transition.condition {
            read(&condition.test, condition.span);
        }
        visit_actions(&transition.content, &mut |action| {
            expressions(action).into_iter().for_each(|(expr, span)| read(expr, span));
        });
        problems
    }
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

/// The kinds that a field has in these messages.
fn kinds<'m>(messages: &'m [&MessageForm], field: &'m str) -> impl Iterator<Item = &'m FieldKind> {
    let fields = messages.iter().flat_map(|message| &message.fields);
    fields.filter(move |(name, _)| name == field).map(|(_, kind)| kind)
}

fn unknown_field(expr: &Expr, messages: &[&MessageForm]) -> Option<Problem> {
    let name = field(expr).filter(|name| kinds(messages, name).next().is_none())?;
    let events: BTreeSet<&str> = messages.iter().map(|message| &*message.event).collect();
    let known: BTreeSet<&str> = messages.iter().flat_map(|message| &message.fields).map(|(name, _)| &**name).collect();
    let events = events.into_iter().map(|event| format!("`{event}`")).collect::<Vec<_>>().join(" or ");
    let problem = Problem::new(format!("{events} has no field `{name}`"));
    Some(problem.with_help(nearest_or_all(name, "fields", &known.into_iter().collect::<Vec<_>>())))
}

/// A comparison with a constant that no value of the field can be like.
fn unlike(expr: &Expr, messages: &[&MessageForm]) -> Option<Problem> {
    use BinaryOp::{Equal, Greater, GreaterEqual, Identical, Less, LessEqual, NotEqual, NotIdentical};
    let Expr::Binary(Equal | NotEqual | Identical | NotIdentical | Less | LessEqual | Greater | GreaterEqual, operands) =
        expr
    else {
        return None;
    };
    let (name, value) = match &**operands {
        [one, Expr::Constant(value)] | [Expr::Constant(value), one] => (field(one)?, value),
        _ => return None,
    };
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
