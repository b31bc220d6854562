//! Faults on channels: what may happen to a message on its way.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{Capacity, ChannelId, Message, Topology, WiringError};

/// Whether a message is concerned.
pub type Concern = Arc<dyn Fn(&Message) -> bool + Send + Sync>;

/// What is put in a message's place.
pub type Corruption = Arc<dyn Fn(&Message) -> Message + Send + Sync>;

/// A fault on a channel of capacity 1: an extra transition of the channel itself.
///
/// While a message that the fault concerns is in the channel, receiving it is not enabled until the channel has taken
/// its own transition ([`EnabledKind::Disturb`](crate::EnabledKind::Disturb)), which the scheduler chooses like any
/// other. Whether a message is concerned is settled when it is sent, so a message that was in the channel before the
/// disturbance began is spared, and so are messages that a disturbance itself puts into a channel. Where several
/// disturbances concern a message, they act one after the other, in the order in which they began, and each sees what
/// the one before has left.
///
/// A disturbance is no event of the timed state sequence: monitors see what the receiver receives.
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
/// let [waits, has_heard] = ["waits", "has heard"].map(|name| receive.location(name));
/// send.send(ready, channel, Message::symbols(["hello"]), sent);
/// receive.receive(waits, channel, Message::symbols(["hello"]), has_heard);
/// let send = GraphProcess::new(Arc::new(send.initial(ready).build()?));
/// let receive = GraphProcess::new(Arc::new(receive.initial(waits).build()?));
/// let processes = [(sender, Box::new(send) as _), (receiver, Box::new(receive) as _)];
/// let mut system = ChannelSystem::new(Arc::new(topology), processes)?;
///
/// let lost = system.disturb(Disturbance::all(channel, Effect::Lose));
/// assert_eq!(system.run(&mut RoundRobin::default(), 100).count(), 0); // nobody hears anything
/// assert_eq!(system.hits(lost), Some(1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Disturbance {
    /// The channel that is disturbed.
    pub channel: ChannelId,
    /// Which of its messages are concerned.
    pub concerns: Concern,
    /// How many of those are hit; all of them, if none.
    pub probability: Option<Chance>,
    /// What happens to them.
    pub effect: Effect,
}

/// A probability, and where its draws come from: one for each message that is concerned.
#[derive(Clone, Debug, PartialEq)]
pub struct Chance {
    /// Between 0, never, and 1, always.
    pub probability: f64,
    /// A stream of random numbers from which nobody else draws.
    pub stream: ChaCha8Rng,
}

/// What happens to a message in a channel.
#[derive(Clone)]
pub enum Effect {
    /// It is taken out; nobody receives it.
    Lose,
    /// It cannot be received before that time after it was sent. Meanwhile the channel is full, so its messages stay in
    /// order.
    Hold(Duration),
    /// Its first delivery leaves it in the channel, so that it is delivered twice.
    Repeat,
    /// Another message takes its place. It has to be one that the channel can carry, else the run ends with
    /// [`RunError::Corrupted`](crate::RunError::Corrupted).
    Replace(Corruption),
    /// It is taken out, and this answer is put into the channel of the opposite direction as soon as that is empty,
    /// with the request's number: a request that somebody pretends to have answered.
    Answer(Message),
}

impl Effect {
    /// The effect in a word: `lose`, `hold`, `repeat`, `replace`, `answer`.
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
    /// That effect on every message of the channel.
    #[must_use]
    pub fn all(channel: ChannelId, effect: Effect) -> Self {
        Self { channel, concerns: Arc::new(|_| true), probability: None, effect }
    }

    /// Checks that the disturbance can take hold in a system of that topology.
    ///
    /// # Errors
    /// [`WiringError::HoldsNothing`] if the channel has capacity 0, [`WiringError::MissingChannel`] if an answer would
    /// have no channel, [`WiringError::OutsideDomain`] if that channel cannot carry the answer.
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

    /// Whether the disturbance hits that message. Draws from its stream if the message is concerned.
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
