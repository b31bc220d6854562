//! The files as a whole: well-formedness, the root element, includes, the trees, and the main tree.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use diagnostics::{Problem, Source};
use miette::SourceSpan;
use roxmltree::{Document, Node, ParsingOptions};

use super::assemble::{self, Index};
use super::elements::{MAX_ATTRIBUTES, span, tag_span};
use super::kept::{namespaces, other_attributes};
use super::loader::Loader;
use super::model::read_models;
use super::nav2::nav2_model;
use super::problems::{Problems, hint, listed, missing_port, not_supported, too_large, wrong_category};
use super::scan::Scan;
use super::source_file::SourceFile;
use super::vocabulary::{self, Builtin};
use crate::library::{Definition, Library, Models};
use crate::{Category, Tree, TreeError};

/// The maximum number of files; more are not the work of a person. Chosen, not measured.
const MAX_FILES: usize = 100;

/// Loads a file and those that it includes. The main file is the first.
pub(super) fn load(
    loader: &Loader,
    path: &Path,
    text: &str,
    read: &dyn Fn(&Path) -> io::Result<String>,
) -> Result<Tree, TreeError> {
    let mut files = vec![SourceFile::new(path, text)];
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
    let problem = Problem::new(format!("the file cannot be read: {error}"));
    TreeError::new(Source::new(&path.display().to_string(), ""), vec![problem])
}

fn error(files: Vec<SourceFile>) -> TreeError {
    let mut errors = files.into_iter().map(|file| (file.text, file.problems));
    let (source, problems) = errors.next().expect("there is a main file");
    let included = errors.filter(|(_, problems)| !problems.is_empty());
    TreeError::new(source, problems)
        .with_included(included.map(|(source, problems)| TreeError::new(source, problems)).collect())
}

/// Reads all included files, and determines their order: included files come before those that include them. A file
/// that is included twice counts once.
fn find_included(
    files: &mut Vec<SourceFile>,
    loader: &Loader,
    read: &dyn Fn(&Path) -> io::Result<String>,
) -> Vec<usize> {
    let mut order = Vec::new();
    // The files in progress, with their remaining includes.
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
                let mut included = SourceFile::new(&path, &text);
                stack.push((files.len(), includes_of(&mut included, loader)));
                files.push(included);
            }
            Err(error) => {
                let problem = Problem::new(format!("`{written}` cannot be included: {error}"));
                files[file].problems.push(problem.at(span, "included here"));
            }
        }
    }
    order
}

/// The includes of a file, in reverse order. A file that is not a tree file is reported when it is finally read.
fn includes_of(file: &mut SourceFile, loader: &Loader) -> Vec<(String, SourceSpan)> {
    let text = file.text.clone();
    let Ok(document) = parse(text.text(), loader) else { return Vec::new() };
    let elements = document.root_element().children().filter(|element| element.has_tag_name("include"));
    let mut includes = Vec::new();
    for element in elements {
        let span = tag_span(element);
        if element.has_attribute("ros_pkg") {
            let help = "write the path to the file, without the package";
            file.problems.push(not_supported("an <include> from a ROS package", span, help));
            continue;
        }
        match element.attribute("path") {
            Some(path) => includes.push((path.to_owned(), span)),
            None => file.problems.push(missing_port("<include>", "path", span, None)),
        }
    }
    includes.reverse();
    includes
}

/// The path of an included file, without `.` and, if possible, `..`.
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

/// Reads a file as XML, whose outermost element is `<root>`.
pub(super) fn parse<'a>(text: &'a str, loader: &Loader) -> Result<Document<'a>, Problem> {
    // Comments and white space between elements count as nodes, too: leave room for them.
    let nodes_limit = u32::try_from(loader.max_nodes.saturating_mul(8)).unwrap_or(u32::MAX);
    let options = ParsingOptions { allow_dtd: false, nodes_limit, ..ParsingOptions::default() };
    diagnostics::xml::check_attributes(text, MAX_ATTRIBUTES)?;
    let is_known = |name: &str| vocabulary::builtin(name).is_some() || vocabulary::explicit(name).is_some();
    let document = Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::NodesLimitReached => too_large(loader.max_nodes, span(0..1)),
        error => diagnostics::xml::problem(text, &error, is_known),
    })?;
    let root = document.root_element();
    if root.tag_name().name() == "root" {
        Ok(document)
    } else {
        let problem =
            Problem::new(format!("the outermost element of a tree file is <root>, not <{}>", root.tag_name().name()));
        Err(problem.at(tag_span(root), "not a tree file?"))
    }
}

