//! Faults on channels: disturbances of messages in transit.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{Capacity, ChannelId, Message, Topology, WiringError};

/// Decides whether a fault applies to a message.
pub type Concern = Arc<dyn Fn(&Message) -> bool + Send + Sync>;

/// Computes the message that replaces another.
pub type Corruption = Arc<dyn Fn(&Message) -> Message + Send + Sync>;

/// A fault on a channel of capacity 1: an extra transition of the channel itself.
///
/// While the channel holds a message that the fault applies to, the message cannot be received until the channel has
/// taken its own transition ([`EnabledKind::Disturb`](crate::EnabledKind::Disturb)), which the scheduler chooses like
/// any other. Whether the fault applies is decided when the message is sent. A disturbance therefore spares messages
/// that were in the channel before it began, and messages that a disturbance put there. If several disturbances apply
/// to a message, they act in the order in which they began, each on the result of the one before.
///
/// A disturbance is not an event of the timed state sequence: monitors see what the receiver receives.
///
/// ```
/// use std::sync::Arc;
/// use channels::{
///     Capacity, ChannelSystem, Disturbance, Domain, Effect, FieldKind, GraphProcess, Message, ProgramGraph,
///     RoundRobin, Shape, Topology,
/// };
///
/// let mut topology = Topology::default();
/// let [sender, receiver] = [topology.process("Sender")?, topology.process("Receiver")?];
/// let hello = Domain::new([Shape::new([("word", FieldKind::symbols(["hello"]))])]);
/// let channel = topology.channel(sender, receiver, Capacity::One, hello)?;
/// let (mut send, mut receive) = (ProgramGraph::builder("Sender"), ProgramGraph::builder("Receiver"));
/// let [ready, sent] = ["ready", "sent"].map(|name| send.location(name));
/// let [waits, has_received] = ["waits", "has received"].map(|name| receive.location(name));
/// send.send(ready, channel, Message::symbols(["hello"]), sent);
/// receive.receive(waits, channel, Message::symbols(["hello"]), has_received);
/// let send = GraphProcess::new(Arc::new(send.initial(ready).build()?));
/// let receive = GraphProcess::new(Arc::new(receive.initial(waits).build()?));
/// let processes = [(sender, Box::new(send) as _), (receiver, Box::new(receive) as _)];
/// let mut system = ChannelSystem::new(Arc::new(topology), processes)?;
///
/// let lost = system.disturb(Disturbance::all(channel, Effect::Lose));
/// assert_eq!(system.run(&mut RoundRobin::default(), 100).count(), 0); // nothing is received
/// assert_eq!(system.hits(lost), Some(1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Disturbance {
    /// The channel that is disturbed.
    pub channel: ChannelId,
    /// The messages to which the disturbance applies.
    pub concerns: Concern,
    /// The probability that it hits such a message; without one, it hits every one.
    pub probability: Option<Chance>,
    /// What happens to them.
    pub effect: Effect,
}

/// A probability, and the stream of its draws: one draw for each message to which the disturbance applies.
#[derive(Clone, Debug, PartialEq)]
pub struct Chance {
    /// Between 0, never, and 1, always.
    pub probability: f64,
    /// A stream of random numbers from which nothing else draws.
    pub stream: ChaCha8Rng,
}

/// The effect on a message in a channel.
#[derive(Clone)]
pub enum Effect {
    /// The message is removed, and no process receives it.
    Lose,
    /// It cannot be received until this much time after it was sent. Meanwhile, the channel stays full, so messages
    /// keep their order.
    Hold(Duration),
    /// Its first delivery leaves it in the channel, so it is delivered twice.
    Repeat,
    /// Another message takes its place. The channel must be able to carry it; otherwise the run ends with
    /// [`RunError::Corrupted`](crate::RunError::Corrupted).
    Replace(Corruption),
    /// It is removed. As soon as the channel in the opposite direction is empty, this answer is put there with the
    /// request's number, as if the receiver had answered.
    Answer(Message),
}

impl Effect {
    /// The effect in one word: `lose`, `hold`, `repeat`, `replace`, `answer`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Lose => "lose",
            Self::Hold(_) => "hold",
            Self::Repeat => "repeat",
            Self::Replace(_) => "replace",
            Self::Answer(_) => "answer",
        }
    }
}

impl Disturbance {
    /// The effect, applied to every message of the channel.
    #[must_use]
    pub fn all(channel: ChannelId, effect: Effect) -> Self {
        Self { channel, concerns: Arc::new(|_| true), probability: None, effect }
    }

    /// Checks that the disturbance is possible in a system with this topology.
    ///
    /// # Errors
    /// [`WiringError::HoldsNothing`] if the channel has capacity 0, [`WiringError::MissingChannel`] if there is no
    /// channel for an answer, [`WiringError::OutsideDomain`] if that channel cannot carry the answer.
    pub fn check(&self, topology: &Topology) -> Result<(), WiringError> {
        if topology.get(self.channel).capacity == Capacity::Zero {
            return Err(WiringError::HoldsNothing { channel: topology.describe(self.channel) });
        }
        let Effect::Answer(answer) = &self.effect else { return Ok(()) };
        let process = topology.name(topology.get(self.channel).target).to_owned();
        let Some(opposite) = topology.opposite(self.channel) else {
            let asking = topology.name(topology.get(self.channel).source);
            return Err(WiringError::MissingChannel { channel: format!("{process} → {asking}"), process });
        };
        if topology.carries(opposite, answer) {
            return Ok(());
        }
        Err(WiringError::OutsideDomain {
            process,
            message: answer.clone(),
            channel: topology.describe(opposite),
            domain: topology.get(opposite).domain.to_string(),
        })
    }

    /// Whether the disturbance hits the message. Draws from its stream if the disturbance applies to the message.
    pub(crate) fn hits(&mut self, message: &Message) -> bool {
        (self.concerns)(message)
            && self.probability.as_mut().is_none_or(|chance| chance.stream.random::<f64>() < chance.probability)
    }
}

impl fmt::Debug for Disturbance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Disturbance")
            .field("channel", &self.channel)
            .field("probability", &self.probability.as_ref().map(|chance| chance.probability))
            .field("effect", &self.effect)
            .finish_non_exhaustive()
    }
}

impl fmt::Debug for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lose | Self::Repeat | Self::Replace(_) => f.write_str(self.name()),
            Self::Hold(time) => write!(f, "hold {time:?}"),
            Self::Answer(answer) => write!(f, "answer {answer}"),
        }
    }
}
