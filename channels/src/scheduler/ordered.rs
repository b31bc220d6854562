//! A policy that makes some messages wait for others.

use std::fmt;

use super::Rest;
use crate::{ChannelId, ChannelSystem, Concern, Enabled, EnabledKind, Scheduler};

/// The messages on a channel of capacity 1 to which an order refers.
#[derive(Clone)]
pub struct Delivery {
    /// The channel.
    pub channel: ChannelId,
    /// Which of the channel's messages are meant.
    pub concerns: Concern,
}

impl Delivery {
    /// Whether the transition delivers such a message.
    fn happens(&self, system: &ChannelSystem, transition: &Enabled) -> bool {
        transition.kind == EnabledKind::Receive(self.channel)
            && system.content(self.channel).is_some_and(|envelope| (self.concerns)(&envelope.message))
    }
}

impl fmt::Debug for Delivery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Delivery").field("channel", &self.channel).finish_non_exhaustive()
    }
}

/// An order: a message is received only after another one.
#[derive(Clone, Debug)]
pub struct Precedence {
    /// The messages that come first: any one of these.
    pub first: Vec<Delivery>,
    /// The messages that wait: all of these. Each waits for its own `first`: one received since the previous `then`.
    pub then: Vec<Delivery>,
}

impl Precedence {
    fn is_first(&self, system: &ChannelSystem, transition: &Enabled) -> bool {
        self.first.iter().any(|delivery| delivery.happens(system, transition))
    }

    fn is_then(&self, system: &ChannelSystem, transition: &Enabled) -> bool {
        self.then.iter().any(|delivery| delivery.happens(system, transition))
    }
}

/// Enforces an order among messages and leaves every other choice to another policy.
///
/// A message waits only while something else can move. So this is a schedule like any other, and a system that becomes
/// quiet under every other policy also becomes quiet under this one.
#[derive(Debug)]
pub struct Ordered {
    rules: Vec<TrackedPrecedence>,
    others: Box<dyn Scheduler>,
    rest: Rest,
}

#[derive(Debug)]
struct TrackedPrecedence {
    precedence: Precedence,
    /// Whether a `first` was received after the last `then`.
    satisfied: bool,
}

impl Ordered {
    /// The policy that enforces these orders and leaves the other choices to `others`.
    pub fn new(orders: impl IntoIterator<Item = Precedence>, others: Box<dyn Scheduler>) -> Self {
        let rules = orders.into_iter().map(|precedence| TrackedPrecedence { precedence, satisfied: false }).collect();
        Self { rules, others, rest: Rest::default() }
    }

    fn note(&mut self, system: &ChannelSystem, taken: &Enabled) {
        for TrackedPrecedence { precedence, satisfied } in &mut self.rules {
            if precedence.is_then(system, taken) {
                *satisfied = false;
            }
            if precedence.is_first(system, taken) {
                *satisfied = true;
            }
        }
    }
}

