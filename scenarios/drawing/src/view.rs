//! Maps points of the `map` frame to the page.

use maps::Point;

use super::geometry::{Area, Spot};

/// A rectangle along the axes of the `map` frame, in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub low: Point,
    /// The corner with the largest coordinates.
    pub high: Point,
}

impl Bounds {
    /// The smallest rectangle around all points; `None` without points.
    pub fn around(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        points.into_iter().map(|point| Self { low: point, high: point }).reduce(Self::union)
    }

    /// The smallest rectangle around both rectangles.
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The rectangle with a margin in meters on every side.
    pub fn grown(self, margin_m: f64) -> Self {
        let margin = nalgebra::Vector2::repeat(margin_m);
        Self { low: self.low - margin, high: self.high + margin }
    }
}

/// Where the points of the `map` frame are on the page: x points right, y up, with the same scale in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The part of the page.
    pub area: Area,
    pixels_per_m: f64,
    center: Point,
}

impl View {
    /// The view in which `bounds` fills `area` as far as its shape allows, centered.
    pub fn fitting(bounds: Bounds, area: Area) -> Self {
        let extent = bounds.high - bounds.low;
        let pixels_per_m = (area.width / extent.x.max(1e-3)).min(area.height / extent.y.max(1e-3));
        Self { area, pixels_per_m, center: nalgebra::center(&bounds.low, &bounds.high) }
    }

    /// A length in meters, in pixels.
    pub fn pixels(&self, length_m: f64) -> f64 {
        length_m * self.pixels_per_m
    }

    /// Where a point of the map is on the page; `None` if it is not finite.
    pub fn spot(&self, point: Point) -> Option<Spot> {
        let offset = (point - self.center) * self.pixels_per_m;
        let (x, y) = self.area.center();
        (offset.x.is_finite() && offset.y.is_finite()).then_some((x + offset.x, y - offset.y))
    }

    /// The positions on the page of the points that are finite and not far outside the picture.
    pub fn spots<'a>(&self, points: &'a [Point]) -> impl Iterator<Item = Spot> + 'a {
        let view = *self;
        let visible = view.area.inset(-view.area.width);
        points.iter().filter_map(move |&point| view.spot(point)).filter(move |&spot| visible.contains(spot))
    }

    /// The point of the map at a position on the page.
    pub fn point_at(&self, spot: Spot) -> Point {
        let (x, y) = self.area.center();
        self.center + nalgebra::Vector2::new(spot.0 - x, y - spot.1) / self.pixels_per_m
    }

    /// The SVG matrix that transforms coordinates from `corner` in steps of `column` and `row` to the page.
    pub fn matrix(&self, corner: Point, column: nalgebra::Vector2<f64>, row: nalgebra::Vector2<f64>) -> [f64; 6] {
        let (x, y) = self.spot(corner).unwrap_or_default();
        let (column, row) = (column * self.pixels_per_m, row * self.pixels_per_m);
        [column.x, -column.y, row.x, -row.y, x, y]
    }
}
