//! The second pass: what the states do.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use roxmltree::Node;

use super::outline::{Outline, descriptors};
use super::targets;
use super::xml::{Written, elements, elements_named, name_span};
use super::{files, reach};
use crate::chart::{
    Binding, Block, Chart, Condition, DataId, DataItem, Descriptor, Domain, EventTree, Initial, State, StateId,
    StateKind, Transition, TransitionId, is_descriptor,
};
use crate::datum::standalone;
use crate::engine::{Code, Form};
use crate::expression::{self, Expr, ExpressionProblem, Names, Parsed, ProblemKind};
use crate::problem::Problem;
use crate::suggest::nearest_or_all;
use crate::{Datum, Strictness};

/// Where a machine comes from, and how strictly it is read.
#[derive(Clone, Debug)]
pub(super) struct Origin<'o> {
    pub(super) file: NamedSource<Arc<str>>,
    /// What the machine is called if it does not say so itself.
    pub(super) stem: &'o str,
    pub(super) strictness: Strictness,
    /// Where files are looked up.
    pub(super) folder: Option<Arc<Path>>,
    /// Whether the machines are looked at that are invoked from files.
    pub(super) looks_further: bool,
}

impl Origin<'_> {
    /// The text of a file beside the machine's.
    pub(super) fn read(&self, address: &str) -> Result<String, String> {
        files::read(&files::path(address, self.folder.as_deref())?)
    }

    /// Whether a file can be invoked as a machine.
    pub(super) fn try_invoked(&self, address: &str) -> Result<(), String> {
        let path = files::path(address, self.folder.as_deref())?;
        if !self.looks_further {
            return Ok(());
        }
        Chart::open_with(&path, self.strictness, false).map(|_| ()).map_err(|error| error.to_string())
    }
}

/// Compiles a machine whose elements are as SCXML has them, and reports what is wrong nevertheless.
pub(super) fn chart(root: Node<'_, '_>, origin: &Origin<'_>, problems: &mut Vec<Problem>) -> Chart {
    let strictness = origin.strictness;
    let is_sound = !problems.iter().any(Problem::is_error);
    let name = root.attribute("name").filter(|name| !name.is_empty()).unwrap_or(origin.stem).into();
    let Outline { states, data, names, .. } = Outline::of(root, origin, problems);
    let events = EventTree::of(descriptors(root));
    let null_model = choice(root, "datamodel", &["ecmascript", "null"], problems) == 1;
    let late = choice(root, "binding", &["early", "late"], problems) == 1;
    let (transitions, foreign) = (Vec::new(), BTreeSet::new());
    let mut compiler =
        Compiler { origin, null_model, names, events, transitions, foreign, leads_nowhere: false, problems };
    let data = data.into_iter().map(|(node, item)| compiler.data(node, item)).collect();
    let scripts = elements_named(root, "script").map(|script| vec![compiler.script(script)]).collect();
    let compile = |(id, (node, state))| compiler.state(StateId::new(id), node, state);
    let states = states.into_iter().enumerate().map(compile).collect();
    let Compiler { events, transitions, foreign, leads_nowhere, .. } = compiler;
    let binding = if late { Binding::Late } else { Binding::Early };
    let (file, folder, span) = (origin.file.clone(), origin.folder.clone(), name_span(root).into());
    let warnings = Vec::new();
    let mut chart = Chart {
        file,
        name,
        binding,
        states,
        transitions,
        data,
        scripts,
        events,
        foreign,
        span,
        folder,
        strictness,
        warnings,
    };
    targets::check(&chart, problems);
    targets::resolve_domains(&mut chart);
    // Where it is not known what was meant, nothing can be said of where it leads.
    if is_sound && !leads_nowhere {
        reach::check(&chart, problems);
    }
    chart
}

/// Which of the values an attribute of the root has; the first if it is not there.
fn choice(root: Node<'_, '_>, name: &'static str, values: &[&str], problems: &mut Vec<Problem>) -> usize {
    let Some(written) = Written::attribute(root, name) else {
        return 0;
    };
    values.iter().position(|value| *value == written.value).unwrap_or_else(|| {
        let problem = Problem::new(format!("there is no {name} `{}` here", written.value));
        problems.push(problem.at(written.span(), "unknown").help(nearest_or_all(written.value, name, values)));
        0
    })
}

