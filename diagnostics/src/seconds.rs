//! Times as numbers of seconds.

use std::time::Duration;

/// A time in seconds as results and files have it: the number nearest to its nanoseconds, so that 1.82 s is 1.82.
/// ([`Duration::as_secs_f64`] adds a fraction to the whole seconds, and gives 1.8199999999999998.)
#[must_use]
pub fn seconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_written_as_they_are_read() {
        assert_eq!(Duration::from_millis(1820).as_secs_f64().to_string(), "1.8199999999999998");
        for milliseconds in (0..2_000_000).step_by(20) {
            let time = Duration::from_millis(milliseconds);
            let (whole, rest) = (milliseconds / 1000, milliseconds % 1000);
            let written = format!("{whole}.{rest:03}");
            let written = written.trim_end_matches('0').trim_end_matches('.');
            assert_eq!(seconds(time).to_string(), written);
            assert_eq!(Duration::from_secs_f64(seconds(time)), time);
        }
        let odd = Duration::new(86_399, 999_999_999);
        assert_eq!(seconds(odd).to_string(), "86399.999999999");
    }
}
