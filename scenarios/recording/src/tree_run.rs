//! The records of a tree that BehaviorTree.CPP runs, from the changes of status that it reports.
//!
//! Every node is a process. Its answers are messages to the tree, like those of a leaf in a simulation; so is its halt,
//! if it was running. All else that a run has is unknown: ticks, which nodes were asked and skipped, and the answers
//! that repeat the one before.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use bt::{Outcome, Status};
use channels::{Capacity, Domain, Event, EventKind, FieldKind, Flaw, Gap, Message, Shape, Topology, Value};
use monitors::{LogEnd, Property};
use tree_logs::{LoggedNode, LoggedTree, NodeStatus, StatusChange};

use crate::{Doubts, End, Ended, EntryValue, Happening, Header, Judge, Node, Origin, Step, TREE};

/// The name of the blackboard that a program may give to its tree, above that of the main tree.
const GIVEN: &str = "ROOT";

/// What has become of the nodes of a tree, and of the properties that it is checked against.
#[derive(Debug)]
pub struct TreeRun {
    topology: Arc<Topology>,
    judge: Judge,
    /// For each node, the first one after it that is not below it.
    ends: Vec<usize>,
    statuses: Vec<NodeStatus>,
    /// The nodes with a last outcome.
    answered: BTreeSet<usize>,
    blackboards: Vec<String>,
    /// The entries of blackboards, by the index of the blackboard and the key.
    entries: BTreeMap<(usize, String), EntryValue>,
    /// By the clock of its source, in microseconds since 1970.
    began_us: i64,
    last_us: i64,
    time: Duration,
}

impl TreeRun {
    /// The processes of a tree's nodes, and from each, in the same order, a channel to the tree.
    #[must_use]
    pub fn topology(tree: &LoggedTree) -> Arc<Topology> {
        wired(tree.nodes())
    }

    /// Starts at a time, in microseconds since 1970. The topology is [that](Self::topology) of the tree; `about` has a
    /// name, and the program in words; `doubts` what may be missing. Also returns the first two records.
    #[must_use]
    pub fn begin(
        about: [String; 2],
        origin: Origin,
        (tree, topology): (&LoggedTree, &Arc<Topology>),
        began_us: i64,
        properties: &[Property],
        doubts: Doubts,
    ) -> (Self, Header, Step) {
        let (judge, header, start) = Judge::begin(about, origin, topology, Duration::ZERO, properties, doubts);
        let (nodes, count) = (tree.nodes(), tree.nodes().len());
        let mut ends: Vec<usize> = (1..=count).collect();
        for node in (1..count).rev() {
            let parent = nodes[node].parent.unwrap_or_default();
            ends[parent] = ends[parent].max(ends[node]);
        }
        let run = Self {
            topology: Arc::clone(topology),
            judge,
            ends,
            statuses: vec![NodeStatus::Idle; count],
            answered: BTreeSet::new(),
            blackboards: tree.blackboards().iter().map(String::as_str).chain([GIVEN]).map(str::to_owned).collect(),
            entries: BTreeMap::new(),
            began_us,
            last_us: began_us,
            time: Duration::ZERO,
        };
        let (tree, blackboards) = (drawn(nodes, topology), run.blackboards.clone());
        (run, Header { tree, blackboards, ..header }, start)
    }

