//! What results show, compared with what was counted.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use reports::results::{CaseResult, Suite};
use serde_json::Value;

use crate::Recounted;
use crate::application::Application;
use crate::brute_force::{Found, interval, nanoseconds};

/// The expectations that a run did not meet, in words: one for each verdict, and each leaf with or without an error.
pub(crate) fn unmet(of: &Application, found: &[Found], silent: &[String]) -> Vec<String> {
    let mut unmet = Vec::new();
    for (property, found) in of.properties.iter().zip(found) {
        let expected =
            of.expected.verdicts.iter().find(|(name, _)| *name == property.name).map(|(_, verdict)| *verdict);
        let name = &property.name;
        match expected {
            Some("any") => {}
            Some(expected) if expected == found.verdict => {}
            Some(expected) => unmet.push(format!("{name} to be {expected}")),
            None if found.verdict == "violated" => unmet.push(format!("{name} not to be violated")),
            None => {}
        }
    }
    unmet.extend(
        of.expected.errors.iter().filter(|leaf| !silent.contains(leaf)).map(|leaf| format!("an error in {leaf}")),
    );
    let unnamed = silent.iter().filter(|leaf| !of.expected.errors.contains(leaf));
    unmet.extend(unnamed.map(|leaf| format!("no error in the tree node {leaf}")));
    unmet
}

/// The cases of JUnit.
pub(crate) fn check_cases(suite: &Suite, of: &Application, found: &[Found], vacuous: &[bool], unmet: &[String]) {
    for (place, property) in of.properties.iter().enumerate() {
        let name = &property.name;
        let case = suite.cases.iter().find(|case| case.group == "properties" && case.name == *name).unwrap();
        let is_named = of.expected.verdicts.iter().any(|(other, verdict)| other == name && *verdict != "any");
        let differs = unmet.iter().any(|words| words.starts_with(&format!("{name} ")));
        let is_open = found[place].verdict != "satisfied" || vacuous[place];
        let wanted = match (differs, is_named) {
            (true, _) => "failed",
            (false, true) => "passed",
            (false, false) if is_open => "skipped",
            (false, false) => "passed",
        };
        let result = match case.result {
            CaseResult::Passed => "passed",
            CaseResult::Skipped(_) => "skipped",
            CaseResult::Failed { .. } | CaseResult::Error(_) => "failed",
        };
        assert_eq!(result, wanted, "{}: {:?}", property.text, case.result);
    }
    let failed = |group: &str| suite.cases.iter().filter(|case| case.group == group && case.result.is_bad()).count();
    assert_eq!(failed("expectations"), unmet.len());
}

/// The verdicts on the page of a run.
pub(crate) fn check_page(page: &str, found: &[Found], has_failed: bool) {
    for verdict in ["satisfied", "violated", "inconclusive"] {
        let count = found.iter().filter(|found| found.verdict == verdict).count();
        assert_eq!(page.matches(&format!("<details class=\"line {verdict}\"")).count(), count, "{verdict}");
    }
    assert_eq!(page.contains("never failed"), !has_failed);
}

