//! Keys and values of TOML files, from what their readers declare.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::LazyLock;

use checks::Toml;
use diagnostics::document::{Key, Referent};
use scenarios::faults::{KINDS, Parameter};
use serde_json::{Value, json};

use crate::proposal::{Explanation, Proposal, ProposalKind};
use crate::toml_place::{Present, TomlPlace, beside, place};

/// The keys of each kind of file, also those that only their rules describe.
static ALL_KEYS: LazyLock<BTreeMap<Toml, Vec<Key>>> = LazyLock::new(|| {
    let kinds = [Toml::Scenario, Toml::Campaign, Toml::Interface, Toml::Places, Toml::Mapping];
    let all = |kind: Toml| {
        let keys = kind.keys();
        let within = within(&keys);
        (kind, [keys, within].concat())
    };
    kinds.map(all).into()
});

/// The keys of such a file at a byte of its text: a fault has the parameters of its kind, too.
pub(crate) fn keys_at(file: Toml, text: &str, at: usize) -> Vec<Key> {
    let mut keys = ALL_KEYS[&file].clone();
    let kind = beside(text, at, &["faults", "kind"]).filter(|_| file == Toml::Scenario);
    let fault = KINDS.iter().find(|known| Some(known.name) == kind.as_deref());
    let parameters = fault.into_iter().flat_map(|fault| fault.parameters).map(Parameter::key);
    keys.extend(parameters.map(|key| Key { path: format!("faults[].{}", key.path), ..key }));
    keys
}

/// A text that stands for something, or a key that the file chooses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blank<'b> {
    pub(crate) what: Referent,
    /// What is written there so far, and the byte of it at which the cursor is.
    pub(crate) written: &'b str,
    pub(crate) at: usize,
    /// The path of the text's key, or of the key's table.
    pub(crate) path: &'b [String],
}

/// What may be written in a blank; the ranges are those of its text.
pub(crate) type Lookup<'n> = dyn Fn(Blank<'_>) -> Vec<Proposal> + 'n;

/// What may be written at a place of a file with these keys.
pub(crate) fn proposals(text: &str, at: usize, keys: &[Key], names: &Lookup<'_>) -> Vec<Proposal> {
    let Some((place, word)) = place(text, at) else { return Vec::new() };
    let chosen = |table: &[String], is_table: bool, present: &[Present]| {
        let keys = keys.iter().filter(|key| key.is_table() || !is_table);
        let chosen = keys.filter(|key| is_at(key.split().0, table) && is_chosen(key.split().1));
        let named = |key: &Key| {
            let blank = |what| Blank { what, written: "", at: 0, path: table };
            let names = key.named_after.map_or_else(Vec::new, |what| names(blank(what))).into_iter();
            let assigned = if key.is_table() { "" } else { " = " };
            names.map(move |name| Proposal { insert: format!("{}{assigned}", as_key(&name.name)), ..name })
        };
        let missing = chosen.flat_map(named).filter(|proposal| !has(present, &proposal.name));
        missing.map(|proposal| Proposal { replaces: word.clone(), ..proposal }).collect::<Vec<_>>()
    };
    match place {
        TomlPlace::Key { table, begins_line, present } => {
            let mut found = below(keys, &table, begins_line, &present, &word);
            found.extend(chosen(&table, false, &present));
            found
        }
        TomlPlace::Header { table, is_item, present } => {
            // What is complete, or repeated in another form, may still be on the way to a table below.
            let leads_on = |key: &Key| {
                let below = format!("{}.", key.path);
                keys.iter().any(|other| other.path.starts_with(&below) && other.is_table())
            };
            let fits = |key: &&Key| match key.split().1.ends_with("[]") {
                is_list if is_list != is_item => leads_on(key),
                false if has(&present, name_of(key)) => leads_on(key),
                _ => true,
            };
            let tables = keys.iter().filter(|key| key.is_table() && is_at(key.split().0, &table));
            let mut found: Vec<_> = tables
                .filter(|key| !is_chosen(key.split().1))
                .filter(fits)
                .filter(|key| is_allowed(name_of(key), keys, &table, &present))
                .map(|key| of_key(key, name_of(key).to_owned(), &word))
                .collect();
            found.extend(chosen(&table, true, &[]));
            found
        }
        TomlPlace::Value { key: path, is_quoted } => {
            let Some(key) = key_at(keys, &path) else { return Vec::new() };
            let mut found = values(key, is_quoted, &word);
            if let Some(what) = key.refers_to.filter(|_| is_text(key)) {
                let (written, at) = if is_quoted { (&text[word.clone()], at - word.start) } else { ("", 0) };
                let quote = text[..word.start].chars().next_back().filter(|_| is_quoted);
                let names = names(Blank { what, written, at, path: &path }).into_iter();
                let fits = |name: &Proposal| quote != Some('\'') || !name.insert.contains('\'');
                found.extend(names.filter(fits).map(|name| in_text(name, quote, &word)));
            }
            found
        }
    }
}

