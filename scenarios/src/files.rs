//! The sources of files: beside the scenario, or inside the program itself.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use diagnostics::document::{Field, Table};
use diagnostics::{Disk, Memo, Problem, ReadFile, Span, Spanned};
use include_dir::{Dir, include_dir};

/// The shipped folders, by the paths that scenarios use.
static FOLDERS: [(&str, Dir<'static>); 9] = [
    ("components/devices", include_dir!("$CARGO_MANIFEST_DIR/../components/devices/interfaces")),
    ("components/guide", include_dir!("$CARGO_MANIFEST_DIR/../components/guide")),
    ("components/nav2", include_dir!("$CARGO_MANIFEST_DIR/../components/nav2")),
    ("properties", include_dir!("$CARGO_MANIFEST_DIR/../monitors/properties")),
    ("scenarios/faults", include_dir!("$CARGO_MANIFEST_DIR/faults")),
    ("scenarios/guide", include_dir!("$CARGO_MANIFEST_DIR/guide")),
    ("scenarios/nav2", include_dir!("$CARGO_MANIFEST_DIR/nav2")),
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
    ("scenarios/takes_turns.toml", include_bytes!("../takes_turns.toml")),
    ("scenarios/errand.toml", include_bytes!("../errand.toml")),
    ("scenarios/corridor.toml", include_bytes!("../corridor.toml")),
    ("scenarios/populated.toml", include_bytes!("../populated.toml")),
    ("scenarios/published.toml", include_bytes!("../published.toml")),
    ("scenarios/parcel.toml", include_bytes!("../parcel.toml")),
    ("scenarios/pick.toml", include_bytes!("../pick.toml")),
    ("scenarios/guide.toml", include_bytes!("../guide.toml")),
    ("scenarios/on_a_robot.toml", include_bytes!("../on_a_robot.toml")),
    ("maps/house.yaml", include_bytes!("../../maps/house.yaml")),
    ("maps/house_shifted.yaml", include_bytes!("../../maps/house_shifted.yaml")),
    ("maps/house_corridor.yaml", include_bytes!("../../maps/house_corridor.yaml")),
    ("maps/house_corridor.places.toml", include_bytes!("../../maps/house_corridor.places.toml")),
    ("maps/house_zones.places.toml", include_bytes!("../../maps/house_zones.places.toml")),
    ("maps/house.pgm", include_bytes!("../../maps/house.pgm")),
    ("maps/house.places.toml", include_bytes!("../../maps/house.places.toml")),
    ("maps/museum.yaml", include_bytes!("../../maps/museum.yaml")),
    ("maps/museum.pgm", include_bytes!("../../maps/museum.pgm")),
    ("maps/museum.places.toml", include_bytes!("../../maps/museum.places.toml")),
    // WaitForUser is not a skill of the paper's published system; the ordinary one is used.
    ("skills/original/WaitForUser.scxml", include_bytes!("../../skills/machines/WaitForUser.scxml")),
];

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
    ("scenarios/campaigns/guide_patience.toml", include_str!("../campaigns/guide_patience.toml")),
    ("scenarios/campaigns/noise.toml", include_str!("../campaigns/noise.toml")),
    ("scenarios/campaigns/noise_short.toml", include_str!("../campaigns/noise_short.toml")),
    ("scenarios/campaigns/people.toml", include_str!("../campaigns/people.toml")),
];

/// Where a scenario's files are looked up: first beside the file that names them, then beside the scenario if that is
/// another file, and then among the shipped files. What an assignment names is looked up in the current folder instead,
/// whichever scenario it changes.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// The folder of the scenario's file; for a shipped scenario, that of the assignments that change it.
    folder: PathBuf,
    /// The folder of the assignments that change the scenario.
    assigned: PathBuf,
    /// The folder that the scenario names instead, relative to its own.
    instead: PathBuf,
    /// The folders of other files from which the scenario inherits, relative to its own.
    of_bases: Vec<PathBuf>,
    /// Whether the scenario is shipped. If so, its only files on disk are those that an [assignment](named) names.
    is_shipped: bool,
    disk: Disk,
    /// The contents of files when they were first read, by the requested paths, if they are remembered.
    memory: Option<Arc<Mutex<BTreeMap<PathBuf, Contents>>>>,
    /// The files that were read, if they are listed.
    taken: Option<Arc<Mutex<BTreeMap<PathBuf, Taken>>>>,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Its path on disk; none if it comes with the program.
    pub on_disk: Option<PathBuf>,
    /// The hash of its contents: BLAKE3, in hexadecimal.
    pub hash: String,
    /// The requested paths of the files that name it, as a map names its image.
    pub named_by: BTreeSet<PathBuf>,
}

