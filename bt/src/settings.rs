//! The values that nodes read from their ports and from the blackboard when they are ticked.

mod input;
mod nav2;
mod pose;

use std::collections::VecDeque;
use std::sync::Arc;

pub(crate) use input::{Input, ReadError};
pub(crate) use nav2::{DetourGuard, DistanceLimit, Goals, Index, Nav2, SpeedLimit, Update, period};

use crate::blackboard::{Blackboard, ScopeId, Scopes, Slot, Type, Value, ValueError};
use crate::script::Script;
use crate::semantics::PortReading;
use crate::{Item, Kind, Status};

/// Values that a node must read, depending on its kind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Setting {
    Nothing,
    /// Numbers that are the same at every tick.
    Constant([i64; 2]),
    /// Numbers or Booleans; the second may be missing.
    Numbers([Option<(Input, Type)>; 2]),
    Switch {
        variable: Option<Input>,
        cases: Vec<Option<Input>>,
        constants: Arc<Constants>,
    },
    Script(Script),
    Condition(Script),
    Precondition {
        script: Script,
        otherwise: Input,
    },
    Loop(Loop),
    /// The number of a watched entry.
    Watched(usize),
    SetBlackboard {
        key: Input,
        value: Input,
        scope: ScopeId,
    },
    UnsetBlackboard {
        key: Input,
        scope: ScopeId,
    },
    Nav2(Box<Nav2>),
}

/// The queue of a loop.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Loop {
    pub(crate) queue: Input,
    pub(crate) value: Option<Slot>,
    pub(crate) if_empty: Input,
    pub(crate) item: Item,
    /// The number of the memo with its remaining items.
    pub(crate) memo: usize,
}

/// Names for numbers in scripts and switches.
pub(crate) type Constants = std::collections::BTreeMap<String, i64>;

impl Setting {
    /// Whether reading it does not involve the blackboard.
    pub(crate) fn is_constant(&self) -> bool {
        self.constant().is_some()
    }

    pub(crate) fn script(&self) -> Option<&Script> {
        match self {
            Self::Script(script) | Self::Condition(script) | Self::Precondition { script, .. } => Some(script),
            _ => None,
        }
    }

    /// The script that decides what it does.
    pub(crate) fn condition(&self) -> Option<&Script> {
        match self {
            Self::Condition(script) | Self::Precondition { script, .. } => Some(script),
            _ => None,
        }
    }

    /// The inputs that the file gives to one of BehaviorTree.CPP's nodes. Those of Nav2's nodes come from outside.
    pub(crate) fn inputs(&self) -> Vec<&Input> {
        match self {
            Self::Numbers(inputs) => inputs.iter().flatten().map(|(input, _)| input).collect(),
            Self::Switch { variable, cases, .. } => variable.iter().chain(cases.iter().flatten()).collect(),
            Self::Precondition { otherwise, .. } => vec![otherwise],
            Self::Loop(one) => vec![&one.queue, &one.if_empty],
            Self::SetBlackboard { key, value, .. } => vec![key, value],
            Self::UnsetBlackboard { key, .. } => vec![key],
            Self::Nothing | Self::Constant(_) | Self::Script(_) | Self::Condition(_) => Vec::new(),
            Self::Watched(_) | Self::Nav2(_) => Vec::new(),
        }
    }

