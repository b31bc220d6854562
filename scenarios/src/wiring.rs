//! Turns a scenario into a channel system: its processes and channels.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use bt::{Tree, TreeProcess};
use channels::{
    Capacity, ChannelSystem, Delivery, Domain, Ordered, Precedence, Process, ProcessId, Random, RoundRobin, Scheduler,
    Shape, Starving, TickGenerator, Topology, Use, Value, WiringError,
};
use components::{
    BATTERY_READER, BLACKBOARD, BatteryReader, Blackboard, LOCALIZATION, Localization, NAVIGATION, Navigation,
    Operation, Processes, operations,
};
use devices::DeviceProcess;
use diagnostics::{Problem, Spanned};
use interfaces::Interface;
use maps::Places;
use programs::ProgramProcess;
use recording::TREE;
use roaml::{Model, Wiring};
use robot::Streams;
use skills::{Chart, Datum, LeafOfSystem, SkillOfSystem, SkillProcess, check_system};

use crate::Error;
use crate::error::Complaints;
use crate::names::unknown;
use crate::occurrences::occurrences;
use crate::processes::{BUILTIN, TICK_GENERATOR};
use crate::scenario::{Component, ComponentEntry, Order, Policy, Runs, RunsEntry, Scenario, Skill, TreeForm};

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
    /// The tree and what generates its ticks, if there is a tree.
    pub(crate) tree: Option<TreeIds>,
    /// The components of a robot, if there is one.
    pub(crate) robot: Option<Processes>,
}

/// The tree and what generates its ticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeIds {
    pub(crate) tick_generator: ProcessId,
    pub(crate) tree: ProcessId,
}

/// Wires tree, skills and components of a scenario.
///
/// # Errors
/// [`Error::BadInput`] with everything that does not fit together.
pub(crate) fn wire(scenario: &Scenario, streams: &Streams) -> Result<Wired, Error> {
    let tree = match (&scenario.model, &scenario.tree) {
        (Some(model), _) => return wire_model(scenario, model, streams),
        (None, tree) => tree.as_ref().expect("only a model may have no tree"),
    };
    let mut complaints = Complaints::default();
    let mut topology = Topology::default();
    let machines =
        scenario.machine_processes().map(|(name, skill)| Client::new(name, scenario.machines_of(name, skill)));
    let clients = machines.chain(scenario.components.iter().filter_map(Client::of_program));
    let parts = Parts { tree, skills: &scenario.skills, components: &scenario.components };
    let places = scenario.premises.as_ref().map(|premises| &premises.places);
    let (ids, robot) = declare(&parts, &clients.collect::<Vec<_>>(), places, &mut topology).map_err(refused)?;
    let mut processes = tree_processes(scenario, tree, &mut topology, ids).map_err(refused)?;
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
            Runs::Device(settings) => {
                processes.push((id, Box::new(DeviceProcess::new(&topology, id, settings))));
            }
        }
    }
    processes.extend(builtin_components(scenario, &topology, robot).map_err(refused)?);
    let scheduler = scheduler(scenario, &topology, streams, &mut complaints);
    complaints.check()?;
    let system = ChannelSystem::new(topology, processes).map_err(refused)?;
    let scheduler = scheduler.expect("an unknown process was reported");
    Ok(Wired { system, scheduler, ids: Ids { tree: Some(ids), robot } })
}

/// Wires a model.
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
    Ok(Wired { system, scheduler, ids: Ids { tree, robot: None } })
}

impl TreeIds {
    fn declare(topology: &mut Topology) -> Result<Self, WiringError> {
        Ok(Self { tick_generator: topology.process(TICK_GENERATOR)?, tree: topology.process(TREE)? })
    }
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

/// Reports a system that cannot be wired as bad input: the message names the files by their processes.
fn refused(error: WiringError) -> Error {
    Error::bad_input(misfit(error))
}

fn misfit(error: WiringError) -> Problem {
    Problem::new(error.to_string())
        .with_help("the tree, the skills and the components must agree on their channels and messages")
}

/// The parts to be wired: the tree, the skills of its leaves, and the components from files.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) skills: &'a BTreeMap<String, Skill>,
    pub(crate) components: &'a BTreeMap<String, Component>,
}

/// A process that may ask components and read their topics.
struct Client<'a> {
    name: &'a str,
    /// All machines that it may run, which determine what it asks and reads.
    machines: Vec<&'a Arc<Chart>>,
    /// The components that a program may ask for anything, and whose topics it all reads.
    components: &'a [String],
}

impl<'a> Client<'a> {
    fn new(name: &'a str, machines: impl Iterator<Item = &'a Arc<Chart>>) -> Self {
        Self { name, machines: machines.collect(), components: &[] }
    }

