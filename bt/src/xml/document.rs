//! The files as a whole: well-formedness, the root element, what they include, which trees there are, which is the main
//! one.

use std::collections::BTreeSet;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use miette::{NamedSource, SourceSpan};
use roxmltree::{Document, Node, ParsingOptions, TextPos};

use super::assemble::{self, Index};
use super::kept::{Kept, namespaces, other_attributes};
use super::model::{Model, Models, read_models};
use super::scan::{Definition, Scan};
use super::{Loader, Problems, hint, listed, nearest, span, tag_span, vocabulary};
use crate::{Category, Problem, Tree, TreeError};

/// How many files may be involved.
const MAX_FILES: usize = 100;

/// All that files say: their trees, and what they declare of nodes.
#[derive(Debug, Default)]
pub(crate) struct Library {
    /// The trees that count: of several with one ID, that of the including file.
    pub(crate) definitions: Vec<Definition>,
    pub(super) models: Models,
    /// What the main file's root says besides its format and its main tree, and the namespaces of all files.
    pub(super) kept: Kept,
}

/// A file, and what is wrong with it.
pub(super) struct SourceFile {
    path: PathBuf,
    text: Arc<str>,
    problems: Problems,
}

impl SourceFile {
    fn source(&self) -> NamedSource<Arc<str>> {
        NamedSource::new(self.path.display().to_string(), Arc::clone(&self.text)).with_language("xml")
    }

    /// Whether there is more to say of it than warnings.
    fn is_wrong(&self) -> bool {
        self.problems.iter().any(Problem::is_error)
    }
}

/// Loads a file and those that it includes. The main file is the first.
pub(super) fn load(
    loader: &Loader,
    path: &Path,
    text: &str,
    read: &dyn Fn(&Path) -> io::Result<String>,
) -> Result<Tree, TreeError> {
    let mut files = vec![SourceFile { path: path.to_owned(), text: text.into(), problems: Vec::new() }];
    let order = if text.contains("<include") { find_included(&mut files, loader, read) } else { vec![0] };
    let Some(mut tree) = build(loader, &mut files, &order).filter(|_| !files.iter().any(SourceFile::is_wrong)) else {
        return Err(error(files));
    };
    if files.iter().any(|file| !file.problems.is_empty()) {
        tree.concerns = Some(error(files));
    }
    Ok(tree)
}

/// The error of a file that cannot be read.
pub(super) fn unreadable(path: &Path, error: &io::Error) -> TreeError {
    let source = NamedSource::new(path.display().to_string(), Arc::from(""));
    TreeError::new(source, vec![Problem::Unreadable { message: error.to_string() }])
}

/// All that is said of the files.
fn error(files: Vec<SourceFile>) -> TreeError {
    let mut errors = files.into_iter().map(|file| (file.source(), file.problems));
    let (source, problems) = errors.next().expect("the main file is there");
    let included = errors.filter(|(_, problems)| !problems.is_empty());
    TreeError::new(source, problems)
        .with_included(included.map(|(source, problems)| TreeError::new(source, problems)).collect())
}

/// Reads all files that are included, and says in which order they count: those that are included before those that
/// include them. A file that is included twice counts once.
fn find_included(
    files: &mut Vec<SourceFile>,
    loader: &Loader,
    read: &dyn Fn(&Path) -> io::Result<String>,
) -> Vec<usize> {
    let mut order = Vec::new();
    // Files that are being looked at, with what they include that has not been followed yet.
    let mut stack = vec![(0, includes_of(&mut files[0], loader))];
    while let Some((file, includes)) = stack.last_mut() {
        let file = *file;
        let Some((written, span)) = includes.pop() else {
            order.push(file);
            stack.pop();
            continue;
        };
        let path = resolved(&files[file].path, &written);
        if files.iter().any(|known| known.path == path) {
            continue;
        }
        let text = if files.len() < MAX_FILES { read(&path) } else { Err(io::Error::other("too many files")) };
        match text {
            Ok(text) => {
                let mut included = SourceFile { path, text: text.into(), problems: Vec::new() };
                stack.push((files.len(), includes_of(&mut included, loader)));
                files.push(included);
            }
            Err(error) => {
                files[file].problems.push(Problem::Include { path: written, message: error.to_string(), span });
            }
        }
    }
    order
}

/// What a file includes, the last first. A file that is no tree file is complained about when it is read for good.
fn includes_of(file: &mut SourceFile, loader: &Loader) -> Vec<(String, SourceSpan)> {
    let text = Arc::clone(&file.text);
    let Ok(document) = parse(&text, loader) else { return Vec::new() };
    let elements = document.root_element().children().filter(|element| element.has_tag_name("include"));
    let mut includes = Vec::new();
    for element in elements {
        let span = tag_span(element);
        if element.has_attribute("ros_pkg") {
            let help = Some("write the path to the file, without the package".to_owned());
            let what = "an <include> from a ROS package".to_owned();
            file.problems.push(Problem::NotSupported { what, span, help });
            continue;
        }
        match element.attribute("path") {
            Some(path) => includes.push((path.to_owned(), span)),
            None => {
                let (node, port) = ("<include>".to_owned(), "path".to_owned());
                file.problems.push(Problem::MissingPort { node, port, span, help: None });
            }
        }
    }
    includes.reverse();
    includes
}

