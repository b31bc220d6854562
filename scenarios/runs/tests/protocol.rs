//! The shipped protocol between tree, skills and components tolerates any single fault of any channel: no matter which
//! message is lost, duplicated or late, the system becomes quiet, the tree takes ticks again, and the final state is
//! the same as without the fault.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bt::{LEAF_TIMEOUT, NodeState, RECHARGE, Tree, TreeProcess};
use channels::{
    Action, Capacity, ChannelId, ChannelSystem, Disturbance, Domain, Effect, Envelope, Message, Offer, Pattern,
    Process, ProcessId, Random, RoundRobin, Scheduler, TickGenerator, Topology, TransitionId, Use, Value,
};
use components::{BATTERY_READER, LOCALIZATION, NAVIGATION, Navigation, operations};
use maps::{Place, Places, Point};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skills::{Chart, SHIPPED, SkillProcess};

const STEP: Duration = Duration::from_millis(100);
const TICKS: u32 = 14;
/// The level is below the threshold from this tick on, so that one trip is halted and another one starts.
const LOW_AFTER: u32 = 4;

/// Answers each request at once, from a table.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Reader {
    /// For each client, the channels of its requests and its answers, and its open request.
    clients: Vec<(ChannelId, ChannelId, Option<Envelope>)>,
    answers: BTreeMap<&'static str, Value>,
}

impl Reader {
    fn new(topology: &Topology, process: ProcessId) -> Self {
        let asked = topology.channels().filter(|&channel| topology.get(channel).target == process);
        let clients = asked.map(|channel| (channel, topology.opposite(channel).unwrap(), None)).collect();
        let answers = [("get_level", 80.0.into()), ("get_charging", false.into()), ("is_at", false.into())];
        Self { clients, answers: BTreeMap::from(answers) }
    }
}

impl Process for Reader {
    fn offers(&self, offers: &mut Vec<Offer>) {
        offers.extend((0..).zip(&self.clients).map(|(number, (requests, replies, asked))| {
            let action = match asked {
                None => Action::Receive(*requests, Pattern::Any),
                Some(Envelope { message, request }) => {
                    let answer = self.answers[message.head().unwrap()].clone();
                    let message = Message::new([Value::symbol("ok"), answer]);
                    Action::Send(*replies, Envelope { message, request: *request })
                }
            };
            Offer { transition: TransitionId(number), action }
        }));
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        self.clients[transition.0 as usize].2 = received;
    }

    fn uses(&self) -> Vec<Use> {
        Vec::new()
    }

    fn location(&self) -> String {
        "ready".to_owned()
    }
}

/// The shipped tree and skills, with components that answer at once.
struct Model {
    tree: Arc<Tree>,
    system: ChannelSystem,
    bt: ProcessId,
    generator: ProcessId,
    reader: ProcessId,
}

impl Model {
    fn new(as_nodes: bool) -> Self {
        let tree = Arc::new(Tree::from_xml("recharge.xml", RECHARGE).unwrap());
        let mut topology = Topology::default();
        let generator = topology.process("TickGenerator").unwrap();
        let bt = topology.process("BT").unwrap();
        let charts =
            SHIPPED.map(|(name, text)| (topology.process(name).unwrap(), name, Chart::load(name, text).unwrap()));
        let [reader, localization, navigation] =
            [BATTERY_READER, LOCALIZATION, NAVIGATION].map(|name| topology.process(name).unwrap());
        bt::declare_channels(&tree, &mut topology, bt, generator).unwrap();
        for (skill, _, chart) in &charts {
            declare_services(&mut topology, *skill, chart);
        }
        let mut processes: Vec<(ProcessId, Box<dyn Process>)> = if as_nodes {
            bt::node_processes(&tree, &mut topology, "BT", "TickGenerator", LEAF_TIMEOUT).unwrap()
        } else {
            vec![(bt, Box::new(TreeProcess::new(Arc::clone(&tree), &topology, "BT", "TickGenerator").unwrap()))]
        };
        let ticks = topology.find_channel("TickGenerator", "BT").unwrap();
        processes.push((generator, Box::new(TickGenerator::new(ticks))));
        for (id, name, chart) in &charts {
            processes.push((*id, Box::new(SkillProcess::new(name, chart, &topology, []).unwrap())));
        }
        processes.push((reader, Box::new(Reader::new(&topology, reader))));
        processes.push((localization, Box::new(Reader::new(&topology, localization))));
        processes.push((navigation, Box::new(Navigation::new(&topology, navigation).unwrap())));
        let system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
        Self { tree, system, bt, generator, reader }
    }

