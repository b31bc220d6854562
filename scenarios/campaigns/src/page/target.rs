//! Events that can happen in a run, and are counted.

use monitors::Outcome;

use super::super::journal::Layout;
use super::super::{RunOutcome, RunRecord};

/// The violation of a property, or a run that is not as its scenario expects.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    /// The property's name, or `expectation`.
    pub(super) name: String,
    /// The property's index; none for the expectation.
    place: Option<usize>,
}

impl Target {
    pub(super) fn all(layout: &Layout) -> Vec<Self> {
        let property = |(place, name): (usize, &String)| Self { name: name.clone(), place: Some(place) };
        let expectation = Self { name: "expectation".to_owned(), place: None };
        layout.properties.iter().enumerate().map(property).chain([expectation]).collect()
    }

    /// Whether it is the expectation rather than a property.
    pub(super) fn is_expectation(&self) -> bool {
        self.place.is_none()
    }

    /// Whether it happened; none if that is not known because the run failed.
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

    /// The event, in words.
    pub(super) fn event(&self) -> String {
        match self.place {
            Some(_) => format!("{} violated", self.name),
            None => "not as expected".to_owned(),
        }
    }

    /// The absence of the event, in words.
    pub(super) fn absence(&self) -> String {
        match self.place {
            Some(_) => format!("{} not violated", self.name),
            None => "as expected".to_owned(),
        }
    }
}
