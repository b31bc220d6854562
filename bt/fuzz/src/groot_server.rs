//! What a client may request about a tree that is run here.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::OnceLock;
use std::time::Duration;

use groot::{Client, RequestHeader, RequestKind, Server, Value};
use tree_logs::LoggedTransition;

use crate::{Random, wire};

const XML: &str = r#"<root BTCPP_format="4"> <BehaviorTree ID="Main" _fullpath=""> <Sequence name="all" _uid="1">
    <Work _uid="2"/> </Sequence> </BehaviorTree> </root>"#;
/// Longer than the server waits for a client.
const PATIENCE: Duration = Duration::from_secs(10);

/// Asks a server. If the first byte is even, the others are all that it is sent; otherwise, each is the code of a
/// request, and the rest from the first zero on is the second part of all of them. Then others are still served.
pub fn exercise(bytes: &[u8]) {
    let Some((way, rest)) = bytes.split_first() else { return };
    let sent = if way % 2 == 0 { rest.to_vec() } else { requests(rest) };
    let server = server();
    let mut stream = TcpStream::connect(server.address()).expect("it listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("the time to wait for it");
    // The server may end the connection at any time, but not keep it.
    let asked = stream.write_all(&sent).and_then(|()| stream.shutdown(Shutdown::Write));
    let answered = asked.and_then(|()| stream.read_to_end(&mut Vec::new()));
    let is_kept = |error: &io::Error| matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
    assert!(!answered.is_err_and(|error| is_kept(&error)), "the connection is ended");
    let mut other = Client::connect(&server.address().to_string(), PATIENCE).expect("others are served");
    assert_eq!(other.statuses().expect("others are answered"), [(1, 1), (2, 12)]);
}

/// The server that all inputs ask.
fn server() -> &'static Server {
    static SERVER: OnceLock<Server> = OnceLock::new();
    SERVER.get_or_init(|| {
        let any = SocketAddr::from(([127, 0, 0, 1], 0));
        let server = (0..100).find_map(|_| Server::open(any).ok()).expect("a free pair of ports");
        server.show(XML, 2, ["Main".to_owned()]);
        server.write("Main", "level", Some(Value::from(42)));
        let transition = |uid, status| LoggedTransition { at_us: 20_000, uid, status };
        server.advance(20_000, [transition(1, 1), transition(2, 2), transition(2, 0)]);
        server
    })
}

/// Requests with these codes.
fn requests(codes: &[u8]) -> Vec<u8> {
    let (codes, about) = codes.split_at(codes.iter().position(|code| *code == 0).unwrap_or(codes.len()));
    let mut bytes = wire::handshake(b"REQ");
    for (code, id) in codes.iter().zip(1..) {
        let mut header = RequestHeader::new(RequestKind::Status, id).bytes();
        header[1] = *code;
        bytes.extend(wire::message(&[&header, about.get(1..).unwrap_or_default()]));
    }
    bytes
}

/// Damaged requests.
pub fn bytes(random: &mut Random) -> Vec<u8> {
    let codes = random.pick(&["TSBrt", "rtt", "BBB", "IXUDRA", "T", "tSr"]).as_bytes();
    let about = random.pick(&["start", "stop", "Main", "Main;Main;none;", "", "{\"uid\": 1}"]).as_bytes();
    let mut codes = [codes, &[0], about].concat();
    if random.below(2) == 0 {
        random.damage_bytes(&mut codes);
        return [&[1][..], &codes].concat();
    }
    let mut raw = requests(&codes);
    random.damage_bytes(&mut raw);
    [&[0][..], &raw].concat()
}
