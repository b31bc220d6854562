//! A minimal robot: a unicycle with limited acceleration and ideal lasers by plain ray casting.

use std::time::Duration;

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, heading, pose};
use rand_chacha::ChaCha8Rng;
use robot::{LaserScan, Odometry, RobotModel, Streams, VelocityCommand, normal};

/// Length of a step.
pub(crate) const STEP: Duration = Duration::from_millis(20);

/// Steps between scans.
const SCAN_STEPS: u64 = 5;

/// The errors of odometry and lasers.
#[derive(Clone, Copy, Default)]
pub(crate) struct Noise {
    /// Odometry overestimates distance and turns by this share.
    pub(crate) drift: f64,
    /// Random error, as a share of the motion.
    pub(crate) scatter: f64,
    /// Standard deviation of a range, in meters.
    pub(crate) laser_m: f64,
}

/// The robot and the world that it is in.
pub(crate) struct Unicycle {
    pub(crate) model: RobotModel,
    pub(crate) world: OccupancyGrid,
    pub(crate) truth: Pose,
    pub(crate) time: Duration,
    pub(crate) driven_m: f64,
    pub(crate) velocity: VelocityCommand,
    odometry: Pose,
    pub(crate) noise: Noise,
    rng: ChaCha8Rng,
    steps: u64,
}

impl Unicycle {
    pub(crate) fn new(world: OccupancyGrid, truth: Pose, noise: Noise) -> Self {
        Self {
            model: RobotModel::default(),
            world,
            truth,
            time: Duration::ZERO,
            driven_m: 0.0,
            velocity: VelocityCommand::STOP,
            // Odometry starts anywhere.
            odometry: pose(3.0, -1.0, 2.0),
            noise,
            rng: Streams::new(11).stream("unicycle"),
            steps: 0,
        }
    }

    /// Drives for a step towards the commanded velocity.
    pub(crate) fn step(&mut self, command: VelocityCommand) {
        let dt = STEP.as_secs_f64();
        let towards = |now: f64, wanted: f64, most: f64, rate: f64| {
            now + (wanted.clamp(-most, most) - now).clamp(-rate * dt, rate * dt)
        };
        let model = &self.model;
        self.velocity = VelocityCommand {
            linear_mps: towards(
                self.velocity.linear_mps,
                command.linear_mps,
                model.max_linear_mps,
                model.max_linear_acceleration_mps2,
            ),
            angular_radps: towards(
                self.velocity.angular_radps,
                command.angular_radps,
                model.max_angular_radps,
                model.max_angular_acceleration_radps2,
            ),
        };
        let (way, turn) = (self.velocity.linear_mps * dt, self.velocity.angular_radps * dt);
        self.truth *= arc(way, turn);
        let mut lie = || 1.0 + self.noise.drift + self.noise.scatter * normal(&mut self.rng);
        let (way_lie, turn_lie) = (lie(), lie());
        // Driving straight makes odometry turn, too.
        self.odometry *= arc(way * way_lie, turn * turn_lie + way * 0.2 * (turn_lie - 1.0));
        self.driven_m += way.abs();
        self.time += STEP;
        self.steps += 1;
    }

    pub(crate) fn odometry(&self) -> Odometry {
        let VelocityCommand { linear_mps, angular_radps } = self.velocity;
        Odometry { time: self.time, pose: self.odometry, linear_mps, angular_radps }
    }

    /// The scans that are due at this step.
    pub(crate) fn scans(&mut self) -> Vec<LaserScan> {
        if !self.steps.is_multiple_of(SCAN_STEPS) {
            return Vec::new();
        }
        (0..self.model.lasers.len()).map(|laser| self.scan(laser)).collect()
    }

