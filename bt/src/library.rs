//! The contents of files, as data: trees as lists of nodes, and the models of nodes. `xml` reads and writes them.

mod model;

use miette::SourceSpan;

pub(crate) use model::{Kept, Model, Models, PortModel};

use crate::Kind;

/// The contents of files: their trees, and their declarations of nodes.
#[derive(Debug, Default)]
pub(crate) struct Library {
    /// The effective trees: of several with one ID, that of the including file.
    pub(crate) definitions: Vec<Definition>,
    pub(crate) models: Models,
    /// The main file's root attributes besides its format and its main tree, and the namespaces of all files.
    pub(crate) kept: Kept,
}

impl Library {
    pub(crate) fn model(&self, id: &str) -> Option<&Model> {
        self.models.get(id)
    }
}

/// A `<BehaviorTree>`.
#[derive(Debug)]
pub(crate) struct Definition {
    pub(crate) id: Option<String>,
    /// The element's attributes besides its ID.
    pub(crate) kept: Kept,
    pub(crate) span: SourceSpan,
    /// The index of its file.
    pub(crate) file: usize,
    /// In document order, the root first; empty if the tree has no root.
    pub(crate) nodes: Vec<Scanned>,
}

/// A node in the file.
#[derive(Debug)]
pub(crate) struct Scanned {
    pub(crate) kind: Kind,
    pub(crate) type_id: String,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) span: SourceSpan,
    /// Its index in the list of its tree.
    pub(crate) parent: Option<usize>,
}

impl Scanned {
    /// The attributes that are kept: all except those that identify the node.
    pub(crate) fn kept_attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        let kept = self.attributes.iter().filter(|attribute| attribute.name != "ID");
        kept.map(|attribute| (attribute.name.as_str(), attribute.value.as_str()))
    }

    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.value.as_str())
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub(crate) name: String,
    /// The name in the file: some ports had other names in version 3.
    pub(crate) written: String,
    pub(crate) value: String,
    /// The position of the whole attribute.
    pub(crate) span: SourceSpan,
    /// The position of the value, between the quotes.
    pub(crate) value_span: SourceSpan,
    /// Whether the value is written literally, without entities such as `&lt;`.
    pub(crate) is_plain: bool,
}
