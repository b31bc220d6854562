//! The processes and the channels that connect them.

use serde::{Deserialize, Serialize};

use crate::{Domain, Message, Shape, WiringError};

/// A process of a system, as an index into the [`Topology`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ProcessId(pub(crate) usize);

impl ProcessId {
    /// Position among the processes of the topology, in the order they were declared.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

/// A channel of a system, as an index into the [`Topology`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ChannelId(pub(crate) usize);

impl ChannelId {
    /// Position among the channels of the topology, in the order they were declared.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

/// How many messages a channel can hold, cap((p, q)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Capacity {
    /// None: sender and receiver move together (handshake).
    Zero,
    /// One: sending fills the channel, receiving empties it (asynchronous message passing). While a message waits, only
    /// a newer message of the same [topic](crate::Role::Topic) can be sent, which replaces it.
    One,
}

/// A channel (p, q) with its capacity and domain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The process that sends.
    pub source: ProcessId,
    /// The process that receives.
    pub target: ProcessId,
    /// How many messages it can hold.
    pub capacity: Capacity,
    /// Which messages it may carry.
    pub domain: Domain,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Declaration {
    name: String,
    /// The process that this one is part of; itself if it is not part of another.
    whole: ProcessId,
    is_outside: bool,
    other_names: Vec<String>,
}

/// The processes and channels of a system, by name: the static structure.
///
/// A process may be composed of member processes, as a tree is of its nodes. Members use the channels of the whole.
/// Communication between members is internal and not part of the timed state sequence.
///
/// ```
/// use channels::{Capacity, Domain, FieldKind, Shape, Topology};
///
/// let mut topology = Topology::default();
/// let skill = topology.process("BatteryLevel")?;
/// let reader = topology.process("BatteryReader")?;
/// let request = Domain::new([Shape::new([("request", FieldKind::symbols(["get_level"]))])]);
/// let asked = topology.channel(skill, reader, Capacity::One, request)?;
/// assert_eq!(topology.find_channel("BatteryLevel", "BatteryReader"), Some(asked));
/// # Ok::<(), channels::WiringError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Topology {
    processes: Vec<Declaration>,
    channels: Vec<Channel>,
    /// The topics that processes publish, whether or not any process has subscribed.
    topics: Vec<(ProcessId, Shape)>,
    /// The requests that processes understand, whether or not any process sends them.
    requests: Vec<(ProcessId, Shape)>,
    /// The answers that processes give to these, whether or not any process sends them.
    answers: Vec<(ProcessId, Shape)>,
}

impl Topology {
    /// Declares a process.
    ///
    /// # Errors
    /// [`WiringError::DuplicateProcess`] if the name is taken.
    pub fn process(&mut self, name: &str) -> Result<ProcessId, WiringError> {
        let id = ProcessId(self.processes.len());
        self.declare(name, id)
    }

    /// Declares a process outside the system: it has no behavior and never moves. Between two such processes, monitors
    /// alone [are shown](crate::ChannelSystem::show) messages, such as what is true in the world; there are no channels
    /// to others.
    ///
    /// # Errors
    /// [`WiringError::DuplicateProcess`] if the name is taken.
    pub fn outside(&mut self, name: &str) -> Result<ProcessId, WiringError> {
        let id = self.process(name)?;
        self.processes[id.0].is_outside = true;
        Ok(id)
    }

    /// Declares a process that is part of `whole`.
    ///
    /// # Errors
    /// [`WiringError::DuplicateProcess`] if the name is taken.
    pub fn member(&mut self, whole: ProcessId, name: &str) -> Result<ProcessId, WiringError> {
        self.declare(name, whole)
    }

    fn declare(&mut self, name: &str, whole: ProcessId) -> Result<ProcessId, WiringError> {
        if self.find_process(name).is_some() {
            return Err(WiringError::DuplicateProcess { name: name.to_owned() });
        }
        let name = name.to_owned();
        self.processes.push(Declaration { name, whole, is_outside: false, other_names: Vec::new() });
        Ok(ProcessId(self.processes.len() - 1))
    }

