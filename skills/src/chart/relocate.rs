//! Maps positions in a translated machine to the text that its author wrote.
//!
//! A position that is not mapped would point to a wrong line. Therefore everything is taken apart completely, without
//! `..` and `_ =>`: a new field or kind of content does not compile until it is decided whether it has a position.

use std::ops::Range;

use diagnostics::{Problem, Source};
use miette::SourceSpan;

use super::content::{Action, ActionKind, Attribute, Block, Branch, Content, Foreach, Invoke, Named, Payload, Send};
use super::{Chart, Condition, DataItem, Descriptor, Initial, Param, State, Transition, range};

type RangeMap<'p> = &'p dyn Fn(Range<usize>) -> Range<usize>;

impl Chart {
    /// Makes `file` the machine's file, and maps all ranges by `map`. Machines inside this one stay as they are.
    pub(crate) fn relocate(&mut self, file: Source, map: RangeMap<'_>) {
        let Self {
            file: own_file,
            span,
            states,
            transitions,
            data,
            scripts,
            warnings,
            ids: _,
            binding: _,
            events: _,
            foreign: _,
            mentions: _,
            folder: _,
            strictness: _,
        } = self;
        *own_file = file;
        shift(span, map);
        data.iter_mut().for_each(|DataItem { id: _, init: _, span, top_level: _ }| shift(span, map));
        scripts.iter_mut().for_each(|script| block(script, map));
        states.iter_mut().for_each(|found| state(found, map));
        transitions.iter_mut().for_each(|found| transition(found, map));
        *warnings = warnings.drain(..).map(|problem| problem.moved(map)).collect();
        warnings.sort_by_key(Problem::offset);
    }
}

fn shift(span: &mut SourceSpan, map: RangeMap<'_>) {
    *span = map(range(*span)).into();
}

fn state(state: &mut State, map: RangeMap<'_>) {
    let State {
        span,
        extent,
        on_entry,
        on_exit,
        initial,
        invokes,
        done_data,
        id: _,
        kind: _,
        parent: _,
        last: _,
        children: _,
        histories: _,
        transitions: _,
        data: _,
        done_event: _,
    } = state;
    shift(span, map);
    shift(extent, map);
    on_entry.iter_mut().chain(on_exit).for_each(|content| block(content, map));
    initial.iter_mut().for_each(|Initial { targets: _, content }| block(content, map));
    invokes.iter_mut().for_each(|found| invoke(found, map));
    payload(done_data, map);
}

fn transition(transition: &mut Transition, map: RangeMap<'_>) {
    let Transition {
        span,
        descriptors,
        condition: guard,
        content,
        source: _,
        targets: _,
        chance: _,
        internal: _,
        domain: _,
    } = transition;
    shift(span, map);
    descriptors.iter_mut().for_each(|Descriptor { text: _, matches: _, span }| shift(span, map));
    guard.iter_mut().for_each(|found| condition(found, map));
    block(content, map);
}

fn condition(Condition { test: _, text: _, span }: &mut Condition, map: RangeMap<'_>) {
    shift(span, map);
}

fn block(block: &mut Block, map: RangeMap<'_>) {
    block.iter_mut().for_each(|found| action(found, map));
}

fn action(Action { kind, span }: &mut Action, map: RangeMap<'_>) {
    shift(span, map);
    match kind {
        ActionKind::Send(found) => send(found, map),
        ActionKind::If(branches) => branches.iter_mut().for_each(|Branch { condition: guard, content }| {
            guard.iter_mut().for_each(|found| condition(found, map));
            block(content, map);
        }),
        ActionKind::Foreach(foreach) => {
            let Foreach { array: _, item: _, index: _, content } = &mut **foreach;
            block(content, map);
        }
        // These have no range besides their action's.
        ActionKind::Raise { .. }
        | ActionKind::Cancel(_)
        | ActionKind::Assign(..)
        | ActionKind::Log { .. }
        | ActionKind::Script(_)
        | ActionKind::Foreign(_)
        | ActionKind::Fail(_) => {}
    }
}

fn send(send: &mut Send, map: RangeMap<'_>) {
    let Send { event, target, processor, id: _, delay: _, name_list, payload: data, span } = send;
    shift(span, map);
    [event, target, processor].into_iter().flatten().for_each(|found| attribute(found, map));
    name_list.iter_mut().for_each(|found| named(found, map));
    payload(data, map);
}

fn invoke(invoke: &mut Invoke, map: RangeMap<'_>) {
    let Invoke { id: _, id_location: _, kind, source: _, name_list, params, auto_forward: _, finalize, span } = invoke;
    shift(span, map);
    kind.iter_mut().for_each(|found| attribute(found, map));
    name_list.iter_mut().for_each(|found| named(found, map));
    params.iter_mut().for_each(|found| param(found, map));
    finalize.iter_mut().for_each(|content| block(content, map));
}

fn attribute(Attribute { source: _, span }: &mut Attribute, map: RangeMap<'_>) {
    shift(span, map);
}

fn named(Named { name: _, value: _, location: _, span }: &mut Named, map: RangeMap<'_>) {
    shift(span, map);
}

fn param(Param { name: _, value: _, location: _, span }: &mut Param, map: RangeMap<'_>) {
    shift(span, map);
}

fn payload(Payload { params, content }: &mut Payload, map: RangeMap<'_>) {
    params.iter_mut().for_each(|found| param(found, map));
    match content {
        Some(Content::Computed(_, span)) => shift(span, map),
        Some(Content::Literal(_)) | None => {}
    }
}
