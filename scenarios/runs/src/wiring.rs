//! Turns a scenario into a channel system: its processes and channels.

use std::sync::Arc;
use std::time::Duration;

use bt::{Tree, TreeProcess};
use channels::{
    ChannelSystem, Delivery, Ordered, Precedence, Process, ProcessId, Random, RoundRobin, Scheduler, Starving,
    Subscriber, TickGenerator, Topology, WiringError,
};
use components::{
    BATTERY_READER, BLACKBOARD, BatteryReader, Blackboard, LOCALIZATION, Localization, NAVIGATION, Navigation,
    Processes,
};
use devices::DeviceProcess;
use diagnostics::Spanned;
use programs::ProgramProcess;
use recording::TREE;
use remote::{Offered, RemoteClients, RemoteProcess};
use roaml::{Model, Wiring};
use robot::Streams;
use scenarios::names::unknown;
use scenarios::occurrences::occurrences;
use scenarios::processes::{ROS, SUBSCRIBER, TICK_GENERATOR};
use scenarios::scenario::{
    Behavior, ComponentEntry, Order, Policy, Runs, RunsEntry, Scenario, TreeForm, TreeIds, Truths, misfit,
};
use scenarios::{Complaints, Error};
use skills::SkillProcess;

type WiredProcess = (ProcessId, Box<dyn Process>);

/// A wired system, with the processes that the run uses directly.
#[derive(Debug)]
pub struct Wired {
    /// The processes at their start.
    pub system: ChannelSystem,
    /// What chooses among enabled transitions.
    pub scheduler: Box<dyn Scheduler>,
    /// The processes that the run uses directly.
    pub ids: Ids,
    /// The truths about the world that monitors are shown, if any property needs them.
    pub truths: Option<Truths>,
}

/// The processes that the run uses directly.
#[derive(Clone, Copy, Debug)]
pub struct Ids {
    /// The tree and what generates its ticks, if there is a tree.
    pub tree: Option<TreeIds>,
    /// The components of a robot, if there is one.
    pub robot: Option<Processes>,
    /// What stands for nodes of ROS 2 to which components are offered, if there are any.
    pub clients: Option<ProcessId>,
}

/// Wires tree, skills and components of a scenario.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub fn wire(scenario: &Scenario, streams: &Streams) -> Result<Wired, Error> {
    wire_for(scenario, streams, &Arc::default())
}

/// The same, with these components offered to nodes of ROS 2.
pub(crate) fn wire_for(scenario: &Scenario, streams: &Streams, offered: &Arc<[Offered]>) -> Result<Wired, Error> {
    wire_with(scenario, streams, offered, Scenario::declare_observed)
}

/// Wires a scenario whose system has this for monitors.
fn wire_with(
    scenario: &Scenario,
    streams: &Streams,
    offered: &Arc<[Offered]>,
    declare_for_monitors: fn(&Scenario, &mut Topology) -> Result<Option<Truths>, WiringError>,
) -> Result<Wired, Error> {
    let tree = match &scenario.behavior {
        Behavior::Tree(tree) => tree,
        Behavior::Model(model) => return wire_model(scenario, model, streams),
    };
    let mut complaints = Complaints::default();
    let mut topology = Topology::default();
    let (ids, robot) = scenario.declare(tree, offered, &mut topology).map_err(refused)?;
    let mut processes = tree_processes(scenario, tree, &mut topology, ids).map_err(refused)?;
    let truths = declare_for_monitors(scenario, &mut topology).map_err(refused)?;
    // All processes and channels are declared before the first process is made: it looks up those that it uses.
    let topology = Arc::new(topology);

    for (name, skill) in scenario.machine_processes() {
        let id = topology.find_process(name).expect("every machine's process has just been declared");
        let data = skill.data_of(&skill.machine);
        let skill = complaints.note(SkillProcess::new(name, &skill.machine, &topology, data));
        processes.extend(skill.map(|skill| (id, Box::new(skill) as Box<dyn Process>)));
    }
    for (name, component) in &scenario.components {
        let id = topology.find_process(name).expect("every component has just been declared");
        match &component.runs {
            Runs::Machine(_) => {}
            Runs::Program { program, data, .. } => {
                processes.push((id, Box::new(ProgramProcess::new(&topology, id, Arc::clone(program), data.clone()))));
            }
            Runs::Remote(component) => {
                processes.push((id, Box::new(RemoteProcess::new(&topology, id, Arc::clone(component)))));
            }
            Runs::Device(settings) => {
                processes.push((id, Box::new(DeviceProcess::new(&topology, id, settings))));
            }
        }
    }
    let clients = topology.find_process(ROS).filter(|_| !offered.is_empty());
    if let Some(id) = clients {
        processes.push((id, Box::new(RemoteClients::new(&topology, id, Arc::clone(offered)))));
    }
    processes.extend(builtin_components(scenario, &topology, robot).map_err(refused)?);
    if let Some(id) = topology.find_process(SUBSCRIBER) {
        processes.push((id, Box::new(Subscriber::new(&topology, id))));
    }
    let scheduler = scheduler(scenario, &topology, streams, &mut complaints);
    complaints.check()?;
    let system = ChannelSystem::new(topology, processes).map_err(refused)?;
    let scheduler = scheduler.expect("an unknown process was reported");
    Ok(Wired { system, scheduler, ids: Ids { tree: Some(ids), robot, clients }, truths })
}

