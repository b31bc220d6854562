//! Whether a component offers what an entry asks for.

use bt::{Node, Source, Tree};
use channels::{FieldKind, Shape};
use diagnostics::{Problem, Span, Spanned};
use skills::Datum;

use super::{Argument, Asking, Endpoint, SuccessWhen, Written};
use crate::error::Complaints;
use crate::names::unknown;
use crate::scenario::offer::{Offer, OfferMessage, Subject};

impl Asking {
    /// Reports what no component offers, or not like this. Returns whether there is nothing to report.
    pub(in crate::scenario) fn check(&self, offers: &[(&str, Vec<Offer>)], complaints: &mut Complaints) -> bool {
        let mut problems = Vec::new();
        match offered(self.of, &self.asked, offers) {
            Ok(offer) => {
                self.check_arguments(offer, &mut problems);
                self.check_fields(offer, &mut problems);
            }
            Err(problem) => problems.push(problem),
        }
        match self.on_halt.as_ref().map(|asked| (asked, offered(Subject::Request, asked, offers))) {
            Some((asked, Ok(offer))) => problems.extend(lacking(
                asked,
                offer.fields(OfferMessage::Request),
                "asked without fields when the tree halts the leaf",
            )),
            Some((_, Err(problem))) => problems.push(problem),
            None => {}
        }
        let fits = problems.is_empty();
        problems.into_iter().for_each(|problem| complaints.push(problem));
        fits
    }

    /// Reports fields that the request or goal does not have, lacks, or cannot have with this value.
    fn check_arguments(&self, offer: &Offer, problems: &mut Vec<Problem>) {
        let what = format!("field of {}", self.asked.name.value);
        for (field, argument) in &self.arguments {
            let Some((_, kind)) = offer.fields(OfferMessage::Request).find(|(name, _)| *name == field.value) else {
                problems.push(unknown(&what, field, offer.fields(OfferMessage::Request).map(|(name, _)| &**name)));
                continue;
            };
            if let Argument::Constant(value) = &argument.value
                && skills::field_value(value, kind).is_none()
            {
                let problem = argument
                    .span
                    .problem(format!("the field `{}` of {} cannot be {value}", field.value, self.asked.name.value));
                problems.push(problem.with_label("this value").with_help(format!("it is {kind}")));
            }
        }
        let missing = offer
            .fields(OfferMessage::Request)
            .filter(|(name, _)| self.arguments.iter().all(|(given, _)| given.value != *name));
        problems.extend(lacking(&self.asked, missing, "`arguments` does not give it"));
    }

    /// Reports fields that the answer does not have.
    fn check_fields(&self, offer: &Offer, problems: &mut Vec<Problem>) {
        let component = &self.asked.component.value;
        let mut check = |of: OfferMessage, field: &str, span: &Span| {
            let known: Vec<&str> = offer.fields(of).map(|(name, _)| &**name).collect();
            if !known.contains(&field) {
                let field = Spanned { value: field.to_owned(), span: span.clone() };
                let head = offer.head(of).unwrap_or_default();
                problems.push(unknown(&format!("field of <{head}> from {component}"), &field, known));
            }
        };
        self.written().for_each(|(of, Written { field, .. })| check(of, &field.value, &field.span));
        if let Some(SuccessWhen { fields, span, .. }) = &self.success_when {
            fields.iter().for_each(|field| check(OfferMessage::Answer, field, span));
        }
        if let Some(when) = self.success_when.as_ref().filter(|_| problems.is_empty()) {
            let fields: Vec<(String, FieldKind)> = offer.fields(OfferMessage::Answer).cloned().collect();
            problems.extend(when.misreadings(&fields));
        }
    }

    /// The fields that are written to ports, each with the message that has it.
    fn written(&self) -> impl Iterator<Item = (OfferMessage, &Written)> {
        let answers = self.outputs.iter().map(|written| (OfferMessage::Answer, written));
        answers.chain(self.feedback.iter().map(|written| (OfferMessage::Feedback, written)))
    }

