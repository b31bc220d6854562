//! The ports of BehaviorTree.CPP's own nodes: their names, types and defaults.

use super::vocabulary;
use crate::blackboard::Type;
use crate::{Item, Kind};

/// A port of a kind of node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Port {
    pub(super) name: &'static str,
    pub(super) of: Of,
    /// Its default.
    pub(super) default: Option<&'static str>,
    /// Whether the node works without it.
    pub(super) optional: bool,
}

impl Port {
    /// Whether the node requires it.
    pub(super) fn is_required(&self) -> bool {
        !self.optional && self.default.is_none()
    }
}

/// A port of one of BehaviorTree.CPP's own nodes, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltinPort {
    /// Its name.
    pub name: &'static str,
    /// What it takes.
    pub takes: &'static str,
    /// What it is if the file does not say.
    pub default: Option<&'static str>,
    /// Whether the node is refused without it.
    pub required: bool,
}

/// The ports of a kind of nodes. Leaves outside the tree have those that their model declares.
pub fn builtin_ports(kind: Kind) -> impl Iterator<Item = BuiltinPort> {
    ports(kind).iter().map(|port| BuiltinPort {
        name: port.name,
        takes: port.of.words(),
        default: port.default,
        required: port.is_required(),
    })
}

/// The type of a port, or a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Of {
    Any,
    Int,
    Unsigned,
    Bool,
    Text,
    Status,
    Item(Item),
    /// A script.
    Code,
    /// The name of an entry, with or without braces.
    Key,
}

impl Of {
    fn words(self) -> &'static str {
        match self {
            Self::Any => "any value",
            Self::Int | Self::Item(Item::Int) => "an integer",
            Self::Unsigned => "an integer of at least 0",
            Self::Bool | Self::Item(Item::Bool) => "true or false",
            Self::Text | Self::Item(Item::Text) => "a text",
            Self::Item(Item::Double) => "a number",
            Self::Status => "SUCCESS, FAILURE, RUNNING or SKIPPED",
            Self::Code => "a script",
            Self::Key => "the name of an entry",
        }
    }

    pub(super) fn type_of(self) -> Type {
        match self {
            Self::Any | Self::Code | Self::Key => Type::Any,
            Self::Int => Type::INT,
            Self::Unsigned => Type::UNSIGNED,
            Self::Bool => Type::Bool,
            Self::Text => Type::Text,
            Self::Status => Type::Status,
            Self::Item(item) => item.type_of(),
        }
    }
}

const fn input(name: &'static str, of: Of) -> Port {
    Port { name, of, default: None, optional: false }
}

const fn with_default(name: &'static str, of: Of, default: &'static str) -> Port {
    Port { default: Some(default), ..input(name, of) }
}

const fn optional(name: &'static str) -> Port {
    Port { optional: true, ..input(name, Of::Text) }
}

const fn output(name: &'static str, of: Of) -> Port {
    Port { name, of, default: None, optional: true }
}

const CASES: [Port; 7] = [
    optional("variable"),
    optional("case_1"),
    optional("case_2"),
    optional("case_3"),
    optional("case_4"),
    optional("case_5"),
    optional("case_6"),
];

const fn a_loop(item: Item) -> [Port; 3] {
    [input("queue", Of::Any), with_default("if_empty", Of::Status, "SUCCESS"), output("value", Of::Item(item))]
}

const LOOP_INT: [Port; 3] = a_loop(Item::Int);
const LOOP_BOOL: [Port; 3] = a_loop(Item::Bool);
const LOOP_DOUBLE: [Port; 3] = a_loop(Item::Double);
const LOOP_TEXT: [Port; 3] = a_loop(Item::Text);

/// The ports of a kind. Leaves outside the tree have those that their model declares.
pub(super) fn ports(kind: Kind) -> &'static [Port] {
    match kind {
        Kind::Parallel => {
            const { &[with_default("success_count", Of::Int, "-1"), with_default("failure_count", Of::Int, "1")] }
        }
        Kind::ParallelAll => const { &[with_default("max_failures", Of::Int, "1")] },
        Kind::Switch(cases) => &CASES[..=usize::from(cases).min(6)],
        Kind::TryCatch => const { &[with_default("catch_on_halt", Of::Bool, "false")] },
        Kind::Repeat => const { &[input("num_cycles", Of::Int)] },
        Kind::RetryUntilSuccessful => const { &[input("num_attempts", Of::Int)] },
        Kind::Delay => const { &[input("delay_msec", Of::Unsigned)] },
        Kind::Timeout | Kind::Sleep => const { &[input("msec", Of::Unsigned)] },
        Kind::RunOnce => const { &[with_default("then_skip", Of::Bool, "true")] },
        Kind::Loop(Item::Int) => &LOOP_INT,
        Kind::Loop(Item::Bool) => &LOOP_BOOL,
        Kind::Loop(Item::Double) => &LOOP_DOUBLE,
        Kind::Loop(Item::Text) => &LOOP_TEXT,
        Kind::Precondition => const { &[input("if", Of::Code), with_default("else", Of::Status, "FAILURE")] },
        Kind::SkipUnlessUpdated | Kind::WaitValueUpdate | Kind::WasEntryUpdated => const { &[input("entry", Of::Key)] },
        Kind::Script | Kind::ScriptCondition => const { &[input("code", Of::Code)] },
        Kind::SetBlackboard => const { &[input("value", Of::Any), input("output_key", Of::Any)] },
        Kind::UnsetBlackboard => const { &[input("key", Of::Text)] },
        _ => &[],
    }
}

/// Whether an attribute with this name can be a port: it begins with a letter, is neither `name` nor `ID`, and has no
/// character that BehaviorTree.CPP forbids.
pub(super) fn is_port_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name != "name"
        && name != "ID"
        && vocabulary::forbidden(name).is_none()
}
