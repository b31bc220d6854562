//! An SCXML machine as a monitor: messages become events of the machine, and some of its states indicate a violation.

use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{
    ChannelId, Condition, Event, EventKind, LocationId, Message, Monitor, NoNormalForm, NormalForm, ProgramGraph,
    Topology, Value, Verdict,
};
use diagnostics::{Span, Spanned};
use monitors::{MessageCondition, OwnWorld};
use skills::{Chart, Datum, Host, Machine, Note, Outgoing, StateId, StateKind, Undelivered};

use crate::error::Complaints;
use crate::names::unknown;
use crate::occurrences::occurrences;
use crate::scenario::ready_made::{Content, WatchingMachine};

/// Further errors of one machine are not recorded: a report shows them all. Chosen, not measured.
const MOST_ERRORS: usize = 20;

/// A machine that monitors a run.
///
/// In the step of a message that is one of its events, it takes that event and comes to rest. Its own delayed events
/// arrive with the next message or tick. Errors in its scripts are recorded and change nothing else.
#[derive(Clone, Debug)]
pub struct MachineMonitor {
    name: String,
    machine: Machine,
    /// What its rules see of the world.
    world: OwnWorld,
    rules: Arc<[MessageRule]>,
    /// The states in which the property is violated, and those in which an obligation is pending.
    violated_in: Arc<[StateId]>,
    pending_in: Arc<[StateId]>,
    picture: Arc<Picture>,
    violated: bool,
    errors: Vec<String>,
}

/// A rule that maps messages to an event.
#[derive(Debug)]
struct MessageRule {
    channel: ChannelId,
    condition: MessageCondition,
    event: Arc<str>,
    data: Vec<(Arc<str>, Content)>,
}

/// The drawn part of a machine: the states without children in the region that contains the violation.
#[derive(Debug)]
struct Picture {
    graph: ProgramGraph,
    states: Vec<(StateId, LocationId)>,
    failures: Vec<LocationId>,
}

impl MachineMonitor {
    /// The machine attached by the scenario, started; `None` after its problems have been reported.
    pub fn new(
        name: &str,
        chart: &Arc<Chart>,
        file: &WatchingMachine,
        topology: &Topology,
        complaints: &mut Complaints,
    ) -> Option<Self> {
        // Everything is looked up before anything is refused, so that all problems are reported at once.
        let violated_in = states(chart, &file.violated_in, complaints);
        let pending_in = states(chart, &file.pending_in, complaints);
        let rules: Vec<Option<Vec<MessageRule>>> =
            file.events.iter().map(|rule| rules(chart, rule, topology, complaints)).collect();
        if let Some((process, message)) = chart.channel_messages().first() {
            let problem = file.machine.span.problem(format!("the monitor sends <{message}> to {process}"));
            let help = "a monitor never changes a run: remove the `<send>`";
            complaints.push(problem.with_label("this machine").with_help(help));
            return None;
        }
        let (violated_in, pending_in) = (violated_in?, pending_in?);
        let rules: Vec<MessageRule> = rules.into_iter().collect::<Option<Vec<_>>>()?.into_iter().flatten().collect();
        let mut monitor = Self {
            name: name.to_owned(),
            machine: Machine::new(Arc::clone(chart)),
            world: OwnWorld::new(rules.iter().flat_map(MessageRule::mentions), topology),
            rules: rules.into(),
            picture: Arc::new(Picture::new(name, chart, &violated_in)),
            violated_in: violated_in.into(),
            pending_in: pending_in.into(),
            violated: false,
            errors: Vec::new(),
        };
        monitor.run(None, Duration::ZERO, |machine, host| machine.start(Duration::ZERO, host));
        Some(monitor)
    }

    /// The monitor as a machine, if it is one.
    pub fn of(monitor: &dyn Monitor) -> Option<&Self> {
        (monitor as &dyn std::any::Any).downcast_ref()
    }

    /// The machine as it was written.
    pub fn chart(&self) -> &Chart {
        self.machine.chart()
    }

    /// What the machine can learn from messages on such channels: the numbers with which the conditions of its events
    /// compare their fields, and the members of `_event.data` that hold a field.
    pub fn learns(&self, of: impl Fn(ChannelId) -> bool) -> (Vec<f64>, Vec<&str>) {
        let (mut numbers, mut members) = (Vec::new(), Vec::new());
        for rule in self.rules.iter().filter(|rule| of(rule.channel)) {
            rule.condition.comparisons(&mut |_, _, value| numbers.extend(value.as_number()));
            let fields = rule.data.iter().filter(|(_, content)| matches!(content, Content::Field(_)));
            members.extend(fields.map(|(name, _)| &**name));
        }
        (numbers, members)
    }

    /// Whether a message on this channel may be one of its events.
    pub fn watches(&self, channel: ChannelId) -> bool {
        self.rules.iter().any(|rule| rule.channel == channel)
    }

    /// The errors of the machine's scripts, each once.
    pub fn errors(&self) -> &[String] {
        &self.errors
    }

