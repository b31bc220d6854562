//! From a scenario to a channel system: its processes and channels.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use bt::{Tree, TreeProcess};
use channels::{
    Capacity, ChannelSystem, Delivery, Domain, Ordered, Precedence, Process, ProcessId, Random, RoundRobin, Scheduler,
    Shape, Starving, TickGenerator, Topology, Use, Value, WiringError,
};
use components::{
    BATTERY_READER, BLACKBOARD, BatteryReader, Blackboard, LOCALIZATION, Localization, NAVIGATION, Navigation,
    Operation, Processes, operations,
};
use diagnostics::{Problem, Spanned};
use maps::Places;
use recording::TREE;
use robot::Streams;
use skills::{Datum, LeafOfSystem, SkillOfSystem, SkillProcess, check_system};

use crate::Error;
use crate::error::Complaints;
use crate::names::unknown;
use crate::occurrences::occurrences;
use crate::processes::TICK_GENERATOR;
use crate::scenario::{Order, Policy, Scenario, Skill, TreeForm};

/// A process and its id in the topology.
type WiredProcess = (ProcessId, Box<dyn Process>);

/// A wired system, with the processes that the run must know.
#[derive(Debug)]
pub(crate) struct Wired {
    pub(crate) system: ChannelSystem,
    pub(crate) scheduler: Box<dyn Scheduler>,
    pub(crate) ids: Ids,
}

/// The processes that the run must know.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ids {
    pub(crate) tick_generator: ProcessId,
    pub(crate) tree: ProcessId,
    /// The components of a robot, if there is one.
    pub(crate) robot: Option<Processes>,
}

/// Wires tree, skills and components of a scenario.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub(crate) fn wire(scenario: &Scenario, streams: &Streams) -> Result<Wired, Error> {
    let mut complaints = Complaints::default();
    let mut topology = Topology::default();
    let says = |name| scenario.machines_of(name).flat_map(|chart| chart.channel_messages()).collect();
    let messages = scenario.skills.keys().map(|name| (&**name, says(name))).collect();
    let places = scenario.premises.as_ref().map(|premises| &premises.places);
    let ids = declare(&scenario.tree, &messages, places, &mut topology).map_err(refused)?;
    let tree_processes = tree_processes(scenario, &mut topology, ids.tree).map_err(refused)?;
    let topology = Arc::new(topology);

    let mut processes = tree_processes;
    let ticks = topology.find_channel(TICK_GENERATOR, TREE).expect("the tree's channels have just been declared");
    processes.push((ids.tick_generator, Box::new(TickGenerator::new(ticks))));
    for (name, skill) in &scenario.skills {
        let id = topology.find_process(name).expect("every skill has just been declared");
        let data = skill.data_of(&skill.machine);
        let skill = complaints.note(SkillProcess::new(name, &skill.machine, &topology, data));
        processes.extend(skill.map(|skill| (id, Box::new(skill) as Box<dyn Process>)));
    }
    processes.extend(components(scenario, &topology, &ids).map_err(refused)?);
    let scheduler = scheduler(scenario, &topology, streams, &mut complaints);
    complaints.check()?;
    let system = ChannelSystem::new(topology, processes).map_err(refused)?;
    Ok(Wired { system, scheduler: scheduler.expect("an unknown process was complained about"), ids })
}

/// The processes and channels of a scenario's system.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub fn topology(scenario: &Scenario) -> Result<Arc<Topology>, Error> {
    let wired = wire(scenario, &Streams::new(scenario.file.seed))?;
    Ok(Arc::clone(wired.system.topology()))
}

/// A system that cannot be wired, as bad input: the message tells the files by the processes' names.
fn refused(error: WiringError) -> Error {
    Error::bad_input(misfit(error))
}

fn misfit(error: WiringError) -> Problem {
    Problem::new(error.to_string())
        .with_help("the tree, the skills and the components must agree on their channels and messages")
}

/// The messages of each skill over channels: the receiver, and the first symbol.
type Messages<'a> = BTreeMap<&'a str, Vec<(&'a str, &'a str)>>;

