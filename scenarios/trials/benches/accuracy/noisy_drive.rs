//! The accuracy of localization on a simulated drive of about 50 m, with inaccurate odometry and lasers.

use std::sync::Arc;

use maps::{Place, Point, Pose, heading, pose, wrap_angle};
use nalgebra::{Matrix3, Vector3};
use nav::{Atlas, InitialPose, Localization, LocalizationParameters};
use rand::RngExt;
use robot::{Reading, RobotModel, Streams};
use sim::{DriftNoise, LaserConfig, OdometryConfig, SimConfig};

use crate::drive::{Drive, route};

/// Distance between the true pose and the initial pose given to localization, in meters.
const INITIAL_OFFSET_M: f64 = 0.2;

/// Standard deviation of a range, in meters.
const LASER_SIGMA_M: f64 = 0.01;

/// The results of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Accuracy {
    /// The distance driven, in meters.
    pub(crate) driven_m: f64,
    /// Error of odometry at the end, in meters.
    pub(crate) odometry_off_m: f64,
    /// Error of its heading, in radians.
    pub(crate) odometry_off_rad: f64,
    /// Root mean square of the distances between estimates and truth, over all scans, in meters.
    pub(crate) rmse_m: f64,
    /// The same for headings, in radians.
    pub(crate) rmse_rad: f64,
    /// The greatest distance, in meters.
    pub(crate) max_m: f64,
    /// Mean of the squared errors in units of the estimate's own covariance. Three is ideal; a larger number means that
    /// the estimate is overconfident, a smaller one that it is underconfident.
    pub(crate) normalized_squared: f64,
    /// How often localization updated its estimate.
    pub(crate) updates: u64,
}

/// The settings of the drive: an odometry that reports 2 % too much distance and drifts slightly to the left, with
/// noise; and lasers with noise.
fn config() -> SimConfig {
    let noise = DriftNoise {
        angle_per_sqrt_rad: 0.01,
        angle_per_sqrt_m: 0.015,
        distance_per_sqrt_m: 0.02,
        distance_per_sqrt_rad: 0.005,
    };
    SimConfig {
        odometry: OdometryConfig {
            noise,
            distance_bias: 0.02,
            angle_bias: 0.01,
            angle_bias_rad_per_m: 0.003,
            ..OdometryConfig::default()
        },
        lasers: LaserConfig { range_sigma_m: LASER_SIGMA_M },
        ..SimConfig::default()
    }
}

/// The map of the drive: the house that comes with the project.
pub(crate) fn floor() -> Arc<Atlas> {
    let atlas = Atlas::new(Arc::new(maps::house::map()), &RobotModel::default(), LocalizationParameters::default());
    Arc::new(atlas.expect("the house has free floor"))
}

/// The path of the drive: from the start to the kitchen, and back via the charging station.
fn path(atlas: &Atlas) -> Vec<Point> {
    let places = maps::house::places();
    let at = |name: &str| places.get(name).map(Place::goal_position).expect("the house has that place");
    let stops = ["start", "Destination", "RechargingStation", "start"].map(at);
    route(atlas, &stops).expect("all places of the house can be reached")
}

/// Drives and localizes with the random numbers of a root seed. `update` is called for every reading and may measure
/// its time.
pub(crate) fn drive(atlas: &Arc<Atlas>, seed: u64, mut update: impl FnMut(&mut Localization, &Reading)) -> Accuracy {
    let streams = Streams::new(seed);
    let mut drive = Drive::along(path(atlas), atlas.map(), &config(), &streams).expect("the path begins on free floor");
    let initial = offset(&drive.sim.truth().pose(), &streams);
    let mut localization = Localization::on(atlas, &initial, streams.stream("nav/localization"));
    let mut sums = Sums::default();
    let mut readings = Vec::new();
    let (first, mut odometry_first, mut odometry_last) = (drive.sim.truth().pose(), None, Pose::identity());
    while let Some(truth) = drive.step(&mut readings) {
        let mut has_scan = false;
        for reading in readings.drain(..) {
            if let Reading::Odometry(odometry) = &reading {
                odometry_last = odometry.pose;
                odometry_first.get_or_insert(odometry.pose);
            }
            has_scan |= matches!(reading, Reading::Scan(_));
            update(&mut localization, &reading);
        }
        if has_scan {
            sums.add(&truth, &localization);
        }
    }
    // Where odometry alone would have led: its motion, beginning at the true first pose.
    let odometry = first * odometry_first.unwrap_or_default().inv_mul(&odometry_last);
    let truth = drive.sim.truth();
    let off = truth.pose().inv_mul(&odometry);
    Accuracy {
        driven_m: truth.distance_m(),
        odometry_off_m: off.translation.vector.norm(),
        odometry_off_rad: heading(&off).abs(),
        updates: localization.updates(),
        ..sums.accuracy()
    }
}

/// An initial pose with this error, in a random direction.
fn offset(truth: &Pose, streams: &Streams) -> InitialPose {
    let direction = streams.stream("accuracy/offset").random::<f64>() * std::f64::consts::TAU;
    let (sin, cos) = libm::sincos(direction);
    let off = pose(INITIAL_OFFSET_M * cos, INITIAL_OFFSET_M * sin, 0.0);
    let variance = INITIAL_OFFSET_M * INITIAL_OFFSET_M;
    InitialPose::Near { pose: truth * off, covariance: Matrix3::from_diagonal(&Vector3::new(variance, variance, 0.01)) }
}

#[derive(Default)]
struct Sums {
    squared_m2: f64,
    squared_rad2: f64,
    max_m: f64,
    normalized_squared: f64,
    count: f64,
}

impl Sums {
    fn add(&mut self, truth: &Pose, localization: &Localization) {
        let estimate = localization.estimate();
        let offset_m = truth.translation.vector - estimate.pose.translation.vector;
        let turn_rad = wrap_angle(heading(truth) - heading(&estimate.pose));
        let off = offset_m.push(turn_rad);
        self.squared_m2 += offset_m.norm_squared();
        self.squared_rad2 += turn_rad * turn_rad;
        self.max_m = self.max_m.max(offset_m.norm());
        let information = estimate.covariance.try_inverse().unwrap_or_default();
        self.normalized_squared += off.dot(&(information * off));
        self.count += 1.0;
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy {
            rmse_m: (self.squared_m2 / self.count).sqrt(),
            rmse_rad: (self.squared_rad2 / self.count).sqrt(),
            max_m: self.max_m,
            normalized_squared: self.normalized_squared / self.count,
            ..Accuracy::default()
        }
    }
}