/// What is needed to compile a part of the file.
pub(super) struct Compiler<'p> {
    pub(super) origin: &'p Origin<'p>,
    pub(super) null_model: bool,
    pub(super) names: Names,
    pub(super) events: EventTree,
    transitions: Vec<Transition>,
    /// Data that code for the engine mentions.
    foreign: BTreeSet<DataId>,
    /// Whether a state or an event is named that there is not, or it is left open which of two is meant.
    leads_nowhere: bool,
    pub(super) problems: &'p mut Vec<Problem>,
}

impl Compiler<'_> {
    fn data(&mut self, node: Option<Node<'_, '_>>, mut item: DataItem) -> DataItem {
        let Some(node) = node else {
            return item;
        };
        if self.null_model {
            let problem = Problem::new("the null data model has no data").at(name_span(node), "a datum");
            self.problems.push(problem.help("datamodel=\"ecmascript\""));
        }
        if let Some(src) = Written::attribute(node, "src") {
            item.init = Some(self.file_value(&src));
            return item;
        }
        let text = Value::of(node);
        item.init = match (Written::attribute(node, "expr"), text) {
            (Some(expr), Some(text)) => {
                let problem = Problem::new("a datum has an expression or a content, not both");
                self.problems.push(problem.at(expr.span(), "either this").at(text.span, "or this"));
                None
            }
            // An empty expression leaves the datum undefined, and the machine whole.
            (Some(expr), None) if expr.value.trim().is_empty() => None,
            (Some(expr), None) => Some(self.expression(&expr)),
            (None, Some(text)) => Some(Expr::Constant(text.value)),
            (None, None) => None,
        };
        item
    }

    /// The value that a file holds.
    fn file_value(&mut self, src: &Written<'_>) -> Expr {
        match self.origin.read(src.value) {
            Ok(text) => Expr::Constant(content_of_file(&text)),
            Err(reason) => Expr::Broken(self.defer(Problem::new(reason).at(src.span(), "cannot be read"))),
        }
    }

    fn state(&mut self, id: StateId, node: Node<'_, '_>, mut state: State) -> State {
        let done: Arc<str> = format!("done.state.{}", state.id).into();
        state.done_event = (Arc::clone(&done), self.events.class(&done));
        state.on_entry = elements_named(node, "onentry").map(|block| self.block(block)).collect();
        state.on_exit = elements_named(node, "onexit").map(|block| self.block(block)).collect();
        state.invokes = elements_named(node, "invoke").map(|invoke| self.invoke(invoke)).collect();
        if let Some(done_data) = elements_named(node, "donedata").next() {
            state.done_data = self.payload(done_data);
        }
        if let StateKind::History(_) = state.kind {
            state.initial = self.history(node);
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

    fn transition(&mut self, source: StateId, node: Node<'_, '_>) -> Transition {
        let event = Written::attribute(node, "event");
        let targets = Written::attribute(node, "target").map_or_else(Vec::new, |target| self.targets(&target));
        let internal = Written::attribute(node, "type").is_some_and(|written| self.is_internal(&written));
        if ["event", "cond", "target"].into_iter().all(|name| node.attribute(name).is_none()) {
            // It would be taken again and again, for ever (SCXML 3.5.1).
            let problem = Problem::new("a transition has an event, a condition or a target");
            let problem = problem.at(name_span(node), "has none of them");
            self.problems.push(problem.help("what is done on entering the state belongs in <onentry>"));
        }
        Transition {
            source,
            targets,
            descriptors: event.map_or_else(Vec::new, |event| self.descriptors(&event)),
            condition: Written::attribute(node, "cond").map(|written| self.condition(&written)),
            internal,
            domain: Domain::None,
            content: self.block(node),
            span: name_span(node).into(),
        }
    }

    fn is_internal(&mut self, written: &Written<'_>) -> bool {
        if !["internal", "external"].contains(&written.value) {
            let problem = Problem::new(format!("there are no {} transitions", written.value));
            self.problems.push(problem.at(written.span(), "unknown type").help("`internal` or `external`"));
        }
        written.value == "internal"
    }

    fn descriptors(&mut self, event: &Written<'_>) -> Vec<Descriptor> {
        let words = event.words();
        if words.is_empty() {
            let problem = Problem::new("no event is named").at(event.span(), "empty");
            self.problems.push(problem.help("leave the attribute out to take the transition without an event"));
        }
        let mut descriptors = Vec::new();
        for (word, span) in words {
            if word == ".*" {
                let problem = Problem::new("`.*` has nothing before its dot").at(span.clone(), "every event is meant?");
                self.defer(problem.help("`*`"));
            }
            if is_descriptor(word) || word == ".*" {
                let matches = self.events.matches(word);
                descriptors.push(Descriptor { text: word.into(), matches, span: span.into() });
            } else {
                self.leads_nowhere = true;
                let problem = Problem::new(format!("`{word}` matches no event")).at(span, "not an event descriptor");
                let forms =
                    "`BT.tick`; `BT` or `BT.*` for every event whose name begins with the word BT; `*` for every event";
                self.problems.push(problem.help(forms));
            }
        }
        descriptors
    }

    /// The states that a target attribute names.
    fn targets(&mut self, written: &Written<'_>) -> Vec<StateId> {
        let words = written.words();
        if words.is_empty() {
            let problem = Problem::new("no state is named").at(written.span(), "empty");
            self.problems.push(problem.help("leave the attribute out to stay in the state"));
        }
        let mut targets = Vec::new();
        for (word, span) in words {
            match self.names.states.get(word) {
                Some(state) => targets.push(*state),
                None => {
                    self.leads_nowhere = true;
                    let known: Vec<&str> = self.names.states.keys().map(String::as_str).collect();
                    let problem = Problem::new(format!("there is no state `{word}`")).at(span, "unknown state");
                    self.problems.push(problem.help(nearest_or_all(word, "states", &known)));
                }
            }
        }
        targets
    }

    /// What a compound state enters by default: its attribute, its element, or its first child.
    fn initial(&mut self, node: Node<'_, '_>, state: &State) -> Option<Initial> {
        let attribute = Written::attribute(node, "initial");
        let element = elements_named(node, "initial").next();
        if state.kind != StateKind::Compound {
            let span = attribute.map(|written| written.span()).or_else(|| element.map(name_span));
            if let Some(span) = span {
                let problem = Problem::new("only a state with child states has an initial one");
                self.problems.push(problem.at(span, format!("{} has no children to choose from", state.id)));
            }
            return None;
        }
        match (attribute, element) {
            (Some(attribute), Some(element)) => {
                let problem = Problem::new("an initial state is given twice");
                self.problems.push(problem.at(attribute.span(), "here").at(name_span(element), "and here"));
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

    fn history(&mut self, node: Node<'_, '_>) -> Option<Initial> {
        self.default_transition(node)
    }

    /// The one transition of `<initial>` or `<history>`: it has a target, and neither event nor condition.
    fn default_transition(&mut self, node: Node<'_, '_>) -> Option<Initial> {
        let name = node.tag_name().name();
        let transitions: Vec<Node<'_, '_>> = elements(node).collect();
        let [transition] = transitions.as_slice() else {
            self.leads_nowhere = true;
            let message = format!("<{name}> has one transition, not {}", transitions.len());
            let problem = Problem::new(message).at(name_span(node), "in here");
            self.problems.push(problem.help("<transition target=\"…\"/>"));
            return None;
        };
        for unwanted in ["event", "cond"] {
            if let Some(written) = Written::attribute(*transition, unwanted) {
                let problem = Problem::new(format!("the transition of <{name}> is always taken"));
                self.problems.push(problem.at(written.span(), format!("`{unwanted}` must not be here")));
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

    pub(super) fn condition(&mut self, written: &Written<'_>) -> Condition {
        Condition { test: self.expression(written), text: written.value.into(), span: written.span().into() }
    }

    /// Compiles an expression. One that cannot be compiled is reported, and is an error whenever it is evaluated.
    pub(super) fn expression(&mut self, written: &Written<'_>) -> Expr {
        let parsed = expression::expression(written.value, &self.names);
        match self.compiled(written, parsed, Form::Expression, |expr| expr, Expr::Foreign) {
            Ok(expr) if self.null_model && !matches!(expr, Expr::In(_)) => {
                let problem =
                    Problem::new("the null data model has no expressions").at(written.span(), "an expression");
                Expr::Broken(self.defer(problem.help("`In('state')`, or datamodel=\"ecmascript\"")))
            }
            Ok(expr) => expr,
            Err(reason) => Expr::Broken(reason),
        }
    }

    /// What was compiled or, if that was not possible and there is an engine that can do it, code for the engine. Otherwise
    /// what is wrong is reported, and `Err` says it.
    pub(super) fn compiled<T, C>(
        &mut self,
        written: &Written<'_>,
        parsed: Parsed<T>,
        form: Form,
        here: impl FnOnce(T) -> C,
        there: impl FnOnce(Arc<Code>) -> C,
    ) -> Result<C, Arc<str>> {
        let for_engine = match &parsed.outcome {
            Err(problem) if problem.kind != ProblemKind::Name && !self.null_model => {
                Code::new(written.value, form, &self.names).map(|code| (code, problem.clone()))
            }
            _ => None,
        };
        match for_engine {
            Some((Ok(code), problem)) => {
                if problem.kind == ProblemKind::Suspicious {
                    self.problems.push(in_file(written, problem).warning());
                }
                self.foreign.extend(code.mentions());
                Ok(there(Arc::new(code)))
            }
            Some((Err(worse), problem)) if problem.kind == ProblemKind::Beyond => {
                Err(self.defer(in_file(written, worse)))
            }
            _ => self.report(written, parsed).map(here),
        }
    }

    pub(super) fn report<T>(&mut self, written: &Written<'_>, parsed: Parsed<T>) -> Result<T, Arc<str>> {
        let fatal = parsed.outcome.as_ref().err().map(|problem| problem.span.clone());
        let overlaps =
            |span: &Range<usize>| fatal.as_ref().is_some_and(|fatal| span.start < fatal.end && fatal.start < span.end);
        let mut meant = None;
        for problem in parsed.unknown {
            if overlaps(&problem.span) {
                meant = problem.help;
            } else {
                self.defer(in_file(written, problem));
            }
        }
        parsed.outcome.map_err(|problem| {
            let help = problem.help.clone().or(meant);
            self.defer(in_file(written, ExpressionProblem { help, ..problem }))
        })
    }

    /// Reports what the recommendation leaves to be an error at run time, and says what is wrong.
    pub(super) fn defer(&mut self, problem: Problem) -> Arc<str> {
        let reason = problem.to_string().into();
        self.problems.push(match self.origin.strictness {
            Strictness::Strict => problem.forgivable(),
            Strictness::Standard => problem.warning(),
        });
        reason
    }
}

fn in_file(written: &Written<'_>, problem: ExpressionProblem) -> Problem {
    let span = written.span_of(problem.span);
    Problem::new(problem.message).at(span, problem.label).maybe_help(problem.help)
}

/// A value that is written between two tags (SCXML B.2.1): XML, JSON, or else a text with single blanks.
pub(super) struct Value {
    pub(super) value: Datum,
    pub(super) span: Range<usize>,
}

impl Value {
    /// What stands in an element; none if that is nothing.
    pub(super) fn of(node: Node<'_, '_>) -> Option<Self> {
        if let Some(element) = node.children().find(Node::is_element) {
            return Some(Self { value: Datum::Xml(standalone(node.children()).into()), span: name_span(element) });
        }
        Written::text(node).map(|text| Self { value: literal(text.value), span: text.span() })
    }
}

/// A value that is text.
fn literal(text: &str) -> Datum {
    expression::literal(text).unwrap_or_else(|| {
        let words: Vec<&str> = text.split_whitespace().collect();
        Datum::text(&words.join(" "))
    })
}

/// The value that a file holds.
fn content_of_file(text: &str) -> Datum {
    let text = text.trim_start_matches('\u{feff}').trim();
    if text.starts_with('<')
        && let Ok(document) = roxmltree::Document::parse(text)
    {
        return Datum::Xml(standalone(std::iter::once(document.root_element())).into());
    }
    literal(text)
}
