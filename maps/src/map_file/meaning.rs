//! The meaning of the pixels in a map's image.

use crate::Cell;

/// Why a pixel means another cell since Nav2's map reader was rewritten (pull request 5071, April 2025; in Jazzy from
/// 1.3.7 on and in Kilted).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Alpha was a color; now a pixel is unknown if it is transparent at all, and alpha has no effect otherwise.
    Alpha,
    /// A pixel on a threshold was unknown; now it counts as free or occupied.
    Threshold,
    /// A shade was the mean of the colors; now they are weighted.
    Weights,
}

/// How shades are read, according to the map file's `mode`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    Trinary,
    Scale,
    Raw,
}

/// Everything that determines the meaning of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meaning {
    pub(super) mode: Mode,
    pub(super) negate: bool,
    /// From 0 to 1, above `free_threshold`.
    pub(super) occupied_threshold: f64,
    /// From 0 to 1.
    pub(super) free_threshold: f64,
}

impl Meaning {
    /// The kind of cell that a pixel represents. The pixel has one to four samples of at most `white`, as in a
    /// [`Raster`](crate::raster::Raster).
    pub(super) fn cell(&self, pixel: &[u16], white: u16) -> Cell {
        let (colors, alpha) = parts(pixel);
        match self.mode {
            Mode::Trinary => match (colors, alpha) {
                // ROS makes three colors of a gray that has alpha.
                ([gray], Some(alpha)) => self.trinary(self.occupancy(shade(&[*gray, *gray, *gray, alpha], white))),
                _ => self.trinary(self.occupancy(shade(pixel, white))),
            },
            Mode::Scale if alpha.is_some_and(|alpha| alpha < white) => Cell::Unknown,
            Mode::Scale => self.percents(self.scaled(self.occupancy(shade(colors, white)))),
            Mode::Raw => self.percents((shade(colors, white) * 255.0).round()),
        }
    }

    /// What the pixel means to newer releases of Nav2, with the reason, if that is another cell.
    pub(super) fn change(&self, pixel: &[u16], white: u16) -> Option<(Change, Cell)> {
        let (colors, alpha) = parts(pixel);
        let is_transparent = alpha.is_some_and(|alpha| alpha < white);
        let weighted = match colors {
            // As GraphicsMagick approximates ITU-R BT.601.
            [red, green, blue] => {
                let sum = [(306, red), (601, green), (117, blue)].map(|(weight, color)| weight * u64::from(*color));
                sum.iter().sum::<u64>() as f64 / (1024.0 * f64::from(white))
            }
            gray => shade(gray, white),
        };
        let newer = match self.mode {
            Mode::Trinary | Mode::Scale if is_transparent => Cell::Unknown,
            Mode::Trinary => self.newer_trinary(weighted),
            Mode::Scale => self.percents(self.scaled(self.occupancy(weighted))),
            Mode::Raw => self.percents((weighted * 255.0).round()),
        };
        let why = if is_transparent || alpha.is_some() && self.cell(colors, white) == newer {
            Change::Alpha
        } else if colors.iter().all(|color| *color == colors[0]) {
            Change::Threshold
        } else {
            Change::Weights
        };
        (newer != self.cell(pixel, white)).then_some((why, newer))
    }

    /// With numbers of Nav2's precision, which decides whether a shade lies on a threshold.
    fn newer_trinary(&self, shade: f64) -> Cell {
        let occupancy = if self.negate { shade as f32 } else { 1.0 - shade as f32 };
        if occupancy <= self.free_threshold as f32 {
            Cell::Free
        } else if occupancy >= self.occupied_threshold as f32 {
            Cell::Occupied
        } else {
            Cell::Unknown
        }
    }

    fn occupancy(&self, shade: f64) -> f64 {
        if self.negate { shade } else { 1.0 - shade }
    }

