//! The normal form of a machine at rest.

use std::sync::Arc;

use channels::{NoNormalForm, NormalForm};

use super::timer::Delivery;
use super::{Machine, Session, Status};
use crate::Datum;
use crate::chart::ADDRESS;

impl Machine {
    /// Brings the machine, which is at rest, into [normal form](NormalForm): delayed events are due relative to now,
    /// the last event is forgotten if nothing can read it anymore, and the machines that it has invoked are renumbered.
    ///
    /// # Errors
    /// [`NoNormalForm`] if it draws random numbers, reads the time of the run or generated ids, or if too many delayed
    /// events wait.
    pub fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.check()?;
        self.scratch.taken.clear();
        self.scratch.entered.clear();
        form.queue(self.events.timers.len(), || {
            format!("more than {} delayed events are waiting in {}", NormalForm::QUEUE, self.chart.name())
        })?;
        for timer in &mut self.events.timers {
            form.time(&mut timer.due);
            // A delayed event that is overdue, because the machine was suspended, fires as soon as it can.
            timer.due = timer.due.max(NormalForm::NOW);
        }
        if !self.may_look_back() {
            self.events.forget_last();
        }
        self.invoked.iter_mut().try_for_each(|invoked| invoked.machine.normalize(form))?;
        if self.generation == 0 && self.has_generated_ids() {
            if self.looks_at_generated_ids() {
                return unsupported(
                    "it reads ids that are generated whenever a machine is invoked or an event is sent",
                    "give `<send>` an `id`, and do not keep the origin of an event",
                );
            }
            self.number_invoked();
        }
        Ok(())
    }

    fn check(&self) -> Result<(), NoNormalForm> {
        if self.random.has_drawn() {
            return unsupported(
                "it draws random numbers",
                "decide by an event instead, which the environment may send or not",
            );
        }
        if self.chart.mentions.clock {
            return unsupported(
                "it reads the time of the run, which never repeats",
                "measure time with a `<send>` that has a `delay`",
            );
        }
        Ok(())
    }

    /// Whether something can read the last event before the next one comes: a transition without an event, which new
    /// data can enable, or the end of an invoked machine.
    fn may_look_back(&self) -> bool {
        let is_eventless = |id: &_| self.chart.transition(*id).descriptors.is_empty();
        let mut active = self.configuration().map(|state| self.chart.state(state));
        let ends_from_outside = self.generation > 0 && self.chart.states.iter().any(|state| !state.on_exit.is_empty());
        self.status == Status::Running
            && self.chart.mentions.event
            && (ends_from_outside || active.any(|state| state.transitions.iter().any(is_eventless)))
    }

    fn has_generated_ids(&self) -> bool {
        self.generated_ids > 0
            || self.children > 0
            || self.invoked.iter().any(|invoked| invoked.machine.has_generated_ids())
    }

    fn looks_at_generated_ids(&self) -> bool {
        let of_timers = self.events.timers.iter().map(|timer| match &timer.delivery {
            Delivery::Internal(event) | Delivery::Own(event) => &event.data,
            Delivery::Away(outgoing, _) => &outgoing.data,
        });
        self.chart.looks_at_generated_ids()
            || self.data.iter().chain(of_timers).any(holds_address)
            || self.invoked.iter().any(|invoked| invoked.machine.looks_at_generated_ids())
    }

    /// Numbers the machines inside, and the ids by which they are known, in the order of their positions.
    fn number_invoked(&mut self) {
        self.children = self.invoked.len() as u32;
        self.generated_ids = self.children;
        for (number, invoked) in (1..).zip(&mut self.invoked) {
            let state = self.chart.state(invoked.state);
            if state.invokes[invoked.index].id.is_none() {
                invoked.id = format!("{}.{number}", state.id()).into();
            }
            let inner = &mut invoked.machine;
            inner.under = Some(Arc::clone(&invoked.id));
            inner.session = Session::new(&format!("{}.{number}", self.session.id));
            inner.random.restart(inner.session.seed());
            inner.number_invoked();
        }
        let location = &self.session.location;
        let of_timers = self.events.timers.iter_mut().filter_map(|timer| match &mut timer.delivery {
            Delivery::Internal(event) | Delivery::Own(event) => Some(event),
            Delivery::Away(..) => None,
        });
        for event in of_timers.chain(&mut self.events.last) {
            // Nothing reads these, but they must not differ.
            event.origin = event.origin.as_ref().map(|_| Arc::clone(location));
            event.invoke_id = None;
        }
    }
}

fn holds_address(value: &Datum) -> bool {
    match value {
        Datum::Text(text) => text.contains(ADDRESS),
        Datum::Array(array) => array.items().iter().any(holds_address),
        Datum::Object(object) => object.members().any(|(_, value)| holds_address(value)),
        _ => false,
    }
}

fn unsupported(reason: &str, help: &str) -> Result<(), NoNormalForm> {
    Err(NoNormalForm::Unsupported { reason: reason.to_owned(), help: Some(help.to_owned()) })
}
