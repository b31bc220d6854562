//! All schedules of the tick of the halt: whether a stop can cancel a trip that has just begun.
//!
//! The system is the shipped one without a robot: tree, skills and components are the real processes, and the driver of
//! Navigation is a program graph, which may report at any moment that the robot has arrived or will not. From the state
//! before the tick at which the level is below 30 % for the first time, every transition that some scheduler could take is
//! taken.

mod exploration;
mod model;

use exploration::{States, reachable};
use model::{Model, Protocol, TreeForm};

/// The states in which only the driver can still move, after the tick of the halt.
fn after_the_halt(model: &Model) -> States {
    let mut under_way = States::default();
    for quiet in reachable(model.tick(model.start(), 80.0)).iter().filter(|state| model.is_quiet(state)) {
        under_way.insert(quiet.fork());
    }
    assert!(under_way.iter().any(|state| model.drives_to(state, "Destination")), "the robot is on its way");
    let mut ends = States::default();
    for before in under_way.iter() {
        for end in reachable(model.tick(before.fork(), 29.0)).iter().filter(|state| model.is_quiet(state)) {
            ends.insert(end.fork());
        }
    }
    ends
}

#[test]
fn no_schedule_of_the_shipped_components_loses_the_trip_to_the_station() {
    for tree in [TreeForm::Whole, TreeForm::Nodes] {
        let model = Model::new(Protocol::Shipped, tree);
        let ends = after_the_halt(&model);
        assert!(ends.len() > 1, "the driver's reports make a difference");
        for end in ends.iter() {
            assert!(model.is_on_trip_to(end, "RechargingStation"), "{tree:?}: lost: {}", model.describe(end));
            assert!(!model.location(end, "GoToDestination").contains("running"), "{}", model.describe(end));
        }
    }
}

#[test]
fn some_schedules_of_the_original_protocol_lose_the_trip_and_others_do_not() {
    for tree in [TreeForm::Whole, TreeForm::Nodes] {
        let model = Model::new(Protocol::Original, tree);
        let ends = after_the_halt(&model);
        let lost: Vec<_> = ends.iter().filter(|end| !model.is_on_trip_to(end, "RechargingStation")).collect();
        assert!(!lost.is_empty(), "the stop overtakes the start");
        assert!(lost.len() < ends.len(), "and sometimes it does not");
        for end in lost {
            assert_eq!(model.location(end, "GotoRechargingStation"), "sendrequest", "{}", model.describe(end));
            assert_eq!(model.location(end, "Navigation"), "idle", "{}", model.describe(end));
            assert_eq!(model.location(end, "Driver"), "standing", "{}", model.describe(end));
        }
    }
}

/// What the enumeration above would not see if its start were wrong: the lock is held by the trip that is halted.
#[test]
fn the_original_protocol_takes_the_lock_before_it_starts() {
    let model = Model::new(Protocol::Original, TreeForm::Whole);
    let states = reachable(model.tick(model.start(), 80.0));
    for state in states.iter().filter(|state| model.location(state, "Navigation").starts_with("Destination")) {
        assert_eq!(model.location(state, "NavigationLock"), "held for Destination", "{}", model.describe(state));
    }
}
