//! What the data of a machine and those inside it may hold: the smallest sets that agree with everything that the
//! machines do.

use std::sync::Arc;
use std::time::Duration;

use channels::Possible;
use miette::SourceSpan;

use super::evaluate::{MachineWalk, binary, of_datum};
use super::family::Family;
use super::sources::{PassedText, TextSources, TextUse};
use super::trigger::Trigger;
use crate::chart::{
    Action, ActionKind, AssignTarget, Attribute, Block, CHANNEL_PROCESSOR, Content, Delay, Invoke, InvokeSource,
    Payload, Send, Source, visit_actions,
};
use crate::expression::{Expr, Location, Statement};
use crate::ids::DataId;
use crate::{Chart, Datum};

impl Chart {
    /// What the machine, and those inside it, may do with texts in any run.
    #[must_use]
    pub fn text_use(&self, sources: TextSources<'_>) -> TextUse {
        let mut family = Family::of(self, sources);
        while family.take_changed() {
            for number in 0..family.charts.len() {
                MachineWalk { chart: family.charts[number], number, family: &mut family }.walk();
            }
        }
        family.into_text_use()
    }
}

impl<'a> MachineWalk<'_, 'a> {
    fn hold(&mut self, data: DataId, value: &Possible) {
        self.family.hold(self.number, data, value);
    }

    fn walk(&mut self) {
        self.begin();
        let any = Trigger::any();
        for block in self.chart.scripts.iter() {
            self.block(block, &any);
        }
        for state in &self.chart.states {
            let initial = state.initial.as_ref().map(|initial| &initial.content);
            let finalize = state.invokes.iter().filter_map(|invoke| invoke.finalize.as_ref());
            for block in state.on_entry.iter().chain(&state.on_exit).chain(initial).chain(finalize) {
                self.block(block, &any);
            }
            state.invokes.iter().for_each(|invoke| self.invoke(invoke));
            for (name, value, _) in self.payload(&state.done_data, state.span, &any) {
                self.family.send_inside(None, name, value);
            }
        }
        for transition in &self.chart.transitions {
            let trigger = Trigger::of(&transition.descriptors);
            if let Some(condition) = &transition.condition {
                self.value(&condition.test, &trigger, condition.span);
            }
            self.block(&transition.content, &trigger);
        }
    }

    /// The values that data have without anything being done.
    fn begin(&mut self) {
        let sources = self.family.sources;
        for (index, item) in self.chart.data.iter().enumerate() {
            let data = DataId::new(index);
            if let Some(init) = &item.init {
                let value = self.value(init, &Trigger::any(), item.span);
                self.hold(data, &value);
            }
            if self.number == 0 {
                for (_, value) in sources.given.iter().filter(|(id, _)| *id == &*item.id) {
                    self.hold(data, &of_datum(value));
                }
                if let Some(value) = sources.ports.get(&*item.id) {
                    self.hold(data, value);
                }
            } else if item.top_level {
                // The machine that invokes this one may set it.
                let given = self.family.fields(&Trigger::any(), Some(&item.id));
                self.hold(data, &given);
            }
            if self.chart.foreign.contains(&data) {
                self.hold(data, &Possible::anything());
            }
        }
    }

    fn block(&mut self, block: &'a Block, trigger: &Trigger<'_>) {
        visit_actions(block, &mut |action| self.action(action, trigger));
    }

    fn action(&mut self, Action { kind, span }: &'a Action, trigger: &Trigger<'_>) {
        match kind {
            ActionKind::Assign(AssignTarget::Compiled(location), value) => {
                let value = self.value(value, trigger, *span);
                self.assign(location, value, trigger, *span);
            }
            ActionKind::Assign(AssignTarget::Foreign(_), value) => {
                let value = self.value(value, trigger, *span);
                self.keep_out(&value, |name| format!("passes {name} to code for the engine"), *span);
            }
            ActionKind::If(branches) => {
                for condition in branches.iter().filter_map(|branch| branch.condition.as_ref()) {
                    self.value(&condition.test, trigger, condition.span);
                }
            }
            ActionKind::Foreach(foreach) => {
                let items = self.value(&foreach.array, trigger, *span).part();
                self.hold(foreach.item, &items);
                foreach.index.iter().for_each(|index| self.hold(*index, &Possible::number()));
            }
            ActionKind::Script(statements) => {
                for statement in statements {
                    match statement {
                        Statement::Assign(location, value) => {
                            let value = self.value(value, trigger, *span);
                            self.assign(location, value, trigger, *span);
                        }
                        Statement::Update(location, op, value) => {
                            let old = self.value(&location.to_expr(), trigger, *span);
                            let by = self.value(value, trigger, *span);
                            let new = binary(self, *op, &old, &by, *span);
                            self.assign(location, new, trigger, *span);
                        }
                        Statement::Evaluate(value) => _ = self.value(value, trigger, *span),
                    }
                }
            }
            ActionKind::Foreign(code) => _ = self.value(&Expr::Foreign(Arc::clone(code)), trigger, *span),
            ActionKind::Send(send) => self.send(send, trigger),
            ActionKind::Cancel(Source::Computed(id)) => {
                let id = self.value(id, trigger, *span);
                self.keep_out(&id, |name| format!("takes the id of an event from {name}"), *span);
            }
            // Logged values are only reported.
            ActionKind::Log { .. } | ActionKind::Raise { .. } | ActionKind::Cancel(_) | ActionKind::Fail(_) => {}
        }
    }

    fn assign(&mut self, location: &Location, value: Possible, trigger: &Trigger<'_>, place: SourceSpan) {
        let whole = location.to_expr();
        if let Expr::Data(data) = whole {
            return self.hold(data, &value);
        }
        self.indices(&whole, trigger, place);
        self.hold(location.data, &value.around());
    }

    fn indices(&mut self, location: &Expr, trigger: &Trigger<'_>, place: SourceSpan) {
        match location {
            Expr::Member(of, _) => self.indices(of, trigger, place),
            Expr::Index(parts) => {
                let index = self.value(&parts[1], trigger, place);
                self.keep_out(&index, |name| format!("takes the name of a member from {name}"), place);
                self.indices(&parts[0], trigger, place);
            }
            _ => {}
        }
    }

    /// The value of an attribute of an event, which no chosen text may be.
    fn attribute(&mut self, attribute: Option<&Attribute>, of: &str, trigger: &Trigger<'_>) {
        if let Some(Attribute { source: Source::Computed(value), span }) = attribute {
            let value = self.value(value, trigger, *span);
            self.keep_out(&value, |name| format!("takes the {of} of an event from {name}"), *span);
        }
    }

    fn send(&mut self, send: &'a Send, trigger: &Trigger<'_>) {
        self.attribute(send.event.as_ref(), "name", trigger);
        self.attribute(send.target.as_ref(), "target", trigger);
        self.attribute(send.processor.as_ref(), "processor", trigger);
        if let Delay::Computed(delay) = &send.delay {
            let delay = self.value(delay, trigger, send.span);
            self.keep_out(&delay, |name| format!("takes the delay of an event from {name}"), send.span);
        }
        let mut fields = self.payload(&send.payload, send.span, trigger);
        for named in &send.name_list {
            let value = self.value(&named.value, trigger, named.span);
            fields.push((Some(Arc::clone(&named.name)), value, named.span));
        }
        if !matches!(send.delay, Delay::Literal(Duration::ZERO)) {
            // It is kept until then, and any number of such events may be waiting.
            for (_, value, place) in &fields {
                self.keep_out(value, |name| format!("keeps {name} in an event with a delay"), *place);
            }
        }
        let literal = |attribute: &Option<Attribute>| attribute.as_ref().and_then(Attribute::literal).cloned();
        let head = literal(&send.event);
        let processor = literal(&send.processor);
        let by_channel = processor.as_deref() == Some(CHANNEL_PROCESSOR);
        // Without a processor, it is SCXML's own. One that is computed may be any.
        let stays = !by_channel && (processor.is_some() || send.processor.is_none());
        for (field, value, _) in fields {
            if !by_channel {
                self.family.send_inside(head.clone(), field.clone(), value.clone());
            }
            if !stays {
                let target = literal(&send.target);
                self.family.pass(PassedText { target, head: head.clone(), field, value });
            }
        }
    }

    /// The fields of the data: each with its name, if that is known.
    fn payload(
        &mut self,
        payload: &'a Payload,
        place: SourceSpan,
        trigger: &Trigger<'_>,
    ) -> Vec<(Option<Arc<str>>, Possible, SourceSpan)> {
        let mut fields = Vec::new();
        for param in &payload.params {
            let value = self.value(&param.value, trigger, param.span);
            fields.push((Some(Arc::clone(&param.name)), value, param.span));
        }
        match &payload.content {
            Some(Content::Computed(Expr::Object(members), place)) => {
                for (name, value) in members {
                    let value = self.value(value, trigger, *place);
                    fields.push((Some(Arc::clone(name)), value, *place));
                }
            }
            Some(Content::Computed(value, place)) => {
                let value = self.value(value, trigger, *place).part();
                fields.push((None, value, *place));
            }
            Some(Content::Literal(Datum::Object(object))) => {
                let members = object.members().map(|(name, value)| (Some(name.into()), of_datum(value), place));
                fields.extend(members);
            }
            Some(Content::Literal(value)) => fields.push((None, of_datum(value), place)),
            None => {}
        }
        fields
    }

    fn invoke(&mut self, invoke: &'a Invoke) {
        let any = Trigger::any();
        let mut given = Vec::new();
        for param in invoke.params.iter().chain(&invoke.name_list) {
            let value = self.value(&param.value, &any, param.span);
            given.push((Arc::clone(&param.name), value));
        }
        let is_inside = matches!(invoke.source, InvokeSource::Inline(_));
        if let InvokeSource::Computed(source) | InvokeSource::File(Source::Computed(source)) = &invoke.source {
            let source = self.value(source, &any, invoke.span);
            self.keep_out(&source, |name| format!("takes a machine from {name}"), invoke.span);
        }
        for (name, value) in given {
            if is_inside {
                self.family.send_inside(None, Some(name), value);
            } else {
                self.keep_out(&value, |name| format!("passes {name} to a machine in another file"), invoke.span);
            }
        }
        if invoke.auto_forward && !is_inside {
            let all = self.family.fields(&any, None);
            self.keep_out(&all, |name| format!("forwards {name} to a machine in another file"), invoke.span);
        }
    }
}
