//! Augmented Monte Carlo localization: notices that the pose may be lost, and how hard to look for it elsewhere.
//!
//! Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", MIT Press 2005, table 8.3. The likelihood that is
//! averaged here is the geometric mean over a scan's beams, so that it compares between scans of different lengths.

/// Down to this share of the usual likelihood nothing is wrong.
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

    /// Takes in the particles' mean likelihood of a scan.
    pub(crate) fn observe(&mut self, likelihood: f64) {
        let (slow, fast) = self.averages.unwrap_or((likelihood, likelihood));
        let follow = |average: f64, alpha: f64| average + alpha * (likelihood - average);
        self.averages = Some((follow(slow, self.alpha_slow), follow(fast, self.alpha_fast)));
    }

    /// How hard to look elsewhere, as a share of the particles: how far the scans have of late been less likely than
    /// usual. Not at all if they are but a little less likely: something always stands about that is not on the map.
    pub(crate) fn random_share(&self) -> f64 {
        match self.averages {
            Some((slow, fast)) if fast < USUAL * slow => (1.0 - fast / slow).clamp(0.0, 1.0),
            _ => 0.0,
        }
    }

    /// The logarithm of a likelihood that is as usual, if only just.
    pub(crate) fn usual_nats(&self) -> Option<f64> {
        self.averages.map(|(slow, _)| libm::log(USUAL * slow))
    }

    /// Forgets what was usual, after the particles have been placed anew.
    pub(crate) fn reset(&mut self) {
        self.averages = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sudden_fall_of_the_likelihood_asks_to_look_elsewhere_until_it_is_over() {
        let mut recovery = Recovery::new(0.005, 0.1);
        (0..100).for_each(|_| recovery.observe(0.8));
        assert!(recovery.random_share() < 1e-9);
        (0..10).for_each(|_| recovery.observe(0.3));
        assert!(recovery.random_share() > 0.3);
        (0..60).for_each(|_| recovery.observe(0.8));
        assert!(recovery.random_share() < 1e-2);
    }

    #[test]
    fn with_both_rates_zero_there_is_no_recovery() {
        let mut recovery = Recovery::new(0.0, 0.0);
        [0.9, 0.1, 0.1, 0.1].into_iter().for_each(|likelihood| recovery.observe(likelihood));
        assert!(recovery.random_share().abs() < 1e-12);
    }
}
