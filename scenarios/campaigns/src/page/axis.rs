//! The axis of a parameter in a report's charts: numbers or single values, depending on the parameter's values.

use std::ops::Range;

use drawing::Scale;

use super::super::ParameterValue;
use super::super::journal::ParameterLayout;

/// A parameter with more different values than this has no axis, unless they are numbers.
const MOST_CLASSES: usize = 24;
/// Up to this many different numbers have an axis of single values.
const FEW_NUMBERS: usize = 12;

/// The axis of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Axis {
    /// Numbers.
    Scale(Scale),
    /// Single values.
    Classes(Vec<ParameterValue>),
}

impl Axis {
    pub(super) fn bins(&self) -> usize {
        match self {
            Self::Scale(scale) => scale.bins,
            Self::Classes(values) => values.len(),
        }
    }

    /// The bin of a value, if it has one.
    pub(super) fn bin(&self, value: &ParameterValue) -> Option<usize> {
        match self {
            Self::Scale(scale) => value.number().map(|number| scale.bin(number)),
            Self::Classes(values) => values.iter().position(|known| known == value),
        }
    }
}

/// The smallest and the greatest of some numbers.
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

/// The values that a parameter has taken, as far as an axis needs them.
#[derive(Clone, Debug, Default)]
pub(super) struct Taken {
    extent: Extent,
    /// The different values, until there are too many.
    classes: Vec<ParameterValue>,
    /// Whether one of them is no number.
    has_others: bool,
}

impl Taken {
    pub(super) fn add(&mut self, value: &ParameterValue) {
        match value.number() {
            Some(number) => self.extent.add(number),
            None => self.has_others = true,
        }
        if self.classes.len() <= MOST_CLASSES && !self.classes.contains(value) {
            self.classes.push(value.clone());
        }
    }

    /// The axis, with this many bins if it has to be divided; none if there are too many different values.
    pub(super) fn axis(mut self, parameter: &ParameterLayout, bins: usize) -> Option<Axis> {
        if !self.has_others && self.classes.len() > FEW_NUMBERS {
            return self.extent.range().map(|range| Axis::Scale(Scale::new(range, parameter.logarithmic, bins)));
        }
        if self.classes.is_empty() || self.classes.len() > MOST_CLASSES {
            return None;
        }
        if !self.has_others {
            self.classes.sort_by(|a, b| a.number().unwrap_or(0.0).total_cmp(&b.number().unwrap_or(0.0)));
        }
        Some(Axis::Classes(self.classes))
    }
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

    fn axis(values: impl IntoIterator<Item = ParameterValue>) -> Option<Axis> {
        let mut taken = Taken::default();
        values.into_iter().for_each(|value| taken.add(&value));
        taken.axis(&parameter(false), 5)
    }

    #[test]
    fn few_values_make_classes_many_numbers_a_scale_and_many_strings_no_axis() {
        let numbers = |count: i64| axis((0..count).rev().map(ParameterValue::Integer));
        assert_eq!(
            numbers(3),
            Some(Axis::Classes(vec![
                ParameterValue::Integer(0),
                ParameterValue::Integer(1),
                ParameterValue::Integer(2)
            ]))
        );
        assert!(matches!(numbers(100), Some(Axis::Scale(Scale { low: 0.0, high: 99.0, bins: 5, .. }))));
        assert_eq!(axis((0..100).map(|number| ParameterValue::Text(number.to_string()))), None);
        let mixed = [ParameterValue::Text("b".into()), ParameterValue::Integer(1)];
        assert_eq!(axis(mixed.clone()), Some(Axis::Classes(mixed.to_vec())));
    }
}
