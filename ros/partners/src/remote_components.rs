//! The connection to the components of a run that are nodes of ROS 2, in a DDS domain.

mod losses;
mod time;

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::time::Duration;

use bags::{Received, Remapping, Source as _, resolve};
use channels::Flaw;
use network::{Domain, Live as _, Publisher, Request};
use remote::{Lost, NodeMessage, ServiceRequest};
use ros_messages::RosType as _;
use ros_messages::standard::Clock;
use runs::{Delivery, RemoteComponents};
use scenarios::Error;
use scenarios::scenario::{Runs, Scenario};

use losses::Losses;
use time::{CLOCK, Time};

/// The name of the run's node.
const NAME: &str = "/steward_run";

/// The longest wait for a message in one call.
const PATIENCE: Duration = Duration::from_millis(10);

/// The time before the run begins in which publishers can discover the node.
const SETTLING: Duration = Duration::from_millis(700);

/// The components of a scenario that are nodes of ROS 2, before the run joins their domain.
pub struct ComponentNodes {
    names: Names,
    /// The types of topics and services, by their names in the domain.
    topics: BTreeMap<String, String>,
    services: BTreeMap<String, String>,
}

impl ComponentNodes {
    /// The components of a scenario, with other names for some topics, services and actions.
    ///
    /// # Errors
    /// If no component has a name that is to be another.
    pub fn of(scenario: &Scenario, remapped: &[Remapping]) -> Result<Self, Error> {
        let (mut topics, mut services, mut names) = (BTreeMap::new(), BTreeMap::new(), Names::default());
        for component in scenario.components.values() {
            if let Runs::Remote(component) = &component.runs {
                topics.extend(component.topics().map(|(name, kind)| (names.resolve(name, remapped), kind)));
                services.extend(component.services().map(|(name, kind)| (names.resolve(name, remapped), kind)));
            }
        }
        if let Some((_, rule)) = remapped.iter().enumerate().find(|(rule, _)| !names.used.contains(rule)) {
            let message = format!("`--remap`: no component has `{}`, or an earlier one is about it", rule.from);
            return Err(Error::refused(message, "names are those of the interface, in the component's namespace"));
        }
        Ok(Self { names, topics, services })
    }

    /// Joins their domain. The time is that of `/clock` if `use_sim_time` is set, or if the topic has a publisher now;
    /// otherwise, it is real time. `note` is called with what a user should know, then and later.
    ///
    /// # Errors
    /// If DDS fails.
    pub fn join(
        self,
        domain: network::Options,
        use_sim_time: bool,
        note: fn(&str),
    ) -> Result<Box<dyn RemoteComponents>, Error> {
        let wanted = self.topics.keys().cloned().chain([CLOCK.to_owned()]).collect();
        let mut node = Domain::nodes(domain, vec![NAME.to_owned()], true, wanted);
        node.prepare(self.services, self.topics);
        node.begin().map_err(|error| Error::refused(error.to_string(), error.help()))?;
        let publisher = node.publisher().ok_or_else(|| Error::refused("the domain has been left", "start it again"))?;
        let mut nodes = Nodes {
            time: Time::Steady(None),
            now: Duration::ZERO,
            node,
            publisher,
            names: self.names,
            run: RandomState::new().build_hasher().finish(),
            open: BTreeMap::new(),
            failures: 0,
            messages: Vec::new(),
            notes: Vec::new(),
            losses: Losses::default(),
            noted: BTreeSet::new(),
            node_notes: 0,
            node_losses: 0,
            body: Vec::new(),
            note,
        };
        let since = network::now();
        while since.elapsed() < SETTLING {
            nodes.poll(PATIENCE);
        }
        nodes.losses.begin_run();
        let has_clock = use_sim_time || nodes.node.robot().publishers.contains_key(CLOCK);
        if has_clock {
            nodes.time = Time::of_clock(use_sim_time);
        }
        let time = if has_clock { "that of /clock" } else { "real time" };
        note(&format!("the run is the node {NAME}, and its time is {time}: another run need not be the same"));
        Ok(Box::new(nodes))
    }
}

/// The names of topics and services: in the run, as the components' interfaces have them, and in the domain.
#[derive(Default)]
struct Names {
    /// The names in the domain, by those in the run.
    external: BTreeMap<String, String>,
    /// The names in the run, by those in the domain: components may share a topic.
    internal: BTreeMap<String, BTreeSet<String>>,
    /// The indices of the remappings that apply to any of them.
    used: BTreeSet<usize>,
}

