//! What has been recorded of a run.

use std::collections::BTreeMap;

use recording::{MonitorLog, Navigation, RobotState};

/// The contents of earlier records: only changes must be recorded again.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    pub(super) outcomes: Vec<Option<bt::Outcome>>,
    /// The entries of the tree's blackboards, by the number of the blackboard and the key.
    pub(super) entries: BTreeMap<(usize, String), bt::Value>,
    /// The locations of skills and components, in the order of their names in the header.
    pub(super) locations: Vec<Option<String>>,
    pub(super) monitors: MonitorLog,
    pub(super) navigation: Option<Navigation>,
    pub(super) robot: RobotState,
    /// Whether the record of the last step had a scene.
    pub(super) scene: bool,
}

impl Recorded {
    /// Nothing has been recorded of a run with this many monitors and this many skills and components.
    pub(super) fn of(monitors: usize, processes: usize) -> Self {
        Self { monitors: MonitorLog::new(monitors), locations: vec![None; processes], ..Self::default() }
    }

    /// The outcomes of the tree's nodes that have changed.
    pub(super) fn new_outcomes(
        &mut self,
        outcomes: impl ExactSizeIterator<Item = Option<bt::Outcome>>,
    ) -> Vec<(usize, Option<bt::Outcome>)> {
        self.outcomes.resize(outcomes.len(), None);
        let is_new = |(node, (outcome, recorded)): (usize, (Option<bt::Outcome>, &mut Option<bt::Outcome>))| {
            (std::mem::replace(recorded, outcome) != outcome).then_some((node, outcome))
        };
        outcomes.zip(&mut self.outcomes).enumerate().filter_map(is_new).collect()
    }
}
