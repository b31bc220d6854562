//! The time to read a log and to verify it: `cargo bench -p steward-monitors --bench log [-- EVENTS [LOG]]`.
//!
//! Writes a log of an artificial run with this many events to the file if it does not exist, reads it without monitors
//! and then with φ1, φ2 and its variant, and prints the times and (on Linux) the peak memory. Unless a file is named,
//! the log is in the target folder.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use channels::{Monitor, Topology};
use monitors::{Channels, EventLog, Property, SHIPPED, load, topology_of_log, verify};

/// A run in which the robot drives, its battery level rises and falls, and nothing is violated.
fn write_log(path: &Path, events: u64) -> io::Result<()> {
    let mut log = BufWriter::with_capacity(1 << 20, File::create(path)?);
    writeln!(log, r#"{{"scenario":"made up","seed":1}}"#)?;
    let mut tick = 0;
    for step in 0..events {
        let time = tick as f64 + (step % 8) as f64 * 0.02;
        let level = 30.5 + (step % 6000) as f64 * 0.01;
        let start = format!(r#"{{"step":{step},"tick":{tick},"time_s":{time:.2},"#);
        match step % 8 {
            0 => writeln!(log, r#"{start}"generated":"tick"}}"#)?,
            1 => writeln!(log, r#"{start}"from":"TickGenerator","to":"BT","message":[{{"sym":"tick"}},{tick}]}}"#)?,
            2 => writeln!(
                log,
                r#"{start}"from":"BatteryLevel","to":"BatteryReader","message":[{{"sym":"get_level"}}]}}"#
            )?,
            3 => writeln!(
                log,
                r#"{start}"from":"BatteryReader","to":"BatteryLevel","message":[{{"sym":"ok"}},{level:.2}]}}"#
            )?,
            4 => writeln!(
                log,
                r#"{start}"from":"Localization","to":"AtRechargingStation","message":[{{"sym":"ok"}},false]}}"#
            )?,
            5 => writeln!(
                log,
                r#"{start}"from":"GotoRechargingStation","to":"Navigation","message":[{{"sym":"get_status"}},{{"sym":"RechargingStation"}}]}}"#
            )?,
            6 => writeln!(
                log,
                r#"{start}"from":"Navigation","to":"GoToDestination","message":[{{"sym":"ok"}},{{"sym":"running"}}]}}"#
            )?,
            _ => writeln!(log, r#"{start}"from":"BT","to":"BatteryLevel","message":[{{"sym":"tick"}}]}}"#)?,
        }
        tick += u64::from(step % 8 == 7);
    }
    log.flush()
}

fn open(path: &Path) -> io::Result<BufReader<File>> {
    Ok(BufReader::with_capacity(1 << 18, File::open(path)?))
}

fn properties(topology: &Arc<Topology>) -> Result<Vec<Property>, Box<dyn std::error::Error>> {
    let mut properties = Vec::new();
    for (name, text) in SHIPPED {
        properties.extend(load(name, text, topology, Duration::from_secs(1))?.properties);
    }
    Ok(properties)
}

#[expect(clippy::print_stdout, clippy::disallowed_methods, reason = "a program that measures time")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo adds `--bench`.
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let events: u64 = arguments.next().unwrap_or_else(|| "1000000".to_owned()).parse()?;
    let path = arguments.next().unwrap_or_else(|| format!("{}/{events}.jsonl", env!("CARGO_TARGET_TMPDIR")));
    let path = Path::new(&path);
    if !path.exists() {
        write_log(path, events)?;
    }
    let bytes = std::fs::metadata(path)?.len() as f64;
    let report = |what: &str, start: Instant| {
        let s = start.elapsed().as_secs_f64();
        println!("{what:<24} {s:6.2} s  {:6.2} M events/s  {:6.0} MB/s", events as f64 / s / 1e6, bytes / s / 1e6);
    };
    let topology = topology_of_log(open(path)?.take_lines(1000))?;
    let start = Instant::now();
    let mut input = open(path)?;
    io::copy(&mut input, &mut io::sink())?;
    report("reading the bytes", start);
    let start = Instant::now();
    let none: [&mut dyn Monitor; 0] = [];
    let end = verify(EventLog::new(open(path)?, &topology, Channels::All), none)?;
    report("reading the events", start);
    let mut properties = properties(&topology)?;
    let start = Instant::now();
    let monitors = properties.iter_mut().map(|property| property.monitor.as_mut() as &mut dyn Monitor);
    verify(EventLog::new(open(path)?, &topology, Channels::All), monitors)?;
    report("and with three monitors", start);
    for property in &properties {
        println!("{}: {:?}", property.name, property.scope_monitor().map(|monitor| monitor.outcome()));
    }
    println!("{} messages, {} ticks", end.messages, end.ticks);
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        status.lines().filter(|line| line.starts_with("VmHWM")).for_each(|line| println!("{line}"));
    }
    Ok(())
}

/// The first lines of a file.
trait TakeLines: io::BufRead + Sized {
    fn take_lines(self, lines: usize) -> io::Cursor<Vec<u8>> {
        let mut text = Vec::new();
        for line in self.lines().take(lines).map_while(Result::ok) {
            text.extend_from_slice(line.as_bytes());
            text.push(b'\n');
        }
        io::Cursor::new(text)
    }
}

impl<R: io::BufRead> TakeLines for R {}
