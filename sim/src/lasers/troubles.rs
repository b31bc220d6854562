//! The combined troubles of a scanner.

use maps::{Pose, pose, wrap_angle};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::{LaserSpec, Streams, normal};

use crate::faults::{LaserFault, LaserTrouble};

/// The combined current troubles of one scanner.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Troubles {
    pub(super) dead: bool,
    pub(super) stuck: bool,
    /// The displacement of the scanner, in the frame of the correctly mounted scanner.
    pub(super) displacement: Option<Pose>,
    ghosts: Vec<Ghost>,
    /// Variance of the errors of ranges, in m².
    variance_m2: f64,
    range_max_m: f64,
    /// Share of the beams with an echo.
    returning: f64,
}

/// An object that does not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ghost {
    distance_m: f64,
    bearing_rad: f64,
    half_width_rad: f64,
}

/// The random numbers for a scanner's troubles.
#[derive(Clone, Debug)]
pub(super) struct TroubleStreams {
    noise: ChaCha8Rng,
    dropout: ChaCha8Rng,
}

impl TroubleStreams {
    /// The streams of the scanner with this name.
    pub(super) fn new(streams: &Streams, laser: &str) -> Self {
        let stream = |trouble: &str| streams.stream(&format!("fault/laser_{laser}_{trouble}"));
        Self { noise: stream("noise"), dropout: stream("dropout") }
    }
}

impl Default for Troubles {
    fn default() -> Self {
        Self {
            dead: false,
            stuck: false,
            displacement: None,
            ghosts: Vec::new(),
            variance_m2: 0.0,
            range_max_m: f64::INFINITY,
            returning: 1.0,
        }
    }
}

impl Troubles {
    /// The troubles of the scanner with this name.
    pub(super) fn of(faults: &[LaserFault], laser: &str) -> Self {
        let mut all = Self::default();
        for fault in faults.iter().filter(|fault| fault.laser.as_deref().is_none_or(|name| name == laser)) {
            all.add(&fault.trouble);
        }
        all
    }

    fn add(&mut self, trouble: &LaserTrouble) {
        match *trouble {
            LaserTrouble::Dead => self.dead = true,
            LaserTrouble::Stuck => self.stuck = true,
            LaserTrouble::Dropout { probability } => self.returning *= 1.0 - probability,
            LaserTrouble::Noise { sigma_m } => self.variance_m2 += sigma_m * sigma_m,
            LaserTrouble::RangeLimit { max_m } => self.range_max_m = self.range_max_m.min(max_m),
            LaserTrouble::Mount { x_m, y_m, yaw_rad } => {
                let displacement = pose(x_m, y_m, yaw_rad);
                self.displacement = Some(self.displacement.map_or(displacement, |before| before * displacement));
            }
            LaserTrouble::Ghost { distance_m, bearing_rad, width_rad } => {
                self.ghosts.push(Ghost { distance_m, bearing_rad, half_width_rad: 0.5 * width_rad });
            }
        }
    }

    /// Shortens the distances of the beams that see a ghost.
    pub(super) fn see_ghosts(&self, spec: &LaserSpec, distances_m: &mut [f64]) {
        for ghost in &self.ghosts {
            for (index, distance_m) in distances_m.iter_mut().enumerate() {
                if wrap_angle(spec.beam_angle_rad(index) - ghost.bearing_rad).abs() <= ghost.half_width_rad {
                    *distance_m = distance_m.min(ghost.distance_m);
                }
            }
        }
    }

