//! Reactions to events, as transitions.

use std::ops::Range;

use diagnostics::Problem;
use diagnostics::xml::name_span;
use roxmltree::Node;

use super::super::declarations::required;
use super::super::vocabulary::{Reaction, Role, event};
use super::super::xml::{is, value_span};
use super::Translator;

impl Translator<'_, '_> {
    pub(super) fn transition(&mut self, node: Node<'_, '_>) {
        let event = node.attribute_node("event");
        let event = event.map(|event| (event.value().to_owned(), event.range_value()));
        self.known_attributes(node, &["event", "cond", "target", "type"]);
        self.branches(node, event, None);
    }

    pub(super) fn reaction(&mut self, node: Node<'_, '_>, reaction: &Reaction) {
        let known: &[&str] = if reaction.role.is_some() { &["name", "cond", "target"] } else { &["cond", "target"] };
        self.known_attributes(node, known);
        let name = match reaction.role {
            Some(role) => match self.interface(node, role) {
                Some(name) => event(reaction.event, &name),
                None => return,
            },
            None => reaction.event.to_owned(),
        };
        let code = reaction.code.map(|code| format!("_event.data.code == {code}"));
        self.branches(node, Some((name, name_span(node))), code.as_deref());
    }

    /// Writes one transition per target: all but the last are left to chance.
    fn branches(&mut self, node: Node<'_, '_>, event: Option<(String, Range<usize>)>, also: Option<&str>) {
        let targets: Vec<Node<'_, '_>> = node.children().filter(|child| is(child, "target")).collect();
        if targets.is_empty() {
            self.branch(node, node, &event, also, None);
            return;
        }
        if let Some(written) = node.attribute_node("target") {
            let problem = Problem::new("the targets are given twice").at(written.range_value(), "either here");
            self.problems.push(problem.at(name_span(targets[0]), "or here"));
        }
        for other in node.children().filter(|child| child.is_element() && !is(child, "target")) {
            let problem = Problem::new(format!("<{}> belongs in one of the targets", other.tag_name().name()));
            self.problems.push(problem.at(name_span(other), "beside targets"));
        }
        let mut rest = 1.0;
        for (index, target) in targets.iter().enumerate() {
            self.known_attributes(*target, &["id", "prob"]);
            let is_last = index + 1 == targets.len();
            let Some(chance) = self.probability(*target, is_last, rest) else { return };
            // A machine tries its transitions in order, so each one's chance is among what those before it have left.
            let of_rest = if rest > 0.0 { (chance / rest).min(1.0) } else { 0.0 };
            rest -= chance;
            self.branch(node, *target, &event, also, (!is_last).then_some(of_rest));
        }
        // More than rounding errors: even thirds with three decimals are off by a thousandth.
        if rest.abs() > 1e-9 {
            let problem = Problem::new("the probabilities of the targets do not add up to 1");
            let message = if rest > 0.0 { format!("{rest:.3} is missing") } else { format!("{:.3} too much", -rest) };
            let help = "leave out `prob` of the last target: it gets the rest";
            self.problems.push(problem.at(name_span(node), message).with_help(help));
        }
    }

    fn probability(&mut self, target: Node<'_, '_>, is_last: bool, rest: f64) -> Option<f64> {
        let Some(written) = target.attribute("prob") else {
            if is_last {
                return Some(rest);
            }
            let problem = Problem::new("only the last target may leave out its probability");
            self.problems.push(problem.at(name_span(target), "`prob` is missing"));
            return None;
        };
        let number = written.trim().parse().ok().filter(|number| (0.0..=1.0).contains(number));
        if number.is_none() {
            let problem = Problem::new(format!("`{written}` is not a probability"));
            self.problems.push(problem.at(value_span(target, "prob"), "not a number from 0 to 1"));
        }
        number
    }

    /// Writes one transition. `branch` has the target and the content: `node` itself, or one of its targets.
    fn branch(
        &mut self,
        node: Node<'_, '_>,
        branch: Node<'_, '_>,
        event: &Option<(String, Range<usize>)>,
        also: Option<&str>,
        chance: Option<f64>,
    ) {
        let plain = &mut self.out.plain;
        plain.open("transition", &name_span(branch), &[]);
        if let Some((name, place)) = event {
            plain.attribute("event", name, place);
        }
        let target = branch.attribute_node("target").or_else(|| branch.attribute_node("id"));
        if let Some(target) = target {
            plain.copied_attribute("target", target.range_value(), &name_span(branch));
        }
        let condition = node.attribute_node("cond");
        match (condition, also) {
            (Some(written), None) => self.attribute(written),
            (Some(written), Some(also)) => {
                let quote = &self.text[written.range_value().start - 1..written.range_value().start];
                plain.write(&format!(" cond={quote}{also} &amp;&amp; ("), &name_span(node));
                self.expression(written.range_value());
                self.out.plain.write(&format!("){quote}"), &name_span(node));
            }
            (None, Some(also)) => plain.attribute("cond", also, &name_span(node)),
            (None, None) => {}
        }
        if let Some(chance) = chance {
            self.out.plain.attribute("steward:chance", &chance.to_string(), &value_span(branch, "prob"));
        }
        // A transition without an event, a condition and a target would be rejected; this one explains itself in the
        // file.
        self.out.plain.begin_content(&name_span(branch));
        for child in branch.children() {
            self.node(child, branch);
        }
        self.out.plain.close("transition", &name_span(branch));
    }

    /// Writes both outcomes of a goal request.
    pub(super) fn goal_response(&mut self, node: Node<'_, '_>) {
        self.known_attributes(node, &["name", "accept", "reject"]);
        let Some(interface) = self.interface(node, Role::ActionClient) else { return };
        for (outcome, attribute) in [("accepted", "accept"), ("rejected", "reject")] {
            if required(node, attribute, self.problems).is_none() {
                continue;
            }
            let name = event(&format!("action_{{}}_goal_{outcome}"), &interface);
            let (plain, place) = (&mut self.out.plain, name_span(node));
            plain.open("transition", &place, &[("event", &name)]);
            plain.copied_attribute("target", value_span(node, attribute), &place);
            plain.close_empty(&place);
        }
    }
}
