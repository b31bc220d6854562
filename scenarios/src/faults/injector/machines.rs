//! Faults of skills: another machine takes a skill's place.

use channels::{ChannelSystem, Process, ProcessId};
use skills::SkillProcess;

use crate::error::Complaints;
use crate::faults::Effect;
use crate::scenario::Scenario;

/// A process that is exchanged for another one.
#[derive(Debug)]
pub(super) struct Exchange {
    id: ProcessId,
    sound: Box<dyn Process>,
    faulty: Box<dyn Process>,
}

impl Exchange {
    /// The faulty process takes its place, in its first state.
    pub(super) fn begin(&self, system: &mut ChannelSystem) {
        put(system, self.id, &*self.faulty);
    }

    /// The sound process is back, in its first state.
    pub(super) fn end(&self, system: &mut ChannelSystem) {
        put(system, self.id, &*self.sound);
    }
}

fn put(system: &mut ChannelSystem, id: ProcessId, process: &dyn Process) {
    let checked = system.replace(id, process.clone_process());
    checked.expect("both processes were checked when the run was set up");
}

/// The exchange that an effect asks for; none for an effect on something else. `index` is the fault's place in the
/// scenario, which has loaded the machine.
pub(super) fn prepare(
    effect: &Effect,
    index: usize,
    scenario: &Scenario,
    system: &ChannelSystem,
    complaints: &mut Complaints,
) -> Option<Exchange> {
    let Effect::Machine { skill, .. } = effect else { return None };
    let chart = scenario.machines.get(&index)?;
    let topology = system.topology();
    let id = topology.find_process(&skill.value)?;
    let faulty = complaints.note(SkillProcess::new(&skill.value, chart, topology, []))?;
    let sound = SkillProcess::new(&skill.value, scenario.charts.get(&skill.value)?, topology, []).ok()?;
    Some(Exchange { id, sound: Box::new(sound), faulty: Box::new(faulty) })
}
