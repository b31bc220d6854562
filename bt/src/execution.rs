//! A running tree: ticks and halts, at once or from leaf call to leaf call.

use std::sync::Arc;
use std::time::Duration;

use channels::{NormalForm, Shared};

use crate::engine::{Context, Later, Now, TreeState};
use crate::{
    Blackboard, Call, Fault, Leaf, Leaves, NodeId, NodeState, NodeTransition, Outcome, Progress, Reply, Status, Tree,
};

/// A running tree: the tree and the status of each of its nodes.
///
/// The state is a value: it can be copied, compared and hashed at any time, even in the middle of a tick. If leaves
/// answer at once, [`tick`](Self::tick) runs a whole tick without allocations. If answers take time,
/// [`start_tick`](Self::start_tick) and [`resume`](Self::resume) run the same tick from call to call:
///
/// ```
/// use std::sync::Arc;
/// use std::time::Duration;
/// use bt::{Execution, Progress, Reply, Request, Status, Tree};
///
/// let tree = Tree::from_xml("greet.xml", r#"<root BTCPP_format="4"> <BehaviorTree ID="Greet">
///     <Sequence> <Condition ID="SomebodyThere"/> <Action ID="SayHello"/> </Sequence>
/// </BehaviorTree> </root>"#)?;
/// let mut execution = Execution::new(Arc::new(tree));
///
/// let now = Duration::ZERO;
/// let Some(Progress::Call(call)) = execution.start_tick(now) else { unreachable!() };
/// assert_eq!(execution.tree().node(call.leaf).label(), "SomebodyThere");
/// let Some(Progress::Call(call)) = execution.resume(now, Reply::Status(Status::Success)) else { unreachable!() };
/// assert_eq!(execution.tree().node(call.leaf).label(), "SayHello");
/// assert_eq!(execution.resume(now, Reply::Status(Status::Running)), Some(Progress::Done(Status::Running)));
///
/// // The greeting is still in progress, so halting the tree halts the action.
/// let Some(Progress::Call(call)) = execution.start_halt(now) else { unreachable!() };
/// assert_eq!((execution.tree().node(call.leaf).label(), call.request), ("SayHello", Request::Halt));
/// assert_eq!(execution.resume(now, Reply::Halted), Some(Progress::Halted));
/// # Ok::<(), bt::TreeError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Execution {
    tree: Shared<Tree>,
    state: TreeState,
}

impl Execution {
    /// The tree before its first tick.
    #[must_use]
    pub fn new(tree: Arc<Tree>) -> Self {
        let state = TreeState::new(&tree.program);
        Self { tree: tree.into(), state }
    }

    /// The tree.
    #[must_use]
    pub fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }

    /// The answer of the last finished tick.
    #[must_use]
    pub fn last_status(&self) -> Option<Status> {
        self.state.last_status()
    }

    /// The call whose answer the execution is waiting for; `None` between ticks.
    #[must_use]
    pub fn pending(&self) -> Option<Call> {
        self.state.pending()
    }

    /// The states of all nodes, in document order.
    #[must_use]
    pub fn states(&self) -> Vec<NodeState> {
        self.state.states(&self.tree.program.ops)
    }

    /// The faults in the last tick and in halts since then.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.state.faults
    }

    /// From now on, changes of status are noted until they are [taken](Self::take_transitions).
    pub fn note_transitions(&mut self) {
        self.state.begin_journal();
    }

    /// The changes of status since the last call, in the order in which a logger of BehaviorTree.CPP gets them; none
    /// if they are not [noted](Self::note_transitions).
    pub fn take_transitions(&mut self) -> Vec<NodeTransition> {
        self.state.take_transitions()
    }

    /// Everything that has happened to nodes in the last tick. Nodes within their tick count as running.
    pub(crate) fn outcomes(&self) -> Vec<(NodeId, Outcome)> {
        self.state.outcomes(&self.tree.program.ops)
    }

    /// The blackboard.
    #[must_use]
    pub fn blackboard(&self) -> &Blackboard {
        &self.state.board
    }

    /// The blackboard, for writing between ticks.
    pub fn blackboard_mut(&mut self) -> &mut Blackboard {
        &mut self.state.board
    }

    /// The leaf of a pending call, with its ports. The leaf sees the time `now`.
    ///
    /// # Panics
    /// If `id` is not a leaf of this tree.
    pub fn leaf(&mut self, id: NodeId, now: Duration) -> Leaf<'_> {
        assert!(self.tree.node(id).kind().is_leaf(), "only leaves are called");
        Leaf { id, tree: &self.tree, board: &mut self.state.board, now }
    }

    /// Begins a tick at this time of the run. While a call is pending, does nothing and returns `None`.
    pub fn start_tick(&mut self, now: Duration) -> Option<Progress> {
        self.pending().is_none().then(|| {
            let tick = self.state.new_tick();
            self.state.run(&mut Context::new(&self.tree, now, Later), tick)
        })
    }

    /// Starts halting the whole tree, including the root: every running action is asked to stop, in document order, and
    /// all nodes become idle. As in BehaviorTree.CPP, every node is then halted once more, running or not, which is
    /// visible in `_onHalted` scripts. While a call is pending, does nothing and returns `None`.
    pub fn start_halt(&mut self, now: Duration) -> Option<Progress> {
        self.pending().is_none().then(|| {
            let mut context = Context::new(&self.tree, now, Later);
            let halt = context.halt_all();
            self.state.run(&mut context, halt)
        })
    }

    /// Continues with the answer to the pending call. Does nothing and returns `None` if no call is pending or the
    /// reply does not answer it.
    pub fn resume(&mut self, now: Duration, reply: Reply) -> Option<Progress> {
        let mut context = Context::new(&self.tree, now, Later);
        let next = self.state.replied(&mut context, reply)?;
        Some(self.state.run(&mut context, next))
    }

    /// Brings the state into [normal form](NormalForm): state that is only reported is forgotten, and times are
    /// relative.
    pub(crate) fn normalize(&mut self, form: &NormalForm<'_>) {
        self.state.normalize(&self.tree.program, form);
    }

    /// Continues without an answer to the pending call: a leaf that was ticked has failed, one that was asked to halt
    /// has halted. `reason` is recorded as the leaf's [fault](Self::faults). Does nothing and returns `None` if no call
    /// is pending.
    pub fn give_up(&mut self, now: Duration, reason: String) -> Option<Progress> {
        let Call { leaf, request } = self.pending()?;
        self.state.fault(leaf.0, reason);
        self.resume(now, request.unanswered())
    }

    /// Runs a tick at this time of the run, with leaves that answer at once. Allocates nothing, unless a script
    /// concatenates strings or an error occurs.
    ///
    /// If a call is pending, its leaf is asked again, and that tick is completed.
    pub fn tick(&mut self, now: Duration, leaves: &mut impl Leaves) -> Status {
        let mut context = Context::new(&self.tree, now, Now(leaves));
        let mut next = self.state.pending_again(&mut context);
        loop {
            let next = next.take().unwrap_or_else(|| self.state.new_tick());
            if let Progress::Done(status) = self.state.run(&mut context, next) {
                return status;
            }
        }
    }

    /// Halts the whole tree like [`start_halt`](Self::start_halt), with leaves that answer at once. A tick with a
    /// pending call is completed first.
    pub fn halt(&mut self, now: Duration, leaves: &mut impl Leaves) {
        let mut context = Context::new(&self.tree, now, Now(leaves));
        if let Some(next) = self.state.pending_again(&mut context) {
            self.state.run(&mut context, next);
        }
        let halt = context.halt_all();
        self.state.run(&mut context, halt);
    }
}
