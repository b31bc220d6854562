//! Dates that would become data, which cannot keep them.

use std::ops::Range;

use super::scan::{Piece, declarations, pieces, words};
use super::{ExpressionProblem, Form};

/// Where code makes a `Date` the value of data, by itself or within arrays and objects, as far as the text alone shows:
/// what functions return is not followed. A date that is only asked for something, as in `new Date().getTime()`, is not
/// one of them.
pub(crate) fn kept_dates(source: &str, form: Form) -> Vec<ExpressionProblem> {
    if !words(source).any(|word| word == "Date") {
        return Vec::new();
    }
    let values = match form {
        Form::Expression => vec![0],
        Form::Script => declarations(source).values,
        Form::Location => Vec::new(),
    };
    let pieces = pieces(source).into_iter().filter(|(piece, _)| *piece != Piece::LineEnd).collect();
    let search = DateSearch { source, pieces };
    let begins = |value: usize| search.pieces.partition_point(|(_, span)| span.start < value);
    let dates = values.into_iter().filter_map(|value| search.date_at(begins(value)));
    let problem = |span: Range<usize>| {
        ExpressionProblem::new("a `Date` cannot be kept in data", span, "an error whenever this is evaluated")
            .with_help("keep its number, `getTime()` or `Date.now()`, or its text, `toISOString()`")
    };
    dates.map(problem).collect()
}

/// Code that is searched for dates.
struct DateSearch<'s> {
    source: &'s str,
    pieces: Vec<(Piece, Range<usize>)>,
}

impl DateSearch<'_> {
    /// The first date in the value that begins with this piece, if the value is a date, or an array or object that
    /// contains one.
    fn date_at(&self, index: usize) -> Option<Range<usize>> {
        if let Some(b'[' | b'{') = self.mark(index) {
            let end = self.closing(index)?;
            let members = if self.is_end(end + 1) { self.members(index, end) } else { Vec::new() };
            return members.into_iter().find_map(|member| self.date_at(member));
        }
        if (self.word(index), self.word(index + 1)) != ("new", "Date") {
            return None;
        }
        let end = if self.mark(index + 2) == Some(b'(') { self.closing(index + 2)? } else { index + 1 };
        self.is_end(end + 1).then(|| self.pieces[index].1.start..self.pieces[end].1.end)
    }

    /// Whether a value before this piece is complete. Before a word that is no operator, a line has ended.
    fn is_end(&self, index: usize) -> bool {
        match self.pieces.get(index) {
            Some((Piece::Mark(mark), _)) => matches!(mark, b';' | b',' | b')' | b']' | b'}'),
            Some((Piece::Word, _)) => !["in", "instanceof"].contains(&self.word(index)),
            Some(_) => false,
            None => true,
        }
    }

    /// The piece that closes this bracket.
    fn closing(&self, open: usize) -> Option<usize> {
        let mut depth = 0_usize;
        (open..self.pieces.len()).find(|index| {
            match self.mark(*index) {
                Some(b'(' | b'[' | b'{') => depth += 1,
                Some(b')' | b']' | b'}') => depth -= 1,
                _ => {}
            }
            depth == 0
        })
    }

    /// The pieces with which the members of an array or object begin; of an object, also their names.
    fn members(&self, open: usize, end: usize) -> Vec<usize> {
        let (mut depth, mut members) = (0_usize, vec![open + 1]);
        for index in open..end {
            match self.mark(index) {
                Some(b'(' | b'[' | b'{') => depth += 1,
                Some(b')' | b']' | b'}') => depth -= 1,
                Some(b',' | b':') if depth == 1 => members.push(index + 1),
                _ => {}
            }
        }
        members
    }

    fn mark(&self, index: usize) -> Option<u8> {
        match self.pieces.get(index) {
            Some((Piece::Mark(mark), _)) => Some(*mark),
            _ => None,
        }
    }

    /// The word there, or an empty string.
    fn word(&self, index: usize) -> &str {
        match self.pieces.get(index) {
            Some((Piece::Word, span)) => &self.source[span.clone()],
            _ => "",
        }
    }
}
