//! Applies faults to a run, and removes them.

mod damage;
mod machines;

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Event, ProcessId};
use components::{Component, Software};
use nav::InitialPose;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::{Streams, normal};
use sim::{SimError, Simulation};

use self::damage::Damages;
use self::machines::Machines;
use super::{Change, Effect, Fault, Observation, TickTrouble, Timetable, stream_name};
use crate::error::Complaints;
use crate::scenario::Scenario;
use crate::wiring::Ids;

/// The faults of a run: their times and their effects.
#[derive(Debug)]
pub(crate) struct Injector {
    timetable: Timetable,
    faults: Vec<Prepared>,
    machines: Machines,
    ids: Ids,
}

/// A fault that is ready to be applied.
#[derive(Debug)]
struct Prepared {
    effect: Effect,
    damages: Damages,
    /// The fault's own random numbers, except for damage to messages.
    rng: ChaCha8Rng,
}

/// The parts of a run on which faults act.
pub(crate) struct SystemUnderTest<'a> {
    pub(crate) sim: &'a mut Simulation,
    pub(crate) software: &'a mut Software,
    pub(crate) system: &'a mut ChannelSystem,
    /// The events of the previous step.
    pub(crate) events: &'a [Event],
}

/// What happened to a fault of the scenario, given by its index.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Happening {
    /// It became active.
    Begun(usize),
    /// It ended.
    Ended(usize),
    /// It was due but could not be applied.
    LeftUndone(usize, SimError),
}

impl Injector {
    /// The faults of a scenario, ready for a run of this simulation and this system. Their problems are recorded.
    pub(crate) fn new(
        scenario: &Scenario,
        sim: &Simulation,
        system: &ChannelSystem,
        ids: Ids,
        streams: &Streams,
        complaints: &mut Complaints,
    ) -> Self {
        let faults = &scenario.file.faults;
        let timetable = Timetable::new(faults, system, &scenario.places, streams, complaints);
        let prepare = |(index, fault): (usize, &Arc<Fault>)| {
            let effect = fault.effect();
            check_place(&effect, sim, complaints);
            let stream = format!("fault/{}", stream_name(faults, index));
            Prepared {
                rng: streams.stream(&stream),
                damages: Damages::prepare(&effect, system.topology(), *streams, stream, complaints),
                effect,
            }
        };
        let faults = faults.iter().enumerate().map(prepare).collect();
        let machines = Machines::prepare(scenario, system, complaints);
        Self { timetable, faults, machines, ids }
    }

    /// Begins and ends the faults that are due. Returns what happened.
    pub(crate) fn act(&mut self, run: &mut SystemUnderTest<'_>) -> Vec<Happening> {
        let (now, pose) = (run.sim.time(), run.sim.truth().pose());
        let changes = self.timetable.changes(&Observation { now, pose, system: run.system, events: run.events });
        let mut happenings = Vec::with_capacity(changes.len());
        for change in changes {
            happenings.push(match change {
                Change::Begins(index) => self.begin(index, run),
                Change::Ends(index) => self.end(index, run),
            });
        }
        if !happenings.is_empty() {
            self.renew(run);
        }
        happenings
    }

    /// Applies the instantaneous effects at the beginning of a fault.
    fn begin(&mut self, index: usize, run: &mut SystemUnderTest<'_>) -> Happening {
        let Prepared { effect, damages, .. } = &mut self.faults[index];
        match effect {
            Effect::Charge(charge_pct) => run.sim.set_battery_charge(*charge_pct),
            Effect::Kidnap(to) => {
                if let Err(error) = run.sim.kidnap(to.value) {
                    return Happening::LeftUndone(index, error);
                }
            }
            Effect::Belief(pose) => run.software.believe(&InitialPose::at(*pose)),
            Effect::Channels { .. } => damages.begin(run.system),
            Effect::World(_) | Effect::Map(_) | Effect::Ticks(_) | Effect::Outage { .. } | Effect::Machine { .. } => {}
        }
        Happening::Begun(index)
    }

    /// Applies the instantaneous effects at the end of a fault.
    fn end(&mut self, index: usize, run: &mut SystemUnderTest<'_>) -> Happening {
        let Prepared { effect, damages, .. } = &mut self.faults[index];
        match effect {
            Effect::Outage { component, crashed: true } => run.software.restart(*component, run.system),
            Effect::Channels { .. } => damages.end(run.system),
            _ => {}
        }
        Happening::Ended(index)
    }

    /// Recomputes the lasting effects from the active faults.
    fn renew(&mut self, run: &mut SystemUnderTest<'_>) {
        self.renew_world(run.sim);
        self.renew_outages(run);
        let holding: Vec<usize> = self.timetable.holding().collect();
        self.machines.renew(&holding, run.system, run.sim.time());
    }

    /// The effects on the simulated world.
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

    /// The frozen components, with their processes and drivers.
    fn renew_outages(&self, run: &mut SystemUnderTest<'_>) {
        for component in Component::ALL {
            let is_out = self
                .effects()
                .any(|effect| matches!(effect, Effect::Outage { component: out, .. } if *out == component));
            if run.software.outages_mut().has(component) != is_out {
                run.software.outages_mut().set(component, is_out);
                run.system.suspend(component_id(self.ids, component), is_out);
            }
        }
    }

    /// The effects of the active faults.
    fn effects(&self) -> impl Iterator<Item = &Effect> {
        self.timetable.holding().map(|index| &self.faults[index].effect)
    }

    /// The delay of a tick that is due now; `None` if it is missed.
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

    /// The number of messages that a fault has damaged so far; `None` for a fault that damages none.
    pub(crate) fn messages_hit(&self, index: usize, system: &ChannelSystem) -> Option<u64> {
        let Prepared { effect, damages, .. } = &self.faults[index];
        matches!(effect, Effect::Channels { .. }).then(|| damages.hits(system))
    }
}

/// Reports an effect that puts the robot where it can never be: outside the map, or in a wall.
fn check_place(effect: &Effect, sim: &Simulation, complaints: &mut Complaints) {
    let Effect::Kidnap(to) = effect else { return };
    if let Err(error) = sim.check_kidnapping(&to.value) {
        let help = "give x and y in metres, in the map frame; the whole body of the robot must be on free floor";
        complaints.push(to.span.problem(error.to_string()).with_label("no room for the robot").with_help(help));
    }
}

fn component_id(ids: Ids, component: Component) -> ProcessId {
    match component {
        Component::BatteryReader => ids.battery_reader,
        Component::Localization => ids.localization,
        Component::Navigation => ids.navigation,
    }
}
