//! What every kind of node does, in the words of BehaviorTree.CPP's documentation: one behaviour a test, named after
//! the node and the behaviour.

mod actions;
mod asynchronous;
mod blackboard;
mod conditional;
mod decorators;
mod halting;
mod hooks;
mod in_order;
mod loops;
mod parallel;
mod ports;
mod repetition;
mod subtrees;
mod switch;
mod timed;
mod try_catch;
mod updates;
