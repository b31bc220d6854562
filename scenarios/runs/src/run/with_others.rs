//! A run in which others take part, in other programs.

use std::sync::Arc;
use std::time::Duration;

use remote::{Call, RemoteProcess};
use scenarios::Error;
use scenarios::scenario::Scenario;

use super::{Run, RunKind};
use crate::others::Others;
use crate::wiring::start_programs;

/// A run with others.
impl Run {
    /// The scenario at its start, as [`new`](Self::new) makes it, with others: in their time, and not the same every
    /// time. If somebody drives the robot, the tree gets no ticks; they still come, for the monitors.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together, or if it is no run for these others.
    pub fn among(scenario: Arc<Scenario>, seed: u64, watch: bool, others: Others) -> Result<Self, Error> {
        let mut run = match &others {
            Others::Nobody => return Self::new(scenario, seed, watch),
            Others::Pilot(_) => {
                let mut run = Self::new(scenario, seed, watch)?;
                run.hand_over()?;
                run
            }
            Others::Components(outside) => Self::beside(scenario, seed, watch, outside.run())?,
        };
        run.others = others;
        Ok(run)
    }

    /// A run beside the nodes of ROS 2 that are components of it, which know it by a number.
    fn beside(scenario: Arc<Scenario>, seed: u64, watch: bool, number: u64) -> Result<Self, Error> {
        let mut run = Self::prepare(scenario, seed, watch)?;
        if !matches!(run.kind, RunKind::Application) {
            let help = "run its application instead";
            return Err(Error::refused("a schedule has no time in which nodes could answer", help));
        }
        start_programs(&run.scenario, &mut run.system)?;
        for id in &run.remote {
            run.system.process_mut::<RemoteProcess>(*id).expect("it is one").begin(number);
        }
        Ok(run)
    }

    /// Takes the robot from the tree.
    fn hand_over(&mut self) -> Result<(), Error> {
        if self.world.robot().is_none() {
            let message = format!("the scenario {} has no robot that somebody could drive", self.scenario.name);
            return Err(Error::refused(message, "name one with a map, and without a schedule"));
        }
        self.ids.tree.iter().for_each(|ids| self.system.suspend(ids.tick_generator, true));
        Ok(())
    }

    /// Lets somebody else drive the robot, and the components that are nodes of ROS 2 say what has come; one that hangs
    /// hears it later. Returns what else has happened there, in words; none while it is not yet known.
    pub(super) fn follow_others(&mut self, now: Duration) -> Option<Vec<String>> {
        if let Some(pilot) = self.others.pilot() {
            return self.world.obey(pilot, &mut self.system);
        }
        let Self { others, remote, system, .. } = self;
        let Some(outside) = others.outside() else { return Some(Vec::new()) };
        let (answers, happened) = outside.hear(now)?;
        for id in remote {
            let is_suspended = system.is_suspended(*id);
            let Some(component) = system.process_mut::<RemoteProcess>(*id) else { continue };
            answers.iter().for_each(|answer| component.hear(answer));
            self.stirred |= !is_suspended && component.act();
        }
        Some(happened)
    }

    /// Sends out what the components that are nodes of ROS 2 were asked in this step.
    pub(super) fn ask_outside(&mut self) {
        let Self { others, remote, system, .. } = self;
        let Some(outside) = others.outside() else { return };
        let calls = remote.iter().filter_map(|id| Some(system.process_mut::<RemoteProcess>(*id)?.take_calls()));
        let calls: Vec<Call> = calls.flatten().collect();
        if !calls.is_empty() {
            outside.ask(calls);
        }
    }

    /// Whether somebody else drives the robot.
    pub(super) fn is_piloted(&self) -> bool {
        matches!(self.others, Others::Pilot(_))
    }

    /// Whether a step has begun that waits for others.
    pub(crate) fn is_waiting(&self) -> bool {
        self.is_waiting
    }

    /// Time has stood still since the last step, or since it last waited for others.
    pub(crate) fn resume(&mut self) {
        self.others.resume();
    }

    /// Cancels what nodes of ROS 2 are still doing for this run, and leaves them.
    pub(super) fn leave_others(&mut self) {
        for id in &self.remote {
            self.system.process_mut::<RemoteProcess>(*id).into_iter().for_each(RemoteProcess::conclude);
        }
        self.ask_outside();
        self.others.leave();
    }
}
