//! The main loop: macrosteps consist of microsteps.

use std::sync::Arc;
use std::time::Duration;

use miette::SourceSpan;

use super::{Event, EventKind, Host, MAX_WAITING, Machine, Note, Queued, Status};
use crate::Datum;
use crate::bit_set::BitSet;
use crate::chart::{Binding, Chart, EventClass, StateKind, range};
use crate::datum::EvaluationError;
use crate::engine::World;
use crate::expression::Code;
use crate::expression::{Expr, Scope};
use crate::ids::{DataId, StateId};
use crate::steps::Steps;

/// A machine that has not come to rest after this many microsteps is stopped. More than twice [`MAX_WAITING`], so that
/// a full queue can be processed.
const MAX_MICROSTEPS: u32 = 10_000;

/// A machine on its way to its next rest.
pub(super) struct Macrostep<'c, 'm> {
    pub(super) chart: &'c Chart,
    pub(super) machine: &'m mut Machine,
    pub(super) now: Duration,
    pub(super) host: &'m mut dyn Host,
    pub(super) outer: OuterSessions<'m>,
    pub(super) steps: &'m Steps,
}

/// The machines around one that was invoked.
pub(super) struct OuterSessions<'k> {
    /// The sessions that are neither it nor inside it.
    pub(super) outside: &'k [Arc<str>],
    pub(super) events: Vec<OuterEvent>,
    /// The room that they have left.
    pub(super) room: usize,
}

pub(super) enum OuterEvent {
    Parent(Event),
    Session(Arc<str>, Event),
}

