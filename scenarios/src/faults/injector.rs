//! Makes faults take hold of a run, and lets go of them.

mod damage;
mod machines;

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Disturbance, DisturbanceId, Event, ProcessId};
use components::{Component, Software};
use nav::InitialPose;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::{Streams, normal};
use sim::Simulation;

use self::machines::Exchange;
use super::{Change, Effect, Fault, Moment, TickTrouble, Timetable};
use crate::error::Complaints;
use crate::scenario::Scenario;
use crate::wiring::Ids;

/// The faults of a run: when they hold, and what they do.
#[derive(Debug)]
pub(crate) struct Injector {
    timetable: Timetable,
    faults: Vec<Prepared>,
    ids: Ids,
}

/// A fault with everything that it needs to take hold.
#[derive(Debug)]
struct Prepared {
    fault: Arc<Fault>,
    effect: Effect,
    disturbances: Vec<Disturbance>,
    exchange: Option<Exchange>,
    /// The fault's own random numbers.
    rng: ChaCha8Rng,
    /// The disturbances of this fault that have begun, those that are over included.
    begun: Vec<DisturbanceId>,
}

/// What faults act on.
pub(crate) struct Run<'a> {
    pub(crate) sim: &'a mut Simulation,
    pub(crate) software: &'a mut Software,
    pub(crate) system: &'a mut ChannelSystem,
    /// What was said in the step before.
    pub(crate) events: &'a [Event],
}

impl Injector {
    /// The faults of a scenario, ready for a run of that system.
    pub(crate) fn new(
        scenario: &Scenario,
        system: &ChannelSystem,
        ids: Ids,
        streams: &Streams,
        complaints: &mut Complaints,
    ) -> Self {
        let faults = &scenario.file.faults;
        let timetable = Timetable::new(faults, system, &scenario.places, streams, complaints);
        let prepare = |(index, fault): (usize, &Arc<Fault>)| {
            let effect = fault.effect();
            let stream = streams.stream(&format!("fault/{}", stream_name(faults, index)));
            Prepared {
                disturbances: damage::prepare(&effect, system.topology(), &stream, complaints),
                exchange: machines::prepare(&effect, index, scenario, system, complaints),
                effect,
                fault: Arc::clone(fault),
                rng: stream,
                begun: Vec::new(),
            }
        };
        let faults = faults.iter().enumerate().map(prepare).collect();
        Self { timetable, faults, ids }
    }

    /// Lets faults begin and end that are due: which of the scenario's faults did. What a fault cannot do (put the robot
    /// into a wall) it leaves undone.
    pub(crate) fn act(&mut self, run: &mut Run<'_>) -> Vec<Change> {
        let (now, pose) = (run.sim.time(), run.sim.truth().pose());
        let changes = self.timetable.changes(&Moment { now, pose, system: run.system, events: run.events });
        for change in &changes {
            match *change {
                Change::Begins(index) => self.begin(index, run),
                Change::Ends(index) => self.end(index, run),
            }
        }
        if !changes.is_empty() {
            self.renew_world(run.sim);
        }
        changes
    }

    /// Computes anew what is wrong in the simulated world.
    fn renew_world(&self, sim: &mut Simulation) {
        let mut wrong = sim::Faults::default();
        for effect in self.effects() {
            if let Effect::World(apply) = effect {
                apply(&mut wrong);
            }
        }
        if *sim.faults() != wrong {
            *sim.faults_mut() = wrong;
        }
    }

    /// The effects of the faults that hold.
    fn effects(&self) -> impl Iterator<Item = &Effect> {
        self.timetable.holding().map(|index| &self.faults[index].effect)
    }

    fn begin(&mut self, index: usize, run: &mut Run<'_>) {
        let Prepared { effect, disturbances, exchange, begun, .. } = &mut self.faults[index];
        match effect {
            Effect::Charge(charge_pct) => run.sim.set_battery_charge(*charge_pct),
            // Nobody can put a robot where there is a wall.
            Effect::Kidnap(to) => drop(run.sim.kidnap(*to)),
            Effect::Belief(pose) => run.software.believe(&InitialPose::at(*pose)),
            Effect::Outage { component, .. } => suspend(run, self.ids, *component, true),
            Effect::Channels { .. } => begun.extend(disturbances.iter().map(|one| run.system.disturb(one.clone()))),
            Effect::Machine { .. } => exchange.iter().for_each(|exchange| exchange.begin(run.system)),
            Effect::World(_) | Effect::Map(_) | Effect::Ticks(_) => {}
        }
    }

    fn end(&mut self, index: usize, run: &mut Run<'_>) {
        let Prepared { effect, exchange, begun, .. } = &self.faults[index];
        match effect {
            Effect::Outage { component, crashed } => {
                suspend(run, self.ids, *component, false);
                if *crashed {
                    run.software.restart(*component, run.system);
                }
            }
            Effect::Channels { .. } => begun.iter().for_each(|id| run.system.calm(*id)),
            Effect::Machine { .. } => exchange.iter().for_each(|exchange| exchange.end(run.system)),
            _ => {}
        }
    }

    /// What becomes of a tick that is due now: nothing if it is missed, else how much later it comes.
    pub(crate) fn delay_of_tick(&mut self) -> Option<Duration> {
        let mut delay = Duration::ZERO;
        for index in self.timetable.holding() {
            let Prepared { effect: Effect::Ticks(trouble), rng, .. } = &mut self.faults[index] else { continue };
            match trouble {
                TickTrouble::Missed(share) if rng.random::<f64>() < *share => return None,
                TickTrouble::Missed(_) => {}
                TickTrouble::Late(by) => delay += *by,
                TickTrouble::Jitter(sigma) => delay += sigma.mul_f64(normal(rng).abs()),
            }
        }
        Some(delay)
    }

    /// A fault by its place in the scenario.
    pub(crate) fn fault(&self, index: usize) -> &Arc<Fault> {
        &self.faults[index].fault
    }

    /// How many messages a fault has damaged so far; nothing for a fault that damages none.
    pub(crate) fn messages_hit(&self, index: usize, system: &ChannelSystem) -> Option<u64> {
        let Prepared { effect, begun, .. } = &self.faults[index];
        matches!(effect, Effect::Channels { .. }).then(|| begun.iter().map(|id| system.hits(*id)).sum())
    }
}

/// The name of a fault's stream of random numbers: its kind and its place among the faults of that kind, so that another
/// kind of fault that is added or taken out changes nothing.
pub(super) fn stream_name(faults: &[Arc<Fault>], index: usize) -> String {
    let kind = faults[index].kind().name;
    let number = faults[..index].iter().filter(|other| other.kind().name == kind).count();
    format!("{kind}/{number}")
}

/// Lets process and driver of a component stand still, or go on.
fn suspend(run: &mut Run<'_>, ids: Ids, component: Component, suspended: bool) {
    run.software.outages_mut().set(component, suspended);
    run.system.suspend(component_id(ids, component), suspended);
}

fn component_id(ids: Ids, component: Component) -> ProcessId {
    match component {
        Component::BatteryReader => ids.battery_reader,
        Component::Localization => ids.localization,
        Component::Navigation => ids.navigation,
    }
}
