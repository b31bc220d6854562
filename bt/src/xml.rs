//! Loading BehaviorTree.CPP's XML, formats 3 and 4, and writing format 4.
//!
//! A file is read in three steps, each of which goes on after a problem and reports them all: the document is parsed,
//! with all that it includes ([`document`]), every tree in it is scanned into a flat list of nodes ([`scan`]), and the
//! main tree is put together with its subtrees ([`assemble`]).

mod assemble;
mod compile;
mod document;
mod kept;
mod model;
mod ports;
mod problems;
mod scan;
mod unknown;
mod vocabulary;
mod write;

use std::collections::BTreeSet;
use std::io;
use std::path::Path;
use std::sync::Arc;

use diagnostics::{MAX_HINTS, Problem, nearest, text_from_disk};
use miette::SourceSpan;

pub(crate) use document::Library;

use crate::settings::Constants;
use crate::{Tree, TreeError};

/// Reads tree files.
///
/// Both spellings of nodes are read: `<Action ID="GoTo"/>` and `<GoTo/>`, `<Control ID="Sequence">` and `<Sequence>`.
/// The short spelling of a leaf needs to be told what the leaf is: by the file's `<TreeNodesModel>`, or by
/// [`leaves`](Self::leaves). What means nothing here (a description, what Groot notes down) is kept. What
/// BehaviorTree.CPP 4 refuses when it loads a tree is refused: IDs with a space or another forbidden character, two subtrees
/// of one name in a tree, ports that no model declares, ports of two types that name one entry. In files of version 3, whose
/// models are notes of Groot's, a port that they do not declare is a warning, as is an attribute that is no script
/// ([`Tree::concerns`]).
///
/// All trees of a file are checked, also those that the main tree does not use.
///
/// ```
/// use bt::Loader;
///
/// let text = r#"<root BTCPP_format="4"> <BehaviorTree ID="Greet">
///     <Sequence> <SomebodyThere/> <SayHello/> </Sequence>
/// </BehaviorTree> </root>"#;
/// let tree = Loader::default().leaves(["SomebodyThere", "SayHello"]).load("greet.xml", text)?;
/// assert_eq!(tree.to_string(), "→*\n  SomebodyThere\n  SayHello\n");
/// # Ok::<(), bt::TreeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Loader {
    leaves: BTreeSet<String>,
    constants: Arc<Constants>,
    main_tree: Option<String>,
    max_depth: usize,
    max_nodes: usize,
}

impl Default for Loader {
    fn default() -> Self {
        let (leaves, constants) = (BTreeSet::new(), Arc::default());
        Self { leaves, constants, main_tree: None, max_depth: 256, max_nodes: 100_000 }
    }
}

impl Loader {
    /// Knows leaves of these IDs, so that `<ID/>` is an action where the file itself does not say what it is.
    #[must_use]
    pub fn leaves(mut self, ids: impl IntoIterator<Item: Into<String>>) -> Self {
        self.leaves.extend(ids.into_iter().map(Into::into));
        self
    }

    /// Knows these names for numbers in scripts and switches, as BehaviorTree.CPP knows the enumerators that a program
    /// registers.
    #[must_use]
    pub fn constants(mut self, constants: impl IntoIterator<Item = (impl Into<String>, i64)>) -> Self {
        let constants = constants.into_iter().map(|(name, number)| (name.into(), number));
        Arc::make_mut(&mut self.constants).extend(constants);
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

    /// Loads the main tree from the text of a file. The file's name serves diagnostics only; nothing is opened, and a
    /// file that includes others is refused.
    ///
    /// # Errors
    /// A [`TreeError`] with everything that is wrong with the file, each with its place.
    pub fn load(&self, file: impl AsRef<Path>, text: &str) -> Result<Tree, TreeError> {
        let refuse = |_: &Path| Err(io::Error::other("no other file is opened here"));
        self.load_with(file, text, refuse)
    }

    /// Loads the main tree from the text of a file, and gets the text of each file that it includes from `read`: by its
    /// path, which is that of the including file with the `path` of the `<include>` at its end.
    ///
    /// Where trees of several files have the same ID, that of the including file counts.
    ///
    /// # Errors
    /// A [`TreeError`] with everything that is wrong with the files, each with its place.
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
    /// A [`TreeError`] with everything that is wrong with the files, each with its place; also if the file itself cannot
    /// be read.
    pub fn load_file(&self, file: impl AsRef<Path>) -> Result<Tree, TreeError> {
        let file = file.as_ref();
        match text_from_disk(file) {
            Ok(text) => self.load_with(file, &text, text_from_disk),
            Err(error) => Err(document::unreadable(file, &error)),
        }
    }
}

/// Where the value of an attribute stands, without its quotes.
fn value_span(element: roxmltree::Node<'_, '_>, attribute: &str) -> Option<SourceSpan> {
    element.attribute_node(attribute).map(|attribute| span(attribute.range_value()))
}

/// The ID of an element that must have one.
fn required_id(element: roxmltree::Node<'_, '_>, meaning: &str, problems: &mut Problems) -> Option<String> {
    match element.attribute("ID").map(str::trim) {
        Some(id) if !id.is_empty() => Some(id.to_owned()),
        _ => {
            let problem = Problem::new(format!("<{}> has no ID", element.tag_name().name()));
            let problem = problem.at(tag_span(element), "needs ID=\"…\"");
            problems.push(problem.with_help(format!("the ID says {meaning}")));
            None
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
    if let Some(near) = near(unknown, known.clone(), problems) {
        return Some(format!("did you mean `{near}`?"));
    }
    (problems < MAX_HINTS && known.clone().next().is_some()).then(|| format!("there is {}", listed(known)))
}

/// The name that one was probably meant to be.
fn near<'a>(unknown: &str, known: impl Iterator<Item = &'a str>, problems: usize) -> Option<&'a str> {
    if problems < MAX_HINTS { nearest(unknown, known) } else { None }
}

/// The names in a sentence; of very many, the first.
fn listed<'a>(mut names: impl Iterator<Item = &'a str>) -> String {
    let mut quoted: Vec<String> = names.by_ref().take(10).map(|name| format!("`{name}`")).collect();
    quoted.extend(names.next().map(|_| "…".to_owned()));
    quoted.join(", ")
}

/// After so many problems, a file is not read on.
const MAX_PROBLEMS: usize = 100_000;

/// So many attributes an element may have, and so many ports a node.
const MAX_ATTRIBUTES: usize = 1000;
const MAX_PORTS: usize = MAX_ATTRIBUTES;

/// The problems found so far.
type Problems = Vec<Problem>;
