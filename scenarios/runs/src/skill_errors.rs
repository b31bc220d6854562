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

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Arc;
    use std::time::Duration;

    use recording::{Detail, Ended, Happening};
    use scenarios::scenario::{Scenario, find};

    use crate::Run;

    /// The errors of the tree and of skills in a run of some seconds, in which a leaf works until it is halted.
    fn errors(work: &str) -> (Vec<String>, Vec<String>) {
        let folder = tempfile::tempdir().expect("a folder");
        let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="T"><Fallback><ReactiveSequence>
            <Condition ID="Early"/><Action ID="Work"/></ReactiveSequence><AlwaysSuccess/></Fallback></BehaviorTree></root>"#;
        let machine = |name: &str, body: &str| {
            format!(
                r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="{name}">
                <datamodel><data id="asked" expr="0"/></datamodel><state id="s">{body}</state></scxml>"#
            )
        };
        let answer = |event: &str, with: &str| {
            format!(r#"<transition event="{event}"><send type="channel" target="BT" event="{with}"/></transition>"#)
        };
        // At the second tick, it is no longer early, so the work is halted.
        let early = machine(
            "Early",
            r#"<transition event="BT.tick" cond="asked == 0"><assign location="asked" expr="1"/>
            <send type="channel" target="BT" event="success"/></transition>
            <transition event="BT.tick"><send type="channel" target="BT" event="failure"/></transition>"#,
        );
        let work = machine("Work", &(answer("BT.tick", "running") + work));
        let scenario = "tree = \"t.xml\"\nskills = \".\"\nexecution.max_time_s = 4.5\n";
        for (name, text) in [("t.xml", tree), ("Early.scxml", &early), ("Work.scxml", &work), ("s.toml", scenario)] {
            fs::write(folder.path().join(name), text).expect("room for a file");
        }
        let found = find::find(folder.path().join("s.toml").to_str().expect("UTF-8")).expect("it was written");
        let scenario = Scenario::load(&found, &[]).expect("a sound scenario");
        let mut run = Run::new(Arc::new(scenario), 1, true).expect("a sound scenario");
        let mut of_tree = Vec::new();
        while run.time() < Duration::from_millis(4_500) {
            run.step().expect("no process gets stuck");
            of_tree.extend(run.record(Detail::Verdicts).happenings.into_iter().filter_map(
                |happening| match happening {
                    Happening::TreeError { message, .. } => Some(message),
                    _ => None,
                },
            ));
        }
        let of_skills =
            run.end(Ended::Interrupted, Detail::Verdicts).skill_errors.into_iter().map(|error| error.message).collect();
        (of_tree, of_skills)
    }

    #[test]
    fn a_halt_that_is_never_confirmed_is_an_error_of_the_run() {
        let confirmed = r#"<transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition>"#;
        assert_eq!(errors(confirmed), (vec![], vec![]));
        // The timeout ends when the next tick is due, which begins with a clean tree.
        let ignored = r#"<transition event="BT.halt"/>"#;
        assert_eq!(errors(ignored).0, ["Work did not confirm that it has halted within 2 s"]);
    }

    #[test]
    fn a_skill_that_answers_twice_makes_an_error() {
        let twice = r#"<transition event="BT.halt"><send type="channel" target="BT" event="halted"/>
            <send type="channel" target="BT" event="halted"/></transition>"#;
        let (of_tree, of_skills) = errors(twice);
        assert_eq!(of_tree, Vec::<String>::new());
        assert_eq!(of_skills.len(), 1, "{of_skills:?}");
        assert!(of_skills[0].contains("BT has had its answer"), "{of_skills:?}");
    }
}
