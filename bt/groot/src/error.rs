//! Why a program cannot be asked about its tree.

use crate::zmtp::ZmtpError;

/// Why a question has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GrootError {
    /// The connection cannot be made, or is over.
    #[error("{address}: {source}")]
    Connection {
        /// The address of the program.
        address: String,
        /// What went wrong.
        source: ZmtpError,
    },
    /// The answer cannot be understood.
    #[error("{address} does not speak Groot2's protocol: {problem}")]
    Foreign {
        /// The address of the program.
        address: String,
        /// What in the answer cannot be so.
        problem: String,
    },
    /// The program refuses to answer.
    #[error("{address} refuses: {reason}")]
    Refused {
        /// The address of the program.
        address: String,
        /// Its reason.
        reason: String,
    },
    /// The blackboards of the program are too large for a reply. The connection is over.
    #[error("{address} has blackboards of more than {bytes} bytes")]
    LargeBlackboards {
        /// The address of the program.
        address: String,
        /// The most bytes of a reply.
        bytes: usize,
    },
    /// The program shows another tree than before.
    #[error("{address} shows another tree than before")]
    OtherTree {
        /// The address of the program.
        address: String,
    },
}
