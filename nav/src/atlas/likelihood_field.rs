//! The likelihood-field sensor model.
//!
//! A beam is likely if it ends near a surface of the map, regardless of obstacles on its way. The likelihood is looked
//! up: the field holds the negative log-likelihood of a beam that ends in a cell, rounded to a byte, so weighting a
//! particle is a sum of bytes. Its cells are finer than the map's, so that the peak is narrower than a cell.
//!
//! Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", MIT Press 2005, table 6.3.

use maps::{Cell, OccupancyGrid};

use super::LocalizationParameters;
use super::surface_field::{SurfaceField, cell};
use crate::particle::{Gaussian, Particle};

/// The largest cell of the field, in meters, as far as memory allows. Finer cells do not improve the estimate, because
/// it is matched to the map's surfaces afterwards.
const LARGEST_M: f64 = 0.025;

/// The most cells of a field: 16 MB.
const MOST_CELLS: usize = 1 << 24;

/// Number of beams weighted at once; as many as fit into vector registers.
const LANES: usize = 8;

/// 2²³: adding it to a number from 0 to 2²² leaves the nearest integer in the lowest bits.
const TO_INTEGER: f32 = 8_388_608.0;

/// The points where beams end, in the robot's frame, in meters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Endpoints {
    pub(crate) x_m: Vec<f32>,
    pub(crate) y_m: Vec<f32>,
}

impl Endpoints {
    pub(crate) fn clear(&mut self) {
        self.x_m.clear();
        self.y_m.clear();
    }

    pub(crate) fn push(&mut self, x_m: f32, y_m: f32) {
        self.x_m.push(x_m);
        self.y_m.push(y_m);
    }

    /// Takes every `step`-th point of others instead of its own.
    pub(crate) fn copy_every(&mut self, step: usize, others: &Self) {
        self.clear();
        self.x_m.extend(others.x_m.iter().step_by(step));
        self.y_m.extend(others.y_m.iter().step_by(step));
    }

    pub(crate) fn len(&self) -> usize {
        self.x_m.len()
    }
}

/// The negative log-likelihood of a beam that ends in a cell.
#[derive(Clone, Debug)]
pub(crate) struct LikelihoodField {
    width: usize,
    height: usize,
    cells_per_m: f64,
    /// Cells from the field's corner to the map's.
    column_offset: f64,
    row_offset: f64,
    penalties: Vec<u8>,
    /// The number of nats (units of the natural logarithm) per unit of penalty.
    pub(crate) nats_per_unit: f64,
}

impl LikelihoodField {
    /// The field of a map with these surfaces, for lasers with a range of `range_max_m`.
    pub(crate) fn new(
        map: &OccupancyGrid,
        surfaces: &SurfaceField,
        parameters: &LocalizationParameters,
        range_max_m: f64,
    ) -> Self {
        let (columns, rows, column, row) = surfaces.window();
        let wanted = (map.resolution_m() / LARGEST_M - 1e-6).ceil().max(1.0) as usize;
        let fine = (1..=wanted).rev().find(|fine| columns * rows * fine * fine <= MOST_CELLS).unwrap_or(1);
        let hit = HitLikelihood::new(parameters, range_max_m);
        let worst = -libm::log(hit.at(surfaces.farthest_m(), false));
        let best = -libm::log(hit.at(0.0, false));
        let nats_per_unit = (worst - best) / 255.0;
        let to_byte =
            |likelihood: f64| ((-libm::log(likelihood) - best) / nats_per_unit).round().clamp(0.0, 255.0) as u8;
        // Distances come in steps of 1/512 of the farthest: finer than a byte resolves.
        let steps = |unknown| -> Vec<u8> {
            (0..=512).map(|step| to_byte(hit.at(f64::from(step) / 512.0 * surfaces.farthest_m(), unknown))).collect()
        };
        let (known, unknown) = (steps(false), steps(true));
        let penalty = |offset: usize| {
            let (x, y) = (offset % (columns * fine), offset / (columns * fine));
            let to_grid = |cells: usize, first: i64| first as f64 + (cells as f64 + 0.5) / fine as f64;
            let distance_m =
                surfaces.sample(to_grid(x, column), to_grid(y, row)).map_or(surfaces.farthest_m(), |at| at.0);
            let step = (distance_m.abs() / surfaces.farthest_m() * 512.0).round().min(512.0) as usize;
            let is_unknown = cell(map, column + (x / fine) as i64, row + (y / fine) as i64) == Cell::Unknown;
            if is_unknown { unknown[step] } else { known[step] }
        };
        Self {
            width: columns * fine,
            height: rows * fine,
            cells_per_m: fine as f64 / map.resolution_m(),
            column_offset: -(column * fine as i64) as f64,
            row_offset: -(row * fine as i64) as f64,
            penalties: (0..columns * fine * rows * fine).map(penalty).collect(),
            nats_per_unit,
        }
    }

