//! The outline of a set of cells, as one SVG path.

/// A black-and-white picture: one Boolean per cell, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mask {
    width: usize,
    height: usize,
    cells: Vec<bool>,
}

impl Mask {
    /// The mask whose cells are `cells`, row by row, each row `width` long.
    pub(super) fn new(width: usize, cells: Vec<bool>) -> Self {
        let height = cells.len().checked_div(width).unwrap_or(0);
        Self { width, height, cells }
    }

    /// Whether the cell is set; false outside.
    pub(super) fn get(&self, column: usize, row: usize) -> bool {
        column < self.width && row < self.height && self.cells[row * self.width + column]
    }

    /// Erosion: the cells whose whole square of `2 · radius + 1` cells is set. Everything beyond the mask's edge counts
    /// as set.
    pub(super) fn eroded(&self, radius: usize) -> Self {
        self.swept(radius, |window| window.iter().all(|&set| set))
    }

    /// Dilation: the cells that have a set cell in their square of `2 · radius + 1` cells.
    pub(super) fn dilated(&self, radius: usize) -> Self {
        self.swept(radius, |window| window.iter().any(|&set| set))
    }

    /// Applies a rule to the square around each cell: to its rows, then to the columns of the result. For both rules,
    /// `all` and `any`, this is the same as applying them to the whole square.
    fn swept(&self, radius: usize, rule: impl Fn(&[bool]) -> bool) -> Self {
        let along_rows = self.swept_rows(radius, &rule);
        along_rows.transposed().swept_rows(radius, &rule).transposed()
    }

    fn swept_rows(&self, radius: usize, rule: &impl Fn(&[bool]) -> bool) -> Self {
        let mut cells = Vec::with_capacity(self.cells.len());
        for row in self.cells.chunks(self.width.max(1)) {
            cells.extend((0..row.len()).map(|i| rule(&row[i.saturating_sub(radius)..row.len().min(i + radius + 1)])));
        }
        Self { cells, ..*self }
    }

    fn transposed(&self) -> Self {
        let cells = (0..self.width)
            .flat_map(|column| (0..self.height).map(move |row| row * self.width + column))
            .map(|offset| self.cells[offset])
            .collect();
        Self { width: self.height, height: self.width, cells }
    }

    /// The edges between set and other cells as closed lines, to be filled with the even–odd rule: SVG path data in
    /// units of cells, with x along the columns and y along the rows.
    pub(super) fn outline(&self) -> String {
        let mut edges = Edges::of(self);
        let mut data = String::new();
        while let Some(start) = edges.next_start() {
            edges.walk(start, &mut data);
        }
        data
    }
}

/// The edges that have not been drawn yet. Every corner has an even number of them, so a walk along undrawn edges can
/// only end where it began.
struct Edges {
    /// Corners per row: one more than cells.
    stride: usize,
    /// Whether an edge runs from corner (x, y) to (x + 1, y).
    right: Vec<bool>,
    /// Whether an edge runs from corner (x, y) to (x, y + 1).
    down: Vec<bool>,
    /// There are no undrawn edges to the right before this corner.
    cursor: usize,
}

impl Edges {
    fn of(mask: &Mask) -> Self {
        let stride = mask.width + 1;
        let corners = stride * (mask.height + 1);
        let (mut right, mut down) = (vec![false; corners], vec![false; corners]);
        for y in 0..=mask.height {
            for x in 0..=mask.width {
                let here = mask.get(x, y);
                right[y * stride + x] = here != (y > 0 && mask.get(x, y - 1));
                down[y * stride + x] = here != (x > 0 && mask.get(x - 1, y));
            }
        }
        Self { stride, right, down, cursor: 0 }
    }

    fn next_start(&mut self) -> Option<usize> {
        let skipped = self.right[self.cursor..].iter().position(|&edge| edge)?;
        self.cursor += skipped;
        Some(self.cursor)
    }

    fn walk(&mut self, start: usize, data: &mut String) {
        *data += &format!("M{},{}", start % self.stride, start / self.stride);
        let mut corner = start;
        let mut horizontal = true;
        loop {
            let end = if horizontal { self.run_horizontally(corner) } else { self.run_vertically(corner) };
            if end == corner {
                break;
            }
            *data += &match horizontal {
                true => format!("h{}", end as isize - corner as isize),
                false => format!("v{}", (end as isize - corner as isize) / self.stride as isize),
            };
            (corner, horizontal) = (end, !horizontal);
        }
        data.push('z');
    }

