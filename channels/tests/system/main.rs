//! Invariants of every channel system, regardless of its processes and its scheduler.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod disturbances;
mod plan;
mod suspension;

use std::sync::Arc;

use channels::{
    Capacity, ChannelId, ChannelSystem, Condition, Content, Domain, Enabled, EnabledKind, Event, EventKind, FieldKind,
    GraphMonitor, GraphProcess, Message, Process, ProcessId, ProgramGraph, Random, Relation, RoundRobin, RunError,
    Scheduler, Shape, Starving, Term, TickGenerator, Topology, Value, Verdict, WiringError,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::plan::{build, number, numbers, plans, process, schedulers};

proptest! {
    /// Without faults, messages are never lost, duplicated or reordered, and a channel never holds two.
    #[test]
    fn messages_arrive_once_and_in_order(plan in plans(), seed: u64, victim in 0..4_usize) {
        let (system, channels) = build(&plan);
        for mut scheduler in schedulers(seed, process(&system, victim)) {
            let mut system = system.fork();
            let mut sent = vec![0_i64; channels.len()];
            let mut received = vec![0_i64; channels.len()];
            loop {
                let enabled = system.enabled();
                if enabled.is_empty() {
                    break;
                }
                let chosen: Enabled = enabled[scheduler.choose(&enabled)].clone();
                let event = system.take(&chosen).unwrap();
                match chosen.kind {
                    EnabledKind::Send(channel) => sent[channel.index()] += 1,
                    EnabledKind::Handshake { channel, .. } => sent[channel.index()] += 1,
                    EnabledKind::Receive(_) | EnabledKind::Internal | EnabledKind::Disturb(_) => {}
                }
                if let Some(Event { kind: EventKind::Received { channel, message }, .. }) = event {
                    prop_assert_eq!(message, number(received[channel.index()]));
                    received[channel.index()] += 1;
                }
                for (index, channel) in channels.iter().enumerate() {
                    let held = i64::from(system.content(*channel).is_some());
                    prop_assert_eq!(sent[index] - received[index], held);
                    prop_assert!(held == 0 || plan.channels[index].2 == Capacity::One);
                }
            }
        }
    }

    /// A run with monitors equals the run without them, event for event.
    #[test]
    fn monitors_never_change_a_run(plan in plans(), seed: u64) {
        let (mut plain, channels) = build(&plan);
        let mut watched = plain.fork();
        for &channel in &channels {
            let mut graph = ProgramGraph::builder("watch");
            let [idle, odd] = ["idle", "odd"].map(|name| graph.location(name));
            let m = graph.variable("m");
            graph.receive(idle, channel, m, odd);
            graph.internal(odd, m.field(1).compare(Relation::Greater, 1), [], idle);
            watched.attach(Box::new(GraphMonitor::new(Arc::new(graph.initial(idle).build().unwrap()), [])));
        }
        let random = || Random::new(ChaCha8Rng::seed_from_u64(seed));
        let events: Vec<_> = plain.run(&mut random(), 10_000).collect();
        let watched_events: Vec<_> = watched.run(&mut random(), 10_000).collect();
        prop_assert_eq!(events, watched_events);
        prop_assert!(plain.same_state(&watched));
    }

    /// A copy of a system continues like the original.
    #[test]
    fn a_state_is_a_value(plan in plans(), seed: u64, steps in 0..20_u64) {
        let (mut system, _) = build(&plan);
        let _ = system.run(&mut Random::new(ChaCha8Rng::seed_from_u64(seed)), steps).count();
        let mut copy = system.fork();
        prop_assert!(system.same_state(&copy));
        prop_assert_eq!(system.enabled(), copy.enabled());
        let rest: Vec<_> = system.run(&mut RoundRobin::default(), 10_000).collect();
        prop_assert_eq!(rest, copy.run(&mut RoundRobin::default(), 10_000).collect::<Vec<_>>());
    }
}

/// Two processes and a channel between them.
pub(crate) fn pair(capacity: Capacity) -> (Topology, [ProcessId; 2], ChannelId) {
    let mut topology = Topology::default();
    let ends = ["P", "Q"].map(|name| topology.process(name).unwrap());
    let channel = topology.channel(ends[0], ends[1], capacity, numbers()).unwrap();
    (topology, ends, channel)
}

pub(crate) fn graph(build: impl FnOnce(&mut channels::GraphBuilder) -> channels::LocationId) -> Box<dyn Process> {
    let mut builder = ProgramGraph::builder("graph");
    let initial = build(&mut builder);
    Box::new(GraphProcess::new(Arc::new(builder.initial(initial).build().unwrap())))
}

pub(crate) fn sender(channel: ChannelId, sent: i64) -> Box<dyn Process> {
    graph(|graph| {
        let [before, after] = ["before", "after"].map(|name| graph.location(name));
        graph.send(before, channel, number(sent), after);
        before
    })
}

pub(crate) fn receiver_of(channel: ChannelId, expected: i64) -> Box<dyn Process> {
    graph(|graph| {
        let [before, after] = ["before", "after"].map(|name| graph.location(name));
        graph.receive(before, channel, number(expected), after);
        before
    })
}

#[test]
fn a_pattern_with_a_message_takes_only_that_message() {
    for (sent, location) in [(7, "after"), (8, "before")] {
        let (topology, [p, q], channel) = pair(Capacity::One);
        let processes = [(p, sender(channel, sent)), (q, receiver_of(channel, 7))];
        let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
        let events = system.run(&mut RoundRobin::default(), 100).count();
        assert_eq!(system.location(q).as_deref(), Some(location));
        assert_eq!((events, system.content(channel).is_none()), (usize::from(sent == 7), sent == 7));
    }
}

#[test]
fn a_handshake_moves_both_sides_or_neither() {
    for (sent, locations) in [(7, ["after", "after"]), (8, ["before", "before"])] {
        let (topology, [p, q], channel) = pair(Capacity::Zero);
        let processes = [(p, sender(channel, sent)), (q, receiver_of(channel, 7))];
        let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
        let _ = system.run(&mut RoundRobin::default(), 100).count();
        assert_eq!([p, q].map(|id| system.location(id).unwrap()), locations);
    }
}

#[test]
fn communication_between_members_of_one_process_is_not_an_event() {
    let mut topology = Topology::default();
    let tree = topology.process("BT").unwrap();
    let members = ["root", "leaf"].map(|name| topology.member(tree, name).unwrap());
    let channel = topology.channel(members[0], members[1], Capacity::Zero, numbers()).unwrap();
    let processes = [(members[0], sender(channel, 7)), (members[1], receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    assert_eq!(system.run(&mut RoundRobin::default(), 100).count(), 0);
    assert_eq!(system.location(members[1]).as_deref(), Some("after"));
    assert_eq!(system.steps(), 0);
}

#[test]
fn a_guard_and_an_effect_make_a_counter() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let counter = graph(|graph| {
        let [count, done] = ["count", "done"].map(|name| graph.location(name));
        let n = graph.variable_with("n", Content::Value(3.into()));
        let less = Term::Difference(Box::new(n.term()), Box::new(1.into()));
        graph.internal(count, n.term().compare(Relation::Greater, 0), [(n, less)], count);
        graph.internal(count, n.term().compare(Relation::Equal, 0), [], done);
        count
    });
    let processes = [(p, counter), (q, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    assert_eq!(system.run(&mut RoundRobin::default(), 100).count(), 0);
    assert_eq!(system.location(p).as_deref(), Some("done"));
}

#[test]
fn a_message_that_the_channel_cannot_carry_is_refused_at_wiring() {
    let (mut topology, [p, q], channel) = pair(Capacity::One);
    let back = topology.channel(q, p, Capacity::One, Domain::new([])).unwrap();
    let wrong = ChannelSystem::new(Arc::new(topology), [(p, sender(channel, 1)), (q, sender(back, 1))]);
    assert!(matches!(wrong, Err(WiringError::OutsideDomain { process, .. }) if process == "Q"));
}

#[test]
fn a_foreign_channel_is_refused_at_wiring() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let wrong = ChannelSystem::new(Arc::new(topology), [(p, sender(channel, 1)), (q, sender(channel, 1))]);
    assert!(matches!(wrong, Err(WiringError::ForeignChannel { process, .. }) if process == "Q"));
}

#[test]
fn a_process_without_behavior_is_refused_at_wiring() {
    let (topology, [p, _], channel) = pair(Capacity::One);
    let wrong = ChannelSystem::new(Arc::new(topology), [(p, sender(channel, 1))]);
    assert!(matches!(wrong, Err(WiringError::MissingProcess { process }) if process == "Q"));
}

#[test]
fn monitors_alone_see_what_is_shown_from_outside_the_system() {
    let (mut topology, [p, q], channel) = pair(Capacity::One);
    let [world, monitors] = ["World", "Monitors"].map(|name| topology.outside(name).unwrap());
    let level = Domain::new([Shape::new([("level", FieldKind::Int)])]);
    for (from, to) in [(world, p), (q, world)] {
        let refused = topology.channel(from, to, Capacity::One, level.clone());
        assert!(matches!(refused, Err(WiringError::Outside { .. })), "no process of the system hears or tells of it");
    }
    let shown = topology.channel(world, monitors, Capacity::Zero, level).unwrap();
    let processes = [(p, sender(channel, 7)), (q, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    let event = system.show(shown, Message::new([Value::Int(3)]));
    assert_eq!((event.step, system.steps()), (0, 0), "it is no communication");
    let mut alone = system.fork();
    assert!(alone.same_state(&system));
    let events = system.run(&mut RoundRobin::default(), 100).map(Result::unwrap).count();
    assert_eq!(events, alone.run(&mut RoundRobin::default(), 100).count());
    assert_eq!(events, 1);
}

#[test]
fn a_message_made_at_run_time_is_checked_when_it_is_sent() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let wrong = graph(|graph| {
        let [start, ready, after] = ["start", "ready", "after"].map(|name| graph.location(name));
        let m = graph.variable("m");
        graph.internal(start, Condition::True, [(m, Term::Tuple(vec![true.into()]))], ready);
        graph.send(ready, channel, m, after);
        start
    });
    let mut system = ChannelSystem::new(Arc::new(topology), [(p, wrong), (q, receiver_of(channel, 7))]).unwrap();
    let last = system.run(&mut RoundRobin::default(), 100).last();
    assert!(matches!(last, Some(Err(RunError::OutsideDomain { process, .. })) if process == "P"));
}

#[test]
fn a_livelock_names_the_processes_that_keep_moving() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let spin = graph(|graph| {
        let here = graph.location("here");
        graph.internal(here, Condition::True, [], here);
        here
    });
    let mut system = ChannelSystem::new(Arc::new(topology), [(p, spin), (q, receiver_of(channel, 7))]).unwrap();
    let last = system.run(&mut RoundRobin::default(), 100).last();
    let expected = RunError::Livelock { steps: 100, time_s: "0.00".to_owned(), processes: vec!["P".to_owned()] };
    assert_eq!(last, Some(Err(expected)));
}

#[test]
fn a_budget_may_be_the_largest_integer() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let processes = [(p, sender(channel, 7)), (q, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    assert_eq!(system.run(&mut RoundRobin::default(), u64::MAX).count(), 1);
}

/// A tick generator and a tree that takes one tick and never finishes it.
pub(crate) fn hung_tree() -> (ChannelSystem, ProcessId) {
    let mut topology = Topology::default();
    let [generator, tree] = ["TickGenerator", "BT"].map(|name| topology.process(name).unwrap());
    let ticks = topology.channel(generator, tree, Capacity::One, Domain::new([TickGenerator::shape()])).unwrap();
    let hung = graph(|graph| {
        let [idle, busy] = ["idle", "busy"].map(|name| graph.location(name));
        let tick = graph.variable("tick");
        graph.receive(idle, ticks, tick, busy);
        idle
    });
    let processes = [(generator, Box::new(TickGenerator::new(ticks)) as _), (tree, hung)];
    (ChannelSystem::new(Arc::new(topology), processes).unwrap(), generator)
}

#[test]
fn a_tick_that_nothing_waits_for_is_an_overrun_but_still_an_event() {
    let (mut system, generator) = hung_tree();
    for (tick, delivered) in [(0, true), (1, false), (2, false)] {
        let (event, taken) = system.generate_tick(generator);
        assert_eq!((event.tick, event.kind, taken), (tick, EventKind::Tick, delivered));
        let events: Vec<_> = system.run(&mut RoundRobin::default(), 100).map(Result::unwrap).collect();
        assert_eq!(events.len(), usize::from(delivered));
    }
    assert_eq!(system.ticks(), 3);
}

#[test]
fn a_monitor_moves_in_the_step_of_the_message_and_failure_is_final() {
    let (mut system, generator) = hung_tree();
    let ticks = system.topology().find_channel("TickGenerator", "BT").unwrap();
    let mut never = ProgramGraph::builder("never");
    let [idle, failure] = ["idle", "failure"].map(|name| never.location(name));
    let tick = never.variable("tick");
    never.receive(idle, ticks, tick, failure);
    never.internal(failure, Condition::True, [], idle);
    system.attach(Box::new(GraphMonitor::new(Arc::new(never.initial(idle).build().unwrap()), [failure])));
    assert_eq!(system.monitors()[0].monitor.verdict(), Verdict::Inconclusive);
    system.generate_tick(generator);
    let _ = system.run(&mut RoundRobin::default(), 100).count();
    assert_eq!(system.monitors()[0].monitor.verdict(), Verdict::False);
    assert_eq!(system.monitors()[0].monitor.location(), "failure");
    assert_eq!(system.monitors()[0].decided.as_ref().map(|event| (event.step, event.tick)), Some((1, 0)));
}

/// Takes four internal transitions.
fn busy() -> Box<dyn Process> {
    graph(|graph| {
        let locations: Vec<_> = (0..5).map(|i| graph.location(&i.to_string())).collect();
        for pair in locations.windows(2) {
            graph.internal(pair[0], Condition::True, [], pair[1]);
        }
        locations[0]
    })
}

/// The processes that move or send, in order, until none can.
fn movers(system: &mut ChannelSystem, scheduler: &mut dyn Scheduler) -> Vec<ProcessId> {
    let mut order = Vec::new();
    loop {
        let enabled = system.enabled();
        if enabled.is_empty() {
            return order;
        }
        let chosen = enabled[scheduler.choose_in(system, &enabled)].clone();
        order.push(chosen.process);
        system.take(&chosen).unwrap();
    }
}

#[test]
fn a_starved_process_moves_only_when_no_other_can() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let mut system = ChannelSystem::new(Arc::new(topology), [(p, sender(channel, 7)), (q, busy())]).unwrap();
    let order = movers(&mut system, &mut Starving::new(p, Box::new(RoundRobin::default())));
    assert_eq!(order, [q, q, q, q, p]);
}

#[test]
fn a_starved_process_does_not_even_receive_in_a_handshake() {
    let mut topology = Topology::default();
    let [p, q, r] = ["P", "Q", "R"].map(|name| topology.process(name).unwrap());
    let channel = topology.channel(p, q, Capacity::Zero, numbers()).unwrap();
    let processes = [(p, sender(channel, 7)), (q, receiver_of(channel, 7)), (r, busy())];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    assert_eq!(movers(&mut system, &mut Starving::new(q, Box::new(RoundRobin::default()))), [r, r, r, r, p]);
}

#[test]
fn a_composed_process_is_starved_as_a_whole() {
    let mut topology = Topology::default();
    let [tree, other] = ["BT", "other"].map(|name| topology.process(name).unwrap());
    let [root, leaf] = ["root", "leaf"].map(|name| topology.member(tree, name).unwrap());
    let channel = topology.channel(root, leaf, Capacity::Zero, numbers()).unwrap();
    let processes = [(root, sender(channel, 7)), (leaf, receiver_of(channel, 7)), (other, busy())];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    let order = movers(&mut system, &mut Starving::new(tree, Box::new(RoundRobin::default())));
    assert_eq!(order, [other, other, other, other, root]);
}

#[test]
fn a_graph_without_a_start_or_with_a_false_initial_condition_is_refused() {
    assert!(ProgramGraph::builder("empty").build().is_err());
    let mut graph = ProgramGraph::builder("false");
    let here = graph.location("here");
    let n = graph.variable_with("n", Content::Value(1.into()));
    let graph = graph.initial(here).initial_condition(n.term().compare(Relation::Equal, 2));
    assert!(graph.build().is_err());
}
