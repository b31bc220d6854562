//! Turns a model into the processes and channels of a system.

mod adapter;
mod clock;

use std::collections::BTreeMap;
use std::sync::Arc;

use channels::{Capacity, ChannelId, Domain, FieldKind, Process, ProcessId, Shape, Subscriber, Topology, WiringError};
use rand::RngExt;
use robot::Streams;
use skills::SkillProcess;

use adapter::{AdapterWiring, Incoming, LeafConnection, RosAdapter, Route};
use clock::{Clock, ClockWiring, Timer};

use crate::instance::{CLOCK, CLOCK_EVENT, Fields, MachineProcess, RECORDER, events, machine_processes};
use crate::machine::{Role, Way};
use crate::model::Model;

/// The declared channels of a model, as its processes need them.
#[derive(Debug)]
pub struct Wiring<'m> {
    model: &'m Model,
    processes: Vec<MachineProcess<'m>>,
    /// The process of the tree, if the model has one.
    tree: Option<ProcessId>,
    /// By process.
    ids: Vec<ProcessId>,
    clock: ProcessId,
    recorder: ProcessId,
    events: Arc<BTreeMap<String, Fields>>,
    timers: Vec<(usize, String, u64)>,
    /// By process.
    ways: Vec<Ways>,
}

/// The receivers of each event that a process sends, as indices of processes. The position of a receiver is its number.
type Ways = BTreeMap<String, (Way, Vec<usize>)>;

impl<'m> Wiring<'m> {
    /// Declares the processes that run a model's machines, its clock and its recorder, and their channels. `tree` are
    /// the processes of its ticks and of its tree, if it has one.
    ///
    /// # Errors
    /// [`WiringError`] if the model's parts do not fit together.
    pub fn declare(
        model: &'m Model,
        topology: &mut Topology,
        tree: Option<(ProcessId, ProcessId)>,
    ) -> Result<Self, WiringError> {
        let processes = machine_processes(&model.machines);
        let ids = processes.iter().map(|process| topology.process(&process.name)).collect::<Result<Vec<_>, _>>()?;
        let (clock, recorder) = (topology.process(CLOCK)?, topology.process(RECORDER)?);
        if let (Some((ticks, bt)), Some(tree)) = (tree, &model.tree) {
            bt::declare_channels(tree, topology, bt, ticks)?;
        }
        let events = Arc::new(events(&model.machines));
        let tree = tree.map(|(_, tree)| tree);
        let mut wiring =
            Self { model, processes, tree, ids, clock, recorder, events, timers: Vec::new(), ways: Vec::new() };
        wiring.ways = wiring.ways();
        wiring.timers = wiring.timers();
        wiring.declare_channels(topology)?;
        Ok(wiring)
    }

    /// The processes. `streams` determine what machines leave to chance.
    #[must_use]
    pub fn processes(&self, topology: &Topology, streams: &Streams) -> Vec<(ProcessId, Box<dyn Process>)> {
        let recorded = self.recorded();
        let mut processes: Vec<(ProcessId, Box<dyn Process>)> = Vec::new();
        for (index, process) in self.processes.iter().enumerate() {
            let adapter = RosAdapter::new(Arc::new(self.adapter_wiring(index, topology, &recorded)));
            let mut machine = skills::Machine::new(Arc::clone(&process.machine.chart));
            machine.set_seed(streams.stream(&format!("roaml/{}", process.name)).random());
            let skill = SkillProcess::connected(&process.name, machine, adapter);
            processes.push((self.ids[index], Box::new(skill)));
        }
        processes.push((self.clock, Box::new(Clock::new(self.clock_wiring(topology)))));
        processes.push((self.recorder, Box::new(Subscriber::new(topology, self.recorder))));
        processes
    }

