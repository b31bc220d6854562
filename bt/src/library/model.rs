//! The model of a node: its category and its ports, as a file or Nav2's model declares them.

use std::collections::BTreeMap;

use miette::SourceSpan;

use crate::blackboard::Type;
use crate::{Category, Direction};

/// Attributes that have no meaning here, but are kept so that they can be written back: by their names as written, in
/// the order of the file.
pub(crate) type Kept = Vec<(String, String)>;

/// The declaration of a node's ID.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Model {
    pub(crate) category: Category,
    pub(crate) ports: Vec<PortModel>,
    /// The index of each port.
    pub(crate) places: BTreeMap<String, usize>,
    /// Whether a `<TreeNodesModel>` or Nav2's model declares it with all its ports; otherwise it is only used as a node
    /// of this category.
    pub(crate) is_declared: bool,
    /// Other contents of the declaration: attributes, and elements such as `<MetadataFields>` and `<description>`.
    pub(crate) kept: Kept,
    pub(crate) notes: Vec<String>,
    /// The position of its declaration or first use, and the index of the file; none in Nav2's model.
    pub(crate) declared: Option<(usize, SourceSpan)>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PortModel {
    pub(crate) name: String,
    pub(crate) direction: Direction,
    pub(crate) of: Type,
    /// The type's name in the file.
    pub(crate) type_name: Option<String>,
    pub(crate) default: Option<String>,
    pub(crate) description: String,
    pub(crate) kept: Kept,
}

impl Model {
    /// A model without a declaration.
    pub(crate) fn of(category: Category) -> Self {
        Self {
            category,
            ports: Vec::new(),
            places: BTreeMap::new(),
            is_declared: false,
            kept: Kept::new(),
            notes: Vec::new(),
            declared: None,
        }
    }

    /// Whether it is from Nav2's model, because no file declares the node.
    pub(crate) fn is_of_nav2(&self) -> bool {
        self.declared.is_none()
    }

    /// Whether it contains more than the category.
    pub(crate) fn declares_more(&self) -> bool {
        !self.ports.is_empty() || !self.notes.is_empty() || self.kept.iter().any(|(name, _)| name != "editable")
    }

    pub(crate) fn port(&self, name: &str) -> Option<&PortModel> {
        self.places.get(name).map(|place| &self.ports[*place])
    }

    pub(crate) fn add(&mut self, port: PortModel) {
        self.places.entry(port.name.clone()).or_insert(self.ports.len());
        self.ports.push(port);
    }
}

pub(crate) type Models = BTreeMap<String, Model>;
