//! A program as a process of a channel system.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use channels::{
    Envelope, NoNormalForm, NormalForm, Offer, Process, ProcessId, Topology, TransitionId, Unobserved, Use,
};
use skills::{Adapter as _, ChannelAdapter, Datum, Mishap};

use crate::child::{AnswerError, Child, ONLY_ANSWERS};
use crate::program::Program;
use crate::protocol::{self, Answer, Message};

/// The shortest and the longest delay of a timer, in seconds. The minimum keeps a program from filling a step with
/// endless timers.
const AFTER_S: std::ops::RangeInclusive<f64> = 1e-3..=1e9;

/// The maximum number of waiting timers.
const MAX_TIMERS: usize = 4096;

/// The location of a program that has not reported a state.
const RUNNING: &str = "running";

/// The location of a program that has failed.
const CRASHED: &str = "crashed";

/// A program that communicates over channels. The crate's documentation describes how messages become lines and lines
/// become messages.
///
/// It offers no transitions before it is [started](Self::start). After a failure it counts as crashed: it receives
/// messages and never answers.
///
/// Its state consists of all messages and answers so far. The running program itself cannot be copied: a copy of this
/// process shares it, and only one of the two may continue. The other one fails at its next message.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ProgramProcess {
    program: Unobserved<Arc<Program>>,
    /// The initial data.
    data: Unobserved<Datum>,
    phase: Phase,
    /// A hash of all messages and answers so far.
    exchanged: ExchangeHash,
    adapter: ChannelAdapter,
    /// By due time, then in the order in which they were set.
    timers: Vec<Timer>,
    location: Unobserved<String>,
    mishaps: Unobserved<Vec<Mishap>>,
    running: Unobserved<Arc<Mutex<Option<Running>>>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Phase {
    New,
    Started,
    Crashed,
}

type ExchangeHash = [u8; blake3::OUT_LEN];

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Timer {
    due: Duration,
    event: String,
    data: Datum,
}

/// A running program, with the hash of all messages and answers so far.
#[derive(Debug)]
struct Running {
    child: Child,
    exchanged: ExchangeHash,
}

/// Why a program has failed, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Failure(String);

