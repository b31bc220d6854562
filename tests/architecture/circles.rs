//! Circular dependencies between files: no file in a circle can be understood, tested or moved without the others.
//!
//! A file uses another if it names an item that the other defines, through any re-exports. `mod` and `pub use` alone do
//! not count: a facade is not a user. Nor is a unit test. Method calls are not detected.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use pathfinding::prelude::strongly_connected_components;

use super::modules::{Crate, Meaning, Names};
use crate::workspace::metadata;

/// The known circles, at most two per crate with at most three files each, and the reason for each, in the words of
/// ARCHITECTURE.md.
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
fn no_files_use_each_other_in_a_circle_except_known_ones() {
    let mut found = BTreeMap::new();
    for target in metadata(&["--no-deps"]).packages.iter().flat_map(|package| &package.targets) {
        if target.kind.iter().any(|kind| ["lib", "bin"].contains(&&**kind)) {
            let root = target.src_path.strip_prefix(env!("CARGO_MANIFEST_DIR")).expect("a crate lies in the workspace");
            found.append(&mut circles(root));
        }
    }
    for (files, _) in CIRCLES {
        let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
        assert!(found.remove(&files).is_some(), "this circle no longer exists: remove it from the list: {files:?}");
    }
    let uses: Vec<String> = found.values().map(|uses| uses.join("\n")).collect();
    assert!(uses.is_empty(), "circles of files:\n{}", uses.join("\n\n"));
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

/// The circles among the files of a crate, starting at its `lib.rs` or `main.rs`, each with the uses that close it.
fn circles(root: &Path) -> BTreeMap<Vec<PathBuf>, Vec<String>> {
    let read = Crate::read(root);
    let arrows = read.arrows();
    let files: Vec<usize> = (0..read.files.len()).collect();
    let used = |file: &usize| arrows.keys().filter(|(user, _)| user == file).map(|(_, used)| *used).collect::<Vec<_>>();
    let circles = strongly_connected_components(&files, used).into_iter().filter(|circle| circle.len() > 1);
    let named = circles.map(|circle| {
        let closing = arrows.iter().filter(|((user, used), _)| circle.contains(user) && circle.contains(used));
        let name = |file: usize| read.files[file].display();
        let uses = closing.map(|((user, used), paths)| format!("{} uses {}: {paths:?}", name(*user), name(*used)));
        let files: BTreeSet<PathBuf> = circle.iter().map(|file| read.files[*file].clone()).collect();
        (files.into_iter().collect(), uses.collect())
    });
    named.collect()
}

/// Where a path leads: to a module, or to an item of a file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Module(usize),
    Item(usize),
}

impl Crate {
    /// Which file uses which, and through which paths.
    fn arrows(&self) -> BTreeMap<(usize, usize), BTreeSet<String>> {
        let mut arrows: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
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
