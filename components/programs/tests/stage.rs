//! A program on its own: a speaker with two clients.

use std::env;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, Domain, Envelope, FieldKind, Message, Process, RequestNumber, Role, Shape, Topology,
    TransitionId, Value,
};
use programs::{Limits, Program, ProgramProcess, Word};
use skills::Datum;
use tempfile::TempDir;

use crate::machine;

/// The executable whose processes are keepers: the example, since the `main` of these tests does not call
/// `programs::keep`.
pub(crate) fn keeper() -> PathBuf {
    let tests = env::current_exe().unwrap();
    let keeper = tests.ancestors().nth(2).unwrap().join("examples/run_speaker");
    assert!(keeper.exists(), "`cargo test -p programs` builds the example, but not with `--test`");
    keeper
}

/// A folder with a program in it.
pub(crate) struct Stage {
    pub(crate) folder: TempDir,
}

impl Stage {
    pub(crate) fn new(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("program.py"), text).unwrap();
        Self { folder }
    }

    /// The program, run by Python.
    pub(crate) fn process(&self, limits: Limits) -> ProgramProcess {
        let file = self.folder.path().join("program.py");
        self.command(&["python3", file.to_str().unwrap()], limits)
    }

    pub(crate) fn command(&self, command: &[&str], limits: Limits) -> ProgramProcess {
        programs::keep_with(keeper());
        let words = command.iter().map(|word| Word::Text((*word).to_owned())).collect();
        let program = Program::new(words, Some(self.folder.path()), limits).unwrap();
        let topology = topology();
        let speaker = topology.find_process("Speaker").unwrap();
        let data = Datum::object([("seconds_per_letter", 0.5.into())]).unwrap();
        ProgramProcess::new(&topology, speaker, Arc::new(program), data)
    }

    /// The command lines of the processes that are running in the folder.
    pub(crate) fn left_over(&self) -> Vec<String> {
        machine::left_over(self.folder.path())
    }
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

/// Sends `say` with a text and this request number from a client, 0 or 1.
pub(crate) fn say(process: &mut ProgramProcess, client: u32, request: u64, text: &str, at_s: f64) {
    let message = Message::new([Value::symbol("say"), text.into()]);
    let envelope = Envelope { message, request: RequestNumber(request) };
    process.take(TransitionId(client), Some(envelope), Duration::from_secs_f64(at_s));
}

/// Takes all messages that the process offers to send, with their request numbers.
pub(crate) fn sent(process: &mut ProgramProcess) -> Vec<(String, u64)> {
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
