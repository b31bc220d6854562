//! Files as people edit them: checked after every edit, completed and explained.

mod answers;
mod expressions;
mod knowledge;
mod leaf_words;
mod machine_words;
mod name_index;
mod paths;
mod project;
pub mod proposal;
mod quick_fix;
mod rename;
mod scope_place;
mod scope_words;
mod text;
mod toml_keys;
mod toml_place;
mod tree_words;
mod xml_place;

pub use answers::EditedFile;
pub use name_index::{Mention, NameIndex, NameKind};
pub use project::{CheckedDocuments, Documents, FileContext, Project};
pub use quick_fix::{QuickFix, quick_fix};
pub use rename::{Renaming, rename};
pub use text::{Position, TextLines, Unit};
