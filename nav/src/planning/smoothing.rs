//! Makes a path of cells drivable: shortens it where a straight line costs no more, then smooths it.
//!
//! No change is accepted that would bring the robot where it cannot be.
//!
//! Smoothing is gradient descent with one term for smoothness and one for the original path, as in Nav2's simple
//! smoother. The weights were chosen, not measured.

use maps::Point;

use super::standing::Ground;

/// Distance between the points of a path, in meters.
const SPACING_M: f64 = 0.1;

/// How many times every point is pulled towards the midpoint of its neighbors.
const ROUNDS: usize = 60;

/// How far a point moves towards the midpoint, and how strongly it is held in its original place.
const PULL: f64 = 0.4;
const HOLD: f64 = 0.08;

/// Number of samples on lines, per cell.
const LOOKS_PER_CELL: f64 = 2.0;

/// A path in the `map` frame along cells, from `start` (or the first cell's center) to `end`, which is in the last
/// cell.
pub(crate) fn smoothed(ground: &Ground<'_>, cells: &[usize], start: Option<&Point>, end: &Point) -> Vec<Point> {
    let frame = &ground.costmap.frame;
    let mut points: Vec<Point> = cells.iter().map(|cell| frame.in_grid(&frame.center(*cell))).collect();
    if let Some(start) = start {
        points[0] = frame.in_grid(start);
    }
    match points.len() {
        1 => points.push(frame.in_grid(end)),
        last => points[last - 1] = frame.in_grid(end),
    }
    let spacing = SPACING_M / frame.resolution_m;
    let shortened = spaced(&shortened(ground, &points), spacing);
    let mut rounded = shortened.clone();
    round_off(ground, &mut rounded);
    let chosen = [rounded, shortened].into_iter().find(|path| is_clear(ground, path));
    chosen.unwrap_or_else(|| spaced(&points, spacing)).iter().map(|point| frame.in_map(point)).collect()
}

/// The path without the points that can be replaced with a straight line that costs no more.
fn shortened(ground: &Ground<'_>, points: &[Point]) -> Vec<Point> {
    let mut costs = vec![0.0; points.len()];
    for index in 1..points.len() {
        let step = line_cost(ground, &points[index - 1], &points[index]).unwrap_or(f64::INFINITY);
        costs[index] = costs[index - 1] + step;
    }
    let pays = |from: usize, to: usize| {
        line_cost(ground, &points[from], &points[to]).is_some_and(|cost| cost <= costs[to] - costs[from] + 1e-6)
    };
    let mut kept = vec![points[0]];
    let mut at = 0;
    while at + 1 < points.len() {
        at = farthest(at, points.len() - 1, |to| pays(at, to));
        kept.push(points[at]);
    }
    kept
}

/// A far good index, found by strides that double while they are good and then halve; at least the next one.
fn farthest(at: usize, last: usize, is_good: impl Fn(usize) -> bool) -> usize {
    let mut good = at + 1;
    let mut stride = 1;
    while good + stride <= last && is_good(good + stride) {
        good += stride;
        stride *= 2;
    }
    while stride > 0 {
        if good + stride <= last && is_good(good + stride) {
            good += stride;
        }
        stride /= 2;
    }
    good
}

/// The cost of driving along a line, or `None` if the robot cannot.
fn line_cost(ground: &Ground<'_>, from: &Point, to: &Point) -> Option<f64> {
    let length = (to - from).norm();
    let looks = (length * LOOKS_PER_CELL).ceil().max(1.0) as usize;
    let mut sum = 0;
    for look in 0..=looks {
        let cost = ground.cost_in_grid(&(from + (to - from) * (look as f64 / looks as f64)));
        if cost == 0 {
            return None;
        }
        // The ends count half: each belongs to two lines.
        sum += if look == 0 || look == looks { cost } else { 2 * cost };
    }
    Some(f64::from(sum) / 2.0 * length / looks as f64)
}

/// A straight path in the `map` frame, with the usual spacing of points.
pub(crate) fn straight(from: &Point, to: &Point) -> Vec<Point> {
    spaced(&[*from, *to], SPACING_M)
}

/// The same path with at most this distance between points.
fn spaced(points: &[Point], spacing: f64) -> Vec<Point> {
    let mut path = vec![points[0]];
    for pair in points.windows(2) {
        let count = ((pair[1] - pair[0]).norm() / spacing).ceil().max(1.0) as usize;
        path.extend((1..=count).map(|i| pair[0] + (pair[1] - pair[0]) * (i as f64 / count as f64)));
    }
    path
}

/// Pulls every point except the ends towards the midpoint of its neighbors, unless the robot cannot be there or the
/// cost would be noticeably higher.
fn round_off(ground: &Ground<'_>, path: &mut [Point]) {
    let held = path.to_vec();
    for _ in 0..ROUNDS {
        for index in 1..path.len().saturating_sub(1) {
            let middle = nalgebra::center(&path[index - 1], &path[index + 1]);
            let moved = path[index] + (middle - path[index]) * PULL + (held[index] - path[index]) * HOLD;
            let (before, after) = (ground.cost_in_grid(&path[index]), ground.cost_in_grid(&moved));
            if after > 0 && after <= before + ground.least_cost() / 2 {
                path[index] = moved;
            }
        }
    }
}

fn is_clear(ground: &Ground<'_>, path: &[Point]) -> bool {
    path.windows(2).all(|pair| line_cost(ground, &pair[0], &pair[1]).is_some())
}
