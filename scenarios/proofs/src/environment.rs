//! What may happen around the tree, skills and components: the drivers of the built-in components, and the world behind
//! them, as the environment of a proof.

use std::time::Duration;

use channels::{Process, ProcessId};
use components::{BatteryReader, Localization, Navigation, TripStatus};
use explorer::{Environment, EnvironmentState, Instant, Move};
use scenarios::scenario::schedule::DriverData;

use super::faults::{inside, is_out};
use super::levels::{Class, FULL, Levels, Micros, Rates};

/// A robot's battery, Localization and Navigation, which may do anything that the assumptions allow.
#[derive(Clone, Debug)]
pub(crate) struct RobotEnvironment {
    driven: Vec<ProcessId>,
    battery: Option<Battery>,
    localization: Option<ProcessId>,
    trips: Trips,
    /// The places that some part asks about, drives to, or passes.
    places: Vec<String>,
    /// All places that Localization knows.
    known: Vec<String>,
    station: Option<Spot>,
    start: Option<Spot>,
}

/// The statuses of a trip, by number.
const STATUSES: [TripStatus; 3] = [TripStatus::Running, TripStatus::Success, TripStatus::Failure];

/// The number of a place at which the robot may be.
type Spot = usize;

/// The battery and its driver.
#[derive(Clone, Debug)]
pub(crate) struct Battery {
    pub(crate) process: ProcessId,
    pub(crate) levels: Levels,
    /// The bounds of its level; `None` if it may jump.
    pub(crate) bounds: Option<Bounds>,
}

/// The bounds of a battery's level.
#[derive(Clone, Debug)]
pub(crate) struct Bounds {
    pub(crate) rates: Rates,
    /// The lowest and the highest level at the start.
    pub(crate) start: (Micros, Micros),
    /// From this level on, it may stop charging at the station.
    pub(crate) is_full_from: Micros,
}

/// Navigation and its driver.
#[derive(Clone, Debug)]
pub(crate) struct Trips {
    pub(crate) process: Option<ProcessId>,
    /// A trip ends before this number of ticks.
    pub(crate) ticks: Option<i64>,
    pub(crate) may_fail: bool,
    /// The places that the robot may pass on a trip.
    pub(crate) passes: Vec<Spot>,
}

/// The places of a robot.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    /// The places that matter.
    pub(crate) places: Vec<String>,
    /// All places.
    pub(crate) known: Vec<String>,
    pub(crate) station: Option<Spot>,
    /// The place of the robot at the start, if it matters.
    pub(crate) start: Option<Spot>,
}

/// The state that is remembered from one instant to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct State {
    /// Whether the drivers have told the processes anything yet.
    has_begun: bool,
    at: Option<Spot>,
    /// The number of ticks since the trip began, if trips are bounded.
    elapsed: i64,
    /// The battery, if its level is bounded.
    charge: Charge,
}

/// A battery whose level is bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Charge {
    level: Class,
    /// The level at the last tick or, if it was both charged and drained since then, the highest since then: it has
    /// lost no more than a tick's drain from there.
    reference: Class,
    is_charging: bool,
    /// What it has done since the last tick.
    since: Since,
}

/// What a battery has done throughout the time since the last tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Since {
    /// It was not charged.
    #[default]
    Drained,
    Charged,
    /// Both, one after the other.
    Mixed,
}

impl State {
    fn encoded(self) -> EnvironmentState {
        let Charge { level, reference, is_charging, since } = self.charge;
        let at = self.at.map_or(-1, |at| at as i64);
        let since = [Since::Drained, Since::Charged, Since::Mixed].iter().position(|one| *one == since).unwrap_or(0);
        let [has_begun, is_charging] = [self.has_begun, is_charging].map(i64::from);
        let level = [level as i64, reference as i64, is_charging, since as i64];
        [has_begun, at, self.elapsed].into_iter().chain(level).collect()
    }

