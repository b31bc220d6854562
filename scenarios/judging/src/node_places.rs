//! Where the nodes of a tree are written.

use bt::Tree;
use reports::file_place::{FilePlace, FileText};

/// Where each node of a tree is written.
pub fn node_places(tree: &Tree) -> impl Iterator<Item = FilePlace> {
    let texts = tree.sources().iter().map(|source| FileText::new(source.name().to_owned(), source.text()));
    let texts: Vec<FileText<'_>> = texts.collect();
    tree.nodes().iter().map(move |node| {
        let (offset, length) = (node.span().offset(), node.span().len());
        texts[node.file()].place(offset..offset + length)
    })
}
