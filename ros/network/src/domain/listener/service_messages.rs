//! Requests and responses of services that are called from here or offered here.

use rustdds::{GUID, RTPSEntity as _, SampleIdentity, SequenceNumber};

use super::Listener;
use crate::domain::correlation::Correlation;
use crate::domain::exchange::{ListenerMessage, Request, Response, Sample, prefix};
use crate::domain::names::{self, RosName};
use crate::domain::services::{Services, incoming_request};

impl Listener {
    /// Adds a request. If its body is empty, only the writer of requests is created.
    pub(super) fn request(&mut self, request: Request) -> Result<(), String> {
        let (topic, kind) = (names::request(&request.service), names::request_kind(&request.kind));
        self.writers.write(topic, kind, false, Vec::new())?;
        if !request.body.is_empty() {
            self.requests.add(request);
        }
        Ok(())
    }

    /// Sends the requests that servers can receive.
    pub(super) fn send_requests(&mut self) {
        for (request, form) in self.requests.due() {
            // The request names the reader of responses: a server responds once it has discovered that.
            let reader = self.readers.guid(&names::reply(&request.service));
            let related =
                reader.map(|guid| SampleIdentity { writer_guid: guid, sequence_number: SequenceNumber::UNKNOWN });
            let topic = names::request(&request.service);
            let beside = related.filter(|_| form == Correlation::Beside);
            let body = self.requests.body(&request, form);
            match related.and_then(|_| self.writers.send_related(&topic, body, beside)) {
                Some(number) => self.requests.add_sent(request, number),
                // There is no reader of responses yet, or no room now.
                None => self.requests.add(request),
            }
        }
    }

    pub(super) fn serve(&mut self, service: &str, kind: &str) -> Result<(), String> {
        self.writers.write(names::reply(service), names::response_kind(kind), false, Vec::new())?;
        self.readers.read(&names::request(service), names::request_kind(kind), true, false)
    }

    /// Sends the responses that clients can receive.
    pub(super) fn send_responses(&mut self) {
        for reply in self.services.due() {
            let client = reply.client;
            let identity = SampleIdentity {
                writer_guid: GUID::from_bytes(client.entity),
                sequence_number: SequenceNumber::from(client.number),
            };
            let related = client.header.is_none().then_some(identity);
            if self.writers.send_related(&names::reply(&reply.service), Services::body(&reply), related).is_none() {
                // There is no room now.
                self.services.respond(reply);
            }
        }
    }

    /// The request or response in a sample, if it belongs to a service that is offered here or called from here.
    pub(super) fn service_message(
        &mut self,
        sample: Sample,
        related: Option<([u8; 16], i64)>,
    ) -> Option<ListenerMessage> {
        let writer = prefix(&sample.writer);
        if !self.peers.is_discovered(&writer) {
            // Its participant has just been discovered.
            self.has_events |= self.peers.process_events(&mut self.pulse);
        }
        let form = self.peers.correlation(&writer);
        match RosName::of(&sample.topic)? {
            RosName::Request(service) => {
                let request = incoming_request(service, form, sample, related.map(|(guid, _)| guid));
                request.map(ListenerMessage::Request)
            }
            RosName::Reply(service) => {
                // All clients of a service receive all of its responses.
                let own = |(guid, _): &([u8; 16], i64)| prefix(guid) == prefix(&self.participant.guid().to_bytes());
                let related = related.filter(own).map(|(_, number)| number);
                let response = self.requests.response(&service, form, related, sample.body);
                response.map(|(number, body)| ListenerMessage::Response(Response { number, body }))
            }
            RosName::Topic(_) => None,
        }
    }
}
