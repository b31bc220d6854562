//! Systems that have no end, or do not fit into memory, get a clear answer and never a wrong one.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use channels::{
    Assignment, Capacity, ChannelId, ChannelSystem, Content, Domain, Envelope, Event, FieldKind, GraphMonitor,
    GraphProcess, Label, Message, Monitor, NoNormalForm, NormalForm, Offer, Process, ProgramGraph, Shape, Slot, Term,
    TickGenerator, Topology, TransitionId, Use, Verdict,
};
use explorer::{
    Closed, Environment, Limit, Limits, Model, NotExported, Order, Outcome, Progress, Reduction, Refused, Ticks,
    explore, promela,
};

/// Two processes with a channel from the first to the second.
fn pair(make: impl FnOnce(ChannelId) -> [Box<dyn Process>; 2]) -> Model {
    pair_with(Capacity::One, make)
}

/// The same, with a channel of this capacity.
fn pair_with(capacity: Capacity, make: impl FnOnce(ChannelId) -> [Box<dyn Process>; 2]) -> Model {
    let mut topology = Topology::default();
    let [from, to] = ["Counter", "Listener"].map(|name| topology.process(name).expect("a new name"));
    let words = Domain::new([Shape::new([("word", FieldKind::symbols(["hello"]))])]);
    let channel = topology.channel(from, to, capacity, words).expect("a new channel");
    let [first, second] = make(channel);
    let system = ChannelSystem::new(Arc::new(topology), [(from, first), (to, second)]).expect("a sound system");
    Model::new(&system, None, Closed.erased())
}

fn run(graph: channels::GraphBuilder, start: channels::LocationId) -> Box<dyn Process> {
    Box::new(GraphProcess::new(Arc::new(graph.initial(start).build().expect("a sound graph"))))
}

/// Counts up to a limit.
fn counter(limit: i64) -> Box<dyn Process> {
    let mut graph = ProgramGraph::builder("Counter");
    let here = graph.location("counting");
    let count = graph.variable_with("count", Content::Value(0.into()));
    let sum = Term::Sum(Box::new(count.term()), Box::new(1.into()));
    let up = vec![Assignment { variable: count, term: sum }];
    graph.transition(here, Label::Internal(up), here).guard = count.term().compare(channels::Relation::Less, limit);
    run(graph, here)
}

fn silent() -> Box<dyn Process> {
    let mut graph = ProgramGraph::builder("Listener");
    let here = graph.location("here");
    run(graph, here)
}

#[test]
fn a_counter_without_a_bound_is_refused() {
    let refused = explore(&pair(|_| [counter(i64::MAX), silent()]), None, &Limits::default(), &mut |_| ()).unwrap_err();
    assert!(matches!(&refused, Refused::TooManyStates { process, .. } if process == "Counter"), "{refused}");
}

#[test]
fn a_search_ends_when_its_memory_runs_out() {
    let limits = Limits { memory: 5_000_000, reduction: Reduction::Off, ..Limits::default() };
    let found = explore(&pair(|_| [counter(60_000), silent()]), None, &limits, &mut |_| ()).expect("a finite model");
    assert!(matches!(found.outcome, Outcome::Undecided(Limit::Memory)), "{:?}", found.outcome);
    assert!(found.progress.states > 100 && found.progress.depth > 100, "{:?}", found.progress);
}

#[test]
fn a_trillion_states_end_in_an_answer_within_the_memory_limit() {
    let mut topology = Topology::default();
    let ids: Vec<_> = (0..12).map(|index| topology.process(&format!("Counter{index}")).expect("a new name")).collect();
    let system = ChannelSystem::new(Arc::new(topology), ids.into_iter().map(|id| (id, counter(9))));
    let model = Model::new(&system.expect("a sound system"), None, Closed.erased());
    for (reduction, threads) in [(Reduction::Off, 1), (Reduction::WhenNeeded, 2)] {
        let limits = Limits { memory: 20_000_000, reduction, threads, ..Limits::default() };
        let (mut most, mut last) = (0, 0);
        let mut look = |progress: &Progress| (most, last) = (most.max(progress.memory), progress.states);
        let found = explore(&model, None, &limits, &mut look).expect("a finite model");
        assert!(matches!(found.outcome, Outcome::Undecided(Limit::Memory)), "{:?}", found.outcome);
        assert_eq!(found.earlier.is_some(), reduction == Reduction::WhenNeeded);
        assert!(found.progress.states > 300_000 && found.progress.depth > 5, "{:?}", found.progress);
        // The search ends with the batch in which memory runs out.
        assert!(most < 2 * limits.memory && last == found.progress.states, "{most} bytes");
    }
}

