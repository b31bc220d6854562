//! The parts of a diagnostic.

use std::borrow::Cow;

use miette::{Diagnostic, SourceCode, SourceSpan};

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

/// Parts of a diagnostic that refer to one text, one after the other.
#[derive(Debug)]
pub struct PartsOfText<'d> {
    /// The name of the text, and the text; none if it has no name.
    pub text: Option<(String, Cow<'d, str>)>,
    /// The parts.
    pub parts: Vec<&'d dyn Diagnostic>,
}

/// All parts of a diagnostic with their texts. Each may have its own handle of a text, which is read only once.
#[must_use]
pub fn parts_by_text(diagnostic: &dyn Diagnostic) -> Vec<PartsOfText<'_>> {
    let mut found: Vec<(Option<*const u8>, PartsOfText<'_>)> = Vec::new();
    for (part, source) in parts(diagnostic) {
        let address =
            source.and_then(|source| Some(source.read_span(&SourceSpan::from((0, 0)), 0, 0).ok()?.data().as_ptr()));
        match found.last_mut() {
            Some((last, group)) if *last == address => group.parts.push(part),
            _ => found.push((address, PartsOfText { text: source.and_then(whole), parts: vec![part] })),
        }
    }
    found.into_iter().map(|(_, group)| group).collect()
}

/// The name of a text, and the text.
fn whole(source: &dyn SourceCode) -> Option<(String, Cow<'_, str>)> {
    let all = source.read_span(&SourceSpan::from((0, 0)), 0, usize::MAX).ok()?;
    Some((all.name()?.to_owned(), String::from_utf8_lossy(all.data())))
}
