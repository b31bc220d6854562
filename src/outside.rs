//! The components of a run that are nodes of ROS 2, in a DDS domain.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::time::{Duration, Instant};

use bags::{Received, Source as _};
use campaigns::Error;
use network::{Domain, Live as _, Request, Voice};
use remote::{Call, FromNode, RemoteComponent};
use ros_messages::CdrReader;
use runs::Outside;
use scenarios::scenario::{Runs, Scenario};

use crate::domain::DomainArgs;
use crate::interrupt;
use crate::moment::moment;
use crate::output::note;

/// The node's name, and the topic of simulated time.
const NAME: &str = "/steward_run";
const CLOCK: &str = "/clock";

/// How long one look for messages takes at most.
const PATIENCE: Duration = Duration::from_millis(10);

/// How long publishers have to notice the node before the run begins.
const SETTLING: Duration = Duration::from_millis(700);

/// How long a clock may say nothing before time goes on without it.
const SILENT: Duration = Duration::from_secs(10);

/// How far a run may fall behind before it gives that up.
const BEHIND: Duration = Duration::from_millis(200);

/// Joins the domain of a scenario's components.
pub(crate) fn join(domain: &DomainArgs, scenario: &Scenario) -> Result<Box<dyn Outside>, Error> {
    let remote = |runs: &Runs| if let Runs::Remote(component) = runs { Some(component.clone()) } else { None };
    let components: Vec<_> = scenario.components.values().filter_map(|component| remote(&component.runs)).collect();
    let all = |names: fn(&RemoteComponent) -> BTreeMap<String, String>| {
        components.iter().flat_map(|component| names(component)).collect::<BTreeMap<String, String>>()
    };
    let topics = all(|component| component.topics().collect());
    let services = all(|component| component.services().collect());
    let wanted = topics.keys().cloned().chain([CLOCK.to_owned()]).collect();
    let mut node = Domain::node(domain.options()?, NAME.to_owned(), true, wanted);
    node.ask(services);
    let refused = |error: network::Error| Error::refused(error.to_string(), error.help());
    node.begin().map_err(refused)?;
    let voice = node.voice().ok_or_else(|| Error::refused("the domain has been left", "start it again"))?;
    let mut nodes = Nodes {
        time: Time::Steady(None),
        node,
        voice,
        topics,
        run: RandomState::new().build_hasher().finish(),
        answers: Vec::new(),
        happened: Vec::new(),
        told: BTreeSet::new(),
        notes: 0,
        lost: 0,
        body: Vec::new(),
    };
    let since = moment();
    while since.elapsed() < SETTLING && interrupt::flow().is_continue() {
        nodes.receive(PATIENCE);
    }
    let has_clock = nodes.node.robot().publishers.contains_key(CLOCK);
    if has_clock {
        nodes.time = Time::Clock { begun_ns: None, now_ns: 0, heard: moment() };
    }
    let time = if has_clock { "that of /clock" } else { "real time" };
    note(&format!("the run is the node {NAME}, and its time is {time}: another run need not be the same"));
    Ok(Box::new(nodes))
}

/// What says how late it is.
#[derive(Debug)]
enum Time {
    /// Since the start of the run, real time; later than at first if it has fallen behind.
    Steady(Option<Instant>),
    /// The clock of a simulation: when the run began, and what it said last.
    Clock { begun_ns: Option<i64>, now_ns: i64, heard: Instant },
}

struct Nodes {
    node: Domain,
    voice: Voice,
    /// The topics that components publish, with their types.
    topics: BTreeMap<String, String>,
    run: u64,
    time: Time,
    /// What has come, and what has happened, since it was last told.
    answers: Vec<FromNode>,
    happened: Vec<String>,
    /// What is not told again, and how much of what the node tells has been.
    told: BTreeSet<String>,
    notes: usize,
    lost: usize,
    /// The last message.
    body: Vec<u8>,
}

impl Outside for Nodes {
    fn run(&self) -> u64 {
        self.run
    }

    fn hear(&mut self, now: Duration) -> (Vec<FromNode>, Vec<String>) {
        while interrupt::flow().is_continue() {
            let left = self.left(now);
            let is_idle = self.receive(left.min(PATIENCE));
            if left.is_zero() && is_idle {
                break;
            }
        }
        let (notes, lost) = (self.node.notes(), self.node.lost());
        self.happened.extend(notes.iter().skip(self.notes).chain(lost.iter().skip(self.lost)).cloned());
        (self.notes, self.lost) = (notes.len(), lost.len());
        self.happened.iter().for_each(|what| note(what));
        (std::mem::take(&mut self.answers), std::mem::take(&mut self.happened))
    }

