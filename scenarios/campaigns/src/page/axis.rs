//! The axes of a report's charts, and the bins into which runs fall on them.

use std::ops::Range;

use super::super::Value;
use super::super::journal::ParameterLayout;

/// A parameter with more different values than this has no axis, unless they are numbers.
const MOST_CLASSES: usize = 24;
/// Numbers that are no more than this many different ones are an axis of single values.
const FEW_NUMBERS: usize = 12;

/// An axis of numbers, divided into bins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) logarithmic: bool,
    pub(super) bins: usize,
}

impl Scale {
    /// An axis over that range; one that has no extent gets some.
    pub(super) fn new(range: Range<f64>, logarithmic: bool, bins: usize) -> Self {
        let Range { start: low, end: high } = range;
        let logarithmic = logarithmic && low > 0.0;
        let high = if high > low { high } else { low + low.abs().max(1.0) };
        Self { low, high, logarithmic, bins: bins.max(1) }
    }

    /// How far along the axis a value lies: 0 at its lower end, 1 at its upper.
    pub(super) fn share(&self, value: f64) -> f64 {
        if self.logarithmic {
            libm::log(value.max(f64::MIN_POSITIVE) / self.low) / libm::log(self.high / self.low)
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The value so far along the axis.
    pub(super) fn at(&self, share: f64) -> f64 {
        if self.logarithmic {
            self.low * libm::pow(self.high / self.low, share)
        } else {
            self.low + (self.high - self.low) * share
        }
    }

    /// The bin of a value; what lies beyond an end belongs to the bin there.
    pub(super) fn bin(&self, value: f64) -> usize {
        ((self.share(value) * self.bins as f64).max(0.0) as usize).min(self.bins - 1)
    }

    /// The values at the ends of a bin.
    pub(super) fn ends(&self, bin: usize) -> [f64; 2] {
        [bin, bin + 1].map(|end| self.at(end as f64 / self.bins as f64))
    }

    /// The same axis with other bins.
    pub(super) fn with_bins(self, bins: usize) -> Self {
        Self { bins, ..self }
    }

    /// Round values along the axis, at most about so many.
    pub(super) fn ticks(&self, most: usize) -> Vec<f64> {
        let ticks = if self.logarithmic { self.ratios(most) } else { Vec::new() };
        if ticks.len() >= 2 { ticks } else { self.steps(most) }
    }

    fn steps(&self, most: usize) -> Vec<f64> {
        let rough = (self.high - self.low) / most.max(1) as f64;
        let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
        let step = [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let first = libm::ceil(self.low / step - 1e-9);
        let last = libm::floor(self.high / step + 1e-9);
        (0..=(last - first).max(0.0) as usize).map(|number| (first + number as f64) * step).collect()
    }

    /// 1, 2 and 5 of every decade, or its beginning alone.
    fn ratios(&self, most: usize) -> Vec<f64> {
        let [first, last] = [self.low, self.high].map(|end| libm::floor(libm::log10(end)) as i32);
        let decades = |parts: &[f64]| -> Vec<f64> {
            let all = (first..=last).flat_map(|decade| {
                parts.iter().map(move |part| {
                    // A negative power of ten is nearest to what people write as a quotient.
                    if decade < 0 {
                        part / libm::pow(10.0, f64::from(-decade))
                    } else {
                        part * libm::pow(10.0, f64::from(decade))
                    }
                })
            });
            all.filter(|tick| (self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9)).contains(tick)).collect()
        };
        let choices = [&[1.0, 2.0, 5.0][..], &[1.0, 3.0], &[1.0]].map(decades);
        let fitting = choices.iter().find(|ticks| ticks.len() <= most);
        fitting.unwrap_or(&choices[2]).clone()
    }
}

/// The axis of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Axis {
    /// Numbers.
    Scale(Scale),
    /// Single values.
    Classes(Vec<Value>),
}

impl Axis {
    pub(super) fn bins(&self) -> usize {
        match self {
            Self::Scale(scale) => scale.bins,
            Self::Classes(values) => values.len(),
        }
    }

    /// The bin of a value, if it has one.
    pub(super) fn bin(&self, value: &Value) -> Option<usize> {
        match self {
            Self::Scale(scale) => number(value).map(|number| scale.bin(number)),
            Self::Classes(values) => values.iter().position(|known| known == value),
        }
    }
}

/// A parameter's value as a number, if it is one.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(integer) => Some(*integer as f64),
        Value::Number(number) => Some(*number),
        Value::Boolean(_) | Value::Text(_) => None,
    }
}

/// The least and the greatest of numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extent {
    ends: Option<(f64, f64)>,
}

