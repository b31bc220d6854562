//! What results were made from, so that they can be made again.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

static COMMIT: OnceLock<String> = OnceLock::new();

/// Names the commit from which the program was built, for everything that it writes. Only programs have one; the first
/// name stays.
pub fn set_commit(commit: impl Into<String>) {
    let _ = COMMIT.set(commit.into());
}

/// The commit from which the program was built, if it is known.
#[must_use]
pub fn commit() -> Option<String> {
    COMMIT.get().cloned()
}

/// What a result was made from, besides seed and version.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// The commit from which the program was built; null if it is unknown.
    pub commit: Option<String>,
    /// The scenario's name on the command line.
    pub scenario: String,
    /// What the command line changed, in the syntax of `--set`.
    pub set: Vec<String>,
    /// The files that were read, in alphabetical order.
    pub inputs: Vec<InputFile>,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Its path, as it is named: in a scenario's results beside the scenario, or with `./` in the current folder.
    pub path: String,
    /// The BLAKE3 hash of its contents, in hexadecimal.
    pub blake3: String,
    /// Whether it comes with the program.
    pub shipped: bool,
}

impl InputFile {
    /// A file on disk, as it is now.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn on_disk(path: &Path) -> io::Result<Self> {
        let hash = blake3::Hasher::new().update_reader(File::open(path)?)?.finalize();
        Ok(Self { path: path.display().to_string(), blake3: hash.to_hex().to_string(), shipped: false })
    }

    /// A file that comes with the program.
    #[must_use]
    pub fn shipped(path: &Path, text: &str) -> Self {
        let blake3 = blake3::hash(text.as_bytes()).to_hex().to_string();
        Self { path: path.display().to_string(), blake3, shipped: true }
    }
}

impl Provenance {
    /// What the running program makes from these files.
    #[must_use]
    pub fn of_files(inputs: Vec<InputFile>) -> Self {
        Self { commit: commit(), inputs, ..Self::default() }
    }

    /// Version and settings as facts: what they are about, and what they are.
    #[must_use]
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let commit = self.commit.clone().unwrap_or_else(|| "unknown".to_owned());
        let set = (!self.set.is_empty()).then(|| ("set", self.set.join(" ")));
        [("version", env!("CARGO_PKG_VERSION").to_owned()), ("commit", commit)].into_iter().chain(set).collect()
    }
}
