//! The beam sensor model.
//!
//! A beam is likely if its length is near the distance to the first obstacle on the map. It may be shorter, because of
//! something that is not on the map; it may hit nothing; it may have any length. If it enters unknown cells before any
//! obstacle, the map does not predict its length, and all longer lengths are equally likely: neither as good as a hit
//! nor as bad as a miss.
//!
//! It casts one ray per beam and particle, which takes about thirty times as long as the likelihood field. Its
//! advantage is that it considers walls between the robot and the end of a beam.
//!
//! The beams' likelihoods are multiplied, as probabilities are, and the product is tempered by `independent_beams`.
//! Nav2's beam model adds the cubes of the likelihoods instead, as its likelihood field does.
//!
//! Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", MIT Press 2005, table 6.1.

use maps::{Cell, CellIndex, OccupancyGrid};

use super::LocalizationParameters;
use crate::particle::Particle;

/// A beam in the robot's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    /// Where it starts, in meters.
    pub(crate) eye: [f32; 2],
    /// Its direction, of length one.
    pub(crate) direction: [f32; 2],
    /// Its length in meters; infinite if it hit nothing.
    pub(crate) range_m: f32,
    /// The maximum range of its laser, in meters.
    pub(crate) range_max_m: f32,
}

/// The length of a ray according to the map, in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Expected {
    /// It ends at an obstacle.
    Wall(f64),
    /// It enters unknown cells before any obstacle.
    Unknown(f64),
    /// It hits nothing within range.
    Nothing,
}

/// The mixture of reasons for a beam's length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BeamModel {
    z_hit: f64,
    z_short: f64,
    z_max: f64,
    z_rand: f64,
    sigma_hit: f64,
    lambda_short: f64,
}

impl BeamModel {
    pub(crate) fn new(parameters: &LocalizationParameters) -> Self {
        Self {
            z_hit: parameters.z_hit,
            z_short: parameters.z_short,
            z_max: parameters.z_max,
            z_rand: parameters.z_rand,
            sigma_hit: parameters.sigma_hit,
            lambda_short: parameters.lambda_short,
        }
    }

    /// The log-likelihood of the rays, seen from a particle: a sum over all of them, in nats.
    pub(crate) fn nats(&self, map: &OccupancyGrid, particle: &Particle, rays: &[Ray]) -> f64 {
        let of = |ray: &Ray| {
            let turned = |[x, y]: [f32; 2]| {
                let (x, y) = (f64::from(x), f64::from(y));
                [particle.cos * x - particle.sin * y, particle.sin * x + particle.cos * y]
            };
            let eye = turned(ray.eye);
            let from = [particle.x_m + eye[0], particle.y_m + eye[1]];
            let expected = expected(map, from, turned(ray.direction), f64::from(ray.range_max_m));
            libm::log(self.likelihood(ray, expected))
        };
        rays.iter().map(of).sum()
    }

    /// The likelihood of a ray's length: a density per meter, but a probability if nothing was hit.
    fn likelihood(&self, ray: &Ray, expected: Expected) -> f64 {
        let (range_m, range_max_m) = (f64::from(ray.range_m), f64::from(ray.range_max_m));
        if range_m >= range_max_m {
            return match expected {
                Expected::Wall(_) => self.z_max,
                Expected::Unknown(_) => self.z_max + 0.5 * self.z_hit,
                Expected::Nothing => self.z_max + self.z_hit,
            };
        }
        let stray = self.z_rand / range_max_m;
        let short = self.z_short * self.lambda_short * libm::exp(-self.lambda_short * range_m);
        match expected {
            Expected::Wall(wall_m) => {
                let deviations = (range_m - wall_m) / self.sigma_hit;
                let hit = self.z_hit * libm::exp(-0.5 * deviations * deviations);
                if range_m < wall_m { hit + short + stray } else { hit + stray }
            }
            Expected::Unknown(unknown_m) if range_m >= unknown_m => stray + self.z_hit / range_max_m,
            Expected::Unknown(_) | Expected::Nothing => short + stray,
        }
    }
}

