//! Reads settings and prints every problem in them. In the crate's folder: `cargo run --example check_settings --
//! examples/pump.toml`.

use std::error::Error;
use std::path::Path;
use std::time::Duration;

use diagnostics::document::{Document, Table};
use diagnostics::text_from_disk;

/// The settings of a pump, checked.
#[derive(Debug)]
struct Pump {
    name: String,
    pressure_bar: f64,
    mode: Mode,
    period: Duration,
}

#[derive(Clone, Copy, Debug)]
enum Mode {
    Always,
    Night,
}

/// Asks for every key before it returns, so that every problem is found.
fn read(root: Table<'_>) -> Option<Pump> {
    let name = root.text("name").required();
    let pressure_bar = root.number("pressure_bar").within(0.5..=6.0).required();
    let schedule = root.table("schedule").required()?;
    let mode = schedule.one_of("mode", &[("always", Mode::Always), ("night", Mode::Night)]).or(Mode::Always);
    let period = schedule.seconds("period_s").required();
    Some(Pump { name: name?, pressure_bar: pressure_bar?, mode, period: period? })
}

#[expect(clippy::print_stdout, reason = "an example prints its results")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which settings?")?;
    match Document::parse_toml(&path, &text_from_disk(Path::new(&path))?)?.read(read) {
        Ok(Pump { name, pressure_bar, mode, period }) => {
            println!("{name}: {pressure_bar} bar, {mode:?}, every {} s", period.as_secs());
        }
        Err(problems) => print!("{}", problems.plain()),
    }
    Ok(())
}
