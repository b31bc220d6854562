//! All that a program tells about the tree that it runs, in order.

use std::collections::VecDeque;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tree_logs::{LoggedTransition, LoggedTree, NodeStatus, StatusChange};

use crate::boards::Blackboards;
use crate::client::{Client, MOST_TRANSITIONS, Statuses};
use crate::error::GrootError;
use crate::zmtp::now;

/// How often it is checked that all transitions have been told.
const CHECK: Duration = Duration::from_secs(1);
/// How often blackboards are read, unless it is said otherwise.
const READ: Duration = Duration::from_millis(200);
/// In the number of a status: the node is idle, and the rest is the status that it had before.
const WAS: u8 = 10;

/// What is new.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TreeNews {
    /// A node got another status.
    Change(StatusChange),
    /// Changes since the last one are missing.
    Missing {
        /// Why, in words.
        why: String,
        /// What is found after them.
        found: FoundStatuses,
    },
    /// The entries of all blackboards, which have changed; none if they are not read any more.
    Blackboards(Blackboards),
}

/// The status of all nodes at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundStatuses {
    /// By the clock of the program, in microseconds since 1970.
    pub at_us: i64,
    /// For each node, in the order of the tree.
    pub nodes: Vec<Standing>,
}

/// Where a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// Its status.
    pub status: NodeStatus,
    /// Its last status that was not idle, if it has had any.
    pub last: NodeStatus,
}

impl Standing {
    const NEW: Self = Self { status: NodeStatus::Idle, last: NodeStatus::Idle };

    /// That with this number.
    fn of(code: u8) -> Option<Self> {
        let last = NodeStatus::of((code % WAS).into())?;
        match code {
            WAS => None,
            0..WAS => Some(Self { status: last, last }),
            _ => (code < 2 * WAS).then_some(Self { status: NodeStatus::Idle, last }),
        }
    }

    fn take(&mut self, status: NodeStatus) {
        self.status = status;
        if status != NodeStatus::Idle {
            self.last = status;
        }
    }
}

/// A program that is asked again and again.
///
/// The program remembers transitions, and forgets those that it has told; so each is told to one client only. If others
/// ask, too, what they were told is missing here. That is noticed if a node then has a status that it cannot have: at
/// its next transition, or when all statuses are compared, once a second.
#[derive(Debug)]
pub struct TreeWatch {
    client: Client,
    tree: LoggedTree,
    /// Whether nothing but statuses and blackboards is asked for.
    is_passive: bool,
    /// When the recording of transitions began, by the clock of the program.
    began_us: i64,
    last_us: i64,
    nodes: Vec<Standing>,
    boards: Blackboards,
    news: VecDeque<TreeNews>,
    checked: Instant,
    read: Option<Instant>,
    /// How often blackboards are read; none if they are not.
    period: Option<Duration>,
}