/// The summary and the page of a campaign.
pub(crate) fn check_campaign(out: &Path, of: &Application, runs: &[Recounted]) {
    let summary: Value = serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let all = runs.len() as u64;
    let not = runs.iter().filter(|run| !run.unmet.is_empty()).count() as u64;
    let outcomes = &summary["outcomes"];
    assert_eq!([&outcomes["as_expected"], &outcomes["not_as_expected"], &outcomes["failed"]], [all - not, not, 0]);
    let mut unmet: BTreeMap<&str, u64> = BTreeMap::new();
    runs.iter().flat_map(|run| &run.unmet).for_each(|words| *unmet.entry(words).or_default() += 1);
    let shown = summary["unmet"].as_array().unwrap().iter();
    let shown = shown.map(|one| (one["expected"].as_str().unwrap(), one["runs"].as_u64().unwrap())).collect();
    assert_eq!(unmet, shown);
    check_share(
        &summary["expectation"]["count"],
        &summary["expectation"]["rate"],
        &summary["expectation"]["interval"],
        not,
        all,
    );
    let hours = runs.iter().map(|run| run.end).sum::<u64>() as f64 / 3.6e12;
    for (place, property) in of.properties.iter().enumerate() {
        let count = |is_so: &dyn Fn(&Recounted) -> bool| runs.iter().filter(|run| is_so(run)).count() as u64;
        let [violated, open] =
            ["violated", "inconclusive"].map(|verdict| count(&|run| run.found[place].verdict == verdict));
        let of = &summary["properties"][place];
        assert_eq!(of["of"], property.name.as_str());
        check_share(&of["count"], &of["rate"], &of["interval"], violated, all);
        assert_eq!((&of["inconclusive"], &of["vacuous"]), (&open.into(), &count(&|run| run.vacuous[place]).into()));
        check_interval(&of["inconclusive_rate"], &of["inconclusive_interval"], open, all);
        let times: u64 = runs.iter().map(|run| run.found[place].violations).sum();
        assert_eq!(of["violations"]["count"], times, "{}", property.text);
        near(&of["violations"]["hours"], hours);
        near(&of["violations"]["per_run"], times as f64 / all as f64);
        near(&of["violations"]["per_hour"], times as f64 / hours);
        if open > 0 {
            assert!(page.contains(&format!("<td>{open} of {all}</td>")), "{}", property.name);
        }
        if violated > 0 {
            assert!(page.contains(&format!("<td>{violated} of {all}")), "{}", property.name);
        }
    }
}

fn near(shown: &Value, wanted: f64) {
    let shown = shown.as_f64().unwrap();
    assert!((shown - wanted).abs() <= 1e-6 * wanted.abs().max(1.0), "{shown} instead of {wanted}");
}

fn check_share(count: &Value, rate: &Value, shown: &Value, happened: u64, runs: u64) {
    assert_eq!((&count["happened"], &count["runs"]), (&happened.into(), &runs.into()));
    check_interval(rate, shown, happened, runs);
}

fn check_interval(rate: &Value, shown: &Value, happened: u64, runs: u64) {
    near(rate, happened as f64 / runs as f64);
    let [low, high] = interval(happened, runs);
    near(&shown["low"], low);
    near(&shown["high"], high);
}

/// The rows of the dataset.
pub(crate) fn check_dataset(out: &Path, of: &Application, runs: &[Recounted]) {
    let reader = SerializedFileReader::new(File::open(out.join("dataset.parquet")).unwrap()).unwrap();
    let summary: Value = serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    let about = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let told = about.iter().find(|about| about.key == "steward.provenance").unwrap().value.as_deref().unwrap();
    assert_eq!(serde_json::from_str::<Value>(told).unwrap(), summary["provenance"]);
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), runs.len());
    for (row, run) in rows.iter().zip(runs) {
        let columns: BTreeMap<&str, &Field> =
            row.get_column_iter().map(|(name, field)| (name.as_str(), field)).collect();
        let integer = |name: &str| if let Field::Long(number) = columns[name] { Some(*number as u64) } else { None };
        let time =
            |name: &str| if let Field::Double(number) = columns[name] { Some(nanoseconds(*number)) } else { None };
        let outcome = if run.unmet.is_empty() { "as_expected" } else { "not_as_expected" };
        assert_eq!(*columns["outcome"], Field::Str(outcome.to_owned()));
        assert_eq!((integer("ticks"), time("sim_time_s")), (Some(run.ticks), Some(run.end)));
        for ((property, found), vacuous) in of.properties.iter().zip(&run.found).zip(&run.vacuous) {
            let name = |column: &str| format!("{}.{column}", property.name);
            assert_eq!(*columns[&*name("verdict")], Field::Str(found.verdict.to_owned()));
            let at = time(&name("time_s")).zip(integer(&name("tick")));
            assert_eq!(at, found.at, "{}", property.text);
            assert_eq!(integer(&name("violations")), Some(found.violations), "{}", property.text);
            assert_eq!(time(&name("violated_s")), found.lasted, "{}", property.text);
            assert_eq!(*columns[&*name("vacuous")], Field::Bool(*vacuous));
        }
    }
}
