//! Every number that results show of a run or a campaign, computed a second time from event logs.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod application;
mod brute_force;
mod shown;

use std::collections::BTreeMap;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use campaigns::{Plan, PlannedRun, Shard, run_and_report};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use recording::Detail;
use reports::Outputs;
use reports::results::Suite;
use runs::Run;
use scenarios::scenario::Scenario;
use serde_json::{Value, json};
use tempfile::tempdir;

use application::Application;
use brute_force::{Found, Log, nanoseconds};

static NOT: AtomicBool = AtomicBool::new(false);

/// What was drawn, to show that the draws are not all alike.
#[derive(Debug, Default)]
struct Seen(BTreeMap<&'static str, usize>);

impl Seen {
    fn count(&mut self, what: &'static str, is_so: bool) {
        *self.0.entry(what).or_default() += usize::from(is_so);
    }
}

/// A run, computed from its event log.
struct Recounted {
    found: Vec<Found>,
    vacuous: Vec<bool>,
    /// What was not as expected, in words.
    unmet: Vec<String>,
    end: u64,
    ticks: u64,
}

/// Computes a run from its event log, and compares what its results show.
fn recount(plan: &Plan, run: &PlannedRun, of: &Application, folder: &Path, seen: &mut Seen) -> Recounted {
    let scenario = Arc::new(Scenario::load(plan.scenario(), &run.overrides(plan)).unwrap());
    let record = folder.join("log.jsonl");
    let end_s = of.max_time_s[run.k as usize];
    let conducted = Run::new(Arc::clone(&scenario), run.seed, true).unwrap();
    let outputs = Outputs { folder: Some(folder.join("out")), ..Outputs::default() };
    let go_on = |_: &_| ControlFlow::Continue(());
    let report = run_and_report(conducted, Detail::Full, &outputs, Some(&record), |_| {}, go_on).unwrap();
    let log = Log::read(&fs::read_to_string(&record).unwrap(), end_s);
    let found: Vec<Found> = of
        .properties
        .iter()
        .map(|property| log.count(property, of.expected.final_for.contains(&property.name)))
        .collect();
    let vacuous = of.properties.iter().zip(&found).map(|(property, found)| log.is_vacuous(property, found.verdict));
    let vacuous: Vec<bool> = vacuous.collect();
    let silent = log.silent(scenario.skills.keys().cloned());
    let unmet = shown::unmet(of, &found, &silent);
    let shown: Value = serde_json::from_str(&fs::read_to_string(folder.join("out/report.json")).unwrap()).unwrap();
    assert_eq!(
        shown["outcome"],
        if unmet.is_empty() { "as_expected" } else { "not_as_expected" },
        "{unmet:?} {shown:#}"
    );
    assert_eq!(shown["differences"].as_array().unwrap().len(), unmet.len(), "{unmet:?} {shown:#}");
    assert_eq!((&shown["ticks"], &shown["sim_time_s"]), (&json!(log.ticks()), &json!(end_s)));
    assert_eq!(!shown["tree_failure"].is_null(), log.has_failed, "{shown:#}");
    for (place, property) in of.properties.iter().enumerate() {
        let monitor = &shown["monitors"][place];
        let is_final = of.expected.final_for.contains(&property.name);
        let context = format!("{}: {:?}, {monitor:#}", property.text, found[place]);
        assert_eq!(monitor["verdict"], found[place].verdict, "{context}");
        let at = monitor["time_s"].as_f64().zip(monitor["tick"].as_u64()).map(|(at_s, tick)| (nanoseconds(at_s), tick));
        assert_eq!(at, found[place].at, "{context}");
        assert_eq!(!monitor["vacuous"].as_array().unwrap().is_empty(), vacuous[place], "{context}");
        if let Some(lasted) = found[place].lasted {
            assert_eq!(monitor["violations"]["count"], found[place].violations, "{context}");
            assert_eq!(nanoseconds(monitor["violations"]["total_s"].as_f64().unwrap()), lasted, "{context}");
        }
        seen.count("violated", found[place].verdict == "violated");
        seen.count("violated at the end", found[place].at.is_some_and(|(at, _)| at == log.end));
        let is_due = is_final && found[place].verdict == "inconclusive";
        seen.count("inconclusive though the end is final", is_due);
        seen.count("violated again", found[place].violations > 1);
        seen.count("inconclusive", found[place].verdict == "inconclusive");
        seen.count("vacuous", vacuous[place]);
        let is_timed = property.kind.is_timed();
        seen.count("properties", true);
        seen.count("timed", is_timed);
        seen.count("timed and violated", is_timed && found[place].verdict == "violated");
        seen.count("timed and open", is_timed && found[place].verdict == "inconclusive");
        seen.count("timed and vacuous", is_timed && vacuous[place]);
    }
    seen.count("errors", !silent.is_empty());
    seen.count("a failed tree", log.has_failed);
    seen.count("not as expected", !unmet.is_empty());
    let suite = Suite::of_run(&scenario.expected(), &report, folder, &reports::results::WrittenPlaces::default());
    shown::check_cases(&suite, of, &found, &vacuous, &unmet);
    shown::check_page(&fs::read_to_string(folder.join("out/report.html")).unwrap(), &found, log.has_failed);
    Recounted { found, vacuous, unmet, end: log.end, ticks: log.ticks() }
}

/// Runs a random campaign, and compares what it shows with its runs, computed from their event logs.
fn check(seed: u64, seen: &mut Seen) {
    let folder = tempdir().unwrap();
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let application = Application::draw(folder.path(), rng);
    let plan = Plan::load(&application.campaign).unwrap();
    let out = folder.path().join("campaign");
    let ran = campaigns::run(&plan, Shard::ALL, &out, 1, &NOT, |_| {}).unwrap();
    ran.finish().unwrap();
    let runs: Vec<Recounted> =
        (0..plan.runs()).map(|k| recount(&plan, &plan.run(k), &application, folder.path(), seen)).collect();
    shown::check_campaign(&out, &application, &runs);
    shown::check_dataset(&out, &application, &runs);
}

#[test]
fn every_number_that_results_show_follows_from_event_logs() {
    let mut seen = Seen::default();
    (0..50).for_each(|seed| check(seed, &mut seen));
    assert!(seen.0.values().all(|count| *count >= 5), "{seen:?}");
    assert!(seen.0["timed"] * 20 >= seen.0["properties"], "{seen:?}");
}

#[test]
#[ignore = "takes minutes: on demand; RECOUNTS says how many applications are drawn"]
fn many_numbers_that_results_show_follow_from_event_logs_on_demand() {
    let many = std::env::var("RECOUNTS").ok().and_then(|many| many.parse().ok()).unwrap_or(3_000);
    let mut seen = Seen::default();
    (1_000..1_000 + many).for_each(|seed| check(seed, &mut seen));
    println!("{seen:?}");
}
