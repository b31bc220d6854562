//! Compiling transitions, and the default children of states (SCXML 3.3 to 3.6, 3.10).

use diagnostics::{MAX_HINTS, Problem, nearest_or_all};

use super::compile::Compiler;
use super::xml::{CHANCE_NAMESPACE, Element, Written, elements, elements_named, is_scxml, name_span};
use crate::chart::{Block, Descriptor, Initial, State, StateKind, Transition, TransitionDomain, is_descriptor};
use crate::ids::StateId;

impl Compiler<'_> {
    pub(super) fn transition(&mut self, source: StateId, node: Element<'_>) -> Transition {
        let event = Written::attribute(node, "event");
        let targets = Written::attribute(node, "target").map_or_else(Vec::new, |target| self.targets(&target));
        let internal = Written::attribute(node, "type").is_some_and(|written| self.is_internal(&written));
        if ["event", "cond", "target"].into_iter().all(|name| node.attribute(name).is_none()) {
            // It would be taken forever (SCXML 3.5.1).
            let problem = Problem::new("a transition needs an event, a condition or a target");
            let problem = problem.at(name_span(node), "this has none of them");
            self.problems.push(problem.with_help("put actions on entering the state in <onentry>"));
        }
        Transition {
            source,
            targets,
            descriptors: event.map_or_else(Vec::new, |event| self.descriptors(&event)),
            condition: Written::attribute(node, "cond").map(|written| self.condition(&written)),
            chance: self.chance(node),
            internal,
            domain: TransitionDomain::None,
            content: self.block(node),
            span: name_span(node).into(),
        }
    }

    /// The attribute `chance`, an extension in its own namespace.
    fn chance(&mut self, node: Element<'_>) -> Option<f64> {
        let attribute = node.attribute_node((CHANCE_NAMESPACE, "chance"))?;
        let chance = attribute.value().parse().ok().filter(|chance| (0.0..=1.0).contains(chance));
        if chance.is_none() {
            let problem = Problem::new(format!("`{}` is not a probability", attribute.value()));
            self.problems.push(problem.at(node.written(attribute.range_value()), "not a number from 0 to 1"));
        }
        // Each region would draw its own number.
        let mut around = node.parent().into_iter().flat_map(|source| source.descendants());
        if around.any(|node| is_scxml(&node) && node.tag_name().name() == "parallel") {
            let problem = Problem::new("a transition of a state with parallel regions cannot be left to chance");
            let problem = problem.at(node.written(attribute.range_qname()), "here");
            self.problems.push(problem.with_help("put it into one of the regions"));
        }
        chance
    }

    fn is_internal(&mut self, written: &Written<'_>) -> bool {
        if !["internal", "external"].contains(&written.value) {
            let problem = Problem::new(format!("unknown transition type `{}`", written.value));
            self.problems.push(problem.at(written.span(), "unknown type").with_help("use `internal` or `external`"));
        }
        written.value == "internal"
    }

    fn descriptors(&mut self, event: &Written<'_>) -> Vec<Descriptor> {
        let words = event.words();
        if words.is_empty() {
            let problem = Problem::new("no event is named").at(event.span(), "empty");
            self.problems.push(problem.with_help("leave out the attribute for a transition without an event"));
        }
        let mut descriptors = Vec::new();
        for word in words {
            let (text, span) = (word.value, word.span());
            if text == ".*" {
                let problem =
                    Problem::new("`.*` has nothing before its dot").at(span.clone(), "did you mean every event, `*`?");
                self.defer(problem.with_help("`*`"));
            }
            if is_descriptor(text) || text == ".*" {
                let matches = self.events.register(text);
                descriptors.push(Descriptor { text: text.into(), matches, span: span.into() });
            } else {
                self.leads_nowhere = true;
                let problem = Problem::new(format!("`{text}` matches no event")).at(span, "not an event descriptor");
                let forms = "use `BT.tick`; `BT` or `BT.*` for every event whose name begins with the word BT; `*` for every event";
                self.problems.push(problem.with_help(forms));
            }
        }
        descriptors
    }

    /// The states that a target attribute names.
    fn targets(&mut self, written: &Written<'_>) -> Vec<StateId> {
        let words = written.words();
        if words.is_empty() {
            let problem = Problem::new("no state is named").at(written.span(), "empty");
            self.problems.push(problem.with_help("leave out the attribute to stay in the state"));
        }
        let mut targets = Vec::new();
        for word in words {
            match self.names.states.get(word.value) {
                Some(state) => targets.push(*state),
                None => {
                    self.leads_nowhere = true;
                    let problem = Problem::new(format!("unknown state `{}`", word.value));
                    let problem = problem.at(word.span(), "unknown state");
                    let help = (self.problems.len() < MAX_HINTS).then(|| {
                        let known: Vec<&str> = self.names.states.keys().map(String::as_str).collect();
                        nearest_or_all(word.value, "states", &known)
                    });
                    self.problems.push(problem.with_help_if(help));
                }
            }
        }
        targets
    }

    /// The default child of a compound state: by its attribute, its element, or else its first child.
    pub(super) fn initial(&mut self, node: Element<'_>, state: &State) -> Option<Initial> {
        let attribute = Written::attribute(node, "initial");
        let element = elements_named(node, "initial").next();
        if state.kind != StateKind::Compound {
            let span = attribute.map(|written| written.span()).or_else(|| element.map(name_span));
            if let Some(span) = span {
                let problem = Problem::new("only a state with child states can have an initial one");
                self.problems.push(problem.at(span, format!("{} has no children", state.id)));
            }
            return None;
        }
        match (attribute, element) {
            (Some(attribute), Some(element)) => {
                let problem = Problem::new("the initial state is given twice");
                self.problems.push(problem.at(attribute.span(), "here").at(name_span(element), "and here"));
                // Both are compiled nevertheless, for their own problems.
                self.targets(&attribute);
                self.default_transition(element);
                self.leads_nowhere = true;
                None
            }
            (Some(attribute), None) => Some(Initial { targets: self.targets(&attribute), content: Block::new() }),
            (None, Some(element)) => self.default_transition(element),
            (None, None) => {
                Some(Initial { targets: state.children.first().copied().into_iter().collect(), content: Block::new() })
            }
        }
    }

    /// The only transition of `<initial>` or `<history>`: it has a target, and neither event nor condition.
    pub(super) fn default_transition(&mut self, node: Element<'_>) -> Option<Initial> {
        let name = node.tag_name().name();
        let transitions: Vec<Element<'_>> = elements(node).collect();
        let [transition] = transitions.as_slice() else {
            self.leads_nowhere = true;
            let message = format!("<{name}> must have one transition, not {}", transitions.len());
            let problem = Problem::new(message).at(name_span(node), "in here");
            self.problems.push(problem.with_help("<transition target=\"…\"/>"));
            return None;
        };
        for unwanted in ["event", "cond"] {
            if let Some(written) = Written::attribute(*transition, unwanted) {
                let problem = Problem::new(format!("the transition of <{name}> is unconditional"));
                self.problems.push(problem.at(written.span(), format!("`{unwanted}` is not allowed here")));
            }
        }
        let Some(target) = Written::attribute(*transition, "target") else {
            self.leads_nowhere = true;
            let problem = Problem::new(format!("the transition of <{name}> leads nowhere"));
            self.problems.push(problem.at(name_span(*transition), "`target` is missing"));
            return None;
        };
        Some(Initial { targets: self.targets(&target), content: self.block(*transition) })
    }
}
