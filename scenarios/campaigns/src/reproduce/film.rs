//! The moments of a run that the paper's figures show.

use std::sync::Arc;
use std::time::Duration;

use drawing::{ExecutionContext, Frame, Level};
use recording::{Detail, Follower, Header, RunView};
use reports::pictures::Camera;
use runs::FITS;
use runs::Run;
use scenarios::scenario::Scenario;

use super::shots::{self, Shot, When};
use crate::Error;

/// The seed of the runs that are shown.
pub(super) const SEED: u64 = 1;

/// A moment of a run.
#[derive(Debug)]
pub(super) struct Still {
    pub(super) shot: &'static Shot,
    pub(super) frame: Frame,
}

/// The parts of a run that the page shows.
#[derive(Debug)]
pub(super) struct Film {
    /// In the order of the figures, without moments that did not occur.
    pub(super) stills: Vec<Still>,
    /// The system that ran.
    pub(super) context: ExecutionContext,
}

/// Runs a scenario and keeps the parts that the page shows.
pub(super) fn film(scenario: &Arc<Scenario>) -> Result<Film, Error> {
    let shots: Vec<&'static Shot> = shots::SHOTS.iter().filter(|shot| shot.scenario == scenario.name).collect();
    let mut taken: Vec<Option<Frame>> = vec![None; shots.len()];
    let mut run = Run::new(Arc::clone(scenario), SEED, true)?;
    let start = run.record(Detail::Scenes);
    let mut view = RunView::new(run.header(), start).expect(FITS);
    let mut camera = Camera::new(&view);
    let mut at_last_tick = camera.frame(&view, "");
    while taken.iter().any(Option::is_none) && view.time() < scenario.file.execution.max_time {
        let ticks = view.ticks();
        run.step().map_err(scenarios::Error::from)?;
        view.apply(run.record(Detail::Scenes)).expect(FITS);
        let Ok(()) = camera.follow(&view);
        for (shot, frame) in shots.iter().zip(&mut taken).filter(|(_, frame)| frame.is_none()) {
            // The paper describes the state at the tick before a fault, and the fault is known only afterwards.
            *frame = match shot.when {
                When::BeforeFault(index) => (view.faults().len() > index).then(|| at_last_tick.clone()),
                when => is_due(when, &view).then(|| camera.frame(&view, "")),
            };
        }
        if view.ticks() != ticks {
            at_last_tick = camera.frame(&view, "");
        }
    }
    let stills = shots.into_iter().zip(taken).filter_map(|(shot, frame)| Some(Still { shot, frame: frame? }));
    Ok(Film { stills: stills.collect(), context: context(&view) })
}

/// The processes of a run and their channels, without the nodes of the tree.
fn context(view: &RunView) -> ExecutionContext {
    let (topology, Header { skills, components, .. }) = (view.topology(), view.header());
    let level = |name: &str| match name {
        "TickGenerator" | "BT" => Some(Level::TaskPlot),
        name if skills.iter().any(|skill| skill == name) => Some(Level::Skill),
        name => components.iter().any(|component| component == name).then_some(Level::Component),
    };
    let named = |process| topology.name(process).to_owned();
    let processes: Vec<(String, Level)> =
        topology.processes().filter_map(|process| Some((named(process), level(topology.name(process))?))).collect();
    let place = |name: &str| processes.iter().position(|process| process.0 == name);
    let ends = topology.channels().map(|channel| topology.ends(channel));
    let channels = ends.filter_map(|(from, to)| Some((place(from)?, place(to)?))).collect();
    ExecutionContext { processes, channels }
}

/// Whether a moment has been reached.
fn is_due(when: When, view: &RunView) -> bool {
    let after = |time: Option<Duration>, seconds: f64| {
        time.is_some_and(|time| view.time() >= time + Duration::from_secs_f64(seconds))
    };
    match when {
        When::Start => true,
        When::BeforeFault(_) => false,
        When::AfterFault(index, seconds) => after(view.faults().get(index).map(|fault| fault.time), seconds),
        When::AfterRelease(index, seconds) => after(view.faults().get(index).and_then(|fault| fault.until), seconds),
        When::AfterVerdict(name, seconds) => {
            let monitor = view.monitors().find(|monitor| monitor.name() == name);
            after(monitor.and_then(|monitor| monitor.decision).map(|decision| decision.event.time), seconds)
        }
    }
}
