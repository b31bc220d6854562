//! A run that was found, simulated: the environment's moves become settings and faults of the
//! scenario.
//!
//! Levels, damaged messages and other faults occur at the same times as in the run. The physics determine where the
//! robot is and how long its trips take; the scheduler determines the order of messages.

use std::time::Duration;

use channels::{EventKind, Verdict};
use components::TripStatus;
use explorer::{Damage, Path, PathStep};
use monitors::Outcome;
use runs::Run;
use runs::Switched;
use scenarios::Error;
use scenarios::scenario::schedule::DriverData;
use scenarios::scenario::schedule::quoted;
use scenarios::scenario::{AllowedFault, Found, STEP, Scenario};

use super::faults::{self, Change};
use super::{Answer, Proof, Question, subject};

/// How much longer the run may take in the simulation.
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
        let told = self.told(answer, run)?;
        let end = duration(run) + LONGER;
        let mut overrides = self.realized(run, &told);
        overrides.extend(self.long_enough(end));
        let all: Vec<String> = self.scenario.origin.overrides.iter().chain(&overrides).cloned().collect();
        let scenario = Scenario::load_for_proof(found, &all)?;
        let mut expected = self.after_ticks(answer, run)?.into_iter();
        let mut run = Run::new(scenario.into(), self.scenario.file.seed, true)?;
        let places = subject::ground(&self.scenario, &self.system).places;
        let watched = run.properties().position(|name| name == question.property);
        let mut difference = None;
        while run.time() < end {
            run.step()?;
            let Some(tick) = run.events().iter().find(|event| event.kind == EventKind::Tick).map(|event| event.tick)
            else {
                continue;
            };
            if let Some(expected) = expected.next() {
                let mut told = DriverData::of(run.system());
                // The run knows only the places that matter.
                told.place = told.place.filter(|place| places.contains(place));
                let differs = || differs(&expected, &told);
                difference = difference.or_else(|| Some(format!("at tick {tick} {}", differs()?)));
            }
            let verdict = watched.map(|watched| run.system().monitors()[watched].monitor.verdict());
            if verdict == Some(Verdict::False) {
                let outcomes = outcomes(&run);
                return Ok(Some(Physical { tick: Some(tick), difference, outcomes, overrides }));
            }
        }
        let outcomes = outcomes(&run);
        Ok(Some(Physical { tick: None, difference, outcomes, overrides }))
    }

    /// What the components know after each tick of the run.
    fn after_ticks(&self, answer: &Answer, run: &Path) -> Result<Vec<DriverData>, Error> {
        let (steps, mut known) = (run.steps(), Vec::new());
        self.replayed(answer, run, |_, system| known.push(faults::told(system)))?;
        let is_later = |step: &PathStep| matches!(step, PathStep::Environment { .. } | PathStep::Wait(_));
        let ticks = (0..steps.len()).filter(|step| matches!(steps[*step], PathStep::Tick { .. }));
        let ends = ticks.map(|tick| tick + steps[tick..].iter().position(is_later).unwrap_or(steps.len() - tick) - 1);
        Ok(ends.map(|end| known[end].clone()).collect())
    }

    /// The moves of the environment, as settings and faults.
    fn realized(&self, run: &Path, told: &[Option<DriverData>]) -> Vec<String> {
        let topology = self.system.topology();
        let changes = faults::changes(run, &self.faults);
        let mut faults = Vec::new();
        // The times at which the active faults began.
        let mut active: Vec<(usize, Duration)> = Vec::new();
        let (mut now, mut level, mut first) = (Duration::ZERO, None, None);
        let mut steps = run.steps().iter().zip(told).zip(changes).peekable();
        while let Some(((step, told), change)) = steps.next() {
            match step {
                PathStep::Wait(span) => now += *span,
                PathStep::Tick { .. } => {}
                PathStep::Environment { .. } => {
                    let wait = match steps.peek() {
                        Some(((PathStep::Wait(span), _), _)) => *span,
                        _ => Duration::ZERO,
                    };
                    let felt = now + wait;
                    if let Some(Change { index, begins }) = change {
                        match active.iter().position(|(other, _)| *other == index).filter(|_| !begins) {
                            Some(found) => {
                                let (_, began) = active.remove(found);
                                faults.push(self.as_fault(index, began, Some(felt)));
                            }
                            None => active.push((index, felt)),
                        }
                    }
                    let Some((level_pct, _)) = told.as_ref().and_then(|told| told.battery) else { continue };
                    first = first.or(Some(level_pct));
                    if level.is_some_and(|level: f64| level.total_cmp(&level_pct).is_ne()) {
                        let at = before(felt);
                        faults.push(format!("{{ kind = 'battery_level', at_s = {at}, level_pct = {level_pct} }}"));
                    }
                    level = Some(level_pct);
                }
                PathStep::Take { enabled, damage } => {
                    let channels::EnabledKind::Send(channel) = enabled.kind else { continue };
                    let (kind, more) = match damage {
                        Damage::None => continue,
                        Damage::Lost => ("message_lost", String::new()),
                        Damage::Repeated => ("message_duplicated", String::new()),
                        Damage::Held => {
                            let hold_s = self.scenario.file.prove.messages.hold.as_secs_f64();
                            ("message_delayed", format!(", delay_s = {hold_s}"))
                        }
                    };
                    let ((from, to), at) = (topology.ends(channel), before(now));
                    let when = format!("at_s = {at}, lasts_s = {}, times = 1", STEP.as_secs_f64());
                    faults.push(format!("{{ kind = '{kind}', from = '{from}', to = '{to}', {when}{more} }}"));
                }
            }
        }
        faults.extend(active.into_iter().map(|(index, began)| self.as_fault(index, began, None)));
        let mut overrides = vec![format!("faults = [{}]", faults.join(", "))];
        if let Some(first) = first {
            // Only the faults change the level.
            overrides.push(format!("battery.initial_pct = {first}"));
            let rates = ["drain_pct_per_s", "standstill_drain_pct_per_s", "charge_pct_per_s"];
            overrides.extend(rates.map(|rate| format!("battery.{rate} = 0")));
        }
        overrides
    }

    /// A fault of the run as one from the catalogue, with its times.
    fn as_fault(&self, index: usize, began: Duration, ended: Option<Duration>) -> String {
        let Switched { kind, name, .. } = &self.faults[index];
        let key = if *kind == AllowedFault::Mutant { "mutant" } else { "component" };
        let lasts = ended.map(|ended| format!(", lasts_s = {}", ended.saturating_sub(began).max(STEP).as_secs_f64()));
        let (name, at, lasts) = (quoted(name), before(began), lasts.unwrap_or_default());
        format!("{{ kind = '{}', at_s = {at}, {key} = {name}{lasts} }}", kind.name())
    }
}

