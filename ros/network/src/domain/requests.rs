//! Requests to services of ROS 2, and which response belongs to which.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use super::correlation::{Correlation, take_header, with_header};
use super::heard::{Offers, Prefix, Request, prefix};
use super::names::{self, RosName};
use crate::clock::now;

/// How long a server that was found may not have found who asks it.
const SETTLING: Duration = Duration::from_millis(500);

/// How long a request waits for a server.
const PATIENCE: Duration = Duration::from_secs(10);

/// The most requests that wait for their servers, and the most that wait for responses.
const MOST: usize = 4096;

/// The requests that have not been answered.
#[derive(Debug)]
pub(super) struct Requests {
    /// Who asks, in headers.
    client: [u8; 8],
    /// What waits for a server, and since when.
    waiting: VecDeque<(Request, Instant)>,
    /// Who offers services, by the service and the DDS type of its requests.
    servers: BTreeMap<(String, String), BTreeMap<[u8; 16], Offered>>,
    /// The requests that have been sent, by service and by the number that their writer gave them: their own numbers,
    /// and whether they have been answered.
    asked: BTreeMap<(String, i64), (u64, bool)>,
}

/// What is known of a server: how it is asked, and since when it is known.
#[derive(Clone, Copy, Debug)]
struct Offered {
    correlation: Correlation,
    since: Instant,
}

impl Requests {
    pub(super) fn of(participant: &[u8; 16]) -> Self {
        let [.., a, b, c, d, e, f, g, h] = prefix(participant);
        let client = [a, b, c, d, e, f, g, h];
        Self { client, waiting: VecDeque::new(), servers: BTreeMap::new(), asked: BTreeMap::new() }
    }

    /// Keeps a request until somebody can answer it. The oldest gives way if there are too many.
    pub(super) fn ask(&mut self, request: Request) {
        if self.waiting.len() == MOST {
            self.waiting.pop_front();
        }
        self.waiting.push_back((request, now()));
    }

    /// Takes note of who offers services. Both ends of a server must be known.
    pub(super) fn note(&mut self, offers: &Offers, correlation: impl Fn(&Prefix) -> Correlation) {
        let before = std::mem::take(&mut self.servers);
        for (topic, servers) in &offers.requests {
            let Some(RosName::Request(service)) = RosName::of(topic) else { continue };
            let reply = names::reply(&service);
            let answers = |of: Prefix| offers.writers.iter().any(|one| one.topic == reply && one.participant() == of);
            for server in servers.iter().filter(|server| answers(prefix(&server.reader))) {
                let key = (service.clone(), server.kind.clone());
                let new = || Offered { correlation: correlation(&prefix(&server.reader)), since: now() };
                let known = before.get(&key).and_then(|known| known.get(&server.reader).copied());
                self.servers.entry(key).or_default().insert(server.reader, known.unwrap_or_else(new));
            }
        }
    }

    /// The requests that can be sent now, once the newest server has had the time to find who asks. Of servers of both
    /// kinds, those of Fast DDS are asked: they might misread a header, and the others only lack it.
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

    /// The numbers of requests for which nobody has come in time. They are not asked any more.
    pub(super) fn given_up(&mut self) -> Vec<u64> {
        let mut given_up = Vec::new();
        self.waiting.retain(|(request, since)| {
            let is_late = since.elapsed() > PATIENCE;
            given_up.extend(is_late.then_some(request.number));
            !is_late
        });
        given_up
    }

    /// The message that asks for a response with this header, or without one.
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

    /// A request has got a number from its writer.
    pub(super) fn sent(&mut self, request: Request, sequence: i64) {
        if self.asked.len() >= MOST
            && let Some(oldest) =
                self.asked.iter().min_by_key(|(_, (number, done))| (!done, *number)).map(|(key, _)| key.clone())
        {
            self.asked.remove(&oldest);
        }
        self.asked.insert((request.service, sequence), (request.number, false));
    }

    /// What a response is, and the number of its request, if it belongs to one of these: `related` is the number in the
    /// parameter beside it, if that refers to a request of this participant.
    pub(super) fn response(
        &mut self,
        service: &str,
        form: Correlation,
        related: Option<i64>,
        mut body: Vec<u8>,
    ) -> Option<(u64, Vec<u8>)> {
        let Correlation::Header = form else {
            let (number, is_answered) = self.asked.get_mut(&(service.to_owned(), related?))?;
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
    use crate::domain::heard::{Server, Writer};

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
    fn a_request_waits_for_a_server_which_says_how_it_is_asked() {
        let mut requests = Requests::of(&[9; 16]);
        [request("/a", 1), request("/b", 2), request("/a", 3)].into_iter().for_each(|one| requests.ask(one));
        requests.note(&offers("/a", 4), |_| Correlation::Header);
        assert!(requests.due().is_empty());
        requests.servers.values_mut().flat_map(BTreeMap::values_mut).for_each(|server| server.since -= SETTLING);
        // It stays known for as long as it is there.
        requests.note(&offers("/a", 4), |_| Correlation::Header);
        let due: Vec<_> = requests.due().into_iter().map(|(request, form)| (request.number, form)).collect();
        assert_eq!(due, [(1, Correlation::Header), (3, Correlation::Header)]);
        requests.note(&offers("/b", 4), |of| Correlation::of((*of == [4; 12]).then_some(CYCLONE)));
        assert_eq!((requests.servers.len(), requests.waiting.len()), (1, 1));
        // One that has been started again must find who asks, too.
        requests.servers.values_mut().flat_map(BTreeMap::values_mut).for_each(|server| server.since -= SETTLING);
        requests.note(&offers("/b", 5), |_| Correlation::Header);
        assert!(requests.due().is_empty());
        assert!(requests.given_up().is_empty());
        requests.waiting.iter_mut().for_each(|(_, since)| *since -= PATIENCE);
        assert_eq!((requests.given_up(), requests.waiting.len()), (vec![2], 0));
        // Who takes requests and does not answer them is no server.
        requests.note(&Offers { writers: Vec::new(), ..offers("/b", 4) }, |_| Correlation::Header);
        assert!(requests.servers.is_empty());
    }

    #[test]
    fn a_response_belongs_to_one_request() {
        let mut requests = Requests::of(&[9; 16]);
        requests.sent(request("/a", 5), 77);
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
