//! Measures text, shortens it and breaks it into lines, by the advance widths of the fonts that draw it.

use super::font::{Face, REPLACEMENT, glyph};

/// How heavy a text is. Only a light face is embedded, so weight is a stroke around the letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Running text.
    Regular,
    /// Headings, names, current values.
    Bold,
}

impl Weight {
    /// Width of the stroke around the letters, in ems.
    pub fn stroke_em(self) -> f64 {
        match self {
            Self::Regular => 0.02,
            Self::Bold => 0.065,
        }
    }

    /// Room added between the letters to make up for the stroke, in ems.
    pub fn spacing_em(self) -> f64 {
        match self {
            Self::Regular => 0.0,
            Self::Bold => 0.022,
        }
    }
}

/// The size and weight of a text, which determine its width.
///
/// ```
/// use drawing::text::Font;
///
/// let font = Font::regular(14.0);
/// assert_eq!(font.fit("GotoRechargingStation", 80.0), "GotoRech…");
/// assert_eq!(font.wrap("drive to the charging station", 90.0, 2), ["drive to the", "charging st…"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Font {
    /// Font size, in pixels.
    pub size: f64,
    /// Weight.
    pub weight: Weight,
}

impl Font {
    /// Running text of this size, in pixels.
    pub const fn regular(size: f64) -> Self {
        Self { size, weight: Weight::Regular }
    }

    /// A heading of this size, in pixels.
    pub const fn bold(size: f64) -> Self {
        Self { size, weight: Weight::Bold }
    }

    /// The same weight at `factor` times the size.
    pub fn scaled(self, factor: f64) -> Self {
        Self { size: self.size * factor, ..self }
    }

    /// Distance between two lines, in pixels.
    pub fn line_height(self) -> f64 {
        self.size * 1.2
    }

    /// How far below the middle of a line its baseline lies, in pixels (half the height of capitals).
    pub fn baseline_below_middle(self) -> f64 {
        self.size * 0.345
    }

    /// Width of a text, in pixels. Kerning is ignored: it only makes a text slightly narrower.
    pub fn width(self, text: &str) -> f64 {
        let runs: f64 = runs(text).iter().map(|run| self.run_width(run)).sum();
        runs + self.weight.stroke_em() * self.size
    }

    /// The advance of a run, in pixels.
    pub fn run_width(self, run: &Run) -> f64 {
        let letters = run.text.chars().count() as f64;
        (run.advance_em + self.weight.spacing_em() * letters) * self.size
    }

    /// The text, or as much of its beginning as fits into `room` pixels with an ellipsis; empty if not even the
    /// ellipsis fits.
    pub fn fit(self, text: &str, room: f64) -> String {
        if self.width(text) <= room {
            return text.to_owned();
        }
        let ends: Vec<usize> = text.trim_end().char_indices().map(|(end, _)| end).collect();
        let shortened = |end: usize| format!("{}…", text[..end].trim_end());
        // A longer beginning is never narrower.
        let fitting = ends.partition_point(|end| self.width(&shortened(*end)) <= room);
        fitting.checked_sub(1).map_or(String::new(), |longest| shortened(ends[longest]))
    }

    /// The text, or its beginning and its end with an ellipsis between them, as much as fits into `room` pixels: names
    /// that begin alike stay different. Empty if not even the ellipsis fits.
    pub fn fit_ends(self, text: &str, room: f64) -> String {
        if self.width(text) <= room {
            return text.to_owned();
        }
        let letters: Vec<char> = text.trim().chars().collect();
        let shortened = |kept: usize| {
            let (first, last) = letters.split_at(kept.div_ceil(2));
            let first: String = first.iter().collect();
            let last: String = last[last.len() - kept / 2..].iter().collect();
            format!("{}…{}", first.trim_end(), last.trim_start())
        };
        // One letter more is never narrower.
        let lengths: Vec<usize> = (0..letters.len()).collect();
        let fitting = lengths.partition_point(|&kept| self.width(&shortened(kept)) <= room);
        fitting.checked_sub(1).map_or(String::new(), shortened)
    }

    /// The text in two lines of at most `room` pixels, the longer one as short as possible; broken between words, also
    /// those of a `camelCase` or `snake_case` name, or where these are too long, anywhere. None if it does not fit.
    ///
    /// ```
    /// use drawing::text::Font;
    ///
    /// let font = Font::regular(14.0);
    /// let [first, second] = font.halved("NavigateToTheChargingStation", 130.0).unwrap();
    /// assert_eq!((first.as_str(), second.as_str()), ("NavigateToThe", "ChargingStation"));
    /// assert_eq!(font.halved("NavigateToTheChargingStation", 60.0), None);
    /// ```
    pub fn halved(self, text: &str, room: f64) -> Option<[String; 2]> {
        let text = text.trim();
        // A line may lose the space at its end, but no more.
        if self.width(text) > 2.0 * room + self.width(" ") {
            return None;
        }
        let letters: Vec<(usize, char)> = text.char_indices().collect();
        let is_word_end =
            |before: char, after: char| !before.is_alphanumeric() || after.is_uppercase() && !before.is_uppercase();
        let longest = |lines: &[String; 2]| lines.iter().map(|line| self.width(line)).fold(0.0, f64::max);
        let best = |is_allowed: &dyn Fn(char, char) -> bool| {
            let ends = letters.windows(2).filter(|pair| is_allowed(pair[0].1, pair[1].1)).map(|pair| pair[1].0);
            let lines = ends.map(|end| [text[..end].trim_end().to_owned(), text[end..].trim_start().to_owned()]);
            let shortest = lines.min_by(|a, b| longest(a).total_cmp(&longest(b)));
            shortest.filter(|lines| longest(lines) <= room)
        };
        best(&is_word_end).or_else(|| best(&|_, _| true))
    }

