//! Random trees, and leaves that answer from a script.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::rc::Rc;
use std::sync::Arc;

use bt::{Category, Kind, Leaf, Leaves, Loader, Node, Request, Status, Tree};
use proptest::prelude::*;

/// A tree as data, independent of the crate.
#[derive(Clone, Debug)]
pub(crate) struct Spec {
    pub(crate) kind: Kind,
    /// Of a leaf.
    pub(crate) id: Option<String>,
    /// The values of its ports, if its kind has any.
    pub(crate) numbers: [i64; 2],
    pub(crate) guard: Option<(Guard, i64)>,
    pub(crate) children: Vec<Spec>,
}

/// The effect of a guard: what happens if the entry [`KEY`] has a certain value when a node is ticked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Guard {
    FailureIf,
    SuccessIf,
    SkipIf,
    While,
}

/// The entry that scripts write, guards compare and switches use: a number as a string.
pub(crate) const KEY: &str = "k";

impl Spec {
    fn new(kind: Kind, mut children: Vec<Spec>) -> Self {
        if kind == Kind::ReactiveSequence {
            // It may have only one such child.
            let others = children.iter_mut().filter(|child| child.kind == Kind::AsyncSequence).skip(1);
            others.for_each(|child| child.kind = Kind::Sequence);
        }
        Self { kind, id: None, numbers: [0; 2], guard: None, children }
    }

    fn leaf(kind: Kind, id: String) -> Self {
        Self { id: Some(id), ..Self::new(kind, Vec::new()) }
    }

    pub(crate) fn tree(&self) -> Arc<Tree> {
        let mut body = String::new();
        self.write(&mut body);
        let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Random\">{body}</BehaviorTree></root>");
        Arc::new(Loader::default().load("random.xml", &text).expect("a random tree is valid"))
    }

    fn write(&self, out: &mut String) {
        write!(out, "<{}", self.kind).unwrap();
        self.write_attributes(out);
        if self.children.is_empty() {
            out.push_str("/>");
            return;
        }
        out.push('>');
        self.children.iter().for_each(|child| child.write(out));
        write!(out, "</{}>", self.kind).unwrap();
    }

    fn write_attributes(&self, out: &mut String) {
        let [first, second] = self.numbers;
        match self.kind {
            Kind::Action | Kind::Condition => write!(out, " ID=\"{}\"", self.id.as_ref().unwrap()),
            Kind::Parallel => write!(out, " success_count=\"{first}\" failure_count=\"{second}\""),
            Kind::ParallelAll => write!(out, " max_failures=\"{first}\""),
            Kind::Switch(_) => write!(out, " variable=\"{{{KEY}}}\" case_1=\"0\" case_2=\"1\""),
            Kind::RecoveryNode => write!(out, " number_of_retries=\"{}\"", first.abs()),
            Kind::RoundRobin => write!(out, " wrap_around=\"{}\"", first > 0),
            Kind::PauseResumeController => write!(out, " pause_service_name=\"/{KEY}\" resume_service_name=\"{KEY}\""),
            Kind::TryCatch => write!(out, " catch_on_halt=\"{}\"", first > 0),
            Kind::Repeat => write!(out, " num_cycles=\"{}\"", first.abs()),
            Kind::RetryUntilSuccessful => write!(out, " num_attempts=\"{}\"", first.abs()),
            Kind::RunOnce => write!(out, " then_skip=\"{}\"", first > 0),
            Kind::Script => write!(out, " code=\"{KEY} := '{first}'\""),
            _ => Ok(()),
        }
        .unwrap();
        if let Some((guard, number)) = self.guard {
            let attribute = match guard {
                Guard::FailureIf => "_failureIf",
                Guard::SuccessIf => "_successIf",
                Guard::SkipIf => "_skipIf",
                Guard::While => "_while",
            };
            write!(out, " {attribute}=\"{KEY} == '{number}'\"").unwrap();
        }
    }
}

