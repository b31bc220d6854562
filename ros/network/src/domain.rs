//! A DDS domain: messages of the nodes of ROS 2, without a bridge.

mod absences;
mod announcements;
mod as_is;
mod correlation;
mod delays;
mod exchange;
mod goodbye;
mod inbox;
mod listener;
mod names;
mod nodes;
mod options;
mod participant;
mod property_statuses;
mod pulse;
mod readers;
mod reception;
mod requests;
mod services;
mod writers;

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;
use std::time::Duration;

use bags::{Account, Received, Source};

use crate::Error;
use crate::clock::now;
use crate::robot::{Live, Publish, Robot};
use exchange::{NodeNames, Subscribed};
use participant::Participant;
use property_statuses::PropertyStatuses;
use reception::Reception;

pub use exchange::{Client, IncomingRequest, Publication, Reply, Request, Response};
pub use options::{Options, obstacles};
pub use participant::Publisher;

/// How long one call waits for a message, by default.
const PATIENCE: Duration = Duration::from_millis(10);

/// The most messages of the listener in one call that lead to nothing to return.
const MOST_RECEIVED: usize = 100;

/// How long to look for publishers: after the last one was found, and at most.
const CALM: Duration = Duration::from_millis(500);
const LONGEST_LOOK: Duration = Duration::from_secs(2);

/// Call this at the beginning of `main`: a program that joins a domain starts itself again as a listener, a process of
/// its own. In that process, this function does all the work, and the process must end with the returned exit status.
#[must_use]
pub fn listen() -> Option<ExitCode> {
    if std::env::args_os().nth(1).is_none_or(|first| first != participant::LISTEN) {
        // The executable file may be replaced while this process runs.
        let own = if cfg!(target_os = "linux") { Ok("/proc/self/exe".into()) } else { std::env::current_exe() };
        own.into_iter().for_each(participant::listen_with);
        return None;
    }
    Some(listener::work())
}

/// A participant in a DDS domain. It is a source of the messages on some topics, or on all. It publishes only its own
/// presence and its subscriptions, unless its [publisher](Self::publisher) is used.
///
/// The time of a message is when it was received, by a clock of this machine that never goes back. Its publish time is
/// the publisher's stamp. Publishers number their messages, so missing ones are known; the loss of the newest ones
/// shows only when the next one arrives.
///
/// The clock advances only as far as messages could have been received. The listener proves that with datagrams to
/// itself, which take the same way as messages. If it fails, another listener takes its place, and the messages of the
/// meantime are missing.
pub struct Domain {
    participant: Option<Participant>,
    reception: Reception,
    /// How long one call waits for a message.
    pub patience: Duration,
}

impl Domain {
    /// Joins a domain, for topics with these names or for all, and looks for publishers for up to two seconds.
    #[must_use]
    pub fn join(options: Options, wanted: Option<BTreeSet<String>>) -> Self {
        Self::join_as(options, None, wanted)
    }

    /// The same as at least one node, with these names, such as `/r1/robot`. Nodes can [publish](Self::publisher), and
    /// receive messages without delay. Subscriptions and publications in a node's namespace belong to that node.
    /// Messages that were latched before are received only if it `receives_latched`.
    ///
    /// # Panics
    /// Without a name.
    #[must_use]
    pub fn nodes(options: Options, names: Vec<String>, receives_latched: bool, wanted: BTreeSet<String>) -> Self {
        assert!(!names.is_empty(), "a node has a name");
        Self::join_as(options, Some(NodeNames { names, receives_latched }), Some(wanted))
    }

    fn join_as(options: Options, node: Option<NodeNames>, wanted: Option<BTreeSet<String>>) -> Self {
        let subscribed = if wanted.is_some() { Subscribed::Nothing } else { Subscribed::All };
        let participant = Participant::join(options, node, subscribed);
        let mut domain = Self { participant: Some(participant), reception: Reception::new(wanted), patience: PATIENCE };
        let (begun, mut found, mut found_at) = (now(), 0, now());
        while domain.reception.is_looking()
            && begun.elapsed() < LONGEST_LOOK
            && (found == 0 || found_at.elapsed() < CALM)
        {
            domain.receive_next();
            let robot = &domain.reception.discovery.robot;
            let publishers = robot.publishers.len() + robot.nodes.len();
            if publishers != found {
                (found, found_at) = (publishers, now());
            }
        }
        domain
    }

