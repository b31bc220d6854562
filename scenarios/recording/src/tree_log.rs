//! The records of a [log](tree_logs::Log) that BehaviorTree.CPP has written.

use std::path::Path;

use chrono::DateTime;
use tree_logs::{Log, LogError, StatusChange};

use crate::{Doubts, Ended, Origin, Record, Step, TreeRun};

/// The records of a log.
#[derive(Debug)]
pub(crate) struct TreeLog {
    log: Log,
    run: TreeRun,
    /// The first records, in reverse.
    start: Vec<Record>,
    /// The next transition, or why it cannot be read.
    next: Option<Result<StatusChange, LogError>>,
    has_ended: bool,
}

impl TreeLog {
    pub(crate) fn open(path: &Path) -> Result<Self, LogError> {
        let mut log = Log::open(path)?;
        let next = log.next_change().transpose();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let root = &log.tree().nodes()[0];
        let session = log.session().filter(|session| session.of > 1);
        let session =
            session.map_or_else(String::new, |session| format!(", session {} of {}", session.number, session.of));
        let about = format!("A log of BehaviorTree.CPP, whose tree begins with {}{session}", root.name);
        let began_us = log.began_us().or(next.as_ref().and_then(|first| Some(first.as_ref().ok()?.at_us))).unwrap_or(0);
        let recorded = Some(format!("steward report {}", path.display()));
        let origin = Origin { recorded, began: DateTime::from_timestamp_micros(began_us), ..Origin::default() };
        let tree = (log.tree(), &TreeRun::topology(log.tree()));
        let (run, header, start) = TreeRun::begin([name, about], origin, tree, began_us, &[], Doubts::none(0));
        let mut start = vec![Record::Step(start), Record::Header(Box::new(header))];
        if !matches!(next, Some(Ok(_))) {
            // A run ends with a step, even if nothing was logged.
            start.insert(0, Record::Step(Step::default()));
        }
        Ok(Self { log, run, start, next, has_ended: false })
    }

    /// The next record; none after the last one.
    pub(crate) fn next_record(&mut self) -> Result<Option<Record>, LogError> {
        if let Some(record) = self.start.pop() {
            return Ok(Some(record));
        }
        if self.has_ended {
            return Ok(None);
        }
        match self.next.take() {
            Some(Ok(change)) => {
                self.next = self.log.next_change().transpose();
                Ok(Some(Record::Step(self.run.step(change, &mut []))))
            }
            None => Ok(Some(self.end(Ended::Recorded))),
            Some(Err(LogError::CutOff { what, .. })) => Ok(Some(self.end(Ended::CutOff(what)))),
            Some(Err(error)) => {
                self.has_ended = true;
                Err(error)
            }
        }
    }

    fn end(&mut self, ended: Ended) -> Record {
        self.has_ended = true;
        Record::End(Box::new(self.run.finish(ended, &[])))
    }
}
