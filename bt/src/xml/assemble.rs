//! Assembles the main tree with its subtrees.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use diagnostics::{Problem, Source};
use miette::SourceSpan;

use super::compile::{Compiler, Surroundings};
use super::loader::Loader;
use super::ports::is_port_name;
use super::problems::{known_names, suggestion, too_deep, too_large, too_many};
use super::source_file::SourceFile;
use super::warnings::Assembled;
use crate::blackboard::{Clash, Declared, Scope, ScopeId, Scopes, Slot, Type, braced_key, pointed_key};
use crate::library::{Definition, Library, Model, Scanned};
use crate::node::name_processes;
use crate::program::{Flags, Op, Program};
use crate::script::Names;
use crate::settings::{Constants, Nav2, Setting};
use crate::{Category, Kind, Node, NodeId, Tree};

/// The trees of a file by ID; of two with the same ID, the first.
pub(super) struct Index<'a>(BTreeMap<&'a str, usize>);

impl<'a> Index<'a> {
    pub(super) fn new(definitions: &'a [Definition]) -> Self {
        let ids = definitions.iter().enumerate().rev();
        Self(ids.filter_map(|(index, definition)| Some((definition.id.as_deref()?, index))).collect())
    }

    pub(super) fn find(&self, id: &str) -> Option<usize> {
        self.0.get(id).copied()
    }

    pub(super) fn ids(&self) -> impl Iterator<Item = &'a str> + Clone {
        self.0.keys().copied()
    }
}

/// Checks that every subtree exists and that no tree contains itself.
pub(super) fn check_references(definitions: &[Definition], index: &Index<'_>, files: &mut [SourceFile]) {
    let mut references: Vec<Vec<(usize, SourceSpan)>> = Vec::new();
    for definition in definitions {
        let mut found = Vec::new();
        for node in definition.nodes.iter().filter(|node| node.kind == Kind::SubTree) {
            let id = &node.type_id;
            match index.find(id) {
                Some(target) => found.push((target, node.span)),
                None => {
                    let problems = &mut files[definition.file].problems;
                    let include = "a tree of another file needs <include path=\"FILE.xml\"/> above the trees";
                    let help = suggestion(id, index.ids(), problems.len()).unwrap_or_else(|| {
                        let known = known_names(index.ids(), problems.len());
                        known.into_iter().chain([include.to_owned()]).collect::<Vec<_>>().join("; ")
                    });
                    let problem = Problem::new(format!("unknown tree `{id}`")).at(node.span, "no such tree");
                    problems.push(problem.with_help(help));
                }
            }
        }
        references.push(found);
    }
    let visits = vec![Visit::Open; definitions.len()];
    let mut search = CycleSearch { definitions, references, files, path: Vec::new(), visits };
    for start in 0..definitions.len() {
        search.visit(start);
    }
}

/// A depth-first search for trees that contain themselves.
struct CycleSearch<'a> {
    definitions: &'a [Definition],
    /// By tree: its subtrees, with their positions.
    references: Vec<Vec<(usize, SourceSpan)>>,
    files: &'a mut [SourceFile],
    /// The trees from the start of the search to the current one, with the number of references followed in each.
    path: Vec<(usize, usize)>,
    visits: Vec<Visit>,
}

/// The progress of the search at a tree.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    /// Not visited yet.
    Open,
    /// The tree is on the path, at this index.
    OnPath(usize),
    Done,
}

