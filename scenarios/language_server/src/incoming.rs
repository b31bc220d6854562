//! What the thread that answers waits for.

use editor::CheckedDocuments;
use lsp_server::Message;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// What the thread that answers waits for.
pub(crate) enum Incoming {
    Message(Message),
    /// The editor has closed the connection.
    End,
    Checked(CheckResult),
}

pub(crate) struct CheckResult {
    /// The number of the edit after which it was made.
    pub(crate) edit: u64,
    /// Nothing if the check failed, with the reason.
    pub(crate) found: Result<CheckedDocuments, String>,
}

/// The parameters of a message; nothing if they are not those of the protocol.
pub(crate) fn parsed<T: DeserializeOwned>(params: Value) -> Option<T> {
    serde_json::from_value(params).ok()
}
