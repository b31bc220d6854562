//! A browser's side of the page: its requests, and its socket.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// A connection that gets the frames of a run.
pub(crate) type Socket = WebSocket<Resuming>;

/// A stream whose reads go on after a signal: the system resumes no read that has a timeout.
pub(crate) struct Resuming(TcpStream);

impl Read for Resuming {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.0.read(buffer) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => return read,
            }
        }
    }
}

impl Write for Resuming {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.0.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// The addresses of a page that is served.
pub(crate) struct Page {
    pub(crate) host: String,
    /// The token of the pilot.
    pub(crate) pilot: String,
    /// The token of viewers.
    pub(crate) viewer: String,
}

impl Page {
    /// The page with these addresses, for the pilot and for viewers.
    pub(crate) fn new(pilot: &str, viewer: &str) -> Self {
        let [(host, pilot), (_, viewer)] = [pilot, viewer].map(|address| {
            address.split_once("http://").unwrap().1.split_once("/?token=").expect("an address contains a token")
        });
        Self { host: host.to_owned(), pilot: pilot.to_owned(), viewer: viewer.to_owned() }
    }

    /// The answer to a request for a path with these headers, as text.
    pub(crate) fn get(&self, path: &str, headers: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    /// Opens a socket as a script of a page from this origin would.
    pub(crate) fn try_socket(&self, token: &str, origin: Option<&str>) -> tungstenite::Result<Socket> {
        let mut request = format!("ws://{}/socket?token={token}", self.host).into_client_request()?;
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(&self.host)?;
        stream.set_read_timeout(Some(Duration::from_secs(100)))?;
        let connected = tungstenite::client(request, Resuming(stream)).map(|(socket, _)| socket);
        connected.map_err(|error| match error {
            tungstenite::HandshakeError::Failure(error) => error,
            tungstenite::HandshakeError::Interrupted(_) => tungstenite::Error::ConnectionClosed,
        })
    }

    /// The socket of the page's own scripts.
    pub(crate) fn socket(&self, token: &str) -> Socket {
        self.try_socket(token, Some(&format!("http://{}", self.host))).unwrap()
    }
}

/// The next frame that has one of these keys.
pub(crate) fn frame_with(socket: &mut Socket, keys: &[&str]) -> Value {
    loop {
        let Message::Text(text) = socket.read().unwrap() else { continue };
        let frame: Value = serde_json::from_str(&text).unwrap();
        if keys.iter().any(|key| frame.get(key).is_some()) {
            return frame;
        }
    }
}

/// The value of this key in the next frame that has it.
pub(crate) fn hear(socket: &mut Socket, key: &str) -> Value {
    frame_with(socket, &[key])[key].take()
}

/// Merges frames until the known state of the run fits.
pub(crate) fn until(socket: &mut Socket, fits: impl Fn(&Value) -> bool) -> Value {
    let mut known = json!({});
    while !fits(&known) {
        let Message::Text(text) = socket.read().unwrap() else { continue };
        let frame: Value = serde_json::from_str(&text).unwrap();
        known.as_object_mut().unwrap().extend(frame.as_object().unwrap().clone());
    }
    known
}

/// The answer to a request.
pub(crate) fn ask(socket: &mut Socket, request: &Value) -> Value {
    socket.send(Message::text(request.to_string())).unwrap();
    hear(socket, "answer")
}
