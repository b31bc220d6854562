//! Triggers of faults, and their durations and repetitions.

use std::time::Duration;

use diagnostics::document::{Referent, Table};
use diagnostics::{Problem, Spanned};

/// The keys of triggers, of which a fault has exactly one.
pub(super) const TRIGGERS: [&str; 5] = ["at_s", "at_tick", "near", "when", "in_state"];

/// The trigger of a fault. Each fires on an edge: when its condition *becomes* true.
#[derive(Clone, Debug)]
pub enum Trigger {
    /// The run reaches this time: `at_s`. With `every_s`, this repeats.
    Time {
        /// For the first time.
        at: Duration,
        /// The time between repetitions.
        every: Option<Duration>,
    },
    /// The tick with this number has been generated: `at_tick`.
    Tick(u64),
    /// The robot's true position is this close to a place: `near` and `within_m`.
    Near {
        /// The place.
        place: Spanned<String>,
        /// The distance, in meters.
        within_m: f64,
    },
    /// A message has been received: `when`, an event in the SCOPE language, `(BatteryReader, BatteryLevel, m[2] < 30)`.
    Message(Spanned<String>),
    /// A process has entered a state: `in_state`, `"GoToDestination.running"`.
    State {
        /// The process, which is a skill.
        process: Spanned<String>,
        /// The state.
        state: String,
    },
}

/// When a fault is active.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Its trigger.
    pub trigger: Trigger,
    /// The probability that it becomes active when the trigger fires.
    pub probability: f64,
    /// How long it is active; `None` until the end of the run.
    pub lasts: Option<Duration>,
    /// The maximum number of times that it becomes active.
    pub times: u64,
}

impl Timing {
    /// Whether both may be active at the same time, with steps of `dt`. Only triggers by time are predictable.
    pub(crate) fn may_overlap(&self, other: &Self, dt: Duration) -> bool {
        let ((from, to), (other_from, other_to)) = (self.window(dt), other.window(dt));
        from < other_to && other_from < to
    }

    /// The interval in which it may be active.
    fn window(&self, dt: Duration) -> (Duration, Duration) {
        let Trigger::Time { at, every } = self.trigger else { return (Duration::ZERO, Duration::MAX) };
        let from = step_at(at, dt);
        let once = self.lasts.filter(|_| every.is_none());
        (from, once.map_or(Duration::MAX, |lasts| step_at(from.saturating_add(lasts), dt)))
    }

    /// Reads the keys that determine when a fault is active. If it is `momentary`, it cannot last.
    pub(super) fn read(table: Table<'_>, momentary: bool) -> Option<Self> {
        let trigger = read_trigger(table);
        let probability = table.number("probability").within(0.0..=1.0);
        let probability = probability.about("The probability that the fault takes effect when it is triggered.");
        let probability = probability.default(1.0);
        let lasts = table.seconds("lasts_s").above_0().spanned().about(
            "How long it lasts, in seconds. Without it, the fault lasts to the end of the run. A momentary fault \
             cannot last.",
        );
        let lasts = lasts.optional();
        if let Some(lasts) = lasts.as_ref().filter(|_| momentary) {
            let problem = lasts.span.problem("this fault is instantaneous and cannot last");
            table.report(problem.with_label("remove this").with_help("use `every_s` and `times` to repeat it"));
        }
        let every = table.seconds("every_s").above_0();
        let every = every.about("With `at_s`: the fault repeats after this time, in seconds.").optional();
        let trigger = trigger.map(|trigger| match trigger {
            Trigger::Time { at, .. } => Trigger::Time { at, every },
            other => other,
        });
        let times = table.get::<u64>("times").within(1..=1_000_000_000);
        let times = times
            .about("The maximum number of times that it takes effect. By default once; with `every_s`, without limit.");
        let times = times.optional();
        let repeats = !matches!(trigger, Some(Trigger::Time { every: None, .. } | Trigger::Tick(_)));
        if times.is_some_and(|times| times > 1) && !repeats {
            let problem = table.span().problem("a fault at a single time is active once, but `times` is larger");
            table.report(problem.with_label("here").with_help("add `every_s`, the time between repetitions"));
        }
        let forever = matches!(trigger, Some(Trigger::Time { every: Some(_), .. }));
        let times = times.unwrap_or(if forever { u64::MAX } else { 1 });
        Some(Self { trigger: trigger?, probability, lasts: lasts.map(|lasts| lasts.value), times })
    }
}

/// The first step at or after a time.
fn step_at(time: Duration, dt: Duration) -> Duration {
    let nanos = time.as_nanos().next_multiple_of(dt.as_nanos().max(1));
    u64::try_from(nanos).map_or(Duration::MAX, Duration::from_nanos)
}

/// Reads the only trigger of a fault, without its repetitions.
fn read_trigger(table: Table<'_>) -> Option<Trigger> {
    let text = |key, about, what| table.text(key).about(about).refers_to(what).spanned().optional();
    let at = table.seconds("at_s").about("Trigger: the fault takes effect at this time, in seconds.").optional();
    let tick = table.get::<u64>("at_tick").about("Trigger: when this tick has been generated.").optional();
    let near = text(
        "near",
        "Trigger: when the center of the robot comes near this place: its position, or the edge of its area.",
        Referent::Place,
    );
    let message = text(
        "when",
        "Trigger: when such a message has been received: an event of the SCOPE language, or several joined by `or`.",
        Referent::Event,
    );
    let state = table.text("in_state").about("Trigger: when a skill enters a state.").words("`SKILL.STATE`");
    let state = state.refers_to(Referent::LeafState).spanned().optional();
    let within_m = table.number("within_m").about("With `near`: how near, in meters.").within(0.0..=1e6).default(1.0);
    let given = TRIGGERS.into_iter().filter(|key| table.has(key));
    let given: Vec<&str> = given.collect();
    if given.len() != 1 {
        let message = match given.as_slice() {
            [] => "this fault has no trigger".to_owned(),
            several => format!("this fault has several triggers: `{}`", several.join("`, `")),
        };
        let help = "use one of `at_s`, `at_tick`, `near` (with `within_m`), `when`, `in_state`; `at_s = 0` means from the start";
        table.report(table.span().problem(message).with_label("this fault").with_help(help));
        return None;
    }
    for (key, belongs_to) in [("every_s", "at_s"), ("within_m", "near")] {
        if table.has(key) && given[0] != belongs_to {
            let problem =
                table.span().problem(format!("`{key}` requires `{belongs_to}`, which this fault does not have"));
            table.report(problem.with_label("this fault").with_help(format!("remove `{key}`")));
        }
    }
    let state = state.map(|text| split_state(&text)).transpose().map_err(|problem| table.report(problem)).ok()?;
    let time = at.map(|at| Trigger::Time { at, every: None });
    let near = near.map(|place| Trigger::Near { place, within_m });
    time.or(tick.map(Trigger::Tick)).or(near).or(message.map(Trigger::Message)).or(state)
}

fn split_state(text: &Spanned<String>) -> Result<Trigger, Problem> {
    let Some((process, state)) = text.value.split_once('.') else {
        let problem = text.span.problem(format!("`{}` is not a state of a skill", text.value));
        return Err(problem
            .with_label("this text")
            .with_help("write a skill, a dot and a state: `GoToDestination.running`"));
    };
    let process = Spanned { value: process.trim().to_owned(), span: text.span.clone() };
    Ok(Trigger::State { process, state: state.trim().to_owned() })
}
