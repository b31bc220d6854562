//! A server that answers clients about a tree that runs in this process.

use std::collections::{BTreeMap, VecDeque};
use std::hash::{BuildHasher as _, RandomState};
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rmpv::Value;
use tree_logs::LoggedTransition;

use crate::client::MOST_TRANSITIONS;
use crate::protocol::{IDLE_AFTER, RequestHeader, RequestKind, TreeId, reply_header};
use crate::zmtp::{Connection, SocketType, ZmtpError};

/// The maximum number of clients at the same time. The connections of others are closed.
const MOST_CLIENTS: usize = 32;
/// The maximum size of a request, in bytes. The longest requests contain names of blackboards.
const MOST_BYTES: usize = 1 << 16;
/// How long the greeting, a request or the transmission of a reply may take.
const TIMEOUT: Duration = Duration::from_secs(2);
/// The interval at which threads check whether the server has been dropped.
const CHECK_PERIOD: Duration = Duration::from_millis(50);
/// After this many checks without a request, the connection of a client is closed. Libraries of ZeroMQ connect again
/// for the next request.
const MOST_IDLE_CHECKS: u32 = 1200;

/// Answers Groot2, and other clients with its protocol, about a tree that runs in this process. Hooks, which would
/// change the behavior of the tree, are refused.
///
/// Each client has its own thread, so the tree never waits for a client. As in a program with BehaviorTree.CPP, all
/// clients share one record of transitions, and there is no authentication. The server ends when it is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    shared: Arc<ServerState>,
}

#[derive(Debug, Default)]
struct ServerState {
    shown: Mutex<Shown>,
    clients: AtomicUsize,
    is_over: AtomicBool,
}

/// The data that clients can request.
#[derive(Debug, Default)]
struct Shown {
    tree: TreeId,
    xml: Arc<str>,
    /// By the numbers of the nodes, which begin with 1.
    statuses: Vec<u8>,
    /// The entries of blackboards, by the names of the blackboards.
    boards: BTreeMap<String, Arc<BTreeMap<String, Value>>>,
    /// The current time on the clock of the transitions, in microseconds.
    now_us: i64,
    /// The time since which transitions are stored; none if they are not stored.
    recorded_from_us: Option<i64>,
    transitions: VecDeque<LoggedTransition>,
}

impl Server {
    /// Listens for requests at this address, and for subscribers at the next port. Only hooks would be published there,
    /// so subscribers receive nothing. Clients wait until a tree is [shown](Self::show).
    ///
    /// # Errors
    /// If one of the ports is not available.
    pub fn open(address: SocketAddr) -> io::Result<Self> {
        let requests = TcpListener::bind(address)?;
        let address = requests.local_addr()?;
        let next = address.port().checked_add(1);
        let next = next.ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "the next port is needed, too"))?;
        let subscribers = TcpListener::bind(SocketAddr::new(address.ip(), next))?;
        let shared = Arc::new(ServerState::default());
        for (listener, socket) in [(requests, SocketType::Rep), (subscribers, SocketType::Pub)] {
            listener.set_nonblocking(true)?;
            let shared = Arc::clone(&shared);
            std::thread::Builder::new().spawn(move || shared.accept(&listener, socket))?;
        }
        Ok(Self { address, shared })
    }

    /// The address at which requests are answered.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Shows another tree, or the same tree from its start: the text that [`LoggedTree`](tree_logs::LoggedTree) reads,
    /// and the number of its nodes, which are numbered from 1. All nodes are idle, all blackboards are empty, and
    /// transitions are not stored.
    pub fn show(&self, xml: &str, nodes: u16, boards: impl IntoIterator<Item = String>) {
        let boards = boards.into_iter().map(|name| (name, Arc::default())).collect();
        let statuses = vec![0; usize::from(nodes)];
        *self.shared.shown() = Shown { tree: new_tree_id(), xml: Arc::from(xml), statuses, boards, ..Shown::default() };
    }

    /// Advances the clock of the transitions to this time, in microseconds, and adds the transitions until then.
    pub fn advance(&self, now_us: i64, transitions: impl IntoIterator<Item = LoggedTransition>) {
        let mut shown = self.shared.shown();
        shown.now_us = now_us;
        transitions.into_iter().for_each(|transition| shown.take(transition));
    }

    /// Sets an entry of a blackboard, or removes it if there is no value.
    pub fn write(&self, board: &str, key: &str, value: Option<Value>) {
        let mut shown = self.shared.shown();
        let Some(entries) = shown.boards.get_mut(board).map(Arc::make_mut) else { return };
        match value {
            Some(value) => drop(entries.insert(key.to_owned(), value)),
            None => drop(entries.remove(key)),
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
    }
}

impl ServerState {
    /// A poisoned mutex is accepted: no operation leaves the data partly changed.
    fn shown(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }

    fn accept(self: &Arc<Self>, listener: &TcpListener, socket: SocketType) {
        while !self.is_over() {
            if self.shown().xml.is_empty() {
                pause();
                continue;
            }
            match listener.accept() {
                Ok((stream, _)) if self.clients.fetch_add(1, Ordering::Relaxed) < MOST_CLIENTS => {
                    let shared = Arc::clone(self);
                    let serve = move || {
                        // An error ends only the connection of this client.
                        let _ = shared.serve(stream, socket);
                        shared.clients.fetch_sub(1, Ordering::Relaxed);
                    };
                    if std::thread::Builder::new().spawn(serve).is_err() {
                        self.clients.fetch_sub(1, Ordering::Relaxed);
                    }
                }
                Ok(_) => drop(self.clients.fetch_sub(1, Ordering::Relaxed)),
                Err(_) => pause(),
            }
        }
    }

