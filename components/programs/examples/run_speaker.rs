//! Runs the speaker of `speaker.py`: `cargo run -p programs --example run_speaker`.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use channels::{Process as _, Topology};
use programs::{Limits, Program, ProgramProcess, Word};
use skills::Datum;

#[expect(clippy::print_stdout, reason = "an example prints its results")]
fn main() -> Result<ExitCode, Box<dyn Error>> {
    // A program runs between two keepers, which are further processes of this executable.
    #[cfg(unix)]
    if let Some(status) = programs::keep() {
        return Ok(status);
    }
    let words = ["python3", "speaker.py"].map(|word| Word::Text(word.to_owned())).to_vec();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let program = Program::new(words, Some(&folder), Limits::default())?;
    let mut topology = Topology::default();
    let speaker = topology.process("Speaker")?;
    let data = Datum::object([("seconds_per_letter", 0.1.into())])?;
    let mut process = ProgramProcess::new(&topology, speaker, Arc::new(program), data);
    process.start(Duration::ZERO)?;
    println!("Speaker is {}", process.location());
    Ok(ExitCode::SUCCESS)
}
