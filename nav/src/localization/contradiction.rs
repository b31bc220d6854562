//! Whether scans can have been seen from where the robot is believed to be, whoever stands about.
//!
//! People, boxes and closed doors make beams shorter than the map says, never longer. So a crowd may hide the map, but
//! beams that go through its walls say that the robot is somewhere else. It takes several looks in a row, some time
//! apart, to say so.

use std::time::Duration;

use maps::OccupancyGrid;

use super::beam_model::{Expected, Ray, expected};
use super::particle::Particle;

/// Time between two looks.
const PERIOD: Duration = Duration::from_secs(1);

/// So many looks in a row that contradict the pose are enough: of a robot at rest, and of one that drives and may find its
/// way back by itself.
const ENOUGH_AT_REST: u32 = 3;
const ENOUGH_DRIVING: u32 = 6;

/// A beam goes through a wall if it ends so far behind it, in metres, or by this share of the way to it: what a heading
/// that is a little off, or a wall that is seen at a flat angle, makes of it.
const THROUGH_M: f64 = 0.4;
const THROUGH_SHARE: f64 = 0.1;

/// The pose is contradicted if this share of the beams goes through walls, or fewer than the other share end at one.
const MOST_THROUGH: f64 = 0.15;
const FEWEST_AT_WALLS: f64 = 0.1;

/// Fewer beams say nothing.
const FEWEST_BEAMS: usize = 20;

/// How scans have of late contradicted the believed pose.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contradiction {
    last_look: Option<Duration>,
    in_a_row: u32,
}

impl Contradiction {
    /// Whether it is time for another look.
    pub(crate) fn is_due(&self, now: Duration) -> bool {
        // A clock that was set back makes a look due, too.
        self.last_look.is_none_or(|last| now.checked_sub(last).is_none_or(|passed| passed >= PERIOD))
    }

    /// Looks at rays (each with its length, in the robot's frame) from where the robot is believed to be. True if the
    /// robot cannot be there.
    pub(crate) fn look(
        &mut self,
        now: Duration,
        is_at_rest: bool,
        map: &OccupancyGrid,
        at: &Particle,
        rays: &[Ray],
    ) -> bool {
        self.last_look = Some(now);
        self.in_a_row = if contradict(map, at, rays, None) { self.in_a_row + 1 } else { 0 };
        self.in_a_row >= if is_at_rest { ENOUGH_AT_REST } else { ENOUGH_DRIVING }
    }

    /// Forgets what has been seen.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Whether rays cannot have been seen from a pose. Rays that hit nothing have been so long, if `silent_m` is given; else
/// they say nothing, since lasers fail and glass is not seen.
pub(crate) fn contradict(map: &OccupancyGrid, at: &Particle, rays: &[Ray], silent_m: Option<f64>) -> bool {
    let (mut beams, mut through, mut at_walls) = (0, 0, 0);
    for ray in rays {
        let range_m = match silent_m {
            _ if ray.range_m.is_finite() => f64::from(ray.range_m),
            Some(silent_m) => silent_m,
            None => continue,
        };
        let behind_m = |wall_m: f64| THROUGH_M.max(THROUGH_SHARE * wall_m);
        let (from, direction) = seen_from(at, ray);
        match expected(map, from, direction, range_m) {
            Expected::Wall(wall_m) if range_m > wall_m + behind_m(wall_m) => through += 1,
            Expected::Wall(_) => at_walls += 1,
            Expected::Unknown(_) => continue,
            Expected::Nothing if ray.range_m.is_infinite() => at_walls += 1,
            // Does the next wall lie where the beam ends, or was it cut short?
            Expected::Nothing => {
                let reach_m = range_m + behind_m(range_m);
                at_walls += usize::from(matches!(expected(map, from, direction, reach_m), Expected::Wall(_)));
            }
        }
        beams += 1;
    }
    let share = |count: usize| count as f64 / beams as f64;
    beams >= FEWEST_BEAMS && (share(through) >= MOST_THROUGH || share(at_walls) < FEWEST_AT_WALLS)
}

/// Where a ray begins and where it leads, in the grid's frame.
fn seen_from(at: &Particle, ray: &Ray) -> ([f64; 2], [f64; 2]) {
    let turned = |[x, y]: [f32; 2]| {
        let (x, y) = (f64::from(x), f64::from(y));
        [at.cos * x - at.sin * y, at.sin * x + at.cos * y]
    };
    let [x, y] = turned(ray.eye);
    ([at.x_m + x, at.y_m + y], turned(ray.direction))
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, pose};
    use proptest::prelude::*;