    /// Lets people call a process by these names, its own among them, from the most specific to the most general.
    /// Other processes may have the same ones.
    pub fn call(&mut self, process: ProcessId, names: Vec<String>) {
        self.processes[process.0].other_names = names;
    }

    /// The names by which people [may call](Self::call) a process; none if only by its own.
    #[must_use]
    pub fn other_names(&self, process: ProcessId) -> &[String] {
        &self.processes[process.0].other_names
    }

    /// The processes that a name may mean: those for which it is the most specific.
    #[must_use]
    pub fn meant_by(&self, name: &str) -> Vec<ProcessId> {
        let own = self.find_process(name).filter(|process| self.other_names(*process).is_empty());
        if let Some(own) = own {
            return vec![own];
        }
        let place = |process: ProcessId| self.other_names(process).iter().position(|other| other == name);
        let places: Vec<_> = self.processes().filter_map(|process| Some((place(process)?, process))).collect();
        let first = places.iter().map(|(place, _)| *place).min();
        places.into_iter().filter(|(place, _)| Some(*place) == first).map(|(_, process)| process).collect()
    }

    /// Declares the channel from `source` to `target`.
    ///
    /// # Errors
    /// [`WiringError::SelfChannel`] if both ends are the same process, [`WiringError::DuplicateChannel`] if the channel
    /// already exists, [`WiringError::Outside`] if only one end is [outside](Self::outside) the system.
    pub fn channel(
        &mut self,
        source: ProcessId,
        target: ProcessId,
        capacity: Capacity,
        domain: Domain,
    ) -> Result<ChannelId, WiringError> {
        if source == target {
            return Err(WiringError::SelfChannel { process: self.name(source).to_owned() });
        }
        if self.channels.iter().any(|channel| (channel.source, channel.target) == (source, target)) {
            let [source, target] = [source, target].map(|end| self.name(end).to_owned());
            return Err(WiringError::DuplicateChannel { source_process: source, target_process: target });
        }
        if self.is_outside(source) != self.is_outside(target) {
            let [source, target] = [source, target].map(|end| self.name(end).to_owned());
            return Err(WiringError::Outside { source_process: source, target_process: target });
        }
        self.channels.push(Channel { source, target, capacity, domain });
        Ok(ChannelId(self.channels.len() - 1))
    }

    /// Declares a topic that the process publishes to every process to which it has a channel that carries the topic.
    pub fn publish(&mut self, process: ProcessId, topic: Shape) {
        self.topics.push((process, topic));
    }

    /// The topics that a process publishes, in the order they were declared.
    pub fn topics(&self, process: ProcessId) -> impl Iterator<Item = &Shape> {
        self.topics.iter().filter(move |(publisher, _)| *publisher == process).map(|(_, topic)| topic)
    }

    /// The topics that a process publishes and no channel carries: nothing reads them.
    pub fn unread_topics(&self, process: ProcessId) -> impl Iterator<Item = &Shape> {
        let from_here = move |channel: &&Channel| channel.source == process;
        let carried = move |topic: &Shape| {
            self.channels.iter().filter(from_here).any(|channel| channel.domain.shapes().contains(topic))
        };
        self.topics(process).filter(move |topic| !carried(topic))
    }

    /// Declares a request that the process understands from any process that has a channel for it.
    pub fn understand(&mut self, process: ProcessId, request: Shape) {
        self.requests.push((process, request));
    }

    /// The requests that a process understands, in the order they were declared.
    pub fn understood(&self, process: ProcessId) -> impl Iterator<Item = &Shape> {
        self.requests.iter().filter(move |(server, _)| *server == process).map(|(_, request)| request)
    }

    /// Declares an answer that the process gives to requests that it understands.
    pub fn answer(&mut self, process: ProcessId, answer: Shape) {
        self.answers.push((process, answer));
    }

    /// The answers that a process gives, in the order they were declared.
    pub fn answers(&self, process: ProcessId) -> impl Iterator<Item = &Shape> {
        self.answers.iter().filter(move |(server, _)| *server == process).map(|(_, answer)| answer)
    }

    /// The process with this name.
    #[must_use]
    pub fn find_process(&self, name: &str) -> Option<ProcessId> {
        self.processes.iter().position(|process| process.name == name).map(ProcessId)
    }

