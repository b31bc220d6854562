//! A leaf as a separate process.

use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, RequestNumber, Shared,
    TransitionId, Use, Value,
};

use super::board::{inputs_question, outputs_question};
use super::patience::Patience;
use super::protocol::{ChannelPair, NodeReply, Skill, answers, number, reply_of, request_message};
use crate::{Fault, Reply, Request};

/// The leaf of a tree whose nodes are processes: passes its parent's requests on to the skill, and the skill's answers
/// back. It asks the [`BlackboardProcess`](super::BlackboardProcess) to read and write its ports.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct LeafProcess {
    wiring: Shared<LeafWiring>,
    stage: Stage,
    /// The number of the last request to the skill.
    request: RequestNumber,
    patience: Patience,
    /// The number of the tree's tick in which the leaf was last asked.
    tick: Option<i64>,
    /// The faults in that tick.
    faults: Vec<Fault>,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct LeafWiring {
    pub(super) skill: Skill,
    /// To the process that sends requests to the leaf.
    pub(super) parent: ChannelPair,
    /// If the leaf has ports connected to blackboard entries.
    pub(super) board: Option<ChannelPair>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Stage {
    Idle,
    /// About to ask the blackboard for the inputs.
    Reading,
    /// Waiting for them.
    Read,
    /// About to ask the skill.
    Asking(Request, Message),
    /// Waiting for the skill.
    Waiting(Request),
    /// About to send the outputs to the blackboard, with the skill's answer.
    Writing(Reply, Message),
    /// Waiting until they are written.
    Written(Reply),
    /// About to answer.
    Answering(Reply),
}

const ASKED: TransitionId = TransitionId(0);
const SEND: TransitionId = TransitionId(1);
const ANSWERED: TransitionId = TransitionId(2);
const BOARD_ANSWERED: TransitionId = TransitionId(3);

impl LeafProcess {
    pub(super) fn new(wiring: LeafWiring, timeout: Duration) -> Self {
        Self {
            wiring: Shared::new(wiring),
            stage: Stage::Idle,
            request: RequestNumber::default(),
            patience: Patience::new(timeout),
            tick: None,
            faults: Vec::new(),
        }
    }

    /// The missing answers in the last tick of the tree in which the leaf was asked.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// The number of that tick; `None` before the first.
    #[must_use]
    pub fn tick(&self) -> Option<i64> {
        self.tick
    }

    fn take_request(&mut self, envelope: &Envelope, now: Duration) {
        let tick = number(&envelope.message, 2);
        if self.tick != tick {
            self.tick = tick;
            self.faults.clear();
        }
        if envelope.message.head() == Some("halt") {
            self.ask(Request::Halt, Vec::new(), now);
        } else if self.wiring.skill.traffic.reads() {
            self.stage = Stage::Reading;
        } else {
            self.ask(Request::Tick, Vec::new(), now);
        }
    }

    fn ask(&mut self, request: Request, inputs: Vec<Value>, now: Duration) {
        self.request.0 += 1;
        self.patience.begin(now);
        self.stage = Stage::Asking(request, request_message(request, inputs));
    }

    fn take_reply(&mut self, envelope: Envelope) {
        if let Stage::Waiting(request) = self.stage
            && envelope.request == self.request
            && let Some(reply) = reply_of(&envelope.message)
            && answers(reply, request)
        {
            self.patience.end();
            let writes = self.wiring.board.is_some() && self.wiring.skill.traffic.writes();
            self.stage = if writes { Stage::Writing(reply, envelope.message) } else { Stage::Answering(reply) };
        }
    }

    /// Handles an answer of the blackboard. Its faults are recorded by the blackboard.
    fn take_board_answer(&mut self, message: &Message, now: Duration) {
        let failed = message.head() == Some("fault");
        match self.stage {
            Stage::Read if failed => self.stage = Stage::Answering(Request::Tick.unanswered()),
            Stage::Read => self.ask(Request::Tick, message.fields().get(1..).unwrap_or_default().to_vec(), now),
            Stage::Written(Reply::Status(_)) if failed => self.stage = Stage::Answering(Request::Tick.unanswered()),
            Stage::Written(reply) => self.stage = Stage::Answering(reply),
            _ => {}
        }
    }
}

impl Process for LeafProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let LeafWiring { skill, parent, board } = &**self.wiring;
        let receive = |transition, channel| Offer { transition, action: Action::Receive(channel, Pattern::Any) };
        let send =
            |channel, message: Message| Offer { transition: SEND, action: Action::Send(channel, message.into()) };
        offers.extend(match &self.stage {
            Stage::Idle => Some(receive(ASKED, parent.requests)),
            Stage::Reading => board.map(|board| send(board.requests, inputs_question(skill.leaf))),
            Stage::Writing(_, answer) => board.map(|board| send(board.requests, outputs_question(skill.leaf, answer))),
            Stage::Read | Stage::Written(_) => board.map(|board| receive(BOARD_ANSWERED, board.replies)),
            Stage::Asking(_, message) => {
                let envelope = Envelope { message: message.clone(), request: self.request };
                Some(Offer { transition: SEND, action: Action::Send(skill.channels.requests, envelope) })
            }
            Stage::Waiting(_) => None,
            Stage::Answering(reply) => Some(send(parent.replies, node_reply(*reply).message())),
        });
        offers.push(receive(ANSWERED, skill.channels.replies));
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        match (transition, received) {
            (ANSWERED, Some(envelope)) => self.take_reply(envelope),
            (BOARD_ANSWERED, Some(envelope)) => self.take_board_answer(&envelope.message, now),
            (_, Some(envelope)) => self.take_request(&envelope, now),
            (_, None) => {
                self.stage = match std::mem::replace(&mut self.stage, Stage::Idle) {
                    Stage::Reading => Stage::Read,
                    Stage::Asking(request, _) => Stage::Waiting(request),
                    Stage::Writing(reply, _) => Stage::Written(reply),
                    _ => Stage::Idle,
                }
            }
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.patience.deadline()
    }

    fn fire_timers(&mut self, now: Duration) {
        if let Stage::Asking(request, _) | Stage::Waiting(request) = self.stage
            && self.patience.is_over(now)
        {
            let Skill { leaf, process, .. } = &self.wiring.skill;
            let message = self.patience.reason(process, request);
            self.faults.push(Fault { node: *leaf, message });
            self.patience.end();
            self.stage = Stage::Answering(request.unanswered());
        }
    }

    fn uses(&self) -> Vec<Use> {
        let LeafWiring { skill, parent, board } = &**self.wiring;
        let parent = [Use::Receives(parent.requests, None), Use::Sends(parent.replies, None)];
        let board = board.iter().flat_map(|pair| [Use::Sends(pair.requests, None), Use::Receives(pair.replies, None)]);
        skill.uses().chain(parent).chain(board).collect()
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        if let Stage::Asking(..) | Stage::Waiting(_) = self.stage {
            requests.push((self.wiring.skill.channels.requests, self.request));
        }
    }

    /// Faults and the number of a tick are only reported.
    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        form.number(self.wiring.skill.channels.requests, &mut self.request);
        self.patience.normalize(form);
        self.tick = None;
        self.faults.clear();
        Ok(())
    }

    fn location(&self) -> String {
        let process = &self.wiring.skill.process;
        match self.stage {
            Stage::Idle => "idle".to_owned(),
            Stage::Reading | Stage::Read | Stage::Writing(..) | Stage::Written(_) => {
                "waiting for the blackboard".to_owned()
            }
            Stage::Asking(Request::Tick, _) | Stage::Waiting(Request::Tick) => format!("waiting for {process}"),
            Stage::Asking(Request::Halt, _) | Stage::Waiting(Request::Halt) => format!("waiting for {process} to halt"),
            Stage::Answering(_) => "answering".to_owned(),
        }
    }
}

/// A leaf's answer to its parent.
fn node_reply(reply: Reply) -> NodeReply {
    match reply {
        Reply::Status(status) => NodeReply { status: Some(status), own_status: Some(status), again: false },
        Reply::Halted => NodeReply { status: None, own_status: None, again: false },
    }
}