/// A name in a text of a file, with its quote: the word is the text, which needs its quotes if it has none.
fn in_text(name: Proposal, quote: Option<char>, word: &Range<usize>) -> Proposal {
    // JSON writes strings as TOML does.
    let string = Value::from(name.insert.as_str()).to_string();
    let insert = match quote {
        None => return Proposal { insert: string, replaces: word.clone(), ..name },
        // A literal string has no escapes.
        Some('\'') => name.insert,
        Some(_) => content(&string).to_owned(),
    };
    let Range { start, end } = name.replaces;
    Proposal { insert, replaces: word.start + start..word.start + end, ..name }
}

/// A string without its quotes.
fn content(written: &str) -> &str {
    written.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(written)
}

/// Whether a key takes texts, among others.
fn is_text(key: &Key) -> bool {
    let has_texts =
        |of: &Value| of == "string" || of.as_array().is_some_and(|several| several.contains(&json!("string")));
    let is_text = |takes: &Value| takes["enum"].is_null() && has_texts(&takes["type"]);
    let may_be = |takes: &Value| is_text(takes) || is_text(&takes["items"]) || is_text(&takes["items"]["items"]);
    may_be(&key.takes) || key.takes["anyOf"].as_array().is_some_and(|several| several.iter().any(may_be))
}

/// What the key at a place means.
pub(crate) fn explanation(text: &str, at: usize, keys: &[Key]) -> Option<Explanation> {
    let (place, range) = place(text, at)?;
    if range.is_empty() {
        return None;
    }
    let path = match place {
        TomlPlace::Key { table, .. } | TomlPlace::Header { table, .. } => {
            [table, vec![text[range.clone()].to_owned()]].concat()
        }
        TomlPlace::Value { key, .. } => key,
    };
    let key = key_at(keys, &path)?;
    Some(Explanation { range, text: format!("`{}`\n\n{}", path.join("."), key.meaning()) })
}

/// The keys and tables below a table that the file does not have yet.
fn below(keys: &[Key], table: &[String], begins_line: bool, present: &[Present], word: &Range<usize>) -> Vec<Proposal> {
    let here = keys.iter().filter(|key| is_at(key.split().0, table) && !is_chosen(key.split().1));
    let missing = here.filter(|key| !has(present, name_of(key)));
    let missing = missing.filter(|key| is_allowed(name_of(key), keys, table, present));
    let proposal = |key: &Key| {
        let name = name_of(key);
        let is_list = key.split().1.ends_with("[]");
        let insert = match (key.is_table(), begins_line) {
            (false, _) => format!("{name} = "),
            // A header names the table from the top level on.
            (true, true) => {
                let path: Vec<String> = table.iter().map(|part| as_key(part)).chain([name.to_owned()]).collect();
                if is_list { format!("[[{}]]", path.join(".")) } else { format!("[{}]", path.join(".")) }
            }
            (true, false) => name.to_owned(),
        };
        of_key(key, insert, word)
    };
    missing.map(proposal).collect()
}

fn has(present: &[Present], name: &str) -> bool {
    present.iter().any(|key| key.name == name)
}

/// Whether a table with these keys may have another one: not if the rules of the table forbid it beside them.
fn is_allowed(name: &str, keys: &[Key], table: &[String], present: &[Present]) -> bool {
    let Some(rules) = key_at(keys, table).map(|key| &key.takes) else { return true };
    let another = Present { name: name.to_owned(), value: None };
    // If the table is wrong already, its rules do not decide.
    forbid(rules, present) || !forbid(rules, &[present, &[another]].concat())
}

