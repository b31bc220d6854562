//! `steward live`: a run in the browser, in which a person may intervene, or one or two recordings.

pub(crate) mod groot_args;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use campaigns::Error;
use clap::Args;
use cockpit::{Board, Cockpit, Feed};
use diagnostics::Unfinished;
use judging::ShownRun;
use recording::{Recording, RecordingError, RunView};
use runs::{Partners, Session};
use scenarios::scenario::{Found, Scenario, find};

use crate::bag_tree::BagTreeArgs;
use crate::browser;
use crate::interrupt;
use crate::names;
use crate::output::{note, note_elsewhere, print_wrapped};
use crate::run::BesideArgs;
use crate::serve_groot::{self as serve, ServeGrootArgs};
use groot_args::GrootArgs;

/// The run or runs to show, and where their page is served.
#[derive(Debug, Args)]
pub(crate) struct LiveArgs {
    /// A scenario: a name (see `steward list`) or a file. Or a recording, finished or growing, or a log of
    /// BehaviorTree.CPP, or with `--tree` a ROS 2 bag; two are shown side by side
    #[arg(value_name = "NAME|FILE", required_unless_present = "groot", num_args = 1..=2,
          value_parser = names::SCENARIOS, hide_possible_values = true)]
    runs: Vec<String>,
    /// The root seed; by default the scenario's own
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Changes a value of the scenario: `battery.initial_pct=50`
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    tree: BagTreeArgs,
    #[command(flatten)]
    beside: BesideArgs,
    #[command(flatten)]
    serve: ServeGrootArgs,
    #[command(flatten)]
    pub(crate) groot: GrootArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
}

/// Where a page is served.
#[derive(Clone, Debug, Args)]
pub(crate) struct PageArgs {
    /// The port of the page on this computer [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub(crate) port: u16,
    /// Does not open the page in the browser
    #[arg(long)]
    no_open: bool,
}

impl PageArgs {
    /// Prints the addresses of the page, and opens it.
    pub(crate) fn announce(&self, cockpit: Result<Cockpit, cockpit::Error>) -> Result<Cockpit, Error> {
        let cockpit = cockpit.map_err(refused)?;
        let address = cockpit.address();
        print_wrapped(format!("{address}\nfor viewers: {}\nCtrl-C ends it.\n", cockpit.address_for_viewers()))?;
        if !self.no_open {
            browser::open(&address);
        }
        Ok(cockpit)
    }
}

/// Whether there is a page, and on which port.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct BoardArgs {
    /// Shows the progress on a page in the browser
    #[arg(long)]
    live: bool,
    /// The port of that page on this computer [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true, requires = "live")]
    port: u16,
    /// Does not open that page in the browser
    #[arg(long, requires = "live")]
    no_open: bool,
}

impl BoardArgs {
    /// The page, if one was requested.
    pub(crate) fn open(&self, title: &str) -> Result<Option<Board>, Error> {
        if !self.live {
            return Ok(None);
        }
        let board = Board::open(title, self.port).map_err(refused)?;
        self.show("the progress is shown", &board.address());
        Ok(Some(board))
    }

    /// Notes the address of the page, and opens it.
    fn show(&self, what: &str, address: &str) {
        note(&format!("{what} at {address}"));
        if !self.no_open {
            browser::open(address);
        }
    }

    /// Where the page is served, if one was requested.
    #[cfg(feature = "dds")]
    pub(crate) fn page(&self) -> Option<PageArgs> {
        self.live.then_some(PageArgs { port: self.port, no_open: self.no_open })
    }

    /// Waits until the program is interrupted, if there is a page that goes on until then.
    pub(crate) fn stay(&self) {
        if self.live && interrupt::flow().is_continue() {
            note("Ctrl-C ends the page");
            while interrupt::flow().is_continue() {
                interrupt::HOST.pause();
            }
        }
    }

    /// Whether a page was requested.
    pub(crate) fn is_live(&self) -> bool {
        self.live
    }

