//! The RoAML model of a scenario, which takes the place of tree, skills and components.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use diagnostics::Spanned;
use diagnostics::document::Table;
use interfaces::Interface;
use roaml::Model;

use super::file::Execution;
use super::file_reader::FileReader;
use super::{Component, Runs, Skill};
use crate::files::named;

/// The keys that describe what a model has itself.
const OF_THE_MODEL: [&str; 5] = ["tree", "skills", "leaves", "components", "map"];

/// The model of a scenario file.
#[derive(Clone, Debug)]
pub struct ModelEntry {
    /// Its main file.
    pub path: Spanned<PathBuf>,
    /// The keys of the table `execution` that the scenario sets itself.
    set: Vec<String>,
}

impl ModelEntry {
    /// Reads the key `model`, and refuses what the model has itself.
    pub(super) fn read(root: Table<'_>) -> Option<Self> {
        let path = root.text("model").try_map(|path, span| Ok(named(path, span))).spanned().optional()?;
        for (key, span) in root.keys().filter(|(key, _)| OF_THE_MODEL.contains(key)) {
            let problem = span.problem(format!("`{key}` has no place beside a `model`"));
            let help = "a RoAML model has a tree and machines of its own, and no map: remove one of the two keys";
            root.report(problem.with_label("this key").with_help(help));
        }
        let _ = (root.text("tree").optional(), root.text("skills").optional());
        let execution = root.table("execution").optional();
        let set = execution.into_iter().flat_map(|table| table.keys()).map(|(key, _)| key.to_owned()).collect();
        Some(Self { path, set })
    }

    /// Takes over from the model what the scenario does not set.
    fn complete(&self, execution: &mut Execution, parameters: &roaml::Parameters) {
        let is_open = |key: &str| !self.set.iter().any(|set| set == key);
        if is_open("tick_s") {
            execution.tick = parameters.tick;
        }
        if is_open("max_time_s") {
            execution.max_time = parameters.max_time;
        }
        if is_open("leaf_timeout_s") {
            // AS2FM waits for an answer for as long as it takes.
            execution.leaf_timeout = execution.max_time + Duration::from_secs(1);
        }
    }
}

impl FileReader<'_> {
    /// The model, unless `known` is the same one; its parameters become those of the run.
    pub(super) fn model(
        &mut self,
        entry: &ModelEntry,
        known: Option<&Arc<Model>>,
        execution: &mut Execution,
    ) -> Option<Arc<Model>> {
        let read = |path: &Path| self.files.read_text(path);
        let model = match known {
            Some(known) => Arc::clone(known),
            None => Arc::new(self.complaints.note(Model::load(&entry.path.value, &read))?),
        };
        entry.complete(execution, &model.parameters);
        Some(model)
    }
}

/// The skills and the components of a model: the machines of leaves, and all others.
pub(super) fn machines(model: &Model) -> (BTreeMap<String, Skill>, BTreeMap<String, Component>) {
    let (mut skills, mut components) = (BTreeMap::new(), BTreeMap::new());
    for process in model.processes() {
        let machine = Arc::clone(process.machine.chart());
        let skill = Skill { path: PathBuf::from(machine.file().name()), machine, data: BTreeMap::new() };
        if process.is_leaf {
            skills.insert(process.name, skill);
        } else {
            let component = Component { interface: Interface::default(), runs: Runs::Machine(skill) };
            components.insert(process.name, component);
        }
    }
    (skills, components)
}
