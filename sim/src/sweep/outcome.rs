//! What beams end on, and how far away that is.

use super::edges::Edges;
use super::fan::{BLOCK, FanBeam};

/// Where a group of neighbouring beams ends: on a run of occupied cells, of which they meet the front or a side, or
/// nowhere.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    /// The first beam behind the group.
    pub(super) end: usize,
    /// Distance along the fan's axis to the front, which is the line before the run's row; infinite if there is no run.
    pub(super) to_front: f64,
    /// Distance across to the side that the beams can meet; negative if there is none.
    pub(super) to_side: f64,
}

impl Outcome {
    /// The beams up to `end` meet nothing.
    pub(super) fn nothing(end: usize) -> Self {
        Self { end, to_front: f64::INFINITY, to_side: -1.0 }
    }

    /// Distance at which a beam of the group meets the run. The plain traversal divides the same numbers.
    #[inline]
    fn distance(&self, beam: &FanBeam, edges: &Edges<'_>) -> f64 {
        let by_front = edges.crosses_column_first(beam, self.to_side, self.to_front);
        let to = if by_front { self.to_front } else { self.to_side };
        let speed = if by_front { beam.along } else { beam.across.abs() };
        to / speed
    }
}

/// Tells how far away the beams of a fan end, in lengths of their directions. `outcomes` holds each group's at its first
/// beam; `beams` and `distances` have room for a block behind the last.
pub(super) fn measure(edges: &Edges<'_>, beams: &[FanBeam], outcomes: &[Outcome], distances: &mut [f64]) {
    let mut start = 0;
    while let Some(outcome) = outcomes.get(start) {
        let end = outcome.end;
        if outcome.to_front == f64::INFINITY {
            distances[start..end].fill(f64::INFINITY);
        } else {
            // What a block has too much belongs to a later group, which will put it right.
            for block in (start..end).step_by(BLOCK) {
                let blocks = distances[block..block + BLOCK].iter_mut().zip(&beams[block..block + BLOCK]);
                blocks.for_each(|(distance, beam)| *distance = outcome.distance(beam, edges));
            }
        }
        start = end;
    }
}
