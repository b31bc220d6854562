//! The numbers with which properties compare fields of messages: the battery's levels, and other signals with their
//! bounds.

use channels::{ChannelId, Message, Relation, Topology, Value};
use monitors::{MessageCondition, MessageField, Role, Term};
use recording::{Header, LEVEL, Monitor};

/// A chart has no room for numbers of this size: differences between them might not be finite.
const MOST: f64 = 1e100;

/// The component that reports the battery's level.
const BATTERY: &str = "BatteryReader";

/// A number with which a property compares a field.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bound {
    /// The channel of the messages.
    pub(crate) channel: ChannelId,
    /// The field's name.
    pub(crate) field: String,
    pub(crate) value: f64,
    /// Whether the comparison is required by itself, rather than as a condition or an alternative.
    pub(crate) is_required: bool,
    /// Whether the field has to stay above it, rather than below it.
    pub(crate) is_lower: bool,
}

/// A field that properties compare with numbers: its values over time, and these numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The channel of the messages.
    pub channel: ChannelId,
    /// The field's name.
    pub field: String,
    /// The numbers, each with the names of its properties, and whether one of them requires it by itself.
    pub bounds: Vec<(f64, String, bool)>,
}

impl Signal {
    /// The value that a message gives it; none if it is too large for a chart.
    #[must_use]
    pub fn value(&self, message: &Message, topology: &Topology) -> Option<f64> {
        let shapes = topology.get(self.channel).domain.shapes();
        let shape = shapes.iter().find(|shape| shape.contains(message))?;
        let place = shape.fields().iter().position(|(name, _)| *name == self.field)?;
        message.fields()[place].as_number().filter(|value| value.abs() < MOST)
    }

    /// What it is, in words: `VisitorSensor → Welcome, distance_m`.
    #[must_use]
    pub fn title(&self, topology: &Topology) -> String {
        let (from, to) = topology.ends(self.channel);
        format!("{from} → {to}, {}", self.field)
    }
}

/// The signals in properties, except for the battery's level: that is drawn as it really is.
#[must_use]
pub fn signals(header: &Header) -> Vec<Signal> {
    let mut signals: Vec<Signal> = Vec::new();
    for monitor in header.monitors.iter() {
        for bound in bounds(monitor, &header.topology).into_iter().filter(|bound| !bound.is_level(&header.topology)) {
            let known = signals.iter_mut().position(|one| (one.channel, &one.field) == (bound.channel, &bound.field));
            let known = known.unwrap_or_else(|| {
                signals.push(Signal { channel: bound.channel, field: bound.field.clone(), bounds: Vec::new() });
                signals.len() - 1
            });
            add(&mut signals[known].bounds, bound.value, &monitor.name, bound.is_required);
        }
    }
    signals
}

/// The battery levels in the properties, each with the names of the properties that compare the level read by a skill
/// with it. A level that a property requires is critical; one that is only a condition is not.
pub(crate) fn thresholds(header: &Header) -> Vec<drawing::Threshold> {
    let mut levels = Vec::new();
    for monitor in header.monitors.iter() {
        for bound in levels_of(monitor, &header.topology) {
            add(&mut levels, bound.value, &monitor.name, bound.is_required && bound.is_lower);
        }
    }
    let threshold = |(level_pct, label, critical)| drawing::Threshold { level_pct, label, critical };
    levels.into_iter().map(threshold).collect()
}

/// Adds a number of a property, each number once.
fn add(bounds: &mut Vec<(f64, String, bool)>, value: f64, property: &str, is_critical: bool) {
    match bounds.iter_mut().find(|(known, ..)| *known == value) {
        Some((_, label, critical)) => {
            *critical |= is_critical;
            if !label.split(", ").any(|name| name == property) {
                *label += &format!(", {property}");
            }
        }
        None => bounds.push((value, property.to_owned(), is_critical)),
    }
}

/// The battery levels in a property.
pub(crate) fn levels_of(monitor: &Monitor, topology: &Topology) -> Vec<Bound> {
    bounds(monitor, topology).into_iter().filter(|bound| bound.is_level(topology)).collect()
}

fn bounds(monitor: &Monitor, topology: &Topology) -> Vec<Bound> {
    let mut bounds = Bounds { topology, found: Vec::new() };
    if let Some(formula) = &monitor.formula {
        formula.roles(&mut |event, role| bounds.of_condition(&event.condition, event.channel, role));
    }
    bounds.found
}

impl Bound {
    /// Whether it is one of the battery's level.
    fn is_level(&self, topology: &Topology) -> bool {
        topology.ends(self.channel).0 == BATTERY && self.field == LEVEL
    }
}

/// The numbers in formulas.
struct Bounds<'a> {
    topology: &'a Topology,
    found: Vec<Bound>,
}

