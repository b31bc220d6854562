//! Leaves in which more messages or delayed events wait than a search follows: what a run can do after that is neither
//! proved nor violated.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Event, Monitor, NoNormalForm, NormalForm, Verdict};
use explorer::{Limits, Order, Outcome, Reduction};
use scenarios::scenario::{ProofOutcome, Scenario, find};
use tempfile::{TempDir, tempdir};

use super::Proof;
use super::texts::{Dice, demanded};

const PROVED: Option<ProofOutcome> = Some(ProofOutcome::Proved);
const VIOLATED: Option<ProofOutcome> = Some(ProofOutcome::Violated);
const UNDECIDED: Option<ProofOutcome> = None;

const ASKS: &str = r#"<send type="channel" target="K" event="ask"/>"#;
const DELAYS: &str = r#"<send event="late" delay="1000s"/>"#;
const ANSWERS: &str = r#"<send type="channel" targetexpr="_event.origin" event="ok"/>"#;

/// How the component K behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    /// It answers the first request and none after it.
    AnswersOnce,
    AnswersNothing,
    /// It answers each request at once.
    Answers,
    /// It answers each request after a second, and takes the next one then.
    AnswersLate,
    /// It answers, but may freeze at any time.
    MayFreeze,
    /// There is none.
    Missing,
}

impl Component {
    /// The content of its machine.
    fn machine(self) -> String {
        let silent = "<state id=\"silent\"/>";
        match self {
            Self::AnswersOnce => format!(
                "<state id=\"first\"><transition event=\"ask\" target=\"silent\">{ANSWERS}</transition></state>{silent}"
            ),
            Self::AnswersNothing => {
                format!("<state id=\"first\"><transition event=\"ask\" target=\"silent\"/></state>{silent}")
            }
            Self::AnswersLate => r#"<datamodel><data id="client" expr="''"/></datamodel>
<state id="first"><transition event="ask" target="later"><assign location="client" expr="_event.origin"/></transition>
</state><state id="later"><onentry><send event="done" delay="1s"/></onentry>
<transition event="done" target="first"><send type="channel" targetexpr="client" event="ok"/></transition></state>"#
                .to_owned(),
            Self::Answers | Self::MayFreeze | Self::Missing => {
                format!("<state id=\"first\"><transition event=\"ask\">{ANSWERS}</transition></state>")
            }
        }
    }
}

/// A tree with one leaf. It fails so many times and does something each time; from then on it succeeds.
#[derive(Clone, Debug)]
struct Application {
    failures: usize,
    does: String,
    /// More transitions of the leaf.
    also: String,
    component: Component,
    /// How many messages the property `few` allows within two ticks.
    few: u64,
}

/// The properties of an application. `p` is violated by the leaf's success, `q` only if the leaf takes longer than a
/// second to answer a tick, which it never does, and `few` by too many requests to K or, without K, to the leaf.
const PROPERTIES: [&str; 4] = ["p", "q", "few", "progress"];

fn application(count: usize, does: &str, component: Component) -> TempDir {
    Application { failures: count, does: does.to_owned(), also: String::new(), component, few: 2 }.write()
}

impl Application {
    fn write(&self) -> TempDir {
        let Self { failures, does, also, component, few } = self;
        let scxml = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">"#;
        let heard = if *component == Component::Missing { "" } else { "<transition event=\"K.*\"/>" };
        let leaf = format!(
            r#"{scxml}<datamodel><data id="n" expr="0"/><data id="m" expr="0"/></datamodel>
<state id="here"><transition event="BT.tick" cond="n &lt; {failures}"><assign location="n" expr="n + 1"/>{does}
<send type="channel" target="BT" event="failure"/></transition>
<transition event="BT.tick"><send type="channel" target="BT" event="success"/></transition>{also}{heard}
<transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition></state></scxml>"#
        );
        let mut scenario = "tree = \"tree.xml\"\nskills = \".\"\nproperties = [\"p.scope\"]\n".to_owned();
        if *component != Component::Missing {
            scenario += "[components.K]\nmachine = \"K.scxml\"\ninterface = \"K.toml\"\n";
        }
        scenario += "[prove]\n";
        if *component == Component::MayFreeze {
            scenario += "faults.component_frozen = \"K\"\n";
        }
        let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="M"><Action ID="L0"/></BehaviorTree></root>"#;
        let counted = if *component == Component::Missing { "(BT, L0, true)" } else { "(L0, K, true)" };
        let properties = format!(
            "property p := always not (L0, BT, m[1] = <success>)\n\
             property q := always ((BT, L0, true) implies time_until (L0, BT, true) < 1)\n\
             property few := always at most {few} {counted} in 2\n"
        );
        let folder = tempdir().expect("a folder");
        for (name, text) in [
            ("s.toml", scenario.as_str()),
            ("tree.xml", tree),
            ("p.scope", &properties),
            ("L0.scxml", &leaf),
            ("K.scxml", &format!("{scxml}{}</scxml>", component.machine())),
            ("K.toml", "[services.ask]\nrequest = {}\nreply = {}\n"),
        ] {
            std::fs::write(folder.path().join(name), text).expect("room for a file");
        }
        folder
    }
}

