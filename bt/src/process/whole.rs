//! A tree as one process.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, RequestNumber, Shared,
    Topology, TransitionId, Use, WiringError,
};

use super::patience::{LEAF_TIMEOUT, Patience};
use super::protocol::{Skill, answers, find_channel, number, reply_of, request_message};
use crate::{Blackboard, Call, Execution, Fault, NodeId, NodeState, PortError, Progress, Request, Tree};

/// A tree as one process.
///
/// It waits for a tick, and then makes one leaf call after another: it sends a request, waits for the answer, and
/// continues until the tick is finished. After that, it takes the next tick. The requests to each skill are numbered
/// from 1; the skill repeats the number of the request that it answers. A reply with another number, or one that does
/// not answer the request, is received and dropped. If a leaf does not answer within [`LEAF_TIMEOUT`] (or the time set
/// by [`with_leaf_timeout`](Self::with_leaf_timeout)), the tree continues without its answer.
///
/// ```
/// use std::sync::Arc;
/// use bt::{Tree, TreeProcess, declare_channels};
/// use channels::{Process, Topology};
///
/// let tree = Tree::from_xml("knock.xml", r#"<root BTCPP_format="4">
///     <BehaviorTree ID="Knock"> <Action ID="KnockAtDoor"/> </BehaviorTree>
/// </root>"#)?;
/// let mut topology = Topology::default();
/// let [ticks, bt] = [topology.process("TickGenerator")?, topology.process("BT")?];
/// topology.process("KnockAtDoor")?; // the skill, which has the leaf's name, or else its ID
/// declare_channels(&tree, &mut topology, bt, ticks)?;
/// let process = TreeProcess::new(Arc::new(tree), &topology, "BT", "TickGenerator")?;
/// assert_eq!(process.location(), "idle");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TreeProcess {
    wiring: Shared<TreeWiring>,
    execution: Execution,
    /// The number of the last request to each skill.
    requests: Box<[RequestNumber]>,
    /// The message of the pending call.
    message: Option<Message>,
    is_sent: bool,
    patience: Patience,
    tick: Option<i64>,
}

#[derive(Debug, PartialEq, Eq)]
struct TreeWiring {
    ticks: ChannelId,
    /// In document order.
    skills: Vec<Skill>,
    /// The messages to leaves that read nothing, created once.
    tick: Message,
    halt: Message,
}

impl TreeWiring {
    /// The index of a leaf's skill.
    fn place(&self, leaf: NodeId) -> usize {
        let place = self.skills.binary_search_by_key(&leaf, |skill| skill.leaf);
        place.expect("every leaf of the tree has a skill")
    }
}

/// Receiving a tick.
const TICK: TransitionId = TransitionId(0);
/// Sending the pending call.
const SEND: TransitionId = TransitionId(1);
/// Receiving a reply from the first skill; the others follow.
const FIRST_REPLY: u32 = 2;

impl TreeProcess {
    /// The process `bt` of this tree, which the process `tick_generator` ticks, on channels that are already declared
    /// (see [`declare_channels`](crate::declare_channels)).
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if one of them is not.
    pub fn new(tree: Arc<Tree>, topology: &Topology, bt: &str, tick_generator: &str) -> Result<Self, WiringError> {
        let skills = tree.leaves().map(|leaf| Skill::find(&tree, leaf, topology, bt));
        let skills: Vec<Skill> = skills.collect::<Result<_, _>>()?;
        let ticks = find_channel(topology, bt, tick_generator, bt)?;
        let [tick, halt] = [Request::Tick, Request::Halt].map(|request| request_message(request, Vec::new()));
        Ok(Self {
            requests: vec![RequestNumber::default(); skills.len()].into(),
            wiring: Shared::new(TreeWiring { ticks, skills, tick, halt }),
            execution: Execution::new(tree),
            message: None,
            is_sent: false,
            patience: Patience::new(LEAF_TIMEOUT),
            tick: None,
        })
    }

    /// The same tree, with another timeout for leaves' answers.
    #[must_use]
    pub fn with_leaf_timeout(mut self, timeout: Duration) -> Self {
        self.patience = Patience::new(timeout);
        self
    }

    /// The running tree.
    #[must_use]
    pub fn execution(&self) -> &Execution {
        &self.execution
    }

    /// The blackboard, for writing while the system is quiet.
    pub fn blackboard_mut(&mut self) -> &mut Blackboard {
        self.execution.blackboard_mut()
    }

    /// The running tree, for noting changes of status.
    pub(super) fn execution_mut(&mut self) -> &mut Execution {
        &mut self.execution
    }

    /// The states of all nodes, in document order.
    #[must_use]
    pub fn states(&self) -> Vec<NodeState> {
        self.execution.states()
    }

