//! Doubts about numbers that are compared with a field in another unit. A field's name ends with its unit: `level_pct`,
//! `speed_mps`.

use channels::{ChannelId, Value};
use diagnostics::Problem;

use super::Resolver;
use super::condition::FieldPosition;
use crate::syntax::Operand;

/// How names of fields end, with the units that they mean.
const ENDINGS: [(&str, &str); 13] = [
    ("pct", "%"),
    ("m", "m"),
    ("mps", "m/s"),
    ("rad", "rad"),
    ("radps", "rad/s"),
    ("kg", "kg"),
    ("hz", "Hz"),
    ("cm", "cm"),
    ("mm", "mm"),
    ("km", "km"),
    ("kmh", "km/h"),
    ("deg", "deg"),
    ("degps", "deg/s"),
];

/// The one field of a built-in component whose name does not contain its unit, percent.
const BATTERY_LEVEL: (&str, &str) = ("BatteryReader", "level");

/// The level of a battery in percent: a fraction of one percent is probably meant as a share of the whole.
const LEVELS: [&str; 4] = ["level_pct", "charge_pct", "battery_pct", "soc_pct"];

impl<'a> Resolver<'a> {
    /// Warns of a constant in another unit than that of the field with which it is compared.
    pub(super) fn doubt_unit(
        &mut self,
        channel: ChannelId,
        positions: &[FieldPosition<'a>],
        operand: &Operand,
        value: &Value,
    ) {
        let (source, _) = self.topology.ends(channel);
        let fields: Vec<&str> = positions.iter().flat_map(|position| position.names_comparable_to(value)).collect();
        let Some(first) = fields.first() else { return };
        let written = self.written(operand);
        let unit = unit_in(written);
        let other = |field: &str| unit_of(source, field).filter(|of| !unit.is_empty() && in_si(unit) != *of);
        if let Some(of) = other(first)
            && fields.iter().all(|field| other(field).is_some())
        {
            let problem = Problem::new(format!("`{written}` is compared with `{first}`, which is in {of}"));
            let help = if in_si(of) == of {
                format!("write a number in {of}")
            } else {
                format!("write the number in {of}, without a unit: with one, it becomes one of {}", in_si(of))
            };
            self.problems.push(problem.at(operand.span(), "another unit").with_help(help).as_warning());
            return;
        }
        let is_level =
            |field: &&str| (source, *field) == BATTERY_LEVEL || LEVELS.iter().any(|level| field.ends_with(level));
        let number = value.as_number().filter(|number| *number > 0.0 && *number < 1.0);
        if let Some(number) = number.filter(|_| fields.iter().all(is_level)) {
            let problem = Problem::new(format!("`{first}` is compared with {number} %, less than one percent"));
            let help = format!("it is in percent: {} is {number} as a share of the whole", number * 100.0);
            self.problems.push(problem.at(operand.span(), "a fraction?").with_help(help).as_warning());
        }
    }

    /// A constant as the file writes its value.
    fn written(&self, operand: &Operand) -> &'a str {
        let span = match operand {
            Operand::Literal(_, span) => Some(*span),
            Operand::Constant(name) => self.constants.get(name.text.as_str()).map(|constant| constant.value_span),
        };
        span.and_then(|span| self.text.get(span.start..span.end)).unwrap_or_default()
    }
}

impl<'a> FieldPosition<'a> {
    /// The names of the field in messages in which it can be compared with the value.
    fn names_comparable_to(&self, value: &Value) -> Vec<&'a str> {
        let with = self.with.iter().filter(|shape| self.kind(shape).is_some_and(|kind| kind.is_comparable_to(value)));
        with.filter_map(|shape| shape.fields().get(self.number - 1)).map(|(name, _)| name.as_str()).collect()
    }
}

fn unit_of(source: &str, field: &str) -> Option<&'static str> {
    if (source, field) == BATTERY_LEVEL {
        return Some("%");
    }
    // A field called `m` is no length.
    let ending = field.rsplit('_').next().filter(|ending| field.len() > ending.len() || ending.len() > 1)?;
    ENDINGS.into_iter().find(|(known, _)| *known == ending).map(|(_, unit)| unit)
}

/// The unit of a number as it is written; empty if there is none.
fn unit_in(written: &str) -> &str {
    written.trim_start_matches(|sign: char| sign.is_ascii_digit() || "+-._eE ".contains(sign))
}

/// The unit of the number that a number of this unit becomes.
fn in_si(unit: &str) -> &str {
    match unit {
        "cm" | "mm" | "km" => "m",
        "km/h" => "m/s",
        "deg" => "rad",
        "deg/s" => "rad/s",
        unit => unit,
    }
}
