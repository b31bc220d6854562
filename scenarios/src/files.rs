//! The sources of files: beside the scenario, or inside the program itself.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use include_dir::{Dir, include_dir};

/// The shipped folders, by the paths that scenarios use.
static FOLDERS: [(&str, Dir<'static>); 4] = [
    ("properties", include_dir!("$CARGO_MANIFEST_DIR/../monitors/properties")),
    ("scenarios/faults", include_dir!("$CARGO_MANIFEST_DIR/faults")),
    ("skills", include_dir!("$CARGO_MANIFEST_DIR/../skills/machines")),
    ("trees", include_dir!("$CARGO_MANIFEST_DIR/../bt/trees")),
];

/// The shipped files whose folders contain other files, too.
const FILES: &[(&str, &[u8])] = &[
    ("scenarios/nominal.toml", include_bytes!("../nominal.toml")),
    ("scenarios/battery_fault.toml", include_bytes!("../battery_fault.toml")),
    ("scenarios/skill_bug.toml", include_bytes!("../skill_bug.toml")),
    ("scenarios/joypad.toml", include_bytes!("../joypad.toml")),
    ("scenarios/never_arrives.toml", include_bytes!("../never_arrives.toml")),
    ("scenarios/already_there.toml", include_bytes!("../already_there.toml")),
    ("scenarios/late_halt.toml", include_bytes!("../late_halt.toml")),
    ("scenarios/early_release.toml", include_bytes!("../early_release.toml")),
    ("scenarios/errand.toml", include_bytes!("../errand.toml")),
    ("scenarios/corridor.toml", include_bytes!("../corridor.toml")),
    ("scenarios/populated.toml", include_bytes!("../populated.toml")),
    ("scenarios/published.toml", include_bytes!("../published.toml")),
    ("scenarios/pick.toml", include_bytes!("../pick.toml")),
    ("maps/house.yaml", include_bytes!("../../maps/house.yaml")),
    ("maps/house_shifted.yaml", include_bytes!("../../maps/house_shifted.yaml")),
    ("maps/house_corridor.yaml", include_bytes!("../../maps/house_corridor.yaml")),
    ("maps/house_corridor.places.toml", include_bytes!("../../maps/house_corridor.places.toml")),
    ("maps/house.pgm", include_bytes!("../../maps/house.pgm")),
    ("maps/house.places.toml", include_bytes!("../../maps/house.places.toml")),
    // WaitForUser is not a skill of the paper's published system; it has the ordinary one.
    ("skills/original/WaitForUser.scxml", include_bytes!("../../skills/machines/WaitForUser.scxml")),
];

/// All shipped files.
static SHIPPED: LazyLock<BTreeMap<String, &[u8]>> = LazyLock::new(|| {
    let mut files: BTreeMap<String, &[u8]> = FILES.iter().map(|(path, bytes)| ((*path).to_owned(), *bytes)).collect();
    FOLDERS.iter().for_each(|(name, folder)| add(name, folder, &mut files));
    files
});

fn add(name: &str, folder: &Dir<'static>, files: &mut BTreeMap<String, &[u8]>) {
    files.extend(folder.files().map(|file| (format!("{name}/{}", file.path().display()), file.contents())));
    folder.dirs().for_each(|inner| add(name, inner, files));
}

/// The shipped campaigns, by their paths in the sources.
const CAMPAIGNS: &[(&str, &str)] = &[
    ("scenarios/campaigns/battery_reserve.toml", include_str!("../campaigns/battery_reserve.toml")),
    ("scenarios/campaigns/bug_hunt.toml", include_str!("../campaigns/bug_hunt.toml")),
    ("scenarios/campaigns/noise.toml", include_str!("../campaigns/noise.toml")),
    ("scenarios/campaigns/noise_short.toml", include_str!("../campaigns/noise_short.toml")),
    ("scenarios/campaigns/people.toml", include_str!("../campaigns/people.toml")),
];

/// Where a scenario's files are looked up: first beside the scenario's own file, then among the shipped files.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// The folder of the scenario's file; `None` for a shipped scenario.
    beside: Option<PathBuf>,
    /// The contents of files read from disk, if they are remembered.
    memory: Option<Arc<Mutex<Memory>>>,
}

/// The contents of files when they were first read, by the requested paths.
#[derive(Debug, Default)]
struct Memory {
    on_disk: BTreeMap<PathBuf, Arc<[u8]>>,
    /// Shipped files, which never change.
    shipped: BTreeSet<PathBuf>,
}

impl Files {
    /// Only the shipped files.
    #[must_use]
    pub fn shipped() -> Self {
        Self::default()
    }

    /// The files in `folder`, and the shipped files.
    #[must_use]
    pub fn beside(folder: impl Into<PathBuf>) -> Self {
        Self { beside: Some(folder.into()), memory: None }
    }

    /// The same files, but each is read from disk only once: later readers, including those of a clone, get the first
    /// contents.
    #[must_use]
    pub fn remembering(self) -> Self {
        Self { memory: Some(Arc::default()), ..self }
    }

