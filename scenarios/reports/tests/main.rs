//! The page of a run, as a text. The tests of the command line open it in a browser.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::error;
use std::ops::ControlFlow;
use std::sync::Arc;

use recording::{Detail, RunView, conduct};
use reports::{Outputs, Presentation, html};
use runs::Run;
use scenarios::scenario::{Scenario, find};
use serde_json::{Value, json};
use tempfile::tempdir;

/// The report of a run of a scenario with these settings, and its page; if no seed is given, with that of the scenario.
fn report(scenario: &str, seed: Option<u64>, set: &[&str], snapshots: bool) -> (Value, String) {
    let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    let scenario = Arc::new(Scenario::load(&find::find(scenario).unwrap(), &set).unwrap());
    let seed = seed.unwrap_or(scenario.file.seed);
    let run = Run::new(scenario, seed, true).unwrap();
    let out = tempdir().unwrap();
    let outputs = Outputs { folder: Some(out.path().to_owned()), snapshots, ..Outputs::default() };
    let begin = |view: &RunView| Ok::<_, Box<dyn error::Error>>(Presentation::begin(view, &outputs)?);
    let (presentation, view) = conduct(run, Detail::Full, None, begin, |_| ControlFlow::Continue(())).unwrap();
    let report = json!(presentation.finish(&view).unwrap());
    (report, std::fs::read_to_string(out.path().join(html::FILE)).unwrap())
}

#[test]
fn messages_before_the_obligation_are_mentioned() {
    let (_, page) = report("faults/halt_lost", None, &[], false);
    assert!(page.contains("one from GotoRechargingStation to Navigation, before one was due"), "{page}");
    let before = "the last message before that was <code>[&lt;start_navigation&gt;, &lt;RechargingStation&gt;]</code>";
    assert!(page.contains(before), "{page}");
}

#[test]
fn the_page_is_one_file_and_the_same_every_time() {
    let pages = ["a", "b"].map(|_| report("battery_fault", Some(7), &["battery.initial_pct=70"], true).1);
    assert!(pages[0] == pages[1], "two runs of one seed give the same page");
    for elsewhere in ["src=\"http", "href=\"http", "url(http", "@import", "<script src"] {
        assert!(!pages[0].contains(elsewhere), "the page has {elsewhere}");
    }
    let options =
        ["--seed 7", "--set battery.initial_pct=70"].map(|option| format!("<span class=\"option\">{option}</span>"));
    let command = format!("steward run battery_fault {}</code>", options.join(" "));
    assert!(pages[0].contains(&command), "the page says how to run it again");
    let sections = ["violations", "verdicts", "way", "timeline", "pictures", "parameters", "reproduce"];
    let places = sections.map(|id| pages[0].find(&format!("<section id=\"{id}\">")));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
}

#[test]
fn what_went_wrong_comes_first_with_time_place_level_and_picture() {
    let (report, page) = report("battery_fault", None, &["snapshots={}"], true);
    let [picture] = report["snapshots"].as_array().unwrap().as_slice() else { panic!("{report}") };
    assert_eq!(picture["violated"], "phi1", "a violation has a picture in any case");
    let (before, rest) = page.split_once("<section id=\"violations\">").unwrap();
    let (wrong, verdicts) = rest.split_once("<section id=\"verdicts\">").unwrap();
    assert!(before.contains("phi1 violated; phi2, phi3 satisfied; the robot came to rest at RechargingStation."));
    for part in
        ["tick 21, 21.02 s", " m from start", "10\u{a0}%", "data:image/png;base64,", "at 46.02 s, the tree began"]
    {
        assert!(wrong.contains(part), "{part}: {wrong}");
    }
    assert_eq!(verdicts.matches("<details class=\"line ").count(), 3);
    assert!(!verdicts.contains("data:image/png"), "one picture, shown once");
}

#[test]
fn a_robot_that_crosses_a_zone_is_in_it_and_not_violating_for_good() {
    let (all, page) = report("faults/zone_ignored", None, &["snapshots={}"], true);
    let monitor = all["monitors"].as_array().unwrap().iter().find(|one| one["name"] == "respects_WetFloor").unwrap();
    assert_eq!((&monitor["verdict"], &monitor["expected"]), (&"violated".into(), &"violated".into()));
    let (_, wrong) = page.split_once("<section id=\"violations\">").unwrap();
    let (wrong, _) = wrong.split_once("</section>").unwrap();
    assert!(wrong.contains(" m), at WetFloor</dd>"), "{wrong}");
    assert!(
        wrong.contains("This is what <code>respects_WetFloor</code> forbids.") && !wrong.contains("for good"),
        "{wrong}"
    );
}

#[test]
fn an_answer_that_is_missing_has_the_value_that_was_remembered() {
    let asked = "always ((GoToDestination, Navigation, m[1] = <start_navigation> and place as p) implies \
                 time_until (GotoRechargingStation, Navigation, m[1] = <get_status> and place = p) < 3 s)";
    let expect = format!("expect={{phi1=\"violated\",back=\"violated\",satisfied={{back=\"{asked}\"}}}}");
    let (_, page) = report("battery_fault", None, &[&expect], false);
    assert!(page.contains("had to tell Navigation <code>[&lt;get_status&gt;, &lt;Destination&gt;]</code> by tick 2"));
}
