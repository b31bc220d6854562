//! The part of ZeroMQ's protocol (ZMTP 3.0) that requests and replies need: no encryption, no authentication.
//!
//! A connection begins with a greeting of 64 bytes and a command `READY` from each side. Messages of one or more frames
//! follow. The first frame of a request or a reply is empty.
//!
//! Whatever the other side sends, the duration and the size of a message are bounded.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// The type of a socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SocketType {
    /// Sends requests.
    Req,
    /// Sends replies.
    Rep,
    /// Publishes to subscribers.
    Pub,
}

impl SocketType {
    fn name(self) -> &'static [u8] {
        match self {
            Self::Req => b"REQ",
            Self::Rep => b"REP",
            Self::Pub => b"PUB",
        }
    }

    /// The types of sockets that may be on the other side.
    fn peers(self) -> &'static [&'static [u8]] {
        match self {
            Self::Req => &[b"REP", b"ROUTER"],
            Self::Rep => &[b"REQ", b"DEALER"],
            Self::Pub => &[b"SUB", b"XSUB"],
        }
    }
}

/// What went wrong on a connection.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ZmtpError {
    /// An error of the operating system.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The other side has closed the connection.
    #[error("the connection was closed")]
    Closed,
    /// The other side has not sent a complete message in time.
    #[error("there is no answer within {:.1} s", .0.as_secs_f64())]
    Timeout(Duration),
    /// The other side uses a different protocol.
    #[error("it does not use ZeroMQ's protocol: {0}")]
    Foreign(String),
    /// The message is larger than the limit of the connection.
    #[error("it sends more than {0} bytes at once")]
    TooLarge(usize),
}

const GREETING: usize = 64;
/// The maximum number of frames of a message.
const MOST_FRAMES: usize = 8;
/// The maximum size of a command, in bytes.
const MOST_IN_COMMAND: usize = 1 << 10;
const MORE: u8 = 1;
const LONG: u8 = 2;
const COMMAND: u8 = 4;

/// A connection between two sockets.
#[derive(Debug)]
pub struct Connection {
    stream: TcpStream,
    timeout: Duration,
    /// The maximum size of a message, in bytes.
    most: usize,
}

