mod losses;
mod partners;

use std::time::Duration;

use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use recording::{Detail, Ended};
use scenarios::faults::KINDS;
use scenarios::scenario::{Found, Scenario, find};
use toml::Table;

use super::Session;
use crate::run::Run;

/// The triggers of faults, which acts do not have.
const TRIGGERS: [&str; 9] =
    ["at_s", "every_s", "at_tick", "near", "within_m", "when", "in_state", "probability", "times"];

/// Runs a session, acts at random moments, and returns the saved scenario and the hash of the trace.
fn play(name: &str, rng: &mut ChaCha8Rng, until: Duration) -> (String, String, usize) {
    let mut session = Session::new(&find::find(name).unwrap(), &[], None).unwrap();
    let mut acts: Vec<usize> = Vec::new();
    while session.view().time() < until {
        while rng.random_bool(0.02) {
            let kind = KINDS.choose(rng).unwrap();
            let mut fault: Table = toml::from_str(kind.example).unwrap();
            TRIGGERS.iter().for_each(|key| drop(fault.remove(*key)));
            fault.insert("kind".to_owned(), kind.name.into());
            if rng.random_bool(0.7) {
                fault.remove("lasts_s");
            }
            acts.extend(session.act(fault).ok());
        }
        if rng.random_bool(0.03)
            && let Some(act) = session.lasting().map(|(act, _)| act).collect::<Vec<_>>().choose(rng)
        {
            session.release(*act).unwrap();
        }
        if rng.random_bool(0.03) {
            drag(&mut session, rng);
        }
        if session.step(Detail::Full).is_err() {
            break;
        }
    }
    session.end();
    (session.saved(), session.view().end().unwrap().trace_hash.clone(), acts.len())
}

/// Moves an object that was put on the floor.
fn drag(session: &mut Session, rng: &mut ChaCha8Rng) {
    let boxes = session.lasting().filter(|(_, act)| act.kind().name == "obstacle_appears");
    let Some(&act) = boxes.map(|(act, _)| act).collect::<Vec<_>>().choose(rng) else { return };
    let at = [rng.random_range(-5.0..5.0), rng.random_range(0.0..8.0), 45.0].map(toml::Value::Float).to_vec();
    let moved = Table::from_iter([("kind".to_owned(), "obstacle_appears".into()), ("at".to_owned(), at.into())]);
    let new = session.replace(act, moved).unwrap();
    assert!(session.lasting().any(|(index, _)| index == new) && session.lasting().all(|(index, _)| index != act));
}

/// The hash of a saved session's trace.
fn replayed(text: &str) -> String {
    let found = Found { text: text.to_owned(), ..find::find("nominal").unwrap() };
    let scenario = Scenario::load(&found, &[]).unwrap_or_else(|error| panic!("{}\n{text}", error.reasons()));
    let until = scenario.file.execution.max_time;
    let seed = scenario.file.seed;
    let mut run = Run::new(scenario.into(), seed, true).unwrap();
    while run.time() < until && run.step().is_ok() {}
    run.end(Ended::Interrupted, Detail::Verdicts).trace_hash
}

#[test]
fn a_saved_session_gives_the_same_trace() {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let mut acts = 0;
    for name in ["nominal", "joypad", "parcel", "errand"] {
        let (text, hash, count) = play(name, rng, Duration::from_secs(20));
        acts += count;
        assert_eq!(replayed(&text), hash, "{text}");
    }
    assert!(acts > 20, "{acts}");
}

#[test]
fn faults_of_the_base_that_are_removed_do_not_happen() {
    let session = Session::new(&find::find("battery_fault").unwrap(), &["faults=[]".to_owned()], None).unwrap();
    assert!(session.view().header().faults.is_empty());
    let saved = Found { text: session.saved(), ..find::find("nominal").unwrap() };
    assert!(Scenario::load(&saved, &[]).unwrap().file.faults.is_empty());
}

#[test]
fn acts_after_the_last_step_change_nothing() {
    let mut session = Session::new(&find::find("nominal").unwrap(), &[], None).unwrap();
    (0..50).for_each(|_| assert!(session.step(Detail::Full).unwrap()));
    session.act(toml::from_str("kind = \"battery_level\"\nlevel_pct = 10").unwrap()).unwrap();
    session.end();
    assert_eq!(replayed(&session.saved()), session.view().end().unwrap().trace_hash);
}

#[test]
fn a_saved_session_of_a_users_own_scenario_lies_beside_it_wherever_that_is() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own.toml");
    std::fs::write(&own, "base = \"nominal\"\nabout = \"mine\"\n").unwrap();
    let session = Session::new(&find::find(own.to_str().unwrap()).unwrap(), &[], None).unwrap();
    let text = session.saved();
    assert!(!text.contains(folder.path().to_str().unwrap()), "{text}");
    let elsewhere = tempfile::tempdir().unwrap();
    std::fs::rename(&own, elsewhere.path().join("own.toml")).unwrap();
    let saved = elsewhere.path().join("own-session.toml");
    std::fs::write(&saved, text).unwrap();
    Scenario::load(&find::find(saved.to_str().unwrap()).unwrap(), &[]).unwrap();
}

#[test]
fn a_fault_that_exists_only_from_the_start_is_no_act() {
    let mut session = Session::new(&find::find("nominal").unwrap(), &[], None).unwrap();
    let act = toml::from_str("kind = \"wrong_map\"\nmap = \"maps/house_shifted.yaml\"").unwrap();
    let refused = session.act(act).unwrap_err().reasons();
    assert!(refused.contains("only from the start"), "{refused}");
    let never: Vec<&str> = KINDS.iter().filter(|kind| !kind.can_begin_later()).map(|kind| kind.name).collect();
    assert_eq!(never, ["wrong_map"]);
}
