//! The two forms of a tree in a channel system, compared with each other and with the engine alone.

use std::sync::Arc;
use std::time::Duration;

use bt::{
    Execution, LEAF_TIMEOUT, NodeState, Outcome, RECHARGE, Request, Status, Tree, TreeProcess, blackboard_in,
    declare_channels, node_processes, states_in,
};
use channels::{
    Action, Chance, ChannelId, ChannelSystem, Disturbance, Effect, Envelope, EventKind, FieldKind, Message,
    NoNormalForm, NormalForm, Offer, Pattern, Process, ProcessId, Random, RequestNumber, Scheduler, TickGenerator,
    Topology, TransitionId, Use, Value,
};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::NOW;
use crate::forest::{Called, Cast, Script, by_process, script, spec, wild_tree};
use crate::lockstep::Lockstep;

/// A skill that answers from a script. `echoes` is the number of wrong replies that it sends before each right one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Skill {
    name: String,
    requests: ChannelId,
    replies: ChannelId,
    answers: Vec<Status>,
    /// The outputs with each answer.
    outputs: Vec<Value>,
    tick: usize,
    echoes: u64,
    outbox: Vec<Envelope>,
    asked: Vec<Envelope>,
}

impl Process for Skill {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let action = match self.outbox.first() {
            Some(envelope) => Action::Send(self.replies, envelope.clone()),
            None => Action::Receive(self.requests, Pattern::Any),
        };
        offers.push(Offer { transition: TransitionId(0), action });
    }

    fn take(&mut self, _: TransitionId, received: Option<Envelope>, _: Duration) {
        let Some(envelope) = received else {
            self.outbox.remove(0);
            return;
        };
        let answer = if envelope.message.head() == Some("halt") {
            "halted"
        } else {
            self.tick += 1;
            self.answers[(self.tick - 1) % self.answers.len()].name()
        };
        let message = |name| Message::new(std::iter::once(Value::symbol(name)).chain(self.outputs.iter().cloned()));
        let reply = |name, request| Envelope { message: message(name), request: RequestNumber(request) };
        let number = envelope.request.0;
        let no_answer = if answer == "halted" { "success" } else { "halted" };
        let wrong = (0..self.echoes).map(|echo| match echo {
            0 => reply("success", number + 7),
            1 => reply("halted", 0),
            _ => reply(no_answer, number),
        });
        self.outbox = wrong.chain([reply(answer, number)]).collect();
        self.asked.push(envelope);
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Receives(self.requests, None), Use::Sends(self.replies, None)]
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.tick %= self.answers.len();
        self.asked.clear();
        self.outbox.iter_mut().for_each(|envelope| form.number(self.requests, &mut envelope.request));
        Ok(())
    }

    fn location(&self) -> String {
        if self.outbox.is_empty() { "idle" } else { "answering" }.to_owned()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Whole,
    Nodes,
}

/// A tree with its skills in a channel system.
pub(crate) struct Stage {
    tree: Arc<Tree>,
    pub(crate) system: ChannelSystem,
    pub(crate) bt: ProcessId,
    pub(crate) generator: ProcessId,
    skills: Vec<ProcessId>,
    scheduler: Box<dyn Scheduler>,
}

impl Stage {
    pub(crate) fn new(tree: &Arc<Tree>, form: Form, script: &Script, echoes: u64, seed: u64) -> Self {
        let mut topology = Topology::default();
        let generator = topology.process("TickGenerator").unwrap();
        let bt = topology.process("BT").unwrap();
        let mut skills: Vec<(ProcessId, String)> = Vec::new();
        for leaf in tree.leaves() {
            skills.push((topology.process(leaf.process()).unwrap(), leaf.process().to_owned()));
        }
        let script = by_process(tree, script);
        declare_channels(tree, &mut topology, bt, generator).unwrap();
        let mut processes = match form {
            Form::Whole => {
                let process = TreeProcess::new(tree.clone(), &topology, "BT", "TickGenerator").unwrap();
                vec![(bt, Box::new(process) as Box<dyn Process>)]
            }
            Form::Nodes => node_processes(tree, &mut topology, "BT", "TickGenerator", LEAF_TIMEOUT).unwrap(),
        };
        let ticks = topology.find_channel("TickGenerator", "BT").unwrap();
        processes.push((generator, Box::new(TickGenerator::new(ticks))));
        for (id, name) in &skills {
            let requests = topology.find_channel("BT", name).unwrap();
            let replies = topology.find_channel(name, "BT").unwrap();
            let answers = script[name].clone();
            let fields = topology.get(replies).domain.shapes()[0].fields().len();
            let outputs = vec![Value::symbol(FieldKind::NONE); fields - 1];
            let (name, outbox, asked) = (name.clone(), vec![], vec![]);
            let skill = Skill { name, requests, replies, answers, outputs, tick: 0, echoes, outbox, asked };
            processes.push((*id, Box::new(skill)));
        }
        let system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
        let scheduler = Box::new(Random::new(ChaCha8Rng::seed_from_u64(seed)));
        let skills = skills.into_iter().map(|(id, _)| id).collect();
        Self { tree: tree.clone(), system, bt, generator, skills, scheduler }
    }

