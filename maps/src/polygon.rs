//! Checks of polygons that a user defines by their corners.

use diagnostics::{Problem, Span, Spanned};

use crate::Point;

/// More corners are refused, because each edge is compared with every other.
const MAX_CORNERS: usize = 1000;

/// Smaller areas, in square meters, count as empty.
const MIN_AREA_M2: f64 = 1e-4;

/// The problems of a polygon: too few corners, coinciding corners, edges that cross or touch, no area. `whole` is the
/// span of the whole polygon.
pub(crate) fn problems(corners: &[Spanned<Point>], whole: &Span) -> Vec<Problem> {
    if !(3..=MAX_CORNERS).contains(&corners.len()) {
        let problem = whole.problem(format!("an area must have from 3 to {MAX_CORNERS} corners"));
        return vec![problem.with_label(format!("this has {}", corners.len()))];
    }
    let coinciding = coinciding(corners);
    if !coinciding.is_empty() {
        return coinciding;
    }
    let nothing = || vec![whole.problem("the area is empty").with_label("this outline")];
    if on_one_line(corners) {
        return nothing();
    }
    let crossings = crossings(corners);
    if crossings.is_empty() && area(corners).abs() < MIN_AREA_M2 { nothing() } else { crossings }
}

fn on_one_line(corners: &[Spanned<Point>]) -> bool {
    let from = corners[0].value;
    let along = corners[1].value - from;
    corners.iter().all(|corner| along.perp(&(corner.value - from)) == 0.0)
}

/// The area, positive if the corners go counter-clockwise, in square meters.
fn area(corners: &[Spanned<Point>]) -> f64 {
    // Computed relative to a corner, so that rounding does not swallow an area far from the origin.
    let from = corners[0].value;
    let doubled: f64 = edges(corners).map(|(a, b)| (a.value - from).perp(&(b.value - from))).sum();
    doubled / 2.0
}

fn coinciding(corners: &[Spanned<Point>]) -> Vec<Problem> {
    let pairs = edges(corners).filter(|(a, b)| a.value == b.value);
    let problem = |(a, b): (&Spanned<_>, &Spanned<_>)| {
        let later = if a.span.range().start > b.span.range().start { a } else { b };
        later.span.problem("two neighboring corners are the same point").with_label("the same as its neighbor")
    };
    pairs.map(problem).collect()
}

/// One problem for each pair of edges that share a point other than a common corner.
fn crossings(corners: &[Spanned<Point>]) -> Vec<Problem> {
    let edges: Vec<_> = edges(corners).collect();
    let mut problems = Vec::new();
    for (i, (a, b)) in edges.iter().enumerate() {
        for (j, (c, d)) in edges.iter().enumerate().skip(i + 1) {
            let neighbors = j == i + 1 || (i == 0 && j == edges.len() - 1);
            let crosses = if neighbors {
                let (before, corner, after) = if j == i + 1 { (a, b, d) } else { (c, a, b) };
                turns_back(&before.value, &corner.value, &after.value)
            } else {
                touch([&a.value, &b.value], [&c.value, &d.value])
            };
            if crosses {
                let problem = c.span.problem("the area's edges cross each other");
                let edge = |from: usize| format!("corner {} to corner {}", from + 1, (from + 1) % edges.len() + 1);
                let label = format!("the edge that begins here, {}, meets the one from {}", edge(j), edge(i));
                problems.push(problem.with_label(label).with_help("list the corners in the order of the outline"));
            }
        }
    }
    problems
}

/// Whether the outline reverses at a corner.
fn turns_back(before: &Point, corner: &Point, after: &Point) -> bool {
    let (come, go) = (corner - before, after - corner);
    come.perp(&go) == 0.0 && come.dot(&go) < 0.0
}

/// Whether two line segments share a point.
fn touch([a, b]: [&Point; 2], [c, d]: [&Point; 2]) -> bool {
    let side = |a: &Point, b: &Point, p: &Point| (b - a).perp(&(p - a));
    let apart = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    let overlap = |a: f64, b: f64, c: f64, d: f64| a.min(b) <= c.max(d) && c.min(d) <= a.max(b);
    !apart(side(a, b, c), side(a, b, d))
        && !apart(side(c, d, a), side(c, d, b))
        && overlap(a.x, b.x, c.x, d.x)
        && overlap(a.y, b.y, c.y, d.y)
}

fn edges(corners: &[Spanned<Point>]) -> impl Iterator<Item = (&Spanned<Point>, &Spanned<Point>)> {
    corners.iter().zip(corners.iter().cycle().skip(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnostics::Source;

    fn messages(corners: &[(f64, f64)]) -> Vec<String> {
        let source = Source::new("polygon", "0123456789");
        let spanned = |(place, (x, y)): (usize, &(f64, f64))| Spanned {
            value: Point::new(*x, *y),
            span: source.span(place..place + 1),
        };
        let corners: Vec<_> = corners.iter().enumerate().map(spanned).collect();
        problems(&corners, &source.span(0..10)).iter().map(Problem::one_line).collect()
    }

    #[test]
    fn simple_outlines_are_accepted_in_either_direction() {
        let outline = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 1.0), (0.0, 3.0)];
        assert_eq!(messages(&outline), [""; 0]);
        let mut reversed = outline;
        reversed.reverse();
        assert_eq!(messages(&reversed), [""; 0]);
        // A corner on a straight edge is accepted.
        assert_eq!(messages(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)]), [""; 0]);
    }

    #[test]
    fn a_bow_tie_is_refused() {
        let problems = messages(&[(0.0, 0.0), (2.0, 2.0), (3.0, 0.0), (0.0, 2.5)]);
        assert_eq!(problems.len(), 1);
        assert!(problems[0].starts_with("polygon:1:3: the area's edges cross"), "{problems:?}");
    }

    #[test]
    fn spikes_touching_corners_and_flat_outlines_are_refused() {
        assert_eq!(messages(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (2.0, 1.0), (0.0, 1.0)]).len(), 2);
        assert!(!messages(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 0.0), (0.0, 2.0)]).is_empty());
        assert_eq!(messages(&[(0.0, 0.0), (1.0, 1.0), (3.0, 3.0)]).len(), 1);
        assert_eq!(messages(&[(0.0, 0.0), (1.0, 1.0)]).len(), 1);
        assert_eq!(messages(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)]).len(), 1);
    }
}