/// A random tree of all nodes that do not depend on time. Leaves share a few IDs: conditions are named C0, C1, … and
/// actions A0, A1, …
pub(crate) fn spec() -> impl Strategy<Value = Spec> {
    let leaf = prop_oneof![
        6 => (0..6_u8).prop_map(|n| Spec::leaf(Kind::Action, format!("A{n}"))),
        4 => (0..4_u8).prop_map(|n| Spec::leaf(Kind::Condition, format!("C{n}"))),
        1 => prop::sample::select(vec![Kind::AlwaysSuccess, Kind::AlwaysFailure, Kind::Script])
            .prop_map(|kind| Spec::new(kind, Vec::new())),
    ];
    let leaf = furnished(leaf.boxed());
    leaf.prop_recursive(5, 40, 5, |inner| {
        let control =
            (prop::sample::select(CONTROL_KINDS.to_vec()), prop::collection::vec(inner.clone(), 4), 0..4_usize)
                .prop_map(|((kind, least, most), mut children, extra)| {
                    children.truncate((least + extra).min(most));
                    Spec::new(kind, children)
                });
        let decorator = (prop::sample::select(DECORATOR_KINDS.to_vec()), inner)
            .prop_map(|(kind, child)| Spec::new(kind, vec![child]));
        furnished(prop_oneof![5 => control, 2 => decorator].boxed())
    })
}

/// Has numbers in its ports, and sometimes a guard.
fn furnished(spec: BoxedStrategy<Spec>) -> BoxedStrategy<Spec> {
    let guards = vec![Guard::FailureIf, Guard::SuccessIf, Guard::SkipIf, Guard::While];
    let guard = prop::option::weighted(0.1, (prop::sample::select(guards), 0..3_i64));
    let furnish = |(spec, numbers, guard): (Spec, [i64; 2], _)| {
        // A parallel node cannot count more children than it has.
        let most = if spec.kind.category() == Category::Control { spec.children.len() } else { 3 };
        let numbers = numbers.map(|number| number.min(most as i64));
        Spec { numbers, guard, ..spec }
    };
    (spec, [-2..4_i64, -2..4_i64], guard).prop_map(furnish).boxed()
}

/// Control nodes, with the allowed number of children.
const CONTROL_KINDS: [(Kind, usize, usize); 18] = [
    (Kind::Sequence, 1, 4),
    (Kind::ReactiveSequence, 1, 4),
    (Kind::SequenceWithMemory, 1, 4),
    (Kind::AsyncSequence, 1, 4),
    (Kind::Fallback, 1, 4),
    (Kind::ReactiveFallback, 1, 4),
    (Kind::AsyncFallback, 1, 4),
    (Kind::Parallel, 1, 4),
    (Kind::ParallelAll, 1, 4),
    (Kind::IfThenElse, 2, 3),
    (Kind::WhileDoElse, 2, 3),
    (Kind::Switch(2), 3, 3),
    (Kind::TryCatch, 2, 4),
    (Kind::PipelineSequence, 1, 4),
    (Kind::NonblockingSequence, 1, 4),
    (Kind::RecoveryNode, 2, 2),
    (Kind::RoundRobin, 1, 4),
    (Kind::PauseResumeController, 1, 4),
];

const DECORATOR_KINDS: [Kind; 8] = [
    Kind::Inverter,
    Kind::ForceSuccess,
    Kind::ForceFailure,
    Kind::Repeat,
    Kind::RetryUntilSuccessful,
    Kind::KeepRunningUntilFailure,
    Kind::RunOnce,
    Kind::SingleTrigger,
];

/// The tree of a body, with subtrees `S0` and `S1` and leaves in explicit form.
pub(crate) fn tree_of(body: &str, subtrees: &[String]) -> Arc<Tree> {
    let mut text =
        format!("<root main_tree_to_execute=\"T\" BTCPP_format=\"4\"><BehaviorTree ID=\"T\">{body}</BehaviorTree>");
    for (number, body) in subtrees.iter().enumerate() {
        write!(text, "<BehaviorTree ID=\"S{number}\">{body}</BehaviorTree>").unwrap();
    }
    text.push_str("</root>");
    Arc::new(Loader::default().load("random.xml", &text).unwrap_or_else(|error| panic!("{error:?}\n{text}")))
}