/// Whether rules forbid a table that has these keys, whatever is added to it.
fn forbid(rules: &Value, table: &[Present]) -> bool {
    fn items(list: &Value) -> &[Value] {
        list.as_array().map_or(&[], Vec::as_slice)
    }
    let has_all = |names: &Value| items(names).iter().all(|name| table.iter().any(|key| *name == key.name));
    let names = &rules["propertyNames"];
    let is_forbidden = |key: &Present| {
        let is_in = |list: &Value| items(list).iter().any(|name| *name == key.name);
        !names["enum"].is_null() && !is_in(&names["enum"]) || is_in(&names["not"]["enum"])
    };
    let by_condition = || {
        let condition = &rules["if"];
        let wanted = condition["properties"].as_object().into_iter().flatten();
        let wanted = wanted.filter_map(|(name, takes)| Some((name, takes.get("const")?)));
        let (mut holds, mut fails) = (has_all(&condition["required"]), false);
        for (name, wanted) in wanted {
            let value = table.iter().find(|key| key.name == *name).and_then(|key| key.value.as_ref());
            holds &= value == Some(wanted);
            fails |= value.is_some_and(|value| value != wanted);
        }
        // What is not written yet may still come.
        (fails || forbid(&rules["then"], table)) && (holds || forbid(&rules["else"], table))
    };
    table.iter().any(is_forbidden)
        || items(&rules["not"]["anyOf"]).iter().any(|set| set["required"].is_array() && has_all(&set["required"]))
        || items(&rules["allOf"]).iter().any(|rules| forbid(rules, table))
        || !rules["if"].is_null() && by_condition()
}

fn of_key(key: &Key, insert: String, replaces: &Range<usize>) -> Proposal {
    let (kind, detail) =
        if key.is_table() { (ProposalKind::Table, String::new()) } else { (ProposalKind::Key, key.accepts()) };
    Proposal { about: key.meaning(), insert, ..Proposal::new(name_of(key), kind, detail, replaces) }
}

/// The keys of tables whose readers ask for none of them one by one, as the rules of these keys describe them: the
/// fields of a message, whose names the file chooses, and what they take.
fn within(keys: &[Key]) -> Vec<Key> {
    let mut found = Vec::new();
    for key in keys {
        collect(key, &key.path, &key.takes, &mut found);
    }
    found.retain(|inner: &Key| !keys.iter().any(|key| key.split().0 == inner.split().0));
    found
}

fn collect(key: &Key, path: &str, takes: &Value, found: &mut Vec<Key>) {
    forms(takes).into_iter().for_each(|form| collect_properties(key, path, form, found));
}

fn collect_properties(key: &Key, path: &str, takes: &Value, found: &mut Vec<Key>) {
    let named = takes["properties"].as_object().into_iter().flatten().map(|(name, takes)| (name.as_str(), takes));
    let chosen = takes.get("additionalProperties").filter(|takes| takes.is_object()).map(|takes| ("NAME", takes));
    for (name, takes) in named.chain(chosen) {
        let path = format!("{path}.{name}");
        collect(key, &path, takes, found);
        let about = takes["description"].as_str().unwrap_or_default().to_owned();
        let (takes, needs) = (takes.clone(), key.needs.clone());
        match found.iter_mut().find(|known| known.path == path) {
            Some(known) => known.takes = json!({ "anyOf": [known.takes.take(), takes] }),
            None => found.push(Key { about, needs, ..Key::new(path, takes) }),
        }
    }
}

/// What a key takes, and each form that it may have instead.
fn forms(takes: &Value) -> Vec<&Value> {
    let several = ["anyOf", "oneOf", "allOf"].into_iter().flat_map(|key| takes[key].as_array()).flatten();
    let others = ["then", "else"].into_iter().filter_map(|key| takes.get(key)).chain(several);
    std::iter::once(takes).chain(others.flat_map(forms)).collect()
}

/// The values that a key accepts, as far as they can be listed.
fn values(key: &Key, is_quoted: bool, word: &Range<usize>) -> Vec<Proposal> {
    let mut listed: BTreeSet<String> = BTreeSet::new();
    let default = key.takes.get("default").filter(|value| !value.is_array() && *value != "");
    listed.extend(default.map(Value::to_string));
    // The items of an array are of one type.
    let items = (key.takes["type"] == "array").then(|| forms(&key.takes["items"]));
    for takes in forms(&key.takes).into_iter().chain(items.into_iter().flatten()) {
        listed.extend(takes["enum"].as_array().into_iter().flatten().map(Value::to_string));
        if takes["type"] == "boolean" {
            listed.extend(["true".to_owned(), "false".to_owned()]);
        }
    }
    let value = |value: &String| Proposal {
        about: key.about.clone(),
        insert: if is_quoted { content(value).to_owned() } else { value.clone() },
        ..Proposal::new(content(value), ProposalKind::Value, key.accepts(), word)
    };
    listed.iter().filter(|value| !is_quoted || value.starts_with('"')).map(value).collect()
}

