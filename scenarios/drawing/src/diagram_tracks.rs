//! Arrows that run above or below a row of locations.
//!
//! Every arrow gets a track (how far out it runs), then its two ports (where it leaves and enters the row), then its
//! label's place along it. Each step depends only on the step before, and the tracks are wide enough for the later
//! steps to find room: labels never overlap, whatever the diagram.

use super::diagram_arrows::{Bundle, Measures, PlacedEdge, stacked};
use super::geometry::Spot;

/// On which side of the row an arrow runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowSide {
    /// Loops, and arrows that skip locations.
    Above,
    /// Arrows that go back.
    Below,
}

/// An arrow with three segments: out of the row, along it, and back into it.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    bundle: Bundle,
    side: RowSide,
    /// Its track: the depth of nesting of the arrows that it encloses.
    track: usize,
    /// Where it leaves and enters the row, along it.
    from_x: f64,
    to_x: f64,
    label_x: f64,
}

impl Arc {
    pub(super) fn new(bundle: Bundle) -> Self {
        let side = if bundle.to < bundle.from { RowSide::Below } else { RowSide::Above };
        Self { bundle, side, track: 0, from_x: 0.0, to_x: 0.0, label_x: 0.0 }
    }

    /// First and last place in the row that it spans.
    fn span(&self) -> (usize, usize) {
        (self.bundle.from.min(self.bundle.to), self.bundle.from.max(self.bundle.to))
    }
}

/// All arrows that run above or below a row.
pub(super) struct Tracks<'a> {
    arcs: Vec<Arc>,
    middles: &'a [f64],
    halves: &'a [f64],
    measures: Measures,
    /// How far labels in the row extend above its middle.
    above_row: f64,
}

impl<'a> Tracks<'a> {
    pub(super) fn new(
        mut arcs: Vec<Arc>,
        middles: &'a [f64],
        halves: &'a [f64],
        measures: Measures,
        above_row: f64,
    ) -> Self {
        arcs.sort_by_key(|arc| (arc.span().1 - arc.span().0, arc.span().0));
        for arc in &mut arcs {
            arc.from_x = middles[arc.bundle.from];
            arc.to_x = middles[arc.bundle.to];
            arc.label_x = (arc.from_x + arc.to_x) / 2.0;
        }
        let mut tracks = Self { arcs, middles, halves, measures, above_row };
        for side in [RowSide::Above, RowSide::Below] {
            tracks.assign_tracks(side);
            tracks.assign_ports(side);
            tracks.shift_labels(side);
        }
        tracks
    }

    /// How far everything on this side extends from the middle of the row, in pixels.
    pub(super) fn extent(&self, side: RowSide) -> f64 {
        let tracks = self.arcs.iter().filter(|arc| arc.side == side).map(|arc| arc.track + 1).max().unwrap_or(0);
        self.base(side) + 3.0 + (0..tracks).map(|track| self.track_height(side, track)).sum::<f64>()
    }

    /// The arrows, with the middle of the row at height `y`.
    pub(super) fn edges(&self, order: &[usize], y: f64) -> Vec<PlacedEdge> {
        self.arcs.iter().map(|arc| self.edge(arc, order, y)).collect()
    }

    fn edge(&self, arc: &Arc, order: &[usize], y: f64) -> PlacedEdge {
        let font = self.measures.font;
        let outwards = if arc.side == RowSide::Above { -1.0 } else { 1.0 };
        let level = y + outwards * self.level(arc.side, arc.track);
        let text = arc.bundle.lines.len() as f64 * font.line_height();
        let top = if arc.side == RowSide::Above { level - text - 1.0 } else { level + 1.0 };
        let end = |place: usize, x: f64| -> Spot { (x, y + outwards * self.rim(place, x)) };
        PlacedEdge {
            from: order[arc.bundle.from],
            to: order[arc.bundle.to],
            spine: vec![
                end(arc.bundle.from, arc.from_x),
                (arc.from_x, level),
                (arc.to_x, level),
                end(arc.bundle.to, arc.to_x),
            ],
            labels: stacked(&arc.bundle.lines, (arc.label_x, top), font),
        }
    }

    /// How far the row itself extends from its middle.
    fn base(&self, side: RowSide) -> f64 {
        match side {
            RowSide::Above => self.above_row,
            RowSide::Below => self.measures.radius,
        }
    }

    /// Distance from the middle of the row to the line of a track.
    fn level(&self, side: RowSide, track: usize) -> f64 {
        self.base(side) + (0..track).map(|inner| self.track_height(side, inner)).sum::<f64>() + self.measures.rise
    }

    /// The room for a track: the distance to its line, and its labels.
    fn track_height(&self, side: RowSide, track: usize) -> f64 {
        let lines = self.arcs.iter().filter(|arc| arc.side == side && arc.track == track);
        let most = lines.map(|arc| arc.bundle.lines.len()).max().unwrap_or(0);
        self.measures.rise + most as f64 * self.measures.font.line_height() + 2.0
    }

