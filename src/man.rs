//! `steward man DIR`: man pages.

use std::path::{Path, PathBuf};

use campaigns::Error;
use clap::{Args, Command};
use clap_mangen::Man;

use crate::output::print_wrapped;

/// Where they go.
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// The folder for the pages: steward.1, steward-run.1, …; `man -M DIR` expects them in DIR/man1
    dir: PathBuf,
}

/// Writes the pages.
pub(crate) fn man(args: &ManArgs, command: Command) -> Result<(), Error> {
    let mut all = command.disable_help_subcommand(true);
    all.build();
    let count = pages(&args.dir, &all)?;
    print_wrapped(format!(
        "wrote {count} pages to {}; read one with: man {}\n",
        args.dir.display(),
        args.dir.join("steward.1").display()
    ))
}

/// Writes the pages of a command and of its subcommands, and returns how many.
fn pages(dir: &Path, command: &Command) -> Result<usize, Error> {
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let path = dir.join(format!("{name}.1"));
    let mut page = Vec::new();
    let written = Man::new(command.clone()).render(&mut page);
    written.map_err(|source| diagnostics::Error::Write { path: path.clone(), source })?;
    diagnostics::write_whole(&path, page)?;
    command.get_subcommands().map(|inner| pages(dir, inner)).sum::<Result<usize, Error>>().map(|below| below + 1)
}