/// Records all problems of skills that do not fit the tree and the components; leaves whose machines could not be
/// loaded are reported elsewhere. Without `places`, there is no robot. Returns the places that skills always drive to,
/// each with one such skill.
pub(crate) fn check_skills(
    tree: &Tree,
    skills: &BTreeMap<String, Skill>,
    places: Option<&Places>,
    complaints: &mut Complaints,
) -> BTreeMap<String, String> {
    let mut topology = Topology::default();
    let messages = skills.iter().map(|(name, skill)| (&**name, skill.machine.channel_messages())).collect();
    if let Err(error) = declare(tree, &messages, places, &mut topology) {
        complaints.push(misfit(error));
        return BTreeMap::new();
    }
    let leaves = tree.leaves().filter(|leaf| skills.contains_key(leaf.process()));
    let leaves = leaves.map(|leaf| LeafOfSystem { name: leaf.process(), is_halted: leaf.kind() == bt::Kind::Action });
    let leaves: Vec<LeafOfSystem<'_>> = leaves.collect();
    let data: Vec<Vec<(&str, Datum)>> = skills.values().map(|skill| skill.data_of(&skill.machine).collect()).collect();
    let skills: Vec<SkillOfSystem<'_>> =
        skills.iter().zip(&data).map(|((name, skill), data)| (&**name, &skill.machine, &data[..])).collect();
    for error in check_system(&leaves, &skills, &topology) {
        complaints.push(error);
    }
    let mut driven_to = BTreeMap::new();
    for (name, machine, data) in skills {
        let Ok(skill) = SkillProcess::new(name, machine, &topology, data.iter().cloned()) else { continue };
        let navigation = topology.find_channel(name, NAVIGATION);
        for used in skill.uses() {
            if let Use::Sends(channel, Some(message)) = used
                && Some(channel) == navigation
                && let [Value::Symbol(request), Value::Symbol(place)] = message.fields()
                && request.name() == "start_navigation"
            {
                driven_to.entry(place.name().to_owned()).or_insert_with(|| name.to_owned());
            }
        }
    }
    driven_to
}

/// Declares all processes except the tree's nodes, and all channels except those between nodes. Without `places`, there
/// is no robot, and so none of its components.
fn declare(
    tree: &Tree,
    messages: &Messages<'_>,
    places: Option<&Places>,
    topology: &mut Topology,
) -> Result<Ids, WiringError> {
    let tick_generator = topology.process(TICK_GENERATOR)?;
    let bt = topology.process(TREE)?;
    for name in tree.leaves().map(|leaf| leaf.process()).collect::<BTreeSet<_>>() {
        topology.process(name)?;
    }
    let mut component = |name| topology.process(name);
    let robot = places.map(|_| -> Result<Processes, WiringError> {
        let (battery_reader, localization) = (component(BATTERY_READER)?, component(LOCALIZATION)?);
        Ok(Processes { battery_reader, localization, navigation: component(NAVIGATION)? })
    });
    let robot = robot.transpose()?;
    // Only the skills of the paper's published system take turns in navigating.
    let take_turns = messages.values().flatten().any(|(to, _)| *to == BLACKBOARD);
    let blackboard = take_turns.then(|| topology.process(BLACKBOARD)).transpose()?;
    bt::declare_channels(tree, topology, bt, tick_generator)?;
    let operations = operations(places.unwrap_or(&Places::default()));
    let of_robot = robot.iter().flat_map(|robot| [robot.battery_reader, robot.localization, robot.navigation]);
    for component in of_robot.chain(blackboard) {
        declare_services(messages, &operations, topology, component)?;
    }
    Ok(Ids { tick_generator, tree: bt, robot })
}

