//! Requests to services of ROS 2: when each can be sent, and which response belongs to it.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use super::correlation::{Correlation, take_header, with_header};
use super::exchange::{Offers, Prefix, Request, prefix};
use super::names::{self, RosName};
use crate::clock::now;

/// How long a server that was discovered may take to discover the client.
const SETTLING: Duration = Duration::from_millis(500);

/// How long a request waits for a server to appear.
const PATIENCE: Duration = Duration::from_secs(10);

/// The most requests that wait for their servers, and the most that wait for responses.
const MOST: usize = 4096;

/// The requests that have no response yet.
#[derive(Debug)]
pub(super) struct Requests {
    /// The client, as headers identify it.
    client: [u8; 8],
    /// The requests that wait for a server, and since when.
    waiting: VecDeque<(Request, Instant)>,
    /// The servers, by the service and the DDS type of its requests.
    servers: BTreeMap<(String, String), BTreeMap<[u8; 16], KnownServer>>,
    /// The requests that have been sent, by service and sequence number: their own numbers, and whether they have been
    /// answered.
    sent: BTreeMap<(String, i64), (u64, bool)>,
}

/// What is known of a server: the form of its requests, and since when it is known.
#[derive(Clone, Copy, Debug)]
struct KnownServer {
    correlation: Correlation,
    since: Instant,
}

impl Requests {
    pub(super) fn of(participant: &[u8; 16]) -> Self {
        let [.., a, b, c, d, e, f, g, h] = prefix(participant);
        let client = [a, b, c, d, e, f, g, h];
        Self { client, waiting: VecDeque::new(), servers: BTreeMap::new(), sent: BTreeMap::new() }
    }

    /// Keeps a request until a server can receive it. If there are too many, the oldest is dropped.
    pub(super) fn add(&mut self, request: Request) {
        if self.waiting.len() == MOST {
            self.waiting.pop_front();
        }
        self.waiting.push_back((request, now()));
    }

    /// Sets the servers that are known now. A server needs both a reader of requests and a writer of responses.
    pub(super) fn set_servers(&mut self, offers: &Offers, correlation: impl Fn(&Prefix) -> Correlation) {
        let before = std::mem::take(&mut self.servers);
        for (topic, servers) in &offers.requests {
            let Some(RosName::Request(service)) = RosName::of(topic) else { continue };
            let reply = names::reply(&service);
            let answers = |of: Prefix| offers.writers.iter().any(|one| one.topic == reply && one.participant() == of);
            for server in servers.iter().filter(|server| answers(prefix(&server.reader))) {
                let key = (service.clone(), server.kind.clone());
                let new = || KnownServer { correlation: correlation(&prefix(&server.reader)), since: now() };
                let known = before.get(&key).and_then(|known| known.get(&server.reader).copied());
                self.servers.entry(key).or_default().insert(server.reader, known.unwrap_or_else(new));
            }
        }
    }

    /// Takes the requests that can be sent now, as their newest server has had the time to discover the client. If a
    /// service has servers of both forms, the request has no header: servers on Fast DDS might misread one, while those
    /// on Cyclone DDS only lack it.
    pub(super) fn due(&mut self) -> Vec<(Request, Correlation)> {
        let mut due = Vec::new();
        self.waiting.retain(|(request, _)| {
            let servers = self.servers.get(&(request.service.clone(), names::request_kind(&request.kind)));
            let mut servers = servers.into_iter().flat_map(BTreeMap::values).peekable();
            if servers.peek().is_none() {
                return true;
            }
            let mut correlation = Correlation::Header;
            let is_settled = servers.fold(true, |all, server| {
                if server.correlation == Correlation::Beside {
                    correlation = Correlation::Beside;
                }
                all && server.since.elapsed() >= SETTLING
            });
            due.extend(is_settled.then(|| (request.clone(), correlation)));
            !is_settled
        });
        due
    }

    /// Removes the requests for which no server has appeared in time. Returns their numbers.
    pub(super) fn take_expired(&mut self) -> Vec<u64> {
        let mut expired = Vec::new();
        self.waiting.retain(|(request, since)| {
            let is_late = since.elapsed() > PATIENCE;
            expired.extend(is_late.then_some(request.number));
            !is_late
        });
        expired
    }

    /// The message of a request in this form.
    pub(super) fn body(&self, request: &Request, form: Correlation) -> Vec<u8> {
        match form {
            Correlation::Beside => request.body.clone(),
            Correlation::Header => {
                let mut header = [0; 16];
                header[..8].copy_from_slice(&self.client);
                header[8..].copy_from_slice(&request.number.to_le_bytes());
                with_header(&header, &request.body)
            }
        }
    }

