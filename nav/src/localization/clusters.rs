//! A histogram of the particles, and the clusters that its occupied bins form.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::particle::{Gaussian, Particle};
use maps::wrap_angle;

/// Side of a bin, in meters.
const BIN_M: f64 = 0.5;

/// Bins in a full turn: 10° each.
const HEADING_BINS: i64 = 36;

/// Bits of a key for a heading or a row or a column of bins.
const KEY_BITS: u32 = 21;

/// An occupied bin.
#[derive(Clone, Copy, Debug)]
struct Bin {
    key: u64,
    weight: f64,
    cluster: Option<usize>,
}

/// Occupied bins by key, and clusters: adjacent bins belong to one cluster.
///
/// All buffers are reused in the next update.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    keyed: Vec<(u64, u32)>,
    bins: Vec<Bin>,
    bin_of_particle: Vec<u32>,
    weights: Vec<f64>,
    open: Vec<usize>,
}

impl Clusters {
    /// Sorts the particles into bins and the bins into clusters.
    pub(crate) fn assign(&mut self, particles: &[Particle]) {
        self.fill_bins(particles);
        self.weights.clear();
        for first in 0..self.bins.len() {
            if self.bins[first].cluster.is_none() {
                self.grow_cluster(first);
            }
        }
    }

    /// The bin of a particle; bins are numbered from 0 to [`bins`](Self::bins).
    pub(crate) fn bin_of(&self, particle: usize) -> usize {
        self.bin_of_particle[particle] as usize
    }

    /// How many bins are occupied.
    pub(crate) fn bins(&self) -> usize {
        self.bins.len()
    }

    /// Mean and covariance of the cluster of greatest weight.
    pub(crate) fn heaviest(&self, particles: &[Particle]) -> Gaussian {
        let heaviest = (0..self.weights.len()).max_by(|a, b| self.weights[*a].total_cmp(&self.weights[*b]));
        mean_and_covariance(self.members(heaviest, particles))
    }

    /// Weight, mean and covariance of every cluster that has weight, heaviest first.
    pub(crate) fn all(&self, particles: &[Particle]) -> Vec<(f64, Gaussian)> {
        let weighty = (0..self.weights.len()).filter(|cluster| self.weights[*cluster] > 0.0);
        let mut all: Vec<(f64, Gaussian)> = weighty
            .map(|cluster| (self.weights[cluster], mean_and_covariance(self.members(Some(cluster), particles))))
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all
    }

    fn members<'a>(
        &'a self,
        cluster: Option<usize>,
        particles: &'a [Particle],
    ) -> impl Iterator<Item = &'a Particle> + Clone {
        let binned = particles.iter().zip(&self.bin_of_particle);
        binned.filter(move |(_, bin)| self.bins[**bin as usize].cluster == cluster).map(|(particle, _)| particle)
    }

    fn fill_bins(&mut self, particles: &[Particle]) {
        self.keyed.clear();
        self.keyed.extend(particles.iter().enumerate().map(|(index, particle)| (key_of(particle), index as u32)));
        self.keyed.sort_unstable();
        self.bins.clear();
        self.bin_of_particle.clear();
        self.bin_of_particle.resize(particles.len(), 0);
        for &(key, particle) in &self.keyed {
            if self.bins.last().is_none_or(|bin| bin.key != key) {
                self.bins.push(Bin { key, weight: 0.0, cluster: None });
            }
            let last = self.bins.len() - 1;
            self.bins[last].weight += particles[particle as usize].weight;
            self.bin_of_particle[particle as usize] = last as u32;
        }
    }

    /// Makes a new cluster of a bin and all bins connected to it.
    fn grow_cluster(&mut self, first: usize) {
        let cluster = Some(self.weights.len());
        let mut weight = 0.0;
        self.open.push(first);
        self.bins[first].cluster = cluster;
        while let Some(bin) = self.open.pop() {
            weight += self.bins[bin].weight;
            for key in neighbors(self.bins[bin].key) {
                let Ok(neighbor) = self.bins.binary_search_by_key(&key, |bin| bin.key) else { continue };
                if self.bins[neighbor].cluster.is_none() {
                    self.bins[neighbor].cluster = cluster;
                    self.open.push(neighbor);
                }
            }
        }
        self.weights.push(weight);
    }
}