impl Names {
    fn resolve(&mut self, name: String, remapped: &[Remapping]) -> String {
        let (external, rule) = resolve("", &name, remapped);
        self.used.extend(rule);
        self.internal.entry(external.clone()).or_default().insert(name.clone());
        self.external.insert(name, external.clone());
        external
    }
}

/// The nodes of ROS 2 that are components of a run.
struct Nodes {
    node: Domain,
    publisher: Publisher,
    names: Names,
    run: u64,
    time: Time,
    /// The time of the run.
    now: Duration,
    /// The requests without a response, by number, each with the time of the run when it was sent.
    open: BTreeMap<u64, (ServiceRequest, Duration)>,
    /// How often DDS had failed at the last step.
    failures: usize,
    /// The responses and messages since the last delivery.
    messages: Vec<NodeMessage>,
    /// The notes since the last delivery.
    notes: Vec<String>,
    losses: Losses,
    /// The notes that are not repeated.
    noted: BTreeSet<String>,
    /// How many of the node's notes and losses have been noted.
    node_notes: usize,
    node_losses: usize,
    /// The last message, whose memory is reused.
    body: Vec<u8>,
    /// Called with what a user should know.
    note: fn(&str),
}

impl RemoteComponents for Nodes {
    fn run(&self) -> u64 {
        self.run
    }

    fn receive(&mut self, now: Duration) -> Option<Delivery> {
        let begun = network::now();
        loop {
            let left = self.left(now);
            let is_idle = self.poll(left.min(PATIENCE));
            if is_idle && left.is_zero() {
                break;
            }
            if is_idle {
                let is_there = self.node.robot().publishers.contains_key(CLOCK);
                self.time.check_silence(is_there).into_iter().for_each(|what| self.note_once(what));
            }
            if begun.elapsed() >= PATIENCE {
                return None;
            }
        }
        self.now = now;
        self.handle_failures();
        let (notes, lost) = (self.node.notes(), self.node.lost());
        self.notes.extend(notes.iter().skip(self.node_notes).chain(lost.iter().skip(self.node_losses)).cloned());
        (self.node_notes, self.node_losses) = (notes.len(), lost.len());
        self.notes.iter().for_each(|what| (self.note)(what));
        let (losses, resumed) = self.losses.take();
        self.node.now_ns().into_iter().for_each(|at_ns| self.losses.end_step(now, at_ns));
        let (messages, notes) = (std::mem::take(&mut self.messages), std::mem::take(&mut self.notes));
        Some(Delivery { messages, losses, resumed, notes })
    }

    fn resume(&mut self) {
        let begun = network::now();
        // Reads what came during the pause, for a limited time: messages may come faster than they are read.
        while !self.poll(Duration::ZERO) && begun.elapsed() < SETTLING {}
        self.time.resume(self.now);
    }

    fn send(&mut self, requests: Vec<ServiceRequest>) {
        for request in requests {
            let now = self.now;
            self.open.entry(request.number).or_insert_with(|| (request.clone(), now));
            let ServiceRequest { service, kind, number, body } = request;
            let service = self.names.external[&service].clone();
            let servers = self.node.servers(&service);
            if servers.is_empty() {
                self.note_once(format!("no node offers the service {service} yet: requests wait for 10 s"));
            } else if let Some(other) = servers.iter().find(|server| **server != kind) {
                self.note_once(format!("a node offers the service {service} with another type, {other}, not {kind}"));
            } else if servers.len() > 1 {
                let count = servers.len();
                self.note_once(format!("{count} nodes offer the service {service}: the first response counts"));
            }
            self.publisher.request(Request { service, kind, number, body });
        }
    }

    fn leave(&mut self) {
        self.node.end();
    }
}

impl Nodes {
    /// How much time is left until `now` is due.
    fn left(&mut self, now: Duration) -> Duration {
        self.time.left(now).unwrap_or_else(|late| {
            self.note_once(late);
            Duration::ZERO
        })
    }

    fn note_once(&mut self, what: String) {
        if self.noted.insert(what.clone()) {
            self.notes.push(what);
        }
    }

