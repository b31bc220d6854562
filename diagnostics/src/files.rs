//! Reading files, with limits.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::{Error, FileProblems, Source, reading};

/// Reads a whole file. Loaders take such a function, so that files can come from disk, from the program or from a test.
pub type ReadFile<'r> = &'r dyn Fn(&Path) -> io::Result<Vec<u8>>;

/// Larger files are refused: no valid map needs more.
pub(crate) const MAX_BYTES: u64 = 1 << 30;

/// Longer texts are refused: even generated scenarios and trees are far shorter.
pub(crate) const MAX_TEXT_BYTES: u64 = 1 << 24;

/// Reads a file from disk; a [`ReadFile`].
///
/// # Errors
/// The operating system's error; [`io::ErrorKind::InvalidInput`] for a device or a pipe, which might never end;
/// [`io::ErrorKind::FileTooLarge`] for more than 1 GiB.
pub fn from_disk(path: &Path) -> io::Result<Vec<u8>> {
    from_disk_up_to(path, MAX_BYTES)
}

/// Reads a file of at most `max_bytes` bytes from disk.
///
/// # Errors
/// As [`from_disk`], with this limit.
pub fn from_disk_up_to(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    bounded(regular(path, max_bytes)?, max_bytes)
}

/// Reads a file or a pipe.
///
/// # Errors
/// The operating system's error; [`io::ErrorKind::FileTooLarge`] for more than 1 GiB.
pub fn from_disk_or_pipe(path: &Path) -> io::Result<Vec<u8>> {
    reading(path)?;
    bounded(File::open(path).map_err(in_words)?, MAX_BYTES)
}

/// Reads a text file from disk, without the byte order mark that some editors write.
///
/// # Errors
/// As [`from_disk`], but for more than 16 MiB; [`io::ErrorKind::InvalidData`] if it is not UTF-8.
pub fn text_from_disk(path: &Path) -> io::Result<String> {
    text(from_disk_up_to(path, MAX_TEXT_BYTES)?)
}

/// Bytes as text, without the byte order mark.
///
/// # Errors
/// [`io::ErrorKind::FileTooLarge`] for more than 16 MiB; [`io::ErrorKind::InvalidData`] if they are not UTF-8.
pub fn text(bytes: Vec<u8>) -> io::Result<String> {
    let bytes = of_text(bytes)?;
    let not_text = |_| io::Error::new(io::ErrorKind::InvalidData, "the file is not UTF-8 text");
    String::from_utf8(bytes).map(without_mark).map_err(not_text)
}

/// Opens a file for reading. It does not wait for a writer to open a pipe, and refuses devices, which may never end.
///
/// # Errors
/// The operating system's error; [`io::ErrorKind::InvalidInput`] for a device or a pipe.
pub fn open_regular(path: &Path) -> io::Result<File> {
    regular(path, u64::MAX)
}

/// Opens a file within the limit.
fn regular(path: &Path, max_bytes: u64) -> io::Result<File> {
    let found = fs::metadata(path).map_err(in_words)?;
    if !found.is_file() && !found.is_dir() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file but a device or a pipe"));
    }
    if found.len() > max_bytes {
        return Err(too_large(max_bytes));
    }
    reading(path)?;
    File::open(path)
}

/// The most common error in plain words, and others unchanged.
fn in_words(error: io::Error) -> io::Error {
    match error.kind() {
        kind @ io::ErrorKind::NotFound => io::Error::new(kind, "there is no such file"),
        _ => error,
    }
}

/// Reads everything within the limit.
fn bounded(from: impl Read, max_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(max_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes { Err(too_large(max_bytes)) } else { Ok(bytes) }
}

/// The bytes of a text, if they are not too many.
fn of_text(bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    if bytes.len() as u64 > MAX_TEXT_BYTES { Err(too_large(MAX_TEXT_BYTES)) } else { Ok(bytes) }
}

pub(crate) fn too_large(max_bytes: u64) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("larger than {} MiB", max_bytes >> 20))
}

fn without_mark(text: String) -> String {
    text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text)
}

/// Reads a text file through `read`, without the byte order mark that some editors write.
///
/// # Errors
/// [`Error::Read`] if it cannot be read, or has more than 16 MiB; [`Error::Problems`] with the first byte that is not
/// UTF-8.
pub fn read_text(path: &Path, read: ReadFile<'_>) -> Result<String, Error> {
    let bytes = read(path).and_then(of_text).map_err(|source| Error::Read { path: path.into(), source })?;
    let text = String::from_utf8(bytes).map_err(|error| not_text(path, &error))?;
    Ok(without_mark(text))
}

fn not_text(path: &Path, error: &std::string::FromUtf8Error) -> FileProblems {
    // Up to the offending byte, the readable version of the text is the same.
    let readable = String::from_utf8_lossy(error.as_bytes());
    let source = Source::new(&path.display().to_string(), readable);
    let at = error.utf8_error().valid_up_to();
    source
        .span(at..at + 1)
        .problem("the file is not UTF-8 text")
        .with_label("this byte is not part of a character")
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_limited_however_its_bytes_are_read() {
        let bytes = |more: usize| vec![b'a'; MAX_TEXT_BYTES as usize + more];
        let read = |more: usize| read_text(Path::new("a.toml"), &|_| Ok(bytes(more)));
        assert!(text(bytes(0)).is_ok() && read(0).is_ok());
        assert_eq!(text(bytes(1)).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        let Err(Error::Read { source, .. }) = read(1) else { panic!("it is too large") };
        assert_eq!(source.to_string(), "larger than 16 MiB");
    }
}
