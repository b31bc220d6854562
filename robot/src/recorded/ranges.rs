//! The range that means that a laser has hit nothing.

use super::lines::Lines;

/// A reading below this, in meters, is not a distance.
pub(super) const LEAST_M: f64 = 0.02;

/// The range that stands for "no hit" unless the log shows another: that of the lasers that recorded most logs.
const USUAL_M: f64 = 80.0;

/// The greatest range in a log stands for "no hit" if it occurs at least this often, and in this share of all beams: no
/// two walls are at exactly the same distance.
const FEWEST: usize = 20;
const LEAST_SHARE: f64 = 0.002;

/// The range that stands for "no hit", in meters.
pub(super) fn nothing_hit_from_m(lines: &Lines) -> f64 {
    let most_m = lines.range_max_m.unwrap_or(USUAL_M);
    let ranges_m = || [0, 1].into_iter().flat_map(|laser| lines.scans(laser)).flat_map(|scan| &scan.ranges_m);
    let greatest_m = ranges_m().copied().filter(|range_m| f64::from(*range_m) < most_m).fold(0.0, f32::max);
    let repeated = ranges_m().filter(|range_m| **range_m >= greatest_m && f64::from(**range_m) < most_m).count();
    let often = repeated >= FEWEST && repeated as f64 >= LEAST_SHARE * ranges_m().count() as f64;
    if often { f64::from(greatest_m) } else { most_m }
}
