//! Loading BehaviorTree.CPP's XML, formats 3 and 4, and writing format 4.
//!
//! A file is read in three steps, each of which continues after a problem and reports them all: the document is parsed
//! with all its includes ([`document`]), every tree is scanned into a flat list of nodes ([`scan`]), and the main tree
//! is assembled with its subtrees ([`assemble`]).

mod assemble;
mod cases;
mod compile;
mod document;
mod elements;
mod entries;
mod instances;
mod kept;
mod layout;
mod loader;
mod model;
mod nav2;
mod ports;
mod problems;
mod scan;
mod source_file;
mod unknown;
mod vocabulary;
mod warnings;
mod write;

use std::io;
use std::path::Path;

use diagnostics::text_from_disk;

pub use layout::layout;
pub use loader::Loader;
pub use ports::{BuiltinPort, PortForm, builtin_ports};
pub use vocabulary::{attributes_of, elements_in, node_attributes};

use crate::{Tree, TreeError};

impl Loader {
    /// Loads the main tree from the text of a file. The file's name is only used in diagnostics; no file is opened, and
    /// a file that includes others is refused.
    ///
    /// # Errors
    /// A [`TreeError`] with all problems of the file, each with its location.
    pub fn load(&self, file: impl AsRef<Path>, text: &str) -> Result<Tree, TreeError> {
        let refuse = |_: &Path| Err(io::Error::other("no other file may be opened here"));
        self.load_with(file, text, refuse)
    }

    /// Loads the main tree from the text of a file. The text of each included file comes from `read`, which gets its
    /// path: the `path` of the `<include>`, relative to the including file.
    ///
    /// If trees in several files have the same ID, the one in the including file is used.
    ///
    /// # Errors
    /// A [`TreeError`] with all problems of the files, each with its location.
    pub fn load_with(
        &self,
        file: impl AsRef<Path>,
        text: &str,
        read: impl Fn(&Path) -> io::Result<String>,
    ) -> Result<Tree, TreeError> {
        document::load(self, file.as_ref(), text, &read)
    }

    /// Opens a file and loads the main tree from it, with all files that it includes.
    ///
    /// # Errors
    /// A [`TreeError`] with all problems of the files, each with its location; also if the file itself cannot be read.
    pub fn load_file(&self, file: impl AsRef<Path>) -> Result<Tree, TreeError> {
        let file = file.as_ref();
        match text_from_disk(file) {
            Ok(text) => self.load_with(file, &text, text_from_disk),
            Err(error) => Err(document::unreadable(file, &error)),
        }
    }
}

impl Tree {
    /// Loads the main tree of a file in BehaviorTree.CPP's XML, format 3 or 4. See [`Loader`] for options.
    ///
    /// # Errors
    /// A [`TreeError`] with all problems of the file, each with its location.
    pub fn from_xml(file: impl AsRef<Path>, text: &str) -> Result<Self, TreeError> {
        Loader::default().load(file, text)
    }
}
