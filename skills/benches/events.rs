//! What an event costs: `cargo bench -p skills`.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, Domain, Envelope, FieldKind, Message, Offer, Process, RequestNumber, Shape, Topology, TransitionId,
    Value, WiringError,
};
use divan::{Bencher, black_box};
use skills::{Chart, Datum, Event, Host, Machine, Outgoing, SkillProcess, Undelivered, shipped};

fn main() {
    divan::main();
}

/// Takes everything and does nothing.
struct Nobody;

impl Host for Nobody {
    fn send(&mut self, _: &Outgoing) -> Result<(), Undelivered> {
        Ok(())
    }
}

/// The paper's safety monitor as a machine.
const SAFETY: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
  <state id="idle"><transition event="BatteryReader" target="get"/></state>
  <state id="get">
    <transition cond="_event.data.level >= 20" target="idle"/>
    <transition target="failure"/>
  </state>
  <state id="failure"/>
</scxml>"#;

fn started(chart: Arc<Chart>) -> Machine {
    let mut machine = Machine::new(chart);
    machine.start(Duration::ZERO, &mut Nobody);
    machine
}

fn chart(leaf: &str) -> Arc<Chart> {
    Chart::load(leaf, shipped(leaf).expect("it is shipped")).expect("it loads")
}

/// BT, BatteryLevel and BatteryReader.
fn topology() -> Result<Topology, WiringError> {
    let mut topology = Topology::default();
    let (tree, skill) = (topology.process("BT")?, topology.process("BatteryLevel")?);
    let reader = topology.process("BatteryReader")?;
    let head = |symbols| Domain::new([Shape::new([("head", symbols)])]);
    let ok = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
    let error = Shape::new([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]);
    topology.channel(tree, skill, Capacity::One, head(FieldKind::symbols(["tick", "halt"])))?;
    topology.channel(skill, tree, Capacity::One, head(FieldKind::symbols(["success", "failure", "halted"])))?;
    topology.channel(skill, reader, Capacity::One, head(FieldKind::symbols(["get_level"])))?;
    topology.channel(reader, skill, Capacity::One, Domain::new([ok, error]))?;
    Ok(topology)
}

fn level(level: f64) -> Datum {
    Datum::object([("level", Datum::from(level))]).expect("one member is not too many")
}

/// One event, two microsteps, a comparison.
#[divan::bench]
fn safety_monitor(bencher: Bencher) {
    let mut machine = started(Chart::load("safety.scxml", SAFETY).expect("a machine"));
    let event = Event::external("BatteryReader.ok").with_data(level(83.2));
    bencher.bench_local(|| machine.handle(black_box(event.clone()), Duration::ZERO, &mut Nobody));
}

/// A tick and the reader's answer, on the machine alone.
#[divan::bench]
fn battery_level_machine(bencher: Bencher) {
    let mut machine = started(chart("BatteryLevel"));
    let tick = Event::external("BT.tick");
    let answer = Event::external("BatteryReader.ok").with_data(level(83.2));
    bencher.bench_local(|| {
        machine.handle(black_box(tick.clone()), Duration::ZERO, &mut Nobody);
        machine.handle(black_box(answer.clone()), Duration::ZERO, &mut Nobody);
    });
}

/// The same as a process: four messages.
#[divan::bench]
fn battery_level_process(bencher: Bencher) {
    let mut skill =
        SkillProcess::new("BatteryLevel", &chart("BatteryLevel"), &topology().expect("names are unique"), [])
            .expect("it fits");
    let tick = Message::symbols(["tick"]);
    let answer = Message::new([Value::symbol("ok"), 83.2.into()]);
    let mut offers: Vec<Offer> = Vec::new();
    let mut number = 0;
    bencher.bench_local(|| {
        number += 1;
        let tick = Envelope { message: tick.clone(), request: RequestNumber(number) };
        skill.take(TransitionId(0), Some(tick), Duration::ZERO);
        offers.clear();
        skill.offers(&mut offers);
        let ask = offers.pop().expect("it asks");
        skill.take(ask.transition, None, Duration::ZERO);
        let answer = Envelope { message: answer.clone(), request: RequestNumber(number) };
        skill.take(TransitionId(1), Some(answer), Duration::ZERO);
        offers.clear();
        skill.offers(&mut offers);
        let result = offers.pop().expect("it answers");
        skill.take(result.transition, None, Duration::ZERO);
    });
}

/// Reading and compiling a machine.
#[divan::bench]
fn load_go_to_destination() -> Arc<Chart> {
    let text = shipped(black_box("GoToDestination")).expect("it is shipped");
    Chart::load("GoToDestination.scxml", text).expect("it loads")
}
