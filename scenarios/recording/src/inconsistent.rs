//! Records that do not fit each other.

/// A record that does not fit those before it: it goes back in time, or refers to a fault, a node or a channel that
/// does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a record refers to something that does not exist in the run")]
pub struct Inconsistent;

/// What applying a record gives if this program has made the record itself. Unlike those of a file, which may be
/// damaged, such records refer only to what their header contains and never go back in time.
///
/// # Panics
/// If a record does not fit: this is a mistake in what makes the records.
pub fn fitting<T>(applied: Result<T, Inconsistent>) -> T {
    applied.expect("a run's records refer only to what its header contains")
}

pub(crate) fn check(fits: bool) -> Result<(), Inconsistent> {
    if fits { Ok(()) } else { Err(Inconsistent) }
}
