//! Turns a run over classes of levels into one with concrete levels that a battery can have.
//!
//! In the search, only the class of a level is known. If one class is reached from another, not every level of it need
//! be reached from every level of the other, so a run of the search may be impossible for every battery. The levels of
//! a run are bounded by differences: a level lies in its class, and differs from an earlier one by a limited amount.
//! Such bounds have a solution unless they contradict each other on a cycle, which the Bellman–Ford algorithm finds.
//!
//! The classes of a run are finer than what happens in it depends on, and the search meets only the first of many runs
//! that differ in nothing else. So a level may have any value that is compared alike, not only those of its class.

use std::sync::Arc;
use std::time::Duration;

use channels::{Message, Process, ProcessId, Value};
use components::BatteryReader;
use explorer::{Path, PathStep};
use robot::BatteryState;

use super::battery::{Bounds, Since};
use super::environment::WorldState;
use super::faults::{inside_mut, is_out, without_faults};
use super::levels::{Class, FULL, Levels, Micros, Rates};

/// The number of an empty battery, from which all levels are measured.
const ZERO: usize = 0;

/// Units per millionth of a percent.
const UNITS: i64 = 1_000_000;

/// A bound: the level with the first number exceeds the second by at most this much, or by less than this if it is
/// strict.
#[derive(Clone, Copy, Debug)]
struct Bound {
    level: usize,
    base: usize,
    most: Micros,
    is_strict: bool,
}

/// A moment of a run at which the level may change.
#[derive(Clone, Copy, Debug)]
struct Moment {
    step: usize,
    class: Class,
    is_charging: bool,
    is_tick: bool,
}

/// What becomes of a run over classes of levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Concretized {
    /// A battery can have its levels.
    Possible,
    /// None can, and the classes are now finer.
    Refined,
    /// None can, however finely levels are distinguished.
    Spurious,
}

/// Gives a run concrete levels, also in the field with this index of what monitors are shown. If no battery can have
/// them, the classes are refined, so that another search does not find this run: counterexample-guided abstraction
/// refinement.
pub(super) fn concretize(
    path: &mut Path,
    levels: &mut Levels,
    bounds: &Bounds,
    shown_as: Option<usize>,
) -> Concretized {
    if let Some(possible) = run(path, levels, bounds, shown_as) {
        *path = possible;
        return Concretized::Possible;
    }
    match levels.refined(bounds.rates).filter(|refined| refined != levels) {
        Some(refined) => {
            *levels = refined;
            Concretized::Refined
        }
        None => Concretized::Spurious,
    }
}

/// The run with concrete levels. `None` if no battery can have them.
fn run(path: &Path, levels: &Levels, bounds: &Bounds, shown_as: Option<usize>) -> Option<Path> {
    let steps = path.steps();
    let moment = |(step, taken): (usize, &PathStep)| {
        let PathStep::Environment { state, .. } = taken else { return None };
        let (class, is_charging) = without_faults(state).get::<WorldState>()?.battery();
        let is_tick = matches!(steps.get(step + 1..step + 3), Some([PathStep::Wait(_), PathStep::Tick { .. }]));
        Some(Moment { step, class, is_charging, is_tick })
    };
    let moments: Vec<Moment> = steps.iter().enumerate().filter_map(moment).collect();
    // The classes themselves, if a battery can have them: their levels are easy to read.
    let own = |class| {
        let (low, high) = levels.ends(class);
        [(low, low != high), (high, low != high)]
    };
    let alike = |class| levels.alike(class, bounds.is_full_from);
    let solved = |ranges: &dyn Fn(Class) -> [(Micros, bool); 2]| {
        solve(&all_bounds(&moments, levels, bounds, ranges), moments.len() + 1)
    };
    let found = solved(&own).or_else(|| solved(&alike))?;
    let mut steps = steps.to_vec();
    for (Moment { step, class, is_charging, .. }, level_pct) in moments.into_iter().zip(found) {
        let PathStep::Environment { words, update, shown, .. } = &mut steps[step] else { continue };
        if let (Some((_, message)), Some(field)) = (shown, shown_as) {
            let fields = message.fields().iter().enumerate();
            let own = |(index, value): (usize, &Value)| if index == field { level_pct.into() } else { value.clone() };
            *message = Message::new(fields.map(own).collect::<Vec<_>>());
        }
        *words = words.replace(&levels.words(class), &format!("{} %", recording::decimals(level_pct, 6)));
        let with_class = Arc::clone(update);
        *update = Arc::new(move |id: ProcessId, process: &mut dyn Process, now: Duration| {
            let was_out = is_out(process);
            with_class(id, process, now);
            // A component that is out receives nothing.
            if !(was_out && is_out(process))
                && let Some(reader) = inside_mut(process).as_any_mut().downcast_mut::<BatteryReader>()
            {
                let (time, charge_pct, charging) = (Duration::ZERO, level_pct, is_charging);
                reader.update(&BatteryState { time, charge_pct, charging });
            }
        });
    }
    Some(Path::from(steps))
}

