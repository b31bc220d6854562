//! Invoked machines (SCXML 6.4): they live inside the machine that invoked them, and run when it is at rest.

use std::sync::Arc;

use super::macrostep::{Macrostep, OuterEvent, OuterSessions};
use super::{Event, Host, Invoked, MAX_WAITING, Machine, Note, Outgoing, Queued, Status, Undelivered, no_room};
use crate::Datum;
use crate::chart::{Chart, INVOKE_KINDS, Invoke, InvokeSource};
use crate::ids::StateId;

/// The maximum number of machines in a family; machines that invoke themselves would exceed it. Chosen, not
/// measured.
const MAX_SESSIONS: usize = 256;
/// The maximum depth of invocations: each level runs on the stack of the one around it. Chosen, not measured.
const MAX_GENERATIONS: u32 = 16;

impl Machine {
    /// Accepts an event from another machine, if there is room for it.
    pub(super) fn admit(&mut self, event: Event) -> Result<(), String> {
        if !self.has_room() {
            return Err(no_room());
        }
        self.enqueue(event);
        Ok(())
    }

    /// Puts an event into the external queue.
    pub(super) fn enqueue(&mut self, event: Event) {
        if self.status == Status::Running {
            let class = self.chart.events.class(&event.name);
            self.events.external.push_back(Queued { event, class });
        }
    }

    /// Whether an event waits for it, or for a machine inside it.
    fn has_work(&self) -> bool {
        self.status == Status::Running && !self.events.external.is_empty()
            || self.invoked.iter().any(|invoked| invoked.machine.has_work())
    }

    /// The machine with this session, if it is inside this one.
    pub(super) fn descendant(&mut self, session: &str) -> Option<&mut Self> {
        let mut running = self.invoked.iter_mut().filter(|invoked| invoked.machine.status == Status::Running);
        running.find_map(
            |Invoked { machine, .. }| {
                if &*machine.session.id == session { Some(machine) } else { machine.descendant(session) }
            },
        )
    }

    fn descendants(&self, sessions: &mut Vec<Arc<str>>) {
        for (_, machine) in self.invoked() {
            sessions.push(Arc::clone(&machine.session.id));
            machine.descendants(sessions);
        }
    }

    /// The invoked machines that still run, each with its id.
    pub fn invoked(&self) -> impl Iterator<Item = (&str, &Self)> {
        let running = self.invoked.iter().filter(|invoked| invoked.machine.status == Status::Running);
        running.map(|invoked| (&*invoked.id, &invoked.machine))
    }
}

impl Macrostep<'_, '_> {
    /// Starts the machines that the entered states invoke, in document order.
    pub(super) fn invoke_all(&mut self) {
        let mut from = 0;
        while let Some(state) = self.machine.to_invoke.next_from(from) {
            from = state + 1;
            self.machine.to_invoke.remove(state);
            for (index, invoke) in self.chart.states[state].invokes.iter().enumerate() {
                match self.prepare(StateId::new(state), index, invoke) {
                    Ok(invoked) => {
                        self.machine.invoked.push(invoked);
                        self.with_child(self.machine.invoked.len() - 1, |run| run.start());
                    }
                    Err(Some(reason)) => self.fail(reason, invoke.span, None),
                    Err(None) => {}
                }
            }
        }
    }

    /// The machine to start. Without one, the reason, unless it is in the queue already.
    fn prepare(&mut self, state: StateId, index: usize, invoke: &Invoke) -> Result<Invoked, Option<String>> {
        self.steps.begin();
        let kind = self.attribute(invoke.kind.as_ref())?;
        if let Some(kind) = kind.filter(|kind| !INVOKE_KINDS.contains(&&**kind)) {
            return Err(Some(format!("unknown service type `{kind}`")));
        }
        let chart = self.invoked_chart(&invoke.source)?;
        let mut given = Vec::new();
        for named in &invoke.name_list {
            let value = self.evaluate(&named.value).map_err(|error| error.to_string())?;
            given.push((Arc::clone(&named.name), value));
        }
        for param in &invoke.params {
            if let Ok(value) = self.value(&param.value, param.span) {
                given.push((Arc::clone(&param.name), value));
            }
        }
        let id = self.invoke_id(state, invoke)?;
        let machine = self.child(chart, &id, given)?;
        Ok(Invoked { state, index, id, machine })
    }

