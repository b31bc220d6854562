//! What goes to stdout and stderr.

use std::io::{self, Write};
use std::path::PathBuf;

use campaigns::Error;

use crate::render::{rendered, visible};

/// Writes an error to stderr, every diagnostic with the text that it is about.
pub(crate) fn complain(error: &Error) {
    match (error, error.diagnostics()) {
        (Error::Interrupted(what), _) => note(what),
        (other, diagnostics) if diagnostics.is_empty() => complain_of(&format!("error: {other}\n")),
        (_, diagnostics) => {
            let _ = io::stderr().write_all(rendered(diagnostics).as_bytes());
        }
    }
}

/// Writes to stderr what looks wrong, though it is accepted.
pub(crate) fn warn(diagnostic: &dyn miette::Diagnostic) {
    let _ = io::stderr().write_all(rendered([diagnostic]).as_bytes());
}

/// Writes lines to stderr, control characters made [visible].
pub(crate) fn complain_of(text: &str) {
    let _ = io::stderr().write_all(visible(text).as_bytes());
}

/// Writes to stderr, in a line, what a user should know of the input.
pub(crate) fn note(text: &str) {
    complain_of(&format!("note: {text}\n"));
}

/// Writes a result to stdout, control characters made [visible]. A reader that has gone away is no error.
///
/// # Errors
/// If stdout cannot be written to for another reason.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    match io::stdout().write_all(visible(text).as_bytes()).and_then(|()| io::stdout().flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(diagnostics::Error::Write { path: PathBuf::from("<stdout>"), source }.into())
        }
        _ => Ok(()),
    }
}
