//! Faults whose beginnings and ends a proof or a schedule determines.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Disturbance, DisturbanceId, Process, ProcessId};
use components::{BatteryReader, LOCALIZATION, Navigation};
use devices::DeviceProcess;
use diagnostics::Spanned;
use scenarios::Complaints;
use scenarios::names::unknown;
use scenarios::scenario::{AllowedFault, Scenario};
use skills::{Chart, SkillProcess, find_mutation, mutate, mutations};

use crate::injector::opposite;

/// A fault that may begin and end at any time.
#[derive(Clone, Debug)]
pub struct Switched {
    /// Its kind.
    pub kind: AllowedFault,
    /// The component, or the skill with its mistake.
    pub name: String,
    /// The process on which it acts.
    pub process: ProcessId,
    /// What it does.
    pub effect: SwitchedEffect,
    /// Its beginning, in words.
    pub begins: String,
    /// Its end, in words.
    pub ends: String,
}

/// What it does, as in a run.
#[derive(Clone, Debug)]
pub enum SwitchedEffect {
    /// The process does nothing; if it has crashed, it starts again when the fault ends.
    Outage {
        /// Whether it forgets everything.
        crashed: bool,
    },
    /// It sends the opposite of each message.
    WrongReply,
    /// It runs another machine, from its initial state.
    Machine {
        /// The machine with the mistake.
        mutant: Box<SkillProcess>,
        /// The machine without it.
        sound: Box<SkillProcess>,
    },
}

impl Switched {
    /// The fault of this kind with this name. Problems are recorded, and the result is then `None`.
    pub fn named(
        kind: AllowedFault,
        name: &Spanned<String>,
        scenario: &Scenario,
        system: &ChannelSystem,
        complaints: &mut Complaints,
    ) -> Option<Self> {
        match kind {
            AllowedFault::Mutant => mutated(scenario, system, name, complaints),
            _ => of_component(scenario, system, kind, name, complaints),
        }
    }
}

fn of_component(
    scenario: &Scenario,
    system: &ChannelSystem,
    kind: AllowedFault,
    name: &Spanned<String>,
    complaints: &mut Complaints,
) -> Option<Switched> {
    let known = || scenario.component_names();
    let Some(process) =
        known().find(|known| *known == name.value).and_then(|name| system.topology().find_process(name))
    else {
        complaints.push(unknown("component", name, known()));
        return None;
    };
    let is_builtin = !scenario.components.contains_key(&name.value);
    if kind == AllowedFault::Crash && name.value == LOCALIZATION && is_builtin {
        let problem = name.span.problem("after a crash, Localization puts the robot where it started");
        let help = "that depends on the map; allow `component_frozen` or `component_wrong_reply` instead";
        complaints.push(problem.with_label("a proof cannot know what it would report then").with_help(help));
        return None;
    }
    let (effect, begins, ends) = match kind {
        AllowedFault::Crash => (SwitchedEffect::Outage { crashed: true }, "crashes", "begins anew"),
        AllowedFault::Frozen => (SwitchedEffect::Outage { crashed: false }, "hangs", "goes on"),
        _ => (SwitchedEffect::WrongReply, "reports the opposite of the truth", "reports the truth again"),
    };
    let words = |what: &str| format!("{} {what}", name.value);
    Some(Switched { kind, name: name.value.clone(), process, effect, begins: words(begins), ends: words(ends) })
}

fn mutated(
    scenario: &Scenario,
    system: &ChannelSystem,
    name: &Spanned<String>,
    complaints: &mut Complaints,
) -> Option<Switched> {
    let (skill, mistake) = name.value.split_once(": ").unwrap_or((&name.value, ""));
    let Some((_, sound)) = scenario.machine_processes().find(|(known, _)| *known == skill) else {
        let named = Spanned { value: skill.to_owned(), span: name.span.clone() };
        complaints.push(unknown("skill", &named, scenario.machine_processes().map(|(known, _)| known)));
        return None;
    };
    let file = sound.machine.file();
    let Some(found) = complaints.note(find_mutation(file.name(), file.text(), mistake))? else {
        let all = complaints.note(mutations(file.name(), file.text()))?;
        let all: Vec<String> = all.iter().map(|mutation| format!("{skill}: {mutation}")).collect();
        complaints.push(unknown("mutant", name, all.iter().map(String::as_str)));
        return None;
    };
    let text = complaints.note(mutate(file.name(), file.text(), &found))?;
    let chart = complaints.note(Chart::load(&format!("{} ({mistake})", file.name()), &text))?;
    // The mutant replaces a process of the wired system: it must get by with the channels that exist.
    let topology = system.topology();
    let mutant = complaints.note(SkillProcess::new(skill, &chart, topology, sound.data_of(&chart)))?;
    let process = topology.find_process(skill)?;
    let sound = system.process::<SkillProcess>(process)?.clone();
    Some(Switched {
        kind: AllowedFault::Mutant,
        name: name.value.clone(),
        process,
        effect: SwitchedEffect::Machine { mutant: Box::new(mutant), sound: Box::new(sound) },
        begins: name.value.clone(),
        ends: format!("{skill} runs its own machine again"),
    })
}

