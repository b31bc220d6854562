//! ARCHITECTURE.md: the crates, what none of them may use, and that everything on the page exists. Also the files
//! within a crate, which do not use each other in circles.

mod circles;
mod modules;
mod names;
mod page;
mod rooms;
mod rules;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::workspace::{cargo, metadata};

/// The name that the code uses for a package: `steward-bt` in the registry is the crate `bt`.
fn crate_name(package: &str) -> String {
    package.strip_prefix("steward-").unwrap_or(package).replace('-', "_")
}

/// Simulation and robot software compile without readers of YAML, TOML and images, and without error rendering.
#[test]
fn simulation_and_navigation_read_no_files() {
    let readers = ["steward-diagnostics", "steward-rasters", "image", "miette", "saphyr", "toml"];
    for package in ["steward-robot", "steward-sim", "steward-nav", "components"] {
        let tree = cargo(&["tree", "--offline", "--edges=normal,no-proc-macro", "--prefix=none", "--package", package]);
        let tree = String::from_utf8(tree).expect("names are text");
        let used: BTreeSet<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
        assert!(used.contains("nalgebra"), "{package}: {tree}");
        assert!(!readers.iter().any(|reader| used.contains(reader)), "{package}: {used:?}");
    }
}

/// Cargo does not even look for them there.
#[test]
fn libraries_that_are_not_tested_have_no_tests_and_no_examples() {
    let packages = metadata(&["--no-deps"]).packages;
    let libraries = packages.iter().flat_map(|package| &package.targets).filter(|target| target.kind == ["lib"]);
    for library in libraries {
        for (path, text) in sources(library.src_path.parent().unwrap()) {
            assert!(library.test || !text.contains("#[test]"), "{} is not run", path.display());
            let lines = text.lines().map(str::trim_start);
            let docs = lines.filter_map(|line| line.strip_prefix("///").or_else(|| line.strip_prefix("//!")));
            let fences = docs.filter_map(|line| line.trim_start().strip_prefix("```"));
            // Every other one ends a block.
            let has_example = fences.step_by(2).any(|language| ["", "rust", "no_run"].contains(&language));
            assert!(library.doctest || !has_example, "the examples in {} are not run", path.display());
        }
    }
}

/// rustfmt breaks long lines of code, but not of comments.
#[test]
fn comments_fit_120_columns() {
    let files = sources(Path::new(env!("CARGO_MANIFEST_DIR")));
    let long = files.iter().flat_map(|(path, text)| {
        let comments = text.lines().enumerate().filter(|(_, line)| line.trim_start().starts_with("//"));
        let too_long = comments.filter(|(_, line)| line.chars().count() > 120);
        too_long.map(|(number, _)| format!("{}:{}", path.display(), number + 1))
    });
    let long: Vec<String> = long.collect();
    assert!(files.len() > 500 && long.is_empty(), "of {} files: {long:#?}", files.len());
}

/// The Rust files in a folder and below, with their texts.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let (mut folders, mut files) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                folders.push(path);
            } else if name.ends_with(".rs") {
                let text = fs::read_to_string(&path).expect("a source is text");
                files.push((path, text));
            }
        }
    }
    files
}

/// Crates for simulation and drawing stay out of the crates that run on a real robot.
#[test]
fn only_sim_simulates_and_only_drawing_draws() {
    let metadata = metadata(&["--no-deps"]);
    let owners = [
        ("rapier2d", "sim"),
        ("bevy_ecs", "sim"),
        ("parry2d", "sim"),
        ("image", "rasters"),
        ("resvg", "drawing"),
        ("clap", "steward"),
        ("lsp-server", "language_server"),
    ];
    for package in &metadata.packages {
        for used in package.normal_dependencies() {
            let owner = owners.iter().find(|(name, _)| *name == used).map(|(_, owner)| *owner);
            assert!(owner.is_none_or(|owner| owner == crate_name(&package.name)), "{} uses {used}", package.name);
        }
    }
}

/// The packages that the project's owner has chosen, each with a room whose work rests on it.
#[test]
fn every_package_that_the_owner_has_chosen_is_used() {
    let chosen = [
        ("rapier2d", "sim"),
        ("parry2d", "sim"),
        ("bevy_ecs", "sim"),
        ("nalgebra", "maps"),
        ("pathfinding", "nav"),
        ("rand", "robot"),
        ("image", "rasters"),
        ("clap", "steward"),
    ];
    let metadata = metadata(&["--no-deps"]);
    for (name, room) in chosen {
        let package = metadata.packages.iter().find(|package| crate_name(&package.name) == room).expect("a room");
        assert!(package.normal_dependencies().any(|used| used == name), "{room} does not depend on {name}");
        let library = package.targets.iter().find(|target| target.src_path.ends_with("src/lib.rs"));
        let root = library.or(package.targets.first()).expect("a room has code");
        let sources = sources(root.src_path.parent().expect("a file is in a folder"));
        assert!(sources.iter().any(|(_, text)| text.contains(&format!("{name}::"))), "{room} does not use {name}");
    }
}

/// `cargo run` and `cargo test` build the program's dependencies only once: tests need no further features of them.
#[test]
fn tests_share_the_dependencies_of_the_program() {
    let features = |selection: &[&str]| {
        let arguments =
            [&["tree", "--offline", "--prefix=none", "--format={p}|{f}", "--no-dedupe"], selection].concat();
        let tree = String::from_utf8(cargo(&arguments)).expect("names are text");
        let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (package, features) in tree.lines().filter_map(|line| line.split_once('|')) {
            // So a circle of dependencies of tests is cut off.
            let features = features.trim_end_matches(" (*)");
            let features = features.split(',').filter(|feature| !feature.is_empty()).map(str::to_owned);
            found.entry(package.to_owned()).or_default().extend(features);
        }
        found
    };
    let program = features(&["--package=steward", "--edges=normal,build"]);
    let all = features(&["--workspace", "--edges=normal,build,dev"]);
    let more = program.iter().filter(|(package, features)| all[*package] != **features);
    let more: Vec<_> = more.map(|(package, features)| (package, all[package].difference(features))).collect();
    assert!(more.is_empty(), "tests want more features than the program has: {more:?}");
}
