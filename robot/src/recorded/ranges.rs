//! From which range on a laser has hit nothing.

use super::lines::Lines;

/// A reading nearer than this, in metres, is none.
pub(super) const LEAST_M: f64 = 0.02;

/// The range from which on nothing was hit, unless the log says better: that of the lasers that most logs were made
/// with.
const USUAL_M: f64 = 80.0;

/// The greatest range read is what the laser says when it hits nothing, if it is read at least so often, and in so many
/// of all beams: no two walls are equally far.
const FEWEST: usize = 20;
const LEAST_SHARE: f64 = 0.002;

/// The range from which on nothing was hit, in metres.
pub(super) fn nothing_hit_from_m(lines: &Lines) -> f64 {
    let most_m = lines.range_max_m.unwrap_or(USUAL_M);
    let ranges_m = || [0, 1].into_iter().flat_map(|laser| lines.scans(laser)).flat_map(|scan| &scan.ranges_m);
    let greatest_m = ranges_m().copied().filter(|range_m| f64::from(*range_m) < most_m).fold(0.0, f32::max);
    let repeated = ranges_m().filter(|range_m| **range_m >= greatest_m && f64::from(**range_m) < most_m).count();
    let often = repeated >= FEWEST && repeated as f64 >= LEAST_SHARE * ranges_m().count() as f64;
    if often { f64::from(greatest_m) } else { most_m }
}
