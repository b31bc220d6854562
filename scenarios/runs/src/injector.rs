//! Applies faults to a run, and removes them.

mod damage;
mod machines;

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Event, ProcessId};
use components::Component;
use devices::DeviceProcess;
use maps::Places;
use nav::{Goal, InitialPose};
use programs::ProgramProcess;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use remote::RemoteProcess;
use robot::{Streams, normal};
use scenarios::faults::{DeviceTrouble, Effect, Fault, TickTrouble};
use scenarios::scenario::Scenario;
use scenarios::{Complaints, Error};
use sim::Simulation;
use skills::SkillProcess;

use self::damage::Damages;
pub use self::damage::opposite;
use self::machines::Machines;
use crate::timetable::{DueChange, Observation, Timetable, stream_names};
use crate::world::World;

/// The faults of a run: their times and their effects.
#[derive(Debug)]
pub(crate) struct Injector {
    timetable: Timetable,
    faults: Vec<Prepared>,
    machines: Machines,
    components: Vec<(String, ProcessId)>,
    /// The faults that were added since the last step.
    pub(crate) added: Vec<Arc<recording::Fault>>,
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
    pub(crate) world: &'a mut World,
    pub(crate) system: &'a mut ChannelSystem,
    /// The events of the previous step.
    pub(crate) events: &'a [Event],
}

/// What happened to a fault of the scenario, identified by its index.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FaultHappening {
    /// It became active.
    Begun(usize),
    /// It ended.
    Ended(usize),
    /// It was due but could not be applied.
    LeftUndone(usize, String),
}

impl Injector {
    /// The faults of a scenario, ready for a run of this world and this system. Their problems are recorded.
    pub(crate) fn new(
        scenario: &Scenario,
        world: &World,
        system: &ChannelSystem,
        streams: &Streams,
        complaints: &mut Complaints,
    ) -> Self {
        Self::prepare(scenario, world, system, streams, None, complaints)
    }

    /// Continues with a scenario that has more faults at its end, or whose faults have other durations. After an error,
    /// nothing has changed.
    ///
    /// # Errors
    /// [`Error::BadInput`] if a new fault does not fit the run.
    pub(crate) fn extend(
        &mut self,
        scenario: &Scenario,
        world: &World,
        system: &ChannelSystem,
        streams: &Streams,
    ) -> Result<(), Error> {
        let mut complaints = Complaints::default();
        let longer = Self::prepare(scenario, world, system, streams, Some(&self.machines), &mut complaints);
        complaints.check()?;
        let earlier = std::mem::replace(self, longer);
        self.timetable.resume(earlier.timetable);
        self.added = earlier.added;
        self.added.extend(scenario.file.faults[earlier.faults.len()..].iter().map(|fault| Arc::new(fault.record())));
        self.faults.splice(..earlier.faults.len(), earlier.faults);
        Ok(())
    }

    fn prepare(
        scenario: &Scenario,
        world: &World,
        system: &ChannelSystem,
        streams: &Streams,
        earlier: Option<&Machines>,
        complaints: &mut Complaints,
    ) -> Self {
        let faults = &scenario.file.faults;
        let no_places = Places::default();
        let places = scenario.premises.as_ref().map_or(&no_places, |premises| &premises.places);
        let timetable = Timetable::new(faults, system, places, streams, complaints);
        let prepare = |(fault, stream): (&Arc<Fault>, String)| {
            let effect = fault.effect();
            check_place(&effect, world, complaints);
            let stream = format!("fault/{stream}");
            Prepared {
                rng: streams.stream(&stream),
                damages: Damages::prepare(&effect, system.topology(), *streams, stream, complaints),
                effect,
            }
        };
        let faults = faults.iter().zip(stream_names(faults)).map(prepare).collect();
        let machines = Machines::prepare(scenario, system, earlier, complaints);
        let id = |name: &str| Some((name.to_owned(), system.topology().find_process(name)?));
        let components = scenario.component_names().filter_map(id).collect();
        Self { timetable, faults, machines, components, added: Vec::new() }
    }

    /// Begins and ends the faults that are due. Returns what happened.
    pub(crate) fn act(&mut self, run: &mut SystemUnderTest<'_>) -> Vec<FaultHappening> {
        let (now, pose) = (run.world.time(), run.world.robot.as_ref().map(|robot| robot.sim.truth().pose()));
        let changes = self.timetable.changes(&Observation { now, pose, system: run.system, events: run.events });
        let mut happenings = Vec::with_capacity(changes.len());
        for change in changes {
            happenings.push(match change {
                DueChange::Begins(index) => self.begin(index, run),
                DueChange::Ends(index) => self.end(index, run),
            });
        }
        if !happenings.is_empty() {
            self.renew(run);
        }
        happenings
    }

