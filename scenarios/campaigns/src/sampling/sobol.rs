//! The Sobol sequence, with the direction numbers of Joe and Kuo.

/// The number of parameters for which there are direction numbers.
pub const MAX_DIMENSIONS: usize = 16;

/// For each dimension after the first: the primitive polynomial's degree and inner coefficients, and its initial
/// numbers (S. Joe and F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections, SIAM Journal on
/// Scientific Computing 30, 2008; the set `new-joe-kuo-6`).
const INITIAL: [(u32, u32, &[u32]); MAX_DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
];

/// The direction numbers of a dimension, as binary fractions: the first is one half.
///
/// # Panics
/// If there are none for that dimension.
pub(super) fn directions(dimension: usize) -> [u32; 32] {
    if dimension == 0 {
        return std::array::from_fn(|bit| 1 << (31 - bit));
    }
    let (degree, coefficients, initial) = INITIAL[dimension - 1];
    let degree = degree as usize;
    let mut directions = [0; 32];
    for bit in 0..32 {
        directions[bit] = if bit < degree {
            initial[bit] << (31 - bit)
        } else {
            let inner = (1..degree).filter(|j| coefficients >> (degree - 1 - j) & 1 == 1);
            let last = directions[bit - degree];
            inner.fold(last ^ (last >> degree), |sum, j| sum ^ directions[bit - j])
        };
    }
    directions
}

/// The point with this number in one dimension, as a binary fraction.
pub(super) fn point(directions: &[u32; 32], k: u32) -> u32 {
    (0..32).filter(|bit| k >> bit & 1 == 1).fold(0, |sum, bit| sum ^ directions[bit])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial as bits, including its leading and last coefficients.
    fn polynomial(degree: u32, coefficients: u32) -> u32 {
        1 << degree | coefficients << 1 | 1
    }

    #[test]
    fn the_polynomials_are_primitive_and_the_initial_numbers_odd_and_small() {
        for (degree, coefficients, initial) in INITIAL {
            // The powers of x modulo a primitive polynomial take every value but 0.
            let modulus = polynomial(degree, coefficients);
            let mut power = 1_u32;
            let order = (1..=1_u32 << degree).find(|_| {
                power <<= 1;
                if power >> degree & 1 == 1 {
                    power ^= modulus;
                }
                power == 1
            });
            assert_eq!(order, Some((1 << degree) - 1), "{modulus:b}");
            assert_eq!(initial.len(), degree as usize);
            let right = |(bit, m): (usize, &u32)| m % 2 == 1 && *m < 2 << bit;
            assert!(initial.iter().enumerate().all(right), "{initial:?}");
        }
    }

    /// The first points printed by the authors' program, which visits the sequence in the order of the Gray code.
    #[test]
    fn the_sequence_starts_as_published() {
        let eighths = |dimension| -> Vec<u32> {
            let directions = directions(dimension);
            (0..8_u32).map(|k| point(&directions, k ^ (k >> 1)) >> 29).collect()
        };
        assert_eq!(eighths(0), [0, 4, 6, 2, 3, 7, 5, 1]);
        assert_eq!(eighths(1), [0, 4, 2, 6, 3, 7, 1, 5]);
        assert_eq!(eighths(2), [0, 4, 2, 6, 5, 1, 7, 3]);
    }
}
