//! Requests to services of ROS 2, and which response belongs to which: what says so depends on the server's middleware.
//!
//! Fast DDS numbers a request as it numbers any sample; a response refers to it in a parameter beside the message,
//! "related sample identity" in DDS-RPC 1.0, 7.8.2. With Cyclone DDS, a request and its response begin with the same
//! sixteen bytes: who asks, and a number.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use super::heard::{Offers, Prefix, Request, prefix};
use super::names::{self, RosName};
use crate::clock::now;

/// How long a server that was found may not have found who asks it.
const SETTLING: Duration = Duration::from_millis(500);

/// The most requests that wait for their servers, and the most that wait for responses.
const MOST: usize = 4096;

/// The bytes that say how a message is encoded, and those of Cyclone's header.
const ENCODING: usize = 4;
const HEADER: usize = 16;

/// The number of Cyclone DDS among the vendors of RTPS.
const CYCLONE: [u8; 2] = [1, 0x10];

/// Where a request and its response say that they belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Correlation {
    Beside,
    Header,
}

impl Correlation {
    /// What a participant of this vendor understands.
    pub(super) fn of(vendor: Option<[u8; 2]>) -> Self {
        if vendor == Some(CYCLONE) { Self::Header } else { Self::Beside }
    }
}

/// The requests that have not been answered.
#[derive(Debug)]
pub(super) struct Requests {
    /// Who asks, in headers.
    client: [u8; 8],
    waiting: VecDeque<Request>,
    /// The services that somebody offers, and of which DDS type the requests are: in which form, and since when.
    servers: BTreeMap<(String, String), (Correlation, Instant)>,
    /// The numbers of requests that have been sent, by service and by the number that their writer gave them.
    asked: BTreeMap<(String, i64), u64>,
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
        self.waiting.push_back(request);
    }

    /// Takes note of who offers services. Both ends of a server must be known.
    pub(super) fn note(&mut self, offers: &Offers, form: impl Fn(&Prefix) -> Correlation) {
        let before = std::mem::take(&mut self.servers);
        for (topic, servers) in &offers.requests {
            let Some(RosName::Request(service)) = RosName::of(topic) else { continue };
            let reply = names::reply(&service);
            let answers = |of: Prefix| offers.writers.iter().any(|one| one.topic == reply && one.participant() == of);
            for server in servers.iter().rev().filter(|server| answers(prefix(&server.reader))) {
                let offered = (service.clone(), server.kind.clone());
                let since = before.get(&offered).map_or_else(now, |(_, since)| *since);
                self.servers.insert(offered, (form(&prefix(&server.reader)), since));
            }
        }
    }

    /// The requests that can be sent now, in the form that their servers understand.
    pub(super) fn due(&mut self) -> Vec<(Request, Correlation)> {
        let mut due = Vec::new();
        self.waiting.retain(|request| match self.servers.get(&(request.service.clone(), request.dds_kind())) {
            Some((form, since)) if since.elapsed() >= SETTLING => {
                due.push((request.clone(), *form));
                false
            }
            _ => true,
        });
        due
    }

    /// The message that asks for a response with this header, or without one.
    pub(super) fn body(&self, request: &Request, form: Correlation) -> Vec<u8> {
        match (form, request.body.split_first_chunk::<ENCODING>()) {
            (Correlation::Header, Some((encoding, message))) => {
                [encoding, &self.client[..], &request.number.to_le_bytes()[..], message].concat()
            }
            _ => request.body.clone(),
        }
    }

    /// A request has got a number from its writer.
    pub(super) fn sent(&mut self, request: Request, sequence: i64) {
        if self.asked.len() >= MOST {
            self.asked.pop_first();
        }
        self.asked.insert((request.service, sequence), request.number);
    }

    /// What a response is, and the number of its request, if it belongs to one of these: `related` is what the
    /// parameter beside it says.
    pub(super) fn response(
        &mut self,
        service: &str,
        form: Correlation,
        related: Option<i64>,
        mut body: Vec<u8>,
    ) -> Option<(u64, Vec<u8>)> {
        let Correlation::Header = form else {
            let number = self.asked.get(&(service.to_owned(), related?))?;
            return Some((*number, body));
        };
        // The second byte of the encoding says whether the least significant byte comes first.
        let is_little = *body.get(1)? == 1;
        let header: [u8; HEADER] = body.get(ENCODING..ENCODING + HEADER)?.try_into().ok()?;
        let [mut client, mut number] =
            [&header[..8], &header[8..]].map(|half| <[u8; 8]>::try_from(half).expect("half"));
        if !is_little {
            client.reverse();
            number.reverse();
        }
        body.drain(ENCODING..ENCODING + HEADER);
        (client == self.client).then(|| (u64::from_le_bytes(number), body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let server = Server { reader: [server; 16], kind: request(service, 0).dds_kind() };
        let requests = [(names::request(service), vec![server])].into();
        Offers { writers: vec![writer], requests, ..Offers::default() }
    }

    #[test]
    fn a_request_waits_for_a_server_which_says_how_it_is_asked() {
        let mut requests = Requests::of(&[9; 16]);
        [request("/a", 1), request("/b", 2), request("/a", 3)].into_iter().for_each(|one| requests.ask(one));
        requests.note(&offers("/a", 4), |_| Correlation::Header);
        assert!(requests.due().is_empty());
        requests.servers.values_mut().for_each(|(_, since)| *since -= SETTLING);
        // It stays known for as long as it is there.
        requests.note(&offers("/a", 4), |_| Correlation::Header);
        let due: Vec<_> = requests.due().into_iter().map(|(request, form)| (request.number, form)).collect();
        assert_eq!(due, [(1, Correlation::Header), (3, Correlation::Header)]);
        requests.note(&offers("/b", 4), |of| Correlation::of((*of == [4; 12]).then_some(CYCLONE)));
        assert_eq!((requests.servers.len(), requests.waiting.len()), (1, 1));
        // Who takes requests and does not answer them is no server.
        requests.note(&Offers { writers: Vec::new(), ..offers("/b", 4) }, |_| Correlation::Header);
        assert!(requests.servers.is_empty());
    }

    #[test]
    fn a_response_belongs_to_one_request() {
        let mut requests = Requests::of(&[9; 16]);
        requests.sent(request("/a", 5), 77);
        assert_eq!(requests.response("/a", Correlation::Beside, Some(77), vec![1]), Some((5, vec![1])));
        assert_eq!(requests.response("/b", Correlation::Beside, Some(77), vec![1]), None);
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
