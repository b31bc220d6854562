//! What may be written at a place, and what is written there.

use std::ops::Range;

/// Something that may be written at a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proposal {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: ProposalKind,
    /// What it is in a few words: the accepted values of a key, the ports of a node.
    pub detail: String,
    /// What it means.
    pub about: String,
    /// The text to insert.
    pub insert: String,
    /// The range that the text replaces, in bytes.
    pub replaces: Range<usize>,
}

impl Proposal {
    /// A name that is inserted as it is.
    pub(crate) fn new(
        name: impl Into<String>,
        kind: ProposalKind,
        detail: impl Into<String>,
        replaces: &Range<usize>,
    ) -> Self {
        let name = name.into();
        let (insert, about) = (name.clone(), String::new());
        Self { name, kind, detail: detail.into(), about, insert, replaces: replaces.clone() }
    }

    /// An element of XML, after its `<` or with it.
    pub(crate) fn element(name: &str, what: &str, before: &str, replaces: &Range<usize>) -> Self {
        Self::new(name, ProposalKind::Element, what, replaces).inserting(format!("{before}{name}"))
    }

    /// An attribute of XML.
    pub(crate) fn attribute(name: &str, detail: impl Into<String>, replaces: &Range<usize>) -> Self {
        Self::new(name, ProposalKind::Key, detail, replaces).inserting(format!("{name}=\"\""))
    }

    /// The same with another text to insert.
    pub(crate) fn inserting(self, insert: impl Into<String>) -> Self {
        Self { insert: insert.into(), ..self }
    }
}

/// What a proposal is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProposalKind {
    /// A key of a table, or an attribute of an element.
    Key,
    /// A table.
    Table,
    /// An element of XML.
    Element,
    /// One of several values.
    Value,
    /// A name that a file of the project defines, or one of a message's fields.
    Name,
    /// A word of the language.
    Keyword,
    /// A file.
    File,
}

/// What is known about the text at a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The text, in bytes.
    pub range: Range<usize>,
    /// What it means, in Markdown.
    pub text: String,
}
