//! Leaves that do not answer: the tree continues without them and reports it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bt::{Execution, Fault, LEAF_TIMEOUT, LeafProcess, Progress, Reply, Request, Status, TreeProcess};
use channels::{ChannelId, Disturbance, Effect};
use proptest::prelude::*;

use crate::forest::{Actors, Called, by_process, script, spec};
use crate::processes::{Form, Stage, calls, recharge};

const PERIOD: Duration = Duration::from_secs(60);

impl Stage {
    /// The channels between the tree and its skills.
    fn leaf_channels(&self) -> Vec<ChannelId> {
        let topology = self.system.topology();
        let is_outer = |channel: &ChannelId| {
            let (from, to) = topology.ends(*channel);
            from != to && from != "TickGenerator"
        };
        topology.channels().filter(is_outer).collect()
    }

    /// Applies this effect to the `nth` message between tree and skills, counted from 0.
    fn disturb_nth(&mut self, nth: u64, effect: &Effect) {
        let sent = Arc::new(AtomicU64::new(0));
        for channel in self.leaf_channels() {
            let sent = Arc::clone(&sent);
            let concerns = Arc::new(move |_: &_| sent.fetch_add(1, Ordering::Relaxed) == nth);
            self.system.disturb(Disturbance { concerns, ..Disturbance::all(channel, effect.clone()) });
        }
    }

    /// Generates a tick and lets time pass until nothing more can happen. Returns the calls that arrived.
    fn long_tick(&mut self, tick: u32) -> Vec<Called> {
        let start = PERIOD * tick;
        self.system.advance(start);
        let mut messages = self.tick();
        for second in 1..PERIOD.as_secs() {
            self.system.advance(start + Duration::from_secs(second));
            messages.extend(self.run());
        }
        calls(&messages)
    }

    /// The faults in the last tick.
    fn faults(&self) -> Vec<Fault> {
        if let Some(tree) = self.system.process::<TreeProcess>(self.bt) {
            return tree.faults().to_vec();
        }
        let leaves = || self.system.topology().processes().filter_map(|id| self.system.process::<LeafProcess>(id));
        let last = i64::try_from(self.system.ticks()).ok().map(|ticks| ticks - 1);
        leaves().filter(|leaf| leaf.tick() == last).flat_map(LeafProcess::faults).cloned().collect()
    }
}

/// A tick by the engine alone, with leaves whose messages may be lost: the first one has number `sent`.
fn lossy_tick(execution: &mut Execution, actors: &mut Actors, sent: &mut u64, lost: u64) {
    let mut arrives = || {
        *sent += 1;
        *sent - 1 != lost
    };
    let mut step = execution.start_tick(Duration::ZERO);
    while let Some(Progress::Call(call)) = step {
        let leaf = execution.tree().node(call.leaf).process().to_owned();
        let reply = arrives().then(|| match call.request {
            Request::Tick => Reply::Status(actors.tick(&leaf)),
            Request::Halt => {
                actors.halt(&leaf);
                Reply::Halted
            }
        });
        step = match reply.filter(|_| arrives()) {
            Some(reply) => execution.resume(Duration::ZERO, reply),
            None => execution.give_up(Duration::ZERO, format!("{leaf} did not answer")),
        };
    }
}

/// The leaves that did not answer; guards and scripts have other faults.
fn silent_leaves(faults: &[Fault]) -> Vec<usize> {
    let silent = faults.iter().filter(|fault| fault.message.contains(" did not "));
    silent.map(|fault| fault.node.index()).collect()
}

