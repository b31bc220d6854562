//! Components that are programs: what they receive, what they may do, and that none of their processes is left running.

mod conversation;
mod hostile;
mod runs;

pub(crate) use conversation::has_python;
