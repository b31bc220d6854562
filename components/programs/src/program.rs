//! The program to run: a command, its folder, its environment and its limits.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use std::{env, fmt};

use diagnostics::Problem;

/// The variables of the caller's environment that a program inherits: those by which it and its libraries are found.
const INHERITED: [&str; 9] =
    ["PATH", "HOME", "TMPDIR", "LD_LIBRARY_PATH", "PYTHONPATH", "PATHEXT", "SystemRoot", "TEMP", "TMP"];

/// The variables that are the same for all programs, so that they behave the same everywhere.
const FIXED: [(&str, &str); 5] = [
    ("LC_ALL", "C.UTF-8"),
    ("TZ", "UTC"),
    // Python prints lines at once, always iterates over sets in the same order, and leaves no files behind.
    ("PYTHONUNBUFFERED", "1"),
    ("PYTHONHASHSEED", "0"),
    ("PYTHONDONTWRITEBYTECODE", "1"),
];

/// A program that a component runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    words: Vec<Word>,
    folder: Option<PathBuf>,
    pub(crate) limits: Limits,
}

/// A word of a program's command.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Word {
    /// Plain text, passed as by a shell.
    Text(String),
    /// A file that is not on disk: while the program runs, it exists in a temporary folder, and its path is passed.
    File {
        /// Its name.
        name: String,
        /// Its contents.
        contents: Arc<[u8]>,
    },
}

/// The resources that a program may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The maximum time for an answer, in real time.
    pub answer_within: Duration,
    /// The maximum address space of each of its processes, in bytes. This is limited only on Linux.
    pub memory_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { answer_within: Duration::from_secs(10), memory_bytes: 1 << 30 }
    }
}

impl Program {
    /// The program that this command starts in this folder, or in a temporary one. The command begins with the path of
    /// an executable file, relative to the folder, or with the name of one on the `PATH`; its arguments follow.
    ///
    /// # Errors
    /// A [`Problem`] without a location if there is no such program, or if the file cannot be executed.
    pub fn new(words: Vec<Word>, folder: Option<&Path>, limits: Limits) -> Result<Self, Problem> {
        let program = Self { words, folder: folder.map(Path::to_owned), limits };
        match program.words.first() {
            None => Err(Problem::new("the command is empty").with_help(EXAMPLE)),
            Some(Word::File { name, .. }) => {
                Err(Problem::new(format!("the file {name} comes with this program and cannot be executed"))
                    .with_help(EXAMPLE))
            }
            Some(Word::Text(name)) => program.find(name).map(|_| program.clone()),
        }
    }

    /// The path of the executable file that the first word names.
    fn find(&self, name: &str) -> Result<PathBuf, Problem> {
        let is_path = Path::new(name).components().count() > 1 || name.contains(std::path::is_separator);
        if !is_path {
            let path = env::var_os("PATH").unwrap_or_default();
            let places = env::split_paths(&path).map(|folder| folder.join(name));
            return places.into_iter().find(|place| is_executable(place)).ok_or_else(|| self.missing(name));
        }
        let file = self.beside(name);
        let file = std::path::absolute(&file).unwrap_or(file);
        if is_executable(&file) {
            Ok(file)
        } else if file.is_file() {
            let help = "make it executable (`chmod +x`), or name the interpreter that runs it: program = [\"python3\", \"FILE\"]";
            Err(Problem::new(format!("the program {} is not executable", file.display())).with_help(help))
        } else {
            Err(Problem::new(format!("there is no program {}", file.display())).with_help(EXAMPLE))
        }
    }

    fn beside(&self, name: &str) -> PathBuf {
        self.folder.as_deref().unwrap_or(Path::new("")).join(name)
    }

    fn missing(&self, name: &str) -> Problem {
        let help = if self.beside(name).is_file() {
            format!("to run the file beside the scenario, write `./{name}`")
        } else {
            EXAMPLE.to_owned()
        };
        Problem::new(format!("there is no program `{name}` on the PATH")).with_help(help)
    }

    /// The executable file and its arguments. Files that are not on disk are written to `folder`.
    pub(crate) fn command(&self, folder: &Path) -> std::io::Result<Vec<OsString>> {
        let mut command = Vec::new();
        for (index, word) in self.words.iter().enumerate() {
            command.push(match word {
                Word::Text(name) if index == 0 => {
                    let missing = |problem: Problem| std::io::Error::other(problem.to_string());
                    self.find(name).map_err(missing)?.into_os_string()
                }
                Word::Text(text) => text.into(),
                Word::File { name, contents } => {
                    let file = folder.join(Path::new(name).file_name().unwrap_or(OsStr::new("file")));
                    std::fs::write(&file, contents)?;
                    file.into_os_string()
                }
            });
        }
        Ok(command)
    }

    /// Whether it needs a temporary folder, for its files or as its working directory.
    pub(crate) fn needs_folder(&self) -> bool {
        self.folder.is_none() || self.words.iter().any(|word| matches!(word, Word::File { .. }))
    }

    /// Its working directory, if that is not temporary.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Its whole environment.
    pub(crate) fn environment() -> impl Iterator<Item = (&'static str, OsString)> {
        let inherited = INHERITED.into_iter().filter_map(|name| Some((name, env::var_os(name)?)));
        inherited.chain(FIXED.into_iter().map(|(name, value)| (name, value.into())))
    }
}

const EXAMPLE: &str = "name a program and its arguments: program = [\"python3\", \"speaker.py\"]";

#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    file.is_file() && rustix::fs::access(file, rustix::fs::Access::EXEC_OK).is_ok()
}

/// Elsewhere, the system decides when the program starts.
#[cfg(not(unix))]
fn is_executable(file: &Path) -> bool {
    file.is_file() || file.with_extension("exe").is_file()
}

/// The command, as a person would type it.
impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = self.words.iter().map(|word| match word {
            Word::Text(text) if text.is_empty() || text.contains(char::is_whitespace) => format!("{text:?}"),
            Word::Text(text) => text.clone(),
            Word::File { name, .. } => name.clone(),
        });
        f.write_str(&words.collect::<Vec<_>>().join(" "))
    }
}
