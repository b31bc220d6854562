//! The ports of BehaviorTree.CPP's and Nav2's nodes: their names, types and defaults.

use super::vocabulary;
use crate::blackboard::Type;
use crate::{Item, Kind};

/// A port of a kind of node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Port {
    pub(super) name: &'static str,
    pub(super) of: Of,
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

/// A port of one of BehaviorTree.CPP's or Nav2's nodes, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltinPort {
    /// Its name.
    pub name: &'static str,
    /// What it takes, in words.
    pub takes: &'static str,
    /// How its value is read.
    pub form: PortForm,
    /// Its value if the file does not set it.
    pub default: Option<&'static str>,
    /// Whether the node is refused without it.
    pub required: bool,
}

/// How the value of a port is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortForm {
    /// As a script.
    Script,
    /// As the name of an entry, with or without braces.
    Entry,
    /// As true or false.
    Truth,
    /// As any other value.
    Value,
}

/// The ports of a kind of nodes. Leaves outside the tree have those that their model declares.
pub fn builtin_ports(kind: Kind) -> impl Iterator<Item = BuiltinPort> {
    ports(kind).iter().map(|port| BuiltinPort {
        name: port.name,
        takes: port.of.words(),
        form: port.of.form(),
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
    Real,
    /// A real number greater than 0.
    Rate,
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
            Self::Text | Self::Item(Item::Text) => "a string",
            Self::Real | Self::Item(Item::Double) => "a number",
            Self::Rate => "a number greater than 0",
            Self::Status => "SUCCESS, FAILURE, RUNNING or SKIPPED",
            Self::Code => "a script",
            Self::Key => "the name of an entry",
        }
    }

    fn form(self) -> PortForm {
        match self {
            Self::Code => PortForm::Script,
            Self::Key => PortForm::Entry,
            Self::Bool | Self::Item(Item::Bool) => PortForm::Truth,
            _ => PortForm::Value,
        }
    }

    pub(super) fn type_of(self) -> Type {
        match self {
            Self::Any | Self::Code | Self::Key => Type::Any,
            Self::Int => Type::INT,
            Self::Unsigned => Type::UNSIGNED,
            Self::Bool => Type::Bool,
            Self::Real | Self::Rate => Type::Real,
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

const fn optional(name: &'static str, of: Of) -> Port {
    Port { optional: true, ..input(name, of) }
}

const CASES: [Port; 7] = [
    optional("variable", Of::Text),
    optional("case_1", Of::Text),
    optional("case_2", Of::Text),
    optional("case_3", Of::Text),
    optional("case_4", Of::Text),
    optional("case_5", Of::Text),
    optional("case_6", Of::Text),
];

const fn a_loop(item: Item) -> [Port; 3] {
    [input("queue", Of::Any), with_default("if_empty", Of::Status, "SUCCESS"), optional("value", Of::Item(item))]
}

const LOOP_INT: [Port; 3] = a_loop(Item::Int);
const LOOP_BOOL: [Port; 3] = a_loop(Item::Bool);
const LOOP_DOUBLE: [Port; 3] = a_loop(Item::Double);
const LOOP_TEXT: [Port; 3] = a_loop(Item::Text);

const DISTANCE: [Port; 3] = [
    with_default("distance", Of::Real, "1.0"),
    optional("global_frame", Of::Text),
    optional("robot_base_frame", Of::Text),
];

const GOALS: [Port; 2] = [with_default("goal", Of::Any, "{goal}"), with_default("goals", Of::Any, "{goals}")];

const SPEED: [Port; 6] = [
    with_default("min_rate", Of::Rate, "0.1"),
    with_default("max_rate", Of::Rate, "1.0"),
    with_default("min_speed", Of::Real, "0.0"),
    with_default("max_speed", Of::Real, "0.5"),
    GOALS[0],
    GOALS[1],
];

const UPDATES: [Port; 4] = [
    optional("input_goal", Of::Any),
    optional("input_goals", Of::Any),
    optional("output_goal", Of::Any),
    optional("output_goals", Of::Any),
];

const PATH: [Port; 3] = [
    optional("path", Of::Any),
    with_default("prox_len", Of::Real, "3.0"),
    with_default("length_factor", Of::Real, "2.0"),
];

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
        kind => nav2_ports(kind),
    }
}

fn nav2_ports(kind: Kind) -> &'static [Port] {
    match kind {
        Kind::PersistentSequence => const { &[input("current_child_idx", Of::Int)] },
        Kind::RecoveryNode => const { &[with_default("number_of_retries", Of::Unsigned, "1")] },
        Kind::RoundRobin => const { &[with_default("wrap_around", Of::Bool, "false")] },
        Kind::PauseResumeController => {
            const { &[input("pause_service_name", Of::Text), input("resume_service_name", Of::Text)] }
        }
        Kind::RateController => const { &[with_default("hz", Of::Rate, "10.0")] },
        Kind::DistanceController => &DISTANCE,
        Kind::SpeedController => &SPEED,
        Kind::GoalUpdater => &UPDATES,
        Kind::GoalUpdatedController => &GOALS,
        Kind::PathLongerOnApproach => &PATH,
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
