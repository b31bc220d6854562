//! A program that runs a tree with BehaviorTree.CPP, asked by Groot2's protocol while it runs.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::Ground;
use checks::System;
use groot::{Blackboards, Client, GrootError, TreeSnapshot, TreeUpdate, TreeWatch};
use monitors::Property;
use recording::{Detail, Doubts, Ended, Header, Next, Origin, RecordSource, RunView, Step, TreeRun, fitting};
use tree_logs::LoggedTree;

use crate::boards::{BoardBudget, entry_value};
use crate::host::Host;
use crate::judge::{MonitoringResult, VerificationResult, load, stories};
use crate::log_context::LogContext;
use crate::tree_log::refuse_unknown;
use crate::wanted::{VerdictObserver, Wanted};

/// How long a program may take to answer.
const TIMEOUT: Duration = Duration::from_secs(2);

/// The effects of requests on the program and on its other clients.
const COST: &str = "the program remembers its last 1000 changes from now on, and forgets those that it has sent: \
                    another client that asks for them, such as Groot2 when it records, gets only some. Breakpoints that \
                    another client has set stay armed. `--passive` only asks for statuses";
const PASSIVE: &str = "only the statuses of nodes are asked for, a hundred times a second: what changes in between is \
                       not seen, so that verdicts are unsure unless a single message violates a property. Breakpoints \
                       that another client has set stay armed";
/// The note about what verdicts leave open.
const LEFT_OPEN: &str = "what the program did before it was asked is not judged. It reports changes of status, and not the answers that repeat the one before: what \
                         `time_until` waits for is a change. Changes that it has sent to another client are noticed \
                         only if a node then has a status that does not follow";

/// A program that runs one tree after the other.
pub struct TreeProgram {
    address: String,
    is_passive: bool,
    host: Host,
    watch: TreeWatch,
    /// The statuses of a tree that has not been judged.
    snapshot: Option<TreeSnapshot>,
}

impl TreeProgram {
    /// Connects to the program at an address, which has Groot2's port if it names none. If it is passive, only statuses
    /// are asked for.
    ///
    /// # Errors
    /// If no program answers.
    pub fn connect(address: &str, is_passive: bool, host: Host) -> Result<Self, Error> {
        let address = with_port(address);
        let client = Client::connect(&address, TIMEOUT).map_err(refused)?;
        (host.note)(if is_passive { PASSIVE } else { COST });
        let (watch, snapshot) = TreeWatch::begin(client, is_passive).map_err(refused)?;
        Ok(Self { address, is_passive, host, watch, snapshot: Some(snapshot) })
    }

    /// Judges the tree that the program runs by the properties in these files, until it runs another one, or until the
    /// end. There is no result once no tree is left.
    ///
    /// # Errors
    /// If a property is wrong, or what is wanted cannot be written.
    pub fn judge(&mut self, files: &[PathBuf], mut wanted: Wanted<'_>) -> Result<Option<VerificationResult>, Error> {
        let Some(snapshot) = self.snapshot.take() else { return Ok(None) };
        let mut tree = WatchedTree::begin(self, files, &snapshot, wanted.observer.take())?;
        let (presentation, view) = wanted.conduct(&mut tree)?;
        let stories = stories(presentation, &view)?;
        let left_open = (!tree.properties.is_empty()).then(|| LEFT_OPEN.to_owned());
        let monitoring = MonitoringResult::of(tree.run.end(), tree.run.doubts(), &tree.properties);
        let result = VerificationResult::of(tree.properties, monitoring);
        let notes = result.notes.into_iter().chain(left_open).chain(tree.unshown).collect();
        Ok(Some(VerificationResult { notes, stories: stories.unwrap_or(result.stories), ..result }))
    }

    /// Asks again whether the program answers.
    fn reconnect(&self) -> Option<(TreeWatch, TreeSnapshot)> {
        let client = Client::connect(&self.address, TIMEOUT);
        client.and_then(|client| TreeWatch::begin(client, self.is_passive)).ok()
    }
}

