//! From a model to a channel system.

mod automaton;
mod clock;
mod recorder;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use bt::TreeProcess;
use channels::{
    Capacity, ChannelId, ChannelSystem, Domain, FieldKind, Process, ProcessId, Shape, TickGenerator, Topology,
    WiringError,
};
use rand::RngExt;
use robot::Streams;

pub(crate) use automaton::Automaton;
pub(crate) use automaton::nested;
use automaton::{Incoming, Leaf, Route};
pub(crate) use clock::Clock;
use clock::Timer;
use recorder::Recorder;

use crate::instance::{CLOCK, CLOCK_EVENT, Fields, Part, RECORDER, TICK_GENERATOR, events, parts};
use crate::machine::{Role, TREE, Way};
use crate::model::Model;

/// A wired model.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) system: ChannelSystem,
    pub(crate) tick_generator: Option<ProcessId>,
    pub(crate) tree: Option<ProcessId>,
    pub(crate) clock: ProcessId,
    pub(crate) recorder: ProcessId,
    pub(crate) machines: Vec<ProcessId>,
    /// The fields of the events that properties are about.
    pub(crate) events: Arc<BTreeMap<String, Fields>>,
}

/// The wiring under construction.
struct Builder<'m> {
    parts: Vec<Part<'m>>,
    topology: Topology,
    ids: Vec<ProcessId>,
    events: Arc<BTreeMap<String, Fields>>,
    /// The events on each channel between machines, by sender and receiver.
    carried: BTreeMap<(ProcessId, ProcessId), Vec<String>>,
}

impl System {
    /// Wires a model. `streams` determine what its machines leave to chance.
    ///
    /// # Errors
    /// [`WiringError`] if the model's parts do not fit together.
    pub(crate) fn new(model: &Model, streams: &Streams) -> Result<Self, WiringError> {
        let mut topology = Topology::default();
        let tick_generator = model.tree.is_some().then(|| topology.process(TICK_GENERATOR)).transpose()?;
        let tree = model.tree.is_some().then(|| topology.process(TREE)).transpose()?;
        let parts = parts(&model.machines);
        let ids = parts.iter().map(|part| topology.process(&part.name)).collect::<Result<Vec<_>, _>>()?;
        let (clock, recorder) = (topology.process(CLOCK)?, topology.process(RECORDER)?);
        if let (Some(ticks), Some(bt), Some(tree)) = (tick_generator, tree, &model.tree) {
            bt::declare_channels(tree, &mut topology, bt, ticks)?;
        }
        let events = Arc::new(events(&model.machines));
        let mut builder = Builder { parts, topology, ids, events, carried: BTreeMap::new() };
        let ways = builder.ways();
        let recorded: Vec<&str> = model.recorded().collect();
        builder.carry(&ways, &recorded, clock, recorder);
        let timers = builder.timers();
        builder.declare_channels(&timers, clock, recorder)?;
        let mut processes: Vec<(ProcessId, Box<dyn Process>)> = Vec::new();
        for (index, way) in ways.iter().enumerate() {
            let wiring = builder.wiring(index, way, &ways, &recorded, tree, recorder, model);
            let machine = skills::Machine::new(Arc::clone(&builder.parts[index].machine.chart));
            let seed = streams.stream(&format!("roaml/{}", builder.parts[index].name)).random();
            processes.push((builder.ids[index], Box::new(Automaton::new(wiring, machine, seed))));
        }
        let wiring = builder.clock(timers, clock, recorder);
        processes.push((clock, Box::new(Clock::new(wiring))));
        let (topology, ids) = (Arc::new(builder.topology), builder.ids);
        let incoming = topology.channels().filter(|channel| topology.get(*channel).target == recorder).collect();
        processes.push((recorder, Box::new(Recorder { incoming })));
        if let (Some(ticks), Some(bt), Some(of)) = (tick_generator, tree, &model.tree) {
            let channel = topology.find_channel(TICK_GENERATOR, TREE).expect("the tree's channels are declared");
            processes.push((ticks, Box::new(TickGenerator::new(channel))));
            // AS2FM waits for an answer for as long as it takes.
            let patience = model.parameters.max_time + Duration::from_secs(1);
            let process = TreeProcess::new(Arc::clone(of), &topology, TREE, TICK_GENERATOR)?;
            processes.push((bt, Box::new(process.with_leaf_timeout(patience))));
        }
        let system = ChannelSystem::new(topology, processes)?;
        Ok(Self { system, tick_generator, tree, clock, recorder, machines: ids, events: builder.events })
    }
}

