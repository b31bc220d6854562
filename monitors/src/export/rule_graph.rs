//! Rules as a program graph, in the shape of the paper's figure for safety and response.

use std::sync::Arc;

use channels::{
    ChannelId, Condition, Content, GraphBuilder, Label, LocationId, Message, ProgramGraph, Relation, Term, Topology,
    Value, VariableId,
};

use crate::clause::{EventId, Literal, Vocabulary, trigger};
use crate::describe;
use crate::engine::{Compact, Rule, Timing};
use crate::export::picture::{Picture, any, channel_name, translate};

/// A graph under construction.
pub(super) struct Draft<'a> {
    graph: GraphBuilder,
    words: &'a Vocabulary,
    topology: &'a Topology,
    /// For each channel that the formula mentions, the variable that holds its last message.
    variables: Vec<(ChannelId, VariableId)>,
    /// Whether the transitions that leave `C1` exist.
    check_is_drawn: bool,
}

impl<'a> Draft<'a> {
    pub(super) fn new(name: &str, words: &'a Vocabulary, topology: &'a Topology) -> Self {
        let mut graph = ProgramGraph::builder(name);
        let channels = words.channels();
        let variable = |channel: &ChannelId| {
            let name = if channels.len() == 1 { "m".to_owned() } else { format!("from{}", topology.ends(*channel).0) };
            (*channel, name)
        };
        let names: Vec<(ChannelId, String)> = channels.iter().map(variable).collect();
        let variables = names.iter().map(|(channel, name)| {
            let same = names.iter().filter(|(_, other)| other == name).count() > 1;
            let full = if same { format!("{name}To{}", topology.ends(*channel).1) } else { name.clone() };
            (*channel, graph.variable(&full))
        });
        let variables = variables.collect();
        Self { graph, words, topology, variables, check_is_drawn: false }
    }

    fn channel_name(&self, channel: ChannelId) -> String {
        channel_name(channel, self.words, self.topology)
    }

    fn variable(&self, channel: ChannelId) -> VariableId {
        let found = self.variables.iter().find(|(known, _)| *known == channel);
        found.expect("every channel of the formula has a variable").1
    }

    /// `idle`, a `get` for each channel, and `failure`.
    pub(super) fn safety(mut self, compact: &Compact) -> Option<Picture> {
        let idle = self.graph.location("idle");
        let channels = channels_of(&compact.rules, self.words);
        let name = |channel: &ChannelId| match channels.len() {
            1 => "get".to_owned(),
            _ => format!("get {}", self.channel_name(*channel)),
        };
        let names: Vec<String> = channels.iter().map(name).collect();
        let gets: Vec<LocationId> = names.iter().map(|name| self.graph.location(name)).collect();
        let failure = self.graph.location("failure");
        for (channel, get) in channels.into_iter().zip(gets) {
            let variable = self.variable(channel);
            self.graph.receive(idle, channel, variable, get).caption = self.topology.describe(channel);
            let asked: Vec<&Rule> = compact
                .rules
                .iter()
                .filter(|rule| trigger(&rule.clause, self.words).channels.contains(&channel))
                .collect();
            // One check for all rules of the channel: the paper's φ1 is the case of a single rule.
            let kept = all(asked.iter().map(|rule| self.kept(rule)).collect());
            let list = |captions: Vec<String>, word: &str| captions.join(word);
            let holds = asked.iter().map(|rule| describe::brief_clause(&rule.clause, self.words)).collect();
            let fails = asked.iter().map(|rule| describe::brief_antecedent(&rule.clause, self.words)).collect();
            self.graph.internal(get, kept.clone(), [], idle).caption = list(holds, " and ");
            self.graph.internal(get, kept.negated(), [], failure).caption = list(fails, " or ");
        }
        let graph = self.graph.initial(idle).build().ok()?;
        let graph = Arc::new(graph);
        let (states, owing) = (Vec::new(), Vec::new());
        Some(Picture { graph, rest: idle, waiting: None, states, owing, failures: vec![failure] })
    }

