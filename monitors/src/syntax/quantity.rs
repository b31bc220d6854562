//! Numbers with a unit other than one of time: they stay numbers, in SI units as in ROS's REP 103.

use super::real::{Unfit, real};
use crate::syntax::ast::Literal;

/// How a number of a unit becomes one of its SI unit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scale {
    /// Times this power of ten, exactly.
    Power(i64),
    /// Times this and divided by that, in floating-point arithmetic.
    Ratio(f64, f64),
}

use Scale::{Power, Ratio};

/// The units, compound ones first.
pub(super) const UNITS: [(&str, Scale); 17] = [
    ("m/s", Power(0)),
    ("km/h", Ratio(1000.0, 3600.0)),
    ("rad/s", Power(0)),
    ("deg/s", DEGREES),
    ("m", Power(0)),
    ("cm", Power(-2)),
    ("mm", Power(-3)),
    ("km", Power(3)),
    ("rad", Power(0)),
    ("deg", DEGREES),
    ("kg", Power(0)),
    ("N", Power(0)),
    ("V", Power(0)),
    ("A", Power(0)),
    ("W", Power(0)),
    ("Hz", Power(0)),
    ("%", Power(0)),
];

const DEGREES: Scale = Ratio(std::f64::consts::PI, 180.0);

/// The number, as it is written, in the SI unit. A whole one is a real, too: a bound, which counts ticks, refuses it.
pub(super) fn in_si(written: &str, scale: Scale) -> Result<Literal, Unfit> {
    match scale {
        Power(power) => {
            let (mantissa, exponent) = written.split_once(['e', 'E']).unwrap_or((written, "0"));
            let exponent = exponent.parse::<i64>().ok().and_then(|exponent| exponent.checked_add(power));
            real(&format!("{mantissa}e{}", exponent.ok_or(Unfit::TooLarge)?))
        }
        Ratio(times, by) => {
            let number: f64 = written.parse().map_err(|_| Unfit::TooLarge)?;
            let scaled = number * times / by;
            if scaled.is_finite() { Ok(Literal::Real(scaled)) } else { Err(Unfit::TooLarge) }
        }
    }
}

/// The number without a unit.
pub(super) fn plain(written: &str) -> Result<Literal, Unfit> {
    if written.contains(['.', 'e', 'E']) {
        real(written)
    } else {
        written.parse().map(Literal::Int).map_err(|_| Unfit::TooLarge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_a_unit_is_the_nearest_one_in_si() {
        for (written, unit, number) in [
            ("0.3", "m/s", 0.3),
            ("36", "km/h", 10.0),
            ("0.3", "cm", 0.003),
            ("1.1", "mm", 0.0011),
            ("7e-1", "km", 700.0),
            ("180", "deg", std::f64::consts::PI),
            ("-90", "deg/s", -std::f64::consts::FRAC_PI_2),
        ] {
            let (_, scale) = UNITS.into_iter().find(|(known, _)| *known == unit).expect("a unit");
            assert_eq!(in_si(written, scale), Ok(Literal::Real(number)), "{written} {unit}");
        }
        assert_eq!(in_si("20", Power(0)), Ok(Literal::Real(20.0)));
        assert_eq!(in_si("1e308", Power(3)), Err(Unfit::TooLarge));
    }
}
