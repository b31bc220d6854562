//! Writes files completely or not at all.
//!
//! Data goes to a temporary name in the same folder; the file gets its own name when it is complete. After a full disk,
//! an error or a panic, the previous file is unchanged and nothing of the new one remains. A killed program may leave
//! the temporary file behind, under a name that begins with `.steward-` and ends with `.part`. The next
//! program that writes to the folder removes it. While a program runs, its temporary files are locked, so that other
//! programs do not remove them.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::{Error, check_unread, writing};

/// The beginning and the end of temporary names.
const TEMPORARY: (&str, &str) = (".steward-", ".part");

/// Writes a whole file and creates missing folders.
///
/// # Errors
/// [`Error::Write`]; the previous file then stays unchanged.
pub fn write_whole(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Error> {
    write_all(Unfinished::create(path)?, contents.as_ref())
}

/// Writes a whole file like [`write_whole`], also one that was read: its new contents are made from the old ones.
///
/// # Errors
/// As for [`write_whole`].
pub fn rewrite_whole(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Error> {
    write_all(Unfinished::begin(path)?, contents.as_ref())
}

fn write_all(mut file: Unfinished, contents: &[u8]) -> Result<(), Error> {
    match file.write_all(contents) {
        Ok(()) => file.finish(),
        Err(source) => Err(write_error(&file.path, source)),
    }
}

/// A file being written. It replaces the previous file when it is [finished](Self::finish), and has its permissions; if
/// it never is, nothing remains of it.
///
/// A device or a pipe (`/dev/stdout`) is not replaced but written to. A pipe that no program reads is an error: to open
/// it would mean to wait for a reader.
///
/// ```
/// use std::io::Write;
/// use diagnostics::Unfinished;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("results/table.csv");
/// let mut file = Unfinished::create(&path)?;
/// writeln!(file, "run,verdict")?;
/// assert!(!path.exists());
/// file.finish()?;
/// assert_eq!(std::fs::read_to_string(&path)?, "run,verdict\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Unfinished {
    /// The name that the caller gave.
    path: PathBuf,
    file: File,
    /// The temporary name and the final one; `None` for a device.
    names: Option<(PathBuf, PathBuf)>,
}

impl Unfinished {
    /// Begins a file and creates missing folders.
    ///
    /// # Errors
    /// [`Error::Write`]; [`Error::Overwrites`] if the process has read it, and [guards](crate::guard_inputs) what it
    /// reads.
    pub fn create(path: &Path) -> Result<Self, Error> {
        writing(path)?;
        Self::begin(path)
    }

    fn begin(path: &Path) -> Result<Self, Error> {
        let begun = match fs::metadata(path) {
            Ok(found) if !found.is_file() => device(path).map(|file| (file, None)),
            // A link remains a link: its target is replaced.
            Ok(found) => fs::canonicalize(path).and_then(temporary).and_then(|begun| {
                begun.0.set_permissions(found.permissions())?;
                Ok(begun)
            }),
            Err(_) => {
                // Likewise if it has none yet.
                let target =
                    fs::read_link(path).map_or_else(|_| path.to_owned(), |target| folder_of(path).join(target));
                fs::create_dir_all(folder_of(&target)).and_then(|()| temporary(target))
            }
        };
        let (file, names) = begun.map_err(|source| write_error(path, source))?;
        Ok(Self { path: path.to_owned(), file, names })
    }

    /// The present location of a file that some program is about to give this name: the latest, if there are several.
    #[must_use]
    pub fn of(path: &Path) -> Option<PathBuf> {
        let tag = tag(path);
        let is_one = |name: &str| name.starts_with(TEMPORARY.0) && name.ends_with(&format!("{tag}{}", TEMPORARY.1));
        let entries = fs::read_dir(folder_of(path)).ok()?.filter_map(Result::ok);
        let found = entries.filter(|entry| entry.file_name().to_str().is_some_and(is_one));
        found.max_by_key(|entry| entry.metadata().and_then(|about| about.modified()).ok()).map(|entry| entry.path())
    }

    /// Gives the file its final name.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn finish(mut self) -> Result<(), Error> {
        let Some((temporary, name)) = &self.names else { return Ok(()) };
        let done = self.file.sync_all().and_then(|()| fs::rename(temporary, name));
        done.map_err(|source| write_error(&self.path, source))?;
        self.names = None;
        Ok(())
    }
}

