//! Errors and warnings as findings in files, for the results of commands.

use std::path::Path;

use diagnostics::{PartsOfText, Span, parts_by_text};
use miette::{Diagnostic, Severity};
use reports::file_place::{FilePlace, FileText};
use reports::results::{FileFinding, FindingKind, Suite};
use scenarios::scenario::find;

use crate::Error;

/// What could not be carried out because of an error. `path` finds the files that its places name.
#[must_use]
pub fn refused(subject: &str, error: &Error, path: impl Fn(&str) -> Option<String>) -> Suite {
    let findings: Vec<FileFinding> = findings_of(error).into_iter().map(|finding| finding.with_path(&path)).collect();
    let reasons: Vec<String> = findings.iter().map(FileFinding::one_line).collect();
    Suite { findings, ..Suite::of_error(subject, reasons.join("; ")) }
}

/// Everything that an error reports.
#[must_use]
pub fn findings_of(error: &Error) -> Vec<FileFinding> {
    match error.diagnostics() {
        none if none.is_empty() => {
            vec![FileFinding { kind: FindingKind::Error, message: error.to_string(), help: None, place: None }]
        }
        diagnostics => diagnostics.into_iter().flat_map(findings).collect(),
    }
}

/// The place of a span; none if its text is an assignment on the command line.
#[must_use]
pub fn place(span: &Span) -> Option<FilePlace> {
    let (name, text) = (span.source().name(), span.source().text());
    FilePlace::of(span).map(|place| if is_made(name, text) { FilePlace::whole(name) } else { place })
}

/// Whether a text was generated, although it has the name of a file: it is that of the scenario of a RoAML model.
fn is_made(name: &str, text: &str) -> bool {
    let file = Path::new(name);
    diagnostics::text_from_disk(file).is_ok_and(|written| written != text && find::is_model(file, &written))
}

/// The parts of a diagnostic with their places; an assignment on the command line, or a text without a name, is none.
#[must_use]
pub fn findings(diagnostic: &dyn Diagnostic) -> Vec<FileFinding> {
    let mut found = Vec::new();
    for PartsOfText { text, parts } in parts_by_text(diagnostic) {
        let text = text.as_ref().filter(|(name, _)| name != diagnostics::ASSIGNMENT);
        let is_made = text.is_some_and(|(name, text)| is_made(name, text));
        let text = text.map(|(name, text)| FileText::new(name.clone(), text));
        found.extend(parts.into_iter().map(|part| {
            let label = part.labels().and_then(|mut labels| labels.next());
            let in_text = |text: &FileText<'_>| match &label {
                Some(label) if !is_made => text.place(label.offset()..label.offset() + label.len()),
                _ => text.whole(),
            };
            let kind = match part.severity() {
                None | Some(Severity::Error) => FindingKind::Error,
                Some(Severity::Warning | Severity::Advice) => FindingKind::Warning,
            };
            let help = part.help().map(|help| help.to_string()).filter(|help| !help.is_empty());
            FileFinding { kind, message: part.to_string(), help, place: text.as_ref().map(in_text) }
        }));
    }
    found
}
