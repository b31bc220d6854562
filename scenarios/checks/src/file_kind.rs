//! The kinds of files that can be checked.

use std::path::Path;

use diagnostics::Disk;
use roxmltree::{Document, ParsingOptions};
use scenarios::files::{Files, shipped_campaigns};
use scenarios::scenario::find;

use crate::toml_subject::Toml;

/// A kind of file that can be checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A behavior tree.
    Tree,
    /// The main file of a RoAML model.
    Model,
    /// A machine in SCXML.
    Machine,
    /// Properties in SCOPE.
    Properties,
    /// A map.
    Map,
    /// The places on a map in an INI file.
    PlacesIni,
    /// A TOML file.
    Toml(Toml),
}

impl FileKind {
    /// The kind of a file on this disk, or of the shipped file with this name; nothing for other files.
    #[must_use]
    pub fn of(disk: &Disk, file: &Path) -> Option<Self> {
        Self::with_text(file, || Files::beside("").on(disk).read_text(file).unwrap_or_default())
    }

    /// The kind of an open document; nothing for those of other programs.
    #[must_use]
    pub fn of_document(disk: &Disk, file: &Path) -> Option<Self> {
        file.extension()?;
        let text = disk.read_text(file).ok()?;
        Self::with_text(file, || &text).filter(|kind| match kind {
            Self::Tree => is_tree(&text),
            Self::Properties => !text.lines().any(|line| matches!(line.trim_end(), "[Unit]" | "[Scope]")),
            Self::Map => text.is_empty() || text.contains("resolution") || text.contains("image"),
            Self::PlacesIni => text.contains("position"),
            Self::Toml(kind) => Toml::of(&text) == Some(*kind),
            _ => true,
        })
    }

    /// The kind of the file with this name; if that is not clear from the name, that of its text.
    fn with_text<T: AsRef<str>>(file: &Path, text: impl Fn() -> T) -> Option<Self> {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        Some(match ending.as_deref() {
            Some("xml") if find::is_model(file, text().as_ref()) => Self::Model,
            Some("xml") => Self::Tree,
            Some("scxml") => Self::Machine,
            Some("scope") => Self::Properties,
            Some("yaml" | "yml") => Self::Map,
            Some("ini") => Self::PlacesIni,
            Some("toml") => Self::Toml(Toml::meant(text().as_ref())),
            Some(_) => return None,
            None => {
                let name = file.to_string_lossy();
                let is_campaign = || shipped_campaigns().any(|(known, _)| known == name);
                Self::Toml(if find::shipped(&name).is_none() && is_campaign() {
                    Toml::Campaign
                } else {
                    Toml::Scenario
                })
            }
        })
    }
}

/// Whether an XML file is a tree, or may become one.
fn is_tree(text: &str) -> bool {
    let options = ParsingOptions { nodes_limit: 100_000, ..ParsingOptions::default() };
    match Document::parse_with_options(text, options) {
        Ok(document) => document.root_element().tag_name().name() == "root",
        Err(_) => text.contains("BehaviorTree") || text.contains("<root"),
    }
}
