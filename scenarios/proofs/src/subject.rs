//! The scenarios that can be proved, and what a proof knows about the robot's places.

use std::collections::BTreeSet;

use channels::{ChannelSystem, Use, Value};
use components::{BATTERY_READER, LOCALIZATION, NAVIGATION};
use devices::DeviceKind;
use diagnostics::Problem;
use scenarios::names::unknown;
use scenarios::scenario::{BatteryAssumption, ComponentEntry, Passes, Premises, RunsEntry, Scenario};
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
        let (what, place) = match runs {
            RunsEntry::Program { command, .. } => ("is a program, whose possible behavior is unknown", &command.span),
            RunsEntry::Device { settings, .. } if is_of_the_world(settings.value.kind()) => {
                ("senses and changes the world, which does not exist in a proof", &settings.span)
            }
            RunsEntry::Machine(_) | RunsEntry::Device { .. } => continue,
        };
        let problem = place.problem(format!("the component {} cannot be explored: it {what}", name.value));
        let help = format!(
            "replace it with a machine that allows all that it may do: `[prove.components.{}] machine = \"FILE.scxml\"`",
            name.value
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

/// Whether devices of this kind depend on the world; others depend only on messages and time.
fn is_of_the_world(kind: DeviceKind) -> bool {
    match kind {
        DeviceKind::Door | DeviceKind::People | DeviceKind::Tray => true,
        DeviceKind::Speaker | DeviceKind::Button | DeviceKind::Microphone => false,
    }
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
    if !is_builtin(NAVIGATION) && is_builtin(LOCALIZATION) {
        let problem = Problem::new(format!("{NAVIGATION} is from a file, and {LOCALIZATION} is built in"));
        let help = "a proof cannot know where such a Navigation drives; replace Localization by a machine as well";
        complaints.push(problem.with_help(help));
    }
}

/// The places that matter: those that some part asks about, drives to, or passes.
pub(super) fn ground(scenario: &Scenario, system: &ChannelSystem) -> Ground {
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
