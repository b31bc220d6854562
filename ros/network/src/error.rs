//! Why a robot cannot be reached.

/// Why there is no connection.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not the address of a bridge.
    #[error("{0} is not the address of a bridge")]
    Address(String),
    /// The connection would need encryption.
    #[error("{0} requires an encrypted connection, which this program cannot open")]
    Encrypted(String),
    /// Nothing answers at the address, or a server with another protocol.
    #[error("{address} does not answer as a Foxglove bridge: {reason}")]
    Silent {
        /// The address.
        address: String,
        /// What went wrong.
        reason: String,
    },
}

impl Error {
    /// How to fix it.
    #[must_use]
    pub fn help(&self) -> &'static str {
        match self {
            Self::Address(_) => "for example `ws://robot.local:8765`",
            Self::Encrypted(_) => {
                "forward the port: `ssh -L 8765:localhost:8765 ROBOT`, and name `ws://localhost:8765`"
            }
            Self::Silent { .. } => "start it on the robot: `ros2 launch foxglove_bridge foxglove_bridge_launch.xml`",
        }
    }
}