/// The bounds on the levels of a run, corresponding to those on classes in
/// [`BatteryModel::levels_after`](super::battery::BatteryModel::levels_after). `ranges` gives the levels that may stand
/// for a class: from the first to the second, or only between them.
fn all_bounds(
    moments: &[Moment],
    levels: &Levels,
    bounds: &Bounds,
    ranges: &dyn Fn(Class) -> [(Micros, bool); 2],
) -> Vec<Bound> {
    let mut all = Vec::new();
    // The number of the level at the last tick, and what the battery has done since.
    let (mut at_tick, mut since) = (ZERO, Since::Drained);
    for (index, &Moment { class, is_charging, is_tick, .. }) in moments.iter().enumerate() {
        let level = index + 1;
        let [(low, is_above), (high, is_below)] = ranges(class);
        all.push(Bound { level, base: ZERO, most: high, is_strict: is_below });
        all.push(Bound { level: ZERO, base: level, most: -low, is_strict: is_above });
        if index == 0 {
            all.extend([at_most(level, ZERO, bounds.start.1), at_most(ZERO, level, -bounds.start.0)]);
        } else {
            since = since.and(is_charging);
            // A full battery stays full.
            let gains = is_tick && levels.ends(class).0 < FULL;
            all.extend(bounds_since_tick(since, at_tick, level, gains, bounds.rates));
        }
        if is_tick || index == 0 {
            (at_tick, since) = (level, if is_charging { Since::Charged } else { Since::Drained });
        }
    }
    all
}

/// The bounds on a level that follow from those since the last tick. With `gains`, a battery that was charged
/// throughout must have gained something.
fn bounds_since_tick(since: Since, at_tick: usize, level: usize, gains: bool, rates: Rates) -> Vec<Bound> {
    let previous = level - 1;
    match since {
        Since::Drained => vec![at_most(level, previous, 0), at_most(at_tick, level, rates.drain)],
        Since::Charged => {
            let gain = gains.then(|| at_most(at_tick, level, -rates.charge));
            std::iter::once(at_most(previous, level, 0)).chain(gain).collect()
        }
        // From wherever it was since then, it has lost no more than a tick's drain.
        Since::Mixed => (at_tick..=previous).map(|earlier| at_most(earlier, level, rates.drain)).collect(),
    }
}

fn at_most(level: usize, base: usize, most: Micros) -> Bound {
    Bound { level, base, most, is_strict: false }
}

/// Levels that satisfy all bounds, in percent, each as high as possible; `None` if there are none.
fn solve(bounds: &[Bound], count: usize) -> Option<Vec<f64>> {
    // A level that is below another lies as large a step below it as possible, so that the levels are easy to read.
    let steps = std::iter::successors(Some(100_000 * UNITS), |step| (*step > 1).then_some(step / 10));
    let solved = |step: i64| {
        let mut found = vec![i64::MAX / 4; count];
        found[ZERO] = 0;
        for _ in 0..=count {
            let mut is_settled = true;
            for Bound { level, base, most, is_strict } in bounds {
                let limit = found[*base] + most * UNITS - if *is_strict { step } else { 0 };
                if limit < found[*level] {
                    (found[*level], is_settled) = (limit, false);
                }
            }
            if is_settled {
                return (found[ZERO] == 0).then_some(found);
            }
        }
        None
    };
    let found = steps.into_iter().find_map(solved)?;
    Some(found[1..].iter().map(|level| *level as f64 / (1e6 * UNITS as f64)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bound(level: usize, base: usize, most_pct: i64, is_strict: bool) -> Bound {
        Bound { level, base, most: most_pct * 1_000_000, is_strict }
    }

    #[test]
    fn levels_satisfy_their_bounds_and_are_easy_to_read() {
        // Above 30 %, then below it and at most 1 % lower.
        let mut bounds = vec![bound(1, 0, 31, true), bound(0, 1, -30, true), bound(2, 0, 30, true)];
        bounds.extend([bound(2, 1, 0, false), bound(1, 2, 1, false)]);
        assert_eq!(solve(&bounds, 3), Some(vec![30.9, 29.9]));
        // And above 29.95 %.
        bounds.push(Bound { level: 0, base: 2, most: -29_950_000, is_strict: true });
        assert!(solve(&bounds, 3).is_some_and(|found| found[1] > 29.95 && found[0] - found[1] <= 1.0));
    }

    #[test]
    fn bounds_that_contradict_each_other_have_no_solution() {
        // Above 30 %, and a tick later below 29 %, though it loses at most 1 %.
        let bounds = [bound(0, 1, -30, true), bound(2, 0, 29, true), bound(1, 2, 1, false), bound(1, 0, 100, false)];
        assert_eq!(solve(&bounds, 3), None);
    }
}
