//! The outcomes of beams: what they hit, and at which distance.

use super::edges::Edges;
use super::fan::{BLOCK, FanBeam};

/// The outcome of a group of neighboring beams: a run of occupied cells whose front or side they hit, or nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    /// The first beam after the group.
    pub(super) end: usize,
    /// Distance along the fan's axis to the front, which is the line before the run's row; infinite if there is no run.
    pub(super) to_front: f64,
    /// Distance across to the side that the beams can hit; negative if there is none.
    pub(super) to_side: f64,
}

impl Outcome {
    /// The beams up to `end` hit nothing.
    pub(super) fn nothing(end: usize) -> Self {
        Self { end, to_front: f64::INFINITY, to_side: -1.0 }
    }

    /// Distance at which a beam of the group hits the run. The plain traversal divides the same numbers.
    #[inline]
    fn distance(&self, beam: &FanBeam, edges: &Edges<'_>) -> f64 {
        let by_front = edges.crosses_column_first(beam, self.to_side, self.to_front);
        let to = if by_front { self.to_front } else { self.to_side };
        let speed = if by_front { beam.along } else { beam.across.abs() };
        to / speed
    }
}

/// Computes the distances of a fan's beams, in lengths of their directions. `outcomes` holds each group's outcome at
/// its first beam; `beams` and `distances` have room for a block after the last beam.
pub(super) fn measure(edges: &Edges<'_>, beams: &[FanBeam], outcomes: &[Outcome], distances: &mut [f64]) {
    let mut start = 0;
    while let Some(outcome) = outcomes.get(start) {
        let end = outcome.end;
        if outcome.to_front == f64::INFINITY {
            distances[start..end].fill(f64::INFINITY);
        } else {
            // The excess of a block belongs to a later group, which overwrites it.
            for block in (start..end).step_by(BLOCK) {
                let blocks = distances[block..block + BLOCK].iter_mut().zip(&beams[block..block + BLOCK]);
                blocks.for_each(|(distance, beam)| *distance = outcome.distance(beam, edges));
            }
        }
        start = end;
    }
}
