//! What a TOML file describes, judging by its keys.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use bags::Mapping;
use campaigns::CampaignFile;
use diagnostics::document::Key;
use diagnostics::{MAX_HINTS, nearest};
use interfaces::Interface;
use maps::PlacesFile;
use scenarios::scenario::ScenarioFile;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The subject of a TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// The keys of the top level, each with the kinds of files that have it.
static OWNERS: LazyLock<BTreeMap<String, BTreeSet<Toml>>> = LazyLock::new(|| {
    let mut kinds: BTreeMap<String, BTreeSet<Toml>> = BTreeMap::new();
    for kind in [Toml::Campaign, Toml::Interface, Toml::Mapping, Toml::Scenario] {
        for key in kind.keys() {
            if let ("", name) = key.split() {
                kinds.entry(name.trim_end_matches("[]").to_owned()).or_default().insert(kind);
            }
        }
    }
    kinds
});

/// What every place has one of.
const OF_PLACE: [&str; 2] = ["position_m", "corners_m"];

impl Toml {
    /// The keys that the reader of such a file requests.
    #[must_use]
    pub fn keys(self) -> Vec<Key> {
        match self {
            Self::Scenario => ScenarioFile::keys().to_vec(),
            Self::Campaign => CampaignFile::keys(),
            Self::Interface => Interface::keys(),
            Self::Places => PlacesFile::keys(),
            Self::Mapping => Mapping::keys(),
        }
    }

    /// A text's most probable kind; one of none is rejected as a scenario.
    pub(crate) fn meant(text: &str) -> Self {
        Self::of(text).or_else(|| meant_by(text)).unwrap_or(Self::Scenario)
    }

    /// A text's kind, whose keys need not be complete: that of which it has the most keys that no other kind has.
    /// Without any key, it may become a scenario; with none of ours, it is nothing.
    #[must_use]
    pub fn of(text: &str) -> Option<Self> {
        let (table, _) = DeTable::parse_recoverable(text);
        let table = table.get_ref();
        let is_place = |value: &Spanned<DeValue<'_>>| {
            let value = value.get_ref().as_table();
            value.is_some_and(|value| OF_PLACE.iter().any(|key| value.contains_key(*key)))
        };
        // A place may have any name.
        let places = BTreeSet::from([Self::Places]);
        let known = || {
            let kinds = |(key, value): (&Spanned<_>, &_)| {
                if is_place(value) { Some(&places) } else { OWNERS.get(AsRef::<str>::as_ref(key.get_ref())) }
            };
            table.iter().filter_map(kinds)
        };
        most(known()).or_else(|| (table.is_empty() || known().next().is_some()).then_some(Self::Scenario))
    }
}

/// The kind of a text none of whose keys is right.
fn meant_by(text: &str) -> Option<Toml> {
    let (table, _) = DeTable::parse_recoverable(text);
    let keys = table.get_ref().keys().take(MAX_HINTS);
    let meant = keys.filter_map(|key| nearest(key.get_ref(), OWNERS.keys().map(String::as_str)));
    let is_place = |value: &Spanned<DeValue<'_>>| {
        let keys = value.get_ref().as_table().into_iter().flat_map(|table| table.keys());
        keys.take(MAX_HINTS).any(|key| nearest(key.get_ref(), OF_PLACE).is_some())
    };
    most(meant.map(|key| &OWNERS[key]))
        .or_else(|| table.get_ref().values().take(MAX_HINTS).any(is_place).then_some(Toml::Places))
}

/// The kind that most keys belong to alone.
fn most<'k>(kinds: impl Iterator<Item = &'k BTreeSet<Toml>>) -> Option<Toml> {
    let mut votes: BTreeMap<Toml, usize> = BTreeMap::new();
    kinds.filter(|kinds| kinds.len() == 1).flatten().for_each(|kind| *votes.entry(*kind).or_default() += 1);
    votes.into_iter().max_by_key(|(_, keys)| *keys).map(|(kind, _)| kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kind_is_that_of_most_keys() {
        let cases = [
            ("", Some(Toml::Scenario)),
            ("seed = 1", Some(Toml::Scenario)),
            ("map = \"m.yaml\"\ntree = \"t.xml\"\n[topics]\nx = 1", Some(Toml::Scenario)),
            ("scenario = \"nominal\"\nmap = \"m.yaml\"", Some(Toml::Campaign)),
            ("[topics]\n", Some(Toml::Interface)),
            ("[[messages]]\ntopic = ", Some(Toml::Mapping)),
            ("[kitchen]\nposition_m = [1, 2]", Some(Toml::Places)),
            ("[stop]\nposition_m = [1, 2]", Some(Toml::Places)),
            ("[package]\nname = \"x\"", None),
        ];
        cases.into_iter().for_each(|(text, kind)| assert_eq!(Toml::of(text), kind, "{text}"));
    }

    #[test]
    fn a_misspelled_key_tells_the_kind_if_none_is_right() {
        assert_eq!(meant_by("[[mesages]]\ntopic = \"/scan\"\nchannel = \"scan\""), Some(Toml::Mapping));
        assert_eq!(meant_by("[servces]\n"), Some(Toml::Interface));
        assert_eq!(meant_by("[kitchen]\npositon_m = [1, 2]"), Some(Toml::Places));
        assert_eq!(meant_by("[qqqqqqqq]\nqqqqqqqq = 1"), None);
    }
}
