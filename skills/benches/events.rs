//! The time per event: `cargo bench -p steward-skills`.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, Domain, Envelope, FieldKind, Message, Offer, Process, RequestNumber, Role, Shape, Topology, TransitionId,
    Value, WiringError,
};
use divan::counter::ItemsCount;
use divan::{AllocProfiler, Bencher, black_box};
use skills::{Chart, Datum, Event, Host, Machine, Outgoing, SkillProcess, Undelivered, shipped};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

/// Accepts everything and does nothing.
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

/// The paper's response monitor as a machine: a low battery must be answered within ten ticks.
const RESPONSE: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
  <datamodel><data id="timer" expr="0"/></datamodel>
  <state id="idle">
    <transition event="BatteryReader.ok" cond="_event.data.level &lt; 30" target="wait">
      <assign location="timer" expr="10"/>
    </transition>
  </state>
  <state id="wait">
    <transition event="GotoRechargingStation.start_navigation" target="idle"/>
    <transition event="TickGenerator.tick" cond="timer > 0"><assign location="timer" expr="timer - 1"/></transition>
    <transition event="TickGenerator.tick" target="failure"/>
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
    topology.channel(
        skill,
        tree,
        Capacity::One,
        head(FieldKind::symbols(["success", "failure", "halted"])).in_role(Role::Reply),
    )?;
    topology.channel(skill, reader, Capacity::One, head(FieldKind::symbols(["get_level"])))?;
    topology.channel(reader, skill, Capacity::One, Domain::new([ok, error]).in_role(Role::Reply))?;
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

/// Four events: a low level, two ticks, the answer. One of them matters.
#[divan::bench]
fn response_monitor(bencher: Bencher) {
    let mut machine = started(Chart::load("response.scxml", RESPONSE).expect("a machine"));
    let events = [
        Event::external("BatteryReader.ok").with_data(level(25.0)),
        Event::external("TickGenerator.tick"),
        Event::external("TickGenerator.tick"),
        Event::external("GotoRechargingStation.start_navigation"),
    ];
    bencher.counter(ItemsCount::new(events.len())).bench_local(|| {
        for event in &events {
            machine.handle(black_box(event.clone()), Duration::ZERO, &mut Nobody);
        }
    });
}

/// The same with the engine, to measure the cost of falling back to it.
#[cfg(feature = "ecmascript")]
#[divan::bench]
fn safety_monitor_by_the_engine(bencher: Bencher) {
    let text = SAFETY.replace("_event.data.level >= 20", "Math.max(_event.data.level, 0) >= 20");
    let mut machine = started(Chart::load("safety.scxml", &text).expect("a machine"));
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
