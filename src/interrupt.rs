//! Ctrl-C: the first asks for an orderly end, the second does not ask.

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use campaigns::Error;

use crate::output::note;

/// Set once the program is asked to end: by Ctrl-C, or by a scheduler that takes its machine away (SIGINT, SIGTERM or
/// SIGHUP).
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Listens from now on. Whoever is asked to end a second time ends at once.
pub(crate) fn listen() -> &'static AtomicBool {
    let heard = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(Error::INTERRUPTED.into());
        }
    });
    if heard.is_err() {
        note("Ctrl-C ends the program at once: the system does not let it listen");
    }
    &INTERRUPTED
}

/// Breaks off once the program is asked to end.
pub(crate) fn flow() -> ControlFlow<()> {
    if INTERRUPTED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// The exit status of a command that was interrupted.
pub(crate) fn status() -> ExitCode {
    ExitCode::from(Error::INTERRUPTED)
}
