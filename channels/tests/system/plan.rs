//! Random systems of scripted processes, and the schedulers that run them.

use std::collections::VecDeque;
use std::sync::Arc;

use channels::{
    Capacity, ChannelId, ChannelSystem, Domain, Enabled, FieldKind, GraphProcess, Message, Process, ProcessId,
    ProgramGraph, Random, RoundRobin, Scheduler, Shape, Starving, Topology, Value,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub(crate) fn numbers() -> Domain {
    Domain::new([Shape::new([("number", FieldKind::Int)])])
}

pub(crate) fn number(n: i64) -> Message {
    Message::new([Value::Int(n)])
}

/// One line of a process's script: use this channel, as its sender or its receiver.
#[derive(Clone, Copy, Debug)]
struct Line {
    channel: usize,
}

/// A random system: channels between some of four processes, and what each process does with them, in order.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) channels: Vec<(usize, usize, Capacity)>,
    scripts: Vec<Vec<Line>>,
}

pub(crate) fn plans() -> impl Strategy<Value = Plan> {
    let capacity = prop_oneof![Just(Capacity::Zero), Just(Capacity::One)];
    let ends = (0..4_usize, 1..4_usize, capacity).prop_map(|(p, hop, capacity)| (p, (p + hop) % 4, capacity));
    (prop::collection::vec(ends, 1..6), prop::collection::vec(0..64_usize, 1..60)).prop_map(|(mut channels, uses)| {
        channels.sort_by_key(|&(p, q, _)| (p, q));
        channels.dedup_by_key(|&mut (p, q, _)| (p, q));
        let mut scripts = vec![Vec::new(); 4];
        for choice in uses {
            let channel = (choice / 2) % channels.len();
            let (source, target, _) = channels[channel];
            scripts[if choice % 2 == 0 { source } else { target }].push(Line { channel });
        }
        Plan { channels, scripts }
    })
}

/// The plan as a system of program graphs. Every message on a channel carries its own number, counted from 0.
pub(crate) fn build(plan: &Plan) -> (ChannelSystem, Vec<ChannelId>) {
    let mut topology = Topology::default();
    let ids: Vec<ProcessId> = (0..4).map(|i| topology.process(&format!("P{i}")).unwrap()).collect();
    let channels: Vec<ChannelId> = plan
        .channels
        .iter()
        .map(|&(p, q, capacity)| topology.channel(ids[p], ids[q], capacity, numbers()).unwrap())
        .collect();
    let mut sent = vec![0; channels.len()];
    let mut processes: Vec<(ProcessId, Box<dyn Process>)> = Vec::new();
    for (index, script) in plan.scripts.iter().enumerate() {
        let mut graph = ProgramGraph::builder(&format!("P{index}"));
        let start = graph.location("0");
        let last = graph.variable("last");
        let mut here = start;
        for (line, Line { channel }) in script.iter().enumerate() {
            let next = graph.location(&format!("{}", line + 1));
            if plan.channels[*channel].0 == index {
                graph.send(here, channels[*channel], number(sent[*channel]), next);
                sent[*channel] += 1;
            } else {
                graph.receive(here, channels[*channel], last, next);
            }
            here = next;
        }
        let graph = Arc::new(graph.initial(start).build().unwrap());
        processes.push((ids[index], Box::new(GraphProcess::new(graph))));
    }
    (ChannelSystem::new(Arc::new(topology), processes).unwrap(), channels)
}

/// Follows a list of processes: the one at the head takes its first enabled transition and is removed from the list. If
/// it cannot move, or the list is empty, the system's first enabled transition is taken.
#[derive(Debug)]
struct Scripted(VecDeque<ProcessId>);

impl Scheduler for Scripted {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        let head = self.0.front();
        let choice = head.and_then(|head| enabled.iter().position(|transition| transition.process == *head));
        if choice.is_some() {
            self.0.pop_front();
        }
        choice.unwrap_or(0)
    }
}

pub(crate) fn schedulers(seed: u64, victim: ProcessId) -> Vec<Box<dyn Scheduler>> {
    let random = || Box::new(Random::new(ChaCha8Rng::seed_from_u64(seed)));
    vec![
        random(),
        Box::new(RoundRobin::default()),
        Box::new(Starving::new(victim, random())),
        Box::new(Scripted([victim, victim].into())),
    ]
}

pub(crate) fn process(system: &ChannelSystem, index: usize) -> ProcessId {
    system.topology().processes().nth(index).unwrap()
}
