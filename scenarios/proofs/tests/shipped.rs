//! Proofs about shipped scenarios, with what their assumptions may be.

use diagnostics::Span;
use explorer::Order;
use tempfile::tempdir;

use crate::{assumptions, load, prove, proved, results};

const FORMS: [&str; 2] = ["execution.tree=whole", "execution.tree=nodes"];

#[test]
fn the_papers_system_behaves_as_its_scenario_says() {
    for tree in FORMS {
        let found = proved(true, "nominal", &[], &[tree]);
        assert_eq!(
            results(&found),
            [("phi1", "proved"), ("phi2", "violated"), ("phi3", "proved"), ("progress", "proved")]
        );
        let (question, answer) = &found[1];
        let run = load("nominal", &[], &[tree]).unwrap().replay(question, answer).unwrap().unwrap();
        assert!(run.events.len() > 10, "{run:#?}");
    }
}

#[test]
fn trips_may_take_9_ticks_where_the_battery_loses_1_percent_per_tick() {
    let of_phi1 = |as_expected: bool, set: &[&str]| proved(as_expected, "nominal", &["phi1"], set);
    let violated = of_phi1(false, &["prove.trips.ticks=10"]);
    assert_eq!(results(&violated), [("phi1", "violated")]);
    of_phi1(true, &["prove.trips.ticks=10", "prove.expect.phi1=violated"]);
    // Twice the drain.
    of_phi1(true, &["prove.battery.drain_pct_per_tick=2", "prove.trips.ticks=4"]);
    of_phi1(false, &["prove.battery.drain_pct_per_tick=2", "prove.trips.ticks=5"]);
}

const OR_THERE: [&str; 3] = ["properties=['properties/phi2_or_there.scope']", "prove={}", "prove.trips.passes='any'"];

#[test]
fn phi2_or_there_is_proved_for_any_battery_and_any_route() {
    for tree in FORMS {
        let found = proved(true, "nominal", &[], &[&OR_THERE[..], &[tree]].concat());
        assert_eq!(results(&found), [("phi2_or_there", "proved"), ("progress", "proved")]);
    }
}

#[test]
fn a_violation_that_takes_many_steps_is_found_depth_first() {
    let proof = load("nominal", &["phi1"], &["prove.trips.ticks=10"]).unwrap();
    assert_eq!(results(&prove(&proof, Order::Depth)), [("phi1", "violated")]);
}

#[test]
fn the_published_protocol_takes_turns_but_not_in_time() {
    for tree in FORMS {
        let found = proved(true, "takes_turns", &[], &[tree]);
        assert_eq!(results(&found), [("takes_turns", "proved"), ("stops_first", "violated"), ("progress", "proved")]);
    }
}

#[test]
fn a_guide_that_cannot_reach_a_stop_skips_it_and_does_nothing_worse() {
    let whole = proved(true, "guide", &[], &[]);
    let expected = ["shows_once", "opens_first", "locks_nobody_in", "plans_promptly"].map(|name| (name, "proved"));
    assert_eq!(results(&whole), [&[("shows_all", "violated")], &expected[..], &[("progress", "proved")]].concat());
    let fewer = ["execution.tree=nodes", "prove.trips.fail=false", "prove.messages={}", "prove.expect={}"];
    let nodes = proved(true, "guide", &["opens_first"], &fewer);
    assert_eq!(results(&nodes), [("opens_first", "proved")]);
}

#[test]
fn unreached_items_do_not_depend_on_the_form_of_the_tree() {
    let [whole, nodes] = FORMS.map(|tree| {
        let found = proved(true, "nominal", &["progress"], &[tree]);
        let unreached = found[0].1.unreached.iter().flatten();
        let file = |place: &Span| (place.source().name().to_owned(), place.line());
        unreached.map(|it| (it.kind, it.words.clone(), file(&it.place))).collect::<Vec<_>>()
    });
    assert_eq!(whole, nodes);
}

#[test]
fn a_message_may_be_delivered_twice() {
    let repeat =
        "prove.messages={repeat=1, on=[['ControllerServer', 'FollowPath'], ['FollowPath', 'ControllerServer']]}";
    let said = assumptions(&load("nav2/halted_early_fixed", &[], &[repeat]).unwrap()).swap_remove(0);
    assert!(said.ends_with("FollowPath → ControllerServer, 1 may be delivered twice."), "{said}");
    let found = proved(true, "nav2/halted_early_fixed", &[], &[repeat]);
    assert_eq!(results(&found), [("stands_still", "proved"), ("progress", "proved")]);
}

#[test]
fn drivers_may_act_anywhere() {
    let found = proved(true, "nominal", &[], &[&OR_THERE[..], &["prove.drivers=anywhere"]].concat());
    assert_eq!(results(&found), [("phi2_or_there", "proved"), ("progress", "proved")]);
    let between = proved(true, "nominal", &[], &OR_THERE);
    let [anywhere, between] = [found, between].map(|found| found[0].1.exploration.progress.states);
    assert!(anywhere > 2 * between, "more can happen");
}

#[test]
fn a_machine_stands_in_for_a_component() {
    let folder = tempdir().unwrap();
    let machine = folder.path().join("Refusing.scxml");
    let text = "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\">\n\
                <state id=\"here\"><transition event=\"follow_path.goal\"><send type=\"channel\" \
                targetexpr=\"_event.origin\" event=\"follow_path.rejected\"/></transition>\n\
                <transition event=\"follow_path.cancel\"/></state></scxml>";
    std::fs::write(&machine, text).unwrap();
    let stand_in = format!("prove.components.ControllerServer.machine='{}'", machine.display());
    let set = [stand_in.as_str(), "prove.expect.stands_still=proved"];
    let found = proved(true, "nav2/halted_early", &[], &set);
    assert_eq!(results(&found)[0], ("stands_still", "proved"), "it never drives");
    let assumed = assumptions(&load("nav2/halted_early", &[], &set).unwrap());
    assert_eq!(assumed.iter().filter(|it| it.starts_with("ControllerServer behaves as")).count(), 1, "{assumed:#?}");
}
