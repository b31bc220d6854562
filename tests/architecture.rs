//! The arrows of ARCHITECTURE.md: which crate may use which, and that files inside of crates use each other in no circles.

mod circles;
mod modules;

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};

/// Each crate of the workspace with the others that it may use, by the names that code uses.
const ROOMS: [(&str, &[&str]); 18] = [
    ("channels", &[]),
    ("diagnostics", &[]),
    ("maps", &["diagnostics"]),
    ("robot", &["maps"]),
    ("sim", &["robot", "maps"]),
    ("nav", &["robot", "maps"]),
    ("bt", &["channels", "diagnostics"]),
    ("skills", &["channels", "diagnostics"]),
    ("components", &["channels", "nav", "robot", "maps"]),
    ("monitors", &["channels", "diagnostics"]),
    ("batch", &[]),
    ("drawing", &["maps"]),
    ("recording", &["channels", "maps", "robot", "monitors", "bt"]),
    ("trials", &["batch", "maps", "robot", "sim", "nav", "drawing"]),
    (
        "scenarios",
        &[
            "channels",
            "diagnostics",
            "maps",
            "robot",
            "sim",
            "nav",
            "bt",
            "skills",
            "components",
            "monitors",
            "recording",
        ],
    ),
    ("reports", &["channels", "diagnostics", "maps", "robot", "bt", "monitors", "recording", "drawing"]),
    (
        "campaigns",
        &["channels", "diagnostics", "robot", "monitors", "batch", "recording", "drawing", "scenarios", "reports"],
    ),
    (
        "steward",
        &[
            "channels",
            "diagnostics",
            "maps",
            "robot",
            "nav",
            "bt",
            "skills",
            "monitors",
            "batch",
            "drawing",
            "recording",
            "trials",
            "scenarios",
            "reports",
            "campaigns",
        ],
    ),
];

/// What code calls a package: `steward-bt`, as the registry knows it, is the crate `bt`.
fn crate_name(package: &str) -> &str {
    package.strip_prefix("steward-").unwrap_or(package)
}

/// The workspace, as cargo knows it.
fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_owned()])
        .exec()
        .expect("cargo describes the workspace")
}

#[test]
fn no_crate_uses_another_that_it_must_not_know() {
    let metadata = metadata();
    let rooms = BTreeMap::from(ROOMS);
    let found: BTreeSet<&str> = metadata.packages.iter().map(|package| crate_name(&package.name)).collect();
    assert_eq!(found, rooms.keys().copied().collect(), "the crates of the workspace");
    for package in &metadata.packages {
        let allowed = rooms[crate_name(&package.name)];
        let used = package.dependencies.iter().filter(|dependency| dependency.kind == DependencyKind::Normal);
        let used = used.map(|dependency| crate_name(&dependency.name));
        for dependency in used.filter(|dependency| rooms.contains_key(dependency)) {
            assert!(allowed.contains(&dependency), "{} must not use {dependency}", package.name);
        }
    }
}

/// Whoever simulates a robot, or drives one, compiles no readers of YAML, TOML and pictures, and no rendering of errors.
#[test]
fn what_simulates_and_drives_reads_no_files() {
    let readers = ["steward-diagnostics", "image", "miette", "saphyr", "toml"];
    for package in ["steward-robot", "steward-sim", "steward-nav", "components"] {
        let tree = Command::new(env!("CARGO"))
            .args(["tree", "--offline", "--edges", "normal,no-proc-macro", "--prefix", "none", "--package", package])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("cargo lists dependencies");
        let tree = String::from_utf8(tree.stdout).expect("names are text");
        let used: BTreeSet<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
        assert!(used.contains("nalgebra"), "{package}: {tree}");
        assert!(!readers.iter().any(|reader| used.contains(reader)), "{package}: {used:?}");
    }
}

/// What simulates or draws stays out of the crates that are to run on a real robot.
#[test]
fn only_sim_simulates_and_only_drawing_draws() {
    let metadata = metadata();
    let owners =
        [("rapier2d", "sim"), ("bevy_ecs", "sim"), ("parry2d", "sim"), ("resvg", "drawing"), ("clap", "steward")];
    for package in &metadata.packages {
        for dependency in package.dependencies.iter().filter(|dependency| dependency.kind == DependencyKind::Normal) {
            let owner = owners.iter().find(|(name, _)| *name == dependency.name).map(|(_, owner)| *owner);
            assert!(
                owner.is_none_or(|owner| owner == crate_name(&package.name)),
                "{} uses {}",
                package.name,
                dependency.name
            );
        }
    }
}