fn key_of(particle: &Particle) -> u64 {
    let heading = (particle.heading_rad / TAU * HEADING_BINS as f64).floor() as i64;
    key((particle.x_m / BIN_M).floor() as i64, (particle.y_m / BIN_M).floor() as i64, heading)
}

/// Packs the position of a bin; half of the range of rows and columns is negative.
fn key(column: i64, row: i64, heading: i64) -> u64 {
    let coordinate = |cells: i64| ((cells + (1 << (KEY_BITS - 1))).clamp(1, (1 << KEY_BITS) - 2)) as u64;
    coordinate(column) << (2 * KEY_BITS) | coordinate(row) << KEY_BITS | heading.rem_euclid(HEADING_BINS) as u64
}

/// The keys of the 26 neighbors of a bin; headings wrap around.
fn neighbors(key: u64) -> impl Iterator<Item = u64> {
    let mask = (1 << KEY_BITS) - 1;
    let (column, row, heading) = (key >> (2 * KEY_BITS), (key >> KEY_BITS) & mask, key & mask);
    let around = |center: u64| center - 1..=center + 1;
    let turns = HEADING_BINS as u64;
    around(column)
        .flat_map(move |column| around(row).map(move |row| column << (2 * KEY_BITS) | row << KEY_BITS))
        .flat_map(move |place| [turns - 1, 0, 1].map(|turn| place | ((heading + turn) % turns)))
        .filter(move |neighbor| *neighbor != key)
}

/// The weighted mean of particles, headings as directions, and their covariance around it.
fn mean_and_covariance<'a>(particles: impl Iterator<Item = &'a Particle> + Clone) -> Gaussian {
    let mut weight = 0.0;
    let (mut x_m, mut y_m, mut cos, mut sin) = (0.0, 0.0, 0.0, 0.0);
    for particle in particles.clone() {
        weight += particle.weight;
        x_m += particle.weight * particle.x_m;
        y_m += particle.weight * particle.y_m;
        cos += particle.weight * particle.cos;
        sin += particle.weight * particle.sin;
    }
    (x_m, y_m) = (x_m / weight, y_m / weight);
    let heading_rad = libm::atan2(sin, cos);
    let mut covariance = Matrix3::zeros();
    for particle in particles {
        let turn = wrap_angle(particle.heading_rad - heading_rad);
        let off = Vector3::new(particle.x_m - x_m, particle.y_m - y_m, turn);
        covariance += off * off.transpose() * (particle.weight / weight);
    }
    Gaussian { x_m, y_m, heading_rad, covariance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particle(x_m: f64, y_m: f64, heading_rad: f64, weight: f64) -> Particle {
        Particle { weight, ..Particle::new(x_m, y_m, heading_rad) }
    }

    #[test]
    fn the_estimate_is_the_heaviest_cluster_not_the_mean_of_all() {
        let particles = [
            particle(1.0, 1.0, 3.13, 0.3),
            particle(1.2, 1.0, -3.13, 0.3),
            particle(-7.0, 4.0, 0.0, 0.2),
            particle(-7.1, 4.0, 0.1, 0.2),
        ];
        let mut clusters = Clusters::default();
        clusters.assign(&particles);
        let heaviest = clusters.heaviest(&particles);
        assert!((heaviest.x_m - 1.1).abs() < 1e-12);
        assert!(heaviest.heading_rad.abs() > 3.13, "headings are directions: {}", heaviest.heading_rad);
        assert!((heaviest.covariance[(0, 0)] - 0.01).abs() < 1e-12);
    }

    #[test]
    fn adjacent_bins_are_one_cluster() {
        // A chain of bins across the origin, and one apart.
        let particles: Vec<_> = (-3..3).map(|i| particle(f64::from(i) * 0.5 + 0.2, 0.1, 0.0, 0.1)).collect();
        let mut clusters = Clusters::default();
        clusters.assign(&particles);
        assert_eq!((clusters.bins(), clusters.weights.len()), (6, 1));
        let apart = [particles[0], particle(9.0, 9.0, 0.0, 0.1)];
        clusters.assign(&apart);
        assert_eq!((clusters.bins(), clusters.weights.len()), (2, 2));
    }
}