    fn decoded(numbers: &[i64]) -> Self {
        let &[has_begun, at, elapsed, level, reference, is_charging, since, ..] = numbers else {
            unreachable!("states are encoded by `encoded`");
        };
        let since = [Since::Drained, Since::Charged, Since::Mixed][since as usize];
        let charge =
            Charge { level: level as Class, reference: reference as Class, is_charging: is_charging == 1, since };
        Self { has_begun: has_begun == 1, at: Spot::try_from(at).ok(), elapsed, charge }
    }
}

/// The class of the battery's level in a state of the environment, and whether the battery is being charged. Faults add
/// numbers of their own to the state.
pub(super) fn battery_in(state: &[i64]) -> (Class, bool) {
    let Charge { level, is_charging, .. } = State::decoded(state).charge;
    (level, is_charging)
}

/// The progress of a trip after a move.
#[derive(Clone, Copy, Debug)]
struct Leg {
    at: Option<Spot>,
    elapsed: i64,
    /// The status reported to Navigation, if there is a trip.
    status: Option<TripStatus>,
}

/// What the battery's driver reports after a move.
#[derive(Clone, Copy, Debug)]
struct Reading {
    class: Class,
    is_charging: bool,
    charge: Charge,
}

impl RobotEnvironment {
    pub(crate) fn new(
        battery: Option<Battery>,
        localization: Option<ProcessId>,
        trips: Trips,
        Ground { places, known, station, start }: Ground,
    ) -> Self {
        let battery_reader = battery.as_ref().map(|battery| battery.process);
        let driven = [battery_reader, localization, trips.process].into_iter().flatten().collect();
        Self { driven, battery, localization, trips, places, known, station, start }
    }