impl TreeWatch {
    /// Asks a program for its tree and its statuses, and makes it remember transitions from then on, unless this is
    /// `passive`: then changes are found by comparing statuses, and have the times at which they were found.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn begin(mut client: Client, is_passive: bool) -> Result<(Self, FoundStatuses), GrootError> {
        let tree = client.tree()?;
        let nodes = vec![Standing::NEW; tree.nodes().len()];
        let mut watch = Self {
            client,
            tree,
            is_passive,
            began_us: 0,
            last_us: 0,
            nodes,
            boards: Blackboards::default(),
            news: VecDeque::new(),
            checked: now(),
            read: None,
            period: Some(READ),
        };
        watch.record()?;
        let found = watch.find()?;
        Ok((watch, found))
    }

    /// The tree.
    #[must_use]
    pub fn tree(&self) -> &LoggedTree {
        &self.tree
    }

    /// Reads blackboards so often from now on, or not at all.
    pub fn read_every(&mut self, period: Option<Duration>) {
        self.period = period;
        if period.is_none() && self.boards != Blackboards::default() {
            self.boards = Blackboards::default();
            self.news.push_back(TreeNews::Blackboards(Blackboards::default()));
        }
    }

    /// What is new since the last time; none if nothing is.
    ///
    /// # Errors
    /// [`GrootError`]. After any, there is no more news.
    pub fn news(&mut self) -> Result<Option<TreeNews>, GrootError> {
        if self.news.is_empty() {
            self.ask()?;
        }
        Ok(self.news.pop_front())
    }

    /// Takes what is still to be told, and lets the program forget transitions again. Nothing is told later that is
    /// missing: it is checked a last time.
    ///
    /// # Errors
    /// [`GrootError`].
    pub fn end(&mut self) -> Result<Vec<TreeNews>, GrootError> {
        self.ask()?;
        if !self.is_passive {
            self.check()?;
            self.client.stop_recording()?;
        }
        Ok(self.news.drain(..).collect())
    }

    fn ask(&mut self) -> Result<(), GrootError> {
        if self.is_passive {
            self.compare()?;
        } else {
            let told = self.client.transitions(self.began_us)?;
            self.take(told)?;
            if self.checked.elapsed() >= CHECK {
                self.checked = now();
                self.check()?;
            }
        }
        if self.period.is_some_and(|period| self.read.is_none_or(|read| read.elapsed() >= period)) {
            self.read = Some(now());
            let boards = self.client.blackboards(self.tree.blackboards())?;
            if boards != self.boards {
                self.news.push_back(TreeNews::Blackboards(boards.clone()));
                self.boards = boards;
            }
        }
        Ok(())
    }

    /// Makes the program remember transitions from now on.
    fn record(&mut self) -> Result<(), GrootError> {
        self.began_us = if self.is_passive { system_us() } else { self.client.start_recording()? };
        self.last_us = self.began_us;
        Ok(())
    }

    /// Finds out the statuses of all nodes, whatever has been told: those at any time, and what has changed since.
    fn find(&mut self) -> Result<FoundStatuses, GrootError> {
        let asked = self.client.statuses()?;
        self.nodes = self.by_node(&asked)?;
        if !self.is_passive {
            let told = self.client.transitions(self.began_us)?;
            if told.len() >= MOST_TRANSITIONS {
                return Err(self.client.foreign("its nodes change faster than it can be asked about them"));
            }
            for transition in told {
                let change = self.change(transition)?;
                self.last_us = self.last_us.max(change.at_us);
                self.nodes[change.node].take(change.status);
            }
        }
        Ok(FoundStatuses { at_us: self.last_us, nodes: self.nodes.clone() })
    }

    /// Finds out where the nodes are after changes have been missed.
    fn miss(&mut self, why: impl Into<String>) -> Result<(), GrootError> {
        let found = self.find()?;
        self.news.push_back(TreeNews::Missing { why: why.into(), found });
        Ok(())
    }

    /// Takes what was told, up to where something is missing.
    fn take(&mut self, told: Vec<LoggedTransition>) -> Result<(), GrootError> {
        if told.len() >= MOST_TRANSITIONS {
            return self.miss(format!("more changed at once than the program remembers, {MOST_TRANSITIONS} changes"));
        }
        for transition in told {
            let change = self.change(transition)?;
            if change.at_us < self.last_us {
                self.record()?;
                return self.miss("somebody else made the recording begin anew, or the clock was set back");
            }
            if change.status == self.nodes[change.node].status {
                return self.miss("changes were told to somebody else, who asks for them, too");
            }
            self.last_us = change.at_us;
            self.nodes[change.node].take(change.status);
            self.news.push_back(TreeNews::Change(change));
        }
        Ok(())
    }

    /// Checks that the nodes have the statuses that follow from what was told.
    fn check(&mut self) -> Result<(), GrootError> {
        let asked = self.client.statuses()?;
        let asked = self.by_node(&asked)?;
        let before = self.nodes.clone();
        let told = self.client.transitions(self.began_us)?;
        let changed: Vec<i64> = told.iter().map(|transition| transition.uid).collect();
        let rests = |node: &usize| !changed.contains(&self.tree.nodes()[*node].uid.into());
        if (0..before.len()).filter(rests).any(|node| before[node] != asked[node]) {
            return self.miss("changes were told to somebody else, who asks for them, too");
        }
        self.take(told)
    }

    /// Takes what has changed since the statuses were compared.
    fn compare(&mut self) -> Result<(), GrootError> {
        let asked = self.client.statuses()?;
        let asked = self.by_node(&asked)?;
        let at_us = system_us().max(self.last_us);
        self.last_us = at_us;
        for (node, found) in asked.into_iter().enumerate() {
            if self.nodes[node] == found {
                continue;
            }
            // What it answered before it became idle may not have been seen.
            for status in [found.last, found.status] {
                if status != self.nodes[node].status {
                    self.nodes[node].take(status);
                    self.news.push_back(TreeNews::Change(StatusChange { at_us, node, before: None, status }));
                }
            }
        }
        Ok(())
    }

    fn change(&self, transition: LoggedTransition) -> Result<StatusChange, GrootError> {
        self.tree.change(transition).map_err(|problem| self.client.foreign(problem))
    }

    /// What was told, in the order of the nodes.
    fn by_node(&self, told: &Statuses) -> Result<Vec<Standing>, GrootError> {
        let mut nodes = vec![None; self.nodes.len()];
        for (uid, code) in told {
            let standing = Standing::of(*code);
            let unknown = || self.client.foreign(format!("there is no status with the number {code}"));
            let of = LoggedTransition { at_us: 0, uid: (*uid).into(), status: 0 };
            nodes[self.change(of)?.node] = Some(standing.ok_or_else(unknown)?);
        }
        let all: Option<Vec<Standing>> = nodes.into_iter().collect();
        all.ok_or_else(|| self.client.foreign("it does not tell the statuses of all nodes"))
    }
}

#[expect(clippy::disallowed_methods, reason = "the clock of a program is compared with that of this computer")]
fn system_us() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_micros()).unwrap_or(i64::MAX)
}
