//! A parameter that varies from run to run: a value of the scenario, and its domain.

use std::fmt;

use diagnostics::document::{FromItem, Item};
use diagnostics::{Problem, Spanned};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A value that a campaign gives to a key of the scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// An integer.
    Integer(i64),
    /// A finite number.
    Number(f64),
    /// A boolean.
    Boolean(bool),
    /// A text.
    Text(String),
}

impl ParameterValue {
    /// The value as a number, if it is one.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(value) => Some(*value as f64),
            Self::Number(value) => Some(*value),
            Self::Boolean(_) | Self::Text(_) => None,
        }
    }
}

/// The value in TOML, as accepted by `--set`.
impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Text(value) => write!(f, "{}", toml::Value::String(value.clone())),
        }
    }
}

impl FromItem<'_> for ParameterValue {
    fn wanted() -> String {
        "a number, a Boolean or a string".into()
    }

    fn takes() -> Value {
        json!({ "title": "a string, a number, true or false", "type": ["string", "number", "boolean"] })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        let integer = item.as_integer().map(Self::Integer);
        let number = || item.as_number().filter(|number| number.is_finite()).map(Self::Number);
        let boolean = || item.as_boolean().map(Self::Boolean);
        let text = || item.as_text().map(|text| Self::Text(text.to_owned()));
        let value = integer.or_else(number).or_else(boolean).or_else(text);
        value.ok_or_else(|| vec![item.wrong(&Self::wanted())])
    }
}

/// A parameter that varies.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// The key, dotted as for `--set`.
    pub key: Spanned<String>,
    /// Its domain.
    pub domain: ParameterDomain,
    /// Its name in the campaign's model: an identifier.
    pub name: Option<String>,
    /// A description, with its unit.
    pub about: Option<String>,
}

/// The domain of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterDomain {
    /// One of these values; never empty.
    Values(Vec<ParameterValue>),
    /// Every whole number from the first to the last.
    Whole {
        /// The first.
        from: i64,
        /// The last, inclusive.
        to: i64,
    },
    /// Numbers from one to another.
    Range {
        /// The lower end.
        from: f64,
        /// The upper end, greater than the lower one.
        to: f64,
        /// Whether the scale is logarithmic.
        logarithmic: bool,
        /// Only this many values, evenly spaced, including both ends; at least 2.
        steps: Option<u64>,
    },
    /// Normally distributed numbers.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation, above 0.
        sd: f64,
        /// The distribution is truncated below this.
        min: Option<f64>,
        /// The distribution is truncated above this.
        max: Option<f64>,
    },
    /// Exponentially distributed numbers.
    Exponential {
        /// The mean, above 0.
        mean: f64,
    },
}

/// In words.
impl fmt::Display for ParameterDomain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Values(values) => {
                let values: Vec<String> = values.iter().map(ParameterValue::to_string).collect();
                write!(f, "one of {}", values.join(", "))
            }
            Self::Whole { from, to } => write!(f, "whole numbers from {from} to {to}"),
            Self::Range { from, to, logarithmic, steps } => {
                write!(f, "{from} to {to}")?;
                steps.map_or(Ok(()), |steps| write!(f, " in {steps} steps"))?;
                if *logarithmic { f.write_str(" on a logarithmic scale") } else { Ok(()) }
            }
            Self::Normal { mean, sd, min, max } => {
                write!(f, "normal with mean {mean} and standard deviation {sd}")?;
                min.map_or(Ok(()), |min| write!(f, ", at least {min}"))?;
                max.map_or(Ok(()), |max| write!(f, ", at most {max}"))
            }
            Self::Exponential { mean } => write!(f, "exponential with mean {mean}"),
        }
    }
}

impl ParameterDomain {
    /// The number of values, if it is finite.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        match self {
            Self::Values(values) => Some(values.len() as u64),
            Self::Whole { from, to } => Some(to.abs_diff(*from).saturating_add(1)),
            Self::Range { steps, .. } => *steps,
            Self::Normal { .. } | Self::Exponential { .. } => None,
        }
    }

    /// The value with this index, if the values can be counted and the index is valid.
    #[must_use]
    pub fn nth(&self, place: u64) -> Option<ParameterValue> {
        let count = self.count().filter(|count| place < *count)?;
        match self {
            Self::Values(values) => Some(values[place as usize].clone()),
            Self::Whole { from, .. } => Some(ParameterValue::Integer(from.wrapping_add_unsigned(place))),
            _ => self.between(place as f64 / (count - 1) as f64),
        }
    }

    /// The value below which a fraction `u` of the values lies, `0 < u < 1`: the quantile.
    #[must_use]
    pub fn at(&self, u: f64) -> ParameterValue {
        let place = |count: u64| ((u * count as f64) as u64).min(count - 1);
        if let Some(value) = self.count().and_then(|count| self.nth(place(count))) {
            return value;
        }
        match self {
            Self::Normal { mean, sd, min, max } => {
                let share = |end: Option<f64>, open| end.map_or(open, |end| normal_cdf((end - mean) / sd));
                let (low, high) = (share(*min, 0.0), share(*max, 1.0));
                let value = mean + sd * normal_quantile(low + u * (high - low));
                ParameterValue::Number(value.clamp(min.unwrap_or(f64::MIN), max.unwrap_or(f64::MAX)))
            }
            Self::Exponential { mean } => ParameterValue::Number(-mean * libm::log1p(-u)),
            Self::Range { .. } | Self::Whole { .. } | Self::Values(_) => {
                self.between(u).expect("a parameter without steps is a range")
            }
        }
    }

    /// Values at or near the ends, and one in the middle: a scenario must accept them before a campaign starts. For an
    /// unlimited tail, the value that one in a thousand exceeds.
    #[must_use]
    pub fn extremes(&self) -> Vec<ParameterValue> {
        match (self, self.count()) {
            (Self::Values(values), _) => values.clone(),
            (_, Some(count)) => [0, count / 2, count - 1].into_iter().filter_map(|place| self.nth(place)).collect(),
            (Self::Range { .. }, None) => [0.0, 0.5, 1.0].into_iter().filter_map(|share| self.between(share)).collect(),
            _ => [0.001, 0.5, 0.999].map(|u| self.at(u)).to_vec(),
        }
    }

    /// The number at a fraction of the distance from the lower to the upper end of a range; none for other domains.
    fn between(&self, share: f64) -> Option<ParameterValue> {
        let Self::Range { from, to, logarithmic, .. } = self else { return None };
        let number = if *logarithmic { from * libm::pow(to / from, share) } else { from * (1.0 - share) + to * share };
        Some(ParameterValue::Number(number.clamp(*from, *to)))
    }
}