    /// A request was sent with this sequence number.
    pub(super) fn add_sent(&mut self, request: Request, sequence: i64) {
        if self.sent.len() >= MOST
            && let Some(oldest) =
                self.sent.iter().min_by_key(|(_, (number, done))| (!done, *number)).map(|(key, _)| key.clone())
        {
            self.sent.remove(&oldest);
        }
        self.sent.insert((request.service, sequence), (request.number, false));
    }

    /// The number of the request to which a response belongs, and the message. None if it belongs to none of these.
    /// `related` is the sequence number in the parameter beside it, if that refers to a request of this participant.
    pub(super) fn response(
        &mut self,
        service: &str,
        form: Correlation,
        related: Option<i64>,
        mut body: Vec<u8>,
    ) -> Option<(u64, Vec<u8>)> {
        let Correlation::Header = form else {
            let (number, is_answered) = self.sent.get_mut(&(service.to_owned(), related?))?;
            *is_answered = true;
            return Some((*number, body));
        };
        let header = take_header(&mut body)?;
        let (client, number) = header.split_first_chunk::<8>()?;
        let number = u64::from_le_bytes(number.try_into().ok()?);
        (*client == self.client).then_some((number, body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::correlation::CYCLONE;
    use crate::domain::exchange::{Server, Writer};

    fn request(service: &str, number: u64) -> Request {
        let kind = "std_srvs/srv/Trigger".to_owned();
        Request { service: service.to_owned(), kind, number, body: vec![0, 1, 0, 0, 7] }
    }

    fn offers(service: &str, server: u8) -> Offers {
        let writer = Writer {
            guid: [server; 16],
            topic: names::reply(service),
            kind: String::new(),
            hash: None,
            is_reliable: true,
            is_latched: false,
            unfit: None,
        };
        let server = Server { reader: [server; 16], kind: names::request_kind(&request(service, 0).kind) };
        let requests = [(names::request(service), vec![server])].into();
        Offers { writers: vec![writer], requests, ..Offers::default() }
    }

    #[test]
    fn a_request_waits_for_a_server_and_takes_its_form() {
        let mut requests = Requests::of(&[9; 16]);
        [request("/a", 1), request("/b", 2), request("/a", 3)].into_iter().for_each(|one| requests.add(one));
        requests.set_servers(&offers("/a", 4), |_| Correlation::Header);
        assert!(requests.due().is_empty());
        requests.servers.values_mut().flat_map(BTreeMap::values_mut).for_each(|server| server.since -= SETTLING);
        // The server stays known while it is there.
        requests.set_servers(&offers("/a", 4), |_| Correlation::Header);
        let due: Vec<_> = requests.due().into_iter().map(|(request, form)| (request.number, form)).collect();
        assert_eq!(due, [(1, Correlation::Header), (3, Correlation::Header)]);
        requests.set_servers(&offers("/b", 4), |of| Correlation::of((*of == [4; 12]).then_some(CYCLONE)));
        assert_eq!((requests.servers.len(), requests.waiting.len()), (1, 1));
        // A server that was started again must discover the client again.
        requests.servers.values_mut().flat_map(BTreeMap::values_mut).for_each(|server| server.since -= SETTLING);
        requests.set_servers(&offers("/b", 5), |_| Correlation::Header);
        assert!(requests.due().is_empty());
        assert!(requests.take_expired().is_empty());
        requests.waiting.iter_mut().for_each(|(_, since)| *since -= PATIENCE);
        assert_eq!((requests.take_expired(), requests.waiting.len()), (vec![2], 0));
        // Without a writer of responses, it is no server.
        requests.set_servers(&Offers { writers: Vec::new(), ..offers("/b", 4) }, |_| Correlation::Header);
        assert!(requests.servers.is_empty());
    }

    #[test]
    fn a_response_belongs_to_one_request() {
        let mut requests = Requests::of(&[9; 16]);
        requests.add_sent(request("/a", 5), 77);
        assert_eq!(requests.response("/b", Correlation::Beside, Some(77), vec![1]), None);
        assert_eq!(requests.response("/a", Correlation::Beside, Some(77), vec![1]), Some((5, vec![1])));
        assert_eq!(requests.response("/a", Correlation::Beside, None, vec![1]), None);

        let body = requests.body(&request("/a", 6), Correlation::Header);
        assert_eq!(body, [&[0, 1, 0, 0][..], &[9; 8], &[6, 0, 0, 0, 0, 0, 0, 0], &[7]].concat());
        assert_eq!(requests.response("/a", Correlation::Header, None, body.clone()), Some((6, vec![0, 1, 0, 0, 7])));
        let others = Requests::of(&[8; 16]).body(&request("/a", 6), Correlation::Header);
        assert_eq!(requests.response("/a", Correlation::Header, None, others), None);
        for short in 0..body.len() - 1 {
            assert_eq!(requests.response("/a", Correlation::Header, None, body[..short].to_vec()), None, "{short}");
        }
    }
}
