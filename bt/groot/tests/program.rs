//! Programs that show a tree, for tests: one with the captured replies of BehaviorTree.CPP 4.10, and one with any
//! replies.

use std::collections::VecDeque;
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;

/// The first bytes of the program, and then the requests with their replies.
pub(crate) fn captured() -> (Vec<u8>, VecDeque<(String, Vec<u8>)>) {
    let mut lines = include_str!("captured/board.wire").lines();
    let replies = |line: &str| {
        let (request, reply) = line.rsplit_once(' ').unwrap();
        (request.to_owned(), bytes(reply))
    };
    (bytes(lines.next().unwrap()), lines.map(replies).collect())
}

fn bytes(hexadecimal: &str) -> Vec<u8> {
    let digits = hexadecimal.as_bytes().chunks(2);
    digits.map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap()).collect()
}

/// A program for one client. `answer` is called with each request.
pub(crate) fn program(
    greeting: Vec<u8>,
    mut answer: impl FnMut(&mut TcpStream, Vec<Vec<u8>>) + Send + 'static,
) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let serving = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let _ = stream.write_all(&greeting);
        // A greeting, and the command `READY`.
        if stream.read_exact(&mut [0; 64]).is_err() || frame(&mut stream).is_none() {
            return;
        }
        let mut parts = Vec::new();
        while let Some((flags, body)) = frame(&mut stream) {
            parts.push(body);
            if flags & 1 == 0 {
                answer(&mut stream, std::mem::take(&mut parts));
            }
        }
    });
    (address, serving)
}

/// A short frame: its flags and its contents.
fn frame(stream: &mut TcpStream) -> Option<(u8, Vec<u8>)> {
    let mut head = [0; 2];
    stream.read_exact(&mut head).ok()?;
    let mut body = vec![0; usize::from(head[1])];
    stream.read_exact(&mut body).ok()?;
    Some((head[0], body))
}
