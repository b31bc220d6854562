//! The battery of a proof: classes of levels, and how the level may change.

use std::collections::BTreeSet;

use channels::ProcessId;
use explorer::Instant;

use super::levels::{Class, FULL, Levels, Micros, Rates};

/// The battery and its driver, with levels that are divided into classes.
#[derive(Clone, Debug)]
pub(crate) struct BatteryModel {
    pub(crate) process: ProcessId,
    pub(crate) levels: Levels,
    /// The bounds of its level; `None` if it may jump.
    pub(crate) bounds: Option<Bounds>,
}

#[derive(Clone, Debug)]
pub(crate) struct Bounds {
    pub(crate) rates: Rates,
    /// The lowest and the highest level at the start.
    pub(crate) start: (Micros, Micros),
    /// From this level on, it may stop charging at the station.
    pub(crate) is_full_from: Micros,
}

/// A battery whose level is bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Charge {
    pub(super) level: Class,
    /// The level at the last tick or, if it was both charged and drained since then, the highest since then: it has
    /// lost no more than a tick's drain from there.
    pub(super) reference: Class,
    pub(super) is_charging: bool,
    pub(super) since: Since,
}

/// What a battery has done throughout the time since the last tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Since {
    /// It was not charged.
    #[default]
    Drained,
    Charged,
    /// Both, one after the other.
    Mixed,
}

/// What the battery's driver reports after a move.
#[derive(Clone, Copy, Debug)]
pub(super) struct BatteryUpdate {
    pub(super) class: Class,
    pub(super) is_charging: bool,
    pub(super) charge: Charge,
}

impl BatteryModel {
    /// A battery whose level may jump. `None` if there are too many classes of levels.
    pub(super) fn free(process: ProcessId, thresholds: &BTreeSet<Micros>) -> Option<Self> {
        Some(Self { process, levels: Levels::new(thresholds, [], None)?, bounds: None })
    }

    /// A battery whose level is bounded. `None` if there are too many classes of levels.
    pub(super) fn bounded(process: ProcessId, thresholds: &BTreeSet<Micros>, bounds: Bounds) -> Option<Self> {
        let Bounds { rates, start: (low, high), is_full_from } = bounds;
        let levels = Levels::new(thresholds, [low, high, is_full_from], Some(rates))?;
        Some(Self { process, levels, bounds: Some(bounds) })
    }

    /// What the driver may report after a move from `charge`, which is `None` before the first one. The battery is
    /// charged only if the robot `is_docked`.
    pub(super) fn updates(
        &self,
        charge: Option<Charge>,
        is_docked: bool,
        is_driving: bool,
        instant: Instant,
    ) -> Vec<BatteryUpdate> {
        let mut updates = Vec::new();
        let charging: &[bool] = if is_docked { &[false, true] } else { &[false] };
        let Some(bounds) = &self.bounds else {
            // Whatever the level was before: nothing about it is remembered.
            let of_class = |class| charging.iter().map(move |&is_charging| (class, is_charging));
            let all = (0..self.levels.len()).flat_map(of_class);
            let update = |(class, is_charging)| BatteryUpdate { class, is_charging, charge: Charge::default() };
            return all.map(update).collect();
        };
        for &is_charging in charging {
            for class in self.levels_after(bounds, charge, is_charging, instant) {
                // A docked robot is charged until it is full or sets out.
                if is_docked && !is_charging && !is_driving && class < self.levels.class(bounds.is_full_from) {
                    continue;
                }
                let charge = Charge::after(charge, class, is_charging, instant);
                updates.push(BatteryUpdate { class, is_charging, charge });
            }
        }
        updates
    }

    /// The possible classes of the level at an instant.
    fn levels_after(&self, bounds: &Bounds, charge: Option<Charge>, is_charging: bool, instant: Instant) -> Vec<Class> {
        let Bounds { rates: Rates { drain, charge: gain }, start, .. } = *bounds;
        let Some(Charge { level, reference, since, .. }) = charge else {
            return (self.levels.class(start.0)..=self.levels.class(start.1)).collect();
        };
        // A battery that is charged throughout a tick gains at least this much.
        let gain = if instant == Instant::Tick { gain } else { 0 };
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
    /// The charge after a move from `before`, which is `None` before the first one.
    fn after(before: Option<Self>, level: Class, is_charging: bool, instant: Instant) -> Self {
        let Some(before) = before.filter(|_| instant != Instant::Tick) else {
            let since = if is_charging { Since::Charged } else { Since::Drained };
            return Self { level, reference: level, is_charging, since };
        };
        let since = before.since.and(is_charging);
        let highest = before.reference.max(before.level).max(level);
        Self { level, reference: if since == Since::Mixed { highest } else { before.reference }, is_charging, since }
    }
}
