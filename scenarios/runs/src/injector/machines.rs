//! Faults of skills: replaced machines.

use std::collections::BTreeMap;
use std::time::Duration;

use channels::{ChannelSystem, ProcessId};
use scenarios::Complaints;
use scenarios::scenario::{Behavior, Scenario};
use skills::SkillProcess;

/// The skills whose machines faults replace.
#[derive(Debug)]
pub(super) struct Machines(Vec<Skill>);

/// A skill, with its correct machine and its faulty ones.
#[derive(Debug)]
struct Skill {
    id: ProcessId,
    sound: SkillProcess,
    /// By the indices of the active faults.
    faulty: BTreeMap<Vec<usize>, SkillProcess>,
    /// The active faults that change this skill.
    holding: Vec<usize>,
}

impl Machines {
    /// The skills of a scenario whose machines faults change; the scenario has loaded these machines. Skills that
    /// `earlier` faults already change stay as they are.
    pub(super) fn prepare(
        scenario: &Scenario,
        system: &ChannelSystem,
        earlier: Option<&Self>,
        complaints: &mut Complaints,
    ) -> Self {
        let topology = system.topology();
        let mut skills = Vec::new();
        for (name, machines) in &scenario.machines {
            let found = topology.find_process(name).and_then(|id| Some((id, system.process::<SkillProcess>(id)?)));
            let Some((id, running)) = found else { continue };
            let earlier = earlier.and_then(|earlier| earlier.0.iter().find(|skill| skill.id == id));
            // The running process may have a faulty machine: the correct one is known from before the first fault.
            let (sound, holding) = earlier.map_or((running, &[][..]), |skill| (&skill.sound, &skill.holding));
            let Some((_, skill)) = scenario.machine_processes().find(|(process, _)| process == name) else { continue };
            let mut faulty = BTreeMap::new();
            for (faults, chart) in machines {
                // A model has connected its processes in its own way, which the new one keeps.
                let process = match &scenario.behavior {
                    Behavior::Model(_) => Some(sound.with_chart(chart)),
                    Behavior::Tree(_) => {
                        complaints.note(SkillProcess::new(name, chart, topology, skill.data_of(chart)))
                    }
                };
                faulty.extend(process.map(|process| (faults.clone(), process)));
            }
            skills.push(Skill { id, sound: sound.clone(), faulty, holding: holding.to_vec() });
        }
        Self(skills)
    }

    /// Makes each skill run the machine for the active faults. A machine that differs from the previous one starts now,
    /// in its initial state.
    pub(super) fn renew(&mut self, holding: &[usize], system: &mut ChannelSystem, now: Duration) {
        for skill in &mut self.0 {
            let holding: Vec<usize> = holding.iter().copied().filter(|index| skill.is_changed_by(*index)).collect();
            if holding != skill.holding {
                skill.holding = holding;
                let before = system.process::<SkillProcess>(skill.id).expect("a skill's process runs a machine");
                let successor = skill.process().succeeding(before, now);
                let checked = system.replace(skill.id, Box::new(successor));
                checked.expect("the process was checked when the run was set up");
            }
        }
    }
}

impl Skill {
    fn is_changed_by(&self, fault: usize) -> bool {
        self.faulty.contains_key([fault].as_slice())
    }

    fn process(&self) -> &SkillProcess {
        match self.holding.as_slice() {
            [] => &self.sound,
            holding => {
                self.faulty.get(holding).expect("all faults that may be active at once were combined beforehand")
            }
        }
    }
}
