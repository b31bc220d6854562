//! Augmented Monte Carlo localization: detects that the pose may be lost, and determines how hard to search elsewhere.
//!
//! Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", MIT Press 2005, table 8.3. The likelihood averaged
//! here is the geometric mean over a scan's beams, so that scans with different numbers of beams can be compared.

/// Down to this share of the usual likelihood, scans count as normal.
const USUAL: f64 = 0.95;

/// The short- and the long-term average of the scans' likelihood.
#[derive(Clone, Debug)]
pub(crate) struct Recovery {
    alpha_slow: f64,
    alpha_fast: f64,
    averages: Option<(f64, f64)>,
}

impl Recovery {
    pub(crate) fn new(alpha_slow: f64, alpha_fast: f64) -> Self {
        Self { alpha_slow, alpha_fast, averages: None }
    }

    /// Records the particles' mean likelihood of a scan.
    pub(crate) fn observe(&mut self, likelihood: f64) {
        let (slow, fast) = self.averages.unwrap_or((likelihood, likelihood));
        let follow = |average: f64, alpha: f64| average + alpha * (likelihood - average);
        self.averages = Some((follow(slow, self.alpha_slow), follow(fast, self.alpha_fast)));
    }

    /// How hard to search elsewhere, as a share of the particles: how much less likely recent scans have been than
    /// usual. Zero if they are only slightly less likely, since there are always some unmapped objects.
    pub(crate) fn random_share(&self) -> f64 {
        match self.averages {
            Some((slow, fast)) if fast < USUAL * slow => (1.0 - fast / slow).clamp(0.0, 1.0),
            _ => 0.0,
        }
    }

    /// The logarithm of a likelihood that is just normal.
    pub(crate) fn usual_nats(&self) -> Option<f64> {
        self.averages.map(|(slow, _)| libm::log(USUAL * slow))
    }

    /// Forgets the usual likelihood, after the particles have been placed again.
    pub(crate) fn reset(&mut self) {
        self.averages = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sudden_drop_of_the_likelihood_triggers_a_search_until_it_is_over() {
        let mut recovery = Recovery::new(0.005, 0.1);
        (0..100).for_each(|_| recovery.observe(0.8));
        assert!(recovery.random_share() < 1e-9);
        (0..10).for_each(|_| recovery.observe(0.3));
        assert!(recovery.random_share() > 0.3);
        (0..60).for_each(|_| recovery.observe(0.8));
        assert!(recovery.random_share() < 1e-2);
    }

    #[test]
    fn with_both_rates_zero_recovery_is_disabled() {
        let mut recovery = Recovery::new(0.0, 0.0);
        [0.9, 0.1, 0.1, 0.1].into_iter().for_each(|likelihood| recovery.observe(likelihood));
        assert!(recovery.random_share().abs() < 1e-12);
    }
}
