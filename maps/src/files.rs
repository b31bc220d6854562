//! Where files come from.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use crate::{Error, FileProblems, Source};

/// Reads a whole file. The loaders of this crate take one, so that files can lie on disk, in the program or in a test.
pub type ReadFile<'r> = &'r dyn Fn(&Path) -> io::Result<Vec<u8>>;

/// Larger files are refused: no map that is allowed needs more.
const MAX_BYTES: u64 = 1 << 30;

/// Reads a file from disk; a [`ReadFile`].
///
/// # Errors
/// What the system says, and [`io::ErrorKind::FileTooLarge`] for more than 1 GiB.
pub fn from_disk(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "it is larger than 1 GiB"));
    }
    Ok(bytes)
}

/// Reads a text file, without the byte order mark that some editors put first.
pub(crate) fn read_text(path: &Path, read: ReadFile<'_>) -> Result<String, Error> {
    let bytes = read(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let text = String::from_utf8(bytes).map_err(|error| not_text(path, &error))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn not_text(path: &Path, error: &std::string::FromUtf8Error) -> FileProblems {
    // What comes before the offending byte is the same in the readable version.
    let readable = String::from_utf8_lossy(error.as_bytes());
    let source = Source::new(&path.display().to_string(), readable);
    let at = error.utf8_error().valid_up_to();
    source.span(at..at + 1).problem("the file is not text in UTF-8").with_label("this byte is no character").into()
}