    /// Lets a skill write these values to its ports with each answer.
    pub(crate) fn writes(&mut self, skill: &str, outputs: &[Value]) {
        let id = self.system.topology().find_process(skill).unwrap();
        self.system.process_mut::<Skill>(id).unwrap().outputs = outputs.to_vec();
    }

    /// Generates a tick and runs the system until it is quiet. Returns the messages received, as (from, to, message).
    pub(crate) fn tick(&mut self) -> Vec<(String, String, Message)> {
        let (_, taken) = self.system.generate_tick(self.generator);
        assert!(taken, "the last tick is finished");
        self.run()
    }

    /// Runs the system until it is quiet. Returns the messages received, as (from, to, message).
    pub(crate) fn run(&mut self) -> Vec<(String, String, Message)> {
        let events: Vec<_> = self.system.run(self.scheduler.as_mut(), 1_000_000).map(Result::unwrap).collect();
        let received = |kind| match kind {
            EventKind::Received { channel, message } => {
                let (from, to) = self.system.topology().ends(channel);
                Some((from.to_owned(), to.to_owned(), message))
            }
            EventKind::Tick => None,
        };
        events.into_iter().filter_map(|event| received(event.kind)).collect()
    }

    pub(crate) fn states(&self) -> Vec<NodeState> {
        states_in(&self.tree, &self.system, self.bt)
    }

    /// Takes random steps, ticks and pauses, and the same from the normal form of each state; some messages are lost or
    /// repeated.
    fn walk_beside_normal_form(&mut self, seed: u64, steps: usize) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut one_of = |count: u64| random.next_u64() % count;
        let topology = self.system.topology().clone();
        let is_outer = |channel: &ChannelId| topology.ends(*channel).0 != topology.ends(*channel).1;
        for channel in topology.channels().filter(is_outer) {
            let effect =
                [Effect::Lose, Effect::Repeat, Effect::Hold(Duration::from_secs(1))][one_of(3) as usize].clone();
            let chance = Chance { probability: 0.05, stream: ChaCha8Rng::seed_from_u64(seed) };
            let disturbance = Disturbance { probability: Some(chance), ..Disturbance::all(channel, effect) };
            if one_of(2) == 0 {
                self.system.disturb(disturbance);
            }
        }
        let mut pair = Lockstep::new(&self.system, Duration::ZERO);
        for _ in 0..steps {
            let is_quiet = one_of(30) == 0 || !pair.step(self.scheduler.as_mut());
            if is_quiet {
                let until = pair.next_timer().unwrap_or_default();
                pair.advance([Duration::from_millis(30), until, 2 * until][one_of(3) as usize]);
                pair.tick(self.generator);
            }
        }
    }

    /// The requests to each skill, with their numbers.
    fn asked(&self) -> Vec<Vec<Envelope>> {
        let asked = |id: &ProcessId| self.system.process::<Skill>(*id).unwrap().asked.clone();
        self.skills.iter().map(asked).collect()
    }
}

