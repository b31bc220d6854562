//! A machine as it was written: compiled once, immutable, shared by everything that runs it.

mod content;
mod events;
mod mentions;
mod relations;
mod show;
mod state;

use std::collections::BTreeSet;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

use diagnostics::{Problem, did_you_mean};
use miette::SourceSpan;

pub(crate) use content::{
    Action, ActionKind, AssignTarget, Attribute, Block, Branch, Condition, Content, Delay, Foreach, Invoke,
    InvokeSource, Param, Payload, Send, SendId, Source, visit_actions,
};
pub(crate) use events::{EventClass, EventTree, Matches, is_descriptor, is_event_name};
pub(crate) use mentions::{ADDRESS, Mentions};
pub(crate) use state::{Descriptor, Initial, TransitionDomain};
pub use state::{HistoryKind, State, StateKind, Transition};

use crate::expression::Expr;
use crate::folder::Folder;
use crate::ids::{DataId, Identifiers, StateId, TransitionId};
use crate::{Concerns, Strictness};

/// A range of a file, from its first byte to the one after its last.
pub(crate) fn range(span: SourceSpan) -> Range<usize> {
    span.offset()..span.offset() + span.len()
}

/// The name of SCXML's own event I/O processor (SCXML C.1); `scxml` is accepted as well.
pub(crate) const SCXML_PROCESSOR: &str = "http://www.w3.org/TR/scxml/#SCXMLEventProcessor";
/// The name of the event I/O processor that sends messages on channels.
pub const CHANNEL_PROCESSOR: &str = "channel";

/// The event I/O processor that delivers one of the events that were sent to it: `<send type="choice" event="opens"/>`.
pub const CHOICE_PROCESSOR: &str = "choice";

/// The types of `<invoke>` that mean a machine (SCXML 6.4.2).
pub(crate) const INVOKE_KINDS: [&str; 3] = ["scxml", "http://www.w3.org/TR/scxml/", "http://www.w3.org/TR/scxml"];

/// `<data>`, or a name that a script or a `<foreach>` declares.
#[derive(Clone, Debug)]
pub(crate) struct DataItem {
    pub(crate) id: Arc<str>,
    /// Its initial value; `None` is `undefined`.
    pub(crate) init: Option<Expr>,
    pub(crate) span: SourceSpan,
    /// Whether it belongs to the data model of the whole machine, so that the caller that starts the machine may give
    /// another value.
    pub(crate) top_level: bool,
}

/// When data get their initial values (SCXML 5.3.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binding {
    Early,
    Late,
}

/// A state machine, compiled from an SCXML file.
///
/// States are numbered in document order, so the numbers of a state's descendants directly follow its own. State 0 is
/// the `<scxml>` element itself.
///
/// Two charts are equal if they were compiled from the same part of the same text.
///
/// ```
/// use skills::Chart;
///
/// let chart = Chart::load("Lamp.scxml", r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
///   <state id="off"><transition event="press" target="on"/></state>
///   <state id="on"><transition event="press" target="off"/></state>
/// </scxml>"#)?;
/// assert!(chart.handles("press") && !chart.handles("pull"));
/// assert!(chart.find_state("on").is_some());
/// assert!(chart.warnings().is_empty());
/// # Ok::<(), skills::SkillError>(())
/// ```
pub struct Chart {
    pub(crate) file: diagnostics::Source,
    pub(crate) ids: Identifiers,
    pub(crate) binding: Binding,
    pub(crate) states: Vec<State>,
    pub(crate) transitions: Vec<Transition>,
    pub(crate) data: Vec<DataItem>,
    pub(crate) scripts: Vec<Block>,
    pub(crate) events: EventTree,
    /// Data that code for the engine may change.
    pub(crate) foreign: BTreeSet<DataId>,
    pub(crate) mentions: Mentions,
    /// The position of `<scxml>` in the file: a file may contain machines inside machines.
    pub(crate) span: SourceSpan,
    /// The folder in which `src` is looked up; `None` if files are not accessible.
    pub(crate) folder: Option<Folder>,
    pub(crate) strictness: Strictness,
    pub(crate) warnings: Vec<Problem>,
}