#[test]
fn a_stopped_search_says_how_far_it_got() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let limits = Limits { stop: Some(&STOP), ..Limits::default() };
    let mut stop_at_depth_50 = |progress: &Progress| STOP.store(progress.depth >= 50, Ordering::Relaxed);
    let found = explore(&pair(|_| [counter(60_000), silent()]), None, &limits, &mut stop_at_depth_50);
    let found = found.expect("a finite model");
    assert!(matches!(found.outcome, Outcome::Undecided(Limit::Stop)), "{:?}", found.outcome);
    assert_eq!(found.progress.depth, 50, "{:?}", found.progress);
}

#[test]
fn a_budget_of_visits_ends_all_searches_of_a_proof_on_any_number_of_threads_alike() {
    let model = pair(|_| [counter(60_000), counter(60_000)]);
    for reduction in [Reduction::Off, Reduction::On, Reduction::WhenNeeded] {
        let found = |visits, threads| {
            // With little memory, the second search gets what the first one has left.
            let memory = if reduction == Reduction::WhenNeeded { 5_000_000 } else { usize::MAX };
            let limits = Limits { visits, memory, reduction, threads, ..Limits::default() };
            let found = explore(&model, None, &limits, &mut |_| ()).expect("a finite model");
            let visited = found.progress.visited + found.earlier.map_or(0, |earlier| earlier.visited);
            (matches!(found.outcome, Outcome::Undecided(Limit::Visits)), visited)
        };
        let (is_over, visited) = found(200_000, 1);
        assert!(is_over && (200_000..200_000 + 4096 * 65).contains(&visited), "{reduction:?}: {visited}");
        assert_eq!(found(200_000, 2), (is_over, visited));
    }
}

#[test]
fn a_search_that_needs_exactly_its_budget_is_complete() {
    let model = pair(|_| [counter(9), silent()]);
    let found = |visits| explore(&model, None, &Limits { visits, ..Limits::default() }, &mut |_| ()).expect("finite");
    let visited = found(u64::MAX).progress.visited;
    assert!(matches!(found(visited).outcome, Outcome::Proved));
}

/// A process that sends itself more and more work.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Chatter {
    channel: ChannelId,
    waiting: usize,
}

impl Process for Chatter {
    fn offers(&self, offers: &mut Vec<Offer>) {
        offers.push(Offer { transition: TransitionId(0), action: channels::Action::Internal });
        if self.waiting > 0 {
            let action = channels::Action::Send(self.channel, Message::symbols(["hello"]).into());
            offers.push(Offer { transition: TransitionId(1), action });
        }
    }

    fn take(&mut self, transition: TransitionId, _received: Option<Envelope>, _now: Duration) {
        self.waiting = if transition.0 == 0 { self.waiting + 1 } else { self.waiting - 1 };
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Sends(self.channel, None)]
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        form.queue(self.waiting, || "more and more messages wait".to_owned())
    }

    fn location(&self) -> String {
        "chatting".to_owned()
    }
}

#[test]
fn messages_that_pile_up_are_shown_by_a_run() {
    let model = pair(|channel| [Box::new(Chatter { channel, waiting: 0 }), silent()]);
    let found = explore(&model, None, &Limits::default(), &mut |_| ()).expect("an answer");
    let Outcome::Endless(path) = found.outcome else { panic!("{:?}", found.outcome) };
    assert_eq!(path.steps().len(), NormalForm::QUEUE + 1);
    path.replay(&model, None).expect("a run of the channel system");
    let exported = promela(&model, None, &Limits::default(), &mut |_| ()).expect("a finite model");
    assert_eq!(exported.text.matches("assert(false)").count(), 1, "{}", exported.text);
}

