//! The arrows of ARCHITECTURE.md: which crate may use which.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Each crate of the workspace with the others that it may use.
const ROOMS: [(&str, &[&str]); 10] = [
    ("channels", &[]),
    ("maps", &[]),
    ("robot", &["maps"]),
    ("sim", &["robot", "maps"]),
    ("nav", &["robot", "maps"]),
    ("bt", &["channels"]),
    ("skills", &["channels"]),
    ("components", &["channels", "nav", "robot", "maps"]),
    ("monitors", &["channels"]),
    ("steward", &["channels", "maps", "robot", "sim", "nav", "bt", "skills", "components", "monitors"]),
];

#[test]
fn no_crate_uses_another_that_it_must_not_know() {
    let metadata = MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_owned()])
        .exec()
        .expect("cargo describes the workspace");
    let rooms = BTreeMap::from(ROOMS);
    let found: BTreeSet<&str> = metadata.packages.iter().map(|package| package.name.as_str()).collect();
    assert_eq!(found, rooms.keys().copied().collect(), "the crates of the workspace");
    for package in &metadata.packages {
        let allowed = rooms[package.name.as_str()];
        let used = package.dependencies.iter().filter(|dependency| dependency.kind == DependencyKind::Normal);
        for dependency in used.filter(|dependency| rooms.contains_key(dependency.name.as_str())) {
            assert!(allowed.contains(&dependency.name.as_str()), "{} must not use {}", package.name, dependency.name);
        }
    }
}

/// What simulates or draws stays out of the crates that are to run on a real robot.
#[test]
fn only_sim_simulates_and_only_scenarios_draws() {
    let metadata = MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_owned()])
        .exec()
        .expect("cargo describes the workspace");
    let owners =
        [("rapier2d", "sim"), ("bevy_ecs", "sim"), ("parry2d", "sim"), ("resvg", "steward"), ("clap", "steward")];
    for package in &metadata.packages {
        for dependency in package.dependencies.iter().filter(|dependency| dependency.kind == DependencyKind::Normal) {
            let owner = owners.iter().find(|(name, _)| *name == dependency.name).map(|(_, owner)| *owner);
            assert!(
                owner.is_none_or(|owner| owner == package.name.as_str()),
                "{} uses {}",
                package.name,
                dependency.name
            );
        }
    }
}
