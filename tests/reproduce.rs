//! The paper's experiments, run again.

use serde_json::Value;
use tempfile::tempdir;

use crate::report_page::look_at;
use crate::steward::steward;

#[test]
#[ignore = "long: .ci/run runs it"]
fn every_claim_is_true_of_every_run_and_the_figures_are_there() {
    let out = tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let output = steward(&["reproduce", "--seeds", "2", "--out", folder]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let outcome = "8 runs in simulation, 2 of the undisturbed scenario and of each of the three experiments: each of the 20 \
                   claims taken from the paper was true";
    assert!(said.contains(outcome), "{said}");
    assert!(said.contains("it watches only the replies"), "what is not claimed is said: {said}");
    for words in [
        "Experiment 1: ",
        "Experiment 2: ",
        "a monitor on a real robot (simulated here)",
        "Figure 8 (b)",
        "2/2",
        "Figure 4 and Section V-A; θ is the published code's",
        "Figure 5 (b) and Section V-B",
        "Ours, not the paper's",
        "it waits there until the battery is full: it leaves only at 99.7 %",
        "idle → get → failure",
    ] {
        assert!(said.contains(words), "{words} is missing in\n{said}");
    }
    let results: Value =
        serde_json::from_str(&std::fs::read_to_string(out.path().join("reproduce.json")).unwrap()).unwrap();
    assert_eq!(results["version"], env!("CARGO_PKG_VERSION"));
    let experiments = results["experiments"].as_array().unwrap();
    assert_eq!(experiments.len(), 4);
    let violated = &experiments[2]["runs"][0]["violated_at_tick"];
    assert_eq!((&violated["phi2"], &violated["figure_5b"]), (&Value::from(31), &Value::from(32)));
    let page = std::fs::read_to_string(out.path().join("index.html")).unwrap();
    for figure in 1..=8 {
        assert!(page.contains(&format!(">Figure {figure}:")), "figure {figure} is missing");
    }
    for words in [
        "Everything on this page was simulated",
        "What is ours",
        "Where this system differs from the published one",
        "time_until ( event ) relop const\nevent ",
        "timer := θ",
        "fail at the ticks 32 and 31",
    ] {
        assert!(page.contains(words), "{words} is missing");
    }
    for experiment in experiments {
        for run in experiment["runs"].as_array().unwrap() {
            assert!(page.contains(run["trace_hash"].as_str().unwrap()), "the page has all trace hashes");
        }
    }
    let captions = page.split("aria-label=").filter(|drawing| drawing.contains("monitor as published"));
    assert!(captions.count() >= 4, "the published monitors are drawn");
    let labels = page.split("<text").filter_map(|text| text.split_once('>'));
    let clipped: Vec<&str> = labels.map(|(_, label)| label).filter(|label| label.contains("…<")).collect();
    assert!(clipped.is_empty(), "{clipped:?}");
    for elsewhere in ["src=\"http", "href=\"http", "url(http", "@import", "<script src"] {
        assert!(!page.contains(elsewhere), "the page has {elsewhere}");
    }
    look_at("reproduce", &out.path().join("index.html"), 23);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_results_are_the_same_every_time() {
    let run = || {
        let out = tempdir().unwrap();
        let output = steward(&["reproduce", "--seeds", "1", "--json", "--out", out.path().to_str().unwrap()]);
        (output.stdout, std::fs::read(out.path().join("index.html")).unwrap())
    };
    assert!(run() == run());
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_command_below_a_panel_is_the_run_of_the_panel() {
    let out = tempdir().unwrap();
    let output = steward(&["reproduce", "--seeds", "1", "--json", "--out", out.path().to_str().unwrap()]);
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    let figures = r#"monitors=[{ figure = "5 (a)" }, { figure = "5 (b)" }]"#;
    let run = crate::steward::report(
        "battery_fault",
        &out.path().join("run"),
        &["--set", figures, "--set", "snapshots.at_s=[20.02]"],
    );
    assert_eq!(run["trace_hash"], results["experiments"][1]["runs"][0]["trace_hash"]);
    let at = |shot: &Value| shot["time_s"] == 20.02;
    assert!(run["snapshots"].as_array().unwrap().iter().any(at), "{}", run["snapshots"]);
}

#[test]
fn another_map_and_another_form_of_the_tree_are_accepted_and_named() {
    let folder = tempdir().unwrap();
    let maps = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    for (from, to) in [("house.yaml", "own.yaml"), ("house.pgm", "house.pgm"), ("house.places.toml", "own.toml")] {
        std::fs::copy(maps.join(from), folder.path().join(to)).unwrap();
    }
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (map, places, out) = (path("own.yaml"), path("own.toml"), path("out"));
    let arguments =
        ["reproduce", "--seeds", "1", "--json", "--map", &map, "--places", &places, "--tree", "nodes", "--out", &out];
    let output = steward(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(results["settings"][2], "execution.tree=nodes");
    assert!(results["settings"].to_string().contains("own.yaml"));
    let page = std::fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(page.contains("--tree nodes") && page.contains("own.toml"));
    std::fs::write(folder.path().join("own.yaml"), "image: none.pgm\n").unwrap();
    assert!(crate::steward::refusal(&arguments).contains("none.pgm"));
}

#[test]
fn a_reproduction_needs_seeds() {
    let said = crate::steward::refusal(&["reproduce", "--seeds", "0"]);
    assert!(said.contains("--seeds"), "{said}");
}
