//! `steward live --groot`: shows the tree of a program with BehaviorTree.CPP in the browser, and checks properties.

mod boards;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::Ground;
use cockpit::{Cockpit, Feed};
use editor::System;
use groot::{Blackboards, Client, GrootError, TreeSnapshot, TreeUpdate, TreeWatch};
use judging::{LogContext, VerdictObserver as _, VerificationResult, load, refuse_unknown};
use monitors::Property;
use recording::{Archive, Doubts, Ended, Follower as _, Origin, RunView, Step, TreeRun, fitting};
use tree_logs::LoggedTree;

use crate::interrupt::{self, HOST, pause};
use crate::live::groot_args::GrootArgs;
use crate::live::{PageArgs, serve_meanwhile};
use crate::output::{note, print_wrapped};
use crate::verify::announcer::{Announcer, Reactions};
use crate::verify::in_words;
use boards::{BoardBudget, entry_value};

/// How long a program may take to answer.
const TIMEOUT: Duration = Duration::from_secs(2);

/// The effects of requests on the program and on its other clients.
const COST: &str = "the program remembers its last 1000 changes from now on, and forgets those that it has told: \
                    whoever else asks for them, such as Groot2 when it records, gets only some. Breakpoints that \
                    another client has set stay armed. `--passive` only asks for statuses";
const PASSIVE: &str = "only the statuses of nodes are asked for, a hundred times a second: what changes in between is \
                       not seen, so that verdicts are unsure unless a single message violates a property. Breakpoints \
                       that another client has set stay armed";
/// The note about what verdicts leave open.
const LEFT_OPEN: &str = "what the program did before it was asked is not judged. It tells changes of status, and not the answers that repeat the one before: what \
                         `time_until` waits for is a change. Changes that it has told to another client are noticed \
                         only if a node then has a status that does not follow";

/// Shows and checks the tree of a program until Ctrl-C. Status 2 if a property has no verdict, otherwise 1 if one is
/// violated, or its verdict is unsure.
pub(crate) fn live(args: &GrootArgs, address: &str, page: &PageArgs) -> Result<ExitCode, Error> {
    interrupt::listen();
    let address = with_port(address);
    let client = Client::connect(&address, TIMEOUT).map_err(refused)?;
    note(if args.passive { PASSIVE } else { COST });
    let (mut program, snapshot) = TreeWatch::begin(client, args.passive).map_err(refused)?;
    let (feed, records) = Feed::new();
    let mut watched = WatchedTree::begin(args, &address, program.tree(), snapshot, (1, feed))?;
    serve_meanwhile(page.announce(Cockpit::follow(records, page.port))?);
    let mut status = 0;
    while interrupt::flow().is_continue() {
        let error = match program.next_update() {
            Ok(Some(update)) => {
                watched.take(update)?;
                program.read_every(watched.boards.period());
                continue;
            }
            Ok(None) => {
                watched.idle();
                pause();
                continue;
            }
            Err(error) => error,
        };
        note(&format!("{error}; waiting for it"));
        if matches!(error, GrootError::LargeBlackboards { .. }) {
            watched.leave_out_boards("they are too large")?;
        }
        watched.note_loss(&format!("the program does not answer: {error}"))?;
        let Some((again, snapshot)) = await_program(&address, args.passive, &mut watched)? else { break };
        note("it answers again");
        program = again;
        program.read_every(watched.boards.period());
        if *program.tree() == watched.tree {
            watched.take(TreeUpdate::Missing { why: "the program answers again".to_owned(), snapshot })?;
        } else {
            note("it runs another tree");
            let number = watched.number + 1;
            let (found, feed) = watched.finish()?;
            status = status.max(found);
            watched = WatchedTree::begin(args, &address, program.tree(), snapshot, (number, feed))?;
            program.read_every(watched.boards.period());
        }
    }
    match program.end() {
        Ok(last) => last.into_iter().try_for_each(|update| watched.take(update))?,
        Err(error) => watched.note_loss(&format!("the program does not answer: {error}"))?,
    }
    Ok(ExitCode::from(status.max(watched.finish()?.0)))
}

