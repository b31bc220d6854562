//! The origin of a machine.

use std::borrow::Cow;
use std::path::Path;

use diagnostics::Source;

use super::files;
use crate::Strictness;
use crate::chart::Chart;
use crate::folder::Folder;

/// The origin of a machine, and how strictly it is checked.
#[derive(Debug)]
pub(super) struct Origin {
    pub(super) file: Source,
    pub(super) strictness: Strictness,
    /// The folder in which files are looked up.
    pub(super) folder: Option<Folder>,
    /// Whether machines that are invoked from files are checked, too.
    pub(super) looks_further: bool,
}

impl Origin {
    /// The origin of a text that is given, without access to files.
    pub(super) fn of(file: &str, text: &str, strictness: Strictness) -> Self {
        Self { file: Source::new(file, text), strictness, folder: None, looks_further: false }
    }

    /// The name of a machine that does not name itself.
    pub(super) fn stem(&self) -> Cow<'_, str> {
        let file = self.file.name();
        Path::new(file).file_stem().map_or(file.into(), |stem| stem.to_string_lossy())
    }

    /// The text of a file beside the machine's.
    pub(super) fn read(&self, address: &str) -> Result<String, String> {
        let (path, folder) = files::path(address, self.folder.as_ref())?;
        files::read(&path, &folder.disk)
    }

    /// Whether a file can be invoked as a machine.
    pub(super) fn try_invoked(&self, address: &str) -> Result<(), String> {
        let (path, folder) = files::path(address, self.folder.as_ref())?;
        if !self.looks_further {
            return Ok(());
        }
        Chart::open_with(&path, &folder.disk, self.strictness, false).map(|_| ()).map_err(|error| error.to_string())
    }
}
