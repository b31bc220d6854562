//! Skills in a real channel system: stubs of a tree and of components, and the skills.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, ChannelId, ChannelSystem, Envelope, Event, EventKind, Message, Offer, Pattern, Process, Random,
    RequestNumber, RoundRobin, Scheduler, Starving, Topology, TransitionId, Use,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skills::{SHIPPED, SkillProcess};

use crate::conversation::{chart, ok, ok_state, topology};

/// Sends its requests in order, each after the answer to the previous one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Tree {
    calls: Vec<(ChannelId, ChannelId, &'static str)>,
    next: usize,
    waiting: bool,
}

impl Tree {
    fn calling(topology: &Topology, calls: &[(&str, &'static str)]) -> Self {
        let channel = |from: &str, to: &str| topology.find_channel(from, to).unwrap();
        let calls = calls.iter().map(|(leaf, what)| (channel("BT", leaf), channel(leaf, "BT"), *what)).collect();
        Self { calls, next: 0, waiting: false }
    }
}

impl Process for Tree {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let Some((call, result, what)) = self.calls.get(self.next) else { return };
        let request = RequestNumber(self.next as u64 + 1);
        let action = if self.waiting {
            Action::Receive(*result, Pattern::Any)
        } else {
            Action::Send(*call, Envelope { message: Message::symbols([what]), request })
        };
        offers.push(Offer { transition: TransitionId(0), action });
    }

    fn take(&mut self, _: TransitionId, received: Option<Envelope>, _: Duration) {
        if let Some(envelope) = received {
            assert_eq!(envelope.request, RequestNumber(self.next as u64 + 1));
            self.next += 1;
        }
        self.waiting = !self.waiting;
    }

    fn uses(&self) -> Vec<Use> {
        Vec::new()
    }

    fn location(&self) -> String {
        format!("call {}", self.next)
    }
}

/// Answers each request at once, from a table.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Component {
    channels: Vec<(ChannelId, ChannelId)>,
    answers: BTreeMap<&'static str, Message>,
    reply: Option<(usize, Envelope)>,
}

fn component_answers() -> BTreeMap<&'static str, Message> {
    BTreeMap::from([
        ("get_level", ok(25.0)),
        ("get_charging", ok(false)),
        ("is_at", ok(false)),
        ("start_navigation", ok_state("running")),
        ("get_status", ok_state("running")),
        ("stop_navigation", ok_state("stopped")),
    ])
}

impl Component {
    fn named(topology: &Topology, name: &str) -> Self {
        let incoming = topology.channels().filter(|channel| topology.ends(*channel).1 == name);
        let pair = |channel| (channel, topology.find_channel(name, topology.ends(channel).0).unwrap());
        Self { channels: incoming.map(pair).collect(), answers: component_answers(), reply: None }
    }
}

impl Process for Component {
    fn offers(&self, offers: &mut Vec<Offer>) {
        match &self.reply {
            Some((index, envelope)) => {
                let action = Action::Send(self.channels[*index].1, envelope.clone());
                offers.push(Offer { transition: TransitionId(0), action });
            }
            None => offers.extend(self.channels.iter().enumerate().map(|(index, (request, _))| Offer {
                transition: TransitionId(index as u32),
                action: Action::Receive(*request, Pattern::Any),
            })),
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _: Duration) {
        self.reply = received.map(|envelope| {
            let message = self.answers[envelope.message.head().unwrap()].clone();
            (transition.0 as usize, Envelope { message, request: envelope.request })
        });
    }

    fn uses(&self) -> Vec<Use> {
        Vec::new()
    }

    fn location(&self) -> String {
        "ready".to_owned()
    }
}

fn sent(scheduler: &mut dyn Scheduler) -> Vec<String> {
    let topology = Arc::new(topology());
    let calls = [
        ("BatteryLevel", "tick"),
        ("AtRechargingStation", "tick"),
        ("GotoRechargingStation", "tick"),
        ("GotoRechargingStation", "tick"),
        ("WaitForUser", "tick"),
        ("GotoRechargingStation", "halt"),
        ("BatteryNotCharging", "tick"),
        ("GoToDestination", "tick"),
    ];
    let mut processes: Vec<(_, Box<dyn Process>)> = Vec::new();
    for id in topology.processes() {
        let name = topology.name(id);
        processes.push(match name {
            "BT" => (id, Box::new(Tree::calling(&topology, &calls))),
            _ if SHIPPED.iter().any(|(leaf, _)| *leaf == name) => {
                (id, Box::new(SkillProcess::new(name, &chart(name), &topology, []).unwrap()))
            }
            _ => (id, Box::new(Component::named(&topology, name))),
        });
    }
    let mut system = ChannelSystem::new(Arc::clone(&topology), processes).unwrap();
    let events: Vec<Event> = system.run(scheduler, 10_000).collect::<Result<_, _>>().unwrap();
    let tree: &Tree = system.process(topology.find_process("BT").unwrap()).unwrap();
    assert_eq!(tree.next, calls.len(), "every call was answered");
    let line = |event: &Event| match &event.kind {
        EventKind::Received { channel, message } => {
            let (from, to) = topology.ends(*channel);
            Some(format!("{from} {to} {message}"))
        }
        _ => None,
    };
    events.iter().filter_map(line).collect()
}

#[test]
fn conversations_are_the_same_under_every_scheduler() {
    let expected = [
        "BT BatteryLevel [<tick>]",
        "BatteryLevel BatteryReader [<get_level>]",
        "BatteryReader BatteryLevel [<ok>, 25.0]",
        "BatteryLevel BT [<failure>]",
        "BT AtRechargingStation [<tick>]",
        "AtRechargingStation Localization [<is_at>, <RechargingStation>]",
        "Localization AtRechargingStation [<ok>, false]",
        "AtRechargingStation BT [<failure>]",
        "BT GotoRechargingStation [<tick>]",
        "GotoRechargingStation Navigation [<start_navigation>, <RechargingStation>]",
        "Navigation GotoRechargingStation [<ok>, <running>]",
        "GotoRechargingStation BT [<running>]",
        "BT GotoRechargingStation [<tick>]",
        "GotoRechargingStation Navigation [<get_status>, <RechargingStation>]",
        "Navigation GotoRechargingStation [<ok>, <running>]",
        "GotoRechargingStation BT [<running>]",
        "BT WaitForUser [<tick>]",
        "WaitForUser BT [<running>]",
        "BT GotoRechargingStation [<halt>]",
        "GotoRechargingStation Navigation [<stop_navigation>, <RechargingStation>]",
        "Navigation GotoRechargingStation [<ok>, <stopped>]",
        "GotoRechargingStation BT [<halted>]",
        "BT BatteryNotCharging [<tick>]",
        "BatteryNotCharging BatteryReader [<get_charging>]",
        "BatteryReader BatteryNotCharging [<ok>, false]",
        "BatteryNotCharging BT [<success>]",
        "BT GoToDestination [<tick>]",
        "GoToDestination Navigation [<start_navigation>, <Destination>]",
        "Navigation GoToDestination [<ok>, <running>]",
        "GoToDestination BT [<running>]",
    ];
    assert_eq!(sent(&mut RoundRobin::default()), expected);
    for seed in 0..5 {
        assert_eq!(sent(&mut Random::new(ChaCha8Rng::seed_from_u64(seed))), expected);
    }
    for victim in topology().processes() {
        assert_eq!(sent(&mut Starving::new(victim, Box::<RoundRobin>::default())), expected);
    }
}