impl Extent {
    pub(super) fn add(&mut self, value: f64) {
        if value.is_finite() {
            let (low, high) = self.ends.unwrap_or((value, value));
            self.ends = Some((low.min(value), high.max(value)));
        }
    }

    pub(super) fn range(self) -> Option<Range<f64>> {
        self.ends.map(|(low, high)| low..high)
    }
}

/// Which values a parameter has taken, as far as an axis needs to know.
#[derive(Clone, Debug, Default)]
pub(super) struct Taken {
    extent: Extent,
    /// The different values, until there are too many.
    classes: Vec<Value>,
    only_numbers: bool,
    runs: u64,
}

impl Taken {
    pub(super) fn add(&mut self, value: &Value) {
        let number = number(value);
        self.only_numbers = number.is_some() && (self.runs == 0 || self.only_numbers);
        self.runs += 1;
        if let Some(number) = number {
            self.extent.add(number);
        }
        if self.classes.len() <= MOST_CLASSES && !self.classes.contains(value) {
            self.classes.push(value.clone());
        }
    }

    /// The axis, with so many bins if it has to be divided; none if there are too many different values.
    pub(super) fn axis(mut self, parameter: &ParameterLayout, bins: usize) -> Option<Axis> {
        if self.only_numbers && self.classes.len() > FEW_NUMBERS {
            return self.extent.range().map(|range| Axis::Scale(Scale::new(range, parameter.logarithmic, bins)));
        }
        if self.classes.is_empty() || self.classes.len() > MOST_CLASSES {
            return None;
        }
        if self.only_numbers {
            self.classes.sort_by(|a, b| number(a).unwrap_or(0.0).total_cmp(&number(b).unwrap_or(0.0)));
        }
        Some(Axis::Classes(self.classes))
    }
}

/// A number with three significant digits, as people write it.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - libm::floor(libm::log10(size)) as i32;
    if !(-4..=8).contains(&digits) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.*}", digits.max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::super::super::journal::ParameterKind;
    use super::*;

    fn parameter(logarithmic: bool) -> ParameterLayout {
        ParameterLayout {
            key: "a".into(),
            kind: ParameterKind::Number,
            domain: String::new(),
            logarithmic,
            name: None,
            about: None,
        }
    }

    fn axis(values: impl IntoIterator<Item = Value>) -> Option<Axis> {
        let mut taken = Taken::default();
        values.into_iter().for_each(|value| taken.add(&value));
        taken.axis(&parameter(false), 5)
    }

    #[test]
    fn every_value_of_a_range_has_a_bin_and_lies_in_it() {
        for scale in [Scale::new(-2.0..3.0, false, 7), Scale::new(0.001..10.0, true, 16)] {
            for step in 0..=100 {
                let value = scale.at(f64::from(step) / 100.0);
                let [low, high] = scale.ends(scale.bin(value));
                assert!(low - 1e-9 <= value && value <= high + 1e-9, "{value} in {low}..{high}");
            }
            assert_eq!((scale.bin(-1e9), scale.bin(1e9)), (0, scale.bins - 1));
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(Scale::new(0.1..9.9, false, 1).ticks(6), [2.0, 4.0, 6.0, 8.0]);
        assert_eq!(Scale::new(0.002..0.5, true, 1).ticks(10), [0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5]);
        assert_eq!(Scale::new(0.002..500.0, true, 1).ticks(6), [0.01, 0.1, 1.0, 10.0, 100.0]);
        assert_eq!(Scale::new(3.0..3.0, false, 4).high, 6.0);
    }

    #[test]
    fn few_values_are_classes_many_numbers_a_scale_and_many_texts_nothing() {
        let numbers = |count: i64| axis((0..count).rev().map(Value::Integer));
        assert_eq!(numbers(3), Some(Axis::Classes(vec![Value::Integer(0), Value::Integer(1), Value::Integer(2)])));
        assert!(matches!(numbers(100), Some(Axis::Scale(Scale { low: 0.0, high: 99.0, bins: 5, .. }))));
        assert_eq!(axis((0..100).map(|number| Value::Text(number.to_string()))), None);
        let mixed = [Value::Text("b".into()), Value::Integer(1)];
        assert_eq!(axis(mixed.clone()), Some(Axis::Classes(mixed.to_vec())));
    }

    #[test]
    fn numbers_are_written_short() {
        let written = [0.0, 12.0, 12.345, 0.012345, 123_456.0, 1e-7, 2.5, -0.5].map(short);
        assert_eq!(written, ["0", "12", "12.3", "0.0123", "123456", "1.00e-7", "2.5", "-0.5"]);
    }
}