/// The address, with Groot2's port if it has none.
fn with_port(address: &str) -> String {
    let is_whole = |host: &str| !host.contains(':') || host.ends_with(']');
    let has_port = address.rsplit_once(':').is_some_and(|(host, _)| is_whole(host));
    if has_port { address.to_owned() } else { format!("{address}:{}", groot::PORT) }
}

/// A tree while the program runs it.
struct WatchedTree<'p> {
    program: &'p mut TreeProgram,
    tree: LoggedTree,
    run: TreeRun,
    properties: Vec<Property>,
    observer: Option<Box<dyn VerdictObserver>>,
    /// The first two records, until they are requested.
    start: Option<(Header, Step)>,
    /// Records that are ready, and what the program has reported after them.
    steps: VecDeque<Step>,
    updates: VecDeque<TreeUpdate>,
    state: Connection,
    last_us: i64,
    boards: BoardBudget,
    /// The parts of blackboards that are not shown, in words.
    unshown: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Connection {
    Answers,
    Lost,
    /// It is not asked any more about this tree.
    Over,
}

impl<'p> WatchedTree<'p> {
    fn begin(
        program: &'p mut TreeProgram,
        files: &[PathBuf],
        snapshot: &TreeSnapshot,
        observer: Option<Box<dyn VerdictObserver>>,
    ) -> Result<Self, Error> {
        let tree = program.watch.tree().clone();
        let (address, topology) = (&program.address, TreeRun::topology(&tree));
        let system = System::new(Arc::clone(&topology), Duration::ZERO);
        let properties = if files.is_empty() { Vec::new() } else { load(files, &system, program.host)? };
        refuse_unknown(&properties)?;
        let root = &tree.nodes()[0];
        let about = format!("A program with BehaviorTree.CPP at {address}, whose tree begins with {}", root.name);
        let recorded = Some(format!("steward live --groot {address}"));
        let last_us = snapshot.at_us;
        let origin = Origin { recorded, began: bags::date(last_us.saturating_mul(1000)), ..Origin::default() };
        let ground = Ground::Assumed("the program reports every change of status while it is asked".to_owned());
        let doubts = Doubts::about_losses(&properties, &topology).on(&ground);
        let about = [root.name.clone(), about];
        let (run, header, start) = TreeRun::begin(about, origin, (&tree, &topology), last_us, &properties, doubts);
        let mut watched = Self {
            program,
            tree,
            run,
            properties,
            observer,
            start: Some((header, start)),
            steps: VecDeque::new(),
            updates: VecDeque::new(),
            state: Connection::Answers,
            last_us,
            boards: BoardBudget::default(),
            unshown: Vec::new(),
        };
        if watched.program.is_passive {
            let step = watched.run.doubt(last_us, PASSIVE, &mut watched.properties);
            watched.steps.push_back(step);
        }
        watched.apply(snapshot);
        watched.program.watch.read_every(watched.boards.period());
        Ok(watched)
    }

    fn apply(&mut self, snapshot: &TreeSnapshot) {
        self.last_us = snapshot.at_us;
        self.steps.push_back(self.run.find(snapshot.at_us, snapshot.nodes.iter().map(|node| (node.status, node.last))));
    }

    fn take(&mut self, update: TreeUpdate) {
        match update {
            TreeUpdate::Change(change) => {
                self.last_us = change.at_us;
                self.steps.push_back(self.run.step(change, &mut self.properties));
            }
            TreeUpdate::Missing { why, snapshot } => {
                self.lose(&why);
                self.apply(&snapshot);
            }
            TreeUpdate::Blackboards(read) => self.read(&read),
            _ => {}
        }
    }

    /// Shows the entries of blackboards, and notes which are not shown.
    fn read(&mut self, read: &Blackboards) {
        let entries = read.boards.iter().flat_map(|(board, entries)| {
            entries.iter().map(|(key, value)| (board.clone(), key.clone(), entry_value(value)))
        });
        let step = self.run.read(self.last_us, entries);
        let unshown = self.boards.take(read, &step);
        self.steps.push_back(step);
        unshown.into_iter().for_each(|words| self.leave_out(words));
    }