impl CycleSearch<'_> {
    fn visit(&mut self, start: usize) {
        if self.visits[start] == Visit::Open {
            self.enter(start);
        }
        // The path is a list and not a recursion: a file may nest as many trees as it has.
        while let Some((tree, followed)) = self.path.last_mut() {
            let tree = *tree;
            let Some(&(target, span)) = self.references[tree].get(*followed) else {
                self.visits[tree] = Visit::Done;
                self.path.pop();
                continue;
            };
            *followed += 1;
            match self.visits[target] {
                Visit::Open => self.enter(target),
                Visit::OnPath(first) => {
                    let cycle = self.circle(first, target);
                    let problem = Problem::new(format!("a tree would contain itself: {}", cycle.join(" → ")));
                    let help = "trees cannot be recursive; repeat a tree by ticking it again";
                    let problem = problem.at(span, "this closes the cycle").with_help(help);
                    self.files[self.definitions[tree].file].problems.push(problem);
                }
                Visit::Done => {}
            }
        }
    }

    fn enter(&mut self, tree: usize) {
        self.visits[tree] = Visit::OnPath(self.path.len());
        self.path.push((tree, 0));
    }

    /// The IDs of the trees on the path from there to its end, and of the target; if there are many, only the first and
    /// the last.
    fn circle(&self, first: usize, target: usize) -> Vec<String> {
        const SHOWN: usize = 5;
        let id = |tree: usize| self.definitions[tree].id.clone();
        let ids = |part: &[(usize, usize)]| part.iter().filter_map(|(tree, _)| id(*tree)).collect::<Vec<String>>();
        let path = &self.path[first..];
        let mut circle = if path.len() <= 2 * SHOWN {
            ids(path)
        } else {
            [ids(&path[..SHOWN]), vec!["…".to_owned()], ids(&path[path.len() - SHOWN..])].concat()
        };
        circle.extend(id(target));
        circle
    }
}

/// Assembles the main tree. All subtrees exist and none contains itself.
pub(super) fn assemble(
    loader: &Loader,
    sources: &[Source],
    library: &Arc<Library>,
    main: usize,
    files: &mut [SourceFile],
) -> Option<Tree> {
    let definitions = &library.definitions;
    let index = &Index::new(definitions);
    let names = Directory {
        scopes: Scopes::default(),
        declared: Declared::default(),
        scope: Scopes::ROOT,
        memos: 0,
        watched: Vec::new(),
        constants: Arc::clone(&loader.constants),
    };
    let (nodes, program) = (Vec::new(), Program::default());
    let mut assembly = Assembly { loader, library, index, nodes, program, ports: 0, names, files };
    if let Err((file, problem)) = assembly.place(main) {
        files[file].problems.push(problem);
        return None;
    }
    let Assembly { mut nodes, mut program, names, .. } = assembly;
    // What depends on the whole tree is determined only now.
    end_subtrees(&mut nodes, &mut program);
    count_children(&mut program);
    let Directory { scopes, declared, .. } = &names;
    Assembled { nodes: &nodes, program: &program, scopes, declared }.warn(files);
    name_processes(&mut nodes);
    program.entries = names.declared.entries;
    program.scopes = Arc::new(names.scopes);
    program.memos = names.memos;
    program.watched = names.watched;
    let file_stem = || Path::new(sources[0].name()).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = definitions[main].id.clone().or_else(file_stem).unwrap_or_default();
    let sources = sources.to_vec();
    let tree = Tree { name, nodes, program, sources, library: Arc::clone(library), main, concerns: None };
    for (file, problem) in tree.entry_concerns() {
        files[file].problems.push(problem);
    }
    Some(tree)
}

/// Sets where each node's subtree ends: where that of its last child does.
fn end_subtrees(nodes: &mut [Node], program: &mut Program) {
    // Children come after their parents, so from the last node backward, each subtree is complete when it is passed on.
    for index in (1..nodes.len()).rev() {
        let end = nodes[index].subtree_end;
        let parent = nodes[index].parent.expect("only the root has no parent");
        let parent_end = &mut nodes[parent.index()].subtree_end;
        *parent_end = end.max(*parent_end);
    }
    for (op, node) in program.ops.iter_mut().zip(nodes) {
        op.end = node.subtree_end;
    }
}

/// Gives each PersistentSequence the number of its children, which is known only now.
fn count_children(program: &mut Program) {
    let sequences = (0..).zip(&program.ops).filter(|(_, op)| op.kind == Kind::PersistentSequence);
    let counts: Vec<_> = sequences.map(|(node, op)| (op.place, program.children(node).count())).collect();
    for (place, children) in counts {
        if let Setting::Nav2(nav2) = &mut program.settings[place as usize]
            && let Nav2::Index(index) = &mut **nav2
        {
            index.children = children;
        }
    }
}