/// The key with this path; one that the readers name comes before one that the file chooses.
pub(crate) fn key_at<'k>(keys: &'k [Key], path: &[String]) -> Option<&'k Key> {
    let chosen = |key: &&Key| key.path.split('.').filter(|part| is_chosen(part.trim_end_matches("[]"))).count();
    keys.iter().filter(|key| is_at(&key.path, path)).min_by_key(chosen)
}

/// The header of a table of the top level.
pub(crate) fn header(key: &Key) -> String {
    let name = name_of(key);
    if key.path.ends_with("[]") { format!("[[{name}]]\n") } else { format!("[{name}]\n") }
}

/// The simplest value that a key accepts, in TOML.
pub(crate) fn simplest(key: &Key) -> String {
    let takes = &key.takes;
    let listed = takes["enum"].get(0).or(takes.get("default")).or(takes.get("minimum"));
    listed.map_or_else(
        || match takes["type"].as_str().or_else(|| takes["type"][0].as_str()) {
            Some("boolean") => "false".to_owned(),
            Some("integer" | "number") => {
                let [least, most] = ["exclusiveMinimum", "exclusiveMaximum"].map(|limit| takes[limit].as_f64());
                match (least, most) {
                    (Some(least), Some(most)) => f64::midpoint(least, most),
                    (least, _) => least.map_or(1.0, |least| least + 1.0),
                }
                .to_string()
            }
            Some("array") => {
                let items = usize::try_from(takes["minItems"].as_u64().unwrap_or(0)).unwrap_or(0);
                format!("[{}]", vec!["0"; items].join(", "))
            }
            Some("object") => "{}".to_owned(),
            _ => "\"\"".to_owned(),
        },
        Value::to_string,
    )
}

/// The last part of a key's path, without the mark of an array.
pub(crate) fn name_of(key: &Key) -> &str {
    key.split().1.trim_end_matches("[]")
}

/// Whether this stands for names that the file chooses.
pub(crate) fn is_chosen(name: &str) -> bool {
    name.chars().all(char::is_uppercase)
}

/// Whether a declared path is that of these parts.
fn is_at(declared: &str, path: &[String]) -> bool {
    let parts: Vec<&str> = declared.split('.').filter(|part| !part.is_empty()).collect();
    let is_same = |(declared, part): (&&str, &String)| {
        is_chosen(declared.trim_end_matches("[]")) || declared.trim_end_matches("[]") == part
    };
    parts.len() == path.len() && parts.iter().zip(path).all(is_same)
}