    /// The record of a change of status. The status before is that of the change, if it has one.
    pub fn step(&mut self, change: StatusChange, properties: &mut [Property]) -> Step {
        let StatusChange { at_us, node, before: said, status } = change;
        let back_us = self.last_us.saturating_sub(at_us);
        self.go_on(at_us);
        let before = said.unwrap_or(self.statuses[node]);
        self.statuses[node] = status;
        let mut outcomes: Vec<(usize, Option<Outcome>)> = Vec::new();
        if before == NodeStatus::Idle {
            // It begins anew: what was answered below it belongs to an earlier time.
            outcomes.extend(self.answered.extract_if(node + 1..self.ends[node], |_| true).map(|below| (below, None)));
        }
        let answer = match status {
            NodeStatus::Answered(answer) => Some(Outcome::Answered(answer)),
            NodeStatus::Idle if before == NodeStatus::Answered(Status::Running) => Some(Outcome::Halted),
            // It was reset after its answer, which remains the last one.
            NodeStatus::Idle => None,
        };
        let mut step = match answer {
            None => self.quiet(),
            Some(answer) => {
                self.answered.insert(node);
                outcomes.push((node, Some(answer)));
                let channel = self.topology.channels().nth(node).expect("each node has a channel");
                let message = Message::new([Value::symbol(answer.name())]);
                let number = self.judge.end().messages + 1;
                let kind = EventKind::Received { channel, message };
                self.judge.step(Event { step: number, tick: 0, time: self.time, kind }, properties)
            }
        };
        step.details.get_or_insert_default().outcomes = outcomes;
        if back_us > 0 {
            let back = Duration::from_micros(back_us.unsigned_abs()).as_secs_f64();
            step.happenings.push(Happening::Moved { words: format!("the clock of the log went back by {back:.6} s") });
        }
        step
    }

    /// The record of a time at which the nodes were found to have these statuses, and the idle ones those before. How
    /// and when they came to it is not known.
    pub fn find(&mut self, at_us: i64, found: impl Iterator<Item = (NodeStatus, NodeStatus)>) -> Step {
        self.go_on(at_us);
        let outcome = |(status, last)| match (status, last) {
            (_, NodeStatus::Idle) => None,
            (NodeStatus::Idle, NodeStatus::Answered(Status::Running)) => Some(Outcome::Halted),
            (_, NodeStatus::Answered(answer)) => Some(Outcome::Answered(answer)),
        };
        let outcomes: Vec<(usize, Option<Outcome>)>;
        (self.statuses, outcomes) = found.enumerate().map(|(node, found)| (found.0, (node, outcome(found)))).unzip();
        self.answered = outcomes.iter().filter(|(_, outcome)| outcome.is_some()).map(|(node, _)| *node).collect();
        let mut step = self.quiet();
        step.details.get_or_insert_default().outcomes = outcomes;
        step
    }

    /// The record of a time at which the blackboards were found to have these entries, by the name of the blackboard
    /// and the key. Those of blackboards that the tree does not have are left out.
    pub fn read(&mut self, at_us: i64, entries: impl Iterator<Item = (String, String, EntryValue)>) -> Step {
        self.go_on(at_us);
        let index = |name: String| self.blackboards.iter().position(|board| *board == name);
        let entries: BTreeMap<_, _> =
            entries.filter_map(|(board, key, value)| Some(((index(board)?, key), value))).collect();
        let gone = self.entries.keys().filter(|entry| !entries.contains_key(*entry));
        let gone = gone.map(|(board, key)| (*board, key.clone(), None));
        let new = entries.iter().filter(|(entry, value)| self.entries.get(*entry) != Some(value));
        let new = new.map(|((board, key), value)| (*board, key.clone(), Some(value.clone())));
        let changed = gone.chain(new).collect();
        self.entries = entries;
        let mut step = self.quiet();
        step.details.get_or_insert_default().entries = changed;
        step
    }

    /// The record of a time until which any changes may be missing, since the last one: the verdicts that they could
    /// change are unsure.
    pub fn miss(&mut self, at_us: i64, why: &str, properties: &mut [Property]) -> Step {
        let anything = Gap::of_anything(why);
        for channel in self.topology.channels() {
            self.judge.miss(&Gap { channel: Some(channel), ends: true, ..anything.clone() }, properties);
            self.judge.resume(channel, properties);
        }
        self.go_on(at_us);
        Step { happenings: vec![Happening::Lost(anything)], ..self.quiet() }
    }

    /// The record of a time from which on any change may be missing.
    pub fn doubt(&mut self, at_us: i64, why: &str, properties: &mut [Property]) -> Step {
        let anything = Gap::of_anything(why);
        self.judge.miss(&anything, properties);
        self.go_on(at_us);
        Step { happenings: vec![Happening::Lost(anything)], ..self.quiet() }
    }

