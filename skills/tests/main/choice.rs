//! Machines that choose.

use std::collections::BTreeSet;
use std::time::Duration;

use channels::{
    Action, Capacity, Domain, FieldKind, Message, Offer, Process, Role, Shape, Topology, TransitionId, Value,
};
use skills::{Chart, SkillProcess};

use crate::stage::file;

/// A door that opens, sticks after a second, or says how often it was asked.
const DOOR: &str = r#"
    <datamodel><data id="asked" expr="0"/></datamodel>
    <state id="closed">
      <transition event="open" target="trying"><assign location="asked" expr="asked + 1"/></transition>
    </state>
    <state id="trying">
      <onentry>
        <send type="choice" event="works"><param name="n" expr="asked"/></send>
        <send type="choice" event="sticks"/>
        <send type="choice" event="late" delay="1s"/>
      </onentry>
      <transition event="works" target="closed">
        <send type="channel" target="Client" event="ok"><param name="n" expr="_event.data.n"/></send>
      </transition>
      <transition event="sticks late" target="closed">
        <send type="channel" target="Client" event="error"><param name="reason" expr="'it ' + _event.name"/></send>
      </transition>
    </state>"#;

fn topology() -> Topology {
    let mut topology = Topology::default();
    let [client, door] = ["Client", "Door"].map(|name| topology.process(name).unwrap());
    let open = Domain::new([Shape::new([("request", FieldKind::symbols(["open"]))])]);
    let ok = Shape::new([("status", FieldKind::symbols(["ok"])), ("n", FieldKind::Int)]);
    let error = Shape::new([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]);
    topology.channel(client, door, Capacity::One, open).unwrap();
    topology.channel(door, client, Capacity::One, Domain::new([ok, error]).in_role(Role::Reply)).unwrap();
    topology
}

fn door() -> SkillProcess {
    let chart = Chart::load("Door.scxml", &file("", DOOR)).unwrap();
    let mut door = SkillProcess::new("Door", &chart, &topology(), []).unwrap();
    take(&mut door, |action| matches!(action, Action::Receive(..)), Some(Message::symbols(["open"])));
    door
}

fn offers(process: &SkillProcess) -> Vec<Offer> {
    let mut offers = Vec::new();
    process.offers(&mut offers);
    offers
}

fn take(process: &mut SkillProcess, is_it: impl Fn(&Action) -> bool, message: Option<Message>) -> TransitionId {
    let offer = offers(process).into_iter().find(|offer| is_it(&offer.action)).expect("it is offered");
    process.take(offer.transition, message.map(Into::into), Duration::ZERO);
    offer.transition
}

fn sent(process: &SkillProcess) -> Option<Message> {
    offers(process).into_iter().find_map(|offer| match offer.action {
        Action::Send(_, envelope) => Some(envelope.message),
        _ => None,
    })
}

#[test]
fn one_of_the_events_is_delivered_and_the_others_are_gone() {
    let start = door();
    let choices = offers(&start);
    assert!(choices.len() == 2 && choices.iter().all(|offer| offer.action == Action::Internal), "{choices:?}");
    let words: Vec<Option<String>> = choices.iter().map(|offer| start.in_words(offer.transition)).collect();
    assert_eq!(words, [Some("chooses `works`".to_owned()), Some("chooses `sticks`".to_owned())]);
    let chosen = |choice: &Offer| {
        let mut door = start.clone();
        door.take(choice.transition, None, Duration::ZERO);
        assert!(!offers(&door).iter().any(|offer| offer.action == Action::Internal), "the other one is gone");
        sent(&door)
    };
    let sticks = Message::new([Value::symbol("error"), "it sticks".into()]);
    assert_eq!(
        choices.iter().map(chosen).collect::<Vec<_>>(),
        [Some(Message::new([Value::symbol("ok"), 1.into()])), Some(sticks)]
    );
}

#[test]
fn a_choice_can_come_later() {
    let mut door = door();
    let first = take(&mut door, |action| *action == Action::Internal, None);
    assert_eq!(door.next_timer(), Some(Duration::from_secs(1)));
    door.fire_timers(Duration::from_secs(1));
    let choices = offers(&door);
    assert_eq!(choices.iter().map(|offer| offer.transition).collect::<BTreeSet<_>>(), [first].into(), "{choices:?}");
    assert_eq!(door.in_words(first), Some("chooses `late`".to_owned()));
}

#[test]
fn a_choice_needs_an_event_and_no_target() {
    let problems = |send: &str| {
        let content = format!("<state id=\"a\"><onentry>{send}</onentry></state>");
        Chart::load("a.scxml", &file("", &content)).err().map(|error| format!("{error:?}")).unwrap_or_default()
    };
    let found = ["<send type=\"choice\"/>", "<send type=\"choice\" event=\"a\" target=\"Door\"/>"].map(problems);
    assert!(found[0].contains("no event is sent") && found[1].contains("a choice has no target"), "{found:?}");
}
