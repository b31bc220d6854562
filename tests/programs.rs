//! Components that are programs: what they are told, what they may do, and that nothing of them is left running.

mod conversation;
mod hostile;
mod runs;

pub(crate) use conversation::has_python;
