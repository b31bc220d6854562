//! Where a machine comes from.

use std::path::Path;
use std::sync::Arc;

use diagnostics::Source;

use super::files;
use crate::Strictness;
use crate::chart::Chart;

/// Where a machine comes from, and how strictly it is read.
#[derive(Clone, Debug)]
pub(super) struct Origin<'o> {
    pub(super) file: Source,
    /// What the machine is called if it does not say so itself.
    pub(super) stem: &'o str,
    pub(super) strictness: Strictness,
    /// Where files are looked up.
    pub(super) folder: Option<Arc<Path>>,
    /// Whether the machines are looked at that are invoked from files.
    pub(super) looks_further: bool,
}

impl Origin<'_> {
    /// The text of a file beside the machine's.
    pub(super) fn read(&self, address: &str) -> Result<String, String> {
        files::read(&files::path(address, self.folder.as_deref())?)
    }

    /// Whether a file can be invoked as a machine.
    pub(super) fn try_invoked(&self, address: &str) -> Result<(), String> {
        let path = files::path(address, self.folder.as_deref())?;
        if !self.looks_further {
            return Ok(());
        }
        Chart::open_with(&path, self.strictness, false).map(|_| ()).map_err(|error| error.to_string())
    }
}
