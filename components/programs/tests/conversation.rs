//! A well-behaved program: the speaker from the documentation.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use channels::Process as _;
use programs::{Limits, ProgramProcess};

use crate::machine::has_python;
use crate::stage::{Stage, say, sent};

fn speaker() -> (Stage, ProgramProcess) {
    let stage = Stage::new(include_str!("../examples/speaker.py"));
    let mut process = stage.process(Limits::default());
    process.start(Duration::ZERO).unwrap();
    (stage, process)
}

#[test]
fn a_program_answers_requests_and_its_timers_fire_when_they_are_due() {
    if !has_python() {
        return;
    }
    let (stage, mut process) = speaker();
    assert_eq!(process.location(), "silent");
    say(&mut process, 0, 7, "hello", 1.0);
    assert_eq!(process.location(), "speaking");
    assert_eq!((sent(&mut process), process.next_timer()), (vec![], Some(Duration::from_millis(3500))));
    say(&mut process, 1, 3, "welcome", 2.0);
    assert_eq!(sent(&mut process), [("[<error>, \"speaking to Guide\"]".to_owned(), 3)]);
    process.fire_timers(Duration::from_millis(3500));
    assert_eq!(sent(&mut process), [("[<ok>]".to_owned(), 7)]);
    assert_eq!((process.location().as_str(), process.mishaps()), ("silent", &[][..]));
    assert!(!stage.left_over().is_empty() || !Path::new("/proc").exists());
    drop(process);
    assert_eq!(stage.left_over(), [""; 0]);
}

#[test]
fn a_successor_does_not_have_what_its_predecessor_received() {
    if !has_python() {
        return;
    }
    let (stage, mut process) = speaker();
    say(&mut process, 0, 7, "hello", 1.0);
    let before = stage.left_over().len();
    let mut successor = process.succeeding(&process, Duration::from_secs(2));
    assert_eq!((successor.location().as_str(), successor.next_timer()), ("silent", None));
    assert_eq!(stage.left_over().len(), before, "the predecessor has ended");
    say(&mut successor, 1, 3, "welcome", 2.0);
    assert_eq!(successor.next_timer(), Some(Duration::from_millis(5500)));
    drop((process, successor));
    assert_eq!(stage.left_over(), [""; 0]);
}

#[test]
fn copies_are_equal_until_they_receive_different_messages_and_only_one_can_continue() {
    if !has_python() {
        return;
    }
    let (_stage, mut process) = speaker();
    let mut copy = process.clone();
    assert_eq!(process, copy);
    say(&mut process, 0, 7, "hello", 1.0);
    assert_ne!(process, copy);
    say(&mut copy, 0, 7, "hello", 1.0);
    let message = "the program, sent `say` by Guide, has continued with another copy of this process";
    assert_eq!(copy.mishaps()[0].message, message);
    process.fire_timers(Duration::from_secs(9));
    assert_eq!(sent(&mut process), [("[<ok>]".to_owned(), 7)]);
}

#[test]
fn programs_that_run_at_the_same_time_do_not_end_each_other() {
    if !has_python() {
        return;
    }
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let (stage, mut process) = speaker();
                for request in 0..20 {
                    say(&mut process, 0, request, "hi", request as f64 * 2.0);
                    process.fire_timers(process.next_timer().unwrap());
                    assert_eq!(sent(&mut process), [("[<ok>]".to_owned(), request)]);
                }
                drop(process);
                assert_eq!(stage.left_over(), [""; 0]);
            });
        }
    });
}

#[test]
fn the_speaker_of_the_page_answers_as_on_the_page() {
    const PAGE: &str = include_str!("../../../docs/src/how-to/program-components.md");
    let block = |from: &str, kind: &str| {
        let block = PAGE.split_once(from).unwrap().1.split_once(&format!("```{kind}\n")).unwrap().1;
        block.split_once("```").unwrap().0
    };
    let program = block("`speaker.py`:", "py");
    assert_eq!(program, include_str!("../examples/speaker.py"));
    if !has_python() {
        return;
    }
    let stage = Stage::new(program);
    std::fs::write(stage.folder.path().join("told.jsonl"), block("`told.jsonl`:", "json")).unwrap();
    let told = std::fs::File::open(stage.folder.path().join("told.jsonl")).unwrap();
    let output = Command::new("python3").arg("program.py").current_dir(&stage.folder).stdin(told).output().unwrap();
    let (_, answers) = block("`told.jsonl`:", "console").split_once('\n').unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout), answers);
}
