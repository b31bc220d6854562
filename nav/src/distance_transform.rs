//! The exact Euclidean distance transform of a grid.
//!
//! Distances run from cell center to cell center, or to the nearest point of a cell, in half cells. They are squared
//! integers, so nothing is rounded. Columns are processed first, in two sweeps; then each row is computed as the lower
//! envelope of parabolas, in time linear in the number of cells. The distance to a cell is the distance to the nearest
//! of its center and its two sides: three parabolas.
//!
//! Source: P. Felzenszwalb and D. Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8,
//! 2012.

/// The distance in a grid without targets.
pub(crate) const NO_TARGET: u32 = u32::MAX;

/// The squared distance in cells from each cell to the nearest one that `is_target` accepts (by its offset in a grid
/// stored row by row), [`NO_TARGET`] where there is none.
pub(crate) fn squared_distances(width: usize, height: usize, is_target: impl Fn(usize) -> bool) -> Vec<u32> {
    if width == 0 || height == 0 {
        return Vec::new();
    }
    let mut field = distances_along_columns(width, height, is_target);
    let mut envelope = Vec::with_capacity(width);
    for row in field.chunks_exact_mut(width) {
        lower_envelope(row, &mut envelope);
        fill_from(&envelope, row);
    }
    field
}

/// The squared distance in half cells from each cell's center to the nearest point of the nearest cell that `is_target`
/// accepts; otherwise like [`squared_distances`].
pub(crate) fn squared_half_cells(width: usize, height: usize, is_target: impl Fn(usize) -> bool) -> Vec<u32> {
    if width == 0 || height == 0 {
        return Vec::new();
    }
    let mut field = distances_along_columns(width, height, is_target);
    // Alternating left sides and centers of the row's cells, and the right side of the last one.
    let mut halves = vec![NO_TARGET; 2 * width + 1];
    let mut envelope = Vec::with_capacity(halves.len());
    for row in field.chunks_exact_mut(width) {
        halves.fill(NO_TARGET);
        for (column, cells) in row.iter().enumerate().filter(|(_, cells)| **cells != NO_TARGET) {
            let half_cells = (2 * cells).saturating_sub(1);
            for half in &mut halves[2 * column..=2 * column + 2] {
                *half = half_cells.min(*half);
            }
        }
        lower_envelope(&halves, &mut envelope);
        fill_from(&envelope, &mut halves);
        for (distance, center) in row.iter_mut().zip(halves.iter().skip(1).step_by(2)) {
            *distance = *center;
        }
    }
    field
}

/// The distance in cells to the nearest target of the same column.
fn distances_along_columns(width: usize, height: usize, is_target: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut field: Vec<u32> = (0..width * height).map(|offset| if is_target(offset) { 0 } else { NO_TARGET }).collect();
    for offset in width..width * height {
        field[offset] = field[offset].min(field[offset - width].saturating_add(1));
    }
    for offset in (0..width * (height - 1)).rev() {
        field[offset] = field[offset].min(field[offset + width].saturating_add(1));
    }
    field
}

/// The parabola over one column of a row: its vertex, and the column from which it is the lowest.
struct Parabola {
    vertex: i64,
    height: i64,
    from: i64,
}

/// The parabolas that make up the lower envelope of a row, left to right.
fn lower_envelope(row: &[u32], envelope: &mut Vec<Parabola>) {
    envelope.clear();
    for (column, &distance) in row.iter().enumerate().filter(|(_, distance)| **distance != NO_TARGET) {
        let (vertex, height) = (column as i64, i64::from(distance).pow(2));
        let mut from = 0;
        while let Some(last) = envelope.last() {
            let rise = (vertex * vertex + height) - (last.vertex * last.vertex + last.height);
            from = rise.div_euclid(2 * (vertex - last.vertex)) + 1;
            if from > last.from {
                break;
            }
            envelope.pop();
            from = 0;
        }
        if from < row.len() as i64 {
            envelope.push(Parabola { vertex, height, from });
        }
    }
}

/// Writes the envelope's heights into the row.
fn fill_from(envelope: &[Parabola], row: &mut [u32]) {
    let mut end = row.len();
    for parabola in envelope.iter().rev() {
        let from = parabola.from as usize;
        for (column, distance) in row.iter_mut().enumerate().take(end).skip(from) {
            let across = column as i64 - parabola.vertex;
            *distance = u32::try_from(across * across + parabola.height).unwrap_or(NO_TARGET - 1);
        }
        end = from;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn brute_force(width: usize, height: usize, targets: &[bool]) -> Vec<u32> {
        let squared = |a: usize, b: usize| {
            let across = (a % width).abs_diff(b % width);
            let along = (a / width).abs_diff(b / width);
            (across * across + along * along) as u32
        };
        (0..width * height)
            .map(|cell| (0..targets.len()).filter(|i| targets[*i]).map(|i| squared(cell, i)).min().unwrap_or(NO_TARGET))
            .collect()
    }

    /// The same to the nearest points of cells, in half cells.
    fn brute_force_to_cells(width: usize, height: usize, targets: &[bool]) -> Vec<u32> {
        let beside = |a: usize, b: usize| (2 * a.abs_diff(b)).saturating_sub(1).pow(2);
        let squared = |a: usize, b: usize| (beside(a % width, b % width) + beside(a / width, b / width)) as u32;
        (0..width * height)
            .map(|cell| (0..targets.len()).filter(|i| targets[*i]).map(|i| squared(cell, i)).min().unwrap_or(NO_TARGET))
            .collect()
    }

    fn grids() -> impl Strategy<Value = (usize, usize, Vec<bool>)> {
        (1_usize..24, 1_usize..24).prop_flat_map(|(width, height)| {
            let sparse = prop::bool::weighted(0.08);
            (Just(width), Just(height), prop::collection::vec(sparse, width * height))
        })
    }

    proptest! {
        #[test]
        fn distances_equal_those_of_brute_force((width, height, targets) in grids()) {
            prop_assert_eq!(squared_distances(width, height, |i| targets[i]), brute_force(width, height, &targets));
        }

        #[test]
        fn distances_to_cells_equal_those_of_brute_force((width, height, targets) in grids()) {
            let expected = brute_force_to_cells(width, height, &targets);
            prop_assert_eq!(squared_half_cells(width, height, |i| targets[i]), expected);
        }
    }

    #[test]
    fn an_empty_grid_has_no_distances() {
        assert!(squared_distances(0, 5, |_| true).is_empty());
        assert!(squared_distances(5, 0, |_| true).is_empty());
        assert!(squared_half_cells(0, 5, |_| true).is_empty());
    }
}
