//! A leaf as a process of its own.

use std::time::Duration;

use channels::{Action, Envelope, Message, Offer, Pattern, Process, RequestNumber, TransitionId, Use};

use super::patience::Patience;
use super::protocol::{Line, Said, answers, reply_of, request_message, said_message};
use super::whole::tick_number;
use crate::shared::Shared;
use crate::{Fault, NodeId, Reply, Request};

/// The leaf of a tree whose nodes are processes: passes the requests of its parent on to the skill, and the skill's
/// answers back.
///
/// All leaves of one ID are one process, which has a channel from each of their parents: they are one skill, asked from
/// several places, but never from two at a time. (Two processes on one channel would take each other's replies.)
///
/// Between nodes, an envelope's number says how many requests the tree has made so far. It goes down and up with the
/// messages, so that a tree numbers its requests without anybody who counts them all.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct LeafProcess {
    wiring: Shared<Wiring>,
    stage: Stage,
    /// The number of the last request that is known here.
    request: RequestNumber,
    patience: Patience,
    /// The number of the tree's tick in which the leaf was last asked.
    tick: Option<i64>,
    /// What went wrong in that tick.
    faults: Vec<Fault>,
}

#[derive(Debug, PartialEq, Eq)]
struct Wiring {
    id: String,
    skill: Line,
    /// Whether the skill is ever told to halt.
    halts: bool,
    parents: Vec<Parent>,
}

/// Who asks a leaf, and as which node: the first of several.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Parent {
    pub(super) line: Line,
    pub(super) node: NodeId,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Stage {
    Idle,
    /// Asked by this parent, and about to ask the skill.
    Asking(usize, Request),
    /// Waiting for the skill.
    Waiting(usize, Request),
    /// About to answer this parent.
    Answering(usize, Reply),
}

const SEND: TransitionId = TransitionId(0);
const RECEIVE: TransitionId = TransitionId(1);
/// Being asked by the first parent.
const FIRST_PARENT: u32 = 2;

impl LeafProcess {
    pub(super) fn new(id: String, skill: Line, halts: bool, parents: Vec<Parent>, timeout: Duration) -> Self {
        Self {
            wiring: Shared::new(Wiring { id, skill, halts, parents }),
            stage: Stage::Idle,
            request: RequestNumber::default(),
            patience: Patience::new(timeout),
            tick: None,
            faults: Vec::new(),
        }
    }

    /// The answers that did not come, in the last tick of the tree in which the leaf was asked.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// The number of that tick; none before the first.
    #[must_use]
    pub fn tick(&self) -> Option<i64> {
        self.tick
    }

    fn envelope(&self, message: Message) -> Envelope {
        Envelope { message, request: self.request }
    }

    fn take_request(&mut self, parent: usize, envelope: &Envelope, now: Duration) {
        let tick = tick_number(&envelope.message);
        if self.tick != tick {
            self.tick = tick;
            self.faults.clear();
        }
        self.patience.begin(now);
        let request = if envelope.message.head() == Some("halt") { Request::Halt } else { Request::Tick };
        self.request = RequestNumber(envelope.request.0 + 1);
        self.stage = Stage::Asking(parent, request);
    }

    fn answer(&mut self, parent: usize, reply: Reply) {
        self.patience.end();
        self.stage = Stage::Answering(parent, reply);
    }

    fn take_reply(&mut self, envelope: &Envelope) {
        if let Stage::Waiting(parent, request) = self.stage
            && envelope.request == self.request
            && let Some(reply) = reply_of(&envelope.message)
            && answers(reply, request)
        {
            self.answer(parent, reply);
        }
    }
}

impl Process for LeafProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let Wiring { skill, parents, .. } = &**self.wiring;
        let send = |channel, message| Offer { transition: SEND, action: Action::Send(channel, self.envelope(message)) };
        match self.stage {
            Stage::Idle => offers.extend((FIRST_PARENT..).zip(parents).map(|(number, parent)| Offer {
                transition: TransitionId(number),
                action: Action::Receive(parent.line.requests, Pattern::Any),
            })),
            Stage::Asking(_, request) => offers.push(send(skill.requests, request_message(request))),
            Stage::Waiting(..) => {}
            Stage::Answering(parent, reply) => {
                offers.push(send(parents[parent].line.replies, said_message(said_by_leaf(reply))))
            }
        }
        offers.push(Offer { transition: RECEIVE, action: Action::Receive(skill.replies, Pattern::Any) });
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        match (transition, received) {
            (RECEIVE, Some(envelope)) => self.take_reply(&envelope),
            (TransitionId(number), Some(envelope)) => {
                self.take_request((number - FIRST_PARENT) as usize, &envelope, now);
            }
            (_, None) => {
                self.stage = match self.stage {
                    Stage::Asking(parent, request) => Stage::Waiting(parent, request),
                    _ => Stage::Idle,
                }
            }
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.patience.deadline()
    }

    fn fire_timers(&mut self, now: Duration) {
        if let Stage::Asking(parent, request) | Stage::Waiting(parent, request) = self.stage
            && self.patience.is_over(now)
        {
            let message = self.patience.reason(&self.wiring.id, request);
            self.faults.push(Fault { node: self.wiring.parents[parent].node, message });
            self.answer(parent, request.unanswered());
        }
    }

    fn uses(&self) -> Vec<Use> {
        let Wiring { skill, halts, parents, .. } = &**self.wiring;
        let lines = parents.iter().map(|parent| parent.line);
        let parents = lines.flat_map(|line| [Use::Receives(line.requests, None), Use::Sends(line.replies, None)]);
        skill.uses(*halts).chain(parents).collect()
    }

    fn location(&self) -> String {
        match self.stage {
            Stage::Idle => "idle".to_owned(),
            Stage::Asking(_, request) | Stage::Waiting(_, request) => match request {
                Request::Tick => format!("waiting for {}", self.wiring.id),
                Request::Halt => format!("waiting for {} to halt", self.wiring.id),
            },
            Stage::Answering(..) => "answering".to_owned(),
        }
    }
}

/// What a leaf says to its parent.
fn said_by_leaf(reply: Reply) -> Said {
    match reply {
        Reply::Status(status) => Said { status: Some(status), stands: Some(status), again: false },
        Reply::Halted => Said { status: None, stands: None, again: false },
    }
}
