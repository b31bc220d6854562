//! Files with results for CI systems: `--results FILE`. `ci_results.py` reads them with programs of others.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{binary, refusal};

/// Runs a command in a folder. Returns its exit status, the SARIF file's run, and the Markdown file.
fn results(folder: &Path, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let to = ["--results", "to/ci.sarif", "--results", "to/ci.md", "--results", "to/ci.XML"];
    let done = Command::new(binary()).args(arguments).args(to).current_dir(folder).output().expect("it starts");
    let read = |name: &str| std::fs::read_to_string(folder.join("to").join(name)).expect("it was written");
    assert!(read("ci.XML").starts_with("<?xml"));
    let sarif: Value = serde_json::from_str(&read("ci.sarif")).expect("SARIF is JSON");
    (done.status.code(), sarif["runs"][0].clone(), read("ci.md"))
}

#[test]
fn results_of_a_run_that_is_not_as_expected_are_in_all_formats() {
    let folder = tempdir().expect("a folder");
    let run = ["run", "battery_fault", "--no-snapshots", "--quiet"];
    let (status, sarif, summary) = results(folder.path(), &run);
    assert_eq!((status, &sarif["results"]), (Some(0), &json!([])));
    assert!(summary.contains("| battery\\_fault | phi1 | violated | passed |"), "{summary}");
    assert!(summary.contains("### phi1: violated") && summary.contains("1. Required: "), "{summary}");
    assert!(summary.contains("[report](../out/battery_fault/report.html)"), "{summary}");

    let (status, sarif, summary) = results(folder.path(), &[&run[..], &["--set", "expect.phi1=satisfied"]].concat());
    let message = "phi1 was expected to be satisfied and is violated";
    let of_phi1 = |result: &&Value| result["ruleId"] == "property/phi1";
    let found = sarif["results"].as_array().expect("results").iter().find(of_phi1).expect("one about phi1");
    assert_eq!((status, &found["level"]), (Some(1), &json!("error")));
    assert!(found["message"]["text"].as_str().is_some_and(|text| text.contains(message)), "{found}");
    let place = &found["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"], json!({ "uri": "properties/phi1.scope", "uriBaseId": "STEWARD" }));
    let steps = found["codeFlows"][0]["threadFlows"][0]["locations"].as_array().expect("steps");
    let last = &steps.last().expect("a step")["location"]["message"]["text"];
    assert!(steps.len() > 1 && last.as_str().is_some_and(|text| text.starts_with("phi1 is violated")), "{steps:?}");
    assert!(summary.contains(&format!("| violated | **failed**: {message} |")), "{summary}");
}

#[test]
fn results_show_where_a_file_is_wrong() {
    let folder = tempdir().expect("a folder");
    let text = "// grün\nproperty p := always (BatteryReader, BatteryLevl, m[2] > 1)\n";
    std::fs::write(folder.path().join("wrong.scope"), text).expect("room for a file");
    let scenario = "skill.toml";
    std::fs::write(folder.path().join(scenario), "base = \"nominal\"\nproperties = [\"wrong.scope\"]\n")
        .expect("room for a file");
    // The check of a file, and a run that loads it.
    for arguments in [["check", "wrong.scope"], ["run", scenario]] {
        let (status, sarif, summary) = results(folder.path(), &arguments);
        let result = &sarif["results"][0];
        assert_eq!((status, &result["ruleId"]), (Some(2), &json!("file-error")), "{sarif}");
        let place = &result["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"], json!({ "uri": "wrong.scope", "uriBaseId": "%SRCROOT%" }));
        assert_eq!(place["region"]["startLine"], 2);
        let offset = place["region"]["charOffset"].as_u64().and_then(|at| usize::try_from(at).ok()).expect("an offset");
        let marked: String = text.chars().skip(offset).collect();
        assert!(marked.starts_with("BatteryLevl") || marked.starts_with("(BatteryReader"), "{marked}");
        assert!(summary.contains("wrong.scope:2:"), "{summary}");
    }
}

/// The line of the summary's table that begins like this.
fn line<'s>(summary: &'s str, start: &str) -> &'s str {
    let line = summary.lines().find(|line| line.starts_with(start));
    line.unwrap_or_else(|| panic!("no line begins with {start:?}: {summary}"))
}

#[test]
fn what_says_nothing_is_not_shown_as_passed() {
    let folder = tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room for a file");
    // Runs that are not as expected, and a goal that two runs do not decide.
    write(
        "camp.toml",
        "scenario = \"battery_fault\"\nruns = 2\nset = ['expect.phi1=\"satisfied\"']\n[goal]\ntest = \"phi1\"\n\
         bound = 0.5\nindifference = 0.05\nerror = 0.01\n",
    );
    let (status, _, summary) = results(folder.path(), &["campaign", "camp.toml", "--quiet"]);
    let runs = line(&summary, "| camp.toml | 2 runs of ");
    assert!(status == Some(0) && runs.contains("0 as expected, 2 not") && runs.contains("| skipped: "), "{runs}");
    assert!(line(&summary, "| camp.toml | goal |").contains("| skipped: not reached"), "{summary}");
    // A fault that never comes.
    let never = "base = \"battery_fault\"\n[[faults]]\nkind = \"battery_level\"\nat_s = 5000\nlevel_pct = 10\n";
    write("never.toml", never);
    let matrix = ["matrix", "never.toml", "--fault-free", "nominal", "--runs", "1", "--quiet"];
    let (_, sarif, summary) = results(folder.path(), &matrix);
    assert!(line(&summary, "| never | phi1 |").contains("| skipped: "), "{summary}");
    assert!(sarif["invocations"].to_string().contains("no property detects the fault of never"), "{sarif}");
    // Monitors that are off.
    let run = ["run", "battery_fault", "--no-snapshots", "--quiet", "--no-monitors"];
    let (_, sarif, summary) = results(folder.path(), &run);
    assert!(line(&summary, "| battery\\_fault | phi1 |").contains("skipped: it was not judged"), "{summary}");
    assert!(sarif["invocations"].to_string().contains("no property was judged"), "{sarif}");
    // A condition that never occurs, in a run and in its log; and a log in which nothing happens.
    write("never.scope", "property never := always ((BatteryReader, BatteryLevel, m[2] < 0) implies next false)\n");
    let run = ["run", "battery_fault", "--no-snapshots", "--quiet", "--record", "run.jsonl"];
    let set = ["--set", "properties=[\"never.scope\"]", "--set", "expect={}"];
    let (_, _, summary) = results(folder.path(), &[&run[..], &set].concat());
    assert!(line(&summary, "| battery\\_fault | never |").contains("| satisfied | skipped: "), "{summary}");
    // What a proof assumes.
    let (_, sarif, summary) = results(folder.path(), &["prove", "nominal", "--property", "phi1", "--quiet"]);
    let assumed = "Trips take at most";
    assert!(summary.contains(assumed) && sarif["invocations"].to_string().contains(assumed), "{summary}");
}

#[test]
fn the_name_of_a_file_says_the_format_of_its_results() {
    for name in ["results", "results.json"] {
        let said = refusal(&["run", "battery_fault", "--results", name]);
        assert!(said.contains("ends in .xml (JUnit), .sarif (SARIF) or .md (Markdown)"), "{said}");
    }
}
