//! Answers about a place in a file, whatever its kind is.

use std::path::Path;

use diagnostics::Disk;

use crate::file_kind::FileKind;
use crate::knowledge::Knowledge;
use crate::project::FileContext;
use crate::proposal::{Explanation, Proposal};
use crate::{scope_words, toml_keys, xml_words};

/// A file, and what belongs to it.
#[derive(Debug)]
pub struct EditedFile<'s> {
    /// The disk with the open documents.
    pub disk: &'s Disk,
    /// The file.
    pub file: &'s Path,
    /// What belongs to it.
    pub context: &'s FileContext,
}

impl EditedFile<'_> {
    /// What may be written at a byte of the file's text.
    #[must_use]
    pub fn proposals(&self, text: &str, at: usize) -> Vec<Proposal> {
        let known = Knowledge::of(self.context);
        let mut found = match FileKind::of(self.disk, self.file) {
            Some(FileKind::Tree) => xml_words::in_tree(text, at, &known),
            Some(FileKind::Machine) => xml_words::in_machine(text, at, &known),
            Some(FileKind::Properties) => scope_words::proposals(text, at, &known),
            Some(FileKind::Toml(kind)) => toml_keys::proposals(text, at, &kind.keys_at(text, at), &known.names()),
            Some(FileKind::Model | FileKind::Map | FileKind::PlacesIni) | None => Vec::new(),
        };
        // What follows a key may be there already.
        for Proposal { insert, replaces, .. } in &mut found {
            let has_value = text[replaces.end..].trim_start_matches([' ', '\t']).starts_with('=');
            if let Some(key) = insert.strip_suffix(" = ").or(insert.strip_suffix("=\"\"")).filter(|_| has_value) {
                *insert = key.to_owned();
            }
        }
        found
    }

    /// What the text at a byte means.
    #[must_use]
    pub fn explanation(&self, text: &str, at: usize) -> Option<Explanation> {
        let known = Knowledge::of(self.context);
        match FileKind::of(self.disk, self.file)? {
            FileKind::Tree => xml_words::explained_in_tree(text, at, &known),
            FileKind::Machine => xml_words::explained_in_machine(text, at, &known),
            FileKind::Properties => scope_words::explanation(text, at, &known),
            FileKind::Toml(kind) => toml_keys::explanation(text, at, &kind.keys_at(text, at)),
            FileKind::Model | FileKind::Map | FileKind::PlacesIni => None,
        }
    }
}