impl Write for Unfinished {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some((temporary, _)) = &self.names {
            // A failure can no longer be reported.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Files that appear in a folder together.
///
/// Until they are [published](Self::publish), they are in a hidden folder inside it. If they are never published,
/// nothing remains of them. Several programs may write to one folder at once: the last to publish wins.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
    hidden: PathBuf,
    /// The folders that were created for it, the innermost first.
    created: Vec<PathBuf>,
    /// Old files to remove when these appear.
    replaced: Vec<String>,
    /// Locked while this value exists, so that others can recognize the remains of a killed program.
    _lock: Option<File>,
}

impl Staging {
    /// Begins files of a folder, which is created if it is missing. Removes what killed programs have left there.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn begin(folder: &Path) -> Result<Self, Error> {
        let begin = || {
            let created = folder.ancestors().take_while(|folder| !folder.exists()).map(Path::to_owned).collect();
            fs::create_dir_all(folder)?;
            let _turn = turn(folder);
            let hidden = first_free(folder, "", |path| fs::create_dir(path))?.0;
            let lock = File::open(&hidden).ok().filter(|lock| lock.try_lock().is_ok());
            Ok(Self { folder: folder.to_owned(), hidden, created, replaced: Vec::new(), _lock: lock })
        };
        begin().map_err(|source| write_error(folder, source))
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Names old files to remove when the new ones appear. They need not exist.
    pub fn replace(&mut self, names: Vec<String>) {
        self.replaced = names;
    }

    /// Whether the folder contains nothing else.
    ///
    /// # Errors
    /// [`Error::Write`] if it cannot be read.
    pub fn is_alone(&self) -> Result<bool, Error> {
        let other = |entry: io::Result<fs::DirEntry>| !entry.is_ok_and(|entry| is_temporary(&entry.path()));
        let entries = fs::read_dir(&self.folder).map_err(|source| write_error(&self.folder, source))?;
        Ok(!entries.into_iter().any(other))
    }

    /// Writes one of the files and creates missing folders; `name` is relative to the folder.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, name: impl AsRef<Path>, contents: impl AsRef<[u8]>) -> Result<(), Error> {
        let path = self.hidden.join(&name);
        let written = fs::create_dir_all(folder_of(&path)).and_then(|()| fs::write(&path, contents));
        written.map_err(|source| write_error(&self.folder.join(name), source))
    }

    /// The text that a file of this name in the folder had before, if it is at hand. It is no input: it will be
    /// replaced.
    #[must_use]
    pub fn earlier(&self, name: impl AsRef<Path>) -> Option<String> {
        fs::read_to_string(self.folder.join(name)).ok()
    }

    /// The content written to one of the files.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn read(&self, name: impl AsRef<Path>) -> Result<Vec<u8>, Error> {
        let path = self.hidden.join(&name);
        fs::read(path).map_err(|source| Error::Read { path: self.folder.join(name), source })
    }

    /// Gives the files their final names. The files in `last` refer to the others: their old versions are removed
    /// first, then the [replaced](Self::replace) files, and their new versions appear last, in this order. So no file
    /// ever refers to files that do not exist.
    ///
    /// # Errors
    /// [`Error::Write`]; [`Error::Overwrites`] as for [`Unfinished::create`], before any file is touched.
    pub fn publish(self, last: &[impl AsRef<OsStr>]) -> Result<(), Error> {
        let entries = fs::read_dir(&self.hidden)
            .and_then(|entries| entries.map(|entry| Ok(entry?.file_name())).collect::<io::Result<Vec<_>>>());
        let mut names = entries.map_err(|source| write_error(&self.folder, source))?;
        let replaced = self.replaced.iter().map(AsRef::as_ref);
        for name in names.iter().map(AsRef::as_ref).chain(last.iter().map(AsRef::as_ref)).chain(replaced.clone()) {
            let name: &OsStr = name;
            check_unread(&self.folder.join(name))?;
        }
        for path in last.iter().map(AsRef::as_ref).chain(replaced).map(|name: &OsStr| self.folder.join(name)) {
            match fs::remove_file(&path) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(write_error(&path, source)),
                _ => {}
            }
        }
        names.sort_by_key(|name| last.iter().position(|last| last.as_ref() == name).map_or(0, |place| place + 1));
        for name in names {
            let path = self.folder.join(&name);
            fs::rename(self.hidden.join(&name), &path).map_err(|source| write_error(&path, source))?;
        }
        Ok(())
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // A failure can no longer be reported.
        let _ = fs::remove_dir_all(&self.hidden);
        for folder in &self.created {
            // Only an empty folder can be removed.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Waits for the turn to create something temporary in a folder, and removes what programs that are no longer running
/// have left there. On a file system without locks, there are no turns, and nothing is removed.
fn turn(folder: &Path) -> Option<File> {
    let turn = File::open(folder).ok().filter(|turn| turn.lock().is_ok());
    if turn.is_some() {
        remove_abandoned(folder);
    }
    turn
}

/// Removes hidden files and folders that no program has locked, as far as possible.
fn remove_abandoned(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let kind = entry.file_type().ok().filter(|kind| is_temporary(&path) && (kind.is_dir() || kind.is_file()));
        let is_abandoned = || File::open(&path).is_ok_and(|lock| lock.try_lock().is_ok());
        match kind {
            Some(kind) if is_abandoned() => {
                let _ = if kind.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            }
            _ => {}
        }
    }
}

fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(TEMPORARY.0) && name.ends_with(TEMPORARY.1)
}

/// Opens a device, or a pipe that some program reads.
fn device(path: &Path) -> io::Result<File> {
    // Held until the file is open, so that the pipe has a reader or is at least not waited for.
    #[cfg(unix)]
    let _held = {
        use std::os::unix::fs::OpenOptionsExt as _;
        let flags = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
        let opened = OpenOptions::new().write(true).custom_flags(flags).open(path);
        opened.map_err(|error| match rustix::io::Errno::from_io_error(&error) {
            Some(rustix::io::Errno::NXIO) => {
                io::Error::new(io::ErrorKind::InvalidInput, "it is a pipe that no program reads")
            }
            _ => error,
        })?
    };
    File::create(path)
}

/// Creates a file under a temporary name beside its final one.
fn temporary(name: PathBuf) -> io::Result<(File, Option<(PathBuf, PathBuf)>)> {
    let create = |path: &Path| OpenOptions::new().write(true).create_new(true).open(path);
    let turn = turn(folder_of(&name));
    let (temporary, file) = first_free(folder_of(&name), &tag(&name), create)?;
    // It is locked before another program gets its turn. Nothing depends on locks but the removal of what is left over.
    let _ = turn.and_then(|_turn| file.try_lock().ok());
    Ok((file, Some((temporary, name))))
}

