//! Events that can happen in a run, and are counted.

use monitors::Outcome;

use super::super::journal::Layout;
use super::super::{RunOutcome, RunRecord};

/// A property's violation, or that a run is not what its scenario expects.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    /// The property's name, or `expectation`.
    pub(super) name: String,
    /// The property's place; none for the expectation.
    place: Option<usize>,
}

impl Target {
    /// All targets of a campaign.
    pub(super) fn all(layout: &Layout) -> Vec<Self> {
        let property = |(place, name): (usize, &String)| Self { name: name.clone(), place: Some(place) };
        let expectation = Self { name: "expectation".to_owned(), place: None };
        layout.properties.iter().enumerate().map(property).chain([expectation]).collect()
    }

    /// Whether it is the expectation, and no property.
    pub(super) fn is_expectation(&self) -> bool {
        self.place.is_none()
    }

    /// Whether it happened; none if the run failed, and nobody knows.
    pub(super) fn happened(&self, record: &RunRecord) -> Option<bool> {
        match self.place {
            Some(place) => Some(record.facts.as_ref()?.monitors.get(place)?.verdict == Outcome::Violated),
            None => Some(record.outcome != RunOutcome::AsExpected),
        }
    }

    /// Time from the first fault's onset to the violation, in seconds.
    pub(super) fn latency_s(&self, record: &RunRecord) -> Option<f64> {
        record.facts.as_ref()?.monitors.get(self.place?)?.latency_s
    }

    /// Time of the violation, in seconds.
    pub(super) fn time_s(&self, record: &RunRecord) -> Option<f64> {
        record.facts.as_ref()?.monitors.get(self.place?)?.time_s
    }

    /// That it happens, as a noun.
    pub(super) fn event(&self) -> String {
        match self.place {
            Some(_) => format!("{} violated", self.name),
            None => "not as expected".to_owned(),
        }
    }

    /// That it does not happen.
    pub(super) fn absence(&self) -> String {
        match self.place {
            Some(_) => format!("{} not violated", self.name),
            None => "as expected".to_owned(),
        }
    }
}
