//! Loading BehaviorTree.CPP's XML, formats 3 and 4.
//!
//! A file is read in three steps, each of which goes on after a problem and reports them all: the document is parsed
//! ([`document`]), every tree in it is scanned into a flat list of nodes ([`scan`]), and the main tree is put together
//! with its subtrees ([`assemble`]).

mod assemble;
mod document;
mod scan;
mod vocabulary;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use miette::{NamedSource, SourceSpan};

use crate::{Problem, Tree, TreeError};

/// Reads tree files.
///
/// Both spellings of nodes are read: `<Action ID="GoTo"/>` and `<GoTo/>`, `<Control ID="Sequence">` and `<Sequence>`.
/// The short spelling of a leaf needs to be told what the leaf is: by the file's `<TreeNodesModel>`, or by
/// [`leaves`](Self::leaves). Attributes that mean nothing here (ports, a layout) are kept and ignored; those that would
/// change what a node does and are not supported (`_skipIf`, `_onSuccess` and their like) are refused.
///
/// All trees of a file are checked, also those that the main tree does not use.
#[derive(Clone, Debug)]
pub struct Loader {
    leaves: BTreeSet<String>,
    main_tree: Option<String>,
    max_depth: usize,
    max_nodes: usize,
}

impl Default for Loader {
    fn default() -> Self {
        Self { leaves: BTreeSet::new(), main_tree: None, max_depth: 256, max_nodes: 100_000 }
    }
}

impl Loader {
    /// Knows leaves of these IDs, so that `<ID/>` is an action where the file itself does not say what it is.
    #[must_use]
    pub fn leaves(mut self, ids: impl IntoIterator<Item: Into<String>>) -> Self {
        self.leaves.extend(ids.into_iter().map(Into::into));
        self
    }

    /// Takes this tree for the main tree, whatever the file says.
    #[must_use]
    pub fn main_tree(mut self, id: impl Into<String>) -> Self {
        self.main_tree = Some(id.into());
        self
    }

    /// Refuses trees that are deeper than this, subtrees included. 256 if not set, as in BehaviorTree.CPP.
    #[must_use]
    pub fn max_depth(mut self, nodes: usize) -> Self {
        self.max_depth = nodes;
        self
    }

    /// Refuses trees of more nodes than this, subtrees included. 100 000 if not set.
    #[must_use]
    pub fn max_nodes(mut self, nodes: usize) -> Self {
        self.max_nodes = nodes;
        self
    }

    /// Loads the main tree from the text of a file. The file's name serves diagnostics only; nothing is opened.
    ///
    /// # Errors
    /// A [`TreeError`] with everything that is wrong with the file, each with its place.
    pub fn load(&self, file: impl AsRef<Path>, text: &str) -> Result<Tree, TreeError> {
        let name = file.as_ref().display().to_string();
        let source = NamedSource::new(name, Arc::from(text)).with_language("xml");
        let mut problems = Vec::new();
        let tree = document::read(self, &source, text, &mut problems);
        match tree {
            Some(tree) if problems.is_empty() => Ok(tree),
            _ => Err(TreeError::new(source, problems)),
        }
    }
}

/// Where an element's start tag stands, without its closing bracket: up to its last attribute.
fn tag_span(element: roxmltree::Node<'_, '_>) -> SourceSpan {
    let start = element.range().start;
    let name_end = start + 1 + element.tag_name().name().len();
    let end = element.attributes().map(|attribute| attribute.range().end).max().unwrap_or(name_end);
    span(start..end.max(name_end))
}

fn span(range: std::ops::Range<usize>) -> SourceSpan {
    (range.start, range.len()).into()
}

/// The name that one was probably meant to be, or else all there are, as help. Nothing after very many problems: a
/// hostile file must not keep us searching.
fn hint<'a>(unknown: &str, known: impl Iterator<Item = &'a str> + Clone, problems: usize) -> Option<String> {
    if let Some(near) = nearest(unknown, known.clone(), problems) {
        return Some(format!("did you mean `{near}`?"));
    }
    (problems < MAX_HINTS && known.clone().next().is_some()).then(|| format!("there is {}", listed(known)))
}

/// The name that one was probably meant to be.
fn nearest<'a>(unknown: &str, known: impl Iterator<Item = &'a str>, problems: usize) -> Option<&'a str> {
    if problems >= MAX_HINTS {
        return None;
    }
    let unknown = unknown.to_lowercase();
    let rated = known.take(MAX_NAMES).map(|name| (strsim::jaro_winkler(&unknown, &name.to_lowercase()), name));
    let (likeness, name) = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (likeness > 0.85).then_some(name)
}

/// The names in a sentence; of very many, the first.
fn listed<'a>(mut names: impl Iterator<Item = &'a str>) -> String {
    let mut quoted: Vec<String> = names.by_ref().take(10).map(|name| format!("`{name}`")).collect();
    quoted.extend(names.next().map(|_| "…".to_owned()));
    quoted.join(", ")
}

/// How many problems of a file get a hint.
const MAX_HINTS: usize = 200;

/// How many names a hint is chosen from.
const MAX_NAMES: usize = 1000;

/// The problems found so far.
type Problems = Vec<Problem>;
