//! Lets processes exchange messages under every possible schedule: `cargo run --example all_schedules`.
//!
//! Anna and Ben share two forks. Who goes hungry depends on the order in which they pick them up, so a test with a
//! single schedule could not tell.

use std::error::Error;
use std::sync::Arc;

use channels::{
    Capacity, ChannelSystem, Domain, EventKind, FieldKind, GraphProcess, Message, Process, ProcessId, ProgramGraph,
    Shape, Topology,
};

const GUESTS: [&str; 2] = ["Anna", "Ben"];
const FORKS: [&str; 2] = ["LeftFork", "RightFork"];

/// A table at which each guest picks up the forks in a certain order.
fn table(orders: [[usize; 2]; 2]) -> Result<ChannelSystem, Box<dyn Error>> {
    let mut topology = Topology::default();
    let mut processes = |names: [&str; 2]| -> Result<[ProcessId; 2], Box<dyn Error>> {
        Ok([topology.process(names[0])?, topology.process(names[1])?])
    };
    let (guests, forks) = (processes(GUESTS)?, processes(FORKS)?);

    // A channel of capacity 0 joins each guest to each fork: both move together when the fork is free.
    let mut channels = Vec::new();
    for guest in guests {
        for fork in forks {
            let words = Shape::new([("word", FieldKind::symbols(["take", "put"]))]);
            channels.push(topology.channel(guest, fork, Capacity::Zero, Domain::new([words]))?);
        }
    }
    let between = |guest: usize, fork: usize| channels[2 * guest + fork];
    let [take, put] = ["take", "put"].map(|word| Message::symbols([word]));

    let mut behaviors: Vec<(ProcessId, Box<dyn Process>)> = Vec::new();
    for (guest, [first, second]) in orders.into_iter().enumerate() {
        let mut graph = ProgramGraph::builder(GUESTS[guest]);
        let names = ["hungry", "waiting", "eating", "leaving", "full"];
        let [hungry, waiting, eating, leaving, full] = names.map(|name| graph.location(name));
        graph.send(hungry, between(guest, first), take.clone(), waiting);
        graph.send(waiting, between(guest, second), take.clone(), eating);
        graph.send(eating, between(guest, second), put.clone(), leaving);
        graph.send(leaving, between(guest, first), put.clone(), full);
        let graph = graph.initial(hungry).build()?;
        behaviors.push((guests[guest], Box::new(GraphProcess::new(Arc::new(graph)))));
    }
    for (fork, name) in FORKS.into_iter().enumerate() {
        let mut graph = ProgramGraph::builder(name);
        let free = graph.location("free");
        for (guest, holder) in GUESTS.into_iter().enumerate() {
            let held = graph.location(&format!("held by {holder}"));
            graph.receive(free, between(guest, fork), take.clone(), held);
            graph.receive(held, between(guest, fork), put.clone(), free);
        }
        let graph = graph.initial(free).build()?;
        behaviors.push((forks[fork], Box::new(GraphProcess::new(Arc::new(graph)))));
    }
    Ok(ChannelSystem::new(Arc::new(topology), behaviors)?)
}

/// A reachable state, and the messages that lead to it.
struct Reached {
    system: ChannelSystem,
    by: Vec<String>,
}

/// Every reachable state, once, with one of the shortest paths to it.
fn explore(start: ChannelSystem) -> Result<Vec<Reached>, Box<dyn Error>> {
    let mut states = vec![Reached { system: start, by: Vec::new() }];
    let mut next = 0;
    while next < states.len() {
        for transition in states[next].system.enabled() {
            let (mut system, mut by) = (states[next].system.fork(), states[next].by.clone());
            if let Some(EventKind::Received { channel, message }) = system.take(&transition)?.map(|event| event.kind) {
                let (from, to) = system.topology().ends(channel);
                by.push(format!("{from} → {to} {message}"));
            }
            // For large state spaces, store states by `hash_state` instead.
            if !states.iter().any(|known| known.system.same_state(&system)) {
                states.push(Reached { system, by });
            }
        }
        next += 1;
    }
    Ok(states)
}

#[expect(clippy::print_stdout, reason = "an example prints its results")]
fn main() -> Result<(), Box<dyn Error>> {
    for (what, orders) in
        [("each a different fork first", [[0, 1], [1, 0]]), ("both the left fork first", [[0, 1], [0, 1]])]
    {
        let mut states = explore(table(orders)?)?;
        println!("{what}: {} states", states.len());
        for Reached { system, by } in &mut states {
            if !system.enabled().is_empty() {
                continue;
            }
            let guests: Vec<ProcessId> = system.topology().processes().take(GUESTS.len()).collect();
            let stand = guests.iter().filter_map(|guest| system.location(*guest));
            let stand: Vec<(&str, String)> = GUESTS.into_iter().zip(stand).collect();
            let words = stand.iter().map(|(name, location)| format!("{name} is {location}"));
            println!("  it can end with: {}", words.collect::<Vec<_>>().join(", "));
            if stand.iter().any(|(_, location)| location != "full") {
                println!("    after: {}", by.join(", "));
            }
        }
    }
    Ok(())
}
