//! The files on disk as an editor shows them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;
use std::{fs, io};

use crate::files::{MAX_BYTES, MAX_TEXT_BYTES, too_large};
use crate::{Memo, from_disk_up_to, normal, text};

/// The files on disk, except that some may be open in an editor: their texts are read instead, saved or not. Cheap to
/// clone.
///
/// ```
/// use diagnostics::Disk;
///
/// let disk = Disk::with_open([("/home/me/a.toml".into(), "seed = 3".into())]);
/// assert_eq!(disk.read_text("/home/me/trees/../a.toml".as_ref())?, "seed = 3");
/// assert!(!disk.exists("/home/me/b.toml".as_ref()));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Disk {
    /// By [normal](normal) path.
    open: Arc<BTreeMap<PathBuf, Arc<str>>>,
    reads: Option<Arc<Mutex<Reads>>>,
    memo: Arc<Memo>,
}

/// What distinguishes one saved state of a file from another: when it was changed, and its length in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileStamp(SystemTime, u64);

impl FileStamp {
    /// The state of a file; nothing if there is none.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let about = fs::metadata(path).ok()?;
        Some(Self(about.modified().ok()?, about.len()))
    }
}

/// The files that were requested.
#[derive(Clone, Debug, Default)]
pub struct Reads {
    /// Their [normal](normal) paths, whether they exist or not, with the state that each had before it was read first.
    pub paths: BTreeMap<PathBuf, Option<FileStamp>>,
    /// The path of each file that was read under another name.
    named: BTreeMap<PathBuf, PathBuf>,
}

impl Reads {
    /// The [normal](normal) path of the file that has this name in messages, if it was read.
    #[must_use]
    pub fn path(&self, name: &str) -> Option<PathBuf> {
        let path = self.named.get(Path::new(name)).cloned().unwrap_or_else(|| normal(Path::new(name)));
        Some(path).filter(|path| self.paths.contains_key(path))
    }
}

impl Disk {
    /// The paths of the files that are open.
    pub fn open_paths(&self) -> impl Iterator<Item = &Path> {
        self.open.keys().map(PathBuf::as_path)
    }

    /// The disk with these texts in place of the files with these paths, or in addition to them.
    #[must_use]
    pub fn with_open(documents: impl IntoIterator<Item = (PathBuf, Arc<str>)>) -> Self {
        let open = documents.into_iter().map(|(path, text)| (normal(&path), text)).collect();
        Self { open: Arc::new(open), ..Self::default() }
    }

    /// The same disk, with the values that were made from the files of another one, perhaps in an earlier state.
    #[must_use]
    pub fn with_memo(self, memo: &Arc<Memo>) -> Self {
        Self { memo: Arc::clone(memo), ..self }
    }

    /// The values that were made from its files; clones share them.
    #[must_use]
    pub fn memo(&self) -> &Arc<Memo> {
        &self.memo
    }

    /// The same disk, remembering what is requested from it and from its clones.
    #[must_use]
    pub fn remembering(&self) -> Self {
        Self { reads: Some(Arc::default()), ..self.clone() }
    }

    /// What was requested from it so far; nothing unless it is [remembering](Self::remembering).
    #[must_use]
    pub fn reads(&self) -> Reads {
        self.remembered().map(|reads| reads.clone()).unwrap_or_default()
    }

    fn remembered(&self) -> Option<MutexGuard<'_, Reads>> {
        self.reads.as_ref().map(|reads| reads.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn ask(&self, path: &Path) -> Option<&Arc<str>> {
        if self.open.is_empty() && self.reads.is_none() {
            return None;
        }
        let path = normal(path);
        let open = self.open.get(&path);
        if let Some(mut reads) = self.remembered() {
            reads.paths.entry(path).or_insert_with_key(|path| FileStamp::of(path));
        }
        open
    }

    /// Whether there is a file or a folder.
    #[must_use]
    pub fn exists(&self, path: &Path) -> bool {
        self.ask(path).is_some() || path.exists()
    }

    /// Whether there is a file, and not a folder.
    #[must_use]
    pub fn is_file(&self, path: &Path) -> bool {
        self.ask(path).is_some() || path.is_file()
    }

    /// Reads a file.
    ///
    /// # Errors
    /// As [`from_disk`](crate::from_disk).
    pub fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.read_up_to(path, MAX_BYTES)
    }

    /// Reads the file that has the name `name` in messages.
    ///
    /// # Errors
    /// As [`from_disk`](crate::from_disk).
    pub fn read_named(&self, path: &Path, name: &Path) -> io::Result<Vec<u8>> {
        if let Some(mut reads) = self.remembered() {
            reads.named.insert(name.to_owned(), normal(path));
        }
        self.read(path)
    }

    /// Reads a file of at most `max_bytes` bytes.
    ///
    /// # Errors
    /// As [`from_disk_up_to`].
    pub fn read_up_to(&self, path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
        match self.ask(path) {
            Some(open) if open.len() as u64 > max_bytes => Err(too_large(max_bytes)),
            Some(open) => Ok(open.as_bytes().to_vec()),
            None => from_disk_up_to(path, max_bytes),
        }
    }

    /// Reads a text file, without the byte order mark that some editors write.
    ///
    /// # Errors
    /// As [`text_from_disk`](crate::text_from_disk).
    pub fn read_text(&self, path: &Path) -> io::Result<String> {
        text(self.read_up_to(path, MAX_TEXT_BYTES)?)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn an_open_file_is_read_instead_of_the_saved_one() {
        let folder = tempfile::tempdir().unwrap();
        let [saved, open] = ["saved.toml", "open.toml"].map(|name| folder.path().join(name));
        fs::write(&saved, "saved").unwrap();
        fs::write(&open, "old").unwrap();
        let disk = Disk::with_open([(open.clone(), "new".into())]);
        assert_eq!(disk.read_text(&saved).unwrap(), "saved");
        assert_eq!(disk.read_text(&folder.path().join("x/../open.toml")).unwrap(), "new");
        assert_eq!(disk.read_up_to(&open, 2).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert!(disk.is_file(&open) && !disk.is_file(folder.path()) && disk.exists(folder.path()));
    }

    #[test]
    fn what_is_asked_for_is_remembered_even_if_it_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let disk = Disk::with_open([(path("trees/a.xml"), "<root/>".into())]).remembering();
        assert!(disk.clone().read_named(&path("trees/a.xml"), Path::new("trees/a.xml")).is_ok());
        assert!(!disk.exists(&path("b.xml")));
        let reads = disk.reads();
        assert!(reads.paths.keys().eq([&path("b.xml"), &path("trees/a.xml")]), "{reads:?}");
        assert_eq!(reads.path("trees/a.xml"), Some(path("trees/a.xml")));
        assert_eq!(reads.path("trees/c.xml"), None);
    }
}
