//! Why the tree failed: the leaf that made it fail, and what this leaf had received, or had waited for in vain.

use std::collections::BTreeMap;
use std::time::Duration;

use bt::{Outcome, Status};
use channels::{Event, EventKind};
use monitors::Sighting;

use crate::header::{Header, Node};

/// A failure of the whole tree.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeFailure {
    /// The index of the node that made the tree fail: a leaf, or a node that failed although none of its children did.
    pub node: usize,
    /// The first tick at which the tree failed, if it failed at several in a row.
    pub tick: u64,
    /// Its time, since the start of the run.
    pub time: Duration,
    /// The last message from a component to the leaf's skill up to then. What came before the leaf asked for something,
    /// or before it began to wait, is not why it failed.
    pub message: Option<Sighting>,
    /// What the leaf's skill asked a component for and did not get.
    pub unmet: Option<Unmet>,
    /// How long the leaf had been running; none if it answered at once.
    pub ran: Option<Duration>,
    /// Whether the tree has failed at every tick since then that it has answered.
    pub lasts: bool,
}

/// Something that a leaf's skill asked for and did not get.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// The request, or the goal.
    pub request: Sighting,
    /// Whether the skill called it off; otherwise nothing was answered.
    pub is_called_off: bool,
}

/// Finds out about failures from one step after another.
#[derive(Clone, Debug)]
pub(crate) struct Failures {
    /// By the index of the channel: the leaf whose skill is at an end of it, and what the messages there are to it.
    leaves: Vec<Option<(usize, MessageRole)>>,
    /// By the index of the node.
    attempts: Vec<Attempt>,
    latest: Option<TreeFailure>,
    /// The tick since which the tree has been running. Within a tick, it is running, too.
    running_since: Option<u64>,
}

/// What the messages of a channel are to a leaf's skill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MessageRole {
    /// From the tree.
    Order,
    /// To the tree.
    Answer,
    /// To a component.
    Request,
    /// From a component.
    Message,
}

/// What a leaf's skill has done and received since the tree started it.
#[derive(Clone, Debug, Default)]
struct Attempt {
    /// None if it has never begun.
    since: Option<Duration>,
    is_running: bool,
    has_run: bool,
    /// The last request, and whether anything has come since.
    request: Option<Event>,
    is_answered: bool,
    is_called_off: bool,
    /// The last request of an earlier attempt, until it is answered. Skills that ask one thing at a time wait for that.
    owed: Option<Event>,
    /// The last message from a component, also before it began.
    message: Option<Event>,
    /// Whether it came since then.
    is_new: bool,
}

impl Attempt {
    fn note(&mut self, role: MessageRole, event: &Event, head: Option<&str>) {
        match role {
            MessageRole::Order if self.is_running => {}
            MessageRole::Order => {
                let Self { request, is_answered, owed, message, .. } = std::mem::take(self);
                let owed = request.filter(|_| !is_answered).or(owed);
                *self = Self { since: Some(event.time), owed, message, ..Self::default() };
            }
            MessageRole::Answer => {
                self.is_running = head == Some("running");
                self.has_run |= self.is_running;
            }
            // So are actions called off, in the names of interfaces.
            MessageRole::Request if head.is_some_and(|head| head.ends_with(".cancel")) => self.is_called_off = true,
            MessageRole::Request => {
                (self.request, self.is_answered, self.is_called_off) = (Some(event.clone()), false, false)
            }
            MessageRole::Message if self.request.is_none() && self.owed.is_some() => self.owed = None,
            MessageRole::Message => (self.message, self.is_new, self.is_answered) = (Some(event.clone()), true, true),
        }
    }

    /// What it asked for and did not get.
    fn unmet(&self) -> Option<&Event> {
        match &self.request {
            Some(request) => (self.is_called_off || !self.is_answered).then_some(request),
            None => self.owed.as_ref(),
        }
    }

    /// The message that may be why it failed.
    fn message(&self) -> Option<&Event> {
        let asks = self.request.is_some() || self.has_run;
        self.message.as_ref().filter(|_| self.is_new || !asks)
    }
}

impl Failures {
    pub(crate) fn new(header: &Header) -> Self {
        let leaves = header.tree.iter().enumerate().filter(|(_, node)| node.is_leaf);
        let leaves: BTreeMap<&str, usize> = leaves.map(|(number, node)| (node.process.as_str(), number)).collect();
        let is_component = |name: &str| header.components.iter().any(|known| known == name);
        let ends = header.topology.channels().map(|channel| header.topology.ends(channel));
        let role = |(from, to): (&str, &str)| match (leaves.get(from), leaves.get(to)) {
            (_, Some(leaf)) => {
                Some((*leaf, if is_component(from) { MessageRole::Message } else { MessageRole::Order }))
            }
            (Some(leaf), None) => {
                Some((*leaf, if is_component(to) { MessageRole::Request } else { MessageRole::Answer }))
            }
            (None, None) => None,
        };
        let attempts = vec![Attempt::default(); header.tree.len()];
        Self { leaves: ends.map(role).collect(), attempts, latest: None, running_since: None }
    }

    /// Takes note of a message; its channel is in the topology.
    pub(crate) fn note(&mut self, event: &Event) {
        let EventKind::Received { channel, message } = &event.kind else { return };
        if let Some((leaf, role)) = self.leaves[channel.index()] {
            self.attempts[leaf].note(role, event, message.head());
        }
    }

