//! The arrows of a state machine: which transitions share an arrow, and its labels.

use super::frame::Diagram;
use super::geometry::{Area, Spot};
use super::text::Font;

/// The maximum number of lines of text on one arrow.
const MOST_LINES: usize = 4;

/// An arrow: all transitions from one location to another.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedEdge {
    /// Index of the location it leaves.
    pub from: usize,
    /// Index of the location it enters.
    pub to: usize,
    /// Its path: two spots for a straight arrow, four for one with three segments.
    pub spine: Vec<Spot>,
    /// Its labels, line by line.
    pub labels: Vec<PlacedLabel>,
}

/// A line of text with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLabel {
    /// Its box.
    pub area: Area,
    /// The text, as far as it fits.
    pub text: String,
}

/// The sizes of everything at one scale, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measures {
    pub(super) font: Font,
    pub(super) radius: f64,
    /// The minimum room for a straight arrow in addition to its label.
    pub(super) gap: f64,
    /// Distance from a row or track to the next.
    pub(super) rise: f64,
    /// Room for the arrow into the initial location.
    pub(super) entry: f64,
}

impl Measures {
    pub(super) fn at(scale: f64) -> Self {
        Self {
            font: Font::regular(13.5 * scale),
            radius: 18.0 * scale,
            gap: 19.0 * scale,
            rise: 9.0 * scale,
            entry: 24.0 * scale,
        }
    }
}

/// All transitions from one location to another, by their places in the row.
#[derive(Clone, Debug)]
pub(super) struct Bundle {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) lines: Vec<String>,
    pub(super) width: f64,
    /// How far its label may be moved along the row from the arrow's middle, beyond what the arrow's ports and length
    /// allow.
    pub(super) sway: f64,
}

/// The transitions, grouped by the locations that they connect, by places in the row.
pub(super) fn bundles(diagram: &Diagram, order: &[usize], font: Font, longest: f64) -> Vec<Bundle> {
    let mut place = vec![usize::MAX; diagram.locations.len()];
    for (i, &location) in order.iter().enumerate() {
        place[location] = i;
    }
    let mut bundles: Vec<(usize, usize, Vec<&str>)> = Vec::new();
    for transition in &diagram.transitions {
        let (Some(&from), Some(&to)) = (place.get(transition.from), place.get(transition.to)) else { continue };
        let label = transition.label.as_str();
        match bundles.iter_mut().find(|bundle| (bundle.0, bundle.1) == (from, to)) {
            Some((_, _, labels)) => labels.push(label),
            None => bundles.push((from, to, vec![label])),
        }
    }
    // Arrows that skip locations rise beside a loop, through the middle of its label if that cannot move aside.
    let rises_at = |place: usize| bundles.iter().any(|&(from, to, _)| to > from + 1 && (from == place || to == place));
    let bundle = |(from, to, labels): &(usize, usize, Vec<&str>)| {
        let (from, to) = (*from, *to);
        let lines = lines(labels, font, longest * from.abs_diff(to).max(1) as f64);
        let width = lines.iter().map(|line| font.width(line)).fold(0.0, f64::max);
        let sway = if from == to && rises_at(from) { width / 2.0 } else { 0.0 };
        Bundle { from, to, lines, width, sway }
    };
    bundles.iter().map(bundle).collect()
}

/// The wrapped labels of one arrow, with as many lines as fit.
fn lines(labels: &[&str], font: Font, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = labels.iter().flat_map(|label| font.wrap(label, room, 2)).collect();
    if lines.len() > MOST_LINES {
        let hidden = lines.len() - (MOST_LINES - 1);
        lines.truncate(MOST_LINES - 1);
        lines.push(font.fit(&format!("… {hidden} more"), room));
    }
    lines
}

/// Centered lines of text below each other, from `top` down.
pub(super) fn stacked(lines: &[String], top: Spot, font: Font) -> Vec<PlacedLabel> {
    let height = font.line_height();
    lines
        .iter()
        .enumerate()
        .map(|(i, line)| {
            let center = (top.0, top.1 + (i as f64 + 0.5) * height);
            PlacedLabel { area: Area::around(center, font.width(line), height), text: line.clone() }
        })
        .collect()
}
