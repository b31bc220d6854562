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
    let mut search = DateSearch { source, pieces, at: 0 };
    let mut dates = Vec::new();
    for value in values {
        let begin = search.pieces.partition_point(|(_, span)| span.start < value);
        // What lies within a value has been read with it.
        if begin >= search.at {
            search.at = begin;
            dates.extend(search.date());
        }
    }
    let when = match form {
        Form::Script => "an error if it is still there when the script ends",
        _ => "an error whenever this is evaluated",
    };
    let problem = |span: Range<usize>| {
        ExpressionProblem::new("a `Date` cannot be kept in data", span, when)
            .with_help("keep its number, `getTime()` or `Date.now()`, or its text, `toISOString()`")
    };
    dates.into_iter().map(problem).collect()
}

/// Code that is searched for dates, from the piece `at` on.
struct DateSearch<'s> {
    source: &'s str,
    pieces: Vec<(Piece, Range<usize>)>,
    at: usize,
}

impl DateSearch<'_> {
    /// The first date in the value that begins here, if the value is a date, or an array or object that contains one.
    fn date(&mut self) -> Option<Range<usize>> {
        // The first date in each array and object that is open.
        let mut open: Vec<Option<Range<usize>>> = Vec::new();
        let mut begins = true;
        while self.at < self.pieces.len() {
            let mark = self.mark(self.at);
            let mut found = None;
            match mark {
                Some(b'[' | b'{') if begins => {
                    open.push(None);
                    self.at += 1;
                    continue;
                }
                Some(b'(' | b'[' | b'{') => self.pass_brackets(),
                Some(b']' | b'}') => {
                    found = open.pop()?;
                    self.at += 1;
                }
                _ if begins && (self.word(self.at), self.word(self.at + 1)) == ("new", "Date") => {
                    let start = self.pieces[self.at].1.start;
                    self.at += 2;
                    if self.mark(self.at) == Some(b'(') {
                        self.pass_brackets();
                    }
                    found = Some(start..self.pieces[self.at - 1].1.end);
                }
                _ => self.at += 1,
            }
            begins = matches!(mark, Some(b',' | b':'));
            match (found.filter(|_| self.is_end()), open.last_mut()) {
                (Some(date), Some(first)) => _ = first.get_or_insert(date),
                (date, None) => return date,
                (None, Some(_)) => {}
            }
        }
        None
    }

    /// Whether a value before this piece is complete. Before a word that is no operator, a line has ended.
    fn is_end(&self) -> bool {
        match self.pieces.get(self.at) {
            Some((Piece::Mark(mark), _)) => matches!(mark, b';' | b',' | b')' | b']' | b'}'),
            Some((Piece::Word, _)) => !["in", "instanceof"].contains(&self.word(self.at)),
            Some(_) => false,
            None => true,
        }
    }

    /// Goes on behind what closes the bracket that opens here.
    fn pass_brackets(&mut self) {
        let mut depth = 0_usize;
        while self.at < self.pieces.len() {
            match self.mark(self.at) {
                Some(b'(' | b'[' | b'{') => depth += 1,
                Some(b')' | b']' | b'}') => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return;
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_is_found_however_deep_it_lies() {
        let nested = |depth: usize, end: &str| {
            let source = format!("x = {}new Date(){}{end}", "[".repeat(depth), "]".repeat(depth));
            kept_dates(&source, Form::Script).len()
        };
        assert_eq!((nested(200_000, ""), nested(200_000, ".length"), nested(0, "")), (1, 0, 1));
        for open in ["x = [", "x = { a: [", "x = ([{"] {
            assert_eq!(kept_dates(&format!("{open} Date"), Form::Script).len(), 0, "{open}");
            assert!(kept_dates(&open.repeat(500), Form::Script).len() <= 1, "{open}");
        }
    }
}
