//! The time axis that all lanes of the timeline share.

use std::time::Duration;

use drawing::Area;

/// A stretch without changes is drawn shorter if it takes more than this part of what is drawn to scale …
const LARGE_PART: f64 = 0.4;
/// … and more than this, in seconds.
const LONG_S: f64 = 60.0;
/// How much of the axis a stretch that is drawn shorter takes, and all of them together.
const SHORTENED_PART: f64 = 0.18;
const ALL_SHORTENED_PART: f64 = 0.45;

/// A time axis. It runs to scale but for long stretches in which nothing changes: these are drawn shorter, so that what
/// happens before and after stays readable.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TimeAxis {
    pieces: Vec<Piece>,
}

/// A stretch of the axis with one scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    pub(super) left: f64,
    pub(super) right: f64,
    /// Whether it is drawn shorter than the others.
    pub(super) shortened: bool,
}

impl Piece {
    fn x(&self, time_s: f64) -> f64 {
        let part = (time_s - self.from_s) / (self.to_s - self.from_s).max(1e-9);
        self.left + (self.right - self.left) * part.clamp(0.0, 1.0)
    }
}

impl TimeAxis {
    /// The axis from zero to `end` across `plot`; `changes` are the times at which something happens, in any order.
    pub(super) fn new(end: Duration, changes: impl IntoIterator<Item = Duration>, plot: Area) -> Self {
        let end_s = end.as_secs_f64().max(1.0);
        let mut stops: Vec<f64> = changes.into_iter().map(|time| time.as_secs_f64()).collect();
        stops.retain(|stop| *stop < end_s);
        stops.extend([0.0, end_s]);
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let gaps: Vec<(f64, f64)> = stops.windows(2).map(|pair| (pair[0], pair[1])).collect();
        Self { pieces: lay_out(&joined(&gaps, &long_gaps(&gaps)), plot) }
    }

    /// Where a time lies.
    pub(super) fn x(&self, time: Duration) -> f64 {
        let time_s = time.as_secs_f64();
        let piece = self.pieces.iter().find(|piece| time_s <= piece.to_s).or(self.pieces.last());
        piece.map_or(0.0, |piece| piece.x(time_s))
    }

    /// The stretches that are drawn shorter.
    pub(super) fn shortened(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().filter(|piece| piece.shortened)
    }

    /// Labels for the axis, each with where it belongs; labels that are `room` wide don't overlap.
    pub(super) fn labels(&self, room: f64) -> Vec<(f64, String)> {
        let to_scale = || self.pieces.iter().filter(|piece| !piece.shortened);
        let (length, span_s) = to_scale().fold((0.0, 0.0), |(length, span_s), piece| {
            (length + piece.right - piece.left, span_s + piece.to_s - piece.from_s)
        });
        let step_s = step_s(span_s, length, room);
        let end_s = self.pieces.last().map_or(0.0, |piece| piece.to_s);
        let mut labels: Vec<(f64, String)> = Vec::new();
        for piece in to_scale() {
            let first = libm::ceil(piece.from_s / step_s - 1e-9) as u64;
            let last = libm::floor(piece.to_s / step_s + 1e-9) as u64;
            for time_s in (first..=last).map(|number| number as f64 * step_s) {
                let x = piece.x(time_s);
                if labels.last().is_none_or(|(before, _)| x - before >= room) {
                    labels.push((x, clock(time_s, end_s)));
                }
            }
        }
        labels
    }
}

/// Which gaps are drawn shorter: the longest ones, as long as they dwarf the rest.
fn long_gaps(gaps: &[(f64, f64)]) -> Vec<bool> {
    let length = |gap: &(f64, f64)| gap.1 - gap.0;
    let mut order: Vec<usize> = (0..gaps.len()).collect();
    order.sort_by(|&a, &b| length(&gaps[b]).total_cmp(&length(&gaps[a])));
    let mut to_scale_s: f64 = gaps.iter().map(length).sum();
    let mut long = vec![false; gaps.len()];
    for index in order {
        let gap_s = length(&gaps[index]);
        if gap_s <= LONG_S || gap_s <= LARGE_PART * to_scale_s || gaps.len() == 1 {
            break;
        }
        long[index] = true;
        to_scale_s -= gap_s;
    }
    long
}

