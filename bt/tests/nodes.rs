//! The behavior of every kind of node, as the documentation of BehaviorTree.CPP and Nav2 describes it: one behavior per
//! test, named after the node and the behavior.

mod actions;
mod asynchronous;
mod blackboard;
mod conditional;
mod decorators;
mod halting;
mod hooks;
mod in_order;
mod loops;
mod nav2;
mod parallel;
mod ports;
mod repetition;
mod subtrees;
mod switch;
mod timed;
mod try_catch;
mod updates;