/// The path of a file that another includes, without `.` and, where that is possible, `..`.
fn resolved(including: &Path, written: &str) -> PathBuf {
    let joined = including.parent().unwrap_or(Path::new("")).join(written);
    let mut path = PathBuf::new();
    for component in joined.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(path.components().next_back(), Some(Component::Normal(_))) => {
                path.pop();
            }
            component => path.push(component),
        }
    }
    path
}

fn parse<'a>(text: &'a str, loader: &Loader) -> Result<Document<'a>, Problem> {
    // Comments and the space between elements count as nodes, too: leave room for them.
    let nodes_limit = u32::try_from(loader.max_nodes.saturating_mul(8)).unwrap_or(u32::MAX);
    let options = ParsingOptions { allow_dtd: false, nodes_limit, ..ParsingOptions::default() };
    let document =
        Document::parse_with_options(text, options).map_err(|error| parse_problem(text, &error, loader.max_nodes))?;
    let root = document.root_element();
    if root.tag_name().name() == "root" {
        Ok(document)
    } else {
        Err(Problem::Root { found: root.tag_name().name().to_owned(), span: tag_span(root) })
    }
}

/// Reads the main tree of the files. Where there is none, there is a problem that says why.
fn build(loader: &Loader, files: &mut [SourceFile], order: &[usize]) -> Option<Tree> {
    let sources: Vec<NamedSource<Arc<str>>> = files.iter().map(SourceFile::source).collect();
    let texts: Vec<Arc<str>> = files.iter().map(|file| Arc::clone(&file.text)).collect();
    let mut documents = Vec::new();
    for file in order {
        match parse(&texts[*file], loader) {
            Ok(document) => documents.push((*file, document)),
            Err(problem) => files[*file].problems.push(problem),
        }
    }
    let (mut models, mut trees) = (Models::new(), BTreeSet::new());
    for (file, document) in &documents {
        read_models(document.root_element(), *file, &mut models, &mut files[*file].problems);
        let elements = document.root_element().children().filter(|element| element.has_tag_name("BehaviorTree"));
        trees.extend(elements.filter_map(|tree| tree.attribute("ID").map(str::to_owned)));
    }
    let mut definitions: Vec<Definition> = Vec::new();
    for (file, document) in &documents {
        let problems = &mut files[*file].problems;
        let format = check_format(document.root_element(), problems);
        let mut scan = Scan { loader, format, file: *file, problems, models: &mut models, trees: &trees };
        let own = scan.read_root(document.root_element());
        check_ids(&own, problems);
        definitions.retain(|earlier| own.iter().all(|tree| tree.id.is_none() || tree.id != earlier.id));
        definitions.extend(own);
    }
    let main_root = documents.iter().find(|(file, _)| *file == 0)?.1.root_element();
    let index = Index::new(&definitions);
    assemble::check_references(&definitions, &index, files);
    let main = main_tree(loader, main_root, &definitions, &index, &mut files[0].problems)?;
    if files.iter().any(SourceFile::is_wrong) {
        return None;
    }
    let mut kept = namespaces(documents.iter().map(|(_, document)| document));
    kept.extend(other_attributes(main_root, &["BTCPP_format", "main_tree_to_execute"]));
    let library = Arc::new(Library { definitions, models, kept });
    assemble::assemble(loader, sources, &library, main, files)
}

impl SourceFile {
    pub(super) fn problems(&mut self) -> &mut Problems {
        &mut self.problems
    }
}

impl Library {
    /// What is declared or known of an ID.
    pub(crate) fn model(&self, id: &str) -> Option<&Model> {
        self.models.get(id)
    }
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
            Problem::Xml { message: error.to_string(), span: at(text.len()), help: None }
        }
        error => {
            let offset = offset(text, error.pos());
            // The parser appends the place to what it says; the label shows it better.
            let message = error.to_string();
            let message = message.rsplit_once(" at ").map_or(message.as_str(), |(message, _)| message).to_owned();
            let help = match error {
                roxmltree::Error::UnexpectedCloseTag(opened, closed, _) => misspelt(opened, closed),
                _ => None,
            };
            Problem::Xml { message, span: at(offset), help }
        }
    }
}

/// What was meant by an element that begins with one name and ends with one much like it.
fn misspelt(opened: &str, closed: &str) -> Option<String> {
    let is_known = |name: &str| vocabulary::builtin(name).is_some() || vocabulary::explicit(name).is_some();
    nearest(opened, std::iter::once(closed), 0)?;
    let meant = if is_known(closed) { closed } else { opened };
    Some(format!("<{opened}> ends as </{closed}>: did you mean <{meant}>?"))
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

/// Several trees of a file need IDs, each its own, and none may be called like a node.
fn check_ids(definitions: &[Definition], problems: &mut Problems) {
    let mut seen = std::collections::BTreeMap::new();
    for Definition { id, span, .. } in definitions {
        let Some(id) = id else {
            if definitions.len() > 1 {
                problems.push(Problem::TreeWithoutId { span: *span });
            }
            continue;
        };
        if let Some(builtin) = vocabulary::builtin(id) {
            let (is, used_as) = (builtin.category(), Category::SubTree);
            problems.push(Problem::WrongCategory { id: id.clone(), is, used_as, span: *span, declared: None });
        }
        match seen.get(id) {
            Some(first) => {
                problems.push(Problem::DuplicateTree { id: id.clone(), span: *span, first: *first });
            }
            None => {
                seen.insert(id, *span);
            }
        }
    }
}

/// Which tree is the main one: the loader's choice, the main file's, or the only one.
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