    fn of_program((name, component): (&'a String, &'a Component)) -> Option<Self> {
        match &component.runs {
            Runs::Program { asks, .. } => Some(Self { name, machines: Vec::new(), components: asks }),
            Runs::Machine(_) | Runs::Device(_) => None,
        }
    }

    fn uses_all(&self, component: &str) -> bool {
        self.components.iter().any(|used| used == component)
    }

    /// The first symbols of its messages to a process.
    fn asks(&self, component: &str) -> Vec<&'a str> {
        let messages = self.machines.iter().flat_map(|chart| chart.channel_messages());
        messages.filter(|(to, _)| *to == component).map(|(_, head)| head).collect()
    }

    /// Whether it has a transition for a message of another process.
    fn reads(&self, component: &str, head: &str) -> bool {
        let event = format!("{component}.{head}");
        self.machines.iter().any(|chart| chart.names(&event))
    }
}

/// Records all problems of skills and components that do not fit together or do not fit the tree. Leaves whose machines
/// could not be loaded are reported elsewhere. Without `places`, there is no robot. Returns the places to which skills
/// always drive, each with one such skill.
pub(crate) fn check_machines(
    parts: &Parts<'_>,
    places: Option<&Places>,
    complaints: &mut Complaints,
) -> BTreeMap<String, String> {
    let mut topology = Topology::default();
    let of_components = parts.components.iter().filter_map(|(name, component)| Some((name, component.machine()?)));
    let machines: Vec<(&String, &Skill)> = parts.skills.iter().chain(of_components).collect();
    let clients = machines.iter().map(|&(name, skill)| Client::new(name, std::iter::once(&skill.machine)));
    let clients: Vec<Client<'_>> = clients.chain(parts.components.iter().filter_map(Client::of_program)).collect();
    // A leaf with the name of a component is reported elsewhere.
    if parts.tree.leaves().any(|leaf| parts.components.contains_key(leaf.process())) {
        return BTreeMap::new();
    }
    if let Err(error) = declare(parts, &clients, places, &mut topology) {
        complaints.push(misfit(error));
        return BTreeMap::new();
    }
    for (name, Component { interface, .. }) in parts.components {
        for client in &clients {
            let asked = client.asks(name);
            let used = interface.restricted_to(|operation| match operation {
                interfaces::Operation::Service(service) => asked.contains(&service.name.as_str()),
                _ => false,
            });
            if let Err(problem) = used.replies() {
                complaints.push(problem);
            }
        }
    }
    let leaves = parts.tree.leaves().filter(|leaf| parts.skills.contains_key(leaf.process()));
    let leaves = leaves.map(|leaf| LeafOfSystem { name: leaf.process(), is_halted: leaf.kind() == bt::Kind::Action });
    let leaves: Vec<LeafOfSystem<'_>> = leaves.collect();
    let data: Vec<Vec<(&str, Datum)>> =
        machines.iter().map(|(_, skill)| skill.data_of(&skill.machine).collect()).collect();
    let machines: Vec<SkillOfSystem<'_>> =
        machines.iter().zip(&data).map(|((name, skill), data)| (name.as_str(), &skill.machine, &data[..])).collect();
    for error in check_system(&leaves, &machines, &topology) {
        complaints.push(error);
    }
    let mut driven_to = BTreeMap::new();
    for (name, machine, data) in machines {
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
/// is no robot, and therefore none of its components.
fn declare(
    parts: &Parts<'_>,
    clients: &[Client<'_>],
    places: Option<&Places>,
    topology: &mut Topology,
) -> Result<(TreeIds, Option<Processes>), WiringError> {
    let tree = TreeIds::declare(topology)?;
    for name in parts.tree.leaves().map(|leaf| leaf.process()).collect::<BTreeSet<_>>() {
        topology.process(name)?;
    }
    // Only the skills of the paper's published system take turns in navigating.
    let takes_turns = clients.iter().any(|client| !client.asks(BLACKBOARD).is_empty());
    let of_robot = BUILTIN.into_iter().filter(|_| places.is_some());
    let builtin = of_robot.chain(takes_turns.then_some(BLACKBOARD));
    let builtin: Vec<&str> = builtin.filter(|name| !parts.components.contains_key(*name)).collect();
    let components = builtin.iter().copied().chain(parts.components.keys().map(String::as_str));
    let components: Vec<(&str, ProcessId)> =
        components.map(|name| Ok((name, topology.process(name)?))).collect::<Result<_, WiringError>>()?;
    bt::declare_channels(parts.tree, topology, tree.tree, tree.tick_generator)?;
    let operations = operations(places.unwrap_or(&Places::default()));
    let mut lines = Lines::default();
    for (name, component) in components {
        let offers: Vec<Offer> = match parts.components.get(name) {
            Some(Component { interface, .. }) => {
                interface.topics.iter().for_each(|topic| topology.publish(component, topic.message()));
                interface.requests().into_iter().for_each(|request| topology.understand(component, request));
                Offer::of_interface(interface)
            }
            None => operations.iter().filter(|operation| operation.component == name).map(Offer::from).collect(),
        };
        for client in clients.iter().filter(|client| client.name != name) {
            let id = topology.find_process(client.name).expect("every machine's process has just been declared");
            declare_offers(client, id, name, component, &offers, &mut lines);
        }
    }
    lines.declare(topology)?;
    let id = |name| topology.find_process(name).expect("it has just been declared, or a component has its name");
    let robot = places.map(|_| Processes {
        battery_reader: id(BATTERY_READER),
        localization: id(LOCALIZATION),
        navigation: id(NAVIGATION),
    });
    Ok((tree, robot))
}

/// Something that a component does for others: the messages that they send and receive.
struct Offer {
    requests: Vec<Shape>,
    replies: Vec<Shape>,
}

impl From<&Operation> for Offer {
    fn from(operation: &Operation) -> Self {
        Self { requests: vec![operation.request.clone()], replies: operation.replies.clone() }
    }
}

impl Offer {
    fn of_interface(interface: &Interface) -> Vec<Self> {
        let services = interface
            .services
            .iter()
            .map(|service| Self { requests: vec![service.request()], replies: service.replies().to_vec() });
        let actions = interface
            .actions
            .iter()
            .map(|action| Self { requests: action.requests().to_vec(), replies: action.answers().to_vec() });
        let topics = interface.topics.iter().map(|topic| Self { requests: Vec::new(), replies: vec![topic.message()] });
        services.chain(actions).chain(topics).collect()
    }

    /// Whether one of these messages begins with the symbol.
    fn has(shapes: &[Shape], head: &str) -> bool {
        shapes.iter().flat_map(Shape::heads).any(|symbol| symbol.name() == head)
    }
}

/// The channels to be declared, with their messages, in the order in which their first messages are known.
#[derive(Default)]
struct Lines(Vec<((ProcessId, ProcessId), Vec<Shape>)>);

impl Lines {
    /// Adds messages to a channel, each shape once.
    fn add<'s>(&mut self, from: ProcessId, to: ProcessId, shapes: impl Iterator<Item = &'s Shape>) {
        let index = self.0.iter().position(|(ends, _)| *ends == (from, to)).unwrap_or_else(|| {
            self.0.push(((from, to), Vec::new()));
            self.0.len() - 1
        });
        let known = &mut self.0[index].1;
        for shape in shapes {
            if !known.contains(shape) {
                known.push(shape.clone());
            }
        }
    }

    fn declare(self, topology: &mut Topology) -> Result<(), WiringError> {
        for ((from, to), shapes) in self.0 {
            topology.channel(from, to, Capacity::One, Domain::new(shapes))?;
        }
        Ok(())
    }
}

/// The channels between a component and a client. They carry only the client's requests (with any machine that a fault
/// may give it), the answers to these, and the topics that it reads.
fn declare_offers(
    client: &Client<'_>,
    id: ProcessId,
    name: &str,
    component: ProcessId,
    offers: &[Offer],
    lines: &mut Lines,
) {
    let asked = client.asks(name);
    // Requests that the component does not understand are refused by the machine's own check, at their locations in the
    // file and with all known requests.
    let is_offered = |head: &&str| offers.iter().any(|offer| Offer::has(&offer.requests, head));
    let uses_all = client.uses_all(name);
    let asks_all = !asked.iter().all(is_offered);
    let is_used = |offer: &&Offer| {
        asked.iter().any(|head| asks_all && !offer.requests.is_empty() || Offer::has(&offer.requests, head))
    };
    let is_read = |offer: &&Offer| {
        let heads = || offer.replies.iter().flat_map(Shape::heads);
        offer.requests.is_empty() && heads().any(|head| client.reads(name, head.name()))
    };
    let used: Vec<&Offer> = offers.iter().filter(|offer| uses_all || is_used(offer) || is_read(offer)).collect();
    if !asked.is_empty() || uses_all && offers.iter().any(|offer| !offer.requests.is_empty()) {
        lines.add(id, component, used.iter().flat_map(|offer| &offer.requests));
    }
    if !used.is_empty() {
        lines.add(component, id, used.iter().flat_map(|offer| &offer.replies));
    }
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
    let id = topology.find_process(&victim.value);
    if id.is_none() {
        let names: Vec<&str> = topology.processes().map(|id| topology.name(id)).collect();
        complaints.push(unknown("process", victim, names));
    }
    Some(Box::new(Starving::new(id?, others)))
}

#[cfg(test)]
#[path = "../../channels/tests/system/lockstep.rs"]
mod lockstep;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::lockstep::Lockstep;
    use super::*;
    use crate::scenario::find;

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
        let lift = Path::new(env!("CARGO_MANIFEST_DIR")).join("roaml/tests/models/lift");
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
