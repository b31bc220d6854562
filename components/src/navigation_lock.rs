//! NavigationLock: lets one skill navigate at a time, as the system did that the paper ran.

use std::time::Duration;

use channels::{Envelope, Message, Offer, Process, ProcessId, Symbol, Topology, TransitionId, Use, Value, WiringError};

use crate::service::Service;

/// The process NavigationLock.
///
/// - `[<take_lock>, <Place>]` is answered `[<ok>, <granted>]` as soon as nobody else has the lock.
/// - `[<give_back>, <Place>]` gives it back, and is not answered.
///
/// The lock is known by the place that its holder drives to. The shipped skills don't need it: a start takes the place of
/// the trip that there was. It is here for [`StopRule::AnyTrip`](crate::StopRule::AnyTrip), to show that it does not help.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct NavigationLock {
    service: Service,
    holder: Option<Symbol>,
}

impl NavigationLock {
    /// The lock for everybody who has a channel to `process`.
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if a client cannot be answered.
    pub fn new(topology: &Topology, process: ProcessId) -> Result<Self, WiringError> {
        Ok(Self { service: Service::new(topology, process)?, holder: None })
    }

    fn answer(&self, request: &Message) -> Option<Message> {
        let is_free = self.holder.as_ref().is_none_or(|holder| place_of(request) == Some(holder));
        is_free.then(|| Message::symbols(["ok", "granted"]))
    }
}

fn place_of(request: &Message) -> Option<&Symbol> {
    if let Some(Value::Symbol(place)) = request.field(2) { Some(place) } else { None }
}

impl Process for NavigationLock {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.service.offers(|request| self.answer(request), offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        if received.is_none() {
            self.holder = self.service.pending(transition).and_then(place_of).cloned();
        }
        let Some(request) = self.service.take(transition, received).cloned() else { return };
        if request.head() == Some("give_back") {
            self.service.dismiss(transition);
            if self.holder.as_ref() == place_of(&request) {
                self.holder = None;
            }
        }
    }

    fn uses(&self) -> Vec<Use> {
        self.service.uses()
    }

    fn location(&self) -> String {
        self.holder.as_ref().map_or_else(|| "free".to_owned(), |holder| format!("held for {}", holder.name()))
    }
}
