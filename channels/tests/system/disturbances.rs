//! Faults on channels: the effect of each, in every system and under every scheduler.

use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, Chance, ChannelId, ChannelSystem, Disturbance, Effect, Enabled, EnabledKind, Envelope, Event,
    EventKind, Message, Offer, Pattern, Process, ProcessId, RequestNumber, RoundRobin, RunError, Scheduler,
    TickGenerator, Topology, TransitionId, Use, Value, WiringError,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::plan::{Plan, build, number, numbers, plans, process, schedulers};
use crate::{hung_tree, pair, receiver_of, sender};

const STEP: Duration = Duration::from_millis(100);

fn value(message: &Message) -> i64 {
    let Some(Value::Int(n)) = message.field(1) else { panic!("{message} is not a number") };
    *n
}

fn plus(n: i64) -> Effect {
    Effect::Replace(Arc::new(move |message| number(value(message) + n)))
}

fn chance(probability: f64, seed: u64) -> Option<Chance> {
    Some(Chance { probability, stream: ChaCha8Rng::seed_from_u64(seed) })
}

fn hash(system: &ChannelSystem) -> u64 {
    let mut hasher = DefaultHasher::new();
    system.hash_state(&mut hasher);
    hasher.finish()
}

/// Lets the system become quiet twenty times, a tenth of a second apart, and lists the transitions taken and their
/// events.
fn run(system: &mut ChannelSystem, scheduler: &mut dyn Scheduler) -> Vec<(Duration, Enabled, Option<Event>)> {
    let mut taken = Vec::new();
    for step in 0..20 {
        system.advance(STEP * step);
        loop {
            let enabled = system.enabled();
            if enabled.is_empty() {
                break;
            }
            let chosen = enabled[scheduler.choose(&enabled)].clone();
            let event = system.take(&chosen).unwrap();
            taken.push((STEP * step, chosen, event));
        }
    }
    taken
}

/// The plan's first channel of capacity 1, if there is one.
fn buffered(plan: &Plan, channels: &[ChannelId]) -> Option<ChannelId> {
    plan.channels.iter().position(|&(_, _, capacity)| capacity == Capacity::One).map(|index| channels[index])
}

/// The messages received on the channel, with their times.
fn received(taken: &[(Duration, Enabled, Option<Event>)], channel: ChannelId) -> Vec<(Duration, i64)> {
    let events = taken.iter().filter_map(|(time, _, event)| Some((*time, event.as_ref()?)));
    events
        .filter_map(|(time, event)| match &event.kind {
            EventKind::Received { channel: on, message } if *on == channel => Some((time, value(message))),
            _ => None,
        })
        .collect()
}

/// The times at which something was sent on the channel.
fn sent(taken: &[(Duration, Enabled, Option<Event>)], channel: ChannelId) -> Vec<Duration> {
    let sends = taken.iter().filter(|(_, enabled, _)| enabled.kind == EnabledKind::Send(channel));
    sends.map(|&(time, ..)| time).collect()
}

fn numbered(received: &[(Duration, i64)]) -> Vec<i64> {
    received.iter().map(|&(_, n)| n).collect()
}

