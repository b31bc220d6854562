//! A run that was found, simulated: the environment's moves become settings and faults of the
//! scenario.
//!
//! Levels, damaged messages and other faults occur at the same times as in the run. The physics determine where the
//! robot is and how long its trips take; the scheduler determines the order of messages.

use std::time::Duration;

use channels::{ChannelId, EventKind, Verdict};
use components::TripStatus;
use explorer::{Damage, Path, PathStep};
use monitors::Outcome;
use runs::{Run, Switched};
use scenarios::Error;
use scenarios::scenario::schedule::{DriverData, quoted};
use scenarios::scenario::{AllowedFault, Found, Scenario};

use super::faults::{self, Switching};
use super::{Answer, Proof, Question, subject};

/// How much longer the run may take in the simulation. Chosen, not measured.
const LONGER: Duration = Duration::from_secs(60);

/// What the simulation shows about a run that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Physical {
    /// The tick at which the property is violated, if it is.
    pub tick: Option<u64>,
    /// The first difference from the run that was found, in words: `at tick 1 the robot is at …`.
    pub difference: Option<String>,
    /// The result of each property by then.
    pub outcomes: Vec<(String, Outcome)>,
    /// The changes to the scenario, as assignments.
    pub overrides: Vec<String>,
}

impl Proof {
    /// Runs the scenario with its physics and with the environment's moves as settings and faults. `None` without a
    /// robot, since there are no physics.
    ///
    /// # Errors
    /// An error in the scenario that shows only when it runs, or a run that cannot continue.
    pub fn with_physics(
        &self,
        question: &Question,
        answer: &Answer,
        run: &Path,
        found: &Found,
    ) -> Result<Option<Physical>, Error> {
        if self.scenario.premises.is_none() {
            return Ok(None);
        }
        let data = self.driver_data(answer, run)?;
        let end = duration(run) + LONGER;
        let mut overrides = self.realized(run, &data);
        overrides.extend(self.long_enough(end));
        let all: Vec<String> = self.scenario.origin.overrides.iter().chain(&overrides).cloned().collect();
        let scenario = Scenario::load_for_proof(found, &all)?;
        let mut expected = self.after_ticks(answer, run)?.into_iter();
        let mut run = Run::new(scenario.into(), self.scenario.file.seed, true)?;
        let places = subject::ground(&self.scenario, &self.system, None).places;
        let watched = run.properties().position(|name| name == question.property);
        let (mut violated_at, mut difference) = (None, None);
        while violated_at.is_none() && run.time() < end {
            run.step()?;
            let Some(tick) = run.events().iter().find(|event| event.kind == EventKind::Tick).map(|event| event.tick)
            else {
                continue;
            };
            if let Some(expected) = expected.next() {
                let mut simulated = DriverData::of(run.system());
                // The run has only the places that matter.
                simulated.place = simulated.place.filter(|place| places.contains(place));
                let differs = || differs(&expected, &simulated);
                difference = difference.or_else(|| Some(format!("at tick {tick} {}", differs()?)));
            }
            let verdict = watched.map(|watched| run.system().monitors()[watched].monitor.verdict());
            violated_at = (verdict == Some(Verdict::False)).then_some(tick);
        }
        Ok(Some(Physical { tick: violated_at, difference, outcomes: outcomes(&run), overrides }))
    }

    /// What the components have received after each tick of the run.
    fn after_ticks(&self, answer: &Answer, run: &Path) -> Result<Vec<DriverData>, Error> {
        let (steps, mut known) = (run.steps(), Vec::new());
        self.replayed(answer, run, |_, system| known.push(DriverData::inside(system, faults::inside)))?;
        let is_later = |step: &PathStep| matches!(step, PathStep::Environment { .. } | PathStep::Wait(_));
        let ticks = (0..steps.len()).filter(|step| matches!(steps[*step], PathStep::Tick { .. }));
        let ends = ticks.map(|tick| tick + steps[tick..].iter().position(is_later).unwrap_or(steps.len() - tick) - 1);
        Ok(ends.map(|end| known[end].clone()).collect())
    }

    /// The moves of the environment, as settings and faults.
    fn realized(&self, run: &Path, data: &[Option<DriverData>]) -> Vec<String> {
        let changes = faults::changes(run, &self.faults);
        let mut realized = Realized::default();
        let mut now = Duration::ZERO;
        let mut steps = run.steps().iter().zip(data).zip(changes).peekable();
        while let Some(((step, data), change)) = steps.next() {
            match step {
                PathStep::Wait(span) => now += *span,
                PathStep::Tick { .. } => {}
                PathStep::Environment { .. } => {
                    // Processes notice a move in the step that it begins: after the wait that follows it.
                    let wait = match steps.peek() {
                        Some(((PathStep::Wait(span), _), _)) => *span,
                        _ => Duration::ZERO,
                    };
                    if let Some(change) = change {
                        self.switch(change, now + wait, &mut realized);
                    }
                    let level = data.as_ref().and_then(|data| data.battery);
                    level.into_iter().for_each(|(level_pct, _)| realized.set_level(level_pct, self.before(now + wait)));
                }
                PathStep::Take { enabled, damage } => {
                    let channels::EnabledKind::Send(channel) = enabled.kind else { continue };
                    realized.faults.extend(self.damage(channel, *damage, now));
                }
            }
        }
        let Realized { mut faults, active, levels } = realized;
        faults.extend(active.into_iter().map(|(index, began)| self.as_fault(index, began, None)));
        let mut overrides = vec![format!("faults = [{}]", faults.join(", "))];
        if let Some((first, _)) = levels {
            // Only the faults change the level.
            overrides.push(format!("battery.initial_pct = {first}"));
            let rates = ["drain_pct_per_s", "standstill_drain_pct_per_s", "charge_pct_per_s"];
            overrides.extend(rates.map(|rate| format!("battery.{rate} = 0")));
        }
        overrides
    }

