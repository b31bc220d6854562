//! A part of a log.

/// Which part of a log was read, of one that has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogSession {
    /// Its number in the file.
    pub number: i64,
    /// How many sessions the file has.
    pub of: u64,
}
