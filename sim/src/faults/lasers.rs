//! Faults of the laser scanners.

/// A fault of one laser scanner, or of all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserFault {
    /// The scanner's name in the robot's model; all scanners if `None`.
    pub laser: Option<String>,
    /// The trouble.
    pub trouble: LaserTrouble,
}

/// Troubles of a laser scanner.
///
/// Several troubles of one scanner accumulate: each acts on the result of the previous one, displacements are composed,
/// variances of noises add up, and the shortest range limit applies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LaserTrouble {
    /// No scans come.
    Dead,
    /// Scans repeat the ranges of the last scan before the fault, with new times.
    Stuck,
    /// Beams without an echo: their range is infinite.
    Dropout {
        /// Share of the beams, from 0 to 1, drawn for every scan.
        probability: f64,
    },
    /// Random errors of the ranges, in addition to those of [`LaserConfig`](crate::LaserConfig).
    Noise {
        /// Standard deviation, in meters.
        sigma_m: f64,
    },
    /// Nothing beyond a distance is visible, as in fog or with a dirty window: such ranges are infinite.
    RangeLimit {
        /// The longest measured distance, in meters.
        max_m: f64,
    },
    /// The scanner is not mounted where the software assumes. The displacement is in the frame of the correctly
    /// mounted scanner.
    Mount {
        /// Displacement along the scanner's correct forward direction, in meters.
        x_m: f64,
        /// Displacement to the left of that direction, in meters.
        y_m: f64,
        /// The scanner's rotation, in radians, counter-clockwise.
        yaw_rad: f64,
    },
    /// A nonexistent object is visible: the beams of a sector measure a fixed distance, unless they hit something
    /// nearer.
    Ghost {
        /// Distance from the scanner, in meters.
        distance_m: f64,
        /// The middle of the sector in the scanner's frame, in radians, counter-clockwise: 0 is forward.
        bearing_rad: f64,
        /// The sector's width, in radians.
        width_rad: f64,
    },
}
