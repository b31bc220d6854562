//! Random trees, and leaves that answer by a script.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::rc::Rc;
use std::sync::Arc;

use bt::{Kind, Leaf, Leaves, Loader, Request, Status, Tree};
use proptest::prelude::*;

/// A tree as it is written down, before anything of the crate has seen it.
#[derive(Clone, Debug)]
pub(crate) struct Spec {
    pub(crate) kind: Kind,
    /// Of a leaf.
    pub(crate) id: Option<String>,
    pub(crate) children: Vec<Spec>,
}

impl Spec {
    pub(crate) fn tree(&self) -> Arc<Tree> {
        let mut body = String::new();
        self.write(&mut body);
        let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Random\">{body}</BehaviorTree></root>");
        Arc::new(Loader::default().load("random.xml", &text).expect("a random tree is a tree"))
    }

    fn write(&self, out: &mut String) {
        match &self.id {
            Some(id) => write!(out, "<{} ID=\"{id}\"/>", self.kind).unwrap(),
            None => {
                write!(out, "<{}>", self.kind).unwrap();
                self.children.iter().for_each(|child| child.write(out));
                write!(out, "</{}>", self.kind).unwrap();
            }
        }
    }
}

/// A random tree. Leaves share a few IDs: conditions are named C0, C1, … and actions A0, A1, …
pub(crate) fn spec() -> impl Strategy<Value = Spec> {
    let leaf = prop_oneof![
        6 => (0..6_u8).prop_map(|n| Spec { kind: Kind::Action, id: Some(format!("A{n}")), children: vec![] }),
        4 => (0..4_u8).prop_map(|n| Spec { kind: Kind::Condition, id: Some(format!("C{n}")), children: vec![] }),
        1 => prop::sample::select(vec![Kind::AlwaysSuccess, Kind::AlwaysFailure])
            .prop_map(|kind| Spec { kind, id: None, children: vec![] }),
    ];
    leaf.prop_recursive(5, 40, 5, |inner| {
        let controls = vec![
            Kind::Sequence,
            Kind::ReactiveSequence,
            Kind::SequenceWithMemory,
            Kind::Fallback,
            Kind::ReactiveFallback,
        ];
        let decorators = vec![Kind::Inverter, Kind::ForceSuccess, Kind::ForceFailure];
        prop_oneof![
            5 => (prop::sample::select(controls), prop::collection::vec(inner.clone(), 1..5))
                .prop_map(|(kind, children)| Spec { kind, id: None, children }),
            1 => (prop::sample::select(decorators), inner)
                .prop_map(|(kind, child)| Spec { kind, id: None, children: vec![child] }),
        ]
    })
}

/// The tree of a body, with subtrees `S0` and `S1` and leaves that are spelled out.
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
        let start = "k0 := 0; k1 := 1.5; k2 := '1'; k3 := 3";
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
const DEEDS: [&str; 9] = [
    "k0 := k0 + 1",
    "k0 = 0",
    "k1 *= 2",
    "k3 -= 1",
    "k2 := 'x'",
    "@k0 += 1",
    "k0 := (k0 > 3 ? 0 : k0 + 1)",
    "q := '1;2;3'",
    "k0 := k0 / 2",
];

/// Scripts among the attributes: mostly none.
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

/// Control nodes, with how many children they may have.
const CONTROLS: [(&str, usize, usize); 17] = [
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
    ("Switch2 variable=\"{k0}\" case_1=\"0\" case_2=\"{k3}\"", 3, 3),
    ("TryCatch", 2, 3),
    ("TryCatch catch_on_halt=\"true\"", 2, 3),
    ("TryCatch catch_on_halt=\"{k0}\"", 2, 3),
];

const DECORATORS: [&str; 23] = [
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
    "LoopString queue=\"{q}\" value=\"{l}\" if_empty=\"SKIPPED\"",
    "Precondition if=\"k0 &lt; 2\"",
    "Precondition if=\"k2 == 1\" else=\"SKIPPED\"",
    "Precondition if=\"k0 == 1\" else=\"RUNNING\"",
    "SkipUnlessUpdated entry=\"{k0}\"",
    "WaitValueUpdate entry=\"k0\"",
    "WaitValueUpdate entry=\"{l}\"",
    "Delay delay_msec=\"{k3}\"",
    "Timeout msec=\"100\"",
];

fn wild_body(depth: u32, subtrees: bool) -> impl Strategy<Value = String> {
    wild_leaf(subtrees).prop_recursive(depth, 40, 4, |inner| {
        let control = (prop::sample::select(CONTROLS.to_vec()), prop::collection::vec(inner.clone(), 4), 0..4_usize);
        let control = control
            .prop_map(|((tag, least, most), children, extra)| (tag, children[..(least + extra).min(most)].concat()));
        let decorator = (prop::sample::select(DECORATORS.to_vec()), inner);
        (prop_oneof![3 => control, 2 => decorator], hooks()).prop_map(|((tag, inside), hooks)| {
            let name = tag.split(' ').next().unwrap();
            format!("<{tag}{hooks}>{inside}</{name}>")
        })
    })
}

/// What the leaves of each ID answer, tick by tick, over and over.
pub(crate) type Script = BTreeMap<String, Vec<Status>>;

pub(crate) fn script() -> impl Strategy<Value = Script> {
    let answers = || {
        let status = prop::sample::select(vec![Status::Running, Status::Success, Status::Failure]);
        prop::collection::vec(status, 1..6)
    };
    (prop::collection::vec(answers(), 6), prop::collection::vec(answers(), 4)).prop_map(|(actions, conditions)| {
        let actions = actions.into_iter().enumerate().map(|(n, answers)| (format!("A{n}"), answers));
        let conditions = conditions.into_iter().enumerate().map(|(n, answers)| (format!("C{n}"), answers));
        actions.chain(conditions).collect()
    })
}

/// A leaf call: the leaf's ID, and what it was asked.
pub(crate) type Called = (String, Request);

/// Leaves that answer by a script and remember their calls.
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

/// Actors on the stage of one tree.
#[derive(Debug)]
pub(crate) struct Cast {
    pub(crate) tree: Arc<Tree>,
    pub(crate) actors: Rc<RefCell<Actors>>,
}

impl Cast {
    pub(crate) fn new(tree: &Arc<Tree>, script: &Script) -> Self {
        Self { tree: tree.clone(), actors: Rc::new(RefCell::new(Actors::new(script))) }
    }

    /// Other actors, who have got as far as these.
    pub(crate) fn understudy(&self) -> Self {
        Self { tree: self.tree.clone(), actors: Rc::new(RefCell::new(self.actors.borrow().clone())) }
    }

    pub(crate) fn calls(&self) -> Vec<Called> {
        self.actors.borrow().calls.clone()
    }
}

impl Leaves for Cast {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        self.actors.borrow_mut().tick(leaf.node().type_id())
    }

    fn halt(&mut self, leaf: Leaf<'_>) {
        self.actors.borrow_mut().halt(leaf.node().type_id());
    }
}
