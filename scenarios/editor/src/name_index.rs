//! Where names are defined and used, in all files of a project.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bt::Kind;
use checks::{FileKind, Toml};
use diagnostics::{Disk, normal};
use monitors::syntax::{Item, parse_file};
use roxmltree::{Attribute, Document, Node, ParsingOptions};

use crate::machine_words::STATES;
use crate::toml_place::{Text, contents};

/// The kinds of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NameKind {
    /// A process: a leaf or a component. A leaf without a name has that of its kind of node.
    Process,
    /// A behavior tree.
    Tree,
    /// A property.
    Property,
    /// A place on the map.
    Place,
    /// A state of a machine, known only in its file.
    State,
    /// A table of a TOML file, known only in its file.
    Table,
    /// A file.
    File,
}

/// A name where it is written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mention {
    /// The file.
    pub path: PathBuf,
    /// Its first and last byte, without quotes.
    pub start: usize,
    /// The end.
    pub end: usize,
    /// What the name stands for.
    pub kind: NameKind,
    /// The name.
    pub name: String,
    /// Whether it is defined here.
    pub is_definition: bool,
}

/// All names of some files.
#[derive(Clone, Debug, Default)]
pub struct NameIndex {
    /// In the order of files and places.
    mentions: Vec<Mention>,
    /// The texts of the files.
    pub texts: Vec<(PathBuf, Arc<str>)>,
}

impl NameIndex {
    /// The names in these files. A file that cannot be read has none.
    #[must_use]
    pub fn of<'p>(disk: &Disk, files: impl IntoIterator<Item = &'p Path>) -> Self {
        let read = |path: &'p Path| {
            let kind = FileKind::of_document(disk, path)?;
            Some((path, kind, disk.read_text(path).ok()?))
        };
        let files: Vec<(&Path, FileKind, String)> = files.into_iter().filter_map(read).collect();
        let mut found = Collector::default();
        for (path, kind, text) in &files {
            found.definitions(path, *kind, text);
        }
        let names = found.found.iter().map(|mention| (mention.kind, mention.name.clone()));
        let defined = Defined { names: names.collect() };
        for (path, kind, text) in &files {
            found.uses(path, *kind, text, disk, &defined);
        }
        let texts = files.iter().map(|(path, _, text)| (path.to_path_buf(), text.as_str().into())).collect();
        Self { mentions: found.found.into_iter().collect(), texts }
    }

    /// The name at a byte of a file.
    #[must_use]
    pub fn at(&self, path: &Path, at: usize) -> Option<&Mention> {
        let here =
            self.mentions.iter().filter(|mention| mention.path == path && mention.start <= at && at <= mention.end);
        // A file's name may contain that of something else.
        here.min_by_key(|mention| mention.end - mention.start)
    }

    /// Where the same name is written, in all files.
    pub fn same<'i>(&'i self, mention: &'i Mention) -> impl Iterator<Item = &'i Mention> {
        self.mentions.iter().filter(|other| {
            let is_local = [NameKind::State, NameKind::Table].contains(&mention.kind);
            other.kind == mention.kind && other.name == mention.name && (!is_local || other.path == mention.path)
        })
    }

    /// Whether any file names this one.
    #[must_use]
    pub fn names_file(&self, path: &Path) -> bool {
        let name = path.to_string_lossy();
        self.mentions.iter().any(|mention| mention.kind == NameKind::File && mention.name == name)
    }

    /// What a file defines.
    pub fn defined_in<'i>(&'i self, path: &'i Path) -> impl Iterator<Item = &'i Mention> {
        self.mentions.iter().filter(move |mention| mention.path == path && mention.is_definition)
    }
}

/// The names that any of the files defines.
struct Defined {
    names: BTreeSet<(NameKind, String)>,
}

impl Defined {
    fn has(&self, kind: NameKind, name: &str) -> bool {
        self.names.contains(&(kind, name.to_owned()))
    }

    /// What a text that is exactly such a name stands for.
    fn kind_of(&self, name: &str) -> Option<NameKind> {
        let kinds = [NameKind::Process, NameKind::Place, NameKind::Property];
        kinds.into_iter().find(|kind| self.has(*kind, name))
    }
}

#[derive(Default)]
struct Collector {
    found: BTreeSet<Mention>,
}

impl Collector {
    fn add(&mut self, path: &Path, kind: NameKind, name: &str, range: Range<usize>, is_definition: bool) {
        let Range { start, end } = range;
        let definition =
            Mention { path: path.to_owned(), start, end, kind, name: name.to_owned(), is_definition: true };
        if is_definition || !self.found.contains(&definition) {
            self.found.insert(Mention { is_definition, ..definition });
        }
    }

