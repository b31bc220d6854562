//! Logs of trees in the formats of BehaviorTree.CPP: which node got which status when.
//!
//! A [`Log`] is what the loggers of BehaviorTree.CPP write since version 4.6.2: `FileLogger2`, a file `.btlog`; or,
//! with the feature `sqlite`, `SqliteLogger`, a file `.db3` or `.btdb`, which has a session for each time that a
//! program began to log. It is also Nav2's topic `/behavior_tree_log` in a bag, beside the file of the tree. A log has
//! its [tree](LoggedTree), and every [`StatusChange`] of one of its nodes.
//!
//! Such a log does not contain when the tree was ticked: a node that gives the same answer again leaves no trace. Nor
//! does it contain which nodes were skipped, what was on the blackboard, and why a program has ended.
//!
//! ```no_run
//! use std::path::Path;
//! use tree_logs::{Log, LogEntry};
//!
//! let mut log = Log::open(Path::new("run.btlog"))?;
//! while let Some(entry) = log.next_entry()? {
//!     match entry {
//!         LogEntry::Changed(change) => {
//!             println!("{} µs: {} is {:?}", change.at_us, log.tree().nodes()[change.node].path, change.status);
//!         }
//!         LogEntry::Lost(gap) => println!("{}", gap.why),
//!     }
//! }
//! # Ok::<(), tree_logs::LogError>(())
//! ```
//!
//! A [`LogWriter`] writes a file `.btlog` of a tree that was run here.
//!
//! # Inside
//! `tree` reads the XML of a log, which is not that of an ordinary file: it has a tree for each place where one is
//! used. `file_logger` and `sqlite` read the two formats. Both are written by programs that may be killed at any time.
//! `writer` writes the first of them.

mod error;
mod file_logger;
mod nav2;
#[cfg(feature = "sqlite")]
mod sqlite;
mod status;
mod tree;
mod writer;

use std::io::Read as _;
use std::path::{Path, PathBuf};

use chrono::{DateTime, Utc};
use file_logger::FileLog;
use nav2::Nav2Log;

pub use channels::Flaw;
pub use error::LogError;
pub use nav2::BagTree;
pub use status::{LogEntry, LogGap, LoggedTransition, NodeStatus, StatusChange};
pub use tree::{LoggedNode, LoggedTree};
pub use writer::LogWriter;

/// A log of BehaviorTree.CPP, read from start to end in constant memory.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    tree: LoggedTree,
    began_us: Option<i64>,
    session: Option<LogSession>,
    topic: Option<String>,
    reader: Reader,
}

/// Which part of a log was read, of one that has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogSession {
    /// Its number in the file.
    pub number: i64,
    /// How many sessions the file has.
    pub of: u64,
}

#[derive(Debug)]
enum Reader {
    File(FileLog),
    #[cfg(feature = "sqlite")]
    Sqlite(sqlite::SqliteLog),
    Nav2(Box<Nav2Log>),
}

/// Why a file that does not begin as a log is none; of one that is named as a log, what is wrong with it.
fn by_name(path: PathBuf, head: &[u8]) -> LogError {
    let is = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    let problem = match head {
        [] if is("btlog") || is("fbl") => "it is empty: its writer was stopped before it wrote anything",
        _ if is("btlog") => "it does not begin as `FileLogger2` of BehaviorTree.CPP begins a log",
        _ if is("fbl") => {
            "it is a log of `FileLogger`, as BehaviorTree.CPP wrote it up to version 4.6.1, which cannot be read; log \
             with `FileLogger2`"
        }
        _ => return LogError::Foreign(path),
    };
    LogError::Damaged { path, problem: problem.to_owned() }
}