fn scenario(folder: &Path) -> Arc<Scenario> {
    let found = find::find(folder.join("s.toml").to_str().expect("UTF-8")).expect("it was written");
    Arc::new(Scenario::load_for_proof(&found, &[]).expect("a sound scenario"))
}

/// Whether more waits in a process than a search follows.
fn is_piled_up(system: &ChannelSystem) -> bool {
    matches!(system.fork().normalize(), Err((_, NoNormalForm::Endless { .. })))
}

/// The results for these properties. Each run that is shown is replayed.
fn results<const N: usize>(folder: &Path, properties: [&str; N], limits: &Limits) -> [Option<ProofOutcome>; N] {
    let scenario = scenario(folder);
    properties.map(|property| {
        let proof = Proof::new(Arc::clone(&scenario), &[property.to_owned()]).expect("it can be proved");
        let question = &proof.questions()[0];
        let answer = proof.prove(question, limits, &mut |_| {}).expect("it can be explored");
        let replay =
            |path: &explorer::Path| path.replay(&answer.model, proof.monitor(question)).expect("a run of the system");
        match &answer.exploration.outcome {
            Outcome::Violated(path) => assert_eq!(replay(path).verdict(), Verdict::False, "{property}"),
            Outcome::Endless(path) => assert!(is_piled_up(&replay(path).system), "{property}: {path:#?}"),
            _ => {}
        }
        answer.outcome()
    })
}

/// With every order of the search, and with the reduction.
fn all_results(application: &TempDir) -> [Option<ProofOutcome>; 3] {
    let of = |order, reduction| {
        let limits = Limits { order, reduction, ..Limits::default() };
        results(application.path(), ["p", "q", "progress"], &limits)
    };
    let found = of(Order::Breadth, Reduction::Off);
    assert_eq!(of(Order::Breadth, Reduction::On), found);
    assert_eq!(of(Order::Depth, Reduction::Off), found);
    found
}

#[test]
fn a_leaf_with_more_waiting_messages_than_the_search_follows_proves_nothing() {
    // K takes one message more than it answers, another one waits in the channel, and the others in the leaf.
    for (component, most) in
        [(Component::AnswersOnce, NormalForm::QUEUE + 3), (Component::AnswersNothing, NormalForm::QUEUE + 2)]
    {
        let with = |count| all_results(&application(count, ASKS, component));
        assert_eq!(with(most), [VIOLATED, PROVED, PROVED], "{component:?}");
        assert_eq!(with(most + 1), [UNDECIDED, UNDECIDED, VIOLATED], "{component:?}");
        assert_eq!(with(45), [UNDECIDED, UNDECIDED, VIOLATED], "{component:?}");
    }
}

#[test]
fn a_leaf_with_more_delayed_events_than_the_search_follows_proves_nothing() {
    let with = |count| all_results(&application(count, DELAYS, Component::Missing));
    assert_eq!(with(NormalForm::QUEUE), [VIOLATED, PROVED, PROVED]);
    assert_eq!(with(NormalForm::QUEUE + 1), [UNDECIDED, UNDECIDED, VIOLATED]);
    assert_eq!(with(45), [UNDECIDED, UNDECIDED, VIOLATED]);
}

#[test]
fn a_violation_is_found_beside_runs_in_which_messages_pile_up() {
    // While K is frozen, messages pile up before the leaf first succeeds; while it is not, none do.
    let application = application(NormalForm::QUEUE + 4, ASKS, Component::MayFreeze);
    let found = results(application.path(), ["p", "progress"], &Limits::default());
    assert_eq!(found, [VIOLATED, VIOLATED]);
}

/// In which way the leaf does it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Once at each of many ticks.
    Steadily,
    /// Many times at a few ticks, in one transition.
    InOneTransition,
    /// The same, in a transition that raises its own event again.
    Raising,
}

