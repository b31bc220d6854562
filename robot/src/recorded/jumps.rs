//! Poses that no robot can have reached since the previous line: errors in the log.

use maps::{Pose, pose};

use super::complaint::{Complaints, Flaw};
use super::lines::LogLine;

/// A jump is at least this long, in meters, and this many times as long as most motions between two lines.
const LEAST_M: f64 = 2.0;
const TIMES: f64 = 5.0;

/// The percentage that counts as "most".
const MOST: usize = 80;

/// Continues odometry from its last position when it jumps: the motion between two such lines is unknown.
pub(super) fn bridge_odometry(lines: &mut [LogLine], complaints: &mut Complaints) {
    let jump_m = jump_m(lines.iter().map(|line| line.odometry));
    let mut bridge = pose(0.0, 0.0, 0.0);
    let mut before: Option<Pose> = None;
    for line in lines {
        let raw = line.odometry;
        if let Some(before) = before {
            let by_m = distance_m(&before, &raw);
            if by_m > jump_m {
                complaints.add(line.number, Flaw::OdometryJumps { by_m });
                bridge = bridge * before * raw.inverse();
            }
        }
        before = Some(raw);
        line.odometry = bridge * raw;
    }
}

/// Leaves out corrected poses that are far from both the previous and the next one while those are near each other.
pub(super) fn leave_out_stray_poses(lines: &mut [LogLine], complaints: &mut Complaints) {
    let jump_m = jump_m(lines.iter().filter_map(|line| line.corrected));
    let known: Vec<usize> = (0..lines.len()).filter(|index| lines[*index].corrected.is_some()).collect();
    let mut kept: Option<Pose> = None;
    for (place, index) in known.iter().enumerate() {
        let Some(here) = lines[*index].corrected else { continue };
        let after = known.get(place + 1).and_then(|after| lines[*after].corrected);
        if let (Some(before), Some(after)) = (kept, after) {
            let by_m = distance_m(&before, &here);
            if by_m > jump_m && distance_m(&here, &after) > jump_m && distance_m(&before, &after) <= 2.0 * jump_m {
                complaints.add(lines[*index].number, Flaw::StrayPose { by_m });
                lines[*index].corrected = None;
                continue;
            }
        }
        kept = Some(here);
    }
}

/// The distance, in meters, from which a motion between two poses counts as a jump.
fn jump_m(poses: impl Iterator<Item = Pose>) -> f64 {
    let poses: Vec<Pose> = poses.collect();
    let mut ways_m: Vec<f64> = poses.windows(2).map(|pair| distance_m(&pair[0], &pair[1])).collect();
    ways_m.sort_unstable_by(f64::total_cmp);
    let usual_m = ways_m.get(ways_m.len().saturating_sub(1) * MOST / 100).copied().unwrap_or_default();
    LEAST_M.max(TIMES * usual_m)
}

fn distance_m(from: &Pose, to: &Pose) -> f64 {
    (to.translation.vector - from.translation.vector).norm()
}