/// A name as a TOML key.
fn as_key(name: &str) -> String {
    let is_bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    // JSON writes strings as TOML does.
    if is_bare { name.to_owned() } else { Value::from(name).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names that are proposed at the `|` of a text.
    fn proposed(marked: &str, keys: &[Key]) -> Vec<String> {
        let at = marked.find('|').unwrap();
        let names = |blank: Blank<'_>| {
            assert_eq!(blank.what, Referent::Place);
            vec![Proposal::new("Dock", ProposalKind::Name, "a place", &(0..blank.written.len()))]
        };
        proposals(&marked.replacen('|', "", 1), at, keys, &names).into_iter().map(|proposal| proposal.insert).collect()
    }

    /// The keys of a reader that requests these keys of a table.
    fn keys(of_battery: &[&str]) -> Vec<Key> {
        Key::all(|root| {
            let _ = root.one_of("mode", &[("fast", 1), ("slow", 2)]).about("How.").optional();
            let battery = root.table("battery").about("The battery.").optional();
            if let Some(battery) = battery {
                for key in of_battery {
                    let _ = battery.number(key).about("Its charge.").within(0.0..=100.0).default(80.0);
                }
            }
            let _ = root.text("start").about("Where it begins.").refers_to(Referent::Place).optional();
            let _ = root.text("about").optional();
        })
    }

    #[test]
    fn a_key_is_proposed_because_its_reader_asks_for_it() {
        assert_eq!(proposed("[battery]\n|", &keys(&["charge_pct", "drain_pct"])), ["charge_pct = ", "drain_pct = "]);
        assert_eq!(proposed("[battery]\n|", &keys(&["drain_pct"])), ["drain_pct = "]);
        let explained = |keys: &[Key]| explanation("[battery]\ncharge_pct = 3\n", 12, keys);
        let text = explained(&keys(&["charge_pct"])).unwrap().text;
        assert_eq!(text, "`battery.charge_pct`\n\nIts charge. [a number from 0 to 100; default 80]");
        assert_eq!(explained(&keys(&["drain_pct"])), None);
    }

    #[test]
    fn the_proposed_keys_are_those_of_the_readers() {
        for kind in [Toml::Scenario, Toml::Campaign, Toml::Interface, Toml::Places, Toml::Mapping] {
            let keys = kind.keys();
            for key in keys.iter().filter(|key| !is_chosen(key.split().1)) {
                let (table, _) = key.split();
                let header = table.split('.').filter(|part| !part.is_empty());
                let header: Vec<&str> = header.map(|part| part.trim_end_matches("[]")).collect();
                let text = if header.is_empty() { "|".to_owned() } else { format!("[{}]\n|", header.join(".")) };
                let at = text.len() - 1;
                let proposals = proposals(&text[..at], at, &keys, &|_| Vec::new());
                assert!(proposals.iter().any(|proposal| proposal.name == name_of(key)), "{} of {kind:?}", key.path);
            }
        }
    }

    #[test]
    fn what_is_there_is_not_proposed_again() {
        let keys = keys(&["charge_pct"]);
        assert_eq!(proposed("|", &keys), ["mode = ", "start = ", "about = ", "[battery]"]);
        assert_eq!(proposed("mode = \"fast\"\n|", &keys), ["start = ", "about = ", "[battery]"]);
        assert_eq!(proposed("battery.|", &keys), ["charge_pct = "]);
        assert_eq!(proposed("[|]", &keys), ["battery"]);
        assert_eq!(proposed("[battery]\n[|]", &keys), [""; 0]);
        assert_eq!(proposed("[[|]]", &keys), [""; 0]);
        assert_eq!(proposed("battery = { charge_pct = 1, | }", &keys), [""; 0]);
    }

    #[test]
    fn keys_of_other_forms_are_not_proposed() {
        let names = |kind: Toml, text: &str| -> Vec<String> {
            let found = proposals(text, text.len(), &kind.keys(), &|_| Vec::new());
            found.into_iter().map(|proposal| proposal.name).collect()
        };
        let component = |written: &str| names(Toml::Scenario, &format!("[components.Door]\n{written}\n"));
        assert_eq!(component("builtin = \"door\""), ["door"]);
        assert_eq!(component("ros = \"/robot\""), ["interface"]);
        assert_eq!(component("machine = \"door.scxml\""), ["interface", "data"]);
        let of_sensor = component("within_m = 3");
        assert!(of_sensor.contains(&"builtin".into()) && !of_sensor.contains(&"machine".into()));
        assert!(component("builtin = \"door\"\nonly = []").contains(&"door".into()), "beside a mistake");
        let headers = |builtin: &str| {
            names(Toml::Scenario, &format!("[components.Ear]\nbuiltin = \"{builtin}\"\n[[components.Ear."))
        };
        assert_eq!((headers("microphone"), headers("tray")), (vec!["hears".to_owned()], Vec::new()));
        let monitor = |written: &str| names(Toml::Scenario, &format!("[[monitors]]\n{written}\n"));
        assert_eq!(
            (monitor("zone = \"a\""), monitor("figure = \"5 (a)\"")),
            (vec!["name".into()], vec!["name".into()])
        );
        let place = |written: &str| names(Toml::Places, &format!("[Dock]\n{written}\n"));
        assert_eq!(place("position_m = [1, 2]"), ["heading_deg", "position_tolerance_m", "heading_tolerance_deg"]);
        assert_eq!(place("keep_out = true"), ["speed_mps", "corners_m"]);
        let leaf = |written: &str| names(Toml::Scenario, &format!("[leaves.Pick]\n{written}\n"));
        assert!(
            leaf("request = \"Arm.pick\"").iter().all(|name| !["machine", "action", "topic"].contains(&name.as_str()))
        );
    }

    #[test]
    fn values_are_those_that_the_reader_accepts() {
        let keys = keys(&["charge_pct"]);
        assert_eq!(proposed("mode = |", &keys), ["\"fast\"", "\"slow\""]);
        assert_eq!(proposed("mode = \"|\"", &keys), ["fast", "slow"]);
        assert_eq!(proposed("battery.charge_pct = |", &keys), ["80"]);
        assert_eq!(proposed("start = |", &keys), ["\"Dock\""]);
        assert_eq!(proposed("start = \"D|", &keys), ["Dock"]);
        for nothing in ["nothing = |", "about = |", "about = \"|\""] {
            assert_eq!(proposed(nothing, &keys), [""; 0]);
        }
    }
}
