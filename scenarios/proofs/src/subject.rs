//! The scenarios that can be proved, and what is known in a proof about the robot's places.

use std::collections::BTreeSet;

use channels::{ChannelId, ChannelSystem, FieldKind, Monitor, Relation, Use, Value};
use components::{BATTERY_READER, LOCALIZATION, NAVIGATION};
use diagnostics::Problem;
use monitors::scope_monitor;
use scenarios::names::unknown;
use scenarios::scenario::{
    BatteryAssumption, ComponentEntry, Fact, MachineMonitor, Passes, Premises, RunsEntry, Scenario, Truths,
};
use scenarios::{Complaints, Error};

use super::environment::Ground;

/// Checks that all parts of a scenario can be explored.
pub(super) fn check(scenario: &Scenario) -> Result<(), Error> {
    let mut complaints = Complaints::default();
    if let Some(model) = scenario.file.behavior.model() {
        let problem = model.path.span.problem(
            "the properties of a RoAML model cannot be proved: they refer to internal states of its processes",
        );
        let help = "run it many times instead: `steward campaign`";
        complaints.push(problem.with_label("this model").with_help(help));
    }
    for ComponentEntry { name, runs, .. } in &scenario.file.components {
        let (place, what) = match runs {
            RunsEntry::Program { command, .. } => (&command.span, "is a program, whose possible behavior is unknown"),
            RunsEntry::Remote { namespace } => {
                (&namespace.span, "consists of nodes of ROS 2, whose behavior is unknown")
            }
            RunsEntry::Machine(_) | RunsEntry::Anything { .. } | RunsEntry::Device { .. } => continue,
        };
        let problem = place.problem(format!("the component {} cannot be explored: it {what}", name.value));
        let help = format!(
            "assume that it may answer anything, `prove.components.{name}.answers = \"anything\"`, or replace it with a \
             machine that allows all that it may do: `prove.components.{name}.machine = \"FILE.scxml\"`",
            name = name.value
        );
        complaints.push(problem.with_label("this component").with_help(help));
    }
    // The run writes these to the blackboard before each tick; a proof has no simulation to take them from.
    let of_the_world = ["robot_pose", "robot_speed"];
    let tree = scenario.tree().filter(|_| scenario.premises.is_some());
    if let Some(key) = tree.and_then(|tree| of_the_world.into_iter().find(|key| tree.names_entry(key))) {
        let place = &scenario.file.behavior.main_file().span;
        let problem =
            place.problem(format!("the tree reads `{key}`, which depends on the simulation, and a proof has none"));
        complaints
            .push(problem.with_label("this tree").with_help("use a tree without nodes that measure speed or distance"));
    }
    complaints.check()
}

/// Checks that each assumption applies to something, and that they do not contradict each other.
pub(super) fn check_assumptions(scenario: &Scenario, complaints: &mut Complaints) {
    let prove = &scenario.file.prove;
    let is_builtin = |name: &str| scenario.premises.is_some() && !scenario.components.contains_key(name);
    if let BatteryAssumption::Drained(drained) = &prove.battery {
        if !is_builtin(BATTERY_READER) {
            let problem = drained.place.problem(format!("the component {BATTERY_READER} is from a file"));
            let help = "its machine determines the level; remove `[prove.battery]`";
            complaints.push(
                problem.with_label("this section describes the level that the built-in one reads").with_help(help),
            );
        }
        let has_station = scenario.premises.as_ref().is_some_and(|premises| premises.station.is_some());
        if drained.charge_pct > 0.0 && !has_station {
            let problem =
                drained.place.problem("`charge_pct_per_tick` needs a charging station, and the scenario has none");
            complaints
                .push(problem.with_label("this battery").with_help("name the station, `sites.station`, or remove it"));
        }
    }
    let Some(premises) = &scenario.premises else { return };
    if let Passes::These(names) = &prove.trips.passes {
        for name in names.iter().filter(|name| premises.places.get(&name.value).is_none()) {
            complaints.push(unknown("place", name, premises.places.iter().map(|(name, _)| name)));
        }
    }
}

/// Whether messages on the channel can change a verdict.
pub(super) fn watches(monitor: &dyn Monitor, channel: ChannelId) -> bool {
    let mut is_watched = MachineMonitor::of(monitor).is_some_and(|machine| machine.watches(channel));
    if let Some(scope) = scope_monitor(monitor) {
        is_watched |= scope.formula().is_about(channel);
    }
    is_watched
}

/// # Errors
/// The problem of a property that can be violated only by waiting forever.
pub(super) fn check_time_limit(monitor: &dyn Monitor) -> Result<(), Problem> {
    if scope_monitor(monitor).is_none_or(|scope| scope.formula().is_safety()) {
        return Ok(());
    }
    let name = monitor.name();
    let message =
        format!("the property {name} requires something without a time limit, and no search can wait forever");
    let help = "limit it in ticks, `time_until (…) < 60`, or prove other properties: `--property NAME`, \
                `prove.properties`";
    Err(Problem::new(message).with_help(help))
}

/// # Errors
/// The problem of a property about facts of the world that are not known in a proof.
pub(super) fn check_world(monitor: &dyn Monitor, truths: Option<&Truths>, has_battery: bool) -> Result<(), Problem> {
    let of_world = truths.filter(|truths| watches(monitor, truths.channel));
    let Some(why) = of_world.and_then(|truths| beyond(monitor, truths, has_battery)) else { return Ok(()) };
    let problem = Problem::new(format!("the property {} {why}", monitor.name()));
    Err(problem.with_help(
        "of the world, a proof has only `level_pct`, `charging` and the places, whenever they change: judge runs \
         with `steward run` and `steward campaign`",
    ))
}

