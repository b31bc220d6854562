//! Levels of a battery, as finely as anything can distinguish them.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// A level in millionths of a percent: sums and comparisons are exact.
pub(crate) type Micros = i64;

pub(crate) const FULL: Micros = 100_000_000;

/// With more classes than this, a search would take too long. Chosen, not measured.
const MOST: usize = 4000;

/// A level, or a change in level, in percent. `None` if it has more than six decimals, or is out of range.
pub(crate) fn micros(percent: f64) -> Option<Micros> {
    let scaled = percent * 1e6;
    ((scaled - scaled.round()).abs() < 1e-3 && scaled.abs() <= 1e12).then(|| scaled.round() as Micros)
}

/// A class of levels: a level with which something is compared, or all levels between two of those.
///
/// Classes are numbered from the lowest: points have even numbers, open intervals odd ones.
pub(crate) type Class = usize;

/// The levels from 0 to 100 %, divided into classes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Levels {
    /// The points, from 0 to [`FULL`].
    points: Vec<Micros>,
    /// The points with which something is compared.
    compared: BTreeSet<Micros>,
    /// The maximum distance of a representative level from the end of its class, in percent.
    inside_pct: f64,
}

/// How the level changes from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rates {
    /// Its maximum loss.
    pub(crate) drain: Micros,
    /// Its minimum gain while it is charged.
    pub(crate) charge: Micros,
}

impl Levels {
    /// The classes given by these thresholds and additional points. `None` if there would be too many.
    ///
    /// Where the level changes slowly, there are rungs below each threshold (and above it, if the battery is charged),
    /// so that a level takes as many ticks from one threshold to the next as in reality.
    pub(crate) fn new(
        thresholds: &BTreeSet<Micros>,
        others: impl IntoIterator<Item = Micros>,
        rates: Option<Rates>,
    ) -> Option<Self> {
        let points = thresholds.iter().copied().chain(others);
        let points: BTreeSet<Micros> = points.filter(|point| (0..=FULL).contains(point)).chain([0, FULL]).collect();
        let mut all = points.clone();
        let lowest = thresholds.first().copied().unwrap_or(FULL);
        let highest = thresholds.last().copied().unwrap_or(0);
        let ends: Vec<Micros> = points.into_iter().collect();
        // Between two points, a rung is one tick's drain below another one, down from the upper point, and one tick's
        // gain above another one, up from the lower point: the level passes each threshold after a whole number of
        // rungs.
        for pair in ends.windows(2) {
            let (low, high) = (pair[0], pair[1]);
            let Some(Rates { drain, charge }) = rates.filter(|_| high <= highest) else { continue };
            // Nothing below the lowest threshold is distinguished.
            let drain = if low >= lowest { drain } else { 0 };
            let is_much = |step: Micros| step > 0 && (high - low) / step > MOST as Micros;
            if is_much(drain) || is_much(charge) {
                return None;
            }
            if drain > 0 {
                all.extend((1..).map(|steps| high - steps * drain).take_while(|point| *point > low));
            }
            if charge > 0 {
                all.extend((1..).map(|steps| low + steps * charge).take_while(|point| *point < high));
            }
        }
        let drain = rates.map_or(0, |rates| rates.drain);
        let inside_pct = if drain > 0 { drain as f64 / 2e6 } else { 100.0 };
        let compared = thresholds.clone();
        (2 * all.len() <= MOST).then(|| Self { points: all.into_iter().collect(), compared, inside_pct })
    }

    /// The same classes, divided until each class is reached from either all levels of another or none of them. `None`
    /// if there would be too many.
    ///
    /// Each point is repeatedly shifted down by the drain and up by the charge. So whichever level of a class the
    /// battery has now, the ends of the range that it may reach within a tick lie in the same classes.
    pub(crate) fn refined(&self, Rates { drain, charge }: Rates) -> Option<Self> {
        let mut all: BTreeSet<Micros> = self.points.iter().copied().collect();
        let mut new = self.points.clone();
        while let Some(point) = new.pop() {
            let next = [point - drain, point + charge];
            new.extend(next.into_iter().filter(|point| (0..=FULL).contains(point)).filter(|point| all.insert(*point)));
            if 2 * all.len() > MOST {
                return None;
            }
        }
        Some(Self { points: all.into_iter().collect(), ..self.clone() })
    }

