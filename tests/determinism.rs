//! The same seed gives the same bits; another seed gives another run.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::report;

/// The files of an output folder by name, the report without its timing.
fn files(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path());
    let named =
        entries.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(path).unwrap()));
    let without_timing = |bytes: &[u8]| {
        let mut report: Value = serde_json::from_slice(bytes).unwrap();
        report.as_object_mut().unwrap().remove("timing").expect("the report has its timing");
        report.to_string().into_bytes()
    };
    named
        .map(|(name, bytes)| if name == "report.json" { (name, without_timing(&bytes)) } else { (name, bytes) })
        .collect()
}

#[test]
fn one_seed_gives_the_same_report_log_and_pictures() {
    let runs = [tempdir().unwrap(), tempdir().unwrap()];
    for out in &runs {
        let log = out.path().join("log.jsonl");
        report("battery_fault", out.path(), &["--seed", "7", "--record", log.to_str().unwrap()]);
    }
    let [first, second] = runs.each_ref().map(|out| files(out.path()));
    assert!(first.keys().filter(|name| name.ends_with(".png")).count() >= 5);
    assert!(first == second, "differences in {:?}", first.keys().filter(|name| first[*name] != second[*name]));
}

#[test]
fn monitors_pictures_and_recording_do_not_change_a_run() {
    let hash = |arguments: &[&str]| {
        let out = tempdir().unwrap();
        report("battery_fault", out.path(), arguments)["trace_hash"].clone()
    };
    let plain = hash(&["--no-snapshots", "--no-monitors"]);
    assert_eq!(plain, hash(&["--no-snapshots"]));
    let out = tempdir().unwrap();
    let [log, gif] = ["log.jsonl", "run.gif"].map(|name| out.path().join(name).to_str().unwrap().to_owned());
    assert_eq!(plain, hash(&["--record", &log, "--gif", &gif]));
}

#[test]
fn different_seeds_give_different_runs() {
    let hash = |seed| {
        let out = tempdir().unwrap();
        report("battery_fault", out.path(), &["--no-snapshots", "--seed", seed])["trace_hash"].clone()
    };
    assert_ne!(hash("1"), hash("2"));
}