/// Why a property about the world cannot be proved, in words; `None` if it can: in a proof, the level and the place are
/// known, and shown when they change. How often the world is shown in between is not known.
fn beyond(monitor: &dyn Monitor, truths: &Truths, has_battery: bool) -> Option<&'static str> {
    let Some(scope) = scope_monitor(monitor) else { return Some("is a machine") };
    let mut unknown = None;
    scope.formula().events(&mut |event| {
        if event.channel == truths.channel {
            event.condition.fields(&mut |field| match truths.facts.get(field.number - 1) {
                Some(Fact::At(_)) => {}
                Some(Fact::Level | Fact::Charging) if has_battery => {}
                _ => unknown = Some(()),
            });
        }
    });
    match unknown {
        Some(()) => Some("is about more than the level and the place"),
        None if !scope.formula().is_steady(truths.channel) => {
            Some("counts messages or measures time, and is about the world")
        }
        None => None,
    }
}

/// Reports a property that may distinguish more numbers of a component that answers anything than it answers: those
/// with which machines and properties compare something.
pub(super) fn check_numbers(
    scenario: &Scenario,
    system: &ChannelSystem,
    monitor: &dyn Monitor,
    complaints: &mut Complaints,
) {
    let topology = system.topology();
    let literals = scenarios::scenario::literals(&scenario.properties);
    for ComponentEntry { name, runs, .. } in &scenario.file.components {
        let RunsEntry::Anything { place, .. } = runs else { continue };
        let is_from = |channel: ChannelId| topology.ends(channel).0 == name.value;
        let is_heard_by_machine = MachineMonitor::of(monitor)
            .is_some_and(|machine| topology.channels().any(|id| is_from(id) && machine.watches(id)));
        let mut is_followed = !is_heard_by_machine;
        if let Some(scope) = scope_monitor(monitor) {
            scope.formula().events(&mut |event| {
                if is_from(event.channel) {
                    let shapes = topology.get(event.channel).domain.shapes();
                    let kinds =
                        |field: usize| shapes.iter().filter_map(move |shape| shape.fields().get(field.checked_sub(1)?));
                    // Of the other kinds, a proof tries every value, or enough of them: of texts, which `texts`
                    // follows.
                    let is_open = |field: usize| {
                        let mut kinds = kinds(field).map(|(_, kind)| kind.present());
                        kinds.any(|kind| matches!(kind, FieldKind::Int | FieldKind::Real | FieldKind::List(_)))
                    };
                    event.condition.related_fields(&mut |field| is_followed &= !is_open(field));
                    // A number that the property computes, `10 + 5`, is not among them.
                    event.condition.comparisons(&mut |_, _, value| {
                        let is_known = |known: &Value| Relation::Equal.holds(known, value);
                        is_followed &= !value.is_number() || literals.iter().any(is_known);
                    });
                }
            });
        }
        if !is_followed {
            let message = format!(
                "the property {} does more with values of {} than compare them with constants",
                monitor.name(),
                name.value
            );
            let problem = place.problem(message).with_label("this answers only what is compared");
            let help = "compare them with constants only, or write a machine that stands for the component";
            complaints.push(problem.with_help(help));
        }
    }
}

/// The places that matter: those that some part refers to, drives to, or passes.
/// Those that the `truths` name are among them.
pub(super) fn ground(scenario: &Scenario, system: &ChannelSystem, truths: Option<&Truths>) -> Ground {
    let Premises { places, start, entry, .. } = scenario.premises.as_ref().expect("only a robot has places");
    let known: Vec<String> = places.iter().map(|(name, _)| name.to_owned()).collect();
    let mut meant: BTreeSet<String> = BTreeSet::new();
    let topology = system.topology();
    let processes = topology.processes().filter_map(|id| system.clone_process(id));
    for used in processes.flat_map(|process| process.uses()) {
        let Use::Sends(channel, message) = used else { continue };
        if ![LOCALIZATION, NAVIGATION].contains(&topology.ends(channel).1) {
            continue;
        }
        match message {
            Some(message) => meant.extend(message.fields().iter().filter_map(|field| match field {
                Value::Symbol(symbol) if known.iter().any(|place| place == symbol.name()) => {
                    Some(symbol.name().to_owned())
                }
                _ => None,
            })),
            // It may send any message that the channel carries.
            None => meant.extend(known.iter().cloned()),
        }
    }
    meant.extend(truths.into_iter().flat_map(|truths| truths.facts.iter()).filter_map(|fact| match fact {
        Fact::At(place) => Some(place.clone()),
        _ => None,
    }));
    match &scenario.file.prove.trips.passes {
        Passes::Any => meant.extend(known.iter().cloned()),
        Passes::These(names) => meant.extend(names.iter().map(|name| name.value.clone())),
    }
    let station = entry.sites.station.as_ref().map(|name| name.value.clone());
    meant.extend(station.clone());
    let meant: Vec<String> = meant.into_iter().collect();
    let is_there = |name: &String| places.get(name).is_some_and(|place| place.contains(start));
    Ground {
        station: station.and_then(|name| meant.iter().position(|place| *place == name)),
        start: meant.iter().position(is_there),
        places: meant,
        known,
    }
}
