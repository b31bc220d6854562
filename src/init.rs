//! `steward init`: a copy of a scenario with everything it names, for editing.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use campaigns::Error;
use diagnostics::Staging;
use scenarios::files::shipped_paths;
use scenarios::scenario::{Scenario, ScenarioFile, find};

use crate::output::print;

/// Writes a scenario, what it names and what comes with the program to `dir`, so that the paths in the scenario hold there.
pub(crate) fn init(dir: &Path, scenario: &str) -> Result<(), Error> {
    let mut found = find::find(scenario)?;
    let copies = Staging::begin(dir)?;
    if !copies.is_alone()? {
        let message = format!("{} is not empty", dir.display());
        return Err(Error::refused(message, "name a new folder: nothing is overwritten"));
    }
    found.files = found.files.remembering();
    Scenario::load(&found, &[])?;
    let mut paths: BTreeSet<PathBuf> = ScenarioFile::bases(&found).map_err(Error::bad_input)?.into_iter().collect();
    paths.extend(found.files.remembered());
    let is_inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if let Some(path) = paths.iter().find(|path| !path.components().all(is_inside)) {
        let message = format!("{} names {}, which lies outside its folder", found.path, path.display());
        return Err(Error::refused(message, "a copy has all files in its own folder: move the file there first"));
    }
    paths.extend(shipped_paths().filter(|path| !path.starts_with("scenarios/")).map(Into::into));
    for path in paths {
        let bytes =
            found.files.read(&path).map_err(|source| diagnostics::Error::Write { path: dir.join(&path), source })?;
        copies.write(&path, bytes)?;
    }
    let name = Path::new(&found.path).file_name().unwrap_or_default();
    copies.write(name, &found.text)?;
    copies.publish(&[name])?;
    print(&format!("wrote {0}; run it with: steward --scenario {0}\n", dir.join(name).display()))
}
