//! A time axis: the position of a moment, and the labeled moments.

use std::time::Duration;

use super::geometry::Area;

/// A stretch without changes is compressed if it takes more than this fraction of the part drawn to scale …
const LARGE_PART: f64 = 0.4;
/// … and more than this, in seconds.
const LONG_S: f64 = 60.0;
/// The fraction of the axis that one compressed stretch takes, and the maximum for all of them together.
const SHORTENED_PART: f64 = 0.18;
const ALL_SHORTENED_PART: f64 = 0.45;

/// A time axis from the start of a run to its end. It is to scale, except for stretches that
/// [`TimeAxis::around_changes`] compresses.
///
/// ```
/// use std::time::Duration;
///
/// use drawing::{Area, TimeAxis};
///
/// let plot = Area::new(100.0, 0.0, 800.0, 300.0);
/// let axis = TimeAxis::to_scale(Duration::from_secs(80), plot);
/// assert_eq!(axis.x(Duration::from_secs(20)), 300.0);
/// let labels: Vec<String> = axis.ticks(150.0).into_iter().map(|tick| tick.label).collect();
/// assert_eq!(labels, ["0", "20 s", "40 s", "60 s", "80 s"]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TimeAxis {
    stretches: Vec<Stretch>,
}

/// A stretch of a [`TimeAxis`] with one scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The time at which it begins, in seconds since the start of the run.
    pub from_s: f64,
    /// The time at which it ends.
    pub to_s: f64,
    /// Where it begins on the page, in pixels.
    pub left: f64,
    /// Where it ends on the page.
    pub right: f64,
    /// Whether it is compressed.
    pub shortened: bool,
}

/// A labeled moment on a [`TimeAxis`].
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Its position on the page, in pixels.
    pub x: f64,
    /// Its text: `0`, `40 s`.
    pub label: String,
}

impl Stretch {
    fn x(&self, time_s: f64) -> f64 {
        let part = (time_s - self.from_s) / (self.to_s - self.from_s).max(1e-9);
        self.left + (self.right - self.left) * part.clamp(0.0, 1.0)
    }
}

impl TimeAxis {
    /// The axis from zero to `end` across the width of `plot`, completely to scale. No axis is shorter than a second.
    #[must_use]
    pub fn to_scale(end: Duration, plot: Area) -> Self {
        Self::around_changes(end, [], plot)
    }

    /// The axis from zero to `end` across the width of `plot`. `changes` are the times at which something happens, in
    /// any order. Long stretches in which nothing happens are compressed, so that what happens before and after stays
    /// readable.
    #[must_use]
    pub fn around_changes(end: Duration, changes: impl IntoIterator<Item = Duration>, plot: Area) -> Self {
        let end_s = end.as_secs_f64().max(1.0);
        let mut stops: Vec<f64> = changes.into_iter().map(|time| time.as_secs_f64()).collect();
        stops.retain(|stop| *stop < end_s);
        stops.extend([0.0, end_s]);
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let gaps: Vec<(f64, f64)> = stops.windows(2).map(|pair| (pair[0], pair[1])).collect();
        Self { stretches: lay_out(&joined(&gaps, &long_gaps(&gaps)), plot) }
    }

    /// The position of a time on the page, in pixels; the end of the axis for times beyond it.
    #[must_use]
    pub fn x(&self, time: Duration) -> f64 {
        let time_s = time.as_secs_f64();
        let stretch = self.stretches.iter().find(|stretch| time_s <= stretch.to_s).or(self.stretches.last());
        stretch.map_or(0.0, |stretch| stretch.x(time_s))
    }

    /// All stretches, from left to right.
    #[must_use]
    pub fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// The compressed stretches.
    pub fn shortened(&self) -> impl Iterator<Item = &Stretch> {
        self.stretches.iter().filter(|stretch| stretch.shortened)
    }

    /// Round times along the axis, from left to right, at least `room` pixels apart. Compressed stretches have none: a
    /// distance there would not mean the same as elsewhere.
    #[must_use]
    pub fn ticks(&self, room: f64) -> Vec<Tick> {
        let to_scale = || self.stretches.iter().filter(|stretch| !stretch.shortened);
        let (length, span_s) = to_scale().fold((0.0, 0.0), |(length, span_s), stretch| {
            (length + stretch.right - stretch.left, span_s + stretch.to_s - stretch.from_s)
        });
        let step_s = step_s(span_s, length, room);
        let mut ticks: Vec<Tick> = Vec::new();
        for stretch in to_scale() {
            // Multiples of the step at an end belong to the axis, whatever the last bit of the quotient is.
            let first = libm::ceil(stretch.from_s / step_s - 1e-9) as u64;
            let last = libm::floor(stretch.to_s / step_s + 1e-9) as u64;
            for time_s in (first..=last).map(|number| number as f64 * step_s) {
                let x = stretch.x(time_s);
                if ticks.last().is_none_or(|before| x - before.x >= room - 1e-6) {
                    ticks.push(Tick { x, label: label(time_s) });
                }
            }
        }
        ticks
    }
}

/// The gaps to compress: the longest ones, as long as they dwarf the rest.
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

/// The stretches of the axis, with begin, end, and whether they are compressed. Adjacent gaps to scale are merged.
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