    /// Applies this effect to the `nth` message that any process outside the tree sends or receives; the returned
    /// counter keeps counting.
    fn disturb_nth(&mut self, nth: u64, effect: &Effect) -> Arc<AtomicU64> {
        let sent = Arc::new(AtomicU64::new(0));
        let topology = Arc::clone(self.system.topology());
        for channel in topology.channels().filter(|channel| !topology.is_internal(*channel)) {
            let count = Arc::clone(&sent);
            let concerns = Arc::new(move |_: &Message| count.fetch_add(1, Ordering::Relaxed) == nth);
            self.system.disturb(Disturbance { concerns, ..Disturbance::all(channel, effect.clone()) });
        }
        sent
    }

    /// Runs all ticks, a second apart; returns which of them were taken, and the final state of the tree.
    fn run(&mut self, scheduler: &mut dyn Scheduler) -> Result<(Vec<bool>, Vec<NodeState>), String> {
        let mut taken = Vec::new();
        for step in 0..10 * TICKS {
            self.system.advance(STEP * step);
            if step % 10 == 0 {
                if step / 10 == LOW_AFTER {
                    let reader = self.system.process_mut::<Reader>(self.reader).unwrap();
                    reader.answers.insert("get_level", 25.0.into());
                }
                taken.push(self.system.generate_tick(self.generator).1);
            }
            for event in self.system.run(scheduler, 5_000) {
                event.map_err(|error| format!("at step {step}: {error}"))?;
            }
        }
        Ok((taken, bt::states_in(&self.tree, &self.system, self.bt)))
    }
}

/// The channels between a skill and the component that it asks.
fn declare_services(topology: &mut Topology, skill: ProcessId, chart: &Chart) {
    let mut places = Places::default();
    for name in ["Destination", "RechargingStation"] {
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec();
        places.insert(name, Place::Area { corners });
    }
    let asked = chart.channel_messages();
    let all = operations(&places);
    let used = || all.iter().filter(|operation| asked.contains(&(operation.component, operation.name)));
    let Some(component) = used().next().and_then(|operation| topology.find_process(operation.component)) else {
        return;
    };
    let requests = Domain::new(used().map(|operation| operation.request.clone()));
    topology.channel(skill, component, Capacity::One, requests).unwrap();
    let replies = Domain::new(used().flat_map(|operation| operation.replies.clone()));
    topology.channel(component, skill, Capacity::One, replies).unwrap();
}

fn schedulers() -> Vec<Box<dyn Scheduler>> {
    vec![Box::new(RoundRobin::default()), Box::new(Random::new(ChaCha8Rng::seed_from_u64(7)))]
}

/// Disturbs every message of a run in this way, one per run.
fn every_message(effect: &Effect) {
    for as_nodes in [false, true] {
        for turn in 0..schedulers().len() {
            let scheduler = || schedulers().remove(turn);
            let mut sound = Model::new(as_nodes);
            let sent = sound.disturb_nth(u64::MAX, &Effect::Lose);
            let (taken, states) = sound.run(scheduler().as_mut()).unwrap();
            assert_eq!(taken, vec![true; TICKS as usize]);
            let messages = sent.load(Ordering::Relaxed);
            assert!(messages > 150, "{messages} messages");
            // Disturbances in the last ticks cannot be overcome by the end.
            for nth in 0..messages * 6 / 10 {
                let mut faulty = Model::new(as_nodes);
                faulty.disturb_nth(nth, effect);
                let (taken, end) =
                    faulty.run(scheduler().as_mut()).unwrap_or_else(|error| panic!("message {nth}: {error}"));
                assert!(taken.ends_with(&[true; 3]), "message {nth}: {taken:?}");
                assert_eq!(end, states, "message {nth}");
            }
        }
    }
}

#[test]
fn any_message_may_be_lost() {
    every_message(&Effect::Lose);
}

#[test]
fn any_message_may_be_duplicated() {
    every_message(&Effect::Repeat);
}

#[test]
fn any_message_may_be_delayed() {
    every_message(&Effect::Hold(Duration::from_millis(300)));
}

#[test]
fn any_message_may_be_delayed_beyond_every_timeout() {
    every_message(&Effect::Hold(Duration::from_secs(3)));
}
