//! The processes and channels of a scenario: which component a skill asks, and with which messages.

use std::collections::{BTreeMap, BTreeSet};
use std::ptr;
use std::sync::Arc;

use bt::Tree;
use channels::{Capacity, Domain, Process, ProcessId, Shape, Topology, Use, Value, WiringError};
use components::{BATTERY_READER, BLACKBOARD, LOCALIZATION, NAVIGATION, Processes, operations};
use diagnostics::{Problem, nearest_or_all};
use interfaces::Interface;
use maps::Places;
use recording::TREE;
use remote::Offered;
use skills::{Chart, Datum, LeafOfSystem, SkillError, SkillOfSystem, SkillProcess, check_system};

use super::leaves::entry_of;
use super::offer::Offer;
use super::{Behavior, Component, LeafEntry, Runs, Scenario, Skill};
use crate::error::Complaints;
use crate::processes::{BUILTIN, ROS, TICK_GENERATOR};

/// The tree and what generates its ticks.
#[derive(Clone, Copy, Debug)]
pub struct TreeIds {
    /// The process that generates ticks.
    pub tick_generator: ProcessId,
    /// The tree.
    pub tree: ProcessId,
}

impl TreeIds {
    /// Declares the two processes.
    ///
    /// # Errors
    /// [`WiringError`] if there are already processes with these names.
    pub fn declare(topology: &mut Topology) -> Result<Self, WiringError> {
        Ok(Self { tick_generator: topology.process(TICK_GENERATOR)?, tree: topology.process(TREE)? })
    }
}

impl Scenario {
    /// Declares all processes except the tree's nodes, and all channels except those between nodes: of the tree, and of
    /// the robot's components if there is a robot. A model declares its own. If components are `offered` to nodes of
    /// ROS 2, the process [`ROS`] stands for these, with channels to and from each of the components.
    ///
    /// # Errors
    /// [`WiringError`] if two parts do not fit together.
    pub fn declare(
        &self,
        tree: &Tree,
        offered: &[Offered],
        topology: &mut Topology,
    ) -> Result<(TreeIds, Option<Processes>), WiringError> {
        self.declare_for(tree, offered, &[], topology)
    }

    /// The processes, with every channel and message that their machines could use; nothing for a model.
    #[must_use]
    pub fn possible_channels(&self) -> Option<Topology> {
        let Behavior::Tree(tree) = &self.behavior else { return None };
        let all: Vec<String> = self.component_names().map(str::to_owned).collect();
        let mut topology = Topology::default();
        self.declare_for(tree, &[], &all, &mut topology).ok()?;
        Some(topology)
    }

    /// What components offer to leaves, each by its name, `COMPONENT.NAME`.
    #[must_use]
    pub fn offers(&self) -> Vec<(String, Offer)> {
        let Behavior::Tree(tree) = &self.behavior else { return Vec::new() };
        let places = self.premises.as_ref().map(|premises| &premises.places);
        let offers = offers(&self.parts(tree), &[], places).into_iter();
        let named = |(component, offers): (&str, Vec<Offer>)| {
            let name = |offer: Offer| (format!("{component}.{}", offer.name), offer);
            offers.into_iter().map(name).collect::<Vec<_>>()
        };
        offers.flat_map(named).collect()
    }

    fn parts<'s>(&'s self, tree: &'s Tree) -> Parts<'s> {
        Parts { tree, leaves: &self.file.leaves, skills: &self.skills, components: &self.components }
    }