#[derive(Clone, Debug)]
struct Contents {
    bytes: Arc<[u8]>,
    /// As in [`Taken`].
    hash: String,
    /// As in [`Taken`].
    on_disk: Option<PathBuf>,
}

/// What was made of a file and of those that it names.
#[derive(Debug)]
struct Made<S, T> {
    settings: S,
    /// The requested paths of all these files in the order in which they were read, each with the hash of its contents;
    /// none if it could not be read.
    inputs: Vec<(PathBuf, Option<String>)>,
    value: T,
}

/// The hash of a file with these contents, as in [`Taken::hash`].
pub(crate) fn hash_of(contents: &[u8]) -> String {
    blake3::hash(contents).to_hex().to_string()
}

impl Files {
    /// The shipped files, and those that assignments name, relative to the current folder.
    #[must_use]
    pub fn shipped() -> Self {
        Self { is_shipped: true, ..Self::default() }
    }

    /// The files in `folder`, and the shipped files.
    #[must_use]
    pub fn beside(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), ..Self::default() }
    }

    /// The same files, on this disk.
    #[must_use]
    pub fn on(self, disk: &Disk) -> Self {
        Self { disk: disk.clone(), ..self }
    }

    /// The same files, except that those that assignments name are relative to `folder`.
    #[must_use]
    pub fn with_assignments_in(self, folder: &Path) -> Self {
        let own = if self.is_shipped { folder.to_owned() } else { self.folder };
        Self { folder: own, assigned: folder.to_owned(), ..self }
    }

    /// The same files, which list what is read from now on, apart from what others have read.
    #[must_use]
    pub(crate) fn listing(self) -> Self {
        Self { taken: Some(Arc::default()), ..self }
    }

    /// The files that were read since they are listed, by the requested paths, in alphabetical order.
    #[must_use]
    pub(crate) fn taken(&self) -> BTreeMap<PathBuf, Taken> {
        let taken = self.taken.as_ref().map(|taken| taken.lock().unwrap_or_else(PoisonError::into_inner).clone());
        taken.unwrap_or_default()
    }

    /// Lists that a file was read, because another one names it or not.
    fn list(&self, path: &Path, Contents { hash, on_disk, .. }: &Contents, by: Option<&Path>) {
        if let Some(taken) = &self.taken {
            let mut taken = taken.lock().unwrap_or_else(PoisonError::into_inner);
            let mut named_by = taken.remove(path).map(|earlier| earlier.named_by).unwrap_or_default();
            named_by.extend(by.map(Path::to_owned));
            taken.insert(path.to_owned(), Taken { on_disk: on_disk.clone(), hash: hash.clone(), named_by });
        }
    }

    pub(crate) fn are_shipped(&self) -> bool {
        self.is_shipped
    }

    /// The same files, but each is read from disk only once: later readers, including those of a clone, get the first
    /// contents.
    #[must_use]
    pub fn remembering(self) -> Self {
        Self { memory: Some(Arc::default()), ..self }
    }

    /// A fingerprint of the remembered files on disk: their paths and contents.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        let mut hash = blake3::Hasher::new();
        if let Some(memory) = &self.memory {
            let memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
            for (path, contents) in memory.iter().filter(|(_, contents)| contents.on_disk.is_some()) {
                for part in [path.as_os_str().as_encoded_bytes(), &contents.bytes] {
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
        memory.map_or_else(BTreeSet::new, |memory| memory.keys().cloned().collect())
    }

    /// Forgets the contents of all files but these.
    pub fn retain(&self, known: &BTreeSet<PathBuf>) {
        if let Some(memory) = &self.memory {
            memory.lock().unwrap_or_else(PoisonError::into_inner).retain(|path, _| known.contains(path));
        }
    }

    /// The same files, except that those on disk are looked up in this folder, unless a base in another folder names
    /// them. It is relative to the current one or, if these are only the shipped files, to the working directory.
    #[must_use]
    pub fn in_folder(&self, folder: &Path) -> Self {
        Self { instead: folder.to_owned(), is_shipped: false, ..self.clone() }
    }

    /// The same files in the folder that the scenario names here, as [`in_folder`](Self::in_folder).
    #[must_use]
    pub(crate) fn in_named_folder(&self, Spanned { value, span }: &Spanned<PathBuf>) -> Self {
        if !span.is_assignment() || self.is_shipped {
            return self.in_folder(value);
        }
        let here = self.assigned.join(value);
        self.in_folder(&std::path::absolute(&here).unwrap_or(here))
    }

    /// The problem of a path that an assignment names. If there is no such file but one beside the scenario, the help
    /// names that one.
    pub(crate) fn hinted(&self, path: &Path, problem: Problem) -> Problem {
        let beside = is_assigned(path).then(|| self.on_disk(unmarked(path))).flatten();
        match beside.filter(|_| self.on_disk(path).is_none()) {
            Some(beside) => {
                let help = "a path of `--set` is looked up in the current folder; the one beside the scenario is";
                problem.with_help(format!("{help} {}", beside.display()))
            }
            None => problem,
        }
    }

    /// The folder in which a program runs that is named at `span`.
    #[must_use]
    pub(crate) fn working_folder(&self, span: &Span) -> Option<PathBuf> {
        if span.is_assignment() { Some(self.assigned.join(HERE)) } else { self.on_disk(&named(HERE, span)) }
    }

    /// The values that were made from these files.
    pub(crate) fn memo(&self) -> &Arc<Memo> {
        self.disk.memo()
    }

    /// What `make` makes of a file and of those that it names, which are looked up as it is itself. If it was made with
    /// the same `settings` before, and all files that were read for it have the same contents, it is not made again.
    /// Values of one type must always be made in the same way, and depend on nothing else.
    ///
    /// # Errors
    /// Those of `make`.
    pub(crate) fn load<S, T, E>(
        &self,
        file: &Path,
        settings: S,
        make: impl FnOnce(ReadFile<'_>) -> Result<T, E>,
    ) -> Result<T, E>
    where
        S: PartialEq + Send + Sync + 'static,
        T: Clone + Send + Sync + 'static,
    {
        // A file is read only because of the contents of those before it, so the first that has changed ends the
        // search.
        let is_current = |made: &Arc<Made<S, T>>| {
            let mut inputs = made.inputs.iter();
            made.settings == settings
                && inputs.all(|(path, hash)| self.contents_for(file, path).ok().map(|it| it.hash) == *hash)
        };
        if let Some(made) = self.memo().find(file, is_current) {
            return Ok(made.value.clone());
        }
        let inputs = RefCell::new(Vec::new());
        let read = |path: &Path| {
            let contents = self.contents_for(file, path);
            let hash = contents.as_ref().ok().map(|contents| contents.hash.clone());
            inputs.borrow_mut().push((path.to_owned(), hash));
            contents.map(|contents| contents.bytes.to_vec())
        };
        let value = make(&read)?;
        self.memo().keep(file, Arc::new(Made { settings, inputs: inputs.take(), value: value.clone() }));
        Ok(value)
    }

    /// The contents of a file, or of one that it names.
    fn contents_for(&self, file: &Path, path: &Path) -> io::Result<Contents> {
        let path = if is_assigned(file) { path } else { unmarked(path) };
        self.contents(path, Some(file).filter(|file| *file != path))
    }

    /// The same files for a scenario that inherits from files in these folders, relative to its own.
    #[must_use]
    pub(crate) fn with_bases(&self, folders: &[PathBuf]) -> Self {
        let of_bases = folders.iter().filter(|folder| !folder.as_os_str().is_empty()).cloned().collect();
        Self { of_bases, ..self.clone() }
    }

    /// The path as a base in another folder writes it, for each such base that may have named it.
    fn as_written<'p>(&'p self, path: &'p Path) -> impl Iterator<Item = &'p Path> {
        self.of_bases.iter().filter_map(move |folder| path.strip_prefix(folder).ok())
    }

    /// The path of the file on disk, if it exists there.
    #[must_use]
    pub fn on_disk(&self, path: &Path) -> Option<PathBuf> {
        if is_assigned(path) {
            return Some(self.assigned.join(path)).filter(|found| self.disk.exists(found));
        }
        if self.is_shipped && !path.is_absolute() && path != Path::new(HERE) {
            return None;
        }
        let own = self.folder.join(&self.instead);
        let mut of_base = self.as_written(path).map(|written| own.join(written)).peekable();
        let first = if of_base.peek().is_some() { self.folder.join(path) } else { own.join(path) };
        std::iter::once(first).chain(of_base).find(|found| self.disk.exists(found))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The operating system's error; `NotFound` if the file is neither on disk nor shipped.
    pub fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.contents(path, None).map(|contents| contents.bytes.to_vec())
    }

    /// The contents of a file, which is listed as read because of this other file or not.
    fn contents(&self, path: &Path, by: Option<&Path>) -> io::Result<Contents> {
        let memory = || self.memory.as_ref().map(|memory| memory.lock().unwrap_or_else(PoisonError::into_inner));
        let known = memory().and_then(|memory| memory.get(path).cloned());
        let contents = match known {
            Some(known) => known,
            None => {
                let read = self.read_anew(path)?;
                // The first reader determines the contents.
                memory().map_or(read.clone(), |mut memory| memory.entry(path.to_owned()).or_insert(read).clone())
            }
        };
        self.list(path, &contents, by);
        Ok(contents)
    }

    fn read_anew(&self, path: &Path) -> io::Result<Contents> {
        let on_disk = self.on_disk(path);
        let bytes: Arc<[u8]> = match &on_disk {
            Some(found) => self.disk.read_named(found, path)?.into(),
            None => {
                let missing = || io::Error::new(io::ErrorKind::NotFound, "there is no such file");
                std::iter::once(path).chain(self.as_written(path)).find_map(shipped).ok_or_else(missing)?.into()
            }
        };
        Ok(Contents { hash: hash_of(&bytes), bytes, on_disk })
    }

    /// Reads a file as text.
    ///
    /// # Errors
    /// As [`read`](Self::read); `InvalidData` if it is not UTF-8.
    pub fn read_text(&self, path: &Path) -> io::Result<String> {
        diagnostics::text(self.read(path)?)
    }
}

fn shipped(path: &Path) -> Option<&'static [u8]> {
    let path = path.strip_prefix(HERE).unwrap_or(path);
    let campaigns = CAMPAIGNS.iter().map(|(name, text)| (*name, text.as_bytes()));
    let mut files = SHIPPED.iter().map(|(name, bytes)| (name.as_str(), *bytes)).chain(campaigns);
    files.find(|(name, _)| Path::new(name) == path).map(|(_, bytes)| bytes)
}

/// The prefix of an assignment's path. Paths in files are [without it](unmarked).
const HERE: &str = ".";

/// Whether an assignment names this path.
pub(crate) fn is_assigned(path: &Path) -> bool {
    path.starts_with(HERE) && path != Path::new(HERE)
}

/// A path in a file, which means the same without `./`.
pub(crate) fn unmarked(path: &Path) -> &Path {
    if is_assigned(path) { path.strip_prefix(HERE).unwrap_or(path) } else { path }
}

/// The path at `span`, relative to the scenario's folder. A file's paths are relative to its own folder, also those
/// that another file inherits. The path of an assignment is relative to the place where it is given, whichever scenario
/// it changes.
pub(crate) fn named(path: impl AsRef<Path>, span: &Span) -> PathBuf {
    match path.as_ref() {
        path if span.is_assignment() => Path::new(HERE).join(path),
        // What is joined to it must not look like an assignment's path.
        path if path == Path::new(HERE) => span.source().folder().to_owned(),
        path => span.source().folder().join(unmarked(path)),
    }
}

/// The path under a key, as [`named`].
pub(crate) fn path<'d>(table: Table<'d>, key: &str, about: &str) -> Field<'d, Spanned<PathBuf>> {
    table.text(key).about(about).try_map(|path, span| Ok(named(path, span))).spanned()
}

