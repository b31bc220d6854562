//! Ways through a port.

/// Which way things go through a port.
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
    /// The element that declares such a port in a `<TreeNodesModel>`.
    #[must_use]
    pub fn element(self) -> &'static str {
        match self {
            Self::Input => "input_port",
            Self::Output => "output_port",
            Self::InOut => "inout_port",
        }
    }
}
