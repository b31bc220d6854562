//! `steward live --groot`: the tree that a program with BehaviorTree.CPP runs, in the browser, and checked meanwhile.

mod boards;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use campaigns::Error;
use channels::Ground;
use cockpit::Cockpit;
use editor::System;
use groot::{Blackboards, Client, FoundStatuses, GrootError, TreeNews, TreeWatch};
use monitors::Property;
use recording::{Archive, Doubts, Ended, Follower as _, Origin, RunView, Step, TreeRun};
use runs::FITS;
use tree_logs::LoggedTree;

use crate::interrupt;
use crate::live::groot_args::GrootArgs;
use crate::live::{PageArgs, serve_meanwhile};
use crate::output::{note, print_wrapped};
use crate::verify::announcer::{Announcer, Reactions};
use crate::verify::around::Around;
use crate::verify::growing::pause;
use crate::verify::in_words;
use crate::verify::judge::{Verified, load};
use crate::verify::live_page::LivePage;
use crate::verify::tree_log::refuse_unknown;
use boards::{BoardBudget, told};

/// How long a program may take to answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// What asking does to the program, and to others who ask it.
const COST: &str = "the program remembers its last 1000 changes from now on, and forgets those that it has told: \
                    whoever else asks for them, such as Groot2 when it records, gets only some. Breakpoints that \
                    another client has set stay armed. `--passive` only asks for statuses";
const PASSIVE: &str = "only the statuses of nodes are asked for, a hundred times a second: what changes in between is \
                       not seen, so that verdicts are unsure unless a single message violates a property. Breakpoints \
                       that another client has set stay armed";
/// What verdicts leave open.
const LEFT_OPEN: &str = "what the program did before it was asked is not judged. It tells changes of status, and not the answers that repeat the one before: what \
                         `time_until` waits for is a change. Changes that it has told to another client are noticed \
                         only if a node then has a status that does not follow";

/// Shows and checks what a program tells, until Ctrl-C. Status 2 if a property has no verdict, otherwise 1 if one is
/// violated, or its verdict is unsure.
pub(crate) fn live(args: &GrootArgs, address: &str, page: &PageArgs) -> Result<ExitCode, Error> {
    interrupt::listen();
    let address = with_port(address);
    let client = Client::connect(&address, PATIENCE).map_err(refused)?;
    note(if args.passive { PASSIVE } else { COST });
    let (mut program, found) = TreeWatch::begin(client, args.passive).map_err(refused)?;
    let mut watched = Watched::begin(args, &address, program.tree(), found, 1)?;
    let shown = show(page, &watched.shown)?;
    let mut status = 0;
    while interrupt::flow().is_continue() {
        let error = match program.news() {
            Ok(Some(news)) => {
                watched.take(news)?;
                program.read_every(watched.boards.period());
                continue;
            }
            Ok(None) => {
                watched.idle()?;
                pause();
                continue;
            }
            Err(error) => error,
        };
        note(&format!("{error}; waiting for it"));
        if matches!(error, GrootError::LargeBlackboards { .. }) {
            watched.leave_out_boards("they are too large")?;
        }
        watched.lose(&format!("the program does not answer: {error}"))?;
        let Some((again, found)) = await_program(&address, args.passive, &mut watched)? else { break };
        note("it answers again");
        program = again;
        program.read_every(watched.boards.period());
        if *program.tree() == watched.tree {
            watched.take(TreeNews::Missing { why: "the program answers again".to_owned(), found })?;
        } else {
            note("it runs another tree");
            let next = Watched::begin(args, &address, program.tree(), found, watched.number + 1)?;
            program.read_every(next.boards.period());
            status = status.max(std::mem::replace(&mut watched, next).finish()?);
            // If nobody takes it, the page has ended.
            let _ = shown.send(watched.shown.clone());
        }
    }
    match program.end() {
        Ok(last) => last.into_iter().try_for_each(|news| watched.take(news))?,
        Err(error) => watched.lose(&format!("the program does not answer: {error}"))?,
    }
    status = status.max(watched.finish()?);
    Ok(ExitCode::from(status))
}

/// With Groot2's port, if the address has none.
fn with_port(address: &str) -> String {
    let is_whole = |host: &str| !host.contains(':') || host.ends_with(']');
    let has_port = address.rsplit_once(':').is_some_and(|(host, _)| is_whole(host));
    if has_port { address.to_owned() } else { format!("{address}:{}", groot::PORT) }
}

/// Serves the page, which shows a recording, and then each one that is sent.
fn show(page: &PageArgs, first: &Path) -> Result<Sender<PathBuf>, Error> {
    let (shown, shows) = channel();
    serve_meanwhile(page.announce(Cockpit::follow(first, shows, page.port()))?);
    Ok(shown)
}

/// Waits until the program answers again, or somebody presses Ctrl-C.
fn await_program(
    address: &str,
    is_passive: bool,
    watched: &mut Watched,
) -> Result<Option<(TreeWatch, FoundStatuses)>, Error> {
    while interrupt::flow().is_continue() {
        let client = Client::connect(address, PATIENCE);
        if let Ok(again) = client.and_then(|client| TreeWatch::begin(client, is_passive)) {
            return Ok(Some(again));
        }
        watched.idle()?;
        (0..20).take_while(|_| interrupt::flow().is_continue()).for_each(|_| pause());
    }
    Ok(None)
}

