//! The number of random cases.

/// The number of random cases to try: `usual`, or an n-th of them with `FEWER_CASES=n` in the environment, for mutation
/// testing.
pub(crate) fn cases(usual: u64) -> u64 {
    let part = std::env::var("FEWER_CASES").ok().and_then(|part| part.parse().ok()).filter(|part| *part > 0);
    usual / part.unwrap_or(1)
}