/// A process that keeps every message that it receives.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Hoarder {
    channel: ChannelId,
    kept: usize,
}

impl Process for Hoarder {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let action = channels::Action::Receive(self.channel, channels::Pattern::Any);
        offers.push(Offer { transition: TransitionId(0), action });
    }

    fn take(&mut self, _transition: TransitionId, _received: Option<Envelope>, _now: Duration) {
        self.kept += 1;
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Receives(self.channel, None)]
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        form.queue(self.kept, || "more and more messages are kept".to_owned())
    }

    fn location(&self) -> String {
        "keeping".to_owned()
    }
}

/// A property that is violated once so many messages have been received.
#[derive(Clone, Debug)]
struct Fewer {
    left: usize,
}

impl Monitor for Fewer {
    fn name(&self) -> &str {
        "fewer"
    }

    fn boxed_clone(&self) -> Box<dyn Monitor> {
        Box::new(self.clone())
    }

    fn observe(&mut self, _event: &Event) {
        self.left = self.left.saturating_sub(1);
    }

    fn verdict(&self) -> Verdict {
        if self.left == 0 { Verdict::False } else { Verdict::Inconclusive }
    }

    fn location(&self) -> String {
        format!("{} left", self.left)
    }

    fn is_open(&self) -> bool {
        false
    }

    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        Ok(())
    }

    fn same_state(&self, other: &dyn Monitor) -> bool {
        (other as &dyn Any).downcast_ref::<Self>().is_some_and(|other| self.left == other.left)
    }
}

#[test]
fn messages_that_pile_up_where_they_are_received_are_not_passed_over() {
    for (capacity, steps_per_message) in [(Capacity::One, 2), (Capacity::Zero, 1)] {
        let model = pair_with(capacity, |channel| {
            let mut graph = ProgramGraph::builder("Counter");
            let here = graph.location("here");
            graph.send(here, channel, Message::symbols(["hello"]), here);
            [run(graph, here), Box::new(Hoarder { channel, kept: 0 })]
        });
        for (order, reduction) in
            [(Order::Breadth, Reduction::Off), (Order::Breadth, Reduction::On), (Order::Depth, Reduction::Off)]
        {
            let limits = Limits { order, reduction, ..Limits::default() };
            let most = NormalForm::QUEUE;
            // What is violated by the message that is one too many is violated, whatever follows.
            for left in [None, Some(most), Some(most + 1), Some(most + 2)] {
                let property = left.map(|left| Fewer { left });
                let property = property.as_ref().map(|property| property as &dyn Monitor);
                let found = explore(&model, property, &limits, &mut |_| ()).expect("an answer");
                let is_violated = left.is_some_and(|left| left <= most + 1);
                let path = match found.outcome {
                    Outcome::Violated(path) if is_violated => path,
                    Outcome::Endless(path) if !is_violated => path,
                    outcome => panic!("{capacity:?}, {limits:?}, {left:?}: {outcome:?}"),
                };
                let messages = left.map_or(most + 1, |left| left.min(most + 1));
                assert_eq!(path.steps().len(), steps_per_message * messages, "{capacity:?}, {limits:?}, {left:?}");
                let replay = path.replay(&model, property).expect("a run of the channel system");
                assert_eq!(replay.verdict() == Verdict::False, is_violated);
                assert_eq!(replay.system.fork().normalize().is_err(), messages > most);
            }
        }
    }
}

#[test]
fn an_export_needs_all_states() {
    let limits = Limits { memory: 5_000_000, ..Limits::default() };
    let refused = promela(&pair(|_| [counter(60_000), silent()]), None, &limits, &mut |_| ()).unwrap_err();
    assert!(matches!(refused, NotExported::Incomplete { states, limit: Limit::Memory } if states > 100), "{refused}");
}

/// Nothing tells which of its states are alike.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Stranger;

