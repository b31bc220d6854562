//! What a view of a run shows, and which records it refuses.

use std::sync::Arc;
use std::time::Duration;

use channels::Verdict;
use monitors::Outcome;
use recording::{Decision, Details, End, Happening, Header, MonitorState, Node, RobotState, RunView, Scene, Step};
use robot::LaserScan;

use crate::drive::{DT, end, fault, header, level, robot, start, steps, until};

/// A step after the start with these happenings.
fn with(happenings: Vec<Happening>) -> Step {
    Step { time: DT, happenings, ..Step::default() }
}

#[test]
fn a_robot_that_stands_at_a_place_from_the_start_has_not_arrived_there() {
    let view = until(300);
    let visits: Vec<_> = view.visits().collect();
    assert_eq!(visits, [("start", Some(DT)), ("hall", None), ("kitchen", Some(300 * DT))]);
    assert_eq!(view.arrivals().collect::<Vec<_>>(), [("kitchen", 300 * DT)]);
    // In the second step it may also have come from elsewhere.
    let mut slow = RunView::new(Header { dt: 2 * DT, ..header() }, Step::default()).unwrap();
    assert!(!slow.is_arrival(2 * DT) && slow.is_arrival(3 * DT));
    slow.apply(Step { time: 4 * DT, ..with(vec![Happening::Arrival { place: 1 }]) }).unwrap();
    assert_eq!(slow.arrivals().collect::<Vec<_>>(), [("hall", 4 * DT)]);
}

#[test]
fn a_robot_that_comes_back_to_its_start_has_arrived_there() {
    let mut view = until(300);
    view.apply(Step { time: 400 * DT, ..with(vec![Happening::Arrival { place: 0 }]) }).unwrap();
    assert_eq!(view.arrivals().next(), Some(("start", 400 * DT)));
}

#[test]
fn a_fault_that_has_not_been_due_is_absent() {
    assert_eq!(until(50).absent_faults().count(), 1);
    assert_eq!(until(120).absent_faults().count(), 0);
}

#[test]
fn a_place_is_entered_on_the_way_without_an_arrival() {
    let view = until(300);
    let entries: Vec<_> = view.entered().map(|(name, at)| (name, at.unwrap().as_secs_f64())).collect();
    // Half a meter per second: the hall begins at 1 m, the kitchen at 3 m with a tolerance of 0.3 m.
    assert_eq!(entries[0], ("start", 0.0));
    assert!((entries[1].1 - 2.0).abs() < 0.03 && (entries[2].1 - 5.4).abs() < 0.03, "{entries:?}");
}

#[test]
fn a_view_has_the_present_state_and_the_history_that_readers_need() {
    let mut view = until(120);
    assert_eq!((view.time(), view.ticks()), (120 * DT, 2));
    assert_eq!(view.doing(), "BatteryLevel is running");
    let [fault] = view.faults() else { panic!("{:?}", view.faults()) };
    assert_eq!((fault.time, fault.until, fault.tick), (100 * DT, None, Some(1)));
    // What a step does not mention stays as it was.
    view.apply(Step { time: 121 * DT, communications: 2, ..Step::default() }).unwrap();
    assert_eq!(view.robot().truth.unwrap().distance_m, 1.2);
    assert_eq!(view.navigation().unwrap().words(), "moving: since step 110");
    assert!(view.new_scene().is_none() && view.scene().bodies.len() == 1);
    assert_eq!(view.seen_from(), until(110).robot().pose());

    let view = until(200);
    assert_eq!(view.faults()[0].until, Some(200 * DT));
    let phi1 = view.monitor(0);
    assert_eq!((phi1.outcome(), phi1.violation().unwrap().event.time), (Outcome::Violated, 200 * DT));
    assert_eq!(phi1.state.location, "idle", "a verdict changes nothing else");
}

#[test]
fn a_verdict_without_details_is_a_verdict() {
    let mut view = start();
    let decision = Decision { verdict: Verdict::False, event: level(DT, 10.0), witness: None };
    view.apply(with(vec![Happening::Verdict { monitor: 0, decision }])).unwrap();
    assert_eq!(view.monitor(0).outcome(), Outcome::Violated);
}

#[test]
fn battery_and_localization_are_summed_up_over_all_steps() {
    let tally = until(300).tally().clone();
    let battery = tally.battery().unwrap();
    assert_eq!(battery.initial_pct, 80.0);
    assert!((battery.minimum_pct - 74.0).abs() < 1e-9);
    let error = tally.localization_error().unwrap();
    assert!((error.rmse_m - 0.5).abs() < 1e-12 && (error.max_m - 0.5).abs() < 1e-12 && error.rmse_rad == 0.0);
    // A step that changes nothing counts: it is as long as the others.
    let mut view = start();
    let exact = RobotState { estimate: Some(maps::pose(0.0, 0.0, 0.0)), ..RobotState::default() };
    view.apply(Step { time: DT, robot: exact, ..Step::default() }).unwrap();
    (2..=4).for_each(|number| view.apply(Step { time: number * DT, ..Step::default() }).unwrap());
    view.apply(Step { time: 5 * DT, robot: robot(0.0, 80.0), ..Step::default() }).unwrap();
    let rmse_m = view.tally().localization_error().unwrap().rmse_m;
    assert!((rmse_m - (0.25_f64 / 5.0).sqrt()).abs() < 1e-12, "{rmse_m}");
}

