//! The process that listens in a DDS domain, seen from the one that judges. When it ends, another takes its place.

use std::collections::{BTreeMap, VecDeque};
use std::io::{BufReader, BufWriter, Read as _, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::heard::{Ask, Heard, LEAVING, NodeNames, Publication, Reply, Request, Subscribed};
use super::options::Options;
use crate::clock::{Clock, now, sleep};

/// The first argument of a process that listens.
pub(super) const LISTEN: &str = "listen-to-dds";

/// How long a process may say nothing: it is never silent for long, except when it begins.
const DEAD: Duration = Duration::from_secs(11);

/// How long to wait before another takes the place of one that has ended, if that has not been there for long.
const AGAIN: Duration = Duration::from_secs(1);
const LONG: Duration = Duration::from_secs(10);

/// The most bytes of messages that wait for whoever judges them: what comes then is missing.
const MOST_WAITING: usize = 1 << 27;

/// The most that waits, of any kind: then the process that listens has to wait, too.
const MOST_HEARD: usize = 1 << 16;

/// The most that waits to be told to the process that listens: what is asked of one that has stopped reading is lost.
const MOST_ASKED: usize = 1 << 12;

/// The executable whose processes can listen.
static LISTENER: OnceLock<PathBuf> = OnceLock::new();

/// Uses this executable; its `main` must call [`listen`](super::listen). Only the first call has an effect.
pub(super) fn listen_with(program: PathBuf) {
    let _ = LISTENER.set(program);
}

/// A participant in a domain. It leaves when this is dropped.
pub(super) struct Participant {
    /// What is heard, and its size in bytes.
    heard: Receiver<(Heard, usize)>,
    shared: Arc<Shared>,
    clock: Clock,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    is_to_end: AtomicBool,
    /// The bytes that wait.
    waiting: AtomicUsize,
    process: Mutex<Process>,
}

/// What the process that listens is told, and the way to tell it.
#[derive(Default)]
struct Process {
    subscribed: Option<Subscribed>,
    /// What was published last on each topic, which services are asked, and which are offered, with their types.
    published: BTreeMap<String, Publication>,
    services: BTreeMap<String, Request>,
    offered: BTreeMap<String, String>,
    /// What could not be asked, or answered, yet.
    unasked: VecDeque<Ask>,
    input: Option<SyncSender<Ask>>,
    child: Option<Child>,
    /// When it last said anything.
    heard: Option<Instant>,
}

impl Participant {
    /// Joins a domain, as nodes with these names, or none.
    pub(super) fn join(options: Options, node: Option<NodeNames>, subscribed: Subscribed) -> Self {
        let (sender, heard) = sync_channel(MOST_HEARD);
        let shared = Arc::new(Shared::default());
        shared.process().subscribed = Some(subscribed);
        let clock = Clock::start();
        let thread = std::thread::spawn({
            let shared = Arc::clone(&shared);
            move || run(&Join { options, clock, node }, &shared, &sender)
        });
        Self { heard, shared, clock, thread: Some(thread) }
    }

    /// Now, by the clock that gives messages their times.
    pub(super) fn now_ns(&self) -> i64 {
        self.clock.now_ns()
    }

    /// What comes next, if anything does within this time.
    pub(super) fn next(&self, patience: Duration) -> Option<Heard> {
        match self.heard.recv_timeout(patience) {
            Ok((heard, size)) => {
                self.shared.waiting.fetch_sub(size, Ordering::Relaxed);
                Some(heard)
            }
            Err(_) => {
                let mut process = self.shared.process();
                if process.heard.is_some_and(|heard| heard.elapsed() > DEAD) {
                    process.kill();
                }
                None
            }
        }
    }

    pub(super) fn subscribe(&self, subscribed: Subscribed) {
        let mut process = self.shared.process();
        process.subscribed = Some(subscribed.clone());
        process.ask(Ask::Subscribe(subscribed));
    }

    /// What publishes there, for as long as it takes part.
    pub(super) fn voice(&self) -> Voice {
        Voice(Arc::clone(&self.shared))
    }
}

/// Publishes in the domain of a participant.
pub struct Voice(Arc<Shared>);

impl Voice {
    /// Publishes a message, reliably.
    pub fn publish(&self, message: Publication) {
        let mut process = self.0.process();
        process.published.insert(message.topic.clone(), message.clone());
        process.ask(Ask::Publish(message));
    }

    /// Asks a service, as soon as a server is there, which gives a [response](super::Domain::response).
    pub fn request(&self, request: Request) {
        let mut process = self.0.process();
        let offer = || Request { body: Vec::new(), ..request.clone() };
        process.services.entry(request.service.clone()).or_insert_with(offer);
        process.ask_or_keep(Ask::Request(request));
    }

    /// Offers a service with this type.
    pub(super) fn serve(&self, service: String, kind: String) {
        let mut process = self.0.process();
        process.offered.insert(service.clone(), kind.clone());
        process.ask(Ask::Serve(service, kind));
    }

    /// Responds to a [request](super::Domain::request) to a service that is offered here.
    pub fn respond(&self, reply: Reply) {
        self.0.process().ask_or_keep(Ask::Respond(reply));
    }
}

impl Drop for Participant {
    fn drop(&mut self) {
        self.shared.is_to_end.store(true, Ordering::Relaxed);
        // The end of its input is the end of its work.
        self.shared.process().input = None;
        let Some(thread) = self.thread.take() else { return };
        let asked = now();
        while !thread.is_finished() {
            // What it still says must not keep the thread from its end.
            let _ = self.heard.recv_timeout(Duration::from_millis(1));
            if asked.elapsed() > LEAVING {
                self.shared.process().kill();
            }
        }
        let _ = thread.join();
    }
}

impl Process {
    /// Asks without waiting, and what was kept before. One that has ended is told of by whoever reads what it says.
    /// Returns whether it is asked.
    fn ask(&mut self, ask: Ask) -> bool {
        let Some(input) = &self.input else { return false };
        while let Some(kept) = self.unasked.pop_front() {
            if let Err(TrySendError::Full(kept) | TrySendError::Disconnected(kept)) = input.try_send(kept) {
                self.unasked.push_front(kept);
                return false;
            }
        }
        input.try_send(ask).is_ok()
    }

    /// Asks what must not be lost: if it cannot be asked now, it is later.
    fn ask_or_keep(&mut self, ask: Ask) {
        if !self.ask(ask.clone()) && self.unasked.len() < MOST_ASKED {
            self.unasked.push_back(ask);
        }
    }

    /// Kills it. What it said last is still heard.
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

/// Keeps a process listening until it is to end.
fn run(join: &Join, shared: &Shared, sender: &SyncSender<(Heard, usize)>) {
    while !shared.is_to_end() {
        let begun = now();
        let why = match start(join, shared) {
            Ok(output) => {
                hand_on(output, shared, sender);
                bury(shared)
            }
            Err(error) => format!("it cannot be started: {error}"),
        };
        if shared.is_to_end() || sender.send((Heard::Died(why), 0)).is_err() {
            return;
        }
        let (ended, pause) = (now(), if begun.elapsed() < LONG { AGAIN } else { Duration::ZERO });
        while ended.elapsed() < pause && !shared.is_to_end() {
            sleep(Duration::from_millis(10));
        }
    }
}

/// Starts a process. Returns where it says what it hears.
fn start(Join { options, clock, node }: &Join, shared: &Shared) -> std::io::Result<Option<ChildStdout>> {
    let none = || std::io::Error::other("the `main` of this process does not call `network::listen`");
    let mut command = Command::new(LISTENER.get().ok_or_else(none)?);
    command.arg(LISTEN).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // Ctrl-C on a terminal reaches a whole process group: this process decides what to do then.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn()?;
    let mut process = shared.process();
    let join = Ask::Join { options: *options, ahead_ns: clock.is_ahead_ns(), node: node.clone() };
    let unasked = std::mem::take(&mut process.unasked);
    let subscribe = process.subscribed.clone().map(Ask::Subscribe);
    let publish = process.published.values().cloned().map(Ask::Publish);
    let request = process.services.values().cloned().map(Ask::Request);
    let serve = process.offered.clone().into_iter().map(|(service, kind)| Ask::Serve(service, kind));
    let offers = publish.chain(request).chain(serve);
    let asks: Vec<Ask> = std::iter::once(join).chain(subscribe).chain(offers).chain(unasked).collect();
    let (sender, asked) = sync_channel::<Ask>(MOST_ASKED);
    let input = child.stdin.take().ok_or_else(none)?;
    // The end of its input is the end of its work.
    std::thread::spawn(move || tell(&asked, BufWriter::new(input)));
    process.input = Some(sender);
    for ask in asks {
        process.ask(ask);
    }
    if shared.is_to_end() {
        process.input = None;
    }
    let output = child.stdout.take();
    (process.child, process.heard) = (Some(child), Some(now()));
    Ok(output)
}

/// Tells a process what it is asked, and all that waits at once.
fn tell(asked: &Receiver<Ask>, mut input: impl Write) -> std::io::Result<()> {
    for first in asked {
        first.write(&mut input)?;
        asked.try_iter().try_for_each(|ask| ask.write(&mut input))?;
        input.flush()?;
    }
    Ok(())
}

/// Hands on what a process says until it says no more.
fn hand_on(output: Option<ChildStdout>, shared: &Shared, sender: &SyncSender<(Heard, usize)>) {
    let Some(output) = output else { return };
    let mut output = BufReader::with_capacity(1 << 16, output);
    while let Ok((mut heard, mut size)) = Heard::read(&mut output) {
        shared.process().heard = Some(now());
        // Of what is no message, there may be too much, too.
        while shared.waiting.load(Ordering::Relaxed) > 2 * MOST_WAITING && !shared.is_to_end() {
            sleep(Duration::from_millis(1));
        }
        if let Heard::Sample(sample) = &mut heard
            && shared.waiting.load(Ordering::Relaxed) > MOST_WAITING
        {
            size -= std::mem::take(&mut sample.body).len();
            heard = Heard::Dropped(sample.clone());
        }
        shared.waiting.fetch_add(size, Ordering::Relaxed);
        if sender.send((heard, size)).is_err() {
            return;
        }
    }
}

/// Waits for the end of the process, which says no more. Returns why it has ended, in words.
fn bury(shared: &Shared) -> String {
    let mut process = shared.process();
    process.input = None;
    let Some(mut child) = process.child.take() else { return "it has ended".to_owned() };
    drop(process);
    let asked = now();
    while asked.elapsed() < LEAVING && matches!(child.try_wait(), Ok(None)) {
        sleep(Duration::from_millis(1));
    }
    let _ = child.kill();
    let status = child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
    let mut words = Vec::new();
    // What it wrote is still there.
    let _ = child.stderr.take().map(|errors| errors.take(1 << 12).read_to_end(&mut words));
    let words = String::from_utf8_lossy(&words);
    // The first line says why; others say where.
    words.trim().lines().next().map_or(status, str::to_owned)
}