struct Assembly<'a> {
    loader: &'a Loader,
    library: &'a Library,
    index: &'a Index<'a>,
    nodes: Vec<Node>,
    program: Program,
    /// The number of ports declared by the models of the nodes placed so far.
    ports: usize,
    names: Directory,
    files: &'a mut [SourceFile],
}

/// The maximum number of declared ports per allowed node of a tree, on average: a node that is inserted many times
/// copies its model's ports each time, so a small file could need much memory. Nav2's nodes have at most 18.
const PORTS_PER_NODE: usize = 20;

/// A tree that is being placed: the ids of its nodes so far, and their number.
struct Placing {
    definition: usize,
    /// The node of the tree, if it is a subtree.
    under: Option<NodeId>,
    places: Vec<NodeId>,
    scope: ScopeId,
}

impl Assembly<'_> {
    /// Places a tree and, depth first, all its subtrees. A tree that becomes too large is reported as a problem of a
    /// file.
    fn place(&mut self, main: usize) -> Result<(), (usize, Problem)> {
        let scope = self.names.scopes.push(Scope::default());
        let mut stack = vec![Placing { definition: main, under: None, places: Vec::new(), scope }];
        let library = self.library;
        while let Some(placing) = stack.last_mut() {
            let definition = &library.definitions[placing.definition];
            let Some(scanned) = definition.nodes.get(placing.places.len()) else {
                stack.pop();
                continue;
            };
            let parent = scanned.parent.map(|place| placing.places[place]).or(placing.under);
            self.names.scope = placing.scope;
            let file = definition.file;
            let id = self.push(scanned, parent, file).map_err(|problem| (file, problem))?;
            placing.places.push(id);
            if scanned.kind == Kind::SubTree {
                let scope = self.subtree_scope(scanned, placing.scope);
                let definition = self.index.find(&scanned.type_id).expect("all subtrees have been found already");
                stack.push(Placing { definition, under: Some(id), places: Vec::new(), scope });
            }
        }
        Ok(())
    }

    fn push(&mut self, scanned: &Scanned, parent: Option<NodeId>, file: usize) -> Result<NodeId, Problem> {
        let &Scanned { kind, span, .. } = scanned;
        let depth = parent.map_or(0, |parent| self.nodes[parent.index()].depth + 1);
        if depth >= self.loader.max_depth {
            return Err(too_deep(self.loader.max_depth, span));
        }
        let limit = self.loader.max_nodes;
        let id = u32::try_from(self.nodes.len()).ok().filter(|_| self.nodes.len() < limit);
        let Some(id) = id else { return Err(too_large(limit, span)) };
        let model = self.library.model(&scanned.type_id);
        self.ports += model.map_or(0, |model| model.ports.len());
        if self.ports > limit.saturating_mul(PORTS_PER_NODE) {
            return Err(too_many("ports in all", limit.saturating_mul(PORTS_PER_NODE), span));
        }
        self.compile(scanned, model, id, parent, file);
        let attributes = scanned.attributes.iter().map(|kept| (kept.name.clone(), kept.value.clone())).collect();
        let (type_id, number, subtree_end) = (scanned.type_id.clone(), NodeId(id), id + 1);
        let process = String::new();
        self.nodes.push(Node { number, kind, type_id, attributes, span, file, parent, depth, subtree_end, process });
        Ok(NodeId(id))
    }

    fn compile(&mut self, scanned: &Scanned, model: Option<&Model>, id: u32, parent: Option<NodeId>, file: usize) {
        let &Scanned { kind, span, ref attributes, ref type_id, .. } = scanned;
        let problems = &mut self.files[file].problems;
        let mut compiler = Compiler { kind, name: type_id, attributes, span, names: &mut self.names, problems };
        let mut flags = Flags::default();
        if let Some(hooks) = compiler.hooks() {
            flags.add(Flags::ENTRANCE, hooks.has_entrance());
            flags.add(Flags::EXIT, hooks.has_exit());
            flags.add(Flags::HALTED, hooks.on_halted.is_some());
            self.program.hooks.insert(id, hooks);
        }
        let place = if kind.is_leaf() {
            self.program.leaves.push(compiler.leaf_ports(model));
            self.program.leaves.len()
        } else {
            let setting = compiler.setting();
            flags.add(Flags::READS, !setting.is_constant());
            if let Some(key) = setting.named_key() {
                self.names.scopes.mention(self.names.scope, &key);
            }
            self.program.settings.push(setting);
            self.program.settings.len()
        };
        let place = u32::try_from(place - 1).expect("there are no more places than nodes");
        self.program.ops.push(Op { kind, flags, parent: parent.map_or(0, |id| id.0), end: id + 1, place });
    }

    /// The scope of a subtree: the keys that its attributes remap or set to a value.
    fn subtree_scope(&mut self, scanned: &Scanned, parent: ScopeId) -> ScopeId {
        let autoremap =
            scanned.attribute("_autoremap").is_some_and(|value| matches!(value, "1" | "true" | "True" | "TRUE"));
        let mut scope = Scope { parent: Some(parent), autoremap, ..Scope::default() };
        let given = scanned.attributes.iter().map(|attribute| (attribute.name.as_str(), attribute.value.as_str()));
        let given: BTreeMap<&str, &str> = given.filter(|(name, _)| is_port_name(name)).collect();
        let model = self.library.model(&scanned.type_id).filter(|model| model.category == Category::SubTree);
        // With `_autoremap`, a port without an attribute is the parent's entry of that name, whatever its default is.
        let declared =
            model.iter().flat_map(|model| &model.ports).filter(|port| !autoremap && !given.contains_key(&*port.name));
        let defaults = declared.filter_map(|port| Some((port.name.as_str(), port.default.as_deref()?)));
        let defaults = defaults.map(|(name, value)| (name, value, braced_key(value)));
        // In a subtree, `=` without braces has no meaning, and in its defaults, neither form has one.
        let given =
            given.iter().map(|(name, value)| (*name, *value, pointed_key(name, value).filter(|_| *value != "=")));
        let mut constants = Vec::new();
        for (name, value, key) in given.chain(defaults) {
            match key {
                Some(key) => {
                    self.names.scopes.mention(parent, key);
                    scope.remapped.insert(name.to_owned(), key.to_owned());
                }
                None => {
                    scope.constants.insert(name.to_owned(), ());
                    constants.push((name, value));
                }
            }
        }
        let scope = self.names.scopes.push(scope);
        for (name, value) in constants {
            let slot = self.names.scopes.slot(scope, name);
            self.names.declared.constant(slot, value);
        }
        scope
    }
}

