//! Ctrl-C: the first one requests an orderly end, the second one ends the program at once.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use judging::Host;

use crate::output::{note, warn};

/// The exit status of a command that was interrupted, as in a shell.
pub(crate) const STATUS: u8 = 130;

/// The program, for what judges logs.
pub(crate) const HOST: Host = Host { is_interrupted: || flow().is_break(), note, warn };

/// Set once the end of the program has been requested: by Ctrl-C, or by a scheduler that takes the machine away
/// (SIGINT, SIGTERM or SIGHUP).
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Starts to listen. A second request ends the program at once.
pub(crate) fn listen() -> &'static AtomicBool {
    let handled = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(STATUS.into());
        }
    });
    if handled.is_err() {
        note("Ctrl-C ends the program at once: the system does not allow it to be handled");
    }
    &INTERRUPTED
}

/// Stops the work once the end of the program has been requested.
pub(crate) fn flow() -> ControlFlow<()> {
    if INTERRUPTED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