fn lay_out(stretches: &[(f64, f64, bool)], plot: Area) -> Vec<Stretch> {
    let count = stretches.iter().filter(|(.., shortened)| *shortened).count().max(1) as f64;
    let short = plot.width * SHORTENED_PART.min(ALL_SHORTENED_PART / count);
    let taken: f64 = stretches.iter().filter(|(.., shortened)| *shortened).map(|_| short).sum();
    let span_s: f64 = stretches.iter().filter(|(.., shortened)| !shortened).map(|(from, to, _)| to - from).sum();
    let scale = (plot.width - taken) / span_s.max(1e-9);
    let mut left = plot.x;
    let stretch = |&(from_s, to_s, shortened): &(f64, f64, bool)| {
        let right = left + if shortened { short } else { (to_s - from_s) * scale };
        let stretch = Stretch { from_s, to_s, left, right, shortened };
        left = right;
        stretch
    };
    stretches.iter().map(stretch).collect()
}

/// A round distance between two ticks, in seconds: 1, 2 or 5 of some power of ten.
fn step_s(span_s: f64, length: f64, room: f64) -> f64 {
    let needed_s = span_s * room / length.max(1e-9);
    let mut power = 1.0;
    while 5.0 * power < needed_s {
        power *= 10.0;
    }
    let step = [1.0, 2.0, 5.0].into_iter().find(|step| step * power >= needed_s);
    step.unwrap_or(5.0) * power
}

/// The text of a time: seconds, as in scenario files, reports and on the terminal.
fn label(time_s: f64) -> String {
    if time_s < 0.5 { "0".to_owned() } else { format!("{time_s:.0} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: Area = Area::new(100.0, 0.0, 800.0, 300.0);

    fn axis(end_s: u64, changes_s: &[u64]) -> TimeAxis {
        let changes = changes_s.iter().map(|time_s| Duration::from_secs(*time_s));
        TimeAxis::around_changes(Duration::from_secs(end_s), changes, PLOT)
    }

    fn x(axis: &TimeAxis, time_s: u64) -> f64 {
        axis.x(Duration::from_secs(time_s))
    }

    fn labels(axis: &TimeAxis, room: f64) -> Vec<String> {
        axis.ticks(room).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn a_short_run_is_drawn_to_scale() {
        let axis = axis(80, &[20, 21, 60]);
        assert_eq!((x(&axis, 0), x(&axis, 40), x(&axis, 80)), (100.0, 500.0, 900.0));
        assert_eq!(axis.shortened().count(), 0);
        assert_eq!(labels(&axis, 60.0), ["0", "10 s", "20 s", "30 s", "40 s", "50 s", "60 s", "70 s", "80 s"]);
    }

    #[test]
    fn a_long_wait_is_compressed_and_what_happens_stays_readable() {
        let axis = axis(1486, &[20, 25, 46, 47, 1444, 1450]);
        let [wait] = axis.shortened().collect::<Vec<_>>()[..] else { panic!("one wait: {axis:?}") };
        assert_eq!((wait.from_s, wait.to_s), (47.0, 1444.0));
        assert!((x(&axis, 46) - x(&axis, 0)) / PLOT.width > 0.35, "{axis:?}");
        let ticks = axis.ticks(60.0);
        assert!(ticks.windows(2).all(|pair| pair[1].x - pair[0].x >= 60.0), "{ticks:?}");
        assert!(ticks.iter().any(|tick| tick.label == "1450 s"), "{ticks:?}");
    }

    #[test]
    fn time_never_runs_backward() {
        for changes in [&[1, 500, 2900][..], &[], &[0, 3600], &[10, 1400, 1410, 2800, 2830]] {
            let axis = axis(3600, changes);
            let places: Vec<f64> = (0..=3600).map(|time_s| x(&axis, time_s)).collect();
            assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "{changes:?}");
            assert!((places[0] - 100.0).abs() < 1e-6 && (places[3600] - 900.0).abs() < 1e-6, "{changes:?}");
        }
    }

    #[test]
    fn labels_of_a_run_of_any_length_have_room() {
        for end_s in [1, 10, 67, 400, 3600, 100_000, 1_000_000_000] {
            let ticks = TimeAxis::to_scale(Duration::from_secs(end_s), PLOT).ticks(60.0);
            assert!(ticks.windows(2).all(|pair| pair[1].x - pair[0].x >= 59.9), "{end_s}: {ticks:?}");
            assert!(ticks.len() > 1, "{end_s}: {ticks:?}");
        }
    }

    /// 20 s take exactly the room requested, up to the last bit.
    #[test]
    fn labels_that_just_fit_are_all_present() {
        let plot = Area::new(0.1, 0.0, 60.0 * 223.0 / 20.0, 1.0);
        assert_eq!(TimeAxis::to_scale(Duration::from_secs(223), plot).ticks(60.0).len(), 12);
    }

    #[test]
    fn labels_are_round_seconds() {
        assert_eq!(labels(&axis(200, &[]), 180.0), ["0", "50 s", "100 s", "150 s", "200 s"]);
        assert_eq!(labels(&axis(4000, &[]), 200.0), ["0", "1000 s", "2000 s", "3000 s", "4000 s"]);
        assert_eq!(labels(&axis(30_000, &[]), 250.0), ["0", "10000 s", "20000 s", "30000 s"]);
    }
}
