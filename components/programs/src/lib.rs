//! Components that are programs in any language, in lockstep with simulated time.
//!
//! A program speaks JSON, one object per line. It receives a line whenever something happens, and answers with one
//! line, for which the run waits. So if a program always gives the same answers, the run is always the same.
//! `docs/src/reference/programs.md` describes the lines field by field; `components/programs/examples/speaker.py` is an
//! example.
//!
//! - [`Program`]: a command, its folder and its [`Limits`].
//! - [`ProgramProcess`]: a program that communicates over channels.
//! - [`keep`]: must be called at the beginning of `main`. It ensures that nothing of a program is left running.
//!
//! # What can go wrong
//! [`Program::new`] refuses a program that cannot be found or executed, and [`ProgramProcess::start`] one that does not
//! start. A program that fails later counts as crashed, and the reason is one of its
//! [`mishaps`](ProgramProcess::mishaps): it ends, does not answer in time, violates the protocol, sends what its
//! channels do not carry, writes without being asked, or runs out of memory.
//!
//! # Systems
//! On Linux, everything that a program has started is killed with it, even if it has left the program's process group,
//! and even if this process is killed. On other Unix systems, this holds only for the program's process group, and
//! memory is not limited. Elsewhere, only the program itself is killed.
//!
//! # Inside
//! `process` is their process in a channel system; `child` is the running program, which receives a line and answers
//! with a line; `protocol` defines these lines. Between steward and a program there is a `keeper`: a second steward
//! process that ends everything that the program has started, and notices when steward is gone. So `main` begins with
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