pub(crate) fn calls(messages: &[(String, String, Message)]) -> Vec<Called> {
    let call = |(from, to, message): &(String, String, Message)| {
        let request = if message.head() == Some("halt") { Request::Halt } else { Request::Tick };
        (from == "BT").then(|| (to.clone(), request))
    };
    messages.iter().filter_map(call).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn whole_tree_and_node_processes_agree_with_the_engine(
        spec in spec(), script in script(), seeds in any::<(u64, u64)>(), ticks in 1..12_usize,
    ) {
        let tree = spec.tree();
        let mut cast = Cast::of_processes(&tree, &script);
        let mut execution = Execution::new(tree.clone());
        let mut whole = Stage::new(&tree, Form::Whole, &script, 0, seeds.0);
        let mut nodes = Stage::new(&tree, Form::Nodes, &script, 0, seeds.1);
        for _ in 0..ticks {
            let made = cast.calls().len();
            execution.tick(NOW, &mut cast);
            let (whole_messages, nodes_messages) = (whole.tick(), nodes.tick());
            prop_assert_eq!(&cast.calls()[made..], calls(&whole_messages));
            prop_assert_eq!(whole_messages, nodes_messages);
            prop_assert_eq!(execution.states(), whole.states());
            prop_assert_eq!(execution.states(), nodes.states());
            let copy = nodes.system.fork();
            prop_assert!(copy.same_state(&nodes.system));
        }
        prop_assert_eq!(whole.asked(), nodes.asked());
    }

    #[test]
    fn whole_tree_and_node_processes_agree_on_all_kinds_of_nodes(
        tree in wild_tree(), script in script(), seeds in any::<(u64, u64)>(), ticks in 1..12_u64,
    ) {
        let mut cast = Cast::of_processes(&tree, &script);
        let mut execution = Execution::new(tree.clone());
        let mut whole = Stage::new(&tree, Form::Whole, &script, 0, seeds.0);
        let mut nodes = Stage::new(&tree, Form::Nodes, &script, 0, seeds.1);
        for tick in 0..ticks {
            let now = Duration::from_millis(100 * tick);
            let made = cast.calls().len();
            execution.tick(now, &mut cast);
            // A tree that keeps asking to be ticked again is slow, and so is everything done with it.
            prop_assume!(cast.calls().len() < made + 2000 && !execution.faults().iter().any(|fault| fault.message.contains("end")));
            whole.system.advance(now);
            nodes.system.advance(now);
            let (whole_messages, nodes_messages) = (whole.tick(), nodes.tick());
            prop_assert_eq!(&cast.calls()[made..], calls(&whole_messages));
            prop_assert_eq!(whole_messages, nodes_messages);
            prop_assert_eq!(execution.states(), whole.states());
            prop_assert_eq!(execution.states(), nodes.states());
            let board = blackboard_in(&nodes.system, nodes.bt).expect("the tree uses its blackboard");
            prop_assert_eq!(execution.blackboard(), board);
            let copy = nodes.system.fork();
            prop_assert!(copy.same_state(&nodes.system));
        }
        prop_assert_eq!(whole.asked(), nodes.asked());
    }

    #[test]
    fn replies_to_other_requests_change_nothing(
        spec in spec(), script in script(), echoes in 1..4_u64, seed in any::<u64>(), ticks in 1..6_usize,
    ) {
        let tree = spec.tree();
        for form in [Form::Whole, Form::Nodes] {
            let mut plain = Stage::new(&tree, form, &script, 0, seed);
            let mut noisy = Stage::new(&tree, form, &script, echoes, seed);
            for _ in 0..ticks {
                prop_assert_eq!(calls(&plain.tick()), calls(&noisy.tick()));
                prop_assert_eq!(plain.states(), noisy.states());
            }
            prop_assert_eq!(plain.asked(), noisy.asked());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    #[ignore = "long: .ci/run runs it"]
    fn a_tree_and_its_normal_form_are_indistinguishable(
        spec in spec(), wild in wild_tree(), script in script(), echoes in 0..4_u64, seed in any::<u64>(),
    ) {
        for tree in [spec.tree(), wild] {
            Stage::new(&tree, Form::Whole, &script, echoes, seed).walk_beside_normal_form(seed, 400);
            Stage::new(&tree, Form::Nodes, &script, echoes, seed).walk_beside_normal_form(seed, 800);
        }
    }
}

/// The paper's tree with leaves that always give the same answer.
pub(crate) fn recharge(answers: &[(&str, Status)]) -> (Arc<Tree>, Script) {
    let tree = Tree::from_xml("recharge.xml", RECHARGE).unwrap();
    let answer = |id: &str| answers.iter().find(|(name, _)| *name == id).map_or(Status::Failure, |(_, status)| *status);
    let script = tree.leaves().map(|leaf| (leaf.type_id().to_owned(), vec![answer(leaf.type_id())])).collect();
    (Arc::new(tree), script)
}

#[test]
fn the_papers_robot_interrupts_its_trip_when_the_battery_is_low() {
    use Status::{Failure, Running, Success};
    let (tree, mut script) =
        recharge(&[("BatteryNotCharging", Success), ("GotoRechargingStation", Running), ("GoToDestination", Running)]);
    script.insert("BatteryLevel".to_owned(), vec![Success, Failure]);
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = Stage::new(&tree, form, &script, 0, 1);
        let ask = |id: &str| (id.to_owned(), Request::Tick);
        assert_eq!(
            calls(&stage.tick()),
            ["BatteryLevel", "BatteryNotCharging", "AtDestination", "GoToDestination"].map(ask)
        );

        let mut expected = ["BatteryLevel", "AtRechargingStation", "GotoRechargingStation"].map(ask).to_vec();
        expected.push(("GoToDestination".to_owned(), Request::Halt));
        assert_eq!(calls(&stage.tick()), expected, "the trip is halted after the other one has begun");
        let states = stage.states();
        let outcome =
            |label: &str| states[tree.leaves().find(|leaf| leaf.label() == label).unwrap().id().index()].outcome;
        assert_eq!(outcome("GoToDestination"), Some(Outcome::Halted));
        assert_eq!(outcome("GotoRechargingStation"), Some(Outcome::Answered(Running)));
        assert_eq!(outcome("WaitForUser"), None);
    }
}

#[test]
fn the_requests_to_each_skill_are_numbered() {
    let (tree, script) = recharge(&[("BatteryLevel", Status::Success), ("BatteryNotCharging", Status::Success)]);
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = Stage::new(&tree, form, &script, 0, 1);
        stage.tick();
        stage.tick();
        let mut numbers: Vec<u64> = stage.asked().iter().flatten().map(|envelope| envelope.request.0).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, [1, 1, 1, 1, 2, 2, 2, 2]);
    }
}

