//! States and transitions of a chart.

use std::sync::Arc;

use miette::SourceSpan;

use super::{Block, Condition, EventClass, Invoke, Matches, Payload};
use crate::ids::{DataId, StateId, TransitionId};

/// The kind of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StateKind {
    /// A state without children.
    Atomic,
    /// A state with exactly one active child; the root is such a state.
    Compound,
    /// A state whose children are all active.
    Parallel,
    /// A state that ends its parent.
    Final,
    /// A pseudo-state that leads to the states last active in its parent.
    History(HistoryKind),
}

/// How much a history state remembers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HistoryKind {
    /// The children of the parent.
    Shallow,
    /// The atomic descendants of the parent.
    Deep,
}

/// A state with all its parts.
#[derive(Clone, Debug)]
pub struct State {
    pub(crate) id: Arc<str>,
    pub(crate) kind: StateKind,
    pub(crate) parent: Option<StateId>,
    /// The last of its descendants, or itself if it has none.
    pub(crate) last: StateId,
    /// Child states without history states.
    pub(crate) children: Vec<StateId>,
    pub(crate) histories: Vec<StateId>,
    /// For a compound state, the state that it enters by default; for a history state, its default.
    pub(crate) initial: Option<Initial>,
    pub(crate) transitions: Vec<TransitionId>,
    pub(crate) on_entry: Vec<Block>,
    pub(crate) on_exit: Vec<Block>,
    pub(crate) invokes: Vec<Invoke>,
    /// Data that late binding initializes here.
    pub(crate) data: Vec<DataId>,
    pub(crate) done_data: Payload,
    /// `done.state.<id>` and its class.
    pub(crate) done_event: (Arc<str>, EventClass),
    pub(crate) span: SourceSpan,
    /// The range of its element.
    pub(crate) extent: SourceSpan,
}

/// The transition of `<initial>` or of a history state, without event or condition.
#[derive(Clone, Debug)]
pub(crate) struct Initial {
    pub(crate) targets: Vec<StateId>,
    pub(crate) content: Block,
}

impl State {
    /// The id; if the file gives none, a generated one: `state@12` (on line 12).
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// The kind of the state.
    #[must_use]
    pub fn kind(&self) -> StateKind {
        self.kind
    }

    /// Its parent; the root has none.
    #[must_use]
    pub fn parent(&self) -> Option<StateId> {
        self.parent
    }

    /// Child states in document order, without history states.
    #[must_use]
    pub fn children(&self) -> &[StateId] {
        &self.children
    }

    /// History states of this state.
    #[must_use]
    pub fn histories(&self) -> &[StateId] {
        &self.histories
    }

    /// The state that a compound state enters by default, or a history state before it remembers anything.
    #[must_use]
    pub fn initial(&self) -> &[StateId] {
        self.initial.as_ref().map_or(&[], |initial| &initial.targets)
    }

    /// Transitions out of this state in document order.
    #[must_use]
    pub fn transitions(&self) -> &[TransitionId] {
        &self.transitions
    }

    /// The position of the state's element in the file: the bytes of its name.
    #[must_use]
    pub fn span(&self) -> std::ops::Range<usize> {
        super::range(self.span)
    }

    pub(crate) fn is_atomic(&self) -> bool {
        matches!(self.kind, StateKind::Atomic | StateKind::Final)
    }
}

/// A transition of a state.
#[derive(Clone, Debug)]
pub struct Transition {
    pub(crate) source: StateId,
    pub(crate) targets: Vec<StateId>,
    /// The attribute `event`, word by word.
    pub(crate) descriptors: Vec<Descriptor>,
    pub(crate) condition: Option<Condition>,
    /// The probability that it counts as enabled when its event and its condition allow it; otherwise the next
    /// transitions are considered.
    pub(crate) chance: Option<f64>,
    pub(crate) internal: bool,
    pub(crate) domain: TransitionDomain,
    pub(crate) content: Block,
    pub(crate) span: SourceSpan,
}

/// An event descriptor.
#[derive(Clone, Debug)]
pub(crate) struct Descriptor {
    pub(crate) text: Arc<str>,
    pub(crate) matches: Matches,
    pub(crate) span: SourceSpan,
}

/// The state within which a transition exits and enters states (SCXML Appendix D, getTransitionDomain).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TransitionDomain {
    /// A transition without a target exits no state.
    None,
    State(StateId),
    /// A target is a history state: the domain depends on what it remembers.
    Remembered,
}

impl Transition {
    /// The state that the transition leaves.
    #[must_use]
    pub fn source(&self) -> StateId {
        self.source
    }

    /// Its target states; empty for a transition that only executes content.
    #[must_use]
    pub fn targets(&self) -> &[StateId] {
        &self.targets
    }

    /// The events it reacts to, as written: `error.*`, `BT.tick`. Empty for an eventless transition.
    pub fn events(&self) -> impl Iterator<Item = &str> {
        self.descriptors.iter().map(|descriptor| &*descriptor.text)
    }

    /// The condition as written.
    #[must_use]
    pub fn condition(&self) -> Option<&str> {
        self.condition.as_ref().map(|condition| &*condition.text)
    }

    /// Whether the transition is internal: it does not exit its source if its targets are inside it.
    #[must_use]
    pub fn is_internal(&self) -> bool {
        self.internal
    }

    /// The position of the transition's element in the file: the bytes of its name.
    #[must_use]
    pub fn span(&self) -> std::ops::Range<usize> {
        super::range(self.span)
    }
}