/// The address, with Groot2's port if it has none.
fn with_port(address: &str) -> String {
    let is_whole = |host: &str| !host.contains(':') || host.ends_with(']');
    let has_port = address.rsplit_once(':').is_some_and(|(host, _)| is_whole(host));
    if has_port { address.to_owned() } else { format!("{address}:{}", groot::PORT) }
}

/// Waits until the program answers again, or until Ctrl-C.
fn await_program(
    address: &str,
    is_passive: bool,
    watched: &mut WatchedTree,
) -> Result<Option<(TreeWatch, TreeSnapshot)>, Error> {
    while interrupt::flow().is_continue() {
        let client = Client::connect(address, TIMEOUT);
        if let Ok(again) = client.and_then(|client| TreeWatch::begin(client, is_passive)) {
            return Ok(Some(again));
        }
        watched.idle();
        (0..20).take_while(|_| interrupt::flow().is_continue()).for_each(|_| pause());
    }
    Ok(None)
}

/// A tree that is shown and checked.
struct WatchedTree {
    tree: LoggedTree,
    /// The number of trees so far.
    number: usize,
    run: TreeRun,
    view: RunView,
    properties: Vec<Property>,
    announcer: Announcer,
    page: Feed,
    archive: Option<Archive>,
    last_us: i64,
    boards: BoardBudget,
    /// The parts of blackboards that are not shown, in words.
    unshown: Vec<String>,
}

impl WatchedTree {
    fn begin(
        args: &GrootArgs,
        address: &str,
        tree: &LoggedTree,
        snapshot: TreeSnapshot,
        (number, page): (usize, Feed),
    ) -> Result<Self, Error> {
        let topology = TreeRun::topology(tree);
        let system = System::new(Arc::clone(&topology), Duration::ZERO);
        let properties = if args.properties.is_empty() { Vec::new() } else { load(&args.properties, &system, HOST)? };
        refuse_unknown(&properties)?;
        let root = &tree.nodes()[0];
        let about = format!("A program with BehaviorTree.CPP at {address}, whose tree begins with {}", root.name);
        let recorded = Some(format!("steward live --groot {address}"));
        let origin = Origin { recorded, began: bags::date(snapshot.at_us.saturating_mul(1000)), ..Origin::default() };
        let name = [root.name.clone(), about];
        let ground = Ground::Assumed("the program tells every change of status while it is asked".to_owned());
        let doubts = Doubts::about_losses(&properties, &topology).on(&ground);
        let (run, header, start) = TreeRun::begin(name, origin, (tree, &topology), snapshot.at_us, &properties, doubts);
        let view = fitting(RunView::new(header, start));
        page.begin(&view);
        let file = args.record.as_deref().map(|file| numbered(file, number));
        let archive = file.map(|file| Archive::begin(&file, &view)).transpose()?;
        let announcer = Announcer::new(false, Reactions::default());
        let last_us = snapshot.at_us;
        let tree = tree.clone();
        let (boards, unshown) = (BoardBudget::default(), Vec::new());
        let mut watched =
            Self { tree, number, run, view, properties, announcer, page, archive, last_us, boards, unshown };
        if args.passive {
            let step = watched.run.doubt(last_us, PASSIVE, &mut watched.properties);
            watched.add(step)?;
        }
        let step = watched.apply(&snapshot);
        watched.add(step)?;
        Ok(watched)
    }

    /// The statuses of a snapshot, as a step.
    fn apply(&mut self, snapshot: &TreeSnapshot) -> Step {
        self.last_us = snapshot.at_us;
        self.run.find(snapshot.at_us, snapshot.nodes.iter().map(|node| (node.status, node.last)))
    }

