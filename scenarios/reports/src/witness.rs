//! Why a property is violated, as in `report.json`.

use channels::Topology;
use monitors::{EventTime, Sighting, Witness};
use recording::{Decision, message_json};
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

/// The event that violated a property, and why it did.
#[derive(Clone, Debug)]
pub struct WitnessReport {
    at: EventTime,
    /// The communication that violated it; none if it was a tick.
    pub communication: Option<Sighting>,
    /// Why, if the monitor can explain it.
    pub why: Option<Witness>,
}

impl WitnessReport {
    pub(crate) fn of(Decision { event, witness, .. }: &Decision, topology: &Topology) -> Self {
        let communication = Sighting::of(event, topology);
        Self { at: EventTime::of(event), communication, why: witness.clone() }
    }

    /// As data and in words.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut json = self.why.as_ref().map_or_else(|| moment(&self.at), witness);
        if let Some(Sighting { from, to, message, .. }) = &self.communication {
            json["from"] = from.as_str().into();
            json["to"] = to.as_str().into();
            json["message"] = message_json(message);
        }
        json
    }
}

impl Serialize for WitnessReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_json().serialize(serializer)
    }
}

/// Why a property is violated, as in `report.json`: as data and in words.
pub fn witness(why: &Witness) -> Value {
    let mut witness = moment(&why.settled);
    witness["clause"] = why.clause.as_str().into();
    witness["messages"] = why.messages.iter().map(sighting).collect();
    witness["since_tick"] = why.since.map(|since| since.tick).into();
    witness["deadline_tick"] = why.deadline_tick.into();
    witness["missing"] = why.missing.as_deref().into();
    witness["words"] = why.to_string().into();
    witness
}

fn sighting(seen: &Sighting) -> Value {
    let mut sighting = moment(&seen.at);
    sighting["from"] = seen.from.as_str().into();
    sighting["to"] = seen.to.as_str().into();
    sighting["message"] = message_json(&seen.message);
    sighting
}

fn moment(at: &EventTime) -> Value {
    json!({ "step": at.step, "tick": at.tick, "time_s": at.time.as_secs_f64() })
}