/// The receivers of each event that a part sends: the indices of parts, in the order of their numbers.
type Ways = BTreeMap<String, (Way, Vec<usize>)>;

impl Builder<'_> {
    /// By part.
    fn ways(&self) -> Vec<Ways> {
        let ways = |(index, part): (usize, &Part<'_>)| {
            let ways = part.machine.sends.iter().map(|(event, sent)| {
                let receivers = self.receivers(index, event, sent.way, sent.interface.as_deref());
                (event.clone(), (sent.way, receivers))
            });
            ways.collect()
        };
        self.parts.iter().enumerate().map(ways).collect()
    }

    fn receivers(&self, sender: usize, event: &str, way: Way, interface: Option<&str>) -> Vec<usize> {
        let family = |index: usize| self.parts[index].thread.map_or(index, |(own, _)| own);
        let all = 0..self.parts.len();
        match way {
            Way::Everyone => all.filter(|index| *index != sender && self.hears(*index, event)).collect(),
            Way::Request | Way::Goal => {
                all.filter(|index| family(*index) != family(sender) && self.hears(*index, event)).collect()
            }
            Way::Response => self.clients(Role::Client, interface),
            Way::Client => self.clients(Role::ActionClient, interface),
            Way::Thread => {
                all.filter(|index| self.parts[*index].thread.is_some_and(|(own, _)| own == family(sender))).collect()
            }
            Way::Server => vec![family(sender)],
        }
    }

    fn hears(&self, part: usize, event: &str) -> bool {
        self.parts[part].machine.chart.hears(event)
    }

    /// The parts that use an interface in this role, in order.
    fn clients(&self, role: Role, interface: Option<&str>) -> Vec<usize> {
        let same =
            |name: &str| interface.is_some_and(|other| name.trim_start_matches('/') == other.trim_start_matches('/'));
        let uses = |part: &Part<'_>| {
            part.thread.is_none() && part.machine.interfaces.iter().any(|known| known.role == role && same(&known.name))
        };
        (0..self.parts.len()).filter(|index| uses(&self.parts[*index])).collect()
    }

    /// Notes which events pass between which processes.
    fn carry(&mut self, ways: &[Ways], recorded: &[&str], clock: ProcessId, recorder: ProcessId) {
        for (sender, ways) in ways.iter().enumerate() {
            for (event, (_, receivers)) in ways {
                for receiver in receivers {
                    self.carried.entry((self.ids[sender], self.ids[*receiver])).or_default().push(event.clone());
                }
                if recorded.contains(&event.as_str()) {
                    self.carried.entry((self.ids[sender], recorder)).or_default().push(event.clone());
                }
            }
        }
        let hearing: Vec<usize> = (0..self.parts.len()).filter(|index| self.hears(*index, CLOCK_EVENT)).collect();
        for index in hearing {
            self.carried.entry((clock, self.ids[index])).or_default().push(CLOCK_EVENT.to_owned());
        }
        if recorded.contains(&CLOCK_EVENT) {
            self.carried.entry((clock, recorder)).or_default().push(CLOCK_EVENT.to_owned());
        }
    }

    /// The timers: part, event, period.
    fn timers(&self) -> Vec<(usize, String, u64)> {
        let timers = |(index, part): (usize, &Part<'_>)| {
            let timers = part.machine.interfaces.iter().filter(|known| known.role == Role::Timer);
            let is_own = part.thread.is_none();
            let timers = timers.filter(move |_| is_own);
            timers.map(move |timer| (index, format!("timer_{}", timer.name), timer.period_ns)).collect::<Vec<_>>()
        };
        self.parts.iter().enumerate().flat_map(timers).collect()
    }

    fn declare_channels(
        &mut self,
        timers: &[(usize, String, u64)],
        clock: ProcessId,
        recorder: ProcessId,
    ) -> Result<(), WiringError> {
        for (index, event, _) in timers {
            self.carried.entry((clock, self.ids[*index])).or_default().push(event.clone());
        }
        for ((sender, receiver), events) in &self.carried {
            let shapes = events.iter().map(|event| {
                let head = ("event".to_owned(), FieldKind::Symbol(vec![channels::Symbol::new(event)]));
                let fields = self.events.get(event).into_iter().flatten();
                Shape::new([head].into_iter().chain(fields.map(|(name, kind)| (name.clone(), kind.field()))))
            });
            let capacity = if *receiver == recorder { Capacity::Zero } else { Capacity::One };
            self.topology.channel(*sender, *receiver, capacity, Domain::new(shapes))?;
        }
        Ok(())
    }

    fn outgoing(&self, process: ProcessId) -> Vec<ChannelId> {
        self.topology.channels().filter(|channel| self.topology.get(*channel).source == process).collect()
    }

    /// The index of the channel to `receiver` among those that leave a process.
    fn out(&self, outgoing: &[ChannelId], receiver: ProcessId) -> Option<usize> {
        outgoing.iter().position(|channel| self.topology.get(*channel).target == receiver)
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of a system that one of its processes touches")]
    fn wiring(
        &self,
        index: usize,
        own: &Ways,
        ways: &[Ways],
        recorded: &[&str],
        tree: Option<ProcessId>,
        recorder: ProcessId,
        model: &Model,
    ) -> automaton::Wiring {
        let (id, part) = (self.ids[index], &self.parts[index]);
        let outgoing = self.outgoing(id);
        let route = |(event, (way, receivers)): (&String, &(Way, Vec<usize>))| {
            let receivers = receivers.iter().map(|receiver| self.out(&outgoing, self.ids[*receiver])).collect();
            (event.clone(), Route { way: *way, receivers, is_recorded: recorded.contains(&event.as_str()) })
        };
        let channels = self.topology.channels().filter(|channel| self.topology.get(*channel).target == id);
        let incoming = channels.map(|channel| {
            let source = self.topology.get(channel).source;
            let sender = self.ids.iter().position(|known| *known == source);
            let client = sender.map(|sender| self.numbers(sender, &ways[sender])).unwrap_or_default();
            Incoming { channel, from_tree: Some(source) == tree, client }
        });
        let incoming = incoming.collect();
        let leaf = part.instance.leaf.filter(|_| part.thread.is_none()).zip(model.tree.as_ref()).zip(tree);
        let leaf = leaf.and_then(|((leaf, of), tree)| {
            Some(Leaf {
                ports: part.machine.ports.clone(),
                requests: bt::request_domain(of, leaf),
                replies: bt::reply_domain(of, leaf),
                out: self.out(&outgoing, tree)?,
            })
        });
        automaton::Wiring {
            name: part.name.clone(),
            incoming,
            routes: own.iter().map(route).collect(),
            recorder: self.out(&outgoing, recorder),
            outgoing,
            events: Arc::clone(&self.events),
            leaf,
        }
    }

    /// The number of a sender among the clients of each interface that it uses, by event; of a thread, its own.
    fn numbers(&self, sender: usize, ways: &Ways) -> BTreeMap<String, usize> {
        let number = |(event, (way, _)): (&String, &(Way, Vec<usize>))| {
            let interface = self.parts[sender].machine.sends.get(event)?.interface.as_deref();
            let role = match way {
                Way::Request => Role::Client,
                Way::Goal => Role::ActionClient,
                Way::Server => return Some((event.clone(), self.parts[sender].thread?.1)),
                _ => return None,
            };
            let number = self.clients(role, interface).iter().position(|client| *client == sender)?;
            Some((event.clone(), number))
        };
        ways.iter().filter_map(number).collect()
    }

    fn clock(&self, timers: Vec<(usize, String, u64)>, clock: ProcessId, recorder: ProcessId) -> clock::Wiring {
        let outgoing = self.outgoing(clock);
        let step_ns = timers.iter().map(|(.., period)| *period).reduce(greatest_common_divisor);
        let hearing =
            (0..self.parts.len()).filter(|index| self.hears(*index, CLOCK_EVENT)).map(|index| self.ids[index]);
        let listeners: Vec<usize> = match step_ns {
            Some(_) => hearing.chain([recorder]).filter_map(|id| self.out(&outgoing, id)).collect(),
            None => Vec::new(),
        };
        let timers = timers.into_iter().filter_map(|(index, event, period_ns)| {
            let out = self.out(&outgoing, self.ids[index])?;
            Some(Timer { out, event, period_ns })
        });
        clock::Wiring { timers: timers.collect(), listeners, step_ns: step_ns.unwrap_or_default(), outgoing }
    }
}

fn greatest_common_divisor(one: u64, other: u64) -> u64 {
    if other == 0 { one } else { greatest_common_divisor(other, one % other) }
}