    fn serve(&self, stream: TcpStream, socket: SocketType) -> Result<(), ZmtpError> {
        stream.set_nonblocking(false)?;
        let mut connection = Connection::begin(stream, socket, TIMEOUT, MOST_BYTES)?;
        let mut idle_checks = 0;
        while !self.is_over() && idle_checks < MOST_IDLE_CHECKS {
            if !connection.is_readable_within(CHECK_PERIOD)? {
                // The connections of subscribers have no time limit.
                idle_checks += u32::from(socket == SocketType::Rep);
                continue;
            }
            idle_checks = 0;
            let request = connection.receive()?;
            if socket == SocketType::Rep {
                let [empty, request @ ..] = request.as_slice() else { return Ok(()) };
                if !empty.is_empty() {
                    return Err(ZmtpError::Foreign("a request has no empty frame first".to_owned()));
                }
                let reply = self.answer(request).unwrap_or_else(|why| vec![b"error".to_vec(), why.into()]);
                let parts: Vec<&[u8]> = std::iter::once(&b""[..]).chain(reply.iter().map(Vec::as_slice)).collect();
                connection.send(&parts)?;
            }
        }
        Ok(())
    }

    /// The parts of the reply to a request, or the reason why it is refused.
    fn answer(&self, request: &[Vec<u8>]) -> Result<Vec<Vec<u8>>, &'static str> {
        let header = request.first().and_then(|header| RequestHeader::read(header));
        let header = header.ok_or("the request does not begin with a header of version 2 of the protocol")?;
        let kind = header.kind().ok_or("steward only shows the tree: there are no hooks")?;
        let about = request.get(1).map(Vec::as_slice);
        let mut shown = self.shown();
        let reply = vec![reply_header(header, shown.tree)];
        let body = match kind {
            RequestKind::FullTree => {
                let xml = Arc::clone(&shown.xml);
                drop(shown);
                xml.as_bytes().to_vec()
            }
            RequestKind::Status => shown.statuses(),
            RequestKind::Blackboard => {
                let names = about.and_then(|names| std::str::from_utf8(names).ok());
                let names = names.ok_or("the second part is to name blackboards, with `;` between them")?;
                let boards: Vec<_> =
                    names.split(';').filter_map(|name| Some((name, Arc::clone(shown.boards.get(name)?)))).collect();
                drop(shown);
                packed(&boards)
            }
            RequestKind::Recording => match about {
                Some(b"start") => shown.begin_recording().to_string().into_bytes(),
                Some(b"stop") => {
                    shown.recorded_from_us = None;
                    shown.transitions.clear();
                    return Ok(reply);
                }
                _ => return Err("the second part is to be `start` or `stop`"),
            },
            RequestKind::Transitions => shown.new_transitions(),
        };
        Ok(reply.into_iter().chain([body]).collect())
    }
}

impl Shown {
    fn take(&mut self, transition: LoggedTransition) {
        let place = usize::try_from(transition.uid).ok().and_then(|uid| uid.checked_sub(1));
        let status = place.and_then(|place| self.statuses.get_mut(place));
        let (Some(status), Ok(new)) = (status, u8::try_from(transition.status)) else { return };
        *status = if new == 0 { IDLE_AFTER + *status % IDLE_AFTER } else { new };
        if self.recorded_from_us.is_some() {
            if self.transitions.len() == MOST_TRANSITIONS {
                self.transitions.pop_front();
            }
            self.transitions.push_back(transition);
        }
    }

    /// Three bytes for each node: its number and its status.
    fn statuses(&self) -> Vec<u8> {
        let uids = (1_u16..).map(u16::to_le_bytes);
        uids.zip(&self.statuses).flat_map(|([low, high], status)| [low, high, *status]).collect()
    }

    /// Returns the time at which the record begins.
    fn begin_recording(&mut self) -> i64 {
        self.transitions.clear();
        *self.recorded_from_us.insert(self.now_us)
    }

    fn new_transitions(&mut self) -> Vec<u8> {
        let began_us = self.recorded_from_us.unwrap_or_default();
        self.transitions.drain(..).filter_map(|transition| transition.to_bytes(began_us)).flatten().collect()
    }
}

/// The entries of blackboards as MessagePack; nil if there are no blackboards.
fn packed(boards: &[(&str, Arc<BTreeMap<String, Value>>)]) -> Vec<u8> {
    let entries = |entries: &BTreeMap<String, Value>| {
        Value::Map(entries.iter().map(|(key, value)| (key.as_str().into(), value.clone())).collect())
    };
    let all = boards.iter().map(|(name, board)| ((*name).into(), entries(board))).collect();
    let mut bytes = Vec::new();
    let value = if boards.is_empty() { Value::Nil } else { Value::Map(all) };
    rmpv::encode::write_value(&mut bytes, &value).expect("writing to memory succeeds");
    bytes
}

/// A random identifier as in BehaviorTree.CPP: a UUID of version 4.
fn new_tree_id() -> TreeId {
    let mut id = [0; 16];
    // Each `RandomState` has different keys, which derive from random numbers of the operating system.
    for half in id.chunks_exact_mut(8) {
        half.copy_from_slice(&RandomState::new().hash_one(half.len()).to_le_bytes());
    }
    (id[6], id[8]) = (id[6] & 0x0f | 0x40, id[8] & 0x3f | 0x80);
    id
}

/// Waits until the next check.
#[expect(clippy::disallowed_methods, reason = "clients are awaited in real time")]
fn pause() {
    std::thread::sleep(CHECK_PERIOD);
}
