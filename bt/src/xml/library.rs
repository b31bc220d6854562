//! What files say: trees as lists of nodes, and models.

use miette::SourceSpan;

use super::kept::Kept;
use super::model::{Model, Models};
use crate::Kind;

/// All that files say: their trees, and what they declare of nodes.
#[derive(Debug, Default)]
pub(crate) struct Library {
    /// The trees that count: of several with one ID, that of the including file.
    pub(crate) definitions: Vec<Definition>,
    pub(super) models: Models,
    /// What the main file's root says besides its format and its main tree, and the namespaces of all files.
    pub(super) kept: Kept,
}

impl Library {
    /// What is declared or known of an ID.
    pub(crate) fn model(&self, id: &str) -> Option<&Model> {
        self.models.get(id)
    }
}

/// A `<BehaviorTree>`.
#[derive(Debug)]
pub(crate) struct Definition {
    pub(crate) id: Option<String>,
    /// What the element says besides its ID.
    pub(super) kept: Kept,
    pub(super) span: SourceSpan,
    /// In which of the files.
    pub(super) file: usize,
    /// In document order, the root first; none where it has no root.
    pub(crate) nodes: Vec<Scanned>,
}

/// A node as the file has it.
#[derive(Debug)]
pub(crate) struct Scanned {
    pub(crate) kind: Kind,
    pub(crate) type_id: String,
    pub(super) attributes: Vec<Attribute>,
    pub(super) span: SourceSpan,
    /// Its place in the list of its tree.
    pub(crate) parent: Option<usize>,
}

impl Scanned {
    /// The attributes that are kept: all but those that spell out what the node is.
    pub(crate) fn kept_attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        let kept = self.attributes.iter().filter(|attribute| attribute.name != "ID");
        kept.map(|attribute| (attribute.name.as_str(), attribute.value.as_str()))
    }

    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.value.as_str())
    }
}

/// An attribute of a node.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub(super) name: String,
    /// The name in the file: version 3 called some ports otherwise.
    pub(super) written: String,
    pub(super) value: String,
    /// Of all of it.
    pub(super) span: SourceSpan,
    /// Of the value, between the quotes.
    pub(super) value_span: SourceSpan,
    /// The value stands in the file as it is, without `&lt;` and its like.
    pub(super) is_plain: bool,
}
