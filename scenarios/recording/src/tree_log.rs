//! The records of a tree that BehaviorTree.CPP has run, from the log that it wrote.
//!
//! Every node is a process. Its answers are messages to the tree, like those of a leaf in a simulation; so is its halt,
//! if it was running. All else that a run has is unknown: ticks, who was asked and skipped, and the answers that repeat
//! the one before.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bt::{Outcome, Status};
use channels::{Capacity, ChannelId, Domain, Event, EventKind, FieldKind, Message, Shape, Topology, Value};
use chrono::DateTime;
use tree_logs::{Log, LogError, LoggedNode, NodeStatus, StatusChange};

use crate::{Doubts, End, Ended, Happening, Header, Judge, Node, Origin, Record, Step, TREE};

/// The records of a log.
#[derive(Debug)]
pub(crate) struct TreeLog {
    log: Log,
    judge: Judge,
    /// From each node to the tree.
    channels: Vec<ChannelId>,
    /// For each node, the first one after it that is not below it.
    ends: Vec<usize>,
    statuses: Vec<NodeStatus>,
    outcomes: Vec<Option<Outcome>>,
    /// By the clock of whoever wrote the log.
    began_us: i64,
    last_us: i64,
    time: Duration,
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
        let (topology, channels) = wired(log.tree().nodes());
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let root = &log.tree().nodes()[0];
        let session = log.session().filter(|session| session.of > 1);
        let session =
            session.map_or_else(String::new, |session| format!(", session {} of {}", session.number, session.of));
        let about = format!("A log of BehaviorTree.CPP, whose tree begins with {}{session}", root.name);
        let began_us = log.began_us().or(next.as_ref().and_then(|first| Some(first.as_ref().ok()?.at_us))).unwrap_or(0);
        let recorded = Some(format!("steward report {}", path.display()));
        let began = DateTime::from_timestamp_micros(began_us);
        let origin = Origin { recorded, began, ..Origin::default() };
        let doubts = Doubts::none(0);
        let (judge, header, start) = Judge::begin([name, about], origin, &topology, Duration::ZERO, &[], doubts);
        let tree = drawn(log.tree().nodes(), &topology);
        let mut start = vec![Record::Step(start), Record::Header(Box::new(Header { tree, ..header }))];
        if !matches!(next, Some(Ok(_))) {
            // A run ends with a step, even if nothing was logged.
            start.insert(0, Record::Step(Step::default()));
        }
        let count = log.tree().nodes().len();
        let mut ends: Vec<usize> = (1..=count).collect();
        for node in (1..count).rev() {
            let parent = log.tree().nodes()[node].parent.unwrap_or_default();
            ends[parent] = ends[parent].max(ends[node]);
        }
        let (statuses, outcomes) = (vec![NodeStatus::Idle; count], vec![None; count]);
        let (last_us, time, has_ended) = (began_us, Duration::ZERO, false);
        Ok(Self { log, judge, channels, ends, statuses, outcomes, began_us, last_us, time, start, next, has_ended })
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
            Some(Ok(transition)) => {
                self.next = self.log.next_change().transpose();
                Ok(Some(Record::Step(self.step(transition))))
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
        Record::End(Box::new(End { ended, ..self.judge.finish(&[]) }))
    }

    /// The record of a transition.
    fn step(&mut self, StatusChange { at_us, node, status }: StatusChange) -> Step {
        let back_us = self.last_us.saturating_sub(at_us);
        self.last_us = at_us;
        // A run does not go back: after the clock was set back, time stands still until it has caught up.
        let since = u64::try_from(at_us.saturating_sub(self.began_us)).unwrap_or(0);
        self.time = self.time.max(Duration::from_micros(since));
        let before = std::mem::replace(&mut self.statuses[node], status);
        if before == NodeStatus::Idle {
            // It begins anew: what was answered below it belongs to an earlier time.
            self.outcomes[node + 1..self.ends[node]].fill(None);
        }
        let answer = match status {
            NodeStatus::Answered(answer) => Some(Outcome::Answered(answer)),
            NodeStatus::Idle if before == NodeStatus::Answered(Status::Running) => Some(Outcome::Halted),
            // It was reset after its answer, which remains the last one.
            NodeStatus::Idle => None,
        };
        let mut step = match answer {
            None => Step { time: self.time, communications: self.judge.end().messages, ..Step::default() },
            Some(answer) => {
                self.outcomes[node] = Some(answer);
                let message = Message::new([Value::symbol(answer.name())]);
                let kind = EventKind::Received { channel: self.channels[node], message };
                self.judge.step(Event { step: self.judge.end().messages + 1, tick: 0, time: self.time, kind }, &mut [])
            }
        };
        let details = step.details.get_or_insert_default();
        details.outcomes = Some(self.outcomes.clone());
        if back_us > 0 {
            let words = format!(
                "the clock of the log went back by {:.6} s",
                Duration::from_micros(back_us.unsigned_abs()).as_secs_f64()
            );
            step.happenings.push(Happening::Moved { words });
        }
        step
    }
}

/// The processes of the nodes, and the channel from each to the tree.
fn wired(nodes: &[LoggedNode]) -> (Arc<Topology>, Vec<ChannelId>) {
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
    let answers = ["running", "success", "failure", "skipped", "halted"];
    let reply = Domain::new([Shape::new([("reply", FieldKind::symbols(answers))])]);
    let wire = |name: &String| {
        let node = topology.process(name).expect(unique);
        topology.channel(node, tree, Capacity::One, reply.clone()).expect(unique)
    };
    let channels = names.iter().map(wire).collect();
    (Arc::new(topology), channels)
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
