//! Random systems in which one message makes many things wait, on both sides of the number that a search follows.

use std::collections::VecDeque;
use std::iter::repeat_n;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, ChannelId, ChannelSystem, Domain, Envelope, GraphMonitor, GraphProcess, Label, Message,
    NoNormalForm, NormalForm, Offer, Pattern, Process, ProcessId, ProgramGraph, RequestNumber, Role, Slot,
    TickGenerator, Topology, TransitionId, Use,
};
use explorer::{Closed, Environment, Instant, Move, Ticks};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::random_systems::{Client, PERIOD, Sample, graph, words};

/// Whether the system with this seed is one of them. Faults and environments go by the remainder of a seed, too: 11 has
/// no factor in common with their numbers, so keepers meet all of them.
pub(crate) fn is_one(seed: u64) -> bool {
    seed % 11 == 5
}

/// Whether a system is one of them.
pub(crate) fn has_keeper(system: &ChannelSystem) -> bool {
    system.topology().find_process("Keeper").is_some()
}

/// Whether more waits in a process than a search follows. It does not ask for normal forms, so it can judge them.
pub(crate) fn is_piled_up(system: &ChannelSystem) -> bool {
    let mut keepers = system.topology().processes().filter_map(|id| system.process::<Keeper>(id));
    keepers.any(Keeper::is_piled_up)
}

/// A client asks a keeper, which tells the process A. A reads often, seldom or never.
pub(crate) fn sample(seed: u64, patience_s: impl Fn(u64) -> u64, another: Option<u64>) -> Sample {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut topology = Topology::default();
    let [generator, client, keeper, reader] =
        ["Ticks", "Client", "Keeper", "A"].map(|name| topology.process(name).expect("a new name"));
    let mut channel =
        |source, target, capacity, domain| topology.channel(source, target, capacity, domain).expect("a new channel");
    let ticks = channel(generator, client, Capacity::One, Domain::new([TickGenerator::shape()]));
    let asked = channel(client, keeper, capacity(rng), words(Role::Request));
    let answered = channel(keeper, client, Capacity::One, words(Role::Reply));
    let told = channel(keeper, reader, capacity(rng), words(Role::Request));
    let asks = Client::new(ticks, asked, answered, patience_s(rng.random_range(3..=14)));
    let keeps = Keeper::draw(rng, asked, answered, told);
    let reads = GraphProcess::new(graph(rng, &[], &[told], another));
    let processes: [(ProcessId, Box<dyn Process>); 4] = [
        (generator, Box::new(TickGenerator::new(ticks))),
        (client, Box::new(asks)),
        (keeper, Box::new(keeps)),
        (reader, Box::new(reads)),
    ];
    let system = ChannelSystem::new(Arc::new(topology), processes).expect("a sound system");
    let first = Duration::from_secs(rng.random_range(0..=3));
    let environment = if rng.random_bool(0.4) { Callers { keeper }.erased() } else { Closed.erased() };
    let monitor = rng.random_bool(0.7).then(|| monitor(rng, &[ticks, asked, answered, told], &[answered, told]));
    Sample { system, ticks: Ticks { generator, period: PERIOD, first, step: Duration::ZERO }, environment, monitor }
}

fn capacity(rng: &mut impl Rng) -> Capacity {
    if rng.random_bool(0.3) { Capacity::Zero } else { Capacity::One }
}

/// From 1 to 45. Each power of two is as likely as the next one, so few things wait as often as many.
fn several(rng: &mut impl Rng) -> usize {
    let least = 1_usize << rng.random_range(0..6_u32);
    rng.random_range(least..(2 * least).min(46))
}

/// Violated after three steps: mostly, that a last word arrives, which happens only once all before it have been read.
fn monitor(rng: &mut impl Rng, channels: &[ChannelId], from_keeper: &[ChannelId]) -> GraphMonitor {
    let mut graph = ProgramGraph::builder("property");
    let locations: Vec<_> = (0..4).map(|index| graph.location(&format!("m{index}"))).collect();
    let seen = graph.variable("seen");
    for step in locations.windows(2) {
        let label = match rng.random_range(0..4) {
            0 => Label::Tick(seen),
            1 => Label::Receive(channels[rng.random_range(0..channels.len())], Slot::Variable(seen)),
            _ => Label::Receive(from_keeper[rng.random_range(0..from_keeper.len())], Slot::Given(word("b"))),
        };
        graph.transition(step[0], label, step[1]);
    }
    GraphMonitor::new(Arc::new(graph.initial(locations[0]).build().expect("a sound graph")), [locations[3]])
}

fn word(word: &str) -> Message {
    Message::symbols([word])
}

/// What a request makes wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    /// What the keeper does by itself. The last of it becomes news.
    Work,
    /// Answers to the client.
    Answers,
    /// Messages to A.
    News,
    /// Timers. Each becomes news when it fires.
    Timers,
}

