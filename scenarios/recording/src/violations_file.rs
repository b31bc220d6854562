//! The violations in a recording of something else, as a file that other tools show beside it.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

use mcap::Summary;
use mcap::read::LinearReader;
use mcap::records::Record;
use monitors::Violation;

use crate::ros;
use crate::topics::level;
use crate::topics::output::{LIBRARY, Output};

const TOPIC: &str = "/steward/violations";

/// Larger files are not ours: there are only the first violations of each property in them.
const MAX_BYTES: u64 = 1 << 26;

/// Writes the violations of properties as an MCAP file with messages of rcl_interfaces/msg/Log: an error where one
/// begins, and an information where it has ended. `start` is the time since 1970 at which the recording starts.
///
/// # Errors
/// If the file cannot be written.
pub fn write_violations<W: Write>(output: W, start: Duration, all: &[(&str, Violation)]) -> io::Result<W> {
    let mut output = Output::begin(output)?;
    let topic = output.topic::<ros::Log>(TOPIC)?;
    let mut logs: Vec<(Duration, u8, &str, &str)> = Vec::new();
    for (property, Violation { from, until }) in all {
        logs.push((start + from.time, level::ERROR, property, "violated"));
        logs.extend(until.map(|until| (start + until.time, level::INFO, *property, "holds again")));
    }
    logs.sort_by_key(|(at, ..)| *at);
    for (at, level, property, what) in logs {
        let msg = format!("{property} {what}");
        let log = ros::Log { stamp: at.into(), level, name: property.to_owned(), msg, ..ros::Log::default() };
        output.write(&topic, at, &log)?;
    }
    output.finish()
}

/// Whether [`write_violations`] wrote this file, so that nothing is lost if it is replaced.
#[must_use]
pub fn are_violations(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_BYTES).read_to_end(&mut bytes));
    let mut records = LinearReader::new(&bytes).into_iter().flatten();
    read.is_ok()
        && matches!(records.next(), Some(Ok(Record::Header(header))) if header.library.starts_with(LIBRARY))
        && matches!(Summary::read(&bytes), Ok(Some(all)) if all.channels.values().all(|one| one.topic == TOPIC))
}
