//! Ticking a tree without a robot: its leaves answer from a script, and every node's status is recorded.

use std::sync::Arc;
use std::time::Duration;

use crate::{Call, Execution, Fault, Leaf, Leaves, NodeId, NodeState, Outcome, Request, Status, Tree, Value, one_line};

/// A leaf's behavior at one of its ticks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cue {
    /// Its answer.
    pub status: Status,
    /// The ports that it writes before it answers.
    pub outputs: Vec<(String, Value)>,
}

impl From<Status> for Cue {
    fn from(status: Status) -> Self {
        Self { status, outputs: Vec::new() }
    }
}

/// A leaf's behavior, tick by tick. After the last cue, it repeats either that cue or all cues from the first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeafBehavior {
    cues: Vec<Cue>,
    repeats: bool,
}

impl LeafBehavior {
    /// A behavior whose last cue is used for all further ticks.
    ///
    /// # Panics
    /// If there is no cue.
    #[must_use]
    pub fn new(cues: impl IntoIterator<Item = Cue>) -> Self {
        let cues: Vec<Cue> = cues.into_iter().collect();
        assert!(!cues.is_empty(), "a behavior has at least one cue");
        Self { cues, repeats: false }
    }

    /// A behavior that starts over after the last cue.
    #[must_use]
    pub fn repeating(self) -> Self {
        Self { repeats: true, ..self }
    }

    /// The number of cues.
    #[must_use]
    pub fn length(&self) -> usize {
        self.cues.len()
    }

    fn cue(&self, tick: usize) -> &Cue {
        let last = self.cues.len() - 1;
        &self.cues[if self.repeats { tick % self.cues.len() } else { tick.min(last) }]
    }
}

/// A tree whose leaves follow a script.
///
/// ```
/// use std::sync::Arc;
/// use std::time::Duration;
/// use bt::{LeafBehavior, Rehearsal, Status, Tree, table};
///
/// let tree = Arc::new(Tree::from_xml("door.xml", r#"<root BTCPP_format="4"> <BehaviorTree ID="Door">
///     <Fallback> <Condition ID="IsOpen"/> <Action ID="Push"/> </Fallback>
/// </BehaviorTree> </root>"#)?);
/// let behaviors = tree.leaves().map(|leaf| match leaf.type_id() {
///     "IsOpen" => LeafBehavior::new([Status::Failure.into()]),
///     _ => LeafBehavior::new([Status::Running.into(), Status::Success.into()]),
/// });
/// let mut rehearsal = Rehearsal::new(tree.clone(), behaviors);
/// let moments = [rehearsal.tick(Duration::ZERO), rehearsal.tick(Duration::from_secs(1))];
/// assert_eq!(moments[1].status, Some(Status::Success));
/// let lines = ["           1 2", "?*         R S", "  IsOpen   F ·", "  Push     R S"];
/// assert_eq!(table(&tree, &moments).lines().collect::<Vec<_>>(), lines);
/// # Ok::<(), bt::TreeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rehearsal {
    execution: Execution,
    cast: Cast,
    ticks: u64,
}

#[derive(Clone, Debug)]
struct Cast {
    /// By leaf, in document order.
    behaviors: Vec<LeafBehavior>,
    /// The number of times that each leaf has been ticked.
    ticked: Vec<usize>,
    /// By node, the index of its behavior.
    places: Vec<usize>,
    calls: Vec<Call>,
    inputs: Vec<Inputs>,
    faults: Vec<Fault>,
}

/// The values that a leaf read, by the names of its ports.
pub type Inputs = Vec<(String, Option<Value>)>;

/// A tick of a rehearsal, or a halt of the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RehearsedTick {
    /// The number of the tick, from 1; for a halt, that of the previous tick.
    pub tick: u64,
    /// Its time.
    pub time: Duration,
    /// The tree's answer; `None` if it was halted.
    pub status: Option<Status>,
    /// The states of the nodes afterwards, in document order.
    pub nodes: Vec<NodeState>,
    /// The leaf calls, in order.
    pub calls: Vec<Call>,
    /// The values that the leaf of each call read from its ports: `None` for a port without a value, and empty for a
    /// halt.
    pub inputs: Vec<Inputs>,
    /// The faults.
    pub faults: Vec<Fault>,
}