impl Scheduler for Ordered {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        self.others.choose(enabled)
    }

    fn choose_in(&mut self, system: &ChannelSystem, enabled: &[Enabled]) -> usize {
        let Self { rules, others, rest } = self;
        let waits = |transition: &Enabled| {
            rules.iter().any(|rule| !rule.satisfied && rule.precedence.is_then(system, transition))
        };
        let choice = rest.choose(enabled, waits, |among| others.choose_in(system, among));
        self.note(system, &enabled[choice]);
        choice
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::{
        Capacity, Domain, EventKind, FieldKind, GraphProcess, Message, ProgramGraph, Random, Shape, Topology, Value,
    };

    /// The order in which R receives messages from A, B and so on, as the senders' names. Each sender has the given
    /// number of messages.
    fn received<const N: usize>(
        seed: u64,
        counts: [i64; N],
        order: impl FnOnce([Delivery; N]) -> Precedence,
    ) -> String {
        let mut topology = Topology::default();
        let names: Vec<String> = ('A'..).take(N).map(String::from).collect();
        let senders: Vec<_> = names.iter().map(|name| topology.process(name).expect("a new name")).collect();
        let r = topology.process("R").expect("a new name");
        let numbers = || Domain::new([Shape::new([("number", FieldKind::Int)])]);
        let channels: [ChannelId; N] =
            std::array::from_fn(|i| topology.channel(senders[i], r, Capacity::One, numbers()).expect("a new channel"));
        let sender = |channel, count: i64| {
            let mut graph = ProgramGraph::builder("sender");
            let first = graph.location("0");
            let mut at = first;
            for number in 1..=count {
                let next = graph.location(&number.to_string());
                graph.send(at, channel, Message::new([Value::Int(number)]), next);
                at = next;
            }
            GraphProcess::new(Arc::new(graph.initial(first).build().expect("an initial location")))
        };
        let mut graph = ProgramGraph::builder("receiver");
        let (here, number) = (graph.location("here"), graph.variable("number"));
        for channel in channels {
            graph.receive(here, channel, number, here);
        }
        let receiver = GraphProcess::new(Arc::new(graph.initial(here).build().expect("an initial location")));
        let mut processes: Vec<(_, Box<dyn crate::Process>)> = vec![(r, Box::new(receiver))];
        for i in 0..N {
            processes.push((senders[i], Box::new(sender(channels[i], counts[i]))));
        }
        let mut system = ChannelSystem::new(Arc::new(topology), processes).expect("a sound system");
        let order = order(channels.map(|channel| Delivery { channel, concerns: Arc::new(|_| true) }));
        let mut ordered = Ordered::new([order], Box::new(Random::new(ChaCha8Rng::seed_from_u64(seed))));
        let events: Vec<_> = system.run(&mut ordered, 1000).map(|event| event.expect("no livelock")).collect();
        let sender = |event: &crate::Event| match &event.kind {
            EventKind::Received { channel, .. } => channels.iter().position(|other| other == channel),
            _ => None,
        };
        events.iter().filter_map(sender).map(|sender| names[sender].as_str()).collect()
    }

    /// B's messages wait for A's.
    fn b_after_a([a, b]: [Delivery; 2]) -> Precedence {
        Precedence { first: vec![a], then: vec![b] }
    }

    #[test]
    fn each_message_waits_for_its_own_predecessor() {
        let orders: Vec<String> = (0..20).map(|seed| received(seed, [9, 3], b_after_a)).collect();
        for order in &orders {
            assert_eq!((order.matches('A').count(), order.matches('B').count()), (9, 3), "{order}");
            // As long as A still has messages to come, those of B wait for them.
            let (while_a_lasts, _) = order.rsplit_once('A').expect("there are nine");
            assert!(!while_a_lasts.starts_with('B') && !while_a_lasts.contains("BB"), "{order}");
        }
        assert!(orders.iter().any(|order| !order.ends_with("BBB")), "{orders:?}");
    }

    #[test]
    fn a_message_stops_waiting_when_nothing_else_can_move() {
        assert_eq!(received(1, [0, 2], b_after_a), "BB");
        assert_eq!(received(1, [1, 2], b_after_a), "ABB");
    }

    #[test]
    fn any_of_several_messages_may_come_first_and_each_releases_one() {
        let orders: Vec<String> = (0..40)
            .map(|seed| received(seed, [3, 3, 3, 3], |[a, b, c, d]| Precedence { first: vec![a, b], then: vec![c, d] }))
            .collect();
        for order in &orders {
            let last = order.rfind(['A', 'B']).expect("there are six");
            let mut free = false;
            for sender in order[..last].chars() {
                let first = matches!(sender, 'A' | 'B');
                assert!(first || free, "{order}: {sender} waits for one of its own");
                free = first;
            }
        }
        assert!(
            orders.iter().any(|order| order.starts_with("AC")) && orders.iter().any(|order| order.starts_with("BD"))
        );
    }
}