/// The standard normal distribution function.
pub(super) fn normal_cdf(x: f64) -> f64 {
    libm::erfc(-x / std::f64::consts::SQRT_2) / 2.0
}

/// Its inverse, by bisection in the lower half, where there is no loss of precision.
fn normal_quantile(u: f64) -> f64 {
    if u > 0.5 {
        return -normal_quantile(1.0 - u);
    }
    let (mut low, mut high) = (-40.0_f64, 0.0_f64);
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        if normal_cdf(middle) < u { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: &ParameterValue) -> f64 {
        let ParameterValue::Number(number) = value else { panic!("{value} is not a number") };
        *number
    }

    fn near(value: &ParameterValue, wanted: f64) -> bool {
        (number(value) - wanted).abs() < 1e-9 * wanted.abs().max(1.0)
    }

    #[test]
    fn ranges_include_their_ends_and_have_even_steps() {
        let range = ParameterDomain::Range { from: 1.0, to: 2.0, logarithmic: false, steps: Some(5) };
        let values: Vec<f64> = (0..5).map(|place| number(&range.nth(place).unwrap())).collect();
        assert_eq!(values, [1.0, 1.25, 1.5, 1.75, 2.0]);
        assert_eq!(range.nth(5), None);
        let ratios = ParameterDomain::Range { from: 0.001, to: 10.0, logarithmic: true, steps: Some(5) };
        assert!(
            (0..5).zip([0.001, 0.01, 0.1, 1.0, 10.0]).all(|(place, wanted)| near(&ratios.nth(place).unwrap(), wanted))
        );
        assert!(near(&ParameterDomain::Range { from: 1.0, to: 100.0, logarithmic: true, steps: None }.at(0.5), 10.0));
        assert_eq!(ParameterDomain::Whole { from: -1, to: 1 }.at(0.999), ParameterValue::Integer(1));
        assert_eq!(ParameterDomain::Whole { from: i64::MIN, to: i64::MAX }.at(0.0), ParameterValue::Integer(i64::MIN));
    }

    #[test]
    fn quantiles_agree_with_tables() {
        let normal = ParameterDomain::Normal { mean: 10.0, sd: 2.0, min: None, max: None };
        for (u, wanted) in [(0.5, 10.0), (0.975, 13.919_927_969_08), (0.001, 3.819_535_387_66)] {
            assert!(near(&normal.at(u), wanted), "{} at {u}", normal.at(u));
        }
        assert!(near(&ParameterDomain::Exponential { mean: 3.0 }.at(0.5), 3.0 * std::f64::consts::LN_2));
        let cut = ParameterDomain::Normal { mean: 0.0, sd: 1.0, min: Some(0.0), max: Some(0.5) };
        assert!(cut.extremes().iter().all(|value| (0.0..=0.5).contains(&number(value))));
        // Half of the truncated distribution lies below it: Φ(x) = (Φ(0) + Φ(0.5))/2.
        assert!((normal_cdf(number(&cut.at(0.5))) - (0.5 + normal_cdf(0.5)) / 2.0).abs() < 1e-12);
    }

    #[test]
    fn values_are_written_in_toml() {
        let all = [
            ParameterValue::Integer(-3),
            ParameterValue::Number(1e-7),
            ParameterValue::Number(5.0),
            ParameterValue::Boolean(true),
            ParameterValue::Text("a \"b\"\n".into()),
        ];
        for value in all {
            let table: toml::Table = format!("value = {value}").parse().expect("it is TOML");
            let back = match &table["value"] {
                toml::Value::Integer(back) => ParameterValue::Integer(*back),
                toml::Value::Float(back) => ParameterValue::Number(*back),
                toml::Value::Boolean(back) => ParameterValue::Boolean(*back),
                toml::Value::String(back) => ParameterValue::Text(back.clone()),
                other => panic!("{other}"),
            };
            assert_eq!(back, value);
        }
    }
}
