//! Checks whether scans are possible from the believed pose, even with unmapped obstacles.
//!
//! People, boxes and closed doors make beams shorter than the map predicts, never longer. So beams that pass through
//! walls of the map show that the robot is elsewhere. A crowd does not: if nearly all beams are short, the map is
//! hidden, and the scan is neither for nor against the pose. A conclusion takes several looks in a row, some time
//! apart.
//!
//! # The numbers
//! They were chosen. To see what they decide, each was halved and doubled (shares as far as they can be), and the
//! drives of `nav/tests/drives` repeated. Four matter there; with all others, every drive ended as before:
//!
//! | changed | what then fails |
//! |---|---|
//! | `MOST_THROUGH` 0.3 | a robot that was carried away does not notice |
//! | `THROUGH_M` 0.2 | unmapped furniture disturbs the tracking |
//! | `MOST_EXACT` 0.7, `EXACT_M` 0.3 | doors that close around a robot move its pose |
//! | `MOST_EXACT` 0.95 | a robot that was carried into a small, changed room is not found |

use std::time::Duration;

use maps::OccupancyGrid;

use crate::atlas::rays::{Expected, Ray, expected};
use crate::particle::{Gaussian, Particle};

/// Time between two looks.
const PERIOD: Duration = Duration::from_secs(1);

/// A beam passes through a wall if it ends this far behind it, in meters, or by this share of the distance to it: small
/// heading errors, or walls at a flat angle, cause smaller differences.
const THROUGH_M: f64 = 0.4;
const THROUGH_SHARE: f64 = 0.1;

/// A beam ends exactly at a wall if it does so within this distance, in meters, or within this share of its length.
const EXACT_M: f64 = 0.15;
const EXACT_SHARE: f64 = 0.05;

/// The pose is contradicted if this share of the beams passes through walls.
const MOST_THROUGH: f64 = 0.15;

/// The map is hidden if less than this share of beams ends at its walls or behind them: with a small pose error, some
/// are too long. If more than the other share ends near walls, the scan fits.
const FEWEST_AT_WALLS: f64 = 0.1;
const MOST_AT_WALLS: f64 = 0.5;

/// The scan is possible only from there, with or without a crowd, if this share of the beams ends exactly at walls.
const MOST_EXACT: f64 = 0.85;

/// Fewer beams are not conclusive.
const FEWEST_BEAMS: usize = 20;

/// A beam that hits nothing was free for this share of the laser's range.
const SILENT_SHARE: f64 = 0.9;

/// The cost of a beam that is too short, and of one that is too long, in nats. A crowd hides many beams at once, so
/// each of them costs little; a stray beam costs as much as in the sensor model.
const SHORT_NATS: f64 = 0.5;
const LONG_NATS: f64 = 4.5;

/// The recent looks of scans from a pose.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contradiction {
    last_look: Option<Duration>,
    last_verdict: Option<Verdict>,
    through: u32,
    short: u32,
    fits: u32,
}

/// The verdict of a scan on a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Beams pass through walls: the robot is elsewhere.
    Through,
    /// Nearly all beams are too short: the map is hidden, or the robot elsewhere.
    Hidden,
    /// Neither of these, but few beams end where the map predicts.
    Unclear,
    /// The map is seen as expected.
    Fits,
}

impl Contradiction {
    /// Whether it is time for another look.
    pub(crate) fn is_due(&self, now: Duration) -> bool {
        // A look is also due after the clock was set back.
        self.last_look.is_none_or(|last| now.checked_sub(last).is_none_or(|passed| passed >= PERIOD))
    }

    /// Records the verdict of a look. A look at a hidden map does not change the count of looks through walls.
    pub(crate) fn take_in(&mut self, now: Duration, verdict: Verdict) {
        let fits = if verdict == Verdict::Fits { self.fits + 1 } else { 0 };
        let (through, short) = match verdict {
            Verdict::Through => (self.through + 1, self.short + 1),
            Verdict::Hidden => (self.through, self.short + 1),
            Verdict::Unclear | Verdict::Fits => (0, 0),
        };
        *self = Self { last_look: Some(now), last_verdict: Some(verdict), through, short, fits };
    }

    /// Whether the map was hidden at the last look.
    pub(crate) fn is_map_hidden(&self) -> bool {
        self.last_verdict == Some(Verdict::Hidden)
    }

    /// The number of looks in which beams passed through walls, since the map was last seen.
    pub(crate) fn looks_through(&self) -> u32 {
        self.through
    }

    /// The number of looks in a row that did not see the map.
    pub(crate) fn looks_without_map(&self) -> u32 {
        self.short
    }

    /// The number of looks in a row that fitted.
    pub(crate) fn looks_that_fit(&self) -> u32 {
        self.fits
    }

    /// Forgets all looks.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// The ends of a scan's beams, seen from a pose.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Look {
    beams: usize,
    through: usize,
    at_walls: usize,
    exact: usize,
    /// Longer than exact.
    long: usize,
}

