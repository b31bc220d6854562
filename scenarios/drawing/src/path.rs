//! The outlines of shapes.
//!
//! Circles and rounded corners are quadratic curves, and the corners of rotated shapes are computed here: the renderer
//! would compute arcs, rotations and the outlines of cubic curves with functions whose last bit differs between
//! machines.

use super::geometry::{Area, Spot};

/// The outline of a shape: SVG path data, with numbers to a hundredth of a pixel.
#[derive(Clone, Debug, Default)]
pub struct Path {
    data: String,
    pen: Spot,
}

impl Path {
    /// An empty outline.
    pub fn new() -> Self {
        Self::default()
    }

    /// The path in SVG syntax.
    pub fn data(&self) -> &str {
        &self.data
    }

    /// Begins a line at this spot.
    pub fn move_to(mut self, to: Spot) -> Self {
        self.push('M', &[to]);
        self
    }

    /// Adds a straight line to this spot.
    pub fn line_to(mut self, to: Spot) -> Self {
        self.push('L', &[to]);
        self
    }

    /// Adds a quadratic curve toward `control`, ending at `to`.
    pub fn curve_to(mut self, control: Spot, to: Spot) -> Self {
        self.push('Q', &[control, to]);
        self
    }

    /// Closes the line.
    pub fn close(mut self) -> Self {
        self.data.push('Z');
        self
    }

    /// Adds a line through all spots.
    pub fn through(spots: impl IntoIterator<Item = Spot>) -> Self {
        let mut path = Self::new();
        for spot in spots {
            path.push(if path.data.is_empty() { 'M' } else { 'L' }, &[spot]);
        }
        path
    }

    /// Adds a point at every spot, to be stroked: the round ends of a line of zero length form a dot.
    pub fn dots(spots: impl IntoIterator<Item = Spot>) -> Self {
        let mut path = Self::new();
        for spot in spots {
            path.push('M', &[spot]);
            path.data.push_str("h0");
        }
        path
    }

    /// Adds a circle of eight curves (exact to 0.03 % of its radius).
    pub fn circle(center: Spot, radius: f64) -> Self {
        const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
        const CONTROL: f64 = std::f64::consts::SQRT_2 - 1.0;
        // An eighth of a circle as a quadratic curve: its control point is where the tangents at its two ends meet, (1,
        // tan 22.5°).
        const ON: [Spot; 8] = [
            (1.0, 0.0),
            (DIAGONAL, DIAGONAL),
            (0.0, 1.0),
            (-DIAGONAL, DIAGONAL),
            (-1.0, 0.0),
            (-DIAGONAL, -DIAGONAL),
            (0.0, -1.0),
            (DIAGONAL, -DIAGONAL),
        ];
        const BETWEEN: [Spot; 8] = [
            (1.0, CONTROL),
            (CONTROL, 1.0),
            (-CONTROL, 1.0),
            (-1.0, CONTROL),
            (-1.0, -CONTROL),
            (-CONTROL, -1.0),
            (CONTROL, -1.0),
            (1.0, -CONTROL),
        ];
        let at = |(x, y): Spot| (center.0 + radius * x, center.1 + radius * y);
        let mut path = Self::new().move_to(at(ON[0]));
        for i in 0..8 {
            path = path.curve_to(at(BETWEEN[i]), at(ON[(i + 1) % 8]));
        }
        path.close()
    }

    /// Adds a box with rounded corners.
    pub fn rounded(area: Area, radius: f64) -> Self {
        let radius = radius.min(area.width / 2.0).min(area.height / 2.0).max(0.0);
        let (left, top, right, bottom) = (area.x, area.y, area.right(), area.bottom());
        if radius < 0.5 {
            return Self::through([(left, top), (right, top), (right, bottom), (left, bottom)]).close();
        }
        Self::new()
            .move_to((left + radius, top))
            .line_to((right - radius, top))
            .corner((right, top), (right, top + radius))
            .line_to((right, bottom - radius))
            .corner((right, bottom), (right - radius, bottom))
            .line_to((left + radius, bottom))
            .corner((left, bottom), (left, bottom - radius))
            .line_to((left, top + radius))
            .corner((left, top), (left + radius, top))
            .close()
    }

    /// Rounds the right angle at `corner` with two eighths of a circle, from the pen's position to `to`, which are
    /// equally far from the corner.
    pub fn corner(self, corner: Spot, to: Spot) -> Self {
        const CUT: f64 = std::f64::consts::SQRT_2 - 1.0;
        const MIDDLE: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
        let from = self.pen;
        let along = |target: Spot, part: f64| {
            (corner.0 + (target.0 - corner.0) * part, corner.1 + (target.1 - corner.1) * part)
        };
        let near = along(from, 1.0 - CUT);
        let far = along(to, 1.0 - CUT);
        let (a, b) = (along(from, MIDDLE), along(to, MIDDLE));
        let middle = (a.0 + b.0 - corner.0, a.1 + b.1 - corner.1);
        self.curve_to(near, middle).curve_to(far, to)
    }

    fn push(&mut self, command: char, spots: &[Spot]) {
        self.data.push(command);
        for (i, &(x, y)) in spots.iter().enumerate() {
            let separator = if i == 0 { "" } else { " " };
            self.data += &format!("{separator}{},{}", number(x), number(y));
            self.pen = (x, y);
        }
    }
}

/// A number in SVG syntax: at most two decimals, no trailing zeros, never NaN or infinity.
pub fn number(value: f64) -> String {
    let value = if value.is_finite() { value.clamp(-1e7, 1e7) } else { 0.0 };
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_finite() {
        let written = [1.0, -0.001, 2.50, 3.146, f64::NAN, f64::INFINITY, -1e300].map(number);
        assert_eq!(written, ["1", "0", "2.5", "3.15", "0", "0", "-10000000"]);
    }

    #[test]
    fn a_rounded_corner_joins_its_two_lines() {
        let path = Path::new().move_to((0.0, 0.0)).line_to((6.0, 0.0)).corner((10.0, 0.0), (10.0, 4.0));
        assert_eq!(path.data(), "M0,0L6,0Q7.66,0 8.83,1.17Q10,2.34 10,4");
        let square = Path::rounded(Area::new(1.0, 2.0, 3.0, 4.0), 0.0);
        assert_eq!(square.data(), "M1,2L4,2L4,6L1,6Z");
    }

    #[test]
    fn a_circle_keeps_its_radius() {
        let circle = Path::circle((10.0, 10.0), 100.0);
        let numbers: Vec<f64> = circle.data().split(['M', 'Q', 'Z', ',', ' ']).filter_map(|n| n.parse().ok()).collect();
        for knot in numbers.chunks(2).step_by(2) {
            let (dx, dy) = (knot[0] - 10.0, knot[1] - 10.0);
            assert!(((dx * dx + dy * dy).sqrt() - 100.0).abs() < 0.02, "{knot:?}");
        }
    }
}