    fn process<'p, P: Process>(&self, driven: &[&'p dyn Process], id: Option<ProcessId>) -> Option<&'p P> {
        inside(self.outside(driven, id)?).as_any().downcast_ref()
    }

    /// The process, inside any wrapper that a fault has put around it.
    fn outside<'p>(&self, driven: &[&'p dyn Process], id: Option<ProcessId>) -> Option<&'p dyn Process> {
        let index = self.driven.iter().position(|known| Some(*known) == id)?;
        Some(driven[index])
    }

    /// How the trip may continue.
    fn legs(&self, state: State, driven: &[&dyn Process], instant: Instant) -> Vec<Leg> {
        let navigation: Option<&Navigation> = self.process(driven, self.trips.process);
        let trip = navigation.and_then(|navigation| Some((navigation.trip_place()?, navigation.trip_status()?)));
        let is_new = navigation.is_some_and(Navigation::has_orders);
        if self.outside(driven, self.trips.process).is_some_and(is_out) {
            // Nothing commands the base, so it stands still, and orders wait.
            let is_under_way = matches!(trip, Some((_, TripStatus::Running))) && !is_new;
            let elapsed = if is_under_way { state.elapsed } else { 0 };
            return vec![Leg { at: state.at, elapsed, status: trip.map(|(_, status)| status) }];
        }
        let Some((to, TripStatus::Running)) = trip else {
            let status = trip.map(|(_, status)| status);
            return vec![Leg { at: state.at, elapsed: 0, status }];
        };
        let to = self.places.iter().position(|place| place == to.name());
        let bound = self.trips.ticks;
        let ticked = bound.is_some() && instant == Instant::Tick;
        let elapsed = if is_new { 0 } else { state.elapsed } + i64::from(ticked);
        let mut on_the_way = vec![state.at, None, to];
        on_the_way.extend(self.trips.passes.iter().copied().map(Some));
        on_the_way.sort_unstable();
        on_the_way.dedup();
        let everywhere = |status: TripStatus, elapsed| {
            on_the_way.iter().map(move |at| Leg { at: *at, elapsed, status: Some(status) }).collect::<Vec<_>>()
        };
        let mut legs = vec![Leg { at: to, elapsed: 0, status: Some(TripStatus::Success) }];
        if self.trips.may_fail {
            legs.extend(everywhere(TripStatus::Failure, 0));
        }
        if bound.is_none_or(|bound| elapsed < bound) {
            legs.extend(everywhere(TripStatus::Running, elapsed));
        }
        legs
    }

    /// What the battery's driver may report.
    fn readings(&self, state: State, leg: Leg, instant: Instant) -> Vec<Option<Reading>> {
        let Some(battery) = &self.battery else { return vec![None] };
        let is_docked = leg.at.is_some() && leg.at == self.station;
        let mut readings = Vec::new();
        let Some(bounds) = &battery.bounds else {
            for class in 0..battery.levels.len() {
                readings.push(Some(Reading { class, is_charging: false, charge: Charge::default() }));
                if is_docked {
                    readings.push(Some(Reading { class, is_charging: true, charge: Charge::default() }));
                }
            }
            return readings;
        };
        for is_charging in [false, true] {
            if is_charging && !is_docked {
                continue;
            }
            for class in battery.levels_after(bounds, state, is_charging, instant) {
                let is_driving = leg.status == Some(TripStatus::Running);
                if is_docked && !is_charging && !is_driving && class < battery.levels.class(bounds.is_full_from) {
                    continue;
                }
                let charge = state.charge.after(state.has_begun, class, is_charging, instant);
                readings.push(Some(Reading { class, is_charging, charge }));
            }
        }
        readings
    }

    /// What may happen to the trip and to the battery.
    fn choices(
        &self,
        state: State,
        driven: &[&dyn Process],
        instant: Instant,
    ) -> impl Iterator<Item = (Leg, Option<Reading>)> {
        let legs = self.legs(state, driven, instant).into_iter();
        legs.flat_map(move |leg| self.readings(state, leg, instant).into_iter().map(move |reading| (leg, reading)))
    }

    fn made(&self, leg: Leg, reading: Option<Reading>) -> Move {
        let charge = reading.map(|reading| reading.charge).unwrap_or_default();
        let state = State { has_begun: true, at: leg.at, elapsed: leg.elapsed, charge };
        let told = [
            reading.map(|Reading { class, is_charging, .. }| 2 * class as u32 + u32::from(is_charging)),
            self.localization.map(|_| leg.at.map_or(0, |at| 1 + at as u32)),
            self.trips.process.map(|_| leg.status.map_or(0, |status| 1 + status as u32)),
        ];
        Move { state: state.encoded(), told: told.into_iter().flatten().collect() }
    }

    /// The changes for the processes, in words.
    fn in_words(&self, before: State, leg: Leg, reading: Option<Reading>, driven: &Driven<'_>) -> String {
        let mut parts = Vec::new();
        let place = |at: Option<Spot>| at.map(|at| self.places[at].as_str());
        let to = driven.navigation.and_then(Navigation::trip_place);
        let was_running = driven.navigation.and_then(Navigation::trip_status) == Some(TripStatus::Running);
        match (leg.status, to) {
            (Some(TripStatus::Success), Some(to)) if was_running => {
                parts.push(format!("the robot arrives at {}", to.name()))
            }
            (status, to) => {
                if let (Some(TripStatus::Failure), true, Some(to)) = (status, was_running, to) {
                    parts.push(format!("the trip to {} fails", to.name()));
                }
                match (place(leg.at), place(before.at)) {
                    (Some(at), _) if !before.has_begun => parts.push(format!("the robot is at {at}")),
                    (Some(at), was) if was != Some(at) => parts.push(format!("the robot comes to {at}")),
                    (None, Some(was)) => parts.push(format!("the robot leaves {was}")),
                    _ => {}
                }
            }
        }
        if let Some((Reading { class, is_charging, .. }, Battery { levels, .. })) = reading.zip(self.battery.as_ref()) {
            let was = driven.battery.and_then(BatteryReader::reading);
            let level_pct = levels.level_pct(class);
            if was.is_none_or(|(was_pct, _)| was_pct.total_cmp(&level_pct).is_ne()) {
                parts.push(format!("the level is {}", levels.words(class)));
            }
            match was.is_some_and(|(_, was_charging)| was_charging) {
                false if is_charging => parts.push("charging begins".to_owned()),
                true if !is_charging => parts.push("charging ends".to_owned()),
                _ => {}
            }
        }
        parts.join(", ")
    }
}

