//! Applications: scenarios with all files that they name, to be copied and changed.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use crate::Error;
use crate::files::{shipped_campaigns, shipped_paths};
use crate::scenario::{Found, Scenario, ScenarioFile, find};

/// Files that can be run together.
#[derive(Clone, Debug)]
pub struct Application {
    /// The name of the scenario's file.
    pub start: String,
    /// Whether the scenario has a robot.
    pub has_robot: bool,
    /// The files, by their paths from their folder.
    pub files: BTreeMap<PathBuf, Vec<u8>>,
}

impl Application {
    /// A scenario with all files that it names.
    ///
    /// # Errors
    /// If the scenario cannot be loaded, or names a file outside its folder.
    pub fn of(mut found: Found) -> Result<Self, Error> {
        found.files = found.files.remembering();
        let scenario = Scenario::load(&found, &[])?;
        let has_robot = scenario.premises.is_some();
        if !scenario.file.prove.components.is_empty() {
            // A proof reads the machines that take the place of components.
            Scenario::load_for_proof(&found, &[])?;
        }
        let bases = ScenarioFile::bases(&found).map_err(Error::bad_input)?;
        let mut files = BTreeMap::new();
        for path in bases.into_iter().chain(found.files.remembered()) {
            if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
                let message = format!("{} names {}, which lies outside its folder", found.path, path.display());
                return Err(Error::refused(message, "a copy contains all its files: move the file there first"));
            }
            let contents =
                found.files.read(&path).map_err(|source| diagnostics::Error::Read { path: path.clone(), source })?;
            files.insert(path, contents);
        }
        let start = Path::new(&found.path).file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.insert(start.clone().into(), found.text.into_bytes());
        Ok(Self { start, has_robot, files })
    }

    /// A shipped scenario, the scenarios in the folder of its name, which are based on it, and its campaigns, side by
    /// side.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn with_variants(name: &str) -> Result<Self, Error> {
        let mut all = Self::of(find::find(name)?)?;
        for path in shipped_paths().filter(|path| path.starts_with(&format!("scenarios/{name}/"))) {
            let Self { start, mut files, .. } = Self::of(find::find(path)?)?;
            // Its base is already there, beside it.
            files.retain(|path, _| !path.starts_with("scenarios"));
            let text = files.entry(start.into()).or_default();
            *text = beside(&String::from_utf8_lossy(text), "base", name).into();
            all.files.extend(files);
        }
        for (campaign, text) in shipped_campaigns() {
            let own = beside(text, "scenario", name);
            if own != text {
                all.files.insert(format!("{campaign}.toml").into(), own.into());
            }
        }
        Ok(all)
    }
}

/// The text; if the key named this scenario or one of its variants, it names a file in the same folder instead.
fn beside(text: &str, key: &str, scenario: &str) -> String {
    let own = |line: &str| {
        let named = line.strip_prefix(&format!("{key} = \""))?.strip_suffix("\"\n")?;
        let named = named.strip_prefix("scenarios/").unwrap_or(named).trim_end_matches(".toml");
        let (folder, name) = named.rsplit_once('/').unwrap_or((named, named));
        (folder == scenario).then(|| format!("{key} = \"{name}.toml\"\n"))
    };
    text.split_inclusive('\n').map(|line| own(line).unwrap_or_else(|| line.to_owned())).collect()
}
