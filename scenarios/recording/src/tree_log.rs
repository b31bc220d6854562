//! The records of a [log](tree_logs::Log) that BehaviorTree.CPP has written, or Nav2 into a bag.

use std::collections::VecDeque;
use std::path::Path;
use std::time::Duration;

use channels::{Flaw, Gap};
use tree_logs::{BagTree, Log, LogEntry, LogError, NodeStatus, StatusChange};

use crate::{Doubts, Ended, Origin, Record, Step, TreeRun};

#[derive(Debug)]
pub(crate) struct TreeLog {
    log: Log,
    run: TreeRun,
    known: Vec<KnownStatus>,
    /// Since when changes may be missing, as far as that has been reported.
    lost_since: Duration,
    /// The next records.
    ready: VecDeque<Record>,
    /// The next entry, or why it cannot be read.
    next: Option<Result<LogEntry, LogError>>,
    has_ended: bool,
}

/// What is known of a node, to compare it with a log.
#[derive(Clone, Copy, Debug, Default)]
struct KnownStatus {
    /// Its last status; none before the first report.
    status: Option<NodeStatus>,
    since: Duration,
    /// Whether changes have been lost since then, so that it may have another.
    is_stale: bool,
}

impl TreeLog {
    pub(crate) fn open(path: &Path) -> Result<Self, LogError> {
        Ok(Self::begin(Log::open(path)?, path, format!("steward report {}", path.display())))
    }

    /// The log of a tree that Nav2 has written into a bag.
    pub(crate) fn of_bag(path: &Path, tree: &BagTree) -> Result<Self, LogError> {
        let topic = tree.topic.as_ref().map_or_else(String::new, |topic| format!("{topic}="));
        let recorded = format!("steward report {} --tree {topic}{}", path.display(), tree.tree.source().name());
        Ok(Self::begin(Log::of_bag(path, tree)?, path, recorded))
    }

    /// The log of this file, which that command shows.
    fn begin(mut log: Log, path: &Path, recorded: String) -> Self {
        let next = log.next_entry().transpose();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let root = &log.tree().nodes()[0];
        let session = log.session().filter(|session| session.of > 1);
        let session =
            session.map_or_else(String::new, |session| format!(", session {} of {}", session.number, session.of));
        let what = log.topic().map_or("A log of BehaviorTree.CPP".to_owned(), |topic| format!("Nav2's {topic}"));
        let about = format!("{what}, whose tree begins with {}{session}", root.name);
        let first_us = match &next {
            Some(Ok(LogEntry::Changed(change))) => Some(change.at_us),
            _ => None,
        };
        let began_us = log.began_us().or(first_us).unwrap_or(0);
        let origin = Origin { recorded: Some(recorded), began: tree_logs::date(began_us), ..Origin::default() };
        let topology = TreeRun::topology(log.tree());
        let (tree, doubts) = ((log.tree(), &topology), Doubts::new(&[], &topology));
        let (run, header, start) = TreeRun::begin([name, about], origin, tree, began_us, &[], doubts);
        let mut ready = VecDeque::from([Record::Header(Box::new(header)), Record::Step(start)]);
        if !matches!(next, Some(Ok(_))) {
            // A run ends with a step, even if nothing was logged.
            ready.push_back(Record::Step(Step::default()));
        }
        let known = vec![KnownStatus::default(); log.tree().nodes().len()];
        Self { log, run, known, lost_since: Duration::MAX, ready, next, has_ended: false }
    }

    /// The next record; none after the last one.
    pub(crate) fn next_record(&mut self) -> Result<Option<Record>, LogError> {
        if let Some(record) = self.ready.pop_front() {
            return Ok(Some(record));
        }
        if self.has_ended {
            return Ok(None);
        }
        match self.next.take() {
            Some(Ok(entry)) => {
                self.next = self.log.next_entry().transpose();
                Ok(Some(Record::Step(match entry {
                    LogEntry::Changed(change) => self.change(change),
                    LogEntry::Lost(gap) => {
                        let since = gap.since_us.map(|since_us| self.run.since_start(since_us));
                        let why = match since {
                            Some(since) => format!("after {:.2} s, {}", since.as_secs_f64(), gap.why),
                            None => gap.why,
                        };
                        self.lose(self.run.time(), Gap { flaw: gap.flaw, since, ..Gap::of_anything(why) })
                    }
                })))
            }
            None => Ok(Some(self.end(Ended::Recorded))),
            Some(Err(LogError::CutOff { what, .. })) => Ok(Some(self.end(Ended::CutOff(what)))),
            Some(Err(error)) => {
                self.has_ended = true;
                Err(error)
            }
        }
    }

    /// The record of a change, or of the loss before it: the change then comes next.
    fn change(&mut self, change: StatusChange) -> Step {
        let at = self.run.time().max(self.run.since_start(change.at_us));
        let now = KnownStatus { status: Some(change.status), since: at, is_stale: false };
        let KnownStatus { status, since, is_stale } = std::mem::replace(&mut self.known[change.node], now);
        // What was lost before explains another status, unless this loss may be an earlier one.
        match (change.before, status) {
            (Some(said), Some(status)) if said != status && !(is_stale && since >= self.lost_since) => {
                let name = &self.log.tree().nodes()[change.node].name;
                let why = format!(
                    "at {:.2} s, {name} was {} before, and the last that is known of it is {}: messages are missing, or \
                     the tree is another one",
                    at.as_secs_f64(),
                    said.name(),
                    status.name()
                );
                let lost = self.lose(at, Gap { since: Some(since), ..Gap::of_anything(why) });
                self.known[change.node] = now;
                self.ready.push_back(Record::Step(self.run.step(change, &mut [])));
                lost
            }
            _ => self.run.step(change, &mut []),
        }
    }

    /// The record of what may be wrong from here on.
    fn lose(&mut self, at: Duration, gap: Gap) -> Step {
        if gap.flaw != Flaw::Late {
            self.lost_since = self.lost_since.min(gap.since.unwrap_or_default());
            self.known.iter_mut().for_each(|known| known.is_stale = true);
        }
        self.run.lose(at, gap)
    }

    fn end(&mut self, ended: Ended) -> Record {
        self.has_ended = true;
        Record::End(Box::new(self.run.finish(ended, &[])))
    }
}
