//! What can be wrong with the laser scanners.

/// Something wrong with a laser scanner, or with all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserFault {
    /// The scanner's name in the robot's model; all scanners if none.
    pub laser: Option<String>,
    /// What is wrong with it.
    pub trouble: LaserTrouble,
}

/// What can be wrong with a laser scanner.
///
/// Several troubles of one scanner add up: what each lets through meets the next, displacements follow one another,
/// variances of noises add, the shortest range limit holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LaserTrouble {
    /// No scans come.
    Dead,
    /// Scans repeat the ranges of the last one before, with new times.
    Stuck,
    /// Beams without a return: their range is infinite.
    Dropout {
        /// Share of the beams, from 0 to 1; new ones in every scan.
        probability: f64,
    },
    /// Random errors of the ranges, on top of those of [`LaserConfig`](crate::LaserConfig).
    Noise {
        /// Standard deviation, in metres.
        sigma_m: f64,
    },
    /// Nothing farther away is seen, as in fog or with a dirty window: such ranges are infinite.
    RangeLimit {
        /// The longest distance that is measured, in metres.
        max_m: f64,
    },
    /// The scanner sits elsewhere than the software believes. The displacement is in the frame of the scanner as it
    /// should sit.
    Mount {
        /// Displacement along the direction in which the scanner should look, in metres.
        x_m: f64,
        /// Displacement to the left of that direction, in metres.
        y_m: f64,
        /// By how much the scanner is turned, in radians, counter-clockwise.
        yaw_rad: f64,
    },
    /// Something that is not there is seen: beams of a sector see something at a distance, unless what they really see is
    /// nearer.
    Ghost {
        /// Distance from the scanner, in metres.
        distance_m: f64,
        /// The sector's middle in the scanner's frame, in radians, counter-clockwise: 0 is where it looks.
        bearing_rad: f64,
        /// The sector's width, in radians.
        width_rad: f64,
    },
}