    /// Lets the machine move, and updates its verdict.
    fn run(&mut self, tick: Option<u64>, now: Duration, go: impl FnOnce(&mut Machine, &mut dyn Host)) {
        let mut watch = Watch { violated_in: &self.violated_in, violated: false, messages: Vec::new() };
        self.machine.fire_timers(now, &mut watch);
        go(&mut self.machine, &mut watch);
        self.violated |= watch.violated;
        for message in watch.messages {
            // The same error recurs; only its first occurrence is worth reporting.
            let known = self.errors.iter().any(|error| error.starts_with(&message));
            if !known && self.errors.len() < MOST_ERRORS {
                self.errors
                    .push(tick.map_or_else(|| message.clone(), |tick| format!("{message}; first at tick {tick}")));
            }
        }
    }

    fn is_in_any(&self, states: &[StateId]) -> bool {
        self.machine.configuration().any(|state| states.contains(&state))
    }

    /// The state that determines how the machine continues; `None` if the property is violated for good.
    fn situation(&self) -> Option<(&Machine, &OwnWorld)> {
        (!self.violated).then_some((&self.machine, &self.world))
    }

    /// The active states in the picture.
    fn active(&self) -> impl Iterator<Item = (StateId, LocationId)> + '_ {
        self.machine.active().filter_map(|state| self.picture.states.iter().find(|drawn| drawn.0 == state).copied())
    }
}

impl Monitor for MachineMonitor {
    fn name(&self) -> &str {
        &self.name
    }

    fn boxed_clone(&self) -> Box<dyn Monitor> {
        Box::new(self.clone())
    }

    fn observe(&mut self, event: &Event) {
        if self.violated {
            return;
        }
        let is_seen = self.world.sees(&event.kind);
        let events: Vec<skills::Event> = match &event.kind {
            EventKind::Received { channel, message } if is_seen => {
                let rules = self.rules.iter().filter(|rule| rule.channel == *channel && rule.condition.holds(message));
                rules.map(|rule| rule.event(message)).collect()
            }
            _ => Vec::new(),
        };
        if events.is_empty() && self.machine.next_timer().is_none_or(|due| due > event.time) {
            return;
        }
        self.run(Some(event.tick), event.time, |machine, host| {
            for event_of_machine in events {
                machine.handle(event_of_machine, event.time, host);
            }
        });
    }

    fn verdict(&self) -> Verdict {
        if self.violated { Verdict::False } else { Verdict::Inconclusive }
    }

    fn location(&self) -> String {
        let active: Vec<&str> = self.active().map(|(state, _)| self.machine.chart().state(state).id()).collect();
        active.join(" ")
    }

    fn is_open(&self) -> bool {
        self.is_in_any(&self.pending_in)
    }

    fn graph(&self) -> Option<(&ProgramGraph, LocationId)> {
        self.active().next().map(|(_, location)| (&self.picture.graph, location))
    }

    fn failures(&self) -> &[LocationId] {
        &self.picture.failures
    }

    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        if self.machine.next_timer().is_some() {
            return Err(NoNormalForm::Unsupported {
                reason: "it measures time in seconds, but a monitor in a proof sees only ticks".to_owned(),
                help: Some("write the deadline as a property, with `time_until`".to_owned()),
            });
        }
        self.errors.clear();
        // It contains neither times nor requests.
        self.machine.normalize(&NormalForm::new(&Topology::default(), Duration::ZERO, &|_, number| number))
    }

    fn same_state(&self, other: &dyn Monitor) -> bool {
        Self::of(other).is_some_and(|other| self.situation() == other.situation())
    }

    fn hash_state(&self, mut hasher: &mut dyn Hasher) {
        self.situation().hash(&mut hasher);
    }
}

impl MessageRule {
    /// The fields of messages that it mentions.
    fn mentions(&self) -> Vec<(ChannelId, usize)> {
        let mut fields = Vec::new();
        self.condition.fields(&mut |field| fields.push((self.channel, field.number)));
        fields.extend(self.data.iter().filter_map(|(_, content)| match content {
            Content::Field(field) => Some((self.channel, *field)),
            Content::Value(_) => None,
        }));
        fields
    }

    fn event(&self, message: &Message) -> skills::Event {
        let members = self.data.iter().map(|(name, content)| (Arc::clone(name), content.datum(message)));
        // Only a text of several megabytes is too large; the machine then sees no data.
        let data = if self.data.is_empty() { Datum::Undefined } else { Datum::object(members).unwrap_or_default() };
        skills::Event::external(Arc::clone(&self.event)).with_data(data)
    }
}

impl Content {
    /// Its value when this message was received.
    fn datum(&self, message: &Message) -> Datum {
        match self {
            Self::Field(field) => message.field(*field).map_or(Datum::Undefined, datum),
            Self::Value(value) => value.clone(),
        }
    }
}

fn datum(value: &Value) -> Datum {
    match value {
        Value::Symbol(symbol) => symbol.name().into(),
        Value::Bool(truth) => (*truth).into(),
        Value::Int(number) => (*number as f64).into(),
        Value::Real(number) => (*number).into(),
        Value::Text(text) => Datum::Text(Arc::clone(text)),
        // Only several megabytes are too large.
        Value::List(items) => Datum::array(items.iter().map(datum)).unwrap_or_default(),
    }
}