/// The built-in components that the environment drives.
struct Driven<'a> {
    battery: Option<&'a BatteryReader>,
    navigation: Option<&'a Navigation>,
}

impl Battery {
    /// The possible classes of the level at an instant.
    fn levels_after(&self, bounds: &Bounds, state: State, is_charging: bool, instant: Instant) -> Vec<Class> {
        let Bounds { rates: Rates { drain, charge }, start, .. } = *bounds;
        let Charge { level, reference, since, .. } = state.charge;
        if !state.has_begun {
            return (self.levels.class(start.0)..=self.levels.class(start.1)).collect();
        }
        // A battery that is charged throughout a tick gains at least `charge`.
        let gain = if instant == Instant::Tick { charge } else { 0 };
        match since.and(is_charging) {
            Since::Drained => self.levels.reached(reference, -drain..=0).filter(|class| *class <= level).collect(),
            Since::Charged => self.levels.reached(reference, gain..=FULL).filter(|class| *class >= level).collect(),
            Since::Mixed => self.levels.reached(reference.max(level), -drain..=FULL).collect(),
        }
    }
}

impl Since {
    /// The same, after more time within the tick.
    pub(super) fn and(self, is_charging: bool) -> Self {
        match (self, is_charging) {
            (Self::Drained, false) => Self::Drained,
            (Self::Charged, true) => Self::Charged,
            _ => Self::Mixed,
        }
    }
}

impl Charge {
    fn after(self, has_begun: bool, level: Class, is_charging: bool, instant: Instant) -> Self {
        let as_now = if is_charging { Since::Charged } else { Since::Drained };
        if instant == Instant::Tick || !has_begun {
            return Self { level, reference: level, is_charging, since: as_now };
        }
        let since = self.since.and(is_charging);
        let highest = self.reference.max(self.level).max(level);
        Self { level, reference: if since == Since::Mixed { highest } else { self.reference }, is_charging, since }
    }
}

impl Environment for RobotEnvironment {
    fn driven(&self) -> &[ProcessId] {
        &self.driven
    }

    fn start(&self) -> EnvironmentState {
        State { has_begun: false, at: self.start, elapsed: 0, charge: Charge::default() }.encoded()
    }

    fn moves(&self, state: &[i64], driven: &[&dyn Process], instant: Instant) -> Vec<Move> {
        let choices = self.choices(State::decoded(state), driven, instant);
        choices.map(|(leg, reading)| self.made(leg, reading)).collect()
    }

    /// The numbers are those of [`RobotEnvironment::made`].
    fn tell(&self, id: ProcessId, told: u32, process: &mut dyn Process, _now: Duration) {
        let mut data = DriverData::default();
        match &self.battery {
            Some(battery) if battery.process == id => {
                data.battery = Some((battery.levels.level_pct(told as Class / 2), told % 2 == 1));
            }
            _ if self.localization == Some(id) => {
                data.place = told.checked_sub(1).map(|at| self.places[at as Spot].clone());
            }
            _ => data.trip = told.checked_sub(1).map(|status| STATUSES[status as usize]),
        }
        data.update(process, &self.known);
    }

    fn words(&self, state: &[i64], driven: &[&dyn Process], instant: Instant) -> Vec<String> {
        let state = State::decoded(state);
        let navigation = self.process(driven, self.trips.process);
        let battery = self.process(driven, self.battery.as_ref().map(|battery| battery.process));
        let known = Driven { battery, navigation };
        let choices = self.choices(state, driven, instant);
        choices.map(|(leg, reading)| self.in_words(state, leg, reading, &known)).collect()
    }

    /// Components move when they receive a request or have an answer to send.
    fn may_stir(&self, _state: &[i64], driven: &[&dyn Process]) -> bool {
        driven.iter().map(|process| inside(*process).as_any()).any(|process| {
            process.downcast_ref::<BatteryReader>().is_none_or(BatteryReader::is_asked)
                && process.downcast_ref::<Localization>().is_none_or(Localization::is_asked)
                && process.downcast_ref::<Navigation>().is_none_or(Navigation::is_asked)
        })
    }
}