    /// Declares the processes and channels if the machines also use all that these components offer.
    fn declare_for(
        &self,
        tree: &Tree,
        offered: &[Offered],
        used: &[String],
        topology: &mut Topology,
    ) -> Result<(TreeIds, Option<Processes>), WiringError> {
        let machine = |(name, skill)| Client { components: used, ..Client::new(name, self.machines_of(name, skill)) };
        let machines = self.machine_processes().map(machine);
        let clients: Vec<Client<'_>> = machines.chain(self.components.iter().filter_map(Client::of_program)).collect();
        let offered: Vec<String> = offered.iter().map(|(name, _)| name.clone()).collect();
        let outside = Client { name: ROS, machines: Vec::new(), components: &offered };
        let outside = (!offered.is_empty()).then_some(outside);
        let places = self.premises.as_ref().map(|premises| &premises.places);
        declare(&self.parts(tree), (&clients, outside), places, topology)
    }
}

/// The problem of parts that cannot be wired: the message names the files by their processes.
#[must_use]
pub fn misfit(error: &WiringError) -> Problem {
    Problem::new(error.to_string())
        .with_help("the tree, the skills and the components must agree on their channels and messages")
}

/// The parts to be wired: the tree, the skills of its leaves, and the components from files.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) leaves: &'a [LeafEntry],
    pub(crate) skills: &'a BTreeMap<String, Skill>,
    pub(crate) components: &'a BTreeMap<String, Component>,
}

/// A process that may ask components and read their topics.
struct Client<'a> {
    name: &'a str,
    /// All machines that it may run, which determine what it asks and reads.
    machines: Vec<&'a Arc<Chart>>,
    /// The components that it may ask for anything, and whose topics it all reads: those that a program names.
    components: &'a [String],
}

impl<'a> Client<'a> {
    fn new(name: &'a str, machines: impl Iterator<Item = &'a Arc<Chart>>) -> Self {
        Self { name, machines: machines.collect(), components: &[] }
    }

