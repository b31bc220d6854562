//! What is wrong with a file, whatever its kind: everything that `steward check` finds.
//!
//! A [`FileKind`] follows from a file's name and contents. [`examine`] checks a file of any kind, saved or open in an
//! editor, and [`findings`] are the results by the files in which they are. [`named_files`] loads what a command names,
//! and a [`System`] is what properties are about.

mod check;
mod checked;
mod file_kind;
pub mod findings;
mod language;
pub mod named_files;
mod system;
mod toml_subject;

pub use check::{Examined, examine};
pub use checked::Checked;
pub use file_kind::FileKind;
pub use language::Language;
pub use system::System;
pub use toml_subject::Toml;