    /// After DDS has failed, earlier requests get no responses: repeats those that are repeatable, and presumes the
    /// responses to the others.
    fn handle_failures(&mut self) {
        if std::mem::replace(&mut self.failures, self.node.failures()) == self.failures {
            return;
        }
        for (request, sent) in std::mem::take(&mut self.open).into_values() {
            let (what, service) = (Lost::Response(request.number), &self.names.external[&request.service]);
            if request.is_repeatable() {
                let why =
                    format!("the response of {service} may have been lost when DDS failed: the request is sent again");
                if self.noted.insert(why.clone()) {
                    (self.note)(&why);
                }
                self.losses.lose(what, Flaw::Missing, sent, why);
                self.open.insert(request.number, (request.clone(), sent));
                self.send(vec![request]);
            } else {
                let presumed = request.presumed();
                let is_lost = matches!(&presumed, NodeMessage::Response { body, .. } if body.is_empty());
                let counts = if is_lost { "failed" } else { "accepted" };
                let why = format!("the response of {service} was lost when DDS failed: the request counts as {counts}");
                (self.note)(&why);
                // The lost response may differ from the presumed one.
                self.losses.lose(what.clone(), Flaw::Mixed, sent, why);
                self.losses.resume(&what);
                self.messages.push(presumed);
            }
        }
    }

    /// Receives the next message within this time, and all responses. Returns whether there was nothing.
    fn poll(&mut self, patience: Duration) -> bool {
        self.node.patience = patience;
        let mut body = std::mem::take(&mut self.body);
        let received = self.node.receive(&mut body);
        if let Received::Message(head) = received {
            let name = self.node.survey().topics[head.topic].name.clone();
            if name == CLOCK {
                self.read_clock(&body);
            }
            for topic in self.names.internal.get(&name).into_iter().flatten().cloned() {
                self.losses.resume(&Lost::Topic(topic.clone()));
                NodeMessage::Message { topic, body: body.clone() }.enqueue_in(&mut self.messages);
            }
        }
        match received {
            Received::Lost { topic, since_ns, .. } => self.lose(topic, since_ns),
            Received::Resumed { topic, .. } => {
                let name = &self.node.survey().topics[topic].name;
                let internal = self.names.internal.get(name).into_iter().flatten();
                internal.for_each(|topic| self.losses.resume(&Lost::Topic(topic.clone())));
            }
            _ => {}
        }
        self.body = body;
        let mut is_idle = matches!(received, Received::Idle | Received::Over);
        while let Some(response) = self.node.response() {
            is_idle = false;
            if self.open.remove(&response.number).is_none() {
                self.note_once("a response came a second time, and is left out".to_owned());
            }
            self.losses.resume(&Lost::Response(response.number));
            self.messages.push(NodeMessage::Response { number: response.number, body: response.body });
        }
        is_idle
    }

    /// Records that messages on a topic were lost, after one received at this time, in nanoseconds since 1970.
    fn lose(&mut self, topic: usize, since_ns: i64) {
        let name = self.node.survey().topics[topic].name.clone();
        let Some(internal) = self.names.internal.get(&name) else {
            return self.note_once(format!("messages on {name} were lost on their way"));
        };
        let since = self.losses.step_before(since_ns);
        for topic in internal {
            let why = format!("messages on {name} were lost after {:.2} s", since.as_secs_f64());
            self.losses.lose(Lost::Topic(topic.clone()), Flaw::Missing, since, why);
        }
        let lost = format!("messages on {name} were lost on their way: verdicts that they could change are unsure");
        if self.noted.insert(lost.clone()) {
            (self.note)(&lost);
        }
    }

    fn read_clock(&mut self, body: &[u8]) {
        let Ok(Clock { clock }) = Clock::decode(body) else { return };
        let odd = self.time.receive_clock(clock.ns());
        odd.into_iter().for_each(|what| self.note_once(what));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_and_services_of_components_are_remapped() {
        let rule = |from: &str, to: &str| Remapping { from: from.to_owned(), to: to.to_owned() };
        let rules = [rule("/r1/go", "/base/drive"), rule("/pose", "/amcl_pose"), rule("/nothing", "/b")];
        let mut names = Names::default();
        let names_in_the_run = ["/r1/go/_action/send_goal", "/pose", "/amcl_pose", "/scan"];
        let external = names_in_the_run.map(|name| names.resolve(name.to_owned(), &rules));
        assert_eq!(external, ["/base/drive/_action/send_goal", "/amcl_pose", "/amcl_pose", "/scan"]);
        assert_eq!(names.external["/r1/go/_action/send_goal"], external[0]);
        // Both topics receive what is published there.
        assert_eq!(names.internal["/amcl_pose"], ["/amcl_pose", "/pose"].map(str::to_owned).into());
        assert_eq!(names.used, [0, 1].into());
    }
}
