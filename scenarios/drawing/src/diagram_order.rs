//! The order of a state machine's locations in their row.

use super::frame::Diagram;

/// All locations, in the order of the row: breadth first from the initial one, or depth first if fewer arrows cross
/// that way. Breadth first keeps alternatives together, depth first keeps chains together. For the machines of
/// monitors, trying both is enough; finding the best order is NP-hard.
pub(super) fn in_row(diagram: &Diagram) -> Vec<usize> {
    let (broad, deep) = (breadth_first(diagram), depth_first(diagram));
    if crossings(diagram, &deep) < crossings(diagram, &broad) { deep } else { broad }
}

/// The locations in breadth-first order from the initial one, then those that cannot be reached.
fn breadth_first(diagram: &Diagram) -> Vec<usize> {
    let count = diagram.locations.len();
    let mut order: Vec<usize> = Vec::with_capacity(count);
    for root in [diagram.initial].into_iter().filter(|&root| root < count).chain(0..count) {
        if order.contains(&root) {
            continue;
        }
        let mut next = order.len();
        order.push(root);
        while let Some(&location) = order.get(next) {
            for transition in diagram.transitions.iter().filter(|transition| transition.from == location) {
                if transition.to < count && !order.contains(&transition.to) {
                    order.push(transition.to);
                }
            }
            next += 1;
        }
    }
    order
}

/// The locations in depth-first order from the initial one, then those that cannot be reached.
fn depth_first(diagram: &Diagram) -> Vec<usize> {
    let count = diagram.locations.len();
    let mut order: Vec<usize> = Vec::with_capacity(count);
    // A stack with the initial location on top. All locations wait below it, the first uppermost, in case they are not
    // reached.
    let mut open: Vec<usize> =
        (0..count).rev().chain([diagram.initial].into_iter().filter(|root| *root < count)).collect();
    while let Some(location) = open.pop() {
        if order.contains(&location) {
            continue;
        }
        order.push(location);
        let leaving = diagram.transitions.iter().rev().filter(|transition| transition.from == location);
        open.extend(leaving.map(|transition| transition.to).filter(|to| *to < count));
    }
    order
}

/// The number of pairs of arrows on the same side of the row that cross each other in this order.
fn crossings(diagram: &Diagram, order: &[usize]) -> usize {
    let place = |location: usize| order.iter().position(|other| *other == location);
    let ends =
        diagram.transitions.iter().filter_map(|transition| Some((place(transition.from)?, place(transition.to)?)));
    let mut arrows: Vec<(usize, usize)> = ends.filter(|(from, to)| *to != from + 1 && from != to).collect();
    arrows.sort_unstable();
    arrows.dedup();
    // Two arrows on the same side cross if each has exactly one end between the ends of the other. Only the arrow that
    // begins farther left is tested, so that each pair counts once.
    let cross = |a: &(usize, usize), b: &(usize, usize)| {
        let [a, b] = [a, b].map(|(from, to)| (from.min(to), from.max(to)));
        a.0 < b.0 && b.0 < a.1 && a.1 < b.1
    };
    let same_side = |a: &(usize, usize), b: &(usize, usize)| (a.0 < a.1) == (b.0 < b.1);
    arrows.iter().map(|a| arrows.iter().filter(|b| same_side(a, b) && cross(a, b)).count()).sum()
}