impl Chart {
    /// The machine's name: the attribute `name`, or else the file's name without folder and extension.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.ids.machine
    }

    /// The file that the machine was read from, with its text.
    #[must_use]
    pub fn file(&self) -> &diagnostics::Source {
        &self.file
    }

    /// Warnings: parts of the file that look wrong but do not make it unusable.
    #[must_use]
    pub fn warnings(&self) -> &[Problem] {
        &self.warnings
    }

    /// The warnings, to be rendered with the file; `None` if there are none.
    #[must_use]
    pub fn concerns(&self) -> Option<Concerns> {
        Concerns::of(&self.file, self.warnings.clone())
    }

    /// The `<scxml>` element as the root of all states.
    #[must_use]
    pub fn root(&self) -> StateId {
        StateId::ROOT
    }

    /// All states in document order, parents before children, without the root.
    pub fn states(&self) -> impl Iterator<Item = StateId> + use<> {
        (1..self.states.len()).map(StateId::new)
    }

    /// The details of a state.
    #[must_use]
    pub fn state(&self, state: StateId) -> &State {
        &self.states[state.index()]
    }

    /// The state with this id.
    #[must_use]
    pub fn find_state(&self, id: &str) -> Option<StateId> {
        self.ids.find_state(id)
    }

    /// All transitions in document order, without those of `<initial>` and `<history>`.
    pub fn transitions(&self) -> impl Iterator<Item = TransitionId> + use<> {
        (0..self.transitions.len()).map(TransitionId::new)
    }

    /// The details of a transition.
    #[must_use]
    pub fn transition(&self, transition: TransitionId) -> &Transition {
        &self.transitions[transition.index()]
    }

    /// The ids of the data to which the caller that starts the machine may give values, in document order.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.data.iter().filter(|item| item.top_level).map(|item| &*item.id)
    }

    pub(crate) fn find_data(&self, id: &str) -> Option<DataId> {
        self.ids.find_data(id)
    }

    /// The datum with this id, if the caller that starts the machine may give it a value.
    pub(crate) fn find_parameter(&self, id: &str) -> Option<DataId> {
        self.find_data(id).filter(|data| self.data[data.index()].top_level)
    }

    /// Every block of executable content.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = &Block> {
        let of_states = self.states.iter().flat_map(|state| {
            let initial = state.initial.as_ref().map(|initial| &initial.content);
            let finalize = state.invokes.iter().filter_map(|invoke| invoke.finalize.as_ref());
            state.on_entry.iter().chain(&state.on_exit).chain(initial).chain(finalize)
        });
        let of_transitions = self.transitions.iter().map(|transition| &transition.content);
        self.scripts.iter().chain(of_states).chain(of_transitions)
    }

    /// Whether some transition handles events with this name.
    #[must_use]
    pub fn handles(&self, event: &str) -> bool {
        self.events.handles(event)
    }

    /// Whether an event descriptor other than `*` matches events with this name.
    #[must_use]
    pub fn names(&self, event: &str) -> bool {
        self.events.names(event)
    }

    /// Whether a transition may handle such an event, here or in a machine to which everything is forwarded.
    pub(crate) fn may_handle(&self, event: &str) -> bool {
        self.handles(event) || self.invokes().any(|invoke| invoke.auto_forward)
    }

    /// The messages that the machine sends over channels to processes other than `known`, to be rendered; `None` if
    /// there are none. `hint` suggests what to do about them.
    #[must_use]
    pub fn sends_elsewhere(&self, known: &[&str], hint: &str) -> Option<Concerns> {
        let mut problems: Vec<Problem> = Vec::new();
        self.visit_sends(&mut |send| {
            if send.goes_by_channel()
                && let Some(target) = &send.target
                && let Some(name) = target.literal().filter(|name| !known.contains(&&***name))
            {
                let problem = Problem::new(format!("the machine sends to the process `{name}`")).as_warning();
                let help = did_you_mean(name, known.iter().copied()).unwrap_or_else(|| hint.to_owned());
                problems.push(problem.at(target.span, "the program does not have this process").with_help(help));
            }
        });
        problems.dedup_by_key(|problem| problem.to_string());
        Concerns::of(&self.file, problems)
    }

    /// The messages that the machine sends over channels, as far as they are literal: the target process, and the
    /// symbol with which the message begins.
    #[must_use]
    pub fn channel_messages(&self) -> Vec<(&str, &str)> {
        let mut messages = Vec::new();
        self.visit_sends(&mut |send| {
            let target = send.target.as_ref().and_then(Attribute::literal);
            let event = send.event.as_ref().and_then(Attribute::literal);
            let both = target.zip(event).filter(|_| send.goes_by_channel());
            messages.extend(both.map(|(target, event)| (&**target, &**event)));
        });
        messages
    }

    /// The machines inside this one, which it can invoke.
    pub fn inner(&self) -> impl Iterator<Item = &Arc<Self>> {
        self.invokes().filter_map(|invoke| match &invoke.source {
            InvokeSource::Inline(chart) => Some(chart),
            _ => None,
        })
    }

    pub(crate) fn invokes(&self) -> impl Iterator<Item = &Invoke> {
        self.states.iter().flat_map(|state| &state.invokes)
    }

    /// Whether the machine, or one inside it, can read an id that is generated when it sends or invokes.
    pub(crate) fn looks_at_generated_ids(&self) -> bool {
        let mut looks = self.mentions.sessions || self.invokes().any(|invoke| invoke.id_location.is_some());
        self.visit_sends(&mut |send| looks |= matches!(send.id, SendId::Generated(_)));
        looks || self.inner().any(|inner| inner.looks_at_generated_ids())
    }

    /// Calls `visit` with every `<send>`.
    pub(crate) fn visit_sends<'a>(&'a self, visit: &mut dyn FnMut(&'a Send)) {
        for block in self.blocks() {
            visit_actions(block, &mut |action| {
                if let ActionKind::Send(send) = &action.kind {
                    visit(send);
                }
            });
        }
    }
}

impl fmt::Debug for Chart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Chart").field("name", &self.name()).field("file", &self.file.name()).finish_non_exhaustive()
    }
}

impl PartialEq for Chart {
    fn eq(&self, other: &Self) -> bool {
        self.file.name() == other.file.name() && self.span == other.span && self.file.text() == other.file.text()
    }
}

impl Eq for Chart {}

impl Hash for Chart {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.file.name().hash(state);
        self.span.hash(state);
    }
}