proptest! {
    /// Whichever message is lost: a leaf without an answer has failed or halted, and everything else is unchanged.
    #[test]
    fn a_lost_message_is_a_leaf_that_failed_or_halted(
        spec in spec(), script in script(), seeds in any::<(u64, u64)>(), ticks in 1..6_u32, lost in 0..40_u64,
    ) {
        let tree = spec.tree();
        let mut actors = Actors::new(&by_process(&tree, &script));
        let (mut sent, mut execution) = (0, Execution::new(tree.clone()));
        let mut whole = Stage::new(&tree, Form::Whole, &script, 0, seeds.0);
        let mut nodes = Stage::new(&tree, Form::Nodes, &script, 0, seeds.1);
        for stage in [&mut whole, &mut nodes] {
            stage.disturb_nth(lost, &Effect::Lose);
        }
        for tick in 0..ticks {
            let made = actors.calls.len();
            lossy_tick(&mut execution, &mut actors, &mut sent, lost);
            let expected = &actors.calls[made..];
            for stage in [&mut whole, &mut nodes] {
                prop_assert_eq!(&stage.long_tick(tick), expected);
                prop_assert_eq!(stage.states(), execution.states());
            }
            let silent = silent_leaves(execution.faults());
            prop_assert_eq!(silent_leaves(&whole.faults()), silent.clone());
            prop_assert_eq!(silent_leaves(&nodes.faults()), silent);
        }
    }

    /// Whatever happens to a message, the tree then waits for the next tick, and the system becomes quiet.
    #[test]
    fn a_tree_always_recovers(
        spec in spec(), script in script(), seed: u64, nth in 0..30_u64, effect in 0..4_usize,
    ) {
        let tree = spec.tree();
        let hold = |seconds| Effect::Hold(Duration::from_secs_f64(seconds));
        let effect = [Effect::Lose, Effect::Repeat, hold(0.3), hold(3.0)][effect].clone();
        for form in [Form::Whole, Form::Nodes] {
            let mut stage = Stage::new(&tree, form, &script, 0, seed);
            stage.disturb_nth(nth, &effect);
            for tick in 0..6 {
                // It panics if the tree does not wait for the next tick.
                stage.long_tick(tick);
            }
        }
    }
}

/// The paper's robot, whose GoToDestination runs and is then halted.
fn interrupted(form: Form, silent: &str) -> Stage {
    use Status::{Failure, Running, Success};
    let (tree, mut script) =
        recharge(&[("BatteryNotCharging", Success), ("GotoRechargingStation", Running), ("GoToDestination", Running)]);
    script.insert("BatteryLevel".to_owned(), vec![Success, Failure]);
    let mut stage = Stage::new(&tree, form, &script, 0, 1);
    let channel = stage.system.topology().find_channel("GoToDestination", "BT").unwrap();
    let silent = silent.to_owned();
    let concerns = Arc::new(move |message: &channels::Message| message.head() == Some(silent.as_str()));
    stage.system.disturb(Disturbance { concerns, ..Disturbance::all(channel, Effect::Lose) });
    stage
}

#[test]
fn the_leaf_that_did_not_answer_is_named() {
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = interrupted(form, "running");
        stage.long_tick(0);
        let reported: Vec<String> = stage.faults().into_iter().map(|fault| fault.message).collect();
        assert_eq!(reported, ["GoToDestination did not answer its tick within 2 s"]);

        let mut stage = interrupted(form, "halted");
        stage.long_tick(0);
        assert_eq!(stage.faults(), []);
        stage.long_tick(1);
        let reported: Vec<String> = stage.faults().into_iter().map(|fault| fault.message).collect();
        assert_eq!(reported, ["GoToDestination did not confirm that it has halted within 2 s"]);
        stage.long_tick(2);
        assert_eq!(stage.faults(), [], "faults are those of the last tick");
    }
}

#[test]
fn the_tree_waits_exactly_as_long_as_it_is_told() {
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = interrupted(form, "running");
        stage.tick();
        for (ms, waits) in [(0, true), (1_999, true), (2_000, false)] {
            stage.system.advance(Duration::from_millis(ms));
            stage.run();
            let (_, taken) = stage.system.fork().generate_tick(stage.generator);
            assert_eq!(taken, !waits, "after {ms} ms");
        }
    }
    assert_eq!(LEAF_TIMEOUT, Duration::from_secs(2));
}

#[test]
fn a_late_answer_is_dropped() {
    let (tree, script) = recharge(&[("BatteryLevel", Status::Success), ("BatteryNotCharging", Status::Success)]);
    for form in [Form::Whole, Form::Nodes] {
        let late = Effect::Hold(LEAF_TIMEOUT + Duration::from_secs(1));
        let mut stage = Stage::new(&tree, form, &script, 0, 1);
        let replies = stage.system.topology().find_channel("BatteryLevel", "BT").unwrap();
        let id = stage.system.disturb(Disturbance::all(replies, late));
        let first = stage.long_tick(0);
        assert_eq!(stage.faults().len(), 1);
        assert_eq!(stage.system.hits(id), Some(1));
        // The late success did not count: the tree went to the station.
        assert!(first.contains(&("AtRechargingStation".to_owned(), Request::Tick)));
        stage.system.calm(id);
        let second = stage.long_tick(1);
        assert!(!second.contains(&("AtRechargingStation".to_owned(), Request::Tick)));
    }
}
