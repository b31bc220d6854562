//! The embedded fonts: which face draws a character, and how wide it is.
//!
//! Only these fonts exist for the renderer, so that a picture has the same bytes on every machine. resvg's own fallback
//! uses another face for a *whole* text as soon as one character is missing. So texts are split into runs of one face
//! each, according to the fonts' own tables.

use std::ops::Range;
use std::sync::{Arc, LazyLock, OnceLock};

use resvg::usvg::{self, fontdb};
use skrifa::charmap::Charmap;
use skrifa::instance::{LocationRef, Size};
use skrifa::metrics::GlyphMetrics;
use skrifa::{FontRef, MetadataProvider};

/// One of the two embedded faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Ubuntu Light: all text.
    Sans,
    /// Hack: the arrows and mathematical signs that Ubuntu lacks.
    Mono,
}

impl Face {
    /// The font families to ask for, the embedded one first; the others are for SVGs that are opened elsewhere.
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

    fn tables(self) -> &'static Tables {
        static SANS: LazyLock<Tables> = LazyLock::new(|| Tables::of(Face::Sans));
        static MONO: LazyLock<Tables> = LazyLock::new(|| Tables::of(Face::Mono));
        match self {
            Self::Sans => &SANS,
            Self::Mono => &MONO,
        }
    }
}

/// A character's glyph: its face and its advance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glyph {
    pub(super) face: Face,
    /// Its advance width, in ems.
    pub(super) advance_em: f64,
}

/// Replaces a character that no embedded face has.
pub(super) const REPLACEMENT: char = '□';

/// The characters that are drawn: Latin, Greek, Cyrillic, punctuation, arrows, mathematics, geometric shapes. Each of
/// them is as wide as its glyph. Combining and invisible characters are left out: the faces have glyphs for some of
/// them, but the renderer merges these with their neighbors or drops them, so their advance means nothing.
const DRAWN: [Range<u32>; 9] = [
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

/// The metrics of a face's glyphs.
struct Tables {
    glyph_ids: Charmap<'static>,
    metrics: GlyphMetrics<'static>,
    units_per_em: f64,
}

impl Tables {
    fn of(face: Face) -> Self {
        let font = FontRef::new(face.data()).expect("the embedded fonts are valid");
        // Unscaled advances are whole font units; at a size in pixels, they would be rounded.
        let (size, location) = (Size::unscaled(), LocationRef::default());
        Self {
            glyph_ids: font.charmap(),
            metrics: font.glyph_metrics(size, location),
            units_per_em: f64::from(font.metrics(size, location).units_per_em),
        }
    }

    fn advance_em(&self, character: char) -> Option<f64> {
        let advance = self.metrics.advance_width(self.glyph_ids.map(character)?)?;
        Some(f64::from(advance) / self.units_per_em)
    }
}

/// The options for reading every SVG of this crate: the embedded fonts, no files, no network.
pub(super) fn options() -> usvg::Options<'static> {
    static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
        let mut fonts = fontdb::Database::new();
        for face in [Face::Sans, Face::Mono] {
            fonts.load_font_data(face.data().to_vec());
        }
        Arc::new(fonts)
    });
    usvg::Options { fontdb: FONTS.clone(), font_family: "Ubuntu".to_owned(), ..usvg::Options::default() }
}

/// The glyph of a character, from the proportional face if it has one; `None` if no embedded face has it.
pub(super) fn glyph(character: char) -> Option<Glyph> {
    const COUNT: usize = DRAWN[DRAWN.len() - 1].end as usize;
    static GLYPHS: [OnceLock<Option<Glyph>>; COUNT] = [const { OnceLock::new() }; COUNT];
    *GLYPHS.get(character as usize)?.get_or_init(|| {
        DRAWN.iter().find(|range| range.contains(&u32::from(character)))?;
        let glyph = |face: Face| Some(Glyph { face, advance_em: face.tables().advance_em(character)? });
        glyph(Face::Sans).or_else(|| glyph(Face::Mono))
    })
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
    fn signs_used_in_labels_have_glyphs() {
        for character in "→←≤≥≠θφτ∧∨¬□◇…·⇉°λ↻∞×−–éЖ".chars().chain([REPLACEMENT])
        {
            assert!(glyph(character).is_some(), "no glyph for {character:?}");
        }
        assert_eq!(glyph('漢'), None);
    }
}