    fn definitions(&mut self, path: &Path, kind: FileKind, text: &str) {
        match kind {
            FileKind::Tree => self.of_tree(path, text, true),
            FileKind::Machine => self.of_machine(path, text, None),
            FileKind::Properties => {
                for item in parse_file(text).file.items {
                    if let Item::Property(property) = item {
                        let span = property.name.span;
                        self.add(path, NameKind::Property, &property.name.text, span.start..span.end, true);
                    }
                }
            }
            FileKind::Toml(kind) => {
                let (parts, texts) = contents(text);
                let is_end = |text: &&Text| kind == Toml::Mapping && is_end_of_channel(&text.key);
                for end in texts.iter().filter(is_end) {
                    self.add(path, NameKind::Process, &end.value, end.range.clone(), true);
                }
                for part in parts {
                    if part.is_header && kind != Toml::Places {
                        self.add(path, NameKind::Table, &part.name, part.range.clone(), true);
                    }
                    let table: Vec<&str> = part.table.iter().map(String::as_str).collect();
                    match (kind, table.as_slice()) {
                        (Toml::Scenario, ["components"]) => {
                            self.add(path, NameKind::Process, &part.name, part.range, true)
                        }
                        (Toml::Places, []) => self.add(path, NameKind::Place, &part.name, part.range, true),
                        _ => {}
                    }
                }
            }
            FileKind::Model | FileKind::Map | FileKind::PlacesIni => {}
        }
    }

    fn uses(&mut self, path: &Path, kind: FileKind, text: &str, disk: &Disk, defined: &Defined) {
        match kind {
            FileKind::Tree => {
                self.of_tree(path, text, false);
                self.places_in_tree(path, text, defined);
            }
            FileKind::Machine => self.of_machine(path, text, Some(defined)),
            FileKind::Properties => self.in_properties(path, text, defined),
            FileKind::Toml(_) => {
                let (parts, texts) = contents(text);
                for part in parts {
                    // A key that a file chooses is a name: `leaves.NAME`, `prove.expect.NAME`.
                    let chosen = ["leaves", "components", "expect"];
                    let is_chosen = part.table.last().is_some_and(|table| chosen.contains(&table.as_str()));
                    if let Some(kind) = defined.kind_of(&part.name).filter(|_| is_chosen) {
                        self.add(path, kind, &part.name, part.range, false);
                    }
                }
                // Moments have names of their own, such as `start`.
                let is_name =
                    |text: &&Text| text.key.last().is_none_or(|key| key != "about") && text.key != ["snapshots", "at"];
                for text in texts.iter().filter(is_name) {
                    self.in_text(path, text, disk, defined);
                }
            }
            FileKind::Model | FileKind::Map | FileKind::PlacesIni => {}
        }
    }

    /// The names in a string of a TOML file.
    fn in_text(&mut self, path: &Path, text: &Text, disk: &Disk, defined: &Defined) {
        let value = text.value.as_str();
        if let Some(kind) = defined.kind_of(value) {
            self.add(path, kind, value, text.range.clone(), false);
        } else if value.trim_start().starts_with('(') {
            // An event: `(A, B, condition)`.
            for (name, range) in words(value).take(2).filter(|(name, _)| defined.has(NameKind::Process, name)) {
                let range = text.range.start + range.start..text.range.start + range.end;
                self.add(path, NameKind::Process, name, range, false);
            }
        } else if let Some((component, _)) =
            value.split_once('.').filter(|(name, _)| defined.has(NameKind::Process, name))
        {
            let range = text.range.start..text.range.start + component.len();
            self.add(path, NameKind::Process, component, range, false);
        } else if value.contains('.') && path.parent().is_some_and(|folder| disk.is_file(&folder.join(value))) {
            let file = normal(&path.parent().unwrap_or(path).join(value));
            self.add(path, NameKind::File, &file.to_string_lossy(), text.range.clone(), false);
        }
    }

    /// The trees and leaves of a tree's file: those that it defines, or those that it uses.
    fn of_tree(&mut self, path: &Path, text: &str, is_definition: bool) {
        let Some(document) = parsed(text) else { return };
        let is_in_tree = |node: &Node<'_, '_>| node.ancestors().any(|around| around.has_tag_name("BehaviorTree"));
        for node in document.descendants().filter(Node::is_element) {
            let name = node.tag_name().name();
            let id = node.attribute_node("ID");
            let mut add = |kind, attribute: Option<Attribute<'_, '_>>, is| {
                if let Some(attribute) = attribute.filter(|_| is == is_definition) {
                    self.add(path, kind, attribute.value(), attribute.range_value(), is);
                }
            };
            match name {
                "BehaviorTree" => add(NameKind::Tree, id, true),
                "SubTree" => add(NameKind::Tree, id, false),
                "root" => add(NameKind::Tree, node.attribute_node("main_tree_to_execute"), false),
                "Action" | "Condition" if !is_in_tree(&node) => add(NameKind::Process, id, false),
                "Action" | "Condition" => {
                    let own = node.attribute_node("name");
                    let is_named = own.is_some();
                    add(NameKind::Process, own, true);
                    add(NameKind::Process, id, !is_named);
                }
                _ if !is_in_tree(&node) || Kind::BUILTIN.iter().any(|kind| kind.name() == name) => {}
                _ if node.children().any(|child| child.is_element()) => {}
                _ => {
                    let start = node.range().start + 1;
                    let own = node.attribute_node("name");
                    let is_named = own.is_some();
                    add(NameKind::Process, own, true);
                    if is_named != is_definition {
                        self.add(path, NameKind::Process, name, start..start + name.len(), is_definition);
                    }
                }
            }
        }
    }