    /// The negative log-likelihood of the beams with these ends, seen from a particle, in units of
    /// [`nats_per_unit`](Self::nats_per_unit), at most 255 per beam.
    pub(crate) fn penalty(&self, particle: &Particle, ends: &Endpoints) -> u32 {
        let view = View::new(self, particle);
        let mut sum = 0;
        let (xs, xs_left) = ends.x_m.as_chunks::<LANES>();
        let (ys, ys_left) = ends.y_m.as_chunks::<LANES>();
        for (xs, ys) in xs.iter().zip(ys) {
            let mut offsets = [0; LANES];
            for lane in 0..LANES {
                offsets[lane] = view.offset(xs[lane], ys[lane]);
            }
            for offset in offsets {
                sum += u32::from(self.penalties[offset as usize]);
            }
        }
        for (x, y) in xs_left.iter().zip(ys_left) {
            sum += u32::from(self.penalties[view.offset(*x, *y) as usize]);
        }
        sum
    }
}

/// The field seen from a particle: the cells of its beams' ends.
struct View {
    x: f32,
    y: f32,
    cos: f32,
    sin: f32,
    last_column: f32,
    last_row: f32,
    width: u32,
}

impl View {
    fn new(field: &LikelihoodField, particle: &Particle) -> Self {
        // Half a cell less, so that rounding to the nearest is rounding down.
        Self {
            x: (particle.x_m * field.cells_per_m + field.column_offset - 0.5) as f32,
            y: (particle.y_m * field.cells_per_m + field.row_offset - 0.5) as f32,
            cos: (particle.cos * field.cells_per_m) as f32,
            sin: (particle.sin * field.cells_per_m) as f32,
            last_column: (field.width - 1) as f32,
            last_row: (field.height - 1) as f32,
            width: field.width as u32,
        }
    }

    /// The offset of the cell that contains a point of the robot's frame. Ends outside the field fall on its rim, which
    /// has the maximum distance from all surfaces.
    fn offset(&self, x_m: f32, y_m: f32) -> u32 {
        let column = (self.x + self.cos * x_m - self.sin * y_m).clamp(0.0, self.last_column);
        let row = (self.y + self.sin * x_m + self.cos * y_m).clamp(0.0, self.last_row);
        let integer = |number: f32| (number + TO_INTEGER).to_bits() & 0x3f_ffff;
        integer(row) * self.width + integer(column)
    }
}

/// The likelihood of a beam's end by its distance from the nearest surface.
struct HitLikelihood {
    z_hit: f64,
    sigma_hit: f64,
    stray: f64,
    uniform: f64,
}

impl HitLikelihood {
    fn new(parameters: &LocalizationParameters, range_max_m: f64) -> Self {
        Self {
            z_hit: parameters.z_hit,
            sigma_hit: parameters.sigma_hit,
            stray: parameters.z_rand / range_max_m,
            uniform: (parameters.z_hit + parameters.z_rand) / range_max_m,
        }
    }

    /// In an unknown cell, any object may be hit, so a beam is not less likely there than elsewhere.
    fn at(&self, distance_m: f64, unknown: bool) -> f64 {
        let deviations = distance_m / self.sigma_hit;
        let known = self.z_hit * libm::exp(-0.5 * deviations * deviations) + self.stray;
        if unknown { known.max(self.uniform) } else { known }
    }
}