fn outcomes(run: &Run) -> Vec<(String, Outcome)> {
    let outcomes = run.system().monitors().iter().map(|attached| Outcome::of(attached.monitor.as_ref()));
    run.properties().map(str::to_owned).zip(outcomes).collect()
}

/// The time, in seconds, at which a fault must begin to take effect at this time.
fn before(time: Duration) -> f64 {
    time.saturating_sub(STEP).as_secs_f64()
}

/// How long a run takes.
pub(super) fn duration(run: &Path) -> Duration {
    let waits = run.steps().iter().map(|step| if let PathStep::Wait(span) = step { *span } else { Duration::ZERO });
    waits.sum()
}

/// The difference in the simulation, in words.
fn differs(expected: &DriverData, told: &DriverData) -> Option<String> {
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
        () if expected.place != told.place => {
            differs(format!("is {}", place(&expected.place)), format!("is {}", place(&told.place)))
        }
        () if expected.trip != told.trip => differs(trip(expected.trip).to_owned(), trip(told.trip).to_owned()),
        () => match (expected.battery, told.battery) {
            (Some((_, true)), Some((_, false))) => differs("is charged".to_owned(), "is not".to_owned()),
            (Some((_, false)), Some((_, true))) => differs("is not charged".to_owned(), "is".to_owned()),
            _ => None,
        },
    }
}
