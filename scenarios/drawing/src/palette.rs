//! The palette of all pixel pictures.

use super::theme::{self, Color};

/// GIF has 256 colors per frame, and one of them means "unchanged".
const MAX_COLORS: usize = 255;

/// The number of steps between two colors where one has a soft edge on the other.
const STEPS: u16 = 5;

/// Which colors are drawn on which: soft edges need the colors between them.
const EDGES: [(&[Color], &[Color]); 4] = [
    (
        &[theme::PAPER],
        &[
            theme::INK,
            theme::MUTED,
            theme::WALL,
            theme::GOOD,
            theme::BAD,
            theme::BUSY,
            theme::BUSY_DARK,
            theme::LASER,
            theme::BELIEF,
            theme::BODY,
            theme::IDLE,
        ],
    ),
    (&[theme::UNKNOWN], &[theme::INK, theme::GOOD, theme::BAD, theme::LASER]),
    (&[theme::GOOD_LIGHT, theme::BAD_LIGHT, theme::BUSY_LIGHT], &[theme::INK]),
    (&[theme::IDLE_LIGHT], &[theme::MUTED]),
];

/// At most [`MAX_COLORS`] fixed colors, the same for all pictures, and the closest of them to any other color.
#[derive(Clone, Debug)]
pub(super) struct Palette {
    /// The closest color, by 5 bits of red, 6 of green and 5 of blue.
    closest: Vec<[u8; 3]>,
}

impl Palette {
    pub(super) fn new() -> Self {
        let colors = colors();
        assert!(colors.len() <= MAX_COLORS, "{} colors are too many for a palette", colors.len());
        let closest = (0..=u16::MAX).map(|packed| closest(&colors, unpack(packed))).collect();
        Self { closest }
    }

    /// The closest color.
    pub(super) fn closest(&self, [red, green, blue]: [u8; 3]) -> [u8; 3] {
        // Comparing half a million pixels with 255 colors would take longer than drawing them. So the answers are
        // computed once, for 16 of the 24 bits; the other eight are noise at soft edges.
        let packed = u16::from(red >> 3) << 11 | u16::from(green >> 2) << 5 | u16::from(blue >> 3);
        self.closest[usize::from(packed)]
    }
}

fn colors() -> Vec<[u8; 3]> {
    let mut colors: Vec<[u8; 3]> = theme::ALL.map(theme::rgb).to_vec();
    for (grounds, fronts) in EDGES {
        for ground in grounds {
            colors.extend(fronts.iter().flat_map(|front| between(theme::rgb(ground), theme::rgb(front))));
        }
    }
    colors.dedup();
    colors
}

fn between(ground: [u8; 3], front: [u8; 3]) -> impl Iterator<Item = [u8; 3]> {
    (1..STEPS).map(move |step| {
        std::array::from_fn(|i| {
            let (ground, front) = (u16::from(ground[i]), u16::from(front[i]));
            ((ground * (STEPS - step) + front * step) / STEPS) as u8
        })
    })
}

/// The middle of all colors with this 16-bit number.
fn unpack(packed: u16) -> [u8; 3] {
    let scaled = |bits: u16, most: u16| (bits * 255 / most) as u8;
    [scaled(packed >> 11, 31), scaled(packed >> 5 & 63, 63), scaled(packed & 31, 31)]
}

/// The color that looks closest: the eye is most sensitive to green and least to blue.
fn closest(colors: &[[u8; 3]], wanted: [u8; 3]) -> [u8; 3] {
    let distance = |color: &[u8; 3]| -> u32 {
        let part = |i: usize, weight: u32| weight * u32::from(color[i].abs_diff(wanted[i])).pow(2);
        part(0, 3) + part(1, 6) + part(2, 1)
    };
    colors.iter().copied().min_by_key(distance).expect("there are colors")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colors_of_the_theme_are_kept() {
        let palette = Palette::new();
        for color in theme::ALL {
            let wanted = theme::rgb(color);
            let got = palette.closest(wanted);
            let off = (0..3).map(|i| wanted[i].abs_diff(got[i])).max();
            assert!(off <= Some(4), "{color} became {got:?}");
        }
        assert_eq!(palette.closest([255; 3]), [255; 3]);
    }
}
