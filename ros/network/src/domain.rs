//! A DDS domain: the nodes of ROS 2 themselves, without a bridge.

mod absences;
mod announcements;
mod as_is;
mod correlation;
mod delays;
mod goodbye;
mod heard;
mod hearing;
mod listener;
mod names;
mod options;
mod participant;
mod pulse;
mod readers;
mod requests;
mod services;
mod standings;
mod writers;

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;
use std::time::Duration;

use bags::{Received, Source, Survey};

use crate::Error;
use crate::clock::now;
use crate::robot::{Live, Publish, Robot};
use heard::{NodeNames, Subscribed};
use hearing::Hearing;
use participant::Participant;
use standings::Standings;

pub use heard::{Client, Publication, Reply, Request, Response, Served};
pub use options::{Options, obstacles};
pub use participant::Voice;

/// How long one call waits for a message, unless it is told otherwise.
const PATIENCE: Duration = Duration::from_millis(10);

/// How much is heard in one call, of which nothing is to be told.
const MOST_HEARD: usize = 100;

/// How long to look for publishers: at least, and after the last one was found; and at most.
const CALM: Duration = Duration::from_millis(500);
const LONGEST_LOOK: Duration = Duration::from_secs(2);

/// Call this at the beginning of `main`: a program that joins a domain starts itself again as the process that listens
/// there. Such a process does its work here, and must end with the returned exit status.
#[must_use]
pub fn listen() -> Option<ExitCode> {
    if std::env::args_os().nth(1).is_none_or(|first| first != participant::LISTEN) {
        // The file may be replaced while this process runs.
        let own = if cfg!(target_os = "linux") { Ok("/proc/self/exe".into()) } else { std::env::current_exe() };
        own.into_iter().for_each(participant::listen_with);
        return None;
    }
    Some(listener::work())
}

/// A participant in a DDS domain, which only listens: it publishes nothing but its own presence, and what it reads,
/// unless its [publisher](Live::publisher) is asked for. It is a source of the messages on some topics, or on all.
///
/// A message's time is when it is received, by a clock of this machine that never goes back; its publish time is the
/// publisher's stamp. Publishers number their messages, so it is known which are missing. That the last ones are
/// missing shows only when the next one comes. Time passes as far as it is known that a message could have been
/// received: what listens proves it by data that comes through all that messages come through, and another takes its
/// place if it cannot. What may have come meanwhile is missing.
pub struct Domain {
    participant: Option<Participant>,
    hearing: Hearing,
    /// How long one call waits for a message.
    pub patience: Duration,
}

impl Domain {
    /// Joins a domain, for topics with these names, or for all, and looks for publishers for a moment.
    #[must_use]
    pub fn join(options: Options, wanted: Option<BTreeSet<String>>) -> Self {
        Self::join_as(options, None, wanted)
    }

    /// The same as at least one node, with these names, such as `/r1/robot`, which [publishes](Self::voice), too, and
    /// hands on messages as soon as they come. What is read and written in a node's namespace belongs to it. What was
    /// latched before is for it only if it `hears_latched`.
    ///
    /// # Panics
    /// Without a name.
    #[must_use]
    pub fn nodes(options: Options, names: Vec<String>, hears_latched: bool, wanted: BTreeSet<String>) -> Self {
        assert!(!names.is_empty(), "a node has a name");
        Self::join_as(options, Some(NodeNames { names, hears_latched }), Some(wanted))
    }

    fn join_as(options: Options, node: Option<NodeNames>, wanted: Option<BTreeSet<String>>) -> Self {
        let subscribed = if wanted.is_some() { Subscribed::Nothing } else { Subscribed::All };
        let participant = Participant::join(options, node, subscribed);
        let mut domain = Self { participant: Some(participant), hearing: Hearing::new(wanted), patience: PATIENCE };
        let (asked, mut found, mut found_at) = (now(), 0, now());
        while domain.hearing.is_looking() && asked.elapsed() < LONGEST_LOOK && (found == 0 || found_at.elapsed() < CALM)
        {
            domain.hear();
            let publishers = domain.hearing.robot.publishers.len() + domain.hearing.robot.nodes.len();
            if publishers != found {
                (found, found_at) = (publishers, now());
            }
        }
        domain
    }

