//! The command line `steward`: see [`steward::cli`].

use std::process::ExitCode;
#[cfg(unix)]
use std::sync::Arc;

use clap::Parser;

fn main() -> ExitCode {
    // Beyond the limit of a file's size (`ulimit -f`), writing fails like on a full disk; the signal would end the program
    // without a word. It is only heard because somebody listens.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    steward::cli::run(&steward::cli::Cli::parse())
}
