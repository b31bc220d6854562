//! The folder of a machine's file.

use std::path::{Path, PathBuf};

use diagnostics::Disk;

/// The folder in which a machine's `src` and `srcexpr` are looked up.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
    pub(crate) disk: Disk,
}

impl Folder {
    pub(crate) fn of(file: &Path, disk: &Disk) -> Self {
        Self { path: file.parent().unwrap_or_else(|| Path::new("")).to_owned(), disk: disk.clone() }
    }
}