/// The length of a ray according to the map, from a point of the grid's frame, in meters, in a direction of length one.
///
/// Source: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987.
pub(crate) fn expected(map: &OccupancyGrid, from: [f64; 2], direction: [f64; 2], range_max_m: f64) -> Expected {
    let resolution_m = map.resolution_m();
    let at = from.map(|meters| meters / resolution_m);
    let mut cell = at.map(|cells| cells.floor() as i64);
    let axis = |along: f64, at: f64, cell: i64| match along {
        0.0 => (0, f64::INFINITY, f64::INFINITY),
        _ if along > 0.0 => (1, ((cell + 1) as f64 - at) / along, 1.0 / along),
        _ => (-1, (cell as f64 - at) / along, -1.0 / along),
    };
    // By axis: the direction of the next cell, the way to its border, and the way from one border to the next. The way
    // is in cells along the ray, since the direction has length one.
    let (step_x, mut next_x, width_x) = axis(direction[0], at[0], cell[0]);
    let (step_y, mut next_y, width_y) = axis(direction[1], at[1], cell[1]);
    let mut way = 0.0;
    while way * resolution_m < range_max_m {
        match cell_at(map, cell) {
            Cell::Free => {}
            Cell::Occupied => return Expected::Wall(way * resolution_m),
            Cell::Unknown => return Expected::Unknown(way * resolution_m),
        }
        if next_x < next_y {
            (way, next_x, cell[0]) = (next_x, next_x + width_x, cell[0] + step_x);
        } else {
            (way, next_y, cell[1]) = (next_y, next_y + width_y, cell[1] + step_y);
        }
    }
    Expected::Nothing
}

fn cell_at(map: &OccupancyGrid, [column, row]: [i64; 2]) -> Cell {
    match (usize::try_from(column), usize::try_from(row)) {
        (Ok(column), Ok(row)) => map.cell(CellIndex { column, row }).unwrap_or_default(),
        _ => Cell::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    /// Free from x = 1 m to 4 m; a wall on the right, unknown space on the left and all around.
    fn map() -> OccupancyGrid {
        let mut map = OccupancyGrid::new(60, 40, 0.1, pose(0.0, 0.0, 0.0));
        for row in 5..35 {
            (10..40).for_each(|column| map.set(CellIndex { column, row }, Cell::Free));
            map.set(CellIndex { column: 40, row }, Cell::Occupied);
        }
        map
    }

    fn model() -> BeamModel {
        BeamModel::new(&LocalizationParameters::default())
    }

    /// The likelihood of a beam from (2, 2), to the right (0) or to the left (π).
    fn nats(heading_rad: f64, range_m: f32) -> f64 {
        nats_of(heading_rad, range_m, 10.0)
    }

    fn nats_of(heading_rad: f64, range_m: f32, range_max_m: f32) -> f64 {
        let ray = Ray { eye: [0.0, 0.0], direction: [1.0, 0.0], range_m, range_max_m };
        model().nats(&map(), &Particle::new(2.0, 2.0, heading_rad), &[ray])
    }

    #[test]
    fn rays_end_at_walls_and_in_unknown_space() {
        let from = [2.0, 2.0];
        assert_eq!(expected(&map(), from, [1.0, 0.0], 10.0), Expected::Wall(2.0));
        assert_eq!(expected(&map(), from, [1.0, 0.0], 1.5), Expected::Nothing);
        let Expected::Unknown(way_m) = expected(&map(), from, [-1.0, 0.0], 10.0) else { panic!("unknown") };
        assert!((way_m - 1.0).abs() < 1e-9);
        let Expected::Wall(way_m) = expected(&map(), from, [0.6, 0.8], 10.0) else { return };
        panic!("the unknown comes before a wall at {way_m}");
    }

    #[test]
    fn a_beam_is_most_likely_at_the_wall_and_more_likely_short_than_long() {
        let at_wall = nats(0.0, 2.0);
        assert!((0..60).all(|step| nats(0.0, 0.1 * step as f32) <= at_wall));
        assert!(nats(0.0, 1.0) > nats(0.0, 3.0), "something may stand in front of a wall, but a wall is not a window");
        assert!(nats(0.0, 1.0) < at_wall - 2.0);
        assert!(nats(0.0, f32::INFINITY) < -2.0, "a wall is rarely overlooked");
    }

    #[test]
    fn a_laser_does_not_miss_walls_that_are_out_of_range() {
        let silent = |range_max_m| nats_of(0.0, f32::INFINITY, range_max_m);
        assert!(silent(1.5) > -0.1, "the wall is 2 m away");
        assert!(silent(3.0) < -2.0, "a wall is rarely overlooked");
    }

    #[test]
    fn in_unknown_space_all_lengths_are_equally_likely() {
        let unknown = std::f64::consts::PI;
        let beyond: Vec<f64> = [1.2, 2.0, 5.0, 9.0].map(|range_m| nats(unknown, range_m)).to_vec();
        assert!(beyond.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 1e-12), "{beyond:?}");
        assert!(beyond[0] < nats(0.0, 2.0), "but not as good as a wall where there should be one");
        assert!(beyond[0] > nats(0.0, 3.0), "and not as bad as a beam through a wall");
        assert!(nats(unknown, f32::INFINITY) > nats(0.0, f32::INFINITY));
    }
}
