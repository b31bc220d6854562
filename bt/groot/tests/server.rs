//! The replies of the server to clients.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use groot::{
    Blackboards, BoardValue, Client, Connection, GrootError, RequestHeader, RequestKind, Server, SocketType, Value,
    ZmtpError,
};
use tree_logs::LoggedTransition;

const TIMEOUT: Duration = Duration::from_secs(5);
const XML: &str = r#"<root BTCPP_format="4"> <BehaviorTree ID="Main" _fullpath=""> <Sequence name="Sequence" _uid="1">
    <Work name="Work" _uid="2"/> </Sequence> </BehaviorTree> </root>"#;

/// A server on a free pair of ports.
fn server() -> Server {
    (0..100).find_map(|_| Server::open(SocketAddr::from(([127, 0, 0, 1], 0))).ok()).expect("there is a free pair")
}

fn client(server: &Server) -> Client {
    Client::connect(&server.address().to_string(), TIMEOUT).unwrap()
}

fn transition(at_us: i64, uid: i64, status: i64) -> LoggedTransition {
    LoggedTransition { at_us, uid, status }
}

#[test]
fn a_client_receives_the_tree_that_is_shown() {
    let server = server();
    server.show(XML, 2, ["Main".to_owned()]);
    server.advance(20_000, [transition(20_000, 1, 1), transition(20_000, 2, 2), transition(20_000, 2, 0)]);
    server.write("Main", "level", Some(Value::from(42)));
    server.write("Main", "gone", Some(Value::from(1)));
    server.write("Main", "gone", None);
    let (mut one, mut other) = (client(&server), client(&server));
    assert_eq!(one.tree().unwrap().nodes().len(), 2);
    assert_eq!(other.statuses().unwrap(), [(1, 1), (2, 12)]);
    let boards = other.blackboards(&["Main".to_owned(), "none".to_owned()]).unwrap();
    let level = ("level".to_owned(), BoardValue::Whole(42.into()));
    assert_eq!(boards.boards, [("Main".to_owned(), vec![level])]);
    assert_eq!(other.blackboards(&["none".to_owned()]).unwrap(), Blackboards::default());
    assert_eq!(one.transitions(0).unwrap(), []);
    // Of too many transitions, the last are stored. They are sent once.
    assert_eq!(one.start_recording().unwrap(), 20_000);
    let all: Vec<_> = (0..1500).map(|place| transition(20_000 + place, 2, 1 + place % 2)).collect();
    server.advance(21_500, all.iter().copied());
    assert_eq!(one.transitions(20_000).unwrap(), all[500..]);
    assert_eq!(other.transitions(20_000).unwrap(), []);
    one.stop_recording().unwrap();
    server.advance(21_600, [transition(21_600, 2, 3)]);
    assert_eq!(one.transitions(20_000).unwrap(), []);
    // For clients, the same tree from its start is another tree.
    server.show(XML, 2, []);
    assert!(matches!(one.statuses(), Err(GrootError::OtherTree { .. })));
    assert_eq!(client(&server).statuses().unwrap(), [(1, 0), (2, 0)]);
}

#[test]
fn strange_clients_get_an_error_or_no_connection_and_others_are_served() {
    let server = server();
    server.show(XML, 2, []);
    let address = server.address().to_string();
    let header = RequestHeader::new(RequestKind::Recording, 7).bytes();
    let mut strange = Connection::connect(&address, SocketType::Req, TIMEOUT, 1 << 20).unwrap();
    let hooks = b"IRUDAX".map(|kind| vec![vec![2, kind, 0, 0, 0, 0], b"{}".to_vec()]);
    let others = [vec![], vec![vec![]], vec![vec![9, b'S', 0, 0, 0, 0]], vec![vec![7; 60_000]], vec![header.to_vec()]];
    for request in hooks.into_iter().chain(others) {
        let parts: Vec<&[u8]> = std::iter::once(&b""[..]).chain(request.iter().map(Vec::as_slice)).collect();
        strange.send(&parts).unwrap();
        let reply = strange.receive().unwrap();
        assert!(reply.len() == 3 && reply[1] == b"error", "{request:?}: {reply:?}");
    }
    // A request that is too large, or no request at all, ends the connection.
    strange.send(&[b"", &vec![0; 1 << 20]]).ok();
    assert!(matches!(strange.receive(), Err(ZmtpError::Closed)));
    let mut half = TcpStream::connect(&address).unwrap();
    half.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
    let idle: Vec<TcpStream> = (0..10).map(|_| TcpStream::connect(&address).unwrap()).collect();
    assert_eq!(client(&server).statuses().unwrap().len(), 2);
    let mut rest = Vec::new();
    half.set_read_timeout(Some(TIMEOUT)).unwrap();
    let _ = half.read_to_end(&mut rest);
    drop(idle);
    // Subscribers are accepted.
    let next = SocketAddr::new(server.address().ip(), server.address().port() + 1);
    assert!(TcpStream::connect(next).is_ok());
    // Connections end when the server is dropped.
    let mut last = client(&server);
    drop(server);
    assert!((0..1_000_000).any(|_| last.statuses().is_err()));
}
