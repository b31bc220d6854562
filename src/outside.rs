//! The components of a run that are nodes of ROS 2, in a DDS domain.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::time::{Duration, Instant};

use bags::{Received, Source as _};
use campaigns::Error;
use network::{Domain, Live as _, Request, Voice};
use remote::{Call, FromNode};
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

/// How far a run may fall behind before it gives that up: in real time, and in that of a clock, in nanoseconds.
const BEHIND: Duration = Duration::from_millis(200);
const LATE_NS: i64 = 2_000_000_000;

/// Joins the domain of a scenario's components. The time is that of `/clock` if somebody publishes it, or is to.
pub(crate) fn join(domain: &DomainArgs, use_sim_time: bool, scenario: &Scenario) -> Result<Box<dyn Outside>, Error> {
    let (mut topics, mut services) = (BTreeMap::new(), BTreeMap::new());
    for component in scenario.components.values() {
        if let Runs::Remote(component) = &component.runs {
            topics.extend(component.topics());
            services.extend(component.services());
        }
    }
    let wanted = topics.keys().cloned().chain([CLOCK.to_owned()]).collect();
    let mut node = Domain::nodes(domain.options()?, vec![NAME.to_owned()], true, wanted);
    node.ask(services, topics.clone());
    let refused = |error: network::Error| Error::refused(error.to_string(), error.help());
    node.begin().map_err(refused)?;
    let voice = node.voice().ok_or_else(|| Error::refused("the domain has been left", "start it again"))?;
    let mut nodes = Nodes {
        time: Time::Steady(None),
        node,
        voice,
        topics,
        run: RandomState::new().build_hasher().finish(),
        open: BTreeMap::new(),
        failures: 0,
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
    let has_clock = use_sim_time || nodes.node.robot().publishers.contains_key(CLOCK);
    if has_clock {
        nodes.time = Time::Clock { begun_ns: None, now_ns: 0, heard: moment(), may_pause: use_sim_time };
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
    /// The clock of a simulation: when the run began, what it said last, and when; and whether it may stand still while
    /// somebody publishes it, and come later.
    Clock { begun_ns: Option<i64>, now_ns: i64, heard: Instant, may_pause: bool },
}

struct Nodes {
    node: Domain,
    voice: Voice,
    /// The topics that components publish, with their types.
    topics: BTreeMap<String, String>,
    run: u64,
    time: Time,
    /// What has not been answered, by number, and how often DDS had failed then.
    open: BTreeMap<u64, Call>,
    failures: usize,
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
            if self.receive(left.min(PATIENCE)) {
                if left.is_zero() {
                    break;
                }
                self.mind_silence();
            }
        }
        self.mind_failures();
        let (notes, lost) = (self.node.notes(), self.node.lost());
        self.happened.extend(notes.iter().skip(self.notes).chain(lost.iter().skip(self.lost)).cloned());
        (self.notes, self.lost) = (notes.len(), lost.len());
        self.happened.iter().for_each(|what| note(what));
        (std::mem::take(&mut self.answers), std::mem::take(&mut self.happened))
    }

    fn ask(&mut self, calls: Vec<Call>) {
        for call in calls {
            self.open.insert(call.number, call.clone());
            let Call { service, kind, number, body } = call;
            let servers = self.node.servers(&service);
            if servers.is_empty() {
                self.tell_once(format!("nobody offers the service {service} yet: requests wait for 10 s"));
            } else if let Some(other) = servers.iter().find(|server| **server != kind) {
                self.tell_once(format!("somebody offers the service {service} with another type, {other}, not {kind}"));
            } else if servers.len() > 1 {
                let count = servers.len();
                self.tell_once(format!("{count} nodes offer the service {service}: the first response counts"));
            }
            self.voice.request(Request { service, kind, number, body });
        }
    }

    fn leave(&mut self) {
        self.node.end();
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
        let late = match &mut self.time {
            Time::Steady(begun) => {
                let begun = begun.get_or_insert_with(|| moment().checked_sub(now).unwrap_or_else(moment));
                let elapsed = begun.elapsed();
                if elapsed <= now.saturating_add(BEHIND) {
                    return now.saturating_sub(elapsed);
                }
                // What was missed is not made up for: nobody could react.
                *begun += elapsed.saturating_sub(now);
                "the run is slower than real time: time passes as it can".to_owned()
            }
            Time::Clock { begun_ns: None, .. } => return PATIENCE,
            Time::Clock { begun_ns: Some(begun_ns), now_ns, .. } => {
                let passed_ns = i64::try_from(now.as_nanos()).unwrap_or(i64::MAX);
                let late_ns = now_ns.saturating_sub(*begun_ns).saturating_sub(passed_ns);
                if late_ns <= LATE_NS {
                    return if late_ns < 0 { PATIENCE } else { Duration::ZERO };
                }
                *begun_ns = begun_ns.saturating_add(late_ns);
                format!("the run is slower than {CLOCK}, or that has jumped: time passes as it can")
            }
        };
        self.tell_once(late);
        Duration::ZERO
    }

    /// Goes on without a clock that has fallen silent.
    fn mind_silence(&mut self) {
        let Time::Clock { begun_ns, heard, may_pause, .. } = self.time else { return };
        let is_there = self.node.robot().publishers.contains_key(CLOCK);
        if heard.elapsed() > SILENT && !(may_pause && (is_there || begun_ns.is_none())) {
            self.time = Time::Steady(None);
            let seconds = SILENT.as_secs();
            self.tell_once(format!("{CLOCK} has said nothing for {seconds} s: from here on, time is real time"));
        }
    }

    /// After DDS has failed, nobody responds to what was asked before. Results can be asked for again.
    fn mind_failures(&mut self) {
        if std::mem::replace(&mut self.failures, self.node.failures()) == self.failures {
            return;
        }
        for call in std::mem::take(&mut self.open).into_values() {
            if call.asks_for_result() {
                self.ask(vec![call]);
            } else {
                self.answers.push(FromNode::Response { number: call.number, body: Vec::new() });
            }
        }
    }

    /// Takes what comes next within this time. Returns whether nothing has come.
    fn receive(&mut self, patience: Duration) -> bool {
        self.node.patience = patience;
        let mut body = std::mem::take(&mut self.body);
        let received = self.node.receive(&mut body);
        if let Received::Message(head) = received {
            let name = self.node.survey().topics[head.topic].name.clone();
            if name == CLOCK {
                self.take_time(&body);
            }
            if self.topics.contains_key(&name) {
                FromNode::Message { topic: name, body: body.clone() }.wait_in(&mut self.answers);
            }
        }
        self.body = body;
        let mut is_idle = matches!(received, Received::Idle | Received::Over | Received::Quiet(_));
        while let Some(response) = self.node.response() {
            is_idle = false;
            if self.open.remove(&response.number).is_none() {
                self.tell_once("a response came a second time, and is left out".to_owned());
            }
            self.answers.push(FromNode::Response { number: response.number, body: response.body });
        }
        is_idle
    }

    /// A message of the clock: seconds and nanoseconds.
    fn take_time(&mut self, body: &[u8]) {
        let read = CdrReader::new(body).and_then(|mut reader| Ok((reader.number()?, reader.number()?)));
        let Ok((seconds, nanoseconds)) = read else { return };
        let (seconds, nanoseconds) = (i32::from_le_bytes(seconds), u32::from_le_bytes(nanoseconds));
        let said_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
        let Time::Clock { begun_ns, now_ns, heard, .. } = &mut self.time else { return };
        *heard = moment();
        let before_ns = std::mem::replace(now_ns, said_ns);
        let begun_ns = begun_ns.get_or_insert(said_ns);
        if said_ns < before_ns {
            *begun_ns = said_ns.saturating_sub(before_ns.saturating_sub(*begun_ns));
            self.tell_once(format!("{CLOCK} went back, or is published twice: the time of the run goes on"));
        }
    }
}
