//! The faults that took effect in a run.

use std::sync::Arc;
use std::time::Duration;

use maps::Point;

use crate::inconsistent::Inconsistent;
use crate::{Fault, Header};

/// A fault that took effect, and where.
#[derive(Clone, Debug)]
pub struct FaultRecord {
    /// When.
    pub time: Duration,
    /// When it ended; none if it is still active or was momentary.
    pub until: Option<Duration>,
    /// The last tick that had been generated, if any.
    pub tick: Option<u64>,
    /// The fault.
    pub fault: Arc<Fault>,
    /// Its index in the scenario.
    pub index: usize,
    /// Where the robot was, in the `map` frame, if that is known.
    pub position: Option<Point>,
}

/// A fault that was due but could not be injected.
#[derive(Clone, Debug)]
pub struct UndoneFault {
    /// When.
    pub time: Duration,
    /// The fault.
    pub fault: Arc<Fault>,
    /// Why it could not be injected, in words.
    pub reason: String,
}

#[derive(Clone, Debug)]
pub(crate) struct FaultLog {
    /// Those that have taken effect.
    pub(crate) records: Vec<FaultRecord>,
    pub(crate) undone: Vec<UndoneFault>,
    due: Vec<bool>,
    /// Whether a person has caused any of them.
    pub(crate) has_acts: bool,
}

impl FaultLog {
    pub(crate) fn of(header: &Header) -> Self {
        Self { records: Vec::new(), undone: Vec::new(), due: vec![false; header.faults.len()], has_acts: false }
    }

    /// A person adds a fault to the scenario.
    pub(crate) fn add(&mut self) {
        self.due.push(false);
        self.has_acts = true;
    }

    pub(crate) fn begin(&mut self, record: FaultRecord) {
        self.due[record.index] = true;
        self.records.push(record);
    }

    pub(crate) fn end(&mut self, index: usize, time: Duration) -> Result<(), Inconsistent> {
        let latest = self.records.iter_mut().rfind(|record| record.index == index);
        latest.ok_or(Inconsistent)?.until = Some(time);
        Ok(())
    }

    pub(crate) fn leave_undone(&mut self, index: usize, fault: UndoneFault) {
        self.due[index] = true;
        self.undone.push(fault);
    }

    /// Those of the scenario's faults that have not been due.
    pub(crate) fn absent<'a>(&'a self, faults: &'a [Arc<Fault>]) -> impl Iterator<Item = &'a Fault> {
        faults.iter().zip(&self.due).filter(|(_, due)| !**due).map(|(fault, _)| &**fault)
    }
}

/// A fault of the scenario with all its occurrences.
#[derive(Clone, Debug)]
pub struct FaultCourse<'a> {
    /// The fault.
    pub fault: &'a Fault,
    /// The occurrences, in order; at least one.
    pub records: Vec<&'a FaultRecord>,
}

impl<'a> FaultCourse<'a> {
    /// Groups occurrences by fault.
    #[must_use]
    pub fn of(records: &'a [FaultRecord]) -> Vec<Self> {
        let mut courses: Vec<Self> = Vec::new();
        for record in records {
            match courses.iter_mut().find(|course| course.first().index == record.index) {
                Some(course) => course.records.push(record),
                None => courses.push(FaultCourse { fault: &record.fault, records: vec![record] }),
            }
        }
        courses
    }

    /// The first occurrence.
    #[must_use]
    pub fn first(&self) -> &FaultRecord {
        self.records[0]
    }

    /// What the fault did, in words, and how often if more than once.
    #[must_use]
    pub fn words(&self) -> String {
        match self.records.len() {
            1 => self.fault.words.clone(),
            times => format!("{} ({times} times)", self.fault.words),
        }
    }
}
