//! The parts of a diagnostic.

use miette::{Diagnostic, SourceCode};

/// A part of a diagnostic, with the text to which it refers.
pub type Part<'d> = (&'d dyn Diagnostic, Option<&'d dyn SourceCode>);

/// All parts of a diagnostic, each with the text to which it refers: its own, or otherwise the diagnostic's.
#[must_use]
pub fn parts(diagnostic: &dyn Diagnostic) -> Vec<Part<'_>> {
    parts_within(diagnostic, None)
}

fn parts_within<'d>(diagnostic: &'d dyn Diagnostic, outer: Option<&'d dyn SourceCode>) -> Vec<Part<'d>> {
    let text = diagnostic.source_code().or(outer);
    let related = diagnostic.related().into_iter().flatten();
    let related: Vec<_> = related.flat_map(|related| parts_within(related, text)).collect();
    if related.is_empty() { vec![(diagnostic, text)] } else { related }
}
