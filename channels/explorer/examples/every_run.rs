//! Proves a property over all runs, then finds a run that violates it when a message may be lost: `cargo run --example
//! every_run`.
//!
//! A client asks a server at each tick. Is every question answered before the next tick?

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, ChannelSystem, Domain, FieldKind, GraphMonitor, GraphProcess, Label, Message, ProgramGraph, Role, Shape,
    TickGenerator, Topology,
};
use explorer::{Closed, Environment, Limits, MessageFaults, Model, Outcome, Ticks, explore};

#[expect(clippy::print_stdout, reason = "an example prints its results")]
fn main() -> Result<(), Box<dyn Error>> {
    let mut topology = Topology::default();
    let [clock, client, server] =
        [topology.process("Clock")?, topology.process("Client")?, topology.process("Server")?];
    let word = |word| Domain::new([Shape::new([("word", FieldKind::symbols([word]))])]);
    let ticks = topology.channel(clock, client, Capacity::One, Domain::new([TickGenerator::shape()]))?;
    let asks = topology.channel(client, server, Capacity::One, word("ask"))?;
    let answers = topology.channel(server, client, Capacity::One, word("ok").in_role(Role::Reply))?;
    let [ask, ok] = ["ask", "ok"].map(|word| Message::symbols([word]));

    let mut graph = ProgramGraph::builder("Client");
    let [idle, about_to_ask, waiting] = ["idle", "about to ask", "waiting"].map(|name| graph.location(name));
    let tick = graph.variable("tick");
    graph.receive(idle, ticks, tick, about_to_ask);
    graph.send(about_to_ask, asks, ask.clone(), waiting);
    graph.receive(waiting, answers, ok.clone(), idle);
    let client_graph = graph.initial(idle).build()?;

    let mut graph = ProgramGraph::builder("Server");
    let [idle, asked] = ["idle", "asked"].map(|name| graph.location(name));
    graph.receive(idle, asks, ask.clone(), asked);
    graph.send(asked, answers, ok.clone(), idle);
    let server_graph = graph.initial(idle).build()?;

    let mut graph = ProgramGraph::builder("answered before the next tick");
    let [fine, open, late] = ["fine", "open", "late"].map(|name| graph.location(name));
    let seen = graph.variable("seen");
    graph.receive(fine, asks, ask, open);
    graph.receive(open, answers, ok, fine);
    graph.transition(open, Label::Tick(seen), late);
    let property = GraphMonitor::new(Arc::new(graph.initial(fine).build()?), [late]);

    let process = |graph| Box::new(GraphProcess::new(Arc::new(graph))) as _;
    let processes = [
        (clock, Box::new(TickGenerator::new(ticks)) as _),
        (client, process(client_graph)),
        (server, process(server_graph)),
    ];
    let system = ChannelSystem::new(Arc::new(topology), processes)?;
    let second = Duration::from_secs(1);
    let ticks = Ticks { generator: clock, period: second, first: second, step: Duration::ZERO };
    for lost in 0..=1 {
        let faults = MessageFaults { lost, channels: vec![asks, answers], ..MessageFaults::default() };
        let model = Model::new(&system, Some(ticks), Closed.erased()).with_message_faults(faults);
        let found = explore(&model, Some(&property), &Limits::default(), &mut |_| ())?;
        let Outcome::Violated(path) = found.outcome else {
            println!("with {lost} lost messages: proved, {} states", found.progress.states);
            continue;
        };
        println!("with {lost} lost message: violated after {} ticks", path.ticks());
        path.replay(&model, Some(&property))?.lines().iter().for_each(|line| println!("  {line}"));
    }
    Ok(())
}