    /// A fault begins or ends. It is known as a fault only when it ends, with its duration.
    fn switch(&self, Switching { index, begins }: Switching, at: Duration, realized: &mut Realized) {
        match realized.active.iter().position(|(other, _)| *other == index).filter(|_| !begins) {
            Some(found) => {
                let (_, began) = realized.active.remove(found);
                realized.faults.push(self.as_fault(index, began, Some(at)));
            }
            None => realized.active.push((index, at)),
        }
    }

    /// The fault of a message that is damaged when it is sent.
    fn damage(&self, channel: ChannelId, damage: Damage, now: Duration) -> Option<String> {
        let (kind, more) = match damage {
            Damage::None => return None,
            Damage::Lost => ("message_lost", String::new()),
            Damage::Repeated => ("message_duplicated", String::new()),
            Damage::Held => {
                let hold_s = diagnostics::seconds(self.scenario.file.prove.messages.hold);
                ("message_delayed", format!(", delay_s = {hold_s}"))
            }
        };
        let ((from, to), at) = (self.system.topology().ends(channel), self.before(now));
        let when = format!("at_s = {at}, lasts_s = {}, times = 1", diagnostics::seconds(self.step()));
        Some(format!("{{ kind = '{kind}', from = '{from}', to = '{to}', {when}{more} }}"))
    }

    /// A fault of the run as one from the catalogue, with its times.
    fn as_fault(&self, index: usize, began: Duration, ended: Option<Duration>) -> String {
        let Switched { kind, name, .. } = &self.faults[index];
        let key = if *kind == AllowedFault::Mutant { "mutant" } else { "component" };
        let lasts = ended
            .map(|ended| format!(", lasts_s = {}", diagnostics::seconds(ended.saturating_sub(began).max(self.step()))));
        let (name, at, lasts) = (quoted(name), self.before(began), lasts.unwrap_or_default());
        format!("{{ kind = '{}', at_s = {at}, {key} = {name}{lasts} }}", kind.name())
    }

    /// The time, in seconds, at which a fault must begin to take effect at this time.
    fn before(&self, time: Duration) -> f64 {
        diagnostics::seconds(time.saturating_sub(self.step()))
    }

    fn step(&self) -> Duration {
        self.scenario.file.execution.step()
    }
}

/// The moves of the environment so far.
#[derive(Default)]
struct Realized {
    faults: Vec<String>,
    /// The active faults, with the times at which they began.
    active: Vec<(usize, Duration)>,
    /// The first level of the battery and the last one, in percent.
    levels: Option<(f64, f64)>,
}

impl Realized {
    /// The level from a time on, in seconds.
    fn set_level(&mut self, level_pct: f64, at: f64) {
        if self.levels.is_some_and(|(_, last)| last.total_cmp(&level_pct).is_ne()) {
            self.faults.push(format!("{{ kind = 'battery_level', at_s = {at}, level_pct = {level_pct} }}"));
        }
        self.levels = Some((self.levels.map_or(level_pct, |(first, _)| first), level_pct));
    }
}

fn outcomes(run: &Run) -> Vec<(String, Outcome)> {
    let outcomes = run.system().monitors().iter().map(|attached| Outcome::of(attached.monitor.as_ref()));
    run.properties().map(str::to_owned).zip(outcomes).collect()
}

pub(super) fn duration(run: &Path) -> Duration {
    let waits = run.steps().iter().map(|step| if let PathStep::Wait(span) = step { *span } else { Duration::ZERO });
    waits.sum()
}

/// The difference in the simulation, in words.
fn differs(expected: &DriverData, simulated: &DriverData) -> Option<String> {
    let place = |place: &Option<String>| place.as_ref().map_or("at no place".to_owned(), |place| format!("at {place}"));
    let trip = |trip: Option<TripStatus>| match trip {
        None => "has no trip",
        Some(TripStatus::Running) => "is on its way",
        Some(TripStatus::Success) => "has arrived",
        Some(TripStatus::Failure) => "has failed to arrive",
    };
    let differs =
        |found: String, physical: String| Some(format!("the robot {found}, and in the simulation it {physical}"));
    match () {
        () if expected.place != simulated.place => {
            differs(format!("is {}", place(&expected.place)), format!("is {}", place(&simulated.place)))
        }
        () if expected.trip != simulated.trip => {
            differs(trip(expected.trip).to_owned(), trip(simulated.trip).to_owned())
        }
        () => match (expected.battery, simulated.battery) {
            (Some((_, true)), Some((_, false))) => differs("is charged".to_owned(), "is not".to_owned()),
            (Some((_, false)), Some((_, true))) => differs("is not charged".to_owned(), "is".to_owned()),
            _ => None,
        },
    }
}
