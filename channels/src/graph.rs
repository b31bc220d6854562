//! Program graphs, PG = (Loc, Act, Effect, ↪, Loc₀, g₀).

use std::sync::Arc;
use std::time::Duration;

use crate::condition::{Assignment, Condition, Content, Evaluation, Term, VariableId};
use crate::{
    Action, ChannelId, Envelope, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, Shared, Topology,
    TransitionId, Use, WiringError,
};

/// A location of a program graph, as an index into the graph's locations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LocationId(pub(crate) usize);

impl LocationId {
    /// Position among the graph's locations, in the order they were declared.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }

    /// What is wrong with the location in a graph with this many locations.
    fn problem(self, locations: usize) -> Option<String> {
        (self.0 >= locations).then(|| format!("uses location {} of another graph: it has only {locations}", self.0))
    }
}

/// ⊙: what a communication action sends or receives.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Slot {
    /// The message in a variable, or the variable to which a message is assigned.
    Variable(VariableId),
    /// A given message: `<m>`.
    Given(Message),
}

impl From<VariableId> for Slot {
    fn from(variable: VariableId) -> Self {
        Self::Variable(variable)
    }
}

impl From<Message> for Slot {
    fn from(message: Message) -> Self {
        Self::Given(message)
    }
}

/// The action of a graph's transition: an element of Act ∪ Comm.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Label {
    /// An internal action with its effect: the assignments, made one after the other.
    Internal(Vec<Assignment>),
    /// `!(p, q, ⊙)`
    Send(ChannelId, Slot),
    /// `?(q, p, ⊙)`
    Receive(ChannelId, Slot),
    /// A tick is generated, whether or not a process takes it: `[<tick>, n]` is assigned to the variable. Only monitors
    /// take such transitions; they are never offered to processes.
    Tick(VariableId),
}

/// A conditional transition ℓ ↪ ℓ′.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct GraphTransition {
    /// ℓ
    pub from: LocationId,
    /// g
    pub guard: Condition,
    /// α
    pub label: Label,
    /// ℓ′
    pub to: LocationId,
    /// The meaning of the transition in words, for diagrams. If empty, diagrams show its guard and label.
    pub caption: String,
}

/// A program graph: an extended finite state machine, as data that can be run, drawn and exported.
///
/// ```
/// use channels::{Capacity, Condition, Domain, FieldKind, ProgramGraph, Relation, Shape, Topology};
///
/// let mut topology = Topology::default();
/// let [reader, skill] = [topology.process("BatteryReader")?, topology.process("BatteryLevel")?];
/// let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
/// let replies = topology.channel(reader, skill, Capacity::One, Domain::new([level]))?;
///
/// let mut graph = ProgramGraph::builder("phi1");
/// let [idle, get, failure] = ["idle", "get", "failure"].map(|name| graph.location(name));
/// let m = graph.variable("m");
/// graph.receive(idle, replies, m, get);
/// graph.internal(get, m.field(2).compare(Relation::GreaterOrEqual, 20), [], idle);
/// graph.internal(get, m.field(2).compare(Relation::Less, 20), [], failure);
/// let graph = graph.initial(idle).build()?;
/// assert_eq!(graph.locations().len(), 3);
/// # Ok::<(), channels::WiringError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramGraph {
    name: String,
    locations: Vec<String>,
    variables: Vec<String>,
    initial_evaluation: Evaluation,
    transitions: Vec<GraphTransition>,
    initial_locations: Vec<LocationId>,
    initial_condition: Condition,
    /// For each location, the range of its transitions in `transitions`, which is sorted by location.
    outgoing: Vec<std::ops::Range<usize>>,
}

impl ProgramGraph {
    /// Starts a graph with this name.
    #[must_use]
    pub fn builder(name: &str) -> GraphBuilder {
        GraphBuilder {
            name: name.to_owned(),
            locations: Vec::new(),
            variables: Vec::new(),
            contents: Vec::new(),
            transitions: Vec::new(),
            initial: Vec::new(),
            initial_condition: Condition::True,
        }
    }

    /// The graph's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Loc: the names of the locations, in the order they were declared.
    #[must_use]
    pub fn locations(&self) -> &[String] {
        &self.locations
    }

    /// Var: the names of the variables, in the order they were declared.
    #[must_use]
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// The initial values of the variables, in the same order.
    #[must_use]
    pub fn initial_contents(&self) -> &[Content] {
        self.initial_evaluation.contents()
    }

    /// ↪: the transitions, ordered by the location they leave and then as they were declared.
    #[must_use]
    pub fn transitions(&self) -> &[GraphTransition] {
        &self.transitions
    }

    /// Loc₀: where the graph may start.
    #[must_use]
    pub fn initial_locations(&self) -> &[LocationId] {
        &self.initial_locations
    }

