//! How tree, skills and components run: the `[execution]` of a scenario file.

use std::path::PathBuf;
use std::time::Duration;

use components::StopRule;
use diagnostics::Spanned;
use diagnostics::document::{Referent, Table};

use super::robot::STEP;
use super::world::MAP;
use crate::files::path;

/// The form of the tree's process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeForm {
    /// One process for the whole tree.
    Whole,
    /// One process per node, with handshakes, as in the paper.
    Nodes,
}

/// The scheduling policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// Each enabled transition is equally likely.
    Random,
    /// Each process takes its turn.
    RoundRobin,
}

/// An order among messages, as in [`channels::Precedence`]: two events in the SCOPE language.
#[derive(Clone, Debug)]
pub struct Order {
    /// What comes first.
    pub first: Spanned<String>,
    /// The message that waits for it.
    pub then: Spanned<String>,
}

/// How tree, skills and components are run.
#[derive(Clone, Debug)]
pub struct Execution {
    /// Time between ticks.
    pub tick: Duration,
    /// The file with the schedule that runs follow, if they follow one.
    pub schedule: Option<Spanned<PathBuf>>,
    /// The scheduling policy.
    pub policy: Policy,
    /// This process moves only when no other can.
    pub starved: Option<Spanned<String>>,
    /// Orders among messages that the scheduler must enforce.
    pub orders: Vec<Order>,
    /// The effect of a stop request to Navigation.
    pub stops: StopRule,
    /// The form of the tree's process.
    pub tree: TreeForm,
    /// How long the tree waits for a leaf's answer.
    pub leaf_timeout: Duration,
    /// The latest time at which the run ends.
    pub max_time: Duration,
    /// The maximum number of transitions of the system in one step of the simulation. Beyond it, the system is
    /// considered never to become quiet.
    pub step_budget: u64,
    /// The maximum number of communications in a run.
    pub run_budget: u64,
}

impl Default for Execution {
    fn default() -> Self {
        Self {
            tick: Duration::from_secs(1),
            schedule: None,
            policy: Policy::Random,
            starved: None,
            orders: Vec::new(),
            stops: StopRule::OwnTrip,
            tree: TreeForm::Whole,
            leaf_timeout: bt::LEAF_TIMEOUT,
            max_time: Duration::from_secs(3600),
            step_budget: 100_000,
            run_budget: 10_000_000,
        }
    }
}

/// The least time between ticks: 100 per second.
const SHORTEST_TICK: Duration = Duration::from_millis(10);

impl Execution {
    /// Time between the steps of a run, each of which may have a tick.
    #[must_use]
    pub fn step(&self) -> Duration {
        STEP.min(self.tick)
    }

    pub(super) fn read(root: Table<'_>) -> Self {
        let defaults = Self::default();
        let table = root.table("execution").about("How tree, skills and components run.").optional();
        let Some(table) = table else { return defaults };
        let seconds = |key, about| table.seconds(key).about(about);
        let budget = |key, about, default| table.get::<u64>(key).about(about).at_least(1).default(default);
        let tick = seconds("tick_s", "Time between ticks of the tree, in seconds.").at_least(SHORTEST_TICK);
        let trees = [("whole", TreeForm::Whole), ("nodes", TreeForm::Nodes)];
        let tree = table.one_of("tree", &trees).about(
            "The tree as one process (`whole`), or one process per node with handshakes (`nodes`), as in the paper.",
        );
        let schedule = path(
            table,
            "schedule",
            "A file with a schedule, as `steward prove --out` writes it. The run follows the schedule step by step, \
             without drivers and physics.",
        );
        let policies = [("random", Policy::Random), ("round-robin", Policy::RoundRobin)];
        let policy = table.one_of("policy", &policies).about(
            "How the next enabled transition is chosen: at random (`random`), or from each process in turn \
             (`round-robin`).",
        );
        let rules = [("own-trip", StopRule::OwnTrip), ("any-trip", StopRule::AnyTrip)];
        let stops = table.one_of("stops", &rules).needs(MAP).about(
            "What a stop request to the built-in Navigation ends: the trip to its own place (`own-trip`), or any trip, \
             as in the paper's published system (`any-trip`).",
        );
        let starved = table.text("starve").about("This process moves only when no other can.");
        let starved = starved.refers_to(Referent::Process).spanned();
        let orders = table.tables("order").about("A message is received only after another one.");
        let leaf_timeout = seconds(
            "leaf_timeout_s",
            "The time, in seconds, after which a leaf that has not answered the tree counts as failed or, if it was \
             told to halt, as halted.",
        );
        let max_time = seconds("max_time_s", "The latest end of the run, in simulated seconds.").above_0();
        Self {
            tick: tick.default(defaults.tick),
            tree: tree.or_first(&trees),
            schedule: schedule.refers_to(Referent::File(&["json"])).optional(),
            policy: policy.or_first(&policies),
            stops: stops.or_first(&rules),
            starved: starved.optional(),
            orders: orders.each(Order::read).or(Vec::new()),
            leaf_timeout: leaf_timeout.above_0().default(defaults.leaf_timeout),
            max_time: max_time.default(defaults.max_time),
            step_budget: budget(
                "step_budget",
                "The maximum number of transitions in one step. Beyond it, the run ends because the system never \
                 becomes quiet.",
                defaults.step_budget,
            ),
            run_budget: budget(
                "run_budget",
                "The maximum number of messages in a run, which is then stopped.",
                defaults.run_budget,
            ),
        }
    }
}

impl Order {
    fn read(table: Table<'_>) -> Option<Self> {
        let event = |key, about| table.text(key).about(about).refers_to(Referent::Event).spanned().required();
        let first =
            event("first", "The message that comes first: an event of the SCOPE language, or several joined by `or`.");
        let then = event("then", "The message that waits for it.");
        Some(Self { first: first?, then: then? })
    }
}