impl ProgramProcess {
    /// The process of a topology that runs this program. The program receives `data`, an object, at its start.
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId, program: Arc<Program>, data: Datum) -> Self {
        Self::unstarted(Unobserved(program), Unobserved(data), ChannelAdapter::new(topology, process))
    }

    fn unstarted(program: Unobserved<Arc<Program>>, data: Unobserved<Datum>, adapter: ChannelAdapter) -> Self {
        Self {
            program,
            data,
            adapter,
            phase: Phase::New,
            exchanged: ExchangeHash::default(),
            timers: Vec::new(),
            location: Unobserved(RUNNING.to_owned()),
            mishaps: Unobserved::default(),
            running: Unobserved::default(),
        }
    }

    /// Starts the program.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be started or does not answer correctly. The process then counts as crashed.
    pub fn start(&mut self, now: Duration) -> Result<(), Failure> {
        let data = self.data.clone();
        let started = Child::start(&self.program).map_err(|error| format!("the program {error}"));
        let started = started.and_then(|child| {
            self.phase = Phase::Started;
            let exchanged = self.exchanged;
            *self.shared() = Some(Running { child, exchanged });
            self.send(&Message { time: now, event: "start", from: None, data: &data })
        });
        started.map_err(|message| Failure(self.crash(message)))
    }

    /// Ends the program at the end of its run. It counts as a failure if the program, or one of its keepers, had
    /// already ended, or if it has written unsolicited output.
    pub fn conclude(&mut self) {
        if self.phase != Phase::Started {
            return;
        }
        let own = |running: &&mut Running| running.exchanged == self.exchanged;
        let concluded = self.shared().as_mut().filter(own).map(|running| running.child.conclude());
        if let Some(Err(error)) = concluded {
            self.crash(format!("the program {error}"));
        }
    }

    /// A new process with the same program and data. It replaces `predecessor`, a process of the same component, which
    /// ends, and starts at `now`. It continues the predecessor's request numbers, so that answers to the predecessor's
    /// requests are ignored.
    #[must_use]
    pub fn succeeding(&self, predecessor: &Self, now: Duration) -> Self {
        let ended = predecessor.shared().take().map(|mut running| running.child.conclude());
        let mut successor = Self::unstarted(self.program.clone(), self.data.clone(), predecessor.adapter.succeeding());
        successor.mishaps = predecessor.mishaps.clone();
        // Other errors are not reported: the component may be restarted because the predecessor had ended.
        if let Some(Err(error @ AnswerError::Unsolicited(_))) = ended {
            let message = format!("the program {error}");
            successor.mishaps.push(Mishap { state: Some(predecessor.location.0.clone()), message, times: 1 });
        }
        // A failure is recorded in its mishaps.
        let _ = successor.start(now);
        successor
    }

    /// The program that it runs.
    #[must_use]
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Its failure and those of its predecessors. They are not part of the process's state.
    #[must_use]
    pub fn mishaps(&self) -> &[Mishap] {
        &self.mishaps
    }

    fn shared(&self) -> std::sync::MutexGuard<'_, Option<Running>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends the program a message and carries out its answer, unless it has crashed.
    fn deliver(&mut self, message: &Message<'_>) {
        if self.phase == Phase::Started
            && let Err(failure) = self.send(message)
        {
            self.crash(failure);
        }
    }

    fn send(&mut self, message: &Message<'_>) -> Result<(), String> {
        let by = message.from.map_or_else(String::new, |from| format!(" by {from}"));
        self.exchange(message).map_err(|failure| format!("the program, sent `{}`{by}, {failure}", message.event))
    }

    fn exchange(&mut self, message: &Message<'_>) -> Result<(), String> {
        let line = message.to_json();
        let mut hash = blake3::Hasher::new();
        hash.update(&self.exchanged).update(line.as_bytes());
        let mut shared = self.shared();
        let Some(running) = shared.as_mut().filter(|running| running.exchanged == self.exchanged) else {
            return Err("has continued with another copy of this process".to_owned());
        };
        let answer = running.child.request(line).map_err(|error| error.to_string())?;
        let exchanged = hash.update(b"\n").update(answer.as_bytes()).finalize().into();
        running.exchanged = exchanged;
        drop(shared);
        self.exchanged = exchanged;
        let wrong = |problem: String| format!("answered wrongly: {}: {}", excerpt(&problem), excerpt(&answer));
        let parsed = Answer::parse(&answer).map_err(|problem| match answer.trim_start().starts_with('{') {
            true => wrong(problem),
            false => format!("{}; {ONLY_ANSWERS}", wrong(problem)),
        })?;
        self.follow(parsed, message.time).map_err(wrong)
    }

    /// Carries out the program's answer. An error names its place in the answer.
    fn follow(&mut self, answer: Answer, now: Duration) -> Result<(), String> {
        for (index, sent) in answer.send.into_iter().enumerate() {
            let data = protocol::datum(sent.data).map_err(|large| format!("at `send[{index}].data`: {large}"))?;
            let delivered = self.adapter.send(sent.to.as_deref(), &sent.event, &data);
            delivered.map_err(|undelivered| format!("at `send[{index}]`: {undelivered}"))?;
        }
        for (index, timer) in answer.timers.into_iter().enumerate() {
            if !AFTER_S.contains(&timer.after) {
                let (least, most) = (AFTER_S.start(), AFTER_S.end());
                return Err(format!("at `timers[{index}].after`: {} is not between {least} and {most} s", timer.after));
            }
            if self.timers.len() >= MAX_TIMERS {
                return Err(format!("at `timers[{index}]`: {MAX_TIMERS} timers are already waiting"));
            }
            let due = now.saturating_add(Duration::from_secs_f64(timer.after));
            let data = protocol::datum(timer.data).map_err(|large| format!("at `timers[{index}].data`: {large}"))?;
            let place = self.timers.partition_point(|other| other.due <= due);
            self.timers.insert(place, Timer { due, event: timer.event, data });
        }
        if let Some(state) = answer.state {
            *self.location = state;
        }
        Ok(())
    }

    /// Ends the program and records the reason. Returns the reason, with what the program wrote to stderr.
    fn crash(&mut self, mut message: String) -> String {
        let own = |running: &mut Running| running.exchanged == self.exchanged;
        let running = self.shared().take_if(own);
        if let Some(stderr) = running.and_then(|running| running.child.end()) {
            message = format!("{message}; on stderr: {stderr}");
        }
        let state = Some(std::mem::replace(&mut *self.location, CRASHED.to_owned()));
        self.mishaps.push(Mishap { state, message: message.clone(), times: 1 });
        self.adapter = self.adapter.succeeding();
        self.timers.clear();
        self.phase = Phase::Crashed;
        message
    }
}

/// The beginning of a text.
fn excerpt(line: &str) -> String {
    match line.char_indices().nth(200) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.to_owned(),
    }
}

impl Process for ProgramProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        if self.phase != Phase::New {
            self.adapter.offers(offers);
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        // A crashed program never answers, so its requests need not be remembered.
        if self.phase == Phase::Crashed {
            return;
        }
        if let Some(event) = self.adapter.take(transition, received.as_ref()) {
            let from = event.origin.as_deref();
            // For machines, the name of an answer begins with its sender: `Navigation.ok`.
            let head = from.and_then(|from| event.name.strip_prefix(from)?.strip_prefix('.')).unwrap_or(&event.name);
            self.deliver(&Message { time: now, event: head, from, data: &event.data });
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.timers.first().map(|timer| timer.due)
    }

    fn fire_timers(&mut self, now: Duration) {
        while self.next_timer().is_some_and(|due| due <= now) {
            let Timer { due, event, data } = self.timers.remove(0);
            self.deliver(&Message { time: due, event: &event, from: None, data: &data });
        }
    }

    fn uses(&self) -> Vec<Use> {
        self.adapter.receives().chain(self.adapter.sends()).collect()
    }

    fn normalize(&mut self, _: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        Err(NoNormalForm::Unsupported {
            reason: "it is a program, whose states are unknown".to_owned(),
            help: Some("replace it with a machine for the proof: an SCXML file with the same interface".to_owned()),
        })
    }

    /// The state that the program reported last.
    fn location(&self) -> String {
        self.location.0.clone()
    }
}
