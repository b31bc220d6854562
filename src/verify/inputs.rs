//! The files with which a log is judged.

use std::path::{Path, PathBuf};

use checks::named_files;
use diagnostics::Disk;
use recording::InputFile;
use scenarios::files::Kind;

/// The files that this process has read, and the shipped files among these property files. A file is hashed as it is
/// now. Files and folders in `others` are excluded: they belong to other logs, or are still being written.
pub(crate) fn inputs(properties: &[PathBuf], others: &[&Path]) -> Vec<InputFile> {
    let is_other = |file: &Path| others.iter().any(|other| file.starts_with(other));
    let read = diagnostics::files_read().into_iter().filter(|file| !is_other(file));
    // A file that no longer exists has no hash.
    let on_disk = read.filter_map(|file| InputFile::on_disk(&file).ok());
    let shipped = properties.iter().filter_map(|name| {
        let disk = Disk::default();
        let (path, text) = named_files::read(&disk, Kind::Properties, name).ok()?;
        Kind::Properties.is_shipped(name, &disk).then(|| InputFile::shipped(&path, &text))
    });
    let mut all: Vec<InputFile> = on_disk.chain(shipped).collect();
    all.sort_by(|one, other| one.path.cmp(&other.path));
    all
}
