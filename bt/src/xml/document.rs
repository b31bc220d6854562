//! The file as a whole: well-formedness, the root element, which trees there are, which is the main one.

use std::sync::Arc;

use miette::{NamedSource, SourceSpan};
use roxmltree::{Document, Node, ParsingOptions, TextPos};

use super::assemble::{self, Index};
use super::scan::{Definition, Scan};
use super::{Loader, Problems, hint, listed, span, tag_span};
use crate::{Problem, Tree};

/// Reads the main tree of a document. Where there is none, there is a problem that says why.
pub(super) fn read(
    loader: &Loader,
    source: &NamedSource<Arc<str>>,
    text: &str,
    problems: &mut Problems,
) -> Option<Tree> {
    // Comments and the space between elements count as nodes, too: leave room for them.
    let nodes_limit = u32::try_from(loader.max_nodes.saturating_mul(8)).unwrap_or(u32::MAX);
    let options = ParsingOptions { allow_dtd: false, nodes_limit, ..ParsingOptions::default() };
    let document = match Document::parse_with_options(text, options) {
        Ok(document) => document,
        Err(error) => {
            problems.push(parse_problem(text, &error, loader.max_nodes));
            return None;
        }
    };
    let root = document.root_element();
    if root.tag_name().name() != "root" {
        problems.push(Problem::Root { found: root.tag_name().name().to_owned(), span: tag_span(root) });
        return None;
    }
    let format = check_format(root, problems);
    let mut scan = Scan::new(loader, format, problems);
    let definitions = scan.read_root(root);
    let index = Index::new(&definitions);
    check_ids(&definitions, &index, problems);
    assemble::check_references(&definitions, &index, problems);
    let main = main_tree(loader, root, &definitions, &index, problems)?;
    if !problems.is_empty() {
        return None;
    }
    assemble::assemble(loader, source, &definitions, &index, main).map_err(|problem| problems.push(problem)).ok()
}

/// The problem of a text that is no acceptable XML, with the place where the parser gave up.
fn parse_problem(text: &str, error: &roxmltree::Error, limit: usize) -> Problem {
    let at = |offset: usize| span(offset..text[offset..].chars().next().map_or(offset, |c| offset + c.len_utf8()));
    match error {
        roxmltree::Error::DtdDetected => {
            let start = text.find("<!DOCTYPE").unwrap_or(0);
            Problem::DocumentType { span: span(start..text.len().min(start + "<!DOCTYPE".len())) }
        }
        roxmltree::Error::NodesLimitReached => Problem::TooLarge { limit, span: at(0) },
        roxmltree::Error::UnclosedRootNode | roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::NoRootNode => {
            Problem::Xml { message: error.to_string(), span: at(text.len()) }
        }
        error => {
            let offset = offset(text, error.pos());
            // The parser appends the place to what it says; the label shows it better.
            let message = error.to_string();
            let message = message.rsplit_once(" at ").map_or(message.as_str(), |(message, _)| message).to_owned();
            Problem::Xml { message, span: at(offset) }
        }
    }
}

/// The byte that a row and a column, both counted from 1, stand for.
fn offset(text: &str, pos: TextPos) -> usize {
    let line_start = text.split_inclusive('\n').take(pos.row.saturating_sub(1) as usize).map(str::len).sum::<usize>();
    let column = pos.col.saturating_sub(1) as usize;
    text[line_start..].char_indices().nth(column).map_or(text.len(), |(offset, _)| line_start + offset)
}

/// The format that the file says it has; 3 where it says nothing, as nothing was said in its days.
fn check_format(root: Node<'_, '_>, problems: &mut Problems) -> u8 {
    let Some(attribute) = root.attribute_node("BTCPP_format") else { return 3 };
    match attribute.value().trim() {
        "3" => 3,
        "4" => 4,
        found => {
            problems.push(Problem::Format { found: found.to_owned(), span: span(attribute.range()) });
            4
        }
    }
}

/// Several trees need IDs, each its own.
fn check_ids(definitions: &[Definition], index: &Index<'_>, problems: &mut Problems) {
    for (place, Definition { id, span, .. }) in definitions.iter().enumerate() {
        match id {
            None if definitions.len() > 1 => problems.push(Problem::TreeWithoutId { span: *span }),
            None => {}
            Some(id) => {
                let first = index.find(id).filter(|first| *first != place);
                problems.extend(first.map(|first| {
                    let first = definitions[first].span;
                    Problem::DuplicateTree { id: id.clone(), span: *span, first }
                }));
            }
        }
    }
}

/// Which tree is the main one: the loader's choice, the file's, or the only one.
fn main_tree(
    loader: &Loader,
    root: Node<'_, '_>,
    definitions: &[Definition],
    index: &Index<'_>,
    problems: &mut Problems,
) -> Option<usize> {
    if definitions.is_empty() {
        problems.push(Problem::NoTree { span: tag_span(root) });
        return None;
    }
    let choice: Option<(&str, SourceSpan)> = match (&loader.main_tree, root.attribute_node("main_tree_to_execute")) {
        (Some(id), _) => Some((id.as_str(), tag_span(root))),
        (None, Some(attribute)) => Some((attribute.value(), span(attribute.range()))),
        (None, None) => None,
    };
    let Some((id, span)) = choice else {
        if definitions.len() == 1 {
            return Some(0);
        }
        let help = Some(format!("write main_tree_to_execute=\"…\" in <root>; there is {}", listed(index.ids())));
        problems.push(Problem::AmbiguousMainTree { count: definitions.len(), span: tag_span(root), help });
        return None;
    };
    let found = index.find(id);
    if found.is_none() {
        problems.push(Problem::NoMainTree { id: id.to_owned(), span, help: hint(id, index.ids(), problems.len()) });
    }
    found
}
