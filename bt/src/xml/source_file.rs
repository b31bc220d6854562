//! A file that is being read.

use std::path::{Path, PathBuf};

use diagnostics::{Problem, Source};

use super::problems::Problems;

pub(super) struct SourceFile {
    pub(super) path: PathBuf,
    pub(super) text: Source,
    pub(super) problems: Problems,
}

impl SourceFile {
    pub(super) fn new(path: &Path, text: &str) -> Self {
        Self { path: path.to_owned(), text: Source::new(&path.display().to_string(), text), problems: Vec::new() }
    }

    /// Whether it has problems other than warnings.
    pub(super) fn is_wrong(&self) -> bool {
        self.problems.iter().any(Problem::is_error)
    }
}