    use super::*;

    /// A hall of 10 m × 6 m, a wall of 0.1 m around it, with a room of 2 m × 6 m beside it.
    fn hall() -> OccupancyGrid {
        let mut map = OccupancyGrid::new(246, 124, 0.05, pose(0.0, 0.0, 0.0));
        for index in (0..124).flat_map(|row| (0..246).map(move |column| CellIndex { column, row })) {
            let wall = [0, 1, 202, 203, 244, 245].contains(&index.column) || [0, 1, 122, 123].contains(&index.row);
            map.set(index, if wall { Cell::Occupied } else { Cell::Free });
        }
        map
    }

    /// What is seen around from a place, every third beam cut short if so many of ten `are_hidden`.
    fn seen(from: &Particle, are_hidden: usize) -> Vec<Ray> {
        let map = hall();
        let ray = |beam: usize| {
            let (sin, cos) = libm::sincos(beam as f64 * 0.1);
            let ray = Ray { eye: [0.0, 0.0], direction: [cos as f32, sin as f32], range_m: 0.0 };
            let (at, direction) = seen_from(from, &ray);
            let Expected::Wall(range_m) = expected(&map, at, direction, 20.0) else { panic!("the hall is closed") };
            let hidden = beam % 10 < are_hidden;
            Ray { range_m: if hidden { 0.4 } else { range_m as f32 }, ..ray }
        };
        (0..62).map(ray).collect()
    }

    proptest! {
        #[test]
        fn a_crowd_does_not_contradict_a_pose_nor_does_a_pose_that_is_a_little_off(
            x in 1.0..9.0_f64, y in 1.0..5.0_f64, off in -0.1..0.1_f64, turn in -0.04..0.04_f64, hidden in 0_usize..8,
        ) {
            let rays = seen(&Particle::new(x, y, 0.3), hidden);
            prop_assert!(!contradict(&hall(), &Particle::new(x + off, y - off, 0.3 + turn), &rays, None));
        }

        #[test]
        fn walls_that_are_seen_through_do(x in 3.0..7.0_f64, y in 1.0..5.0_f64, there in 10.8..11.6_f64) {
            let rays = seen(&Particle::new(x, y, 0.3), 0);
            prop_assert!(contradict(&hall(), &Particle::new(there, y, 0.3), &rays, None));
        }
    }

    #[test]
    fn one_look_is_not_enough_and_one_that_fits_begins_anew() {
        let (map, here, there) = (hall(), Particle::new(5.0, 3.0, 0.3), Particle::new(11.2, 3.0, 0.3));
        let rays = seen(&here, 0);
        let mut contradiction = Contradiction::default();
        let mut look = |second, at: &Particle| {
            let now = Duration::from_secs(second);
            assert!(contradiction.is_due(now));
            contradiction.look(now, true, &map, at, &rays)
        };
        let places = [&there, &there, &here, &there, &there, &there];
        let lost: Vec<bool> = (1..).zip(places).map(|(second, at)| look(second, at)).collect();
        assert_eq!(lost, [false, false, false, false, false, true]);
    }

    #[test]
    fn few_beams_say_nothing() {
        let rays = seen(&Particle::new(5.0, 3.0, 0.3), 0);
        assert!(!contradict(&hall(), &Particle::new(11.2, 3.0, 0.3), &rays[..FEWEST_BEAMS - 1], None));
    }

    #[test]
    fn beams_that_hit_nothing_speak_only_if_they_are_asked() {
        let here = Particle::new(5.0, 3.0, 0.3);
        let rays: Vec<Ray> = seen(&here, 0).into_iter().map(|ray| Ray { range_m: f32::INFINITY, ..ray }).collect();
        assert!(!contradict(&hall(), &here, &rays, None));
        assert!(contradict(&hall(), &here, &rays, Some(9.0)));
        assert!(!contradict(&hall(), &here, &rays, Some(1.5)), "nothing was to be hit");
    }
}
