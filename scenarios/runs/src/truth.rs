//! What is true in the world, as monitors are shown it.

use channels::{ChannelSystem, Event, Message, Value};
use maps::{Point, heading};
use scenarios::scenario::{Fact, Premises, Truths};

use crate::world::SimulatedRobot;

/// Shows the monitors what is true, once per step in which something of it has changed.
#[derive(Debug)]
pub(crate) struct TruthShow {
    truths: Truths,
    shown: Option<Message>,
}

impl TruthShow {
    pub(crate) fn new(truths: Truths) -> Self {
        Self { truths, shown: None }
    }

    /// Shows what is true now, unless it was shown before.
    pub(crate) fn show(
        &mut self,
        robot: &SimulatedRobot,
        premises: &Premises,
        system: &mut ChannelSystem,
    ) -> Option<Event> {
        let message = Message::new(self.truths.facts.iter().map(|fact| value(fact, robot, premises)));
        if self.shown.as_ref() == Some(&message) {
            return None;
        }
        self.shown = Some(message.clone());
        Some(system.show(self.truths.channel, message))
    }
}

fn value(fact: &Fact, robot: &SimulatedRobot, premises: &Premises) -> Value {
    let truth = robot.sim.truth();
    let position = Point::from(truth.pose().translation.vector);
    let body = |name: &str| robot.body(name).unwrap_or(position);
    match fact {
        Fact::Level => truth.battery().charge_pct.into(),
        Fact::Charging => truth.battery().charging.into(),
        Fact::X => position.x.into(),
        Fact::Y => position.y.into(),
        Fact::Heading => heading(&truth.pose()).into(),
        Fact::Speed => truth.linear_mps().into(),
        Fact::Turning => truth.angular_radps().into(),
        Fact::Touching => truth.is_touching().into(),
        Fact::Clearance => truth.clearance_m(robot.radius_m()).into(),
        Fact::Person => robot.person_m().into(),
        Fact::At(place) => premises.places.get(place).is_some_and(|place| place.covers(&position)).into(),
        Fact::Open(door) => truth.door_opening(door).unwrap_or_default().into(),
        Fact::BodyX(name) => body(name).x.into(),
        Fact::BodyY(name) => body(name).y.into(),
        Fact::Carried(name) => robot.body(name).is_none().into(),
    }
}