    pub(crate) fn len(&self) -> usize {
        2 * self.points.len() - 1
    }

    pub(crate) fn class(&self, level: Micros) -> Class {
        match self.points.binary_search(&level) {
            Ok(index) => 2 * index,
            Err(index) => (2 * index).saturating_sub(1).min(self.len() - 1),
        }
    }

    /// The lowest and the highest level of a class. An interval only approaches them.
    pub(super) fn ends(&self, class: Class) -> (Micros, Micros) {
        (self.points[class / 2], self.points[class.div_ceil(2)])
    }

    /// The levels that no machine, property or battery distinguishes from those of a class, as a lowest and a highest
    /// level, and whether they only approach these. `full_from` is the level from which charging may end.
    pub(super) fn alike(&self, class: Class, full_from: Micros) -> [(Micros, bool); 2] {
        let (low, high) = self.ends(class);
        let is_open = low != high;
        let is_compared = |level: Micros| level == full_from || self.compared.contains(&level);
        // A full battery is the only one that charging leaves as it is.
        if !is_open && (is_compared(low) || low == FULL) {
            return [(low, false), (low, false)];
        }
        let points = || self.compared.iter().copied().chain([full_from]);
        let below = points().filter(|point| *point < high && *point <= low).max();
        let above = points().filter(|point| *point > low && *point >= high).min();
        [below.map_or((0, false), |low| (low, true)), above.map_or((FULL, true), |high| (high, true))]
    }

    /// A level that represents the class, in percent: the point, the middle of the interval, or a level near the
    /// thresholds.
    pub(crate) fn level_pct(&self, class: Class) -> f64 {
        let (low, high) = self.ends(class);
        let [low_pct, high_pct] = [low, high].map(|level| level as f64 / 1e6);
        let inside_pct = f64::min((high_pct - low_pct) / 2.0, self.inside_pct);
        if low == 0 { high_pct - inside_pct } else { low_pct + inside_pct }
    }

    /// The classes that contain a level reached from some level of `class` by a change within `change`.
    pub(crate) fn reached(&self, class: Class, change: RangeInclusive<Micros>) -> RangeInclusive<Class> {
        let is_open = class % 2 == 1;
        let (low, high) = self.ends(class);
        let (low, high) = (low + change.start(), high + change.end());
        let at = |level: Micros| self.class(level.clamp(0, FULL));
        // An end that is only approached lies in the class above or below.
        let lowest = if is_open && (0..FULL).contains(&low) && at(low) % 2 == 0 { at(low) + 1 } else { at(low) };
        let highest = if is_open && (1..=FULL).contains(&high) && at(high) % 2 == 0 { at(high) - 1 } else { at(high) };
        lowest..=highest
    }

