//! Numbers in readable form.

/// A number with at most this many decimals.
#[must_use]
pub fn decimals(number: f64, most: usize) -> String {
    let text = format!("{number:.most$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_trailing_zeros() {
        let said = [9.973_999_999_999, 10.0, -0.000_1, 100.0].map(|number| decimals(number, 3));
        assert_eq!(said, ["9.974", "10", "0", "100"]);
        assert_eq!(decimals(100.0, 0), "100");
    }
}