    /// The channel between the processes with these names.
    #[must_use]
    pub fn find_channel(&self, source: &str, target: &str) -> Option<ChannelId> {
        let ends = (self.find_process(source)?, self.find_process(target)?);
        self.channels.iter().position(|channel| (channel.source, channel.target) == ends).map(ChannelId)
    }

    /// The channel between the same processes in the opposite direction.
    #[must_use]
    pub fn opposite(&self, channel: ChannelId) -> Option<ChannelId> {
        let Channel { source, target, .. } = *self.get(channel);
        let is_opposite = |other: &Channel| (other.source, other.target) == (target, source);
        self.channels.iter().position(is_opposite).map(ChannelId)
    }

    /// The name of a process.
    #[must_use]
    pub fn name(&self, process: ProcessId) -> &str {
        &self.processes[process.0].name
    }

    /// Whether the process is [outside](Self::outside) the system.
    #[must_use]
    pub fn is_outside(&self, process: ProcessId) -> bool {
        self.processes[process.0].is_outside
    }

    /// The process that `process` is part of; itself if it is not part of another.
    #[must_use]
    pub fn whole(&self, process: ProcessId) -> ProcessId {
        self.processes[process.0].whole
    }

    /// Whether the process may use this end of a channel: it is the end, or a part of it.
    #[must_use]
    pub fn is_part_of(&self, process: ProcessId, end: ProcessId) -> bool {
        process == end || self.whole(process) == end
    }

    /// The channel's ends, capacity and domain.
    #[must_use]
    pub fn get(&self, channel: ChannelId) -> &Channel {
        &self.channels[channel.0]
    }

    /// The same processes and channels, of whose messages nothing is known: their domains have no shapes. For monitors,
    /// this means that any message may come.
    #[must_use]
    pub fn without_shapes(&self) -> Self {
        let channels = self.channels.iter();
        let channels = channels.map(|channel| Channel { domain: Domain::new([]), ..channel.clone() }).collect();
        Self { channels, ..self.clone() }
    }

    /// The same processes and channels, as properties about one part see them: its processes, whose names begin with
    /// this prefix, are named without it; all others belong to one process, whose messages to itself are not visible.
    #[must_use]
    pub fn part(&self, prefix: &str) -> Self {
        let own = |process: &Declaration| {
            process.name.strip_prefix(prefix).filter(|name| !name.contains('/')).map(str::to_owned)
        };
        let others = self.processes.iter().position(|process| own(process).is_none()).map(ProcessId);
        let processes = self.processes.iter().map(|process| match own(process) {
            Some(name) => Declaration { name, ..process.clone() },
            None => Declaration { whole: others.unwrap_or(process.whole), ..process.clone() },
        });
        Self { processes: processes.collect(), ..self.clone() }
    }

    /// All processes, in the order they were declared.
    pub fn processes(&self) -> impl Iterator<Item = ProcessId> + use<> {
        (0..self.processes.len()).map(ProcessId)
    }

    /// All channels, in the order they were declared.
    pub fn channels(&self) -> impl Iterator<Item = ChannelId> + use<> {
        (0..self.channels.len()).map(ChannelId)
    }

    /// The names of a channel's two ends, sender first, as monitors and logs use them: for a member, the name of its
    /// whole.
    #[must_use]
    pub fn ends(&self, channel: ChannelId) -> (&str, &str) {
        let channel = self.get(channel);
        (self.name(self.whole(channel.source)), self.name(self.whole(channel.target)))
    }

    /// Whether the channel connects two members of the same process.
    #[must_use]
    pub fn is_internal(&self, channel: ChannelId) -> bool {
        let channel = self.get(channel);
        self.whole(channel.source) == self.whole(channel.target)
    }

    /// A channel in words, for messages: `BatteryReader → BatteryLevel`.
    #[must_use]
    pub fn describe(&self, channel: ChannelId) -> String {
        let channel = self.get(channel);
        format!("{} → {}", self.name(channel.source), self.name(channel.target))
    }

    /// Whether the channel may carry the message.
    #[must_use]
    pub fn carries(&self, channel: ChannelId, message: &Message) -> bool {
        self.get(channel).domain.contains(message)
    }
}