    /// Shows a run from its start, as long as the program goes on.
    pub(crate) fn feed(&self, start: &RunView) -> Result<ShownRun, Error> {
        let (feed, records) = Feed::new();
        feed.begin(start);
        let cockpit = Cockpit::follow(records, self.port).map_err(refused)?;
        self.show("the page is", &cockpit.address());
        serve_meanwhile(cockpit);
        Ok(Box::new(feed))
    }
}

/// Serves the page until the program is interrupted.
pub(crate) fn live(args: &LiveArgs) -> Result<ExitCode, Error> {
    match args.runs.as_slice() {
        recordings if recordings.iter().all(|name| is_recording(Path::new(name)) || args.tree.is_named()) => {
            if args.seed.is_some() || !args.set.is_empty() || args.beside.use_sim_time {
                let help = "leave `--seed`, `--set` and `--use-sim-time` out, or name a scenario";
                return Err(Error::refused("a recording cannot be changed", help));
            }
            if args.serve.is_given() {
                return Err(Error::refused("`--serve-groot` is for the run of a scenario", "name a scenario"));
            }
            let recordings: Vec<PathBuf> = recordings.iter().map(PathBuf::from).collect();
            let tree = args.tree.load(&recordings)?;
            let open = move |path: &Path| Recording::open_with(path, tree.as_ref());
            serve_page(Cockpit::replay(&recordings, open, args.page.port), &args.page)
        }
        [scenario] => {
            let beside = args.beside.clone();
            let found = find::find(scenario)?;
            let join = move |scenario: &Scenario| {
                note_elsewhere(scenario);
                beside.join(scenario)
            };
            session(found, &args.set, args.seed, &args.page, &args.serve, join)
        }
        _ => {
            let help = "record each run: `steward run NAME --record NAME.rec`";
            Err(Error::refused("only recordings can be shown side by side", help))
        }
    }
}

/// Serves the page of a session of a scenario, with the partners that `join` finds for it, until the program is
/// interrupted.
pub(crate) fn session<J>(
    found: Found,
    set: &[String],
    seed: Option<u64>,
    page: &PageArgs,
    serve: &ServeGrootArgs,
    join: J,
) -> Result<ExitCode, Error>
where
    J: Fn(&Scenario) -> Result<Partners, scenarios::Error> + Send + 'static,
{
    let set = set.to_vec();
    let server = serve.open()?;
    let begin = move || {
        let session = Session::with_partners(&found, &set, seed, &join)?;
        let Some(server) = &server else { return Ok(session) };
        serve::check(session.view().header())?;
        Ok(session.with_audience(serve::audience(Arc::clone(server))))
    };
    serve_page(Cockpit::open(begin, page.port), page)
}

fn serve_page(cockpit: Result<Cockpit, cockpit::Error>, page: &PageArgs) -> Result<ExitCode, Error> {
    let interrupted = interrupt::listen();
    let cockpit = page.announce(cockpit)?;
    cockpit.serve_until(interrupted).map_err(refused)?;
    Ok(ExitCode::SUCCESS)
}

/// Serves a page as long as the program goes on.
pub(crate) fn serve_meanwhile(cockpit: Cockpit) {
    std::thread::spawn(move || {
        if let Err(error) = cockpit.serve() {
            note(&format!("the page is no longer shown: {error}"));
        }
    });
}

/// Whether a file is a recording, will become one, or has the name of one.
fn is_recording(path: &Path) -> bool {
    let is_named = path.extension().is_some_and(|ending| ending == "rec" || ending == "mcap");
    is_named || !path.exists() && Unfinished::of(path).is_some() || {
        matches!(Recording::open(path), Ok(_) | Err(RecordingError::Version { .. } | RecordingError::TreeLog(_)))
    }
}

fn refused(error: cockpit::Error) -> Error {
    match error {
        cockpit::Error::Scenario(error) => error.into(),
        cockpit::Error::Recording(error) => reports::Error::from(error).into(),
        cockpit::Error::Io { .. } => Error::refused(error.to_string(), "choose another port with `--port N`"),
    }
}