    fn trinary(&self, occupancy: f64) -> Cell {
        if occupancy > self.occupied_threshold {
            Cell::Occupied
        } else if occupancy < self.free_threshold {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }

    /// The percentage that ROS publishes in scale mode.
    fn scaled(&self, occupancy: f64) -> f64 {
        let (free, occupied) = (self.free_threshold, self.occupied_threshold);
        ((occupancy - free) / (occupied - free)).clamp(0.0, 1.0) * 100.0
    }

    /// A percentage as one of three kinds of cell.
    fn percents(&self, percents: f64) -> Cell {
        let occupancy = percents.round_ties_even() / 100.0;
        if occupancy > 1.0 {
            Cell::Unknown
        } else if occupancy >= self.occupied_threshold {
            Cell::Occupied
        } else if occupancy <= self.free_threshold {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}

/// The colors of a pixel, and its alpha if it has any.
fn parts(pixel: &[u16]) -> (&[u16], Option<u16>) {
    match pixel {
        [colors @ .., alpha] if pixel.len().is_multiple_of(2) => (colors, Some(*alpha)),
        colors => (colors, None),
    }
}

/// The mean of the samples, from 0 (black) to 1 (white).
fn shade(samples: &[u16], white: u16) -> f64 {
    let sum: u32 = samples.iter().map(|sample| u32::from(*sample)).sum();
    f64::from(sum) / (samples.len() as f64 * f64::from(white))
}

#[cfg(test)]
mod tests {
    use super::Cell::{Free, Occupied, Unknown};
    use super::*;

    fn meaning(mode: Mode, negate: bool) -> Meaning {
        Meaning { mode, negate, occupied_threshold: 0.65, free_threshold: 0.25 }
    }

    #[test]
    fn trinary_thresholds_the_darkness() {
        let cells = |negate| [0, 128, 254].map(|gray| meaning(Mode::Trinary, negate).cell(&[gray], 255));
        assert_eq!(cells(false), [Occupied, Unknown, Free]);
        assert_eq!(cells(true), [Free, Unknown, Occupied]);
    }

    #[test]
    fn trinary_values_on_a_threshold_are_unknown() {
        let exact = Meaning { occupied_threshold: 0.75, free_threshold: 0.25, ..meaning(Mode::Trinary, false) };
        assert_eq!([64, 63, 192, 193].map(|gray| exact.cell(&[gray], 256)), [Unknown, Occupied, Unknown, Free]);
    }

    #[test]
    fn trinary_counts_alpha_as_a_color_and_scale_as_transparency() {
        let glass = [255, 0];
        assert_eq!(meaning(Mode::Trinary, false).cell(&glass, 255), Unknown);
        assert_eq!(meaning(Mode::Scale, false).cell(&glass, 255), Unknown);
        assert_eq!(meaning(Mode::Scale, false).cell(&[255, 255], 255), Free);
        assert_eq!(meaning(Mode::Trinary, false).cell(&[255, 255, 0, 255], 255), Unknown);
        assert_eq!(meaning(Mode::Raw, false).cell(&[90, 90, 90, 0], 255), Occupied);
    }

    #[test]
    fn a_gray_with_alpha_is_as_dark_as_three_colors_with_alpha() {
        let dark = meaning(Mode::Trinary, false);
        for gray in 0..=255 {
            assert_eq!(dark.cell(&[gray, 255], 255), dark.cell(&[gray, gray, gray, 255], 255), "{gray}");
        }
    }

    #[test]
    fn newer_releases_differ_in_alpha_thresholds_and_weights() {
        let changed = |meaning: Meaning, pixel: &[u16]| meaning.change(pixel, 255);
        let usual = Meaning { free_threshold: 0.196, ..meaning(Mode::Trinary, false) };
        assert_eq!(changed(usual, &[205, 255]), Some((Change::Alpha, Unknown)));
        assert_eq!(changed(usual, &[205, 205, 205, 255]), Some((Change::Alpha, Unknown)));
        assert_eq!(changed(usual, &[254, 254]), Some((Change::Alpha, Unknown)));
        assert_eq!(changed(usual, &[0, 255]), None, "occupied in both");
        assert_eq!(changed(usual, &[0, 200, 0]), Some((Change::Weights, Unknown)));
        for mode in [Mode::Trinary, Mode::Scale, Mode::Raw] {
            for gray in 0..=255 {
                assert_eq!(changed(Meaning { mode, ..usual }, &[gray]), None, "{gray}");
                assert_eq!(changed(Meaning { mode, ..usual }, &[gray; 3]), None, "{gray}");
            }
        }
        let exact = Meaning { occupied_threshold: 0.6, free_threshold: 0.2, ..meaning(Mode::Trinary, true) };
        assert_eq!(changed(exact, &[51]), Some((Change::Threshold, Free)));
        assert_eq!(changed(exact, &[153]), Some((Change::Threshold, Occupied)));
        let wide = Meaning { occupied_threshold: 1.0, free_threshold: 0.0, ..meaning(Mode::Trinary, false) };
        let changes = [0, 1, 254, 255].map(|gray| changed(wide, &[gray]));
        assert_eq!(changes, [Some((Change::Threshold, Occupied)), None, None, Some((Change::Threshold, Free))]);
    }

    #[test]
    fn scale_stretches_between_the_thresholds() {
        // With thresholds 0.25 and 0.65 an occupancy of 0.35 is 25 %, one of 0.51 is 65 %.
        let cell = |gray| meaning(Mode::Scale, false).cell(&[gray], 100);
        assert_eq!([100, 65, 64, 50, 49, 0].map(cell), [Free, Free, Unknown, Unknown, Occupied, Occupied]);
    }

    #[test]
    fn raw_reads_shades_as_percentages_and_ignores_negate() {
        for negate in [false, true] {
            let cell = |gray| meaning(Mode::Raw, negate).cell(&[gray], 255);
            assert_eq!(
                [0, 25, 26, 64, 65, 100, 101, 255].map(cell),
                [Free, Free, Unknown, Unknown, Occupied, Occupied, Unknown, Unknown]
            );
        }
    }
}