    /// The record of what may be wrong from here on, at a time. If changes are missing, no node is known any more.
    pub(crate) fn lose(&mut self, at: Duration, gap: Gap) -> Step {
        self.time = self.time.max(at);
        let mut step = self.quiet();
        if gap.flaw != Flaw::Late {
            let forgotten = std::mem::take(&mut self.answered).into_iter().map(|node| (node, None));
            step.details.get_or_insert_default().outcomes = forgotten.collect();
        }
        step.happenings.push(Happening::Lost(gap));
        step
    }

    /// The record of something else that happened, in words.
    pub fn note(&mut self, at_us: i64, words: String) -> Step {
        self.go_on(at_us);
        Step { happenings: vec![Happening::Moved { words }], ..self.quiet() }
    }

    /// The last record.
    #[must_use]
    pub fn finish(&self, ended: Ended, properties: &[Property]) -> End {
        End { ended, ..self.judge.finish(properties) }
    }

    /// How far it goes.
    #[must_use]
    pub fn end(&self) -> LogEnd {
        self.judge.end()
    }

    /// What missing messages make unsure.
    #[must_use]
    pub fn doubts(&self) -> &Doubts {
        self.judge.doubts()
    }

    /// A run does not go back: after the clock was set back, time stands still until it has caught up.
    fn go_on(&mut self, at_us: i64) {
        self.last_us = at_us;
        self.time = self.time.max(self.since_start(at_us));
    }

    /// A time, in microseconds since 1970, as one of the run.
    pub(crate) fn since_start(&self, at_us: i64) -> Duration {
        Duration::from_micros(u64::try_from(at_us.saturating_sub(self.began_us)).unwrap_or(0))
    }

    pub(crate) fn time(&self) -> Duration {
        self.time
    }

    /// A record without a message.
    fn quiet(&self) -> Step {
        Step { time: self.time, communications: self.judge.end().messages, ..Step::default() }
    }
}

/// The processes of the nodes, and the channel from each to the tree.
fn wired(nodes: &[LoggedNode]) -> Arc<Topology> {
    // A leaf has the name that it would have in a simulation, unless that is the tree's.
    let leaves_first = || {
        nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.is_leaf)
            .chain(nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf))
    };
    let labels: Vec<&str> = std::iter::once(TREE).chain(leaves_first().map(|(_, node)| node.name.as_str())).collect();
    let mut names = vec![String::new(); nodes.len()];
    for ((index, _), name) in leaves_first().zip(bt::process_names(&labels).into_iter().skip(1)) {
        names[index] = name;
    }
    let mut topology = Topology::default();
    let unique = "every name is different, and every channel has ends of its own";
    let tree = topology.process(TREE).expect(unique);
    let mut paths: BTreeMap<&str, usize> = BTreeMap::new();
    nodes.iter().for_each(|node| *paths.entry(&node.path).or_default() += 1);
    let answers = ["running", "success", "failure", "skipped", "halted"];
    let reply = Domain::new([Shape::new([("reply", FieldKind::symbols(answers))])]);
    for (LoggedNode { uid, type_id, name: label, path, .. }, name) in nodes.iter().zip(names) {
        let node = topology.process(&name).expect(unique);
        topology.channel(node, tree, Capacity::One, reply.clone()).expect(unique);
        let unique_path = if paths[path.as_str()] == 1 { path.clone() } else { format!("{path}::{uid}") };
        topology.call(node, vec![unique_path, path.clone(), label.clone(), name, type_id.clone()]);
    }
    Arc::new(topology)
}

/// The nodes as pages and pictures draw them.
fn drawn(nodes: &[LoggedNode], topology: &Topology) -> Vec<Node> {
    let processes = topology.processes().skip(1);
    nodes
        .iter()
        .zip(processes)
        .map(|(node, process)| Node {
            parent: node.parent,
            process: topology.name(process).to_owned(),
            symbol: node.kind.and_then(bt::Kind::symbol).map(str::to_owned),
            is_leaf: node.is_leaf,
        })
        .collect()
}