    /// Follows edges to the right, or else to the left, up to the first corner where it can turn. So where two cells
    /// touch diagonally, the line turns instead of crossing itself.
    fn run_horizontally(&mut self, from: usize) -> usize {
        let mut corner = from;
        if self.right[corner] {
            while self.right[corner] && (corner == from || !self.turns_vertically(corner)) {
                self.right[corner] = false;
                corner += 1;
            }
            return corner;
        }
        while corner > 0 && self.right[corner - 1] && (corner == from || !self.turns_vertically(corner)) {
            corner -= 1;
            self.right[corner] = false;
        }
        corner
    }

    fn run_vertically(&mut self, from: usize) -> usize {
        let mut corner = from;
        if self.down[corner] {
            while self.down[corner] && (corner == from || !self.turns_horizontally(corner)) {
                self.down[corner] = false;
                corner += self.stride;
            }
            return corner;
        }
        while corner >= self.stride
            && self.down[corner - self.stride]
            && (corner == from || !self.turns_horizontally(corner))
        {
            corner -= self.stride;
            self.down[corner] = false;
        }
        corner
    }

    fn turns_vertically(&self, corner: usize) -> bool {
        self.down[corner] || (corner >= self.stride && self.down[corner - self.stride])
    }

    fn turns_horizontally(&self, corner: usize) -> bool {
        self.right[corner] || (corner > 0 && self.right[corner - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> Mask {
        let cells = rows.iter().flat_map(|row| row.bytes().map(|cell| cell == b'#')).collect();
        Mask::new(rows[0].len(), cells)
    }

    /// The steps of one closed line, such as `h2v-1h-2v1z`.
    fn steps(line: &str) -> Vec<(char, isize)> {
        let starts: Vec<usize> = line.match_indices(['h', 'v']).map(|(start, _)| start).collect();
        let ends = starts.iter().skip(1).copied().chain([line.len() - 1]);
        let step = |(&start, end): (&usize, usize)| {
            (line[start..].chars().next().unwrap(), line[start + 1..end].parse().unwrap())
        };
        starts.iter().zip(ends).map(step).collect()
    }

    /// Fills an outline with the even–odd rule, cell by cell, independently of how it was traced.
    fn filled(outline: &str, width: usize, height: usize) -> Mask {
        let mut crossings = vec![false; (width + 1) * height];
        for line in outline.split('M').skip(1) {
            let (start, line) = line.split_at(line.find('h').unwrap());
            let (x, y) = start.split_once(',').unwrap();
            let (mut x, mut y): (isize, isize) = (x.parse().unwrap(), y.parse().unwrap());
            for (direction, length) in steps(line) {
                if direction == 'h' {
                    x += length;
                    continue;
                }
                for row in y.min(y + length)..y.max(y + length) {
                    crossings[row as usize * (width + 1) + x as usize] ^= true;
                }
                y += length;
            }
        }
        let rows = crossings.chunks(width + 1).map(|row| {
            row[..width].iter().scan(false, |inside, &crossing| {
                *inside ^= crossing;
                Some(*inside)
            })
        });
        Mask::new(width, rows.flatten().collect())
    }

    #[test]
    fn a_rectangle_is_one_loop_of_four_lines() {
        assert_eq!(mask(&["....", ".##.", "...."]).outline(), "M1,1h2v1h-2v-1z");
    }

    #[test]
    fn filling_an_outline_gives_the_cells_back() {
        let pictures: [&[&str]; 5] = [
            &["#.#", ".#.", "#.#"],
            &["####", "#..#", "#.##", "####"],
            &["##..##", "#.##.#", ".#..#.", "##..##"],
            &["...", "..."],
            &["#"],
        ];
        for rows in pictures {
            let mask = mask(rows);
            assert_eq!(filled(&mask.outline(), mask.width, mask.height), mask, "{rows:?}");
        }
    }

    #[test]
    fn random_pictures_survive_the_round_trip() {
        let mut chance = crate::sample::Chance::new(1);
        for _ in 0..200 {
            let cells: Vec<bool> = (0..11 * 9).map(|_| chance.below(2) == 1).collect();
            let mask = Mask::new(11, cells);
            assert_eq!(filled(&mask.outline(), 11, 9), mask);
        }
    }

    #[test]
    fn erosion_keeps_the_inside_and_dilation_restores_the_outline() {
        let block = mask(&[".......", ".#####.", ".#####.", ".#####.", ".......", ".#....."]);
        let inside = mask(&[".......", ".......", "..###..", ".......", ".......", "......."]);
        assert_eq!(block.eroded(1), inside);
        assert_eq!(inside.dilated(1), mask(&[".......", ".#####.", ".#####.", ".#####.", ".......", "......."]));
    }

    #[test]
    fn a_mask_without_cells_has_no_outline() {
        assert_eq!(Mask::new(0, Vec::new()).outline(), "");
    }
}
