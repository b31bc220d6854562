//! What can be wrong with a tree file.

use std::sync::Arc;

use miette::{Diagnostic, NamedSource, SourceSpan};

/// Everything that is wrong with a tree file: the file, and its problems in the order of their places.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("{} cannot be used as a behavior tree", source_code.name())]
pub struct TreeError {
    #[source_code]
    source_code: NamedSource<Arc<str>>,
    #[related]
    problems: Vec<Problem>,
}

impl TreeError {
    pub(crate) fn new(source_code: NamedSource<Arc<str>>, mut problems: Vec<Problem>) -> Self {
        problems.sort_by_key(Problem::offset);
        Self { source_code, problems }
    }

    /// The problems, in the order of their places in the file.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }
}

/// One problem of a tree file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Diagnostic)]
#[non_exhaustive]
pub enum Problem {
    /// It is not XML.
    #[error("this is not well-formed XML: {message}")]
    Xml {
        /// What the XML parser says.
        message: String,
        /// Where it gave up.
        #[label("here")]
        span: SourceSpan,
    },
    /// It declares a document type.
    #[error("a document type declaration is not accepted")]
    #[diagnostic(help("remove it: tree files have no document type and no entities"))]
    DocumentType {
        /// Where it starts.
        #[label("starts here")]
        span: SourceSpan,
    },
    /// The file or the tree with its subtrees is too large.
    #[error("this is too large: more than {limit} nodes")]
    TooLarge {
        /// How many nodes are accepted.
        limit: usize,
        /// The file's start, or the subtree that is one too many.
        #[label("here")]
        span: SourceSpan,
    },
    /// Nodes are nested too deeply.
    #[error("nodes are nested more than {limit} deep")]
    #[diagnostic(help(
        "move a part into a tree of its own, or loosen the nesting; BehaviorTree.CPP has the same limit"
    ))]
    TooDeep {
        /// How deep is accepted.
        limit: usize,
        /// The first node that is too deep.
        #[label("one level too deep")]
        span: SourceSpan,
    },
    /// The outermost element is not `<root>`.
    #[error("the outermost element of a tree file is <root>, not <{found}>")]
    Root {
        /// What it is.
        found: String,
        /// Where.
        #[label("not a tree file?")]
        span: SourceSpan,
    },
    /// The format is neither 3 nor 4.
    #[error("there is no format `{found}`")]
    #[diagnostic(help("write BTCPP_format=\"4\" (or \"3\", or leave it out, for files of Groot 1)"))]
    Format {
        /// What the file says.
        found: String,
        /// Where.
        #[label("unknown format")]
        span: SourceSpan,
    },
    /// There is no tree in the file.
    #[error("there is no <BehaviorTree> in this file")]
    NoTree {
        /// The root element.
        #[label("no tree in here")]
        span: SourceSpan,
    },
    /// One of several trees has no ID.
    #[error("a tree without ID cannot stand beside others")]
    #[diagnostic(help("write <BehaviorTree ID=\"…\">"))]
    TreeWithoutId {
        /// The tree.
        #[label("this tree needs an ID")]
        span: SourceSpan,
    },
    /// Two trees have the same ID.
    #[error("there are two trees `{id}`")]
    #[diagnostic(help("give one of them another ID"))]
    DuplicateTree {
        /// The ID.
        id: String,
        /// The second.
        #[label("again here")]
        span: SourceSpan,
        /// The first.
        #[label("first here")]
        first: SourceSpan,
    },
    /// The main tree does not exist.
    #[error("there is no tree `{id}` to be the main tree")]
    NoMainTree {
        /// The ID that is asked for.
        id: String,
        /// Where it is asked for: the attribute, or the root element if it is asked for from outside.
        #[label("no such tree")]
        span: SourceSpan,
        /// What there is.
        #[help]
        help: Option<String>,
    },
    /// Nothing says which of several trees is the main tree.
    #[error("nothing says which of the {count} trees is the main tree")]
    AmbiguousMainTree {
        /// How many trees there are.
        count: usize,
        /// The root element.
        #[label("no main_tree_to_execute")]
        span: SourceSpan,
        /// What could be said.
        #[help]
        help: Option<String>,
    },
    /// An element that nobody knows.
    #[error("<{element}> is no node that is known here")]
    UnknownNode {
        /// The element's name.
        element: String,
        /// Where.
        #[label("unknown")]
        span: SourceSpan,
        /// The nearest name, or how to declare it.
        #[help]
        help: Option<String>,
    },
    /// An element that does not belong at this place of the file.
    #[error("<{element}> does not belong here")]
    Misplaced {
        /// The element's name.
        element: String,
        /// Where.
        #[label("unexpected")]
        span: SourceSpan,
        /// What could stand here.
        #[help]
        help: Option<String>,
    },
    /// BehaviorTree.CPP knows it; this crate does not yet.
    #[error("{what} is part of BehaviorTree.CPP, but not supported yet")]
    NotSupported {
        /// The node or attribute.
        what: String,
        /// Where.
        #[label("not supported yet")]
        span: SourceSpan,
        /// What can be done about it.
        #[help]
        help: Option<String>,
    },
    /// A control node or decorator that somebody has written in C++.
    #[error("`{id}` is none of BehaviorTree.CPP's own nodes, and cannot be run as a <{category}>")]
    CustomNode {
        /// Its ID.
        id: String,
        /// What it is.
        category: crate::Category,
        /// Where it is used.
        #[label("unknown")]
        span: SourceSpan,
        /// What was perhaps meant.
        #[help]
        help: Option<String>,
    },
    /// An element that needs an ID has none.
    #[error("<{element}> has no ID")]
    MissingId {
        /// The element.
        element: String,
        /// Where.
        #[label("needs ID=\"…\"")]
        span: SourceSpan,
        /// What an ID would say.
        #[help]
        help: Option<String>,
    },
    /// An element whose name says what it is has an ID besides.
    #[error("<{element}> is the ID already; the attribute ID is not allowed")]
    NeedlessId {
        /// The element.
        element: String,
        /// The attribute.
        #[label("a second ID")]
        span: SourceSpan,
        /// What was probably meant.
        #[help]
        help: Option<String>,
    },
    /// A node with the wrong number of children.
    #[error("{node} must have {expected}, and has {found}")]
    ChildCount {
        /// The node.
        node: String,
        /// How many it must have, in words.
        expected: &'static str,
        /// How many it has.
        found: usize,
        /// Where.
        #[label("must have {expected}")]
        span: SourceSpan,
    },
    /// A node that is used as something else than what it is.
    #[error("`{id}` is {}, not {}", with_article(*is), with_article(*used_as))]
    WrongCategory {
        /// The node's ID.
        id: String,
        /// What it is.
        is: crate::Category,
        /// As what it is used.
        used_as: crate::Category,
        /// Where it is used.
        #[label("used as <{used_as}> here")]
        span: SourceSpan,
        /// Where the file says what it is.
        #[label("<{is}> here")]
        declared: Option<SourceSpan>,
    },
    /// A subtree that is not in the file.
    #[error("there is no tree `{id}`")]
    NoSubTree {
        /// The ID that is asked for.
        id: String,
        /// Where.
        #[label("no such tree")]
        span: SourceSpan,
        /// What there is.
        #[help]
        help: Option<String>,
    },
    /// A tree that contains itself.
    #[error("a tree would contain itself: {}", cycle.join(" → "))]
    #[diagnostic(help("trees cannot be recursive; repeat a tree by ticking it again"))]
    Recursion {
        /// The trees in the circle; the first and the last are the same.
        cycle: Vec<String>,
        /// The subtree that closes the circle.
        #[label("closes the circle")]
        span: SourceSpan,
    },
    /// Something that only the surroundings of the tree know is wrong with a node: see
    /// [`Tree::problem_at`](crate::Tree::problem_at).
    #[error("{message}")]
    Surroundings {
        /// What is wrong.
        message: String,
        /// The same at the place itself, in few words.
        label: String,
        /// The node.
        #[label("{label}")]
        span: SourceSpan,
        /// What can be done about it.
        #[help]
        help: Option<String>,
    },
}

impl Problem {
    /// Where the problem is in the file, in bytes: the first of its labels.
    #[must_use]
    pub fn offset(&self) -> usize {
        self.labels().and_then(|mut labels| labels.next()).map_or(0, |label| label.offset())
    }
}

fn with_article(category: crate::Category) -> String {
    let article = if category == crate::Category::Action { "an" } else { "a" };
    format!("{article} <{category}>")
}
