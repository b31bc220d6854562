//! The ports of leaves, and the values that pass through them while a tree runs: from the blackboard to a leaf with
//! each tick, and back with each answer.

use channels::{FieldKind, Value as Field};

use crate::blackboard::{Blackboard, Slot, Type, Value};
use crate::program::LeafPort;
use crate::settings::Input;
use crate::{Direction, NodeId, PortError, Tree};

/// A port of a leaf, as the file connects it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port<'t> {
    /// Its name.
    pub name: &'t str,
    /// Its direction: in and out, if no model declares it.
    pub direction: Direction,
    /// Its type; [`Type::Any`] if no model declares one.
    pub of: &'t Type,
    /// Its source.
    pub source: Source<'t>,
}

/// The source of a port's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source<'t> {
    /// The constant in the file, converted to the port's type.
    Constant(&'t Value),
    /// The blackboard entry with this key.
    Entry(&'t str),
    /// None: the model declares the port, but the file does not connect it.
    Nothing,
}

impl Tree {
    /// The ports of a leaf, in alphabetical order: its attributes, and all ports that its model declares.
    ///
    /// # Panics
    /// If the node is not a leaf of this tree.
    pub fn ports(&self, leaf: NodeId) -> impl Iterator<Item = Port<'_>> {
        self.program.leaf_ports(leaf).iter().map(|(name, port)| Port {
            name,
            direction: port.direction,
            of: &port.of,
            source: match &port.input {
                Some(Input::Constant(value)) => Source::Constant(value),
                Some(Input::Entry(_, key)) => Source::Entry(key),
                None => Source::Nothing,
            },
        })
    }
}

/// The ports of a leaf whose values travel in messages, in alphabetical order.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Traffic {
    leaf: String,
    inputs: Vec<Lane>,
    outputs: Vec<Lane>,
}

/// A port, and its blackboard entry; outputs need not have one.
#[derive(Debug, PartialEq, Eq)]
struct Lane {
    port: String,
    of: Type,
    entry: Option<Slot>,
    is_own: bool,
}

impl Traffic {
    pub(crate) fn of(tree: &Tree, leaf: NodeId) -> Self {
        let is_input = |port: &LeafPort| port.direction != Direction::Output && port.entry().is_some();
        // A skill may write to every declared output; if the file does not connect it, the value is dropped.
        let is_output =
            |port: &LeafPort| port.direction != Direction::Input && (port.is_declared || port.entry().is_some());
        let lanes = |goes: &dyn Fn(&LeafPort) -> bool| {
            let ports = tree.program.leaf_ports(leaf).iter().filter(|(_, port)| goes(port));
            let lane = |(name, port): (&String, &LeafPort)| {
                let LeafPort { of, is_own, .. } = port.clone();
                Lane { port: name.clone(), of, entry: port.entry(), is_own }
            };
            ports.map(lane).collect()
        };
        Self { leaf: tree.node(leaf).process().to_owned(), inputs: lanes(&is_input), outputs: lanes(&is_output) }
    }

    /// Whether the leaf reads from the blackboard.
    pub(crate) fn reads(&self) -> bool {
        !self.inputs.is_empty()
    }

    /// Whether the leaf may write to the blackboard.
    pub(crate) fn writes(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// The fields after `<tick>`.
    pub(crate) fn input_fields(&self) -> impl Iterator<Item = (String, FieldKind)> {
        self.inputs.iter().map(Lane::field)
    }

    /// The fields after an answer.
    pub(crate) fn output_fields(&self) -> impl Iterator<Item = (String, FieldKind)> {
        self.outputs.iter().map(Lane::field)
    }

    /// The current values of the inputs.
    pub(crate) fn read(&self, board: &Blackboard) -> Result<Vec<Field>, PortError> {
        self.inputs.iter().map(|lane| lane.read(board).map_err(|message| self.error(lane, message))).collect()
    }

    /// Writes the fields after an answer. A failure does not prevent the other writes.
    pub(crate) fn write(&self, fields: &[Field], board: &mut Blackboard) -> Result<(), PortError> {
        let mut failed = Ok(());
        for (lane, field) in self.outputs.iter().zip(fields) {
            if let Err(message) = lane.write(field, board) {
                failed = failed.and(Err(self.error(lane, message)));
            }
        }
        failed
    }

    fn error(&self, lane: &Lane, message: String) -> PortError {
        PortError::Value { leaf: self.leaf.clone(), port: lane.port.clone(), message }
    }
}

impl Lane {
    /// Messages have the types that ports declare; anything that is not a number or Boolean is text.
    fn field(&self) -> (String, FieldKind) {
        let kind = match self.of {
            Type::Bool => FieldKind::Bool,
            Type::Int { .. } => FieldKind::Int,
            Type::Real | Type::Float => FieldKind::Real,
            _ => FieldKind::Text,
        };
        (self.port.clone(), FieldKind::Optional(Box::new(kind)))
    }

    /// An entry without a value is `<none>`.
    fn read(&self, board: &Blackboard) -> Result<Field, String> {
        let Some(value) = self.entry.and_then(|entry| board.value(entry)) else {
            return Ok(Field::symbol(FieldKind::NONE));
        };
        let field = match self.of {
            Type::Bool => self.of.convert(value).and_then(|value| value.to_bool()).map(Field::Bool),
            Type::Int { .. } => self.of.convert(value).and_then(|value| value.to_int()).map(Field::Int),
            Type::Real | Type::Float => self.of.convert(value).and_then(|value| value.to_real()).map(Field::Real),
            _ => Ok(Field::Text(value.to_text())),
        };
        match field {
            Ok(Field::Real(number)) if number.is_nan() => Err("`NaN` is not a number".to_owned()),
            field => field.map_err(|error| error.to_string()),
        }
    }

    fn write(&self, field: &Field, board: &mut Blackboard) -> Result<(), String> {
        let value = match field {
            Field::Bool(truth) => Value::from(*truth),
            Field::Int(number) => Value::Int(*number),
            Field::Real(number) => Value::Real(*number),
            Field::Text(text) => self.of.parse(text).map_err(|error| error.to_string())?,
            // A lane has no lists.
            Field::Symbol(_) | Field::List(_) => return Ok(()),
        };
        let Some(entry) = self.entry else { return Ok(()) };
        board.write(entry, value, &self.of, self.is_own).map_err(|error| error.to_string())
    }
}
