//! Where the locations and transitions of a state machine are drawn.
//!
//! Locations are in one row. A transition to the next location is a straight arrow with its label above; one that skips
//! locations runs above the row, one that goes back runs below it, and a loop is on top of its location. Transitions
//! between the same two locations share an arrow, with one label below the other. Arrows above and below the row run in
//! tracks: an arrow that encloses another runs farther out, so that labels never overlap.
//!
//! A general graph layout would give shorter arrows, but its labels cross arrows as soon as a monitor has more than a
//! few locations. In a row, whether two labels can overlap is a question about intervals, which the tracks answer
//! exactly.

use super::diagram_arrows::{Bundle, Measures, PlacedEdge, bundles, stacked};
use super::diagram_order::in_row;
use super::diagram_tracks::{Arc, RowSide, Tracks};
use super::frame::Diagram;
use super::geometry::Area;

/// Scales and longest labels (pixels at scale 1) to try, the most pleasant first. Wrapping a label costs a line of
/// height, and a smaller font strains the eyes. So labels are wrapped once before anything shrinks, and shrink in small
/// steps before they are wrapped again.
const ATTEMPTS: [(f64, f64); 11] = [
    (1.0, 150.0),
    (1.0, 105.0),
    (0.95, 105.0),
    (0.9, 105.0),
    (0.86, 105.0),
    (0.82, 105.0),
    (0.82, 74.0),
    (0.82, 58.0),
    (0.78, 58.0),
    (0.78, 44.0),
    (0.76, 34.0),
];

/// Where everything of a state machine is drawn, in pixels from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagramLayout {
    /// The locations, in the order of the diagram.
    pub locations: Vec<PlacedLocation>,
    /// The arrows.
    pub edges: Vec<PlacedEdge>,
    /// Extent to the right.
    pub width: f64,
    /// Extent downwards.
    pub height: f64,
    /// Size of the labels' font.
    pub font_px: f64,
}

/// A location with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLocation {
    /// Its box; its ends are semicircles.
    pub area: Area,
    /// The part of its name that fits.
    pub label: String,
}

impl DiagramLayout {
    /// Lays out a state machine in at most `width` pixels. Labels are wrapped, then everything is made smaller down to
    /// three quarters, then labels are shortened and finally left out.
    #[must_use]
    pub fn new(diagram: &Diagram, width: f64) -> Self {
        let order = &in_row(diagram);
        if order.is_empty() {
            return Self { locations: Vec::new(), edges: Vec::new(), width: 0.0, height: 0.0, font_px: 0.0 };
        }
        let mut attempts =
            ATTEMPTS.iter().map(|&(scale, longest)| Row::new(diagram, order, Measures::at(scale), longest));
        let row = attempts.find(|row| row.width() <= width);
        let row = row.unwrap_or_else(|| {
            // Without labels, every length is proportional to the scale, so one division gives the scale that fits.
            let bare = Row::new(diagram, order, Measures::at(0.72), 0.0);
            let squeeze = (width / bare.width()).min(1.0);
            Row::new(diagram, order, Measures::at(0.72 * squeeze), 0.0)
        });
        row.stretched(width).placed(order)
    }

    /// Whether every name and label is complete.
    #[must_use]
    pub fn is_complete(&self, diagram: &Diagram) -> bool {
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<String>>();
        let named = self.locations.iter().zip(&diagram.locations).all(|(placed, named)| placed.label == named.name);
        let labelled = |edge: &PlacedEdge| {
            let between = diagram
                .transitions
                .iter()
                .filter(|transition| (transition.from, transition.to) == (edge.from, edge.to));
            let wanted: Vec<String> = between.flat_map(|transition| words(&transition.label)).collect();
            let shown: Vec<String> = edge.labels.iter().flat_map(|label| words(&label.text)).collect();
            wanted == shown
        };
        named && self.edges.iter().all(labelled)
    }
}

/// Locations in a row, with the distances that labels need.
struct Row {
    measures: Measures,
    names: Vec<String>,
    /// Half the width of each location.
    halves: Vec<f64>,
    /// Room between each location and the next.
    gaps: Vec<f64>,
    bundles: Vec<Bundle>,
    /// Where the first location begins, and how far labels extend beyond the last.
    left: f64,
    beyond: f64,
}

impl Row {
    fn new(diagram: &Diagram, order: &[usize], measures: Measures, longest: f64) -> Self {
        let Measures { font, radius, gap, .. } = measures;
        let longest = longest * font.size / 13.5;
        let names: Vec<String> =
            order.iter().map(|&location| font.fit(&diagram.locations[location].name, radius * 5.0)).collect();
        let halves: Vec<f64> = names.iter().map(|name| (font.width(name) / 2.0 + radius * 0.42).max(radius)).collect();
        let bundles = bundles(diagram, order, font, longest);
        let mut gaps = vec![gap; order.len().saturating_sub(1)];
        for bundle in &bundles {
            if bundle.to == bundle.from + 1 {
                // A straight arrow is as long as the gap, and its label has to fit into it.
                gaps[bundle.from] = gaps[bundle.from].max(bundle.width + gap);
            } else if bundle.from == bundle.to + 1 {
                // An arrow to the previous location runs from port to port, below both locations, so its label needs
                // that much less of the gap. Arrows over several gaps are long enough for their labels.
                let ports = halves[bundle.to].min(radius) * 0.4 + halves[bundle.from].min(radius) * 0.4;
                let inside = (halves[bundle.from] + halves[bundle.to] - ports).max(0.0);
                gaps[bundle.to] = gaps[bundle.to].max(bundle.width + gap * 0.7 - inside);
            }
        }
        Self { measures, names, halves, gaps, bundles, left: measures.entry, beyond: 4.0 }.with_margins()
    }