/// A kind of file that people name on the command line: by its path, or a shipped one by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Behavior trees: `recharge` is `trees/recharge.xml`.
    Tree,
    /// Machines: `BatteryLevel` is `skills/BatteryLevel.scxml`.
    Skill,
    /// Property files: `phi1` is `properties/phi1.scope`.
    Properties,
    /// Maps: `house` is `maps/house.yaml`.
    Map,
    /// Places: `house` is `maps/house.places.toml`.
    Places,
}

impl Kind {
    /// The folder of the shipped files of the kind, and the ending of their names.
    fn place(self) -> (&'static str, &'static str) {
        match self {
            Self::Tree => ("trees/", ".xml"),
            Self::Skill => ("skills/", ".scxml"),
            Self::Properties => ("properties/", ".scope"),
            Self::Map => ("maps/", ".yaml"),
            Self::Places => ("maps/", ".places.toml"),
        }
    }

    /// The path of the shipped file that people mean if they write its name instead: `maps/house.yaml` for the map
    /// `house`.
    pub(crate) fn shipped_as(self, written: &str) -> Option<String> {
        let (folder, ending) = self.place();
        let path = format!("{folder}{}{ending}", written.trim_matches(['"', '\'']));
        shipped(Path::new(&path)).map(|_| path)
    }