const WAYS: [Way; 3] = [Way::Steadily, Way::InOneTransition, Way::Raising];

const COMPONENTS: [Component; 5] = [
    Component::AnswersOnce,
    Component::AnswersNothing,
    Component::Answers,
    Component::AnswersLate,
    Component::MayFreeze,
];

/// One of them.
fn pick<T: Copy>(dice: &mut Dice, all: &[T]) -> T {
    all[below(dice, all.len())]
}

fn below(dice: &mut Dice, sides: usize) -> usize {
    usize::try_from(dice.roll(sides as u64)).expect("few")
}

/// From 1 to 45. Each power of two is as likely as the next one, so few things wait as often as many.
fn several(dice: &mut Dice) -> usize {
    let least = 1 << below(dice, 6);
    least + below(dice, least.min(46 - least))
}

impl Application {
    /// A random one: its leaf asks K, or sends itself delayed events, with which it may ask K later.
    fn draw(dice: &mut Dice) -> (Way, Self) {
        let way = pick(dice, &WAYS);
        let late = format!("<send event=\"late\" delay=\"{}\"/>", pick(dice, &["3s", "1000s"]));
        let component = pick(dice, &COMPONENTS);
        let (what, component, mut also) = match dice.roll(4) {
            0 => (late, Component::Missing, String::new()),
            1 => (late, component, format!("<transition event=\"late\">{ASKS}</transition>")),
            _ => (ASKS.to_owned(), component, String::new()),
        };
        let (count, a_few) = (several(dice), 1 + below(dice, 3));
        let (failures, does) = match way {
            Way::Steadily => (count, what),
            Way::InOneTransition => (a_few, what.repeat(count)),
            Way::Raising => {
                also += &format!(
                    "<transition event=\"more\" cond=\"m &lt; {count}\"><assign location=\"m\" expr=\"m + 1\"/>{what}\
                     <raise event=\"more\"/></transition>"
                );
                (a_few, "<assign location=\"m\" expr=\"0\"/><raise event=\"more\"/>".to_owned())
            }
        };
        (way, Self { failures, does, also, component, few: dice.roll(8) })
    }
}

/// A property in a random run.
struct WatchedProperty {
    monitor: Box<dyn Monitor>,
    /// If it is violated, whether more had waited before than a search follows.
    violated: Option<bool>,
}

/// A random run. Nothing freezes in it.
struct RandomRun<'a> {
    dice: &'a mut Dice,
    system: ChannelSystem,
    /// Whether more waits, or has waited, than a search follows.
    piled_up: bool,
    watched: Vec<WatchedProperty>,
}

impl RandomRun<'_> {
    /// Looks at the system after a step.
    fn see(&mut self, event: Option<&Event>) {
        for WatchedProperty { monitor, violated } in &mut self.watched {
            event.into_iter().for_each(|event| monitor.observe(event));
            if monitor.verdict() == Verdict::False {
                *violated = violated.or(Some(self.piled_up));
            }
        }
        self.piled_up = self.piled_up || is_piled_up(&self.system);
    }

    /// Lets processes move until none can.
    fn until_quiet(&mut self) {
        loop {
            let enabled = self.system.enabled();
            if enabled.is_empty() {
                return;
            }
            let taken = self.system.take(&enabled[below(self.dice, enabled.len())]);
            self.see(taken.expect("a message within its domain").as_ref());
        }
    }

    /// Whether there is no such run if these are the results for the properties.
    fn contradicts(&self, results: &[Option<ProofOutcome>; 4]) -> bool {
        let [of_properties @ .., progress] = results;
        let is_wrong = |(result, property): (&Option<ProofOutcome>, &WatchedProperty)| {
            // A run is followed until something piles up.
            let violated = property.violated;
            *result == PROVED && violated.is_some() || *result == UNDECIDED && violated == Some(false)
        };
        *progress == PROVED && self.piled_up || of_properties.iter().zip(&self.watched).any(is_wrong)
    }
}

/// A random run of so many ticks, as the proof takes them: timers fire, and the tick comes, at the steps of the clock.
fn random_run<'a>(proof: &Proof, ticks: u32, dice: &'a mut Dice) -> RandomRun<'a> {
    let execution = &proof.scenario.file.execution;
    let generator = proof.ids.tree.expect("there is a tree").tick_generator;
    let monitors = proof.questions().iter().filter_map(|question| proof.monitor(question));
    let watched = monitors.map(|monitor| WatchedProperty { monitor: monitor.boxed_clone(), violated: None }).collect();
    let mut run = RandomRun { dice, system: proof.system.fork(), piled_up: false, watched };
    let (mut now, mut next_tick) = (Duration::ZERO, execution.step());
    run.until_quiet();
    while now < execution.tick * ticks {
        now += execution.step();
        if run.system.advance(now) {
            run.see(None);
        }
        if now >= next_tick {
            next_tick += execution.tick;
            let (event, _) = run.system.generate_tick(generator);
            run.see(Some(&event));
        }
        run.until_quiet();
    }
    run
}

