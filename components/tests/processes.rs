//! How components answer: each request once, with its number, when the answer is known.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::Duration;

use channels::{
    Action, Capacity, Domain, Envelope, Message, Offer, Process, ProcessId, RequestNumber, Symbol, Topology, Value,
};
use components::{
    BLACKBOARD, BatteryReader, Blackboard, LOCALIZATION, Localization, NAVIGATION, Navigation, Order, StopRule,
    operations,
};
use maps::{Place, Places, Point};

fn places() -> Places {
    let mut places = Places::default();
    for name in ["Destination", "RechargingStation"] {
        let corners = vec![Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(0.0, 1.0)];
        places.insert(name, Place::Area { corners });
    }
    places
}

/// A component with clients; the channels carry every message that the component understands.
fn wire(component: &str, clients: &[&str]) -> (Topology, ProcessId) {
    let mut topology = Topology::default();
    let id = topology.process(component).unwrap();
    let operations = operations(&places());
    let own: Vec<_> = operations.iter().filter(|operation| operation.component == component).collect();
    for client in clients {
        let client = topology.process(client).unwrap();
        let requests = Domain::new(own.iter().map(|operation| operation.request.clone()));
        let replies = Domain::new(own.iter().flat_map(|operation| operation.replies.clone()));
        topology.channel(client, id, Capacity::One, requests).unwrap();
        topology.channel(id, client, Capacity::One, replies).unwrap();
    }
    (topology, id)
}

fn offers(process: &dyn Process) -> Vec<Offer> {
    let mut offers = Vec::new();
    process.offers(&mut offers);
    offers
}

/// Gives the component a request from this client; panics if it does not receive one.
fn ask(process: &mut dyn Process, topology: &Topology, client: &str, request: Message, number: u64) {
    let taking = offers(process).into_iter().find(|offer| match offer.action {
        Action::Receive(channel, _) => topology.ends(channel).0 == client,
        _ => false,
    });
    let envelope = Envelope { message: request, request: RequestNumber(number) };
    process.take(taking.expect("the component receives a request").transition, Some(envelope), Duration::ZERO);
}

/// Lets the component answer this client, if it can.
fn answer(process: &mut dyn Process, topology: &Topology, client: &str) -> Option<Envelope> {
    let (transition, envelope) = offers(process).into_iter().find_map(|offer| match offer.action {
        Action::Send(channel, envelope) if topology.ends(channel).1 == client => Some((offer.transition, envelope)),
        _ => None,
    })?;
    process.take(transition, None, Duration::ZERO);
    Some(envelope)
}

fn go(what: &str, place: &str) -> Message {
    Message::symbols([what, place])
}

#[test]
fn a_client_has_one_pending_request_at_a_time() {
    let (topology, id) = wire("BatteryReader", &["BatteryLevel"]);
    let mut reader = BatteryReader::new(&topology, id).unwrap();
    ask(&mut reader, &topology, "BatteryLevel", Message::symbols(["get_level"]), 1);
    assert!(offers(&reader).is_empty(), "there is no reading yet");
    assert_eq!(reader.location(), "no reading yet");
}

#[test]
fn a_reply_repeats_the_number_and_is_sent_once() {
    let (topology, id) = wire(NAVIGATION, &["GoToDestination"]);
    let mut navigation = Navigation::new(&topology, id).unwrap();
    ask(&mut navigation, &topology, "GoToDestination", go("get_status", "Destination"), 42);
    let reply = answer(&mut navigation, &topology, "GoToDestination").unwrap();
    assert_eq!(reply, Envelope { message: Message::symbols(["ok", "idle"]), request: RequestNumber(42) });
    assert_eq!(answer(&mut navigation, &topology, "GoToDestination"), None);
}

#[test]
fn a_stop_ends_only_the_trip_to_its_place() {
    let (topology, id) = wire(NAVIGATION, &["GotoRechargingStation", "GoToDestination"]);
    let mut navigation = Navigation::new(&topology, id).unwrap();
    let mut ask = |client: &str, what: &str, place: &str| {
        ask(&mut navigation, &topology, client, go(what, place), 0);
        answer(&mut navigation, &topology, client).unwrap().message
    };
    assert_eq!(ask("GoToDestination", "start_navigation", "Destination"), Message::symbols(["ok", "running"]));
    let station = "RechargingStation";
    assert_eq!(ask("GotoRechargingStation", "start_navigation", station), Message::symbols(["ok", "running"]));
    // The stop of the old trip comes after the start of the new one.
    assert_eq!(ask("GoToDestination", "stop_navigation", "Destination"), Message::symbols(["ok", "stopped"]));
    assert_eq!(ask("GotoRechargingStation", "get_status", station), Message::symbols(["ok", "running"]));
    assert_eq!(ask("GotoRechargingStation", "stop_navigation", station), Message::symbols(["ok", "stopped"]));
    assert_eq!(ask("GotoRechargingStation", "get_status", station), Message::symbols(["ok", "idle"]));
}

#[test]
fn no_running_status_of_an_old_trip_arrives_after_a_new_one_has_started() {
    let (topology, id) = wire(NAVIGATION, &["GotoRechargingStation", "GoToDestination"]);
    let mut navigation = Navigation::new(&topology, id).unwrap();
    ask(&mut navigation, &topology, "GoToDestination", go("start_navigation", "Destination"), 0);
    ask(&mut navigation, &topology, "GotoRechargingStation", go("start_navigation", "RechargingStation"), 0);
    let late = answer(&mut navigation, &topology, "GoToDestination").unwrap();
    assert_eq!(late.message, Message::symbols(["ok", "stopped"]));
}