impl Connection {
    /// Connects to a listening socket. A message may take as long as `timeout`, and have `most` bytes.
    ///
    /// # Errors
    /// [`ZmtpError`], after at most `timeout` for each address of the name.
    pub fn connect(address: &str, socket: SocketType, timeout: Duration, most: usize) -> Result<Self, ZmtpError> {
        let mut last = io::Error::new(ErrorKind::NotFound, "the name has no address");
        for address in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, timeout) {
                Ok(stream) => return Self::begin(stream, socket, timeout, most),
                Err(error) => last = error,
            }
        }
        Err(last.into())
    }

    /// Begins a connection on an open stream.
    ///
    /// # Errors
    /// [`ZmtpError`].
    pub fn begin(stream: TcpStream, socket: SocketType, timeout: Duration, most: usize) -> Result<Self, ZmtpError> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(timeout))?;
        let mut connection = Self { stream, timeout, most };
        let deadline = now() + timeout;
        let mut greeting = [0; GREETING];
        (greeting[0], greeting[9], greeting[10]) = (0xff, 0x7f, 3);
        greeting[12..16].copy_from_slice(b"NULL");
        connection.write(&greeting)?;
        let theirs = connection.read(GREETING, deadline)?;
        let foreign = |what: &str| Err(ZmtpError::Foreign(what.to_owned()));
        if theirs[0] != 0xff || theirs[9] & 1 == 0 {
            return foreign("its greeting is another one");
        }
        if theirs[10] < 3 {
            return foreign("its version is older than 3");
        }
        if &theirs[12..17] != b"NULL\0" {
            return foreign("it requires authentication or encryption");
        }
        let mut ready = b"\x05READY".to_vec();
        for (name, value) in [(&b"Socket-Type"[..], socket.name()), (b"Identity", b"")] {
            ready.push(name.len() as u8);
            ready.extend(name);
            ready.extend((value.len() as u32).to_be_bytes());
            ready.extend(value);
        }
        connection.write(&frame(COMMAND, &ready))?;
        let (flags, body) = connection.frame(MOST_IN_COMMAND, deadline)?;
        let properties = body.strip_prefix(b"\x05READY").filter(|_| flags & COMMAND != 0);
        match properties.and_then(|properties| property(properties, b"socket-type")) {
            Some(theirs) if socket.peers().contains(&theirs) => Ok(connection),
            Some(theirs) => foreign(&format!("it is a socket {}", String::from_utf8_lossy(theirs).escape_debug())),
            None => foreign("it does not report that it is ready"),
        }
    }

    /// Sends a message. The first frame of a request or a reply must be empty.
    ///
    /// # Errors
    /// [`ZmtpError`].
    pub fn send(&mut self, parts: &[&[u8]]) -> Result<(), ZmtpError> {
        let mut bytes = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            bytes.extend(frame(if index + 1 < parts.len() { MORE } else { 0 }, part));
        }
        self.write(&bytes)
    }

    /// The frames of the next message.
    ///
    /// # Errors
    /// [`ZmtpError`]. After an error, the connection must not be used again.
    pub fn receive(&mut self) -> Result<Vec<Vec<u8>>, ZmtpError> {
        let deadline = now() + self.timeout;
        let (mut parts, mut rest) = (Vec::new(), self.most);
        loop {
            let (flags, body) = self.frame(rest, deadline)?;
            if flags & COMMAND != 0 {
                // A heartbeat: its time to live and a context, which the reply repeats.
                if let Some([_, _, context @ ..]) = body.strip_prefix(b"\x04PING") {
                    let pong = [b"\x04PONG", context].concat();
                    self.write(&frame(COMMAND, &pong))?;
                }
                continue;
            }
            rest -= body.len();
            parts.push(body);
            if flags & MORE == 0 {
                return Ok(parts);
            }
            if parts.len() == MOST_FRAMES {
                return Err(ZmtpError::Foreign(format!("a message has more than {MOST_FRAMES} frames")));
            }
        }
    }

    /// Whether data arrives, or the other side closes the connection, within this time.
    ///
    /// # Errors
    /// [`ZmtpError`].
    pub fn is_readable_within(&self, time: Duration) -> Result<bool, ZmtpError> {
        self.stream.set_read_timeout(Some(time))?;
        match self.stream.peek(&mut [0]) {
            Ok(_) => Ok(true),
            Err(error) if is_timeout(&error) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    fn frame(&mut self, most: usize, deadline: Instant) -> Result<(u8, Vec<u8>), ZmtpError> {
        let head = self.read(2, deadline)?;
        let (flags, mut length) = (head[0], u64::from(head[1]));
        if flags & !(MORE | LONG | COMMAND) != 0 || flags & COMMAND != 0 && flags & MORE != 0 {
            return Err(ZmtpError::Foreign(format!("a frame begins with the byte {flags}")));
        }
        if flags & LONG != 0 {
            let rest = self.read(7, deadline)?;
            length = rest.iter().fold(length, |length, byte| length << 8 | u64::from(*byte));
        }
        let most = if flags & COMMAND == 0 { most } else { MOST_IN_COMMAND };
        let length = usize::try_from(length).ok().filter(|length| *length <= most);
        let length = length.ok_or(ZmtpError::TooLarge(if flags & COMMAND == 0 { self.most } else { most }))?;
        Ok((flags, self.read(length, deadline)?))
    }

    /// The next bytes. Memory is allocated as they arrive, not as they are announced.
    fn read(&mut self, length: usize, deadline: Instant) -> Result<Vec<u8>, ZmtpError> {
        let (mut bytes, mut block) = (Vec::new(), [0; 1 << 14]);
        while bytes.len() < length {
            let left = deadline.saturating_duration_since(now());
            if left.is_zero() {
                return Err(ZmtpError::Timeout(self.timeout));
            }
            self.stream.set_read_timeout(Some(left))?;
            let most = block.len().min(length - bytes.len());
            match self.stream.read(&mut block[..most]) {
                Ok(0) => return Err(ZmtpError::Closed),
                Ok(read) => bytes.extend(&block[..read]),
                Err(error) if is_timeout(&error) || error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return Err(ZmtpError::Closed),
                Err(error) => return Err(error.into()),
            }
        }
        Ok(bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), ZmtpError> {
        self.stream.write_all(bytes).map_err(|error| match error.kind() {
            ErrorKind::BrokenPipe | ErrorKind::ConnectionReset => ZmtpError::Closed,
            _ if is_timeout(&error) => ZmtpError::Timeout(self.timeout),
            _ => error.into(),
        })
    }
}

/// A frame with its length.
fn frame(flags: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = match u8::try_from(body.len()) {
        Ok(length) => vec![flags, length],
        Err(_) => [&[flags | LONG][..], &(body.len() as u64).to_be_bytes()].concat(),
    };
    bytes.extend(body);
    bytes
}

/// A property of a command `READY`. As the protocol requires, the case of its name is ignored.
fn property<'p>(mut properties: &'p [u8], name: &[u8]) -> Option<&'p [u8]> {
    loop {
        let (length, rest) = properties.split_first()?;
        let (found, rest) = rest.split_at_checked(usize::from(*length))?;
        let (length, rest) = rest.split_first_chunk()?;
        let (value, rest) = rest.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        if found.eq_ignore_ascii_case(name) {
            return Some(value);
        }
        properties = rest;
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

#[expect(clippy::disallowed_methods, reason = "the replies of other programs are awaited in real time")]
pub(crate) fn now() -> Instant {
    Instant::now()
}