    /// Prepares to call these services, and reads these topics only with the given types. Both map names to types. Must
    /// be called before it [begins](Live::begin).
    pub fn prepare(&mut self, services: BTreeMap<String, String>, topics: BTreeMap<String, String>) {
        self.reception.discovery.wanted.kinds = topics;
        let Some(publisher) = self.publisher() else { return };
        for (service, kind) in services {
            self.reception.services.called.insert(service.clone(), kind.clone());
            publisher.request(Request { service, kind, number: 0, body: Vec::new() });
        }
    }

    /// The next response to a [request](Publisher::request), if one was received.
    pub fn response(&mut self) -> Option<Response> {
        self.reception.services.responses.pop_front()
    }

    /// Offers services: their types by their names. Must be called before it [begins](Live::begin).
    pub fn serve(&mut self, services: BTreeMap<String, String>) {
        let Some(publisher) = self.publisher() else { return };
        services.iter().for_each(|(service, kind)| publisher.serve(service.clone(), kind.clone()));
        self.reception.services.offered = services;
    }

    /// The next request to a service that is offered here, if one was received. It must get a
    /// [response](Publisher::respond).
    pub fn request(&mut self) -> Option<IncomingRequest> {
        self.reception.services.requests.pop_front()
    }

    /// The time of the clock that stamps received messages, in nanoseconds since 1970. None if it has left the domain.
    #[must_use]
    pub fn now_ns(&self) -> Option<i64> {
        self.participant.as_ref().map(Participant::now_ns)
    }

    /// How often DDS has failed. Requests that were sent before get no response.
    #[must_use]
    pub fn failures(&self) -> usize {
        self.reception.services.failures
    }

    /// The types of a service, one for each known server.
    #[must_use]
    pub fn servers(&self, service: &str) -> Vec<String> {
        let servers = self.reception.services.servers.get(&names::request(service));
        let kind = |server: &exchange::Server| names::whole(&server.kind, &["_Request"]).unwrap_or_default();
        servers.into_iter().flatten().map(kind).collect()
    }

    /// Receives the next message of the listener. Returns whether there was one.
    fn receive_next(&mut self) -> bool {
        let patience = self.patience;
        let message = self.participant.as_ref().and_then(|participant| participant.next(patience));
        message.map(|message| self.reception.receive(message)).is_some()
    }

    /// Publishes in the domain. None if it has left the domain.
    #[must_use]
    pub fn publisher(&self) -> Option<Publisher> {
        self.participant.as_ref().map(Participant::publisher)
    }

    /// The topics that are published here and have a subscriber.
    #[must_use]
    pub fn read(&self) -> &BTreeSet<String> {
        &self.reception.discovery.read
    }
}

impl Source for Domain {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        // Not every message of the listener leads to something to return.
        for _ in 0..MOST_RECEIVED {
            if let Some(received) = self.reception.next(body) {
                return received;
            }
            let has_received = self.receive_next();
            let services = &self.reception.services;
            if !has_received || !services.responses.is_empty() || !services.requests.is_empty() {
                break;
            }
        }
        self.reception.next(body).unwrap_or(Received::Idle)
    }

    fn end(&mut self) {
        self.participant = None;
    }

    fn account(&self) -> Account<'_> {
        let Reception { discovery, remarks, .. } = &self.reception;
        Account { survey: &discovery.survey, lost: &remarks.lost, notes: &remarks.notes, counts_losses: true }
    }
}

impl Live for Domain {
    fn name(&self) -> &str {
        "the robot's nodes"
    }

    fn robot(&self) -> &Robot {
        &self.reception.discovery.robot
    }

    fn only_show(&mut self, topics: BTreeSet<String>) {
        self.reception.discovery.wanted.shown = topics;
    }

    /// Subscribes to the wanted topics. Messages count once their publishers have discovered that.
    fn begin(&mut self) -> Result<(), Error> {
        if let (Some(topics), Some(participant)) = (self.reception.dds_topics(), &self.participant) {
            participant.subscribe(Subscribed::To(topics));
            self.reception.begin();
        }
        Ok(())
    }

    fn status_publisher(&self) -> Option<Publish> {
        let publisher = self.publisher()?;
        let mut statuses = PropertyStatuses::default();
        Some(Box::new(move |now| statuses.publications(now).into_iter().for_each(|message| publisher.publish(message))))
    }
}
