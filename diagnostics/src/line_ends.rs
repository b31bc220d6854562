//! How the lines of a text end.

use std::borrow::Cow;

/// How the lines of a text end, by its first one. What lays a text out keeps that, because a version control system may
/// have chosen it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineEnds {
    /// `\n`
    Lf,
    /// `\r\n`, as on Windows.
    CrLf,
}

impl LineEnds {
    /// Those of a text.
    ///
    /// ```
    /// use diagnostics::LineEnds;
    ///
    /// let text = "\u{feff}one\r\ntwo\n";
    /// assert_eq!(LineEnds::plain(text), "one\ntwo\n");
    /// assert_eq!(LineEnds::of(text).write("one\ntwo\n".to_owned()), "one\r\ntwo\r\n");
    /// ```
    #[must_use]
    pub fn of(text: &str) -> Self {
        match text.find('\n') {
            Some(end) if text[..end].ends_with('\r') => Self::CrLf,
            _ => Self::Lf,
        }
    }

    /// The text with line feeds, and without a byte order mark.
    #[must_use]
    pub fn plain(text: &str) -> Cow<'_, str> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if text.contains("\r\n") { Cow::Owned(text.replace("\r\n", "\n")) } else { Cow::Borrowed(text) }
    }

    /// A text with line feeds, with these ends instead.
    #[must_use]
    pub fn write(self, text: String) -> String {
        match self {
            Self::Lf => text,
            Self::CrLf => text.replace('\n', "\r\n"),
        }
    }
}