    /// Shorter arrows come first; an arrow that conflicts with others runs outside all of them. As `arcs` is sorted by
    /// length, everything that an arrow can enclose already has its track, so one pass is enough.
    fn assign_tracks(&mut self, side: RowSide) {
        for i in 0..self.arcs.len() {
            if self.arcs[i].side == side {
                let inner = self.arcs[..i].iter().filter(|other| other.side == side && self.meet(&self.arcs[i], other));
                self.arcs[i].track = inner.map(|other| other.track + 1).max().unwrap_or(0);
            }
        }
    }

    /// Whether two arrows cannot share a track: they run along the same stretch of the row, or the label of one
    /// overlaps the other.
    fn meet(&self, a: &Arc, b: &Arc) -> bool {
        let overlap = |a: (f64, f64), b: (f64, f64)| a.0 < b.1 && b.0 < a.1;
        let same_stretch = a.span().0 < b.span().1 && b.span().0 < a.span().1;
        let into = |a: &Arc, b: &Arc| {
            self.label_reach(a).is_some_and(|label| {
                overlap(label, self.line_reach(b)) || self.label_reach(b).is_some_and(|other| overlap(label, other))
            })
        };
        same_stretch || into(a, b) || into(b, a)
    }

    /// The range of an arrow along the row.
    fn line_reach(&self, arc: &Arc) -> (f64, f64) {
        (self.middles[arc.span().0], self.middles[arc.span().1])
    }

    /// The range that the label of an arrow can cover, if it is longer than the arrow. Ports and shifts of the label
    /// are not known yet, so this is the farthest that they can move it.
    fn label_reach(&self, arc: &Arc) -> Option<(f64, f64)> {
        let (low, high) = self.line_reach(arc);
        let shift = 0.4 * (self.halves[arc.span().0] + self.halves[arc.span().1]);
        let half = arc.bundle.width / 2.0 + shift + arc.bundle.sway + 4.0;
        (2.0 * half > high - low).then_some(((low + high) / 2.0 - half, (low + high) / 2.0 + half))
    }

    /// Determines where arrows leave and enter each location: side by side, in an order in which they do not cross.
    /// From left to right, these are the arrows from the left, the innermost first; the two ends of the loop; and the
    /// arrows to the right, the outermost first. So each arrow encloses those farther in, at both of its ends.
    fn assign_ports(&mut self, side: RowSide) {
        for place in 0..self.middles.len() {
            // From the left, loop, to the right; then the order within each group.
            let mut ends: Vec<(usize, isize, usize, bool)> = Vec::new();
            for (i, arc) in self.arcs.iter().enumerate().filter(|(_, arc)| arc.side == side) {
                let (first, last, track) = (arc.span().0, arc.span().1, arc.track as isize);
                let leaves = arc.bundle.from == place;
                if first == last && first == place {
                    ends.push((1, 0, i, true));
                    ends.push((1, 1, i, false));
                } else if last == place {
                    ends.push((0, track, i, leaves));
                } else if first == place {
                    ends.push((2, -track, i, leaves));
                }
            }
            ends.sort_unstable();
            let half = self.halves[place];
            let step = (self.measures.radius * 0.62).min(1.6 * half / ends.len().max(1) as f64);
            for (slot, (_, _, i, leaves)) in ends.iter().enumerate() {
                let x = self.middles[place] + (slot as f64 - (ends.len() - 1) as f64 / 2.0) * step;
                if *leaves {
                    self.arcs[*i].from_x = x;
                } else {
                    self.arcs[*i].to_x = x;
                }
            }
        }
    }

    /// Moves labels along their arrows to where no arrow farther out passes through them.
    fn shift_labels(&mut self, side: RowSide) {
        for i in 0..self.arcs.len() {
            let arc = &self.arcs[i];
            if arc.side != side {
                continue;
            }
            let middle = (arc.from_x + arc.to_x) / 2.0;
            let room = ((arc.from_x - arc.to_x).abs() - arc.bundle.width).max(0.0) / 2.0 + arc.bundle.sway;
            let clear = arc.bundle.width / 2.0 + 4.0;
            let legs: Vec<f64> = self
                .arcs
                .iter()
                .filter(|other| other.side == side && other.track > arc.track)
                .flat_map(|other| [other.from_x, other.to_x])
                .collect();
            let beside = legs.iter().flat_map(|leg| [leg - clear, leg + clear]);
            let free = [middle].into_iter().chain(beside).filter(|x| {
                (x - middle).abs() <= room + 1e-9 && legs.iter().all(|leg| (leg - x).abs() >= clear - 1e-9)
            });
            let best = free.min_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
            self.arcs[i].label_x = best.unwrap_or(middle);
        }
    }

    /// The distance of a location's outline from the middle of the row at `x`.
    fn rim(&self, place: usize, x: f64) -> f64 {
        let radius = self.measures.radius;
        let beyond = ((x - self.middles[place]).abs() - (self.halves[place] - radius)).max(0.0);
        (radius * radius - beyond * beyond).max(0.0).sqrt()
    }
}
