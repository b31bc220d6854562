//! Fixed-point numbers with 32 fractional bits, in an `i64`.
//!
//! An interval's edges advance by two integer additions per row, and the column of an edge is a shift.

const FRACTION: u32 = 32;

/// 1 as a fixed-point number.
pub(super) const ONE: i64 = 1 << FRACTION;

/// The limit for absolute values.
pub(super) const LIMIT: usize = 1 << (51 - FRACTION);

/// The sum of this and any number below [`LIMIT`] has a last bit worth 2⁻³².
const SHIFT: f64 = (3 * LIMIT) as f64;

/// The fixed-point number nearest to `value`, whose absolute value must be less than [`LIMIT`]; otherwise the result is
/// meaningless.
///
/// Adding a constant moves the bits of the sum to where an integer has them. A processor can do this for several
/// numbers at once, unlike conversions.
#[inline]
pub(super) fn fixed(value: f64) -> i64 {
    (value + SHIFT).to_bits().wrapping_sub(SHIFT.to_bits()) as i64
}

/// The greatest integer that is not greater than a fixed-point number.
#[inline]
pub(super) fn floor(value: i64) -> i64 {
    value >> FRACTION
}

/// The least integer that is not less than a fixed-point number.
#[inline]
pub(super) fn ceil(value: i64) -> i64 {
    floor(value.wrapping_add(ONE - 1))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn is_within_half_a_bit(value in -524_287.0..524_287.0_f64) {
            let exact = value * ONE as f64;
            prop_assert!((fixed(value) as f64 - exact).abs() <= 0.5);
        }
    }

    #[test]
    fn rounds_to_integers_on_both_sides_of_0() {
        for value in [-3.0, -2.75, -0.5, 0.0, 0.25, 7.0, 524_287.5] {
            assert_eq!(floor(fixed(value)) as f64, value.floor());
            assert_eq!(ceil(fixed(value)) as f64, value.ceil());
        }
    }
}
