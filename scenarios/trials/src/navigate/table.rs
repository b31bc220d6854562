//! The benchmark as text for the terminal.

use std::fmt::{self, Formatter};

use super::{Benchmark, Sums, Trip};

/// The benchmark as a table, then the failed trips. `again` returns the command that repeats one trip alone.
pub fn table(benchmark: &Benchmark, again: impl Fn(&Trip) -> String) -> String {
    let whole = fmt::from_fn(|text| {
        write_table(text, benchmark)?;
        write_failures(text, benchmark, &again)
    });
    whole.to_string()
}

fn write_table(text: &mut Formatter<'_>, benchmark: &Benchmark) -> fmt::Result {
    let widest = benchmark.maps.iter().map(|sums| sums.map.chars().count()).max().unwrap_or(0).max(3);
    writeln!(text, "{:<widest$}  trips  arrived    false  gave  timed  touched          × optimum", "")?;
    writeln!(text, "{:<widest$}                  arrival    up    out  wall rest walker   way   time", "map")?;
    for sums in &benchmark.maps {
        let Sums { trips, arrived_pct, elsewhere, gave_up, time_over, .. } = sums;
        let Sums { wall_contacts, standing_contacts, walking_contacts, .. } = sums;
        write!(text, "{:<widest$}  {trips:>5}  {arrived_pct:>5.1} %", sums.map)?;
        write!(text, "  {elsewhere:>7}  {gave_up:>4}  {time_over:>5}")?;
        write!(text, "  {wall_contacts:>4} {standing_contacts:>4} {walking_contacts:>6}")?;
        writeln!(text, "  {}   {}", ratio(sums.way_ratio), ratio(sums.time_ratio))?;
    }
    writeln!(
        text,
        "\n{}.\nFalse arrival: the robot wrongly believes that it has arrived. Touched: walls, standing obstacles, walking \
         people. × optimum: the path driven relative to the shortest path, and the time relative to that at full speed \
         on the shortest path (medians of the trips that arrived).",
        about(benchmark)
    )
}

/// The people and boxes on the trips.
fn about(benchmark: &Benchmark) -> String {
    let of = |wanted: usize, mean: f64, what: &str| {
        let found =
            if mean < wanted as f64 { format!(" wanted, {mean:.1} could be placed (mean)") } else { String::new() };
        format!("{wanted} {what}{found}")
    };
    let people = of(benchmark.wanted.people, benchmark.mean_people, "people");
    match benchmark.wanted.boxes {
        0 => format!("With {people}"),
        boxes => format!("With {people}; {}", of(boxes, benchmark.mean_boxes, "boxes")),
    }
}

fn ratio(ratio: Option<f64>) -> String {
    ratio.map_or("   -".to_owned(), |ratio| format!("{ratio:.2}"))
}

fn write_failures(text: &mut Formatter<'_>, benchmark: &Benchmark, again: impl Fn(&Trip) -> String) -> fmt::Result {
    if benchmark.failures().next().is_none() {
        return writeln!(text, "All trips arrived without touching walls or standing obstacles.");
    }
    writeln!(text, "\nFailures, each with the command that repeats it:")?;
    benchmark.failures().try_for_each(|trip| {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::navigate::{About, TripOutcome};

    fn trip(seed: u64, outcome: TripOutcome, reason: Option<&str>) -> Trip {
        Trip {
            map: "depot".to_owned(),
            map_file: "maps/depot.yaml".to_owned(),
            seed,
            about: About { people: 7, boxes: 0 },
            start: [0.0, 0.0],
            goal: [4.0, 0.0],
            end: [4.0, 0.0],
            good: outcome == TripOutcome::Arrived,
            outcome,
            reason: reason.map(str::to_owned),
            time_s: 20.0,
            driven_m: 4.4,
            shortest_m: 4.0,
            off_m: 0.1,
            localization_max_m: 0.1,
            contacts: Vec::new(),
            wall_contacts: 0,
            standing_contacts: 0,
            walking_contacts: 0,
        }
    }

    fn benchmark(people: usize, trips: Vec<Trip>) -> Benchmark {
        Benchmark {
            wanted: About { people, boxes: 0 },
            mean_people: 7.0,
            mean_boxes: 0.0,
            seed: 1,
            maps: vec![Sums::of("depot", trips.iter(), 0.5)],
            trips,
            scenes: Vec::new(),
        }
    }

    #[test]
    fn the_table_shows_the_result_of_every_trip() {
        let trips = vec![
            trip(1, TripOutcome::Arrived, None),
            trip(2, TripOutcome::Elsewhere, None),
            trip(3, TripOutcome::GaveUp, Some("there is no path to the goal")),
            trip(4, TripOutcome::TimeOver, Some("there is no path to the goal")),
        ];
        let text = table(&benchmark(10, trips), |trip| format!("again {} {}", trip.map_file, trip.seed));
        let expected = "       trips  arrived    false  gave  timed  touched          × optimum
map                    arrival    up    out  wall rest walker   way   time
depot      4   25.0 %        1     1      1     0    0      0  1.10   2.50

With 10 people wanted, 7.0 could be placed (mean).
False arrival: the robot wrongly believes that it has arrived. Touched: walls, standing obstacles, walking people. \
× optimum: the path driven relative to the shortest path, and the time relative to that at full speed on the shortest path \
(medians of the trips that arrived).

Failures, each with the command that repeats it:
  depot, seed 2, after 20 s: false arrival
    again maps/depot.yaml 2
  depot, seed 3, after 20 s: gave up: there is no path to the goal
    again maps/depot.yaml 3
  depot, seed 4, after 20 s: timed out; last: there is no path to the goal
    again maps/depot.yaml 4
";
        assert_eq!(text, expected);
    }

    #[test]
    fn the_number_wanted_is_omitted_if_all_people_were_placed() {
        let text = table(&benchmark(7, vec![trip(1, TripOutcome::Arrived, None)]), |_| String::new());
        assert!(text.contains("\nWith 7 people.\n"), "{text}");
    }
}
