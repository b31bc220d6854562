//! What may happen around the tree, skills and components: the drivers of the built-in components, and the world behind
//! them, as the environment of a proof.

use std::hash::{Hash, Hasher};
use std::time::Duration;

use channels::{ChannelId, Message, Process, ProcessId, Symbol, Value};
use components::{BatteryReader, Localization, Navigation, TripStatus};
use explorer::{Environment, Instant, Move};
use scenarios::scenario::schedule::DriverData;
use scenarios::scenario::{Fact, Truths};

use super::battery::{BatteryModel, BatteryUpdate, Charge};
use super::faults::{inside, is_out};
use super::levels::{Class, Levels};

/// A robot's battery, Localization and Navigation, which may do anything that the assumptions allow.
#[derive(Clone, Debug)]
pub(crate) struct RobotEnvironment {
    driven: Vec<ProcessId>,
    battery: Option<BatteryModel>,
    localization: Option<ProcessId>,
    trips: Trips,
    /// The places that some part refers to, drives to, or passes.
    places: Vec<String>,
    /// All places of Localization.
    known: Vec<String>,
    station: Option<Spot>,
    start: Option<Spot>,
    /// What monitors are shown of the world, if the property is about it.
    world: Option<Truths>,
}

/// The statuses of a trip, by number.
const STATUSES: [TripStatus; 3] = [TripStatus::Running, TripStatus::Success, TripStatus::Failure];

/// The number of a place at which the robot may be.
type Spot = usize;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct WorldState {
    /// Whether the drivers have reported anything to the processes yet.
    has_begun: bool,
    at: Option<Spot>,
    /// The number of ticks since the trip began, if trips are bounded.
    elapsed: i64,
    /// The battery, if its level is bounded.
    charge: Charge,
    /// The class of the battery's level, and whether it is being charged, if monitors are shown the world.
    shown: Option<(Class, bool)>,
    /// What the move to this state has changed.
    pub(super) changed: Changed,
}

impl WorldState {
    /// The class of the battery's level, and whether the battery is being charged.
    pub(super) fn battery(self) -> (Class, bool) {
        (self.charge.level, self.charge.is_charging)
    }
}

/// What a move changes for the processes. Nothing depends on it: states that differ only in it are the same state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Changed {
    /// The battery's level, whether it is being charged, or something at the station, where it may be charged.
    pub(super) battery: bool,
    /// The robot's place, or the end of its trip.
    pub(super) trip: bool,
}

