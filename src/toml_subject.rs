//! What a TOML file describes, judging by its keys.

use std::path::Path;

use crate::named_files;

/// The subject of a TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Toml {
    Scenario,
    Campaign,
    Interface,
    Places,
}

impl Toml {
    /// A file's probable kind, judging by its keys; one that cannot be read is rejected as a scenario.
    pub(crate) fn of_file(path: &Path) -> Self {
        named_files::text(path).map_or(Self::Scenario, |text| Self::of(&text))
    }

    /// A text's probable kind.
    pub(crate) fn of(text: &str) -> Self {
        let table: toml::Table = text.parse().unwrap_or_default();
        let is_place = |value: &toml::Value| value.get("position_m").or(value.get("corners_m")).is_some();
        if table.contains_key("scenario") {
            Self::Campaign
        } else if ["services", "topics", "actions"].iter().any(|key| table.contains_key(*key)) {
            Self::Interface
        } else if !table.contains_key("map") && table.values().any(is_place) {
            Self::Places
        } else {
            Self::Scenario
        }
    }
}
