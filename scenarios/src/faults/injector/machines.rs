//! Faults of skills: other machines take a skill's place.

use std::collections::BTreeMap;
use std::time::Duration;

use channels::{ChannelSystem, ProcessId};
use skills::SkillProcess;

use crate::error::Complaints;
use crate::scenario::Scenario;

/// The skills whose machines faults change.
#[derive(Debug)]
pub(super) struct Machines(Vec<Skill>);

/// A skill with what it runs, sound and faulty.
#[derive(Debug)]
struct Skill {
    id: ProcessId,
    sound: SkillProcess,
    /// By the places in the scenario of the faults that hold.
    faulty: BTreeMap<Vec<usize>, SkillProcess>,
    /// The faults that hold and change this skill.
    holding: Vec<usize>,
}

impl Machines {
    /// The skills of a scenario whose machines faults change; the scenario has loaded those machines.
    pub(super) fn prepare(scenario: &Scenario, system: &ChannelSystem, complaints: &mut Complaints) -> Self {
        let topology = system.topology();
        let mut skills = Vec::new();
        for (name, machines) in &scenario.machines {
            let found = topology.find_process(name).and_then(|id| Some((id, system.process::<SkillProcess>(id)?)));
            let Some((id, sound)) = found else { continue };
            let mut faulty = BTreeMap::new();
            for (faults, chart) in machines {
                let process =
                    complaints.note(SkillProcess::new(name, chart, topology, scenario.skills[name].data_of(chart)));
                faulty.extend(process.map(|process| (faults.clone(), process)));
            }
            skills.push(Skill { id, sound: sound.clone(), faulty, holding: Vec::new() });
        }
        Self(skills)
    }

    /// Lets each skill run what the faults that hold make of it. Where that is another machine than before, it starts now,
    /// in its first state.
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

    /// What it runs while those faults hold that do.
    fn process(&self) -> &SkillProcess {
        match self.holding.as_slice() {
            [] => &self.sound,
            holding => self.faulty.get(holding).expect("all faults that may hold at once were combined beforehand"),
        }
    }
}
