//! The files that are open in an editor, checked together with those to which they belong.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use checks::findings::{self, Findings};
use checks::{Examined, FileKind, System, Toml};
use diagnostics::{Disk, FileStamp, Memo, Reads, normal};
use scenarios::scenario::{Scenario, find};

use crate::text::{MARK, TextLines};

/// The texts that are open in an editor.
#[derive(Clone, Debug, Default)]
pub struct Documents {
    /// By [normal] path, without byte order marks.
    pub open: BTreeMap<PathBuf, Arc<str>>,
    /// The paths of those that begin with a byte order mark.
    pub marked: BTreeSet<PathBuf>,
    /// The folders in which the editor works: scenarios of an open file are looked up in its folder and in those around
    /// it, up to one of these.
    pub folders: Vec<PathBuf>,
}

impl Documents {
    /// The disk with these texts.
    #[must_use]
    pub fn disk(&self) -> Disk {
        Disk::with_open(self.open.iter().map(|(path, text)| (path.clone(), Arc::clone(text))))
    }

    /// Opens a file, or replaces its text.
    pub fn put(&mut self, path: PathBuf, text: &str) {
        let unmarked = text.strip_prefix(MARK);
        match unmarked {
            Some(_) => self.marked.insert(path.clone()),
            None => self.marked.remove(&path),
        };
        self.open.insert(path, unmarked.unwrap_or(text).into());
    }

    /// The text of an open file, as the editor has it.
    #[must_use]
    pub fn whole(&self, path: &Path) -> Option<String> {
        let mark = if self.marked.contains(path) { MARK } else { "" };
        Some(format!("{mark}{}", self.open.get(path)?))
    }

    /// The lines of a file's text, as the editor counts them.
    #[must_use]
    pub fn lines<'t>(&self, path: &Path, text: &'t str) -> TextLines<'t> {
        let lines = TextLines::of(text);
        if self.marked.contains(path) { lines.after_mark() } else { lines }
    }

    /// The kinds of these documents, and of the saved files in the folders where their scenarios may be.
    fn kinds(&self) -> Kinds {
        let folders: BTreeSet<&Path> = self.open.keys().flat_map(|document| self.around(document)).collect();
        let entries = folders.into_iter().flat_map(fs::read_dir).flatten().flatten();
        let paths: BTreeSet<PathBuf> =
            entries.map(|entry| normal(&entry.path())).chain(self.open.keys().cloned()).collect();
        let disk = self.disk();
        let with_kind = |path: PathBuf| FileKind::of_document(&disk, &path).map(|kind| (path, kind));
        paths.into_iter().filter_map(with_kind).collect()
    }

    /// The folders in which the scenarios of an open file may be.
    fn around<'p>(&self, file: &'p Path) -> impl Iterator<Item = &'p Path> {
        let below = |file: &Path, folder: &Path| file.strip_prefix(folder).ok().map(|below| below.components().count());
        let as_named = self.folders.iter().filter_map(|folder| below(file, folder)).max();
        // The editor may name the folder or the file through a link.
        let real = || {
            let file = fs::canonicalize(file.parent()?).ok()?.join(file.file_name()?);
            self.folders.iter().filter_map(|folder| below(&file, &fs::canonicalize(folder).ok()?)).max()
        };
        file.ancestors().skip(1).take(as_named.or_else(real).unwrap_or(1))
    }
}

/// Files by [normal] path, with the kind of each. Those of other programs are left out.
type Kinds = BTreeMap<PathBuf, FileKind>;

/// Checks open documents after every edit. What has not changed since is not checked again.
///
/// A document that a scenario near it reads is checked with this scenario, as `steward check SCENARIO` does; properties
/// that none reads, with a mapping near them, as `steward check FILE --scenario MAPPING` does; any other alone. As long
/// as its scenario cannot be read, only that is found which is wrong in any scenario.
#[derive(Debug, Default)]
pub struct Project {
    known: BTreeMap<PathBuf, Root>,
    /// The scenario to which files belong that no other scenario reads, once needed.
    nominal: Option<Option<Arc<Scenario>>>,
}

/// What belongs to a file.
#[derive(Clone, Debug, Default)]
pub struct FileContext {
    /// The scenarios that read it, as far as they could be loaded, or as they were when they could.
    pub scenarios: Vec<Arc<Scenario>>,
    /// The robot that its mapping described when it could last be read, if it is one of properties without a scenario.
    pub mapped: Option<System>,
    /// All files that these read, whether they exist or not, with the file itself.
    pub files: BTreeSet<PathBuf>,
}

