//! SPIN's answers about random systems, where SPIN is installed.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use channels::Monitor;
use explorer::{Limits, MessageFaults, Model, NotExported, Outcome, Reduction, Ticks, explore, promela};

use crate::keepers;
use crate::random_systems::{message_faults, sample};

/// Runs a program in a folder and returns its output.
fn run(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let finished =
        Command::new(program).args(arguments).current_dir(folder).output().expect("a program that can be run");
    let output = String::from_utf8_lossy(&finished.stdout).into_owned();
    let complains = String::from_utf8_lossy(&finished.stderr);
    assert!(finished.status.success(), "{program} {}: {output}{complains}", arguments.join(" "));
    output
}

/// The number of states that SPIN stores, and the number of errors that it finds.
fn ask(text: &str) -> (u64, u64) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("model.pml"), text).expect("a file");
    run(folder.path(), "spin", &["-a", "-o1", "-o2", "-o3", "model.pml"]);
    run(folder.path(), "cc", &["-w", "-DSAFETY", "-DNOREDUCE", "-o", "pan", "pan.c"]);
    let pan = folder.path().join("pan");
    let output = run(folder.path(), pan.to_str().expect("a path"), &["-c0", "-m200000", "-w18", "-n"]);
    assert!(!output.contains("max search depth too small"), "{output}");
    let number = |words: &mut dyn Iterator<Item = &str>| words.next().and_then(|word| word.parse().ok());
    let stored = output.lines().find(|line| line.contains("states, stored")).map(str::split_whitespace);
    let errors = output.split("errors:").nth(1).map(str::split_whitespace);
    let [stored, errors] = [stored, errors].map(|words| words.and_then(|mut words| number(&mut words)));
    (stored.expect("states"), errors.expect("errors"))
}

fn has_spin() -> bool {
    let there_is = |program| Command::new(program).arg("--version").output().is_ok();
    there_is("spin") && there_is("cc")
}

/// How many systems SPIN checked, and in how many of them the property is violated.
fn compare(seeds: impl Iterator<Item = u64>) -> (usize, usize) {
    let (mut asked, mut violated) = (0, 0);
    for seed in seeds {
        let sample = sample(seed);
        let property = sample.monitor.as_ref().map(|monitor| monitor as &dyn Monitor);
        let faults = MessageFaults { repeated: u8::from(seed % 8 < 2), ..message_faults(seed, &sample.system) };
        let mut model = Model::new(&sample.system, Some(sample.ticks), sample.environment).with_message_faults(faults);
        if seed.is_multiple_of(10) {
            model = model.with_interleaved_drivers();
        }
        let limits = Limits { reduction: Reduction::Off, ..Limits::default() };
        let exported = match promela(&model, property, &limits, &mut |_| ()) {
            // Promela has only what is received.
            Err(NotExported::Shown { .. }) => continue,
            exported => exported.expect("a finite model"),
        };
        if exported.states > 40_000 {
            continue;
        }
        let found = explore(&model, property, &limits, &mut |_| ()).expect("a finite model");
        // Messages that pile up are an error, too.
        let is_violated = matches!(found.outcome, Outcome::Violated(_) | Outcome::Endless(_));
        let (stored, errors) = ask(&exported.text);
        assert_eq!(errors > 0, is_violated, "seed {seed}");
        // If they pile up while time passes, SPIN goes on as if they did not: to states of no run.
        assert!(stored == exported.states || is_violated && keepers::is_one(seed), "seed {seed}: {stored}");
        assert!(is_violated || found.progress.states == exported.states, "seed {seed}");
        (asked, violated) = (asked + 1, violated + usize::from(is_violated));
    }
    (asked, violated)
}

/// How many random systems are tried.
const SYSTEMS: u64 = 140;

#[test]
#[ignore = "long: .ci/run runs it"]
fn spin_stores_as_many_states_and_gives_the_same_verdicts() {
    if !has_spin() {
        println!("not run here: spin or cc is not installed");
        return;
    }
    let halves = std::thread::scope(|scope| {
        let threads = [0, 1].map(|half| scope.spawn(move || compare((0..SYSTEMS).filter(|seed| seed % 2 == half))));
        threads.map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let (asked, violated) = (halves[0].0 + halves[1].0, halves[0].1 + halves[1].1);
    assert!(asked >= 100 && violated > 20 && asked - violated > 20, "{asked} checked, {violated} violated");
    println!(
        "ran: spin on {asked} systems, {violated} of them violated; {} were too large, or show \
        their property something",
        SYSTEMS - asked as u64
    );
}

#[test]
fn times_must_fit_into_promela_integers() {
    let sample = sample(0);
    let ticks = Ticks { first: Duration::from_nanos(1), ..sample.ticks };
    let model = Model::new(&sample.system, Some(ticks), sample.environment);
    let refused = promela(&model, None, &Limits::default(), &mut |_| ()).unwrap_err();
    let NotExported::TimesTooFine { longest, unit } = refused else { panic!("{refused}") };
    assert_eq!((longest, unit), (Duration::from_secs(10), Duration::from_nanos(1)));
}
