//! BatteryReader: reports the battery's charge and whether it is charging.

use channels::{Message, Value};
use robot::BatteryState;

use crate::service::{Handler, Service};

/// The process BatteryReader. It answers `[<get_level>]` with `[<ok>, level]` and `[<get_charging>]` with `[<ok>,
/// charging]`, from the latest state that its driver has supplied. Requests before the first state wait.
pub type BatteryReader = Service<BatteryHandler>;

/// The latest state of the battery, if there is one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct BatteryHandler(Option<Latest>);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Latest {
    /// Charge, in percent.
    level: Value,
    charging: Value,
}

impl BatteryReader {
    /// Receives the latest state of the battery from its driver.
    pub fn update(&mut self, state: &BatteryState) {
        self.handler.0 = Some(Latest { level: state.charge_pct.into(), charging: state.charging.into() });
    }

    /// The latest level, in percent, and whether it is charging; `None` before the first.
    #[must_use]
    pub fn reading(&self) -> Option<(f64, bool)> {
        let Latest { level, charging } = self.handler.0.as_ref()?;
        Some((level.as_number()?, *charging == true.into()))
    }
}

impl Handler for BatteryHandler {
    fn answer(&self, request: &Message) -> Option<Message> {
        let latest = self.0.as_ref()?;
        let value = if request.head() == Some("get_charging") { &latest.charging } else { &latest.level };
        Some(Message::new([Value::symbol("ok"), value.clone()]))
    }

    fn location(&self, is_asked: bool) -> String {
        match (&self.0, is_asked) {
            (None, _) => "no reading yet",
            (_, true) => "asked",
            (_, false) => "idle",
        }
        .to_owned()
    }
}