/// Declares the channels between a component and the skills that ask it. They carry the skill's requests (with any
/// machine that a fault may give it) and the answers to these, and nothing else.
fn declare_services(
    messages: &Messages<'_>,
    operations: &[Operation],
    topology: &mut Topology,
    component: ProcessId,
) -> Result<(), WiringError> {
    let component_name = topology.name(component).to_owned();
    for (name, messages) in messages {
        let messages = messages.iter().copied();
        let asked: Vec<&str> = messages.filter(|(to, _)| *to == component_name).map(|(_, request)| request).collect();
        if asked.is_empty() {
            continue;
        }
        let offered = || operations.iter().filter(|operation| operation.component == component_name);
        let used: Vec<&Operation> = offered().filter(|operation| asked.contains(&operation.name)).collect();
        // Requests that the component does not understand are refused by the skill's own check, at their place in the
        // file and with all known requests.
        let is_offered = |request: &&str| offered().any(|operation| operation.name == *request);
        let used = if asked.iter().all(is_offered) { used } else { offered().collect() };
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

fn tree_processes(
    scenario: &Scenario,
    topology: &mut Topology,
    tree: ProcessId,
) -> Result<Vec<WiredProcess>, WiringError> {
    let leaf_timeout = scenario.file.execution.leaf_timeout;
    match scenario.file.execution.tree {
        TreeForm::Whole => {
            let process = TreeProcess::new(Arc::clone(&scenario.tree), topology, TREE, TICK_GENERATOR)?;
            Ok(vec![(tree, Box::new(process.with_leaf_timeout(leaf_timeout)))])
        }
        TreeForm::Nodes => bt::node_processes(&scenario.tree, topology, TREE, TICK_GENERATOR, leaf_timeout),
    }
}

fn components(scenario: &Scenario, topology: &Topology, ids: &Ids) -> Result<Vec<WiredProcess>, WiringError> {
    let mut players: Vec<WiredProcess> = Vec::new();
    if let Some(Processes { battery_reader, localization, navigation }) = ids.robot {
        let driver = Navigation::new(topology, navigation)?.with_stops(scenario.file.execution.stops);
        players.push((battery_reader, Box::new(BatteryReader::new(topology, battery_reader)?)));
        players.push((localization, Box::new(Localization::new(topology, localization)?)));
        players.push((navigation, Box::new(driver)));
    }
    if let Some(blackboard) = topology.find_process(BLACKBOARD) {
        players.push((blackboard, Box::new(Blackboard::new(topology, blackboard)?)));
    }
    Ok(players)
}

/// The scheduler: the scenario's policy, within the orders that it demands.
fn scheduler(
    scenario: &Scenario,
    topology: &Topology,
    streams: &Streams,
    complaints: &mut Complaints,
) -> Option<Box<dyn Scheduler>> {
    let policy = policy(scenario, topology, streams, complaints);
    let orders = &scenario.file.execution.orders;
    let precedences: Vec<_> = orders.iter().map(|order| precedence(order, topology, complaints)).collect();
    let policy = policy?;
    Some(if orders.is_empty() { policy } else { Box::new(Ordered::new(precedences, policy)) })
}

/// An order among messages.
fn precedence(order: &Order, topology: &Topology, complaints: &mut Complaints) -> Precedence {
    let mut deliveries = |event: &Spanned<String>| -> Vec<Delivery> {
        let events = occurrences(event, topology, complaints).unwrap_or_default();
        let delivery = |event: monitors::EventAtom| {
            let condition = event.condition;
            Delivery { channel: event.channel, concerns: Arc::new(move |message| condition.holds(message)) }
        };
        events.into_iter().map(delivery).collect()
    };
    Precedence { first: deliveries(&order.first), then: deliveries(&order.then) }
}

fn policy(
    scenario: &Scenario,
    topology: &Topology,
    streams: &Streams,
    complaints: &mut Complaints,
) -> Option<Box<dyn Scheduler>> {
    let execution = &scenario.file.execution;
    let others: Box<dyn Scheduler> = match execution.policy {
        Policy::Random => Box::new(Random::new(streams.stream("channels/scheduler"))),
        Policy::RoundRobin => Box::new(RoundRobin::default()),
    };
    let Some(victim) = &execution.starved else { return Some(others) };
    let id = topology.find_process(&victim.value);
    if id.is_none() {
        let names: Vec<&str> = topology.processes().map(|id| topology.name(id)).collect();
        complaints.push(unknown("process", victim, names));
    }
    Some(Box::new(Starving::new(id?, others)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::find;

    #[test]
    fn starving_a_process_leaves_the_choice_among_the_others_to_the_policy() {
        let found = find::find("errand").expect("a scenario of the program's");
        for (policy, words) in [("random", "Random"), ("round-robin", "RoundRobin")] {
            let overrides = [format!("execution.policy={policy}"), "execution.starve=BT".to_owned()];
            let scenario = Scenario::load(&found, &overrides).expect("a sound scenario");
            let wired = wire(&scenario, &Streams::new(1)).expect("a system");
            let scheduler = format!("{:?}", wired.scheduler);
            assert!(scheduler.starts_with("Starving") && scheduler.contains(words), "{scheduler}");
        }
    }
}