/// The parsed files, by their indices, in the order in which they are read.
type Documents<'a> = [(usize, Document<'a>)];

/// Reads the main tree of the files. If there is none, a problem explains why.
fn build(loader: &Loader, files: &mut [SourceFile], order: &[usize]) -> Option<Tree> {
    let sources: Vec<Source> = files.iter().map(|file| file.text.clone()).collect();
    let mut documents = Vec::new();
    for file in order {
        match parse(sources[*file].text(), loader) {
            Ok(document) => documents.push((*file, document)),
            Err(problem) => files[*file].problems.push(problem),
        }
    }
    let (mut models, trees) = declared(&documents, loader, files);
    let definitions = definitions(&documents, loader, &mut models, &trees, files);
    check_categories(loader, &definitions, &models, files);
    let main_root = documents.iter().find(|(file, _)| *file == 0)?.1.root_element();
    let index = Index::new(&definitions);
    assemble::check_references(&definitions, &index, files);
    let main = main_tree(loader, main_root, &definitions, &index, &mut files[0].problems)?;
    // The assembly assumes that all subtrees exist and none contains itself.
    if files.iter().any(SourceFile::is_wrong) {
        return None;
    }
    let mut kept = namespaces(documents.iter().map(|(_, document)| document));
    kept.extend(other_attributes(main_root, &vocabulary::OF_ROOT));
    let library = Arc::new(Library { definitions, models, kept });
    assemble::assemble(loader, &sources, &library, main, files)
}

/// What the files declare: the models of nodes, and the IDs of trees.
fn declared(documents: &Documents<'_>, loader: &Loader, files: &mut [SourceFile]) -> (Models, BTreeSet<String>) {
    let (mut models, mut trees) = (Models::new(), BTreeSet::new());
    for (file, document) in documents {
        read_models(document.root_element(), *file, &mut models, &mut files[*file].problems);
        let elements = document.root_element().children().filter(|element| element.has_tag_name("BehaviorTree"));
        trees.extend(elements.filter_map(|tree| tree.attribute("ID").map(str::to_owned)));
    }
    // A file's own declarations count more than Nav2's model, whichever file comes first.
    for (_, document) in documents {
        add_nav2_leaves(document, loader, &trees, &mut models);
    }
    (models, trees)
}

/// The trees of all files. A file's tree replaces that of an included file with the same ID.
fn definitions(
    documents: &Documents<'_>,
    loader: &Loader,
    models: &mut Models,
    trees: &BTreeSet<String>,
    files: &mut [SourceFile],
) -> Vec<Definition> {
    let mut definitions: Vec<Definition> = Vec::new();
    for (file, document) in documents {
        let problems = &mut files[*file].problems;
        let format = check_format(document.root_element(), problems);
        let mut scan = Scan { loader, format, file: *file, problems, models, trees, unknown: BTreeMap::new() };
        let own = scan.read_root(document.root_element());
        check_ids(&own, document.root_element(), format, problems);
        let ids: BTreeSet<&str> = own.iter().filter_map(|tree| tree.id.as_deref()).collect();
        definitions.retain(|earlier| earlier.id.as_deref().is_none_or(|id| !ids.contains(id)));
        definitions.extend(own);
    }
    definitions
}

/// Adds the models of Nav2's leaves that a document uses, `<Wait/>`, but nothing declares.
fn add_nav2_leaves(document: &Document<'_>, loader: &Loader, trees: &BTreeSet<String>, models: &mut Models) {
    let elements = document.root_element().children().filter(|element| element.has_tag_name("BehaviorTree"));
    for element in elements.flat_map(|tree| tree.descendants().skip(1)).filter(Node::is_element) {
        let id = element.tag_name().name();
        let is_known = vocabulary::builtin(id).is_some()
            || vocabulary::explicit(id).is_some()
            || models.contains_key(id)
            || loader.leaves.contains(id)
            || trees.contains(id);
        // Asked last: the first question reads Nav2's whole model, which takes as long as loading a tree ten times.
        if !is_known && let Some(model) = nav2_model(id) {
            models.insert(id.to_owned(), model.clone());
        }
    }
}

