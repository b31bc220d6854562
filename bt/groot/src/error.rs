//! Why a request to a program fails.

use crate::zmtp::ZmtpError;

/// Why a request has no valid reply.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GrootError {
    /// The connection cannot be established, or has ended.
    #[error("{address}: {source}")]
    Connection {
        /// The address of the program.
        address: String,
        /// What went wrong.
        source: ZmtpError,
    },
    /// The reply violates the protocol.
    #[error("{address} does not follow Groot2's protocol: {problem}")]
    Foreign {
        /// The address of the program.
        address: String,
        /// The violation, in words.
        problem: String,
    },
    /// The program has refused the request.
    #[error("{address} refuses: {reason}")]
    Refused {
        /// The address of the program.
        address: String,
        /// Its reason.
        reason: String,
    },
    /// The blackboards of the program are too large for a reply. The connection has ended.
    #[error("{address} has blackboards of more than {bytes} bytes")]
    LargeBlackboards {
        /// The address of the program.
        address: String,
        /// The maximum size of a reply, in bytes.
        bytes: usize,
    },
    /// The program shows a different tree than before.
    #[error("{address} shows another tree than before")]
    OtherTree {
        /// The address of the program.
        address: String,
    },
}
