//! BehaviorTree.CPP's own nodes, and Nav2's control nodes and decorators, by name.

use std::collections::HashMap;
use std::sync::LazyLock;

use crate::hooks::Hooks;
use crate::{Category, Direction, Kind};

/// The meaning of a name in BehaviorTree.CPP or Nav2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Builtin {
    /// A supported kind.
    Known(Kind),
    /// A node of version 3 that version 4 no longer has, and its replacement.
    Gone(Category, &'static str),
}

impl Builtin {
    pub(super) fn category(self) -> Category {
        match self {
            Self::Known(kind) => kind.category(),
            Self::Gone(category, _) => category,
        }
    }

    /// Whether this is its name in version 4.
    pub(super) fn is_called(self, name: &str) -> bool {
        matches!(self, Self::Known(kind) if kind.name() == name)
    }
}

/// The replacement of version 3's comparisons.
const PRECONDITION: &str = "write <Precondition if=\"…\"> with a script, as in version 4";

/// Names that differ from the name of the kind.
const OTHER_NAMES: [(&str, Builtin); 8] = [
    ("SequenceStar", Builtin::Known(Kind::SequenceWithMemory)),
    ("RetryUntilSuccesful", Builtin::Known(Kind::RetryUntilSuccessful)),
    ("SubTreePlus", Builtin::Known(Kind::SubTree)),
    ("BlackboardCheckInt", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("BlackboardCheckDouble", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("BlackboardCheckString", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("BlackboardCheckBool", Builtin::Gone(Category::Decorator, PRECONDITION)),
    ("ManualSelector", Builtin::Gone(Category::Control, "it asks a person at a terminal; use <Switch2> instead")),
];

/// The elements of the explicit form.
const EXPLICIT: [Category; 5] =
    [Category::Action, Category::Condition, Category::Control, Category::Decorator, Category::SubTree];

/// The elements in the root.
pub(super) const IN_ROOT: [&str; 3] = ["BehaviorTree", "TreeNodesModel", "include"];

/// The names of the elements that may be in these, the outermost first. A node of a kind that the file declares has the
/// name that it gives to the kind.
#[must_use]
pub fn elements_in(around: &[&str]) -> Vec<&'static str> {
    let explicit = EXPLICIT.into_iter().map(Category::element);
    match around {
        [] => vec!["root"],
        [.., "root"] => IN_ROOT.to_vec(),
        [.., "TreeNodesModel"] => explicit.collect(),
        [.., "TreeNodesModel", _] => {
            [Direction::Input, Direction::Output, Direction::InOut].map(Direction::element).into()
        }
        _ => Kind::BUILTIN.into_iter().map(Kind::name).chain(explicit).collect(),
    }
}

/// The attributes of the root.
pub(super) const OF_ROOT: [&str; 2] = ["BTCPP_format", "main_tree_to_execute"];

/// The attributes that an element has because it is called so, apart from ports.
#[must_use]
pub fn attributes_of(element: &str) -> &'static [&'static str] {
    match element {
        "root" => &OF_ROOT,
        "BehaviorTree" => &["ID"],
        "SubTree" => &["ID", "_autoremap"],
        "include" => &["path", "ros_pkg"],
        "input_port" | "output_port" | "inout_port" => &["name", "type", "default"],
        _ if explicit(element).is_some() => &["ID"],
        _ => &[],
    }
}

/// The attributes that every node may have, apart from its ports.
pub fn node_attributes() -> impl Iterator<Item = &'static str> {
    std::iter::once("name").chain(Hooks::NAMES)
}

/// The first character of a name that BehaviorTree.CPP forbids in the ID of a tree and in the name of a node or a port.
pub(super) fn forbidden(name: &str) -> Option<char> {
    let is_forbidden = |c: char| {
        matches!(c, ' ' | '<' | '>' | '&' | '"' | '\'' | '/' | '\\' | ':' | '*' | '?' | '|' | '.')
            || c.is_ascii_control()
    };
    name.chars().find(|c| is_forbidden(*c))
}

/// The built-in node with this name.
pub(super) fn builtin(name: &str) -> Option<Builtin> {
    // Loading looks up every element several times: comparing all names each time took a tenth of its time.
    static BY_NAME: LazyLock<HashMap<&str, Builtin>> = LazyLock::new(|| {
        let kinds = Kind::BUILTIN.into_iter().map(|kind| (kind.name(), Builtin::Known(kind)));
        kinds.chain(OTHER_NAMES).collect()
    });
    BY_NAME.get(name).copied()
}

/// The category of an element in explicit form.
pub(super) fn explicit(element: &str) -> Option<Category> {
    EXPLICIT.into_iter().find(|category| category.element() == element)
}

/// All names that elements may have without a declaration.
pub(super) fn names<'a>() -> impl Iterator<Item = &'a str> {
    let kinds = Kind::BUILTIN.into_iter().map(|kind| -> &'a str { kind.name() });
    let others = OTHER_NAMES.iter().map(|(name, _)| -> &'a str { name });
    kinds.chain(others).chain(EXPLICIT.into_iter().map(|category| -> &'a str { category.element() }))
}

/// The names of built-in nodes of a category.
pub(super) fn builtins_of(category: Category) -> impl Iterator<Item = &'static str> {
    Kind::BUILTIN.into_iter().filter(move |kind| kind.category() == category).map(Kind::name)
}

/// The name in version 4 of a port of this kind.
pub(super) fn current_port_name(kind: Kind, name: &str) -> &str {
    match (kind, name) {
        (Kind::Parallel, "success_threshold" | "threshold") => "success_count",
        (Kind::Parallel, "failure_threshold") => "failure_count",
        (Kind::SubTree, "__autoremap" | "__shared_blackboard") => "_autoremap",
        _ => name,
    }
}
