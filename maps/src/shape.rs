//! The outlines of bodies.

/// The outline of a body around its center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A disc.
    Disc {
        /// Radius, in meters.
        radius_m: f64,
    },
    /// A rectangle.
    Box {
        /// Extent along the body's x axis, in meters.
        length_m: f64,
        /// Extent along the body's y axis, in meters.
        width_m: f64,
    },
}

impl Shape {
    /// Radius of the smallest circle around the center that contains the shape, in meters.
    #[must_use]
    pub fn bounding_radius_m(&self) -> f64 {
        match self {
            Self::Disc { radius_m } => *radius_m,
            Self::Box { length_m, width_m } => 0.5 * (length_m * length_m + width_m * width_m).sqrt(),
        }
    }
}
