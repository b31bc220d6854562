//! Leaves: what a tree calls, and what they can see of the tree.

use std::time::Duration;

use crate::blackboard::{Blackboard, Value};
use crate::program::LeafPort;
use crate::settings::ReadError;
use crate::{Direction, Node, NodeId, Status, Tree};

/// The leaves of a tree, if they answer at once.
pub trait Leaves {
    /// Ticks a leaf: it continues, and returns its status.
    fn tick(&mut self, leaf: Leaf<'_>) -> Status;

    /// Halts a leaf that was running.
    fn halt(&mut self, leaf: Leaf<'_>);
}

/// A leaf during a call, with its ports.
///
/// A port is an attribute of the leaf in the file. Its value is a constant, or an entry of the blackboard: `{key}`. Its
/// type and its default are declared in the file's `<TreeNodesModel>`.
#[derive(Debug)]
pub struct Leaf<'a> {
    pub(crate) id: NodeId,
    pub(crate) tree: &'a Tree,
    pub(crate) board: &'a mut Blackboard,
    pub(crate) now: Duration,
}

/// An error of a port.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PortError {
    /// The leaf has no such port: neither the file nor its model contains it.
    #[error("`{leaf}` has no port `{port}`")]
    Missing {
        /// The leaf's ID.
        leaf: String,
        /// The port.
        port: String,
    },
    /// The port is not connected to a blackboard entry, so it cannot be written.
    #[error("the port `{port}` of `{leaf}` is not connected to a blackboard entry")]
    NoEntry {
        /// The leaf's ID.
        leaf: String,
        /// The port.
        port: String,
    },
    /// Its value is missing or of another type.
    #[error("the port `{port}` of `{leaf}`: {message}")]
    Value {
        /// The leaf's ID.
        leaf: String,
        /// The port.
        port: String,
        /// The problem.
        message: String,
    },
}

impl<'a> Leaf<'a> {
    /// The leaf's number.
    #[must_use]
    pub fn id(&self) -> NodeId {
        self.id
    }

    /// The leaf's node in the tree.
    #[must_use]
    pub fn node(&self) -> &'a Node {
        self.tree.node(self.id)
    }

    /// The time of the run.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.now
    }

    /// Reads a port.
    ///
    /// # Errors
    /// [`PortError::Missing`] if there is no port with this name; [`PortError::Value`] if it has no value or one of the
    /// wrong type.
    pub fn input(&self, port: &str) -> Result<Value, PortError> {
        let missing = || PortError::Missing { leaf: self.node().type_id().to_owned(), port: port.to_owned() };
        let found = self.tree.program.leaf_ports(self.id).get(port);
        let (of, input) = found.and_then(|port| Some((&port.of, port.input.as_ref()?))).ok_or_else(missing)?;
        input.read(self.board, of).map_err(|error: ReadError| self.value_error(port, &error))
    }

    /// Reads all input and in-out ports, in alphabetical order.
    pub fn inputs(&self) -> impl Iterator<Item = (&'a str, Result<Value, PortError>)> {
        let ports = self.tree.program.leaf_ports(self.id).iter();
        let is_input = |port: &LeafPort| port.direction != Direction::Output && port.input.is_some();
        ports.filter(move |(_, port)| is_input(port)).map(|(name, _)| (name.as_str(), self.input(name)))
    }

    /// Writes a port.
    ///
    /// # Errors
    /// [`PortError::Missing`] if there is no port with this name; [`PortError::NoEntry`] if it is a constant;
    /// [`PortError::Value`] if the entry has another type.
    pub fn output(&mut self, port: &str, value: impl Into<Value>) -> Result<(), PortError> {
        let (leaf, port) = (self.node().type_id().to_owned(), port.to_owned());
        let found = self.tree.program.leaf_ports(self.id).get(&port).filter(|port| port.input.is_some());
        let Some(found) = found else { return Err(PortError::Missing { leaf, port }) };
        let Some(slot) = found.entry() else { return Err(PortError::NoEntry { leaf, port }) };
        self.board.write(slot, value.into(), &found.of, found.is_own).map_err(|error| self.value_error(&port, &error))
    }

    fn value_error(&self, port: &str, error: &dyn std::error::Error) -> PortError {
        let leaf = self.node().type_id().to_owned();
        PortError::Value { leaf, port: port.to_owned(), message: error.to_string() }
    }
}