    fn take(&mut self, update: TreeUpdate) -> Result<(), Error> {
        let step = match update {
            TreeUpdate::Change(change) => {
                self.last_us = change.at_us;
                self.run.step(change, &mut self.properties)
            }
            TreeUpdate::Missing { why, snapshot } => {
                self.note_loss(&why)?;
                self.apply(&snapshot)
            }
            TreeUpdate::Blackboards(read) => return self.read(&read),
            _ => return Ok(()),
        };
        self.add(step)
    }

    /// Shows the entries of blackboards, and notes which are not shown.
    fn read(&mut self, read: &Blackboards) -> Result<(), Error> {
        let entries = read.boards.iter().flat_map(|(board, entries)| {
            entries.iter().map(|(key, value)| (board.clone(), key.clone(), entry_value(value)))
        });
        let step = self.run.read(self.last_us, entries);
        let unshown = self.boards.take(read, &step);
        self.add(step)?;
        unshown.into_iter().try_for_each(|words| self.leave_out(words))
    }

    fn leave_out_boards(&mut self, why: &str) -> Result<(), Error> {
        self.boards.give_up();
        let step = self.run.read(self.last_us, std::iter::empty());
        self.add(step)?;
        self.leave_out(format!("blackboards are not shown from here on: {why}"))
    }

    /// Notes, also on the page, that a part of blackboards is not shown.
    fn leave_out(&mut self, words: String) -> Result<(), Error> {
        note(&words);
        let step = self.run.note(self.last_us, words.clone());
        self.unshown.push(words);
        self.add(step)
    }

    /// Notes that changes may be missing until now.
    fn note_loss(&mut self, why: &str) -> Result<(), Error> {
        let step = self.run.miss(self.last_us, &format!("changes may be missing: {why}"), &mut self.properties);
        self.add(step)
    }

    fn add(&mut self, step: Step) -> Result<(), Error> {
        fitting(self.view.apply(step));
        let Ok(()) = self.page.follow(&self.view);
        self.archive.follow(&self.view)?;
        self.announcer.follow(self.view.time(), &self.properties, self.run.doubts(), &LogContext::without_ticks())
    }

    /// Updates the progress line without a new step.
    fn idle(&mut self) {
        self.announcer.idle(&self.properties, &LogContext::without_ticks());
    }

    /// Ends the recordings, and prints the verdicts. Returns the exit status, and the feed of the page.
    fn finish(mut self) -> Result<(u8, Feed), Error> {
        // The last step is recorded with the end.
        let last = self.run.note(self.last_us, "nobody asks the program any more".to_owned());
        fitting(self.view.apply(last));
        fitting(self.view.finish(self.run.finish(Ended::Recorded, &self.properties)));
        self.archive.follow(&self.view)?;
        self.archive.map_or(Ok(()), Archive::finish)?;
        let Ok(()) = self.page.follow(&self.view);
        if self.properties.is_empty() {
            self.unshown.iter().for_each(|text| note(text));
            return Ok((0, self.page));
        }
        let (end, left_open) = (self.run.end(), LEFT_OPEN.to_owned());
        let mut result = VerificationResult::of(self.properties, end, self.run.doubts(), left_open);
        result.notes.extend(self.unshown);
        result.notes.iter().for_each(|text| note(text));
        print_wrapped(in_words(&result))?;
        Ok((result.status(), self.page))
    }
}

/// The file of the tree with this number.
fn numbered(file: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return file.to_owned();
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let name = format!("{stem}-{number}");
    match file.extension() {
        Some(ending) => file.with_file_name(name).with_extension(ending),
        None => file.with_file_name(name),
    }
}

fn refused(error: GrootError) -> Error {
    let help = match error {
        GrootError::Connection { .. } => {
            "start the program, with a `BT::Groot2Publisher` of its tree; Nav2 has `<navigator>.groot_server_port`"
        }
        _ => "name the host and the port of a `BT::Groot2Publisher`, of BehaviorTree.CPP 4.6.2 or later",
    };
    Error::refused(error.to_string(), help)
}
