//! The text edits that make up a mutation.

use std::ops::Range;

use diagnostics::markup::attribute;
use diagnostics::{Problem, nearest_or_all};

use super::place::Site;
use super::{Mutation, TransitionPlace};
use crate::chart::{Chart, StateKind, Transition, TransitionDomain};
use crate::ids::{StateId, TransitionId};
use crate::load::{Element, Written, name_span};

/// A range of bytes and its new text.
pub(super) type Edit = (Range<usize>, String);

/// Applies edits that are in order and do not overlap.
pub(super) fn apply(text: &str, edits: Vec<Edit>) -> String {
    let (mut result, mut done) = (String::with_capacity(text.len() + 64), 0);
    for (range, replacement) in edits {
        result.push_str(&text[done..range.start]);
        result.push_str(&replacement);
        // The number of lines stays the same.
        let lines = |text: &str| text.matches('\n').count();
        let fewer = lines(&text[range.clone()]).saturating_sub(lines(&replacement));
        result.extend(std::iter::repeat_n('\n', fewer));
        done = range.end;
    }
    result.push_str(&text[done..]);
    result
}

pub(super) fn edits(site: &Site<'_>, mutation: &Mutation) -> Result<Vec<Edit>, Problem> {
    Ok(match mutation {
        Mutation::Data { id, expr } => data(site, id, expr)?,
        Mutation::NegateGuard { transition } => {
            let guard = guard(site, transition)?.span();
            vec![insertion(guard.start, "!("), insertion(guard.end, ")")]
        }
        Mutation::DropGuard { transition } => {
            let guard = guard(site, transition)?.span();
            let text = site.node(site.transition(transition)?).document().input_text();
            // The name, the equals sign and the quotes are included.
            let start = text[..guard.start].rfind("cond").unwrap_or(guard.start);
            vec![blank(text, start..guard.end + 1)]
        }
        Mutation::SwapTarget { transition, target } => {
            site.state(target)?;
            vec![(targets(site, transition)?.span(), escaped(target))]
        }
        Mutation::DropTransition { transition } => vec![without(site.node(site.transition(transition)?))],
        Mutation::StuckState { state } => stuck(site, site.state(state)?)?,
        Mutation::SwapSend { send, event } => vec![(site.send(send)?.event.span(), escaped(event))],
        Mutation::DropSend { send } => never(site.send(send)?.node),
    })
}

fn insertion(at: usize, text: &str) -> Edit {
    (at..at, text.to_owned())
}

/// Replaces an element and its contents with white space, so that everything after it keeps its line and column.
fn without(node: Element<'_>) -> Edit {
    blank(node.document().input_text(), node.range())
}

/// Makes an action that is never executed, but is still part of the machine: its channels and events stay the same.
fn never(node: Element<'_>) -> Vec<Edit> {
    if is_null_model(node) {
        return vec![without(node)];
    }
    vec![insertion(node.range().start, "<if cond=\"false\">"), insertion(node.range().end, "</if>")]
}

fn is_null_model(node: Element<'_>) -> bool {
    node.document().root_element().attribute("datamodel") == Some("null")
}

fn blank(text: &str, range: Range<usize>) -> Edit {
    let mut blanks = String::with_capacity(range.len());
    for letter in text[range.clone()].chars() {
        match letter {
            '\n' | '\r' => blanks.push(letter),
            _ => blanks.extend(std::iter::repeat_n(' ', letter.len_utf8())),
        }
    }
    (range, blanks)
}

/// Text for an attribute with either kind of quotes: the text that it replaces may be in single ones.
fn escaped(text: &str) -> String {
    attribute(text).replace('\'', "&apos;")
}

