//! A tree at work: ticks and halts, in one go or from leaf call to leaf call.

use std::sync::Arc;
use std::time::Duration;

use crate::engine::{Context, Later, Now, State};
use crate::shared::Shared;
use crate::{Blackboard, Call, Fault, Leaf, Leaves, NodeId, NodeState, Reply, Status, Step, Tree};

/// A tree at work: the tree and the status of each of its nodes.
///
/// The state is a value: it can be copied, compared and hashed at any time, also in the middle of a tick. Where leaves
/// answer at once, [`tick`](Self::tick) runs a whole tick; it allocates nothing. Where an answer takes time,
/// [`start_tick`](Self::start_tick) and [`resume`](Self::resume) run the same tick from call to call:
///
/// ```
/// use std::sync::Arc;
/// use std::time::Duration;
/// use bt::{Execution, Reply, Request, Status, Step, Tree};
///
/// let tree = Tree::from_xml("greet.xml", r#"<root BTCPP_format="4"> <BehaviorTree ID="Greet">
///     <Sequence> <Condition ID="SomebodyThere"/> <Action ID="SayHello"/> </Sequence>
/// </BehaviorTree> </root>"#)?;
/// let mut execution = Execution::new(Arc::new(tree));
///
/// let now = Duration::ZERO;
/// let Some(Step::Call(call)) = execution.start_tick(now) else { unreachable!() };
/// assert_eq!(execution.tree().node(call.leaf).label(), "SomebodyThere");
/// let Some(Step::Call(call)) = execution.resume(now, Reply::Status(Status::Success)) else { unreachable!() };
/// assert_eq!(execution.tree().node(call.leaf).label(), "SayHello");
/// assert_eq!(execution.resume(now, Reply::Status(Status::Running)), Some(Step::Done(Status::Running)));
///
/// // The greeting is still going on: halting the tree tells the action.
/// let Some(Step::Call(call)) = execution.start_halt(now) else { unreachable!() };
/// assert_eq!((execution.tree().node(call.leaf).label(), call.request), ("SayHello", Request::Halt));
/// assert_eq!(execution.resume(now, Reply::Halted), Some(Step::Halted));
/// # Ok::<(), bt::TreeError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Execution {
    tree: Shared<Tree>,
    state: State,
}

impl Execution {
    /// The tree before its first tick.
    #[must_use]
    pub fn new(tree: Arc<Tree>) -> Self {
        let state = State::new(&tree.program);
        Self { tree: tree.into(), state }
    }

    /// The tree that is at work.
    #[must_use]
    pub fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }

    /// What the last tick that came to its end answered.
    #[must_use]
    pub fn last_status(&self) -> Option<Status> {
        self.state.last_status()
    }

    /// The call whose answer the execution waits for; none between ticks.
    #[must_use]
    pub fn pending(&self) -> Option<Call> {
        self.state.pending()
    }

    /// How all nodes stand, in document order.
    #[must_use]
    pub fn states(&self) -> Vec<NodeState> {
        self.state.states(&self.tree.program.ops)
    }

    /// What went wrong in the last tick, and in halts since.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        self.state.faults()
    }

    /// The blackboard.
    #[must_use]
    pub fn blackboard(&self) -> &Blackboard {
        &self.state.board
    }

    /// The blackboard, to be written to between ticks.
    pub fn blackboard_mut(&mut self) -> &mut Blackboard {
        &mut self.state.board
    }

    /// The leaf of a pending call, with its ports. `now` is what the leaf takes for the time.
    ///
    /// # Panics
    /// If it is no leaf of this tree.
    pub fn leaf(&mut self, id: NodeId, now: Duration) -> Leaf<'_> {
        assert!(self.tree.node(id).kind().is_leaf(), "only leaves are called");
        Leaf { id, tree: &self.tree, board: &mut self.state.board, now }
    }

    /// Begins a tick at that time of the run. None, and nothing happens, while a call is pending.
    pub fn start_tick(&mut self, now: Duration) -> Option<Step> {
        self.pending().is_none().then(|| {
            let tick = self.state.new_tick();
            self.state.run(&mut Context::new(&self.tree, now, Later), tick)
        })
    }

    /// Begins to halt the whole tree, the root too: every action that is running is told to stop, in document order,
    /// and all nodes become idle. As BehaviorTree.CPP does it, every node is halted once more afterwards, whether it was
    /// running or not, which shows in `_onHalted` scripts. None, and nothing happens, while a call is pending.
    pub fn start_halt(&mut self, now: Duration) -> Option<Step> {
        self.pending().is_none().then(|| {
            let mut context = Context::new(&self.tree, now, Later);
            let halt = context.halt_all();
            self.state.run(&mut context, halt)
        })
    }

    /// Goes on with the answer to the pending call. None, and nothing happens, if there is no call pending or that is
    /// no answer to it.
    pub fn resume(&mut self, now: Duration, reply: Reply) -> Option<Step> {
        let mut context = Context::new(&self.tree, now, Later);
        let next = self.state.replied(&mut context, reply)?;
        Some(self.state.run(&mut context, next))
    }

    /// Goes on without the answer to the pending call, which has not come: a leaf that was ticked has failed, one that was
    /// told to halt has halted. `reason` is kept as the leaf's [fault](Self::faults). None, and nothing happens, if there
    /// is no call pending.
    pub fn give_up(&mut self, now: Duration, reason: String) -> Option<Step> {
        let Call { leaf, request } = self.pending()?;
        self.state.fault(leaf.0, reason);
        self.resume(now, request.unanswered())
    }

    /// Runs a tick at that time of the run, with leaves that answer at once. Allocates nothing, unless a script joins
    /// texts or something goes wrong.
    ///
    /// If a call is pending, its leaf is asked again first, and it is that tick that is run to its end.
    pub fn tick(&mut self, now: Duration, leaves: &mut impl Leaves) -> Status {
        let mut context = Context::new(&self.tree, now, Now(leaves));
        let mut next = self.state.pending_again(&mut context);
        loop {
            let next = next.take().unwrap_or_else(|| self.state.new_tick());
            if let Step::Done(status) = self.state.run(&mut context, next) {
                return status;
            }
        }
    }

    /// Halts the whole tree, as [`start_halt`](Self::start_halt) does, with leaves that answer at once. A tick whose
    /// call is pending is run to its end first.
    pub fn halt(&mut self, now: Duration, leaves: &mut impl Leaves) {
        let mut context = Context::new(&self.tree, now, Now(leaves));
        if let Some(next) = self.state.pending_again(&mut context) {
            self.state.run(&mut context, next);
        }
        let halt = context.halt_all();
        self.state.run(&mut context, halt);
    }
}
