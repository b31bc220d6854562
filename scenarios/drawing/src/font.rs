//! The embedded fonts, and which of their faces has which character how wide.
//!
//! Only these fonts exist for the renderer, so that a picture has the same bytes on every machine. resvg's own fallback
//! takes another face for a *whole* text as soon as one character is missing; so texts are split into runs of one face
//! each, by what is known here.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use resvg::usvg::{self, fontdb};

/// One of the two embedded faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Ubuntu Light: all text.
    Sans,
    /// Hack: the arrows and mathematical signs that Ubuntu lacks.
    Mono,
}

impl Face {
    /// The font families to ask for, the embedded one first; the others serve whoever opens an SVG elsewhere.
    pub(super) fn families(self) -> &'static str {
        match self {
            Self::Sans => "Ubuntu, 'DejaVu Sans', sans-serif",
            Self::Mono => "Hack, 'DejaVu Sans Mono', monospace",
        }
    }

    fn data(self) -> &'static [u8] {
        match self {
            Self::Sans => epaint_default_fonts::UBUNTU_LIGHT,
            Self::Mono => epaint_default_fonts::HACK_REGULAR,
        }
    }
}

/// Which face draws a character, and how far it moves the pen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glyph {
    /// The face that has it.
    pub(super) face: Face,
    /// Its advance width, in ems.
    pub(super) advance_em: f64,
}

/// Stands for a character that no embedded face has.
pub(super) const REPLACEMENT: char = '□';

/// The characters worth knowing: Latin, Greek, Cyrillic, punctuation, arrows, mathematics, geometric shapes.
/// Combining and invisible characters are left out; they have no width of their own.
const KNOWN: [Range<u32>; 9] = [
    0x20..0x7f,
    0xa1..0xad,
    0xae..0x300,
    0x370..0x483,
    0x48a..0x530,
    0x1e00..0x1f00,
    0x2010..0x2028,
    0x2030..0x2060,
    0x2070..0x2c00,
];

/// Options under which every SVG of this module is read: the embedded fonts, no files, no network.
pub(super) fn options() -> usvg::Options<'static> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    options_with(FONTS.get_or_init(|| database(&[Face::Sans, Face::Mono])).clone())
}

/// The glyph of a character, or `None` if no embedded face has it.
pub(super) fn glyph(character: char) -> Option<Glyph> {
    static GLYPHS: OnceLock<BTreeMap<char, Glyph>> = OnceLock::new();
    GLYPHS.get_or_init(measure).get(&character).copied()
}

fn database(faces: &[Face]) -> Arc<fontdb::Database> {
    let mut fonts = fontdb::Database::new();
    for face in faces {
        fonts.load_font_data(face.data().to_vec());
    }
    Arc::new(fonts)
}

fn options_with(fontdb: Arc<fontdb::Database>) -> usvg::Options<'static> {
    usvg::Options { fontdb, font_family: "Ubuntu".to_owned(), ..usvg::Options::default() }
}

/// The glyphs of all known characters, the proportional face preferred.
fn measure() -> BTreeMap<char, Glyph> {
    let known: Vec<char> = KNOWN.into_iter().flatten().filter_map(char::from_u32).collect();
    let mut glyphs = BTreeMap::new();
    for face in [Face::Mono, Face::Sans] {
        let options = options_with(database(&[face]));
        for line in known.chunks(256) {
            glyphs.extend(measure_line(line, face, &options));
        }
    }
    glyphs
}

/// Lays the characters out as one line of text: where a glyph ends, the next one begins.
fn measure_line(line: &[char], face: Face, options: &usvg::Options<'_>) -> Vec<(char, Glyph)> {
    const EM: f64 = 1000.0;
    let spaced: String = line.iter().flat_map(|&character| [character, 'x']).collect();
    let svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"><text font-family="{}" font-size="{EM}" style="font-kerning:none">x{}</text></svg>"#,
        face.families(),
        super::xml::escape(&spaced),
    );
    let tree = usvg::Tree::from_str(&svg, options).expect("a line of text is a valid picture");
    let Some(usvg::Node::Text(text)) = tree.root().children().first() else { return Vec::new() };
    let placed: Vec<(&str, u32, f64)> = text
        .layouted()
        .iter()
        .flat_map(|span| &span.positioned_glyphs)
        .map(|glyph| (glyph.text.as_str(), glyph.id.0, f64::from(glyph.transform().tx)))
        .collect();
    placed
        .windows(2)
        .filter(|pair| pair[0].1 != 0)
        .filter_map(|pair| Some((single(pair[0].0)?, Glyph { face, advance_em: (pair[1].2 - pair[0].2) / EM })))
        .collect()
}

fn single(text: &str) -> Option<char> {
    let mut characters = text.chars();
    characters.next().filter(|_| characters.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_ascii_character_has_a_proportional_glyph() {
        for character in ' '..='~' {
            let glyph = glyph(character).unwrap_or_else(|| panic!("no glyph for {character:?}"));
            assert_eq!(glyph.face, Face::Sans, "{character:?}");
            assert!((0.1..1.1).contains(&glyph.advance_em), "{character:?} is {} em wide", glyph.advance_em);
        }
    }

    #[test]
    fn signs_that_labels_use_have_glyphs() {
        for character in "→←≤≥≠θφτ∧∨¬□◇…·⇉°λ↻∞×−–éЖ".chars().chain([REPLACEMENT])
        {
            assert!(glyph(character).is_some(), "no glyph for {character:?}");
        }
        assert_eq!(glyph('漢'), None);
    }
}
