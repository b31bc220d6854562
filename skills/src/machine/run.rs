//! The main loop: macrosteps out of microsteps.

use std::sync::Arc;
use std::time::Duration;

use super::{Event, EventKind, Host, Machine, Note, Queued, Status};
use crate::Datum;
use crate::chart::{Binding, BitSet, Chart, DataId, EventClass, StateId};
use crate::expression::Scope;
use crate::problem::Span;

/// A machine that has not come to rest after so many microsteps runs in circles.
const MAX_MICROSTEPS: u32 = 10_000;

/// A machine on its way to its next rest.
pub(super) struct Run<'c, 'm> {
    pub(super) chart: &'c Chart,
    pub(super) machine: &'m mut Machine,
    pub(super) now: Duration,
    pub(super) host: &'m mut dyn Host,
}

impl<'c, 'm> Run<'c, 'm> {
    pub(super) fn new(chart: &'c Chart, machine: &'m mut Machine, now: Duration, host: &'m mut dyn Host) -> Self {
        Self { chart, machine, now, host }
    }

    /// The procedure `interpret` of Appendix D up to its first rest.
    pub(super) fn start(&mut self) {
        self.machine.status = Status::Running;
        self.initialise_all();
        for script in &self.chart.scripts {
            self.execute(script);
        }
        self.enter_initially();
        self.until_rest();
    }

    /// Takes events until there are none left (mainEventLoop).
    pub(super) fn until_rest(&mut self) {
        let mut microsteps = 0;
        while self.machine.status == Status::Running && self.next_microstep() {
            microsteps += 1;
            if microsteps == MAX_MICROSTEPS {
                self.host.note(Note::Stuck { microsteps });
                self.machine.status = Status::Stuck;
                self.drop_events();
            }
        }
        if self.machine.status == Status::Done {
            self.exit_interpreter();
        }
    }

    /// Takes the transitions that are enabled without an event, or else by the next event, internal ones first.
    /// False if there is nothing left to do.
    fn next_microstep(&mut self) -> bool {
        self.select(None);
        if self.machine.scratch.enabled.is_empty() {
            let Some(next) = self.machine.internal.pop_front().or_else(|| self.machine.external.pop_front()) else {
                return false;
            };
            self.machine.event = Some(next.event);
            self.select(Some(next.class));
            self.note_unhandled();
        }
        if !self.machine.scratch.enabled.is_empty() {
            self.microstep();
        }
        true
    }

    fn note_unhandled(&mut self) {
        let machine = &*self.machine;
        if let Some(event) = machine.event.as_ref().filter(|event| event.kind == EventKind::Platform)
            && machine.scratch.enabled.is_empty()
            && event.name.starts_with("error.")
        {
            self.host.note(Note::UnhandledError { event: Arc::clone(&event.name) });
        }
    }

    /// Runs the exit handlers of all active states (exitInterpreter). The configuration stays to be looked at.
    fn exit_interpreter(&mut self) {
        let ended_in = self.machine.configuration.clone();
        let mut limit = self.chart.states.len();
        while let Some(state) = self.machine.configuration.last_below(limit) {
            for block in &self.chart.states[state].on_exit {
                self.execute(block);
            }
            self.machine.configuration.remove(state);
            limit = state;
        }
        self.machine.configuration = ended_in;
        self.drop_events();
    }

    /// A machine at its end has nothing to come.
    fn drop_events(&mut self) {
        self.machine.internal.clear();
        self.machine.external.clear();
        self.machine.timers.clear();
    }

    /// Gives the data their first values: all of them with early binding, those of the machine with late binding.
    pub(super) fn initialise_all(&mut self) {
        match self.chart.binding {
            Binding::Early => (0..self.chart.data.len()).for_each(|index| self.initialise(DataId::new(index))),
            Binding::Late => self.initialise_state(StateId::ROOT),
        }
    }

    /// Gives a state's data their first values when it is entered for the first time (late binding).
    pub(super) fn initialise_state(&mut self, state: StateId) {
        if !self.machine.initialised.contains(state.index()) {
            self.machine.initialised.insert(state.index());
            self.chart.state(state).data.iter().for_each(|data| self.initialise(*data));
        }
    }

    fn initialise(&mut self, id: DataId) {
        let item = &self.chart.data[id.index()];
        let given = self.machine.given.iter().rev().find(|(data, _)| *data == id);
        let value = match (given, &item.init) {
            (Some((_, value)), _) => value.clone(),
            (None, None) => return,
            (None, Some(expr)) => match expr.evaluate(&self.scope()) {
                Ok(value) => value,
                Err(error) => {
                    self.fail(format!("{} has no value: {error}", item.id), item.span, None);
                    Datum::Undefined
                }
            },
        };
        self.machine.data[id.index()] = value;
    }

    /// What expressions see now.
    pub(super) fn scope(&self) -> Scope<'_> {
        Scope {
            chart: Some(self.chart),
            session: &self.machine.session.id,
            configuration: Some(&self.machine.configuration),
            data: &self.machine.data,
            event: self.machine.event.as_ref(),
        }
    }

    pub(super) fn is_active(&self, state: StateId) -> bool {
        self.machine.configuration.contains(state.index())
    }

    /// What a history state remembers.
    pub(super) fn remembered(&self, history: StateId) -> Option<&BitSet> {
        self.machine.remembered.get(history.index())?.as_ref()
    }

    pub(super) fn raise(&mut self, event: Event, class: EventClass) {
        self.machine.internal.push_back(Queued { event, class });
    }

    /// Puts `error.execution` into the internal queue.
    pub(super) fn fail(&mut self, reason: String, span: Span, send_id: Option<Arc<str>>) {
        self.raise_error("error.execution", reason, span, send_id);
    }

    pub(super) fn raise_error(&mut self, name: &'static str, reason: String, span: Span, send_id: Option<Arc<str>>) {
        let event = Event::new(name.into(), EventKind::Platform).with_data(Datum::text(&reason));
        let class = self.chart.events.class(name);
        self.raise(Event { send_id, ..event }, class);
        self.host.note(Note::Error { event: name, reason, span: span.into() });
    }
}