impl Rehearsal {
    /// A rehearsal of this tree, with a behavior for each of its [leaves](Tree::leaves).
    ///
    /// # Panics
    /// If there are fewer behaviors than leaves.
    #[must_use]
    pub fn new(tree: Arc<Tree>, behaviors: impl IntoIterator<Item = LeafBehavior>) -> Self {
        let behaviors: Vec<LeafBehavior> = behaviors.into_iter().take(tree.leaves().count()).collect();
        assert_eq!(behaviors.len(), tree.leaves().count(), "every leaf has a behavior");
        let mut places = vec![0; tree.nodes().len()];
        for (place, leaf) in tree.leaves().enumerate() {
            places[leaf.id().index()] = place;
        }
        let ticked = vec![0; behaviors.len()];
        let cast = Cast { behaviors, ticked, places, calls: Vec::new(), inputs: Vec::new(), faults: Vec::new() };
        Self { execution: Execution::new(tree), cast, ticks: 0 }
    }

    /// The running tree.
    #[must_use]
    pub fn execution(&self) -> &Execution {
        &self.execution
    }

    /// The running tree, for writing to its blackboard.
    pub fn execution_mut(&mut self) -> &mut Execution {
        &mut self.execution
    }

    /// Ticks the tree.
    pub fn tick(&mut self, now: Duration) -> RehearsedTick {
        self.ticks += 1;
        let status = self.execution.tick(now, &mut self.cast);
        self.moment(now, Some(status), 0)
    }

    /// Halts the tree.
    pub fn halt(&mut self, now: Duration) -> RehearsedTick {
        let (old_faults, before) = (self.execution.faults().len(), self.execution.states());
        self.execution.halt(now, &mut self.cast);
        let mut moment = self.moment(now, None, old_faults);
        for (node, old) in moment.nodes.iter_mut().zip(before) {
            // Its answer in the previous tick is not part of the halt.
            node.outcome = node.outcome.filter(|outcome| Some(*outcome) != old.outcome);
        }
        moment
    }

    fn moment(&mut self, time: Duration, status: Option<Status>, old_faults: usize) -> RehearsedTick {
        let (calls, inputs) = (std::mem::take(&mut self.cast.calls), std::mem::take(&mut self.cast.inputs));
        let mut faults = self.execution.faults()[old_faults..].to_vec();
        faults.append(&mut self.cast.faults);
        RehearsedTick { tick: self.ticks, time, status, nodes: self.execution.states(), calls, inputs, faults }
    }
}

impl Leaves for Cast {
    fn tick(&mut self, mut leaf: Leaf<'_>) -> Status {
        self.calls.push(Call { leaf: leaf.id(), request: Request::Tick });
        self.inputs.push(leaf.inputs().map(|(port, value)| (port.to_owned(), value.ok())).collect());
        let place = self.places[leaf.id().index()];
        let cue = self.behaviors[place].cue(self.ticked[place]);
        self.ticked[place] += 1;
        for (port, value) in &cue.outputs {
            if let Err(error) = leaf.output(port, value.clone()) {
                self.faults.push(Fault { node: leaf.id(), message: error.to_string() });
            }
        }
        cue.status
    }

    fn halt(&mut self, leaf: Leaf<'_>) {
        self.calls.push(Call { leaf: leaf.id(), request: Request::Halt });
        self.inputs.push(Inputs::new());
    }
}

/// The maximum number of ticks side by side: two or three characters each leave room for the nodes' names.
const COLUMNS: usize = 25;