    fn recorded(&self) -> Vec<&'m str> {
        self.model.recorded().collect()
    }

    fn ways(&self) -> Vec<Ways> {
        let ways = |(index, process): (usize, &MachineProcess<'_>)| {
            let ways = process.machine.sends.iter().map(|(event, sent)| {
                let receivers = self.receivers(index, event, sent.way, sent.interface.as_deref());
                (event.clone(), (sent.way, receivers))
            });
            ways.collect()
        };
        self.processes.iter().enumerate().map(ways).collect()
    }

    fn receivers(&self, sender: usize, event: &str, way: Way, interface: Option<&str>) -> Vec<usize> {
        let family = |index: usize| self.processes[index].thread.map_or(index, |(own, _)| own);
        let all = 0..self.processes.len();
        match way {
            Way::Everyone => all.filter(|index| *index != sender && self.receives(*index, event)).collect(),
            Way::Request | Way::Goal => {
                all.filter(|index| family(*index) != family(sender) && self.receives(*index, event)).collect()
            }
            Way::Response => self.clients(Role::Client, interface),
            Way::Client => self.clients(Role::ActionClient, interface),
            Way::Thread => all
                .filter(|index| self.processes[*index].thread.is_some_and(|(own, _)| own == family(sender)))
                .collect(),
            Way::Server => vec![family(sender)],
        }
    }

    fn receives(&self, process: usize, event: &str) -> bool {
        self.processes[process].machine.chart.handles(event)
    }

    /// The processes that use an interface in this role, in order.
    fn clients(&self, role: Role, interface: Option<&str>) -> Vec<usize> {
        let same =
            |name: &str| interface.is_some_and(|other| name.trim_start_matches('/') == other.trim_start_matches('/'));
        let uses = |process: &MachineProcess<'_>| {
            process.thread.is_none()
                && process.machine.interfaces.iter().any(|known| known.role == role && same(&known.name))
        };
        (0..self.processes.len()).filter(|index| uses(&self.processes[*index])).collect()
    }

    /// The events that pass between processes, by sender and receiver.
    fn carried(&self) -> BTreeMap<(ProcessId, ProcessId), Vec<String>> {
        let recorded = self.recorded();
        // In order, so that channels get the same numbers in every build.
        let mut carried: BTreeMap<(ProcessId, ProcessId), Vec<String>> = BTreeMap::new();
        let mut carry = |from, to, event: &str| carried.entry((from, to)).or_default().push(event.to_owned());
        for (sender, ways) in self.ways.iter().enumerate() {
            for (event, (_, receivers)) in ways {
                for receiver in receivers {
                    carry(self.ids[sender], self.ids[*receiver], event);
                }
                if recorded.contains(&event.as_str()) {
                    carry(self.ids[sender], self.recorder, event);
                }
            }
        }
        for index in (0..self.processes.len()).filter(|index| self.receives(*index, CLOCK_EVENT)) {
            carry(self.clock, self.ids[index], CLOCK_EVENT);
        }
        if recorded.contains(&CLOCK_EVENT) {
            carry(self.clock, self.recorder, CLOCK_EVENT);
        }
        for (index, event, _) in &self.timers {
            carry(self.clock, self.ids[*index], event);
        }
        carried
    }

    /// The timers: process, event, period.
    fn timers(&self) -> Vec<(usize, String, u64)> {
        let timers = |(index, process): (usize, &MachineProcess<'_>)| {
            let timers = process.machine.interfaces.iter().filter(|known| known.role == Role::Timer);
            let is_own = process.thread.is_none();
            let timers = timers.filter(move |_| is_own);
            timers.map(move |timer| (index, format!("timer_{}", timer.name), timer.period_ns)).collect::<Vec<_>>()
        };
        self.processes.iter().enumerate().flat_map(timers).collect()
    }

    fn declare_channels(&self, topology: &mut Topology) -> Result<(), WiringError> {
        for ((sender, receiver), events) in self.carried() {
            let shapes = events.iter().map(|event| {
                let head = ("event".to_owned(), FieldKind::Symbol(vec![channels::Symbol::new(event)]));
                let fields = self.events.get(event).into_iter().flatten();
                Shape::new([head].into_iter().chain(fields.map(|(name, kind)| (name.clone(), kind.field()))))
            });
            let capacity = if receiver == self.recorder { Capacity::Zero } else { Capacity::One };
            topology.channel(sender, receiver, capacity, Domain::new(shapes))?;
        }
        Ok(())
    }

    fn adapter_wiring(&self, index: usize, topology: &Topology, recorded: &[&str]) -> AdapterWiring {
        let (id, process) = (self.ids[index], &self.processes[index]);
        let outgoing = outgoing(topology, id);
        let route = |(event, (way, receivers)): (&String, &(Way, Vec<usize>))| {
            let receivers = receivers.iter().map(|receiver| out(topology, &outgoing, self.ids[*receiver])).collect();
            (event.clone(), Route { way: *way, receivers, is_recorded: recorded.contains(&event.as_str()) })
        };
        let channels = topology.channels().filter(|channel| topology.get(*channel).target == id);
        let incoming = channels.map(|channel| {
            // Messages of a tree whose nodes are processes come from a part of it.
            let source = topology.whole(topology.get(channel).source);
            let sender = self.ids.iter().position(|known| *known == source);
            let client = sender.map(|sender| self.numbers(sender)).unwrap_or_default();
            Incoming { channel, from_tree: Some(source) == self.tree, client }
        });
        let leaf = process.instance.leaf.filter(|_| process.thread.is_none());
        let leaf = leaf.zip(self.model.tree.as_ref()).zip(self.tree).and_then(|((leaf, of), tree)| {
            Some(LeafConnection {
                ports: process.machine.ports.clone(),
                requests: bt::request_domain(of, leaf),
                replies: bt::reply_domain(of, leaf),
                out: out(topology, &outgoing, tree)?,
            })
        });
        AdapterWiring {
            name: process.name.clone(),
            incoming: incoming.collect(),
            routes: self.ways[index].iter().map(route).collect(),
            recorder: out(topology, &outgoing, self.recorder),
            outgoing,
            events: Arc::clone(&self.events),
            leaf,
        }
    }

    /// The number of a sender among the clients of each interface that it uses, by event; for a thread, its own number.
    fn numbers(&self, sender: usize) -> BTreeMap<String, usize> {
        let number = |(event, (way, _)): (&String, &(Way, Vec<usize>))| {
            let interface = self.processes[sender].machine.sends.get(event)?.interface.as_deref();
            let role = match way {
                Way::Request => Role::Client,
                Way::Goal => Role::ActionClient,
                Way::Server => return Some((event.clone(), self.processes[sender].thread?.1)),
                _ => return None,
            };
            let number = self.clients(role, interface).iter().position(|client| *client == sender)?;
            Some((event.clone(), number))
        };
        self.ways[sender].iter().filter_map(number).collect()
    }

    fn clock_wiring(&self, topology: &Topology) -> ClockWiring {
        let outgoing = outgoing(topology, self.clock);
        let step_ns = self.timers.iter().map(|(.., period)| *period).reduce(greatest_common_divisor);
        let receivers =
            (0..self.processes.len()).filter(|index| self.receives(*index, CLOCK_EVENT)).map(|index| self.ids[index]);
        let listeners: Vec<usize> = match step_ns {
            Some(_) => receivers.chain([self.recorder]).filter_map(|id| out(topology, &outgoing, id)).collect(),
            None => Vec::new(),
        };
        let timers = self.timers.iter().filter_map(|(index, event, period_ns)| {
            let out = out(topology, &outgoing, self.ids[*index])?;
            Some(Timer { out, event: event.clone(), period_ns: *period_ns })
        });
        ClockWiring { timers: timers.collect(), listeners, step_ns: step_ns.unwrap_or_default(), outgoing }
    }
}

fn outgoing(topology: &Topology, process: ProcessId) -> Vec<ChannelId> {
    topology.channels().filter(|channel| topology.get(*channel).source == process).collect()
}

/// The index of the channel to `receiver` among those that leave a process.
fn out(topology: &Topology, outgoing: &[ChannelId], receiver: ProcessId) -> Option<usize> {
    outgoing.iter().position(|channel| topology.whole(topology.get(*channel).target) == receiver)
}

fn greatest_common_divisor(one: u64, other: u64) -> u64 {
    if other == 0 { one } else { greatest_common_divisor(other, one % other) }
}