#[test]
fn a_tree_with_a_silent_skill_takes_no_further_tick_while_it_waits() {
    let (tree, script) = recharge(&[]);
    for form in [Form::Whole, Form::Nodes] {
        let mut stage = Stage::new(&tree, form, &script, 0, 1);
        stage.system.process_mut::<Skill>(stage.skills[0]).unwrap().outbox = vec![];
        stage.system.generate_tick(stage.generator);
        // Until BatteryLevel has been asked, but has not answered.
        for _ in 0..100 {
            let waits = stage.system.process::<Skill>(stage.skills[0]).is_some_and(|skill| !skill.outbox.is_empty());
            let Some(next) = stage.system.enabled().into_iter().next().filter(|_| !waits) else { break };
            stage.system.take(&next).unwrap();
        }
        let (_, taken) = stage.system.generate_tick(stage.generator);
        assert!(!taken);
        let location = match form {
            Form::Whole => stage.system.location(stage.bt).unwrap(),
            Form::Nodes => {
                stage.system.location(stage.system.topology().find_process("BT/3 BatteryLevel").unwrap()).unwrap()
            }
        };
        assert_eq!(location, "waiting for BatteryLevel");
        let states = stage.states();
        assert_eq!(
            states[3].outcome,
            Some(Outcome::Answered(Status::Running)),
            "a leaf that is being asked is running"
        );
        assert_eq!(states[0].status, Some(Status::Running));
    }
}

#[test]
fn a_missing_skill_is_an_error_of_wiring() {
    let (tree, _) = recharge(&[]);
    let mut topology = Topology::default();
    let [generator, bt] = ["TickGenerator", "BT"].map(|name| topology.process(name).unwrap());
    let error = declare_channels(&tree, &mut topology, bt, generator).unwrap_err();
    assert_eq!(error.to_string(), "BT needs the channel BT → BatteryLevel, which does not exist");
    let error = TreeProcess::new(tree, &topology, "BT", "TickGenerator").unwrap_err();
    assert_eq!(error.to_string(), "BT needs the channel BT → BatteryLevel, which does not exist");
}
