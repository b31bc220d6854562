//! Services of ROS 2 that are offered here: which request a response answers, and when it reaches who has asked.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use super::correlation::{Correlation, take_header, with_header};
use super::heard::{Client, Prefix, Reply, Sample, Served, prefix};
use super::names;
use crate::clock::now;

/// How long after its request a client's reader of responses may not be known, and how long that may not have an effect
/// yet.
const PATIENCE: Duration = Duration::from_secs(10);
const SETTLING: Duration = Duration::from_millis(50);

/// The most responses that wait for their clients: beyond that, the oldest are lost.
const MOST: usize = 4096;

/// The responses that have not been sent, and who reads responses.
#[derive(Debug, Default)]
pub(super) struct Services {
    waiting: VecDeque<(Reply, Instant)>,
    /// By the DDS topic and the participant: since when it is known.
    readers: BTreeMap<(String, Prefix), Instant>,
}

/// A request, as it was received: `related` is the entity to which a response is to refer, if there is one beside it.
/// None if it is too short for its middleware.
pub(super) fn served(service: String, form: Correlation, sample: Sample, related: Option<[u8; 16]>) -> Option<Served> {
    let Sample { writer, number, mut body, .. } = sample;
    let header = if form == Correlation::Header { Some(take_header(&mut body)?) } else { None };
    let asker = related.filter(|guid| *guid != [0; 16]).unwrap_or(writer);
    Some(Served { service, client: Client { writer, asker, number, header }, body })
}

impl Services {
    /// Takes note of all who read responses.
    pub(super) fn note(&mut self, readers: BTreeSet<(String, Prefix)>) {
        let known = std::mem::take(&mut self.readers);
        self.readers = readers
            .into_iter()
            .map(|reader| {
                let since = known.get(&reader).copied().unwrap_or_else(now);
                (reader, since)
            })
            .collect();
    }

    /// Keeps a response until it can be sent.
    pub(super) fn respond(&mut self, reply: Reply) {
        self.keep(reply, now());
    }

    fn keep(&mut self, reply: Reply, since: Instant) {
        if self.waiting.len() == MOST {
            self.waiting.pop_front();
        }
        self.waiting.push_back((reply, since));
    }

    /// The responses that can be sent now: their clients read them, or are not known to for too long.
    pub(super) fn due(&mut self) -> Vec<Reply> {
        let (mut due, readers) = (Vec::new(), &self.readers);
        self.waiting.retain(|(reply, since)| {
            let reader = readers.get(&(names::reply(&reply.service), prefix(&reply.client.writer)));
            let is_due = reader.is_some_and(|since| since.elapsed() >= SETTLING) || since.elapsed() >= PATIENCE;
            due.extend(is_due.then(|| reply.clone()));
            !is_due
        });
        due
    }

    /// The message that answers a request.
    pub(super) fn body(reply: &Reply) -> Vec<u8> {
        reply.client.header.map_or_else(|| reply.body.clone(), |header| with_header(&header, &reply.body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(body: Vec<u8>) -> Sample {
        Sample {
            topic: "rq/aRequest".into(),
            writer: [4; 16],
            number: 7,
            received_ns: 0,
            sent_ns: None,
            by_ns: None,
            stalled_ns: None,
            body,
        }
    }

    fn reply(client: Client) -> Reply {
        Reply { service: "/a".to_owned(), kind: "std_srvs/srv/Trigger".to_owned(), client, body: vec![0, 1, 0, 0, 9] }
    }

    #[test]
    fn a_response_refers_to_its_request_as_its_client_expects() {
        let of = |form, related, body| served("/a".to_owned(), form, sample(body), related);
        let Some(Served { client, body, .. }) = of(Correlation::Beside, Some([5; 16]), vec![0, 1, 0, 0, 8]) else {
            panic!()
        };
        assert_eq!((client.asker, client.number, body), ([5; 16], 7, vec![0, 1, 0, 0, 8]));
        assert_eq!(Services::body(&reply(client)), [0, 1, 0, 0, 9]);
        for nobody in [None, Some([0; 16])] {
            assert_eq!(of(Correlation::Beside, nobody, Vec::new()).map(|served| served.client.asker), Some([4; 16]));
        }
        let header: Vec<u8> = (0..16).collect();
        let Some(Served { client, body, .. }) =
            of(Correlation::Header, None, [&[0, 1, 0, 0], &header[..], &[8]].concat())
        else {
            panic!()
        };
        assert_eq!(body, [0, 1, 0, 0, 8]);
        assert_eq!(Services::body(&reply(client)), [&[0, 1, 0, 0], &header[..], &[9]].concat());
        // In the response, numbers begin with the least significant byte.
        let Some(Served { client, .. }) = of(Correlation::Header, None, [&[0, 0, 0, 0], &header[..]].concat()) else {
            panic!()
        };
        assert_eq!(client.header.map(|header| (header[0], header[8])), Some((7, 15)));
        for short in 0..20 {
            assert_eq!(of(Correlation::Header, None, vec![1; short]), None, "{short}");
        }
    }

    #[test]
    fn a_response_waits_for_its_client() {
        let mut services = Services::default();
        services.respond(reply(Client { writer: [4; 16], asker: [4; 16], number: 7, header: None }));
        assert!(services.due().is_empty());
        services.note([("rr/aReply".to_owned(), [4; 12]), ("rr/aReply".to_owned(), [5; 12])].into());
        assert!(services.due().is_empty());
        services.readers.values_mut().for_each(|since| *since -= SETTLING);
        services.note([("rr/aReply".to_owned(), [4; 12])].into());
        assert_eq!((services.due().len(), services.due().len()), (1, 0));
        // Who has not been found as a reader by then gets it all the same, if it reads.
        services.respond(reply(Client { writer: [6; 16], asker: [6; 16], number: 8, header: None }));
        assert!(services.due().is_empty());
        services.waiting.iter_mut().for_each(|(_, since)| *since -= PATIENCE);
        assert_eq!(services.due().len(), 1);
    }
}
