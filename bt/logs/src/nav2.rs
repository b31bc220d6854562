//! Nav2's topic `/behavior_tree_log` in a bag: a message for each tick that ends running and changed something. The
//! messages do not name their tree.

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

use bags::{Bag, Definitions, Messages, Received, Source as _};
use bt::{Status, Tree};
use channels::Flaw;
use diagnostics::from_disk;
use ros_messages::{Decoder, Layout, Value, Want};

use crate::error::LogError;
use crate::status::{LogEntry, LogGap, NodeStatus, StatusChange};
use crate::tree::{LoggedNode, LoggedTree};

/// The type of the topic.
const KIND: &str = "nav2_msgs/msg/BehaviorTreeLog";

/// How long after the last change of a tick its message is stamped, at most, if both are by the same clock: chosen, not
/// measured. Simulated time is years away from the wall clock.
const SAME_CLOCK_US: i64 = 1_000_000;

/// The tree whose statuses a bag has.
#[derive(Debug)]
pub struct BagTree {
    /// As Nav2 loaded it.
    pub tree: Tree,
    /// The topic with its statuses; none if the bag has only one of that type.
    pub topic: Option<String>,
}

impl From<Tree> for BagTree {
    fn from(tree: Tree) -> Self {
        Self { tree, topic: None }
    }
}

/// The statuses of a tree's nodes in a bag.
pub(crate) struct Nav2Log {
    path: PathBuf,
    topic: Topic,
    /// The time of the first entry.
    pub(crate) began_us: Option<i64>,
    messages: Messages,
    body: Vec<u8>,
    waiting: VecDeque<LogEntry>,
    /// The time of the message before.
    last_us: Option<i64>,
    /// How many losses of the bag have been reported.
    reported: usize,
}

/// How the messages of the topic are read.
struct Topic {
    name: String,
    decoder: Decoder,
    fields: Fields,
    /// The names of the tree's nodes, in document order.
    names: Vec<String>,
    /// The nodes by their names, if the messages do not number them.
    by_name: Option<BTreeMap<String, usize>>,
}

/// The indices of the fields that are read.
struct Fields {
    timestamp: usize,
    items: usize,
    item_timestamp: usize,
    node_name: usize,
    uid: Option<usize>,
    previous: usize,
    current: usize,
}

/// The contents of a message.
struct Tick {
    at_us: i64,
    changes: Vec<StatusChange>,
    /// Whether it begins with changes of an earlier tick, at an unknown time.
    is_late: bool,
}

/// Why a message is not one of the tree's.
enum Unfit {
    /// It is about another tree, in these words.
    Foreign(String),
    Unreadable(String),
}

impl std::fmt::Debug for Nav2Log {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Nav2Log").field("path", &self.path).field("topic", &self.topic.name).finish_non_exhaustive()
    }
}

/// Opens a bag that has the statuses of a tree. Returns the tree as the log has it, too.
pub(crate) fn open(path: &Path, BagTree { tree, topic }: &BagTree) -> Result<(LoggedTree, Nav2Log), LogError> {
    let unfit = |problem: String, help: String| LogError::Unfit { path: path.to_owned(), problem, help };
    let bag = Bag::open(path)?;
    let survey = bag.survey();
    let topics: Vec<_> = survey.topics.iter().filter(|topic| topic.kind == KIND).collect();
    let names: Vec<&str> = topics.iter().map(|topic| topic.name.as_str()).collect();
    let file = tree.source().name();
    let topic = match (topics.as_slice(), topic) {
        ([], _) => {
            let help = "record `/behavior_tree_log`, which Nav2's navigators publish".to_owned();
            return Err(unfit(format!("it has no topic of type {KIND}"), help));
        }
        ([topic], None) => *topic,
        ([first, ..], None) => {
            let problem = format!("it has several topics of type {KIND}: {}", names.join(", "));
            return Err(unfit(problem, format!("name the one of the tree: `--tree {}={file}`", first.name)));
        }
        (_, Some(name)) => *topics.iter().find(|topic| topic.name == *name).ok_or_else(|| {
            let known = if names.len() == 1 { "only one" } else { "only these" };
            unfit(format!("it has no topic {name} of type {KIND}"), format!("{known}: {}", names.join(", ")))
        })?,
    };
    let definitions = Definitions { survey, folders: &[], read: &from_disk };
    let layout = definitions.layout(topic).map_err(|undefined| unfit(undefined.why, undefined.help))?;
    let tree = LoggedTree::of(tree);
    let foreign = || unfit(format!("{} is not {KIND} as Nav2 has it", topic.name), "record it with Nav2".to_owned());
    let fields = Fields::of(&layout).ok_or_else(foreign)?;
    let by_name = match fields.uid {
        Some(_) => None,
        None => Some(by_name(tree.nodes()).map_err(|name| {
            let problem = format!(
                "the messages on {} have no numbers of nodes, and several nodes of the tree are called `{name}`",
                topic.name
            );
            unfit(problem, "give each node a `name` of its own; Nav2 numbers nodes from Jazzy on".to_owned())
        })?),
    };
    let names = tree.nodes().iter().map(|node| node.name.clone()).collect();
    let topic = Topic { name: topic.name.clone(), decoder: Decoder::new(&layout, &Want::All), fields, names, by_name };
    let help = || "name the file of the tree that ran: `--tree FILE.xml`".to_owned();
    let (began_us, waiting) = topic.begin(&bag).map_err(|problem| unfit(problem, help()))?;
    let (messages, body) = (bag.messages_on([topic.name.as_str()]), Vec::new());
    Ok((tree, Nav2Log { path: path.to_owned(), topic, began_us, messages, body, waiting, last_us: None, reported: 0 }))
}

