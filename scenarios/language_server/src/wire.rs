//! Findings as the protocol has them.

use std::ops::Range;

use checks::findings::{Finding, InText};
use editor::{TextLines, Unit};
use lsp_types as lsp;
use lsp_types::{DiagnosticRelatedInformation, DiagnosticSeverity, Location, Uri};

pub(crate) fn position(position: editor::Position) -> lsp::Position {
    lsp::Position { line: position.line, character: position.character }
}

pub(crate) fn of_position(position: lsp::Position) -> editor::Position {
    editor::Position { line: position.line, character: position.character }
}

pub(crate) fn range(lines: &TextLines<'_>, bytes: &Range<usize>, unit: Unit) -> lsp::Range {
    let Range { start, end } = lines.positions(bytes, unit);
    lsp::Range { start: position(start), end: position(end) }
}

/// The findings in a file at this address.
pub(crate) fn diagnostics(found: &InText, lines: &TextLines<'_>, address: &Uri, unit: Unit) -> Vec<lsp::Diagnostic> {
    found.findings.iter().map(|finding| diagnostic(finding, lines, address, unit)).collect()
}

pub(crate) fn diagnostic(finding: &Finding, lines: &TextLines<'_>, address: &Uri, unit: Unit) -> lsp::Diagnostic {
    let help = finding.help.as_ref().map(|help| format!("\nhelp: {help}")).unwrap_or_default();
    let label = |(bytes, label): &(Range<usize>, String)| DiagnosticRelatedInformation {
        location: Location { uri: address.clone(), range: range(lines, bytes, unit) },
        message: label.clone(),
    };
    let labels: Vec<_> = finding.labels.iter().map(label).collect();
    lsp::Diagnostic {
        range: range(lines, &finding.range, unit),
        severity: Some(if finding.is_error { DiagnosticSeverity::ERROR } else { DiagnosticSeverity::WARNING }),
        source: Some("steward".to_owned()),
        message: format!("{}{help}", finding.message),
        related_information: (!labels.is_empty()).then_some(labels),
        ..lsp::Diagnostic::default()
    }
}
