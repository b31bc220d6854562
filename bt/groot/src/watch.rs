//! Polls a program for the changes of its tree, in order.

use std::collections::VecDeque;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tree_logs::{LoggedTransition, LoggedTree, NodeStatus, StatusChange};

use crate::boards::Blackboards;
use crate::client::{Client, MOST_TRANSITIONS, Statuses};
use crate::error::GrootError;
use crate::protocol::IDLE_AFTER;
use crate::zmtp::now;

/// The interval between checks that no transitions are missing.
const CHECK: Duration = Duration::from_secs(1);
/// The default interval at which blackboards are read.
const READ: Duration = Duration::from_millis(200);

/// A change of the tree or its blackboards.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TreeUpdate {
    /// A node has changed its status.
    Change(StatusChange),
    /// Changes since the last update are missing.
    Missing {
        /// The reason, in words.
        why: String,
        /// The statuses after the missing changes.
        snapshot: TreeSnapshot,
    },
    /// The entries of all blackboards, some of which have changed; empty if blackboards are no longer read.
    Blackboards(Blackboards),
}

/// The statuses of all nodes at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeSnapshot {
    /// By the clock of the program, in microseconds since 1970.
    pub at_us: i64,
    /// The status of each node, in the order of the tree.
    pub nodes: Vec<NodeSnapshot>,
}

/// The status of a node, now and before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeSnapshot {
    /// Its status.
    pub status: NodeStatus,
    /// Its last status that was not idle; idle if there was none.
    pub last: NodeStatus,
}

impl NodeSnapshot {
    const NEW: Self = Self { status: NodeStatus::Idle, last: NodeStatus::Idle };

    /// The statuses that a number encodes.
    fn of(code: u8) -> Option<Self> {
        let last = NodeStatus::of((code % IDLE_AFTER).into())?;
        match code {
            IDLE_AFTER => None,
            0..IDLE_AFTER => Some(Self { status: last, last }),
            _ => (code < 2 * IDLE_AFTER).then_some(Self { status: NodeStatus::Idle, last }),
        }
    }

    fn take(&mut self, status: NodeStatus) {
        self.status = status;
        if status != NodeStatus::Idle {
            self.last = status;
        }
    }
}

/// Polls a program.
///
/// The program stores transitions until they are requested, so each transition reaches only one client. Transitions
/// that another client has received are missing here. This is detected if a node then has a status that does not follow
/// from the transitions received: at its next transition, or when all statuses are compared, once per second.
#[derive(Debug)]
pub struct TreeWatch {
    client: Client,
    tree: LoggedTree,
    /// Whether only statuses and blackboards are requested.
    is_passive: bool,
    /// When the recording of transitions began, on the clock of the program.
    began_us: i64,
    last_us: i64,
    nodes: Vec<NodeSnapshot>,
    boards: Blackboards,
    updates: VecDeque<TreeUpdate>,
    checked: Instant,
    read: Option<Instant>,
    /// The interval at which blackboards are read; none if they are not read.
    period: Option<Duration>,
}