    fn of_program((name, component): (&'a String, &'a Component)) -> Option<Self> {
        match &component.runs {
            Runs::Program { asks, .. } => Some(Self { name, machines: Vec::new(), components: asks }),
            Runs::Machine(_) | Runs::Remote(_) | Runs::Device(_) => None,
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
    if let Err(error) = declare(parts, (&clients, None), places, &mut topology) {
        complaints.push(misfit(&error));
        return BTreeMap::new();
    }
    check_replies(parts.components, &clients, complaints);
    let unfit = check_entries(parts, &offers(parts, &clients, places), complaints);
    let machines: Vec<(&String, &Skill)> =
        machines.into_iter().filter(|(name, _)| !unfit.contains(name.as_str())).collect();
    let leaves = parts.tree.leaves().filter(|leaf| parts.skills.contains_key(leaf.process()));
    let leaves = leaves.filter(|leaf| !unfit.contains(leaf.process()));
    let leaves = leaves.map(|leaf| LeafOfSystem { name: leaf.process(), is_halted: leaf.kind() == bt::Kind::Action });
    let leaves: Vec<LeafOfSystem<'_>> = leaves.collect();
    let data: Vec<Vec<(&str, Datum)>> =
        machines.iter().map(|(_, skill)| skill.data_of(&skill.machine).collect()).collect();
    let machines: Vec<SkillOfSystem<'_>> =
        machines.iter().zip(&data).map(|((name, skill), data)| (name.as_str(), &skill.machine, &data[..])).collect();
    let mut misspelled = Vec::new();
    for error in check_system(&leaves, &machines, &topology) {
        match places.and_then(|places| misspelled_place(parts, places, &machines, &topology, &error)) {
            Some(MisspelledPlace { problem, is_in_tree: true }) => misspelled.push(problem),
            Some(MisspelledPlace { problem, is_in_tree: false }) => complaints.push(problem),
            None => complaints.push(error),
        }
    }
    if !misspelled.is_empty() {
        complaints.push(parts.tree.error(&misspelled));
    }
    driven_to(&machines, &topology)
}

/// A place that the tree or the scenario gives to a machine, and that does not exist.
struct MisspelledPlace {
    problem: Problem,
    is_in_tree: bool,
}

/// The reason why a machine does not fit, if that is only a value that its leaf gives it: with the name of a place
/// instead, it fits. The value is wrong and not the machine, which may be by another author.
fn misspelled_place(
    parts: &Parts<'_>,
    places: &Places,
    machines: &[SkillOfSystem<'_>],
    topology: &Topology,
    error: &SkillError,
) -> Option<MisspelledPlace> {
    let SkillError::Wiring { process, .. } = error else { return None };
    let (name, machine, data) = *machines.iter().find(|(name, ..)| name == process)?;
    let leaf = parts.tree.leaves().find(|leaf| leaf.process() == process.as_str())?;
    let known = || places.iter().map(|(name, _)| name);
    data.iter().find_map(|(id, datum)| {
        let Datum::Text(written) = datum else { return None };
        let with = |place: &str| {
            data.iter()
                .map(|(other, datum)| (*other, if other == id { Datum::text(place) } else { datum.clone() }))
                .collect::<Vec<_>>()
        };
        let fits = |place: &str| SkillProcess::new(name, machine, topology, with(place)).is_ok();
        if known().any(|place| place == &**written) || !known().any(fits) {
            return None;
        }
        let message = format!("there is no place `{written}`, to which the machine of `{process}` drives");
        let help = nearest_or_all(written, "places", &known().collect::<Vec<_>>());
        let entry = entry_of(parts.leaves, leaf).and_then(|entry| entry.data.iter().find(|(set, _)| set.value == *id));
        let is_in_tree = entry.is_none();
        let problem = match entry {
            Some((set, _)) => set.span.problem(message).with_label("this place").with_help(help),
            None => parts.tree.problem_at(leaf.id(), message, format!("its `{id}`"), help),
        };
        Some(MisspelledPlace { problem, is_in_tree })
    })
}

/// Reports entries of the table `leaves` that ask what no component offers. Returns the processes of their leaves,
/// whose machines are generated: what is wrong with these would be reported in terms of their SCXML.
fn check_entries<'p>(
    parts: &Parts<'p>,
    offers: &[(&str, Vec<Offer>)],
    complaints: &mut Complaints,
) -> BTreeSet<&'p str> {
    let mut unfit = BTreeSet::new();
    for entry in parts.leaves {
        let is_of = |leaf: &&bt::Node| entry_of(parts.leaves, leaf).is_some_and(|of| ptr::eq(of, entry));
        let leaves: Vec<&bt::Node> = parts.tree.leaves().filter(is_of).collect();
        let Some(asking) = entry.asking.as_ref().filter(|_| !leaves.is_empty()) else { continue };
        let fits = asking.check(offers, complaints);
        // Several leaves may be the same node of the tree's file.
        let mut reported = BTreeSet::new();
        for leaf in leaves {
            let misfits = asking.port_misfits(parts.tree, leaf, offers);
            if !asking.check_ports(parts.tree, leaf, complaints) || !misfits.is_empty() || !fits {
                unfit.insert(leaf.process());
            }
            let new = misfits.into_iter().filter(|problem| reported.insert(problem.one_line()));
            new.for_each(|problem| complaints.push(problem));
        }
    }
    unfit
}

/// Reports services of a component whose replies look alike to a client that asks both.
fn check_replies(components: &BTreeMap<String, Component>, clients: &[Client<'_>], complaints: &mut Complaints) {
    for (name, Component { interface, .. }) in components {
        for client in clients {
            let asked = client.asks(name);
            // Other replies cannot be confused.
            let used = interface.restricted_to(|operation| match operation {
                interfaces::Operation::Service(service) => asked.contains(&service.name.as_str()),
                _ => false,
            });
            if let Err(problem) = used.replies() {
                complaints.push(problem);
            }
        }
    }
}

/// The places to which machines always drive, each with one such machine.
fn driven_to(machines: &[SkillOfSystem<'_>], topology: &Topology) -> BTreeMap<String, String> {
    let mut driven_to = BTreeMap::new();
    for &(name, machine, data) in machines {
        let Ok(skill) = SkillProcess::new(name, machine, topology, data.iter().cloned()) else { continue };
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

/// What each component offers, the built-in ones first. Without `places`, there is no robot, and therefore none of its
/// components.
fn offers<'p>(parts: &Parts<'p>, clients: &[Client<'_>], places: Option<&Places>) -> Vec<(&'p str, Vec<Offer>)> {
    // Only the skills of the paper's published system take turns in navigating.
    let takes_turns = clients.iter().any(|client| !client.asks(BLACKBOARD).is_empty());
    let builtin = BUILTIN.into_iter().filter(|_| places.is_some());
    let builtin = builtin.chain(takes_turns.then_some(BLACKBOARD));
    let operations = operations(places.unwrap_or(&Places::default()));
    let builtin = builtin.filter(|name| !parts.components.contains_key(*name)).map(|name| {
        let own = operations.iter().filter(|operation| operation.component == name);
        (name, own.map(Offer::from).collect())
    });
    let components = parts.components.iter();
    builtin.chain(components.map(|(name, component)| (name.as_str(), Offer::all(&component.interface)))).collect()
}

/// Declares all processes except the tree's nodes, and all channels except those between nodes. Without `places`, there
/// is no robot, and therefore none of its components. The last client is no process of the scenario.
fn declare(
    parts: &Parts<'_>,
    (clients, outside): (&[Client<'_>], Option<Client<'_>>),
    places: Option<&Places>,
    topology: &mut Topology,
) -> Result<(TreeIds, Option<Processes>), WiringError> {
    let tree = TreeIds::declare(topology)?;
    for name in parts.tree.leaves().map(|leaf| leaf.process()).collect::<BTreeSet<_>>() {
        topology.process(name)?;
    }
    let offers = offers(parts, clients, places);
    let components = offers.into_iter().map(|(name, offers)| Ok((name, topology.process(name)?, offers)));
    let components: Vec<(&str, ProcessId, Vec<Offer>)> = components.collect::<Result<_, WiringError>>()?;
    if let Some(Client { name, .. }) = outside {
        topology.process(name)?;
    }
    bt::declare_channels(parts.tree, topology, tree.tree, tree.tick_generator)?;
    let mut lines = Lines::default();
    for (name, component, offers) in components {
        if let Some(Component { interface, .. }) = parts.components.get(name) {
            declare_interface(interface, component, topology);
        }
        for client in clients.iter().chain(&outside).filter(|client| client.name != name) {
            let id = topology.find_process(client.name).expect("every client's process has just been declared");
            declare_offers(client, id, name, component, &offers, &mut lines);
        }
    }
    lines.declare(topology)?;
    Ok((tree, places.map(|_| of_robot(topology))))
}

fn of_robot(topology: &Topology) -> Processes {
    let id = |name| topology.find_process(name).expect("it has just been declared, or a component has its name");
    Processes { battery_reader: id(BATTERY_READER), localization: id(LOCALIZATION), navigation: id(NAVIGATION) }
}

/// Declares what a component with this interface publishes and understands.
fn declare_interface(interface: &Interface, component: ProcessId, topology: &mut Topology) {
    interface.topics.iter().for_each(|topic| topology.publish(component, topic.message()));
    interface.requests().into_iter().for_each(|request| topology.understand(component, request));
    let replies = interface.services.iter().flat_map(|service| service.replies().to_vec());
    let replies = replies.chain(interface.actions.iter().flat_map(|action| action.answers().to_vec()));
    replies.for_each(|answer| topology.answer(component, answer));
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
    // file and with all known requests: the channel then carries all of them.
    let is_offered = |head: &&str| offers.iter().any(|offer| Offer::has(&offer.requests, head));
    let uses_all = client.uses_all(name);
    let asks_unknown = !asked.iter().all(is_offered);
    let is_used = |offer: &&Offer| {
        asked.iter().any(|head| asks_unknown && !offer.requests.is_empty() || Offer::has(&offer.requests, head))
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
