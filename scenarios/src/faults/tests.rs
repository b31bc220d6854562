use std::collections::BTreeSet;

use diagnostics::document::Document;

use super::*;

/// Reads an entry of `[[faults]]`.
fn read(text: &str) -> Result<Fault, diagnostics::FileProblems> {
    Document::parse_toml("fault.toml", text)?.read(Fault::read)
}

#[test]
fn every_kind_has_a_unique_name_and_a_valid_example() {
    let names: BTreeSet<&str> = KINDS.iter().map(|kind| kind.name).collect();
    assert_eq!(names.len(), KINDS.len());
    for kind in KINDS {
        let fault = read(&format!("kind = \"{}\"\n{}", kind.name, kind.example))
            .unwrap_or_else(|problems| panic!("{}: {problems}", kind.name));
        assert_eq!(fault.kind().name, kind.name);
        assert!(!fault.words().is_empty() && !fault.words().ends_with('.'), "{}", fault.words());
    }
}

#[test]
fn every_kind_has_a_scenario_that_shows_it() {
    for kind in KINDS {
        let name = format!("faults/{}", kind.name);
        let found = crate::scenario::find::find(&name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let scenario = crate::scenario::Scenario::load(&found, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(scenario.name, name);
        assert!(scenario.file.faults.iter().any(|fault| fault.kind().name == kind.name), "{name}");
    }
}

#[test]
fn the_list_of_the_kinds_covers_every_file() {
    let subsystems: BTreeSet<_> = KINDS.iter().map(|kind| kind.subsystem).collect();
    assert_eq!(subsystems.len(), 8);
    assert!(KINDS.is_sorted_by_key(|kind| kind.subsystem), "the kinds are ordered by subsystem");
}

#[test]
fn all_errors_in_a_fault_are_reported_at_once() {
    let problems = |text: &str| -> Vec<String> {
        let problems = read(text).expect_err(text);
        problems.problems().iter().map(|problem| problem.message().to_owned()).collect()
    };
    assert_eq!(
        problems("kind = \"battery_level\"\nlevel_pct = 180\nlasts_s = 3"),
        [
            "this fault has no trigger",
            "`level_pct` must lie between 0 and 100",
            "this fault is instantaneous and cannot last",
        ]
    );
    assert_eq!(
        problems("kind = \"joypad\"\nat_s = 1\nnear = \"start\"\nangular_rad = 1"),
        ["this fault has several triggers: `at_s`, `near`", "unknown key `angular_rad`"]
    );
    assert_eq!(problems("kind = \"joipad\"\nat_s = 1"), ["`kind` cannot be `joipad`"]);
    assert_eq!(problems("kind = \"joypad\"\nin_state = \"running\""), ["`running` is not a state of a skill"]);
    for fraction in [
        "kind = \"people\"\nat = [4, 3]\nroute = [[6, 3]]\ncount = 2.7",
        "kind = \"skill_guard_negated\"\nskill = \"A\"\nstate = \"get\"\nnth = 1.5",
        "kind = \"message_corrupted\"\nfrom = \"A\"\nto = \"B\"\nvalue = \"15\"\nfield = 2.5",
    ] {
        let [reported] = &problems(&format!("{fraction}\nat_s = 1"))[..] else { panic!("{fraction}") };
        assert!(reported.contains("must be an integer"), "{reported}");
    }
    assert_eq!(
        problems("kind = \"joypad\"\nat_s = 1\ntimes = 3"),
        ["a fault at a single time is active once, but `times` is larger"]
    );
}

#[test]
fn faults_at_fixed_times_may_overlap_only_if_their_times_do() {
    let timing = |text: &str| read(&format!("kind = \"joypad\"\n{text}")).expect(text).timing;
    let dt = std::time::Duration::from_millis(20);
    let overlap = |one: &str, other: &str| {
        let (one, other) = (timing(one), timing(other));
        assert_eq!(one.may_overlap(&other, dt), other.may_overlap(&one, dt));
        one.may_overlap(&other, dt)
    };
    assert!(!overlap("at_s = 0\nlasts_s = 5", "at_s = 5"));
    assert!(overlap("at_s = 0\nlasts_s = 5", "at_s = 4.98"));
    // From 0.02 s to 5.04 s, in steps.
    assert!(overlap("at_s = 0.001\nlasts_s = 5.005", "at_s = 5.006\nlasts_s = 1"));
    assert!(!overlap("at_s = 0.001\nlasts_s = 5.005", "at_s = 5.021\nlasts_s = 1"));
    assert!(overlap("at_s = 10", "at_s = 100"));
    assert!(overlap("at_s = 0\nevery_s = 50\nlasts_s = 1", "at_s = 100\nlasts_s = 1"));
    assert!(overlap("at_s = 0\nlasts_s = 1", "near = \"start\""));
}