/// The format that the file declares; 3 if it declares none, as files of that format often do not.
fn check_format(root: Node<'_, '_>, problems: &mut Problems) -> u8 {
    let Some(attribute) = root.attribute_node("BTCPP_format") else { return 3 };
    match attribute.value().trim() {
        "3" => 3,
        "4" => 4,
        found => {
            let problem = Problem::new(format!("unknown format `{found}`")).at(attribute.range(), "unknown format");
            let help = "write BTCPP_format=\"4\" (or \"3\", or leave it out, for files of Groot 1)";
            problems.push(problem.with_help(help));
            4
        }
    }
}

/// Checks that no tree has the name of a node.
fn check_categories(loader: &Loader, definitions: &[Definition], models: &Models, files: &mut [SourceFile]) {
    for &Definition { ref id, span, file, .. } in definitions {
        let Some(id) = id else { continue };
        let model = models.get(id).filter(|model| model.category != Category::SubTree);
        let builtin = vocabulary::builtin(id).map(Builtin::category);
        let is = builtin.or(model.map(|model| model.category));
        let Some(is) = is.or(loader.leaves.contains(id).then_some(Category::Action)) else { continue };
        let place = model.and_then(|model| model.declared).filter(|(declared_in, _)| *declared_in == file);
        let (used_as, declared) = (Category::SubTree, place.map(|(_, span)| span));
        files[file].problems.push(wrong_category(id, is, used_as, span, declared));
    }
}

/// Checks that several trees of a file have different IDs.
fn check_ids(definitions: &[Definition], root: Node<'_, '_>, format: u8, problems: &mut Problems) {
    let mut seen = BTreeMap::new();
    let has_others = root.children().filter(Node::is_element).count() > 1;
    for Definition { id, span, .. } in definitions {
        let Some(id) = id else {
            if definitions.len() <= 1 && has_others && format == 4 {
                let message = "a tree needs an ID if there is anything else in <root>, such as <TreeNodesModel>";
                let help = "write <BehaviorTree ID=\"…\">; BehaviorTree.CPP refuses to load this tree: \"The tag \
                            <BehaviorTree> must have the attribute [ID]\"";
                problems.push(Problem::new(message).at(*span, "this tree has no ID").with_help(help));
            }
            if definitions.len() > 1 {
                let problem = Problem::new("a tree needs an ID if there are others");
                problems.push(problem.at(*span, "this tree has no ID").with_help("write <BehaviorTree ID=\"…\">"));
            }
            continue;
        };
        match seen.get(id) {
            Some(first) => {
                let problem = Problem::new(format!("there are two trees with the ID `{id}`")).at(*span, "again here");
                problems.push(problem.at(*first, "first here").with_help("give one of them a different ID"));
            }
            None => {
                seen.insert(id, *span);
            }
        }
    }
}

/// The main tree: the loader's choice, the main file's, or the only one.
fn main_tree(
    loader: &Loader,
    root: Node<'_, '_>,
    definitions: &[Definition],
    index: &Index<'_>,
    problems: &mut Problems,
) -> Option<usize> {
    if definitions.is_empty() {
        let problem = Problem::new("there is no <BehaviorTree> in this file");
        problems.push(problem.at(tag_span(root), "this contains no tree"));
        return None;
    }
    // The loader's choice is written in no file: if it does not exist, the problem points to the root.
    let choice: Option<(&str, SourceSpan)> = match (&loader.main_tree, root.attribute_node("main_tree_to_execute")) {
        (Some(id), _) => Some((id.as_str(), tag_span(root))),
        (None, Some(attribute)) => Some((attribute.value(), span(attribute.range()))),
        (None, None) => None,
    };
    let Some((id, span)) = choice else {
        if definitions.len() == 1 {
            return Some(0);
        }
        let message = format!("the main tree is not set, and there are {} trees", definitions.len());
        let problem = Problem::new(message).at(tag_span(root), "no main_tree_to_execute");
        let help = format!("write main_tree_to_execute=\"…\" in <root>; the trees are {}", listed(index.ids()));
        problems.push(problem.with_help(help));
        return None;
    };
    let found = index.find(id);
    if found.is_none() {
        let problem = Problem::new(format!("the main tree `{id}` does not exist")).at(span, "no such tree");
        problems.push(problem.with_help_if(hint(id, index.ids(), problems.len())));
    }
    found
}
