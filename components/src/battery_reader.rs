//! BatteryReader: reports the battery's charge and whether it is charging.

use std::time::Duration;

use channels::{
    ChannelSystem, Envelope, Message, NoNormalForm, NormalForm, Offer, Process, ProcessId, Topology, TransitionId, Use,
    Value, WiringError,
};
use robot::BatteryState;

use crate::service::Service;

/// The process BatteryReader. It answers `[<get_level>]` with `[<ok>, level]` and `[<get_charging>]` with `[<ok>,
/// charging]`, from the latest state that its driver has supplied. Requests before the first state wait.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct BatteryReader {
    service: Service,
    latest: Option<Latest>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Latest {
    /// Charge, in percent.
    level: Value,
    charging: Value,
}

impl BatteryReader {
    /// The reader that serves every process with a channel to `process`.
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if a client cannot be answered.
    pub fn new(topology: &Topology, process: ProcessId) -> Result<Self, WiringError> {
        Ok(Self { service: Service::new(topology, process)?, latest: None })
    }

    /// Returns it to its initial state, after a crash and restart.
    pub fn restart(&mut self) {
        self.service.forget();
        self.latest = None;
    }

    /// Receives the latest state of the battery from its driver.
    pub fn update(&mut self, state: &BatteryState) {
        self.latest = Some(Latest { level: state.charge_pct.into(), charging: state.charging.into() });
    }

    /// The latest level, in percent, and whether it is charging; `None` before the first.
    #[must_use]
    pub fn reading(&self) -> Option<(f64, bool)> {
        let Latest { level, charging } = self.latest.as_ref()?;
        Some((level.as_number()?, *charging == true.into()))
    }

    /// Whether a client waits for an answer.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.service.is_asked()
    }

    fn answer(&self, request: &Message) -> Option<Message> {
        let latest = self.latest.as_ref()?;
        let value = if request.head() == Some("get_charging") { &latest.charging } else { &latest.level };
        Some(Message::new([Value::symbol("ok"), value.clone()]))
    }
}

impl Process for BatteryReader {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.service.offers(|request| self.answer(request), offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        self.service.take(transition, received);
    }

    fn uses(&self) -> Vec<Use> {
        self.service.uses()
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.service.normalize(form);
        Ok(())
    }

    fn location(&self) -> String {
        match (&self.latest, self.service.is_asked()) {
            (None, _) => "no reading yet",
            (_, true) => "asked",
            (_, false) => "idle",
        }
        .to_owned()
    }
}

/// Gives the battery's readings to BatteryReader.
#[derive(Clone, Debug)]
pub(crate) struct BatteryDriver {
    pub(crate) process: ProcessId,
}

impl BatteryDriver {
    pub(crate) fn battery(&self, state: &BatteryState, system: &mut ChannelSystem) {
        if let Some(reader) = system.process_mut::<BatteryReader>(self.process) {
            reader.update(state);
        }
    }
}