    /// Will ask these services, and read nothing else than these types on topics, both by their names. Must be called
    /// before it [begins](Live::begin).
    pub fn ask(&mut self, services: BTreeMap<String, String>, topics: BTreeMap<String, String>) {
        self.hearing.kinds = topics;
        let Some(voice) = self.voice() else { return };
        for (service, kind) in services {
            self.hearing.asked.insert(service.clone(), kind.clone());
            voice.request(Request { service, kind, number: 0, body: Vec::new() });
        }
    }

    /// The next response to a [request](Voice::request), if one has come.
    pub fn response(&mut self) -> Option<Response> {
        self.hearing.responses.pop_front()
    }

    /// Offers these services, by their names, with their types. Must be called before it [begins](Live::begin).
    pub fn serve(&mut self, services: BTreeMap<String, String>) {
        let Some(voice) = self.voice() else { return };
        services.iter().for_each(|(service, kind)| voice.serve(service.clone(), kind.clone()));
        self.hearing.offered = services;
    }

    /// The next request to a service that is offered here, if one has come: it is to be [responded](Voice::respond) to.
    pub fn request(&mut self) -> Option<Served> {
        self.hearing.served.pop_front()
    }

    /// Now, in nanoseconds since 1970, by the clock that gives messages their times; none if it has left the domain.
    #[must_use]
    pub fn now_ns(&self) -> Option<i64> {
        self.participant.as_ref().map(Participant::now_ns)
    }

    /// How often DDS has failed. What was asked before then is not answered any more.
    #[must_use]
    pub fn failures(&self) -> usize {
        self.hearing.failures
    }

    /// The types of a service, once for each server that is known.
    #[must_use]
    pub fn servers(&self, service: &str) -> Vec<String> {
        let servers = self.hearing.requests.get(&names::request(service));
        let kind = |server: &heard::Server| names::whole(&server.kind, &["_Request"]).unwrap_or_default();
        servers.into_iter().flatten().map(kind).collect()
    }

    /// Hears what comes next. Returns whether anything has come.
    fn hear(&mut self) -> bool {
        let patience = self.patience;
        let heard = self.participant.as_ref().and_then(|participant| participant.next(patience));
        heard.map(|heard| self.hearing.hear(heard)).is_some()
    }

    /// What publishes here; none if it has left the domain.
    #[must_use]
    pub fn voice(&self) -> Option<Voice> {
        self.participant.as_ref().map(Participant::voice)
    }

    /// The topics of what is published here that somebody reads.
    #[must_use]
    pub fn read(&self) -> &BTreeSet<String> {
        &self.hearing.read
    }
}

impl Source for Domain {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        // Not all that is heard is to be told.
        for _ in 0..MOST_HEARD {
            if let Some(received) = self.hearing.next(body) {
                return received;
            }
            if !self.hear() || !self.hearing.responses.is_empty() || !self.hearing.served.is_empty() {
                break;
            }
        }
        self.hearing.next(body).unwrap_or(Received::Idle)
    }

    fn end(&mut self) {
        self.participant = None;
    }

    fn survey(&self) -> &Survey {
        &self.hearing.survey
    }

    fn lost(&self) -> &[String] {
        &self.hearing.lost
    }

    fn notes(&self) -> &[String] {
        &self.hearing.notes
    }

    fn counts_losses(&self) -> bool {
        true
    }
}

impl Live for Domain {
    fn name(&self) -> &str {
        "the robot's nodes"
    }

    fn robot(&self) -> &Robot {
        &self.hearing.robot
    }

    fn only_show(&mut self, topics: BTreeSet<String>) {
        self.hearing.shown = topics;
    }

    /// Subscribes to the wanted topics. Messages count once their publishers know it.
    fn begin(&mut self) -> Result<(), Error> {
        if let (Some(topics), Some(participant)) = (self.hearing.wanted(), &self.participant) {
            participant.subscribe(Subscribed::To(topics));
            self.hearing.begin();
        }
        Ok(())
    }

    fn publisher(&self) -> Option<Publish> {
        let voice = self.voice()?;
        let mut standings = Standings { last: Vec::new() };
        Some(Box::new(move |now| standings.publications(now).into_iter().for_each(|message| voice.publish(message))))
    }
}
