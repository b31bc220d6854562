//! Runs a machine alone and prints what it does: `cargo run -p steward-skills --example rehearse -- MACHINE.scxml
//! [EVENTS.jsonl]`.
//!
//! Several files whose names end in `.scxml` are run one after the other.

use std::error::Error;
use std::io::{Write as _, stdout};
use std::path::Path;
use std::time::Duration;

use miette::Diagnostic as _;
use skills::{Chart, Cues, Strictness, rehearse};

const UNTIL: Duration = Duration::from_secs(3600);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (machines, events): (Vec<_>, Vec<_>) = arguments.iter().partition(|name| name.ends_with(".scxml"));
    let cues = match events.first() {
        Some(file) => Cues::parse(file, &std::fs::read_to_string(file)?)?,
        None => Cues::default(),
    };
    for machine in machines {
        match Chart::open(Path::new(machine), Strictness::Standard) {
            Ok(chart) => {
                let ending = rehearse(&chart, &cues, UNTIL, &mut |line| {
                    // If the reader has gone away, the output is not needed.
                    let _ = writeln!(stdout(), "{line}");
                });
                writeln!(stdout(), "{machine}: {ending:?}")?;
            }
            Err(error) => {
                writeln!(stdout(), "{machine}: {error}")?;
                for problem in error.related().into_iter().flatten() {
                    writeln!(stdout(), "  {problem}")?;
                }
            }
        }
    }
    Ok(())
}
