//! The benchmark for the terminal.

use std::fmt::Write;

use super::{Benchmark, Sums, Trip};

/// The benchmark as a table, then the trips that failed. `again` is the command that drives one of them alone.
pub(crate) fn table(benchmark: &Benchmark, again: impl Fn(&Trip) -> String) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_table(&mut text, benchmark);
    let _ = write_failures(&mut text, benchmark, again);
    text
}

fn write_table(text: &mut String, benchmark: &Benchmark) -> std::fmt::Result {
    let widest = benchmark.maps.iter().map(|sums| sums.map.chars().count()).max().unwrap_or(0).max(3);
    writeln!(
        text,
        "{:<widest$}  trips  arrived  gave up  time over  contacts: walls  standing  walking  way  time",
        "map"
    )?;
    for sums in &benchmark.maps {
        let Sums { trips, arrived_pct, gave_up, time_over, wall_contacts, standing_contacts, walking_contacts, .. } =
            sums;
        write!(text, "{:<widest$}  {trips:>5}  {arrived_pct:>5.1} %  {gave_up:>7}  {time_over:>9}", sums.map)?;
        write!(text, "  {wall_contacts:>15}  {standing_contacts:>8}  {walking_contacts:>7}")?;
        writeln!(text, "  {}  {}", ratio(sums.way_ratio), ratio(sums.time_ratio))?;
    }
    writeln!(
        text,
        "\n{} people about. way: driven over the shortest; time: taken over that at full speed on the shortest way \
         (medians of the trips that arrived)",
        benchmark.people
    )
}

fn ratio(ratio: Option<f64>) -> String {
    ratio.map_or("   -".to_owned(), |ratio| format!("{ratio:.2}"))
}

fn write_failures(text: &mut String, benchmark: &Benchmark, again: impl Fn(&Trip) -> String) -> std::fmt::Result {
    if benchmark.failures.is_empty() {
        return writeln!(text, "All trips arrived, and touched neither walls nor people who stood still.");
    }
    writeln!(text, "\nFailures, each with the command that drives it again:")?;
    benchmark.failures.iter().try_for_each(|trip| {
        writeln!(
            text,
            "  {}, seed {}, after {:.0} s: {}\n    {}",
            trip.map,
            trip.seed,
            trip.time_s,
            trip.words(),
            again(trip)
        )
    })
}