    /// The same row, with room at its ends for labels that are wider than their arrows.
    fn with_margins(mut self) -> Self {
        let middles = self.middles();
        let end = self.width() - self.beyond;
        for bundle in self.bundles.iter().filter(|bundle| bundle.to != bundle.from + 1) {
            let middle = (middles[bundle.from] + middles[bundle.to]) / 2.0;
            // Where several arrows leave a location side by side, each is shifted by at most this much.
            let shift = 0.4 * (self.halves[bundle.from] + self.halves[bundle.to]);
            let reach = bundle.width / 2.0 + shift + bundle.sway;
            self.left = self.left.max(self.measures.entry + reach - middle);
            self.beyond = self.beyond.max(middle + reach - end);
        }
        self
    }

    fn width(&self) -> f64 {
        self.left + self.halves.iter().sum::<f64>() * 2.0 + self.gaps.iter().sum::<f64>() + self.beyond
    }

    /// The same row, with wider gaps if there is room.
    fn stretched(mut self, width: f64) -> Self {
        let spare = (width - self.width()).max(0.0) / self.gaps.len().max(1) as f64;
        self.gaps.iter_mut().for_each(|gap| *gap += spare.min(64.0));
        self
    }

    /// The middle of each location, along the row.
    fn middles(&self) -> Vec<f64> {
        let mut left = self.left;
        let mut middles = Vec::with_capacity(self.halves.len());
        for (i, half) in self.halves.iter().enumerate() {
            middles.push(left + half);
            left += 2.0 * half + self.gaps.get(i).copied().unwrap_or(0.0);
        }
        middles
    }

    fn placed(&self, order: &[usize]) -> DiagramLayout {
        let Measures { font, radius, .. } = self.measures;
        let middles = self.middles();
        let (straight, round): (Vec<&Bundle>, Vec<&Bundle>) =
            self.bundles.iter().partition(|bundle| bundle.to == bundle.from + 1);
        let stack = |bundle: &&Bundle| bundle.lines.len() as f64 * font.line_height() + font.size * 0.35;
        let above_row = straight.iter().map(stack).fold(radius, f64::max);
        let arcs: Vec<Arc> = round.into_iter().map(|bundle| Arc::new(bundle.clone())).collect();
        let tracks = Tracks::new(arcs, &middles, &self.halves, self.measures, above_row);
        let y = tracks.extent(RowSide::Above);
        let locations = self.locations(order, &middles, y);
        let mut edges: Vec<PlacedEdge> =
            straight.into_iter().map(|bundle| self.straight_edge(bundle, order, &middles, y)).collect();
        edges.extend(tracks.edges(order, y));
        let height = y + tracks.extent(RowSide::Below);
        DiagramLayout { locations, edges, width: self.width(), height, font_px: font.size }
    }

    fn locations(&self, order: &[usize], middles: &[f64], y: f64) -> Vec<PlacedLocation> {
        let mut locations: Vec<(usize, PlacedLocation)> = (0..order.len())
            .map(|i| {
                let area = Area::around((middles[i], y), 2.0 * self.halves[i], 2.0 * self.measures.radius);
                (order[i], PlacedLocation { area, label: self.names[i].clone() })
            })
            .collect();
        locations.sort_by_key(|(location, _)| *location);
        locations.into_iter().map(|(_, location)| location).collect()
    }

