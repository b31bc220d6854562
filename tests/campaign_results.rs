//! The results of campaigns: the shipped ones, the report page, and comparisons.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::report_page::look_at;
use crate::steward::{refusal, steward};

/// Runs a campaign with these additional arguments in its own folder.
fn run(campaign: &str, arguments: &[&str]) -> TempDir {
    let out = tempdir().unwrap();
    let all = [&["campaign", campaign, "--quiet", "--out", out.path().to_str().unwrap()], arguments].concat();
    let output = steward(&all);
    assert_eq!(output.status.code(), Some(0), "{campaign}: {}", String::from_utf8_lossy(&output.stderr));
    out
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn page(out: &TempDir) -> String {
    fs::read_to_string(out.path().join("report.html")).unwrap()
}

/// The runs of a journal.
fn records(out: &TempDir) -> Vec<Value> {
    let journal = fs::read_to_string(out.path().join("journal.jsonl")).unwrap();
    journal.lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn says(page: &str, words: &[&str]) {
    for words in words {
        assert!(page.contains(words), "the page does not say: {words}");
    }
}

#[test]
fn what_was_violated_comes_first_and_what_was_open_at_the_end_is_said() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("short.toml");
    // Five properties that are satisfied, one of which demands nothing, phi1, and phi3, which waits for the arrival at
    // the station.
    let five = (1..6).map(|k| format!("property p{k} := always true\n")).collect::<String>();
    let idle = "property idle := always ((BatteryReader, BatteryLevel, level > 100) implies next (BatteryReader, BatteryLevel, true))\n";
    fs::write(folder.path().join("five.scope"), five + idle).unwrap();
    let five = format!("{}/five.scope", folder.path().display());
    let files = format!("properties=[\"properties/phi1.scope\", \"properties/phi3.scope\", \"{five}\"]");
    let set = format!("set = ['execution.max_time_s=22', 'expect={{phi1=\"any\"}}', '{files}']");
    fs::write(&file, format!("scenario = \"battery_fault\"\nruns = 2\n{set}\n")).unwrap();
    let out = folder.path().join("out");
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.starts_with("2 runs, nothing expected of them\n  phi1 "), "{said}");
    let lines: Vec<&str> =
        said.lines().skip(1).skip_while(|line| !line.starts_with("  phi1 ")).take(5).map(str::trim_start).collect();
    assert!(lines[0].starts_with("phi1") && lines[0].contains("violated in 2 of 2"), "{said}");
    assert!(lines[1].starts_with("phi3") && lines[1].contains("violated in 0 of 2"), "{said}");
    assert!(lines[2].starts_with("inconclusive in 2 of 2: 1.0000 (95 %: "), "{said}");
    assert!(lines[3].starts_with("idle") && lines[3].ends_with("; vacuous in 2"), "{said}");
    assert!(lines[4].starts_with("5 properties") && lines[4].ends_with("each: p1, p2, p3, p4, p5"), "{said}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    says(
        &page,
        &[
            "inconclusive: something was still pending",
            "vacuous in 2",
            "p1, p2, p3, p4, p5",
            "nothing expected of them",
        ],
    );
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_battery_reserve_has_a_frontier_near_the_model_and_its_runs_can_be_repeated() {
    let out = run("battery_reserve", &["--runs", "128"]);
    let summary = json(&out.path().join("summary.json"));
    assert_eq!((&summary["expects"], &summary["outcomes"]["as_expected"]), (&false.into(), &128.into()));
    let frontier = summary["frontier"].as_str().unwrap();
    assert!(
        frontier.starts_with("phi1 violated where drain * ") && frontier.contains("the model says 10"),
        "{frontier}"
    );
    assert_eq!(summary["outcomes"]["failed"], 0, "{summary}");
    let page = page(&out);
    says(
        &page,
        &[
            "Where it begins",
            "What it depends on",
            "Two parameters at a time",
            "Runs worth a look",
            "phi1 violated, nearest to the frontier",
        ],
    );
    let (mut wrong, mut violated) = (0, 0);
    for record in records(&out) {
        let value = |place: usize| record["values"][place].as_f64().unwrap();
        let quantity = value(0) * (value(1) / 0.45 + value(2) + 2.0);
        let happened = record["facts"]["monitors"][0]["verdict"] == "violated";
        wrong += u32::from(happened != (quantity > 10.0));
        violated += u32::from(happened);
    }
    assert!((20..=108).contains(&violated), "{violated} of 128 violated");
    assert!(wrong <= 16, "the model is wrong in {wrong} of 128 runs");
    look_at("battery_reserve", &out.path().join("report.html"), 16);
    // The first run that the page recommends, by its own command.
    let (_, card) = page.split_once("<h3>Run ").unwrap();
    let k: usize = card.split_once('<').unwrap().0.parse().unwrap();
    let (_, command) = card.split_once("<pre><code>steward ").unwrap();
    let command = command.split_once("</pre>").unwrap().0;
    // Each option has an element of its own.
    let command: String = command.split('<').map(|part| part.split_once('>').map_or(part, |(_, text)| text)).collect();
    let command = command.as_str();
    assert_eq!(command, format!("campaign battery_reserve --runs 128 --only {k}"));
    let again = tempdir().unwrap();
    let mut arguments: Vec<&str> = command.split(' ').collect();
    arguments.extend(["--out", again.path().to_str().unwrap(), "--quiet"]);
    let status = steward(&arguments).status.code();
    let (report, record) = (json(&again.path().join(format!("run-{k}")).join("report.json")), &records(&out)[k]);
    assert_eq!(report["trace_hash"], record["facts"]["trace_hash"]);
    assert_eq!(status, Some(i32::from(record["outcome"] == "not_as_expected")), "{record}");
}

#[test]
fn the_noise_campaign_shows_localization_errors() {
    let out = run("noise_short", &["--runs", "12"]);
    let page = page(&out);
    says(&page, &["What was measured", "error (RMSE), m", "All runs"]);
    let summary = json(&out.path().join("summary.json"));
    assert_eq!(summary["outcomes"]["failed"], 0, "{summary}");
    assert!(records(&out).iter().all(|record| record["facts"]["sim_time_s"].as_f64().unwrap() < 10.1));
}

#[test]
fn a_campaign_says_what_was_not_met_and_which_runs_are_instructive() {
    let out = tempdir().unwrap();
    let output = steward(&["campaign", "noise_short", "--runs", "20", "--out", out.path().to_str().unwrap()]);
    let said = String::from_utf8(output.stdout).unwrap();
    insta::assert_snapshot!(said.replace(out.path().to_str().unwrap(), "OUT"), @r"
    20 runs: 18 as expected, 2 not
      not met   in 2 runs: expected localization to stay within 0.5 m
      phi2      violated in 0 of 20: 0.0000 (95 %: 0.0000 to 0.1684); vacuous in 20
      phi3      violated in 0 of 20: 0.0000 (95 %: 0.0000 to 0.1684); vacuous in 20
      phi1      violated in 0 of 20: 0.0000 (95 %: 0.0000 to 0.1684)
      run 17    the largest localization error at any moment, 21.2 m
      run 1     expected localization to stay within 0.5 m
      repeat    steward campaign noise_short --runs 20 --only 17
      wrote     OUT/report.html
    ");
}

#[test]
fn each_run_has_its_number_of_people() {
    let out = run("people", &["--runs", "2"]);
    let summary = json(&out.path().join("summary.json"));
    assert_eq!(summary["outcomes"]["failed"], 0, "{summary}");
    let records = records(&out);
    assert_ne!(records[0]["facts"]["trace_hash"], records[1]["facts"]["trace_hash"]);
    says(&page(&out), &["people in the corridor", "time of arrival, s"]);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_bug_hunt_names_each_mistake_and_the_properties_that_detect_it() {
    let out = run("bug_hunt", &["--runs", "2"]);
    says(&page(&out), &["What happens together", "BatteryLevel: the datum `threshold` starts with 15"]);
    // With 15 instead of 30, the robot does not start for the station in time.
    let first = &records(&out)[0];
    assert_eq!(first["outcome"], "not_as_expected", "{first}");
    assert_eq!(first["facts"]["monitors"][1]["verdict"], "violated", "{first}");
}

const SOME: &str = r#"
scenario = "errand"
sampling = "sobol"
runs = 6
set = ["execution.max_time_s=2", "expect={}"]

[[parameters]]
key = "battery.initial_pct"
from = 31
to = 80
"#;

/// Runs campaigns in one folder, each given by its name, text and exit status; returns the folders of their results.
fn campaigns(texts: &[(&str, &str, i32)]) -> (TempDir, Vec<PathBuf>) {
    let folder = tempdir().unwrap();
    let one = |(name, text, status): &(&str, &str, i32)| {
        let (file, out) = (folder.path().join(format!("{name}.toml")), folder.path().join(name));
        fs::write(&file, text).unwrap();
        let output = steward(&["campaign", file.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(*status), "{}", String::from_utf8_lossy(&output.stderr));
        out
    };
    let outs = texts.iter().map(one).collect();
    (folder, outs)
}

#[test]
fn a_model_with_one_parameter_is_on_the_page_too() {
    let model = "name = \"charge\"\n[model]\nof = \"phi1\"\nquantity = \"charge\"\nbound = 50\n";
    let (_folder, outs) = campaigns(&[("one", &format!("{SOME}{model}"), 0)]);
    let page = fs::read_to_string(outs[0].join("report.html")).unwrap();
    says(&page, &["Where it begins", "The model is right in"]);
}

#[test]
fn a_campaign_is_compared_with_its_later_version() {
    // In the second, no run finishes.
    let broken = SOME.replace("\"expect={}\"", "\"expect={}\", \"execution.step_budget=2\"");
    let unexpected = SOME.replace("\"expect={}\"", "\"expect={reached=[\\\"Destination\\\"]}\"");
    let (_folder, outs) = campaigns(&[("old", SOME, 0), ("broken", &broken, 1), ("unexpected", &unexpected, 0)]);
    let path = |place: usize| outs[place].to_str().unwrap();
    let compare = |a: usize, b: usize, more: &[&str]| {
        let output = steward(&[&["campaign", "compare", path(a), path(b)], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let found: Value = serde_json::from_str(&compare(0, 2, &["--json"])).unwrap();
    let near = |value: &Value, wanted: f64| {
        let value = value.as_f64().unwrap_or_else(|| panic!("{found}"));
        assert!((value - wanted).abs() < 1e-9, "{value}, not {wanted}");
    };
    assert_eq!((found["pairs"].as_u64(), found["comparisons"].as_array().map(Vec::len)), (Some(6), Some(4)));
    let expectation = &found["comparisons"][3];
    assert_eq!(expectation["of"], "expectation");
    // None of 6 against all of 6: Fisher's p is 2 of the 924 ways to choose 6 of 12, McNemar's 2 of the 64 outcomes of
    // 6 coins.
    near(&expectation["p_value"], 2.0 / 924.0);
    near(&expectation["paired_p_value"], 2.0 / 64.0);
    near(&expectation["difference"], 1.0);
    assert!(expectation["odds_ratio"].is_null() && expectation["odds_interval"]["high"].is_null(), "{expectation}");
    assert_eq!(expectation["paired"]["only_after"], 6);
    assert_eq!(expectation["first_only_after"], serde_json::json!([0, 1, 2]));
    near(&found["comparisons"][0]["p_value"], 1.0);
    assert_eq!(found["comparisons"][0]["change"], "no_difference");
    let words = compare(0, 1, &[]);
    for part in [
        "6 failed",
        "expectation:",
        "0 of 6 (0.00 %) before, 6 of 6 (100.00 %) after",
        "only after: run 0, steward campaign",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(
        words.contains("in 0 of 6 (0.00 %) before, 0 of 0 (–) after"),
        "runs that fail count for no property: {words}"
    );
    let journal = outs[2].join("journal.jsonl");
    let whole = fs::read_to_string(&journal).unwrap();
    fs::write(&journal, &whole[..=whole.trim_end().rfind('\n').unwrap()]).unwrap();
    let refused = steward(&["campaign", "compare", path(0), path(2)]);
    assert_eq!(refused.status.code(), Some(2));
    says(&String::from_utf8(refused.stderr).unwrap(), &["has 5 runs, and summary.json counts 6"]);
}

#[test]
fn incomparable_campaigns_are_refused() {
    let wider = SOME.replace("to = 80", "to = 90");
    let other = SOME.replace("battery.initial_pct", "execution.tick_s").replace("31", "1").replace("80", "2");
    let unwatched = SOME.replace("\"expect={}\"", "\"expect={}\", \"properties=[\\\"properties/phi1.scope\\\"]\"");
    let foreign =
        SOME.replace("\"expect={}\"", "\"expect={}\", \"properties=[\\\"properties/phi2_or_there.scope\\\"]\"");
    let all = [("some", SOME), ("wider", &wider), ("other", &other), ("unwatched", &unwatched), ("foreign", &foreign)];
    let (folder, outs) = campaigns(&all.map(|(name, text)| (name, text, 0)));
    let path = |place: usize| outs[place].to_str().unwrap().to_owned();
    let refused = |a: &str, b: &str| {
        let said = refusal(&["campaign", "compare", a, b]);
        said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ")
    };
    assert!(refused(&path(0), &path(1)).contains("vary `battery.initial_pct` differently: 31 to 80, and 31 to 90"));
    assert!(
        refused(&path(0), &path(2))
            .contains("vary different parameters: `battery.initial_pct`; and `execution.tick_s`")
    );
    assert!(refused(&path(3), &path(4)).contains("have no property in common"));
    assert!(refused(&path(0), folder.path().to_str().unwrap()).contains("cannot read"));
    let file = folder.path().join("some.toml");
    let shards = folder.path().join("shards");
    let arguments =
        ["campaign", file.to_str().unwrap(), "--shard", "0/2", "--quiet", "--out", shards.to_str().unwrap()];
    assert!(steward(&arguments).status.success());
    assert!(refused(&path(0), shards.join("shard-0-of-2").to_str().unwrap()).contains("is shard 0/2"));
    let journal = outs[3].join("journal.jsonl");
    let text = fs::read_to_string(&journal).unwrap();
    fs::write(&journal, format!("{text}{}\n", text.lines().last().unwrap())).unwrap();
    assert!(refused(&path(0), &path(3)).contains("is damaged"), "a run comes again");
    fs::remove_file(outs[0].join("summary.json")).unwrap();
    assert!(refused(&path(0), &path(3)).contains("has not finished"));
}

#[test]
fn a_campaign_without_a_robot_has_no_measures_of_a_robot() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("some.toml");
    let text = "scenario = \"pick\"\nruns = 5\nsampling = \"sobol\"\n[[parameters]]\n\
                key = \"leaves.PickUp.data.slips\"\nfrom = 0\nto = 4\n";
    let run = |more: &str| {
        std::fs::write(&file, format!("{more}{text}")).unwrap();
        steward(&["campaign", file.to_str().unwrap(), "--out", folder.path().join("out").to_str().unwrap()])
    };
    let output = run("");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("unaided"), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let output = run("measures = [\"distance_m\"]\n");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("there is no robot for which to measure `distance_m`"), "{said}");
}