    /// The distance between the robot's body and the nearest wall; negative means a collision.
    pub(crate) fn clearance_m(&self) -> f64 {
        let center = self.world.to_grid(&self.truth.translation.vector.into());
        let reach = 20;
        let (column, row) = (center.x as i64, center.y as i64);
        let mut nearest = f64::INFINITY;
        for r in row - reach..=row + reach {
            for c in column - reach..=column + reach {
                if is_occupied(&self.world, c, r) {
                    let dx = (c as f64 - center.x).max(center.x - (c + 1) as f64).max(0.0);
                    let dy = (r as f64 - center.y).max(center.y - (r + 1) as f64).max(0.0);
                    nearest = nearest.min((dx * dx + dy * dy).sqrt());
                }
            }
        }
        nearest * self.world.resolution_m() - self.model.radius_m
    }

    fn scan(&mut self, laser: usize) -> LaserScan {
        let spec = &self.model.lasers[laser];
        let eye = self.truth * spec.mount;
        let ranges_m = (0..spec.beams)
            .map(|beam| {
                let range = cast(&self.world, &eye, spec.beam_angle_rad(beam), spec.range_max_m);
                let range =
                    range + if self.noise.laser_m > 0.0 { self.noise.laser_m * normal(&mut self.rng) } else { 0.0 };
                let nearer = if range < spec.range_min_m { f64::NEG_INFINITY } else { range };
                nearer as f32
            })
            .collect();
        LaserScan { time: self.time, laser, ranges_m }
    }
}

/// The motion along an arc.
fn arc(way_m: f64, turn_rad: f64) -> Pose {
    pose(0.0, 0.0, turn_rad / 2.0) * pose(way_m, 0.0, turn_rad / 2.0)
}

fn is_occupied(map: &OccupancyGrid, column: i64, row: i64) -> bool {
    column >= 0
        && row >= 0
        && map.cell(CellIndex { column: column as usize, row: row as usize }) == Some(Cell::Occupied)
}

/// Distance to the first occupied cell, infinite beyond `range_max_m`.
fn cast(map: &OccupancyGrid, eye: &Pose, angle_rad: f64, range_max_m: f64) -> f64 {
    let start = map.to_grid(&eye.translation.vector.into());
    let direction = angle_rad + heading(eye) - heading(&map.origin());
    let (sin, cos) = libm::sincos(direction);
    let mut cell = [start.x.floor() as i64, start.y.floor() as i64];
    let axis = |along: f64, at: f64, cell: i64| match along {
        0.0 => (0, f64::INFINITY, f64::INFINITY),
        _ if along > 0.0 => (1, ((cell + 1) as f64 - at) / along, 1.0 / along),
        _ => (-1, (cell as f64 - at) / along, -1.0 / along),
    };
    let (step_x, mut next_x, width_x) = axis(cos, start.x, cell[0]);
    let (step_y, mut next_y, width_y) = axis(sin, start.y, cell[1]);
    let most = range_max_m / map.resolution_m();
    let mut way = 0.0;
    while way < most {
        if is_occupied(map, cell[0], cell[1]) {
            return way * map.resolution_m();
        }
        if next_x < next_y {
            (way, next_x, cell[0]) = (next_x, next_x + width_x, cell[0] + step_x);
        } else {
            (way, next_y, cell[1]) = (next_y, next_y + width_y, cell[1] + step_y);
        }
    }
    f64::INFINITY
}

/// Drives along a polyline by plain pure pursuit with a given pose, for tests of localization alone.
pub(crate) fn towards(path: &[Point], next: &mut usize, at: &Pose) -> VelocityCommand {
    while *next < path.len() && (path[*next] - Point::from(at.translation.vector)).norm() < 0.3 {
        *next += 1;
    }
    let Some(target) = path.get(*next) else { return VelocityCommand::STOP };
    let seen = at.inverse_transform_point(target);
    let bearing = libm::atan2(seen.y, seen.x);
    let linear_mps = if bearing.abs() > 0.5 { 0.0 } else { 0.45 };
    VelocityCommand { linear_mps, angular_radps: (2.0 * bearing).clamp(-1.0, 1.0) }
}
