//! Reads the files that a scenario names.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::{Problem, ReadFile, Span, Spanned};
use maps::OccupancyGrid;
use skills::Chart;

use super::schedule::Schedule;
use crate::error::Complaints;
use crate::files::{Files, Kind};

pub(super) struct FileReader<'a> {
    pub(super) files: &'a Files,
    pub(super) complaints: &'a mut Complaints,
}

/// A map, and the warnings about it.
pub(super) type LoadedMap = (Arc<OccupancyGrid>, Vec<Problem>);

/// What a file is that a scenario names.
#[derive(Clone, Copy, Debug)]
pub(super) enum FileRole {
    /// One of a kind of which some are shipped.
    Of(Kind),
    Interface,
    Program,
    Schedule,
}

impl fmt::Display for FileRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Of(Kind::Tree) => "tree",
            Self::Of(Kind::Skill) => "machine",
            Self::Of(Kind::Properties) => "property file",
            Self::Of(Kind::Map) => "map",
            Self::Of(Kind::Places) => "places",
            Self::Interface => "interface",
            Self::Program => "program",
            Self::Schedule => "schedule",
        })
    }
}

impl FileReader<'_> {
    /// The loaded file. A file that cannot be read is reported at the line that names it.
    pub(super) fn loaded<T>(
        &mut self,
        path: &Spanned<PathBuf>,
        role: FileRole,
        result: Result<T, diagnostics::Error>,
    ) -> Option<T> {
        match result {
            Err(diagnostics::Error::Read { path: file, source }) => {
                self.complaints.push(self.files.hinted(&path.value, unreadable(&path.span, role, &file, &source)));
                None
            }
            result => self.complaints.note(result),
        }
    }

    pub(super) fn map(&mut self, path: &Spanned<PathBuf>) -> Option<LoadedMap> {
        let load = |read: ReadFile<'_>| maps::load_map_with_concerns(&path.value, read);
        let map = self.files.load(&path.value, (), |read| load(read).map(|(map, concerns)| (Arc::new(map), concerns)));
        self.loaded(path, FileRole::Of(Kind::Map), map)
    }

    /// The machine with this text in a file, or in a place of the scenario that has a name.
    pub(super) fn chart(&mut self, name: &Path, text: &str) -> Option<Arc<Chart>> {
        let load = || Chart::load(&name.display().to_string(), text);
        let chart = self.files.memo().get(name, text.to_owned(), load);
        self.complaints.note(chart)
    }

    pub(super) fn schedule(&mut self, path: &Spanned<PathBuf>) -> Option<Schedule> {
        let text = self.text(&path.span, FileRole::Schedule, &path.value)?;
        self.complaints.note(Schedule::parse(&path.value.display().to_string(), &text))
    }

    pub(super) fn text(&mut self, span: &Span, role: FileRole, path: &Path) -> Option<String> {
        let text = self.files.read_text(path);
        text.map_err(|error| self.complaints.push(self.files.hinted(path, unreadable(span, role, path, &error)))).ok()
    }
}

/// The problem of an unreadable file, at the location of its name.
pub(super) fn unreadable(span: &Span, role: FileRole, path: &Path, error: &std::io::Error) -> Problem {
    let problem = span.problem(format!("cannot read the {role} {}: {error}", path.display()));
    if diagnostics::would_be_overwritten(error) {
        return problem.with_label("named here");
    }
    let help = "a path is looked up beside the file that names it, or that of a `--set` in the current folder; and then among \
                the shipped files";
    let shipped = if let FileRole::Of(kind) = role { kind.shipped_as(span.text()) } else { None };
    let help = shipped.map_or_else(|| help.to_owned(), |shipped| format!("the shipped {role} is `{shipped}`"));
    problem.with_label("named here").with_help(help)
}