impl<'c, 'm> Macrostep<'c, 'm> {
    pub(super) fn new(
        chart: &'c Chart,
        machine: &'m mut Machine,
        now: Duration,
        host: &'m mut dyn Host,
        steps: &'m Steps,
    ) -> Self {
        Self {
            chart,
            machine,
            now,
            host,
            outer: OuterSessions { outside: &[], events: Vec::new(), room: MAX_WAITING },
            steps,
        }
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

    /// Processes events until none are left (mainEventLoop).
    pub(super) fn until_rest(&mut self) {
        let mut microsteps = 0;
        while self.machine.status == Status::Running && self.next_microstep() {
            microsteps += 1;
            if microsteps == MAX_MICROSTEPS || self.steps.are_over() {
                self.host.note(Note::Stuck { microsteps });
                self.machine.status = Status::Stuck;
                self.drop_events();
            }
        }
        if self.machine.status == Status::Done {
            self.exit_interpreter();
        }
    }

    /// Takes the transitions that are enabled without an event, or else by the next event, internal events first.
    /// Returns false if nothing is left to do.
    fn next_microstep(&mut self) -> bool {
        self.steps.begin();
        self.select(None);
        if self.machine.scratch.enabled.is_empty() {
            if let Some(next) = self.machine.events.internal.pop_front() {
                self.machine.events.set_last(next.event);
                self.select(Some(next.class));
                self.note_unhandled();
            } else if self.machine.to_invoke.next_from(0).is_some() {
                self.invoke_all();
            } else if self.run_children() {
                return true;
            } else if let Some(next) = self.machine.events.external.pop_front() {
                self.take_external(next);
            } else {
                return false;
            }
        }
        if !self.machine.scratch.enabled.is_empty() {
            self.microstep();
        }
        true
    }

    fn take_external(&mut self, next: Queued) {
        if self.machine.invoked.is_empty() {
            self.machine.events.set_last(next.event);
        } else {
            self.machine.events.set_last(next.event.clone());
            self.finalize_and_forward(&next.event);
        }
        self.select(Some(next.class));
    }

    fn note_unhandled(&mut self) {
        let machine = &*self.machine;
        if let Some(event) = machine.events.last.as_ref().filter(|event| event.kind == EventKind::Platform)
            && machine.scratch.enabled.is_empty()
            && event.name.starts_with("error.")
        {
            self.host.note(Note::UnhandledError { event: Arc::clone(&event.name) });
        }
    }

    /// Runs the exit handlers of all active states (exitInterpreter). The configuration is kept for inspection.
    pub(super) fn exit_interpreter(&mut self) {
        let ended_in = self.machine.configuration.clone();
        let mut limit = self.chart.states.len();
        while let Some(state) = self.machine.configuration.last_below(limit) {
            for block in &self.chart.states[state].on_exit {
                self.execute(block);
            }
            self.cancel_invoked(StateId::new(state));
            let particulars = &self.chart.states[state];
            if particulars.kind == StateKind::Final && particulars.parent == Some(StateId::ROOT) {
                self.machine.result = self.payload(&particulars.done_data);
            }
            self.machine.configuration.remove(state);
            limit = state;
        }
        self.machine.configuration = ended_in;
        self.drop_events();
    }

    /// Nothing can reach a machine that has ended.
    fn drop_events(&mut self) {
        self.machine.events.clear();
        self.machine.to_invoke.clear();
        self.machine.invoked.clear();
    }

    /// Initializes the data: all of them with early binding, those of the machine with late binding.
    pub(super) fn initialise_all(&mut self) {
        match self.chart.binding {
            Binding::Early => (0..self.chart.data.len()).for_each(|index| self.initialise(DataId::new(index))),
            Binding::Late => self.initialise_state(StateId::ROOT),
        }
    }

    /// Initializes a state's data when it is entered for the first time (late binding).
    pub(super) fn initialise_state(&mut self, state: StateId) {
        if !self.machine.initialised.contains(state.index()) {
            self.machine.initialised.insert(state.index());
            self.chart.state(state).data.iter().for_each(|data| self.initialise(*data));
        }
    }

    fn initialise(&mut self, id: DataId) {
        self.steps.begin();
        let item = &self.chart.data[id.index()];
        let given = self.machine.given.iter().rev().find(|(data, _)| *data == id);
        let value = match (given, &item.init) {
            (Some((_, value)), _) => value.clone(),
            (None, None) => return,
            (None, Some(expr)) => match self.evaluate(expr) {
                Ok(value) => value,
                Err(error) => {
                    self.fail(format!("{} has no value: {error}", item.id), item.span, None);
                    Datum::Undefined
                }
            },
        };
        self.machine.data.set(id, value);
    }

    /// The value of an expression.
    pub(super) fn evaluate(&mut self, expr: &Expr) -> Result<Datum, EvaluationError> {
        match expr {
            Expr::Foreign(code) => self.run_code(code, None),
            expr => expr.evaluate(&self.scope()),
        }
    }

    /// Runs a piece of code in the engine.
    pub(super) fn run_code(&mut self, code: &Code, argument: Option<&Datum>) -> Result<Datum, EvaluationError> {
        let machine = &mut *self.machine;
        let scope = Scope {
            ids: Some(&self.chart.ids),
            session: &machine.session.id,
            configuration: Some(&machine.configuration),
            data: &[],
            event: machine.events.last.as_ref(),
            event_object: Some(&machine.events.last_object),
            io_processors: Some(&machine.session.io_processors),
            steps: Some(self.steps),
        };
        let (memory, random) = (&mut machine.data, &mut machine.random.position);
        let mut world = World { scope, memory, now: self.now, random, steps: self.steps };
        code.run(&mut world, argument)
    }

    /// The current scope of expressions.
    pub(super) fn scope(&self) -> Scope<'_> {
        Scope {
            ids: Some(&self.chart.ids),
            session: &self.machine.session.id,
            configuration: Some(&self.machine.configuration),
            data: &self.machine.data,
            event: self.machine.events.last.as_ref(),
            event_object: Some(&self.machine.events.last_object),
            io_processors: Some(&self.machine.session.io_processors),
            steps: Some(self.steps),
        }
    }

    pub(super) fn is_active(&self, state: StateId) -> bool {
        self.machine.configuration.contains(state.index())
    }

    pub(super) fn remembered(&self, history: StateId) -> Option<&BitSet> {
        self.machine.remembered.get(history.index())?.as_ref()
    }

    pub(super) fn raise(&mut self, event: Event, class: EventClass) {
        self.machine.events.internal.push_back(Queued { event, class });
    }

    /// Puts `error.execution` into the internal queue.
    pub(super) fn fail(&mut self, reason: String, span: SourceSpan, send_id: Option<Arc<str>>) {
        self.raise_error("error.execution", reason, false, span, send_id);
    }

    pub(super) fn raise_error(
        &mut self,
        name: &'static str,
        reason: String,
        is_harmless: bool,
        span: SourceSpan,
        send_id: Option<Arc<str>>,
    ) {
        let event = Event::new(name.into(), EventKind::Platform).with_data(Datum::text(&reason));
        let class = self.chart.events.class(name);
        self.raise(Event { send_id, ..event }, class);
        self.host.note(Note::Error { event: name, reason, is_harmless, span: range(span) });
    }
}
