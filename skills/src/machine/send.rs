//! `<send>`, `<cancel>` and the timers of delayed events (SCXML 6.2, 6.3).

use std::sync::Arc;
use std::time::Duration;

use miette::SourceSpan;

use super::execute::Aborted;
use super::macrostep::{Macrostep, OuterEvent};
use super::timer::{Delivery, Spot, Timer};
use super::{Event, EventKind, Invoked, Note, Outgoing, Queued, Session, Status, Undelivered, no_room};
use crate::Datum;
use crate::chart::{
    ADDRESS, Attribute, CHANNEL_PROCESSOR, CHOICE_PROCESSOR, Delay, SCXML_PROCESSOR, Send, SendId, Source,
};
use crate::delay;
use crate::load::INTERNAL_TARGET;

/// The target for the machine that has invoked this one.
const PARENT_TARGET: &str = "#_parent";

impl Macrostep<'_, '_> {
    /// Evaluates the event now, and sends it now or later.
    pub(super) fn send(&mut self, send: &Send) -> Result<(), Aborted> {
        let id = self.send_id(send)?;
        let (delivery, delay) = self.delivery_with_delay(send, id.clone()).map_err(|reason| {
            self.fail(reason, send.span, id.clone());
            Aborted
        })?;
        if delay.is_zero() {
            self.deliver(delivery);
        } else {
            let due = self.now.saturating_add(delay);
            self.machine.events.delay(Timer { due, send_id: id, delivery });
        }
        Ok(())
    }

    /// The event, and its delay.
    fn delivery_with_delay(&mut self, send: &Send, send_id: Option<Arc<str>>) -> Result<(Delivery, Duration), String> {
        let delivery = self.delivery(send, send_id)?;
        let delay = self.delay(send)?;
        let waits_here = !delay.is_zero() || !matches!(delivery, Delivery::Away(..));
        if waits_here && !self.machine.has_room() { Err(no_room()) } else { Ok((delivery, delay)) }
    }

    fn send_id(&mut self, send: &Send) -> Result<Option<Arc<str>>, Aborted> {
        match &send.id {
            SendId::None => Ok(None),
            SendId::Literal(id) => Ok(Some(Arc::clone(id))),
            SendId::Generated(location) => {
                self.machine.generated_ids += 1;
                let id: Arc<str> = format!("{}.send{}", self.machine.session.id, self.machine.generated_ids).into();
                self.assign(location, Datum::Text(Arc::clone(&id)), send.span)?;
                Ok(Some(id))
            }
        }
    }

    /// The event and its target, or the reason why there is none.
    fn delivery(&mut self, send: &Send, send_id: Option<Arc<str>>) -> Result<Delivery, String> {
        let event = self.attribute(send.event.as_ref())?;
        let target = self.attribute(send.target.as_ref())?;
        let processor = self.attribute(send.processor.as_ref())?;
        let mut members = Vec::new();
        for named in &send.name_list {
            let value = self.evaluate(&named.value).map_err(|error| error.to_string())?;
            members.push((Arc::clone(&named.name), value));
        }
        let (data, repeated) = if send.payload.content.is_some() {
            (self.payload(&send.payload), None)
        } else {
            members.extend(self.params(&send.payload));
            let is_again = |(index, (name, _)): (usize, &(Arc<str>, Datum))| {
                members[..index].iter().any(|(earlier, _)| earlier == name)
            };
            let is_repeated = members.iter().enumerate().any(is_again);
            let repeated = is_repeated.then(|| members.as_slice().into());
            (self.object(members), repeated)
        };
        let processor = processor.unwrap_or_else(|| Arc::clone(&self.machine.session.processor));
        self.route(Outgoing { processor, target, event, send_id, data, repeated }, send.span)
    }

    /// The route of an event: by channel to another process, or by SCXML's own processor to this machine.
    fn route(&self, outgoing: Outgoing, span: SourceSpan) -> Result<Delivery, String> {
        if is_by_host(&outgoing) {
            return Ok(Delivery::Away(outgoing, Spot(span)));
        }
        if ![SCXML_PROCESSOR, "scxml"].contains(&&*outgoing.processor) {
            return Err(format!("unknown event processor `{}`", outgoing.processor));
        }
        let session = &self.machine.session;
        match outgoing.target.as_deref() {
            Some(INTERNAL_TARGET) => Ok(Delivery::Internal(own_event(outgoing, EventKind::Internal))),
            Some(target) if target == &*session.location => Ok(self.to_itself(outgoing)),
            None => Ok(self.to_itself(outgoing)),
            Some(target) if target.starts_with("#_") => Ok(Delivery::Away(outgoing, Spot(span))),
            Some(target) => Err(format!("`{target}` is not a valid target of an SCXML event")),
        }
    }