/// Creates something under an unused temporary name, which is short however long the final name is.
fn first_free<T>(folder: &Path, tag: &str, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(PathBuf, T)> {
    let (begin, end) = TEMPORARY;
    let mut number = 0_u64;
    loop {
        let path = folder.join(format!("{begin}{}-{number}{tag}{end}", std::process::id()));
        match make(&path) {
            Ok(made) => return Ok((path, made)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(error),
        }
    }
}

/// The part of a file's temporary name that identifies its final name.
fn tag(name: &Path) -> String {
    let mut hasher = DefaultHasher::new();
    name.file_name().hash(&mut hasher);
    format!("-{:016x}", hasher.finish())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn write_error(path: &Path, source: io::Error) -> Error {
    Error::Write { path: path.to_owned(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort_unstable();
        names
    }

    #[test]
    fn a_file_gets_its_name_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/some.txt");
        write_whole(&path, "old").unwrap();
        let mut file = Unfinished::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        drop(file);
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(path.parent().unwrap()).len()), ("old", 1));
        write_whole(&path, "new").unwrap();
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(path.parent().unwrap()).len()), ("new", 1));
    }

    #[test]
    fn a_file_that_is_still_being_written_can_be_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rec");
        assert_eq!(Unfinished::of(&path), None);
        let _other = Unfinished::create(&folder.path().join("other.rec")).unwrap();
        let mut file = Unfinished::create(&path).unwrap();
        file.write_all(b"begun").unwrap();
        assert_eq!(fs::read(Unfinished::of(&path).unwrap()).unwrap(), b"begun");
        file.finish().unwrap();
        assert_eq!(Unfinished::of(&path), None);
    }

    #[test]
    fn what_a_killed_program_left_is_removed_by_the_next_writer_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("run.rec"), folder.path().join("other.rec"));
        let left = folder.path().join(".steward-1-0-0123456789abcdef.part");
        fs::write(&left, "half").unwrap();
        fs::create_dir(folder.path().join(".steward-1-1.part")).unwrap();
        let mut begun = Unfinished::create(&path).unwrap();
        begun.write_all(b"begun").unwrap();
        assert!(!left.exists());
        write_whole(&other, "whole").unwrap();
        drop(Staging::begin(folder.path()).unwrap());
        assert_eq!(fs::read(Unfinished::of(&path).unwrap()).unwrap(), b"begun");
        begun.finish().unwrap();
        assert_eq!(names(folder.path()), ["other.rec", "run.rec"]);
    }

    /// The temporary name is no longer than the file's own.
    #[test]
    fn the_longest_possible_file_name_can_be_written() {
        let folder = tempfile::tempdir().unwrap();
        write_whole(&folder.path().join("n".repeat(255)), "").unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_without_a_reader_is_refused_and_one_with_a_reader_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let refused = write_whole(&pipe, "lost").unwrap_err();
        assert!(format!("{refused:?}").contains("a pipe that no program reads"), "{refused:?}");

        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        // The reader may not have come yet.
        while write_whole(&pipe, "read").is_err() {
            std::thread::yield_now();
        }
        assert_eq!(reader.join().unwrap(), "read");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_whole(&link, "new").unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        assert!(link.is_symlink());
        // The target of a link is relative to the link's folder, and may not exist yet.
        let dangling = folder.path().join("dangling");
        std::os::unix::fs::symlink("later/target", &dangling).unwrap();
        write_whole(&dangling, "begun").unwrap();
        assert_eq!(fs::read_to_string(folder.path().join("later/target")).unwrap(), "begun");
        assert!(dangling.is_symlink());
        write_whole(Path::new("/dev/null"), "gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_file_keeps_its_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        for mode in [0o755, 0o600, 0o444] {
            fs::write(&file, "old").unwrap();
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
            write_whole(&file, "new").unwrap();
            assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, mode);
            assert_eq!(fs::read_to_string(&file).unwrap(), "new");
            fs::remove_file(&file).unwrap();
        }
    }

    #[test]
    fn files_of_a_folder_appear_together() {
        let folder = tempfile::tempdir().unwrap();
        let begin = || Staging::begin(folder.path()).unwrap();
        let staging = begin();
        assert!(staging.is_alone().unwrap());
        staging.write("b.txt", "b").unwrap();
        staging.write("sub/a.txt", "a").unwrap();
        assert_eq!(names(folder.path()).len(), 1, "only the hidden folder remains");
        // Another one at the same time does not interfere.
        begin().write("b.txt", "lost").unwrap();
        assert_eq!(staging.read("b.txt").unwrap(), b"b");
        staging.publish(&["b.txt", "not there"]).unwrap();
        assert_eq!(names(folder.path()), ["b.txt", "sub"]);
        let mut staging = begin();
        staging.write("c.txt", "c").unwrap();
        staging.replace(vec!["b.txt".to_owned(), "not there".to_owned()]);
        staging.publish(&["c.txt"]).unwrap();
        assert_eq!(names(folder.path()), ["c.txt", "sub"]);
        assert!(!begin().is_alone().unwrap());
        assert_eq!(fs::read_to_string(folder.path().join("c.txt")).unwrap(), "c");
    }

    #[test]
    fn nothing_remains_of_files_that_are_never_published() {
        let folder = tempfile::tempdir().unwrap();
        let begin = || Staging::begin(&folder.path().join("new/run")).unwrap();
        begin().write("a.txt", "a").unwrap();
        assert!(names(folder.path()).is_empty());
        let staging = begin();
        staging.write("a.txt", "a").unwrap();
        staging.publish(&["a.txt"]).unwrap();
        begin().write("b.txt", "b").unwrap();
        assert_eq!(names(&folder.path().join("new/run")), ["a.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn remains_of_a_killed_program_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let alive = Staging::begin(folder.path()).unwrap();
        fs::create_dir(folder.path().join(".steward-1-0.part")).unwrap();
        let _another = Staging::begin(folder.path()).unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        alive.write("a.txt", "a").unwrap();
    }
}
