//! The four fans of a scan.

use std::ops::Range;

use nalgebra::Vector2;

/// The dominant direction of a beam. Beams at 45° belong to those along x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quadrant {
    /// Along x.
    Right,
    /// Along y.
    Up,
    /// Against x.
    Left,
    /// Against y.
    Down,
}

impl Quadrant {
    const ALL: [Self; 4] = [Self::Right, Self::Up, Self::Left, Self::Down];

    /// Whether a beam belongs to this quadrant.
    #[inline]
    fn holds(self, direction: &Vector2<f64>) -> bool {
        let (x, y) = (direction.x, direction.y);
        match self {
            Self::Right => x >= y.abs(),
            Self::Up => y > x.abs(),
            Self::Left => -x >= y.abs(),
            Self::Down => -y > x.abs(),
        }
    }

    /// Whether its beams follow the x axis.
    pub(super) fn is_along_x(self) -> bool {
        matches!(self, Self::Right | Self::Left)
    }

    /// Whether its beams go in the positive direction of their axis.
    pub(super) fn is_forward(self) -> bool {
        matches!(self, Self::Right | Self::Up)
    }

    /// Whether counter-clockwise beams are in descending order of their gain across.
    pub(super) fn is_reversed(self) -> bool {
        matches!(self, Self::Up | Self::Left)
    }

    /// Absolute component of a beam along the quadrant's axis, and its component across.
    #[inline]
    pub(super) fn components(self, direction: &Vector2<f64>) -> (f64, f64) {
        if self.is_along_x() { (direction.x.abs(), direction.y) } else { (direction.y.abs(), direction.x) }
    }
}

/// Divides an arc of counter-clockwise beams into fans of beams with the same dominant direction. No beam is lost;
/// beams without a direction form a separate fan.
pub(crate) fn fans(directions: &[Vector2<f64>], arc: Range<usize>) -> impl Iterator<Item = (Quadrant, Range<usize>)> {
    let mut start = arc.start;
    std::iter::from_fn(move || {
        let first = directions[start..arc.end].first()?;
        let quadrant = Quadrant::ALL.into_iter().find(|quadrant| quadrant.holds(first)).unwrap_or(Quadrant::Right);
        let rest = directions[start + 1..arc.end].iter().take_while(|direction| quadrant.holds(direction)).count();
        let fan = start..start + 1 + rest;
        start = fan.end;
        Some((quadrant, fan))
    })
}
