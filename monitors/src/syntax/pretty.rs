//! Text that is broken into lines where it does not fit on one: Wadler's "A prettier printer", with comments.

/// A text whose lines are not chosen yet.
#[derive(Clone, Debug)]
pub(super) enum Document {
    Text(String),
    /// A blank at which no line ends.
    Space,
    /// A blank, or a line break if its group does not fit on the line.
    Line,
    /// Nothing, or a line break.
    Break,
    /// A comment, which ends its line. If it is not `behind` something, it begins a line, too.
    Comment {
        text: String,
        is_behind: bool,
    },
    Sequence(Vec<Document>),
    /// Its line breaks are either all taken or none.
    Group(Box<Document>),
    /// Further lines are indented by this much more.
    Nest(usize, Box<Document>),
    /// Further lines begin in the column in which this begins.
    Align(Box<Document>),
}

impl Document {
    /// The group of this. A comment behind the last of it does not prevent it from being on one line.
    pub(super) fn group(mut self) -> Self {
        match self.take_comment_behind() {
            Some(comment) => Self::Sequence(vec![Self::Group(Box::new(self)), comment]),
            None => Self::Group(Box::new(self)),
        }
    }

    pub(super) fn nest(self, columns: usize) -> Self {
        Self::Nest(columns, Box::new(self))
    }

    pub(super) fn align(self) -> Self {
        Self::Align(Box::new(self))
    }

    fn take_comment_behind(&mut self) -> Option<Self> {
        match self {
            Self::Sequence(parts) => match parts.last_mut()? {
                Self::Comment { is_behind: true, .. } => parts.pop(),
                last => last.take_comment_behind(),
            },
            Self::Group(inner) | Self::Nest(_, inner) | Self::Align(inner) => inner.take_comment_behind(),
            Self::Text(_) | Self::Space | Self::Line | Self::Break | Self::Comment { .. } => None,
        }
    }

    /// Appends it to a text that ends with a line break, in lines of at most `width` characters where it can be broken.
    pub(super) fn write(&self, width: usize, out: &mut String) {
        Writer { width, column: 0, is_ended: false, out }.write(self);
    }
}

/// A part that is not written yet: its indentation, and whether its line breaks are taken.
type Pending<'d> = (usize, bool, &'d Document);

struct Writer<'o> {
    width: usize,
    /// The characters that are already on the line.
    column: usize,
    /// Whether a comment has ended the line.
    is_ended: bool,
    out: &'o mut String,
}

impl Writer<'_> {
    fn write(&mut self, document: &Document) {
        let mut parts: Vec<Pending<'_>> = vec![(0, true, document)];
        while let Some((indent, is_broken, part)) = parts.pop() {
            match part {
                Document::Text(text) => {
                    if self.is_ended {
                        self.line(indent);
                    }
                    self.push(text);
                }
                Document::Line | Document::Break if is_broken => self.line(indent),
                Document::Space | Document::Line if !self.is_ended => self.push(" "),
                Document::Space | Document::Line | Document::Break => {}
                Document::Comment { text, is_behind } => {
                    let line = &self.out[self.out.rfind('\n').map_or(0, |end| end + 1)..];
                    if self.is_ended || !is_behind && !line.trim().is_empty() {
                        self.line(indent);
                    } else if *is_behind {
                        self.push(" ");
                    }
                    self.push(text);
                    self.is_ended = true;
                }
                Document::Sequence(inner) => parts.extend(inner.iter().rev().map(|part| (indent, is_broken, part))),
                Document::Group(inner) => parts.push((indent, is_broken && !self.fits(inner, &parts), inner)),
                Document::Nest(columns, inner) => parts.push((indent + columns, is_broken, inner)),
                Document::Align(inner) => {
                    parts.push((if self.is_ended { indent } else { self.column }, is_broken, inner));
                }
            }
        }
    }

    fn push(&mut self, text: &str) {
        self.out.push_str(text);
        self.column += text.chars().count();
    }

    fn line(&mut self, indent: usize) {
        self.out.truncate(self.out.trim_end_matches(' ').len());
        self.out.push('\n');
        self.out.extend(std::iter::repeat_n(' ', indent));
        self.column = indent;
        self.is_ended = false;
    }

    /// Whether a part and what follows it, up to the next line break, fit on the line.
    fn fits(&self, part: &Document, rest: &[Pending<'_>]) -> bool {
        let mut left = self.width.saturating_sub(self.column);
        let (mut parts, mut rest) = (vec![(false, part)], rest.iter().rev());
        while let Some((is_broken, part)) =
            parts.pop().or_else(|| rest.next().map(|(_, is_broken, part)| (*is_broken, *part)))
        {
            let used = match part {
                Document::Line | Document::Break if is_broken => return true,
                // A comment ends the line: that of the part is too early.
                Document::Comment { .. } => return is_broken,
                Document::Text(text) => text.chars().count(),
                Document::Space | Document::Line => 1,
                Document::Break => 0,
                Document::Sequence(inner) => {
                    parts.extend(inner.iter().rev().map(|part| (is_broken, part)));
                    0
                }
                Document::Group(inner) | Document::Nest(_, inner) | Document::Align(inner) => {
                    parts.push((is_broken, inner));
                    0
                }
            };
            match left.checked_sub(used) {
                Some(now) => left = now,
                None => return false,
            }
        }
        true
    }
}
