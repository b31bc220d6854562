//! Why a property is violated, as in `report.json`.

use channels::Topology;
use diagnostics::seconds;
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
    /// Whether it is known when the tree was ticked.
    pub(crate) knows_ticks: bool,
}

impl WitnessReport {
    pub(crate) fn of(Decision { event, witness, .. }: &Decision, topology: &Topology, knows_ticks: bool) -> Self {
        let communication = Sighting::of(event, topology);
        Self { at: EventTime::of(event), communication, why: witness.clone(), knows_ticks }
    }

    /// In words: as data if the monitor cannot explain it.
    pub(crate) fn in_words(&self) -> String {
        self.why.as_ref().map_or_else(|| self.to_json().to_string(), |why| witness_in_words(why, self.knows_ticks))
    }

    /// As data and in words.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let knows_ticks = self.knows_ticks;
        let mut json = self.why.as_ref().map_or_else(|| moment(&self.at, knows_ticks), |why| witness(why, knows_ticks));
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

/// Why a property is violated, as in `report.json`: as data and in words. `knows_ticks` is whether it is known when
/// the tree was ticked.
pub fn witness(why: &Witness, knows_ticks: bool) -> Value {
    let mut witness = moment(&why.settled, knows_ticks);
    witness["clause"] = why.clause.as_str().into();
    witness["messages"] = why.messages.iter().map(|seen| sighting(seen, knows_ticks)).collect();
    witness["since_tick"] = why.since.map(|since| since.tick).filter(|_| knows_ticks).into();
    witness["deadline_tick"] = why.deadline_tick.filter(|_| knows_ticks).into();
    witness["missing"] = why.missing.as_deref().into();
    witness["words"] = witness_in_words(why, knows_ticks).into();
    witness
}

/// Why a property is violated, in lines.
pub fn witness_in_words(why: &Witness, knows_ticks: bool) -> String {
    if knows_ticks { why.to_string() } else { format!("{why:#}") }
}

fn sighting(seen: &Sighting, knows_ticks: bool) -> Value {
    let mut sighting = moment(&seen.at, knows_ticks);
    sighting["from"] = seen.from.as_str().into();
    sighting["to"] = seen.to.as_str().into();
    sighting["message"] = message_json(&seen.message);
    sighting
}

fn moment(at: &EventTime, knows_ticks: bool) -> Value {
    json!({ "step": at.step, "tick": knows_ticks.then_some(at.tick), "time_s": seconds(at.time) })
}
