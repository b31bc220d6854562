//! Which messages the system of a run could carry.

use std::collections::{BTreeMap, BTreeSet};

use channels::{ChannelId, Shape, Topology};

/// By channel, such as `BT → Say`, its messages: how they can begin, and the names of their other fields in
/// order, `moved(state)`. A log has it, as the scenario may be another one when the log is read: with other topics,
/// with fields in another order, or with others of the world.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Carried(BTreeMap<String, BTreeSet<String>>);

impl Carried {
    /// What the channels of this system can carry, apart from those inside of a process.
    #[must_use]
    pub fn by(topology: &Topology) -> Self {
        let mut carried = Self::default();
        for channel in topology.channels().filter(|channel| !topology.is_internal(*channel)) {
            carried.0.entry(name(topology, channel)).or_default().extend(messages(topology, channel));
        }
        carried
    }

    /// As an event log has it.
    ///
    /// # Errors
    /// If the value is something else.
    pub fn read(value: &serde_json::Value) -> Result<Self, serde_json::Error> {
        serde::Deserialize::deserialize(value).map(Self)
    }

    /// As [`read`](Self::read) reads it.
    #[must_use]
    pub fn written(&self) -> serde_json::Value {
        serde_json::json!(self.0)
    }

    /// The channels of this system with messages that are not among them.
    pub fn missing<'t>(&'t self, topology: &'t Topology) -> impl Iterator<Item = ChannelId> + 't {
        topology.channels().filter(move |channel| {
            let known = self.0.get(&name(topology, *channel));
            let is_known = |message: &String| known.is_some_and(|known| known.contains(message));
            !topology.is_internal(*channel) && !messages(topology, *channel).iter().all(is_known)
        })
    }
}

fn name(topology: &Topology, channel: ChannelId) -> String {
    let (from, to) = topology.ends(channel);
    format!("{from} → {to}")
}

fn messages(topology: &Topology, channel: ChannelId) -> Vec<String> {
    let of_shape = |shape: &Shape| {
        let names: Vec<&str> = shape.fields().iter().map(|(name, _)| name.as_str()).collect();
        let message = |head: &str, names: &[&str]| format!("{head}({})", names.join(", "));
        match shape.heads() {
            [] => vec![message("", &names)],
            heads => heads.iter().map(|head| message(head.name(), &names[1..])).collect(),
        }
    };
    topology.get(channel).domain.shapes().iter().flat_map(of_shape).collect()
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, FieldKind};

    use super::*;

    /// The messages of a topic with these fields.
    fn topology(fields: &[&str]) -> Topology {
        let mut topology = Topology::default();
        let [meter, reader] = ["Meter", "Reader"].map(|name| topology.process(name).expect("a new name"));
        let head = [("topic", FieldKind::symbols(["level"]))];
        let shape = Shape::new(head.into_iter().chain(fields.iter().map(|name| (*name, FieldKind::Real))));
        topology.channel(meter, reader, Capacity::One, Domain::new([shape])).expect("a new channel");
        topology
    }

    #[test]
    fn messages_with_other_fields_or_in_another_order_are_others() {
        let carried = Carried::by(&topology(&["charge_pct", "current_a"]));
        assert_eq!(carried.written(), serde_json::json!({ "Meter → Reader": ["level(charge_pct, current_a)"] }));
        let missing = |fields: &[&str]| carried.missing(&topology(fields)).count();
        assert_eq!(missing(&["charge_pct", "current_a"]), 0);
        assert_eq!(missing(&["current_a", "charge_pct"]), 1);
        assert_eq!(missing(&["charge_pct", "power_w"]), 1);
        assert_eq!(Carried::read(&carried.written()).expect("as it was written"), carried);
    }
}
