//! The RoAML model of a scenario, which replaces tree, skills and components.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use interfaces::Interface;
use roaml::Model;

use super::execution::Execution;
use super::file_reader::FileReader;
use super::model_entry::ModelEntry;
use super::{Component, Runs, Skill};

/// Takes from the model what the scenario does not set.
fn complete(entry: &ModelEntry, execution: &mut Execution, parameters: &roaml::Parameters) {
    let is_open = |key: &str| !entry.sets(key);
    if is_open("tick_s") {
        execution.tick = parameters.tick;
    }
    if is_open("max_time_s") {
        execution.max_time = parameters.max_time;
    }
    if is_open("leaf_timeout_s") {
        // AS2FM waits for an answer forever.
        execution.leaf_timeout = execution.max_time + Duration::from_secs(1);
    }
}

impl FileReader<'_> {
    /// The model; its parameters become those of the run.
    pub(super) fn model(&mut self, entry: &ModelEntry, execution: &mut Execution) -> Option<Arc<Model>> {
        let path = &entry.path.value;
        let model = self.files.load(path, (), |read| {
            let read = |path: &Path| diagnostics::text(read(path)?);
            Model::load(path, &read).map(Arc::new)
        });
        let model = self.complaints.note(model)?;
        complete(entry, execution, &model.parameters);
        Some(model)
    }
}

/// The skills and the components of a model: the machines of leaves, and all the others.
pub(super) fn machines(model: &Model) -> (BTreeMap<String, Skill>, BTreeMap<String, Component>) {
    let (mut skills, mut components) = (BTreeMap::new(), BTreeMap::new());
    for process in model.processes() {
        let machine = Arc::clone(process.machine.chart());
        let skill = Skill { path: PathBuf::from(machine.file().name()), machine, place: None, data: BTreeMap::new() };
        if process.is_leaf {
            skills.insert(process.name, skill);
        } else {
            let component = Component { interface: Interface::default(), runs: Runs::Machine(skill) };
            components.insert(process.name, component);
        }
    }
    (skills, components)
}
