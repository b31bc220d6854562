//! Requests and responses, of services that are called from here and of services that are offered here.

use std::collections::{BTreeMap, VecDeque};

use crate::domain::exchange::{IncomingRequest, Response, Server};
use crate::domain::names;

/// The services of a participant, by their names, with their types; and what has been received for them.
#[derive(Default)]
pub(in crate::domain) struct ServiceTraffic {
    /// The servers that are known, by the DDS topics of their requests.
    pub(in crate::domain) servers: BTreeMap<String, Vec<Server>>,
    /// The services that are called from here, and their responses.
    pub(in crate::domain) called: BTreeMap<String, String>,
    pub(in crate::domain) responses: VecDeque<Response>,
    /// The services that are offered here, and the requests to them.
    pub(in crate::domain) offered: BTreeMap<String, String>,
    pub(in crate::domain) requests: VecDeque<IncomingRequest>,
    /// How often DDS has failed. Requests that were sent before get no response.
    pub(in crate::domain) failures: usize,
}

impl ServiceTraffic {
    /// The DDS topics of the responses and requests to read, with their types.
    pub(super) fn dds_topics(&self) -> BTreeMap<String, Option<String>> {
        let responses = self.called.iter().map(|(name, kind)| (names::reply(name), Some(names::response_kind(kind))));
        let requests = self.offered.iter().map(|(name, kind)| (names::request(name), Some(names::request_kind(kind))));
        responses.chain(requests).collect()
    }
}
