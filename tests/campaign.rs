//! Campaigns: the same results in the same bytes, however they were obtained.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::{TempDir, tempdir};

#[cfg(feature = "ecmascript")]
use crate::skill_errors::campaign_of_failing_scripts;
use crate::steward::{binary, refusal, steward};

const SOME: &str = r#"
scenario = "errand"
sampling = "sobol"
runs = 24
set = ["execution.max_time_s=3"]

[[parameters]]
key = "battery.initial_pct"
from = 31
to = 80

[[parameters]]
key = "execution.step_budget"
values = [100000, 2]
"#;

/// A folder with a campaign file.
fn campaign(text: &str) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let file = folder.path().join("some.toml");
    fs::write(&file, text).unwrap();
    (folder, file)
}

/// Runs a campaign with these additional arguments; returns the folder of its results.
fn results(file: &Path, name: &str, arguments: &[&str]) -> PathBuf {
    let out = file.with_file_name(name);
    let mut all = vec!["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    all.extend(arguments);
    let output = steward(&all);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

/// Repeats a run that is not as expected, which the exit status confirms; returns the folder of its report.
fn repeated(file: &Path, k: &str, arguments: &[&str]) -> PathBuf {
    let out = file.with_file_name("alone");
    let all = ["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap(), "--only", k];
    let output = steward(&[&all, arguments].concat());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("NOT as expected"));
    out.join(format!("run-{k}"))
}

/// The binary's message when it refuses its input, on one line: the graphical report breaks lines between words.
fn refused(arguments: &[&str]) -> String {
    refusal(arguments).split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ")
}

/// Everything except wall times.
pub(crate) fn bytes(folder: &Path) -> [Vec<u8>; 4] {
    ["dataset.parquet", "summary.json", "journal.jsonl", "report.html"].map(|name| fs::read(folder.join(name)).unwrap())
}

/// Runs a campaign on this many threads; returns the folder of its results.
pub(crate) fn results_on(threads: u32, file: &Path) -> PathBuf {
    let out = file.with_file_name(format!("on{threads}"));
    let output = Command::new(binary())
        .args(["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()])
        .env("RAYON_NUM_THREADS", threads.to_string())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

#[test]
fn results_do_not_depend_on_threads_and_shards() {
    let (_folder, file) = campaign(SOME);
    let whole = results(&file, "whole", &[]);
    assert_eq!(bytes(&whole), bytes(&results_on(1, &file)), "one thread");
    for of in [3, 5] {
        let name = format!("shards{of}");
        let shards: Vec<String> = (0..of)
            .map(|index| {
                let out = results(&file, &name, &["--shard", &format!("{index}/{of}"), "--quiet"]);
                out.join(format!("shard-{index}-of-{of}")).to_str().unwrap().to_owned()
            })
            .rev()
            .collect();
        let merged = file.with_file_name(format!("merged{of}"));
        let mut arguments = vec!["campaign", "merge", "--out", merged.to_str().unwrap()];
        arguments.extend(shards.iter().map(String::as_str));
        assert!(steward(&arguments).status.success());
        assert_eq!(bytes(&whole), bytes(&merged), "{of} shards");
        assert_eq!(timed_runs(&merged), (0..24).collect::<Vec<u64>>(), "{of} shards");
    }
    let summary: serde_json::Value = serde_json::from_slice(&bytes(&whole)[1]).unwrap();
    assert_eq!(summary["outcomes"]["failed"], 12, "a system that is never quiet is a result");
    assert!(summary["failures"][0]["command"].as_str().unwrap().contains(" --only "), "{summary}");
    assert_eq!(fs::read_to_string(whole.join("timing.csv")).unwrap().lines().count(), 25);
}

/// Starts a campaign that writes its results to a folder of that name.
fn begun(file: &Path, name: &str) -> Child {
    Command::new(binary())
        .args(["campaign", file.to_str().unwrap(), "--out", file.with_file_name(name).to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Kills campaigns at random moments: while they load, read earlier results, run, or write results. Whenever one
/// finishes, another is started.
#[test]
fn a_killed_campaign_resumes_without_losing_repeating_or_changing_a_run() {
    let (_folder, file) = campaign(SOME);
    survives(&file, 24, 25);
}

#[cfg(feature = "ecmascript")]
#[test]
#[ignore = "long: .ci/run runs it"]
fn failing_scripts_give_the_same_results_after_a_kill() {
    let folder = tempdir().unwrap();
    survives(&campaign_of_failing_scripts(folder.path(), 6), 6, 10);
}

/// Kills a campaign this many times, and compares its results with those of one that was left alone.
fn survives(file: &Path, runs: u64, wanted_kills: u32) {
    let began = now();
    let whole = bytes(&results(file, "whole", &[]));
    let life = began.elapsed();
    let (mut kills, mut campaigns, mut random) = (0, 0, 12_345_u64);
    while kills < wanted_kills {
        let name = format!("killed{campaigns}");
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut child = begun(file, &name);
        wait(life.mul_f64((random >> 40) as f64 / (1 << 24) as f64));
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success());
            assert_eq!(bytes(&file.with_file_name(&name)), whole, "{name}");
            campaigns += 1;
        } else {
            // On Unix, this is kill -9.
            child.kill().unwrap();
            child.wait().unwrap();
            kills += 1;
        }
    }
    let out = results(file, &format!("killed{campaigns}"), &[]);
    assert_eq!(bytes(&out), whole);
    assert_eq!(timed_runs(&out), (0..runs).collect::<Vec<u64>>());
}

/// The runs with known wall times.
fn timed_runs(folder: &Path) -> Vec<u64> {
    let timed = fs::read_to_string(folder.join("timing.csv")).unwrap();
    timed.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect()
}

#[expect(clippy::disallowed_methods, reason = "a process is killed at moments that are measured")]
fn now() -> Instant {
    Instant::now()
}

#[expect(clippy::disallowed_methods, reason = "a process is killed at any moment")]
fn wait(time: Duration) {
    std::thread::sleep(time);
}

#[cfg(unix)]
#[test]
fn an_interrupted_campaign_ends_cleanly_and_says_how_to_resume() {
    let (_folder, file) = campaign(&SOME.replace("max_time_s=3", "max_time_s=60"));
    let whole = bytes(&results(&file, "whole", &[]));
    let journal = file.with_file_name("out").join("journal.jsonl");
    let child = begun(&file, "out");
    while fs::read_to_string(&journal).map_or(0, |text| text.lines().count()) < 4 {
        wait(Duration::from_millis(5));
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{said}");
    let text = fs::read_to_string(&journal).unwrap();
    let runs = text.lines().count() - 1;
    assert!(text.ends_with('\n') && (3..24).contains(&runs), "{runs} runs");
    assert!(said.contains(&format!("interrupted after {runs} of 24 runs; the same command resumes")), "{said}");
    assert!(!journal.with_file_name("dataset.parquet").exists());
    assert_eq!(bytes(&results(&file, "out", &[])), whole);
}

/// Wherever a journal ends, the results are the same.
#[test]
fn a_journal_may_be_truncated_at_any_byte() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 3"));
    let out = results(&file, "out", &[]);
    let whole = bytes(&out);
    let len = whole[2].len();
    for end in [0, 1, len / 3, len / 2, len - 1, len] {
        fs::write(out.join("journal.jsonl"), &whole[2][..end]).unwrap();
        assert_eq!(bytes(&results(&file, "out", &[])), whole, "cut off at {end} of {len}");
    }
}

#[test]
fn a_campaign_stops_at_its_goal_and_has_nothing_to_resume() {
    let goal = "[goal]\nestimate = \"expectation\"\nhalf_width = 0.25\nconfidence = 0.8\n";
    let (_folder, file) = campaign(&(SOME.replace("runs = 24\n", "") + goal));
    let out = results(&file, "out", &[]);
    let summary: serde_json::Value = serde_json::from_slice(&bytes(&out)[1]).unwrap();
    assert_eq!(summary["goal"]["reached"], true, "{summary}");
    assert_eq!(summary["goal"]["count"]["runs"], summary["runs"]);
    assert_eq!(bytes(&out), bytes(&results(&file, "out", &[])), "the goal is already reached");
}

/// Every second run ends at once and is not as expected; the others take long and are as expected. If results counted
/// as they come, many threads would see the bad ones first and stop early.
#[test]
fn stopping_on_many_threads_does_not_favor_short_runs() {
    let goal = "[goal]\ntest = \"expectation\"\nbound = 0.6\nindifference = 0.2\nerror = 0.01\n";
    let short_or_long = SOME.replace("runs = 24", "runs = 200").replace("[\"exec", "[\"expect.reached=[]\", \"exec");
    let (_folder, file) = campaign(&(short_or_long + goal));
    let one = bytes(&results_on(1, &file));
    for threads in [2, 8] {
        assert_eq!(bytes(&results_on(threads, &file)), one, "{threads} threads");
    }
    let summary: serde_json::Value = serde_json::from_slice(&one[1]).unwrap();
    assert_eq!((&summary["goal"]["reached"], &summary["goal"]["side"]), (&true.into(), &"below".into()), "{summary}");
}

#[test]
fn a_run_is_repeated_alone() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 6"));
    let out = results(&file, "out", &[]);
    let journal = fs::read_to_string(out.join("journal.jsonl")).unwrap();
    let runs: Vec<serde_json::Value> =
        journal.lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect();
    let ended = runs.iter().find(|run| run["failure"].is_null()).unwrap();
    let k = ended["k"].to_string();
    assert_eq!(ended["outcome"], "not_as_expected");
    let alone = repeated(&file, &k, &[]);
    let report: serde_json::Value = serde_json::from_slice(&fs::read(alone.join("report.json")).unwrap()).unwrap();
    assert_eq!(report["trace_hash"], ended["facts"]["trace_hash"]);
    assert!(alone.join("report.html").exists());
    let failed = runs.iter().find(|run| run["outcome"] == "failed").unwrap();
    let only = ["campaign", file.to_str().unwrap(), "--only", &failed["k"].to_string()];
    assert!(refused(&only).contains(failed["failure"].as_str().unwrap()), "{failed}");
    assert!(refused(&[&only[..3], &["6"]].concat()).contains("no run 6"));
}

/// The strata of a Latin hypercube depend on the number of runs, so the command contains it.
#[test]
fn the_command_that_the_summary_gives_repeats_the_run() {
    let (_folder, file) = campaign(&SOME.replace("sobol", "latin_hypercube").replace("100000, 2", "100000"));
    let out = results(&file, "out", &["--runs", "7"]);
    let summary: serde_json::Value = serde_json::from_slice(&bytes(&out)[1]).unwrap();
    let command = summary["unexpected"][5]["command"].as_str().unwrap();
    let words: Vec<&str> = command.split(' ').collect();
    assert_eq!(words[..2], ["steward", "campaign"]);
    assert_eq!(words[3..], ["--runs", "7", "--only", "5"]);
    let hash = |arguments: &[&str]| {
        let report = repeated(&file, "5", arguments).join("report.json");
        let report: serde_json::Value = serde_json::from_slice(&fs::read(report).unwrap()).unwrap();
        report["trace_hash"].clone()
    };
    let journal = String::from_utf8(bytes(&out)[2].clone()).unwrap();
    let fifth: serde_json::Value = serde_json::from_str(journal.lines().nth(6).unwrap()).unwrap();
    assert_eq!(hash(&words[3..5]), fifth["facts"]["trace_hash"]);
    assert_ne!(hash(&[]), fifth["facts"]["trace_hash"], "with the file's number of runs, it is a different run");
}

/// A run that never stops communicating, even though each burst is short, is stopped by a count and not by the clock.
#[test]
fn a_run_beyond_its_budget_is_a_result() {
    let (_folder, file) = campaign(&SOME.replace("step_budget", "run_budget").replace("runs = 24", "runs = 2"));
    let out = results(&file, "out", &[]);
    let summary: serde_json::Value = serde_json::from_slice(&bytes(&out)[1]).unwrap();
    assert_eq!(summary["outcomes"]["failed"], 1);
    let why = summary["failures"][0]["why"].as_str().unwrap();
    assert!(why.contains("more than 2 communications (`execution.run_budget`)"), "{why}");
}

#[test]
fn a_campaign_whose_files_were_edited_does_not_resume() {
    let (folder, file) = campaign(&SOME.replace("runs = 24", "runs = 2"));
    let copy = folder.path().join("scenario");
    assert!(steward(&["init", copy.to_str().unwrap(), "--scenario", "errand"]).status.success());
    let file = {
        let own = copy.join("some.toml");
        fs::write(&own, fs::read_to_string(&file).unwrap().replace("\"errand\"", "\"errand.toml\"")).unwrap();
        own
    };
    let out = results(&file, "out", &[]);
    let before = bytes(&out);
    for (edited, was) in [
        ("scenarios/nominal.toml", "min_battery_pct = 20"),
        ("maps/house.yaml", "resolution"),
        ("maps/house.places.toml", "[start]"),
        ("trees/recharge.xml", "<root"),
        ("skills/BatteryLevel.scxml", "<scxml"),
        ("properties/phi1.scope", "property phi1"),
    ] {
        let path = copy.join(edited);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(was), "{edited}: {text}");
        fs::write(&path, format!("{text}\n")).unwrap();
        let said = refused(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
        assert!(said.contains("another campaign") && said.contains("or a file of its scenario"), "{edited}: {said}");
        assert_eq!(bytes(&out), before);
        fs::write(&path, text).unwrap();
    }
    assert_eq!(bytes(&results(&file, "out", &[])), before, "as it was");
}

/// `--fresh` removes what a campaign wrote, and only that.
#[test]
fn a_campaign_can_start_over_in_the_folder_of_another() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 4"));
    let out = results(&file, "out", &[]);
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let again = ["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap(), "--runs", "3"];
    let said = refused(&again);
    assert!(said.contains("another campaign") && said.contains("start over with `--fresh`"), "{said}");
    let other = results(&file, "other", &["--runs", "3"]);
    let _ = results(&file, "out", &["--runs", "3", "--fresh"]);
    assert_eq!(bytes(&out), bytes(&other));
    assert_eq!(timed_runs(&out), [0, 1, 2]);
    assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine");
    // Files that no campaign wrote are not removed.
    fs::write(out.join("journal.jsonl"), "{\"mine\": 1}\n").unwrap();
    assert!(refused(&[&again[..], &["--fresh"]].concat()).contains("is not the journal of a campaign"));
    assert_eq!(fs::read_to_string(out.join("journal.jsonl")).unwrap(), "{\"mine\": 1}\n");
    assert_eq!(bytes(&out)[..2], bytes(&other)[..2]);
}

#[test]
fn a_shard_that_is_refused_does_not_start_over() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 2"));
    let out = results(&file, "out", &["--shard", "0/2"]);
    let journal = || fs::read_to_string(out.join("shard-0-of-2/journal.jsonl")).unwrap();
    let before = journal();
    fs::write(&file, format!("{SOME}[goal]\nestimate = \"expectation\"\nhalf_width = 0.25\nconfidence = 0.8\n"))
        .unwrap();
    let arguments = ["campaign", file.to_str().unwrap(), "--shard", "0/2", "--out", out.to_str().unwrap(), "--fresh"];
    assert!(refused(&arguments).contains("a campaign that stops at a goal cannot be sharded"));
    assert_eq!(journal(), before);
}

#[test]
fn shards_are_merged_from_the_folder_that_contains_them() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 4"));
    let whole = results(&file, "whole", &[]);
    for (name, shard) in [("one", "0/3"), ("one", "2/3"), ("two", "1/3")] {
        let _ = results(&file, name, &["--shard", shard]);
    }
    let path = |name: &str| file.with_file_name(name).to_str().unwrap().to_owned();
    let merge = ["campaign", "merge", &path("one"), &path("two/shard-1-of-3"), "--out", &path("merged")];
    let output = steward(&merge);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(bytes(&file.with_file_name("merged")), bytes(&whole));
}

/// Each is refused with one message before anything is run or written.
#[test]
fn invalid_campaigns_are_refused_before_the_first_run() {
    let grid = "scenario = \"errand\"\nsampling = \"grid\"\n";
    let steps = |key: &str| format!("[[parameters]]\nkey = \"{key}\"\nfrom = 0\nto = 1\nsteps = 1000000\n");
    for (text, wanted) in [
        (SOME.replace("runs = 24", "rums = 24"), "did you mean `runs`?"),
        (SOME.replace("from = 31", "form = 31"), "did you mean `from`?"),
        (SOME.replace("to = 80", "to = 30"), "`to` must be greater than `from`"),
        (SOME.replace("to = 80", "to = 800"), "between 0 and 100"),
        (SOME.replace("battery.initial_pct", "batery.initial_pct"), "unknown key `batery`"),
        (SOME.replace("battery.initial_pct", "faults.0.at_s"), "faults"),
        (SOME.replace("\"errand\"", "\"erand\""), "unknown scenario `erand`"),
        (SOME.replace("max_time_s=3", "max_time=3"), "unknown key `max_time`"),
        (grid.to_owned() + &steps("noise.laser_sigma_m") + &steps("battery.drain_pct_per_s"), "= 1000000000000 runs"),
    ] {
        let (folder, file) = campaign(&text);
        let out = folder.path().join("out");
        let said = refused(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
        assert!(said.contains(wanted), "{wanted} is missing: {said}");
        assert!(!out.exists(), "{wanted}");
    }
    let (_folder, file) = campaign(SOME);
    let with = |arguments: &[&str]| refused(&[&["campaign", file.to_str().unwrap()], arguments].concat());
    assert!(with(&["--shard", "9/8"]).contains("a shard is I/N, with I from 0 to N-1"));
    assert!(with(&["--runs", "0"]).contains("cannot have 0 runs"));
    assert!(refused(&["campaign", "nowhere.toml"]).contains("nowhere.toml"));
}

#[test]
fn unrelated_results_are_refused_and_left_untouched() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 4"));
    let path = |name: &str| file.with_file_name(name).to_str().unwrap().to_owned();
    let out = results(&file, "out", &[]);
    let before = bytes(&out);
    let again = ["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap(), "--runs", "3"];
    assert!(refused(&again).contains("another campaign"));
    for shard in ["0/2", "1/2"] {
        let _ = results(&file, "shards", &["--shard", shard]);
    }
    let _ = results(&file, "other", &["--shard", "1/2", "--runs", "3"]);
    let (even, odd) = (path("shards/shard-0-of-2"), path("shards/shard-1-of-2"));
    let other = path("other/shard-1-of-2");
    let merged = path("merged");
    let merge = |shards: &[&str], to: &str| refused(&[&["campaign", "merge", "--out", to], shards].concat());
    assert!(merge(&[&even, &other], &merged).contains("another campaign"));
    assert!(merge(&[&even], &merged).contains("shards 0 to 1 are needed"));
    assert!(merge(&[&even, &odd, &odd], &merged).contains("each shard must be present exactly once"));
    assert!(merge(&[&even, &odd], &path("out")).contains("already has results"));
    let journal = fs::read_to_string(format!("{odd}/journal.jsonl")).unwrap();
    fs::write(format!("{odd}/journal.jsonl"), &journal[..journal.len() - 5]).unwrap();
    assert!(merge(&[&even, &odd], &merged).contains("not complete"));
    assert!(!Path::new(&merged).exists());
    let old = String::from_utf8(before[2].clone()).unwrap().replacen("\"version\":\"", "\"version\":\"0.0.", 1);
    fs::write(out.join("journal.jsonl"), &old).unwrap();
    assert!(refused(&again[..4]).contains("results of version 0.0."));
    let journal = String::from_utf8(before[2].clone()).unwrap();
    if journal.contains("\"commit\":\"") {
        fs::write(out.join("journal.jsonl"), journal.replacen("\"commit\":\"", "\"commit\":\"0", 1)).unwrap();
        assert!(refused(&again[..4]).contains("results of commit 0"));
    }
    let other_format = old.replacen("\"format\":4", "\"format\":1", 1).replacen("\"layout\"", "\"columns\"", 1);
    fs::write(out.join("journal.jsonl"), other_format).unwrap();
    let said = refused(&again[..4]);
    let parts = [" in format 1; this program is version ", " and writes format 4"];
    assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    fs::write(out.join("journal.jsonl"), &old).unwrap();
    assert_eq!(fs::read_to_string(out.join("journal.jsonl")).unwrap(), old);
    assert_eq!(bytes(&out)[..2], before[..2]);
    fs::remove_file(out.join("journal.jsonl")).unwrap();
    assert!(refused(&again[..4]).contains("a dataset without its journal"));
    assert_eq!(fs::read(out.join("dataset.parquet")).unwrap(), before[0]);
}

#[test]
fn results_that_are_not_of_a_campaign_are_refused_and_left_untouched() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 2"));
    let path = |name: &str| file.with_file_name(name).to_str().unwrap().to_owned();
    let out = results(&file, "out", &[]);
    let (file, out) = (path("some.toml"), out.to_str().unwrap());
    for name in ["summary.json", "report.html", "timing.csv"] {
        let to = path(&format!("of_{name}"));
        fs::create_dir(&to).unwrap();
        let other = Path::new(&to).join(name);
        fs::write(&other, "mine").unwrap();
        for command in [&["campaign", "merge", out][..], &["campaign", &file], &["campaign", &file, "--fresh"]] {
            let said = refused(&[command, &["--out", &to]].concat());
            assert!(said.contains("without the journal of its campaign"), "{command:?}, {name}: {said}");
            assert_eq!(fs::read_to_string(&other).unwrap(), "mine", "{command:?}, {name}");
            assert_eq!(fs::read_dir(&to).unwrap().count(), 1, "{command:?}, {name}");
        }
    }
}

#[test]
fn a_journal_that_is_not_of_a_campaign_is_refused_and_left_untouched() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 2"));
    let out = file.with_file_name("out");
    let journal = out.join("journal.jsonl");
    fs::create_dir(&out).unwrap();
    let command = ["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    for text in ["mine", "mine\n", "{\"mine\": 1}", "{\"mine\": 1}\n", "{\"plan\": \"mine\"}\n"] {
        fs::write(&journal, text).unwrap();
        for (more, wanted) in [(&[][..], "is damaged"), (&["--fresh"][..], "is not the journal of a campaign")] {
            let said = refused(&[&command[..], more].concat());
            assert!(said.contains(wanted), "{text:?}: {said}");
            assert_eq!(fs::read_to_string(&journal).unwrap(), text);
            assert_eq!(fs::read_dir(&out).unwrap().count(), 1, "{text:?}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 4"));
    let out = file.with_file_name("full");
    fs::create_dir(&out).unwrap();
    std::os::unix::fs::symlink("/dev/full", out.join("journal.jsonl")).unwrap();
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("No space left") && said.contains("journal.jsonl"), "{said}");
}

#[test]
fn a_merge_that_was_killed_halfway_resumes() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 5"));
    let path = |name: &str| file.with_file_name(name).to_str().unwrap().to_owned();
    for shard in ["0/2", "1/2"] {
        let _ = results(&file, "shards", &["--shard", shard]);
    }
    let [even, odd, merged] = ["shards/shard-0-of-2", "shards/shard-1-of-2", "merged"].map(path);
    let merge = || assert_eq!(steward(&["campaign", "merge", &even, &odd, "--out", &merged]).status.code(), Some(0));
    merge();
    let whole = bytes(Path::new(&merged));
    let len = whole[2].len();
    for end in [0, len / 3, len / 2, len] {
        fs::write(format!("{merged}/journal.jsonl"), &whole[2][..end]).unwrap();
        fs::remove_file(format!("{merged}/dataset.parquet")).unwrap();
        merge();
        assert_eq!(bytes(Path::new(&merged)), whole, "cut off at {end} of {len}");
        assert_eq!(timed_runs(Path::new(&merged)), (0..5).collect::<Vec<u64>>());
    }
}

#[test]
fn a_campaign_fails_if_all_its_runs_fail() {
    let (_folder, file) = campaign("scenario = \"errand\"\nruns = 2\nset = [\"execution.step_budget=2\"]\n");
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", file.with_file_name("out").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("2 failed"));
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_removed_during_the_campaign_cannot_be_written() {
    let (_folder, file) = campaign(&SOME.replace("max_time_s=3", "max_time_s=60"));
    for arguments in [&[][..], &["--shard", "0/2"]] {
        let out = file.with_file_name("out");
        let all = [&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()], arguments].concat();
        let child = Command::new(binary()).args(all).stderr(Stdio::piped()).spawn().unwrap();
        let journal = if arguments.is_empty() { out.clone() } else { out.join("shard-0-of-2") }.join("journal.jsonl");
        while fs::read_to_string(&journal).map_or(0, |text| text.lines().count()) < 2 {
            wait(Duration::from_millis(5));
        }
        // The campaign may be writing a file at that moment.
        while out.exists() {
            let _ = fs::remove_dir_all(&out);
        }
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(3), "{said}");
        assert!(said.contains("cannot write") && said.contains("No such file"), "{said}");
    }
}

#[test]
fn the_number_of_shards_is_limited() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 2"));
    for shard in ["0/18446744073709551615", "0/1000000000000"] {
        let said = refusal(&["campaign", file.to_str().unwrap(), "--shard", shard]);
        assert!(said.contains("N at most 1000000"), "{said}");
    }
    // Nor does the program believe such a number in a journal.
    let out = results(&file, "out", &[]);
    let journal = fs::read_to_string(out.join("journal.jsonl")).unwrap();
    for (old, new) in [("\"of\":1", "\"of\":18446744073709551615"), ("\"runs\":2", "\"runs\":18446744073709551615")] {
        fs::write(out.join("journal.jsonl"), journal.replacen(old, new, 1)).unwrap();
        let all = file.with_file_name("all");
        let merge = ["campaign", "merge", out.to_str().unwrap(), "--out", all.to_str().unwrap()];
        assert!(refused(&merge).contains("is damaged"));
    }
}
