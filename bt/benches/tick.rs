//! The speed of ticking and of loading.

use std::sync::Arc;
use std::time::Duration;

use bt::{Execution, Leaf, Leaves, RECHARGE, Status, Tree};
use divan::{AllocProfiler, Bencher, black_box};

/// Counts allocations as well: a tick makes none.
#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

/// No node of these trees depends on time.
const NOW: Duration = Duration::ZERO;

fn main() {
    divan::main();
}

/// Leaves that always give the same answer, indexed by node number.
struct Trivial(Vec<Status>);

impl Leaves for Trivial {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        self.0[leaf.id().index()]
    }

    fn halt(&mut self, _: Leaf<'_>) {}
}

fn trivial(tree: &Tree, answer: impl Fn(&str) -> Status) -> Trivial {
    Trivial(tree.nodes().iter().map(|node| answer(node.type_id())).collect())
}

/// The paper's tree on its way to the destination: four leaves are ticked, nothing is halted.
#[divan::bench]
fn recharge_driving(bencher: Bencher) {
    let tree = Arc::new(Tree::from_xml("recharge.xml", RECHARGE).expect("the shipped tree is valid"));
    let mut leaves = trivial(&tree, |id| match id {
        "BatteryLevel" | "BatteryNotCharging" => Status::Success,
        "GoToDestination" | "GotoRechargingStation" | "WaitForUser" => Status::Running,
        _ => Status::Failure,
    });
    let mut execution = Execution::new(tree);
    bencher.bench_local(|| execution.tick(NOW, black_box(&mut leaves)));
}

/// The paper's tree with a battery that is low at every second tick: an action is halted at each tick.
#[divan::bench]
fn recharge_changing_its_mind(bencher: Bencher) {
    let tree = Arc::new(Tree::from_xml("recharge.xml", RECHARGE).expect("the shipped tree is valid"));
    let level = tree.leaves().next().expect("the first leaf is BatteryLevel").id().index();
    let mut leaves = trivial(&tree, |id| match id {
        "BatteryLevel" | "BatteryNotCharging" => Status::Success,
        "GoToDestination" | "GotoRechargingStation" | "WaitForUser" => Status::Running,
        _ => Status::Failure,
    });
    let mut execution = Execution::new(tree);
    bencher.bench_local(|| {
        leaves.0[level] = if leaves.0[level] == Status::Success { Status::Failure } else { Status::Success };
        execution.tick(NOW, black_box(&mut leaves))
    });
}

fn wide(count: usize) -> String {
    let leaves: String = (0..count).map(|n| format!("<Condition ID=\"c{n}\"/>")).collect();
    format!("<ReactiveSequence>{leaves}</ReactiveSequence>")
}

/// 100 nested sequences of 10 leaves each.
fn deep() -> String {
    (0..100).fold(String::new(), |inner, n| {
        let leaves: String = (0..10).map(|leaf| format!("<Condition ID=\"c{n}_{leaf}\"/>")).collect();
        format!("<ReactiveSequence>{leaves}{inner}</ReactiveSequence>")
    })
}

/// Three levels of 10.
fn balanced() -> String {
    let hundred = |n: usize| (0..10).map(|m| wide(10).replace("\"c", &format!("\"c{n}_{m}_"))).collect::<String>();
    let thousand: String = (0..10).map(|n| format!("<ReactiveSequence>{}</ReactiveSequence>", hundred(n))).collect();
    format!("<ReactiveSequence>{thousand}</ReactiveSequence>")
}

/// A thousand leaves that are all ticked and all succeed.
#[divan::bench(args = ["wide", "deep", "balanced"])]
fn thousand_leaves(bencher: Bencher, shape: &str) {
    let body = match shape {
        "wide" => wide(1000),
        "deep" => deep(),
        _ => balanced(),
    };
    let text = format!("<root><BehaviorTree>{body}</BehaviorTree></root>");
    let tree = Arc::new(Tree::from_xml("thousand.xml", &text).expect("the tree is valid"));
    assert_eq!(tree.leaves().count(), 1000);
    let mut leaves = trivial(&tree, |_| Status::Success);
    let mut execution = Execution::new(tree);
    bencher.bench_local(|| execution.tick(NOW, black_box(&mut leaves)));
}

/// The paper's tree from its XML.
#[divan::bench]
fn load_recharge() -> Tree {
    Tree::from_xml("recharge.xml", black_box(RECHARGE)).expect("the shipped tree is valid")
}
