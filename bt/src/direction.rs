//! The directions of ports.

/// The direction of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// The node reads it.
    Input,
    /// The node writes it.
    Output,
    /// The node does both.
    InOut,
}

impl Direction {
    /// The element that declares a port of this direction in a `<TreeNodesModel>`.
    #[must_use]
    pub fn element(self) -> &'static str {
        match self {
            Self::Input => "input_port",
            Self::Output => "output_port",
            Self::InOut => "inout_port",
        }
    }
}