/// Makes many things wait when it receives a request.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Keeper {
    asked: ChannelId,
    answered: ChannelId,
    told: ChannelId,
    kind: Kind,
    count: usize,
    /// Whether it gives one answer in any case: the client asks again sooner.
    answers_once: bool,
    /// Whether it takes a request while anything waits.
    is_eager: bool,
    delay: Duration,
    work: usize,
    answers: VecDeque<Envelope>,
    news: VecDeque<Envelope>,
    timers: Vec<Duration>,
}

impl Keeper {
    fn draw(rng: &mut impl Rng, asked: ChannelId, answered: ChannelId, told: ChannelId) -> Self {
        let kinds = [Kind::Work, Kind::Answers, Kind::News, Kind::News, Kind::Timers];
        Self {
            asked,
            answered,
            told,
            kind: kinds[rng.random_range(0..kinds.len())],
            count: several(rng),
            answers_once: rng.random_bool(0.6),
            is_eager: rng.random_bool(0.7),
            // Longer than a period: a call that only sets timers is the same now or when time passes next.
            delay: PERIOD + Duration::from_secs(rng.random_range(1..=15)),
            work: 0,
            answers: VecDeque::new(),
            news: VecDeque::new(),
            timers: Vec::new(),
        }
    }

    /// How much of each kind waits.
    fn waiting(&self) -> [usize; 4] {
        [self.work, self.answers.len(), self.news.len(), self.timers.len()]
    }

    fn is_idle(&self) -> bool {
        self.waiting() == [0; 4]
    }

    fn is_piled_up(&self) -> bool {
        self.waiting().into_iter().any(|count| count > NormalForm::QUEUE)
    }

    fn serve(&mut self, request: RequestNumber, now: Duration) {
        let count = self.count;
        // The last word is another one: it is seen only if none before it was forgotten.
        let words = (1..=count).map(|number| word(if number == count { "b" } else { "a" }));
        match self.kind {
            Kind::Work => self.work += count,
            Kind::Answers => self.answers.extend(words.map(|message| Envelope { message, request })),
            Kind::News => self.news.extend(words.map(Envelope::from)),
            Kind::Timers => self.timers.extend(repeat_n(now + self.delay, count)),
        }
        if self.answers_once && self.kind != Kind::Answers {
            self.answers.push_back(Envelope { message: word("a"), request });
        }
    }

    fn finish_work(&mut self) {
        self.work -= 1;
        if self.work == 0 {
            self.news.push_back(word("b").into());
        }
    }
}

impl Process for Keeper {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let mut offer = |number, action| offers.push(Offer { transition: TransitionId(number), action });
        if self.is_eager || self.is_idle() {
            offer(0, Action::Receive(self.asked, Pattern::Any));
        }
        if self.work > 0 {
            offer(1, Action::Internal);
        }
        if let Some(envelope) = self.answers.front() {
            offer(2, Action::Send(self.answered, envelope.clone()));
        }
        if let Some(envelope) = self.news.front() {
            offer(3, Action::Send(self.told, envelope.clone()));
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        match (transition.0, received) {
            (0, Some(envelope)) => self.serve(envelope.request, now),
            (1, _) => self.finish_work(),
            (2, _) => _ = self.answers.pop_front(),
            _ => _ = self.news.pop_front(),
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.timers.first().copied()
    }

    fn fire_timers(&mut self, now: Duration) {
        let before = self.timers.len();
        self.timers.retain(|due| *due > now);
        self.news.extend(repeat_n(Envelope::from(word("b")), before - self.timers.len()));
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Receives(self.asked, None), Use::Sends(self.answered, None), Use::Sends(self.told, None)]
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        for count in self.waiting() {
            form.queue(count, || "more and more waits in the keeper".to_owned())?;
        }
        self.answers.iter_mut().for_each(|envelope| form.envelope(self.answered, envelope));
        self.news.iter_mut().for_each(|envelope| form.envelope(self.told, envelope));
        self.timers.iter_mut().for_each(|due| form.time(due));
        Ok(())
    }

    fn location(&self) -> String {
        "keeping".to_owned()
    }
}

/// The environment may call the keeper whenever it is idle.
#[derive(Debug)]
struct Callers {
    keeper: ProcessId,
}

impl Environment for Callers {
    type State = ();

    fn driven(&self) -> &[ProcessId] {
        std::slice::from_ref(&self.keeper)
    }

    fn start(&self) {}

    fn moves(&self, (): &(), _driven: &[&dyn Process], _instant: Instant) -> Vec<Move<()>> {
        [0, 1].map(|calls| Move { state: (), reports: [calls].into_iter().collect() }).to_vec()
    }

    fn report(&self, _id: ProcessId, report: u32, process: &mut dyn Process, now: Duration) {
        let keeper = process.as_any_mut().downcast_mut::<Keeper>().expect("a keeper");
        if report == 1 && keeper.is_idle() {
            keeper.serve(RequestNumber(0), now);
        }
    }

    fn words(&self, (): &(), _driven: &[&dyn Process], _instant: Instant) -> Vec<String> {
        ["", "somebody calls"].map(str::to_owned).to_vec()
    }
}
