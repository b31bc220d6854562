//! Delays as SCXML writes them (SCXML 6.2.3, after CSS 2): `500ms`, `0.5s`.

use std::time::Duration;

/// The valid forms of a delay, for messages.
pub(crate) const FORMS: &str = "a delay is a number with a unit: `500ms`, `0.5s`, `2m`, `1h`, `1d`";

const NANOS_PER_UNIT: [(&str, u128); 5] = [
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
    ("m", 60_000_000_000),
    ("h", 3_600_000_000_000),
    ("d", 86_400_000_000_000),
];

/// The delay, to the nanosecond; `None` if the text is not a delay, or one of more than 500 years.
pub(crate) fn parse(text: &str) -> Option<Duration> {
    let text = text.trim();
    let unit_start = text.find(|c: char| c.is_ascii_alphabetic())?;
    let (number, unit) = text.split_at(unit_start);
    let (_, unit_nanos) = NANOS_PER_UNIT.iter().find(|(name, _)| *name == unit)?;
    let (whole, fraction) = number.split_once('.').unwrap_or((number, "0"));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit()) && text.len() <= 18;
    if !digits(whole) || !digits(fraction) || fraction.is_empty() || number.is_empty() {
        return None;
    }
    let whole: u128 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    let scale = 10_u128.pow(u32::try_from(fraction.len()).ok()?);
    let fraction: u128 = fraction.parse().ok()?;
    let nanos = whole * unit_nanos + fraction * unit_nanos / scale;
    u64::try_from(nanos).ok().map(Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_exact() {
        for (text, nanos) in [
            ("500ms", 500_000_000),
            ("0.5s", 500_000_000),
            (".5s", 500_000_000),
            ("0.1s", 100_000_000),
            ("0.000000001s", 1),
            ("2m", 120_000_000_000),
            (" 1s ", 1_000_000_000),
            ("0s", 0),
        ] {
            assert_eq!(parse(text), Some(Duration::from_nanos(nanos)), "{text:?}");
        }
    }

    #[test]
    fn invalid_delays_are_refused() {
        for text in ["", "5", "s", "-1s", "1 s", "1.s", "1sec", "1e3s", "1.2.3s", "99999999999999999999s", "9999999d"] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }
}