    /// g₀: the condition on the variables at the start.
    #[must_use]
    pub fn initial_condition(&self) -> &Condition {
        &self.initial_condition
    }

    /// The meaning of a transition in words, for diagrams: its caption, or else its guard and label.
    #[must_use]
    pub fn caption(&self, transition: &GraphTransition, topology: &Topology) -> String {
        if !transition.caption.is_empty() {
            return transition.caption.clone();
        }
        let slot = |slot: &Slot| match slot {
            Slot::Variable(variable) => self.variables[variable.0].clone(),
            Slot::Given(message) => message.to_string(),
        };
        let label = match &transition.label {
            Label::Internal(effect) => {
                let effect: Vec<String> = effect.iter().map(|change| change.describe(&self.variables)).collect();
                effect.join(", ")
            }
            Label::Send(channel, sent) => format!("!({}, {})", topology.describe(*channel), slot(sent)),
            Label::Receive(channel, taken) => format!("?({}, {})", topology.describe(*channel), slot(taken)),
            Label::Tick(_) => "tick".to_owned(),
        };
        match (&transition.guard, label.as_str()) {
            (Condition::True, _) => label,
            (guard, "") => guard.describe(&self.variables),
            (guard, _) => format!("{}: {label}", guard.describe(&self.variables)),
        }
    }

    /// The transitions that leave a location, with their numbers.
    fn leaving(&self, location: LocationId) -> impl Iterator<Item = (TransitionId, &GraphTransition)> {
        let range = self.outgoing[location.0].clone();
        range.map(|index| (TransitionId(index as u32), &self.transitions[index]))
    }
}

/// Builds a [`ProgramGraph`].
#[derive(Clone, Debug)]
pub struct GraphBuilder {
    name: String,
    locations: Vec<String>,
    variables: Vec<String>,
    contents: Vec<Content>,
    transitions: Vec<GraphTransition>,
    initial: Vec<LocationId>,
    initial_condition: Condition,
}

impl GraphBuilder {
    /// Declares a location.
    pub fn location(&mut self, name: &str) -> LocationId {
        self.locations.push(name.to_owned());
        LocationId(self.locations.len() - 1)
    }

    /// Declares a variable that holds nothing at the start.
    pub fn variable(&mut self, name: &str) -> VariableId {
        self.variable_with(name, Content::Nothing)
    }

    /// Declares a variable with its content at the start.
    pub fn variable_with(&mut self, name: &str, content: Content) -> VariableId {
        self.variables.push(name.to_owned());
        self.contents.push(content);
        VariableId(self.variables.len() - 1)
    }

    /// Adds a transition and returns it, so that a guard or a caption can be set.
    pub fn transition(&mut self, from: LocationId, label: Label, to: LocationId) -> &mut GraphTransition {
        self.transitions.push(GraphTransition { from, guard: Condition::True, label, to, caption: String::new() });
        self.transitions.last_mut().expect("a transition was just added")
    }

    /// Adds the transition `?(q, p, ⊙)` without a guard.
    pub fn receive(
        &mut self,
        from: LocationId,
        channel: ChannelId,
        slot: impl Into<Slot>,
        to: LocationId,
    ) -> &mut GraphTransition {
        self.transition(from, Label::Receive(channel, slot.into()), to)
    }

    /// Adds the transition `!(p, q, ⊙)` without a guard.
    pub fn send(
        &mut self,
        from: LocationId,
        channel: ChannelId,
        slot: impl Into<Slot>,
        to: LocationId,
    ) -> &mut GraphTransition {
        self.transition(from, Label::Send(channel, slot.into()), to)
    }

    /// Adds an internal transition with a guard and an effect.
    pub fn internal<const N: usize>(
        &mut self,
        from: LocationId,
        guard: Condition,
        effect: [(VariableId, Term); N],
        to: LocationId,
    ) -> &mut GraphTransition {
        let effect = effect.map(|(variable, term)| Assignment { variable, term }).to_vec();
        let transition = self.transition(from, Label::Internal(effect), to);
        transition.guard = guard;
        transition
    }

    /// Adds a location to Loc₀.
    #[must_use]
    pub fn initial(mut self, location: LocationId) -> Self {
        self.initial.push(location);
        self
    }

    /// Sets g₀, which the initial values of the variables must satisfy.
    #[must_use]
    pub fn initial_condition(mut self, condition: Condition) -> Self {
        self.initial_condition = condition;
        self
    }

