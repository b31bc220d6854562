//! Numbers in readable form.

use channels::Value;

/// A number with at most this many decimals.
#[must_use]
pub fn decimals(number: f64, most: usize) -> String {
    format!("{:.most$}", Value::Real(number))
}

/// A length: `0.3 mm`, `14.76 m`.
#[must_use]
pub fn length(meters: f64) -> String {
    if meters < 0.1 { format!("{:.1} mm", meters * 1000.0) } else { format!("{meters:.2} m") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_trailing_zeros() {
        let written = [9.973_999_999_999, 10.0, -0.000_1, 100.0].map(|number| decimals(number, 3));
        assert_eq!(written, ["9.974", "10", "0", "100"]);
        assert_eq!(decimals(100.0, 0), "100");
        assert_eq!([0.000_3, 0.5, 14.764_4].map(length), ["0.3 mm", "0.50 m", "14.76 m"]);
    }
}
