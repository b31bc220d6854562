//! What the thread that answers waits for.

use editor::CheckedDocuments;
use lsp_server::Message;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// What the thread that answers waits for.
pub(super) enum Incoming {
    Message(Message),
    /// The editor has closed the connection.
    End,
    Checked(CheckResult),
}

pub(super) struct CheckResult {
    /// The number of the edit after which it was made.
    pub(super) edit: u64,
    /// Nothing if the check failed, with the reason.
    pub(super) found: Result<CheckedDocuments, String>,
}

/// The parameters of a message; nothing if they are not those of the protocol.
pub(super) fn parsed<T: DeserializeOwned>(params: Value) -> Option<T> {
    serde_json::from_value(params).ok()
}
