//! The nodes of this participant, as it announces them.

use std::time::{Duration, Instant};

use crate::clock::now;
use crate::domain::exchange::{NODES, NodeNames};
use crate::domain::names;
use crate::domain::nodes::nodes_message;
use crate::domain::readers::Readers;
use crate::domain::writers::Writers;

/// How often the announcement is repeated, and how long after the last one.
const REPETITIONS: u32 = 3;
const REPETITION_PERIOD: Duration = Duration::from_millis(500);

pub(super) struct OwnNodes {
    node: NodeNames,
    /// When they were last announced.
    announced: Option<Instant>,
    /// How often the announcement is still to be repeated.
    repetitions: u32,
}

impl OwnNodes {
    /// They are announced even if they have no readers and writers.
    pub(super) fn of(node: NodeNames) -> Self {
        Self { node, announced: None, repetitions: REPETITIONS }
    }

    pub(super) fn receives_latched(&self) -> bool {
        self.node.receives_latched
    }

    /// Repeats the announcement: a participant that has just appeared may have missed it.
    pub(super) fn repeat(&mut self) {
        self.repetitions = REPETITIONS;
    }

    /// Announces the nodes with the readers and writers of their participant, if those have changed, or if a repetition
    /// is due.
    pub(super) fn announce(
        &mut self,
        participant: &[u8; 16],
        readers: &mut Readers,
        writers: &mut Writers,
    ) -> Result<(), String> {
        let has_changed = readers.has_new || writers.has_new;
        let is_repetition_due =
            self.repetitions > 0 && self.announced.is_none_or(|announced| announced.elapsed() > REPETITION_PERIOD);
        if !has_changed && !is_repetition_due {
            return Ok(());
        }
        self.repetitions = if has_changed { REPETITIONS } else { self.repetitions - 1 };
        self.announced = Some(now());
        let body = nodes_message(participant, &self.node.names, &readers.guids(), &writers.guids());
        (readers.has_new, writers.has_new) = (false, false);
        let kind = names::dds_kind("rmw_dds_common/msg/ParticipantEntitiesInfo");
        writers.write(NODES.to_owned(), kind, true, body)
    }
}