    /// Response: `I`; a check of the antecedent, `C1`; `S`, where the clock starts; `C2`, where it runs; a check of the
    /// answer, `A`; `T`, at a tick; and `Err`.
    ///
    /// A ban has the same shape: the forbidden event leads to `Err`, and the end of the time back to `I`.
    pub(super) fn timed(mut self, rule: &Rule) -> Option<Picture> {
        let (events, ticks, answered) = match rule.timing {
            Timing::Within { answers, ticks } => (answers, ticks, true),
            Timing::Without { bans, ticks } => (bans, ticks, false),
            Timing::Never => return None,
        };
        let places = Places::new(&mut self.graph, answered);
        let own = trigger(&rule.clause, self.words).channels;
        self.clock(&places, i64::try_from(ticks).unwrap_or(i64::MAX), own.is_empty());
        let passing = self.channels_of(events);
        for channel in &own {
            self.antecedent(rule, *channel, passing.contains(channel).then_some(events), &places);
            if !passing.contains(channel) {
                self.while_waiting(rule, *channel, &places);
            }
        }
        for channel in &passing {
            self.answer(rule, (*channel, events), own.contains(channel), &places, passing.len() == 1);
        }
        let Places { rest, waiting, failure, .. } = places;
        let graph = self.graph.initial(rest).build().ok()?;
        let owing = if answered { vec![waiting] } else { Vec::new() };
        let (graph, failures) = (Arc::new(graph), vec![failure]);
        Some(Picture { graph, rest, waiting: Some(waiting), states: Vec::new(), owing, failures })
    }

    /// Ticks: the clock starts in `S`, and `T` compares it with the bound.
    fn clock(&mut self, places: &Places, bound: i64, asked_at_ticks: bool) {
        let start = Message::new([Value::symbol("tick"), Value::Int(0)]);
        let tick = self.graph.variable_with("tick", Content::Message(start));
        let since = self.graph.variable_with("since", Content::Value(Value::Int(0)));
        let &Places { rest, start, waiting, ticked, failure, answered, .. } = places;
        self.graph.transition(rest, Label::Tick(tick), if asked_at_ticks { start } else { rest }).caption =
            "tick".to_owned();
        self.graph.internal(start, Condition::True, [(since, tick.field(2))], waiting).caption =
            "since := tick".to_owned();
        if asked_at_ticks && !answered {
            self.graph.transition(waiting, Label::Tick(tick), start).caption = "tick".to_owned();
            return;
        }
        self.graph.transition(waiting, Label::Tick(tick), ticked).caption = "tick".to_owned();
        let elapsed = Term::Difference(Box::new(tick.field(2)), Box::new(since.term()));
        let late = if answered { failure } else { rest };
        let in_time = elapsed.clone().compare(Relation::Less, bound);
        self.graph.internal(ticked, in_time, [], waiting).caption = format!("tick − since < {bound}");
        let too_late = elapsed.compare(Relation::GreaterOrEqual, bound);
        self.graph.internal(ticked, too_late, [], late).caption = format!("tick − since ≥ {bound}");
    }

    /// At rest, a message on one of the clause's own channels: does the antecedent hold now? The message may itself be
    /// the answer, according to `events`.
    fn antecedent(&mut self, rule: &Rule, channel: ChannelId, events: Option<u64>, places: &Places) {
        let caption = describe::brief_antecedent(&rule.clause, self.words);
        let check = match events {
            Some(_) => self.graph.location(&format!("C1 {}", self.channel_name(channel))),
            None => places.check,
        };
        let variable = self.variable(channel);
        self.graph.receive(places.rest, channel, variable, check).caption = self.topology.describe(channel);
        if events.is_none() && std::mem::replace(&mut self.check_is_drawn, true) {
            return;
        }
        let kept = self.kept(rule);
        if let Some(events) = events {
            let passed = self.passed(events, channel);
            let to = if places.answered { places.rest } else { places.failure };
            let at_once = kept.clone().negated().and(passed);
            self.graph.internal(check, at_once, [], to).caption = format!("{caption}, and {}", self.short(events));
        }
        self.graph.internal(check, kept.clone(), [], places.rest).caption = format!("not ({caption})");
        self.graph.internal(check, kept.negated(), [], places.start).caption = caption;
    }

    /// While the clock runs: a message of the antecedent is remembered. With a ban, it may restart the clock.
    fn while_waiting(&mut self, rule: &Rule, channel: ChannelId, places: &Places) {
        let variable = self.variable(channel);
        let name = self.topology.describe(channel);
        if places.answered {
            self.graph.receive(places.waiting, channel, variable, places.waiting).caption = name;
            return;
        }
        let again = self.graph.location(&format!("K {}", self.channel_name(channel)));
        self.graph.receive(places.waiting, channel, variable, again).caption = name;
        let (kept, caption) = (self.kept(rule), describe::brief_antecedent(&rule.clause, self.words));
        self.graph.internal(again, kept.clone(), [], places.waiting).caption = format!("not ({caption})");
        self.graph.internal(again, kept.negated(), [], places.start).caption = caption;
    }