    fn invoke_id(&mut self, state: StateId, invoke: &Invoke) -> Result<Arc<str>, Option<String>> {
        if let Some(id) = &invoke.id {
            return Ok(Arc::clone(id));
        }
        self.machine.generated_ids += 1;
        let id: Arc<str> = format!("{}.{}", self.chart.state(state).id(), self.machine.generated_ids).into();
        if let Some(place) = &invoke.id_location {
            self.assign(place, Datum::Text(Arc::clone(&id)), invoke.span).map_err(|_| None)?;
        }
        Ok(id)
    }

    fn invoked_chart(&mut self, source: &InvokeSource) -> Result<Arc<Chart>, String> {
        match source {
            InvokeSource::Inline(chart) => Ok(Arc::clone(chart)),
            InvokeSource::File(address) => {
                let address = self.source(address)?;
                self.chart.beside(&address)
            }
            InvokeSource::Computed(expr) => match self.evaluate(expr).map_err(|error| error.to_string())? {
                Datum::Text(text) | Datum::Xml(text) => self.chart.computed(&text),
                other => Err(format!("{other} is not a machine")),
            },
            InvokeSource::Broken(reason) => Err(reason.to_string()),
        }
    }

    fn child(&mut self, chart: Arc<Chart>, id: &Arc<str>, given: Vec<(Arc<str>, Datum)>) -> Result<Machine, String> {
        let mut sessions = self.outer.outside.to_vec();
        self.machine.descendants(&mut sessions);
        if sessions.len() >= MAX_SESSIONS || self.machine.generation >= MAX_GENERATIONS {
            return Err("too many machines invoke each other".to_owned());
        }
        self.machine.children += 1;
        let mut machine = Machine::new(chart);
        machine.set_session(&format!("{}.{}", self.machine.session.id, self.machine.children));
        machine.generation = self.machine.generation + 1;
        machine.under = Some(Arc::clone(id));
        for (name, value) in given {
            let known = machine.chart.find_data(&name).filter(|data| machine.chart.data[data.index()].top_level);
            machine.given.extend(known.map(|data| (data, value)));
        }
        Ok(machine)
    }

    /// Lets one of the machines inside process its next event; false if none waits.
    pub(super) fn run_children(&mut self) -> bool {
        let waiting = self.machine.invoked.iter().position(|invoked| invoked.machine.has_work());
        if let Some(index) = waiting {
            self.with_child(index, |run| run.until_rest());
        }
        waiting.is_some()
    }

    /// Delivers the delayed events that are due next, here or inside, and comes to rest.
    pub(super) fn fire_next(&mut self) {
        let due = self.machine.next_timer();
        if self.machine.events.timers.first().map(|timer| timer.due) == due {
            if due.is_some() {
                let timer = self.machine.events.timers.remove(0);
                self.deliver(timer.delivery);
            }
        } else if let Some(index) = self.machine.invoked.iter().position(|inner| inner.machine.next_timer() == due) {
            self.with_child(index, |run| run.fire_next());
        }
        self.until_rest();
    }

    /// Runs a machine inside, forwards what it sends, and notices its end.
    fn with_child(&mut self, index: usize, act: impl FnOnce(&mut Macrostep<'_, '_>)) {
        let mut invoked = self.machine.invoked.remove(index);
        let events = self.run_child(&mut invoked, act);
        let (id, status) = (Arc::clone(&invoked.id), invoked.machine.status);
        let (result, span) = (invoked.machine.result.clone(), self.invoke(&invoked).span);
        self.machine.invoked.insert(index, invoked);
        for event in events {
            self.pass_on(event, &id);
        }
        match status {
            Status::Done => {
                let event = Event::external(format!("done.invoke.{id}")).with_data(result);
                self.machine.enqueue(Event { invoke_id: Some(id), ..event });
            }
            Status::Stuck => {
                self.raise_error(
                    "error.communication",
                    format!("{id} did not come to rest and was stopped"),
                    // The invoked machine has a note of it.
                    true,
                    span,
                    None,
                );
            }
            Status::Ready | Status::Running => {}
        }
    }

