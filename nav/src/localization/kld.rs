//! KLD sampling: as many particles as the distribution requires.

/// The smallest number of particles with which the sampled distribution stays within `pf_err` of the true one in
/// Kullback–Leibler divergence, with the confidence of the normal quantile `pf_z`, if it occupies `bins` bins.
///
/// One bin (or none) needs one particle.
pub(crate) fn particles_needed(bins: usize, pf_err: f64, pf_z: f64) -> usize {
    if bins <= 1 {
        return 1;
    }
    let freedom = (bins - 1) as f64;
    // Wilson and Hilferty's approximation of the chi-squared quantile.
    let spread = 2.0 / (9.0 * freedom);
    let root = 1.0 - spread + spread.sqrt() * pf_z;
    (freedom / (2.0 * pf_err) * root * root * root).ceil() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_the_chi_squared_quantile_over_twice_the_error() {
        // χ²(0.99) from tables, by degrees of freedom.
        for (freedom, quantile) in [(1_usize, 6.635), (5, 15.086), (10, 23.209), (50, 76.154), (100, 135.807)] {
            let exact = quantile / (2.0 * 0.05);
            let bound = particles_needed(freedom + 1, 0.05, 2.3263) as f64;
            assert!((bound - exact).abs() < 0.012 * exact + 1.0, "{freedom}: {bound} instead of {exact}");
        }
    }

    #[test]
    fn more_bins_need_more_particles() {
        let needed: Vec<usize> = (0..200).map(|bins| particles_needed(bins, 0.05, 2.33)).collect();
        assert_eq!(needed[..2], [1, 1]);
        assert!(needed[1..].windows(2).all(|pair| pair[0] < pair[1]));
    }
}
