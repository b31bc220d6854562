//! A scenario file's settings for a RoAML model.

use std::path::PathBuf;

use diagnostics::Spanned;
use diagnostics::document::{Referent, Table};

use crate::files::path;

/// The keys that describe what a model itself contains.
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
    /// Reads the key `model`, and refuses keys that describe what the model itself contains.
    pub(super) fn read(root: Table<'_>) -> Option<Self> {
        let path = path(
            root,
            "model",
            "A RoAML model: its main file. It replaces `tree`, `skills`, `leaves` and `components`, and has no map. \
             It also gives `execution.tick_s` and `execution.max_time_s`, unless they are set.",
        );
        let path = path.refers_to(Referent::File(&["xml"])).optional()?;
        for (key, span) in root.keys().filter(|(key, _)| OF_THE_MODEL.contains(key)) {
            let problem = span.problem(format!("`{key}` is not allowed beside a `model`"));
            let help = "a RoAML model has its own tree and machines, and no map: remove one of the two keys";
            root.report(problem.with_label("this key").with_help(help));
        }
        ["tree", "skills"].into_iter().for_each(|key| root.know(key));
        let execution = root.table("execution").optional();
        let set = execution.into_iter().flat_map(|table| table.keys()).map(|(key, _)| key.to_owned()).collect();
        Some(Self { path, set })
    }

    /// Whether the scenario sets this key of the table `execution` itself.
    pub(super) fn sets(&self, key: &str) -> bool {
        self.set.iter().any(|set| set == key)
    }
}
