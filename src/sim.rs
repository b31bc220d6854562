//! `steward sim SCENARIO`: the simulated robot as a robot of ROS 2, for whoever drives it from outside.

#[cfg(feature = "dds")]
mod action;
mod args;
#[cfg(feature = "dds")]
mod commands;
#[cfg(feature = "dds")]
mod frames;
#[cfg(feature = "dds")]
mod hub;
#[cfg(feature = "dds")]
mod navigation;
#[cfg(feature = "dds")]
mod pace;
#[cfg(feature = "dds")]
mod robot;
#[cfg(feature = "dds")]
mod topics;

use std::process::ExitCode;

use campaigns::Error;
#[cfg(feature = "dds")]
use runs::Others;

#[cfg(feature = "dds")]
use crate::{live, run};

pub(crate) use args::SimArgs;

#[cfg(feature = "dds")]
pub(crate) fn sim(args: &SimArgs) -> Result<ExitCode, Error> {
    let (found, options) = (scenarios::scenario::find::find(&args.scenario)?, &args.options);
    let Some(page) = args.board.page() else {
        return run::piloted(&found, options, &args.namespaces, |scenario| robot::join(args, scenario));
    };
    if args.namespaces.len() > 1 {
        return Err(Error::refused("a page shows one robot", "name one namespace"));
    }
    let joined = args.clone();
    live::session(found, &options.set, options.seed, &page, move |scenario| {
        let driver = robot::join(&joined, scenario)?.pop().expect("there is a robot in each namespace");
        Ok(Others::Pilot(driver))
    })
}

#[cfg(not(feature = "dds"))]
pub(crate) fn sim(_: &SimArgs) -> Result<ExitCode, Error> {
    Err(Error::refused(crate::domain::WITHOUT, crate::domain::HOW))
}