/// What a check has found, and learned.
#[derive(Debug)]
pub struct CheckedDocuments {
    /// By file.
    pub findings: Findings,
    /// What belongs to each open document.
    pub contexts: BTreeMap<PathBuf, FileContext>,
    /// The files that each scenario near an open document reads, with its own.
    pub scenarios: Vec<BTreeSet<PathBuf>>,
}

/// A checked file.
#[derive(Debug)]
struct Root {
    /// As what it was checked: what is being written may have another kind at the next look.
    kind: FileKind,
    /// The mappings to one of which it belongs.
    mappings: Vec<PathBuf>,
    /// The robot, as it was when one of them could last be read.
    mapped: Option<System>,
    reads: Reads,
    /// The state of each file that was requested.
    stamps: BTreeMap<PathBuf, Stamp>,
    findings: Findings,
    is_refused: bool,
    text: Arc<str>,
    /// The scenario, as far as it could be loaded, or as it was when it could.
    scenario: Option<Arc<Scenario>>,
    /// What was made of its files.
    memo: Arc<Memo>,
}

/// What distinguishes one state of a file from another.
#[derive(Clone, Debug)]
enum Stamp {
    Open(Arc<str>),
    Saved(Option<FileStamp>),
}

impl PartialEq for Stamp {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Open(one), Self::Open(other)) => Arc::ptr_eq(one, other) || one == other,
            (Self::Saved(one), Self::Saved(other)) => one == other,
            _ => false,
        }
    }
}

impl Stamp {
    fn of(path: &Path, documents: &Documents) -> Self {
        Self::open(path, documents).unwrap_or_else(|| Self::Saved(FileStamp::of(path)))
    }

    fn open(path: &Path, documents: &Documents) -> Option<Self> {
        documents.open.get(path).map(|text| Self::Open(Arc::clone(text)))
    }
}

impl Project {
    /// What is wrong with the open documents and with the scenarios that read them, and what belongs to them.
    pub fn check(&mut self, documents: &Documents) -> CheckedDocuments {
        let kinds = documents.kinds();
        let (roots, unread) = self.sorted(documents, &kinds);
        let mut findings = Findings::new();
        roots
            .iter()
            .filter_map(|root| self.known.get(root))
            .for_each(|root| findings::merge(&mut findings, &root.findings));
        for (path, kind) in unread {
            let disk = documents.disk().remembering();
            let checked = kind.examine_alone(&disk, path);
            let found = findings::of_check(path, &documents.open[path], &checked, &disk.reads());
            findings::merge(&mut findings, &found);
        }
        let open = documents.open.keys();
        let context = |document: &PathBuf| (document.clone(), self.context(document, kinds.get(document), &roots));
        let contexts = open.map(context).collect();
        let scenarios = self.known.values().map(|root| root.reads.paths.keys().cloned().collect()).collect();
        CheckedDocuments { findings, contexts, scenarios }
    }

    fn context(&mut self, document: &Path, kind: Option<&FileKind>, roots: &BTreeSet<PathBuf>) -> FileContext {
        let roots = roots.iter().filter_map(|root| self.known.get(root));
        let reads: Vec<&Root> = roots.filter(|root| root.reads.paths.contains_key(document)).collect();
        let files = reads.iter().flat_map(|root| root.reads.paths.keys().cloned());
        let files = files.chain([document.to_owned()]).collect();
        let mut scenarios: Vec<Arc<Scenario>> = reads.iter().filter_map(|root| root.scenario.clone()).collect();
        let mapped = reads.iter().find_map(|root| root.mapped.clone());
        let needs_scenario = kind.is_some_and(needs_scenario);
        if scenarios.is_empty() && reads.iter().all(|root| root.mappings.is_empty()) && needs_scenario {
            // As `steward check` does.
            let nominal = self.nominal.get_or_insert_with(|| {
                let found = find::find("nominal").ok()?;
                Some(Arc::new(Scenario::load(&found, &[]).ok()?))
            });
            scenarios.extend(nominal.clone());
        }
        FileContext { scenarios, mapped, files }
    }

    /// The files to check for the open documents. They have been checked.
    pub fn roots(&mut self, documents: &Documents) -> BTreeSet<PathBuf> {
        self.sorted(documents, &documents.kinds()).0
    }