    /// The entries that the node writes, apart from its scripts.
    pub(crate) fn written(&self, scopes: &Scopes) -> Vec<Slot> {
        match self {
            Self::Loop(one) => one.value.into_iter().collect(),
            Self::SetBlackboard { key: Input::Constant(key), scope, .. } => {
                scopes.find(*scope, &key.to_text()).into_iter().collect()
            }
            Self::Nav2(nav2) => match &**nav2 {
                Nav2::Index(index) => vec![index.slot],
                Nav2::Updates(updates) => updates.iter().filter_map(|update| update.output).collect(),
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    /// The key that it names without a port: what it sets or unsets.
    pub(crate) fn named_key(&self) -> Option<Arc<str>> {
        match self {
            Self::SetBlackboard { key: Input::Constant(key), .. }
            | Self::UnsetBlackboard { key: Input::Constant(key), .. } => Some(key.to_text()),
            _ => None,
        }
    }

    /// The result of reading, if it does not involve the blackboard.
    pub(crate) fn constant(&self) -> Option<PortReading> {
        match self {
            Self::Nothing => Some(PortReading::Nothing),
            Self::Constant(numbers) => Some(PortReading::Numbers(*numbers)),
            _ => None,
        }
    }

    /// Reads what the node needs, and writes what it writes. `starts` means that the node was idle.
    #[inline]
    pub(crate) fn read(&self, board: &mut Blackboard, starts: bool, kind: Kind) -> Result<PortReading, ReadError> {
        match self {
            Self::Nothing => Ok(PortReading::Nothing),
            Self::Constant(numbers) => Ok(PortReading::Numbers(*numbers)),
            _ => self.read_board(board, starts, kind),
        }
    }

    fn read_board(&self, board: &mut Blackboard, starts: bool, kind: Kind) -> Result<PortReading, ReadError> {
        let succeed_if = |holds| PortReading::Status(if holds { Status::Success } else { Status::Failure });
        Ok(match self {
            Self::Nothing => PortReading::Nothing,
            Self::Constant(numbers) => PortReading::Numbers(*numbers),
            Self::Numbers(inputs) => PortReading::Numbers(numbers(inputs, board, kind)?),
            Self::Switch { variable, cases, constants } => {
                let chosen = choose(variable.as_ref(), cases, constants, board);
                PortReading::Numbers([i64::try_from(chosen).unwrap_or(i64::MAX), 0])
            }
            Self::Script(script) => {
                script.run(board)?;
                PortReading::Status(Status::Success)
            }
            Self::Condition(script) => succeed_if(script.holds(board)?),
            Self::Precondition { script, otherwise } => {
                // As in BehaviorTree.CPP, a wrong `else` is an error even if the script holds.
                let otherwise = otherwise.status(board)?;
                if script.holds(board)? { PortReading::Proceed } else { PortReading::Status(otherwise) }
            }
            Self::Loop(one) => one.read(board, starts)?,
            Self::Watched(number) => PortReading::Numbers([board.has_new_value(*number).into(), 0]),
            Self::SetBlackboard { key, value, scope } => succeed_if(set(board, key, value, *scope)?),
            Self::UnsetBlackboard { key, scope } => {
                unset(board, key, *scope)?;
                PortReading::Status(Status::Success)
            }
            Self::Nav2(nav2) => nav2.read(board, starts)?,
        })
    }

    /// Reads what the node needs when a child has given this answer.
    pub(crate) fn read_after(
        &self,
        status: Status,
        board: &mut Blackboard,
        kind: Kind,
    ) -> Result<PortReading, ReadError> {
        match self {
            Self::Nav2(nav2) => nav2.read_after(status, board),
            _ => self.read(board, false, kind),
        }
    }
}

/// One or two numbers; 0 if the node has no second one.
fn numbers(inputs: &[Option<(Input, Type)>; 2], board: &Blackboard, kind: Kind) -> Result<[i64; 2], ReadError> {
    let mut numbers = [0; 2];
    for (number, input) in numbers.iter_mut().zip(inputs) {
        if let Some((input, of)) = input {
            match input.number(board, of) {
                Ok(read) => *number = read,
                // BehaviorTree.CPP assumes the same values if it cannot read the flag.
                Err(_) if kind == Kind::RunOnce => *number = 1,
                Err(_) if kind == Kind::TryCatch => *number = 0,
                Err(error) => return Err(error),
            }
        }
    }
    Ok(numbers)
}

/// Removes an entry if it belongs to the tree.
fn unset(board: &mut Blackboard, key: &Input, scope: ScopeId) -> Result<(), ReadError> {
    let key = key.read(board, &Type::Text)?.to_text();
    if board.is_own(scope, &key)
        && let Some(slot) = board.find(scope, &key)
    {
        board.unset(slot);
    }
    Ok(())
}

/// Writes an entry. Returns false if there is nothing to write.
fn set(board: &mut Blackboard, key: &Input, value: &Input, scope: ScopeId) -> Result<bool, ReadError> {
    let key = key.read(board, &Type::Text)?.to_text();
    let read = match value {
        Input::Entry(slot, _) if !board.exists(*slot) => return Err(value.empty()),
        value => value.value(board).cloned(),
    };
    let slot = board.slot(scope, &key);
    let is_new = !board.exists(slot);
    let source = value.entry();
    if is_new {
        // A new entry has the type of the entry that is copied; one that gets a constant is a string.
        match source {
            Some(source) => board.declare_like(slot, source),
            None => board.declare(slot, Type::Text),
        }
    }
    let Some(read) = read else { return Ok(false) };
    let mut holds = source.map_or(Type::Text, |source| board.holds(source).clone());
    let of = board.type_of(slot).clone();
    let mut read = Some(read);
    // The value of a status is no string in BehaviorTree.CPP, and no string becomes one.
    if matches!(read, Some(Value::Text(_))) && of != Type::Text && !(of == Type::Status || holds == Type::Status) {
        // BehaviorTree.CPP parses a string with the type of the entry. One that has none cannot parse it and is
        // emptied.
        if board.is_any(slot) {
            return Err(ValueError::new(
                read.unwrap_or_else(|| "".into()),
                "a BT::Any: no string can be parsed as one",
            )
            .into());
        }
        // One whose type is only in the robot's program is taken to be able to.
        if !board.is_unknown(slot) {
            read = read.filter(|_| of.is_strong()).map(|text| of.convert(&text)).transpose()?;
            holds = of;
        }
    }
    let own = key.starts_with('@') || board.is_own(scope, &key);
    board.copy(slot, read, holds, own)?;
    Ok(true)
}

/// The number of the case that equals a variable; that of the last child if there is none.
fn choose(variable: Option<&Input>, cases: &[Option<Input>], constants: &Constants, board: &Blackboard) -> usize {
    let Some(value) = variable.and_then(|input| input.value(board)) else { return cases.len() };
    let is_equal = |case: &Option<Input>| {
        case.as_ref().and_then(|case| case.value(board)).is_some_and(|case| are_equal(value, case, constants))
    };
    cases.iter().position(is_equal).unwrap_or(cases.len())
}

/// Whether two values are equal as strings, as integers, or, within a small tolerance, as real numbers.
#[expect(clippy::cast_precision_loss, reason = "constants are small, and larger integers are compared as well")]
fn are_equal(left: &Value, right: &Value, constants: &Constants) -> bool {
    match (left, right) {
        (Value::Int(left), Value::Int(right)) => return left == right,
        (Value::Text(left), Value::Text(right)) if left == right => return true,
        _ => {}
    }
    let number = |value: &Value| match value {
        // An integer that is too large to calculate with can be equal to its digits.
        Value::Int(number) => Some(*number as f64),
        Value::Real(number) => Some(*number),
        Value::Text(text) => constants
            .get(&**text)
            .map(|number| *number as f64)
            .or_else(|| text.parse().ok().filter(|_| !text.starts_with('+'))),
        Value::List(_) => None,
    };
    let equal = |(left, right): (f64, f64)| (left - right).abs() <= f64::from(f32::EPSILON);
    number(left).zip(number(right)).is_some_and(equal)
}

impl Loop {
    /// Takes the first item from the queue and writes it.
    fn read(&self, board: &mut Blackboard, starts: bool) -> Result<PortReading, ReadError> {
        if starts {
            // A queue in the file is copied again only now, because the loop may have emptied or abandoned its previous
            // copy.
            *board.memo(self.memo) = match &self.queue {
                Input::Constant(constant) => Some(self.copy(constant)?),
                Input::Entry(..) => None,
            };
        }
        let is_unread = board.memo(self.memo).is_none();
        let first = match &self.queue {
            Input::Entry(slot, name) if !matches!(board.value(*slot), Some(Value::List(_))) => {
                match board.value(*slot) {
                    Some(Value::Text(text)) if is_unread => {
                        let copy = self.copy(&Value::Text(text.clone()))?;
                        *board.memo(self.memo) = Some(copy);
                    }
                    Some(Value::Text(_)) => {}
                    Some(other) => return Err(ValueError::new(other, "a queue").into()),
                    None if board.exists(*slot) => return Err(ReadError::Empty(name.clone())),
                    None => {}
                }
                board.memo(self.memo).as_mut().and_then(VecDeque::pop_front)
            }
            Input::Entry(slot, _) => match board.value_mut(*slot) {
                Some(Value::List(items)) => items.pop_front(),
                _ => None,
            },
            Input::Constant(_) => board.memo(self.memo).as_mut().and_then(VecDeque::pop_front),
        };
        let Some(first) = first else { return Ok(PortReading::Status(self.if_empty.status(board)?)) };
        if let Some(slot) = self.value {
            board.write(slot, first, &self.item.type_of(), true)?;
        }
        Ok(PortReading::Proceed)
    }

    fn copy(&self, value: &Value) -> Result<VecDeque<Value>, ReadError> {
        match Type::List(Box::new(self.item.type_of())).convert(value)? {
            Value::List(items) => Ok(items),
            other => Err(ValueError::new(other, "a queue").into()),
        }
    }
}

impl Item {
    pub(crate) fn type_of(self) -> Type {
        match self {
            Self::Int => Type::INT,
            Self::Bool => Type::Bool,
            Self::Double => Type::Real,
            Self::Text => Type::Text,
        }
    }
}
