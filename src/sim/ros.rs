//! The simulated robot in a DDS domain.

mod commands;
mod exchange;
mod frames;
mod hub;
mod lifecycle;
mod navigation;
mod pace;
mod robot;
mod topics;

use std::process::ExitCode;

use campaigns::Error;
use runs::Partners;

use crate::serve_groot::ServeGrootArgs;
use crate::sim::SimArgs;
use crate::{live, run};

pub(crate) fn sim(args: &SimArgs) -> Result<ExitCode, Error> {
    let options = &args.options;
    let Some(page) = args.board.page() else {
        return run::controlled(&args.scenario, options, &args.namespaces, |scenario| robot::join(args, scenario));
    };
    if args.namespaces.len() > 1 {
        return Err(Error::refused("a page shows one robot", "name one namespace"));
    }
    let found = scenarios::scenario::find::find(&args.scenario)?;
    let joined = args.clone();
    live::session(found, &options.set, options.seed, &page, &ServeGrootArgs::default(), move |scenario| {
        let controller = robot::join(&joined, scenario)?.pop().expect("there is a robot in each namespace");
        Ok(Partners::Controller(controller))
    })
}
