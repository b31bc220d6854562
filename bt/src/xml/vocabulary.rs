//! BehaviorTree.CPP's own nodes, by name.

use crate::{Category, Kind};

/// What a name of BehaviorTree.CPP's stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Builtin {
    /// A kind that we run.
    Known(Kind),
    /// A kind that we do not run yet.
    Later(Category),
}

impl Builtin {
    pub(super) fn category(self) -> Category {
        match self {
            Self::Known(kind) => kind.category(),
            Self::Later(category) => category,
        }
    }
}

/// The nodes that BehaviorTree.CPP 4.10 and 3.8 register themselves.
const BUILTINS: &[(&str, Builtin)] = &[
    ("AlwaysFailure", Builtin::Known(Kind::AlwaysFailure)),
    ("AlwaysSuccess", Builtin::Known(Kind::AlwaysSuccess)),
    ("AsyncFallback", Builtin::Later(Category::Control)),
    ("AsyncSequence", Builtin::Later(Category::Control)),
    ("BlackboardCheckBool", Builtin::Later(Category::Decorator)),
    ("BlackboardCheckDouble", Builtin::Later(Category::Decorator)),
    ("BlackboardCheckInt", Builtin::Later(Category::Decorator)),
    ("BlackboardCheckString", Builtin::Later(Category::Decorator)),
    ("Delay", Builtin::Later(Category::Decorator)),
    ("Fallback", Builtin::Known(Kind::Fallback)),
    ("ForceFailure", Builtin::Known(Kind::ForceFailure)),
    ("ForceSuccess", Builtin::Known(Kind::ForceSuccess)),
    ("IfThenElse", Builtin::Later(Category::Control)),
    ("Inverter", Builtin::Known(Kind::Inverter)),
    ("KeepRunningUntilFailure", Builtin::Later(Category::Decorator)),
    ("LoopBool", Builtin::Later(Category::Decorator)),
    ("LoopDouble", Builtin::Later(Category::Decorator)),
    ("LoopInt", Builtin::Later(Category::Decorator)),
    ("LoopString", Builtin::Later(Category::Decorator)),
    ("ManualSelector", Builtin::Later(Category::Control)),
    ("Parallel", Builtin::Later(Category::Control)),
    ("ParallelAll", Builtin::Later(Category::Control)),
    ("Precondition", Builtin::Later(Category::Decorator)),
    ("ReactiveFallback", Builtin::Known(Kind::ReactiveFallback)),
    ("ReactiveSequence", Builtin::Known(Kind::ReactiveSequence)),
    ("Repeat", Builtin::Later(Category::Decorator)),
    ("RetryUntilSuccesful", Builtin::Later(Category::Decorator)),
    ("RetryUntilSuccessful", Builtin::Later(Category::Decorator)),
    ("RunOnce", Builtin::Later(Category::Decorator)),
    ("Script", Builtin::Later(Category::Action)),
    ("ScriptCondition", Builtin::Later(Category::Condition)),
    ("Sequence", Builtin::Known(Kind::Sequence)),
    // Version 3's name of it.
    ("SequenceStar", Builtin::Known(Kind::SequenceWithMemory)),
    ("SequenceWithMemory", Builtin::Known(Kind::SequenceWithMemory)),
    ("SetBlackboard", Builtin::Later(Category::Action)),
    ("SkipUnlessUpdated", Builtin::Later(Category::Decorator)),
    ("Sleep", Builtin::Later(Category::Action)),
    ("SubTreePlus", Builtin::Later(Category::SubTree)),
    ("Switch2", Builtin::Later(Category::Control)),
    ("Switch3", Builtin::Later(Category::Control)),
    ("Switch4", Builtin::Later(Category::Control)),
    ("Switch5", Builtin::Later(Category::Control)),
    ("Switch6", Builtin::Later(Category::Control)),
    ("Timeout", Builtin::Later(Category::Decorator)),
    ("TryCatch", Builtin::Later(Category::Control)),
    ("UnsetBlackboard", Builtin::Later(Category::Action)),
    ("WaitValueUpdate", Builtin::Later(Category::Decorator)),
    ("WasEntryUpdated", Builtin::Later(Category::Action)),
];

/// The elements that spell a category out.
const EXPLICIT: [Category; 5] =
    [Category::Action, Category::Condition, Category::Control, Category::Decorator, Category::SubTree];

/// Attributes that hold scripts: they say when a node is ticked at all, or what happens when it is done.
const SCRIPTS: [&str; 8] =
    ["_skipIf", "_failureIf", "_successIf", "_while", "_onSuccess", "_onFailure", "_onHalted", "_post"];

/// BehaviorTree.CPP's node of that name.
pub(super) fn builtin(name: &str) -> Option<Builtin> {
    BUILTINS.iter().find(|(known, _)| *known == name).map(|(_, builtin)| *builtin)
}

/// The category that an element spells out.
pub(super) fn explicit(element: &str) -> Option<Category> {
    EXPLICIT.into_iter().find(|category| category.element() == element)
}

/// All names that an element may have without being declared.
pub(super) fn names<'a>() -> impl Iterator<Item = &'a str> {
    BUILTINS.iter().map(|(name, _)| -> &str { name }).chain(EXPLICIT.iter().map(|category| category.element()))
}

/// The names of BehaviorTree.CPP's nodes of a category.
pub(super) fn builtins_of<'a>(category: Category) -> impl Iterator<Item = &'a str> {
    BUILTINS.iter().filter(move |(_, builtin)| builtin.category() == category).map(|(name, _)| -> &str { name })
}

/// Whether an attribute of that name holds a script.
pub(super) fn is_script(attribute: &str) -> bool {
    SCRIPTS.contains(&attribute)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_inner_node_is_found_under_its_own_name() {
        for (name, builtin) in BUILTINS {
            if let Builtin::Known(kind) = builtin {
                assert!(kind.name() == *name || *name == "SequenceStar", "{name}");
            }
        }
    }
}
