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

pub(crate) use args::SimArgs;

#[cfg(feature = "dds")]
pub(crate) fn sim(args: &SimArgs) -> Result<ExitCode, Error> {
    let found = scenarios::scenario::find::find(&args.scenario)?;
    crate::run::piloted(&found, &args.options, &args.namespaces, |scenario| robot::join(args, scenario))
}

#[cfg(not(feature = "dds"))]
pub(crate) fn sim(_: &SimArgs) -> Result<ExitCode, Error> {
    Err(Error::refused(crate::domain::WITHOUT, crate::domain::HOW))
}