    /// Builds the graph.
    ///
    /// A location or variable of another builder is recognized by its number: one that this graph also has is taken for
    /// the one with that number here.
    ///
    /// # Errors
    /// [`WiringError::Graph`] if a location or a variable was not declared here, if a term reads field 0, if there is
    /// no initial location, or if the variables do not satisfy g₀ at the start.
    pub fn build(mut self) -> Result<ProgramGraph, WiringError> {
        let problem = |problem: &str| WiringError::Graph { graph: self.name.clone(), problem: problem.to_owned() };
        if let Some(found) = self.problem() {
            return Err(problem(&found));
        }
        if self.initial.is_empty() {
            return Err(problem("has no initial location"));
        }
        let evaluation = Evaluation::new(self.contents);
        if !self.initial_condition.holds(&evaluation) {
            return Err(problem("starts with variables that do not satisfy its initial condition"));
        }
        // The transitions of a location become one range. The sort is stable: they keep the order in which they were
        // added, which is the order of the process's offers.
        self.transitions.sort_by_key(|transition| transition.from);
        let outgoing = (0..self.locations.len())
            .map(|location| {
                let start = self.transitions.partition_point(|transition| transition.from.0 < location);
                start..self.transitions.partition_point(|transition| transition.from.0 <= location)
            })
            .collect();
        Ok(ProgramGraph {
            name: self.name,
            locations: self.locations,
            variables: self.variables,
            initial_evaluation: evaluation,
            transitions: self.transitions,
            initial_locations: self.initial,
            initial_condition: self.initial_condition,
            outgoing,
        })
    }

    /// What is wrong with the parts that the graph is made of: they would panic, or never hold, only when it runs.
    fn problem(&self) -> Option<String> {
        let (locations, variables) = (self.locations.len(), self.variables.len());
        let of_slot = |slot: &Slot| match slot {
            Slot::Variable(variable) => variable.problem(variables),
            Slot::Given(_) => None,
        };
        let of_label = |label: &Label| match label {
            Label::Internal(effect) => effect.iter().find_map(|Assignment { variable, term }| {
                variable.problem(variables).or_else(|| term.problem(variables))
            }),
            Label::Send(_, slot) | Label::Receive(_, slot) => of_slot(slot),
            Label::Tick(variable) => variable.problem(variables),
        };
        let of_transition = |GraphTransition { from, guard, label, to, .. }: &GraphTransition| {
            let ends = from.problem(locations).or_else(|| to.problem(locations));
            ends.or_else(|| guard.problem(variables)).or_else(|| of_label(label))
        };
        let starts = || self.initial.iter().find_map(|location| location.problem(locations));
        let transitions = self.transitions.iter().find_map(of_transition);
        transitions.or_else(starts).or_else(|| self.initial_condition.problem(variables))
    }
}

/// A running program graph: its location and the values of its variables.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct GraphProcess {
    location: LocationId,
    evaluation: Evaluation,
    graph: Shared<ProgramGraph>,
}

impl GraphProcess {
    /// The graph at its first initial location.
    #[must_use]
    pub fn new(graph: Arc<ProgramGraph>) -> Self {
        let location = graph.initial_locations[0];
        Self { evaluation: graph.initial_evaluation.clone(), location, graph: graph.into() }
    }

    /// One process per initial location of the graph.
    pub fn starts(graph: &Arc<ProgramGraph>) -> impl Iterator<Item = Self> {
        graph.initial_locations.iter().map(|&location| Self { location, ..Self::new(Arc::clone(graph)) })
    }

    /// The graph.
    #[must_use]
    pub fn graph(&self) -> &Arc<ProgramGraph> {
        &self.graph
    }

    /// The current location.
    #[must_use]
    pub fn location_id(&self) -> LocationId {
        self.location
    }

    /// The first transition that can receive the message from the channel.
    pub(crate) fn receiving(&self, channel: ChannelId, message: &Message) -> Option<TransitionId> {
        self.ready().find_map(|(id, transition)| match &transition.label {
            Label::Receive(on, Slot::Variable(_)) if *on == channel => Some(id),
            Label::Receive(on, Slot::Given(given)) if *on == channel && given == message => Some(id),
            _ => None,
        })
    }

    /// The first transition that observes a generated tick.
    pub(crate) fn ticking(&self) -> Option<TransitionId> {
        self.ready().find_map(|(id, transition)| matches!(transition.label, Label::Tick(_)).then_some(id))
    }

    /// The first internal transition whose guard holds.
    pub(crate) fn internal(&self) -> Option<TransitionId> {
        self.ready().find_map(|(id, transition)| matches!(transition.label, Label::Internal(_)).then_some(id))
    }

    /// Takes a transition whose guard holds.
    pub(crate) fn follow(&mut self, transition: TransitionId, received: Option<&Message>) {
        let graph = Shared::clone(&self.graph);
        let transition = &graph.transitions[transition.0 as usize];
        match (&transition.label, received) {
            (Label::Internal(effect), _) => {
                for Assignment { variable, term } in effect {
                    let content = term.evaluate(&self.evaluation);
                    self.evaluation.set(*variable, content);
                }
            }
            (Label::Receive(_, Slot::Variable(variable)) | Label::Tick(variable), Some(message)) => {
                self.evaluation.set(*variable, Content::Message(message.clone()));
            }
            _ => {}
        }
        self.location = transition.to;
    }

