//! Numbers in readable form.

/// A number with at most this many decimals; a huge one as `1e308`.
#[must_use]
pub fn decimals(number: f64, most: usize) -> String {
    if number.abs() >= 1e16 {
        return format!("{number:?}");
    }
    let text = format!("{number:.most$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
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
        assert_eq!([decimals(100.0, 0), decimals(1e308, 2)], ["100", "1e308"]);
        assert_eq!([0.000_3, 0.5, 14.764_4].map(length), ["0.3 mm", "0.50 m", "14.76 m"]);
    }
}