/// The logarithm of the geometric mean of the beams' likelihoods, in nats; zero at best.
pub(crate) fn log_likelihood(field: &LikelihoodField, at: &Gaussian, ends: &Endpoints) -> f64 {
    let particle = Particle::new(at.x_m, at.y_m, at.heading_rad);
    -f64::from(field.penalty(&particle, ends)) * field.nats_per_unit / ends.len() as f64
}

#[cfg(test)]
mod tests {
    use maps::{CellIndex, pose};
    use proptest::prelude::*;

    use super::*;

    fn room() -> OccupancyGrid {
        let mut map = OccupancyGrid::new(80, 60, 0.05, pose(0.0, 0.0, 0.0));
        for row in 10..50 {
            for column in 10..70 {
                let wall = row == 10 || row == 49 || column == 10 || column == 69;
                map.set(CellIndex { column, row }, if wall { Cell::Occupied } else { Cell::Free });
            }
        }
        map
    }

    fn field_of(map: &OccupancyGrid) -> LikelihoodField {
        let parameters = LocalizationParameters::default();
        let surfaces = SurfaceField::new(map, parameters.laser_likelihood_max_dist);
        LikelihoodField::new(map, &surfaces, &parameters, 10.0)
    }

    /// The points on the four walls that a robot at this pose in the room sees.
    fn seen_from(at: &Particle, points: usize) -> Endpoints {
        let mut ends = Endpoints::default();
        for i in 0..points {
            let along = i as f64 / points as f64;
            let (w, h) = (0.55 + 2.9 * along, 0.55 + 1.9 * along);
            for (x, y) in [(w, 0.55), (w, 2.45), (0.55, h), (3.45, h)] {
                let (x, y) = (x - at.x_m, y - at.y_m);
                ends.push((at.cos * x + at.sin * y) as f32, (at.cos * y - at.sin * x) as f32);
            }
        }
        ends
    }

    #[test]
    fn the_true_pose_is_the_most_likely() {
        let field = field_of(&room());
        let truth = Particle::new(1.62, 1.27, 0.4);
        let ends = seen_from(&truth, 25);
        let at_truth = field.penalty(&truth, &ends);
        let mut rng = robot::Streams::new(1).stream("poses");
        for _ in 0..2000 {
            let mut off = || (rand::RngExt::random::<f64>(&mut rng) - 0.5) * 0.6;
            let other = Particle::new(truth.x_m + off(), truth.y_m + off(), truth.heading_rad + off());
            assert!(field.penalty(&other, &ends) >= at_truth, "{other:?} is likelier than the truth");
        }
        let near = Particle::new(truth.x_m + 0.03, truth.y_m, truth.heading_rad);
        assert!(field.penalty(&near, &ends) > at_truth, "three centimeters off is less likely");
    }

    #[test]
    fn a_beam_into_unknown_space_is_more_likely_than_one_into_the_open() {
        let field = field_of(&room());
        let mut end = Endpoints::default();
        end.push(0.0, 0.0);
        let at = |x, y| field.penalty(&Particle::new(x, y, 0.0), &end);
        assert!(at(2.0, 1.5) == 255, "in the open");
        assert!(at(0.1, 0.1) < 255, "outside the room");
        assert!(at(0.5, 1.5) < 3, "on a wall");
    }

    proptest! {
        #[test]
        fn ends_anywhere_are_weighted_without_a_panic(
            x in -1e4..1e4_f64, y in -1e4..1e4_f64, heading in -4.0..4.0_f64, far in -1e3..1e3_f32, count in 0_usize..20,
        ) {
            let mut ends = Endpoints::default();
            (0..count).for_each(|i| ends.push(far * i as f32, -far));
            let field = field_of(&room());
            prop_assert!(field.penalty(&Particle::new(x, y, heading), &ends) <= 255 * count as u32);
        }
    }
}