    fn straight_edge(&self, bundle: &Bundle, order: &[usize], middles: &[f64], y: f64) -> PlacedEdge {
        let font = self.measures.font;
        let from = middles[bundle.from] + self.halves[bundle.from];
        let to = middles[bundle.to] - self.halves[bundle.to];
        let top = y - font.size * 0.35 - bundle.lines.len() as f64 * font.line_height();
        PlacedEdge {
            from: order[bundle.from],
            to: order[bundle.to],
            spine: vec![(from, y), (to, y)],
            labels: stacked(&bundle.lines, ((from + to) / 2.0, top), font),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Location, Transition};
    use crate::sample::{Chance, everything, phi1, phi2};

    fn check(diagram: &Diagram, width: f64) -> DiagramLayout {
        let layout = DiagramLayout::new(diagram, width);
        let page = Area::new(0.0, 0.0, width, layout.height);
        let labels = layout.edges.iter().flat_map(|edge| &edge.labels).map(|label| label.area);
        let boxes: Vec<Area> = layout.locations.iter().map(|location| location.area).chain(labels).collect();
        assert_eq!(layout.locations.len(), diagram.locations.len());
        for (i, area) in boxes.iter().enumerate() {
            assert!(page.encloses(area), "{area:?} leaves {page:?}");
            for other in &boxes[..i] {
                assert!(!area.inset(0.01).overlaps(other), "{area:?} overlaps {other:?} in {layout:#?}");
            }
        }
        for spot in layout.edges.iter().flat_map(|edge| &edge.spine) {
            assert!(page.inset(-1e-6).contains(*spot), "{spot:?} leaves {page:?}");
        }
        layout
    }

    #[test]
    fn the_monitors_of_the_paper_keep_their_labels() {
        for monitor in [phi1(), phi2()] {
            let layout = check(&monitor.diagram, 572.0);
            let shown: Vec<&str> =
                layout.edges.iter().flat_map(|edge| &edge.labels).map(|label| label.text.as_str()).collect();
            for transition in &monitor.diagram.transitions {
                assert!(shown.contains(&transition.label.as_str()), "{} is not in {shown:?}", transition.label);
            }
        }
    }

    #[test]
    fn locations_are_in_breadth_first_order_with_back_edges_below() {
        let layout = check(&phi2().diagram, 572.0);
        let lefts: Vec<f64> = layout.locations.iter().map(|location| location.area.x).collect();
        assert!(lefts.is_sorted(), "{lefts:?}");
        let row = layout.locations[0].area.center().1;
        for edge in &layout.edges {
            let straight = edge.to == edge.from + 1;
            assert_eq!(edge.spine.len(), if straight { 2 } else { 4 });
            assert!(straight || edge.spine[1].1 > row, "{edge:?}");
        }
    }

    #[test]
    fn locations_are_placed_so_that_arrows_do_not_cross() {
        // In breadth-first order, 0 → 2 and 1 → 3 would cross.
        let transition = |from, to| Transition { from, to, label: format!("from {from} to {to}") };
        let diagram = Diagram {
            locations: ["wait", "count", "answer", "fail"]
                .map(|name| Location { name: name.to_owned(), error: name == "fail", ..Location::default() })
                .to_vec(),
            initial: 0,
            active: 0,
            transitions: vec![transition(0, 1), transition(0, 2), transition(1, 3), transition(1, 0), transition(2, 0)],
        };
        let layout = check(&diagram, 572.0);
        let lefts = [0, 1, 3, 2].map(|location: usize| layout.locations[location].area.x);
        assert!(lefts.is_sorted(), "{lefts:?}");
        assert_eq!(layout.edges.iter().filter(|edge| edge.spine.len() == 2).count(), 2);
    }

    #[test]
    fn loops_skips_and_parallel_transitions_do_not_overlap() {
        for width in [300.0, 480.0, 572.0, 1200.0] {
            let layout = check(&everything().diagram, width);
            assert_eq!(layout.edges.len(), 12, "transitions between the same locations share an arrow");
        }
    }

    #[test]
    fn the_label_of_a_loop_avoids_an_arrow_that_rises_beside_it() {
        let transition = |from, to, label: &str| Transition { from, to, label: label.to_owned() };
        let diagram = Diagram {
            locations: ["I", "C", "T", "A"]
                .map(|name| Location { name: name.to_owned(), ..Location::default() })
                .to_vec(),
            initial: 0,
            active: 0,
            transitions: vec![
                transition(0, 1, "asked"),
                transition(1, 1, "a message that changes nothing"),
                transition(1, 2, "tick"),
                transition(1, 3, "answered"),
                transition(2, 3, "late"),
            ],
        };
        let layout = check(&diagram, 900.0);
        for edge in layout.edges.iter().filter(|edge| edge.spine.len() == 4) {
            for leg in [(edge.spine[0], edge.spine[1]), (edge.spine[2], edge.spine[3])] {
                let x = leg.0.0;
                for label in layout.edges.iter().filter(|other| *other != edge).flat_map(|other| &other.labels) {
                    let (top, bottom) = (leg.0.1.min(leg.1.1), leg.0.1.max(leg.1.1));
                    let beside = x < label.area.x || x > label.area.x + label.area.width;
                    let apart = bottom < label.area.y || top > label.area.y + label.area.height;
                    assert!(beside || apart, "{edge:?} cuts {label:?}");
                }
            }
        }
    }

    #[test]
    fn a_diagram_without_locations_is_empty() {
        let layout = check(&Diagram::default(), 500.0);
        assert!(layout.edges.is_empty());
    }

    #[test]
    fn labels_of_random_diagrams_do_not_overlap() {
        let mut chance = Chance::new(3);
        for _ in 0..500 {
            let count = 1 + chance.below(12);
            let locations =
                (0..count).map(|_| Location { name: "loc".repeat(chance.below(5)), ..Location::default() }).collect();
            let transitions = (0..chance.below(16)).map(|_| Transition {
                from: chance.below(count),
                to: chance.below(count + 1),
                label: "on a word ".repeat(chance.below(4)),
            });
            let transitions = transitions.collect();
            check(&Diagram { locations, initial: chance.below(count), active: 0, transitions }, 480.0);
        }
    }
}
