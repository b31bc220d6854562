//! The second pass: the contents of the states.

use std::collections::BTreeSet;
use std::sync::Arc;

use diagnostics::{Problem, nearest_or_all};

use super::origin::Origin;
use super::outline::{Outline, descriptors};
use super::value::{InlineContent, content_of_file};
use super::xml::{Element, Written, elements_named, name_span};
use super::{reach, targets};
use crate::Strictness;
use crate::chart::{Binding, Chart, DataItem, EventTree, Mentions, State, StateKind, Transition};
use crate::expression::{Expr, Names};
use crate::ids::{DataId, Identifiers, StateId, TransitionId};

/// Compiles a machine with a valid structure, and reports its remaining problems. Also returns how many of them the
/// recommendation would forgive.
pub(super) fn chart(root: Element<'_>, origin: &Origin, problems: &mut Vec<Problem>) -> (Chart, usize) {
    let is_sound = !problems.iter().any(Problem::is_error);
    let name = root.attribute("name").filter(|name| !name.is_empty());
    let name = name.map_or_else(|| origin.stem().into(), Arc::from);
    let Outline { states, data, names, .. } = Outline::of(root, origin, problems);
    let mut compiler = Compiler::new(root, origin, names, problems);
    let late = choice(root, "binding", &["early", "late"], compiler.problems) == 1;
    let data: Vec<DataItem> = data.into_iter().map(|(node, item)| compiler.data(node, item)).collect();
    let scripts = elements_named(root, "script").map(|script| vec![compiler.script(script)]).collect();
    let compile = |(id, (node, state))| compiler.state(StateId::new(id), node, state);
    let states: Vec<State> = states.into_iter().enumerate().map(compile).collect();
    let Compiler { events, transitions, foreign, mentions, leads_nowhere, forgivable, .. } = compiler;
    let state_ids = states.iter().map(|state| Arc::clone(&state.id)).collect();
    let data_ids = data.iter().map(|item| Arc::clone(&item.id)).collect();
    let mut chart = Chart {
        file: origin.file.clone(),
        ids: Identifiers::new(name, state_ids, data_ids),
        binding: if late { Binding::Late } else { Binding::Early },
        states,
        transitions,
        data,
        scripts,
        events,
        foreign,
        mentions,
        span: name_span(root).into(),
        folder: origin.folder.clone(),
        strictness: origin.strictness,
        warnings: Vec::new(),
    };
    targets::check(&chart, problems);
    targets::resolve_domains(&mut chart);
    // If a name is unknown, nothing can be concluded about reachability.
    if is_sound && !leads_nowhere {
        reach::check(&chart, problems);
    }
    (chart, forgivable)
}

/// The value of an attribute of the root; the first of `values` if it is missing.
fn choice(root: Element<'_>, name: &'static str, values: &[&str], problems: &mut Vec<Problem>) -> usize {
    let Some(written) = Written::attribute(root, name) else {
        return 0;
    };
    values.iter().position(|value| *value == written.value).unwrap_or_else(|| {
        let problem = Problem::new(format!("unknown {name} `{}`", written.value));
        problems.push(problem.at(written.span(), "unknown").with_help(nearest_or_all(written.value, name, values)));
        0
    })
}

/// The state of compiling a part of the file.
pub(super) struct Compiler<'p> {
    pub(super) origin: &'p Origin,
    pub(super) null_model: bool,
    pub(super) names: Names,
    pub(super) events: EventTree,
    transitions: Vec<Transition>,
    /// Data that code for the engine mentions.
    pub(super) foreign: BTreeSet<DataId>,
    pub(super) mentions: Mentions,
    /// Whether an unknown state or event is named, or a name is ambiguous.
    pub(super) leads_nowhere: bool,
    /// The number of problems with which the machine could still run, according to the recommendation.
    pub(super) forgivable: usize,
    pub(super) problems: &'p mut Vec<Problem>,
}

impl<'p> Compiler<'p> {
    fn new(root: Element<'_>, origin: &'p Origin, names: Names, problems: &'p mut Vec<Problem>) -> Self {
        Self {
            origin,
            null_model: choice(root, "datamodel", &["ecmascript", "null"], problems) == 1,
            names,
            events: EventTree::of(descriptors(root)),
            transitions: Vec::new(),
            foreign: BTreeSet::new(),
            mentions: Mentions::default(),
            leads_nowhere: false,
            forgivable: 0,
            problems,
        }
    }

    fn data(&mut self, node: Option<Element<'_>>, mut item: DataItem) -> DataItem {
        let Some(node) = node else {
            return item;
        };
        if self.null_model {
            let problem = Problem::new("the null data model has no data").at(name_span(node), "a datum");
            self.problems.push(problem.with_help("datamodel=\"ecmascript\""));
        }
        if let Some(src) = Written::attribute(node, "src") {
            item.init = Some(self.file_value(&src));
            return item;
        }
        let text = InlineContent::of(node);
        item.init = match (Written::attribute(node, "expr"), text) {
            (Some(expr), Some(text)) => {
                let problem = Problem::new("a datum has either an expression or content, not both");
                self.problems.push(problem.at(expr.span(), "either this").at(text.span, "or this"));
                None
            }
            // An empty expression leaves the datum undefined; the machine can run.
            (Some(expr), None) if expr.value.trim().is_empty() => None,
            (Some(expr), None) => Some(self.expression(&expr)),
            (None, Some(text)) => Some(Expr::Constant(text.value)),
            (None, None) => None,
        };
        item
    }

    fn file_value(&mut self, src: &Written<'_>) -> Expr {
        match self.origin.read(src.value) {
            Ok(text) => Expr::Constant(content_of_file(&text)),
            Err(reason) => Expr::Broken(self.defer(Problem::new(reason).at(src.span(), "cannot be read"))),
        }
    }

    fn state(&mut self, id: StateId, node: Element<'_>, mut state: State) -> State {
        let done: Arc<str> = format!("done.state.{}", state.id).into();
        state.done_event = (Arc::clone(&done), self.events.class(&done));
        state.on_entry = elements_named(node, "onentry").map(|block| self.block(block)).collect();
        state.on_exit = elements_named(node, "onexit").map(|block| self.block(block)).collect();
        state.invokes = elements_named(node, "invoke").map(|invoke| self.invoke(invoke)).collect();
        if let Some(done_data) = elements_named(node, "donedata").next() {
            state.done_data = self.payload(done_data);
        }
        if let StateKind::History(_) = state.kind {
            state.initial = self.default_transition(node);
            return state;
        }
        for transition in elements_named(node, "transition") {
            state.transitions.push(TransitionId::new(self.transitions.len()));
            let transition = self.transition(id, transition);
            self.transitions.push(transition);
        }
        state.initial = self.initial(node, &state);
        state
    }

    /// Reports a problem that the recommendation makes an error at run time, and returns its description.
    pub(super) fn defer(&mut self, problem: Problem) -> Arc<str> {
        let reason = problem.to_string().into();
        self.problems.push(match self.origin.strictness {
            Strictness::Strict => {
                self.forgivable += 1;
                problem
            }
            Strictness::Standard => problem.as_warning(),
        });
        reason
    }
}
