//! Files with results, each in the format of its ending.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::results::Results;
use crate::{Error, junit, markdown, sarif};

/// What our files begin with is within this many bytes.
const BEGINNING: u64 = 1024;

/// A file for results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResultsFile {
    path: PathBuf,
    format: ResultsFormat,
}

/// How results are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultsFormat {
    /// JUnit XML.
    Junit,
    /// SARIF 2.1.0.
    Sarif,
    /// A summary in Markdown.
    Markdown,
}

impl ResultsFile {
    /// A file with this format, whatever its name is.
    #[must_use]
    pub fn new(path: PathBuf, format: ResultsFormat) -> Self {
        Self { path, format }
    }

    /// A file in the format of its ending; `None` if the ending is that of no format.
    #[must_use]
    pub fn of_name(path: &str) -> Option<Self> {
        let ending = Path::new(path).extension()?.to_str()?.to_ascii_lowercase();
        let format = match ending.as_str() {
            "xml" => ResultsFormat::Junit,
            "sarif" => ResultsFormat::Sarif,
            "md" => ResultsFormat::Markdown,
            _ => return None,
        };
        Some(Self::new(PathBuf::from(path), format))
    }

    /// Its name.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether there can be no such file: it is a folder, or what is to be its folder is a file.
    #[must_use]
    pub fn is_impossible(&self) -> bool {
        let there_is = self.path.ancestors().skip(1).find(|folder| folder.exists());
        self.path.is_dir() || there_is.is_some_and(|folder| !folder.is_dir())
    }

    /// Whether nothing is lost if it is written: there is no such file yet, or it is empty, or its beginning shows that
    /// it contains earlier results in this format. A device or a pipe is not read.
    #[must_use]
    pub fn is_free(&self) -> bool {
        if !std::fs::metadata(&self.path).is_ok_and(|about| about.is_file() && about.len() > 0) {
            return true;
        }
        let mut beginning = Vec::new();
        let read = File::open(&self.path).and_then(|file| file.take(BEGINNING).read_to_end(&mut beginning));
        let begins = match self.format {
            ResultsFormat::Junit => junit::begins,
            ResultsFormat::Sarif => sarif::begins,
            ResultsFormat::Markdown => markdown::begins,
        };
        read.is_ok() && begins(&String::from_utf8_lossy(&beginning))
    }

    /// Whether it contains the stories of violations, which take longer to find than verdicts.
    #[must_use]
    pub fn has_stories(&self) -> bool {
        self.format == ResultsFormat::Markdown
    }

    /// Removes what it contains. A link remains a link: its target is removed. A device or a pipe stays.
    ///
    /// # Errors
    /// [`Error::File`] if that is not possible.
    pub fn remove(&self) -> Result<(), Error> {
        match self.path.canonicalize() {
            // One that is empty contains no results, and may be something else.
            Ok(path) if path.metadata().is_ok_and(|about| about.is_file() && about.len() > 0) => {
                diagnostics::writing(&path)?;
                let removed = std::fs::remove_file(&path);
                removed.map_err(|source| diagnostics::Error::Write { path: self.path.clone(), source }.into())
            }
            _ => Ok(()),
        }
    }

    /// Writes it, and creates missing folders. Returns what is left out because of limits, in words.
    ///
    /// # Errors
    /// [`Error::File`] if that is not possible.
    pub fn write(&self, results: &Results) -> Result<Vec<String>, Error> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let (text, left_out) = match self.format {
            ResultsFormat::Junit => (junit::document(results), Vec::new()),
            ResultsFormat::Sarif => sarif::document(results),
            ResultsFormat::Markdown => markdown::document(results, folder),
        };
        diagnostics::write_whole(&self.path, text)?;
        Ok(left_out)
    }
}