    fn places_in_tree(&mut self, path: &Path, text: &str, defined: &Defined) {
        let Some(document) = parsed(text) else { return };
        for attribute in document.descendants().flat_map(|node| node.attributes()) {
            if !["ID", "name"].contains(&attribute.name()) && defined.has(NameKind::Place, attribute.value()) {
                self.add(path, NameKind::Place, attribute.value(), attribute.range_value(), false);
            }
        }
    }

    /// The names of a machine's file: those that it defines or, once all are known, those that it uses.
    fn of_machine(&mut self, path: &Path, text: &str, defined: Option<&Defined>) {
        let Some(document) = parsed(text) else { return };
        for node in document.descendants().filter(Node::is_element) {
            for attribute in node.attributes() {
                let (value, range) = (attribute.value(), attribute.range_value());
                // A value with references of XML has other positions than its text.
                let is_plain = text[range.clone()] == *value;
                let Some(defined) = defined else {
                    match (node.tag_name().name(), attribute.name()) {
                        ("scxml", "name") => self.add(path, NameKind::Process, value, range, true),
                        (element, "id") if STATES.contains(&element) => {
                            self.add(path, NameKind::State, value, range, true)
                        }
                        _ => {}
                    }
                    continue;
                };
                let all = || words(value).map(|(name, at)| (name, range.start + at.start..range.start + at.end));
                match (node.tag_name().name(), attribute.name()) {
                    ("send", "target") if defined.has(NameKind::Process, value) => {
                        self.add(path, NameKind::Process, value, range, false);
                    }
                    ("transition", "target") | (_, "initial") if is_plain => {
                        all().for_each(|(name, range)| self.add(path, NameKind::State, name, range, false));
                    }
                    ("transition", "event") if is_plain => {
                        // `Speaker.done`: a message from the process.
                        let processes = all().filter(|(name, range)| {
                            defined.has(NameKind::Process, name)
                                && text[range.end..].starts_with('.')
                                && text[..range.start].ends_with([' ', '"', '\''])
                        });
                        processes.for_each(|(name, range)| self.add(path, NameKind::Process, name, range, false));
                    }
                    (_, "expr" | "cond") if is_plain => {
                        let quoted = all().filter(|(name, range)| {
                            defined.has(NameKind::Place, name)
                                && text[range.end..].starts_with(['\'', '"'])
                                && text[..range.start].ends_with(['\'', '"'])
                        });
                        quoted.for_each(|(name, range)| self.add(path, NameKind::Place, name, range, false));
                    }
                    _ => {}
                }
            }
        }
    }

    fn in_properties(&mut self, path: &Path, text: &str, defined: &Defined) {
        for item in parse_file(text).file.items {
            let Item::Property(property) = item else { continue };
            property.constraint.events(&mut |event| {
                for party in [&event.source, &event.target] {
                    if let Some(name) = party.name().filter(|name| defined.has(NameKind::Process, &name.text)) {
                        self.add(path, NameKind::Process, &name.text, name.span.start..name.span.end, false);
                    }
                }
                let span = event.condition.span;
                for (name, at) in words(&text[span.start..span.end]) {
                    let range = span.start + at.start..span.start + at.end;
                    let around = (text[..range.start].chars().next_back(), text[range.end..].chars().next());
                    let is_value = matches!(around, (Some('<'), Some('>')) | (Some('"'), Some('"')));
                    if is_value && defined.has(NameKind::Place, name) {
                        self.add(path, NameKind::Place, name, range, false);
                    }
                }
            });
        }
    }
}

fn parsed(text: &str) -> Option<Document<'_>> {
    let options = ParsingOptions { nodes_limit: 100_000, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).ok()
}

/// Whether a key of a mapping names a process.
fn is_end_of_channel(key: &[String]) -> bool {
    matches!(key, [messages, end] if messages == "messages" && (end == "from" || end == "to"))
}

/// The words of a text, with their ranges.
fn words(text: &str) -> impl Iterator<Item = (&str, Range<usize>)> {
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    let starts = text.char_indices().filter(move |(at, c)| is_word(*c) && !text[..*at].ends_with(is_word));
    starts.map(move |(at, _)| {
        let end = text[at..].find(|c| !is_word(c)).map_or(text.len(), |length| at + length);
        (&text[at..end], at..end)
    })
}
