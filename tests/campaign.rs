//! Campaigns: the same results in the same bytes, however they were come by.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

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

/// A folder with a campaign's file.
fn campaign(text: &str) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let file = folder.path().join("some.toml");
    fs::write(&file, text).unwrap();
    (folder, file)
}

/// Runs a campaign with these further arguments; the folder of its results.
fn results(file: &Path, name: &str, arguments: &[&str]) -> PathBuf {
    let out = file.with_file_name(name);
    let mut all = vec!["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    all.extend(arguments);
    let output = steward(&all);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

/// What the binary says when it refuses its input, in one line: the graphical report breaks lines between words.
fn refused(arguments: &[&str]) -> String {
    refusal(arguments).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// Everything but wall times.
fn bytes(folder: &Path) -> [Vec<u8>; 4] {
    ["dataset.parquet", "summary.json", "journal.jsonl", "report.html"].map(|name| fs::read(folder.join(name)).unwrap())
}

#[test]
fn threads_and_shards_change_no_byte() {
    let (_folder, file) = campaign(SOME);
    let whole = results(&file, "whole", &[]);
    let out = file.with_file_name("one");
    let one = Command::new(env!("CARGO_BIN_EXE_steward"))
        .args(["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .unwrap();
    assert!(one.status.success());
    assert_eq!(bytes(&whole), bytes(&out), "one thread");
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
    }
    let summary: serde_json::Value = serde_json::from_slice(&bytes(&whole)[1]).unwrap();
    assert_eq!(summary["outcomes"]["failed"], 12, "a system that is never quiet is a result");
    assert!(summary["failures"][0]["command"].as_str().unwrap().contains(" --only "), "{summary}");
    assert_eq!(fs::read_to_string(whole.join("timing.csv")).unwrap().lines().count(), 25);
}

#[test]
fn what_was_killed_goes_on_without_a_run_lost_repeated_or_different() {
    let (_folder, file) = campaign(SOME);
    let whole = bytes(&results(&file, "whole", &[]));
    let out = file.with_file_name("killed");
    let mut kills = 0;
    for delay_ms in (0..20).map(|n| 15 + n * 37 % 190) {
        let mut child = Command::new(env!("CARGO_BIN_EXE_steward"))
            .args(["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        wait(delay_ms);
        let ended = child.try_wait().unwrap().is_some();
        // On Unix, this is kill -9.
        child.kill().unwrap();
        child.wait().unwrap();
        kills += u32::from(!ended);
    }
    assert!(kills > 0, "nothing was killed");
    assert_eq!(bytes(&results(&file, "killed", &[])), whole);
    let timed = fs::read_to_string(out.join("timing.csv")).unwrap();
    let runs: Vec<String> = timed.lines().skip(1).map(|line| line.split(',').next().unwrap().to_owned()).collect();
    assert_eq!(runs, (0..24).map(|k| k.to_string()).collect::<Vec<_>>());
}

#[expect(clippy::disallowed_methods, reason = "a process is killed at any moment")]
fn wait(delay_ms: u64) {
    std::thread::sleep(std::time::Duration::from_millis(delay_ms));
}

/// Wherever a journal breaks off, what comes of it is the same.
#[test]
fn a_journal_may_break_off_at_any_byte() {
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
fn a_campaign_stops_at_its_goal_and_there_is_nothing_to_go_on_with() {
    let goal = "[goal]\nestimate = \"expectation\"\nhalf_width = 0.25\nconfidence = 0.8\n";
    let (_folder, file) = campaign(&(SOME.replace("runs = 24\n", "") + goal));
    let out = results(&file, "out", &[]);
    let summary: serde_json::Value = serde_json::from_slice(&bytes(&out)[1]).unwrap();
    assert_eq!(summary["goal"]["reached"], true, "{summary}");
    assert_eq!(summary["goal"]["count"]["runs"], summary["runs"]);
    assert_eq!(bytes(&out), bytes(&results(&file, "out", &[])), "again, it is reached already");
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
    let alone = results(&file, "alone", &["--only", &k]).join(format!("run-{k}"));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(alone.join("report.json")).unwrap()).unwrap();
    assert_eq!(report["trace_hash"], ended["facts"]["trace_hash"]);
    assert!(alone.join("report.html").exists());
    let failed = runs.iter().find(|run| run["outcome"] == "failed").unwrap();
    let only = ["campaign", file.to_str().unwrap(), "--only", &failed["k"].to_string()];
    assert!(refused(&only).contains(failed["failure"].as_str().unwrap()), "{failed}");
    assert!(refused(&[&only[..3], &["6"]].concat()).contains("no run 6"));
}

#[test]
fn what_does_not_belong_together_is_refused_and_left_untouched() {
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
    assert!(merge(&[&even], &merged).contains("of the shards 0 to 1"));
    assert!(merge(&[&even, &odd, &odd], &merged).contains("each must be there once"));
    assert!(merge(&[&even, &odd], &path("out")).contains("has results already"));
    let journal = fs::read_to_string(format!("{odd}/journal.jsonl")).unwrap();
    fs::write(format!("{odd}/journal.jsonl"), &journal[..journal.len() - 5]).unwrap();
    assert!(merge(&[&even, &odd], &merged).contains("not complete"));
    assert!(!Path::new(&merged).exists());
    let old = String::from_utf8(before[2].clone()).unwrap().replacen("\"version\":\"", "\"version\":\"0.0.", 1);
    fs::write(out.join("journal.jsonl"), &old).unwrap();
    assert!(refused(&again[..4]).contains("results of version 0.0."));
    assert_eq!(fs::read_to_string(out.join("journal.jsonl")).unwrap(), old);
    assert_eq!(bytes(&out)[..2], before[..2]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_and_leaves_results_as_they_were() {
    let (_folder, file) = campaign(&SOME.replace("runs = 24", "runs = 4"));
    let out = file.with_file_name("full");
    fs::create_dir(&out).unwrap();
    std::os::unix::fs::symlink("/dev/full", out.join("journal.jsonl")).unwrap();
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("No space left") && said.contains("journal.jsonl"), "{said}");
    let whole = results(&file, "whole", &[]);
    let before = bytes(&whole);
    std::os::unix::fs::symlink("/dev/full", whole.join("dataset.parquet.part")).unwrap();
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", whole.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("No space left"), "{said}");
    assert_eq!(bytes(&whole), before);
}