    fn to_itself(&self, outgoing: Outgoing) -> Delivery {
        let Session { location, processor, .. } = &*self.machine.session;
        let event = own_event(outgoing, EventKind::External);
        Delivery::Own(event.with_origin(Arc::clone(location), Arc::clone(processor)))
    }

    pub(super) fn attribute(&mut self, attribute: Option<&Attribute>) -> Result<Option<Arc<str>>, String> {
        attribute.map(|attribute| self.source(&attribute.source)).transpose()
    }

    pub(super) fn source(&mut self, source: &Source) -> Result<Arc<str>, String> {
        match source {
            Source::Literal(text) => Ok(Arc::clone(text)),
            Source::Computed(expr) => match self.evaluate(expr) {
                Ok(value) => Ok(value.to_text()),
                Err(error) => Err(error.to_string()),
            },
        }
    }

    fn delay(&mut self, send: &Send) -> Result<Duration, String> {
        match &send.delay {
            Delay::Literal(delay) => Ok(*delay),
            Delay::Computed(expr) => {
                let text = self.evaluate(expr).map_err(|error| error.to_string())?.to_text();
                delay::parse(&text).ok_or_else(|| format!("`{text}` is not a delay; {}", delay::FORMS))
            }
        }
    }

    /// Delivers an event to its queue or to the host.
    pub(super) fn deliver(&mut self, delivery: Delivery) {
        match delivery {
            Delivery::Internal(event) => {
                let class = self.chart.events.class(&event.name);
                self.raise(event, class);
            }
            Delivery::Own(event) => {
                if !self.chart.may_handle(&event.name) {
                    self.host.note(Note::Unheard { event: Arc::clone(&event.name) });
                }
                let class = self.chart.events.class(&event.name);
                self.machine.events.external.push_back(Queued { event, class });
            }
            Delivery::Away(outgoing, Spot(span)) => {
                let send_id = outgoing.send_id.clone();
                let result = if is_by_host(&outgoing) {
                    self.host.send(&outgoing)
                } else {
                    self.send_to_machine(outgoing).map_err(Undelivered::Unfit)
                };
                if let Err(undelivered) = result {
                    // A late answer is no mistake of the machine: the client has stopped waiting in the meantime.
                    let is_harmless = matches!(undelivered, Undelivered::Late(_));
                    self.raise_error("error.communication", undelivered.to_string(), is_harmless, span, send_id);
                }
            }
        }
    }

    /// Sends an event to an outer or inner machine (SCXML C.1).
    fn send_to_machine(&mut self, outgoing: Outgoing) -> Result<(), String> {
        let Session { location, processor, .. } = &*self.machine.session;
        let target = outgoing.target.clone().unwrap_or_default();
        let event = own_event(outgoing, EventKind::External).with_origin(Arc::clone(location), Arc::clone(processor));
        if &*target == PARENT_TARGET && self.machine.under.is_some() {
            self.post(OuterEvent::Parent(event))
        } else if let Some(session) = target.strip_prefix(ADDRESS) {
            match self.machine.descendant(session) {
                Some(machine) => machine.admit(event),
                None if self.outer.outside.iter().any(|known| &**known == session) => {
                    self.post(OuterEvent::Session(session.into(), event))
                }
                None => Err(format!("there is no session {session}")),
            }
        } else {
            let is_meant = |invoked: &&mut Invoked| {
                target.strip_prefix("#_") == Some(&*invoked.id) && invoked.machine.status == Status::Running
            };
            match self.machine.invoked.iter_mut().find(is_meant) {
                Some(invoked) => invoked.machine.admit(event),
                None => Err(format!("there is no machine at `{target}`")),
            }
        }
    }

    /// Sends an event to an outer machine, if there is room for it.
    fn post(&mut self, event: OuterEvent) -> Result<(), String> {
        if self.outer.events.len() >= self.outer.room {
            return Err(no_room());
        }
        self.outer.events.push(event);
        Ok(())
    }

    /// Cancels the delayed events with this id; one that is already on its way cannot be canceled.
    pub(super) fn cancel(&mut self, id: &Source, span: SourceSpan) -> Result<(), Aborted> {
        match self.source(id) {
            Ok(id) => {
                self.machine.events.cancel(&id);
                Ok(())
            }
            Err(reason) => self.abort(reason, span),
        }
    }
}

/// Whether the host delivers the event: to another process, or as a choice.
fn is_by_host(outgoing: &Outgoing) -> bool {
    [CHANNEL_PROCESSOR, CHOICE_PROCESSOR].contains(&&*outgoing.processor)
}

fn own_event(outgoing: Outgoing, kind: EventKind) -> Event {
    let Outgoing { event, send_id, data, repeated, .. } = outgoing;
    Event { send_id, data, repeated, ..Event::new(event.unwrap_or_default(), kind) }
}
