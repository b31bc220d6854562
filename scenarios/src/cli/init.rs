//! `steward init`: a copy of a scenario with everything it names, for editing.

use std::path::Path;

use super::print;
use crate::Error;
use crate::files::{Files, shipped_paths};
use crate::scenario::{ScenarioFile, find};

/// Writes the scenario and the files that come with the program to `dir`, so that the paths in the scenario hold there.
pub(super) fn init(dir: &Path, scenario: &str) -> Result<(), Error> {
    let shipped = find::shipped(scenario)?;
    if std::fs::read_dir(dir).is_ok_and(|mut entries| entries.next().is_some()) {
        let message = format!("{} is not empty", dir.display());
        return Err(Error::refused(message, "name a new folder: nothing is overwritten"));
    }
    let file = dir.join(Path::new(shipped).file_name().unwrap_or_default());
    write(shipped, &file)?;
    for base in ScenarioFile::bases(shipped, &Files::shipped())? {
        write(&base, &dir.join(&base))?;
    }
    for path in shipped_paths().filter(|path| !path.starts_with("scenarios/")) {
        write(path, &dir.join(path))?;
    }
    print(&format!("wrote {0}; run it with: steward --scenario {0}\n", file.display()))
}

fn write(shipped: &str, copy: &Path) -> Result<(), Error> {
    let failed = |source| Error::Write { path: copy.to_owned(), source };
    let bytes = Files::shipped().read(Path::new(shipped)).map_err(failed)?;
    std::fs::create_dir_all(copy.parent().unwrap_or(copy)).map_err(failed)?;
    std::fs::write(copy, bytes).map_err(failed)
}
