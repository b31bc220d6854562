//! What `steward check` finds, by the files in which it is.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use campaigns::Error;
use diagnostics::{PartsOfText, Reads, parts_by_text};
use miette::{Diagnostic, LabeledSpan, MietteDiagnostic, Severity};

use crate::checked::Checked;

/// One thing that is wrong with a file, or looks wrong.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Finding {
    /// Where it is, in bytes.
    pub range: Range<usize>,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// Whether the file is refused; a warning is not an error.
    pub is_error: bool,
    /// The places that belong to it, in bytes, with what each of them is. The first is usually its own.
    pub labels: Vec<(Range<usize>, String)>,
}

/// The findings in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InText {
    /// The text in which they were found.
    pub text: Arc<str>,
    /// In the order of their places; none is there twice.
    pub findings: Vec<Finding>,
}

/// The findings in several files, by path.
pub type Findings = BTreeMap<PathBuf, InText>;

/// The findings of a check of `root`, in which these files were read.
pub fn of_check(root: &Path, root_text: &Arc<str>, checked: &Result<Checked, Error>, reads: &Reads) -> Findings {
    let mut found = Collector { root, root_text, reads, found: Findings::new() };
    match checked {
        Ok(checked) => checked.concerns.iter().for_each(|concern| found.add(concern.as_ref())),
        Err(error) => match error.diagnostics() {
            none if none.is_empty() => found.add(&MietteDiagnostic::new(error.to_string())),
            diagnostics => diagnostics.into_iter().for_each(|diagnostic| found.add(diagnostic)),
        },
    }
    found.found.values_mut().for_each(InText::tidy);
    found.found
}

/// Adds the findings of another check.
pub fn merge(into: &mut Findings, from: &Findings) {
    for (path, other) in from {
        match into.get_mut(path) {
            None => drop(into.insert(path.clone(), other.clone())),
            Some(known) => {
                known.findings.extend(other.findings.iter().cloned());
                known.tidy();
            }
        }
    }
}

impl InText {
    fn tidy(&mut self) {
        let mut known = HashSet::new();
        self.findings.retain(|finding| known.insert(finding.clone()));
        self.findings.sort_by_key(|finding| finding.range.start);
    }
}

struct Collector<'c> {
    root: &'c Path,
    root_text: &'c Arc<str>,
    reads: &'c Reads,
    found: Findings,
}

impl Collector<'_> {
    fn add(&mut self, diagnostic: &dyn Diagnostic) {
        for PartsOfText { text, parts } in parts_by_text(diagnostic) {
            let path = text.as_ref().and_then(|(name, _)| self.reads.path(name));
            match (text, path) {
                (Some((_, text)), Some(path)) => {
                    let findings = parts.into_iter().map(|part| in_text(part, &text)).collect();
                    self.push(path, &text.as_ref().into(), findings);
                }
                // One of the files that come with the program, or text that it made itself.
                (Some((name, _)), None) => self.add_at_root(parts, |part| format!("{name}: {part}")),
                (None, _) => self.add_at_root(parts, |part| part.to_string()),
            }
        }
    }

    fn add_at_root(&mut self, parts: Vec<&dyn Diagnostic>, message: impl Fn(&dyn Diagnostic) -> String) {
        let at_start = |part| Finding { range: 0..0, message: message(part), labels: Vec::new(), ..in_text(part, "") };
        let findings = parts.into_iter().map(at_start).collect();
        self.push(self.root.to_owned(), self.root_text, findings);
    }

    fn push(&mut self, path: PathBuf, text: &Arc<str>, findings: Vec<Finding>) {
        let of_file = self.found.entry(path);
        of_file.or_insert_with(|| InText { text: Arc::clone(text), findings: Vec::new() }).findings.extend(findings);
    }
}

/// A part of a diagnostic in its text.
fn in_text(part: &dyn Diagnostic, text: &str) -> Finding {
    let labels: Vec<_> = part.labels().into_iter().flatten().collect();
    let range = |label: &LabeledSpan| {
        let [start, end] = [label.offset(), label.offset() + label.len()].map(|at| text.floor_char_boundary(at));
        start..end
    };
    Finding {
        range: labels.first().map_or(0..0, range),
        message: part.to_string(),
        help: part.help().map(|help| help.to_string()).filter(|help| !help.is_empty()),
        is_error: part.severity().unwrap_or_default() == Severity::Error,
        labels: labels.iter().filter_map(|label| Some((range(label), label.label()?.to_owned()))).collect(),
    }
}
