//! Checks properties on your own event log: which held, which were violated, and by which messages.
//!
//! `cargo run --example watch_log -- examples/lift.jsonl examples/lift.scope`, in the crate's folder. The log is that
//! of a lift; there is no robot. `EventLog` describes its lines.

use std::fs::{File, read_to_string};
use std::io::BufReader;
use std::time::Duration;

use channels::Monitor;
use miette::{IntoDiagnostic, Result, miette};
use monitors::{Channels, EventLog, GapMark, Outcome, load, topology_of_log, verify};

/// The time between the log's ticks, by which durations in properties are converted to ticks.
const TICK: Duration = Duration::from_secs(1);

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [log, properties] = arguments.as_slice() else { return Err(miette!("usage: watch_log LOG.jsonl FILE.scope")) };
    let open = || Ok::<_, miette::Report>(BufReader::new(File::open(log).into_diagnostic()?));

    // The processes and channels. If you know the system, declare them in a `Topology` with the messages of each
    // channel: conditions are then checked against those messages, too.
    let topology = topology_of_log(open()?).into_diagnostic()?;

    // The properties, each with its monitor. All mistakes in the file are reported at once, each with its location.
    let text = read_to_string(properties).into_diagnostic()?;
    let mut file = load(properties, &text, &topology, TICK)?;

    // One pass over the log, in constant memory. For live events, call `observe` of each monitor yourself.
    let mut events = EventLog::new(open()?, &topology, Channels::All);
    let monitors = file.properties.iter_mut().map(|property| property.monitor.as_mut() as &mut dyn Monitor);
    let end = verify(&mut events, monitors).into_diagnostic()?;

    println!("{} messages, {} ticks", end.messages, end.ticks);
    while let Some(mark) = events.next_gap_mark() {
        if let GapMark::Begins(gap) = mark {
            println!("verdicts may be wrong: {}", gap.why);
        }
    }
    for property in &file.properties {
        println!("{}: {}", property.name, Outcome::of(property.monitor.as_ref()));
        let Some(monitor) = property.scope_monitor() else { continue };
        if let Some(witness) = monitor.witness() {
            print!("{witness}");
        }
        for obligation in monitor.open_obligations() {
            println!("{obligation}");
        }
    }
    Ok(())
}
