//! What results were made from, so that they can be made again.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

/// The commit of the running program.
static COMMIT: OnceLock<String> = OnceLock::new();

/// Names the commit from which the program was built, for everything that it writes. Only a program knows it; the first
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
    /// Its path, as it is named: beside the scenario, or with `./` in the current folder.
    pub path: String,
    /// The BLAKE3 hash of its contents, in hexadecimal.
    pub blake3: String,
    /// Whether it comes with the program.
    pub shipped: bool,
}
