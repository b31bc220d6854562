//! A name is changed in all files of a project.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use checks::findings::Findings;

use crate::name_index::{Mention, NameIndex, NameKind};
use crate::project::{Documents, Project};

/// The changes that rename something.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Renaming {
    /// The ranges in each file that the new name replaces, in bytes, in the order of the text.
    pub ranges: BTreeMap<PathBuf, Vec<Range<usize>>>,
    /// The files that get another path.
    pub files: Vec<(PathBuf, PathBuf)>,
}

/// Renames what is mentioned. The machine of a leaf is found by the leaf's name, so its file is renamed, too.
///
/// # Errors
/// A reason: the name is not allowed, or taken, or a check finds afterwards what it did not find before.
pub fn rename(documents: &Documents, index: &NameIndex, mention: &Mention, name: &str) -> Result<Renaming, String> {
    if matches!(mention.kind, NameKind::File | NameKind::Table) {
        return Err("files and tables cannot be renamed here".to_owned());
    }
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    if name.is_empty() || !name.chars().all(is_word) {
        return Err(format!("`{name}` is not a name: letters, digits, `_` and `-` are"));
    }
    let taken = Mention { name: name.to_owned(), ..mention.clone() };
    if let Some(other) = index.same(&taken).find(|other| other.is_definition) {
        return Err(format!("there is already a `{name}`, in {}", other.path.display()));
    }
    if !index.same(mention).any(|same| same.is_definition) {
        return Err(format!("`{}` is not defined in a file of the project", mention.name));
    }
    let mut renaming = Renaming::default();
    for same in index.same(mention) {
        renaming.ranges.entry(same.path.clone()).or_default().push(same.start..same.end);
    }
    if mention.kind == NameKind::Process {
        renaming.files = machines_named(index, &mention.name, name);
        if let Some((_, new)) = renaming.files.iter().find(|(_, new)| documents.disk().exists(new)) {
            return Err(format!("there is already a file {}", new.display()));
        }
    }
    renaming.verify(documents, index, &mention.name, name)?;
    Ok(renaming)
}

/// The machines that are found by this name, with their paths under the other one. A machine that another file names
/// stays.
fn machines_named(index: &NameIndex, old: &str, new: &str) -> Vec<(PathBuf, PathBuf)> {
    let is_machine = |path: &Path| path.extension().is_some_and(|ending| ending == "scxml");
    let has_name = |path: &Path| path.file_stem().is_some_and(|stem| stem == old);
    let found = index.texts.iter().map(|(path, _)| path).filter(|path| is_machine(path) && has_name(path));
    let found = found.filter(|path| !index.names_file(path));
    found.map(|path| (path.clone(), path.with_file_name(format!("{new}.scxml")))).collect()
}

impl Renaming {
    /// The documents afterwards.
    fn applied(&self, documents: &Documents, index: &NameIndex, name: &str) -> Documents {
        let mut documents = documents.clone();
        for (path, text) in &index.texts {
            let mut text = text.to_string();
            for range in self.ranges.get(path).into_iter().flatten().rev() {
                text.replace_range(range.clone(), name);
            }
            let renamed = self.files.iter().find(|(old, _)| old == path).map_or(path, |(_, new)| new);
            documents.open.insert(renamed.clone(), Arc::from(text));
        }
        documents
    }

    /// Checks that nothing is wrong afterwards that was right before.
    fn verify(&self, documents: &Documents, index: &NameIndex, old: &str, new: &str) -> Result<(), String> {
        let before = Self::default().applied(documents, index, old);
        let [before, after] = [before, self.applied(documents, index, new)]
            .map(|documents| Project::default().check(&documents).findings);
        let message = |message: &str| message.replace(old, new);
        let known: Vec<String> = messages(&before).map(message).collect();
        match messages(&after).find(|found| !known.contains(&message(found))) {
            None => Ok(()),
            Some(found) => Err(format!("after this, a check would find: {found}")),
        }
    }
}

fn messages(findings: &Findings) -> impl Iterator<Item = &str> {
    findings.values().flat_map(|found| &found.findings).map(|finding| finding.message.as_str())
}
