//! A number that messages carry: it holds until the next message.

use std::time::Duration;

use crate::bounds::Signal;

/// With more values than this, only the extremes of each few are kept: a page has fewer pixels.
const MANY: usize = 5_000;

/// The values of a signal over time, where they change noticeably: by more than a small part of the numbers with which
/// properties compare them, or from one side of such a number to the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    signal: Signal,
    values: Vec<(Duration, f64)>,
    tolerance: f64,
}

impl Steps {
    pub(super) fn new(signal: Signal) -> Self {
        let most = signal.bounds.iter().map(|(bound, ..)| bound.abs()).fold(0.0, f64::max);
        let tolerance = if most > 0.0 { most / 500.0 } else { 1e-3 };
        Self { signal, values: Vec::new(), tolerance }
    }

    /// What it is.
    #[must_use]
    pub fn signal(&self) -> &Signal {
        &self.signal
    }

    pub(super) fn note(&mut self, now: Duration, value: f64) {
        if self.values.last().is_none_or(|(_, last)| self.differs(*last, value)) {
            self.values.push((now, value));
        }
        if self.values.len() > MANY {
            self.thin_out();
        }
    }

    /// Keeps the least and the greatest of four values in a row.
    fn thin_out(&mut self) {
        let extremes = |four: &[(Duration, f64)]| {
            let order = |a: &usize, b: &usize| four[*a].1.total_cmp(&four[*b].1);
            let mut kept: Vec<usize> =
                (0..four.len()).min_by(order).into_iter().chain((0..four.len()).max_by(order)).collect();
            kept.sort_unstable();
            kept.dedup();
            kept.into_iter().map(|place| four[place]).collect::<Vec<_>>()
        };
        self.values = self.values.chunks(4).flat_map(extremes).collect();
    }

    fn differs(&self, last: f64, value: f64) -> bool {
        let sides = |value: f64| self.signal.bounds.iter().map(move |(bound, ..)| value.total_cmp(bound));
        (value - last).abs() > self.tolerance || !sides(last).eq(sides(value))
    }

    pub(super) fn until(&self, time: Duration) -> Self {
        let values = self.values.iter().copied().filter(|(at, _)| *at <= time).collect();
        Self { values, ..self.clone() }
    }

    /// The line that it draws until `end`: level, and up or down where it changes.
    #[must_use]
    pub fn points(&self, end: Duration) -> Vec<(Duration, f64)> {
        let next = self.values.iter().skip(1).map(|(at, _)| *at).chain([end]);
        self.values.iter().zip(next).flat_map(|((at, value), next)| [(*at, *value), (next, *value)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, Topology};

    use super::*;

    fn steps(values: impl IntoIterator<Item = f64>) -> Steps {
        let mut topology = Topology::default();
        let [a, b] = ["A", "B"].map(|name| topology.process(name).unwrap());
        let channel = topology.channel(a, b, Capacity::One, Domain::new([])).unwrap();
        let bounds = vec![(20.0, "p".to_owned(), true)];
        let mut steps = Steps::new(Signal { channel, field: "level".to_owned(), bounds });
        values
            .into_iter()
            .enumerate()
            .for_each(|(second, value)| steps.note(Duration::from_secs(second as u64), value));
        steps
    }

    #[test]
    fn small_changes_are_left_out_unless_they_cross_a_bound() {
        let at = Duration::from_secs;
        let drawn = steps([20.01, 20.02, 20.0, 19.99, 25.0]).points(at(9));
        let (first, rest) = drawn.split_at(2);
        assert_eq!(first, [(at(0), 20.01), (at(2), 20.01)]);
        assert_eq!(rest, [(at(2), 20.0), (at(3), 20.0), (at(3), 19.99), (at(4), 19.99), (at(4), 25.0), (at(9), 25.0)]);
    }

    #[test]
    fn a_restless_signal_does_not_make_the_page_large() {
        let noise = (0..100_000_u64).map(|k| 30.0 + (k.wrapping_mul(2_654_435_761) % 1000) as f64 / 100.0);
        let kept: Vec<f64> = steps(noise).values.into_iter().map(|(_, value)| value).collect();
        assert!((MANY / 2..=MANY).contains(&kept.len()), "{}", kept.len());
        let extreme = |of: fn(f64, f64) -> f64| kept.iter().copied().reduce(of);
        assert_eq!((extreme(f64::min), extreme(f64::max)), (Some(30.0), Some(39.99)));
    }
}
