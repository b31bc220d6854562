//! `steward lsp`: checks files in an editor.

use std::process::ExitCode;

use campaigns::Error;
use clap::Args;

use crate::output::complain;

/// How to talk to the editor.
#[derive(Debug, Args)]
pub(crate) struct LspArgs {
    /// Over stdin and stdout, as always; editors may pass it
    #[arg(long)]
    stdio: bool,
}

/// Serves an editor until it exits.
pub(crate) fn lsp(_: &LspArgs) -> Result<ExitCode, Error> {
    Ok(language_server::serve(|error| {
        let help = "`steward lsp` is started by an editor; the page \"Editors\" of the book shows how";
        complain(&Error::refused(format!("the editor broke off: {error}"), help));
    }))
}
