//! Services of ROS 2 that are offered here: which request a response answers, and when its client can receive it.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use super::correlation::{Correlation, take_header, with_header};
use super::exchange::{Client, IncomingRequest, Prefix, Reply, Sample, prefix};
use super::names;
use crate::clock::now;

/// How long a response waits until its client's reader of responses is discovered, and how long that may take to have
/// an effect.
const PATIENCE: Duration = Duration::from_secs(10);
const SETTLING: Duration = Duration::from_millis(50);

/// The most responses that wait for their clients. If there are more, the oldest are lost.
const MOST: usize = 4096;

/// The responses that have not been sent, and the readers of responses.
#[derive(Debug, Default)]
pub(super) struct Services {
    waiting: VecDeque<(Reply, Instant)>,
    /// When a reader of responses was discovered, by its DDS topic and its participant.
    readers: BTreeMap<(String, Prefix), Instant>,
}

/// The request in a sample. `related` is the entity to which the response must refer, if the sample names one. None if
/// the message is too short for its form.
pub(super) fn incoming_request(
    service: String,
    form: Correlation,
    sample: Sample,
    related: Option<[u8; 16]>,
) -> Option<IncomingRequest> {
    let Sample { writer, number, mut body, .. } = sample;
    let header = if form == Correlation::Header { Some(take_header(&mut body)?) } else { None };
    let entity = related.filter(|guid| *guid != [0; 16]).unwrap_or(writer);
    Some(IncomingRequest { service, client: Client { writer, entity, number, header }, body })
}

impl Services {
    /// Sets the readers of responses that are known now.
    pub(super) fn set_readers(&mut self, readers: BTreeSet<(String, Prefix)>) {
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

    /// Takes the responses that can be sent now: their clients' readers are known, or have not been discovered in time.
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

    /// The message of a response, in the form of its request.
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
        let of = |form, related, body| incoming_request("/a".to_owned(), form, sample(body), related);
        let Some(IncomingRequest { client, body, .. }) = of(Correlation::Beside, Some([5; 16]), vec![0, 1, 0, 0, 8])
        else {
            panic!()
        };
        assert_eq!((client.entity, client.number, body), ([5; 16], 7, vec![0, 1, 0, 0, 8]));
        assert_eq!(Services::body(&reply(client)), [0, 1, 0, 0, 9]);
        for none in [None, Some([0; 16])] {
            let request = of(Correlation::Beside, none, Vec::new());
            assert_eq!(request.map(|request| request.client.entity), Some([4; 16]));
        }
        let header: Vec<u8> = (0..16).collect();
        let Some(IncomingRequest { client, body, .. }) =
            of(Correlation::Header, None, [&[0, 1, 0, 0], &header[..], &[8]].concat())
        else {
            panic!()
        };
        assert_eq!(body, [0, 1, 0, 0, 8]);
        assert_eq!(Services::body(&reply(client)), [&[0, 1, 0, 0], &header[..], &[9]].concat());
        // In the response, numbers begin with the least significant byte.
        let Some(IncomingRequest { client, .. }) = of(Correlation::Header, None, [&[0, 0, 0, 0], &header[..]].concat())
        else {
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
        services.respond(reply(Client { writer: [4; 16], entity: [4; 16], number: 7, header: None }));
        assert!(services.due().is_empty());
        services.set_readers([("rr/aReply".to_owned(), [4; 12]), ("rr/aReply".to_owned(), [5; 12])].into());
        assert!(services.due().is_empty());
        services.readers.values_mut().for_each(|since| *since -= SETTLING);
        services.set_readers([("rr/aReply".to_owned(), [4; 12])].into());
        assert_eq!((services.due().len(), services.due().len()), (1, 0));
        // A client whose reader was not discovered in time gets it all the same, if it reads.
        services.respond(reply(Client { writer: [6; 16], entity: [6; 16], number: 8, header: None }));
        assert!(services.due().is_empty());
        services.waiting.iter_mut().for_each(|(_, since)| *since -= PATIENCE);
        assert_eq!(services.due().len(), 1);
    }
}
