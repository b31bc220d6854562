//! Whether a component offers what an entry asks for.

use channels::{FieldKind, Shape};
use diagnostics::{Problem, Span, Spanned};

use super::{Argument, Asking, Endpoint, SuccessWhen, Written};
use crate::error::Complaints;
use crate::names::unknown;
use crate::scenario::offer::{Offer, Subject};

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
                fields(&offer.requests),
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
            let Some((_, kind)) = fields(&offer.requests).find(|(name, _)| *name == field.value) else {
                problems.push(unknown(&what, field, fields(&offer.requests).map(|(name, _)| &**name)));
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
        let missing =
            fields(&offer.requests).filter(|(name, _)| self.arguments.iter().all(|(given, _)| given.value != *name));
        problems.extend(lacking(&self.asked, missing, "`arguments` does not give it"));
    }

    /// Reports fields that the answer does not have.
    fn check_fields(&self, offer: &Offer, problems: &mut Vec<Problem>) {
        let component = &self.asked.component.value;
        let mut check = |head: &str, field: &str, span: &Span| {
            let says = |shape: &&Shape| shape.heads().iter().any(|symbol| symbol.name() == head);
            let known = offer.replies.iter().filter(says).flat_map(|shape| shape.fields().iter().skip(1));
            let known: Vec<&str> = known.map(|(name, _)| &**name).collect();
            if !known.contains(&field) {
                let field = Spanned { value: field.to_owned(), span: span.clone() };
                problems.push(unknown(&format!("field of <{head}> from {component}"), &field, known));
            }
        };
        let success = match self.of {
            Subject::Request => "ok".to_owned(),
            Subject::Action => format!("{}.succeeded", self.asked.name.value),
            Subject::Topic => self.asked.name.value.clone(),
        };
        for Written { field, .. } in &self.outputs {
            check(&success, &field.value, &field.span);
        }
        for Written { field, .. } in &self.feedback {
            check(&format!("{}.feedback", self.asked.name.value), &field.value, &field.span);
        }
        if let Some(SuccessWhen { fields, span, .. }) = &self.success_when {
            fields.iter().for_each(|field| check(&success, field, span));
        }
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

/// The fields of a request or a goal, which is the first of these.
fn fields(requests: &[Shape]) -> impl Iterator<Item = &(String, FieldKind)> {
    requests.first().into_iter().flat_map(|shape| shape.fields().iter().skip(1))
}