/// The meaning of beams that hit nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Silent {
    /// None, since lasers fail and glass is invisible.
    TellNothing,
    /// Free space, nearly to the end of the laser's range.
    AreFree,
}

impl Look {
    /// Checks rays (each with its length, in the robot's frame) from a pose in the grid's frame.
    pub(crate) fn from(map: &OccupancyGrid, at: &Gaussian, rays: &[Ray], silent: Silent) -> Self {
        let at = Particle::new(at.x_m, at.y_m, at.heading_rad);
        let mut look = Self::default();
        for ray in rays.iter().filter(|ray| ray.range_m.is_finite() || silent == Silent::AreFree) {
            look.add(map, &at, ray);
        }
        look
    }

    fn add(&mut self, map: &OccupancyGrid, at: &Particle, ray: &Ray) {
        let is_silent = ray.range_m.is_infinite();
        let range_m = f64::from(if is_silent { ray.range_max_m * SILENT_SHARE as f32 } else { ray.range_m });
        let behind_m = |wall_m: f64| THROUGH_M.max(THROUGH_SHARE * wall_m);
        let (from, direction) = seen_from(at, ray);
        // Looks only as far as needed to see whether the beam ends at the next wall or before it.
        let reach_m = if is_silent { range_m } else { range_m + behind_m(range_m) };
        match expected(map, from, direction, reach_m) {
            Expected::Wall(wall_m) if range_m > wall_m + behind_m(wall_m) => {
                (self.through, self.long) = (self.through + 1, self.long + 1);
            }
            Expected::Wall(wall_m) => {
                self.at_walls += 1;
                let about_m = EXACT_M.max(EXACT_SHARE * wall_m);
                self.exact += usize::from(!is_silent && (range_m - wall_m).abs() <= about_m);
                self.long += usize::from(range_m > wall_m + about_m);
            }
            Expected::Unknown(unknown_m) if unknown_m < range_m => return,
            Expected::Unknown(_) | Expected::Nothing if !is_silent => {}
            Expected::Unknown(_) | Expected::Nothing => {
                (self.at_walls, self.exact) = (self.at_walls + 1, self.exact + 1)
            }
        }
        self.beams += 1;
    }

    pub(crate) fn verdict(&self) -> Verdict {
        match () {
            () if self.beams < FEWEST_BEAMS => Verdict::Unclear,
            () if self.share(self.through) >= MOST_THROUGH => Verdict::Through,
            () if self.share(self.exact + self.long) < FEWEST_AT_WALLS => Verdict::Hidden,
            () if self.share(self.at_walls) >= MOST_AT_WALLS => Verdict::Fits,
            () => Verdict::Unclear,
        }
    }

    /// Whether it is more likely that the robot is elsewhere than that the map is hidden.
    pub(crate) fn contradicts(&self) -> bool {
        matches!(self.verdict(), Verdict::Through | Verdict::Hidden)
    }

    /// Whether nearly all beams end exactly where the map predicts.
    pub(crate) fn is_exact(&self) -> bool {
        self.beams >= FEWEST_BEAMS && self.share(self.exact) >= MOST_EXACT
    }

    /// The log-likelihood per beam, in nats, 0 at best. Short beams cost little.
    pub(crate) fn nats_a_beam(&self) -> f64 {
        let short = self.beams - self.exact - self.long;
        -(SHORT_NATS * self.share(short) + LONG_NATS * self.share(self.long))
    }

    fn share(&self, count: usize) -> f64 {
        count as f64 / self.beams.max(1) as f64
    }
}

