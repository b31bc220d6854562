//! Processes that are suspended for a while, and processes that are replaced.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, ChannelSystem, Envelope, Offer, Process, RoundRobin, Topology, TransitionId, Use, WiringError,
};

use crate::{hung_tree, pair, receiver_of, sender};

/// Records whether its timer, due after one second, has fired.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Alarm {
    fired: Option<Duration>,
}

impl Process for Alarm {
    fn offers(&self, _offers: &mut Vec<Offer>) {}

    fn take(&mut self, _transition: TransitionId, _received: Option<Envelope>, _now: Duration) {}

    fn next_timer(&self) -> Option<Duration> {
        self.fired.is_none().then_some(Duration::from_secs(1))
    }

    fn fire_timers(&mut self, now: Duration) {
        self.fired = Some(now);
    }

    fn uses(&self) -> Vec<Use> {
        Vec::new()
    }

    fn location(&self) -> String {
        String::new()
    }
}

#[test]
fn timers_of_a_suspended_process_fire_late() {
    let mut topology = Topology::default();
    let id = topology.process("Alarm").unwrap();
    let process: Box<dyn Process> = Box::new(Alarm { fired: None });
    let mut system = ChannelSystem::new(Arc::new(topology), [(id, process)]).unwrap();
    let fired = |system: &ChannelSystem| system.process::<Alarm>(id).and_then(|alarm| alarm.fired);
    system.suspend(id, true);
    system.advance(Duration::from_secs(2));
    assert_eq!(fired(&system), None);
    system.suspend(id, false);
    assert_eq!(fired(&system), None);
    system.advance(Duration::from_secs(3));
    assert_eq!(fired(&system), Some(Duration::from_secs(3)));
}

#[test]
fn a_suspended_process_neither_communicates_nor_loses_messages() {
    for (capacity, suspended) in [(Capacity::One, 0), (Capacity::One, 1), (Capacity::Zero, 0), (Capacity::Zero, 1)] {
        let (topology, ends, channel) = pair(capacity);
        let processes = [(ends[0], sender(channel, 7)), (ends[1], receiver_of(channel, 7))];
        let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
        let awake = system.fork();
        system.suspend(ends[suspended], true);
        assert!(!system.same_state(&awake));
        assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 0);
        assert_eq!(system.location(ends[suspended]).as_deref(), Some("before"));
        system.suspend(ends[suspended], false);
        assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 1);
    }
}

#[test]
fn suspending_a_process_suspends_all_its_members() {
    let mut topology = Topology::default();
    let tree = topology.process("BT").unwrap();
    let leaf = topology.member(tree, "leaf").unwrap();
    let skill = topology.process("Skill").unwrap();
    let channel = topology.channel(tree, skill, Capacity::One, crate::plan::numbers()).unwrap();
    let processes = [(leaf, sender(channel, 7)), (skill, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    system.suspend(tree, true);
    assert_eq!(system.enabled(), []);
    assert!(matches!(system.replace(tree, sender(channel, 8)), Err(WiringError::Composed { .. })));
    assert!(system.clone_process(tree).is_none());
    system.suspend(tree, false);
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 1);
}

#[test]
fn a_suspended_generator_loses_its_ticks() {
    let (mut system, generator) = hung_tree();
    system.suspend(generator, true);
    assert!(!system.generate_tick(generator).1);
    system.suspend(generator, false);
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 0);
    assert!(system.generate_tick(generator).1);
}

#[test]
fn a_process_can_be_replaced_and_restored() {
    let (topology, [p, q], channel) = pair(Capacity::One);
    let processes = [(p, sender(channel, 8)), (q, receiver_of(channel, 7))];
    let mut system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
    let first = system.fork();
    let initial = system.clone_process(q).unwrap();
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 0, "Q does not accept an 8");
    system.replace(q, receiver_of(channel, 8)).unwrap();
    assert_eq!(system.run(&mut RoundRobin::default(), 9).count(), 1);
    system.replace(q, initial).unwrap();
    system.replace(p, first.clone_process(p).unwrap()).unwrap();
    assert!(system.same_state(&first));
    let foreign = system.replace(q, sender(channel, 7));
    assert!(matches!(foreign, Err(WiringError::ForeignChannel { process, .. }) if process == "Q"));
}
