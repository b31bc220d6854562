//! Which number a decimal number with a point or an exponent stands for.
//!
//! A real is rounded to the nearest floating-point number, and so are the reals in messages: 0.1 is the same number in
//! both. But messages also contain integers, which are exact. If rounding moved a constant onto an integer, or from one
//! integer to another, comparisons with integers would be wrong. So no such constant is rounded.

use crate::syntax::ast::Literal;

/// Why a decimal number has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unfit {
    TooLarge,
    /// It would be rounded to this number.
    Rounded(f64),
}

/// The number that is written: a whole number exactly, as an integer if no real is equal to it.
pub(super) fn real(written: &str) -> Result<Literal, Unfit> {
    let real: f64 = written.parse().ok().filter(|real: &f64| real.is_finite()).ok_or(Unfit::TooLarge)?;
    if real.fract() != 0.0 {
        return Ok(Literal::Real(real));
    }
    let decimal = Decimal::of(written).ok_or(Unfit::Rounded(real))?;
    // The standard library writes all digits of a whole real.
    if Decimal::of(&format!("{real:.0}")).as_ref() == Some(&decimal) {
        return Ok(Literal::Real(real));
    }
    // The shortest number that is rounded to a real stands for it where no integer could be meant: 1e300.
    let is_shortest = || Decimal::of(&format!("{real:e}")).as_ref() == Some(&decimal) && real != 0.0;
    match decimal.integer() {
        Some(integer) => Ok(Literal::Int(integer)),
        None if is_shortest() => Ok(Literal::Real(real)),
        None => Err(Unfit::Rounded(real)),
    }
}

/// `digits · 10^exponent`, with as few digits as possible; none for zero.
#[derive(Debug, PartialEq)]
struct Decimal {
    is_negative: bool,
    digits: String,
    exponent: i64,
}

impl Decimal {
    /// A decimal number as it is written; `None` if its exponent is absurd.
    fn of(written: &str) -> Option<Self> {
        let (mantissa, exponent) = written.split_once(['e', 'E']).unwrap_or((written, "0"));
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = format!("{}{fraction}", whole.trim_start_matches('-'));
        let significant = digits.trim_end_matches('0');
        let dropped = digits.len() as i64 - significant.len() as i64;
        let exponent = exponent.parse::<i64>().ok()?.checked_add(dropped - fraction.len() as i64)?;
        let significant = significant.trim_start_matches('0').to_owned();
        let is_zero = significant.is_empty();
        Some(Self {
            is_negative: written.starts_with('-') && !is_zero,
            digits: significant,
            exponent: if is_zero { 0 } else { exponent },
        })
    }

    /// The integer that it is, if it is one of 64 bits.
    fn integer(&self) -> Option<i64> {
        let zeros = usize::try_from(self.exponent).ok().filter(|zeros| *zeros < 20)?;
        let sign = if self.is_negative { "-" } else { "" };
        format!("{sign}{}{}", self.digits, "0".repeat(zeros)).parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_never_rounded_onto_an_integer_or_from_one_to_another() {
        for (written, number) in [
            ("0.1", 0.1),
            ("20.0", 20.0),
            ("-0.0", -0.0),
            ("0e5", 0.0),
            ("1.5e3", 1500.0),
            ("9007199254740992.0", 9_007_199_254_740_992.0),
            ("9223372036854775808.0", 9_223_372_036_854_775_808.0),
            ("1e23", 1e23),
            ("-1.7976931348623157E+308", f64::MIN),
            ("4.9e-324", 5e-324),
        ] {
            assert_eq!(real(written), Ok(Literal::Real(number)), "{written}");
        }
        for (written, number) in [
            ("9007199254740995.0", 9_007_199_254_740_995),
            ("-9.007199254740993e15", -9_007_199_254_740_993),
            ("1152921504606847000.0", 1_152_921_504_606_847_000),
            ("9223372036854775807.0", i64::MAX),
        ] {
            assert_eq!(real(written), Ok(Literal::Int(number)), "{written}");
        }
        for (written, rounded) in [
            ("9007199254740992.5", 9_007_199_254_740_992.0),
            ("0.99999999999999999999", 1.0),
            ("9223372036854775809.0", 9_223_372_036_854_775_808.0),
            ("1e-400", 0.0),
            ("1e-99999999999999999999", 0.0),
        ] {
            assert_eq!(real(written), Err(Unfit::Rounded(rounded)), "{written}");
        }
        assert_eq!(real("1e309"), Err(Unfit::TooLarge));
    }

    #[test]
    fn whole_reals_of_any_size_are_read_as_they_are_printed() {
        let powers = std::iter::successors(Some(1.0_f64), |power| Some(power * 2.0));
        for power in powers.take_while(|power| power.is_finite()) {
            for number in [power, power.next_up().round(), -power] {
                let printed = Literal::Real(number).to_string();
                assert_eq!(real(&printed), Ok(Literal::Real(number)), "{printed}");
            }
        }
    }
}
