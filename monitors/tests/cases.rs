//! The number of random cases, and their seeds.

/// The number of random cases to try: `usual`, or an n-th of them with `FEWER_CASES=n` in the environment, for mutation
/// testing.
pub(crate) fn cases(usual: u64) -> u64 {
    let part = std::env::var("FEWER_CASES").ok().and_then(|part| part.parse().ok()).filter(|part| *part > 0);
    usual / part.unwrap_or(1)
}

/// A number that a test on demand takes from the environment: how many cases to try, or the first `SEED`.
pub(crate) fn demanded(name: &str, usual: u64) -> u64 {
    std::env::var(name).map_or(usual, |text| text.parse().unwrap_or_else(|_| panic!("{name} is a number, not {text}")))
}
