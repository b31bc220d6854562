//! Navigation: drives to places.

use std::collections::VecDeque;

use channels::{Message, Symbol, Value};

use crate::service::{Handler, Service};

/// The status of a trip, as Navigation reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TripStatus {
    /// The robot is on its way.
    Running,
    /// It has arrived.
    Success,
    /// It will not arrive.
    Failure,
}

/// The effect of a stop request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StopRule {
    /// It ends only the trip to the place that it names. It is answered with `[<ok>, <stopped>]` when it is received.
    #[default]
    OwnTrip,
    /// It ends any trip, whatever place it names, as in the paper's published system (`halt` in `GoToComponent.cpp`,
    /// where the comparison of the places is commented out). It is answered in the same way.
    AnyTrip,
}

impl TripStatus {
    fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Success => "success",
            Self::Failure => "failure",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Trip {
    place: Symbol,
    status: TripStatus,
}

/// The driver's next action.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// Drive to this place and abandon any other trip.
    Start(Symbol),
    /// Stop.
    Stop,
}

/// The process Navigation.
///
/// - `[<start_navigation>, <Place>]` begins a trip, replaces any current one, and is answered with `[<ok>, <running>]`
///   at once (`<stopped>` if another trip replaced it before the answer was sent).
/// - `[<get_status>, <Place>]` is answered with the status of the last trip to this place, or with `[<ok>, <idle>]` if
///   the last trip was to another place or was stopped.
/// - `[<stop_navigation>, <Place>]` ends only the trip to this place. It is answered with `[<ok>, <stopped>]` when it
///   is received, not when the robot stands still. So once a new trip has started, no `<running>` from the old one
///   arrives. Under [`StopRule::AnyTrip`] it ends every trip.
///
/// Between steps the driver carries out its [orders](Navigation::next_order) and
/// [reports](Navigation::set_trip_status) the status of the trip; [`Software`](crate::Software) contains one.
pub type Navigation = Service<Trips>;

/// The trip, and what the driver does not know of it yet.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Trips {
    trip: Option<Trip>,
    orders: VecDeque<Order>,
    stops: StopRule,
}

impl Navigation {
    /// The same, with another rule for stops, which a restart keeps.
    #[must_use]
    pub fn with_stops(mut self, stops: StopRule) -> Self {
        self.handler.stops = stops;
        self
    }

    /// Takes the next order for the driver.
    pub fn next_order(&mut self) -> Option<Order> {
        self.handler.orders.pop_front()
    }

    /// Whether there are orders that the driver has not taken yet.
    #[must_use]
    pub fn has_orders(&self) -> bool {
        !self.handler.orders.is_empty()
    }

    /// The status of the trip, if there is one.
    #[must_use]
    pub fn trip_status(&self) -> Option<TripStatus> {
        self.handler.trip.as_ref().map(|trip| trip.status)
    }

    /// The destination of the trip, if there is one.
    #[must_use]
    pub fn trip_place(&self) -> Option<&Symbol> {
        self.handler.trip.as_ref().map(|trip| &trip.place)
    }

    /// Sets the status of the trip; does nothing if there is none.
    pub fn set_trip_status(&mut self, status: TripStatus) {
        if let Some(trip) = &mut self.handler.trip {
            trip.status = status;
        }
    }
}

impl Trips {
    /// Whether a stop that names `place` ends the trip.
    fn ends(&self, trip: &Trip, place: &Symbol) -> bool {
        self.stops == StopRule::AnyTrip || trip.place == *place
    }
}

impl Handler for Trips {
    fn answer(&self, request: &Message) -> Option<Message> {
        let trip = self.trip.as_ref().filter(|trip| request.field(2) == Some(&trip.place.clone().into()));
        let status = match (request.head(), trip) {
            (Some("stop_navigation"), _) | (Some("start_navigation"), None) => "stopped",
            (_, Some(trip)) => trip.status.name(),
            (_, None) => "idle",
        };
        Some(Message::symbols(["ok", status]))
    }

    /// Begins or ends a trip.
    fn received(&mut self, request: &Message) {
        let Some(Value::Symbol(place)) = request.field(2) else { return };
        match request.head() {
            Some("start_navigation") => {
                self.trip = Some(Trip { place: place.clone(), status: TripStatus::Running });
                self.orders.push_back(Order::Start(place.clone()));
            }
            Some("stop_navigation") if self.trip.as_ref().is_some_and(|trip| self.ends(trip, place)) => {
                self.trip = None;
                self.orders.push_back(Order::Stop);
            }
            _ => {}
        }
    }

    fn restarted(&self) -> Self {
        Self { stops: self.stops, ..Self::default() }
    }

    /// Only the last order counts: the driver carries out all waiting orders before it moves the base.
    fn normalize(&mut self) {
        let outdated = self.orders.len().saturating_sub(1);
        self.orders.drain(..outdated);
    }

    fn location(&self, _: bool) -> String {
        self.trip
            .as_ref()
            .map_or_else(|| "idle".to_owned(), |trip| format!("{}: {}", trip.place.name(), trip.status.name()))
    }
}
