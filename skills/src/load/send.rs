//! Compiling `<send>` (SCXML 6.2).

use std::time::Duration;

use diagnostics::Problem;

use super::compile::Compiler;
use super::xml::{Element, Written, elements_named, name_span};
use crate::chart::{ActionKind, CHANNEL_PROCESSOR, CHOICE_PROCESSOR, Delay, SCXML_PROCESSOR, Send, SendId};
use crate::delay;

/// The target of events for the machine's own internal queue.
pub(crate) const INTERNAL_TARGET: &str = "#_internal";

impl Compiler<'_> {
    pub(super) fn send(&mut self, node: Element<'_>) -> ActionKind {
        if let Some(written) = Written::attribute(node, "event") {
            self.event_name(&written);
        }
        self.check_processor(node);
        let delay = self.delay(node);
        let id = match (Written::attribute(node, "id"), Written::attribute(node, "idlocation")) {
            (Some(id), _) => SendId::Literal(id.value.into()),
            (None, Some(written)) => match self.assign_target(&written) {
                Ok(target) => SendId::Generated(target),
                Err(reason) => return ActionKind::Fail(reason),
            },
            (None, None) => SendId::None,
        };
        let name_list = self.name_list(node);
        ActionKind::Send(Box::new(Send {
            event: self.alternative(node, "event", "eventexpr"),
            target: self.alternative(node, "target", "targetexpr"),
            processor: self.alternative(node, "type", "typeexpr"),
            id,
            delay,
            name_list,
            payload: self.payload(node),
            span: name_span(node).into(),
        }))
    }

    fn check_processor(&mut self, node: Element<'_>) {
        let has = |name: &str| node.attribute(name).is_some();
        let has_content = elements_named(node, "content").next();
        match Written::attribute(node, "type") {
            Some(written) if written.value == CHANNEL_PROCESSOR => {
                if !has("event") && !has("eventexpr") {
                    let problem = Problem::new("the message has no name");
                    let help = "`event` is the message's first field: event=\"tick\" sends [<tick>]";
                    self.problems.push(problem.at(name_span(node), "`event` is missing").with_help(help));
                }
                if let Some(content) = has_content {
                    let problem = Problem::new("the fields of a message have names")
                        .at(name_span(content), "content has no field names");
                    self.problems.push(problem.with_help("use <param name=\"place\" expr=\"…\"/>"));
                }
            }
            Some(written) if written.value == CHOICE_PROCESSOR => {
                if !has("event") && !has("eventexpr") {
                    let problem = Problem::new("no event is sent").at(name_span(node), "`event` is missing");
                    self.problems.push(problem.with_help("of all events that are sent to `choice`, one is delivered"));
                }
                if let Some(target) = Written::attribute(node, "target").or(Written::attribute(node, "targetexpr")) {
                    let problem = Problem::new("a choice has no target").at(target.span(), "leave this out");
                    self.problems.push(problem.with_help("a machine chooses among events for itself"));
                }
            }
            // An unknown processor is an error whenever the event is sent (SCXML 6.2), so the machine could run.
            Some(written) if ![SCXML_PROCESSOR, "scxml"].contains(&written.value) => {
                let problem = Problem::new(format!("unknown event processor `{}`", written.value));
                self.defer(
                    problem
                        .at(written.span(), "unknown type")
                        .with_help(format!("use `{CHANNEL_PROCESSOR}`, `{CHOICE_PROCESSOR}` or `scxml`")),
                );
            }
            _ if !has("event") && !has("eventexpr") && has_content.is_none() => {
                let problem = Problem::new("no event is sent").at(name_span(node), "`event` is missing");
                self.problems.push(problem);
            }
            _ => {}
        }
    }

    fn delay(&mut self, node: Element<'_>) -> Delay {
        let literal = Written::attribute(node, "delay");
        let computed = Written::attribute(node, "delayexpr");
        if let Some(span) = literal.as_ref().or(computed.as_ref()).map(Written::span)
            && node.attribute("target") == Some(INTERNAL_TARGET)
        {
            let problem = Problem::new("events to the internal queue cannot be delayed").at(span, "a delay");
            self.problems.push(problem.with_help("leave out the target: the event then comes back as an external one"));
        }
        match (literal, computed) {
            (Some(written), _) => match delay::parse(written.value) {
                Some(delay) => Delay::Literal(delay),
                None => {
                    let problem = Problem::new(format!("`{}` is not a delay", written.value));
                    let reason = self.defer(problem.at(written.span(), "not a delay").with_help(delay::FORMS));
                    Delay::Computed(crate::expression::Expr::Broken(reason))
                }
            },
            (None, Some(written)) => Delay::Computed(self.expression(&written)),
            (None, None) => Delay::Literal(Duration::ZERO),
        }
    }
}
