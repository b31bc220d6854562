//! Observations that the paper mentions but no report contains: what the robot knew when it set out, how it was
//! charged, and which path the safety monitor took.

use std::convert::Infallible;

use channels::{Event, EventKind, Message, Symbol, Topology, Value};
use recording::{Battery, Follower, RunView};
use scenarios::scenario::Figure;

/// Observations of a run while it was in progress.
#[derive(Clone, Debug, Default)]
pub(super) struct Observed {
    /// Each command to drive somewhere.
    pub(super) departures: Vec<Departure>,
    /// Each completed charging.
    pub(super) charges: Vec<Charge>,
    /// How often a level was read.
    pub(super) readings: u64,
    /// How often the safety monitor of the paper's figure entered its locations.
    pub(super) safety: SafetyPath,
    level_pct: Option<f64>,
    level_before_pct: Option<f64>,
    /// The charge at which the present charging began.
    charging_since_pct: Option<f64>,
    charge_pct: f64,
}

/// A command to drive somewhere.
#[derive(Clone, Debug)]
pub(super) struct Departure {
    /// Where to.
    pub(super) place: String,
    /// The level that was read last, and the one read before it, in percent.
    pub(super) level_pct: Option<f64>,
    pub(super) level_before_pct: Option<f64>,
}

/// Charging that has ended, because the battery was full or because the robot left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Charge {
    pub(super) from_pct: f64,
    pub(super) to_pct: f64,
}

/// How often the safety monitor of the paper's Figure 5 (a) entered each of its locations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SafetyPath {
    pub(super) get: u64,
    pub(super) idle: u64,
    pub(super) failure: u64,
}

impl Follower for Observed {
    type Error = Infallible;

    fn follow(&mut self, view: &RunView) -> Result<(), Infallible> {
        self.see_battery(view.robot().battery);
        view.events().iter().for_each(|event| self.see(event, view.topology()));
        if view.end().is_some() {
            self.count_safety_path(view);
        }
        Ok(())
    }
}

impl Observed {
    /// Begins with a run at its start.
    pub(super) fn begin(view: &RunView) -> Self {
        let mut observed = Self::default();
        observed.see_battery(view.robot().battery);
        observed
    }

    fn see_battery(&mut self, battery: Option<Battery>) {
        let Some(Battery { charge_pct, charging }) = battery else { return };
        match (self.charging_since_pct, charging) {
            (None, true) => self.charging_since_pct = Some(charge_pct),
            // The level in the last step of charging: driving has used some since then.
            (Some(from_pct), false) => {
                let to_pct = charge_pct.max(self.charge_pct);
                self.charges.push(Charge { from_pct, to_pct });
                self.charging_since_pct = None;
            }
            _ => {}
        }
        self.charge_pct = charge_pct;
    }

    fn see(&mut self, event: &Event, topology: &Topology) {
        let EventKind::Received { channel, message } = &event.kind else { return };
        match topology.ends(*channel) {
            ("BatteryReader", "BatteryLevel") => {
                if let (Some("ok"), Some(Value::Real(level_pct))) = (symbol(message, 1), message.field(2)) {
                    self.readings += 1;
                    self.level_before_pct = self.level_pct.replace(*level_pct);
                }
            }
            (_, "Navigation") if symbol(message, 1) == Some("start_navigation") => {
                self.departures.extend(symbol(message, 2).map(|place| Departure {
                    place: place.to_owned(),
                    level_pct: self.level_pct,
                    level_before_pct: self.level_before_pct,
                }));
            }
            _ => {}
        }
    }

    fn count_safety_path(&mut self, view: &RunView) {
        let Some(monitor) = view.monitors().find(|monitor| monitor.name() == Figure::Safety.name()) else { return };
        let (Some(graph), Some(end)) = (&monitor.about.graph, monitor.end) else { return };
        let visits = |name: &str| {
            let locations = graph.locations.iter().zip(&end.visits);
            locations.filter(|(location, _)| location.name == name).map(|(_, visits)| visits).sum()
        };
        let [get, idle, failure] = ["get", "idle", "failure"].map(visits);
        self.safety = SafetyPath { get, idle, failure };
    }

    /// The first command to drive to a place.
    pub(super) fn first_departure_for(&self, place: &str) -> Option<&Departure> {
        self.departures.iter().find(|departure| departure.place == place)
    }
}

fn symbol(message: &Message, field: usize) -> Option<&str> {
    match message.field(field)? {
        Value::Symbol(symbol) => Some(Symbol::name(symbol)),
        _ => None,
    }
}
