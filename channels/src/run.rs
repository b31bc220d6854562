//! Runs a system with a scheduler until it is quiet.

use crate::{ChannelSystem, Enabled, Event, ProcessId, RunError, Scheduler};

/// The timed state sequence of one run until the system is quiet; see [`ChannelSystem::run`].
#[derive(Debug)]
pub struct Run<'a> {
    system: &'a mut ChannelSystem,
    scheduler: &'a mut dyn Scheduler,
    budget: u64,
    taken: u64,
    enabled: Vec<Enabled>,
    /// The processes that moved in the last tenth of the budget.
    busy: Vec<ProcessId>,
    over: bool,
}

impl ChannelSystem {
    /// Runs the system until it is quiet and yields the events of the timed state sequence as they happen.
    ///
    /// After `budget` transitions the last item is [`RunError::Livelock`].
    pub fn run<'a>(&'a mut self, scheduler: &'a mut dyn Scheduler, budget: u64) -> Run<'a> {
        Run { system: self, scheduler, budget, taken: 0, enabled: Vec::new(), busy: Vec::new(), over: false }
    }
}

impl Run<'_> {
    fn livelock(&mut self) -> RunError {
        let name = |&id: &ProcessId| self.system.topology().name(id).to_owned();
        let mut processes: Vec<String> = self.busy.iter().map(name).collect();
        processes.sort();
        let time_s = format!("{:.2}", self.system.time().as_secs_f64());
        RunError::Livelock { steps: self.taken, time_s, processes }
    }

    fn move_on(&mut self) -> Result<Option<Event>, RunError> {
        let choice = self.scheduler.choose_in(self.system, &self.enabled);
        let enabled = self.enabled[choice].clone();
        self.taken += 1;
        let is_late = self.taken > self.budget - self.budget.div_ceil(10);
        if is_late && !self.busy.contains(&enabled.process) {
            self.busy.push(enabled.process);
        }
        self.system.take(&enabled)
    }
}

impl Iterator for Run<'_> {
    type Item = Result<Event, RunError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.over {
            self.system.list_enabled(&mut self.enabled);
            if self.enabled.is_empty() {
                self.over = true;
                return None;
            }
            if self.taken >= self.budget {
                self.over = true;
                return Some(Err(self.livelock()));
            }
            match self.move_on() {
                Ok(None) => {}
                Ok(Some(event)) => return Some(Ok(event)),
                Err(error) => {
                    self.over = true;
                    return Some(Err(error));
                }
            }
        }
        None
    }
}
