//! The scripts that the repository ships: each can be started, and the gate runs it, or it is named here with what runs
//! it instead.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Scripts that other files run: the gate runs those.
const RUN_BY: &[(&str, &str)] = &[
    (".ci/parts.py", ".ci/release"),
    (".ci/same-bits", ".ci/seeds"),
    (".ci/unoptimized", ".ci/features"),
    ("components/guide/tour_planner.py", "scenarios/guide.toml"),
    ("components/programs/examples/speaker.py", "components/programs/tests/conversation.rs"),
    ("ros/messages/tests/random_messages.py", "ros/messages/tests/foreign.py"),
    ("ros/network/tests/apart.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/peer.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/records.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/bridge.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/caller.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/commander.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/cyclone.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/cyclone_actions.py", "ros/network/tests/robots/cyclone_server.py"),
    ("ros/network/tests/robots/cyclone_caller.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/cyclone_goals.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/cyclone_marker.py", "ros/network/tests/pauses.py"),
    ("ros/network/tests/robots/cyclone_nav2.py", "ros/network/tests/robots/cyclone_navigator.py"),
    ("ros/network/tests/robots/cyclone_navigator.py", "ros/network/tests/components.py"),
    ("ros/network/tests/robots/cyclone_ros.py", "ros/network/tests/robots/cyclone_server.py"),
    ("ros/network/tests/robots/cyclone_server.py", "ros/network/tests/components.py"),
    ("ros/network/tests/robots/driver.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/driving.py", "ros/network/tests/robots/navigator.py"),
    ("ros/network/tests/robots/fast.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/firmware.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/fleet.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/goals.py", "ros/network/tests/components.py"),
    ("ros/network/tests/robots/helper.py", "ros/network/tests/components.py"),
    ("ros/network/tests/robots/hostile.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/lines.py", "ros/network/tests/robots/driver.py"),
    ("ros/network/tests/robots/listener.py", "ros/network/tests/sim.py"),
    ("ros/network/tests/robots/marker.py", "ros/network/tests/pauses.py"),
    ("ros/network/tests/robots/navigator.py", "ros/network/tests/components.py"),
    ("ros/network/tests/robots/relay.py", "ros/network/tests/dds.py"),
    ("ros/network/tests/robots/visitor.py", "ros/network/tests/sim.py"),
    ("scenarios/campaigns/slurm.sbatch", "tests/slurm.sh"),
    ("tests/live/attacks.mjs", "tests/live/browser.mjs"),
    ("tests/live/cockpit.mjs", "tests/live/browser.mjs"),
    ("tests/live/experiments.mjs", "tests/live/browser.mjs"),
    ("tests/live/firefox.mjs", "tests/live/browser.mjs"),
    ("tests/live/line.mjs", "tests/live/attacks.mjs"),
    ("tests/live/looks.mjs", "tests/live/browser.mjs"),
    ("tests/live/sessions.mjs", "tests/live/browser.mjs"),
    ("tests/live/strangers.mjs", "tests/live/browser.mjs"),
    ("tests/live/timeline.mjs", "tests/live/browser.mjs"),
    ("tests/live/trees.mjs", "tests/live/browser.mjs"),
];

/// Scripts that the gate does not run, and why.
const NOT_RUN: &[(&str, &str)] = &[
    (".ci/run", "is the gate"),
    (".ci/fast", "runs commands of the gate for those crates that have changed"),
    (".ci/release", "makes what others get, with optimization at link time: a quarter of an hour"),
    (".ci/try-release", "tries what that has made"),
    (".ci/wheel/steward/__main__.py", "is in the wheel, which `.ci/try-release` tries"),
    ("bt/groot/tests/captured/capture.py", "needs BehaviorTree.CPP; what it captured is committed"),
    ("bt/logs/tests/random/generate.py", "makes trees for BehaviorTree.CPP, whose logs are committed"),
    ("bt/tests/answers/generate.py", "makes trees for BehaviorTree.CPP, whose answers are committed"),
    ("ros/bags/benches/speed.py", "measures, for an hour and with gigabytes"),
    ("ros/network/benches/cost.py", "measures, and its figures depend on the machine"),
    ("src/init/recording/make_bag.py", "made the bag of the template, which is committed"),
    ("tests/live/measure.mjs", "measures, and its figures depend on the machine"),
    ("tests/tools/scxml_traces.mjs", "needs SCION, which few machines have"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The scripts, by their paths in the repository: what has the name of one, and everything in `.ci`.
fn scripts() -> Vec<String> {
    let (mut folders, mut scripts) = (vec![PathBuf::new()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).unwrap().map(Result::unwrap) {
            let name = entry.file_name().into_string().unwrap();
            let path = folder.join(&name);
            if entry.file_type().unwrap().is_dir() {
                let is_foreign = ["target", "node_modules", "out"].contains(&&*name);
                let is_hidden = name.starts_with('.') && name != ".ci";
                folders.extend((!is_foreign && !is_hidden).then_some(path));
            } else if folder == Path::new(".ci")
                || [".sh", ".sbatch", ".py", ".mjs"].iter().any(|ending| name.ends_with(ending))
            {
                scripts.push(path.to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    scripts.sort();
    scripts
}

#[test]
fn every_script_can_be_started() {
    let interpreters = ["bash", "python3"].map(|name| format!("#!/usr/bin/env {name}"));
    for name in scripts() {
        let text = read(&name);
        let first = text.lines().next().unwrap_or_default();
        let shell = !name.ends_with(".py") && !name.ends_with(".mjs");
        assert!(!first.starts_with("# !"), "{name}: {first}");
        assert!(!first.starts_with("#!") || interpreters.iter().any(|line| line == first), "{name}: {first}");
        assert!(!shell || first == interpreters[0], "{name} begins with {first:?}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let executable = fs::metadata(root().join(&name)).unwrap().permissions().mode() & 0o111 != 0;
            assert!(!shell || executable, "{name} is not executable");
            let parses =
                || Command::new("bash").arg("-n").arg(root().join(&name)).status().is_ok_and(|it| it.success());
            assert!(!shell || parses(), "bash does not understand {name}");
        }
    }
}

#[test]
fn the_gate_runs_every_script_or_a_reason_is_given() {
    let (scripts, gate) = (scripts(), read(".ci/run"));
    // A Python file imports another without its ending.
    let named = |name: &str| Path::new(name).file_stem().unwrap().to_str().unwrap().to_owned();
    for script in &scripts {
        let by_gate = gate.contains(&**script);
        let by_other = RUN_BY.iter().find(|(name, _)| name == script);
        let reasons = NOT_RUN.iter().filter(|(name, _)| name == script).count();
        let ways = usize::from(by_gate && reasons == 0) + usize::from(by_other.is_some()) + reasons;
        assert_eq!(ways, 1, "{script} is run by the gate, by another file, or not, with a reason");
        assert!(by_other.is_none_or(|(name, runner)| read(runner).contains(&named(name))), "{by_other:?}");
    }
    let listed = RUN_BY.iter().map(|(name, _)| name).chain(NOT_RUN.iter().map(|(name, _)| name));
    let gone: Vec<_> = listed.filter(|name| !scripts.iter().any(|script| script == *name)).collect();
    assert!(gone.is_empty(), "there are no scripts {gone:?}");
}
