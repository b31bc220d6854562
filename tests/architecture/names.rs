//! Names of types: who greps for one finds one subject, or few.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use syn::{Attribute, Item};

use super::sources;

/// In how many files a name may stand for something else.
const MOST: usize = 4;

/// The error of a crate is called `Error` by custom, and written with the crate's name: `maps::Error`.
const CUSTOMARY: [&str; 1] = ["Error"];

/// Names that say little of a type: it would have to be looked up.
const VAGUE: [&str; 11] = ["Desk", "Grip", "Hand", "Harvest", "Kin", "Mail", "News", "Reel", "Side", "Tape", "Told"];

#[test]
fn no_name_stands_for_more_than_four_types() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files_of: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in sources(root) {
        let path = path.strip_prefix(root).expect("it is inside").to_string_lossy().into_owned();
        let is_product = path.starts_with("src/") || path.contains("/src/");
        if is_product && !path.ends_with("/tests.rs") && !path.contains("/tests/") {
            let items = syn::parse_file(&text).expect("the source compiles").items;
            types(&items, &mut |name| _ = files_of.entry(name).or_default().insert(path.clone()));
        }
    }
    assert!(files_of.len() > 1000, "found {} names", files_of.len());
    files_of.retain(|name, files| {
        VAGUE.contains(&name.as_str()) || files.len() > MOST && !CUSTOMARY.contains(&name.as_str())
    });
    assert!(files_of.is_empty(), "each of these names stands for too much, or says too little: {files_of:#?}");
}

/// Calls `visit` with the name of each type and trait of a module, except in its tests.
fn types(items: &[Item], visit: &mut impl FnMut(String)) {
    for item in items {
        match item {
            Item::Struct(item) => visit(item.ident.to_string()),
            Item::Enum(item) => visit(item.ident.to_string()),
            Item::Trait(item) => visit(item.ident.to_string()),
            Item::Type(item) => visit(item.ident.to_string()),
            Item::Mod(item) if !item.attrs.iter().any(is_for_tests) => {
                item.content.iter().for_each(|(_, items)| types(items, visit));
            }
            _ => {}
        }
    }
}

fn is_for_tests(attribute: &Attribute) -> bool {
    attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Ident>().is_ok_and(|what| what == "test")
}
