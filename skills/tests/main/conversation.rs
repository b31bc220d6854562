//! A skill and a scripted partner at each of its channels.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, Domain, Envelope, FieldKind, Message, Offer, Process, RequestNumber, Role, Shape, Topology, Value,
};
use skills::{Chart, Datum, SHIPPED, SkillError, SkillProcess, shipped};

fn symbols<const N: usize>(names: [&str; N]) -> FieldKind {
    FieldKind::symbols(names)
}

fn replies(field: &str, kind: FieldKind) -> Domain {
    let ok = Shape::new([("status", symbols(["ok"])), (field, kind)]);
    let error = Shape::new([("status", symbols(["error"])), ("reason", FieldKind::Text)]);
    Domain::new([ok, error]).in_role(Role::Reply)
}

/// The processes and channels of the shipped system.
pub(crate) fn topology() -> Topology {
    let places = || symbols(["RechargingStation", "Destination"]);
    let simple = |request| Domain::new([Shape::new([("request", symbols([request]))])]);
    let placed = |requests| Domain::new([Shape::new([("request", requests), ("place", places())])]);
    let states = symbols(["running", "success", "failure", "stopped", "idle"]);
    let trips = || placed(symbols(["start_navigation", "get_status", "stop_navigation"]));
    let services = [
        ("BatteryLevel", "BatteryReader", simple("get_level"), replies("level", FieldKind::Real)),
        ("BatteryNotCharging", "BatteryReader", simple("get_charging"), replies("charging", FieldKind::Bool)),
        ("AtRechargingStation", "Localization", placed(symbols(["is_at"])), replies("at", FieldKind::Bool)),
        ("AtDestination", "Localization", placed(symbols(["is_at"])), replies("at", FieldKind::Bool)),
        ("GotoRechargingStation", "Navigation", trips(), replies("state", states.clone())),
        ("GoToDestination", "Navigation", trips(), replies("state", states)),
    ];
    let mut topology = Topology::default();
    let tree = topology.process("BT").unwrap();
    for (leaf, _) in SHIPPED {
        let skill = topology.process(leaf).unwrap();
        let call = Domain::new([Shape::new([("call", symbols(["tick", "halt"]))])]);
        let result = Shape::new([("result", symbols(["running", "success", "failure", "halted"]))]);
        let result = Domain::new([result]).in_role(Role::Reply);
        topology.channel(tree, skill, Capacity::One, call).unwrap();
        topology.channel(skill, tree, Capacity::One, result).unwrap();
    }
    for (skill, component, request, reply) in services {
        let skill = topology.find_process(skill).unwrap();
        let component = topology.find_process(component).unwrap_or_else(|| topology.process(component).unwrap());
        topology.channel(skill, component, Capacity::One, request).unwrap();
        topology.channel(component, skill, Capacity::One, reply).unwrap();
    }
    topology
}

/// The same, followed by those of the Blackboard in the published system.
pub(crate) fn topology_with_blackboard() -> Topology {
    let entry = |request| [("request", request), ("skill", FieldKind::Text), ("key", symbols(["navigation"]))];
    let [request, skill, key] = entry(symbols(["write_data"]));
    let write = Shape::new([request, skill, key, ("value", FieldKind::Int)]);
    let board = Domain::new([Shape::new(entry(symbols(["lock", "unlock", "read_data"]))), write]);
    let ok = |field, kind| Shape::new([("status", symbols(["ok"])), (field, kind)]);
    let answers = Domain::new([ok("done", FieldKind::Bool), ok("value", FieldKind::Int)]).in_role(Role::Reply);
    let mut topology = topology();
    let blackboard = topology.process("Blackboard").unwrap();
    for skill in ["GotoRechargingStation", "GoToDestination"] {
        let skill = topology.find_process(skill).unwrap();
        topology.channel(skill, blackboard, Capacity::One, board.clone()).unwrap();
        topology.channel(blackboard, skill, Capacity::One, answers.clone()).unwrap();
    }
    topology
}