/// The names of the tree that has been assembled so far.
struct Directory {
    scopes: Scopes,
    declared: Declared,
    /// The scope of the current node.
    scope: ScopeId,
    memos: usize,
    watched: Vec<Slot>,
    constants: Arc<Constants>,
}

impl Names for Directory {
    fn constant(&self, name: &str) -> Option<i64> {
        self.constants.get(name).copied()
    }

    fn slot(&mut self, name: &str) -> Slot {
        self.scopes.named_slot(self.scope, name)
    }
}

impl Surroundings for Directory {
    fn scope(&self) -> ScopeId {
        self.scope
    }

    fn port(&mut self, key: &str, of: &Type) -> (Slot, Option<Clash>) {
        let slot = self.scopes.named_slot(self.scope, key);
        (slot, self.declared.port(slot, of))
    }

    fn any_port(&mut self, key: &str) -> Slot {
        let slot = self.scopes.named_slot(self.scope, key);
        self.declared.any_port(slot);
        slot
    }

    fn is_own(&self, key: &str) -> bool {
        key.starts_with('@') || self.scopes.resolve(self.scope, key).0 == self.scope
    }

    fn next_memo(&mut self) -> usize {
        self.memos += 1;
        self.memos - 1
    }

    fn watch(&mut self, slot: Slot) -> usize {
        self.watched.push(slot);
        self.watched.len() - 1
    }

    fn unknown_port(&mut self, key: &str) -> Slot {
        let slot = self.scopes.named_slot(self.scope, key);
        self.declared.unknown_port(slot);
        slot
    }

    fn constants(&self) -> Arc<Constants> {
        Arc::clone(&self.constants)
    }
}
