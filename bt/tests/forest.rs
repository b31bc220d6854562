//! Random trees, and leaves that answer by a script.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::rc::Rc;
use std::sync::Arc;

use bt::{Kind, Leaves, Loader, NodeId, Request, Status, Tree};
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
    fn tick(&mut self, leaf: NodeId) -> Status {
        self.actors.borrow_mut().tick(self.tree.node(leaf).type_id())
    }

    fn halt(&mut self, leaf: NodeId) {
        self.actors.borrow_mut().halt(self.tree.node(leaf).type_id());
    }
}