fn wire_model(scenario: &Scenario, model: &Model, streams: &Streams) -> Result<Wired, Error> {
    let mut complaints = Complaints::default();
    let mut topology = Topology::default();
    let tree = model.tree.as_ref().map(|_| TreeIds::declare(&mut topology)).transpose().map_err(refused)?;
    let ids = tree.map(|ids| (ids.tick_generator, ids.tree));
    let wiring = Wiring::declare(model, &mut topology, ids).map_err(refused)?;
    let mut processes: Vec<WiredProcess> = Vec::new();
    if let Some((tree, ids)) = model.tree.as_ref().zip(tree) {
        processes.extend(tree_processes(scenario, tree, &mut topology, ids).map_err(refused)?);
    }
    let topology = Arc::new(topology);
    processes.extend(wiring.processes(&topology, streams));
    let scheduler = scheduler(scenario, &topology, streams, &mut complaints);
    complaints.check()?;
    let system = ChannelSystem::new(topology, processes).map_err(refused)?;
    let scheduler = scheduler.expect("an unknown process was reported");
    Ok(Wired { system, scheduler, ids: Ids { tree, robot: None, clients: None }, truths: None })
}

/// Starts the programs among the components.
///
/// # Errors
/// [`Error::BadInput`] with all programs that cannot be started or do not answer.
pub(crate) fn start_programs(scenario: &Scenario, system: &mut ChannelSystem) -> Result<(), Error> {
    let mut complaints = Complaints::default();
    for ComponentEntry { name, runs, .. } in &scenario.file.components {
        let RunsEntry::Program { command, .. } = runs else { continue };
        let id = system.topology().find_process(&name.value).expect("every component is a process");
        let process = system.process_mut::<ProgramProcess>(id).expect("it runs a program");
        if let Err(failure) = process.start(Duration::ZERO) {
            let problem = command.span.problem(format!("the component {} does not start: {failure}", name.value));
            complaints.push(problem.with_label("this command"));
        }
    }
    complaints.check()
}

/// The processes and channels of a scenario's system.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub fn topology(scenario: &Scenario) -> Result<Arc<Topology>, Error> {
    let wired = wire(scenario, &Streams::new(scenario.file.seed))?;
    Ok(Arc::clone(wired.system.topology()))
}

/// The same with everything that the system can have for monitors, for properties that it does not have yet.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub fn topology_for_properties(scenario: &Scenario) -> Result<Arc<Topology>, Error> {
    let wired = wire_with(scenario, &Streams::new(scenario.file.seed), &Arc::default(), Scenario::declare_observable)?;
    Ok(Arc::clone(wired.system.topology()))
}

/// Reports a system that cannot be wired as bad input.
fn refused(error: WiringError) -> Error {
    Error::bad_input(misfit(&error))
}

/// The tree and what generates its ticks.
fn tree_processes(
    scenario: &Scenario,
    tree: &Arc<Tree>,
    topology: &mut Topology,
    ids: TreeIds,
) -> Result<Vec<WiredProcess>, WiringError> {
    let leaf_timeout = scenario.file.execution.leaf_timeout;
    let mut processes: Vec<WiredProcess> = match scenario.file.execution.tree {
        TreeForm::Whole => {
            let process = TreeProcess::new(Arc::clone(tree), topology, TREE, TICK_GENERATOR)?;
            vec![(ids.tree, Box::new(process.with_leaf_timeout(leaf_timeout)))]
        }
        TreeForm::Nodes => bt::node_processes(tree, topology, TREE, TICK_GENERATOR, leaf_timeout)?,
    };
    let ticks = topology.find_channel(TICK_GENERATOR, TREE).expect("the tree's channels have just been declared");
    processes.push((ids.tick_generator, Box::new(TickGenerator::new(ticks))));
    Ok(processes)
}

