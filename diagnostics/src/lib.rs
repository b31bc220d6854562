//! Files that people write and read: read within limits, refused with all their problems at once, and written
//! completely or not at all.
//!
//! Readers collect [`Problem`]s instead of stopping at the first one. Each has its location in a [`Source`] and states
//! what is accepted there. They are returned together as [`FileProblems`]. For a misspelled name, the [`nearest`] known
//! name is suggested. All of them implement [`miette::Diagnostic`], so a binary can render them with the offending
//! text; line and column are available without a renderer.
//!
//! ```
//! use diagnostics::{FileProblems, Source, did_you_mean};
//!
//! let source = Source::new("robot.conf", "color=red\nspede=3\n");
//! let key = source.span(10..15);
//! let problem = key.problem("unknown key `spede`").with_label("unknown key");
//! let problem = problem.with_help_if(did_you_mean(key.text(), ["color", "speed"]));
//! let problems = FileProblems::none_of(vec![problem]).unwrap_err();
//! assert_eq!(problems.plain(), "robot.conf:2:1: unknown key `spede` (did you mean `speed`?)\n");
//! ```
//!
//! [`text_from_disk`] and [`read_text`] read files, always with a limit. A [`Disk`] also has the unsaved texts of an
//! editor, and a [`Memo`] of what was made of its files. [`write_whole`], [`Unfinished`] and
//! [`Staging`] write them: a file under its final name is always complete. After [`guard_inputs`], none of them
//! overwrites what the process reads.
//!
//! [`markup`] is text as it is written in XML.
//!
//! Features, both on by default: `documents` has the module `document`, which reads TOML and YAML; `xml` has the module
//! `xml`, which explains why a text is not XML, and lays XML out.

mod counted;
mod disk;
#[cfg(feature = "documents")]
pub mod document;
mod error;
mod files;
mod line_ends;
pub mod markup;
mod memo;
mod nearest;
mod normal_path;
mod output;
mod overwriting;
mod parts;
mod problem;
mod seconds;
mod source;
#[cfg(feature = "xml")]
pub mod xml;

pub use counted::counted;
pub use disk::{Disk, FileStamp, Reads};
pub use error::Error;
pub use files::{
    ReadFile, from_disk, from_disk_or_pipe, from_disk_up_to, open_regular, read_text, text, text_from_disk,
};
pub use line_ends::LineEnds;
pub use memo::{Memo, Same};
pub use nearest::{MAX_HINTS, did_you_mean, nearest, nearest_or_all};
pub use normal_path::normal;
pub use output::{Staging, Unfinished, rewrite_whole, write_whole};
pub use overwriting::{
    check_unread, check_unread_in, files_read, guard_inputs, reading, would_be_overwritten, writing,
};
pub use parts::{Part, PartsOfText, parts, parts_by_text};
pub use problem::{FileProblems, Problem};
pub use seconds::seconds;
pub use source::{ASSIGNMENT, Source, Span, Spanned};
