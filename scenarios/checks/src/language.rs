//! The languages of files that have a layout.

use std::path::Path;

use campaigns::Error;
use diagnostics::{text_from_disk, xml};

/// The languages that have a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// BehaviorTree.CPP's XML.
    Tree,
    /// SCXML.
    Machine,
    /// SCOPE.
    Properties,
}

impl Language {
    /// By the ending of a file's name.
    #[must_use]
    pub fn of_name(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "xml" => Some(Self::Tree),
            "scxml" => Some(Self::Machine),
            "scope" => Some(Self::Properties),
            _ => None,
        }
    }

    /// By the contents.
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        match xml::root_name(text) {
            None => Self::Properties,
            Some(name) if name.ends_with("scxml") => Self::Machine,
            Some(_) => Self::Tree,
        }
    }

    /// The layout of a text. Files that it names are beside the one with this name.
    ///
    /// # Errors
    /// If the text cannot be parsed.
    pub fn layout(self, path: &Path, text: &str) -> Result<String, Error> {
        let name = path.display().to_string();
        match self {
            Self::Tree => bt::layout(path, text, text_from_disk).map_err(Error::bad_input),
            Self::Machine => skills::layout(&name, text, path.parent()).map_err(Error::bad_input),
            Self::Properties => monitors::layout(&name, text).map_err(Error::bad_input),
        }
    }
}
