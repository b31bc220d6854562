//! From the text of a property file to monitors.

use std::sync::Arc;
use std::time::Duration;

use channels::{Monitor, Topology, Verdict};
use diagnostics::{Problem, Source, Span};

use crate::engine::Limits;
use crate::explain::explain;
use crate::formula::Formula;
use crate::monitor::ScopeMonitor;
use crate::problem::{ScopeError, Warnings};
use crate::resolve::{Definition, defined_twice, resolve};
use crate::syntax::{ByteRange, parse_file, summary_above};

/// A property of the messages on the channels, with its monitor.
#[derive(Debug)]
pub struct Property {
    /// Its name, for example `phi1`.
    pub name: String,
    /// The formula, in the SCOPE language.
    pub formula: String,
    /// Its requirement in a few words: the first sentence of the comment directly above it, or else its formula in
    /// English.
    pub summary: String,
    /// Where its file names it; none if it is from no file.
    pub place: Option<Span>,
    /// The monitor.
    pub monitor: Box<dyn Monitor>,
}

impl Property {
    /// The property's monitor as a [`ScopeMonitor`], which can explain its verdicts; `None` if it was built by hand.
    #[must_use]
    pub fn scope_monitor(&self) -> Option<&ScopeMonitor> {
        scope_monitor(self.monitor.as_ref())
    }

    /// Gives it another name.
    pub fn rename(&mut self, name: String) {
        self.scope_monitor_mut().into_iter().for_each(|monitor| monitor.rename(&name));
        self.name = name;
    }

    /// The same, to begin anew.
    pub fn scope_monitor_mut(&mut self) -> Option<&mut ScopeMonitor> {
        (self.monitor.as_mut() as &mut dyn std::any::Any).downcast_mut()
    }
}

/// The monitor as a [`ScopeMonitor`], if it was made from a SCOPE formula; `None` if it was built by hand.
#[must_use]
pub fn scope_monitor(monitor: &dyn Monitor) -> Option<&ScopeMonitor> {
    (monitor as &dyn std::any::Any).downcast_ref()
}

/// The properties of a file.
#[derive(Debug)]
pub struct PropertyFile {
    /// The properties in the order of the file, each with its monitor.
    pub properties: Vec<Property>,
    /// Warnings.
    pub warnings: Warnings,
}

/// Reads a property file and makes its monitors.
///
/// `name` is the file's name in diagnostics; durations are converted to ticks of `tick_period`.
///
/// ```
/// use std::{sync::Arc, time::Duration};
/// use channels::{Capacity, Domain, FieldKind, Shape, Topology};
///
/// let mut topology = Topology::default();
/// let [reader, skill] = [topology.process("BatteryReader")?, topology.process("BatteryLevel")?];
/// let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
/// topology.channel(reader, skill, Capacity::One, Domain::new([level]))?;
///
/// let text = "property phi1 := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m.level >= 20)";
/// let file = monitors::load("phi1.scope", text, &Arc::new(topology), Duration::from_secs(1))?;
/// assert_eq!(file.properties[0].monitor.location(), "idle");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ScopeError`] with everything that is wrong with the file.
pub fn load(
    name: &str,
    text: &str,
    topology: &Arc<Topology>,
    tick_period: Duration,
) -> Result<PropertyFile, ScopeError> {
    let source = Source::new(name, text);
    let parsed = parse_file(text);
    let (definitions, unresolved) = resolve(text, &parsed.file, topology, tick_period);
    let mut problems = parsed.problems;
    problems.extend(unresolved);
    let mut properties = Vec::new();
    for definition in &definitions {
        match ScopeMonitor::new(&definition.name.text, definition.formula.clone(), topology) {
            Ok(monitor) => {
                problems.extend(doubts(definition, &monitor));
                properties.push(Property {
                    name: definition.name.text.clone(),
                    formula: definition.constraint.to_string(),
                    summary: summary_above(text, definition.span.start)
                        .unwrap_or_else(|| explain(&definition.formula, topology)),
                    place: Some(source.span(definition.name.span.start..definition.name.span.end)),
                    monitor: Box::new(monitor),
                });
            }
            Err(error) => problems.push(Problem::new(error.to_string()).at(definition.name.span, "this property")),
        }
    }
    problems.sort_by_key(Problem::offset);
    if problems.iter().any(Problem::is_error) {
        return Err(ScopeError::new(source, problems));
    }
    Ok(PropertyFile { properties, warnings: Warnings::new(source, problems) })
}

