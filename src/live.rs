//! `steward live SCENARIO`: a run in the browser, with which a person may interfere.

use std::process::ExitCode;

use campaigns::Error;
use clap::Args;
use cockpit::Cockpit;
use scenarios::scenario::find;
use scenarios::session::Session;

use crate::browser;
use crate::names::ScenarioName;
use crate::output::say;

/// Which scenario, and where its page is served.
#[derive(Debug, Args)]
pub(crate) struct LiveArgs {
    /// A scenario: a name (see `steward list`) or a file
    #[arg(value_name = "NAME|FILE", value_parser = ScenarioName, hide_possible_values = true)]
    scenario: String,
    /// The root seed; the scenario's own if not given
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Changes a value of the scenario: `battery.initial_pct=50`
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// The port of the page on this computer [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Does not open the page in the browser
    #[arg(long)]
    no_open: bool,
}

/// Serves the page until the program is interrupted.
pub(crate) fn live(args: &LiveArgs) -> Result<ExitCode, Error> {
    let (found, set, seed) = (find::find(&args.scenario)?, args.set.clone(), args.seed);
    let cockpit = Cockpit::open(move || Session::new(&found, &set, seed), args.port).map_err(refused)?;
    let address = cockpit.address();
    say(format!("{address}\nfor viewers: {}\nCtrl-C ends it.\n", cockpit.address_for_viewers()))?;
    if !args.no_open {
        browser::open(&address);
    }
    cockpit.serve().map_err(refused)?;
    Ok(ExitCode::SUCCESS)
}

fn refused(error: cockpit::Error) -> Error {
    match error {
        cockpit::Error::Scenario(error) => error.into(),
        cockpit::Error::Io { .. } => Error::refused(error.to_string(), "choose another port with `--port N`"),
    }
}
