//! What looks like a mistake in a scenario that could be meant: names that other leaves get when a tree is rearranged,
//! numbers in another unit, and what cannot happen in a run.

use std::collections::BTreeMap;

use bt::{Node, Tree};
use diagnostics::{Problem, Source, Span, Spanned};
use maps::{Pose, heading, heading_concern};
use monitors::syntax;

use super::{Behavior, Scenario, Start};
use crate::faults::{Effect, Trigger, Which};

impl Scenario {
    /// Warnings about its own file, its properties and its places.
    #[must_use]
    pub fn doubts(&self) -> Vec<Problem> {
        let mut doubts = self.numbered_leaves();
        doubts.extend(self.late_faults());
        doubts.extend(self.fractions());
        doubts.extend(self.headings());
        doubts.extend(self.fast_zones());
        doubts
    }

    /// Names of leaves that depend on the order of the tree.
    fn numbered_leaves(&self) -> Vec<Problem> {
        let Behavior::Tree(tree) = &self.behavior else { return Vec::new() };
        let numbered: BTreeMap<&str, &Node> =
            tree.leaves().filter(|leaf| leaf.process() != leaf.label()).map(|leaf| (leaf.process(), leaf)).collect();
        if numbered.is_empty() {
            return Vec::new();
        }
        let mut doubts = Vec::new();
        let mut named = |name: &str, problem: &dyn Fn(String) -> Problem| {
            if let Some(leaf) = numbered.get(name) {
                doubts.push(numbered_leaf(tree, leaf, problem));
            }
        };
        let mut of_file = |name: &Spanned<String>| named(&name.value, &|message| name.span.problem(message));
        self.file.leaves.iter().for_each(|entry| of_file(&entry.leaf));
        for fault in &self.file.faults {
            match fault.effect() {
                Effect::Machine { skill, .. } => of_file(&skill),
                Effect::Channels { channels, .. } => match channels {
                    Which::Between(from, to) => [from, to].iter().for_each(&mut of_file),
                    Which::From(one) | Which::To(one) => of_file(&one),
                },
                _ => {}
            }
            if let Trigger::State { process, .. } = &fault.timing.trigger {
                of_file(process);
            }
        }
        for (file, text) in &self.properties {
            let source = Source::new(file, text);
            for item in &syntax::parse_file(text).file.items {
                let syntax::Item::Property(property) = item else { continue };
                property.constraint.events(&mut |event| {
                    for name in [event.source.name(), event.target.name()].into_iter().flatten() {
                        let range = name.span.start..name.span.end;
                        named(&name.text, &|message| Problem::new(message).of(&source).at(range.clone(), "this leaf"));
                    }
                });
            }
        }
        doubts
    }

    fn late_faults(&self) -> Vec<Problem> {
        let end = self.file.execution.max_time;
        let late = self.file.faults.iter().filter_map(|fault| {
            let at = match fault.timing.trigger {
                Trigger::Time { at, .. } => at,
                Trigger::Tick(tick) => {
                    let before = u32::try_from(tick.saturating_sub(1)).unwrap_or(u32::MAX);
                    self.file.execution.tick.saturating_mul(before)
                }
                _ => return None,
            };
            let message = format!(
                "this fault would begin at {} s, but the run ends at {} s",
                at.as_secs_f64(),
                end.as_secs_f64()
            );
            let problem = fault.arguments().span().problem(message).as_warning().with_label("never takes effect");
            (at >= end).then(|| problem.with_help("set `execution.max_time_s` higher, or let it begin earlier"))
        });
        late.collect()
    }

    /// Percentages that look like fractions.
    fn fractions(&self) -> Vec<Problem> {
        let is_fraction = |value: f64| value > 0.0 && value < 1.0;
        let mut doubts = Vec::new();
        for fault in &self.file.faults {
            if let Effect::Charge(level) = fault.effect()
                && is_fraction(level)
            {
                let problem = fault.arguments().span().problem(fraction("level_pct", level));
                doubts.push(problem.as_warning().with_label("a fraction?").with_help(percent(level)));
            }
        }
        let initial = self.premises.as_ref().map(|premises| premises.entry.sim.battery.initial_pct);
        if let Some(initial) = initial.filter(|initial| is_fraction(*initial)) {
            let problem = Problem::new(fraction("battery.initial_pct", initial)).as_warning();
            doubts.push(problem.with_help(percent(initial)));
        }
        doubts
    }

    /// Headings that look like radians.
    fn headings(&self) -> Vec<Problem> {
        let Some(premises) = &self.premises else { return Vec::new() };
        let mut doubts = premises.written.concerns().to_vec();
        let mut look = |at: &Pose, span: &Span| {
            // The file has degrees with fewer digits.
            let heading_deg = (heading(at).to_degrees() * 1e9).round() / 1e9;
            doubts.extend(heading_concern(heading_deg, span));
        };
        if let Spanned { value: Start::At(pose), span } = &premises.entry.sites.start {
            look(pose, span);
        }
        for body in &premises.entry.world {
            look(&body.value.pose, &body.span);
        }
        doubts
    }

    /// Zones in which the robot may be faster than it can be.
    fn fast_zones(&self) -> Vec<Problem> {
        let Some(premises) = &self.premises else { return Vec::new() };
        let most = premises.entry.sim.model.max_linear_mps;
        let fast = premises.places.zones().iter().filter_map(|zone| {
            let speed = zone.speed_mps.filter(|speed| *speed > most)?;
            let span = premises.written.span(&zone.name)?;
            let message =
                format!("the zone `{}` allows {speed} m/s, but the robot is never faster than {most} m/s", zone.name);
            let problem = span.problem(message).as_warning().with_label("a limit without an effect");
            Some(
                problem
                    .with_help("`speed_mps` is in meters per second; `robot.max_linear_mps` is the robot's own limit"),
            )
        });
        fast.collect()
    }
}

/// The warning about a name that a leaf has only by its place among others.
fn numbered_leaf(tree: &Tree, leaf: &Node, problem: &dyn Fn(String) -> Problem) -> Problem {
    let alike = tree.leaves().filter(|other| other.label() == leaf.label());
    let (place, count) = alike
        .fold((0, 0), |(place, count), other| (if other.id() == leaf.id() { count + 1 } else { place }, count + 1));
    let source = &tree.sources()[leaf.file()];
    let line = source.span(leaf.span().offset()..leaf.span().offset()).line();
    let message = format!(
        "`{}` is the leaf at {}:{line}, number {place} of {count} named `{}` in the order of the tree",
        leaf.process(),
        source.name(),
        leaf.label()
    );
    problem(message).as_warning().with_label("another leaf, when the tree is rearranged").with_help(format!(
        "give the leaf a `name` of its own in the tree, and use that here: <{} name=\"…\">",
        leaf.type_id()
    ))
}

fn fraction(key: &str, value: f64) -> String {
    format!("`{key}` is {value} %, less than one percent")
}

fn percent(value: f64) -> String {
    format!("it is in percent: {} is {value} as a share of the whole", value * 100.0)
}