impl Bounds<'_> {
    fn of_condition(&mut self, condition: &MessageCondition, channel: ChannelId, role: Role) {
        match condition {
            MessageCondition::Compare { field, relation, value } => {
                let most = matches!(relation, Relation::LessOrEqual | Relation::Less);
                let least = matches!(relation, Relation::GreaterOrEqual | Relation::Greater);
                self.of_comparison((field, value), (least, most), channel, role);
            }
            // `15 <= m.level`.
            MessageCondition::Relate { left: Term::Value(value), relation, right: Term::Field(field) } => {
                let most = matches!(relation, Relation::GreaterOrEqual | Relation::Greater);
                let least = matches!(relation, Relation::LessOrEqual | Relation::Less);
                self.of_comparison((field, value), (least, most), channel, role);
            }
            MessageCondition::True
            | MessageCondition::False
            | MessageCondition::Relate { .. }
            | MessageCondition::Remember { .. }
            | MessageCondition::Is { .. } => {}
            MessageCondition::Not(part) => self.of_condition(part, channel, role.negated()),
            MessageCondition::And(parts) => parts.iter().for_each(|part| self.of_condition(part, channel, role)),
            MessageCondition::Or(parts) if !role.holds => {
                parts.iter().for_each(|part| self.of_condition(part, channel, role));
            }
            MessageCondition::Or(parts) => {
                // `m[1] = <error> or level >= 15`: messages of other kinds have no level.
                let is_other_kind = |part: &&MessageCondition| {
                    matches!(part, MessageCondition::Compare { relation: Relation::Equal, value: Value::Symbol(_), .. })
                };
                let selects = parts.iter().filter(is_other_kind).count() + 1 == parts.len();
                let role = if selects { role } else { role.among_others() };
                parts.iter().for_each(|part| self.of_condition(part, channel, role));
            }
            MessageCondition::Implies(a, b) => {
                self.of_condition(a, channel, role.among_others());
                self.of_condition(b, channel, role);
            }
        }
    }

    /// A comparison of a field with a value, as a lower or an upper bound: of what has to hold, or of its opposite.
    fn of_comparison(
        &mut self,
        (field, value): (&MessageField, &Value),
        (least, most): (bool, bool),
        channel: ChannelId,
        role: Role,
    ) {
        if let Some(value) = value.as_number().filter(|value| (least || most) && value.abs() < MOST)
            && let Some(field) = self.name(channel, field)
        {
            let is_lower = least == role.holds;
            self.found.push(Bound { channel, field, value, is_required: role.alone, is_lower });
        }
    }

    /// The name of a field. Different messages may have different fields at the same place: the level comes first.
    fn name(&self, channel: ChannelId, field: &MessageField) -> Option<String> {
        let shapes = self.topology.get(channel).domain.shapes().iter();
        let at = field.number.checked_sub(1)?;
        let mut names: Vec<&str> = match &field.name {
            Some(name) => vec![name],
            None => shapes.filter_map(|shape| Some(shape.fields().get(at)?.0.as_str())).collect(),
        };
        names.sort_by_key(|name| *name != LEVEL);
        names.first().map(|name| (*name).to_owned())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::Arc;

    use runs::Run;
    use scenarios::scenario::{Scenario, find};

    use super::*;

    /// The header of the scenario `battery_fault` with these changes.
    pub(crate) fn header(overrides: &[&str]) -> Header {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let scenario = Scenario::load(&find::find("battery_fault").unwrap(), &overrides).unwrap();
        Run::new(Arc::new(scenario), 1, true).unwrap().header()
    }

    #[test]
    fn levels_are_those_of_the_properties() {
        let levels = |header: &Header| -> Vec<(f64, String, bool)> {
            thresholds(header).into_iter().map(|known| (known.level_pct, known.label, known.critical)).collect()
        };
        let shipped = [(20.0, "phi1".to_owned(), true), (30.0, "phi2, phi3".to_owned(), false)];
        assert_eq!(levels(&header(&[])), shipped);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.scope");
        let text = "property own := always not (BatteryReader, BatteryLevel, m[1] = <ok> and m[2] < 60)\n\
                    property other := always ((Navigation, GoToDestination, m[2] = <running>) implies true)\n";
        std::fs::write(&file, text).unwrap();
        let own = format!("properties=[\"{}\"]", file.display());
        assert_eq!(levels(&header(&[&own])), [(60.0, "own".to_owned(), true)]);
        assert_eq!(levels(&header(&["properties=[]"])), []);
    }

    #[test]
    fn a_required_level_is_critical_however_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.scope");
        let own = format!("properties=[\"{}\"]", file.display());
        let critical = |requirement: &str| {
            let text = requirement.replace("[", "(BatteryReader, BatteryLevel, ").replace(']', ")");
            std::fs::write(&file, format!("property own := {text}\n")).unwrap();
            thresholds(&header(&[&own])).iter().map(|known| (known.level_pct, known.critical)).collect::<Vec<_>>()
        };
        for requirement in [
            "always [level >= 15]",
            "always [15 <= level]",
            "always not [15 > level]",
            "always ([level < 15] implies false)",
            "always at most 0 [level < 15] in 10 s",
            "always [status = <error> or level >= 15]",
        ] {
            assert_eq!(critical(requirement), [(15.0, true)], "{requirement}");
        }
        for requirement in [
            "always [15 > level]",
            "always ([level < 15] implies next [level >= 0])",
            "always at most 1 [level < 15] in 10 s",
        ] {
            let found = critical(requirement);
            assert!(found.contains(&(15.0, false)), "{requirement}: {found:?}");
        }
    }

    #[test]
    fn signals_have_the_bounds_of_their_properties() {
        let own = "expect={satisfied={slow=\"always (World, Monitors, speed_mps < 0.5)\", \
                   brisk=\"always (World, Monitors, speed_mps >= 0.5 implies clearance_m > 0.2)\"}}";
        let header = header(&["properties=[]", own]);
        let found = signals(&header);
        let words: Vec<_> = found.iter().map(|signal| (signal.field.as_str(), signal.bounds.clone())).collect();
        let speed = vec![(0.5, "slow, brisk".to_owned(), true)];
        assert_eq!(words, [("speed_mps", speed), ("clearance_m", vec![(0.2, "brisk".to_owned(), true)])]);
        assert_eq!(found[0].title(&header.topology), "World → Monitors, speed_mps");
    }
}