impl Process for Stranger {
    fn offers(&self, _offers: &mut Vec<Offer>) {}

    fn take(&mut self, _transition: TransitionId, _received: Option<Envelope>, _now: Duration) {}

    fn uses(&self) -> Vec<Use> {
        Vec::new()
    }

    fn location(&self) -> String {
        "somewhere".to_owned()
    }
}

#[test]
fn a_process_without_a_normal_form_is_named() {
    let model = pair(|_| [Box::new(Stranger), silent()]);
    let refused = explore(&model, None, &Limits::default(), &mut |_| ()).unwrap_err();
    assert!(matches!(&refused, Refused::Process { process, .. } if process == "Counter"), "{refused}");
}

/// A property that nothing can violate.
fn calm() -> GraphMonitor {
    let mut graph = ProgramGraph::builder("calm");
    let [good, bad] = ["good", "bad"].map(|name| graph.location(name));
    GraphMonitor::new(Arc::new(graph.initial(good).build().expect("a sound graph")), [bad])
}

/// A property that holds from the start, whatever happens.
#[derive(Clone, Debug)]
struct Settled;

impl Monitor for Settled {
    fn name(&self) -> &str {
        "settled"
    }

    fn boxed_clone(&self) -> Box<dyn Monitor> {
        Box::new(self.clone())
    }

    fn observe(&mut self, _event: &Event) {}

    fn verdict(&self) -> Verdict {
        Verdict::True
    }

    fn location(&self) -> String {
        "settled".to_owned()
    }

    fn is_open(&self) -> bool {
        false
    }

    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        Ok(())
    }

    fn same_state(&self, _other: &dyn Monitor) -> bool {
        true
    }
}

/// Proves the property of a tree that takes ticks, or `spins` forever so that none comes. Returns whether a tick is
/// delivered, and whether the proof is vacuous.
fn proved(property: &dyn Monitor, spins: bool) -> (Option<bool>, bool) {
    let mut topology = Topology::default();
    let [ticks, tree] = ["Ticks", "Tree"].map(|name| topology.process(name).expect("a new name"));
    let domain = Domain::new([TickGenerator::shape()]);
    let channel = topology.channel(ticks, tree, Capacity::One, domain).expect("a new channel");
    let mut graph = ProgramGraph::builder("Tree");
    let here = graph.location("here");
    let last = graph.variable("last");
    if spins {
        graph.transition(here, Label::Internal(Vec::new()), here);
    } else {
        graph.transition(here, Label::Receive(channel, Slot::Variable(last)), here);
    }
    let processes: [(_, Box<dyn Process>); 2] =
        [(ticks, Box::new(TickGenerator::new(channel))), (tree, run(graph, here))];
    let system = ChannelSystem::new(Arc::new(topology), processes).expect("a sound system");
    let second = Duration::from_secs(1);
    let ticks = Ticks { generator: ticks, period: second, first: second, step: Duration::ZERO };
    let model = Model::new(&system, Some(ticks), Closed.erased());
    let found = explore(&model, Some(property), &Limits::default(), &mut |_| ()).expect("a finite model");
    assert!(matches!(found.outcome, Outcome::Proved), "{:?}", found.outcome);
    (found.is_ticked(), found.is_vacuous())
}

#[test]
fn a_proof_in_which_no_tick_arrives_is_vacuous() {
    assert_eq!(proved(&calm(), false), (Some(true), false));
    // It is busy for ever, and time never passes.
    assert_eq!(proved(&calm(), true), (Some(false), true));
    let unticked = explore(&pair(|_| [counter(9), silent()]), Some(&calm()), &Limits::default(), &mut |_| ());
    let unticked = unticked.expect("a finite model");
    assert_eq!((unticked.is_ticked(), unticked.is_vacuous()), (None, false));
}

#[test]
fn a_property_that_is_settled_before_a_tick_could_arrive_is_not_vacuous() {
    assert_eq!(proved(&Settled, false), (Some(false), false));
    assert_eq!(proved(&Settled, true), (Some(false), false));
}