    /// The transitions from here whose guards hold.
    fn ready(&self) -> impl Iterator<Item = (TransitionId, &GraphTransition)> {
        self.graph.leaving(self.location).filter(|(_, transition)| transition.guard.holds(&self.evaluation))
    }

    /// The action that a transition offers; `None` if a variable to be sent holds no message.
    fn action(&self, transition: &GraphTransition) -> Option<Action> {
        Some(match &transition.label {
            Label::Internal(_) => Action::Internal,
            Label::Send(channel, Slot::Given(message)) => Action::Send(*channel, message.clone().into()),
            Label::Send(channel, Slot::Variable(variable)) => match self.evaluation.get(*variable) {
                Content::Message(message) => Action::Send(*channel, message.clone().into()),
                _ => return None,
            },
            Label::Receive(channel, Slot::Variable(_)) => Action::Receive(*channel, Pattern::Any),
            Label::Receive(channel, Slot::Given(message)) => {
                Action::Receive(*channel, Pattern::Exactly(message.clone()))
            }
            Label::Tick(_) => return None,
        })
    }
}

impl Process for GraphProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        offers.extend(
            self.ready()
                .filter_map(|(id, transition)| self.action(transition).map(|action| Offer { transition: id, action })),
        );
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        self.follow(transition, received.as_ref().map(|envelope| &envelope.message));
    }

    fn uses(&self) -> Vec<Use> {
        let given = |slot: &Slot| match slot {
            Slot::Given(message) => Some(message.clone()),
            Slot::Variable(_) => None,
        };
        let uses = self.graph.transitions.iter().filter_map(|transition| match &transition.label {
            Label::Internal(_) | Label::Tick(_) => None,
            Label::Send(channel, slot) => Some(Use::Sends(*channel, given(slot))),
            Label::Receive(channel, slot) => Some(Use::Receives(*channel, given(slot))),
        });
        uses.collect()
    }

    fn normalize(&mut self, _form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        Ok(())
    }

    fn location(&self) -> String {
        self.graph.locations[self.location.0].clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Relation;

    /// The result of `build` for a graph with two locations and one variable, to which `change` adds something.
    fn refusal(change: impl FnOnce(&mut GraphBuilder, LocationId, VariableId)) -> Option<String> {
        let mut graph = ProgramGraph::builder("door");
        let [open, _shut] = ["open", "shut"].map(|name| graph.location(name));
        let level = graph.variable("level");
        change(&mut graph, open, level);
        graph.initial(open).build().err().map(|error| error.to_string())
    }

    #[test]
    fn a_graph_with_locations_variables_or_fields_that_it_does_not_have_is_refused() {
        let mut other = ProgramGraph::builder("other");
        let far = ["a", "b", "c"].map(|name| other.location(name))[2];
        let [_, foreign] = ["x", "y"].map(|name| other.variable(name));
        assert_eq!(refusal(|_, _, _| ()), None);
        let location = Some("the program graph door uses location 2 of another graph: it has only 2".to_owned());
        assert_eq!(refusal(|graph, open, _| _ = graph.internal(open, Condition::True, [], far)), location);
        assert_eq!(refusal(|graph, open, _| _ = graph.internal(far, Condition::True, [], open)), location);
        assert_eq!(refusal(|graph, _, _| graph.initial.push(far)), location);
        let variable = Some("the program graph door uses variable 1 of another graph: it has only 1".to_owned());
        let guard = |term: Term| term.compare(Relation::Less, 20).negated().and(Condition::True);
        assert_eq!(refusal(|graph, open, _| _ = graph.internal(open, guard(foreign.field(1)), [], open)), variable);
        assert_eq!(refusal(|graph, open, _| _ = graph.transition(open, Label::Tick(foreign), open)), variable);
        let changes = [(true, false), (false, true)].map(|(is_changed, is_read)| {
            refusal(|graph, open, level| {
                let pick = |is_foreign: bool| if is_foreign { foreign } else { level };
                let term = Term::Sum(Box::new(1.into()), Box::new(pick(is_read).term()));
                graph.internal(open, Condition::True, [(pick(is_changed), term)], open);
            })
        });
        assert_eq!(changes, [variable.clone(), variable.clone()]);
        assert_eq!(refusal(|graph, _, _| graph.initial_condition = guard(foreign.term())), variable);
        let field =
            Some("the program graph door reads field 0 of a message, whose fields are counted from 1".to_owned());
        assert_eq!(refusal(|graph, open, level| _ = graph.internal(open, guard(level.field(0)), [], open)), field);
    }
}