    /// Notes, also on the page, that a part of blackboards is not shown.
    fn leave_out(&mut self, words: String) {
        (self.program.host.note)(&words);
        self.steps.push_back(self.run.note(self.last_us, words.clone()));
        self.unshown.push(words);
    }

    /// Notes that changes may be missing until now.
    fn lose(&mut self, why: &str) {
        let why = format!("changes may be missing: {why}");
        self.steps.push_back(self.run.miss(self.last_us, &why, &mut self.properties));
    }

    /// Takes what the program reports next, if anything.
    fn ask(&mut self) {
        let error = match self.program.watch.next_update() {
            Ok(Some(update)) => {
                self.take(update);
                self.program.watch.read_every(self.boards.period());
                return;
            }
            Ok(None) => return self.program.host.pause(),
            Err(error) => error,
        };
        (self.program.host.note)(&format!("{error}; waiting for it"));
        if matches!(error, GrootError::LargeBlackboards { .. }) {
            self.boards.give_up();
            self.steps.push_back(self.run.read(self.last_us, std::iter::empty()));
            self.leave_out("blackboards are not shown from here on: they are too large".to_owned());
        }
        self.lose(&format!("the program does not answer: {error}"));
        self.state = Connection::Lost;
    }

    /// Asks whether the program answers again, and which tree it runs now.
    fn ask_again(&mut self) {
        let host = self.program.host;
        let Some((watch, snapshot)) = self.program.reconnect() else {
            return (0..20).take_while(|_| !(host.is_interrupted)()).for_each(|_| host.pause());
        };
        (host.note)("it answers again");
        self.program.watch = watch;
        if *self.program.watch.tree() == self.tree {
            self.state = Connection::Answers;
            self.take(TreeUpdate::Missing { why: "the program answers again".to_owned(), snapshot });
            self.program.watch.read_every(self.boards.period());
        } else {
            (host.note)("it runs another tree");
            self.program.snapshot = Some(snapshot);
            self.state = Connection::Over;
        }
    }

    /// Takes what the program has left to report, at the end.
    fn end(&mut self) {
        match self.program.watch.end() {
            Ok(last) => self.updates.extend(last),
            Err(error) => self.lose(&format!("the program does not answer: {error}")),
        }
        self.state = Connection::Over;
    }
}

impl RecordSource for WatchedTree<'_> {
    type Error = Error;

    fn start(&mut self, _: Detail) -> Result<RunView, Error> {
        let (header, start) = self.start.take().expect("a run is started once");
        Ok(fitting(RunView::new(header, start)))
    }

    fn next(&mut self, view: &mut RunView, _: Detail, is_stopped: bool) -> Result<Next<Error>, Error> {
        if self.steps.is_empty()
            && let Some(update) = self.updates.pop_front()
        {
            self.take(update);
        } else if self.steps.is_empty() {
            match self.state {
                Connection::Over => {
                    let last = self.run.note(self.last_us, "the program is not asked any more".to_owned());
                    fitting(view.apply(last));
                    fitting(view.finish(self.run.finish(Ended::Recorded, &self.properties)));
                    return Ok(Next::Step);
                }
                _ if is_stopped => self.end(),
                Connection::Answers => self.ask(),
                Connection::Lost => self.ask_again(),
            }
        }
        let context = LogContext { lacks_ticks: true, ..LogContext::default() };
        let Some(step) = self.steps.pop_front() else {
            self.observer.iter_mut().for_each(|observer| observer.idle(&self.properties, &context));
            return Ok(Next::Idle);
        };
        fitting(view.apply(step));
        let observer = self.observer.as_mut();
        observer
            .map_or(Ok(()), |observer| observer.follow(view.time(), &self.properties, self.run.doubts(), &context))?;
        Ok(Next::Step)
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