/// A random tree of all kinds of nodes, with scripts, a blackboard, times and subtrees.
pub(crate) fn wild_tree() -> impl Strategy<Value = Arc<Tree>> {
    let subtrees = prop::collection::vec(wild_body(2, false), 2);
    (wild_body(4, true), subtrees).prop_map(|(body, subtrees)| {
        let start = "k0 := 0; k1 := 1.5; k2 := '1'; k3 := 3; k4 := 1; k5 := 3; i := 0; n := 2; h := 4";
        let body = format!("<Sequence><RunOnce><Script code=\"{start}\"/></RunOnce>{body}</Sequence>");
        tree_of(&body, &subtrees)
    })
}

const CONDITIONS: [&str; 8] = [
    "k0 == 1",
    "k0 &lt; 2",
    "k2 == 1",
    "k1 > 0.5 &amp;&amp; k0 &lt; 3",
    "k3 != 3",
    "missing == 1",
    "true",
    "@k0 &lt; 2",
];
const DEEDS: [&str; 16] = [
    "k0 := k0 + 1",
    "k0 = 0",
    "k1 *= 2",
    "k3 -= 1",
    "k2 := 'x'",
    "@k0 += 1",
    "k0 := (k0 > 3 ? 0 : k0 + 1)",
    "q := '1;2;3'",
    "k0 := k0 / 2",
    "k4 := 1 - k4",
    "@robot_pose := '1;0'",
    "@robot_pose := '0;3'",
    "@robot_speed := 1.5",
    "i := 1",
    "p := '0;0;1;1'",
    "p := '0;0;0;1;1;1'",
];

/// Scripts in attributes: usually none.
fn hooks() -> impl Strategy<Value = String> {
    let before = (
        prop::sample::select(vec!["_failureIf", "_successIf", "_skipIf", "_while"]),
        prop::sample::select(CONDITIONS.to_vec()),
    );
    let after = (
        prop::sample::select(vec!["_onSuccess", "_onFailure", "_onHalted", "_post"]),
        prop::sample::select(DEEDS.to_vec()),
    );
    let attribute = |(name, script): (&str, &str)| format!(" {name}=\"{script}\"");
    prop_oneof![
        12 => Just(String::new()),
        1 => before.prop_map(attribute),
        1 => after.prop_map(attribute),
    ]
}

/// A node without children, which may be a subtree.
fn wild_leaf(subtrees: bool) -> impl Strategy<Value = String> {
    let condition = CONDITIONS.map(|script| format!("ScriptCondition code=\"{script}\""));
    let deed = DEEDS.map(|script| format!("Script code=\"{script}\""));
    let others = [
        "AlwaysSuccess",
        "AlwaysFailure",
        "Sleep msec=\"0\"",
        "Sleep msec=\"250\"",
        "SetBlackboard value=\"{k0}\" output_key=\"m0\"",
        "SetBlackboard value=\"7\" output_key=\"m1\"",
        "UnsetBlackboard key=\"k2\"",
        "WasEntryUpdated entry=\"{k0}\"",
    ];
    let others: Vec<String> = others.map(str::to_owned).into_iter().chain(condition).chain(deed).collect();
    let used = if subtrees {
        vec![
            "SubTree ID=\"S0\" k0=\"{k1}\"",
            "SubTree ID=\"S1\" _autoremap=\"true\" k3=\"5\"",
            "SubTree ID=\"S1\" k2=\"{@k2}\"",
        ]
    } else {
        vec!["AlwaysSuccess"]
    };
    let tag = prop_oneof![
        8 => (0..6_u8).prop_map(|n| format!("Action ID=\"A{n}\"")),
        4 => (0..4_u8).prop_map(|n| format!("Condition ID=\"C{n}\"")),
        5 => prop::sample::select(others),
        1 => prop::sample::select(used).prop_map(str::to_owned),
    ];
    (tag, hooks()).prop_map(|(tag, hooks)| format!("<{tag}{hooks}/>"))
}