impl TreeWatch {
    /// Requests the tree and the statuses of a program, and makes it store transitions from then on. If this watch is
    /// passive, changes are instead found by comparing statuses, and have the times at which they were found.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn begin(mut client: Client, is_passive: bool) -> Result<(Self, TreeSnapshot), GrootError> {
        let tree = client.tree()?;
        let nodes = vec![NodeSnapshot::NEW; tree.nodes().len()];
        let mut watch = Self {
            client,
            tree,
            is_passive,
            began_us: 0,
            last_us: 0,
            nodes,
            boards: Blackboards::default(),
            updates: VecDeque::new(),
            checked: now(),
            read: None,
            period: Some(READ),
        };
        watch.record()?;
        let snapshot = watch.take_snapshot()?;
        Ok((watch, snapshot))
    }

    /// The tree.
    #[must_use]
    pub fn tree(&self) -> &LoggedTree {
        &self.tree
    }

    /// Sets the interval at which blackboards are read. Without one, they are no longer read.
    pub fn read_every(&mut self, period: Option<Duration>) {
        self.period = period;
        if period.is_none() && self.boards != Blackboards::default() {
            self.boards = Blackboards::default();
            self.updates.push_back(TreeUpdate::Blackboards(Blackboards::default()));
        }
    }

    /// The next update; none if there is none yet.
    ///
    /// # Errors
    /// [`GrootError`]. After an error, there are no more updates.
    pub fn next_update(&mut self) -> Result<Option<TreeUpdate>, GrootError> {
        if self.updates.is_empty() {
            self.poll()?;
        }
        Ok(self.updates.pop_front())
    }

    /// The remaining updates. Makes the program stop storing transitions, after a last check that none are missing.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn end(&mut self) -> Result<Vec<TreeUpdate>, GrootError> {
        self.poll()?;
        if !self.is_passive {
            self.check()?;
            self.client.stop_recording()?;
        }
        Ok(self.updates.drain(..).collect())
    }

    fn poll(&mut self) -> Result<(), GrootError> {
        if self.is_passive {
            self.compare()?;
        } else {
            let transitions = self.client.transitions(self.began_us)?;
            self.take(transitions)?;
            if self.checked.elapsed() >= CHECK {
                self.checked = now();
                self.check()?;
            }
        }
        if self.period.is_some_and(|period| self.read.is_none_or(|read| read.elapsed() >= period)) {
            self.read = Some(now());
            let boards = self.client.blackboards(self.tree.blackboards())?;
            if boards != self.boards {
                self.updates.push_back(TreeUpdate::Blackboards(boards.clone()));
                self.boards = boards;
            }
        }
        Ok(())
    }

    /// Makes the program store transitions from now on.
    fn record(&mut self) -> Result<(), GrootError> {
        self.began_us = if self.is_passive { system_us() } else { self.client.start_recording()? };
        self.last_us = self.began_us;
        Ok(())
    }

    /// Requests the statuses of all nodes, regardless of the transitions so far, and then applies the transitions that
    /// the program has stored, some of which may be later.
    fn take_snapshot(&mut self) -> Result<TreeSnapshot, GrootError> {
        let statuses = self.client.statuses()?;
        self.nodes = self.by_node(&statuses)?;
        if !self.is_passive {
            let transitions = self.client.transitions(self.began_us)?;
            if transitions.len() >= MOST_TRANSITIONS {
                return Err(self.client.foreign("its nodes change faster than their changes can be requested"));
            }
            for transition in transitions {
                let change = self.change(transition)?;
                self.last_us = self.last_us.max(change.at_us);
                self.nodes[change.node].take(change.status);
            }
        }
        Ok(TreeSnapshot { at_us: self.last_us, nodes: self.nodes.clone() })
    }

    /// Reports that changes are missing, with the statuses after them.
    fn report_missing(&mut self, why: impl Into<String>) -> Result<(), GrootError> {
        let snapshot = self.take_snapshot()?;
        self.updates.push_back(TreeUpdate::Missing { why: why.into(), snapshot });
        Ok(())
    }

    /// Takes transitions, up to a place where some are missing.
    fn take(&mut self, transitions: Vec<LoggedTransition>) -> Result<(), GrootError> {
        if transitions.len() >= MOST_TRANSITIONS {
            return self.report_missing(format!(
                "more changed at once than the program remembers, {MOST_TRANSITIONS} changes"
            ));
        }
        for transition in transitions {
            let change = self.change(transition)?;
            if change.at_us < self.last_us {
                self.record()?;
                return self.report_missing("another client restarted the recording, or the clock was set back");
            }
            if change.status == self.nodes[change.node].status {
                return self.report_missing("another client has requested changes, and received them");
            }
            self.last_us = change.at_us;
            self.nodes[change.node].take(change.status);
            self.updates.push_back(TreeUpdate::Change(change));
        }
        Ok(())
    }

    /// Checks that the statuses of the nodes follow from the transitions.
    fn check(&mut self) -> Result<(), GrootError> {
        let statuses = self.client.statuses()?;
        let statuses = self.by_node(&statuses)?;
        let before = self.nodes.clone();
        let transitions = self.client.transitions(self.began_us)?;
        let changed: Vec<i64> = transitions.iter().map(|transition| transition.uid).collect();
        let is_unchanged = |node: &usize| !changed.contains(&self.tree.nodes()[*node].uid.into());
        if (0..before.len()).filter(is_unchanged).any(|node| before[node] != statuses[node]) {
            return self.report_missing("another client has requested changes, and received them");
        }
        self.take(transitions)
    }

    /// Takes the changes since the last comparison of statuses.
    fn compare(&mut self) -> Result<(), GrootError> {
        let statuses = self.client.statuses()?;
        let statuses = self.by_node(&statuses)?;
        let at_us = system_us().max(self.last_us);
        self.last_us = at_us;
        for (node, found) in statuses.into_iter().enumerate() {
            if self.nodes[node] == found {
                continue;
            }
            // The status that it had before it became idle may be new as well.
            for status in [found.last, found.status] {
                if status != self.nodes[node].status {
                    self.nodes[node].take(status);
                    self.updates.push_back(TreeUpdate::Change(StatusChange { at_us, node, before: None, status }));
                }
            }
        }
        Ok(())
    }

    fn change(&self, transition: LoggedTransition) -> Result<StatusChange, GrootError> {
        self.tree.change(transition).map_err(|problem| self.client.foreign(problem))
    }

    fn by_node(&self, statuses: &Statuses) -> Result<Vec<NodeSnapshot>, GrootError> {
        let mut nodes = vec![None; self.nodes.len()];
        for (uid, code) in statuses {
            let node = NodeSnapshot::of(*code);
            let unknown = || self.client.foreign(format!("there is no status with the number {code}"));
            let of = LoggedTransition { at_us: 0, uid: (*uid).into(), status: 0 };
            nodes[self.change(of)?.node] = Some(node.ok_or_else(unknown)?);
        }
        let all: Option<Vec<NodeSnapshot>> = nodes.into_iter().collect();
        all.ok_or_else(|| self.client.foreign("it does not report the statuses of all nodes"))
    }
}

#[expect(clippy::disallowed_methods, reason = "the clock of a program is compared with that of this computer")]
fn system_us() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_micros()).unwrap_or(i64::MAX)
}
