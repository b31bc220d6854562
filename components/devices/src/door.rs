//! A door that opens and closes on request.

use skills::Datum;

use crate::Surroundings;
use crate::lines::Lines;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Door {
    name: String,
    /// Whether it has to open or to close.
    order: Option<bool>,
    /// `None` until it is first seen.
    state: Option<DoorState>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum DoorState {
    Open,
    Closed,
    Moving,
}

impl Door {
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), order: None, state: None }
    }

    pub(crate) fn restart(&mut self) {
        *self = Self::new(&self.name);
    }

    pub(crate) fn handle(&mut self, request: &str, client: &str, lines: &mut Lines<'_>) {
        match request {
            "open" | "close" => {
                self.order = Some(request == "open");
                lines.answer(client, []);
            }
            _ => lines.answer(client, [("state", Datum::text(self.location()))]),
        }
    }

    pub(crate) fn act(&mut self, surroundings: &mut dyn Surroundings, lines: &mut Lines<'_>) {
        if let Some(open) = self.order.take() {
            surroundings.move_door(&self.name, open);
        }
        let state = surroundings.door_opening(&self.name).map(|open| match open {
            open if open <= 0.0 => DoorState::Closed,
            open if open >= 1.0 => DoorState::Open,
            _ => DoorState::Moving,
        });
        let before = std::mem::replace(&mut self.state, state);
        if before.is_some() && before != state {
            lines.publish("moved", [("state", Datum::text(self.location()))]);
        }
    }

    pub(crate) fn location(&self) -> &'static str {
        match self.state {
            Some(DoorState::Open) => "open",
            Some(DoorState::Closed) => "closed",
            // No request can arrive before the first step.
            Some(DoorState::Moving) | None => "moving",
        }
    }
}