    /// The path that an argument refers to, where [`Files::beside`] is the current folder: the argument itself, if it
    /// is the path of a file on this disk or of a shipped one, or otherwise that of the shipped file with this name.
    #[must_use]
    pub fn path(self, argument: &Path, disk: &Disk) -> PathBuf {
        self.named(argument, disk).unwrap_or_else(|| argument.to_owned())
    }

    /// The path of the shipped file that an argument names; none if the argument is a path.
    #[must_use]
    pub fn named(self, argument: &Path, disk: &Disk) -> Option<PathBuf> {
        let (folder, ending) = self.place();
        let named = PathBuf::from(format!("{folder}{}{ending}", argument.display()));
        let is_path = disk.is_file(argument) || shipped(argument).is_some();
        Some(named).filter(|named| !is_path && shipped(named).is_some())
    }

    /// Whether an argument refers to a shipped file.
    #[must_use]
    pub fn is_shipped(self, argument: &Path, disk: &Disk) -> bool {
        self.named(argument, disk).is_some() || !disk.is_file(argument) && shipped(argument).is_some()
    }

    /// The names of the shipped files of the kind, in alphabetical order.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let (folder, ending) = self.place();
        shipped_paths().filter_map(move |path| path.strip_prefix(folder)?.strip_suffix(ending))
    }
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