proptest! {
    /// A disturbance that applies to no message, one that never hits and one that is over change nothing.
    #[test]
    fn without_a_disturbance_everything_is_as_before(plan in plans(), seed: u64, victim in 0..4_usize) {
        let (plain, channels) = build(&plan);
        let Some(channel) = buffered(&plan, &channels) else { return Ok(()) };
        let mut disturbed = plain.fork();
        let lose = Disturbance::all(channel, Effect::Lose);
        disturbed.disturb(Disturbance { concerns: Arc::new(|_| false), ..lose.clone() });
        disturbed.disturb(Disturbance { probability: chance(0.0, seed), ..lose.clone() });
        let over = disturbed.disturb(lose);
        disturbed.calm(over);
        let victim = process(&plain, victim);
        for (mut one, mut other) in schedulers(seed, victim).into_iter().zip(schedulers(seed, victim)) {
            let expected = run(&mut plain.fork(), one.as_mut());
            prop_assert_eq!(expected, run(&mut disturbed.fork(), other.as_mut()));
        }
    }

    #[test]
    fn lost_messages_never_arrive(plan in plans(), seed: u64, victim in 0..4_usize) {
        let (mut system, channels) = build(&plan);
        let Some(channel) = buffered(&plan, &channels) else { return Ok(()) };
        let id = system.disturb(Disturbance::all(channel, Effect::Lose));
        for mut scheduler in schedulers(seed, process(&system, victim)) {
            let mut system = system.fork();
            let taken = run(&mut system, scheduler.as_mut());
            prop_assert_eq!(received(&taken, channel), []);
            prop_assert_eq!(system.hits(id), Some(sent(&taken, channel).len() as u64));
            prop_assert_eq!(system.content(channel), None);
        }
    }

    #[test]
    fn repeated_messages_arrive_twice(plan in plans(), seed: u64, victim in 0..4_usize) {
        let (mut system, channels) = build(&plan);
        let Some(channel) = buffered(&plan, &channels) else { return Ok(()) };
        system.disturb(Disturbance::all(channel, Effect::Repeat));
        for mut scheduler in schedulers(seed, process(&system, victim)) {
            let mut system = system.fork();
            let taken = run(&mut system, scheduler.as_mut());
            let received = numbered(&received(&taken, channel));
            let twice: Vec<i64> = (0..received.len()).map(|place| place as i64 / 2).collect();
            prop_assert_eq!(received, twice);
        }
    }

    #[test]
    fn held_messages_arrive_in_order_and_not_too_early(
        plan in plans(), seed: u64, victim in 0..4_usize, hold_ms in 0..400_u64
    ) {
        let (mut system, channels) = build(&plan);
        let Some(channel) = buffered(&plan, &channels) else { return Ok(()) };
        let hold = Duration::from_millis(hold_ms);
        system.disturb(Disturbance::all(channel, Effect::Hold(hold)));
        for mut scheduler in schedulers(seed, process(&system, victim)) {
            let mut system = system.fork();
            let taken = run(&mut system, scheduler.as_mut());
            let received = received(&taken, channel);
            prop_assert_eq!(numbered(&received), (0..received.len() as i64).collect::<Vec<_>>());
            for (&(arrived, _), sent) in received.iter().zip(sent(&taken, channel)) {
                prop_assert!(arrived >= sent + hold);
            }
        }
    }

    #[test]
    fn replaced_messages_arrive_as_their_replacement(plan in plans(), seed: u64, victim in 0..4_usize) {
        let (mut system, channels) = build(&plan);
        let Some(channel) = buffered(&plan, &channels) else { return Ok(()) };
        system.disturb(Disturbance::all(channel, plus(100)));
        for mut scheduler in schedulers(seed, process(&system, victim)) {
            let mut system = system.fork();
            let received = numbered(&received(&run(&mut system, scheduler.as_mut()), channel));
            prop_assert_eq!(&received, &(100..100 + received.len() as i64).collect::<Vec<_>>());
        }
    }

    /// A copy of a system with messages in transit continues like the original, with the same draws.
    #[test]
    fn messages_in_transit_are_part_of_the_state(plan in plans(), seed: u64, steps in 0..30_u64) {
        let (mut system, channels) = build(&plan);
        let Some(channel) = buffered(&plan, &channels) else { return Ok(()) };
        for (index, effect) in [Effect::Lose, Effect::Repeat, Effect::Hold(STEP * 2), plus(100)].into_iter().enumerate() {
            let probability = chance(0.5, seed ^ index as u64);
            system.disturb(Disturbance { probability, ..Disturbance::all(channel, effect) });
        }
        for scheduler in &mut schedulers(seed, process(&system, 0)) {
            let mut system = system.fork();
            let _ = system.run(scheduler.as_mut(), steps).count();
            let mut copy = system.fork();
            prop_assert!(system.same_state(&copy));
            prop_assert_eq!(hash(&system), hash(&copy));
            let rest = run(&mut system, &mut RoundRobin::default());
            prop_assert_eq!(rest, run(&mut copy, &mut RoundRobin::default()));
            prop_assert!(system.same_state(&copy));
        }
    }
}