/// The stretches of the axis: gaps that are drawn to scale belong together.
fn joined(gaps: &[(f64, f64)], long: &[bool]) -> Vec<(f64, f64, bool)> {
    let mut stretches: Vec<(f64, f64, bool)> = Vec::new();
    for (&(from_s, to_s), &long) in gaps.iter().zip(long) {
        match stretches.last_mut() {
            Some(last) if !last.2 && !long => last.1 = to_s,
            _ => stretches.push((from_s, to_s, long)),
        }
    }
    stretches
}

fn lay_out(stretches: &[(f64, f64, bool)], plot: Area) -> Vec<Piece> {
    let count = stretches.iter().filter(|(.., shortened)| *shortened).count().max(1) as f64;
    let short = plot.width * SHORTENED_PART.min(ALL_SHORTENED_PART / count);
    let taken: f64 = stretches.iter().filter(|(.., shortened)| *shortened).map(|_| short).sum();
    let span_s: f64 = stretches.iter().filter(|(.., shortened)| !shortened).map(|(from, to, _)| to - from).sum();
    let scale = (plot.width - taken) / span_s.max(1e-9);
    let mut left = plot.x;
    let piece = |&(from_s, to_s, shortened): &(f64, f64, bool)| {
        let right = left + if shortened { short } else { (to_s - from_s) * scale };
        let piece = Piece { from_s, to_s, left, right, shortened };
        left = right;
        piece
    };
    stretches.iter().map(piece).collect()
}

/// A round distance between two labels.
fn step_s(span_s: f64, length: f64, room: f64) -> f64 {
    const STEPS_S: [f64; 16] = [
        1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 14_400.0, 36_000.0,
    ];
    let needed_s = span_s * room / length.max(1e-9);
    STEPS_S.into_iter().find(|step_s| *step_s >= needed_s).unwrap_or(libm::ceil(needed_s / 36_000.0) * 36_000.0)
}

/// A time on the axis of a run of that length: `20 s`, or `24:40`.
pub(super) fn clock(time_s: f64, end_s: f64) -> String {
    let whole_s = time_s as u64;
    let (hours, minutes, seconds) = (whole_s / 3600, whole_s / 60 % 60, whole_s % 60);
    match end_s {
        ..120.0 => format!("{whole_s} s"),
        ..3600.5 => format!("{}:{seconds:02}", whole_s / 60),
        _ => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: Area = Area::new(100.0, 0.0, 800.0, 300.0);

    fn axis(end_s: u64, changes_s: &[u64]) -> TimeAxis {
        TimeAxis::new(Duration::from_secs(end_s), changes_s.iter().map(|time_s| Duration::from_secs(*time_s)), PLOT)
    }

    fn x(axis: &TimeAxis, time_s: u64) -> f64 {
        axis.x(Duration::from_secs(time_s))
    }

    #[test]
    fn a_short_run_is_drawn_to_scale() {
        let axis = axis(80, &[20, 21, 60]);
        assert_eq!((x(&axis, 0), x(&axis, 40), x(&axis, 80)), (100.0, 500.0, 900.0));
        assert_eq!(axis.shortened().count(), 0);
        let labels: Vec<String> = axis.labels(60.0).into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["0 s", "10 s", "20 s", "30 s", "40 s", "50 s", "60 s", "70 s", "80 s"]);
    }

    #[test]
    fn a_long_wait_is_drawn_shorter_and_what_happens_stays_readable() {
        let axis = axis(1486, &[20, 25, 46, 47, 1444, 1450]);
        let [wait] = axis.shortened().collect::<Vec<_>>()[..] else { panic!("one wait: {axis:?}") };
        assert_eq!((wait.from_s, wait.to_s), (47.0, 1444.0));
        assert!((x(&axis, 46) - x(&axis, 0)) / PLOT.width > 0.35, "{axis:?}");
        let labels = axis.labels(60.0);
        assert!(labels.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 60.0), "{labels:?}");
        assert!(labels.iter().any(|(_, label)| label == "24:10"), "{labels:?}");
    }

    #[test]
    fn time_never_runs_backwards() {
        for changes in [&[1, 500, 2900][..], &[], &[0, 3600], &[10, 1400, 1410, 2800, 2830]] {
            let axis = axis(3600, changes);
            let places: Vec<f64> = (0..=3600).map(|time_s| x(&axis, time_s)).collect();
            assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "{changes:?}");
            assert!((places[0] - 100.0).abs() < 1e-6 && (places[3600] - 900.0).abs() < 1e-6, "{changes:?}");
        }
    }
}
