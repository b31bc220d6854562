//! How much is tried.

/// How many random cases to try where `usual` are: with `FEWER_CASES=n` in the environment, an n-th of them. Mutation
/// testing takes fewer.
pub(crate) fn cases(usual: u64) -> u64 {
    let part = std::env::var("FEWER_CASES").ok().and_then(|part| part.parse().ok()).filter(|part| *part > 0);
    usual / part.unwrap_or(1)
}
