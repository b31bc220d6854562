//! Nothing that a command reads is overwritten by it.
//!
//! A program that carries out one command line names the files that it will write before it reads any
//! ([`guard_inputs`]). From then on, every reader of this crate refuses these files, so that nothing has been run yet,
//! and every writer refuses to replace a file that was read, whichever path, link or hard link leads to it. This table
//! is the process's: it has no way around it, and a new command cannot forget it. Before the guard is set, as in
//! libraries and editors, nothing is refused.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fs, io};

use crate::{Error, normal};

static GUARDED: Mutex<Option<Guarded>> = Mutex::new(None);

/// The files of a command.
#[derive(Debug, Default)]
struct Guarded {
    outputs: Vec<Output>,
    /// The path under which each file was read.
    read: BTreeMap<Identity, PathBuf>,
}

/// A file to be written.
#[derive(Debug)]
struct Output {
    path: PathBuf,
    /// The option that names it.
    option: String,
    /// Whether its writer has begun. What it contains is then the command's own.
    is_begun: bool,
    /// Whether it was to be read. A reader may do without it and go on.
    is_needed: bool,
}

/// What all paths of a file have in common. It may belong to another file once this one is removed, so it is compared
/// only between files that exist.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

/// The identity of a file, after links; none for folders, devices and pipes, and where there is no file.
fn identity(path: &Path) -> Option<Identity> {
    let about = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Some((about.dev(), about.ino()))
    }
    #[cfg(not(unix))]
    {
        let _ = about;
        path.canonicalize().ok()
    }
}

/// The identity of a file that is to be written. Its writer creates missing folders, so `new/../file` is `file`
/// although it cannot be read under that path yet.
fn identity_if_written(path: &Path) -> Option<Identity> {
    identity(path).or_else(|| identity(&normal(path)))
}

fn guarded() -> MutexGuard<'static, Option<Guarded>> {
    GUARDED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether both paths are those of one file, which may not exist yet. A device has room for everything.
fn is_same(one: &Path, other: &Path) -> bool {
    if fs::metadata(one).is_ok_and(|about| !about.is_file()) {
        return false;
    }
    // The folder may be named in two ways although the file does not exist.
    let whole = |path: &Path| {
        let path = target(path);
        let folder = path.parent().and_then(|folder| normal(folder).canonicalize().ok());
        folder.zip(path.file_name()).map_or_else(|| normal(&path), |(folder, name)| folder.join(name))
    };
    match (identity_if_written(one), identity_if_written(other)) {
        (Some(one), Some(other)) => one == other,
        (None, None) => whole(one) == whole(other),
        _ => false,
    }
}

/// Where a link leads to; any other path itself.
fn target(path: &Path) -> PathBuf {
    fs::read_link(path).map_or_else(|_| path.to_owned(), |to| path.with_file_name(to))
}

/// Guards what this process reads, from now on: it will write these files, each named by an option of the command line,
/// whose other values are `named`.
///
/// # Errors
/// [`Error::Overwrites`] if the options name one file twice, or if an option names one that the command line also names
/// otherwise.
pub fn guard_inputs<'v>(
    outputs: impl IntoIterator<Item = (String, PathBuf)>,
    named: impl IntoIterator<Item = &'v Path>,
) -> Result<(), Error> {
    let mut all: Vec<Output> = Vec::new();
    for (option, path) in outputs {
        if let Some(other) = all.iter().find(|other| is_same(&other.path, &path)) {
            let with = if other.option == option { String::new() } else { format!("`{}` and ", other.option) };
            let why = format!("the command line names it twice, with {with}`{option}`");
            return Err(Error::Overwrites { path, why });
        }
        all.push(Output { path, option, is_begun: false, is_needed: false });
    }
    for path in named {
        if let Some(output) = all.iter().find(|output| identity(path).is_some() && is_same(&output.path, path)) {
            let why = format!("the command line names it twice, with `{}` and to be read", output.option);
            return Err(Error::Overwrites { path: path.to_owned(), why });
        }
    }
    *guarded() = Some(Guarded { outputs: all, read: BTreeMap::new() });
    Ok(())
}

