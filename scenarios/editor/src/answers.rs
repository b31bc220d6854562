//! Answers about a place in a file, whatever its kind is.

use std::path::Path;

use checks::{FileKind, Toml};
use diagnostics::Disk;
use diagnostics::document::Referent;

use crate::knowledge::Knowledge;
use crate::project::FileContext;
use crate::proposal::{Explanation, Proposal, ProposalKind};
use crate::toml_keys::{Blank, keys_at};
use crate::{leaf_words, machine_words, paths, scope_words, toml_keys, tree_words};

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
            Some(FileKind::Tree) => tree_words::proposals(text, at, &known),
            Some(FileKind::Machine) => machine_words::proposals(text, at, &known, &known.vocabulary(self.file)),
            Some(FileKind::Properties) => scope_words::proposals(text, at, &known),
            Some(FileKind::Toml(kind)) => {
                let names = |blank: Blank<'_>| self.named(blank, text, &known);
                toml_keys::proposals(text, at, &keys_at(kind, text, at), &names)
            }
            Some(FileKind::Model | FileKind::Map | FileKind::PlacesIni) | None => Vec::new(),
        };
        // What follows a key may be there already.
        for Proposal { insert, replaces, .. } in &mut found {
            let rest = text[replaces.end..].trim_start_matches(['"', '\'']);
            let has_value = rest.trim_start_matches([' ', '\t']).starts_with('=');
            if let Some(key) = insert.strip_suffix(" = ").or(insert.strip_suffix("=\"\"")).filter(|_| has_value) {
                *insert = key.to_owned();
            }
        }
        found
    }

    /// What may be written in a blank of the file's text.
    fn named(&self, blank: Blank<'_>, text: &str, known: &Knowledge) -> Vec<Proposal> {
        let Blank { what, written, at, .. } = blank;
        let folder = self.file.parent().unwrap_or(self.file);
        let of_kind = |endings, kinds: &[FileKind]| paths::of_kind(self.disk, folder, written, endings, kinds);
        match what {
            Referent::Event if !written[..at].contains('(') => Vec::new(),
            Referent::Event => scope_words::proposals(written, at, known),
            Referent::File(endings) => paths::files(self.disk, folder, written, endings),
            Referent::Places => of_kind(&["toml", "ini"], &[FileKind::Toml(Toml::Places), FileKind::PlacesIni]),
            Referent::Interface => of_kind(&["toml"], &[FileKind::Toml(Toml::Interface)]),
            Referent::Machine => {
                let folders = known.skill_folders(folder).into_iter();
                let mut found: Vec<_> =
                    folders.flat_map(|folder| paths::machines(self.disk, &folder, written)).collect();
                found.dedup();
                found
            }
            Referent::Scenario => paths::scenarios(self.disk, self.file, written),
            Referent::Own(own) => leaf_words::proposals(own, blank, text, known),
            // Of an assignment, `KEY=VALUE`, the key.
            _ if written[..at].contains('=') => Vec::new(),
            _ => {
                let word = 0..written.find('=').unwrap_or(written.len());
                let names = known.named(what).into_iter();
                names.map(|(name, about)| Proposal::new(name, ProposalKind::Name, about, &word)).collect()
            }
        }
    }

    /// What the text at a byte means.
    #[must_use]
    pub fn explanation(&self, text: &str, at: usize) -> Option<Explanation> {
        let known = Knowledge::of(self.context);
        match FileKind::of(self.disk, self.file)? {
            FileKind::Tree => tree_words::explanation(text, at, &known),
            FileKind::Machine => machine_words::explanation(text, at, &known, &known.vocabulary(self.file)),
            FileKind::Properties => scope_words::explanation(text, at, &known),
            FileKind::Toml(kind) => toml_keys::explanation(text, at, &keys_at(kind, text, at)),
            FileKind::Model | FileKind::Map | FileKind::PlacesIni => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::PathBuf;

    use diagnostics::document::Own;
    use diagnostics::normal;

    use super::*;
    use crate::project::{Documents, Project};
    use crate::toml_keys::key_at;
    use crate::toml_place::contents;

    /// The files with this ending in a folder of the repository.
    fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| normal(&entry.unwrap().path()));
        entries.filter(|path| path.extension().is_some_and(|known| known == ending)).collect()
    }

    #[test]
    fn names_in_shipped_files_are_proposed_where_they_are() {
        let folders = ["scenarios", "scenarios/faults", "scenarios/guide", "scenarios/campaigns"];
        // The files of the published system are not in the repository.
        let is_whole = |path: &PathBuf| !path.ends_with("published.toml");
        let paths = folders.iter().flat_map(|folder| files(folder, "toml")).filter(is_whole);
        let open = paths.map(|path| (path.clone(), std::fs::read_to_string(path).unwrap().into())).collect();
        let documents = Documents { open, ..Documents::default() };
        let (disk, checked) = (documents.disk(), Project::default().check(&documents));
        let mut seen = BTreeMap::new();
        for (file, text) in &documents.open {
            let Some(FileKind::Toml(kind)) = FileKind::of_document(&disk, file) else { continue };
            let subject = EditedFile { disk: &disk, file, context: &checked.contexts[file] };
            for written in contents(text).1 {
                let keys = keys_at(kind, text, written.range.start);
                let Some(what) = key_at(&keys, &written.key).and_then(|key| key.refers_to) else { continue };
                let name = written.value.split('=').next().unwrap();
                let proposals = subject.proposals(text, written.range.start + name.len());
                // An assignment may set an item of an array.
                let array = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
                let is_constant = what == Referent::Own(Own::InputPort) && !name.starts_with('{');
                let is_free = is_constant || matches!(what, Referent::Event | Referent::Own(Own::AnswerCondition));
                let is_known = proposals.iter().any(|proposal| [name, array].contains(&proposal.name.as_str()));
                assert!(is_known || is_free || ["any", "."].contains(&name), "{file:?}: {what:?} {name}");
                *seen.entry(format!("{what:?}")).or_insert(0) += 1;
            }
        }
        assert!(seen.len() > 20, "{seen:?}");
    }
}
