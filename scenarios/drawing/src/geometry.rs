//! Points and boxes on the page, in pixels: x to the right, y downwards.

/// A position on the page, in pixels.
pub type Spot = (f64, f64);

/// An axis-parallel box on the page, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left edge.
    pub x: f64,
    /// Upper edge.
    pub y: f64,
    /// Extent to the right.
    pub width: f64,
    /// Extent downwards.
    pub height: f64,
}

impl Area {
    /// The box of this width and height whose upper left corner is (`x`, `y`).
    #[must_use]
    pub const fn new(x: f64, y: f64, width: f64, height: f64) -> Self {
        Self { x, y, width, height }
    }

    /// The box of this size around a center.
    #[must_use]
    pub fn around(center: Spot, width: f64, height: f64) -> Self {
        Self::new(center.0 - width / 2.0, center.1 - height / 2.0, width, height)
    }

    /// The right edge.
    #[must_use]
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// The lower edge.
    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// The middle.
    #[must_use]
    pub fn center(&self) -> Spot {
        (self.x + self.width / 2.0, self.y + self.height / 2.0)
    }

    /// The box without a margin of this many pixels on every side; its size is never negative.
    #[must_use]
    pub fn inset(&self, margin: f64) -> Self {
        let (width, height) = ((self.width - 2.0 * margin).max(0.0), (self.height - 2.0 * margin).max(0.0));
        Self::around(self.center(), width, height)
    }

    /// The same box, moved.
    #[must_use]
    pub fn shifted(&self, dx: f64, dy: f64) -> Self {
        Self { x: self.x + dx, y: self.y + dy, ..*self }
    }

    /// The spot in it that is nearest to another one.
    #[must_use]
    pub fn nearest(&self, (x, y): Spot) -> Spot {
        (x.clamp(self.x, self.right()), y.clamp(self.y, self.bottom()))
    }

    /// Whether the two boxes share more than an edge.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.x < other.right() && other.x < self.right() && self.y < other.bottom() && other.y < self.bottom()
    }

    /// The area that the two boxes share, in square pixels.
    #[must_use]
    pub fn shared_with(&self, other: &Self) -> f64 {
        let width = self.right().min(other.right()) - self.x.max(other.x);
        let height = self.bottom().min(other.bottom()) - self.y.max(other.y);
        width.max(0.0) * height.max(0.0)
    }

    /// Whether a straight line goes through the box.
    #[must_use]
    pub fn is_crossed_by(&self, [from, to]: [Spot; 2]) -> bool {
        // The part of the line that is within the box's extent along both axes.
        let along = |from: f64, to: f64, low: f64, high: f64| match to - from {
            0.0 => (low..=high).contains(&from).then_some((0.0, 1.0)),
            length => {
                let (a, b) = ((low - from) / length, (high - from) / length);
                Some((a.min(b), a.max(b)))
            }
        };
        let parts = [along(from.0, to.0, self.x, self.right()), along(from.1, to.1, self.y, self.bottom())];
        let [Some(across), Some(down)] = parts else { return false };
        across.0.max(down.0).max(0.0) <= across.1.min(down.1).min(1.0)
    }

    /// Whether the spot is inside or on the edge.
    #[must_use]
    pub fn contains(&self, spot: Spot) -> bool {
        (self.x..=self.right()).contains(&spot.0) && (self.y..=self.bottom()).contains(&spot.1)
    }

    /// Whether all of `other` is inside (edges may touch, to within a thousandth of a pixel).
    #[must_use]
    pub fn encloses(&self, other: &Self) -> bool {
        const SLACK: f64 = 1e-3;
        other.x >= self.x - SLACK
            && other.y >= self.y - SLACK
            && other.right() <= self.right() + SLACK
            && other.bottom() <= self.bottom() + SLACK
    }
}
