//! The moments of a run that the paper's figures show.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use drawing::{ExecutionContext, Frame, Level};
use recording::{Detail, Follower, Header, RunView, conduct};
use reports::pictures::Camera;
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

/// Runs a scenario until all of its moments have occurred, and keeps the parts that the page shows.
pub(super) fn film(scenario: &Arc<Scenario>) -> Result<Film, Error> {
    let shots = || shots::SHOTS.iter().filter(|shot| shot.scenario == scenario.name);
    let run = Run::new(Arc::clone(scenario), SEED, true)?;
    let goes_on = |view: &RunView| {
        if shots().all(|shot| is_due(shot.when, view)) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let begin = |view: &RunView| Ok::<_, Error>(Filming::begin(view, shots().collect()));
    let (Filming { shots, taken, .. }, view) = conduct(run, Detail::Scenes, None, begin, goes_on)?;
    let stills = shots.into_iter().zip(taken).filter_map(|(shot, frame)| Some(Still { shot, frame: frame? }));
    Ok(Film { stills: stills.collect(), context: context(&view) })
}

/// A film that is being made.
struct Filming {
    camera: Camera,
    shots: Vec<&'static Shot>,
    /// The moments that have occurred, in the order of `shots`.
    taken: Vec<Option<Frame>>,
    ticks: u64,
    at_last_tick: Frame,
}

impl Filming {
    fn begin(view: &RunView, shots: Vec<&'static Shot>) -> Self {
        let camera = Camera::new(view);
        let at_last_tick = camera.frame(view, "");
        Self { camera, taken: vec![None; shots.len()], shots, ticks: view.ticks(), at_last_tick }
    }
}

impl Follower for Filming {
    type Error = Error;

    fn follow(&mut self, view: &RunView) -> Result<(), Error> {
        let Ok(()) = self.camera.follow(view);
        for (shot, taken) in self.shots.iter().zip(&mut self.taken) {
            if taken.is_none() && is_due(shot.when, view) {
                // The paper describes the state at the tick before a fault, and the fault is known only afterwards.
                let is_before = matches!(shot.when, When::BeforeFault(_));
                *taken = Some(if is_before { self.at_last_tick.clone() } else { self.camera.frame(view, "") });
            }
        }
        if view.ticks() != self.ticks {
            self.ticks = view.ticks();
            self.at_last_tick = self.camera.frame(view, "");
        }
        Ok(())
    }
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

/// Whether a moment has been reached, or is known to have passed.
fn is_due(when: When, view: &RunView) -> bool {
    let after = |time: Option<Duration>, seconds: f64| {
        time.is_some_and(|time| view.time() >= time + Duration::from_secs_f64(seconds))
    };
    match when {
        When::Start => true,
        When::BeforeFault(index) => view.faults().len() > index,
        When::AfterFault(index, seconds) => after(view.faults().get(index).map(|fault| fault.time), seconds),
        When::AfterRelease(index, seconds) => after(view.faults().get(index).and_then(|fault| fault.until), seconds),
        When::AfterVerdict(name, seconds) => {
            let monitor = view.monitors().find(|monitor| monitor.name() == name);
            after(monitor.and_then(|monitor| monitor.decision).map(|decision| decision.event.time), seconds)
        }
    }
}