/// A process starts again, as after a crash.
pub fn restart(process: &mut dyn Process, now: Duration) {
    let process = process.as_any_mut();
    if let Some(skill) = process.downcast_mut::<SkillProcess>() {
        *skill = skill.succeeding(skill, now);
    } else if let Some(device) = process.downcast_mut::<DeviceProcess>() {
        device.restart(now);
    } else if let Some(battery) = process.downcast_mut::<BatteryReader>() {
        battery.restart();
    } else if let Some(navigation) = process.downcast_mut::<Navigation>() {
        navigation.restart();
    }
}

/// The faults of a schedule, which begin and end in a channel system.
#[derive(Debug, Default)]
pub(crate) struct Switchboard {
    faults: Vec<Switched>,
    /// The active faults, each with its effect on messages.
    active: Vec<(usize, Vec<DisturbanceId>)>,
}

impl Switchboard {
    /// The number of a fault.
    pub(crate) fn find(&self, kind: AllowedFault, name: &str) -> Option<usize> {
        self.faults.iter().position(|fault| fault.kind == kind && fault.name == name)
    }

    pub(crate) fn add(&mut self, fault: Switched) {
        self.faults.push(fault);
    }

    pub(crate) fn switch(&mut self, fault: usize, begins: bool, system: &mut ChannelSystem, now: Duration) {
        let Switched { process, effect, .. } = &self.faults[fault];
        let (id, before) = (*process, self.active.iter().position(|(active, _)| *active == fault));
        let ended = before.filter(|_| !begins).map(|index| self.active.remove(index).1);
        let mut disturbances = Vec::new();
        // The process that takes its place, if one does. During an outage, the process is only suspended: one that
        // hangs goes on where it was, and one that has crashed starts again at the end.
        let successor = match effect {
            SwitchedEffect::Outage { .. } if begins => None,
            SwitchedEffect::Outage { crashed } => system.clone_process(id).filter(|_| *crashed).map(|mut process| {
                restart(process.as_mut(), now);
                process
            }),
            SwitchedEffect::WrongReply => {
                ended.into_iter().flatten().for_each(|disturbance| _ = system.calm(disturbance));
                let topology = Arc::clone(system.topology());
                let sent = topology.channels().filter(|channel| topology.get(*channel).source == id && begins);
                let effect = |channel| channels::Effect::Replace(opposite(&topology, channel));
                disturbances.extend(sent.map(|channel| system.disturb(Disturbance::all(channel, effect(channel)))));
                None
            }
            SwitchedEffect::Machine { mutant, sound } => {
                let next = if begins { mutant } else { sound };
                let before = system.process::<SkillProcess>(id);
                before.map(|before| Box::new(next.succeeding(before, now)) as Box<dyn Process>)
            }
        };
        if let Some(successor) = successor {
            system.replace(id, successor).expect("it keeps its channels");
        }
        if begins {
            self.active.push((fault, disturbances));
        }
        self.suspend_or_resume(id, system);
    }

    /// Several faults may have stopped the same process: it continues when the last of them has ended.
    fn suspend_or_resume(&self, id: ProcessId, system: &mut ChannelSystem) {
        let is_out = |(fault, _): &(usize, _)| {
            let fault = &self.faults[*fault];
            fault.process == id && matches!(fault.effect, SwitchedEffect::Outage { .. })
        };
        let is_out = self.active.iter().any(is_out);
        if system.is_suspended(id) != is_out {
            system.suspend(id, is_out);
        }
    }
}
