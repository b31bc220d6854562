//! Circular dependencies: nothing in a circle can be understood, tested or moved without the rest of it.
//!
//! There are circles of files and circles of modules. A file uses another if it names an item that the other defines,
//! through any re-exports. `mod` and `pub use` alone do not count: a facade is not a user. Nor is a unit test. Method
//! calls are not detected.
//!
//! A module is a file together with those in its folder. It uses a sibling if any of its files uses any of the
//! sibling's. So two modules may form a circle although none of their files do: `a.rs` uses `b/x.rs`, and `b/y.rs`
//! uses `a.rs`. Between a module's own file and its submodules only circles of files count, since they lie in one
//! place and are moved together.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use pathfinding::prelude::strongly_connected_components;

use super::modules::{Crate, Meaning, Names};
use crate::workspace::metadata;

/// The known circles of files, at most two per crate with at most three files each, and the reason for each, in the
/// words of ARCHITECTURE.md.
const CIRCLES: [(&[&str], &str); 2] = [
    (
        &["diagnostics/src/document/field.rs", "diagnostics/src/document/item.rs", "diagnostics/src/document/table.rs"],
        "a table hands out fields, a field reports to its table, and an item may be a table",
    ),
    (
        &["skills/src/chart/content.rs", "skills/src/chart/state.rs", "skills/src/chart.rs"],
        "a chart has states, a state has content, and content may invoke a nested chart",
    ),
];

#[test]
fn nothing_is_in_a_circle_except_known_ones() {
    let mut found = BTreeMap::new();
    for target in metadata(&["--no-deps"]).packages.iter().flat_map(|package| &package.targets) {
        if target.kind.iter().any(|kind| ["lib", "bin"].contains(&&**kind)) {
            let root = target.src_path.strip_prefix(env!("CARGO_MANIFEST_DIR")).expect("a crate lies in the workspace");
            // The tools include files of tests.
            found.append(&mut if root.starts_with("tests/tools") { BTreeMap::new() } else { circles(root) });
        }
    }
    for (files, _) in CIRCLES {
        let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
        assert!(found.remove(&files).is_some(), "this circle no longer exists: remove it from the list: {files:?}");
    }
    let uses: Vec<String> = found.values().map(|uses| uses.join("\n")).collect();
    assert!(uses.is_empty(), "circles:\n{}", uses.join("\n\n"));
}

#[test]
fn there_are_few_circles_and_each_has_a_reason() {
    let page = fs::read_to_string("ARCHITECTURE.md").expect("the page is there");
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for (files, reason) in CIRCLES {
        let room = files[0].split("/src/").next();
        let of_room = CIRCLES.iter().filter(|(files, _)| files[0].split("/src/").next() == room).count();
        assert!(files.len() <= 3 && of_room <= 2 && !files[0].starts_with("scenarios/"), "{files:?}");
        assert!(page.contains(reason), "ARCHITECTURE.md does not say why: {reason}");
    }
}

/// What uses what, each with the paths that it names.
type Arrows = BTreeMap<(usize, usize), BTreeSet<String>>;

/// The circles of a crate, starting at its `lib.rs` or `main.rs`, each with the uses that close it. A module is named
/// by its file. Modules whose files form a circle are not listed again.
fn circles(root: &Path) -> BTreeMap<Vec<PathBuf>, Vec<String>> {
    let read = Crate::read(root);
    let uses = read.arrows();
    let of_files = strong_components(&uses);
    let between_siblings = read.between_siblings(&uses);
    let mut of_modules = strong_components(&between_siblings);
    of_modules.retain(|modules| !of_files.iter().any(|files| modules.is_subset(files)));
    let name = |file: usize| read.files[file].display();
    let named = |circle: &BTreeSet<usize>, arrows: &Arrows| {
        let closing = arrows.iter().filter(|((user, used), _)| circle.contains(user) && circle.contains(used));
        let uses = closing.map(|((user, used), paths)| format!("{} uses {}: {paths:?}", name(*user), name(*used)));
        let files: BTreeSet<PathBuf> = circle.iter().map(|file| read.files[*file].clone()).collect();
        (files.into_iter().collect(), uses.collect())
    };
    let of_files = of_files.iter().map(|circle| named(circle, &uses));
    of_files.chain(of_modules.iter().map(|circle| named(circle, &between_siblings))).collect()
}

