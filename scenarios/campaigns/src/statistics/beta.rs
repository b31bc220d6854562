//! The Beta distribution, from which exact intervals are computed.

/// The continued fraction has converged when a step changes it by less than this.
const CONVERGED: f64 = 1e-15;
/// Replaces a zero denominator (Lentz).
const TINY: f64 = 1e-300;
/// Far above what is needed: the number of steps grows with √max(a, b).
const MAX_STEPS: u32 = 100_000;

/// The probability that a Beta(a, b) variable is at most `x`: the regularized incomplete beta function
/// (DLMF 8.17.22, and 8.17.4 where the fraction converges slowly). `a` and `b` are positive.
pub(super) fn cdf(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x <= (a + 1.0) / (a + b + 2.0) { tail(x, a, b) } else { 1.0 - tail(1.0 - x, b, a) }
}

/// The `x` for which [`cdf`] is `probability`, by bisection down to adjacent numbers.
pub(super) fn quantile(probability: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    while high - low > f64::EPSILON * high {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            break;
        }
        if cdf(middle, a, b) < probability { low = middle } else { high = middle }
    }
    low + (high - low) / 2.0
}

/// The incomplete beta function, where its continued fraction converges fast.
fn tail(x: f64, a: f64, b: f64) -> f64 {
    let ln_beta = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    let front = libm::exp(a * libm::log(x) + b * libm::log1p(-x) - ln_beta) / a;
    front / fraction(x, a, b)
}

/// 1 + d₁/(1 + d₂/(1 + …)), evaluated from the front (the modified method of Lentz).
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let (mut value, mut c, mut d) = (1.0, 1.0, 0.0);
    for step in 1..=MAX_STEPS {
        let m = f64::from(step / 2);
        let numerator = if step % 2 == 0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        d = 1.0 / away_from_zero(1.0 + numerator * d);
        c = away_from_zero(1.0 + numerator / c);
        value *= c * d;
        if (c * d - 1.0).abs() < CONVERGED {
            break;
        }
    }
    value
}

fn away_from_zero(value: f64) -> f64 {
    if value.abs() < TINY { TINY } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P(at least `k` of `n`) for a probability of `p`, summed term by term.
    fn binomial_tail(k: u32, n: u32, p: f64) -> f64 {
        let choose = |j: u32| (1..=j).fold(1.0, |c, i| c * f64::from(n + 1 - i) / f64::from(i));
        (k..=n).map(|j| choose(j) * libm::pow(p, f64::from(j)) * libm::pow(1.0 - p, f64::from(n - j))).sum()
    }

    #[test]
    fn the_cdf_is_the_tail_of_the_binomial_distribution() {
        for n in [1, 2, 7, 30] {
            for k in 1..=n {
                for p in [1e-6, 0.01, 0.3, 0.5, 0.77, 0.999] {
                    let (got, wanted) = (cdf(p, f64::from(k), f64::from(n - k + 1)), binomial_tail(k, n, p));
                    assert!((got - wanted).abs() < 1e-12 * wanted.max(1e-3), "{k} of {n} at {p}: {got}, not {wanted}");
                }
            }
        }
    }

    #[test]
    fn the_quantile_inverts_the_cdf() {
        for (a, b) in [(1.0, 10.0), (0.5, 0.5), (3.0, 100_000.0), (50_000.0, 50_000.0)] {
            for probability in [1e-9, 0.025, 0.5, 0.975] {
                let back = cdf(quantile(probability, a, b), a, b);
                assert!((back / probability - 1.0).abs() < 1e-8, "{probability} of ({a}, {b}) comes back as {back}");
            }
        }
    }
}
