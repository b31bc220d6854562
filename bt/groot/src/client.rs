//! A client that requests data about the tree of a program.

use std::time::Duration;

use tree_logs::{LoggedTransition, LoggedTree};

use crate::boards::Blackboards;
use crate::error::GrootError;
use crate::protocol::{RequestHeader, RequestKind, TreeId, tree_of_reply};
use crate::zmtp::{Connection, SocketType, ZmtpError};

/// The most transitions that a program stores. If a reply contains as many, earlier ones may be missing.
pub const MOST_TRANSITIONS: usize = 1000;

/// The most bytes of a reply. The largest reply is a tree; a node takes about 200 bytes.
const MOST_BYTES: usize = 64 << 20;

/// The numbers of nodes, each with the number of its status: 0 idle, 1 running, 2 success, 3 failure, 4 skipped; 10
/// more if the node is idle now and had that status before.
pub type Statuses = Vec<(u16, u8)>;

/// A connection to a program.
#[derive(Debug)]
pub struct Client {
    address: String,
    connection: Connection,
    /// The number of requests so far.
    requests: u32,
    /// The tree that the program shows; none before its first reply.
    tree: Option<TreeId>,
}

impl Client {
    /// Connects to a program. `address` is a host and a port; `timeout` limits the connection and each reply.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn connect(address: &str, timeout: Duration) -> Result<Self, GrootError> {
        let connection = Connection::connect(address, SocketType::Req, timeout, MOST_BYTES);
        let address = address.to_owned();
        match connection {
            Ok(connection) => Ok(Self { address, connection, requests: 0, tree: None }),
            Err(source) => Err(GrootError::Connection { address, source }),
        }
    }

    /// The tree.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn tree(&mut self) -> Result<LoggedTree, GrootError> {
        let xml = self.request(RequestKind::FullTree, None)?;
        let xml = String::from_utf8(xml).map_err(|_| self.foreign("its tree is not UTF-8 text"))?;
        LoggedTree::read(&xml).map_err(|problem| self.foreign(problem))
    }

    /// The status of all nodes.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn statuses(&mut self) -> Result<Statuses, GrootError> {
        let bytes = self.request(RequestKind::Status, None)?;
        let (nodes, []) = bytes.as_chunks::<3>() else { return Err(self.foreign("a status has not three bytes")) };
        Ok(nodes.iter().map(|[low, high, status]| (u16::from_le_bytes([*low, *high]), *status)).collect())
    }

    /// The entries of these blackboards. A blackboard that the program does not have is left out.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn blackboards(&mut self, names: &[String]) -> Result<Blackboards, GrootError> {
        let bytes =
            self.request(RequestKind::Blackboard, Some(names.join(";").as_bytes())).map_err(|error| match error {
                GrootError::Connection { address, source: ZmtpError::TooLarge(bytes) } => {
                    GrootError::LargeBlackboards { address, bytes }
                }
                error => error,
            })?;
        Blackboards::read(&bytes)
            .ok_or_else(|| self.foreign("its blackboards are not MessagePack, or are nested too deep"))
    }

    /// Makes the program store transitions from now on. Returns the current time of its clock, in microseconds since
    /// 1970. Transitions that it has stored for other clients are lost.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn start_recording(&mut self) -> Result<i64, GrootError> {
        let bytes = self.request(RequestKind::Recording, Some(b"start"))?;
        let text = String::from_utf8_lossy(&bytes);
        text.parse().map_err(|_| self.foreign(format!("the recording began at `{}`", text.escape_debug())))
    }

    /// Makes the program stop storing transitions.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn stop_recording(&mut self) -> Result<(), GrootError> {
        self.request(RequestKind::Recording, Some(b"stop")).map(drop)
    }

    /// The transitions since the last such request of any client, at most the last [`MOST_TRANSITIONS`]. The recording
    /// began at `began_us`.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn transitions(&mut self, began_us: i64) -> Result<Vec<LoggedTransition>, GrootError> {
        let bytes = self.request(RequestKind::Transitions, None)?;
        let (all, []) = bytes.as_chunks::<{ LoggedTransition::BYTES }>() else {
            return Err(self.foreign("a transition has not nine bytes"));
        };
        Ok(all.iter().map(|bytes| LoggedTransition::from_bytes(*bytes, began_us)).collect())
    }

    /// Sends a request. Returns the body of the reply.
    fn request(&mut self, kind: RequestKind, about: Option<&[u8]>) -> Result<Vec<u8>, GrootError> {
        self.requests = self.requests.wrapping_add(1);
        let request = RequestHeader::new(kind, self.requests);
        let header = request.bytes();
        let parts: Vec<&[u8]> = [&b""[..], &header].into_iter().chain(about).collect();
        let replied = self.connection.send(&parts).and_then(|()| self.connection.receive());
        let replied = replied.map_err(|source| GrootError::Connection { address: self.address.clone(), source })?;
        let [empty, parts @ ..] = replied.as_slice() else { return Err(self.foreign("its reply is empty")) };
        match parts {
            _ if !empty.is_empty() => Err(self.foreign("its reply has no empty frame first")),
            [error, reason] if error == b"error" => {
                let reason = String::from_utf8_lossy(reason).escape_debug().to_string();
                Err(GrootError::Refused { address: self.address.clone(), reason })
            }
            [header, body @ ..] if body.len() < 2 => {
                let tree = tree_of_reply(request, header);
                let tree = tree.ok_or_else(|| self.foreign("its reply is not to the request"))?;
                if *self.tree.get_or_insert(tree) != tree {
                    return Err(GrootError::OtherTree { address: self.address.clone() });
                }
                Ok(body.first().cloned().unwrap_or_default())
            }
            parts => Err(self.foreign(format!("its reply has {} parts", parts.len()))),
        }
    }

    pub(crate) fn foreign(&self, problem: impl Into<String>) -> GrootError {
        GrootError::Foreign { address: self.address.clone(), problem: problem.into() }
    }
}