/// Control nodes, with the allowed number of children.
const CONTROLS: [(&str, usize, usize); 25] = [
    ("Sequence", 1, 4),
    ("ReactiveSequence", 1, 4),
    ("SequenceWithMemory", 1, 4),
    ("AsyncSequence", 1, 4),
    ("Fallback", 1, 4),
    ("ReactiveFallback", 1, 4),
    ("AsyncFallback", 1, 4),
    ("Parallel", 1, 4),
    ("Parallel success_count=\"1\" failure_count=\"-1\"", 1, 4),
    ("Parallel success_count=\"{k0}\" failure_count=\"2\"", 2, 4),
    ("ParallelAll max_failures=\"-1\"", 1, 4),
    ("IfThenElse", 2, 3),
    ("WhileDoElse", 2, 3),
    ("Switch2 variable=\"{k2}\" case_1=\"1\" case_2=\"{k6}\"", 3, 3),
    ("TryCatch", 2, 3),
    ("TryCatch catch_on_halt=\"true\"", 2, 3),
    ("TryCatch catch_on_halt=\"{k4}\"", 2, 3),
    ("PipelineSequence", 1, 4),
    ("NonblockingSequence", 1, 4),
    ("PersistentSequence current_child_idx=\"{i}\"", 1, 4),
    ("RecoveryNode", 2, 2),
    ("RecoveryNode number_of_retries=\"{n}\"", 2, 2),
    ("RoundRobin", 1, 4),
    ("RoundRobin wrap_around=\"true\"", 1, 4),
    ("PauseResumeController pause_service_name=\"/k0\" resume_service_name=\"k3\"", 1, 4),
];

const DECORATORS: [&str; 31] = [
    "Inverter",
    "ForceSuccess",
    "ForceFailure",
    "Repeat num_cycles=\"3\"",
    "Repeat num_cycles=\"{k3}\"",
    "RetryUntilSuccessful num_attempts=\"2\"",
    "RetryUntilSuccessful num_attempts=\"{k3}\"",
    "KeepRunningUntilFailure",
    "Delay delay_msec=\"250\"",
    "Timeout msec=\"250\"",
    "Timeout msec=\"0\"",
    "RunOnce",
    "RunOnce then_skip=\"false\"",
    "LoopInt queue=\"1;2\" value=\"{l}\"",
    "LoopString queue=\"{q}\" value=\"{k6}\" if_empty=\"SKIPPED\"",
    "Precondition if=\"k0 &lt; 2\"",
    "Precondition if=\"k2 == 1\" else=\"SKIPPED\"",
    "Precondition if=\"k0 == 1\" else=\"RUNNING\"",
    "SkipUnlessUpdated entry=\"{k0}\"",
    "WaitValueUpdate entry=\"k0\"",
    "WaitValueUpdate entry=\"{l}\"",
    "Delay delay_msec=\"{k5}\"",
    "Timeout msec=\"100\"",
    "RateController hz=\"4\"",
    "RateController hz=\"{h}\"",
    "DistanceController distance=\"1.5\"",
    "SpeedController min_rate=\"1\" max_rate=\"4\" goal=\"{k3}\"",
    "GoalUpdater input_goal=\"{k0}\" output_goal=\"{k2}\"",
    "GoalUpdatedController goal=\"{k0}\"",
    "PathLongerOnApproach path=\"{p}\" length_factor=\"0.5\"",
    "SingleTrigger",
];

fn wild_body(depth: u32, subtrees: bool) -> impl Strategy<Value = String> {
    wild_leaf(subtrees).prop_recursive(depth, 40, 4, |inner| {
        let control = (prop::sample::select(CONTROLS.to_vec()), prop::collection::vec(inner.clone(), 4), 0..4_usize);
        let control = control.prop_map(|((tag, least, most), children, extra)| {
            let children = &children[..(least + extra).min(most)];
            (tag, if tag == "ReactiveSequence" { with_one_async(children) } else { children.concat() })
        });
        let decorator = (prop::sample::select(DECORATORS.to_vec()), inner);
        (prop_oneof![3 => control, 2 => decorator], hooks()).prop_map(|((tag, inside), hooks)| {
            let name = tag.split(' ').next().unwrap();
            format!("<{tag}{hooks}>{inside}</{name}>")
        })
    })
}

