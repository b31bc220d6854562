//! Writes what a run's tree did as a log of BehaviorTree.CPP.

use std::io::{self, Write};

use tree_logs::{LogWriter, LoggedTransition, NodeStatus};

use crate::{Follower, RunView};

/// Writes the changes of status in a run's tree as a file `.btlog`. Its clock is that of the run, which begins in 1970:
/// the same run gives the same bytes.
#[derive(Debug)]
pub(crate) struct TreeLogWriter<W: Write>(LogWriter<W>);

/// When a run begins by the clock of its log, in microseconds since 1970.
const BEGAN_US: i64 = 0;

impl<W: Write> TreeLogWriter<W> {
    pub(crate) fn begin(output: W, view: &RunView) -> io::Result<Self> {
        let header = view.header();
        let refused = |why: &str| Err(io::Error::other(format!("a log of BehaviorTree.CPP has a tree, but {why}")));
        if header.tree.is_empty() {
            return refused("there is none in this run");
        }
        let Some(xml) = &header.tree_xml else {
            return refused(
                "how the statuses of this one change is not known: it was not run here, or with `tree = \"nodes\"` in \
                 `[execution]`",
            );
        };
        if u16::try_from(header.tree.len()).is_err() {
            return refused(&format!("at most {} nodes, and this one has {}", u16::MAX, header.tree.len()));
        }
        let mut writer = Self(LogWriter::begin(output, xml, BEGAN_US)?);
        writer.follow(view)?;
        Ok(writer)
    }

    pub(crate) fn finish(self) -> io::Result<W> {
        self.0.finish()
    }
}

impl<W: Write> Follower for TreeLogWriter<W> {
    type Error = io::Error;

    fn follow(&mut self, view: &RunView) -> io::Result<()> {
        logged_transitions(view).try_for_each(|transition| self.0.write(transition))
    }
}

/// The changes of status in the last step, as a log has them: by the clock of the run, and with the number that a node
/// has in the XML of its tree.
pub fn logged_transitions(view: &RunView) -> impl Iterator<Item = LoggedTransition> {
    let at_us = i64::try_from(view.time().as_micros()).unwrap_or(i64::MAX);
    let details = view.step().details.as_deref();
    details.map_or(&[][..], |details| &details.transitions).iter().map(move |(node, status)| LoggedTransition {
        at_us,
        uid: *node as i64 + 1,
        status: status.map_or(NodeStatus::Idle, NodeStatus::Answered).number().into(),
    })
}
