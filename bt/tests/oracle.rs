//! The engine against an independent oracle: one object per node, with the methods that BehaviorTree.CPP documents
//! (`executeTick`, `haltNode`, `resetStatus`), calling each other recursively. It covers everything that depends
//! neither on time nor on arbitrary scripts.

mod controls;
mod decorators;
mod object;

use bt::{Execution, Leaves, NodeState, Progress, Reply, Request, Status};
use std::time::Duration;

use proptest::prelude::*;

use crate::NOW;
use crate::forest::{Cast, KEY, script, script_with_skips, spec, wild_tree};
use object::Oracle;

#[derive(Clone, Copy, Debug)]
enum Order {
    Tick,
    HaltTree,
}

fn orders() -> impl Strategy<Value = Vec<Order>> {
    prop::collection::vec(prop_oneof![8 => Just(Order::Tick), 1 => Just(Order::HaltTree)], 1..30)
}

/// The value written to the blackboard before each order, if any.
fn writes() -> impl Strategy<Value = Vec<Option<i64>>> {
    prop::collection::vec(prop::option::weighted(0.3, 0..3_i64), 30)
}

fn statuses(execution: &Execution) -> Vec<Option<Status>> {
    execution.states().into_iter().map(|NodeState { status, .. }| status).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_engine_agrees_with_the_oracle(
        spec in spec(), script in script_with_skips(), orders in orders(), writes in writes(),
    ) {
        let tree = spec.tree();
        let mut oracle = Oracle::new(&spec, &script);
        let mut cast = Cast::new(&tree, &script);
        let mut execution = Execution::new(tree);
        execution.blackboard_mut().set(KEY, "0").unwrap();
        for (order, written) in orders.into_iter().zip(writes) {
            if let Some(number) = written {
                execution.blackboard_mut().set(KEY, number.to_string().as_str()).unwrap();
                oracle.write(number);
            }
            match order {
                Order::Tick => match oracle.tick_once() {
                    Some(status) => prop_assert_eq!(execution.tick(NOW, &mut cast), status),
                    // The engine eventually gives up, which BehaviorTree.CPP does not.
                    None => return Ok(()),
                },
                Order::HaltTree => {
                    execution.halt(NOW, &mut cast);
                    oracle.halt_tree();
                }
            }
            prop_assert_eq!(cast.calls(), oracle.calls());
            prop_assert_eq!(statuses(&execution), oracle.statuses());
        }
    }

    #[test]
    fn a_tick_from_call_to_call_is_the_same_tick(spec in spec(), script in script(), orders in orders()) {
        let tree = spec.tree();
        let (mut cast, mut others) = (Cast::new(&tree, &script), Cast::new(&tree, &script));
        let (mut whole, mut split) = (Execution::new(tree.clone()), Execution::new(tree));
        for order in orders {
            let mut step = match order {
                Order::Tick => split.start_tick(NOW),
                Order::HaltTree => split.start_halt(NOW),
            };
            while let Some(Progress::Call(call)) = step {
                prop_assert_eq!(split.start_tick(NOW), None);
                let (wrong, reply) = match call.request {
                    Request::Tick => (Reply::Halted, Reply::Status(others.tick(split.leaf(call.leaf, NOW)))),
                    Request::Halt => {
                        others.halt(split.leaf(call.leaf, NOW));
                        (Reply::Status(Status::Success), Reply::Halted)
                    }
                };
                prop_assert_eq!(split.resume(NOW, wrong), None);
                // A copy taken here continues alone, and behaves like the original.
                let mut copy = split.clone();
                prop_assert_eq!(&copy, &split);
                step = split.resume(NOW, reply);
                prop_assert_eq!(copy.resume(NOW, reply), step);
                prop_assert_eq!(&copy, &split);
            }
            let done = match order {
                Order::Tick => Progress::Done(whole.tick(NOW, &mut cast)),
                Order::HaltTree => {
                    whole.halt(NOW, &mut cast);
                    Progress::Halted
                }
            };
            prop_assert_eq!(step, Some(done));
            prop_assert_eq!(&whole, &split);
            prop_assert_eq!(cast.calls(), others.calls());
        }
    }

    #[test]
    fn a_random_tree_does_the_same_from_call_to_call(
        tree in wild_tree(), script in script(), orders in orders(),
    ) {
        let (mut cast, mut others) = (Cast::new(&tree, &script), Cast::new(&tree, &script));
        let mut whole = Execution::new(tree.clone());
        let mut split = Execution::new(tree);
        for (count, order) in (0..).zip(orders) {
            let now = Duration::from_millis(100 * count);
            let mut step = match order {
                Order::Tick => split.start_tick(now),
                Order::HaltTree => split.start_halt(now),
            };
            while let Some(Progress::Call(call)) = step {
                prop_assert_eq!(split.pending(), Some(call));
                let reply = match call.request {
                    Request::Tick => Reply::Status(others.tick(split.leaf(call.leaf, now))),
                    Request::Halt => {
                        others.halt(split.leaf(call.leaf, now));
                        Reply::Halted
                    }
                };
                let mut copy = split.clone();
                step = split.resume(now, reply);
                prop_assert_eq!(copy.resume(now, reply), step);
                prop_assert_eq!(&copy, &split);
            }
            match order {
                Order::Tick => prop_assert_eq!(step, Some(Progress::Done(whole.tick(now, &mut cast)))),
                Order::HaltTree => {
                    whole.halt(now, &mut cast);
                    prop_assert_eq!(step, Some(Progress::Halted));
                }
            }
            prop_assert_eq!(&whole, &split);
            prop_assert_eq!(cast.calls(), others.calls());
        }
    }

    #[test]
    fn a_tick_in_progress_can_be_finished_at_once(spec in spec(), script in script(), stop in 0..6_usize) {
        let tree = spec.tree();
        let mut cast = Cast::new(&tree, &script);
        let mut execution = Execution::new(tree);
        for _ in 0..4 {
            let mut expected = execution.clone();
            let mut expected_cast = cast.understudy();
            let status = expected.tick(NOW, &mut expected_cast);

            let mut step = execution.start_tick(NOW);
            for _ in 0..stop {
                let Some(Progress::Call(call)) = step else { break };
                let reply = match call.request {
                    Request::Tick => Reply::Status(cast.tick(execution.leaf(call.leaf, NOW))),
                    Request::Halt => {
                        cast.halt(execution.leaf(call.leaf, NOW));
                        Reply::Halted
                    }
                };
                step = execution.resume(NOW, reply);
            }
            if let Some(Progress::Call(_)) = step {
                prop_assert_eq!(execution.tick(NOW, &mut cast), status);
            }
            prop_assert_eq!(cast.calls(), expected_cast.calls());
            prop_assert_eq!(&execution, &expected);
        }
    }
}
