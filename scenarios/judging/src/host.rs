//! The program that judges.

use std::ops::ControlFlow;
use std::time::Duration;

use miette::Diagnostic;

/// The program that judges: when it is to end, and where it writes what users should see at once.
#[derive(Clone, Copy, Debug)]
pub struct Host {
    /// Whether a user has asked it to end.
    pub is_interrupted: fn() -> bool,
    /// Writes a line.
    pub note: fn(&str),
    /// Writes warnings about a file.
    pub warn: fn(&dyn Diagnostic),
}

impl Host {
    #[cfg(test)]
    pub(crate) const SILENT: Self = Self { is_interrupted: || false, note: |_| {}, warn: |_| {} };

    /// The interval at which what other programs write is looked at again. Chosen, not measured.
    pub const PAUSE: Duration = Duration::from_millis(10);

    /// Stops the work once the program has been asked to end.
    pub fn flow(self) -> ControlFlow<()> {
        if (self.is_interrupted)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Waits for other programs, or for the request to end.
    #[expect(clippy::disallowed_methods, reason = "waits for another program")]
    pub fn pause(self) {
        std::thread::sleep(Self::PAUSE);
    }
}