pub(crate) fn chart(leaf: &str) -> Arc<Chart> {
    let text = shipped(leaf).unwrap();
    Chart::load(&format!("{leaf}.scxml"), text).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

pub(crate) fn skill(leaf: &str, parameters: &[(&str, Datum)]) -> Result<SkillProcess, SkillError> {
    SkillProcess::new(leaf, &chart(leaf), &topology(), parameters.iter().cloned())
}

/// `[<ok>, value]`
pub(crate) fn ok(value: impl Into<Value>) -> Message {
    Message::new([Value::symbol("ok"), value.into()])
}

/// `[<ok>, <state>]`
pub(crate) fn ok_state(state: &str) -> Message {
    Message::symbols(["ok", state])
}

pub(crate) fn error(reason: &str) -> Message {
    Message::new([Value::symbol("error"), reason.into()])
}

#[derive(Clone)]
pub(crate) struct Conversation {
    pub(crate) process: SkillProcess,
    topology: Topology,
    now: Duration,
    calls: u64,
    /// The number of the last request, by component.
    asked: BTreeMap<String, RequestNumber>,
}

impl Conversation {
    pub(crate) fn with(leaf: &str) -> Self {
        Self::with_parameters(leaf, &[])
    }

    pub(crate) fn with_parameters(leaf: &str, parameters: &[(&str, Datum)]) -> Self {
        Self::of(skill(leaf, parameters).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error))))
    }

    pub(crate) fn of(process: SkillProcess) -> Self {
        // The parts that both topologies share have the same numbers.
        Self { process, topology: topology_with_blackboard(), now: Duration::ZERO, calls: 100, asked: BTreeMap::new() }
    }

    /// Sends the skill a message.
    pub(crate) fn deliver(&mut self, from: &str, message: Message, request: RequestNumber) {
        let mut offers = Vec::new();
        self.process.offers(&mut offers);
        let from_there = |offer: &&Offer| match &offer.action {
            Action::Receive(channel, _) => self.topology.ends(*channel).0 == from,
            _ => false,
        };
        let transition = offers.iter().find(from_there).expect("a skill always receives").transition;
        self.process.take(transition, Some(Envelope { message, request }), self.now);
    }

    fn call(&mut self, what: &str) -> Vec<String> {
        self.calls += 1;
        self.deliver("BT", Message::symbols([what]), RequestNumber(self.calls));
        self.sent()
    }

    pub(crate) fn tick(&mut self) -> Vec<String> {
        self.call("tick")
    }

    pub(crate) fn halt(&mut self) -> Vec<String> {
        self.call("halt")
    }

    /// Answers the last request to a component.
    pub(crate) fn reply(&mut self, from: &str, message: Message) -> Vec<String> {
        let request = self.last_request(from);
        self.deliver(from, message, request);
        self.sent()
    }

    pub(crate) fn last_request(&self, to: &str) -> RequestNumber {
        self.asked[to]
    }

    /// Advances the time of the run to this many milliseconds.
    pub(crate) fn at_ms(&mut self, now: u64) -> Vec<String> {
        self.now = Duration::from_millis(now);
        if self.process.next_timer().is_some_and(|due| due <= self.now) {
            self.process.fire_timers(self.now);
        }
        self.sent()
    }

    /// Takes the messages that the skill wants to send: `Navigation [<get_status>, <Destination>]`. Answers to the tree
    /// must carry the number of its last call.
    pub(crate) fn sent(&mut self) -> Vec<String> {
        let mut sent = Vec::new();
        loop {
            let mut offers = Vec::new();
            self.process.offers(&mut offers);
            let sends = offers.into_iter().find_map(|offer| match offer.action {
                Action::Send(channel, envelope) => Some((offer.transition, channel, envelope)),
                _ => None,
            });
            let Some((transition, channel, envelope)) = sends else {
                return sent;
            };
            let (_, peer) = self.topology.ends(channel);
            assert!(self.topology.carries(channel, &envelope.message), "{}", envelope.message);
            if peer == "BT" {
                assert_eq!(envelope.request, RequestNumber(self.calls), "the answer echoes the call's number");
            } else {
                self.asked.insert(peer.to_owned(), envelope.request);
            }
            sent.push(format!("{peer} {}", envelope.message));
            self.process.take(transition, None, self.now);
        }
    }

    pub(crate) fn location(&self) -> String {
        self.process.location()
    }
}

#[test]
fn a_successor_of_a_skill_starts_at_that_time_and_continues_its_numbers() {
    let mut talk = Conversation::with("GoToDestination");
    assert_eq!(talk.at_ms(3_000), [""; 0]);
    assert_eq!(talk.tick(), ["Navigation [<start_navigation>, <Destination>]"]);
    let asked = talk.last_request("Navigation");
    let fresh = skill("GoToDestination", &[("timeout", "2s".into())]).unwrap();
    talk.process = fresh.succeeding(&talk.process, Duration::from_secs(3));
    assert_eq!((talk.location().as_str(), talk.process.next_timer()), ("idle", None));
    assert_eq!(talk.tick(), ["Navigation [<start_navigation>, <Destination>]"]);
    assert!(talk.last_request("Navigation") > asked, "two requests with the same number");
    assert_eq!(talk.process.next_timer(), Some(Duration::from_secs(5)), "the parameters are those of the successor");
    // Nobody expects the answer for which the predecessor was waiting.
    talk.deliver("Navigation", ok_state("success"), asked);
    assert_eq!(talk.sent(), [""; 0]);
    assert_eq!(talk.reply("Navigation", ok_state("running")), ["BT [<running>]"]);
}

#[test]
fn a_delay_counts_from_the_start_of_the_machine() {
    let late = "<state id=\"idle\"><onentry><send event=\"late\" delay=\"10s\"/></onentry>\
                <transition event=\"late\" target=\"failure\"/></state>";
    let text = shipped("AtDestination").unwrap().replace("<state id=\"idle\"/>", late);
    let chart = Chart::load("Late.scxml", &text).unwrap();
    let first = SkillProcess::new("AtDestination", &chart, &topology(), []).unwrap();
    let second = first.succeeding(&first, Duration::from_secs(30));
    assert_eq!(first.next_timer(), Some(Duration::from_secs(10)));
    assert_eq!(second.next_timer(), Some(Duration::from_secs(40)), "not overdue from the start");
}
