//! Reads the files that a scenario names.

use std::path::{Path, PathBuf};

use diagnostics::{Problem, Span, Spanned};

use super::schedule::Schedule;
use crate::error::Complaints;
use crate::files::{Files, shipped_as};

/// Reads the files that a scenario names, and records their problems.
pub(super) struct FileReader<'a> {
    /// Where they are looked up.
    pub(super) files: &'a Files,
    pub(super) complaints: &'a mut Complaints,
}

impl FileReader<'_> {
    /// The loaded file. A file that cannot be read is reported at the line that names it.
    pub(super) fn loaded<T>(
        &mut self,
        path: &Spanned<PathBuf>,
        what: &str,
        result: Result<T, diagnostics::Error>,
    ) -> Option<T> {
        match result {
            Err(diagnostics::Error::Read { path: file, source }) => {
                self.complaints.push(self.files.hinted(&path.value, unreadable(&path.span, what, &file, &source)));
                None
            }
            result => self.complaints.note(result),
        }
    }

    /// The schedule in a file.
    pub(super) fn schedule(&mut self, path: &Spanned<PathBuf>) -> Option<Schedule> {
        let text = self.text(&path.span, "schedule", &path.value)?;
        self.complaints.note(Schedule::parse(&path.value.display().to_string(), &text))
    }

    /// The text of the file named at `span`.
    pub(super) fn text(&mut self, span: &Span, what: &str, path: &Path) -> Option<String> {
        let text = self.files.read_text(path);
        text.map_err(|error| self.complaints.push(self.files.hinted(path, unreadable(span, what, path, &error)))).ok()
    }
}

/// The problem of an unreadable file, at the location of its name.
pub(super) fn unreadable(span: &Span, what: &str, path: &Path, error: &std::io::Error) -> Problem {
    let problem = span.problem(format!("cannot read the {what} {}: {error}", path.display()));
    if diagnostics::would_be_overwritten(error) {
        return problem.with_label("named here");
    }
    let help = "a path is looked up beside the file that names it, or that of a `--set` in the current folder; and then among \
                the shipped files";
    let shipped = shipped_as(what, span.text());
    let help = shipped.map_or_else(|| help.to_owned(), |shipped| format!("the shipped {what} is `{shipped}`"));
    problem.with_label("named here").with_help(help)
}
