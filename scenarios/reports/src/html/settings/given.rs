//! The settings of the scenario's file, and the changes from the command line.

use maud::{Markup, html};
use recording::Origin;

use crate::html::markup::{breakable, row};

/// A key of the scenario's file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Given {
    key: String,
    value: String,
    /// Whether it was set on the command line.
    overridden: bool,
}

impl Given {
    /// The key as a row of a table.
    pub(super) fn row(&self) -> Markup {
        let value = html! {
            code { (self.value) }
            @if self.overridden { span.note { "set on the command line" } }
        };
        row(breakable(&self.key), [value])
    }
}

/// The settings of the scenario's file, key by key as `--set` names them, with the changes from the command line.
pub(super) fn of(origin: &Origin) -> Vec<Given> {
    let mut given = Vec::new();
    // The file has been read before, so the text is valid TOML.
    let table: toml::Table = origin.text.parse().unwrap_or_default();
    flatten("", &toml::Value::Table(table), false, &mut given);
    for assignment in &origin.overrides {
        let Some((key, text)) = assignment.split_once('=') else { continue };
        let key = key.trim();
        let inside = format!("{key}.");
        given.retain(|known| known.key != key && !known.key.starts_with(&inside));
        let parsed: Option<toml::Table> = format!("value = {}", text.trim()).parse().ok();
        let value = parsed.and_then(|mut table| table.remove("value"));
        let value = value.unwrap_or_else(|| toml::Value::String(text.to_owned()));
        flatten(key, &value, true, &mut given);
    }
    given.sort_by_cached_key(|given| (given.key.contains('.'), order(&given.key)));
    given
}

/// The sort order of keys: part by part, with numbers by value.
fn order(key: &str) -> Vec<(Option<u64>, String)> {
    key.split('.').map(|part| (part.parse().ok(), part.to_owned())).collect()
}

fn flatten(key: &str, value: &toml::Value, overridden: bool, given: &mut Vec<Given>) {
    let inner = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(name, value)| flatten(&inner(name), value, overridden, given));
        }
        toml::Value::Array(items) if items.iter().any(toml::Value::is_table) => {
            let items = items.iter().enumerate();
            items.for_each(|(index, value)| flatten(&inner(&index.to_string()), value, overridden, given));
        }
        value => given.push(Given { key: key.to_owned(), value: value.to_string(), overridden }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(overrides: &[&str]) -> Origin {
        Origin {
            argument: "test".into(),
            text: "about = \"a\"\n[battery]\ninitial_pct = 80\n[[faults]]\nkind = \"x\"\nat_s = 20.5\n".into(),
            overrides: overrides.iter().map(|text| (*text).to_owned()).collect(),
            ..Origin::default()
        }
    }

    #[test]
    fn values_from_the_command_line_replace_those_from_the_file() {
        let given = of(&origin(&["battery.initial_pct=35", "faults.0.kind=other", "seed = 4"]));
        let shown: Vec<_> =
            given.iter().map(|given| (given.key.as_str(), given.value.as_str(), given.overridden)).collect();
        assert_eq!(
            shown,
            [
                ("about", "\"a\"", false),
                ("seed", "4", true),
                ("battery.initial_pct", "35", true),
                ("faults.0.at_s", "20.5", false),
                ("faults.0.kind", "\"other\"", true),
            ]
        );
    }
}