fn states(chart: &Chart, ids: &[Spanned<String>], complaints: &mut Complaints) -> Option<Vec<StateId>> {
    let find = |id: &Spanned<String>| {
        let found = chart.find_state(&id.value);
        if found.is_none() {
            let known = chart.states().map(|state| chart.state(state).id());
            complaints.push(unknown(&format!("state of {}", chart.name()), id, known));
        }
        found
    };
    ids.iter().map(find).collect::<Vec<_>>().into_iter().collect()
}

/// A rule for each event that the scenario's rule names.
fn rules(
    chart: &Chart,
    rule: &crate::scenario::ready_made::EventRule,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<Vec<MessageRule>> {
    let Spanned { value: name, span } = &rule.event;
    if !chart.handles(name) {
        deaf(chart, name, span, complaints);
    }
    let events = occurrences(&rule.when, topology, complaints)?;
    let rule = |event: monitors::EventAtom| MessageRule {
        channel: event.channel,
        condition: event.condition,
        event: name.as_str().into(),
        data: rule.data.iter().map(|(name, content)| (name.as_str().into(), content.clone())).collect(),
    };
    chart.handles(name).then(|| events.into_iter().map(rule).collect())
}

fn deaf(chart: &Chart, name: &str, span: &Span, complaints: &mut Complaints) {
    let mut received: Vec<&str> =
        chart.transitions().flat_map(|transition| chart.transition(transition).events()).collect();
    received.sort_unstable();
    received.dedup();
    let problem = span.problem(format!("no transition of {} is triggered by the event `{name}`", chart.name()));
    let help = diagnostics::did_you_mean(name, received.iter().copied());
    let help = help.unwrap_or_else(|| format!("it takes {}", received.join(", ")));
    complaints.push(problem.with_label("this event").with_help(help));
}

/// The effects and notes of a machine while it moves.
struct Watch<'w> {
    violated_in: &'w [StateId],
    violated: bool,
    messages: Vec<String>,
}

impl Host for Watch<'_> {
    fn send(&mut self, _: &Outgoing) -> Result<(), Undelivered> {
        Err(Undelivered::Unfit("a monitor does not send messages".to_owned()))
    }

    fn note(&mut self, note: Note) {
        match note {
            Note::Error { event, reason, .. } => self.messages.push(format!("{event}: {reason}")),
            Note::Stuck { microsteps } => {
                self.messages.push(format!("it did not come to rest in {microsteps} microsteps"))
            }
            _ => {}
        }
    }

    fn entered(&mut self, machine: &Machine) {
        self.violated |= machine.configuration().any(|state| self.violated_in.contains(&state));
    }
}

impl Picture {
    fn new(name: &str, chart: &Chart, violated_in: &[StateId]) -> Self {
        // A machine with parallel states is in several states at once, but a graph is in one location: it is the region
        // that contains the violation.
        let around = |state: StateId| std::iter::successors(Some(state), |state| chart.state(*state).parent());
        let is_region = |state: &StateId| {
            chart.state(*state).parent().is_none_or(|parent| chart.state(parent).kind() == StateKind::Parallel)
        };
        let region = violated_in.first().and_then(|state| around(*state).find(is_region)).unwrap_or(chart.root());
        let is_drawn =
            |state: &StateId| chart.state(*state).children().is_empty() && around(*state).any(|a| a == region);
        let is_history = |state: StateId| matches!(chart.state(state).kind(), StateKind::History(_));
        let drawn = chart.states().filter(|state| is_drawn(state) && !is_history(*state));
        let mut graph = ProgramGraph::builder(name);
        let states: Vec<(StateId, LocationId)> =
            drawn.map(|state| (state, graph.location(chart.state(state).id()))).collect();
        let location = |state: StateId| states.iter().find(|drawn| drawn.0 == state).map(|drawn| drawn.1);
        for (state, from) in &states {
            let leaving = around(*state).flat_map(|around| chart.state(around).transitions());
            for transition in leaving.map(|transition| chart.transition(*transition)) {
                let to = transition.targets().iter().find_map(|target| location(first_entered(chart, *target)));
                let Some(to) = to else { continue };
                let condition = transition.condition().map(str::to_owned);
                let caption: Vec<String> = transition.events().map(str::to_owned).chain(condition).collect();
                let caption = if caption.is_empty() { "else".to_owned() } else { caption.join(" ") };
                graph.internal(*from, Condition::True, [], to).caption = caption;
            }
        }
        let is_failure = |state: StateId| around(state).any(|around| violated_in.contains(&around));
        let failures = states.iter().filter(|(state, _)| is_failure(*state)).map(|(_, location)| *location).collect();
        let initial = location(first_entered(chart, region)).unwrap_or(states[0].1);
        let graph = graph.initial(initial).build().expect("a graph with an initial location");
        Self { graph, states, failures }
    }
}

/// The atomic state that is entered by default with a state.
fn first_entered(chart: &Chart, state: StateId) -> StateId {
    let inside = chart.state(state).initial().first().or_else(|| chart.state(state).children().first());
    inside.map_or(state, |inside| first_entered(chart, *inside))
}