    fn ask(&mut self, calls: Vec<Call>) {
        for Call { service, kind, number, body } in calls {
            let servers = self.node.servers(&service);
            if servers.is_empty() {
                self.tell_once(format!("nobody offers the service {service} yet: requests wait"));
            } else if let Some(other) = servers.iter().find(|server| **server != kind) {
                self.tell_once(format!("somebody offers the service {service} with another type, {other}, not {kind}"));
            } else if servers.len() > 1 {
                let count = servers.len();
                self.tell_once(format!("{count} nodes offer the service {service}: the first response counts"));
            }
            self.voice.request(Request { service, kind, number, body });
        }
    }
}

impl Nodes {
    fn tell_once(&mut self, what: String) {
        if self.told.insert(what.clone()) {
            self.happened.push(what);
        }
    }

    /// How much time is left until `now` is due.
    fn left(&mut self, now: Duration) -> Duration {
        match &mut self.time {
            Time::Steady(begun) => {
                let begun = begun.get_or_insert_with(|| moment().checked_sub(now).unwrap_or_else(moment));
                let elapsed = begun.elapsed();
                if elapsed > now.saturating_add(BEHIND) {
                    // What was missed is not made up for: nobody could react.
                    *begun += elapsed.saturating_sub(now);
                    self.tell_once("the run is slower than real time: time passes as it can".to_owned());
                }
                now.saturating_sub(elapsed)
            }
            Time::Clock { begun_ns, now_ns, heard } => {
                let passed_ns = begun_ns.map_or(0, |begun_ns| now_ns.saturating_sub(begun_ns));
                if begun_ns.is_some() && passed_ns >= i64::try_from(now.as_nanos()).unwrap_or(i64::MAX) {
                    return Duration::ZERO;
                }
                if heard.elapsed() > SILENT {
                    self.time = Time::Steady(None);
                    let seconds = SILENT.as_secs();
                    self.tell_once(format!(
                        "{CLOCK} has said nothing for {seconds} s: from here on, time is real time"
                    ));
                }
                PATIENCE
            }
        }
    }

    /// Takes what comes next within this time. Returns whether nothing has come.
    fn receive(&mut self, patience: Duration) -> bool {
        self.node.patience = patience;
        let mut body = std::mem::take(&mut self.body);
        let received = self.node.receive(&mut body);
        if let Received::Message(head) = received {
            let topic = &self.node.survey().topics[head.topic];
            let (name, kind) = (topic.name.clone(), topic.kind.clone());
            if name == CLOCK {
                self.take_time(&body);
            }
            match self.topics.get(&name) {
                Some(known) if *known == kind => {
                    self.answers.push(FromNode::Message { topic: name, body: body.clone() });
                }
                Some(known) => {
                    self.tell_once(format!(
                        "messages on {name} are of another type, {kind}, not {known}, and left out"
                    ));
                }
                None => {}
            }
        }
        self.body = body;
        let mut is_idle = matches!(received, Received::Idle | Received::Over | Received::Quiet(_));
        while let Some(response) = self.node.response() {
            is_idle = false;
            self.answers.push(FromNode::Response { number: response.number, body: response.body });
        }
        is_idle
    }

    /// A message of the clock: seconds and nanoseconds.
    fn take_time(&mut self, body: &[u8]) {
        let Time::Clock { begun_ns, now_ns, heard } = &mut self.time else { return };
        let read = CdrReader::new(body).and_then(|mut reader| Ok((reader.number()?, reader.number()?)));
        let Ok((seconds, nanoseconds)) = read else { return };
        let (seconds, nanoseconds) = (i32::from_le_bytes(seconds), u32::from_le_bytes(nanoseconds));
        let said_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
        let begun_ns = begun_ns.get_or_insert(said_ns);
        if said_ns < *now_ns {
            // The simulation has begun anew: the time of the run goes on from where it was.
            *begun_ns = said_ns.saturating_sub(now_ns.saturating_sub(*begun_ns));
            self.happened.push(format!("{CLOCK} went back"));
        }
        (*now_ns, *heard) = (said_ns, moment());
    }
}
