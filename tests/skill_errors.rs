//! Errors in the machines of running skills are in the report, on its page and in the summary.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
#[cfg(feature = "ecmascript")]
use skills::Chart;
use tempfile::tempdir;

use crate::bad_input::copy_of_battery_fault;
#[cfg(feature = "ecmascript")]
use crate::campaign::{bytes, results_on};
use crate::steward::steward;

/// A copy of `battery_fault` in which BatteryLevel's machine does this when it is ticked.
fn spoilt(content: &str, folder: &Path) -> PathBuf {
    let scenario = copy_of_battery_fault(folder);
    let machine = scenario.with_file_name("skills").join("BatteryLevel.scxml");
    let text = std::fs::read_to_string(&machine).unwrap();
    let spoilt = text.replacen("<state id=\"get\">", &format!("<state id=\"get\"><onentry>{content}</onentry>"), 1);
    assert_ne!(spoilt, text);
    std::fs::write(&machine, spoilt).unwrap();
    scenario
}

/// Runs a few ticks of such a copy.
fn run(content: &str) -> (Value, String, String) {
    let folder = tempdir().unwrap();
    let scenario = spoilt(content, folder.path());
    let out = folder.path().join("out");
    let arguments = ["--no-snapshots", "--set", "execution.max_time_s=5", "--out", out.to_str().unwrap()];
    let output = steward(&[&["--scenario", scenario.to_str().unwrap()], &arguments[..]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let report = serde_json::from_str(&read("report.json")).unwrap();
    (report, read("report.html"), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn an_expression_that_fails_is_reported_with_its_skill_its_state_and_how_often() {
    let (report, page, summary) = run("<assign location=\"threshold\" expr=\"_event.data.missing.level\"/>");
    let errors = &report["skill_errors"];
    let (message, times) = ("undefined has no member level", errors[0]["times"].as_u64().unwrap());
    let expected = json!([{
        "kind": "skill", "skill": "BatteryLevel", "state": "get", "message": message, "time_s": errors[0]["time_s"], "times": times,
    }]);
    assert_eq!(*errors, expected);
    assert!(times > 1, "it is asked at every tick");
    assert!(page.contains("BatteryLevel, state get"));
    let line = format!("  skill    BatteryLevel, state get: {message} ({times} times); first at ");
    assert!(summary.contains(&line), "{summary}");
}

#[cfg(feature = "ecmascript")]
#[test]
fn endless_scripts_are_stopped_reproducibly_and_do_not_stop_the_run() {
    let script = "<script>for (;;) { try { [].includes.call({length: 9e15}, 1) } catch (e) { } }</script>";
    let (report, _, summary) = run(script);
    assert_eq!(report["skill_errors"][0]["message"], "this takes too many steps and may never end");
    assert!(summary.contains("  skill    BatteryLevel, state get: this takes too many steps"), "{summary}");
    assert_eq!(run(script).0["trace_hash"], report["trace_hash"]);
}

#[cfg(feature = "ecmascript")]
#[test]
fn a_campaign_of_such_scripts_gives_the_same_bytes_on_one_thread_and_on_two() {
    let folder = tempdir().unwrap();
    assert!(is_the_same_on_two_threads(&campaign_of_failing_scripts(folder.path(), 6)));
}

/// A campaign with a scenario in which a skill's scripts fail in several ways.
#[cfg(feature = "ecmascript")]
pub(crate) fn campaign_of_failing_scripts(folder: &Path, runs: u64) -> PathBuf {
    let deep = "<script>var f = () => f(); try { f() } catch (e) { [[0]].flat(); throw 'x'.repeat(1000000) }</script>";
    let long = "<script>new Array(4294967295).forEach(() => [].indexOf(1))</script>";
    let random = "<script>threshold = 30 + Math.random() * [1].map((one) => one)[0]</script>";
    let scenario = spoilt(&format!("{random}</onentry><onentry>{deep}</onentry><onentry>{long}"), folder);
    campaign_of(&scenario, runs, 3)
}

#[cfg(feature = "ecmascript")]
fn campaign_of(scenario: &Path, runs: u64, max_time_s: usize) -> PathBuf {
    let file = scenario.with_file_name("some.toml");
    let text = format!("scenario = {scenario:?}\nruns = {runs}\nset = [\"execution.max_time_s={max_time_s}\"]\n");
    std::fs::write(&file, text).unwrap();
    file
}

/// Whether a campaign writes the same bytes on one thread and on two.
#[cfg(feature = "ecmascript")]
fn is_the_same_on_two_threads(campaign: &Path) -> bool {
    bytes(&results_on(1, campaign)) == bytes(&results_on(2, campaign))
}

/// Scripts that would use up all time, memory or stack, one per line.
#[cfg(feature = "ecmascript")]
const BOMBS: &str = include_str!("../skills/tests/main/bombs.js");

/// The data and the state of a machine that runs these scripts one after another, each on its own timer, so that each
/// starts with the full budget of steps; finally it throws a checksum of their results.
#[cfg(feature = "ecmascript")]
fn machine_of(bombs: &[&str]) -> (&'static str, String) {
    let data = "<datamodel><data id=\"x\"/><data id=\"sum\" expr=\"0\"/><data id=\"turn\" expr=\"0\"/>";
    let sum = "sum = [...String(x).slice(0, 80)].reduce((sum, c) => (sum * 31 + c.charCodeAt(0)) % 65521, sum)";
    let run = |(turn, bomb): (usize, &&str)| {
        let bomb = bomb.replace('&', "&amp;").replace('<', "&lt;");
        format!(
            "<transition event=\"next\" cond=\"turn == {turn}\" target=\"bombs\"><assign location=\"turn\" expr=\"turn + 1\"/>
             <script>x = (() => {{{bomb}\n}})()</script><script>{sum}</script></transition>"
        )
    };
    let runs: String = bombs.iter().enumerate().map(run).collect();
    // A tick of the tree enters the state again, so the old timer is canceled.
    let wait = "<cancel sendid=\"wait\"/><send event=\"next\" id=\"wait\" delay=\"10ms\"/>";
    let state = format!(
        "<state id=\"bombs\"><onentry>{wait}</onentry>{runs}
         <transition event=\"next\"><script>throw 'they leave ' + sum</script></transition></state>"
    );
    (data, state)
}

/// Runs every `step`th script in `skill run`, in a run of a scenario and in a campaign, twice each.
#[cfg(feature = "ecmascript")]
fn bombs_end_alike_everywhere(step: usize) {
    let folder = tempdir().unwrap();
    let machine = |bombs: &[&str]| {
        let (data, state) = machine_of(bombs);
        format!("<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\">{data}</datamodel>{state}</scxml>")
    };
    let bombs: Vec<&str> = BOMBS.lines().filter(|line| !line.is_empty()).step_by(step).collect();
    let file = folder.path().join("Bombs.scxml");
    std::fs::write(&file, machine(&bombs)).unwrap();
    let alone = || {
        let output = steward(&["skill", "run", file.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(1), "nobody handles the errors");
        String::from_utf8(output.stdout).unwrap()
    };
    let said = alone();
    assert!(said.contains("they leave "), "{said}");
    assert_eq!(said, alone());

    // A scenario refuses invalid ECMAScript before it runs.
    let readable: Vec<&str> =
        bombs.into_iter().filter(|bomb| Chart::load("Bomb.scxml", &machine(&[*bomb])).is_ok()).collect();
    let scenario = copy_of_battery_fault(folder.path());
    let skill = scenario.with_file_name("skills").join("BatteryLevel.scxml");
    let (data, state) = machine_of(&readable);
    let text = std::fs::read_to_string(&skill).unwrap().replacen("<datamodel>", data, 1);
    let text = text.replacen("<state ", "<parallel id=\"both\"><state ", 1);
    std::fs::write(&skill, text.replace("</scxml>", &format!("{state}</parallel></scxml>"))).unwrap();
    // Timers go off between two steps of 20 ms.
    let max_time_s = 2 + readable.len() / 40;
    let limit = format!("execution.max_time_s={max_time_s}");
    let report = |out: &str| {
        let out = folder.path().join(out);
        let arguments = ["--no-snapshots", "--set", &limit, "--out", out.to_str().unwrap()];
        let output = steward(&[&["--scenario", scenario.to_str().unwrap()], &arguments[..]].concat());
        assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
        let mut report: Value = serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
        report["timing"].take();
        report
    };
    let reported = report("one");
    assert!(reported.to_string().contains("they leave "), "{reported}");
    assert_eq!(reported, report("other"));

    assert!(is_the_same_on_two_threads(&campaign_of(&scenario, 2, max_time_s)));
}

#[cfg(feature = "ecmascript")]
#[test]
fn some_bombs_end_the_same_way_in_a_machine_a_run_and_a_campaign() {
    bombs_end_alike_everywhere(12);
}

#[cfg(feature = "ecmascript")]
#[test]
#[ignore = "takes minutes: on demand"]
fn all_bombs_end_the_same_way_in_a_machine_a_run_and_a_campaign_on_demand() {
    bombs_end_alike_everywhere(1);
}

#[test]
fn a_run_without_errors_prints_none() {
    let (report, _, summary) = run("<log expr=\"1\"/>");
    assert_eq!(report["skill_errors"], json!([]));
    assert!(!summary.contains("  skill "), "{summary}");
}
