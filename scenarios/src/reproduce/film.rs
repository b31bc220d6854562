//! The moments of a run that the paper's figures show.

use std::sync::Arc;
use std::time::Duration;

use crate::Error;
use crate::draw::Frame;
use crate::live::{Live, StepError};
use crate::pictures::Camera;
use crate::scenario::Scenario;

use super::shots::{self, Shot, When};

/// The seed of the runs that are shown.
pub(super) const SEED: u64 = 1;

/// A moment of a run.
#[derive(Debug)]
pub(super) struct Still {
    pub(super) shot: &'static Shot,
    pub(super) frame: Frame,
}

/// The stills of a scenario, in the order of the figures; none of moments that did not come.
pub(super) fn film(scenario: &Arc<Scenario>) -> Result<Vec<Still>, Error> {
    let shots: Vec<&'static Shot> = shots::SHOTS.iter().filter(|shot| shot.scenario == scenario.name).collect();
    let mut taken: Vec<Option<Frame>> = vec![None; shots.len()];
    let mut live = Live::new(Arc::clone(scenario), SEED, true)?;
    let mut camera = Camera::new(&live);
    let mut at_last_tick = camera.frame(&live, SEED, "", false);
    while taken.iter().any(Option::is_none) && live.time() < scenario.file.execution.max_time {
        let ticks = live.system().ticks();
        live.step(None).map_err(|error| match error {
            StepError::Run(error) => Error::from(error),
            StepError::Budget(limit) => Error::Budget(limit),
            StepError::Record(source) => Error::Draw(source.to_string()),
        })?;
        camera.follow(&live);
        for (shot, frame) in shots.iter().zip(&mut taken).filter(|(_, frame)| frame.is_none()) {
            *frame = match shot.when {
                When::BeforeFault(index) => (live.faults().len() > index).then(|| at_last_tick.clone()),
                when => is_due(when, &live).then(|| camera.frame(&live, SEED, "", false)),
            };
        }
        if live.system().ticks() != ticks {
            at_last_tick = camera.frame(&live, SEED, "", false);
        }
    }
    Ok(shots.into_iter().zip(taken).filter_map(|(shot, frame)| Some(Still { shot, frame: frame? })).collect())
}

/// Whether a moment has come.
fn is_due(when: When, live: &Live) -> bool {
    let after = |time: Option<Duration>, seconds: f64| {
        time.is_some_and(|time| live.time() >= time + Duration::from_secs_f64(seconds))
    };
    match when {
        When::Start => true,
        When::BeforeFault(_) => false,
        When::AfterFault(index, seconds) => after(live.faults().get(index).map(|fault| fault.time), seconds),
        When::AfterRelease(index, seconds) => after(live.faults().get(index).and_then(|fault| fault.until), seconds),
        When::AfterVerdict(name, seconds) => {
            let watched = live.watched().iter().find(|watched| watched.name == name);
            after(watched.and_then(|watched| watched.decided.as_ref()).map(|event| event.time), seconds)
        }
    }
}