/// P has sent 7 to Q, which waits only for that.
fn sent_to_q(prepare: impl FnOnce(&mut ChannelSystem, ChannelId)) -> (ChannelSystem, ChannelId, ProcessId) {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let processes = [(p, sender(channel, 7)), (q, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    prepare(&mut system, channel);
    let send = system.enabled().remove(0);
    assert_eq!(send.kind, EnabledKind::Send(channel));
    system.take(&send).unwrap();
    (system, channel, q)
}

fn kinds(system: &mut ChannelSystem) -> Vec<EnabledKind> {
    system.enabled().into_iter().map(|enabled| enabled.kind).collect()
}

#[test]
fn a_disturbed_message_cannot_be_received_until_the_channel_has_moved() {
    let (mut system, channel, _) = sent_to_q(|system, channel| {
        system.disturb(Disturbance::all(channel, Effect::Repeat));
    });
    let before = system.fork();
    let disturb = system.enabled().remove(0);
    assert_eq!(kinds(&mut system), [EnabledKind::Disturb(channel)]);
    assert_eq!(disturb.process, system.topology().find_process("P").unwrap());
    assert_eq!(system.take(&disturb), Ok(None), "no event");
    assert_eq!(kinds(&mut system), [EnabledKind::Receive(channel)]);
    assert!(!system.same_state(&before), "an armed channel is a different state");
}

#[test]
fn a_held_message_and_a_receivable_one_are_different_states() {
    let (mut held, channel, q) = sent_to_q(|system, channel| {
        system.disturb(Disturbance::all(channel, Effect::Hold(STEP)));
    });
    assert_eq!(held.run(&mut RoundRobin::default(), 9).count(), 0);
    let mut released = held.fork();
    released.advance(STEP);
    assert!(held.content(channel).is_some() && !held.same_state(&released));
    held.advance(STEP / 2);
    assert_eq!(kinds(&mut held), []);
    assert_eq!(released.run(&mut RoundRobin::default(), 9).count(), 1);
    assert_eq!(released.location(q).as_deref(), Some("after"));
}

#[test]
fn messages_in_transit_are_spared_when_a_disturbance_begins_or_ends() {
    let (mut system, channel, _) = sent_to_q(|_, _| {});
    system.disturb(Disturbance::all(channel, Effect::Lose));
    assert_eq!(kinds(&mut system), [EnabledKind::Receive(channel)]);

    let mut ids = Vec::new();
    let (mut system, channel, _) = sent_to_q(|system, channel| {
        ids.push(system.disturb(Disturbance::all(channel, Effect::Lose)));
        ids.push(system.disturb(Disturbance::all(channel, Effect::Repeat)));
    });
    assert_eq!(system.calm(ids[0]), Some(0));
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 1, "the second still acts; Q takes one of two");
    assert!(system.content(channel).is_some());
    assert_eq!([system.hits(ids[0]), system.hits(ids[1])], [None, Some(1)], "the first is over");
}

#[test]
fn disturbances_that_come_and_go_leave_nothing_behind() {
    let (mut system, channel, _) = sent_to_q(|_, _| {});
    let stays = system.disturb(Disturbance::all(channel, Effect::Repeat));
    let fresh = system.fork();
    let mut ids = vec![stays];
    for _ in 0..1_000 {
        let id = system.disturb(Disturbance::all(channel, Effect::Lose));
        assert!(!ids.contains(&id), "{id:?} was another's");
        assert_eq!((system.calm(id), system.calm(id)), (Some(0), None), "it ends only once");
        ids.push(id);
    }
    assert!(system.same_state(&fresh));
    assert_eq!(hash(&system), hash(&fresh));
    assert_eq!(system.hits(stays), Some(0), "and the one that began before is still there");
}

#[test]
fn held_messages_are_released_after_the_disturbance_has_ended() {
    let mut ids = Vec::new();
    let (mut system, _, q) = sent_to_q(|system, channel| {
        ids.push(system.disturb(Disturbance::all(channel, Effect::Hold(STEP))));
    });
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 0, "the channel has moved");
    assert_eq!(system.calm(ids[0]), Some(1));
    assert_eq!(kinds(&mut system), []);
    system.advance(STEP);
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 1);
    assert_eq!(system.location(q).as_deref(), Some("after"));
}

#[test]
fn disturbances_act_in_order_each_on_the_previous_result() {
    for (concerned, arrives) in [(7, true), (8, false)] {
        let (mut system, ..) = sent_to_q(|system, channel| {
            system.disturb(Disturbance::all(channel, plus(1)));
            let concerns = Arc::new(move |message: &Message| value(message) == concerned);
            system.disturb(Disturbance { concerns, ..Disturbance::all(channel, Effect::Lose) });
            system.disturb(Disturbance::all(channel, plus(-1)));
        });
        assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), usize::from(arrives));
    }
}

#[test]
fn a_replacement_that_the_channel_cannot_carry_ends_the_run() {
    let (mut system, ..) = sent_to_q(|system, channel| {
        let effect = Effect::Replace(Arc::new(|_| Message::symbols(["seven"])));
        system.disturb(Disturbance::all(channel, effect));
    });
    let last = system.run(&mut RoundRobin::default(), 9).last();
    assert!(matches!(last, Some(Err(RunError::Corrupted { channel, .. })) if channel == "P → Q"));
}

