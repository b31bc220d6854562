//! Components from files, loaded.

use std::collections::BTreeMap;
use std::path::Path;

use channels::Symbol;
use interfaces::Interface;
use maps::Places;
use recording::TREE;
use skills::Chart;

use super::file_reader::FileReader;
use super::{ComponentEntry, ScenarioFile, Skill};
use crate::processes::TICK_GENERATOR;

/// A component from files, ready to be run.
#[derive(Clone, Debug)]
pub struct Component {
    /// What it can be asked, publishes, and does over time.
    pub interface: Interface,
    /// Its machine.
    pub machine: Skill,
}

impl FileReader<'_> {
    /// The components that the scenario describes, by name; `None` after reporting problems. Fields of the kind `place`
    /// take these places.
    pub(super) fn components(&mut self, file: &ScenarioFile, places: &Places) -> Option<BTreeMap<String, Component>> {
        let places: Vec<Symbol> = places.iter().map(|(name, _)| Symbol::new(name)).collect();
        let mut components = BTreeMap::new();
        for entry in &file.components {
            let name = &entry.name;
            if [TICK_GENERATOR, TREE].contains(&name.value.as_str()) {
                let problem = name.span.problem(format!("a component cannot be named `{}`", name.value));
                let help = "that is the name of another process";
                self.complaints.push(problem.with_label("this component").with_help(help));
                continue;
            }
            let machine = self.component_machine(entry);
            let interface = entry.interface.as_ref().map_or_else(
                || Some(Interface::default()),
                |file| {
                    let read = |path: &Path| self.files.read(path);
                    let interface = Interface::load(&file.value, &places, &read);
                    self.loaded(file, "interface", interface)
                },
            );
            if let (Some(interface), Some(machine)) = (interface, machine) {
                components.insert(name.value.clone(), Component { interface, machine });
            }
        }
        (components.len() == file.components.len()).then_some(components)
    }

    fn component_machine(&mut self, ComponentEntry { machine: path, data, .. }: &ComponentEntry) -> Option<Skill> {
        let text = self.text(&path.span, "machine", &path.value)?;
        let machine = self.complaints.note(Chart::load(&path.value.display().to_string(), &text))?;
        let mut skill = Skill { path: path.value.clone(), machine, data: BTreeMap::new() };
        self.set_data(&mut skill, data);
        Some(skill)
    }
}