/// The statuses of all nodes as a table: one line per node, one column per tick; long names are shortened. `S`, `F`,
/// `R` and `K` are success, failure, running and skipped, `H` is halted, and `·` is a node that the tick did not reach.
/// Faults follow.
#[must_use]
pub fn table(tree: &Tree, moments: &[RehearsedTick]) -> String {
    let labels: Vec<String> = tree.nodes().iter().map(|node| shortened(node.outline())).collect();
    let label_width = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0).max(8) + 2;
    let mut text = String::new();
    for (number, block) in moments.chunks(COLUMNS).enumerate() {
        // Each block is as narrow as the names of its own ticks allow.
        text.push_str(if number > 0 { "\n" } else { "" });
        let names: Vec<String> = block.iter().map(column_name).collect();
        let width = names.iter().map(String::len).max().unwrap_or(1);
        let mut head = format!("{:label_width$}", "");
        names.iter().for_each(|name| head.push_str(&format!(" {name:>width$}")));
        push_line(&mut text, &head);
        for (node, label) in labels.iter().enumerate() {
            let mut line = format!("{label:label_width$}");
            for moment in block {
                line.push_str(&format!(" {:>width$}", letter(moment.nodes[node].outcome)));
            }
            push_line(&mut text, &line);
        }
    }
    for moment in moments {
        for Fault { node, message } in &moment.faults {
            let line = format!("tick {}: {} (node {node}): {message}", moment.tick, tree.node(*node).process());
            push_line(&mut text, &one_line(&line));
        }
    }
    text
}

/// The maximum width of a node's name beside its statuses.
const LABEL_WIDTH: usize = 100;

fn shortened(label: String) -> String {
    match label.char_indices().nth(LABEL_WIDTH) {
        Some((end, _)) => format!("{}…", &label[..end]),
        None => label,
    }
}

fn push_line(text: &mut String, line: &str) {
    *text += &format!("{}\n", line.trim_end());
}

fn column_name(moment: &RehearsedTick) -> String {
    if moment.status.is_some() { moment.tick.to_string() } else { "halt".to_owned() }
}

fn letter(outcome: Option<Outcome>) -> &'static str {
    match outcome {
        Some(Outcome::Answered(Status::Success)) => "S",
        Some(Outcome::Answered(Status::Failure)) => "F",
        Some(Outcome::Answered(Status::Running)) => "R",
        Some(Outcome::Answered(Status::Skipped)) => "K",
        Some(Outcome::Halted) => "H",
        None => "·",
    }
}

impl Tree {
    /// The tree in Graphviz's language, each node with its number and, if `states` are given, colored by its state.
    ///
    /// ```
    /// let tree = bt::Tree::from_xml("wave.xml", r#"<root BTCPP_format="4"> <BehaviorTree ID="Greet">
    ///     <Inverter> <Action ID="Wave"/> </Inverter>
    /// </BehaviorTree> </root>"#)?;
    /// assert!(tree.to_dot(None).contains("n0 -> n1;"));
    /// # Ok::<(), bt::TreeError>(())
    /// ```
    #[must_use]
    pub fn to_dot(&self, states: Option<&[NodeState]>) -> String {
        let quoted = |label: &str| one_line(label).replace('\\', "\\\\").replace('"', "\\\"");
        let mut dot =
            format!("digraph \"{}\" {{\n  ordering=out;\n  node [fontname=\"sans-serif\"];\n", quoted(self.name()));
        for node in self.nodes() {
            let id: NodeId = node.id();
            let label = match (node.kind().symbol(), node.name()) {
                (Some(symbol), Some(name)) => format!("{symbol} {name}"),
                (Some(symbol), None) if node.kind() == crate::Kind::SubTree => format!("{symbol} {}", node.type_id()),
                (Some(symbol), None) => symbol.to_owned(),
                (None, _) => node.process().to_owned(),
            };
            let shape = if node.kind().is_leaf() { "ellipse" } else { "box" };
            let outcome = states.and_then(|states| states.get(id.index())?.outcome);
            let fill = color(outcome).map_or(String::new(), |fill| format!(" style=filled fillcolor=\"{fill}\""));
            dot += &format!("  n{id} [label=\"{}\" shape={shape}{fill}];\n", quoted(&label));
            if let Some(parent) = node.parent() {
                dot += &format!("  n{parent} -> n{id};\n");
            }
        }
        dot.push_str("}\n");
        dot
    }
}

/// A color on which dark letters are legible.
fn color(outcome: Option<Outcome>) -> Option<&'static str> {
    Some(match outcome? {
        Outcome::Answered(Status::Success) => "#b7e1b0",
        Outcome::Answered(Status::Failure) => "#f4b9b3",
        Outcome::Answered(Status::Running) => "#bcd7f5",
        Outcome::Answered(Status::Skipped) => "#e4e4e4",
        Outcome::Halted => "#f3ddb0",
    })
}