/// The results of many proofs.
#[derive(Clone, Debug, Default)]
struct Tally {
    proved: u64,
    violated: u64,
    undecided: u64,
    /// Applications in which more may wait than a search follows, and in which it never does.
    piled_up: u64,
    bounded: u64,
    /// Applications, by the way in which the leaf does it.
    drawn: [u64; WAYS.len()],
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { proved, violated, undecided, piled_up, bounded, drawn } = self;
        write!(f, "{proved} properties proved, {violated} violated, {undecided} undecided; ")?;
        write!(f, "{piled_up} applications in which more waits than is searched, {bounded} in which it does not:")?;
        WAYS.iter().zip(drawn).try_for_each(|(way, count)| write!(f, " {way:?} {count}"))
    }
}

impl Tally {
    fn note(&mut self, way: Way, results: &[Option<ProofOutcome>; 4]) {
        let [of_properties @ .., progress] = results;
        let count =
            |result: Option<ProofOutcome>| of_properties.iter().filter(|found| **found == result).count() as u64;
        self.proved += count(PROVED);
        self.violated += count(VIOLATED);
        self.undecided += count(UNDECIDED);
        *if *progress == PROVED { &mut self.bounded } else { &mut self.piled_up } += 1;
        self.drawn[WAYS.iter().position(|other| *other == way).expect("one of them")] += 1;
    }
}

/// Whether the results fit each other: what is proved never piles up, and all else is undecided only if something does.
fn fit_each_other(results: &[Option<ProofOutcome>; 4]) -> bool {
    let [of_properties @ .., progress] = results;
    *progress != UNDECIDED && !of_properties.contains(if *progress == PROVED { &UNDECIDED } else { &PROVED })
}

/// Compares the results about random applications with each other, and with a few random runs of each.
fn agree(first: u64, applications: u64) -> Tally {
    let (mut tally, mut wrong) = (Tally::default(), Vec::new());
    for seed in first..first + applications {
        let dice = &mut Dice(seed);
        let (way, application) = Application::draw(dice);
        let folder = application.write();
        let (order, reduction) = match seed % 3 {
            0 => (Order::Breadth, Reduction::Off),
            1 => (Order::Breadth, Reduction::On),
            _ => (Order::Depth, Reduction::Off),
        };
        let limits = Limits { order, reduction, ..Limits::default() };
        let found = results(folder.path(), PROPERTIES, &limits);
        tally.note(way, &found);
        let proof = Proof::new(scenario(folder.path()), &PROPERTIES.map(str::to_owned)).expect("it can be proved");
        let ticks = u32::try_from(application.failures).expect("few") + 5;
        let contradicts = (0..3).any(|_| random_run(&proof, ticks, dice).contradicts(&found));
        if contradicts || !fit_each_other(&found) {
            wrong.push(format!("seed {seed}, {order:?}, {reduction:?}: {found:?}\n{application:?}"));
        }
    }
    eprintln!("{applications} applications: {tally}");
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong[..wrong.len().min(5)].join("\n\n"));
    tally
}

#[test]
fn runs_of_applications_in_which_much_waits_do_not_contradict_a_proof() {
    let tally = agree(0, 24);
    assert!(tally.proved > 0 && tally.violated > 0 && tally.undecided > 0, "{tally}");
    assert!(tally.piled_up > 2 && tally.bounded > 2 && tally.drawn.iter().all(|count| *count > 0), "{tally}");
}

#[test]
#[ignore = "long: SYSTEMS=1000 SEED=0 cargo test -p proofs proofs_agree_on_demand -- --ignored --nocapture"]
fn proofs_agree_on_demand() {
    let systems = demanded("SYSTEMS", 500);
    let tally = agree(demanded("SEED", 0), systems);
    let share = |count: &u64| *count * 20 >= systems;
    let mut counts = tally.drawn.iter().chain([&tally.piled_up, &tally.bounded]);
    assert!(systems < 200 || counts.all(share), "each is at least 5 % of the draws: {tally}");
    println!("{systems} applications: {tally}; none wrong");
}