    /// Takes note of what the nodes have answered so far at this tick.
    pub(crate) fn judge(&mut self, header: &Header, outcomes: &[Option<Outcome>], tick: u64, time: Duration) {
        if let Some(node) = cause(&header.tree, outcomes) {
            let has_run = self.running_since.is_some_and(|since| since != tick);
            if has_run || self.latest.as_ref().is_none_or(|failure| !failure.lasts) {
                let (attempt, seen) = (&self.attempts[node], |event| Sighting::of(event, &header.topology));
                let is_called_off = attempt.is_called_off;
                let unmet = attempt.unmet().and_then(seen).map(|request| Unmet { request, is_called_off });
                let message = attempt.message().and_then(seen);
                let ran = attempt.since.filter(|_| attempt.has_run).map(|since| time.saturating_sub(since));
                self.latest = Some(TreeFailure { node, tick, time, message, unmet, ran, lasts: true });
            }
            self.running_since = None;
        } else if let Some(Some(Outcome::Answered(answer))) = outcomes.first() {
            match (answer, &mut self.latest) {
                (Status::Running, _) => _ = self.running_since.get_or_insert(tick),
                (_, Some(failure)) => failure.lasts = false,
                _ => {}
            }
        }
    }

    pub(crate) fn latest(&self) -> Option<TreeFailure> {
        self.latest
            .clone()
            .map(|failure| TreeFailure { lasts: failure.lasts && self.running_since.is_none(), ..failure })
    }
}

/// The node that made the root fail, if it has failed: of a fallback, the last alternative counts, since the others had
/// one more; of others, the first child that has failed.
pub(crate) fn cause(tree: &[Node], outcomes: &[Option<Outcome>]) -> Option<usize> {
    let failed = |&node: &usize| outcomes[node] == Some(Outcome::Answered(Status::Failure));
    let mut node = (!tree.is_empty()).then_some(0).filter(failed)?;
    loop {
        let mut children = (0..tree.len()).filter(|&child| tree[child].parent == Some(node)).filter(failed);
        let is_fallback = tree[node].symbol.as_ref().is_some_and(|symbol| symbol.starts_with('?'));
        match if is_fallback { children.next_back() } else { children.next() } {
            // A parent comes before its children, also in a damaged recording.
            Some(child) if child > node => node = child,
            _ => return Some(node),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(parent: Option<usize>, symbol: &str) -> Node {
        let symbol = (!symbol.is_empty()).then(|| symbol.to_owned());
        Node { parent, process: String::new(), is_leaf: symbol.is_none(), symbol }
    }

    #[test]
    fn the_cause_of_a_failure_is_where_no_alternative_was_left() {
        let tree = [
            node(None, "→"),
            node(Some(0), "?"),
            node(Some(1), ""),
            node(Some(1), ""),
            node(Some(0), "?*"),
            node(Some(4), ""),
            node(Some(4), "→*"),
            node(Some(6), ""),
            node(Some(6), ""),
            node(Some(0), "¬"),
            node(Some(9), ""),
        ];
        let outcomes = |answers: &str| -> Vec<Option<Outcome>> {
            let status = |answer| match answer {
                'S' => Some(Status::Success),
                'F' => Some(Status::Failure),
                'R' => Some(Status::Running),
                _ => None,
            };
            answers.chars().map(|answer| status(answer).map(Outcome::Answered)).collect()
        };
        // The condition of the second fallback is false, as usual; what fails is the way to make it true.
        assert_eq!(cause(&tree, &outcomes("FSFSFFFSF--")), Some(8));
        assert_eq!(cause(&tree, &outcomes("FFFF-------")), Some(3));
        // An inverter fails although its child does not.
        assert_eq!(cause(&tree, &outcomes("FS-SS-S--FS")), Some(9));
        assert_eq!(cause(&tree[..1], &outcomes("F")), Some(0));
        assert_eq!(cause(&tree, &outcomes("SFFFF------")), None);
        assert_eq!(cause(&[], &[]), None);
    }

    #[test]
    fn a_failure_lasts_while_every_tick_ends_in_one() {
        let header = Header { tree: vec![node(None, "")], ..Header::default() };
        let judged = |answers: &[(u64, Status)]| {
            let mut failures = Failures::new(&header);
            for &(tick, answer) in answers {
                failures.judge(&header, &[Some(Outcome::Answered(answer))], tick, Duration::from_secs(tick));
            }
            failures.latest().map(|failure| (failure.tick, failure.lasts))
        };
        use Status::{Failure, Running, Success};
        assert_eq!(judged(&[(0, Running), (1, Success)]), None);
        // Within its tick, the tree is running.
        assert_eq!(judged(&[(3, Running), (3, Failure), (4, Running), (4, Failure)]), Some((3, true)));
        assert_eq!(judged(&[(3, Failure), (4, Running), (6, Failure)]), Some((6, true)));
        assert_eq!(judged(&[(3, Failure), (4, Success)]), Some((3, false)));
        assert_eq!(judged(&[(3, Failure), (4, Running), (5, Running)]), Some((3, false)));
        assert_eq!(judged(&[(3, Failure), (4, Running)]), Some((3, false)));
    }
}