#[test]
fn questions_about_places_wait_for_the_first_pose_estimate() {
    let (topology, id) = wire(LOCALIZATION, &["AtDestination"]);
    let mut localization = Localization::new(&topology, id).unwrap();
    ask(&mut localization, &topology, "AtDestination", go("is_at", "Destination"), 0);
    assert_eq!(answer(&mut localization, &topology, "AtDestination"), None);
    assert_eq!(localization.location(), "no estimate yet");
}

#[test]
fn a_request_without_a_known_place_is_answered_with_an_error() {
    let (topology, id) = wire(LOCALIZATION, &["AtDestination"]);
    let mut localization = Localization::new(&topology, id).unwrap();
    ask(&mut localization, &topology, "AtDestination", Message::symbols(["is_at"]), 7);
    let reply = answer(&mut localization, &topology, "AtDestination").unwrap();
    assert_eq!(reply.message.field(1), Some(&Value::symbol("error")));
    assert_eq!(reply.request, RequestNumber(7));
}

#[test]
fn every_operation_has_an_answer_and_an_error() {
    for operation in operations(&places()) {
        assert_eq!(operation.replies.len(), 2, "{}", operation.name);
    }
}

#[test]
fn under_the_original_rule_a_stop_ends_every_trip() {
    let (topology, id) = wire(NAVIGATION, &["GotoRechargingStation", "GoToDestination"]);
    let mut navigation = Navigation::new(&topology, id).unwrap().with_stops(StopRule::AnyTrip);
    ask(&mut navigation, &topology, "GotoRechargingStation", go("start_navigation", "RechargingStation"), 1);
    assert!(answer(&mut navigation, &topology, "GotoRechargingStation").is_some());
    ask(&mut navigation, &topology, "GoToDestination", go("stop_navigation", "Destination"), 2);
    let reply = answer(&mut navigation, &topology, "GoToDestination").unwrap();
    assert_eq!(reply.message, Message::symbols(["ok", "stopped"]));
    assert_eq!(navigation.trip_place(), None);
    let orders: Vec<_> = std::iter::from_fn(|| navigation.next_order()).collect();
    assert_eq!(orders, [Order::Start(Symbol::new("RechargingStation")), Order::Stop]);
}

/// A blackboard and two skills; assertions state the answers.
struct Board {
    topology: Topology,
    blackboard: Blackboard,
}

impl Board {
    fn new() -> Self {
        let (topology, id) = wire(BLACKBOARD, &["one", "other"]);
        let blackboard = Blackboard::new(&topology, id).unwrap();
        Self { topology, blackboard }
    }

    fn ask(&mut self, skill: &str, what: &str, value: Option<i64>) {
        let fields = [Value::symbol(what), skill.into(), Value::symbol("navigation")];
        let request = Message::new(fields.into_iter().chain(value.map(Value::Int)));
        ask(&mut self.blackboard, &self.topology, skill, request, 1);
    }

    fn answer(&mut self, skill: &str) -> Option<Message> {
        answer(&mut self.blackboard, &self.topology, skill).map(|reply| reply.message)
    }

    fn call(&mut self, skill: &str, what: &str, value: Option<i64>) -> Option<Message> {
        self.ask(skill, what, value);
        self.answer(skill)
    }
}

fn ok(value: impl Into<Value>) -> Option<Message> {
    Some(Message::new([Value::symbol("ok"), value.into()]))
}

#[test]
fn a_lock_is_granted_to_one_skill_at_a_time() {
    let mut board = Board::new();
    assert_eq!(board.call("one", "lock", None), ok(true));
    assert_eq!(board.call("one", "lock", None), ok(true), "the holder may ask again");
    assert_eq!(board.call("other", "lock", None), None);
    assert_eq!(board.blackboard.location(), "navigation: 1, one");
    assert_eq!(board.call("one", "unlock", None), ok(true));
    assert_eq!(board.answer("other"), ok(true));
}

#[test]
fn only_the_holder_writes_and_others_cannot_read_meanwhile() {
    let mut board = Board::new();
    let refused = Some(Message::new([Value::symbol("error"), "unauthorized client".into()]));
    assert_eq!(board.call("one", "write_data", Some(0)), refused, "it is not locked");
    assert_eq!(board.call("one", "read_data", None), ok(1));
    assert_eq!(board.call("one", "lock", None), ok(true));
    assert_eq!(board.call("one", "write_data", Some(0)), ok(true));
    for (what, value) in [("read_data", None), ("write_data", Some(1)), ("unlock", None)] {
        assert_eq!(board.call("other", what, value), refused, "{what}");
    }
    assert_eq!(board.blackboard.location(), "navigation: 0, one");
}

#[test]
fn a_skill_that_read_zero_gets_the_lock_after_a_write() {
    let mut board = Board::new();
    for (what, value) in [("lock", None), ("write_data", Some(0)), ("unlock", None)] {
        assert_eq!(board.call("one", what, value), ok(true));
    }
    assert_eq!(board.call("other", "lock", None), ok(true), "it has not read yet");
    assert_eq!(board.call("other", "read_data", None), ok(0));
    assert_eq!(board.call("other", "unlock", None), ok(true));
    assert_eq!(board.call("other", "lock", None), None);
    assert_eq!(board.call("one", "lock", None), ok(true));
    assert_eq!(board.call("one", "write_data", Some(1)), ok(true));
    assert_eq!(board.answer("other"), None, "it is locked");
    assert_eq!(board.call("one", "unlock", None), ok(true));
    assert_eq!(board.answer("other"), ok(true));
}
