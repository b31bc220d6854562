//! The paper's experiments, run again.

use serde_json::Value;
use tempfile::tempdir;

use crate::report_page::look_at;
use crate::steward::steward;

#[test]
fn every_run_is_as_the_paper_says_and_its_figures_are_there() {
    let out = tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let output = steward(&["reproduce", "--seeds", "2", "--out", folder]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("All 8 runs are as the paper says."), "{said}");
    for words in ["Experiment 1: ", "Experiment 2: ", "Experiment 3: ", "Figure 8 (b)", "2/2"] {
        assert!(said.contains(words), "{words} is missing in\n{said}");
    }
    let results: Value =
        serde_json::from_str(&std::fs::read_to_string(out.path().join("reproduce.json")).unwrap()).unwrap();
    assert_eq!(results["experiments"].as_array().unwrap().len(), 4);
    let page = std::fs::read_to_string(out.path().join("index.html")).unwrap();
    for figure in ["Figure 1", "Figure 5", "Figure 6", "Figure 7", "Figure 8", "Experiment 2"] {
        assert!(page.contains(&format!(">{figure}")), "{figure} is missing");
    }
    for elsewhere in ["src=\"http", "href=\"http", "url(http", "@import", "<script"] {
        assert!(!page.contains(elsewhere), "the page has {elsewhere}");
    }
    look_at("reproduce", &out.path().join("index.html"), 19);
}

#[test]
fn the_results_are_the_same_every_time() {
    let run = || {
        let out = tempdir().unwrap();
        let output = steward(&["reproduce", "--seeds", "1", "--json", "--out", out.path().to_str().unwrap()]);
        (output.stdout, std::fs::read(out.path().join("index.html")).unwrap())
    };
    assert!(run() == run());
}

#[test]
fn no_seeds_are_no_reproduction() {
    let said = crate::steward::refusal(&["reproduce", "--seeds", "0"]);
    assert!(said.contains("--seeds"), "{said}");
}
