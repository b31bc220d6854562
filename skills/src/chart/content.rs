//! Executable content (SCXML 4), compiled.

use std::sync::Arc;
use std::time::Duration;

use miette::SourceSpan;

use super::{CHANNEL_PROCESSOR, Chart, EventClass};
use crate::Datum;
use crate::expression::Code;
use crate::expression::{Expr, Location, Statement};
use crate::ids::DataId;

/// The actions of one `<onentry>`, `<onexit>` or transition. An error ends the block early and affects no other block.
pub(crate) type Block = Vec<Action>;

/// One element of executable content, and its position in the file.
#[derive(Clone, Debug)]
pub(crate) struct Action {
    pub(crate) kind: ActionKind,
    pub(crate) span: SourceSpan,
}

#[derive(Clone, Debug)]
pub(crate) enum ActionKind {
    Raise {
        event: Arc<str>,
        class: EventClass,
    },
    Send(Box<Send>),
    Cancel(Source),
    Assign(AssignTarget, Expr),
    If(Vec<Branch>),
    Foreach(Box<Foreach>),
    Log {
        label: Arc<str>,
        value: Option<Expr>,
    },
    Script(Vec<Statement>),
    /// A script outside the compiled subset.
    Foreign(Arc<Code>),
    /// A problem found when the file was loaded that the recommendation makes an error at run time.
    Fail(Arc<str>),
}

/// A branch of `<if>`; `<else>` has no condition.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    pub(crate) condition: Option<Condition>,
    pub(crate) content: Block,
}

/// A condition and its position.
#[derive(Clone, Debug)]
pub(crate) struct Condition {
    pub(crate) test: Expr,
    pub(crate) text: Arc<str>,
    pub(crate) span: SourceSpan,
}

#[derive(Clone, Debug)]
pub(crate) struct Foreach {
    pub(crate) array: Expr,
    pub(crate) item: DataId,
    pub(crate) index: Option<DataId>,
    pub(crate) content: Block,
}

/// A text that is literal or computed.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Literal(Arc<str>),
    Computed(Expr),
}

/// An attribute that is literal or computed, and its position.
#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub(crate) source: Source,
    pub(crate) span: SourceSpan,
}

impl Attribute {
    /// The text, if it is literal.
    pub(crate) fn literal(&self) -> Option<&Arc<str>> {
        match &self.source {
            Source::Literal(text) => Some(text),
            Source::Computed(_) => None,
        }
    }
}

/// `<send>`
#[derive(Clone, Debug)]
pub(crate) struct Send {
    pub(crate) event: Option<Attribute>,
    pub(crate) target: Option<Attribute>,
    pub(crate) processor: Option<Attribute>,
    pub(crate) id: SendId,
    pub(crate) delay: Delay,
    pub(crate) name_list: Vec<Param>,
    pub(crate) payload: Payload,
    pub(crate) span: SourceSpan,
}

impl Send {
    /// Whether it goes by channel, as far as that is literal.
    pub(crate) fn goes_by_channel(&self) -> bool {
        self.processor.as_ref().and_then(Attribute::literal).is_some_and(|name| &**name == CHANNEL_PROCESSOR)
    }

    /// The data that it sends by name: name, value and position.
    pub(crate) fn named(&self) -> impl Iterator<Item = (&Arc<str>, &Expr, SourceSpan)> {
        let params = self.name_list.iter().chain(&self.payload.params);
        params.map(|param| (&param.name, &param.value, param.span))
    }
}

#[derive(Clone, Debug)]
pub(crate) enum AssignTarget {
    Compiled(Location),
    /// Code that stores a value there.
    Foreign(Arc<Code>),
}

/// `<invoke>`
#[derive(Clone, Debug)]
pub(crate) struct Invoke {
    /// The attribute `id`.
    pub(crate) id: Option<Arc<str>>,
    /// The location that receives a generated id.
    pub(crate) id_location: Option<AssignTarget>,
    pub(crate) kind: Option<Attribute>,
    pub(crate) source: InvokeSource,
    pub(crate) name_list: Vec<Param>,
    pub(crate) params: Vec<Param>,
    pub(crate) auto_forward: bool,
    pub(crate) finalize: Option<Block>,
    pub(crate) span: SourceSpan,
}

/// The machine that an `<invoke>` starts.
#[derive(Clone, Debug)]
pub(crate) enum InvokeSource {
    /// A machine inside the file.
    Inline(Arc<Chart>),
    /// A file beside the machine's file.
    File(Source),
    /// A machine as text or XML.
    Computed(Expr),
    /// A machine that cannot be started, and why.
    Broken(Arc<str>),
}

#[derive(Clone, Debug)]
pub(crate) enum SendId {
    None,
    Literal(Arc<str>),
    /// The id is generated and stored there.
    Generated(AssignTarget),
}

#[derive(Clone, Debug)]
pub(crate) enum Delay {
    Literal(Duration),
    Computed(Expr),
}

/// The data that an event carries: `<param>`s or `<content>`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Payload {
    pub(crate) params: Vec<Param>,
    pub(crate) content: Option<Content>,
}

/// A `<param>`, or a word of a `namelist`.
#[derive(Clone, Debug)]
pub(crate) struct Param {
    pub(crate) name: Arc<str>,
    pub(crate) value: Expr,
    /// The location that receives a returned value, if the value is given by its location.
    pub(crate) location: Option<AssignTarget>,
    pub(crate) span: SourceSpan,
}

#[derive(Clone, Debug)]
pub(crate) enum Content {
    Computed(Expr, SourceSpan),
    Literal(Datum),
}

/// Calls `visit` with every action of a block, including those inside `<if>` and `<foreach>`.
pub(crate) fn visit_actions<'a>(block: &'a [Action], visit: &mut dyn FnMut(&'a Action)) {
    for action in block {
        visit(action);
        match &action.kind {
            ActionKind::If(branches) => branches.iter().for_each(|branch| visit_actions(&branch.content, visit)),
            ActionKind::Foreach(foreach) => visit_actions(&foreach.content, visit),
            _ => {}
        }
    }
}
