//! Which messages the system of a run could carry.

use std::collections::{BTreeMap, BTreeSet};

use channels::{ChannelId, Shape, Symbol, Topology};

/// By channel, such as `BT → Say`, what its messages can begin with, or else the names of their fields. A log has it,
/// as the scenario may be another one when the log is read: with other topics, or other fields of the world.
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
    let of_shape = |shape: &Shape| match shape.heads() {
        [] => shape.fields().iter().map(|(name, _)| name.clone()).collect::<Vec<_>>(),
        heads => heads.iter().map(Symbol::name).map(str::to_owned).collect(),
    };
    topology.get(channel).domain.shapes().iter().flat_map(of_shape).collect()
}
