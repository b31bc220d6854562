//! Errors in the machines and programs of running skills and components: expressions, scripts and programs that fail.

use std::time::Duration;

use channels::{ChannelSystem, ProcessId};
use programs::ProgramProcess;
use recording::SkillError;
use remote::RemoteProcess;
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
        let skills = processes.filter(|id| mishaps(system, *id).is_some()).collect();
        Self { skills, first: Vec::new() }
    }

    /// Records new errors.
    pub(crate) fn note(&mut self, system: &ChannelSystem, time: Duration) {
        for skill in &self.skills {
            let known = self.first.iter().filter(|(noted, ..)| noted == skill).count();
            let mishaps = mishaps(system, *skill).map_or(0, <[Mishap]>::len);
            self.first.extend((known..mishaps).map(|index| (*skill, index, time)));
        }
    }

    pub(crate) fn all(&self, system: &ChannelSystem) -> Vec<SkillError> {
        let record = |(skill, index, time): &(ProcessId, usize, Duration)| {
            let Mishap { state, message, times } = mishaps(system, *skill)?.get(*index)?.clone();
            Some(SkillError { skill: system.topology().name(*skill).to_owned(), state, message, time: *time, times })
        };
        self.first.iter().filter_map(record).collect()
    }
}

/// The errors so far of a process that runs a machine or a program, or of nodes of ROS 2; `None` for any other process.
fn mishaps(system: &ChannelSystem, process: ProcessId) -> Option<&[Mishap]> {
    let of_program = || system.process::<ProgramProcess>(process).map(ProgramProcess::mishaps);
    let of_nodes = || system.process::<RemoteProcess>(process).map(RemoteProcess::mishaps);
    system.process::<SkillProcess>(process).map(SkillProcess::mishaps).or_else(of_program).or_else(of_nodes)
}