/// The origin and direction of a ray, in the grid's frame.
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
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    use super::*;

    /// A hall of 10 m × 6 m with a wall of 0.1 m around it and a room of 2 m × 6 m beside it.
    fn hall() -> OccupancyGrid {
        let mut map = OccupancyGrid::new(246, 124, 0.05, pose(0.0, 0.0, 0.0));
        for index in (0..124).flat_map(|row| (0..246).map(move |column| CellIndex { column, row })) {
            let wall = [0, 1, 202, 203, 244, 245].contains(&index.column) || [0, 1, 122, 123].contains(&index.row);
            map.set(index, if wall { Cell::Occupied } else { Cell::Free });
        }
        map
    }

    fn gaussian(x_m: f64, y_m: f64, heading_rad: f64) -> Gaussian {
        Gaussian { x_m, y_m, heading_rad, covariance: Matrix3::zeros() }
    }

    fn verdict(at: &Gaussian, rays: &[Ray], silent: Silent) -> Verdict {
        Look::from(&hall(), at, rays, silent).verdict()
    }

    /// The rays from a place; `are_hidden` of every ten are cut short.
    fn seen(from: &Particle, are_hidden: usize) -> Vec<Ray> {
        let map = hall();
        let ray = |beam: usize| {
            let (sin, cos) = libm::sincos(beam as f64 * 0.1);
            let ray = Ray { eye: [0.0, 0.0], direction: [cos as f32, sin as f32], range_m: 0.0, range_max_m: 10.0 };
            let (at, direction) = seen_from(from, &ray);
            let Expected::Wall(range_m) = expected(&map, at, direction, 20.0) else { panic!("the hall is closed") };
            let hidden = beam % 10 < are_hidden;
            Ray { range_m: if hidden { 0.4 } else { range_m as f32 }, ..ray }
        };
        (0..62).map(ray).collect()
    }

    proptest! {
        #[test]
        fn neither_a_crowd_nor_a_small_pose_error_contradicts_a_pose(
            x in 1.0..9.0_f64, y in 1.0..5.0_f64, off in -0.1..0.1_f64, turn in -0.04..0.04_f64, hidden in 0_usize..=10,
        ) {
            let rays = seen(&Particle::new(x, y, 0.3), hidden);
            let verdict = verdict(&gaussian(x + off, y - off, 0.3 + turn), &rays, Silent::TellNothing);
            prop_assert_ne!(verdict, Verdict::Through);
            prop_assert_eq!(verdict == Verdict::Hidden, hidden >= 9, "a tenth of the beams is not enough");
            prop_assert_eq!(verdict == Verdict::Fits, hidden <= 4);
        }

        #[test]
        fn beams_through_walls_contradict_a_pose(x in 3.0..7.0_f64, y in 1.0..5.0_f64, there in 10.8..11.6_f64) {
            let rays = seen(&Particle::new(x, y, 0.3), 0);
            prop_assert_eq!(verdict(&gaussian(there, y, 0.3), &rays, Silent::TellNothing), Verdict::Through);
        }

        #[test]
        fn only_scans_from_the_same_place_are_exact(x in 1.0..9.0_f64, y in 1.0..5.0_f64, hidden in 0_usize..=10) {
            let rays = seen(&Particle::new(x, y, 0.3), hidden);
            let look = |x, y| Look::from(&hall(), &gaussian(x, y, 0.3), &rays, Silent::AreFree);
            prop_assert_eq!(look(x, y).is_exact(), hidden <= 1);
            prop_assert!(!look(x + 0.5, y + 0.5).is_exact());
        }
    }

    #[test]
    fn one_look_is_not_enough_and_a_fitting_look_resets_the_count() {
        use Verdict::{Fits, Hidden, Through};
        let mut contradiction = Contradiction::default();
        let mut look = |second, verdict| {
            let now = Duration::from_secs(second);
            assert!(contradiction.is_due(now));
            contradiction.take_in(now, verdict);
            (contradiction.looks_through(), contradiction.looks_without_map(), contradiction.looks_that_fit())
        };
        let verdicts = [Through, Hidden, Through, Fits, Fits, Hidden];
        let counts: Vec<_> = (1..).zip(verdicts).map(|(second, verdict)| look(second, verdict)).collect();
        assert_eq!(counts, [(1, 1, 0), (1, 2, 0), (2, 3, 0), (0, 0, 1), (0, 0, 2), (0, 1, 0)]);
    }

    #[test]
    fn few_beams_are_not_conclusive() {
        let rays = seen(&Particle::new(5.0, 3.0, 0.3), 0);
        let verdict = verdict(&gaussian(11.2, 3.0, 0.3), &rays[..FEWEST_BEAMS - 1], Silent::TellNothing);
        assert_eq!(verdict, Verdict::Unclear);
    }

    #[test]
    fn short_beams_cost_a_pose_much_less_than_beams_through_walls() {
        let here = Particle::new(5.0, 3.0, 0.3);
        let nats =
            |at: &Gaussian, hidden| Look::from(&hall(), at, &seen(&here, hidden), Silent::TellNothing).nats_a_beam();
        let at = gaussian(5.0, 3.0, 0.3);
        assert_eq!(nats(&at, 0), 0.0);
        assert!((nats(&at, 10) + SHORT_NATS).abs() < 1e-9);
        assert!(nats(&gaussian(11.2, 3.0, 0.3), 0) < 4.0 * nats(&at, 10));
    }

    #[test]
    fn beams_that_hit_nothing_count_only_on_request() {
        let here = gaussian(5.0, 3.0, 0.3);
        let silent = |range_max_m| -> Vec<Ray> {
            let rays = seen(&Particle::new(5.0, 3.0, 0.3), 0).into_iter();
            rays.map(|ray| Ray { range_m: f32::INFINITY, range_max_m, ..ray }).collect()
        };
        assert_eq!(verdict(&here, &silent(10.0), Silent::TellNothing), Verdict::Unclear);
        assert_eq!(verdict(&here, &silent(10.0), Silent::AreFree), Verdict::Through);
        assert_eq!(verdict(&here, &silent(1.6), Silent::AreFree), Verdict::Fits, "no obstacle was expected");
    }
}