    /// A fingerprint of the remembered files: their paths and contents.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        let mut hash = blake3::Hasher::new();
        if let Some(memory) = &self.memory {
            for (path, bytes) in &memory.lock().unwrap_or_else(PoisonError::into_inner).on_disk {
                for part in [path.as_os_str().as_encoded_bytes(), bytes] {
                    hash.update(&(part.len() as u64).to_le_bytes()).update(part);
                }
            }
        }
        hash.finalize().to_hex().to_string()
    }

    /// The files that were read, by the requested paths, in alphabetical order.
    #[must_use]
    pub fn remembered(&self) -> BTreeSet<PathBuf> {
        let memory = self.memory.as_ref().map(|memory| memory.lock().unwrap_or_else(PoisonError::into_inner));
        memory.map_or_else(BTreeSet::new, |memory| memory.on_disk.keys().chain(&memory.shipped).cloned().collect())
    }

    /// The same files, but those on disk are looked up in this folder: relative to the current one or, if these are
    /// only the shipped files, to the working directory.
    #[must_use]
    pub fn in_folder(&self, folder: &Path) -> Self {
        let beside = self.beside.as_deref().unwrap_or(Path::new("")).join(folder);
        Self { beside: Some(beside), ..self.clone() }
    }

    /// The path of the file on disk, if it exists there.
    #[must_use]
    pub fn on_disk(&self, path: &Path) -> Option<PathBuf> {
        let folder = self.beside.as_deref().unwrap_or(Path::new(""));
        let found = folder.join(path);
        ((self.beside.is_some() || path.is_absolute()) && found.exists()).then_some(found)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The error of the operating system; `NotFound` if the file is neither on disk nor shipped.
    pub fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let memory = || self.memory.as_ref().map(|memory| memory.lock().unwrap_or_else(PoisonError::into_inner));
        if let Some(known) = memory().and_then(|memory| memory.on_disk.get(path).cloned()) {
            return Ok(known.to_vec());
        }
        let Some(found) = self.on_disk(path) else {
            let missing = || io::Error::new(io::ErrorKind::NotFound, "there is no such file");
            let bytes = shipped(path).ok_or_else(missing)?;
            memory().map(|mut memory| memory.shipped.insert(path.to_owned()));
            return Ok(bytes.to_vec());
        };
        let bytes = diagnostics::from_disk(&found)?;
        // The first reader determines the contents.
        let first = memory()
            .map(|mut memory| Arc::clone(memory.on_disk.entry(path.to_owned()).or_insert(bytes.as_slice().into())));
        Ok(first.map_or(bytes, |first| first.to_vec()))
    }

    /// Reads a file as text.
    ///
    /// # Errors
    /// As [`read`](Self::read); `InvalidData` if it is not UTF-8.
    pub fn read_text(&self, path: &Path) -> io::Result<String> {
        diagnostics::text(self.read(path)?)
    }
}

/// A shipped file.
fn shipped(path: &Path) -> Option<&'static [u8]> {
    let path = path.strip_prefix(".").unwrap_or(path);
    SHIPPED.iter().find(|(name, _)| Path::new(name) == path).map(|(_, bytes)| *bytes)
}

/// The paths of all shipped files, in alphabetical order.
pub fn shipped_paths() -> impl Iterator<Item = &'static str> {
    SHIPPED.keys().map(String::as_str)
}

/// The shipped campaigns: the name and the text of each, in alphabetical order.
pub fn shipped_campaigns() -> impl Iterator<Item = (&'static str, &'static str)> {
    let name = |path: &'static str| path.strip_prefix("scenarios/campaigns/")?.strip_suffix(".toml");
    CAMPAIGNS.iter().filter_map(move |(path, text)| Some((name(path)?, *text)))
}

/// The names of the shipped scenarios in alphabetical order, without those that demonstrate a kind of fault.
#[must_use]
pub fn shipped_scenarios() -> Vec<&'static str> {
    let name = |path: &'static str| path.strip_prefix("scenarios/")?.strip_suffix(".toml");
    shipped_paths().filter_map(name).filter(|name| !name.contains('/')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_cached_and_distinguished() {
        let folder = tempfile::tempdir().unwrap();
        let (path, file) = (Path::new("some.txt"), folder.path().join("some.txt"));
        std::fs::write(&file, "old").unwrap();
        let forgetful = Files::beside(folder.path());
        let files = forgetful.clone().remembering();
        assert_eq!(files.read_text(path).unwrap(), "old");
        let before = files.fingerprint();
        std::fs::write(&file, "new").unwrap();
        assert_eq!((files.read_text(path).unwrap(), forgetful.read_text(path).unwrap()), ("old".into(), "new".into()));
        assert_eq!(files.clone().fingerprint(), before);
        let anew = forgetful.remembering();
        assert_eq!(anew.read_text(path).unwrap(), "new");
        assert_ne!(anew.fingerprint(), before);
        assert_eq!(
            files.read(Path::new("maps/house.yaml")).unwrap(),
            Files::shipped().read(Path::new("maps/house.yaml")).unwrap()
        );
        assert_eq!(files.fingerprint(), before, "what comes with the program is no file on disk");
    }
}
