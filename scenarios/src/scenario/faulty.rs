//! The files that faults require: other machines, or another map.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use diagnostics::{Span, Spanned};
use roaml::Model;
use skills::{Chart, Mutation, SkillError, find_mutation, mutate_all, mutations};

use super::file_reader::{FileReader, FileRole, LoadedMap};
use super::{Component, STEP, ScenarioFile, Skill};
use crate::faults::{Effect, Fault, MachineChange, Trigger};
use crate::files::Kind;
use crate::names::unknown;

/// The machines that a skill runs while faults change it, by the sorted indices of these faults: one for each set that
/// may be active together.
pub type FaultyMachines = BTreeMap<Vec<usize>, Arc<Chart>>;

/// The maximum number of combinations of faults of one skill's machine that may be active together. Each is loaded
/// before the run, and they double with each fault. Chosen, not measured.
const MOST_COMBINATIONS: usize = 100;

/// A machine's file: its name and its text.
type MachineFile = (String, String);

struct Changing<'f> {
    index: usize,
    fault: &'f Fault,
    change: LoadedChange,
}

enum LoadedChange {
    Replaced(MachineFile),
    Mutated(Mutation),
}

impl Changing<'_> {
    fn span(&self) -> &Span {
        self.fault.arguments().span()
    }
}

