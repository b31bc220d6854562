//! Maps positions in a translated machine to the text that its author wrote.

use std::ops::Range;

use diagnostics::{Problem, Source};
use miette::SourceSpan;

use super::content::{Action, ActionKind, Attribute, Block, Branch, Content, Payload, Send};
use super::{Chart, Descriptor, State, Transition, range};

/// The map of ranges.
type Place<'p> = &'p dyn Fn(Range<usize>) -> Range<usize>;

impl Chart {
    /// Makes `file` the machine's file, and maps all ranges by `place`. Machines inside this one stay as they are.
    pub(crate) fn relocate(&mut self, file: Source, place: Place<'_>) {
        self.file = file;
        shift(&mut self.span, place);
        self.data.iter_mut().for_each(|item| shift(&mut item.span, place));
        self.scripts.iter_mut().for_each(|script| block(script, place));
        self.states.iter_mut().for_each(|found| state(found, place));
        self.transitions.iter_mut().for_each(|found| transition(found, place));
        self.warnings = self.warnings.drain(..).map(|problem| problem.moved(place)).collect();
        self.warnings.sort_by_key(Problem::offset);
    }
}

fn shift(span: &mut SourceSpan, place: Place<'_>) {
    *span = place(range(*span)).into();
}

fn state(state: &mut State, place: Place<'_>) {
    shift(&mut state.span, place);
    shift(&mut state.extent, place);
    state.on_entry.iter_mut().chain(&mut state.on_exit).for_each(|content| block(content, place));
    state.initial.iter_mut().for_each(|initial| block(&mut initial.content, place));
    payload(&mut state.done_data, place);
}

fn transition(transition: &mut Transition, place: Place<'_>) {
    shift(&mut transition.span, place);
    transition.descriptors.iter_mut().for_each(|Descriptor { span, .. }| shift(span, place));
    transition.condition.iter_mut().for_each(|condition| shift(&mut condition.span, place));
    block(&mut transition.content, place);
}

fn block(block: &mut Block, place: Place<'_>) {
    block.iter_mut().for_each(|found| action(found, place));
}

fn action(action: &mut Action, place: Place<'_>) {
    shift(&mut action.span, place);
    match &mut action.kind {
        ActionKind::Send(found) => send(found, place),
        ActionKind::If(branches) => branches.iter_mut().for_each(|Branch { condition, content }| {
            condition.iter_mut().for_each(|condition| shift(&mut condition.span, place));
            block(content, place);
        }),
        ActionKind::Foreach(foreach) => block(&mut foreach.content, place),
        // These have no range besides their action's. The list is complete, so that a kind with ranges of its own
        // cannot be forgotten: its problems would point to a wrong line.
        ActionKind::Raise { .. }
        | ActionKind::Cancel(_)
        | ActionKind::Assign(..)
        | ActionKind::Log { .. }
        | ActionKind::Script(_)
        | ActionKind::Foreign(_)
        | ActionKind::Fail(_) => {}
    }
}

fn send(send: &mut Send, place: Place<'_>) {
    shift(&mut send.span, place);
    let Send { event, target, processor, .. } = send;
    let attributes = [event, target, processor].into_iter().flatten();
    attributes.for_each(|Attribute { span, .. }| shift(span, place));
    send.name_list.iter_mut().for_each(|named| shift(&mut named.span, place));
    payload(&mut send.payload, place);
}

fn payload(payload: &mut Payload, place: Place<'_>) {
    payload.params.iter_mut().for_each(|param| shift(&mut param.span, place));
    match &mut payload.content {
        Some(Content::Computed(_, span)) => shift(span, place),
        Some(Content::Literal(_)) | None => {}
    }
}