/// A tree that is shown and checked.
struct Watched {
    tree: LoggedTree,
    /// How many trees have been shown.
    number: usize,
    run: TreeRun,
    view: RunView,
    properties: Vec<Property>,
    announcer: Announcer,
    page: LivePage,
    /// The recording that the page shows.
    shown: PathBuf,
    archive: Option<Archive>,
    last_us: i64,
    boards: BoardBudget,
    /// What is not shown of blackboards, in words.
    unshown: Vec<String>,
}

impl Watched {
    fn begin(
        args: &GrootArgs,
        address: &str,
        tree: &LoggedTree,
        found: FoundStatuses,
        number: usize,
    ) -> Result<Self, Error> {
        let topology = TreeRun::topology(tree);
        let system = System::new(Arc::clone(&topology), Duration::ZERO);
        let properties = if args.properties.is_empty() { Vec::new() } else { load(&args.properties, &system)? };
        refuse_unknown(&properties)?;
        let root = &tree.nodes()[0];
        let about = format!("A program with BehaviorTree.CPP at {address}, whose tree begins with {}", root.name);
        let recorded = Some(format!("steward live --groot {address}"));
        let origin = Origin { recorded, began: bags::date(found.at_us.saturating_mul(1000)), ..Origin::default() };
        let name = [root.name.clone(), about];
        let ground = Ground::Assumed("the program tells every change of status while it is asked".to_owned());
        let doubts = Doubts::about_losses(&properties, &topology).on(&ground);
        let (run, header, start) = TreeRun::begin(name, origin, (tree, &topology), found.at_us, &properties, doubts);
        let view = RunView::new(header, start).expect(FITS);
        let page = LivePage::begin(&view)?;
        let file = args.record.as_deref().map(|file| numbered(file, number));
        let archive = file.map(|file| Archive::begin(&file, &view)).transpose()?;
        let announcer = Announcer::new(false, Reactions::default());
        let (shown, last_us) = (page.recording(), found.at_us);
        let tree = tree.clone();
        let (boards, unshown) = (BoardBudget::default(), Vec::new());
        let mut watched =
            Self { tree, number, run, view, properties, announcer, page, shown, archive, last_us, boards, unshown };
        if args.passive {
            let step = watched.run.doubt(last_us, PASSIVE, &mut watched.properties);
            watched.add(step)?;
        }
        let step = watched.find(&found);
        watched.add(step)?;
        Ok(watched)
    }

    fn find(&mut self, found: &FoundStatuses) -> Step {
        self.last_us = found.at_us;
        self.run.find(found.at_us, found.nodes.iter().map(|node| (node.status, node.last)))
    }

    fn take(&mut self, news: TreeNews) -> Result<(), Error> {
        let step = match news {
            TreeNews::Change(change) => {
                self.last_us = change.at_us;
                self.run.step(change, &mut self.properties)
            }
            TreeNews::Missing { why, found } => {
                self.lose(&why)?;
                self.find(&found)
            }
            TreeNews::Blackboards(read) => return self.read(&read),
            _ => return Ok(()),
        };
        self.add(step)
    }

    /// Shows what was read of blackboards, and what is not shown of them.
    fn read(&mut self, read: &Blackboards) -> Result<(), Error> {
        let entries = read
            .boards
            .iter()
            .flat_map(|(board, entries)| entries.iter().map(|(key, value)| (board.clone(), key.clone(), told(value))));
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

    /// Tells, also on the page, that something is not shown.
    fn leave_out(&mut self, words: String) -> Result<(), Error> {
        note(&words);
        let step = self.run.note(self.last_us, words.clone());
        self.unshown.push(words);
        self.add(step)
    }

    /// Changes may be missing until here.
    fn lose(&mut self, why: &str) -> Result<(), Error> {
        let step = self.run.miss(self.last_us, &format!("changes may be missing: {why}"), &mut self.properties);
        self.add(step)
    }

    fn add(&mut self, step: Step) -> Result<(), Error> {
        self.view.apply(step).expect(FITS);
        self.page.follow(&self.view)?;
        self.archive.follow(&self.view)?;
        self.announcer.follow(self.view.time(), &self.properties, self.run.doubts(), &Around::without_ticks())
    }

    /// Nothing is new.
    fn idle(&mut self) -> Result<(), Error> {
        self.announcer.idle(&self.properties, &Around::without_ticks());
        self.page.show()
    }

    /// Ends what is written, and says how the properties stand. Returns the exit status.
    fn finish(mut self) -> Result<u8, Error> {
        // The last step is recorded with the end.
        let last = self.run.note(self.last_us, "nobody asks the program any more".to_owned());
        self.view.apply(last).expect(FITS);
        self.view.finish(self.run.finish(Ended::Recorded, &self.properties)).expect(FITS);
        self.archive.follow(&self.view)?;
        self.archive.map_or(Ok(()), Archive::finish)?;
        self.page.follow(&self.view)?;
        self.page.finish(&self.view)?;
        if self.properties.is_empty() {
            self.unshown.iter().for_each(|text| note(text));
            return Ok(0);
        }
        let mut verified = Verified::of(self.properties, self.run.end(), self.run.doubts(), LEFT_OPEN.to_owned());
        verified.notes.extend(self.unshown);
        verified.notes.iter().for_each(|text| note(text));
        print_wrapped(in_words(&verified))?;
        Ok(verified.status())
    }
}

/// The name of a file for the tree with this number.
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