    /// Applies a fault's instantaneous effects when it begins.
    fn begin(&mut self, index: usize, run: &mut SystemUnderTest<'_>) -> FaultHappening {
        let Prepared { effect, damages, .. } = &mut self.faults[index];
        // Effects that last are not applied here: `renew` derives them from all active faults, so that the end of one
        // leaves the others as they were.
        match (effect, run.world.robot.as_mut()) {
            (Effect::Charge(charge_pct), Some(robot)) => robot.sim.set_battery_charge(*charge_pct),
            (Effect::Kidnap(to), Some(robot)) => {
                if let Err(error) = robot.sim.kidnap(to.value) {
                    return FaultHappening::LeftUndone(index, error.to_string());
                }
            }
            (Effect::Belief(pose), Some(robot)) => robot.software.relocalize(&InitialPose::at(*pose)),
            (Effect::Goal(to), Some(robot)) => {
                let to = to.value;
                let goal = Goal::at(to.translation.vector.into(), Some(maps::heading(&to)));
                if let Err(reason) = robot.software.drive_to(goal, run.system) {
                    return FaultHappening::LeftUndone(index, reason.to_owned());
                }
            }
            (Effect::Device { component, trouble: DeviceTrouble::Drop }, Some(robot)) => {
                let id = run.system.topology().find_process(&component.value).expect("a tray of the scenario");
                if let Err(reason) = robot.drop_box(id, run.system) {
                    return FaultHappening::LeftUndone(index, reason.to_owned());
                }
            }
            (Effect::Channels { .. }, _) => damages.begin(run.system),
            _ => {}
        }
        FaultHappening::Begun(index)
    }

    /// Applies a fault's instantaneous effects when it ends.
    fn end(&mut self, index: usize, run: &mut SystemUnderTest<'_>) -> FaultHappening {
        let Prepared { effect, damages, .. } = &mut self.faults[index];
        match effect {
            Effect::Outage { component, crashed: true } => {
                let known = self.components.iter().find(|(name, _)| *name == component.value);
                restart(known.expect("the scenario has this component").1, &component.value, run);
            }
            Effect::Channels { .. } => damages.end(run.system),
            _ => {}
        }
        FaultHappening::Ended(index)
    }

    /// Recomputes the lasting effects from the active faults.
    fn renew(&mut self, run: &mut SystemUnderTest<'_>) {
        if let Some(robot) = run.world.robot.as_mut() {
            self.renew_world(&mut robot.sim);
            robot.software.ignore_zones(|zone| {
                let ignores = |effect: &Effect| {
                    matches!(effect, Effect::Zones(name) if name.as_ref().is_none_or(|name| name.value == zone))
                };
                self.effects().any(ignores)
            });
        }
        self.renew_outages(run);
        let holding: Vec<usize> = self.timetable.holding().collect();
        self.machines.renew(&holding, run.system, run.world.time());
    }

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

    /// The frozen components, with their processes and drivers, and the impaired devices.
    fn renew_outages(&self, run: &mut SystemUnderTest<'_>) {
        for (name, id) in &self.components {
            let is_out = self
                .effects()
                .any(|effect| matches!(effect, Effect::Outage { component, .. } if component.value == *name));
            if let (Some(driver), Some(robot)) = (Component::named(name), run.world.robot.as_mut()) {
                robot.software.freeze(driver, is_out);
            }
            if run.system.is_suspended(*id) != is_out {
                run.system.suspend(*id, is_out);
            }
            let is_impaired = self
                .effects()
                .any(|effect| matches!(effect, Effect::Device { component, .. } if component.value == *name));
            if let Some(device) = run.system.process_mut::<DeviceProcess>(*id) {
                device.impair(is_impaired, run.world.time());
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

/// Reports an effect that puts the robot where it cannot be: outside the map, or in a wall.
fn check_place(effect: &Effect, world: &World, complaints: &mut Complaints) {
    let (Effect::Kidnap(to), Some(robot)) = (effect, &world.robot) else { return };
    if let Err(error) = robot.sim.check_kidnapping(&to.value) {
        let help = "give x and y in meters, in the map frame; the whole body of the robot must be on free floor";
        complaints.push(to.span.problem(error.to_string()).with_label("no room for the robot").with_help(help));
    }
}

/// Restarts a component that has crashed: a machine or program starts again, a built-in component together with its
/// driver.
fn restart(id: ProcessId, name: &str, run: &mut SystemUnderTest<'_>) {
    let now = run.world.time();
    if let Some(skill) = run.system.process_mut::<SkillProcess>(id) {
        *skill = skill.succeeding(skill, now);
    } else if let Some(program) = run.system.process_mut::<ProgramProcess>(id) {
        *program = program.succeeding(program, now);
    } else if let Some(component) = run.system.process_mut::<RemoteProcess>(id) {
        component.restart();
    } else if let Some(device) = run.system.process_mut::<DeviceProcess>(id) {
        device.restart(now);
    } else if let (Some(component), Some(robot)) = (Component::named(name), run.world.robot.as_mut()) {
        robot.software.restart(component, run.system);
    }
}