    /// While the clock runs: a message on a channel that may bring the answer or the forbidden event.
    fn answer(&mut self, rule: &Rule, (channel, events): (ChannelId, u64), own: bool, places: &Places, alone: bool) {
        let variable = self.variable(channel);
        let check =
            if alone { places.reply } else { self.graph.location(&format!("A {}", self.channel_name(channel))) };
        self.graph.receive(places.waiting, channel, variable, check).caption = self.topology.describe(channel);
        let (passed, caption) = (self.passed(events, channel), self.short(events));
        let to = if places.answered { places.rest } else { places.failure };
        self.graph.internal(check, passed.clone(), [], to).caption.clone_from(&caption);
        if own && !places.answered {
            let kept = self.kept(rule);
            self.graph.internal(check, kept.negated(), [], places.start).caption =
                describe::brief_antecedent(&rule.clause, self.words);
        }
        self.graph.internal(check, passed.negated(), [], places.waiting).caption = format!("not ({caption})");
    }

    /// The condition that one of a rule's literals holds.
    fn kept(&self, rule: &Rule) -> Condition {
        let spoken = trigger(&rule.clause, self.words).channels.len() == 1;
        let literals = rule.clause.iter().filter_map(|literal| match literal {
            Literal::Event { event, holds } => {
                let condition = self.event(*event, spoken);
                Some(if *holds { condition } else { condition.negated() })
            }
            _ => None,
        });
        any(literals.collect())
    }

    fn passed(&self, events: u64, channel: ChannelId) -> Condition {
        let on_channel = bits(self.words, events).filter(|event| self.words.get(*event).channel == channel);
        any(on_channel.map(|event| self.event(event, true)).collect())
    }

    /// An event atom over the variable of its channel: false while the variable is empty, unless the channel has just
    /// carried a message.
    fn event(&self, event: EventId, spoken: bool) -> Condition {
        let event = self.words.get(event);
        let variable = self.variable(event.channel);
        let condition = translate(&event.condition, variable);
        // Only a message equals itself: an empty variable does not.
        let is_there = || variable.term().compare(Relation::Equal, variable.term());
        if !spoken && event.condition.holds(&Message::new([])) { is_there().and(condition) } else { condition }
    }

    fn channels_of(&self, events: u64) -> Vec<ChannelId> {
        let mut channels: Vec<ChannelId> =
            bits(self.words, events).map(|event| self.words.get(event).channel).collect();
        channels.dedup();
        channels
    }

    fn short(&self, events: u64) -> String {
        let texts: Vec<String> =
            bits(self.words, events).map(|event| describe::brief(&self.words.get(event).condition)).collect();
        texts.join(" or ")
    }
}

/// The locations of a monitor with a clock.
struct Places {
    rest: LocationId,
    check: LocationId,
    start: LocationId,
    waiting: LocationId,
    reply: LocationId,
    ticked: LocationId,
    failure: LocationId,
    /// Whether the awaited events answer, or are forbidden.
    answered: bool,
}

impl Places {
    fn new(graph: &mut GraphBuilder, answered: bool) -> Self {
        let [rest, check, start, waiting, reply, ticked, failure] =
            ["I", "C1", "S", "C2", "A", "T", "Err"].map(|name| graph.location(name));
        Self { rest, check, start, waiting, reply, ticked, failure, answered }
    }
}

/// The events of a set.
fn bits(words: &Vocabulary, events: u64) -> impl Iterator<Item = EventId> + use<> {
    words.ids().filter(move |event| events >> event.0 & 1 == 1)
}

fn channels_of(rules: &[Rule], words: &Vocabulary) -> Vec<ChannelId> {
    let mut channels: Vec<ChannelId> = rules.iter().flat_map(|rule| trigger(&rule.clause, words).channels).collect();
    channels.sort_unstable();
    channels.dedup();
    channels
}

fn all(mut conditions: Vec<Condition>) -> Condition {
    if conditions.len() == 1 { conditions.remove(0) } else { Condition::And(conditions) }
}
