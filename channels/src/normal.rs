//! The normal form of a state: what all situations that continue alike have in common.

use std::time::Duration;

use crate::{ChannelId, Envelope, RequestNumber, Role, Topology};

/// Makes the state space finite: a system whose step, tick and request numbers grow forever visits finitely many normal
/// forms.
///
/// - A request number only identifies an open request. In a normal form, the requests on a channel that still
///   [await](crate::Process::awaits) an answer are numbered from 1, and every other number is 0, since it is not
///   awaited.
/// - A point in time counts only by its distance. In a normal form it is always [`NOW`](Self::NOW).
/// - State that is only reported, and has no effect on the future (the number of a tick, faults of a tree, notes of a
///   machine), is forgotten.
///
/// [`Process::normalize`](crate::Process::normalize) brings one process into normal form,
/// [`ChannelSystem::normalize`](crate::ChannelSystem::normalize) the whole system.
#[derive(Clone, Copy)]
pub struct NormalForm<'a> {
    topology: &'a Topology,
    now: Duration,
    numbers: &'a dyn Fn(ChannelId, RequestNumber) -> RequestNumber,
}

impl<'a> NormalForm<'a> {
    /// The present time in every normal form: late enough for everything that came before.
    pub const NOW: Duration = Duration::from_secs(1 << 32);

    /// The number of messages that may wait in a process. More are considered endless: a search reports them, and does
    /// not look at what follows. Chosen, not measured: each length of a queue is a state of its own.
    pub const QUEUE: usize = 32;

    /// The normal form at the time `now`. `numbers` gives the new number of a request on a channel.
    pub fn new(
        topology: &'a Topology,
        now: Duration,
        numbers: &'a dyn Fn(ChannelId, RequestNumber) -> RequestNumber,
    ) -> Self {
        Self { topology, now, numbers }
    }

    /// Brings a point in time into normal form.
    pub fn time(&self, time: &mut Duration) {
        *time = Self::NOW.saturating_add(time.saturating_sub(self.now)).saturating_sub(self.now.saturating_sub(*time));
    }

    /// Brings the number of a request on this channel into normal form.
    pub fn number(&self, requests: ChannelId, number: &mut RequestNumber) {
        *number = (self.numbers)(requests, *number);
    }

    /// Brings the number of a message on this channel into normal form: that of a request, or of an answer to one in
    /// the opposite direction.
    pub fn envelope(&self, channel: ChannelId, envelope: &mut Envelope) {
        let role = self.topology.get(channel).domain.shape_of(&envelope.message).map(crate::Shape::role);
        let is_answer = matches!(role, Some(Role::Reply | Role::Feedback | Role::Result));
        let requests = self.topology.opposite(channel).filter(|_| is_answer).unwrap_or(channel);
        self.number(requests, &mut envelope.request);
    }

    /// Checks that a queue is not endless.
    ///
    /// # Errors
    /// [`NoNormalForm::Endless`] if more than [`QUEUE`](Self::QUEUE) messages wait.
    pub fn queue(&self, length: usize, what: impl FnOnce() -> String) -> Result<(), NoNormalForm> {
        if length <= Self::QUEUE { Ok(()) } else { Err(NoNormalForm::Endless { what: what() }) }
    }
}

/// Why a process has no normal form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoNormalForm {
    /// Its state has no finite form.
    #[error("{reason}")]
    Unsupported {
        /// The reason, as a phrase that starts in lower case and has no full stop: `it draws random numbers`.
        reason: String,
        /// How to fix it.
        help: Option<String>,
    },
    /// Messages pile up in it: more of them wait than a search follows.
    #[error("{what}")]
    Endless {
        /// Which ones: `more than 32 messages to Navigation wait`.
        what: String,
    },
}
