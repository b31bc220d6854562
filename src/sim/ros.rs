//! The simulated robot in a DDS domain.

use std::process::ExitCode;

use campaigns::Error;
use partners::{BoxedController, PaceConfig, RobotConfig, Robots};
use runs::Partners;
use scenarios::scenario::{Scenario, find};

use crate::output::note;
use crate::serve_groot::ServeGrootArgs;
use crate::sim::SimArgs;
use crate::{live, run};

pub(crate) fn sim(args: &SimArgs) -> Result<ExitCode, Error> {
    let options = &args.options;
    let Some(page) = args.board.page() else {
        return run::controlled(&args.scenario, options, &args.namespaces, |scenario| args.join(scenario));
    };
    if args.namespaces.len() > 1 {
        return Err(Error::refused("a page shows one robot", "name one namespace"));
    }
    let found = find::find(&args.scenario)?;
    let joined = args.clone();
    live::session(found, &options.set, options.seed, &page, &ServeGrootArgs::default(), move |scenario| {
        let controller = joined.join(scenario)?.pop().expect("there is a robot in each namespace");
        Ok(Partners::Controller(controller))
    })
}

impl SimArgs {
    /// Joins the domain as a scenario's robot, or as one in each namespace, in their order.
    fn join(&self, scenario: &Scenario) -> Result<Vec<BoxedController>, scenarios::Error> {
        let pace = match self.lock_step {
            true => PaceConfig::LockStep { period_s: self.period, deadline_s: self.deadline },
            false => PaceConfig::Steady { speed: self.speed },
        };
        let config = RobotConfig {
            namespaces: self.namespaces.clone(),
            remapped: self.remapped.clone(),
            frames: self.frames.clone(),
            localizes: self.localize,
            navigates: self.navigate,
            publishes_map: !self.no_map,
            pace,
        };
        Robots::of(config, scenario)?.join(self.domain.options()?, note)
    }
}