/// Announces that a file will be read. Every reader of this crate does; others call it themselves.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] if the command would overwrite it, with the option that names it.
pub fn reading(path: &Path) -> io::Result<()> {
    let mut guarded = guarded();
    let Some((guarded, identity)) = guarded.as_mut().zip(identity(path)) else { return Ok(()) };
    let is_it =
        |output: &&mut Output| !output.is_begun && identity_if_written(&output.path).as_ref() == Some(&identity);
    if let Some(Output { option, is_needed, .. }) = guarded.outputs.iter_mut().find(is_it) {
        *is_needed = true;
        let why = format!("`{option}` would overwrite it; name another file there");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, WouldOverwrite(why)));
    }
    guarded.read.entry(identity).or_insert_with(|| path.to_owned());
    Ok(())
}

/// The files that this process has read, in alphabetical order; none before the guard is set.
#[must_use]
pub fn files_read() -> Vec<PathBuf> {
    let mut read: Vec<PathBuf> = guarded().iter().flat_map(|guarded| guarded.read.values().cloned()).collect();
    read.sort();
    read
}

/// Announces that a file will be written or removed. Every writer of this crate does; others call it themselves.
///
/// # Errors
/// [`Error::Overwrites`] if this process has read it.
pub fn writing(path: &Path) -> Result<(), Error> {
    check_not_read(path)?;
    let mut guarded = guarded();
    let outputs = guarded.iter_mut().flat_map(|guarded| &mut guarded.outputs);
    outputs.filter(|output| is_same(&output.path, path)).for_each(|output| output.is_begun = true);
    Ok(())
}

/// Checks before the work begins that a file can be written at its end which no option names.
///
/// # Errors
/// As [`writing`]; also if an option names the file to be written: one of both would be lost.
pub fn check_unread(path: &Path) -> Result<(), Error> {
    check_not_read(path)?;
    let guarded = guarded();
    match guarded.iter().flat_map(|guarded| &guarded.outputs).find(|output| is_same(&output.path, path)) {
        Some(Output { option, .. }) => {
            let why = format!("this command writes it, and `{option}` names it, too");
            Err(Error::Overwrites { path: path.to_owned(), why })
        }
        None => Ok(()),
    }
}

/// The same for the files of a folder: any with names such as these may be written.
///
/// # Errors
/// As [`check_unread`].
pub fn check_unread_in(folder: &Path, is_written: impl Fn(&str) -> bool) -> Result<(), Error> {
    let there = fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.file_name()));
    // Those that do not exist yet.
    let named: Vec<OsString> =
        guarded().iter().flat_map(|guarded| &guarded.outputs).filter_map(|output| file_name(&output.path)).collect();
    let written = there.chain(named).filter(|name| name.to_str().is_some_and(&is_written));
    written.map(|name| folder.join(name)).try_for_each(|path| check_unread(&path))
}

/// The name that a file gets that is written to this path, after a link.
fn file_name(path: &Path) -> Option<OsString> {
    target(path).file_name().map(OsStr::to_owned)
}

/// Whether this process has not read a file that is to be written.
fn check_not_read(path: &Path) -> Result<(), Error> {
    let guarded = guarded();
    let Some((guarded, identity)) = guarded.as_ref().zip(identity_if_written(path)) else { return Ok(()) };
    if guarded.outputs.iter().any(|output| output.is_needed && is_same(&output.path, path)) {
        return Err(Error::Overwrites { path: path.to_owned(), why: "this command needs it".to_owned() });
    }
    match guarded.read.get(&identity).filter(|read| self::identity(read) == Some(identity)) {
        None => Ok(()),
        Some(read) if read == path => {
            Err(Error::Overwrites { path: path.to_owned(), why: "this command reads it".to_owned() })
        }
        Some(read) => {
            let why = format!("this command reads it, as {}", read.display());
            Err(Error::Overwrites { path: path.to_owned(), why })
        }
    }
}

