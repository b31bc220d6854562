//! What a program may answer those who ask it about its tree.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpListener};
use std::thread;
use std::time::Duration;

use groot::{Client, GrootError, RequestHeader, RequestKind, reply_header};

use crate::{Random, wire};

/// What a client asks for, in this order.
const ASKED: [RequestKind; 5] = [
    RequestKind::FullTree,
    RequestKind::Status,
    RequestKind::Blackboard,
    RequestKind::Recording,
    RequestKind::Transitions,
];
const TREE: &str = r#"<root BTCPP_format="4"> <BehaviorTree ID="Main" _fullpath=""> <Sequence name="all" _uid="1">
    <SubTree ID="A" _fullpath="A::2" _uid="2"/> <Work _uid="3"/> </Sequence> </BehaviorTree>
    <BehaviorTree ID="A" _fullpath="A::2"> <Work _uid="4"/> </BehaviorTree> </root>"#;

/// Asks a program for everything. If the first byte is even, the others are all that it sends; otherwise, they are the
/// contents of its replies, each with its length in the first two bytes.
pub fn exercise(bytes: &[u8]) {
    let Some((way, rest)) = bytes.split_first() else { return };
    let sent = if way % 2 == 0 { rest.to_vec() } else { replies(rest) };
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("its address").to_string();
    let program = thread::spawn(move || {
        let Ok((mut stream, _)) = listener.accept() else { return };
        // The client may end the connection at any time.
        let _ = stream.write_all(&sent).and_then(|()| stream.shutdown(Shutdown::Write));
        let _ = stream.read_to_end(&mut Vec::new());
    });
    if let Err(error) = ask(&address) {
        assert!(!error.to_string().is_empty(), "a refusal has a reason");
    }
    program.join().expect("the program does not fail");
}

fn ask(address: &str) -> Result<(), GrootError> {
    let mut client = Client::connect(address, Duration::from_secs(1))?;
    let tree = client.tree()?;
    client.statuses()?;
    client.blackboards(tree.blackboards())?;
    let began_us = client.start_recording()?;
    for transition in client.transitions(began_us)? {
        // What does not fit the tree is refused with a reason.
        drop(tree.change(transition));
    }
    Ok(())
}

/// Replies with these contents.
fn replies(mut contents: &[u8]) -> Vec<u8> {
    let mut bytes = wire::handshake(b"REP");
    for (kind, id) in ASKED.into_iter().zip(1..) {
        let header = reply_header(RequestHeader::new(kind, id), [7; 16]);
        let Some(([low, high], rest)) = contents.split_first_chunk() else { break };
        let (content, rest) = rest.split_at(usize::from(u16::from_le_bytes([*low, *high])).min(rest.len()));
        bytes.extend(wire::message(&[&header, content]));
        contents = rest;
    }
    bytes
}

/// Damaged replies.
pub fn bytes(random: &mut Random) -> Vec<u8> {
    // {"Main": {"a": 1, "b": [true, "x"]}}, as MessagePack.
    let board = b"\x81\xa4Main\x82\xa1a\x01\xa1b\x92\xc3\xa1x".to_vec();
    let transitions = vec![1, 0, 0, 0, 0, 0, 3, 0, 1, 2, 0, 0, 0, 0, 0, 3, 0, 2];
    let contents = [TREE.into(), vec![1, 0, 1, 2, 0, 12], board, b"1795779814000000".to_vec(), transitions];
    let damaged = random.below(contents.len());
    let contents = contents.into_iter().enumerate().flat_map(|(place, mut content)| {
        if place == damaged {
            random.damage_bytes(&mut content);
        }
        [&(content.len() as u16).to_le_bytes()[..], &content].concat()
    });
    let contents: Vec<u8> = contents.collect();
    if random.below(2) == 0 {
        return [&[1][..], &contents].concat();
    }
    let mut raw = replies(&contents);
    random.damage_bytes(&mut raw);
    [&[0][..], &raw].concat()
}
