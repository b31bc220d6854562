//! The cost of a communication: a request and its reply between two program graphs, and an event of a monitor.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, ChannelSystem, Domain, Event, EventKind, FieldKind, GraphMonitor, GraphProcess, Message, Monitor,
    ProgramGraph, Relation, RoundRobin, Shape, Topology, Value,
};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// A process that keeps asking, and one that answers.
fn conversation() -> ChannelSystem {
    let mut topology = Topology::default();
    let [skill, reader] = ["BatteryLevel", "BatteryReader"].map(|name| topology.process(name).expect("a new name"));
    let get_level = Domain::new([Shape::new([("request", FieldKind::symbols(["get_level"]))])]);
    let level = Domain::new([Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)])]);
    let requests = topology.channel(skill, reader, Capacity::One, get_level).expect("a new channel");
    let replies = topology.channel(reader, skill, Capacity::One, level).expect("a new channel");
    let mut ask = ProgramGraph::builder("BatteryLevel");
    let [start, wait] = ["start", "wait"].map(|name| ask.location(name));
    let answer = ask.variable("answer");
    ask.send(start, requests, Message::symbols(["get_level"]), wait);
    ask.receive(wait, replies, answer, start);
    let mut read = ProgramGraph::builder("BatteryReader");
    let [idle, asked] = ["idle", "asked"].map(|name| read.location(name));
    read.receive(idle, requests, Message::symbols(["get_level"]), asked);
    read.send(asked, replies, Message::new([Value::symbol("ok"), 83.2.into()]), idle);
    let graphs = [(skill, ask.initial(start)), (reader, read.initial(idle))];
    let processes = graphs.map(|(id, graph)| {
        (id, Box::new(GraphProcess::new(Arc::new(graph.build().expect("a graph with a start")))) as _)
    });
    ChannelSystem::new(Arc::new(topology), processes).expect("a wired system")
}

/// One communication: a send, a receive and the choice among the enabled transitions.
#[divan::bench]
fn communication(bencher: Bencher) {
    let mut system = conversation();
    let mut scheduler = RoundRobin::default();
    bencher.bench_local(|| black_box(system.run(&mut scheduler, u64::MAX).next()));
}

/// One event that moves the paper's safety monitor through `get` and back.
#[divan::bench]
fn monitor_event(bencher: Bencher) {
    let system = conversation();
    let channel = system.topology().find_channel("BatteryReader", "BatteryLevel").expect("a wired channel");
    let mut graph = ProgramGraph::builder("phi1");
    let [idle, get, failure] = ["idle", "get", "failure"].map(|name| graph.location(name));
    let m = graph.variable("m");
    graph.receive(idle, channel, m, get);
    graph.internal(get, m.field(2).compare(Relation::GreaterOrEqual, 20), [], idle);
    graph.internal(get, m.field(2).compare(Relation::Less, 20), [], failure);
    let graph = graph.initial(idle).build().expect("a graph with a start");
    let mut monitor = GraphMonitor::new(Arc::new(graph), [failure]);
    let message = Message::new([Value::symbol("ok"), 83.2.into()]);
    let event = Event { step: 1, tick: 1, time: Duration::ZERO, kind: EventKind::Received { channel, message } };
    bencher.bench_local(|| monitor.observe(black_box(&event)));
}
