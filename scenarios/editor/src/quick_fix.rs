//! Names that were misspelled, replaced by those that were meant.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use diagnostics::nearest;

use crate::answers::EditedFile;
use crate::findings::Finding;
use crate::project::{Documents, FileContext, Project};

/// A replacement after which a finding is gone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuickFix {
    /// The range to replace, in bytes.
    pub range: Range<usize>,
    /// The text instead.
    pub text: String,
}

/// The replacement of a misspelled name by the nearest of those that may be there, if a check confirms it: the finding
/// is gone, and nothing else is found instead.
#[must_use]
pub fn quick_fix(documents: &Documents, context: &FileContext, file: &Path, finding: &Finding) -> Option<QuickFix> {
    let text = documents.open.get(file)?;
    let range = word_in(text, &finding.range)?;
    let disk = documents.disk();
    let subject = EditedFile { disk: &disk, file, scenarios: &context.scenarios };
    let proposals = subject.proposals(text, range.end);
    let written = &text[range.clone()];
    let meant =
        nearest(written, proposals.iter().map(|proposal| proposal.name.as_str()).filter(|name| *name != written))?;
    let fix = QuickFix { range, text: meant.to_owned() };
    let mut fixed = documents.clone();
    let mut changed = text.to_string();
    changed.replace_range(fix.range.clone(), &fix.text);
    fixed.open.insert(file.to_owned(), Arc::from(changed));
    let [before, after] = [documents, &fixed].map(|documents| Project::default().check(documents).findings);
    let count = |findings: &crate::findings::Findings| -> usize {
        findings.values().map(|found| found.findings.iter().filter(|finding| finding.is_error).count()).sum()
    };
    let is_gone =
        after.get(file).is_none_or(|found| found.findings.iter().all(|other| other.message != finding.message));
    (is_gone && count(&after) < count(&before)).then_some(fix)
}

/// The word to which a finding points: its text without quotes and brackets.
fn word_in(text: &str, range: &Range<usize>) -> Option<Range<usize>> {
    let inside = text.get(range.clone())?;
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    let start = inside.find(is_word)?;
    let rest = &inside[start..];
    let length = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
    // With more than one word, it is not certain which is meant.
    let is_only = !rest[length..].contains(is_word);
    is_only.then_some(range.start + start..range.start + start + length)
}
