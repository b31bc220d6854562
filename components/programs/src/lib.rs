//! Components that are programs in any language, in lockstep with simulated time.
//!
//! Messages are JSON objects, one per line. A program receives a line for each event, and answers with one line, for
//! which the run waits. So a run is reproducible if the program always gives the same answers.
//! `docs/src/reference/programs.md` describes the lines field by field; `components/programs/examples/speaker.py` is an
//! example.
//!
//! - [`Program`]: a command, its folder and its [`Limits`].
//! - [`ProgramProcess`]: a program that communicates over channels.
//! - [`keep`]: must be called at the beginning of `main`. It ensures that no process of a program is left running.
//!
//! # What can go wrong
//! [`Program::new`] refuses a program that cannot be found or executed, and [`ProgramProcess::start`] one that does not
//! start. A program that fails later counts as crashed, and the reason is one of its
//! [`mishaps`](ProgramProcess::mishaps): it ends, does not answer in time, violates the protocol, sends messages that
//! its channels do not carry, writes unsolicited output, or runs out of memory.
//!
//! # Systems
//! On Linux, all processes that a program has started are killed with it, even if they have left its process group, and
//! even if this process is killed. On other Unix systems, this holds only for the program's process group, and memory
//! is not limited. Elsewhere, only the program itself is killed.
//!
//! # Inside
//! `process` is their process in a channel system; `child` is the running program, which receives a line and answers
//! with a line; `protocol` defines these lines. Between steward and a program there is a `keeper`: another steward
//! process that ends all processes that the program has started, also when steward has ended. So `main` begins with
//! `programs::keep`.

mod child;
#[cfg(unix)]
mod keeper;
mod process;
mod program;
mod protocol;

#[cfg(unix)]
pub use keeper::{keep, keep_with};
pub use process::{Failure, ProgramProcess};
pub use program::{Limits, Program, Word};
