//! The modules of a crate, read from its source: which names each of them knows, and which paths it uses.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Ident, Item, ItemMod, ItemUse, Macro, MetaList, UseTree, Visibility};

/// A path as written, without generic arguments.
pub(super) type Names = Vec<String>;

/// The meaning of a name in a module.
pub(super) enum Meaning {
    Item,
    Module(usize),
    Import(Names),
}

/// A module and its contents.
pub(super) struct Module {
    pub(super) file: usize,
    pub(super) parent: usize,
    pub(super) names: Vec<(String, Meaning)>,
    pub(super) globs: Vec<Names>,
    pub(super) uses: BTreeSet<Names>,
}

/// The files and modules of a crate, its root first.
#[derive(Default)]
pub(super) struct Crate {
    pub(super) files: Vec<PathBuf>,
    pub(super) modules: Vec<Module>,
}

impl Crate {
    /// Reads a crate, starting at its `lib.rs` or `main.rs`.
    pub(super) fn read(root: &Path) -> Self {
        let mut read = Self::default();
        read.read_file(root.to_owned(), root.parent().expect("a file lies in a folder"), 0);
        read
    }

    fn read_file(&mut self, path: PathBuf, folder: &Path, parent: usize) -> usize {
        let text = fs::read_to_string(&path).expect("a module has a file");
        self.files.push(path);
        let items = syn::parse_file(&text).expect("the crate compiles").items;
        self.read_module(&items, self.files.len() - 1, folder, parent)
    }

    /// Reads a module whose children lie in `folder`.
    fn read_module(&mut self, items: &[Item], file: usize, folder: &Path, parent: usize) -> usize {
        let id = self.modules.len();
        self.modules.push(Module { file, parent, names: Vec::new(), globs: Vec::new(), uses: BTreeSet::new() });
        let mut reader = Reader { read: self, id, folder };
        items.iter().for_each(|item| reader.visit_item(item));
        id
    }
}

/// Reads the items of one module.
struct Reader<'a> {
    read: &'a mut Crate,
    id: usize,
    folder: &'a Path,
}

impl Reader<'_> {
    fn module(&mut self) -> &mut Module {
        &mut self.read.modules[self.id]
    }

    fn import(&mut self, tree: &UseTree, mut path: Names, public: bool) {
        let (name, known_as) = match tree {
            UseTree::Path(tree) => {
                path.push(tree.ident.to_string());
                return self.import(&tree.tree, path, public);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.import(tree, path.clone(), public));
            }
            UseTree::Glob(_) => return self.module().globs.push(path),
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(name) => (&name.ident, &name.rename),
        };
        if name != "self" {
            path.push(name.to_string());
        }
        let known_as = path.last().filter(|_| known_as == "self").cloned().unwrap_or_else(|| known_as.to_string());
        if !public {
            self.module().uses.insert(path.clone());
        }
        self.module().names.push((known_as, Meaning::Import(path)));
    }

    /// The paths in the arguments of a macro or an attribute, including those in quotes: `#[serde(with =
    /// "plain::pose")]`.
    fn tokens(&mut self, tokens: &str) {
        let text = tokens.replace(" ::", "::").replace(":: ", "::");
        let paths = text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
        self.module().uses.extend(paths.map(|path| path.split("::").map(str::to_owned).collect()));
    }
}

/// An item's attributes and, if it defines one, its name.
fn heading(item: &Item) -> (&[Attribute], Option<&Ident>) {
    match item {
        Item::Const(item) => (&item.attrs, Some(&item.ident)),
        Item::Enum(item) => (&item.attrs, Some(&item.ident)),
        Item::Fn(item) => (&item.attrs, Some(&item.sig.ident)),
        Item::Static(item) => (&item.attrs, Some(&item.ident)),
        Item::Struct(item) => (&item.attrs, Some(&item.ident)),
        Item::Trait(item) => (&item.attrs, Some(&item.ident)),
        Item::Type(item) => (&item.attrs, Some(&item.ident)),
        Item::Impl(item) => (&item.attrs, None),
        Item::Mod(item) => (&item.attrs, None),
        Item::Use(item) => (&item.attrs, None),
        _ => (&[], None),
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        let (attributes, name) = heading(item);
        let mut lists = attributes.iter().filter_map(|attribute| attribute.meta.require_list().ok());
        if lists.any(|list| list.path.is_ident("cfg") && list.tokens.to_string() == "test") {
            return;
        }
        if let Some(name) = name {
            self.module().names.push((name.to_string(), Meaning::Item));
        }
        visit::visit_item(self, item);
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        let name = item.ident.to_string();
        let (folder, file, id) = (self.folder.join(&name), self.module().file, self.id);
        let child = if let Some((_, items)) = &item.content {
            self.read.read_module(items, file, &folder, id)
        } else {
            self.read.read_file(self.folder.join(format!("{name}.rs")), &folder, id)
        };
        self.module().names.push((name, Meaning::Module(child)));
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.import(&item.tree, Names::new(), !matches!(item.vis, Visibility::Inherited));
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.module().uses.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast Macro) {
        self.tokens(&call.tokens.to_string());
    }

    fn visit_meta_list(&mut self, list: &'ast MetaList) {
        self.tokens(&list.tokens.to_string());
    }
}