    /// Applies the troubles to measured distances. Every beam draws, whatever it hits.
    pub(super) fn spoil(&self, streams: &mut TroubleStreams, distances_m: &mut [f64]) {
        if self.variance_m2 > 0.0 {
            let sigma_m = self.variance_m2.sqrt();
            distances_m.iter_mut().for_each(|distance_m| *distance_m += sigma_m * normal(&mut streams.noise));
        }
        if self.range_max_m < f64::INFINITY {
            let is_too_far = |distance_m: &&mut f64| **distance_m > self.range_max_m;
            distances_m.iter_mut().filter(is_too_far).for_each(|distance_m| *distance_m = f64::INFINITY);
        }
        if self.returning < 1.0 {
            for distance_m in distances_m {
                if streams.dropout.random::<f64>() >= self.returning {
                    *distance_m = f64::INFINITY;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use robot::RobotModel;

    use super::*;

    fn of(troubles: &[LaserTrouble]) -> Troubles {
        let faults: Vec<_> = troubles.iter().map(|trouble| LaserFault { laser: None, trouble: *trouble }).collect();
        Troubles::of(&faults, "front")
    }

    fn spoilt(troubles: &[LaserTrouble], mut distances_m: Vec<f64>) -> Vec<f64> {
        of(troubles).spoil(&mut TroubleStreams::new(&Streams::new(3), "front"), &mut distances_m);
        distances_m
    }

    #[test]
    fn only_faults_of_this_scanner_and_of_all_of_them_count() {
        let dead = |laser: Option<&str>| LaserFault { laser: laser.map(str::to_owned), trouble: LaserTrouble::Dead };
        assert!(Troubles::of(&[dead(Some("front"))], "front").dead);
        assert!(Troubles::of(&[dead(None)], "front").dead);
        assert_eq!(Troubles::of(&[dead(Some("back"))], "front"), Troubles::default());
    }

    #[test]
    fn troubles_accumulate() {
        let errors_m =
            spoilt(&[LaserTrouble::Noise { sigma_m: 0.03 }, LaserTrouble::Noise { sigma_m: 0.04 }], vec![0.0; 50_000]);
        let sigma_m = (errors_m.iter().map(|error_m| error_m * error_m).sum::<f64>() / 50_000.0).sqrt();
        assert!((sigma_m - 0.05).abs() < 5e-4, "{sigma_m}");
        let half = LaserTrouble::Dropout { probability: 0.5 };
        let left = spoilt(&[half, half], vec![2.0; 50_000]).iter().filter(|range_m| range_m.is_finite()).count();
        assert!((left as f64 / 50_000.0 - 0.25).abs() < 0.01, "{left}");
        let mounts = [LaserTrouble::Mount { x_m: 0.1, y_m: 0.0, yaw_rad: 0.2 }; 2];
        assert_eq!(of(&mounts).displacement, Some(pose(0.1, 0.0, 0.2) * pose(0.1, 0.0, 0.2)));
        let limits = [LaserTrouble::RangeLimit { max_m: 3.0 }, LaserTrouble::RangeLimit { max_m: 2.0 }];
        assert_eq!(spoilt(&limits, vec![1.0, 2.0, 2.5, 3.5]), [1.0, 2.0, f64::INFINITY, f64::INFINITY]);
    }

    #[test]
    fn a_ghost_behind_the_scanner_is_seen_by_the_first_and_last_beams() {
        let spec = LaserSpec {
            angle_min_rad: -std::f64::consts::PI,
            angle_increment_rad: std::f64::consts::FRAC_PI_4,
            beams: 8,
            ..RobotModel::default().lasers[0].clone()
        };
        let mut distances_m = vec![5.0; 8];
        let ghost = LaserTrouble::Ghost { distance_m: 1.0, bearing_rad: 3.1, width_rad: 1.7 };
        of(&[ghost]).see_ghosts(&spec, &mut distances_m);
        assert_eq!(distances_m, [1.0, 1.0, 5.0, 5.0, 5.0, 5.0, 5.0, 1.0]);
    }

    proptest! {
        #[test]
        fn a_ghost_does_not_hide_nearer_objects(
            distance_m in 0.0..12.0_f64, bearing_rad in -4.0..4.0_f64, width_rad in 0.0..6.3_f64,
            before_m in prop::collection::vec(0.0..12.0_f64, 360)
        ) {
            let spec = &RobotModel::default().lasers[0];
            let mut after_m = before_m.clone();
            of(&[LaserTrouble::Ghost { distance_m, bearing_rad, width_rad }]).see_ghosts(spec, &mut after_m);
            for (before_m, after_m) in before_m.iter().zip(&after_m) {
                prop_assert!(after_m == before_m || (*after_m == distance_m && after_m < before_m));
            }
        }

        #[test]
        fn a_scanner_without_troubles_changes_nothing_and_draws_nothing(distances_m in prop::collection::vec(0.0..12.0_f64, 40)) {
            let mut streams = TroubleStreams::new(&Streams::new(3), "front");
            let mut after_m = distances_m.clone();
            Troubles::default().see_ghosts(&RobotModel::default().lasers[0], &mut after_m);
            Troubles::default().spoil(&mut streams, &mut after_m);
            prop_assert_eq!(after_m, distances_m);
            let fresh = TroubleStreams::new(&Streams::new(3), "front");
            prop_assert_eq!((streams.noise, streams.dropout), (fresh.noise, fresh.dropout));
        }
    }
}