    fn run_child(&mut self, invoked: &mut Invoked, act: impl FnOnce(&mut Macrostep<'_, '_>)) -> Vec<OuterEvent> {
        let mut outside = self.outer.outside.to_vec();
        outside.push(Arc::clone(&self.machine.session.id));
        self.machine.descendants(&mut outside);
        let chart = Arc::clone(&invoked.machine.chart);
        let mut host = Inside { id: &invoked.id, host: self.host };
        let room_here = MAX_WAITING.saturating_sub(self.machine.events.external.len());
        let room = self.outer.room.saturating_sub(self.outer.events.len()).min(room_here);
        let outer = OuterSessions { outside: &outside, events: Vec::new(), room };
        let (machine, now, steps) = (&mut invoked.machine, self.now, self.steps);
        let mut run = Macrostep { chart: &chart, machine, now, host: &mut host, outer, steps };
        act(&mut run);
        run.outer.events
    }

    /// Delivers an event from a machine inside.
    fn pass_on(&mut self, event: OuterEvent, sender: &Arc<str>) {
        match event {
            OuterEvent::Parent(event) => self.machine.enqueue(Event { invoke_id: Some(Arc::clone(sender)), ..event }),
            OuterEvent::Session(session, event) if session == self.machine.session.id => self.machine.enqueue(event),
            OuterEvent::Session(session, event) => match self.machine.descendant(&session) {
                Some(machine) => machine.enqueue(event),
                None => self.outer.events.push(OuterEvent::Session(session, event)),
            },
        }
    }

    /// Ends the machines that a state has invoked; their further events to this machine are dropped.
    pub(super) fn cancel_invoked(&mut self, state: StateId) {
        while let Some(index) = self.machine.invoked.iter().position(|invoked| invoked.state == state) {
            let mut invoked = self.machine.invoked.remove(index);
            if invoked.machine.status != Status::Running {
                continue;
            }
            let id = Arc::clone(&invoked.id);
            for event in self.run_child(&mut invoked, |run| run.exit_interpreter()) {
                if matches!(event, OuterEvent::Session(..)) {
                    self.pass_on(event, &id);
                }
            }
        }
    }

    fn invoke(&self, invoked: &Invoked) -> &Invoke {
        &self.chart.state(invoked.state).invokes[invoked.index]
    }

    /// Handles an external event before transitions are selected: finalizes it if it comes from an invoked machine, and
    /// forwards it to the machines with `autoforward`.
    pub(super) fn finalize_and_forward(&mut self, event: &Event) {
        let chart = self.chart;
        for place in 0..self.machine.invoked.len() {
            let Some(Invoked { state, index, id, .. }) = self.machine.invoked.get(place) else {
                return;
            };
            let invoke = &chart.state(*state).invokes[*index];
            let comes_from_it = event.invoke_id.as_ref() == Some(id);
            if comes_from_it {
                self.finalize(invoke, event);
            }
            if invoke.auto_forward
                && let Some(invoked) = self.machine.invoked.get_mut(place)
            {
                invoked.machine.enqueue(event.clone());
            }
        }
    }

    /// An empty `<finalize>` assigns the returned values to the names that were sent (SCXML 6.5.2).
    fn finalize(&mut self, invoke: &Invoke, event: &Event) {
        let Some(block) = &invoke.finalize else {
            return;
        };
        self.execute(block);
        if !block.is_empty() {
            return;
        }
        for param in invoke.name_list.iter().chain(&invoke.params) {
            if let (Some(place), Some(value)) = (&param.location, event.data.member(&param.name)) {
                // An error is in the queue already.
                let _ = self.assign(place, value.clone(), param.span);
            }
        }
    }
}

/// The environment of an invoked machine.
struct Inside<'h> {
    id: &'h Arc<str>,
    host: &'h mut dyn Host,
}

impl Host for Inside<'_> {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        self.host.send(outgoing)
    }

    fn note(&mut self, note: Note) {
        self.host.note(Note::Invoked { id: Arc::clone(self.id), note: Box::new(note) });
    }
}
