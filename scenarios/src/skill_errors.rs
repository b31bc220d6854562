//! Errors in the machines of running skills: expressions and scripts that fail.

use std::time::Duration;

use channels::{ChannelSystem, ProcessId};
use recording::SkillError;
use skills::{Mishap, SkillProcess};

/// The first occurrences of all errors in skills.
#[derive(Clone, Debug, Default)]
pub(crate) struct SkillErrors {
    skills: Vec<ProcessId>,
    /// The skill, and the index of its mishap.
    first: Vec<(ProcessId, usize, Duration)>,
}

impl SkillErrors {
    pub(crate) fn of(system: &ChannelSystem) -> Self {
        let processes = system.topology().processes();
        let skills = processes.filter(|id| system.process::<SkillProcess>(*id).is_some()).collect();
        Self { skills, first: Vec::new() }
    }

    /// Records new errors.
    pub(crate) fn note(&mut self, system: &ChannelSystem, time: Duration) {
        for skill in &self.skills {
            let known = self.first.iter().filter(|(noted, ..)| noted == skill).count();
            let mishaps = mishaps(system, *skill).len();
            self.first.extend((known..mishaps).map(|index| (*skill, index, time)));
        }
    }

    pub(crate) fn all(&self, system: &ChannelSystem) -> Vec<SkillError> {
        let told = |(skill, index, time): &(ProcessId, usize, Duration)| {
            let Mishap { state, message, times } = mishaps(system, *skill)[*index].clone();
            SkillError { skill: system.topology().name(*skill).to_owned(), state, message, time: *time, times }
        };
        self.first.iter().map(told).collect()
    }
}

fn mishaps(system: &ChannelSystem, skill: ProcessId) -> &[Mishap] {
    system.process::<SkillProcess>(skill).map_or(&[], SkillProcess::mishaps)
}
