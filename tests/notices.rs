//! Notices that licenses require.

use std::collections::{BTreeMap, BTreeSet};

use crate::steward::steward;
use crate::workspace::{Package, metadata};

const NOTICES: &str = include_str!("../THIRD-PARTY.md");

/// The licenses of an expression that LICENSE-APACHE does not cover: of several choices, MIT or else the first.
fn to_be_named(expression: &str) -> BTreeSet<String> {
    let chosen = expression.split(" AND ").filter_map(|part| {
        let choices: Vec<&str> =
            part.trim_matches(['(', ')']).split(" OR ").flat_map(|choice| choice.split('/')).map(str::trim).collect();
        // The public domain requires nothing.
        let is_free = choices.iter().any(|choice| ["Apache-2.0", "CC0-1.0"].contains(choice));
        let chosen = choices.iter().find(|choice| **choice == "MIT").or(choices.first());
        chosen.filter(|_| !is_free).map(|chosen| (*chosen).to_owned())
    });
    chosen.collect()
}

/// The crates that the program consists of, with all its features, without those of this workspace.
#[cfg(target_os = "linux")]
fn crates() -> Vec<Package> {
    let platform = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let metadata = metadata(&["--filter-platform", &platform, "--features", "dds"]);
    let resolve = metadata.resolve.expect("dependencies are resolved");
    let nodes: BTreeMap<&str, _> = resolve.nodes.iter().map(|node| (&*node.id, node)).collect();
    let mut found: BTreeSet<&str> = BTreeSet::new();
    let mut next: Vec<&str> = resolve.root.iter().map(|root| &**root).collect();
    while let Some(id) = next.pop() {
        if found.insert(id) {
            next.extend(nodes[id].normal_dependencies());
        }
    }
    let found = |package: &Package| found.contains(&*package.id) && package.source.is_some();
    metadata.packages.iter().filter(|package| found(package)).cloned().collect()
}

#[cfg(target_os = "linux")]
#[test]
fn every_required_notice_is_there() {
    let mut wanted: BTreeSet<(String, String)> = BTreeSet::new();
    for package in crates() {
        let expression = package.license.as_deref().unwrap_or("a licence of its own");
        wanted.extend(to_be_named(expression).into_iter().map(|licence| (licence, package.name.to_string())));
    }
    let mut named: BTreeSet<(String, String)> = BTreeSet::new();
    let unwrapped = NOTICES.replace("\n  ", " ");
    for section in unwrapped.split("\n## ").skip(1) {
        let (licence, rest) = section.split_once('\n').unwrap();
        assert!(rest.contains("```text\n"), "{licence} has no text");
        let entries = rest.lines().filter_map(|line| line.strip_prefix("- ")?.split_once(": "));
        let names = entries.flat_map(|(names, _)| names.split(", "));
        named.extend(names.map(|name| (licence.to_owned(), name.to_owned())));
    }
    let difference =
        |a: &BTreeSet<(String, String)>, b: &BTreeSet<(String, String)>| a.difference(b).cloned().collect::<Vec<_>>();
    let (missing, stale) = (difference(&wanted, &named), difference(&named, &wanted));
    assert!(missing.is_empty() && stale.is_empty(), "THIRD-PARTY.md lacks {missing:?} and need not have {stale:?}");
}

#[test]
fn a_license_is_named_unless_a_different_one_may_be_chosen() {
    let named = |expression| to_be_named(expression).into_iter().collect::<Vec<_>>().join(" ");
    assert_eq!(named("MIT OR Apache-2.0"), "");
    assert_eq!(named("Unlicense/MIT"), "MIT");
    assert_eq!(named("BSD-3-Clause"), "BSD-3-Clause");
    assert_eq!(named("(MIT OR Apache-2.0) AND OFL-1.1 AND Ubuntu-font-1.0"), "OFL-1.1 Ubuntu-font-1.0");
}

#[test]
fn the_program_prints_the_notices() {
    let output = steward(&["licenses"]);
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap(), NOTICES);
}