    /// The files to check, which have been checked, and the documents that these do not read, or may not have looked at
    /// to the end: they belong to a scenario that is refused.
    fn sorted<'d>(
        &mut self,
        documents: &'d Documents,
        kinds: &Kinds,
    ) -> (BTreeSet<PathBuf>, Vec<(&'d PathBuf, FileKind)>) {
        let (mut roots, mut unread, mut used) = (BTreeSet::new(), Vec::new(), BTreeSet::new());
        for document in documents.open.keys() {
            // A part of a scenario may be too broken to have a kind.
            let kind = kinds.get(document).copied();
            let dependent = kind.filter(needs_scenario);
            let scenarios = self.scenarios_of(document, dependent.is_some(), documents, kinds, &mut used);
            if scenarios.is_empty() {
                let Some(kind) = kind else { continue };
                self.refresh(document, kind, documents, mappings_of(document, kind, documents, kinds));
                roots.insert(document.clone());
            } else if let Some(kind) = dependent
                && scenarios
                    .iter()
                    .map(|scenario| &self.known[*scenario])
                    .all(|root| !root.reads.paths.contains_key(document) || root.is_refused)
            {
                unread.push((document, kind));
            }
            roots.extend(scenarios.into_iter().cloned());
        }
        used.extend(roots.iter().cloned());
        self.known.retain(|path, _| used.contains(path));
        (roots, unread)
    }

    /// The scenarios to which a document belongs: those that read it and, if it has no meaning without one, those that
    /// are refused before they read it but mention it. All that were considered are added to `used`.
    fn scenarios_of<'u>(
        &mut self,
        document: &Path,
        needs_scenario: bool,
        documents: &Documents,
        kinds: &Kinds,
        used: &'u mut BTreeSet<PathBuf>,
    ) -> Vec<&'u PathBuf> {
        let mut belongs_to = Vec::new();
        for (candidate, kind) in documents.around(document).flat_map(|folder| files_in(folder, kinds, is_scenario)) {
            let root = self.refresh(candidate, kind, documents, Vec::new());
            let may_read = || needs_scenario && root.is_refused && mentions(&root.text, document);
            if root.reads.paths.contains_key(document) || may_read() {
                belongs_to.push(candidate);
            }
            used.insert(candidate.clone());
        }
        used.iter().filter(|path| belongs_to.contains(path)).collect()
    }

    /// The result of a check of this file, as it is now.
    fn refresh(&mut self, path: &Path, kind: FileKind, documents: &Documents, mappings: Vec<PathBuf>) -> &Root {
        let is_same = |(path, stamp): (&PathBuf, &Stamp)| Stamp::of(path, documents) == *stamp;
        let is_fresh = |root: &Root| root.kind == kind && root.mappings == mappings && root.stamps.iter().all(is_same);
        if !self.known.get(path).is_some_and(is_fresh) {
            let before = self.known.remove(path);
            self.known.insert(path.to_owned(), Root::check(path, kind, documents, mappings, before));
        }
        &self.known[path]
    }
}

impl Root {
    fn check(path: &Path, kind: FileKind, documents: &Documents, mappings: Vec<PathBuf>, before: Option<Self>) -> Self {
        let memo = before.as_ref().map(|before| Arc::clone(&before.memo)).unwrap_or_default();
        let disk = documents.disk().remembering().with_memo(&memo);
        let text: Arc<str> = disk.read_text(path).unwrap_or_default().into();
        let with_mapping = |mapping: &PathBuf| kind.examine(&disk, path, Some(&mapping.to_string_lossy()));
        // Of several mappings, the first with which nothing is wrong.
        let mut tried: Vec<Examined> = mappings.iter().map(with_mapping).collect();
        let best = tried.iter().position(|examined| examined.result.is_ok()).unwrap_or(0);
        let examined = if tried.is_empty() { kind.examine(&disk, path, None) } else { tried.swap_remove(best) };
        let Examined { result: checked, scenario, system: mapped } = examined;
        if checked.is_ok() {
            // What is refused may not have used all of its files.
            memo.forget_unused();
        }
        let scenario = scenario.map(|scenario| match before.as_ref().and_then(|before| before.scenario.as_deref()) {
            Some(before) if checked.is_err() => Arc::new(Scenario::clone(&scenario).with_machines_of(before)),
            _ => scenario,
        });
        let mapped_before = || before.as_ref().filter(|before| before.mappings == mappings)?.mapped.clone();
        let mapped = mapped.or_else(mapped_before);
        let reads = disk.reads();
        let stamp = |(path, saved): (&PathBuf, &Option<FileStamp>)| {
            (path.clone(), Stamp::open(path, documents).unwrap_or(Stamp::Saved(*saved)))
        };
        Self {
            kind,
            mappings,
            mapped,
            stamps: reads.paths.iter().map(stamp).collect(),
            findings: findings::of_check(path, &text, &checked, &reads),
            is_refused: checked.is_err(),
            reads,
            text,
            scenario: scenario.or(before.and_then(|before| before.scenario)),
            memo,
        }
    }
}

/// The files of some kinds in a folder, in alphabetical order.
fn files_in<'k>(
    folder: &Path,
    kinds: &'k Kinds,
    is_wanted: impl Fn(FileKind) -> bool,
) -> impl Iterator<Item = (&'k PathBuf, FileKind)> {
    let here = kinds.iter().filter(move |(path, kind)| path.parent() == Some(folder) && is_wanted(**kind));
    here.map(|(path, kind)| (path, *kind))
}

