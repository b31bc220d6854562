//! Files that a text may name.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use checks::{FileKind, Toml};
use diagnostics::{Disk, normal};
use scenarios::files::{scenario_names, shipped_paths};

use crate::proposal::{Proposal, ProposalKind};

/// The files with one of these endings, and the folders, that a text may name in a file of this folder: those beside
/// the part of the path that is written, and those that come with the program. Without endings, only folders.
pub(crate) fn files(disk: &Disk, folder: &Path, written: &str, endings: &[&str]) -> Vec<Proposal> {
    let shipped = shipped_paths().filter_map(|path| match endings {
        [] => path.rsplit_once('/').map(|(folder, _)| folder.to_owned()),
        _ => has_ending(path, endings).then(|| path.to_owned()),
    });
    proposals(beside(disk, folder, written, endings).chain(shipped), written)
}

/// The same, only files of these kinds.
pub(crate) fn of_kind(
    disk: &Disk,
    folder: &Path,
    written: &str,
    endings: &[&str],
    kinds: &[FileKind],
) -> Vec<Proposal> {
    let is_meant = |path: &Path| path.is_dir() || FileKind::of(disk, path).is_some_and(|kind| kinds.contains(&kind));
    let mut found = files(disk, folder, written, endings);
    // A shipped file is not in the folder.
    found.retain(|proposal| is_meant(&folder.join(&proposal.name)) || is_meant(Path::new(&proposal.name)));
    found
}

/// The machines that a text may name in this folder of skills, which those that come with the program complete.
pub(crate) fn machines(disk: &Disk, folder: &Path, written: &str) -> Vec<Proposal> {
    let endings = ["scxml"];
    let shipped = shipped_paths().filter(|path| has_ending(path, &endings));
    let shipped = shipped.filter_map(|path| path.strip_prefix("skills/")).map(str::to_owned);
    proposals(beside(disk, folder, written, &endings).chain(shipped), written)
}

fn proposals(names: impl Iterator<Item = String>, written: &str) -> Vec<Proposal> {
    let names: BTreeSet<String> = names.collect();
    let whole = 0..written.len();
    names.into_iter().map(|name| Proposal::new(name, ProposalKind::File, "", &whole)).collect()
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    endings.iter().any(|ending| name.ends_with(&format!(".{ending}")))
}

/// The files, saved or open, and the folders beside the part of a path that is written.
fn beside(disk: &Disk, folder: &Path, written: &str, endings: &[&str]) -> impl Iterator<Item = String> {
    let begun = &written[..written.rfind('/').map_or(0, |slash| slash + 1)];
    let entries = fs::read_dir(folder.join(begun)).into_iter().flatten().flatten();
    let saved = entries.filter_map(move |entry| {
        let name = entry.file_name().into_string().ok().filter(|name| !name.starts_with('.'))?;
        match entry.path().is_dir() {
            true => Some(format!("{begun}{name}{}", if endings.is_empty() { "" } else { "/" })),
            false => has_ending(&name, endings).then(|| format!("{begun}{name}")),
        }
    });
    let here = normal(&folder.join(begun));
    let open = disk.open_paths().filter(move |path| path.parent() == Some(&here));
    let open = open.filter_map(|path| path.file_name()?.to_str()).filter(|name| has_ending(name, endings));
    saved.chain(open.map(move |name| format!("{begun}{name}")))
}

/// The scenarios that a text may name in a file: those in its folder, and those that come with the program.
pub(crate) fn scenarios(disk: &Disk, file: &Path, written: &str) -> Vec<Proposal> {
    let folder = file.parent().unwrap_or(file);
    let is_shipped = |path: &str| {
        let name = path.strip_prefix("scenarios/").and_then(|path| path.strip_suffix(".toml"));
        scenario_names().any(|known| Some(known) == name)
    };
    let is_scenario = |written: &str| {
        let path = folder.join(written);
        is_shipped(written)
            || path != file
                && (path.is_dir() || FileKind::of_document(disk, &path) == Some(FileKind::Toml(Toml::Scenario)))
    };
    let mut found = files(disk, folder, written, &["toml"]);
    found.retain(|proposal| is_scenario(&proposal.name));
    let whole = 0..written.len();
    found.extend(scenario_names().map(|name| Proposal::new(name, ProposalKind::Name, "a shipped scenario", &whole)));
    found
}
