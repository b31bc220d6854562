//! `steward fmt`: one layout for each kind of file.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use campaigns::Error;
use checks::Language;
use clap::Args;
use diagnostics::{counted, from_disk, read_text, rewrite_whole, text_from_disk, xml};
use similar::TextDiff;

use crate::output::{complain, print, print_exactly};

/// What stands for stdin.
const STDIN: &str = "-";

/// The longest text that is read from stdin.
const MAX_BYTES: u64 = 1 << 24;

/// The most places of a file that are shown.
const MOST_PLACES: usize = 3;

/// What to lay out.
#[derive(Debug, Args)]
pub(crate) struct FmtArgs {
    /// Trees (.xml), machines (.scxml) and property files (.scope), or folders that contain some; `-` reads a file from
    /// stdin and prints it
    #[arg(value_name = "FILE|FOLDER|-", required = true)]
    files: Vec<PathBuf>,
    /// Writes nothing: shows the first places that would change, and exits with 1 if there are any
    #[arg(long)]
    check: bool,
    /// The name of the file on stdin, which shows its kind [default: its contents do]
    #[arg(long, value_name = "FILE")]
    stdin_name: Option<PathBuf>,
}

/// Lays out files, or checks that they are. Exit status 1 if a file would change, 2 if one is refused, and 3 if one
/// cannot be written.
pub(crate) fn fmt(args: &FmtArgs) -> Result<ExitCode, Error> {
    let is_stdin = args.files.iter().any(|file| file == Path::new(STDIN));
    if is_stdin && args.files.len() > 1 {
        return Err(Error::refused("`-` is given beside other files", "lay them out by two commands"));
    }
    if !is_stdin && args.stdin_name.is_some() {
        return Err(Error::refused("--stdin-name is given, but stdin is not read", "give `-` instead of files"));
    }
    if is_stdin { from_stdin(args) } else { files(args) }
}

fn from_stdin(args: &FmtArgs) -> Result<ExitCode, Error> {
    let path = args.stdin_name.as_deref().unwrap_or(Path::new("<stdin>"));
    let bytes = read_text(path, &|_| {
        let mut bytes = Vec::new();
        io::stdin().take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("larger than {} MiB", MAX_BYTES >> 20)));
        }
        Ok(bytes)
    });
    let text = bytes?;
    let language = match &args.stdin_name {
        Some(name) => language_of(name)?,
        None => Language::of_text(&text),
    };
    let laid_out = language.layout(path, &text)?;
    if !args.check {
        print_exactly(&laid_out)?;
    } else if laid_out != text {
        print(&difference(path, &text, &laid_out))?;
        return Ok(ExitCode::from(1));
    }
    Ok(ExitCode::SUCCESS)
}

fn files(args: &FmtArgs) -> Result<ExitCode, Error> {
    let mut files = Vec::new();
    for path in &args.files {
        let before = files.len();
        if path.is_dir() {
            find(path, &mut files)?;
            if files.len() == before {
                let message = format!("{} contains no trees, machines or property files", path.display());
                return Err(Error::refused(message, "they end in .xml, .scxml and .scope"));
            }
        } else {
            files.push(path.clone());
        }
    }
    let (mut changed, mut worst) = (0, 0);
    for file in &files {
        match one(file, args.check) {
            Ok(is_changed) => changed += usize::from(is_changed),
            Err(error) => {
                complain(&error);
                worst = worst.max(error.exit_status());
            }
        }
    }
    if files.len() > 1 {
        let what = if args.check { "would change" } else { "changed" };
        print(&format!("{}, {changed} of them {what}\n", counted(files.len(), "file")))?;
    }
    Ok(ExitCode::from(if worst == 0 && args.check && changed > 0 { 1 } else { worst }))
}

/// Finds the files in a folder that have a layout, in order. Hidden ones, links, and files in XML whose outermost
/// element is not that of a tree are none.
fn find(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), Error> {
    let unreadable = |source| diagnostics::Error::Read { path: folder.to_owned(), source };
    let entries: io::Result<Vec<fs::DirEntry>> = fs::read_dir(folder).and_then(Iterator::collect);
    let mut entries = entries.map_err(unreadable)?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let (kind, path) = (entry.file_type().map_err(unreadable)?, entry.path());
        let is_hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        if is_hidden || kind.is_symlink() {
        } else if kind.is_dir() {
            find(&path, found)?;
        } else if Language::of_name(&path).is_some_and(|language| is_one(language, &path)) {
            found.push(path);
        }
    }
    Ok(())
}

/// Whether a file is one of this language. One that cannot be read is, so that this is reported.
fn is_one(language: Language, path: &Path) -> bool {
    let Language::Tree = language else { return true };
    text_from_disk(path).map_or(true, |text| xml::root_name(&text) == Some("root"))
}

/// Lays out a file, or only shows what would change. Whether it changes.
fn one(file: &Path, is_check: bool) -> Result<bool, Error> {
    let language = language_of(file)?;
    let bytes = from_disk(file).map_err(|source| diagnostics::Error::Read { path: file.to_owned(), source })?;
    let text = read_text(file, &|_| Ok(bytes.clone()))?;
    let laid_out = language.layout(file, &text)?;
    if laid_out.as_bytes() == bytes {
        return Ok(false);
    }
    if is_check {
        print(&difference(file, &text, &laid_out))?;
    } else {
        rewrite_whole(file, &laid_out)?;
        print(&format!("{} changed\n", file.display()))?;
    }
    Ok(true)
}

fn language_of(file: &Path) -> Result<Language, Error> {
    Language::of_name(file).ok_or_else(|| {
        let message = format!("{} is not a kind of file that has a layout", file.display());
        Error::refused(message, "trees end in .xml, machines in .scxml, and property files in .scope")
    })
}

/// The first places in which two texts differ.
fn difference(file: &Path, old: &str, new: &str) -> String {
    let file = file.display();
    let difference = TextDiff::from_lines(old, new);
    let mut unified = difference.unified_diff();
    let places: Vec<String> = unified.context_radius(1).iter_hunks().map(|hunk| hunk.to_string()).collect();
    if places.is_empty() {
        return format!("{file} would change: its byte order mark\n");
    }
    let more = match places.len().saturating_sub(MOST_PLACES) {
        0 => String::new(),
        more => format!("and {}\n", counted(more, "more place")),
    };
    format!("{file} would change:\n{}{more}", places[..places.len().min(MOST_PLACES)].concat())
}