    /// The faults in the last tick, including missing answers of leaves.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        self.execution.faults()
    }

    /// The number of the last tick received; `None` before the first.
    #[must_use]
    pub fn tick(&self) -> Option<i64> {
        self.tick
    }

    fn pending_request(&self) -> Option<(ChannelId, Envelope)> {
        let place = self.wiring.place(self.execution.pending()?.leaf);
        let envelope = Envelope { message: self.message.clone()?, request: self.requests[place] };
        Some((self.wiring.skills[place].channels.requests, envelope))
    }

    fn go_on(&mut self, mut step: Option<Progress>, now: Duration) {
        while let Some(Progress::Call(call)) = step {
            match self.message_of(call) {
                Ok(message) => {
                    self.message = Some(message);
                    self.requests[self.wiring.place(call.leaf)].0 += 1;
                    self.is_sent = false;
                    return self.patience.begin(now);
                }
                // The leaf is not even asked.
                Err(error) => step = self.execution.give_up(now, error.to_string()),
            }
        }
        if step.is_some() {
            self.message = None;
            self.patience.end();
        }
    }

    fn message_of(&self, call: Call) -> Result<Message, PortError> {
        let traffic = &self.wiring.skills[self.wiring.place(call.leaf)].traffic;
        match call.request {
            Request::Halt => Ok(self.wiring.halt.clone()),
            Request::Tick if !traffic.reads() => Ok(self.wiring.tick.clone()),
            Request::Tick => Ok(request_message(Request::Tick, traffic.read(self.execution.blackboard())?)),
        }
    }

    fn receive_reply(&mut self, place: usize, envelope: &Envelope, now: Duration) {
        let wiring = Shared::clone(&self.wiring);
        let skill = &wiring.skills[place];
        let Some(call) = self.execution.pending().filter(|call| self.is_sent && call.leaf == skill.leaf) else {
            return;
        };
        // A reply that does not answer the request leaves the execution unchanged.
        let answer = reply_of(&envelope.message).filter(|reply| answers(*reply, call.request));
        let Some(reply) = answer.filter(|_| envelope.request == self.requests[place]) else { return };
        let outputs = envelope.message.fields().get(1..).unwrap_or_default();
        let step = match skill.traffic.write(outputs, self.execution.blackboard_mut()) {
            Ok(()) => self.execution.resume(now, reply),
            Err(error) => self.execution.give_up(now, error.to_string()),
        };
        self.go_on(step, now);
    }
}

impl Process for TreeProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        match self.pending_request() {
            None => offers.push(Offer { transition: TICK, action: Action::Receive(self.wiring.ticks, Pattern::Any) }),
            Some((channel, envelope)) if !self.is_sent => {
                offers.push(Offer { transition: SEND, action: Action::Send(channel, envelope) });
            }
            Some(_) => {}
        }
        offers.extend((FIRST_REPLY..).zip(&self.wiring.skills).map(|(number, skill)| Offer {
            transition: TransitionId(number),
            action: Action::Receive(skill.channels.replies, Pattern::Any),
        }));
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        match (transition, received) {
            (SEND, _) => self.is_sent = true,
            (TICK, Some(envelope)) => {
                self.tick = number(&envelope.message, 2);
                let step = self.execution.start_tick(now);
                self.go_on(step, now);
            }
            (TransitionId(number), Some(envelope)) => {
                self.receive_reply((number - FIRST_REPLY) as usize, &envelope, now)
            }
            (_, None) => {}
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.patience.deadline()
    }

    fn fire_timers(&mut self, now: Duration) {
        let Some(call) = self.execution.pending().filter(|_| self.patience.is_over(now)) else { return };
        let reason = self.patience.reason(self.execution.tree().node(call.leaf).process(), call.request);
        let step = self.execution.give_up(now, reason);
        self.go_on(step, now);
    }

    fn uses(&self) -> Vec<Use> {
        let on_lines = self.wiring.skills.iter().flat_map(Skill::uses);
        std::iter::once(Use::Receives(self.wiring.ticks, None)).chain(on_lines).collect()
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        requests.extend(self.pending_request().map(|(channel, envelope)| (channel, envelope.request)));
    }

    /// The number of a tick is only reported.
    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        for (skill, number) in self.wiring.skills.iter().zip(&mut self.requests) {
            form.number(skill.channels.requests, number);
        }
        self.is_sent &= self.message.is_some();
        self.patience.normalize(form);
        self.tick = None;
        self.execution.normalize(form);
        Ok(())
    }

    fn location(&self) -> String {
        let Some(call) = self.execution.pending() else { return "idle".to_owned() };
        let leaf = self.execution.tree().node(call.leaf).process();
        match call.request {
            Request::Tick => format!("waiting for {leaf}"),
            Request::Halt => format!("waiting for {leaf} to halt"),
        }
    }
}
