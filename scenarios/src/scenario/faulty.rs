//! The files that faults need: other machines, another map.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use maps::{OccupancyGrid, Spanned};
use skills::{Chart, mutate, mutations};

use super::{Loader, ScenarioFile, unknown};
use crate::faults::{Effect, Fault, MachineChange, Trigger};

impl Loader<'_> {
    /// The machines that faults put in the place of others, by the fault's place in the scenario.
    pub(super) fn faulty_machines(
        &mut self,
        file: &ScenarioFile,
        charts: &BTreeMap<String, Arc<Chart>>,
    ) -> BTreeMap<usize, Arc<Chart>> {
        let faulty = file.faults.iter().enumerate();
        faulty.filter_map(|(index, fault)| Some((index, self.faulty_machine(file, fault, charts)?))).collect()
    }

    fn faulty_machine(
        &mut self,
        file: &ScenarioFile,
        fault: &Fault,
        charts: &BTreeMap<String, Arc<Chart>>,
    ) -> Option<Arc<Chart>> {
        let Effect::Machine { skill, change } = fault.effect() else { return None };
        if !charts.contains_key(&skill.value) {
            self.complaints.push(unknown("skill", &skill, charts.keys().map(String::as_str)));
            return None;
        }
        match change {
            MachineChange::Replaced(Spanned { value: path, span }) => {
                let text = self.text(&span, "machine", &path)?;
                self.complaints.note(Chart::load(&path.display().to_string(), &text))
            }
            MachineChange::Mutated(mutation) => {
                let path = file.skills.value.join(format!("{}.scxml", skill.value));
                let text = self.text(&skill.span, "machine", &path)?;
                let name = path.display().to_string();
                let mutant = self.complaints.note(mutate(&name, &text, &mutation))?;
                self.complaints.note(Chart::load(&format!("{name} ({})", fault.words()), &mutant))
            }
            MachineChange::MutatedAs(mistake) => {
                let path = file.skills.value.join(format!("{}.scxml", skill.value));
                let text = self.text(&skill.span, "machine", &path)?;
                let name = path.display().to_string();
                let all = self.complaints.note(mutations(&name, &text))?;
                let Some(mutation) = all.iter().find(|mutation| mutation.to_string() == mistake.value) else {
                    let all: Vec<String> = all.iter().map(ToString::to_string).collect();
                    let what = format!("mistake of {}", skill.value);
                    self.complaints.push(unknown(&what, &mistake, all.iter().map(String::as_str)));
                    return None;
                };
                let mutant = self.complaints.note(mutate(&name, &text, mutation))?;
                self.complaints.note(Chart::load(&format!("{name} ({mutation})"), &mutant))
            }
        }
    }

    /// The map that a fault gives to the software.
    pub(super) fn wrong_map(&mut self, file: &ScenarioFile) -> Option<OccupancyGrid> {
        let maps = file.faults.iter().filter_map(|fault| match fault.effect() {
            Effect::Map(path) => Some((fault, path)),
            _ => None,
        });
        let mut loaded = None;
        for (fault, path) in maps {
            let from_start = matches!(fault.timing.trigger, Trigger::Time { at: Duration::ZERO, every: None });
            if !from_start || fault.timing.lasts.is_some() || fault.timing.probability < 1.0 {
                let problem = fault.arguments().span().problem("a wrong map is wrong all the time");
                let help = "say `at_s = 0`, and neither `lasts_s` nor `probability`";
                self.complaints.push(problem.with_label("this fault").with_help(help));
                continue;
            }
            let read = |path: &Path| self.found.files.read(path);
            let map = maps::load_map(&path.value, &read);
            loaded = self.loaded(&path, "map", map);
        }
        loaded
    }
}