/// The nodes by their names, or a name that several have.
fn by_name(nodes: &[LoggedNode]) -> Result<BTreeMap<String, usize>, String> {
    let mut by_name = BTreeMap::new();
    match nodes.iter().enumerate().find(|(index, node)| by_name.insert(node.name.clone(), *index).is_some()) {
        Some((_, twice)) => Err(twice.name.clone()),
        None => Ok(by_name),
    }
}

impl Fields {
    fn of(layout: &Layout) -> Option<Self> {
        let field = |layout: &Layout, name: &str| layout.fields.iter().position(|field| field.name == name);
        let items = field(layout, "event_log")?;
        let ros_messages::Base::Message(item) = &layout.fields[items].kind.base else { return None };
        Some(Self {
            timestamp: field(layout, "timestamp")?,
            items,
            item_timestamp: field(item, "timestamp")?,
            node_name: field(item, "node_name")?,
            uid: field(item, "uid"),
            previous: field(item, "previous_status")?,
            current: field(item, "current_status")?,
        })
    }
}

impl Topic {
    /// Reads all messages once, to know before the first of them what is missing, and that some are about another tree.
    /// Also returns the time of the first change.
    ///
    /// # Errors
    /// Why the tree is not that of the messages, in words.
    fn begin(&self, bag: &Bag) -> Result<(Option<i64>, VecDeque<LogEntry>), String> {
        let (mut messages, mut body) = (bag.messages_on([self.name.as_str()]), Vec::new());
        let (mut began_us, mut fit, mut foreign, mut first) = (None, 0_u64, 0_u64, None);
        loop {
            match messages.receive(&mut body) {
                Received::Message(_) => {}
                Received::Over => break,
                _ => continue,
            }
            match self.tick(&body) {
                Ok(tick) => {
                    fit += 1;
                    began_us = began_us.or(tick.changes.first().map(|change| change.at_us));
                }
                Err(Unfit::Foreign(why)) => {
                    foreign += 1;
                    first.get_or_insert(why);
                }
                Err(Unfit::Unreadable(_)) => {}
            }
        }
        if let Some(first) = first.as_ref().filter(|_| fit == 0) {
            return Err(format!("no message on {} is about the tree; the first: {first}", self.name));
        }
        let gap = |flaw| move |why| LogEntry::Lost(LogGap { since_us: None, flaw, why });
        // Messages of another tree that fit by chance cannot be distinguished from the tree's own.
        let foreign = first.map(|first| {
            let count = if foreign == 1 { "1 message".to_owned() } else { format!("{foreign} messages") };
            format!("{count} of {} on {} cannot be of this tree; the first: {first}", fit + foreign, self.name)
        });
        let lost = bag.survey().lost.iter().cloned().map(gap(Flaw::Missing));
        Ok((began_us, lost.chain(foreign.map(gap(Flaw::Mixed))).collect()))
    }

    /// The contents of a message.
    fn tick(&self, body: &[u8]) -> Result<Tick, Unfit> {
        let unreadable = || Unfit::Unreadable("it is not a message of its type".to_owned());
        let message = self.decoder.decode(body).map_err(|mismatch| Unfit::Unreadable(mismatch.to_string()))?;
        let Value::Message(fields) = &message else { return Err(unreadable()) };
        let Value::List(items) = &fields[self.fields.items] else { return Err(unreadable()) };
        let at_us = stamp_us(&fields[self.fields.timestamp]).ok_or_else(unreadable)?;
        let change = |item: &Value| {
            let Value::Message(item) = item else { return Err(unreadable()) };
            let [node_name, previous, current] = [self.fields.node_name, self.fields.previous, self.fields.current]
                .map(|field| match &item[field] {
                    Value::Text(text) => text.as_str(),
                    _ => "",
                });
            let status = |name: &str| {
                status(name).ok_or_else(|| Unfit::Unreadable(format!("`{name}` is not the status of a node")))
            };
            let own_us = stamp_us(&item[self.fields.item_timestamp]).ok_or_else(unreadable)?;
            let node = self.node(node_name, self.fields.uid.map(|uid| &item[uid]))?;
            let (before, status) = (Some(status(previous)?), status(current)?);
            Ok((own_us, StatusChange { at_us, node, before, status }))
        };
        let changes = items.iter().map(change).collect::<Result<Vec<_>, _>>()?;
        // The first message of a goal also has what happened since the last message of the goal before: the end of that
        // goal, which is before the root begins anew. If time is not simulated, changes have times by the same clock.
        let late = changes.iter().rposition(|(_, change)| change.begins_run()).unwrap_or(0);
        let last_us = changes.last().map_or(at_us, |(own_us, _)| *own_us);
        let is_same_clock = (0..=SAME_CLOCK_US).contains(&at_us.saturating_sub(last_us));
        let timed =
            changes.into_iter().enumerate().map(|(index, (own_us, change))| match index < late && is_same_clock {
                true => StatusChange { at_us: own_us, ..change },
                false => change,
            });
        Ok(Tick { at_us, changes: timed.collect(), is_late: late > 0 && !is_same_clock })
    }

