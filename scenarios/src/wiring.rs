//! From a scenario to a channel system: which processes there are and which channels join them.

use std::sync::Arc;

use bt::TreeProcess;
use channels::{
    Capacity, ChannelSystem, Domain, Process, ProcessId, Random, RoundRobin, Scheduler, Shape, Starving, TickGenerator,
    Topology, WiringError,
};
use components::{
    BATTERY_READER, BatteryReader, LOCALIZATION, Localization, NAVIGATION, Navigation, Operation, operations,
};
use robot::Streams;
use skills::SkillProcess;

use crate::Error;
use crate::error::Complaints;
use crate::scenario::{Policy, Scenario, TreeForm, unknown};

/// The name of the process that supplies ticks.
const TICK_GENERATOR: &str = "TickGenerator";
/// The name of the tree's process.
const TREE: &str = "BT";

/// A process with its place in the topology.
type Player = (ProcessId, Box<dyn Process>);

/// A wired system, with the processes that the run has to know.
#[derive(Debug)]
pub(crate) struct Wired {
    pub(crate) system: ChannelSystem,
    pub(crate) scheduler: Box<dyn Scheduler>,
    pub(crate) ids: Ids,
}

/// The processes that the run has to know.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ids {
    pub(crate) tick_generator: ProcessId,
    pub(crate) tree: ProcessId,
    pub(crate) battery_reader: ProcessId,
    pub(crate) localization: ProcessId,
    pub(crate) navigation: ProcessId,
}

/// Wires tree, skills and components of a scenario.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub(crate) fn wire(scenario: &Scenario, streams: &Streams) -> Result<Wired, Error> {
    let mut complaints = Complaints::default();
    let operations = operations(&scenario.places);
    let mut topology = Topology::default();
    let ids = declare(scenario, &operations, &mut topology).map_err(refused)?;
    let tree_processes = tree_processes(scenario, &mut topology, ids.tree).map_err(refused)?;
    let topology = Arc::new(topology);

    let mut processes = tree_processes;
    let ticks = topology.find_channel(TICK_GENERATOR, TREE).expect("the tree's channels have just been declared");
    processes.push((ids.tick_generator, Box::new(TickGenerator::new(ticks))));
    for (name, chart) in &scenario.charts {
        let id = topology.find_process(name).expect("every skill has just been declared");
        let skill = complaints.note(SkillProcess::new(name, chart, &topology, []));
        processes.extend(skill.map(|skill| (id, Box::new(skill) as Box<dyn Process>)));
    }
    processes.extend(components(&topology, &ids).map_err(refused)?);
    let scheduler = scheduler(scenario, &topology, streams, &mut complaints);
    complaints.check()?;
    let system = ChannelSystem::new(topology, processes).map_err(refused)?;
    Ok(Wired { system, scheduler: scheduler.expect("an unknown process was complained about"), ids })
}

/// A system that cannot be wired, as bad input: which files are at fault, the message says by the processes' names.
fn refused(error: WiringError) -> Error {
    Error::refused(error.to_string(), "tree, skills and components have to agree on their channels and messages")
}

/// Declares all processes but the tree's nodes, and all channels but those between nodes.
fn declare(scenario: &Scenario, operations: &[Operation], topology: &mut Topology) -> Result<Ids, WiringError> {
    let tick_generator = topology.process(TICK_GENERATOR)?;
    let tree = topology.process(TREE)?;
    for name in scenario.charts.keys() {
        topology.process(name)?;
    }
    let battery_reader = topology.process(BATTERY_READER)?;
    let localization = topology.process(LOCALIZATION)?;
    let navigation = topology.process(NAVIGATION)?;
    bt::declare_channels(&scenario.tree, topology, tree, tick_generator)?;
    for component in [battery_reader, localization, navigation] {
        declare_services(scenario, operations, topology, component)?;
    }
    Ok(Ids { tick_generator, tree, battery_reader, localization, navigation })
}

/// Declares the channels between a component and the skills that ask it; they carry what the skill asks (with any machine
/// that a fault may give it) and its answers, and no more.
fn declare_services(
    scenario: &Scenario,
    operations: &[Operation],
    topology: &mut Topology,
    component: ProcessId,
) -> Result<(), WiringError> {
    let component_name = topology.name(component).to_owned();
    for name in scenario.charts.keys() {
        let messages = scenario.machines_of(name).flat_map(|chart| chart.channel_messages());
        let asked: Vec<&str> = messages.filter(|(to, _)| *to == component_name).map(|(_, request)| request).collect();
        if asked.is_empty() {
            continue;
        }
        let offered = || operations.iter().filter(|operation| operation.component == component_name);
        let used: Vec<&Operation> = offered().filter(|operation| asked.contains(&operation.name)).collect();
        // What the component does not understand is refused by the skill, at its place in the file.
        let used = if used.is_empty() { offered().collect() } else { used };
        let skill = topology.find_process(name).expect("every skill has just been declared");
        let requests = Domain::new(used.iter().map(|operation| operation.request.clone()));
        topology.channel(skill, component, Capacity::One, requests)?;
        topology.channel(component, skill, Capacity::One, Domain::new(replies(&used)))?;
    }
    Ok(())
}

/// The replies to these operations, each shape once.
fn replies(operations: &[&Operation]) -> Vec<Shape> {
    let mut shapes: Vec<Shape> = Vec::new();
    for shape in operations.iter().flat_map(|operation| &operation.replies) {
        if !shapes.contains(shape) {
            shapes.push(shape.clone());
        }
    }
    shapes
}

fn tree_processes(scenario: &Scenario, topology: &mut Topology, tree: ProcessId) -> Result<Vec<Player>, WiringError> {
    match scenario.file.execution.tree {
        TreeForm::Whole => {
            let process = TreeProcess::new(Arc::clone(&scenario.tree), topology, TREE, TICK_GENERATOR)?;
            Ok(vec![(tree, Box::new(process))])
        }
        TreeForm::Nodes => bt::node_processes(&scenario.tree, topology, TREE, TICK_GENERATOR),
    }
}

fn components(topology: &Topology, ids: &Ids) -> Result<[Player; 3], WiringError> {
    Ok([
        (ids.battery_reader, Box::new(BatteryReader::new(topology, ids.battery_reader)?)),
        (ids.localization, Box::new(Localization::new(topology, ids.localization)?)),
        (ids.navigation, Box::new(Navigation::new(topology, ids.navigation)?)),
    ])
}

fn scheduler(
    scenario: &Scenario,
    topology: &Topology,
    streams: &Streams,
    complaints: &mut Complaints,
) -> Option<Box<dyn Scheduler>> {
    let random = || Box::new(Random::new(streams.stream("channels/scheduler")));
    match &scenario.file.execution.policy {
        Policy::Random => Some(random()),
        Policy::RoundRobin => Some(Box::new(RoundRobin::default())),
        Policy::Starve(victim) => {
            let id = topology.find_process(&victim.value);
            if id.is_none() {
                let names: Vec<&str> = topology.processes().map(|id| topology.name(id)).collect();
                complaints.push(unknown("process", victim, names));
            }
            Some(Box::new(Starving::new(id?, random())))
        }
    }
}