impl Log {
    /// Opens a log. Of several sessions, `FILE#2` names the second, and the file's name alone the last.
    ///
    /// # Errors
    /// [`LogError`], also if the log ends before its first transition could come.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let (path, session) = session_of(path);
        let failed = |source| LogError::Read { path: path.clone(), source };
        let (mut file, mut head) = (diagnostics::open_regular(&path).map_err(failed)?, Vec::new());
        (&mut file).take(file_logger::MAGIC.len() as u64).read_to_end(&mut head).map_err(failed)?;
        if head.starts_with(SQLITE) {
            #[cfg(not(feature = "sqlite"))]
            return Err(LogError::NoSqlite(path));
            #[cfg(feature = "sqlite")]
            {
                let (xml, number, of, log) = sqlite::open(&path, session)?;
                return Self::with(path, &xml, None, Some(LogSession { number, of }), Reader::Sqlite(log));
            }
        }
        if head != file_logger::MAGIC {
            return Err(by_name(path, &head));
        }
        if let Some(session) = session {
            let problem = format!("it has no sessions: leave out `#{session}`");
            return Err(LogError::Damaged { path, problem });
        }
        let (xml, log) = FileLog::begin(file, &path)?;
        Self::with(path, &xml, Some(log.began_us), None, Reader::File(log))
    }

    /// Opens a bag with a topic of `nav2_msgs/msg/BehaviorTreeLog`, whose messages are about this tree.
    ///
    /// # Errors
    /// [`LogError::Bag`] if the bag cannot be read; [`LogError::Unfit`] if it has no such topic, or several and none is
    /// named, or if no message is about the tree.
    pub fn of_bag(path: &Path, tree: &BagTree) -> Result<Self, LogError> {
        let (tree, reader) = nav2::open(path, tree)?;
        let (began_us, topic) = (reader.began_us, Some(reader.topic().to_owned()));
        Ok(Self { path: path.to_owned(), tree, began_us, session: None, topic, reader: Reader::Nav2(Box::new(reader)) })
    }

    fn with(
        path: PathBuf,
        xml: &str,
        began_us: Option<i64>,
        session: Option<LogSession>,
        reader: Reader,
    ) -> Result<Self, LogError> {
        match LoggedTree::read(xml) {
            Ok(tree) => Ok(Self { path, tree, began_us, session, topic: None, reader }),
            Err(problem) => Err(LogError::Damaged { path, problem }),
        }
    }

    /// Its tree.
    #[must_use]
    pub fn tree(&self) -> &LoggedTree {
        &self.tree
    }

    /// When it began, in microseconds since 1970; none if it has only the times of its transitions.
    #[must_use]
    pub fn began_us(&self) -> Option<i64> {
        self.began_us
    }

    /// Its session, if the file can have several.
    #[must_use]
    pub fn session(&self) -> Option<LogSession> {
        self.session
    }

    /// The topic of a bag, if that is where its transitions are.
    #[must_use]
    pub fn topic(&self) -> Option<&str> {
        self.topic.as_deref()
    }

    /// The next entry, in the order of the log; none at its end.
    ///
    /// # Errors
    /// [`LogError`]; [`CutOff`](LogError::CutOff) if the log ends in the middle of a transition.
    pub fn next_entry(&mut self) -> Result<Option<LogEntry>, LogError> {
        let transition = match &mut self.reader {
            Reader::File(log) => log.next_transition(&self.path)?,
            #[cfg(feature = "sqlite")]
            Reader::Sqlite(log) => log.next_transition(&self.path)?,
            Reader::Nav2(log) => return log.next_entry(),
        };
        let change = transition.map(|transition| self.tree.change(transition)).transpose();
        let change = change.map_err(|problem| LogError::Damaged { path: self.path.clone(), problem })?;
        Ok(change.map(LogEntry::Changed))
    }
}

/// The date of a time in a log; none if its clock does not count from 1970, as in a simulation.
#[must_use]
pub fn date(at_us: i64) -> Option<DateTime<Utc>> {
    bags::date(at_us.saturating_mul(1000))
}

/// How an SQLite file begins.
const SQLITE: &[u8] = b"SQLite format 3\0";

/// The file, and the number of a session if one is named after it.
fn session_of(path: &Path) -> (PathBuf, Option<i64>) {
    let named = path.to_str().and_then(|text| text.rsplit_once('#')).filter(|_| !path.exists());
    match named.and_then(|(file, number)| Some((PathBuf::from(file), number.parse().ok()?))) {
        Some((file, number)) => (file, Some(number)),
        None => (path.to_owned(), None),
    }
}