/// Whether a file was not read because the command would overwrite it. The error then contains the advice.
#[must_use]
pub fn would_be_overwritten(error: &io::Error) -> bool {
    error.get_ref().is_some_and(|inner| inner.is::<WouldOverwrite>())
}

/// Why a file is not read.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct WouldOverwrite(String);

#[cfg(test)]
mod tests {
    use super::*;

    /// One test, since the table is the process's: no other test of this crate meets it for these files.
    #[test]
    fn what_is_read_is_not_overwritten_by_whichever_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["input", "old", "results"] {
            fs::write(path(name), "a").unwrap();
        }
        fs::hard_link(path("old"), path("hard")).unwrap();
        let option = |name: &str, file: &str| (name.to_owned(), path(file));
        let guard = |outputs: Vec<(String, PathBuf)>, named: &[&str]| {
            let named: Vec<PathBuf> = named.iter().map(|name| path(name)).collect();
            guard_inputs(outputs, named.iter().map(PathBuf::as_path))
        };
        assert!(guard(vec![option("--a", "new"), option("--b", "./new")], &[]).is_err(), "one that does not exist yet");
        assert!(guard(vec![option("--a", "old"), option("--b", "hard")], &[]).is_err());
        for [one, other] in [["new", "new"], ["new", "./new"], ["old", "hard"]] {
            let refused = guard(vec![option("--a", one), option("--a", other)], &[]).unwrap_err().to_string();
            assert!(refused.contains("names it twice, with `--a`"), "{one} and {other}: {refused}");
        }
        assert!(guard(vec![option("--a", "hard")], &["input", "old"]).is_err());
        guard(vec![option("--a", "old"), option("--b", "new"), option("--c", "results")], &["input", "new"]).unwrap();

        let refused = crate::from_disk(&path("hard")).unwrap_err();
        assert!(would_be_overwritten(&refused) && refused.to_string().contains("`--a`"), "{refused}");
        assert_eq!(crate::from_disk(&path("./input")).unwrap(), b"a");
        for to in ["input", "x/../input"] {
            assert!(matches!(crate::write_whole(&path(to), "lost"), Err(Error::Overwrites { .. })), "{to}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(path("input"), path("link")).unwrap();
            assert!(matches!(crate::write_whole(&path("link"), "lost"), Err(Error::Overwrites { .. })));
        }
        let staging = crate::Staging::begin(folder.path()).unwrap();
        staging.write("input", "lost").unwrap();
        assert!(matches!(staging.publish(&["input"]), Err(Error::Overwrites { .. })));
        assert_eq!(fs::read(path("input")).unwrap(), b"a");

        assert_eq!(files_read(), [path("./input")], "under the path by which it was read");

        // Nor does the command write two things to one path.
        for name in ["new", "./results", "hard"] {
            assert!(matches!(check_unread(&path(name)), Err(Error::Overwrites { .. })), "{name}");
        }
        assert!(check_unread(&path("newer")).is_ok());
        assert!(check_unread_in(folder.path(), |name| name.starts_with("ne")).is_err());
        assert!(check_unread_in(folder.path(), |name| name.starts_with("newer")).is_ok());
        let staging = crate::Staging::begin(folder.path()).unwrap();
        staging.write("new", "lost").unwrap();
        assert!(matches!(staging.publish(&["new"]), Err(Error::Overwrites { .. })));

        // What was to be read is not overwritten later either.
        assert!(matches!(crate::write_whole(&path("old"), "lost"), Err(Error::Overwrites { .. })));
        // What the command has written itself can be read.
        crate::write_whole(&path("new"), "own").unwrap();
        assert_eq!(crate::from_disk(&path("new")).unwrap(), b"own");
        // A file that takes the place of another in the file system is not that one.
        fs::remove_file(path("results")).unwrap();
        fs::write(path("temporary"), "b").unwrap();
        assert_eq!(crate::from_disk(&path("temporary")).unwrap(), b"b");
        *guarded() = None;
    }
}
