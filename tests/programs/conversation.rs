//! A program that talks to a client, without a run around it.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, Domain, Envelope, FieldKind, Message, Process, RequestNumber, Role, Shape, Topology,
    TransitionId, Value,
};
use programs::{Limits, Program, ProgramProcess, Word};
use skills::Datum;
use tempfile::TempDir;

use crate::steward::binary;

/// Whether Python is installed; says so if not.
pub(crate) fn has_python() -> bool {
    let found = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("not run here: no python3");
    }
    found
}

/// A folder with a program in it.
pub(super) struct Stage {
    pub(super) folder: TempDir,
}

impl Stage {
    pub(super) fn new(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("program.py"), text).unwrap();
        Self { folder }
    }

    /// The program, run by Python.
    pub(super) fn process(&self, limits: Limits) -> ProgramProcess {
        let file = self.folder.path().join("program.py");
        self.command(&["python3", file.to_str().unwrap()], limits)
    }

    pub(super) fn command(&self, command: &[&str], limits: Limits) -> ProgramProcess {
        programs::keep_with(binary());
        let words = command.iter().map(|word| Word::Text((*word).to_owned())).collect();
        let program = Program::new(words, Some(self.folder.path()), limits).unwrap();
        let topology = topology();
        let speaker = topology.find_process("Speaker").unwrap();
        let data = Datum::object([("seconds_per_letter", 0.5.into())]).unwrap();
        ProgramProcess::new(&topology, speaker, Arc::new(program), data)
    }

    /// The command lines of the processes that run there.
    pub(super) fn left_over(&self) -> Vec<String> {
        left_over(self.folder.path())
    }
}

/// The command lines of running processes that name this folder or work in it.
pub(super) fn left_over(folder: &Path) -> Vec<String> {
    let command_line = |entry: std::io::Result<std::fs::DirEntry>| {
        let process = entry.ok()?.path();
        let line = String::from_utf8_lossy(&std::fs::read(process.join("cmdline")).ok()?).replace('\0', " ");
        let works_there = std::fs::read_link(process.join("cwd")).is_ok_and(|place| place.starts_with(folder));
        (works_there || line.contains(folder.to_str()?)).then_some(line)
    };
    std::fs::read_dir("/proc").into_iter().flatten().filter_map(command_line).collect()
}

/// A speaker with two clients.
fn topology() -> Topology {
    let mut topology = Topology::default();
    let speaker = topology.process("Speaker").unwrap();
    for client in ["Guide", "Host"] {
        let client = topology.process(client).unwrap();
        let say = Shape::new([("request", FieldKind::symbols(["say"])), ("text", FieldKind::Text)]);
        let ok = Shape::new([("reply", FieldKind::symbols(["ok"]))]).with_role(Role::Reply);
        let error = Shape::new([("reply", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]);
        topology.channel(client, speaker, Capacity::One, Domain::new([say])).unwrap();
        topology.channel(speaker, client, Capacity::One, Domain::new([ok, error.with_role(Role::Reply)])).unwrap();
    }
    topology
}

/// Lets a client, 0 or 1, send a text with this request number.
pub(super) fn say(process: &mut ProgramProcess, client: u32, request: u64, text: &str, at_s: f64) {
    let message = Message::new([Value::symbol("say"), text.into()]);
    let envelope = Envelope { message, request: RequestNumber(request) };
    process.take(TransitionId(client), Some(envelope), Duration::from_secs_f64(at_s));
}

/// Takes everything that the process wants to send, with the request numbers.
pub(super) fn sent(process: &mut ProgramProcess) -> Vec<(String, u64)> {
    let mut sent = Vec::new();
    loop {
        let mut offers = Vec::new();
        process.offers(&mut offers);
        let next = offers.into_iter().find_map(|offer| match offer.action {
            Action::Send(_, envelope) => Some((offer.transition, envelope)),
            _ => None,
        });
        let Some((transition, envelope)) = next else { return sent };
        process.take(transition, None, Duration::ZERO);
        sent.push((envelope.message.to_string(), envelope.request.0));
    }
}

/// The speaker from the documentation.
fn speaker() -> (Stage, ProgramProcess) {
    let stage = Stage::new(include_str!("../../components/programs/examples/speaker.py"));
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
fn a_successor_knows_nothing_of_what_its_predecessor_received() {
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
    let message = "the program, told `say` by Guide, has continued with another copy of this process";
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
fn the_speaker_of_the_page_answers_as_the_page_says() {
    const PAGE: &str = include_str!("../../docs/src/how-to/program-components.md");
    let block = |from: &str, kind: &str| {
        let block = PAGE.split_once(from).unwrap().1.split_once(&format!("```{kind}\n")).unwrap().1;
        block.split_once("```").unwrap().0
    };
    let program = block("`speaker.py`:", "py");
    assert_eq!(program, include_str!("../../components/programs/examples/speaker.py"));
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
