//! What other nodes ask of the simulated robot, and what they are told, under the names that these know.

use std::collections::BTreeMap;

use network::{Client, Publication, Reply, Served, Voice};
use remote::{Call, FromNode};

use super::topics::{OfferedNames, OfferedTopic};

/// The most calls that wait for a response: beyond that, the oldest get none.
const MOST_OPEN: usize = 10_000;

/// Hands on calls and what is said to whom they come from.
pub(super) struct Exchange {
    names: OfferedNames,
    /// The calls that have no response yet: with the services, as these are called outside, and who asks.
    open: BTreeMap<u64, (String, Client)>,
    last_number: u64,
}

impl Exchange {
    pub(super) fn of(names: OfferedNames) -> Self {
        Self { names, open: BTreeMap::new(), last_number: 0 }
    }

    /// Offers all topics.
    pub(super) fn offer(&self, voice: &Voice) {
        for OfferedTopic { name, kind, is_latched } in self.names.topics.values().cloned() {
            voice.publish(Publication { topic: name, kind, is_latched, body: Vec::new() });
        }
    }

    /// What a service is called within.
    pub(super) fn within(&self, service: &str) -> &str {
        self.names.services.get(service).map_or("", |(within, _)| within)
    }

    /// The call that has come as a request; none if there is no such service.
    pub(super) fn call(&mut self, request: Served) -> Option<Call> {
        let (service, kind) = self.names.services.get(&request.service)?.clone();
        self.last_number += 1;
        if self.open.len() == MOST_OPEN {
            self.open.pop_first();
        }
        self.open.insert(self.last_number, (request.service, request.client));
        Some(Call { service, kind, number: self.last_number, body: request.body })
    }

    /// Tells others what is said.
    pub(super) fn tell(&mut self, said: FromNode, voice: &Voice) {
        match said {
            FromNode::Response { number, body } => {
                let Some((service, client)) = self.open.remove(&number) else { return };
                let kind = self.names.services[&service].1.clone();
                voice.respond(Reply { service, kind, client, body });
            }
            FromNode::Message { topic, body } => {
                let Some(OfferedTopic { name, kind, is_latched }) = self.names.topics.get(&topic).cloned() else {
                    return;
                };
                voice.publish(Publication { topic: name, kind, is_latched, body });
            }
        }
    }
}
