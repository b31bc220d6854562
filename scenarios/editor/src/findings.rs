//! What `steward check` finds, by the files in which it is.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use campaigns::Error;
use diagnostics::Reads;
use miette::{Diagnostic, Severity, SourceCode, SourceSpan};

use crate::check::Checked;
use crate::parts::{Part, parts};

/// One thing that is wrong with a file, or looks wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
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
pub(crate) fn of_check(root: &Path, root_text: &str, checked: &Result<Checked, Error>, reads: &Reads) -> Findings {
    let mut found = Collector { root, root_text, reads, found: Findings::new() };
    match checked {
        Ok(checked) => checked.concerns.iter().for_each(|concern| found.add(concern.as_ref())),
        Err(error) => match error.diagnostics() {
            none if none.is_empty() => found.add_at_root(error.to_string(), None, true),
            diagnostics => diagnostics.into_iter().for_each(|diagnostic| found.add(diagnostic)),
        },
    }
    found.found
}

/// Adds the findings of another check.
pub(crate) fn merge(into: &mut Findings, from: &Findings) {
    for (path, other) in from {
        match into.get_mut(path) {
            None => drop(into.insert(path.clone(), other.clone())),
            Some(known) => {
                let new = other.findings.iter().filter(|finding| !known.findings.contains(finding));
                let new: Vec<Finding> = new.cloned().collect();
                known.findings.extend(new);
                known.findings.sort_by_key(|finding| finding.range.start);
            }
        }
    }
}

struct Collector<'c> {
    root: &'c Path,
    root_text: &'c str,
    reads: &'c Reads,
    found: Findings,
}

impl Collector<'_> {
    fn add(&mut self, diagnostic: &dyn Diagnostic) {
        for part in parts(diagnostic) {
            self.add_part(part);
        }
    }

    fn add_part(&mut self, (part, text): Part<'_>) {
        let is_error = part.severity().unwrap_or_default() == Severity::Error;
        let help = part.help().map(|help| help.to_string()).filter(|help| !help.is_empty());
        let named = text.and_then(whole);
        let Some((name, text)) = named else { return self.add_at_root(part.to_string(), help, is_error) };
        let Some(path) = self.reads.path(&name) else {
            // One of the files that come with the program, or text that it made itself.
            return self.add_at_root(format!("{name}: {part}"), help, is_error);
        };
        let labels: Vec<_> = part.labels().into_iter().flatten().collect();
        let range = |offset: usize, length: usize| {
            let [start, end] = [offset, offset + length].map(|at| text.floor_char_boundary(at));
            start..end
        };
        let finding = Finding {
            range: labels.first().map_or(0..0, |first| range(first.offset(), first.len())),
            message: part.to_string(),
            help,
            is_error,
            labels: labels
                .iter()
                .filter_map(|label| Some((range(label.offset(), label.len()), label.label()?.to_owned())))
                .collect(),
        };
        self.push(path, &text, finding);
    }

    fn add_at_root(&mut self, message: String, help: Option<String>, is_error: bool) {
        let finding = Finding { range: 0..0, message, help, is_error, labels: Vec::new() };
        self.push(self.root.to_owned(), self.root_text, finding);
    }

    fn push(&mut self, path: PathBuf, text: &str, finding: Finding) {
        let found = InText { text: text.into(), findings: vec![finding] };
        merge(&mut self.found, &Findings::from([(path, found)]));
    }
}

/// The name of a text, and the text.
fn whole(text: &dyn SourceCode) -> Option<(String, String)> {
    let all = text.read_span(&SourceSpan::from((0, 0)), 0, usize::MAX).ok()?;
    Some((all.name()?.to_owned(), String::from_utf8_lossy(all.data()).into_owned()))
}
