//! Behavior trees: BehaviorTree.CPP XML, node semantics, ticking and halting.