/// The number of messages lost in a row before the first that gets through.
fn lost_in_a_row(seed: u64) -> u64 {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let processes = [(p, sender(channel, 8)), (q, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    let lose = Disturbance::all(channel, Effect::Lose);
    let id = system.disturb(Disturbance { probability: chance(0.5, seed), ..lose });
    // Q does not take an 8, so an 8 that is not lost stays in the channel.
    while system.content(channel).is_none() {
        system.replace(p, sender(channel, 8)).unwrap();
        assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 0);
    }
    system.calm(id).unwrap()
}

#[test]
fn random_choices_come_from_the_stream() {
    let rows: Vec<u64> = (0..64).map(lost_in_a_row).collect();
    assert_eq!(rows, (0..64).map(lost_in_a_row).collect::<Vec<_>>());
    let mean = rows.iter().sum::<u64>() as f64 / 64.0;
    assert!((0.5..2.0).contains(&mean), "with a probability of one half it is 1 on average, not {mean}");
}

/// Asks with request number 42 and keeps the answer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Asker {
    requests: ChannelId,
    replies: ChannelId,
    asked: bool,
    answer: Option<Envelope>,
}

impl Process for Asker {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let request = Envelope { message: number(1), request: RequestNumber(42) };
        let action =
            if self.asked { Action::Receive(self.replies, Pattern::Any) } else { Action::Send(self.requests, request) };
        offers.push(Offer { transition: TransitionId(0), action });
    }

    fn take(&mut self, _transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        self.asked = true;
        self.answer = received.or(self.answer.take());
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Sends(self.requests, None), Use::Receives(self.replies, None)]
    }

    fn location(&self) -> String {
        String::new()
    }
}

/// P asks Q, which has its own answer ready and receives no request.
fn asking() -> (Topology, [ProcessId; 2], [ChannelId; 2]) {
    let (mut topology, [p, q], requests) = pair(Capacity::One);
    let replies = topology.channel(q, p, Capacity::One, numbers()).unwrap();
    (topology, [p, q], [requests, replies])
}

#[test]
fn a_forged_answer_carries_the_number_of_the_request() {
    let (topology, [p, q], [requests, replies]) = asking();
    let asker = Asker { requests, replies, asked: false, answer: None };
    let processes = [(p, Box::new(asker) as Box<dyn Process>), (q, sender(replies, 5))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    let id = system.disturb(Disturbance::all(requests, Effect::Answer(number(9))));
    // Q speaks first: the forged answer waits until its channel is empty.
    let reply = system.enabled().into_iter().find(|enabled| enabled.process == q).unwrap();
    system.take(&reply).unwrap();
    let ask = system.enabled().remove(0);
    system.take(&ask).unwrap();
    assert_eq!(kinds(&mut system), [EnabledKind::Receive(replies)]);
    let _ = system.run(&mut RoundRobin::default(), 9).count();
    let answer = system.process::<Asker>(p).and_then(|asker| asker.answer.clone());
    assert_eq!(answer, Some(Envelope { message: number(9), request: RequestNumber(42) }));
    assert_eq!((system.hits(id), system.content(requests)), (Some(1), None));
}

#[test]
fn a_disturbance_is_checked_against_the_topology() {
    let (topology, _, handshake) = pair(Capacity::Zero);
    let lose = Disturbance::all(handshake, Effect::Lose);
    assert!(matches!(lose.check(&topology), Err(WiringError::HoldsNothing { .. })));
    let (topology, _, one_way) = pair(Capacity::One);
    let answer = Disturbance::all(one_way, Effect::Answer(number(1)));
    let missing = answer.check(&topology);
    assert!(matches!(missing, Err(WiringError::MissingChannel { channel, .. }) if channel == "Q → P"));
    let (topology, _, [requests, _]) = asking();
    let answer = |message| Disturbance::all(requests, Effect::Answer(message)).check(&topology);
    assert!(
        matches!(answer(Message::symbols(["ok"])), Err(WiringError::OutsideDomain { process, .. }) if process == "Q")
    );
    assert_eq!(answer(number(1)), Ok(()));
}

#[test]
fn a_lost_tick_is_followed_by_the_next() {
    let (mut system, generator) = hung_tree();
    let ticks = system.topology().find_channel("TickGenerator", "BT").unwrap();
    let id = system.disturb(Disturbance::all(ticks, Effect::Lose));
    for (calm, arrives) in [(false, 0), (false, 0), (true, 1)] {
        if calm {
            system.calm(id);
        }
        assert!(system.generate_tick(generator).1, "although it is lost, it was delivered to the channel");
        assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), arrives);
    }
    assert!(system.process::<TickGenerator>(generator).is_some());
}
