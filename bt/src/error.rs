//! What can be wrong with a tree file.

use std::sync::Arc;

use miette::{Diagnostic, NamedSource, Severity, SourceCode, SourceSpan};

/// Everything that is wrong with a tree file, or looks wrong: the file, and its problems in the order of their places.
/// Problems of files that it includes come with those files.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{} {}", source_code.name(), verdict(self.is_error()))]
pub struct TreeError {
    source_code: NamedSource<Arc<str>>,
    problems: Vec<Problem>,
    included: Vec<TreeError>,
}

impl TreeError {
    pub(crate) fn new(source_code: NamedSource<Arc<str>>, mut problems: Vec<Problem>) -> Self {
        problems.sort_by_key(Problem::offset);
        Self { source_code, problems, included: Vec::new() }
    }

    /// The error of a file and of those that it includes.
    pub(crate) fn with_included(mut self, included: Vec<Self>) -> Self {
        self.included = included;
        self
    }

    /// The problems of the file itself, in the order of their places in it.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// What is wrong with the files that it includes.
    #[must_use]
    pub fn included(&self) -> &[Self] {
        &self.included
    }

    /// Whether the file, or one that it includes, cannot be used. Else there are only warnings: see
    /// [`Tree::concerns`](crate::Tree::concerns).
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.problems.iter().any(Problem::is_error) || self.included.iter().any(Self::is_error)
    }

    /// The name of the file.
    #[must_use]
    pub fn file(&self) -> &str {
        self.source_code.name()
    }
}

impl Diagnostic for TreeError {
    fn severity(&self) -> Option<Severity> {
        Some(if self.is_error() { Severity::Error } else { Severity::Warning })
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source_code)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let problems = self.problems.iter().map(|problem| problem as &dyn Diagnostic);
        let included = self.included.iter().map(|error| error as &dyn Diagnostic);
        Some(Box::new(problems.chain(included)))
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
        /// What was probably meant.
        #[help]
        help: Option<String>,
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
    /// BehaviorTree.CPP knows or knew it; this crate does not.
    #[error("{what} is not supported")]
    NotSupported {
        /// The node or attribute.
        what: String,
        /// Where.
        #[label("not supported")]
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
    /// A file that is included cannot be read.
    #[error("`{path}` cannot be included: {message}")]
    Include {
        /// The path, as it is written.
        path: String,
        /// Why not.
        message: String,
        /// Where it is included.
        #[label("included here")]
        span: SourceSpan,
    },
    /// The file itself cannot be read.
    #[error("the file cannot be read: {message}")]
    Unreadable {
        /// Why not.
        message: String,
    },
    /// A port that a node can't do without is not there.
    #[error("{node} needs the port `{port}`")]
    MissingPort {
        /// The node.
        node: String,
        /// The port.
        port: String,
        /// Where the node is.
        #[label("needs {port}=\"…\"")]
        span: SourceSpan,
        /// What was perhaps meant to be it.
        #[help]
        help: Option<String>,
    },
    /// An attribute that is none of a node's ports: of BehaviorTree.CPP's own nodes, any; of others, one that is nearly
    /// called like a port.
    #[error("{node} has no port `{port}`")]
    UnknownPort {
        /// The node.
        node: String,
        /// The attribute.
        port: String,
        /// Where it is.
        #[label("no such port")]
        span: SourceSpan,
        /// What was probably meant.
        #[help]
        help: Option<String>,
    },
    /// An attribute that the node's model does not declare as a port.
    #[error("{node} declares no port `{port}`")]
    #[diagnostic(severity(Warning))]
    UndeclaredPort {
        /// The node.
        node: String,
        /// The attribute.
        port: String,
        /// Where it is.
        #[label("not declared")]
        span: SourceSpan,
        /// What is declared.
        #[help]
        help: Option<String>,
    },
    /// An attribute that begins with `_`, as scripts do, and that nobody knows.
    #[error("the attribute `{attribute}` means nothing")]
    #[diagnostic(severity(Warning))]
    UnknownAttribute {
        /// The attribute.
        attribute: String,
        /// Where it is.
        #[label("has no effect")]
        span: SourceSpan,
        /// What was probably meant.
        #[help]
        help: Option<String>,
    },
    /// A port's value is not of its type, or cannot be right.
    #[error("the port `{port}`: {message}")]
    PortValue {
        /// The port.
        port: String,
        /// What is wrong with it.
        message: String,
        /// Where the value is.
        #[label("not accepted here")]
        span: SourceSpan,
        /// What would be accepted.
        #[help]
        help: Option<String>,
    },
    /// A port in a `<TreeNodesModel>` has no name, or one that no port can have.
    #[error("this port has no name")]
    PortName {
        /// Where.
        #[label("needs name=\"…\"")]
        span: SourceSpan,
        /// What a name is like.
        #[help]
        help: Option<String>,
    },
    /// Ports of different types use one entry of the blackboard.
    #[error("the entry `{key}` is of the type {is} already, and cannot be used as {used_as}")]
    EntryType {
        /// The key.
        key: String,
        /// The type that a port has given it before.
        is: String,
        /// The type of this port.
        used_as: String,
        /// Where.
        #[label("used as {used_as} here")]
        span: SourceSpan,
    },
    /// A script that is none.
    #[error("this script cannot be read: {message}")]
    Script {
        /// What is wrong with it.
        message: String,
        /// Where: in the script, or the whole of it.
        #[label("here")]
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
        /// Which of the tree's files it is in: the main file is 0.
        file: usize,
    },
}

impl Problem {
    /// Whether a file with this problem cannot be used; else it is a warning.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity() != Some(Severity::Warning)
    }

    /// Where the problem is in the file, in bytes: the first of its labels.
    #[must_use]
    pub fn offset(&self) -> usize {
        self.labels().and_then(|mut labels| labels.next()).map_or(0, |label| label.offset())
    }
}

fn verdict(is_error: bool) -> &'static str {
    if is_error { "cannot be used as a behavior tree" } else { "can be used, but looks odd" }
}

fn with_article(category: crate::Category) -> String {
    let article = if category == crate::Category::Action { "an" } else { "a" };
    format!("{article} <{category}>")
}