#[test]
fn levels_are_unknown_once_messages_were_not_recorded() {
    let channel = start().topology().channels().next().unwrap();
    let mut view = until(70);
    let heard = view.heard(channel).unwrap().unwrap();
    assert_eq!((heard.lowest_pct, heard.last), (80.0 - 1.2, 60 * DT));
    view.apply(Step { time: 71 * DT, communications: 1, ..Step::default() }).unwrap();
    assert!(view.heard(channel).is_some(), "nothing was received in this step");
    view.apply(Step { time: 72 * DT, communications: 3, ..Step::default() }).unwrap();
    assert_eq!(view.heard(channel), None);
}

#[test]
fn occurrences_of_a_fault_are_one_course() {
    let mut view = until(200);
    let began = |time| Happening::FaultBegan { fault: 0, time, tick: None, position: None };
    view.apply(Step { time: 201 * DT, ..with(vec![Happening::FaultAdded(Arc::new(fault("it tips over")))]) }).unwrap();
    view.apply(Step { time: 202 * DT, ..with(vec![began(202 * DT)]) }).unwrap();
    let other = Happening::FaultBegan { fault: 1, time: 203 * DT, tick: None, position: None };
    view.apply(Step { time: 203 * DT, ..with(vec![other]) }).unwrap();
    let courses = view.fault_courses();
    let words: Vec<String> = courses.iter().map(|course| course.words()).collect();
    assert_eq!(words, ["the wheels slip (2 times)", "it tips over"]);
    assert_eq!(courses[0].first().time, 100 * DT);
}

#[test]
fn what_happened_is_put_into_words() {
    let view = start();
    let (time, reason) = (DT, "no body".to_owned());
    let decided = |verdict| Decision { verdict, event: level(time, 10.0), witness: None };
    for (happening, words) in [
        (Happening::FaultAdded(Arc::new(fault("a push"))), "manually: a push"),
        (Happening::FaultBegan { fault: 0, time, tick: None, position: None }, "the wheels slip"),
        (Happening::FaultEnded { fault: 0, time }, "ended: the wheels slip"),
        (Happening::FaultLeftUndone { fault: 0, time, reason }, "could not be done: the wheels slip: no body"),
        (Happening::TreeError { node: 1, message: "no such port".to_owned(), tick: 3 }, "no such port"),
        (Happening::GivenUp { reason: "no path".to_owned() }, "navigation gave up: no path"),
        (Happening::Verdict { monitor: 0, decision: decided(Verdict::False) }, "phi1 is violated"),
        (Happening::Verdict { monitor: 0, decision: decided(Verdict::True) }, "phi1 is satisfied"),
        (Happening::Said { by: 0, text: "hello".to_owned() }, "“hello”"),
        (Happening::Moved { words: "the door closes".to_owned() }, "the door closes"),
        (Happening::Arrival { place: 2 }, "at kitchen"),
    ] {
        assert_eq!(happening.words(&view), words);
    }
}

/// Whether a step is refused after the start.
fn is_refused(step: Step) -> bool {
    start().apply(step).is_err()
}

#[test]
fn records_that_refer_to_what_does_not_exist_are_refused() {
    let time = DT;
    let decision = Decision { verdict: Verdict::False, event: level(time, 10.0), witness: None };
    for happening in [
        Happening::FaultBegan { fault: 1, time, tick: None, position: None },
        Happening::FaultEnded { fault: 0, time },
        Happening::FaultLeftUndone { fault: 1, time, reason: String::new() },
        Happening::TreeError { node: 2, message: String::new(), tick: 0 },
        Happening::Verdict { monitor: 1, decision },
        Happening::Said { by: 3, text: String::new() },
        Happening::Arrival { place: 3 },
    ] {
        assert!(is_refused(with(vec![happening.clone()])), "{happening:?}");
    }
    let active = MonitorState { active: Some(0), ..MonitorState::default() };
    let scan = LaserScan { time, laser: 1, ranges_m: Vec::new() };
    let scene = Scene { scans: vec![Arc::new(scan)], ..Scene::default() };
    for details in [
        Details { outcomes: vec![(2, None)], ..Details::default() },
        Details { locations: vec![(3, "idle".to_owned())], ..Details::default() },
        Details { monitors: vec![(1, MonitorState::default())], ..Details::default() },
        Details { monitors: vec![(0, active)], ..Details::default() },
        Details { scene: Some(Arc::new(scene)), ..Details::default() },
    ] {
        assert!(is_refused(Step { details: Some(Box::new(details.clone())), ..with(vec![]) }), "{details:?}");
    }
    let mut later = until(1);
    assert!(later.apply(Step { time: Duration::ZERO, ..Step::default() }).is_err(), "it goes back in time");
    for wrong in [End { monitors: Vec::new(), ..end() }, End { messages_hit: Vec::new(), ..end() }] {
        assert!(start().finish(wrong).is_err());
    }
    let circle = Node { parent: Some(1), process: String::new(), symbol: None, is_leaf: true };
    let tree = vec![header().tree.remove(0), circle];
    assert!(RunView::new(Header { tree, ..header() }, steps().swap_remove(0)).is_err(), "it is its own parent");
}