/// Checks a property file without its system.
///
/// # Errors
/// Everything that is wrong with it in any system.
pub fn check(name: &str, text: &str) -> Result<(), ScopeError> {
    let parsed = parse_file(text);
    let mut problems = parsed.problems;
    problems.extend(defined_twice(&parsed.file));
    problems.sort_by_key(Problem::offset);
    if problems.iter().any(Problem::is_error) {
        Err(ScopeError::new(Source::new(name, text), problems))
    } else {
        Ok(())
    }
}

/// Warnings about a property: it is trivial or contradictory, or it needs too many states.
fn doubts(definition: &Definition, monitor: &ScopeMonitor) -> impl Iterator<Item = Problem> {
    impossible_events(definition, monitor).chain(triviality(definition, monitor)).chain(delay(definition, monitor))
}

fn warning(message: String, span: ByteRange, label: &str, help: &str) -> Problem {
    Problem::new(message).at(span, label).with_help(help).as_warning()
}

fn impossible_events(definition: &Definition, monitor: &ScopeMonitor) -> impl Iterator<Item = Problem> + use<> {
    let (mut spans, mut impossible) = (Vec::new(), Vec::new());
    definition.constraint.events(&mut |event| spans.push(event.span));
    definition.formula.events(&mut |event| impossible.push(!monitor.can_hold(event)));
    let help = "the conditions contradict each other or the channel's messages";
    let warn = move |span| warning("no message can satisfy this event".to_owned(), span, "never true", help);
    spans.into_iter().zip(impossible).filter(|(_, impossible)| *impossible).map(move |(span, _)| warn(span))
}

fn triviality(definition: &Definition, monitor: &ScopeMonitor) -> Option<Problem> {
    let name = &definition.name;
    match (monitor.verdict(), monitor.is_violated_by_a_tick()) {
        (Verdict::True, _) => {
            let help = "it holds whatever messages its channels carry: is a condition missing?";
            Some(warning(format!("`{}` can never be violated", name.text), name.span, "always satisfied", help))
        }
        (Verdict::False, _) | (_, true) => {
            let help = "it fails whatever messages its channels carry: do two conditions contradict each other?";
            Some(warning(format!("`{}` can never be satisfied", name.text), name.span, "always violated", help))
        }
        _ => None,
    }
}

/// The warning of a property whose verdicts may come late.
fn delay(definition: &Definition, monitor: &ScopeMonitor) -> Option<Problem> {
    let (why, label) = if monitor.method().is_prompt() {
        return None;
    } else if monitor.is_cut_off() {
        ("has conditions with too many combinations".to_owned(), "not all are foreseen")
    } else if monitor.has_letters() {
        let states = Limits::default().automaton_states;
        (format!("needs more than {states} states"), "too large for an automaton")
    } else {
        ("has no automaton: it measures time, remembers values or calculates".to_owned(), "monitored step by step")
    };
    let name = &definition.name;
    let help = "it is monitored without an automaton: its verdicts are never wrong, but may come late";
    Some(warning(format!("`{}` {why}", name.text), name.span, label, help))
}

/// Reads a file and resolves its names, without making monitors. Returns the formulas by name.
///
/// # Errors
/// [`ScopeError`] with everything that is wrong with the file.
pub fn formulas(
    name: &str,
    text: &str,
    topology: &Topology,
    tick_period: Duration,
) -> Result<Vec<(String, Formula)>, ScopeError> {
    let source = Source::new(name, text);
    let parsed = parse_file(text);
    let (definitions, unresolved) = resolve(text, &parsed.file, topology, tick_period);
    let mut problems = parsed.problems;
    problems.extend(unresolved);
    if problems.iter().any(Problem::is_error) {
        problems.sort_by_key(Problem::offset);
        return Err(ScopeError::new(source, problems));
    }
    Ok(definitions.into_iter().map(|definition| (definition.name.text, definition.formula)).collect())
}