fn strong_components(arrows: &Arrows) -> Vec<BTreeSet<usize>> {
    let users: Vec<usize> = arrows.keys().map(|(user, _)| *user).collect();
    let used = |by: &usize| arrows.keys().filter(|(user, _)| user == by).map(|(_, used)| *used).collect::<Vec<_>>();
    let components = strongly_connected_components(&users, used).into_iter().map(BTreeSet::from_iter);
    components.filter(|circle: &BTreeSet<usize>| circle.len() > 1).collect()
}

/// Where a path leads: to a module, or to an item of a file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Module(usize),
    Item(usize),
}

impl Crate {
    /// Which file uses which, and through which paths.
    fn arrows(&self) -> Arrows {
        let mut arrows = Arrows::new();
        for (id, module) in self.modules.iter().enumerate() {
            for path in &module.uses {
                for place in self.resolve(id, path, &mut Vec::new()) {
                    if let Place::Item(file) = place
                        && file != module.file
                    {
                        arrows.entry((module.file, file)).or_default().insert(path.join("::"));
                    }
                }
            }
        }
        arrows
    }

    /// Which module uses which of its siblings, given the uses of files: the user and what it uses are replaced by the
    /// modules that contain them and have the same parent. If one contains the other, there are no such modules.
    fn between_siblings(&self, uses: &Arrows) -> Arrows {
        let mut arrows = Arrows::new();
        for ((user, used), paths) in uses {
            let (user, used) = (self.ancestry(*user), self.ancestry(*used));
            if let Some(siblings) = user.into_iter().zip(used).find(|(user, used)| user != used) {
                arrows.entry(siblings).or_default().extend(paths.iter().cloned());
            }
        }
        arrows
    }

    /// The files of the modules that contain a file, from the root of the crate to the file itself.
    fn ancestry(&self, file: usize) -> Vec<usize> {
        let module = self.modules.iter().find(|module| module.file == file).expect("a file is a module");
        let parent = self.modules[module.parent].file;
        let mut files = if parent == file { Vec::new() } else { self.ancestry(parent) };
        files.push(file);
        files
    }

    /// Where a path in a module leads: nowhere if it begins with another crate or a local variable. Imports may refer
    /// to each other in a circle, so those `under_way` are not followed again.
    fn resolve(&self, module: usize, path: &[String], under_way: &mut Vec<(usize, Names)>) -> BTreeSet<Place> {
        let query = (module, path.to_vec());
        if under_way.contains(&query) {
            return BTreeSet::new();
        }
        under_way.push(query);
        let mut places = BTreeSet::from([Place::Module(module)]);
        for name in path {
            // Where a module and a function share a name, a path that continues with `::` means the module.
            let in_modules = places.iter().any(|place| matches!(place, Place::Module(_)));
            let next = places.iter().flat_map(|place| match place {
                Place::Module(module) => self.look_up(*module, name, under_way),
                Place::Item(_) if in_modules => BTreeSet::new(),
                Place::Item(_) => BTreeSet::from([*place]),
            });
            places = next.collect();
        }
        under_way.pop();
        places
    }

    fn look_up(&self, id: usize, name: &str, under_way: &mut Vec<(usize, Names)>) -> BTreeSet<Place> {
        let module = &self.modules[id];
        match name {
            "crate" => return BTreeSet::from([Place::Module(0)]),
            "self" => return BTreeSet::from([Place::Module(id)]),
            "super" => return BTreeSet::from([Place::Module(module.parent)]),
            _ => {}
        }
        let meanings = module.names.iter().filter(|(known, _)| known == name);
        let places = meanings.flat_map(|(_, meaning)| match meaning {
            Meaning::Item => BTreeSet::from([Place::Item(module.file)]),
            Meaning::Module(child) => BTreeSet::from([Place::Module(*child)]),
            Meaning::Import(path) => self.resolve(id, path, under_way),
        });
        let places: BTreeSet<Place> = places.collect();
        if !places.is_empty() {
            return places;
        }
        let through_globs = module.globs.iter().map(|glob| [glob, [name.to_owned()].as_slice()].concat());
        through_globs.flat_map(|path| self.resolve(id, &path, under_way)).collect()
    }
}