fn builtin_components(
    scenario: &Scenario,
    topology: &Topology,
    robot: Option<Processes>,
) -> Result<Vec<WiredProcess>, WiringError> {
    let mut processes: Vec<WiredProcess> = Vec::new();
    let is_builtin = |name| !scenario.components.contains_key(name);
    if let Some(Processes { battery_reader, localization, navigation }) = robot {
        if is_builtin(BATTERY_READER) {
            processes.push((battery_reader, Box::new(BatteryReader::new(topology, battery_reader)?)));
        }
        if is_builtin(LOCALIZATION) {
            processes.push((localization, Box::new(Localization::new(topology, localization)?)));
        }
        if is_builtin(NAVIGATION) {
            let driver = Navigation::new(topology, navigation)?.with_stops(scenario.file.execution.stops);
            processes.push((navigation, Box::new(driver)));
        }
    }
    if let Some(blackboard) = topology.find_process(BLACKBOARD).filter(|_| is_builtin(BLACKBOARD)) {
        processes.push((blackboard, Box::new(Blackboard::new(topology, blackboard)?)));
    }
    Ok(processes)
}

/// The scheduler: the scenario's policy, within the orders that the scenario requires.
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
    let moving = || topology.processes().filter(|id| !topology.is_outside(*id));
    let id = moving().find(|id| topology.name(*id) == victim.value);
    if id.is_none() {
        let names: Vec<&str> = moving().map(|id| topology.name(id)).collect();
        complaints.push(unknown("process", victim, names));
    }
    Some(Box::new(Starving::new(id?, others)))
}

#[cfg(test)]
#[path = "../../../channels/tests/system/lockstep.rs"]
mod lockstep;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::lockstep::Lockstep;
    use super::*;
    use scenarios::scenario::find;

    fn wired(name: &str) -> Wired {
        let found = find::find(name).expect("a scenario");
        wire(&Scenario::load(&found, &[]).expect("a sound scenario"), &Streams::new(1)).expect("a system")
    }

    /// Lets a system run for a minute beside its normal form, and returns the number of steps.
    fn walk_beside_normal_form(mut wired: Wired) -> usize {
        let mut pair = Lockstep::new(&wired.system, Duration::ZERO);
        let generator = wired.ids.tree.expect("it has a tree").tick_generator;
        let mut steps = 0;
        for tenth in 0..600 {
            if tenth % 10 == 0 {
                pair.tick(generator);
            }
            steps += (0..40).take_while(|_| pair.step(wired.scheduler.as_mut())).count();
            pair.advance(Duration::from_millis(100));
        }
        steps
    }

    #[test]
    fn devices_and_their_normal_forms_are_indistinguishable() {
        let steps = walk_beside_normal_form(wired("parcel"));
        assert!(steps > 100, "{steps} steps");
    }

    #[test]
    fn a_model_without_chance_and_its_normal_form_are_indistinguishable() {
        let lift = Path::new(env!("CARGO_MANIFEST_DIR")).join("../roaml/tests/models/lift");
        let folder = tempfile::tempdir().expect("a folder");
        for entry in std::fs::read_dir(&lift).expect("its files") {
            let file = entry.expect("a file").path();
            let mut text = std::fs::read_to_string(&file).expect("a text");
            if let Some((before, after)) = text.split_once("<target id=\"idle\">") {
                let (_, after) = after.split_once("</target>").expect("its end");
                text = format!("{before}{after}").replace(" prob=\"0.75\"", "");
            }
            std::fs::write(folder.path().join(file.file_name().expect("a name")), text).expect("a copy");
        }
        let steps = walk_beside_normal_form(wired(&folder.path().join("main.xml").display().to_string()));
        assert!(steps > 100, "{steps} steps");

        let mut by_chance = wired(&lift.join("main.xml").display().to_string()).system;
        let refused = (0..600).find_map(|tenth| {
            by_chance.advance(Duration::from_millis(100) * tenth);
            let generator = by_chance.topology().find_process(TICK_GENERATOR).expect("it has a tree");
            if tenth % 10 == 0 {
                by_chance.generate_tick(generator);
            }
            let mut in_turn = channels::RoundRobin::default();
            by_chance.run(&mut in_turn, 10_000).for_each(|event| drop(event.expect("a sound message")));
            let (id, why) = by_chance.fork().normalize().err()?;
            Some(format!("{}: {why}", by_chance.topology().name(id)))
        });
        assert_eq!(refused.as_deref(), Some("Lift: it draws random numbers"));
    }

    #[test]
    fn starving_a_process_leaves_the_choice_among_the_others_to_the_policy() {
        let found = find::find("errand").expect("a shipped scenario");
        for (policy, words) in [("random", "Random"), ("round-robin", "RoundRobin")] {
            let overrides = [format!("execution.policy={policy}"), "execution.starve=BT".to_owned()];
            let scenario = Scenario::load(&found, &overrides).expect("a sound scenario");
            let wired = wire(&scenario, &Streams::new(1)).expect("a system");
            let scheduler = format!("{:?}", wired.scheduler);
            assert!(scheduler.starts_with("Starving") && scheduler.contains(words), "{scheduler}");
        }
    }
}