    /// The field that is written to this port, in words, and its kind if there is a value.
    pub(in crate::scenario) fn written_to<'o>(
        &self,
        port: &str,
        offers: &'o [(&str, Vec<Offer>)],
    ) -> Option<(String, &'o FieldKind)> {
        let offer = offered(self.of, &self.asked, offers).ok()?;
        let (of, written) = self.written().find(|(_, written)| written.port.value == port)?;
        let (name, kind) = offer.fields(of).find(|(name, _)| *name == written.field.value)?;
        Some((format!("`{name}` of {}", self.asked.component.value), kind.present()))
    }

    /// Reports ports of a leaf that do not fit what is offered: an input port that is not set though the request needs
    /// its value, and an output port that cannot have the value of its field.
    pub(in crate::scenario) fn port_misfits(
        &self,
        tree: &Tree,
        leaf: &Node,
        offers: &[(&str, Vec<Offer>)],
    ) -> Vec<Problem> {
        let Ok(offer) = offered(self.of, &self.asked, offers) else { return Vec::new() };
        let Endpoint { component, name } = &self.asked;
        let kind = |of, field: &str| offer.fields(of).find(|(known, _)| known == field).map(|(_, kind)| kind);
        let mut problems = Vec::new();
        for (field, argument) in &self.arguments {
            let Argument::Port(port) = &argument.value else { continue };
            let is_unset = |found: bt::Port<'_>| found.name == port && found.source == Source::Nothing;
            let kind = kind(OfferMessage::Request, &field.value);
            if kind.is_some_and(|kind| !matches!(kind, FieldKind::Optional(_))) && tree.ports(leaf.id()).any(is_unset) {
                let message = format!("`{}` needs the port `{port}`", leaf.label());
                let help = format!("it is the field `{}` of {}.{}", field.value, component.value, name.value);
                problems.push(tree.problem_at(leaf.id(), message, "not set here", help));
            }
        }
        let replies = bt::reply_domain(tree, leaf.id());
        for (of, Written { port, field }) in self.written() {
            let ports = replies.shapes().iter().flat_map(Shape::fields);
            let Some((_, taken)) = ports.into_iter().find(|(known, _)| *known == port.value) else { continue };
            let Some(given) = kind(of, &field.value) else { continue };
            if sample(given).is_some_and(|value| skills::field_value(&value, taken).is_none()) {
                let taken = taken.present();
                let message = format!(
                    "the port `{}` of `{}` is {taken}, and `{}` of {} is {given}",
                    port.value,
                    leaf.label(),
                    field.value,
                    component.value
                );
                let help = format!("declare its type in the tree: <output_port name=\"{}\" type=\"…\"/>", port.value);
                problems.push(port.span.problem(message).with_label("this port").with_help(help));
            }
        }
        problems
    }
}

/// A value of a kind; `None` for a list, which no port takes.
fn sample(kind: &FieldKind) -> Option<Datum> {
    match kind {
        FieldKind::Bool => Some(true.into()),
        FieldKind::Int | FieldKind::Real => Some(0.0.into()),
        FieldKind::Text | FieldKind::Symbol(_) => Some(Datum::text("")),
        FieldKind::Optional(kind) => sample(kind),
        FieldKind::List(_) => None,
    }
}

/// What a component offers under this name, as this.
fn offered<'o>(of: Subject, asked: &Endpoint, offers: &'o [(&str, Vec<Offer>)]) -> Result<&'o Offer, Problem> {
    let Endpoint { component, name } = asked;
    let Some((_, offers)) = offers.iter().find(|(known, _)| *known == component.value) else {
        return Err(unknown("component", component, offers.iter().map(|(known, _)| *known)));
    };
    let find = |of| offers.iter().find(|offer| offer.of == of && offer.name == name.value);
    find(of).ok_or_else(|| {
        let Some(other) = Subject::ALL.into_iter().find(|other| find(*other).is_some()) else {
            let known = offers.iter().filter(|offer| offer.of == of).map(|offer| offer.name.as_str());
            return unknown(&format!("{} of {}", of.noun(), component.value), name, known);
        };
        let is = format!("`{}` is not a {} of {}, but a {}", name.value, of.noun(), component.value, other.noun());
        let help = format!("write `{} = \"{}.{}\"`", other.key(), component.value, name.value);
        name.span.problem(is.replace(" a action", " an action")).with_label("here").with_help(help)
    })
}

/// The problem of a request without these fields, the first of which is named.
fn lacking<'f>(
    asked: &Endpoint,
    mut missing: impl Iterator<Item = &'f (String, FieldKind)>,
    label: &str,
) -> Option<Problem> {
    let (name, kind) = missing.find(|(_, kind)| !matches!(kind, FieldKind::Optional(_)))?;
    let problem = asked.name.span.problem(format!("`{}` needs the field `{name}`", asked.name.value));
    Some(problem.with_label(label).with_help(format!("it is {kind}")))
}
