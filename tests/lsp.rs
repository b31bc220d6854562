//! `steward lsp`, as an editor talks to it.

mod client;
mod completion;
mod diagnostics;
mod edits;
mod mappings;
mod names;
mod sessions;

use client::Editor;