/// The names of the shipped scenarios in alphabetical order, without those in folders: `faults/KIND` for each kind of
/// fault, and those of the things that can go wrong in the tour of `guide`.
#[must_use]
pub fn shipped_scenarios() -> Vec<&'static str> {
    scenario_names().filter(|name| !name.contains('/')).collect()
}

/// The names of all shipped scenarios, in alphabetical order.
pub fn scenario_names() -> impl Iterator<Item = &'static str> {
    shipped_paths().filter_map(|path| path.strip_prefix("scenarios/")?.strip_suffix(".toml"))
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
        assert_eq!(files.fingerprint(), before, "a shipped file is not a file on disk");
    }

    #[test]
    fn a_value_is_made_again_only_if_a_file_that_was_read_for_it_has_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for (name, text) in [("list", "a b missing"), ("a", "1"), ("b", "2")] {
            std::fs::write(path(name), text).unwrap();
        }
        let files = Files::beside(folder.path());
        let made = RefCell::new(0);
        // The texts of the files that a file names, in the order in which they are named.
        let joined = |files: &Files, settings: u8| {
            let text =
                |read: ReadFile<'_>, path: &str| read(Path::new(path)).map(|bytes| String::from_utf8(bytes).unwrap());
            let made = files.load(Path::new("list"), settings, |read| -> io::Result<String> {
                *made.borrow_mut() += 1;
                let names = text(read, "list")?;
                let texts = names.split(' ').map(|name| text(read, name).unwrap_or_default());
                Ok(texts.collect::<Vec<_>>().join("+"))
            });
            made.unwrap()
        };
        let check = |settings: u8, expected: (&str, i32)| {
            // What is read is listed alike, whether the value is made or known, and through any clone.
            let listing = files.clone().listing();
            let value = joined(&listing, settings);
            assert_eq!((value.as_str(), *made.borrow()), expected);
            let anew = Files::beside(folder.path()).listing();
            joined(&anew, settings);
            *made.borrow_mut() -= 1;
            assert_eq!(listing.taken(), anew.taken());
        };
        check(0, ("1+2+", 1));
        check(0, ("1+2+", 1));
        check(1, ("1+2+", 2));
        check(0, ("1+2+", 2));
        std::fs::write(path("b"), "3").unwrap();
        check(0, ("1+3+", 3));
        std::fs::write(path("missing"), "4").unwrap();
        check(0, ("1+3+4", 4));
        std::fs::write(path("list"), "a").unwrap();
        check(0, ("1", 5));
        std::fs::write(path("b"), "no longer read").unwrap();
        check(0, ("1", 5));
        assert!(files.load(Path::new("nowhere"), (), |read| read(Path::new("nowhere"))).is_err());
    }

    #[test]
    fn a_shipped_scenario_reads_only_files_on_disk_that_an_assignment_names() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("trees")).unwrap();
        std::fs::write(folder.path().join("trees/recharge.xml"), "own").unwrap();
        let files = Files::shipped().with_assignments_in(folder.path());
        let at = |source: &str| diagnostics::Source::new(source, "trees/recharge.xml").span(0..18);
        let read = |source: &str| files.read_text(&named("trees/recharge.xml", &at(source))).unwrap();
        assert_eq!(read("--set"), "own");
        assert_eq!(read("nominal.toml"), Files::shipped().read_text(Path::new("trees/recharge.xml")).unwrap());
        let shipped = named("maps/house.yaml", &at("--set"));
        assert!(files.read(&shipped).is_ok(), "an assignment may also name a shipped file");
    }

    #[test]
    fn a_path_of_an_assignment_is_relative_to_the_current_folder_and_no_other_path_is() {
        let folder = tempfile::tempdir().unwrap();
        let (task, here) = (folder.path().join("task"), folder.path().join("here"));
        for (at, text) in [(&task, "of the task"), (&here, "own")] {
            std::fs::create_dir(at).unwrap();
            std::fs::write(at.join("tree.xml"), text).unwrap();
        }
        std::fs::write(task.join("other.xml"), "of the task").unwrap();
        let files = Files::beside(&task).with_assignments_in(&here);
        let at = |source: &str| diagnostics::Source::new(source, "tree.xml").span(0..8);
        let read = |path: &str, source: &str| files.read_text(&named(path, &at(source)));
        for path in ["tree.xml", "./tree.xml"] {
            assert_eq!(read(path, "--set").unwrap(), "own");
            assert_eq!(read(path, "scenario.toml").unwrap(), "of the task");
        }
        assert!(read("other.xml", "--set").is_err());
        // What a file names is looked up as the file itself.
        let beside = |of: &str, source: &str| {
            let contents = files.contents_for(&named(of, &at(source)), Path::new("./tree.xml"));
            contents.unwrap().bytes.to_vec()
        };
        assert_eq!((beside("a.yaml", "--set"), beside("a.yaml", "a.toml")), (b"own".into(), b"of the task".into()));
        let problem = files.hinted(Path::new("./other.xml"), at("--set").problem("no file"));
        let help = miette::Diagnostic::help(&problem).unwrap().to_string();
        assert!(help.ends_with("task/other.xml"), "{help}");
    }

    #[test]
    fn a_shipped_file_is_found_by_path_and_by_name() {
        for (kind, name, path) in [
            (Kind::Tree, "recharge", "trees/recharge.xml"),
            (Kind::Skill, "original/GoToDestination", "skills/original/GoToDestination.scxml"),
            (Kind::Properties, "phi1", "properties/phi1.scope"),
            (Kind::Map, "house", "maps/house.yaml"),
            (Kind::Places, "house", "maps/house.places.toml"),
        ] {
            assert_eq!(
                [name, path].map(|given| kind.path(Path::new(given), &Disk::default())),
                [path, path].map(PathBuf::from)
            );
            assert!(kind.names().any(|known| known == name), "{name}");
        }
        assert_eq!(
            Kind::Tree.path(Path::new("phi1"), &Disk::default()),
            Path::new("phi1"),
            "which is not a name in any tree"
        );
    }
}