    /// The text in at most `lines` lines of at most `room` pixels, broken between words; what does not fit ends in an
    /// ellipsis.
    pub fn wrap(self, text: &str, room: f64, lines: usize) -> Vec<String> {
        let mut wrapped: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            let full = wrapped.len() == lines;
            match wrapped.last_mut() {
                Some(line) if full || self.width(&format!("{line} {word}")) <= room => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => wrapped.push(word.to_owned()),
            }
        }
        wrapped.iter().map(|line| self.fit(line, room)).filter(|line| !line.is_empty()).collect()
    }

    /// The items in lines of at most `room` pixels, with a separator between the items of a line. No item is broken.
    pub(super) fn wrap_items(self, items: &[String], between: &str, room: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for item in items {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line}{between}{item}")) <= room => {
                    *line += &(between.to_owned() + item)
                }
                _ => lines.push(item.clone()),
            }
        }
        lines.iter().map(|line| self.fit(line, room)).collect()
    }
}

/// A stretch of text in one face.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The face that has all of its characters.
    pub face: Face,
    /// The characters. Those that no face has are replaced; control characters are dropped.
    pub text: String,
    /// The advance of the run, in ems.
    pub advance_em: f64,
}

/// Splits a text into runs of one face each.
pub fn runs(text: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for character in text.chars().filter_map(printable) {
        let Some(glyph) = glyph(character) else { continue };
        match runs.last_mut() {
            Some(run) if run.face == glyph.face => {
                run.text.push(character);
                run.advance_em += glyph.advance_em;
            }
            _ => runs.push(Run { face: glyph.face, text: character.to_string(), advance_em: glyph.advance_em }),
        }
    }
    runs
}

fn printable(character: char) -> Option<char> {
    match character {
        _ if character.is_whitespace() => Some(' '),
        _ if character.is_control() => None,
        _ if glyph(character).is_some() => Some(character),
        _ => Some(REPLACEMENT),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FONT: Font = Font::regular(14.0);

    #[test]
    fn a_shortened_text_fits_and_keeps_its_beginning() {
        let name = "GotoRechargingStation";
        for room in [5.0, 20.0, 60.0, 100.0, 1000.0] {
            let fitted = FONT.fit(name, room);
            assert!(fitted.is_empty() || FONT.width(&fitted) <= room, "{fitted:?} in {room}");
            assert!(name.starts_with(fitted.trim_end_matches('…')));
        }
        assert_eq!(FONT.fit(name, 1000.0), name);
        assert!(FONT.fit(name, 60.0).ends_with('…'));
        assert_eq!(FONT.fit(name, 2.0), "");
    }

    /// If every beginning of the text were tried, this would take days.
    #[test]
    fn a_text_of_any_length_is_shortened() {
        let endless = "word ".repeat(400_000);
        let fitted = FONT.fit(&endless, 100.0);
        assert!(fitted.starts_with("word word") && fitted.ends_with('…') && FONT.width(&fitted) <= 100.0);
        let wrapped = FONT.wrap(&endless, 100.0, 3);
        assert_eq!((wrapped.len(), &wrapped[0]), (3, &wrapped[1]));
        assert_eq!(FONT.fit(&"n".repeat(2_000_000), 1.0), "");
    }

    #[test]
    fn wrapped_lines_fit_and_there_are_no_more_than_requested() {
        let lines = FONT.wrap("start for the charging station at once, or else", 90.0, 3);
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| FONT.width(line) <= 90.0), "{lines:?}");
        assert_eq!(lines[0], "start for the");
        assert!(lines[2].ends_with('…'));
        assert_eq!(FONT.wrap("  ", 90.0, 3), Vec::<String>::new());
    }

    #[test]
    fn a_character_of_the_other_face_is_a_separate_run() {
        let texts: Vec<_> = runs("fi → x\u{7}漢").into_iter().map(|run| run.text).collect();
        assert_eq!(texts, ["fi ", "→", " x", "□"]);
    }

    #[test]
    fn bold_text_is_wider() {
        assert!(Font::bold(14.0).width("phi1") > FONT.width("phi1"));
    }
}
