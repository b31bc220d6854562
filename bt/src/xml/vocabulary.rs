//! BehaviorTree.CPP's own nodes, by name.

use crate::{Category, Kind};

/// What a name of BehaviorTree.CPP's stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Builtin {
    /// A kind that we run.
    Known(Kind),
    /// A node of version 3 that version 4 no longer has, and what to write instead.
    Gone(Category, &'static str),
}

impl Builtin {
    pub(super) fn category(self) -> Category {
        match self {
            Self::Known(kind) => kind.category(),
            Self::Gone(category, _) => category,
        }
    }

    /// Whether that is what version 4 calls it.
    pub(super) fn is_called(self, name: &str) -> bool {
        matches!(self, Self::Known(kind) if kind.name() == name)
    }
}

/// What to write instead of version 3's comparisons.
const PRECONDITION: &str = "write <Precondition if=\"…\"> with a script, as version 4 has it";

/// Names that are not those of a kind.
const OTHER_NAMES: [(&str, Builtin); 8] = [
    ("SequenceStar", Builtin::Known(Kind::SequenceWithMemory)),
    ("RetryUntilSuccesful", Builtin::Known(Kind::RetryUntilSuccessful)),
    ("SubTreePlus", Builtin::Known(Kind::SubTree)),
    ("BlackboardCheckInt", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("BlackboardCheckDouble", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("BlackboardCheckString", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("BlackboardCheckBool", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("ManualSelector", Builtin::Gone(Category::Control, "it asks a person at a terminal; write a <Switch2> instead")),
];

/// The elements that spell a category out.
const EXPLICIT: [Category; 5] =
    [Category::Action, Category::Condition, Category::Control, Category::Decorator, Category::SubTree];

/// Characters that BehaviorTree.CPP allows neither in the ID of a tree nor in the name of a node or a port. Control
/// characters are not allowed, either.
const FORBIDDEN: &str = " <>&\"'/\\:*?|.";

/// The first character of a name that BehaviorTree.CPP does not allow there.
pub(super) fn forbidden(name: &str) -> Option<char> {
    name.chars().find(|c| c.is_ascii_control() || FORBIDDEN.contains(*c))
}

/// BehaviorTree.CPP's node of that name.
pub(super) fn builtin(name: &str) -> Option<Builtin> {
    let kind = Kind::BUILTIN.into_iter().find(|kind| kind.name() == name).map(Builtin::Known);
    kind.or_else(|| OTHER_NAMES.iter().find(|(other, _)| *other == name).map(|(_, builtin)| *builtin))
}

/// The category that an element spells out.
pub(super) fn explicit(element: &str) -> Option<Category> {
    EXPLICIT.into_iter().find(|category| category.element() == element)
}

/// All names that an element may have without being declared.
pub(super) fn names<'a>() -> impl Iterator<Item = &'a str> {
    let kinds = Kind::BUILTIN.into_iter().map(|kind| -> &'a str { kind.name() });
    let others = OTHER_NAMES.iter().map(|(name, _)| -> &'a str { name });
    kinds.chain(others).chain(EXPLICIT.into_iter().map(|category| -> &'a str { category.element() }))
}

/// The names of BehaviorTree.CPP's nodes of a category.
pub(super) fn builtins_of(category: Category) -> impl Iterator<Item = &'static str> {
    Kind::BUILTIN.into_iter().filter(move |kind| kind.category() == category).map(Kind::name)
}

/// What version 3 called a port of that kind.
pub(super) fn current_port_name(kind: Kind, name: &str) -> &str {
    match (kind, name) {
        (Kind::Parallel, "success_threshold" | "threshold") => "success_count",
        (Kind::Parallel, "failure_threshold") => "failure_count",
        (Kind::SubTree, "__autoremap" | "__shared_blackboard") => "_autoremap",
        _ => name,
    }
}