impl PartialEq for Changed {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Changed {}

impl Hash for Changed {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}

/// Something that changes for the processes.
#[derive(Clone, Copy, Debug)]
enum Change<'a> {
    /// The robot reaches the goal of its trip, which implies where it is.
    Arrives(&'a str),
    TripFails(&'a str),
    IsAt(&'a str),
    ComesTo(&'a str),
    Leaves(&'a str),
    Level(&'a Levels, Class),
    Charging(bool),
}

impl Change<'_> {
    fn in_words(self) -> String {
        match self {
            Self::Arrives(place) => format!("the robot arrives at {place}"),
            Self::TripFails(place) => format!("the trip to {place} fails"),
            Self::IsAt(place) => format!("the robot is at {place}"),
            Self::ComesTo(place) => format!("the robot comes to {place}"),
            Self::Leaves(place) => format!("the robot leaves {place}"),
            Self::Level(levels, class) => format!("the level is {}", levels.words(class)),
            Self::Charging(true) => "charging begins".to_owned(),
            Self::Charging(false) => "charging ends".to_owned(),
        }
    }
}

/// The progress of a trip after a move.
#[derive(Clone, Copy, Debug)]
struct Leg {
    at: Option<Spot>,
    elapsed: i64,
    /// The status reported to Navigation, if there is a trip.
    status: Option<TripStatus>,
}

impl RobotEnvironment {
    pub(crate) fn new(
        battery: Option<BatteryModel>,
        localization: Option<ProcessId>,
        trips: Trips,
        Ground { places, known, station, start }: Ground,
    ) -> Self {
        let battery_reader = battery.as_ref().map(|battery| battery.process);
        let driven = [battery_reader, localization, trips.process].into_iter().flatten().collect();
        Self { driven, battery, localization, trips, places, known, station, start, world: None }
    }

    /// The same, with monitors that are shown the world.
    pub(crate) fn with_world(self, world: Option<Truths>) -> Self {
        Self { world, ..self }
    }

    /// The value of a fact in a state. Only the level and the place are needed.
    fn value(&self, fact: &Fact, state: &WorldState) -> Value {
        let (class, is_charging) = state.shown.unwrap_or_default();
        match fact {
            Fact::Level => self.battery.as_ref().map_or(0.0, |battery| battery.levels.level_pct(class)).into(),
            Fact::Charging => is_charging.into(),
            Fact::At(place) => state.at.is_some_and(|at| self.places[at] == *place).into(),
            Fact::Touching | Fact::Carried(_) => false.into(),
            _ => 0.0.into(),
        }
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
    fn legs(&self, state: WorldState, driven: &[&dyn Process], instant: Instant) -> Vec<Leg> {
        if self.trips.process.is_none() && self.localization.is_some() {
            // It is unknown where a Navigation from a file drives.
            let anywhere = std::iter::once(None).chain((0..self.places.len()).map(Some));
            return anywhere.map(|at| Leg { at, elapsed: 0, status: None }).collect();
        }
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

    fn battery_updates(&self, state: WorldState, leg: Leg, instant: Instant) -> Vec<Option<BatteryUpdate>> {
        let Some(battery) = &self.battery else { return vec![None] };
        let is_docked = leg.at.is_some() && leg.at == self.station;
        let is_driving = leg.status == Some(TripStatus::Running) || self.trips.process.is_none();
        let charge = state.has_begun.then_some(state.charge);
        battery.updates(charge, is_docked, is_driving, instant).into_iter().map(Some).collect()
    }

    /// What may happen to the trip and to the battery.
    fn choices(
        &self,
        state: WorldState,
        driven: &[&dyn Process],
        instant: Instant,
    ) -> impl Iterator<Item = (Leg, Option<BatteryUpdate>)> {
        let legs = self.legs(state, driven, instant).into_iter();
        legs.flat_map(move |leg| self.battery_updates(state, leg, instant).into_iter().map(move |update| (leg, update)))
    }

    fn made(
        &self,
        before: WorldState,
        leg: Leg,
        update: Option<BatteryUpdate>,
        driven: &Driven<'_>,
    ) -> Move<WorldState> {
        let charge = update.map(|update| update.charge).unwrap_or_default();
        let battery = update.map(|BatteryUpdate { class, is_charging, .. }| (class, is_charging));
        let shown = self.world.as_ref().map(|_| battery.unwrap_or_default());
        let changed = self.changed(self.changes(before, leg, update, driven));
        let state = WorldState { has_begun: true, at: leg.at, elapsed: leg.elapsed, charge, shown, changed };
        let reports = [
            update.map(|BatteryUpdate { class, is_charging, .. }| 2 * class as u32 + u32::from(is_charging)),
            self.localization.map(|_| leg.at.map_or(0, |at| 1 + at as u32)),
            self.trips.process.map(|_| leg.status.map_or(0, |status| 1 + status as u32)),
        ];
        Move { state, reports: reports.into_iter().flatten().collect() }
    }

    /// The changes for the processes: only they are worth mentioning.
    fn changes<'s>(
        &'s self,
        before: WorldState,
        leg: Leg,
        update: Option<BatteryUpdate>,
        driven: &Driven<'s>,
    ) -> [Option<Change<'s>>; 4] {
        let place = |at: Option<Spot>| at.map(|at| self.places[at].as_str());
        let to = driven.navigation.and_then(Navigation::trip_place).map(Symbol::name);
        let was_running = driven.navigation.and_then(Navigation::trip_status) == Some(TripStatus::Running);
        let [ended, moved] = match (leg.status.filter(|_| was_running), to) {
            (Some(TripStatus::Success), Some(to)) => [Some(Change::Arrives(to)), None],
            (status, to) => {
                let failed = to.filter(|_| status == Some(TripStatus::Failure));
                let moved = match (place(leg.at), place(before.at)) {
                    (Some(at), _) if !before.has_begun => Some(Change::IsAt(at)),
                    (Some(at), was) if was != Some(at) => Some(Change::ComesTo(at)),
                    (None, Some(was)) => Some(Change::Leaves(was)),
                    _ => None,
                };
                [failed.map(Change::TripFails), moved]
            }
        };
        let [level, charging] = match (update, &self.battery) {
            (Some(BatteryUpdate { class, is_charging, .. }), Some(BatteryModel { levels, .. })) => {
                let was = driven.battery.and_then(BatteryReader::reading);
                let is_new = was.is_none_or(|(was_pct, _)| was_pct.total_cmp(&levels.level_pct(class)).is_ne());
                let was_charging = was.is_some_and(|(_, was_charging)| was_charging);
                let charging = (was_charging != is_charging).then_some(Change::Charging(is_charging));
                [is_new.then_some(Change::Level(levels, class)), charging]
            }
            _ => [None, None],
        };
        [ended, moved, level, charging]
    }

    /// What these changes are about. At the station, the battery may be charged or not.
    fn changed(&self, changes: [Option<Change<'_>>; 4]) -> Changed {
        let station = self.station.map(|station| self.places[station].as_str());
        let mut changed = Changed::default();
        for change in changes.into_iter().flatten() {
            match change {
                Change::Level(..) | Change::Charging(_) => changed.battery = true,
                Change::Arrives(place)
                | Change::TripFails(place)
                | Change::IsAt(place)
                | Change::ComesTo(place)
                | Change::Leaves(place) => {
                    changed.trip = true;
                    changed.battery |= station == Some(place);
                }
            }
        }
        changed
    }

    fn components<'p>(&self, driven: &[&'p dyn Process]) -> Driven<'p> {
        let battery = self.battery.as_ref().map(|battery| battery.process);
        Driven { battery: self.process(driven, battery), navigation: self.process(driven, self.trips.process) }
    }
}

/// The built-in components that the environment drives.
struct Driven<'a> {
    battery: Option<&'a BatteryReader>,
    navigation: Option<&'a Navigation>,
}

impl Environment for RobotEnvironment {
    type State = WorldState;

    fn driven(&self) -> &[ProcessId] {
        &self.driven
    }

    fn start(&self) -> WorldState {
        WorldState {
            has_begun: false,
            at: self.start,
            elapsed: 0,
            charge: Charge::default(),
            shown: None,
            changed: Changed::default(),
        }
    }

    fn moves(&self, state: &WorldState, driven: &[&dyn Process], instant: Instant) -> Vec<Move<WorldState>> {
        let (choices, components) = (self.choices(*state, driven, instant), self.components(driven));
        choices.map(|(leg, update)| self.made(*state, leg, update, &components)).collect()
    }

    /// The numbers are those of [`RobotEnvironment::made`].
    fn report(&self, id: ProcessId, report: u32, process: &mut dyn Process, _now: Duration) {
        let mut data = DriverData::default();
        match &self.battery {
            Some(battery) if battery.process == id => {
                data.battery = Some((battery.levels.level_pct(report as Class / 2), report % 2 == 1));
            }
            _ if self.localization == Some(id) => {
                data.place = report.checked_sub(1).map(|at| self.places[at as Spot].clone());
            }
            _ => data.trip = report.checked_sub(1).map(|status| STATUSES[status as usize]),
        }
        data.update(process, &self.known);
    }

    fn words(&self, state: &WorldState, driven: &[&dyn Process], instant: Instant) -> Vec<String> {
        let (choices, components) = (self.choices(*state, driven, instant), self.components(driven));
        let in_words = |(leg, update)| {
            let changes = self.changes(*state, leg, update, &components).into_iter().flatten();
            changes.map(Change::in_words).collect::<Vec<_>>().join(", ")
        };
        choices.map(in_words).collect()
    }

    /// As in a run, monitors are shown what has changed.
    fn shown(&self, before: &WorldState, after: &WorldState) -> Option<(ChannelId, Message)> {
        let Truths { channel, facts } = self.world.as_ref()?;
        let message = |state: &WorldState| Message::new(facts.iter().map(|fact| self.value(fact, state)));
        let now = message(after);
        (!before.has_begun || message(before) != now).then_some((*channel, now))
    }

    /// Components move when they receive a request or have an answer to send.
    fn may_stir(&self, _state: &WorldState, driven: &[&dyn Process]) -> bool {
        self.world.is_some()
            || driven.iter().map(|process| inside(*process).as_any()).any(|process| {
                process.downcast_ref::<BatteryReader>().is_none_or(BatteryReader::is_asked)
                    && process.downcast_ref::<Localization>().is_none_or(Localization::is_asked)
                    && process.downcast_ref::<Navigation>().is_none_or(Navigation::is_asked)
            })
    }
}