    /// The node of that name, and with that number if the messages have numbers.
    fn node(&self, name: &str, uid: Option<&Value>) -> Result<usize, Unfit> {
        match (&self.by_name, uid) {
            (Some(by_name), _) => {
                by_name.get(name).copied().ok_or_else(|| Unfit::Foreign(format!("the tree has no node `{name}`")))
            }
            (None, Some(Value::Int(uid))) => {
                let node = usize::try_from(uid - 1).ok().filter(|node| *node < self.names.len());
                match node.map(|node| (node, &self.names[node])) {
                    Some((node, known)) if known == name => Ok(node),
                    Some((_, known)) => {
                        Err(Unfit::Foreign(format!("node {uid} is `{name}`, and that of the tree is `{known}`")))
                    }
                    None => Err(Unfit::Foreign(format!("the tree has no node {uid}, `{name}`"))),
                }
            }
            _ => Err(Unfit::Unreadable("it is not a message of its type".to_owned())),
        }
    }
}

impl Nav2Log {
    pub(crate) fn topic(&self) -> &str {
        &self.topic.name
    }

    pub(crate) fn next_entry(&mut self) -> Result<Option<LogEntry>, LogError> {
        loop {
            if let Some(entry) = self.waiting.pop_front() {
                return Ok(Some(entry));
            }
            let received = self.messages.receive(&mut self.body);
            let lost = self.messages.lost().get(self.reported..).unwrap_or_default().join("; ");
            self.reported = self.messages.lost().len();
            let lost = (!lost.is_empty()).then_some(lost);
            match received {
                Received::Message(_) => {
                    lost.into_iter().for_each(|why| self.miss(why));
                    match self.topic.tick(&self.body) {
                        Ok(tick) => self.take(tick),
                        Err(Unfit::Foreign(_)) => {}
                        Err(Unfit::Unreadable(why)) => {
                            self.miss(format!("a message on {} cannot be read: {why}", self.topic.name));
                        }
                    }
                }
                Received::Lost { count, .. } => {
                    let count = count.map_or("messages".to_owned(), |count| format!("{count} messages"));
                    self.miss(format!("{count} on {} were lost when they were recorded", self.topic.name));
                }
                Received::Late { .. } | Received::Resumed { .. } | Received::Idle | Received::ClockAdvanced(_) => {}
                Received::Over => {
                    return match lost {
                        Some(what) => Err(LogError::CutOff { path: self.path.clone(), what }),
                        None => Ok(None),
                    };
                }
            }
        }
    }

    /// Something is missing after the message before.
    fn miss(&mut self, why: String) {
        self.waiting.push_back(LogEntry::Lost(LogGap { since_us: self.last_us, flaw: Flaw::Missing, why }));
    }

    fn take(&mut self, Tick { at_us, changes, is_late }: Tick) {
        if is_late {
            let why = "the end of a goal came only with the next goal, at an unknown time, since time is simulated";
            let since_us = self.last_us.or(Some(at_us));
            self.waiting.push_back(LogEntry::Lost(LogGap { since_us, flaw: Flaw::Late, why: why.to_owned() }));
        }
        self.waiting.extend(changes.into_iter().map(LogEntry::Changed));
        self.last_us = Some(at_us);
    }
}

fn stamp_us(stamp: &Value) -> Option<i64> {
    let Value::Message(fields) = stamp else { return None };
    let [Value::Int(seconds), Value::Int(ns)] = fields.as_slice() else { return None };
    i64::try_from(seconds * 1_000_000 + ns / 1000).ok()
}

/// The status with this name in BehaviorTree.CPP.
fn status(name: &str) -> Option<NodeStatus> {
    Some(match name {
        "IDLE" => NodeStatus::Idle,
        "RUNNING" => NodeStatus::Answered(Status::Running),
        "SUCCESS" => NodeStatus::Answered(Status::Success),
        "FAILURE" => NodeStatus::Answered(Status::Failure),
        "SKIPPED" => NodeStatus::Answered(Status::Skipped),
        _ => return None,
    })
}
