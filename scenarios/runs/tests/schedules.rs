//! All schedules of the tick at which a trip is halted: whether a stop can cancel a trip that has just begun.
//!
//! The system is the real one, but without a robot: tree, skills and components are the real processes, and
//! Navigation's driver is a program graph, which may report at any moment that the robot has arrived or will not
//! arrive. From the start until a second after the tick at which the level is below 30 % for the first time, every
//! transition that some scheduler could take is taken; the same goes for one more second, in which the level is high
//! again.

mod exploration;
#[path = "../../../channels/tests/system/lockstep.rs"]
mod lockstep;
mod model;

use std::time::Duration;

use channels::{ChannelSystem, Random, RoundRobin};
use exploration::States;
use lockstep::Lockstep;
use model::{Model, Protocol, TreeForm, Trips};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const FORMS: [TreeForm; 2] = [TreeForm::Whole, TreeForm::Nodes];
const STATION: &str = "RechargingStation";

/// The states a second after the tick of the halt: those in which the trip to the station goes on, and those in which
/// it is lost.
fn after_the_halt(model: &Model) -> (States, States) {
    let under_way = model.first_second();
    assert!(under_way.iter().any(|state| model.drives_to(state, "Destination")), "the robot is on its way");
    split(&model.second(1, &under_way, 29.0), |end| model.is_on_trip_to(end, STATION))
}

/// The states for which this is true, and the others.
fn split(states: &States, is_so: impl Fn(&ChannelSystem) -> bool) -> (States, States) {
    let (so, not): (Vec<_>, Vec<_>) = states.iter().partition(|state| is_so(state));
    [so, not].map(|states| states.into_iter().map(ChannelSystem::fork).collect()).into()
}

/// Whether some schedules keep the trip, and whether some lose it, for each form of the tree.
fn depends_on_the_schedule(protocol: Protocol, trips: Trips) -> [(bool, bool); 2] {
    FORMS.map(|form| {
        let (kept, lost) = after_the_halt(&Model::new(protocol, form, trips));
        (kept.len() > 0, lost.len() > 0)
    })
}

#[test]
fn no_schedule_of_the_shipped_skills_loses_the_trip_to_the_station() {
    for form in FORMS {
        let model = Model::new(Protocol::Shipped, form, Trips::Ending);
        let (kept, lost) = after_the_halt(&model);
        assert!(kept.len() > 1, "the driver's reports make a difference");
        assert_eq!(lost.len(), 0, "{form:?}: {:?}", lost.iter().map(|state| model.describe(state)).next());
        for end in kept.iter() {
            assert!(!model.location(end, "GoToDestination").contains("running"), "{}", model.describe(end));
        }
    }
}

#[test]
fn no_schedule_of_the_published_protocol_loses_the_trip_while_the_robot_is_on_its_way() {
    for form in FORMS {
        let model = Model::new(Protocol::Original, form, Trips::Endless);
        let (kept, lost) = after_the_halt(&model);
        assert_eq!(lost.len(), 0, "{form:?}: {:?}", lost.iter().map(|state| model.describe(state)).next());
        for end in kept.iter() {
            assert_eq!(model.location(end, "Blackboard"), "navigation: 0", "the station's trip has the resource");
            assert_eq!(model.location(end, "GoToDestination"), "idle", "{}", model.describe(end));
        }
    }
}

/// The halt of a trip that has ended ends the one that has just begun, and no skill recovers from a failure.
#[test]
#[ignore = "long: .ci/run runs it"]
fn some_schedules_of_the_published_protocol_lose_the_trip_when_the_previous_one_has_just_ended() {
    for form in FORMS {
        let model = Model::new(Protocol::Original, form, Trips::Ending);
        let (kept, mut lost) = after_the_halt(&model);
        assert!(kept.len() > 0 && lost.len() > 0, "{} kept, {} lost", kept.len(), lost.len());
        for second in 2..5 {
            for end in lost.iter() {
                assert!(!model.is_on_trip_to(end, STATION), "{}", model.describe(end));
                assert_eq!(model.location(end, "GotoRechargingStation"), "failure", "{}", model.describe(end));
                assert_eq!(model.location(end, "Navigation"), "idle", "{}", model.describe(end));
                assert_eq!(model.location(end, "Driver"), "standing", "{}", model.describe(end));
                assert_eq!(model.location(end, "Blackboard"), "navigation: 1", "{}", model.describe(end));
            }
            lost = model.second(second, &lost, 29.0);
        }
    }
}