/// The children of a reactive sequence, which may have only one <AsyncSequence>.
fn with_one_async(children: &[String]) -> String {
    let mut found = false;
    let other = |child: &String| match child.strip_prefix("<AsyncSequence") {
        Some(rest) if std::mem::replace(&mut found, true) => {
            format!("<Sequence{}</Sequence>", rest.strip_suffix("</AsyncSequence>").unwrap())
        }
        _ => child.clone(),
    };
    children.iter().map(other).collect()
}

/// The answers of the leaves with each ID, tick by tick, repeated.
pub(crate) type Script = BTreeMap<String, Vec<Status>>;

pub(crate) fn script() -> impl Strategy<Value = Script> {
    script_of(vec![Status::Running, Status::Success, Status::Failure])
}

/// Leaves outside a channel system may be skipped as well.
pub(crate) fn script_with_skips() -> impl Strategy<Value = Script> {
    use Status::{Failure, Running, Skipped, Success};
    script_of(vec![Running, Running, Success, Success, Failure, Failure, Skipped])
}

fn script_of(statuses: Vec<Status>) -> impl Strategy<Value = Script> {
    let answers = || prop::collection::vec(prop::sample::select(statuses.clone()), 1..6);
    (prop::collection::vec(answers(), 6), prop::collection::vec(answers(), 4)).prop_map(|(actions, conditions)| {
        let actions = actions.into_iter().enumerate().map(|(n, answers)| (format!("A{n}"), answers));
        let conditions = conditions.into_iter().enumerate().map(|(n, answers)| (format!("C{n}"), answers));
        actions.chain(conditions).collect()
    })
}

/// The same answers, by the names of the leaves' processes.
pub(crate) fn by_process(tree: &Tree, script: &Script) -> Script {
    tree.leaves().map(|leaf| (leaf.process().to_owned(), script[leaf.type_id()].clone())).collect()
}

/// A leaf call: the leaf, and the request.
pub(crate) type Called = (String, Request);

/// Leaves that answer from a script and remember their calls.
#[derive(Clone, Debug)]
pub(crate) struct Actors {
    script: Script,
    ticks: BTreeMap<String, usize>,
    pub(crate) calls: Vec<Called>,
}

impl Actors {
    pub(crate) fn new(script: &Script) -> Self {
        Self { script: script.clone(), ticks: BTreeMap::new(), calls: Vec::new() }
    }

    pub(crate) fn tick(&mut self, id: &str) -> Status {
        self.calls.push((id.to_owned(), Request::Tick));
        let answers = &self.script[id];
        let tick = self.ticks.entry(id.to_owned()).or_default();
        let status = answers[*tick % answers.len()];
        *tick += 1;
        status
    }

    pub(crate) fn halt(&mut self, id: &str) {
        self.calls.push((id.to_owned(), Request::Halt));
    }
}

/// Actors for one tree.
#[derive(Debug)]
pub(crate) struct Cast {
    pub(crate) tree: Arc<Tree>,
    pub(crate) actors: Rc<RefCell<Actors>>,
    /// The actor of a leaf.
    actor: fn(&Node) -> &str,
}

impl Cast {
    pub(crate) fn new(tree: &Arc<Tree>, script: &Script) -> Self {
        Self { tree: tree.clone(), actors: Rc::new(RefCell::new(Actors::new(script))), actor: Node::type_id }
    }

    /// An actor for every leaf, as in a channel system.
    pub(crate) fn of_processes(tree: &Arc<Tree>, script: &Script) -> Self {
        Self { actor: Node::process, ..Self::new(tree, &by_process(tree, script)) }
    }

    /// Other actors, with the same progress as these.
    pub(crate) fn understudy(&self) -> Self {
        Self { actors: Rc::new(RefCell::new(self.actors.borrow().clone())), tree: self.tree.clone(), ..*self }
    }

    pub(crate) fn calls(&self) -> Vec<Called> {
        self.actors.borrow().calls.clone()
    }
}

impl Leaves for Cast {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        self.actors.borrow_mut().tick((self.actor)(leaf.node()))
    }

    fn halt(&mut self, leaf: Leaf<'_>) {
        self.actors.borrow_mut().halt((self.actor)(leaf.node()));
    }
}
