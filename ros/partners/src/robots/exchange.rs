//! Passes requests of other nodes on to the simulated robot, and its responses and messages to these nodes, under the
//! names that they have in the domain.

use std::collections::BTreeMap;

use network::{Client, IncomingRequest, Publication, Publisher, Reply};
use remote::{NodeMessage, ServiceRequest};

use super::topics::{OfferedNames, OfferedTopic};

/// The most requests that wait for a response. Beyond that, the oldest get none.
const MOST_OPEN: usize = 10_000;

/// Translates names, and remembers which client gets which response.
pub(super) struct Exchange {
    names: OfferedNames,
    /// The requests without a response, by number: the name of the service in the domain, and the client.
    open: BTreeMap<u64, (String, Client)>,
    last_number: u64,
}

impl Exchange {
    pub(super) fn of(names: OfferedNames) -> Self {
        Self { names, open: BTreeMap::new(), last_number: 0 }
    }

    /// Announces all topics.
    pub(super) fn offer(&self, publisher: &Publisher) {
        for OfferedTopic { name, kind, is_latched } in self.names.topics.values().cloned() {
            publisher.publish(Publication { topic: name, kind, is_latched, body: Vec::new() });
        }
    }

    /// The name within the program of a service of the domain.
    pub(super) fn within(&self, service: &str) -> &str {
        self.names.services.get(service).map_or("", |(within, _)| within)
    }

    /// Accepts a request and numbers it; `None` if there is no such service.
    pub(super) fn accept(&mut self, request: IncomingRequest) -> Option<ServiceRequest> {
        let (service, kind) = self.names.services.get(&request.service)?.clone();
        self.last_number += 1;
        if self.open.len() == MOST_OPEN {
            self.open.pop_first();
        }
        self.open.insert(self.last_number, (request.service, request.client));
        Some(ServiceRequest { service, kind, number: self.last_number, body: request.body })
    }

    /// Sends a response to its client, or a message on its topic.
    pub(super) fn send(&mut self, message: NodeMessage, publisher: &Publisher) {
        match message {
            NodeMessage::Response { number, body } => {
                let Some((service, client)) = self.open.remove(&number) else { return };
                let kind = self.names.services[&service].1.clone();
                publisher.respond(Reply { service, kind, client, body });
            }
            NodeMessage::Message { topic, body } => {
                let Some(OfferedTopic { name, kind, is_latched }) = self.names.topics.get(&topic).cloned() else {
                    return;
                };
                publisher.publish(Publication { topic: name, kind, is_latched, body });
            }
        }
    }
}