fn data(site: &Site<'_>, id: &str, expr: &str) -> Result<Vec<Edit>, Problem> {
    let Some((node, name)) = site.data().find(|(_, name)| name.value == id) else {
        let known: Vec<&str> = site.data().map(|(_, name)| name.value).collect();
        return Err(Problem::new(format!("unknown datum `{id}`")).with_help(nearest_or_all(id, "data", &known)));
    };
    if let Some(src) = Written::attribute(node, "src") {
        let problem = Problem::new(format!("the value of `{id}` is in another file"));
        return Err(problem.at(src.span(), "there").with_help("change that file, or write the value here"));
    }
    if node.children().any(|child| child.is_element()) {
        let problem = Problem::new(format!("the value of `{id}` is written as XML"));
        return Err(problem.at(name.span(), "this datum").with_help("write it as `expr` to change it"));
    }
    if let Some(old) = Written::attribute(node, "expr") {
        return Ok(vec![(old.span(), escaped(expr))]);
    }
    // The content between the tags may be text, but an attribute is always an expression.
    let text = node.document().input_text();
    let between = node.first_child().zip(node.last_child());
    let between = between.map(|(first, last)| blank(text, first.range().start..last.range().end));
    let attribute = insertion(name.span().end + 1, &format!(" expr=\"{}\"", escaped(expr)));
    Ok(between.into_iter().chain([attribute]).collect())
}

fn guard<'a>(site: &Site<'a>, place: &TransitionPlace) -> Result<Written<'a>, Problem> {
    let transition = site.transition(place)?;
    let node = site.node(transition);
    let problem = |message: String| Problem::new(message).at(name_span(node), "this transition");
    let guard = Written::attribute(node, "cond").ok_or_else(|| {
        let help = "`swap_target` and `drop_transition` need no condition";
        problem(format!("{place} has no condition")).with_help(help)
    })?;
    if is_null_model(node) {
        return Err(problem("the null data model has no negation".to_owned()).with_help("datamodel=\"ecmascript\""));
    }
    Ok(guard)
}

fn targets<'a>(site: &Site<'a>, place: &TransitionPlace) -> Result<Written<'a>, Problem> {
    let node = site.node(site.transition(place)?);
    Written::attribute(node, "target").ok_or_else(|| {
        let problem = Problem::new(format!("{place} has no target")).at(name_span(node), "this transition");
        problem.with_help("it only executes content; use `drop_transition` to remove it")
    })
}

/// Every transition that would exit the state is taken only while the state is not active.
fn stuck(site: &Site<'_>, state: StateId) -> Result<Vec<Edit>, Problem> {
    let id = site.chart.state(state).id();
    let here = |problem: Problem| problem.at(site.chart.state(state).span(), "this state");
    let leaving: Vec<&Transition> = leaving(site.chart, state).collect();
    let Some(first) = leaving.first() else {
        return Err(here(Problem::new(format!("no transition leaves `{id}` anyway"))));
    };
    if is_null_model(site.node(first)) {
        return Err(here(Problem::new("the null data model has no negation")).with_help("datamodel=\"ecmascript\""));
    }
    let quoted = id.replace('\\', "\\\\").replace('\'', "\\'");
    let elsewhere = escaped(&format!("!In('{quoted}')"));
    let guarded = |transition: &&Transition| {
        let node = site.node(transition);
        match Written::attribute(node, "cond") {
            Some(guard) => vec![
                insertion(guard.span().start, "("),
                insertion(guard.span().end, &format!(") &amp;&amp; {elsewhere}")),
            ],
            None => vec![insertion(name_span(node).end, &format!(" cond=\"{elsewhere}\""))],
        }
    };
    Ok(leaving.iter().flat_map(guarded).collect())
}

/// The transitions that exit the state if they are taken while it is active.
pub(super) fn leaving(chart: &Chart, state: StateId) -> impl Iterator<Item = &Transition> {
    let exits = move |id: &TransitionId| {
        let transition = chart.transition(*id);
        let source = transition.source();
        let is_active_with = source == state
            || chart.is_descendant(source, state)
            || chart.is_descendant(state, source)
            || chart.are_orthogonal(&[source, state]);
        let domain = chart.domain_of(*id, transition.targets());
        is_active_with && matches!(domain, TransitionDomain::State(domain) if chart.is_descendant(state, domain))
    };
    let is_state = !matches!(chart.state(state).kind(), StateKind::History(_));
    chart.transitions().filter(move |id| is_state && exits(id)).map(|id| chart.transition(id))
}
