//! What a TOML file describes, judging by its keys.

use std::path::Path;

use diagnostics::Disk;
use toml::de::{DeTable, DeValue};

use crate::named_files;

/// The subject of a TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toml {
    /// A scenario.
    Scenario,
    /// A campaign.
    Campaign,
    /// The interface of a component.
    Interface,
    /// The places on a map.
    Places,
    /// A mapping of a robot's messages to channels.
    Mapping,
}

impl Toml {
    /// A file's probable kind, judging by its keys; one that cannot be read is rejected as a scenario.
    #[must_use]
    pub fn of_file(disk: &Disk, path: &Path) -> Self {
        named_files::text(disk, path).map_or(Self::Scenario, |text| Self::of(&text))
    }

    /// A text's probable kind, whose keys need not be complete.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let (table, _) = DeTable::parse_recoverable(text);
        let table = table.get_ref();
        let is_place = |value: &DeValue| {
            let value = value.as_table();
            value.is_some_and(|value| ["position_m", "corners_m"].iter().any(|key| value.contains_key(*key)))
        };
        if table.contains_key("scenario") {
            Self::Campaign
        } else if ["services", "topics", "actions"].iter().any(|key| table.contains_key(*key)) {
            Self::Interface
        } else if ["messages", "definitions", "reorder_s"].iter().any(|key| table.contains_key(*key)) {
            Self::Mapping
        } else if !table.contains_key("map") && table.values().any(|value| is_place(value.get_ref())) {
            Self::Places
        } else {
            Self::Scenario
        }
    }
}