impl FileReader<'_> {
    /// The machines that skills run while faults change them, by skill.
    pub(super) fn faulty_machines(
        &mut self,
        file: &ScenarioFile,
        model: Option<&Model>,
        skills: &BTreeMap<String, Skill>,
        components: &BTreeMap<String, Component>,
    ) -> BTreeMap<String, FaultyMachines> {
        let machine = |name: &str| skills.get(name).or_else(|| components.get(name)?.machine());
        let mut faults: BTreeMap<String, Vec<(usize, &Fault, MachineChange)>> = BTreeMap::new();
        for (index, fault) in file.faults.iter().enumerate() {
            let Effect::Machine { skill, change } = fault.effect() else { continue };
            if machine(&skill.value).is_some() {
                faults.entry(skill.value).or_default().push((index, fault, change));
            } else {
                let known =
                    skills.keys().chain(components.keys()).map(String::as_str).filter(|name| machine(name).is_some());
                self.complaints.push(unknown("skill", &skill, known));
            }
        }
        let mut machines = BTreeMap::new();
        for (skill, faults) in faults {
            let Some(Skill { path, .. }) = machine(&skill) else { continue };
            // Faults change the SCXML document into which a model's machine was translated.
            let translated = model.and_then(|model| model.processes().find(|process| process.name == skill));
            let text = match (&translated, file.behavior.files()) {
                (Some(process), _) => Some(process.machine.scxml().to_owned()),
                (None, files) => files.and_then(|files| self.text(&files.skills.span, FileRole::Of(Kind::Skill), path)),
            };
            let Some(text) = text else { continue };
            let sound = (path.display().to_string(), text);
            let changing = faults.into_iter().filter_map(|(index, fault, change)| {
                let of_model = translated.as_ref().map(|process| process.machine);
                let change = self.change(change, &skill, &sound, of_model)?;
                Some(Changing { index, fault, change })
            });
            let changing: Vec<Changing<'_>> = changing.collect();
            machines.insert(skill, self.combined(&sound, &changing));
        }
        machines
    }

    fn change(
        &mut self,
        change: MachineChange,
        skill: &str,
        (name, text): &MachineFile,
        of_model: Option<&roaml::Machine>,
    ) -> Option<LoadedChange> {
        Some(match change {
            MachineChange::Replaced(Spanned { value: path, span }) => {
                let name = path.display().to_string();
                let mut text = self.text(&span, FileRole::Of(Kind::Skill), &path)?;
                // A machine of a model is written in RoAML's SCXML: the new one is translated as the old one was.
                if let Some(machine) = of_model {
                    match machine.load_instead(&name, &text) {
                        Ok(other) => text = other.scxml().to_owned(),
                        Err(problems) => {
                            problems.into_iter().for_each(|problem| self.complaints.push(problem));
                            return None;
                        }
                    }
                }
                LoadedChange::Replaced((name, text))
            }
            MachineChange::Mutated(mutation) => LoadedChange::Mutated(mutation),
            MachineChange::MutatedAs(mistake) => {
                let Some(found) = self.complaints.note(find_mutation(name, text, &mistake.value))? else {
                    let all = self.complaints.note(mutations(name, text))?;
                    let all: Vec<String> = all.iter().map(ToString::to_string).collect();
                    let what = format!("mistake of {skill}");
                    self.complaints.push(unknown(&what, &mistake, all.iter().map(String::as_str)));
                    return None;
                };
                LoadedChange::Mutated(found)
            }
        })
    }

    /// The machine of every combination of faults that may be active together.
    fn combined(&mut self, sound: &MachineFile, changing: &[Changing<'_>]) -> FaultyMachines {
        let mut machines = FaultyMachines::new();
        let mut combinations: Vec<Vec<&Changing<'_>>> = Vec::new();
        for one in changing {
            let overlaps = |other: &&Changing<'_>| other.fault.timing.may_overlap(&one.fault.timing, STEP);
            let others = combinations.iter().filter(|others| others.iter().all(overlaps));
            let with_one: Vec<_> =
                std::iter::once(&Vec::new()).chain(others).map(|them| [them, &[one][..]].concat()).collect();
            if combinations.len() + with_one.len() > MOST_COMBINATIONS {
                let problem = one.span().problem("too many faults of one skill's machine may be active at once");
                let help = format!(
                    "separate them with `at_s` and `lasts_s`; at most {MOST_COMBINATIONS} combinations are possible"
                );
                self.complaints.push(problem.with_label("one too many").with_help(help));
                break;
            }
            for combination in with_one {
                // A fault that is wrong on its own is reported once, and not again in every combination.
                let Some(chart) = self.machine(sound, &combination) else {
                    if combination.len() == 1 { break } else { continue }
                };
                machines.insert(combination.iter().map(|one| one.index).collect(), chart);
                combinations.push(combination);
            }
        }
        machines
    }

    /// The machine while these faults are active, or a problem reported at the last of them.
    fn machine(&mut self, sound: &MachineFile, faults: &[&Changing<'_>]) -> Option<Arc<Chart>> {
        let refused = match (changed(sound, faults), faults) {
            (Ok(chart), _) => return Some(chart),
            (Err(error), [] | [_]) => return self.complaints.note(Err(error)),
            (Err(error), [others @ .., last]) => {
                let others: Vec<String> = others.iter().map(|other| format!("\"{}\"", other.fault.words())).collect();
                let message = format!("this fault cannot be active together with {}: {error}", others.join(" and "));
                last.span().problem(message).with_label("this fault")
            }
        };
        self.complaints.push(refused.with_help("start one after the other has ended, with `at_s` and `lasts_s`"));
        None
    }
}

/// The machine while these faults are active: the last replacement among them, or otherwise the correct machine, with
/// the mistakes of all the others.
fn changed(sound: &MachineFile, faults: &[&Changing<'_>]) -> Result<Arc<Chart>, SkillError> {
    let replacement = faults.iter().rev().find_map(|one| match &one.change {
        LoadedChange::Replaced(file) => Some(file),
        LoadedChange::Mutated(_) => None,
    });
    let (name, text) = replacement.unwrap_or(sound);
    let mutated = faults.iter().filter_map(|one| match &one.change {
        LoadedChange::Replaced(_) => None,
        LoadedChange::Mutated(mutation) => Some((mutation, one.fault.words())),
    });
    let (mutations, words): (Vec<&Mutation>, Vec<String>) = mutated.unzip();
    if mutations.is_empty() {
        return Chart::load(name, text);
    }
    Chart::load(&format!("{name} ({})", words.join("; ")), &mutate_all(name, text, mutations)?)
}

impl FileReader<'_> {
    /// The map that a fault gives to the software, and the warnings about it.
    pub(super) fn wrong_map(&mut self, file: &ScenarioFile) -> Option<LoadedMap> {
        let maps = file.faults.iter().filter_map(|fault| match fault.effect() {
            Effect::Map(path) => Some((fault, path)),
            _ => None,
        });
        let mut loaded = None;
        for (fault, path) in maps {
            let from_start = matches!(fault.timing.trigger, Trigger::Time { at: Duration::ZERO, every: None });
            if !from_start || fault.timing.lasts.is_some() || fault.timing.probability < 1.0 {
                let problem = fault.arguments().span().problem("a wrong map lasts for the whole run");
                let help = "set `at_s = 0`, and neither `lasts_s` nor `probability`";
                self.complaints.push(problem.with_label("this fault").with_help(help));
                continue;
            }
            loaded = self.map(&path);
        }
        loaded
    }
}