fn is_scenario(kind: FileKind) -> bool {
    matches!(kind, FileKind::Model | FileKind::Toml(Toml::Scenario))
}

/// Whether what is wrong with such a file depends on the scenario to which it belongs.
fn needs_scenario(kind: &FileKind) -> bool {
    matches!(kind, FileKind::Machine | FileKind::Properties | FileKind::Toml(Toml::Interface))
}

/// The mappings to which properties without a scenario may belong: those in the nearest folder that has any.
fn mappings_of(document: &Path, kind: FileKind, documents: &Documents, kinds: &Kinds) -> Vec<PathBuf> {
    let is_mapping = |kind| kind == FileKind::Toml(Toml::Mapping);
    let mut folders = documents.around(document).filter(|_| kind == FileKind::Properties);
    let found = folders.find_map(|folder| {
        let found: Vec<PathBuf> = files_in(folder, kinds, is_mapping).map(|(path, _)| path.clone()).collect();
        Some(found).filter(|found| !found.is_empty())
    });
    found.unwrap_or_default()
}

/// Whether the text of a scenario has the name of a file or of its folder.
fn mentions(text: &str, file: &Path) -> bool {
    let names = [file.file_stem(), file.parent().and_then(Path::file_name)];
    names.into_iter().flatten().any(|name| text.contains(&*name.to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use scenarios::scenario::Premises;

    use super::*;

    /// Whether both have the same of each kind of file, not merely equal ones: the tree, the first skill, the second
    /// skill, the component, the map.
    fn shared(one: &Scenario, other: &Scenario) -> [bool; 5] {
        let same_machine = |name: &str| {
            let machine = |of: &Scenario| {
                Arc::clone(&of.machine_processes().find(|(known, _)| *known == name).unwrap().1.machine)
            };
            Arc::ptr_eq(&machine(one), &machine(other))
        };
        let same_tree = Arc::ptr_eq(one.tree().unwrap(), other.tree().unwrap());
        let map = |of: &Scenario| of.premises.as_ref().map(|Premises { map, .. }| Arc::clone(map)).unwrap();
        let same_map = Arc::ptr_eq(&map(one), &map(other));
        [same_tree, same_machine("AnnounceArrival"), same_machine("Again"), same_machine("Speaker"), same_map]
    }

    #[test]
    fn a_keystroke_parses_the_edited_file_only() {
        let folder = tempfile::tempdir().unwrap();
        let root = normal(&folder.path().canonicalize().unwrap());
        let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../skills/examples");
        let example = |name: &str| fs::read_to_string(examples.join(name)).unwrap();
        let leaf = example("AnnounceArrival.scxml");
        let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence><AnnounceArrival/><Again/></Sequence></BehaviorTree>
            <TreeNodesModel><Action ID="AnnounceArrival"/><Action ID="Again"/></TreeNodesModel></root>"#;
        let main = "base = \"nominal\"\ntree = \"tree.xml\"\nskills = \".\"\nproperties = []\nexpect = {}\n\
                    components.Speaker = { machine = \"Speaker.scxml\", interface = \"speaker.toml\" }\n";
        let mut documents = Documents { folders: vec![root.clone()], ..Documents::default() };
        for (name, text) in [
            ("main.toml", main),
            ("tree.xml", tree),
            ("AnnounceArrival.scxml", &leaf),
            ("Again.scxml", &leaf.replace("name=\"AnnounceArrival\"", "name=\"Again\"")),
            ("Speaker.scxml", &example("Speaker.scxml")),
            ("speaker.toml", &example("speaker.toml")),
        ] {
            fs::write(root.join(name), text).unwrap();
            documents.put(root.join(name), text);
        }
        let mut project = Project::default();
        let mut check = |documents: &Documents| {
            let checked = project.check(documents);
            assert!(checked.findings.is_empty(), "{:?}", checked.findings);
            Arc::clone(&checked.contexts[&root.join("main.toml")].scenarios[0])
        };
        let mut before = check(&documents);
        for (file, expected) in [
            ("main.toml", [true; 5]),
            ("tree.xml", [false, true, true, true, true]),
            ("Again.scxml", [true, true, false, true, true]),
            ("Speaker.scxml", [true, true, true, false, true]),
            ("speaker.toml", [true; 5]),
        ] {
            documents.put(root.join(file), &format!("{}\n", documents.open[&root.join(file)]));
            let after = check(&documents);
            assert_eq!(shared(&before, &after), expected, "{file}");
            before = after;
        }
    }
}
