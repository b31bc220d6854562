//! Files as people edit them: checked by their kinds, saved or not.

mod answers;
pub mod check;
mod expressions;
mod file_kind;
pub mod findings;
mod knowledge;
mod language;
mod leaf_words;
mod machine_words;
mod name_index;
pub mod named_files;
mod paths;
mod project;
pub mod proposal;
mod quick_fix;
mod rename;
mod scope_place;
mod scope_words;
mod system;
mod text;
mod toml_keys;
mod toml_place;
mod toml_subject;
mod tree_words;
mod xml_place;

pub use answers::EditedFile;
pub use file_kind::FileKind;
pub use language::Language;
pub use name_index::{Mention, NameIndex, NameKind};
pub use project::{CheckedDocuments, Documents, FileContext, Project};
pub use quick_fix::{QuickFix, quick_fix};
pub use rename::{Renaming, rename};
pub use system::System;
pub use text::{Position, TextLines, Unit};
pub use toml_subject::Toml;
