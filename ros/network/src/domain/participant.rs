//! The listener, as the process that judges sees it: a child process. When it ends, another takes its place.

use std::collections::{BTreeMap, VecDeque};
use std::io::{BufReader, BufWriter, Read as _, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::exchange::{LEAVING, ListenerCommand, ListenerMessage, NodeNames, Publication, Reply, Request, Subscribed};
use super::options::Options;
use crate::clock::{Clock, now, sleep};

/// The first argument of a listener.
pub(super) const LISTEN: &str = "listen-to-dds";

/// How long a listener may send nothing. It sends often, except at the beginning.
const DEAD: Duration = Duration::from_secs(11);

/// How long to wait before a listener that has ended is replaced, unless it has run for long.
const RESTART: Duration = Duration::from_secs(1);
const LONG: Duration = Duration::from_secs(10);

/// The most bytes of messages that wait to be judged. Samples beyond that are dropped.
const MOST_WAITING: usize = 1 << 27;

/// The most messages that wait to be judged. Beyond that, the listener has to wait.
const MOST_MESSAGES: usize = 1 << 16;

/// The most commands that wait for the listener. If it has stopped reading, further ones are lost.
const MOST_COMMANDS: usize = 1 << 12;

/// The executable of listeners.
static LISTENER: OnceLock<PathBuf> = OnceLock::new();

/// Uses this executable for listeners. Its `main` must call [`listen`](super::listen). Only the first call has an
/// effect.
pub(super) fn listen_with(program: PathBuf) {
    let _ = LISTENER.set(program);
}

/// A participant in a domain. It leaves the domain when this is dropped.
pub(super) struct Participant {
    /// The messages of the listener, each with its size in bytes.
    messages: Receiver<(ListenerMessage, usize)>,
    shared: Arc<Shared>,
    clock: Clock,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    is_to_end: AtomicBool,
    /// The bytes of the messages that wait.
    waiting: AtomicUsize,
    process: Mutex<Process>,
}

/// The present listener, and what the next one has to be sent.
#[derive(Default)]
struct Process {
    subscribed: Option<Subscribed>,
    /// The last message on each topic.
    published: BTreeMap<String, Publication>,
    /// The services that are called.
    services: BTreeMap<String, Request>,
    /// The services that are offered, with their types.
    offered: BTreeMap<String, String>,
    /// The requests and responses that could not be sent yet.
    unsent: VecDeque<ListenerCommand>,
    input: Option<SyncSender<ListenerCommand>>,
    child: Option<Child>,
    /// When the listener last sent a message.
    last_message: Option<Instant>,
}

impl Participant {
    /// Joins a domain, as these nodes or without any.
    pub(super) fn join(options: Options, node: Option<NodeNames>, subscribed: Subscribed) -> Self {
        let (sender, messages) = sync_channel(MOST_MESSAGES);
        let shared = Arc::new(Shared::default());
        shared.process().subscribed = Some(subscribed);
        let clock = Clock::start();
        let thread = std::thread::spawn({
            let shared = Arc::clone(&shared);
            move || run(&Join { options, clock, node }, &shared, &sender)
        });
        Self { messages, shared, clock, thread: Some(thread) }
    }

    /// The time of the clock that stamps received messages.
    pub(super) fn now_ns(&self) -> i64 {
        self.clock.now_ns()
    }

    /// The next message of the listener, if there is one within this time.
    pub(super) fn next(&self, patience: Duration) -> Option<ListenerMessage> {
        match self.messages.recv_timeout(patience) {
            Ok((message, size)) => {
                self.shared.waiting.fetch_sub(size, Ordering::Relaxed);
                Some(message)
            }
            Err(_) => {
                let mut process = self.shared.process();
                if process.last_message.is_some_and(|last| last.elapsed() > DEAD) {
                    process.kill();
                }
                None
            }
        }
    }

    pub(super) fn subscribe(&self, subscribed: Subscribed) {
        let mut process = self.shared.process();
        process.subscribed = Some(subscribed.clone());
        process.send(ListenerCommand::Subscribe(subscribed));
    }

    /// Publishes in the domain until this participant leaves.
    pub(super) fn publisher(&self) -> Publisher {
        Publisher(Arc::clone(&self.shared))
    }
}

/// Publishes messages, and sends requests and responses, in the domain of a participant.
pub struct Publisher(Arc<Shared>);

impl Publisher {
    /// Publishes a message, reliably.
    pub fn publish(&self, message: Publication) {
        let mut process = self.0.process();
        process.published.insert(message.topic.clone(), message.clone());
        process.send(ListenerCommand::Publish(message));
    }

    /// Sends a request as soon as the service has a server. It gets a [response](super::Domain::response).
    pub fn request(&self, request: Request) {
        let mut process = self.0.process();
        let offer = || Request { body: Vec::new(), ..request.clone() };
        process.services.entry(request.service.clone()).or_insert_with(offer);
        process.send_or_keep(ListenerCommand::Request(request));
    }

    /// Offers a service with this type.
    pub(super) fn serve(&self, service: String, kind: String) {
        let mut process = self.0.process();
        process.offered.insert(service.clone(), kind.clone());
        process.send(ListenerCommand::Serve(service, kind));
    }

    /// Sends the response to a [request](super::Domain::request) to a service that is offered here.
    pub fn respond(&self, reply: Reply) {
        self.0.process().send_or_keep(ListenerCommand::Respond(reply));
    }
}

impl Drop for Participant {
    fn drop(&mut self) {
        self.shared.is_to_end.store(true, Ordering::Relaxed);
        // The listener ends when its input ends.
        self.shared.process().input = None;
        let Some(thread) = self.thread.take() else { return };
        let begun = now();
        while !thread.is_finished() {
            // The thread must not block on messages that nothing receives.
            let _ = self.messages.recv_timeout(Duration::from_millis(1));
            if begun.elapsed() > LEAVING {
                self.shared.process().kill();
            }
        }
        let _ = thread.join();
    }
}

impl Process {
    /// Sends a command without waiting, after those that were kept. Returns whether it was sent. If the listener has
    /// ended, the thread that reads its output notices that.
    fn send(&mut self, command: ListenerCommand) -> bool {
        let Some(input) = &self.input else { return false };
        while let Some(kept) = self.unsent.pop_front() {
            if let Err(TrySendError::Full(kept) | TrySendError::Disconnected(kept)) = input.try_send(kept) {
                self.unsent.push_front(kept);
                return false;
            }
        }
        input.try_send(command).is_ok()
    }

    /// Sends a command that must not be lost. If it cannot be sent now, it is sent later.
    fn send_or_keep(&mut self, command: ListenerCommand) {
        if !self.send(command.clone()) && self.unsent.len() < MOST_COMMANDS {
            self.unsent.push_back(command);
        }
    }

    /// Kills the listener. Its last messages are still received.
    fn kill(&mut self) {
        self.child.as_mut().map(Child::kill);
    }
}

impl Shared {
    fn process(&self) -> MutexGuard<'_, Process> {
        self.process.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_to_end(&self) -> bool {
        self.is_to_end.load(Ordering::Relaxed)
    }
}

/// How to join a domain.
struct Join {
    options: Options,
    clock: Clock,
    node: Option<NodeNames>,
}

/// Starts listeners, one after the other, until the participant leaves.
fn run(join: &Join, shared: &Shared, sender: &SyncSender<(ListenerMessage, usize)>) {
    while !shared.is_to_end() {
        let begun = now();
        let why = match start(join, shared) {
            Ok(output) => {
                forward(output, shared, sender);
                reap(shared)
            }
            Err(error) => format!("it cannot be started: {error}"),
        };
        if shared.is_to_end() || sender.send((ListenerMessage::Failed(why), 0)).is_err() {
            return;
        }
        let (ended, pause) = (now(), if begun.elapsed() < LONG { RESTART } else { Duration::ZERO });
        while ended.elapsed() < pause && !shared.is_to_end() {
            sleep(Duration::from_millis(10));
        }
    }
}

/// Starts a listener. Returns its output.
fn start(Join { options, clock, node }: &Join, shared: &Shared) -> std::io::Result<Option<ChildStdout>> {
    let none = || std::io::Error::other("the `main` of this process does not call `network::listen`");
    let mut command = Command::new(LISTENER.get().ok_or_else(none)?);
    command.arg(LISTEN).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // Ctrl-C on a terminal is sent to a whole process group. Only this process is to handle it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn()?;
    let mut process = shared.process();
    let join = ListenerCommand::Join { options: *options, ahead_ns: clock.is_ahead_ns(), node: node.clone() };
    let unsent = std::mem::take(&mut process.unsent);
    let subscribe = process.subscribed.clone().map(ListenerCommand::Subscribe);
    let publish = process.published.values().cloned().map(ListenerCommand::Publish);
    let request = process.services.values().cloned().map(ListenerCommand::Request);
    let serve = process.offered.clone().into_iter().map(|(service, kind)| ListenerCommand::Serve(service, kind));
    let offers = publish.chain(request).chain(serve);
    let all: Vec<ListenerCommand> = std::iter::once(join).chain(subscribe).chain(offers).chain(unsent).collect();
    let (sender, commands) = sync_channel::<ListenerCommand>(MOST_COMMANDS);
    let input = child.stdin.take().ok_or_else(none)?;
    // The listener ends when its input ends.
    std::thread::spawn(move || write_commands(&commands, BufWriter::new(input)));
    process.input = Some(sender);
    for command in all {
        process.send(command);
    }
    if shared.is_to_end() {
        process.input = None;
    }
    let output = child.stdout.take();
    (process.child, process.last_message) = (Some(child), Some(now()));
    Ok(output)
}

/// Writes commands to the input of a listener, all that wait at once.
fn write_commands(commands: &Receiver<ListenerCommand>, mut input: impl Write) -> std::io::Result<()> {
    for first in commands {
        first.write(&mut input)?;
        commands.try_iter().try_for_each(|command| command.write(&mut input))?;
        input.flush()?;
    }
    Ok(())
}

/// Forwards the messages of a listener until its output ends.
fn forward(output: Option<ChildStdout>, shared: &Shared, sender: &SyncSender<(ListenerMessage, usize)>) {
    let Some(output) = output else { return };
    let mut output = BufReader::with_capacity(1 << 16, output);
    while let Ok((mut message, mut size)) = ListenerMessage::read(&mut output) {
        shared.process().last_message = Some(now());
        // Only samples can be dropped, so that others may have to wait.
        while shared.waiting.load(Ordering::Relaxed) > 2 * MOST_WAITING && !shared.is_to_end() {
            sleep(Duration::from_millis(1));
        }
        if let ListenerMessage::Sample(sample) = &mut message
            && shared.waiting.load(Ordering::Relaxed) > MOST_WAITING
        {
            size -= std::mem::take(&mut sample.body).len();
            message = ListenerMessage::Dropped(sample.clone());
        }
        shared.waiting.fetch_add(size, Ordering::Relaxed);
        if sender.send((message, size)).is_err() {
            return;
        }
    }
}

/// Waits until a listener whose output has ended has ended itself. Returns why, in words.
fn reap(shared: &Shared) -> String {
    let mut process = shared.process();
    process.input = None;
    let Some(mut child) = process.child.take() else { return "it has ended".to_owned() };
    drop(process);
    let begun = now();
    while begun.elapsed() < LEAVING && matches!(child.try_wait(), Ok(None)) {
        sleep(Duration::from_millis(1));
    }
    let _ = child.kill();
    let status = child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
    let mut words = Vec::new();
    // Its errors can still be read.
    let _ = child.stderr.take().map(|errors| errors.take(1 << 12).read_to_end(&mut words));
    let words = String::from_utf8_lossy(&words);
    // The first line is the reason. Others describe where it happened.
    words.trim().lines().next().map_or(status, str::to_owned)
}
