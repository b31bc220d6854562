//! An automaton as a program graph: one location for each state with an open verdict, and one for each verdict.

use std::collections::BTreeMap;
use std::sync::Arc;

use channels::{
    ChannelId, Condition, Content, GraphBuilder, Label, LocationId, Message, ProgramGraph, Relation, Topology, Value,
    VariableId, Verdict,
};

use crate::clause::{EventId, Vocabulary};
use crate::describe;
use crate::engine::{Alphabet, Automaton, Letter, Symbol};
use crate::export::picture::{Picture, any, channel_name, translate};

/// The graph of an automaton with at most `limit` open states.
///
/// A tick with number 0 is treated as the first of the run, any other as one that follows another tick. The graph is
/// correct on runs whose ticks are numbered from 0 without gaps.
pub(super) fn picture(
    name: &str,
    automaton: &Automaton,
    (words, alphabet): (&Vocabulary, &Alphabet),
    topology: &Topology,
    limit: usize,
) -> Option<Picture> {
    let open = (0..automaton.len()).filter(|state| automaton.verdict(*state) == Verdict::Inconclusive).count();
    if open == 0 || open > limit {
        return None;
    }
    let mut graph = ProgramGraph::builder(name);
    let [satisfied, violated] = [Verdict::True, Verdict::False].map(|verdict| {
        let name = if verdict == Verdict::True { "satisfied" } else { "violated" };
        (0..automaton.len()).any(|state| automaton.verdict(state) == verdict).then(|| graph.location(name))
    });
    // All states with the same verdict are one location: nothing changes it any more.
    let places = (0..automaton.len()).map(|state| match automaton.verdict(state) {
        Verdict::True => satisfied,
        Verdict::False => violated,
        Verdict::Inconclusive => None,
    });
    let mut number = 0..;
    let places: Vec<LocationId> = places
        .map(|settled| settled.unwrap_or_else(|| graph.location(&format!("q{}", number.next().unwrap_or(0)))))
        .collect();
    let mut draft = Draft { graph, automaton, words, alphabet, topology, places, variables: Vec::new() };
    draft.draw();
    let Draft { graph, places, .. } = draft;
    let owing = (0..automaton.len())
        .filter(|state| automaton.verdict(*state) == Verdict::Inconclusive && !automaton.holds(*state))
        .map(|state| places[state])
        .collect();
    let graph = Arc::new(graph.initial(places[0]).build().ok()?);
    let failures = violated.into_iter().collect();
    Some(Picture { graph, rest: places[0], waiting: None, states: places, owing, failures })
}

struct Draft<'a> {
    graph: GraphBuilder,
    automaton: &'a Automaton,
    words: &'a Vocabulary,
    alphabet: &'a Alphabet,
    topology: &'a Topology,
    /// The location of each state.
    places: Vec<LocationId>,
    variables: Vec<(ChannelId, VariableId)>,
}

impl Draft<'_> {
    fn draw(&mut self) {
        let start = Message::new([Value::symbol("tick"), Value::Int(0)]);
        let tick = self.graph.variable_with("tick", Content::Message(start));
        for channel in self.words.channels() {
            let (source, target) = self.topology.ends(channel);
            let variable = self.graph.variable(&format!("from{source}To{target}"));
            self.variables.push((channel, variable));
        }
        for state in (0..self.automaton.len()).filter(|state| self.automaton.verdict(*state) == Verdict::Inconclusive) {
            self.tick(state, tick);
            for (channel, variable) in self.variables.clone() {
                self.channel(state, channel, variable);
            }
        }
    }

    fn target(&self, state: usize, symbol: Symbol) -> Option<LocationId> {
        self.automaton.successor(state, symbol).map(|next| self.places[next])
    }

    fn tick(&mut self, state: usize, tick: VariableId) {
        let from = self.places[state];
        let (Some(first), Some(next)) = (self.target(state, Symbol::TICK), self.target(state, Symbol::NEXT_TICK))
        else {
            return;
        };
        if first == next {
            self.graph.transition(from, Label::Tick(tick), next).caption = "tick".to_owned();
            return;
        }
        let check = self.graph.location(&format!("t{state}"));
        self.graph.transition(from, Label::Tick(tick), check).caption = "tick".to_owned();
        let is_first = tick.field(2).compare(Relation::Equal, 0);
        self.graph.internal(check, is_first.clone(), [], first).caption = "the first".to_owned();
        self.graph.internal(check, is_first.negated(), [], next).caption = "a later one".to_owned();
    }

    /// The transitions for messages on a channel, one for each target location.
    fn channel(&mut self, state: usize, channel: ChannelId, variable: VariableId) {
        let from = self.places[state];
        let mut targets: BTreeMap<LocationId, Vec<Letter>> = BTreeMap::new();
        for (letter, ..) in self.alphabet.letters().filter(|(_, on, _)| *on == channel) {
            if let Some(to) = self.target(state, self.alphabet.symbol(letter)) {
                targets.entry(to).or_default().push(letter);
            }
        }
        let name = self.topology.describe(channel);
        // The default target is the one that most letters lead to.
        let Some(other) = targets.iter().max_by_key(|(_, letters)| letters.len()).map(|(to, _)| *to) else { return };
        if targets.len() == 1 {
            if other != from {
                self.graph.receive(from, channel, variable, other).caption = name;
            }
            return;
        }
        let check = self.graph.location(&format!("c{state} {}", channel_name(channel, self.words, self.topology)));
        self.graph.receive(from, channel, variable, check).caption = name;
        let mut elsewhere = Vec::new();
        for (to, letters) in targets.into_iter().filter(|(to, _)| *to != other) {
            let guards: Vec<Condition> = letters.iter().map(|letter| self.guard(*letter, variable)).collect();
            let captions: Vec<String> = letters.iter().map(|letter| self.caption(*letter)).collect();
            let guard = any(guards);
            self.graph.internal(check, guard.clone(), [], to).caption = captions.join(" or ");
            elsewhere.push(guard);
        }
        self.graph.internal(check, any(elsewhere).negated(), [], other).caption = "else".to_owned();
    }

    /// The events on a letter's channel, each with whether the letter satisfies it.
    fn events(&self, letter: Letter) -> impl Iterator<Item = (EventId, bool)> + '_ {
        let on_channel = self.words.ids().filter(move |event| letter.channel >> event.0 & 1 == 1);
        on_channel.map(move |event| (event, letter.satisfied >> event.0 & 1 == 1))
    }

    fn guard(&self, letter: Letter, variable: VariableId) -> Condition {
        let conditions = self.events(letter).map(|(event, satisfied)| {
            let condition = translate(&self.words.get(event).condition, variable);
            if satisfied { condition } else { condition.negated() }
        });
        Condition::And(conditions.collect())
    }

    fn caption(&self, letter: Letter) -> String {
        let conditions = self.events(letter).map(|(event, satisfied)| {
            let condition = &self.words.get(event).condition;
            if satisfied { describe::brief(condition) } else { describe::brief_not(condition) }
        });
        conditions.collect::<Vec<_>>().join(" and ")
    }
}
