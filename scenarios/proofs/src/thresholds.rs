//! The levels with which anything is compared.

use std::collections::BTreeSet;

use channels::{
    ChannelId, ChannelSystem, Condition, FieldKind, Label, Monitor, ProcessId, ProgramGraph, Slot, Term, Topology,
    Value,
};
use components::BATTERY_READER;
use diagnostics::Problem;
use monitors::{ScopeMonitor, scope_monitor};
use scenarios::Complaints;
use scenarios::scenario::{MachineMonitor, Scenario};

use super::levels::{Micros, micros};

/// The field of BatteryReader's answers that holds a level.
const LEVEL: &str = "level";

/// The levels with which a scenario's machines compare the battery's.
pub(super) fn of_machines(scenario: &Scenario, complaints: &mut Complaints) -> BTreeSet<Micros> {
    let mut thresholds = BTreeSet::new();
    for (name, skill) in scenario.machine_processes() {
        let asks = |chart: &skills::Chart| {
            chart.channel_messages().iter().any(|(to, head)| *to == BATTERY_READER && *head == "get_level")
        };
        if !asks(&skill.machine) {
            continue;
        }
        match skill.thresholds(name, scenario.tree().map(|tree| &**tree), LEVEL) {
            Ok(levels) => add(levels, &mut thresholds, complaints),
            Err(problems) => problems.into_iter().for_each(|problem| complaints.push(problem)),
        }
    }
    thresholds
}

/// Adds the levels with which a property's monitor compares the battery's: the one that it receives, and that which the
/// world has `shown` on a channel.
pub(super) fn of_monitor(
    monitor: &dyn Monitor,
    system: &ChannelSystem,
    (battery_reader, shown): (ProcessId, Option<ChannelId>),
    thresholds: &mut BTreeSet<Micros>,
    complaints: &mut Complaints,
) {
    let is_of_reader = |channel| system.topology().get(channel).source == battery_reader || Some(channel) == shown;
    let levels = match (MachineMonitor::of(monitor), scope_monitor(monitor), monitor.graph()) {
        (Some(machine), ..) => of_machine(machine, is_of_reader, complaints),
        (_, Some(scope), _) => of_property(scope, system.topology(), is_of_reader, complaints),
        (_, _, Some((graph, _))) => constants(graph),
        // The search rejects anything unknown.
        (None, None, None) => Vec::new(),
    };
    add(levels, thresholds, complaints);
}

/// The levels with which a machine compares what it receives on these channels.
fn of_machine(
    machine: &MachineMonitor,
    is_of_reader: impl Fn(ChannelId) -> bool,
    complaints: &mut Complaints,
) -> Vec<f64> {
    let (mut levels, members) = machine.learns(is_of_reader);
    for member in members {
        match machine.chart().thresholds(member, &[], &[]) {
            Ok(more) => levels.extend(more),
            Err(problems) => problems.into_iter().for_each(|problem| complaints.push(problem)),
        }
    }
    levels
}

/// The levels with which a property compares the fields of messages on these channels.
fn of_property(
    property: &ScopeMonitor,
    topology: &Topology,
    is_of_reader: impl Fn(ChannelId) -> bool,
    complaints: &mut Complaints,
) -> Vec<f64> {
    let mut levels = Vec::new();
    let mut is_followed = true;
    property.formula().events(&mut |event| {
        if is_of_reader(event.channel) {
            event.condition.comparisons(&mut |_, _, value| levels.extend(value.as_number()));
            let shapes = topology.get(event.channel).domain.shapes();
            let is_level = |field: usize| {
                let kinds = shapes.iter().filter_map(|shape| shape.fields().get(field.checked_sub(1)?));
                kinds.into_iter().any(|(_, kind)| *kind == FieldKind::Real)
            };
            event.condition.related_fields(&mut |field| is_followed &= !is_level(field));
        }
    });
    // All levels of a class would count as the same one.
    if !is_followed {
        let name = property.name();
        let problem = Problem::new(format!("the property {name} remembers a level or computes with it"));
        complaints.push(
            problem
                .with_help("compare the level with constants only: a proof distinguishes levels by such comparisons"),
        );
    }
    levels
}

fn add(levels: Vec<f64>, thresholds: &mut BTreeSet<Micros>, complaints: &mut Complaints) {
    for level in levels {
        match micros(level) {
            Some(level) => _ = thresholds.insert(level),
            None => {
                let problem =
                    Problem::new(format!("a level is compared with {level}, which has more than six decimals"));
                complaints.push(problem.with_help("round it: the levels in a proof are exact to six decimals"));
            }
        }
    }
}

/// The numbers in a program graph.
fn constants(graph: &ProgramGraph) -> Vec<f64> {
    fn of_term(term: &Term, numbers: &mut Vec<f64>) {
        match term {
            Term::Constant(value) => numbers.extend(value.as_number()),
            Term::Sum(a, b) | Term::Difference(a, b) => [a, b].into_iter().for_each(|term| of_term(term, numbers)),
            Term::Tuple(terms) => terms.iter().for_each(|term| of_term(term, numbers)),
            Term::Variable(_) | Term::Field(..) => {}
        }
    }
    fn of_condition(condition: &Condition, numbers: &mut Vec<f64>) {
        match condition {
            Condition::True => {}
            Condition::Not(condition) => of_condition(condition, numbers),
            Condition::And(all) | Condition::Or(all) => all.iter().for_each(|one| of_condition(one, numbers)),
            Condition::Compare(a, _, b) => [a, b].into_iter().for_each(|term| of_term(term, numbers)),
        }
    }
    let mut numbers = Vec::new();
    for transition in graph.transitions() {
        of_condition(&transition.guard, &mut numbers);
        // To receive only this message is to compare each of its fields.
        if let Label::Receive(_, Slot::Given(message)) = &transition.label {
            numbers.extend(message.fields().iter().filter_map(Value::as_number));
        }
    }
    numbers
}