/// The tree stops only skills that it considers running, and starts only idle ones.
#[test]
#[ignore = "long: .ci/run runs it"]
fn the_published_protocol_does_not_restart_an_action_whose_end_the_tree_has_seen() {
    for form in FORMS {
        for (protocol, some_end) in [(Protocol::Shipped, false), (Protocol::Original, true)] {
            let model = Model::new(protocol, form, Trips::Ending);
            let has_ended = |state: &ChannelSystem| {
                protocol == Protocol::Original
                    && ["success", "failure"].contains(&model.location(state, "GoToDestination").as_str())
            };
            let (ended, idle) = split(&after_the_halt(&model).0, has_ended);
            assert!(idle.len() > 0 && (ended.len() > 0) == some_end, "{} ended, {} idle", ended.len(), idle.len());
            for (states, resumes) in [(ended, false), (idle, true)] {
                for end in model.second(2, &states, 80.0).iter() {
                    assert_eq!(model.is_on_trip_to(end, "Destination"), resumes, "{}", model.describe(end));
                }
            }
        }
    }
}

/// The reason why the trip is lost: the published component does not check whose trip it ends.
#[test]
fn no_schedule_loses_the_trip_if_a_stop_ends_only_its_own_trip() {
    assert_eq!(depends_on_the_schedule(Protocol::OwnTrips, Trips::Ending), [(true, false); 2]);
}

/// The enumeration would have found a trip lost on the way: it finds the one that a single wrong order of calls loses.
#[test]
fn some_schedules_lose_the_trip_if_the_resource_is_released_before_navigation_is_halted() {
    assert_eq!(depends_on_the_schedule(Protocol::EarlyRelease, Trips::Endless), [(true, true); 2]);
}

#[test]
fn the_shipped_system_and_its_normal_form_are_indistinguishable() {
    for (form, protocol) in
        FORMS.into_iter().flat_map(|form| [Protocol::Shipped, Protocol::Original].map(|p| (form, p)))
    {
        let model = Model::new(protocol, form, Trips::Ending);
        let (system, generator) = model.start();
        let mut pair = Lockstep::new(&system, Duration::ZERO);
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut scheduler = Random::new(ChaCha8Rng::seed_from_u64(8));
        let mut delivered = 0;
        for _ in 0..60 {
            let now = random.next_u64();
            let (charge_pct, charging, is_there) = ([80.0, 50.0, 29.0][now as usize % 3], now % 5 == 0, now % 7 < 3);
            pair.with(|system| model.sense(system, charge_pct, charging, is_there));
            delivered += usize::from(pair.tick(generator));
            for _ in 0..10 {
                // Time may pass while messages are under way.
                for _ in 0..random.next_u64() % 60 {
                    pair.step(&mut scheduler);
                }
                pair.advance(Duration::from_millis(100));
            }
        }
        assert!(delivered > 20, "{form:?}, {protocol:?}: {delivered} ticks are taken");
    }
}

#[test]
fn a_day_of_the_shipped_system_has_as_many_normal_forms_as_its_first_hours() {
    let ticks_per_day = 24 * 60 * 6;
    for form in FORMS {
        let model = Model::new(Protocol::Shipped, form, Trips::Ending);
        let (mut system, generator) = model.start();
        let mut scheduler = RoundRobin::default();
        let (mut quiet, mut early) = (States::default(), 0);
        for tick in 0..ticks_per_day {
            let (charge_pct, charging, is_there) = match tick % 40 {
                0..20 => (80.0, false, false),
                20..25 => (29.0, false, false),
                25..35 => (50.0, true, true),
                _ => (90.0, true, true),
            };
            model.sense(&mut system, charge_pct, charging, is_there);
            for half in 0..4 {
                system.advance(Duration::from_secs(10) * tick + Duration::from_millis(500) * half);
                if half == 0 {
                    assert!(system.generate_tick(generator).1, "the previous tick is finished");
                }
                system.run(&mut scheduler, 10_000).for_each(|event| drop(event.unwrap()));
            }
            let mut state = system.fork();
            state.normalize().unwrap_or_else(|(id, why)| panic!("{}: {why}", system.topology().name(id)));
            quiet.insert(state);
            if tick == ticks_per_day / 8 {
                early = quiet.len();
            }
        }
        assert!((4..=20).contains(&early), "{form:?}: {early}");
        assert_eq!(quiet.len(), early, "{form:?}");
    }
}
