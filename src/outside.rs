//! The components of a run that are nodes of ROS 2, in a DDS domain.

mod losses;
mod time;

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::time::Duration;

use bags::{Received, Remapping, Source as _, resolve};
use channels::Flaw;
use network::{Domain, Live as _, Request, Voice};
use remote::{Call, FromNode, Lost};
use ros_messages::CdrReader;
use runs::{Delivery, Outside};
use scenarios::Error;
use scenarios::scenario::{Runs, Scenario};

use crate::domain::DomainArgs;
use crate::interrupt;
use crate::moment::moment;
use crate::output::note;
use losses::Losses;
use time::{CLOCK, Time};

/// The node's name.
const NAME: &str = "/steward_run";

/// How long one look for messages takes at most.
const PATIENCE: Duration = Duration::from_millis(10);

/// How long publishers have to notice the node before the run begins.
const SETTLING: Duration = Duration::from_millis(700);

/// Joins the domain of a scenario's components. The time is that of `/clock` if somebody publishes it, or is to.
pub(crate) fn join(
    domain: &DomainArgs,
    use_sim_time: bool,
    remapped: &[Remapping],
    scenario: &Scenario,
) -> Result<Box<dyn Outside>, Error> {
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
    let wanted = topics.keys().cloned().chain([CLOCK.to_owned()]).collect();
    let mut node = Domain::nodes(domain.options()?, vec![NAME.to_owned()], true, wanted);
    node.ask(services, topics);
    let refused = |error: network::Error| Error::refused(error.to_string(), error.help());
    node.begin().map_err(refused)?;
    let voice = node.voice().ok_or_else(|| Error::refused("the domain has been left", "start it again"))?;
    let mut nodes = Nodes {
        time: Time::Steady(None),
        now: Duration::ZERO,
        node,
        voice,
        names,
        run: RandomState::new().build_hasher().finish(),
        open: BTreeMap::new(),
        failures: 0,
        answers: Vec::new(),
        happened: Vec::new(),
        losses: Losses::default(),
        told: BTreeSet::new(),
        notes: 0,
        lost: 0,
        body: Vec::new(),
    };
    let since = moment();
    while since.elapsed() < SETTLING && interrupt::flow().is_continue() {
        nodes.receive(PATIENCE);
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

/// What topics and services are called outside.
#[derive(Default)]
struct Names {
    /// By what components call them, and the other way round: one topic may be that of several.
    outside: BTreeMap<String, String>,
    inside: BTreeMap<String, BTreeSet<String>>,
    /// The remappings that are about any of them.
    used: BTreeSet<usize>,
}

impl Names {
    fn resolve(&mut self, name: String, remapped: &[Remapping]) -> String {
        let (outside, rule) = resolve("", &name, remapped);
        self.used.extend(rule);
        self.inside.entry(outside.clone()).or_default().insert(name.clone());
        self.outside.insert(name, outside.clone());
        outside
    }
}

struct Nodes {
    node: Domain,
    voice: Voice,
    names: Names,
    run: u64,
    time: Time,
    /// How far the run is.
    now: Duration,
    /// What has not been answered, by number, with the time of the run when it was asked; and how often DDS had failed
    /// then.
    open: BTreeMap<u64, (Call, Duration)>,
    failures: usize,
    /// What has come, and what has happened, since it was last told.
    answers: Vec<FromNode>,
    happened: Vec<String>,
    losses: Losses,
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

    fn hear(&mut self, now: Duration) -> Option<Delivery> {
        let asked = moment();
        loop {
            let left = self.left(now);
            let is_idle = self.receive(left.min(PATIENCE));
            if is_idle && left.is_zero() {
                break;
            }
            if is_idle {
                let is_there = self.node.robot().publishers.contains_key(CLOCK);
                self.time.mind_silence(is_there).into_iter().for_each(|what| self.tell_once(what));
            }
            if asked.elapsed() >= PATIENCE {
                return None;
            }
        }
        self.now = now;
        self.mind_failures();
        let (notes, lost) = (self.node.notes(), self.node.lost());
        self.happened.extend(notes.iter().skip(self.notes).chain(lost.iter().skip(self.lost)).cloned());
        (self.notes, self.lost) = (notes.len(), lost.len());
        self.happened.iter().for_each(|what| note(what));
        let (losses, resumed) = self.losses.take();
        self.node.now_ns().into_iter().for_each(|at_ns| self.losses.end_step(now, at_ns));
        let (answers, happened) = (std::mem::take(&mut self.answers), std::mem::take(&mut self.happened));
        Some(Delivery { answers, losses, resumed, happened })
    }

    fn resume(&mut self) {
        let asked = moment();
        // What the clock has said meanwhile is of the pause. So long as it comes faster than it can be read, it counts.
        while !self.receive(Duration::ZERO) && asked.elapsed() < SETTLING {}
        self.time.resume(self.now);
    }

    fn ask(&mut self, calls: Vec<Call>) {
        for call in calls {
            let now = self.now;
            self.open.entry(call.number).or_insert_with(|| (call.clone(), now));
            let Call { service, kind, number, body } = call;
            let service = self.names.outside[&service].clone();
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
    /// How much time is left until `now` is due.
    fn left(&mut self, now: Duration) -> Duration {
        self.time.left(now).unwrap_or_else(|late| {
            self.tell_once(late);
            Duration::ZERO
        })
    }

    fn tell_once(&mut self, what: String) {
        if self.told.insert(what.clone()) {
            self.happened.push(what);
        }
    }

    /// After DDS has failed, nobody responds to what was asked before.
    fn mind_failures(&mut self) {
        if std::mem::replace(&mut self.failures, self.node.failures()) == self.failures {
            return;
        }
        for (call, asked) in std::mem::take(&mut self.open).into_values() {
            let (what, service) = (Lost::Response(call.number), &self.names.outside[&call.service]);
            if call.is_repeatable() {
                let why = format!("the response of {service} may have been lost when DDS failed: it is asked again");
                if self.told.insert(why.clone()) {
                    note(&why);
                }
                self.losses.lose(what, Flaw::Missing, asked, why);
                self.open.insert(call.number, (call.clone(), asked));
                self.ask(vec![call]);
            } else {
                let presumed = call.presumed();
                let is_lost = matches!(&presumed, FromNode::Response { body, .. } if body.is_empty());
                let counts = if is_lost { "failed" } else { "accepted" };
                let why =
                    format!("the response of {service} was lost when DDS failed: what was asked counts as {counts}");
                note(&why);
                // It may have been another one than what is presumed.
                self.losses.lose(what.clone(), Flaw::Mixed, asked, why);
                self.losses.resume(&what);
                self.answers.push(presumed);
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
            for topic in self.names.inside.get(&name).into_iter().flatten().cloned() {
                self.losses.resume(&Lost::Topic(topic.clone()));
                FromNode::Message { topic, body: body.clone() }.wait_in(&mut self.answers);
            }
        }
        match received {
            Received::Lost { topic, since_ns, .. } => self.lose(topic, since_ns),
            Received::Resumed { topic, .. } => {
                let name = &self.node.survey().topics[topic].name;
                let inside = self.names.inside.get(name).into_iter().flatten();
                inside.for_each(|topic| self.losses.resume(&Lost::Topic(topic.clone())));
            }
            _ => {}
        }
        self.body = body;
        let mut is_idle = matches!(received, Received::Idle | Received::Over);
        while let Some(response) = self.node.response() {
            is_idle = false;
            if self.open.remove(&response.number).is_none() {
                self.tell_once("a response came a second time, and is left out".to_owned());
            }
            self.losses.resume(&Lost::Response(response.number));
            self.answers.push(FromNode::Response { number: response.number, body: response.body });
        }
        is_idle
    }

    /// Messages on a topic were lost, after one that came at a time, in nanoseconds since 1970.
    fn lose(&mut self, topic: usize, since_ns: i64) {
        let name = self.node.survey().topics[topic].name.clone();
        let Some(inside) = self.names.inside.get(&name) else {
            return self.tell_once(format!("messages on {name} were lost on their way"));
        };
        let since = self.losses.step_before(since_ns);
        for topic in inside {
            let why = format!("messages on {name} were lost after {:.2} s", since.as_secs_f64());
            self.losses.lose(Lost::Topic(topic.clone()), Flaw::Missing, since, why);
        }
        let lost = format!("messages on {name} were lost on their way: verdicts that they could change are unsure");
        if self.told.insert(lost.clone()) {
            note(&lost);
        }
    }

    /// A message of the clock: seconds and nanoseconds.
    fn take_time(&mut self, body: &[u8]) {
        let read = CdrReader::new(body).and_then(|mut reader| Ok((reader.number()?, reader.number()?)));
        let Ok((seconds, nanoseconds)) = read else { return };
        let (seconds, nanoseconds) = (i32::from_le_bytes(seconds), u32::from_le_bytes(nanoseconds));
        let odd = self.time.hear(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds));
        odd.into_iter().for_each(|what| self.tell_once(what));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_components_ask_and_hear_has_other_names_outside() {
        let rule = |from: &str, to: &str| Remapping { from: from.to_owned(), to: to.to_owned() };
        let rules = [rule("/r1/go", "/base/drive"), rule("/pose", "/amcl_pose"), rule("/nothing", "/b")];
        let mut names = Names::default();
        let told = ["/r1/go/_action/send_goal", "/pose", "/amcl_pose", "/scan"];
        let outside = told.map(|name| names.resolve(name.to_owned(), &rules));
        assert_eq!(outside, ["/base/drive/_action/send_goal", "/amcl_pose", "/amcl_pose", "/scan"]);
        assert_eq!(names.outside["/r1/go/_action/send_goal"], outside[0]);
        // Both hear what is published there.
        assert_eq!(names.inside["/amcl_pose"], ["/amcl_pose", "/pose"].map(str::to_owned).into());
        assert_eq!(names.used, [0, 1].into());
    }
}