    /// A class in words: `30 %`, `between 20 and 30 %`.
    pub(crate) fn words(&self, class: Class) -> String {
        let number = |level: Micros| recording::decimals(level as f64 / 1e6, 6);
        match (class % 2, self.ends(class)) {
            (0, (level, _)) => format!("{} %", number(level)),
            (_, (0, high)) => format!("below {} %", number(high)),
            (_, (low, FULL)) => format!("above {} %", number(low)),
            (_, (low, high)) => format!("between {} and {} %", number(low), number(high)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(points: &[f64], drain: f64, charge: f64) -> Levels {
        let of = |percent: f64| micros(percent).expect("few decimals");
        let rates = Some(Rates { drain: of(drain), charge: of(charge) });
        let thresholds = points.iter().map(|point| of(*point)).collect();
        Levels::new(&thresholds, [of(95.0)], rates).expect("few classes")
    }

    fn reached(levels: &Levels, from: f64, low: f64, high: f64) -> (String, String) {
        let of = |percent: f64| micros(percent).expect("few decimals");
        let range = levels.reached(levels.class(of(from)), of(low)..=of(high));
        (levels.words(*range.start()), levels.words(*range.end()))
    }

    #[test]
    fn points_and_the_intervals_between_them_are_classes() {
        let levels = Levels::new(&[20_000_000, 30_000_000].into(), [], None).expect("few classes");
        let words: Vec<String> = (0..levels.len()).map(|class| levels.words(class)).collect();
        let expected =
            ["0 %", "below 20 %", "20 %", "between 20 and 30 %", "30 %", "above 30 %", "100 %"].map(str::to_owned);
        assert_eq!(words, expected);
        assert!((levels.level_pct(3) - 25.0).abs() < 1e-9);
        for class in 0..levels.len() {
            assert_eq!(levels.class(micros(levels.level_pct(class)).expect("few decimals")), class);
        }
    }

    #[test]
    fn a_slow_battery_goes_down_rung_by_rung() {
        let levels = levels(&[20.0, 30.0], 1.0, 0.0);
        assert_eq!(reached(&levels, 31.5, -1.0, 0.0).0, "between 29 and 30 %", "just above 30, it may lose all of 1 %");
        assert_eq!(reached(&levels, 29.5, -1.0, 0.0), ("between 28 and 29 %".into(), "between 29 and 30 %".into()));
        assert_eq!(reached(&levels, 21.0, -1.0, 0.0), ("20 %".into(), "21 %".into()));
        assert_eq!(reached(&levels, 20.5, -1.0, 0.0).0, "below 20 %");
        assert_eq!(reached(&levels, 0.0, -1.0, 0.0), ("0 %".into(), "0 %".into()), "an empty battery stays empty");
        assert_eq!(reached(&levels, 99.0, 0.0, 100.0).1, "100 %");
    }

    #[test]
    fn every_real_change_is_among_the_reached_classes() {
        let levels = levels(&[12.5, 20.0, 30.0], 0.7, 0.3);
        assert_eq!([1, levels.len() - 2].map(|class| levels.level_pct(class)), [0.15, 95.35]);
        let mut level = 60.0;
        for step in 0..2000_i32 {
            let change = f64::from((step * 7919) % 1001) / 1000.0 - 0.7;
            let next = f64::clamp(level + change, 0.0, 100.0);
            let class = |percent: f64| levels.class((percent * 1e6).round() as Micros);
            let range = levels.reached(class(level), -700_000..=300_000);
            assert!(range.contains(&class(next)), "{level} to {next}");
            level = if step % 500 == 499 { f64::from(step % 97) } else { (next * 1e6).round() / 1e6 };
        }
    }

    #[test]
    fn levels_are_alike_if_they_are_compared_alike() {
        let levels = levels(&[20.0, 30.0], 1.0, 0.0);
        let alike = |percent: f64| {
            let class = levels.class(micros(percent).expect("few decimals"));
            levels.alike(class, 95_000_000).map(|(level, is_approached)| (level / 1_000_000, is_approached))
        };
        assert_eq!(alike(20.0), [(20, false), (20, false)]);
        assert_eq!(alike(95.0), [(95, false), (95, false)], "charging may end from here on");
        assert_eq!(alike(100.0), [(100, false), (100, false)]);
        // The rungs at 28 % and at 29 %, and the empty battery, are compared with nothing.
        for level in [28.0, 28.5, 29.0] {
            assert_eq!(alike(level), [(20, true), (30, true)], "{level} %");
        }
        assert_eq!([alike(0.0), alike(7.0)], [[(0, false), (20, true)]; 2]);
        assert_eq!(alike(97.0), [(95, true), (100, true)]);
    }

    #[test]
    fn too_fine_a_drain_gives_no_grid() {
        let thresholds = [20_000_000, 30_000_000].into();
        assert_eq!(Levels::new(&thresholds, [], Some(Rates { drain: 1, charge: 0 })), None);
        assert_eq!(micros(0.000_000_1), None);
    }
}
