//! The chapters of docs/src/reference: the code generates what it can, between two comments; the rest is checked.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use bt::{Kind, builtin_ports};
use campaigns::CampaignFile;
use channels::Symbol;
use diagnostics::document::Key;
use interfaces::{Interface, KINDS as KINDS_OF_FIELDS};
use monitors::{GRAMMAR, OPERATORS, Pattern, PatternEvents, Scope};
use scenarios::faults::{KINDS, Parameter};
use scenarios::scenario::DeviceKind;
use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{binary, report, steward};

/// Fails if a file of the repository differs from what the code generates; with `STEWARD_BLESS`, writes it instead.
pub(crate) fn compare(file: &str, made: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    if std::env::var_os("STEWARD_BLESS").is_some() {
        std::fs::write(&path, made).unwrap();
    }
    let command = "STEWARD_BLESS=1 cargo test --test main -- reference schemas architecture";
    assert!(
        std::fs::read_to_string(&path).unwrap_or_default() == made,
        "{file} is out of date; to regenerate it: {command}"
    );
}

/// Compares a part of a chapter.
fn compare_part(chapter: &str, part: &str, made: &str) {
    compare_part_of(&format!("docs/src/reference/{chapter}.md"), part, made);
}

/// Compares a part of a page: what is between two comments.
pub(crate) fn compare_part_of(file: &str, part: &str, made: &str) {
    let text = read(file);
    let begin = format!("<!-- The code writes this: {part} -->\n");
    let (before, rest) = text.split_once(&begin).unwrap_or_else(|| panic!("{file} has no {begin}"));
    let (_, after) = rest.split_once("<!-- end -->\n").unwrap_or_else(|| panic!("{file} has no end of {part}"));
    compare(file, &format!("{before}{begin}\n{}\n\n<!-- end -->\n{after}", made.trim()));
}

/// A file of the repository.
fn read(file: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

/// A table in Markdown.
pub(crate) fn table<const N: usize>(head: [&str; N], rows: impl IntoIterator<Item = [String; N]>) -> String {
    let line = |cells: [String; N]| format!("| {} |\n", cells.join(" | "));
    let head = line(head.map(str::to_owned)) + &line(head.map(|_| "---".to_owned()));
    rows.into_iter().fold(head, |text, row| text + &line(row.map(|cell| cell.replace('|', "\\|").replace('\n', " "))))
}

fn code(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("`{text}`") }
}

#[test]
fn commands() {
    compare_part("commands", "commands", &help_of(&[]));
}

/// The help of a command and its subcommands, as the binary prints it.
fn help_of(path: &[&str]) -> String {
    let output = Command::new(binary()).args(path).arg("--help").env("COLUMNS", "80").output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
    let listed = help.split("\nCommands:\n").nth(1).unwrap_or_default().lines().take_while(|line| !line.is_empty());
    let names = listed.filter_map(|line| line.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty()));
    let below: String = names.map(|name| help_of(&[path, &[name]].concat())).collect();
    format!("## `{}`\n\n```text\n{}\n```\n\n{below}", [&["steward"], path].concat().join(" "), help.trim_end())
}

#[test]
fn scenario() {
    compare_part("scenario", "keys", &keys(scenarios::scenario::ScenarioFile::keys()));
}

#[test]
fn mappings() {
    compare_part("mappings", "keys", &keys(&bags::Mapping::keys()));
}

#[test]
fn places() {
    let keys = maps::PlacesFile::keys();
    compare_part("files", "places", &rows(keys.iter().filter(|key| !key.is_table()).collect()));
}

#[test]
fn interfaces() {
    let keys = Interface::keys();
    let rows = keys.iter().filter(|key| !key.is_table());
    let rows = rows.map(|key| [code(&key.path), key.about.clone(), key.accepts()]);
    compare_part("interfaces", "keys", &table(["key", "meaning", "takes"], rows));
    let rows = KINDS_OF_FIELDS.iter().map(|(kind, about)| [code(kind), format!("{about}.")]);
    compare_part("interfaces", "kinds", &table(["kind", "a field holds"], rows));
    let device =
        |kind: DeviceKind| format!("`builtin = \"{}\"`:\n\n```toml\n{}```\n", kind.name(), kind.interface_file());
    let definition = |name: &str| {
        let text = read(&format!("components/devices/interfaces/{name}"));
        format!("`{name}`:\n\n```text\n{text}```\n")
    };
    let definitions = ["steward_msgs/srv/GetPeople.srv", "steward_msgs/srv/Say.srv"].map(definition);
    compare_part("interfaces", "devices", &[&DeviceKind::ALL.map(device)[..], &definitions].concat().join("\n"));
}

#[test]
fn examples_of_interface_files_are_interfaces() {
    let page = read("docs/src/reference/interfaces.md");
    let mut files: BTreeMap<&Path, &str> = BTreeMap::new();
    let parts: Vec<&str> = page.split("\n```").collect();
    for pair in parts.windows(2) {
        let name = pair[0].trim_end().lines().last().and_then(|line| line.strip_prefix('`')?.strip_suffix("`:"));
        if let (Some(name), Some((_, text))) = (name, pair[1].split_once('\n')) {
            files.insert(Path::new(name), text);
        }
    }
    let read = |path: &Path| {
        let text = files.get(path).ok_or(std::io::ErrorKind::NotFound)?;
        Ok(text.as_bytes().to_vec())
    };
    let interfaces = files.keys().filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let loaded = interfaces.map(|path| Interface::load(path, &[Symbol::new("Dock")], &read).map(|_| ()));
    let loaded: Vec<_> = loaded.collect();
    assert!(loaded.len() == 2 && loaded.iter().all(Result::is_ok), "{loaded:?}");
}

#[test]
fn campaign() {
    compare_part("campaign", "keys", &keys(&CampaignFile::keys()));
}

/// All keys, table by table.
fn keys(keys: &[Key]) -> String {
    let mut text = String::new();
    let top: Vec<&Key> = keys.iter().filter(|key| key.split().0.is_empty() && !key.is_table()).collect();
    text += &rows(top);
    for owner in keys.iter().filter(|key| key.is_table()) {
        let name = owner.path.replace("[]", "");
        let name = if owner.path.ends_with("[]") { format!("[[{name}]]") } else { format!("[{name}]") };
        text += &format!("\n## `{name}`\n\n{}\n\n", owner.about);
        text += &rows(keys.iter().filter(|key| key.split().0 == owner.path && !key.is_table()).collect());
    }
    text
}

fn rows(keys: Vec<&Key>) -> String {
    let row = |key: &Key| {
        let default = if key.required {
            "required".to_owned()
        } else {
            key.default().map_or_else(String::new, |text| code(&text))
        };
        [code(key.split().1), key.about.clone(), key.accepts(), default]
    };
    if keys.is_empty() {
        String::new()
    } else {
        table(["key", "meaning", "takes", "default"], keys.into_iter().map(row))
    }
}

#[test]
fn faults() {
    let mut text = String::new();
    let mut place = None;
    for kind in KINDS {
        if place != Some(kind.subsystem) {
            text += &format!("\n## {}\n", scenarios::faults::sentence(kind.subsystem.name()).trim_end_matches('.'));
            place = Some(kind.subsystem);
        }
        let momentary = if kind.is_momentary() { " Happens at one instant." } else { "" };
        text += &format!("\n### `{}`\n\n{}{momentary}\n\n", kind.name, scenarios::faults::sentence(kind.about));
        let parameters: Vec<Key> = kind.parameters.iter().map(Parameter::key).collect();
        text += &rows(parameters.iter().collect());
        text += &format!("\n```toml\n[[faults]]\nkind = \"{}\"\n{}\n```\n", kind.name, kind.example);
    }
    compare_part("faults", "kinds", &text);
}

#[test]
fn properties() {
    compare_part("properties", "grammar", &format!("```text\n{GRAMMAR}```"));
    let rows = OPERATORS.iter().map(|operator| {
        let signs: Vec<String> = operator.signs.split_whitespace().map(code).collect();
        [code(operator.written), signs.join(" "), operator.about.to_owned(), code(operator.example)]
    });
    compare_part("properties", "operators", &table(["written", "also", "meaning", "example"], rows));
}

#[test]
fn patterns() {
    let events = PatternEvents { p: "P", s: "S", q: "Q", r: "R" };
    let rows = Pattern::ALL.into_iter().flat_map(|pattern| {
        Scope::ALL.map(|scope| {
            let about = if scope == Scope::Globally { pattern.about() } else { "" };
            [about.to_owned(), scope.to_string(), code(&pattern.formula(scope, events))]
        })
    });
    compare_part("patterns", "patterns", &table(["what is required", "scope", "property"], rows));
}

#[test]
fn examples_of_operators_are_properties() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("all.scope");
    let event = |text: &str| {
        text.replace('E', "(BatteryReader, BatteryLevel, m[1] = <ok>)")
            .replace('F', "(Navigation, GoToDestination, true)")
    };
    let written = OPERATORS.iter().enumerate().map(|(number, operator)| match operator.written {
        "const" => format!("{}\n", operator.example),
        // No process of the shipped scenarios sends a list; the crate's own tests read this one.
        "any(C)" => String::new(),
        "property" | "timed" => format!("{}\n", event(operator.example).replace("phi", &format!("p{number}"))),
        _ => format!("property p{number} := {}\n", event(operator.example)),
    });
    std::fs::write(&file, written.collect::<String>()).unwrap();
    let output = steward(&["monitor", "check", file.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The comment above an item.
fn docs(attributes: &[syn::Attribute]) -> String {
    let line = |attribute: &syn::Attribute| {
        let syn::Meta::NameValue(meta) = &attribute.meta else { return None };
        let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) = &meta.value else { return None };
        meta.path.is_ident("doc").then(|| text.value().strip_prefix(' ').map_or_else(|| text.value(), str::to_owned))
    };
    let lines: Vec<String> = attributes.iter().filter_map(line).collect();
    without_links(&lines.join("\n"))
}

/// Documentation without the links that only rustdoc can resolve: ``[`a`](Self::a)`` and ``[`b`]``.
fn without_links(text: &str) -> String {
    let is_target = |line: &&str| !(line.starts_with("[`") && line.contains("`]: "));
    let mut text = text.lines().filter(is_target).collect::<Vec<_>>().join("\n");
    while let Some(at) = text.find("`](") {
        let end = at + text[at..].find(')').unwrap();
        text.replace_range(at + 1..=end, "");
    }
    text.replace("[`", "`").replace("`]", "`")
}

#[test]
fn nodes() {
    let file = syn::parse_file(&read("bt/src/kind.rs")).unwrap();
    let kinds = file.items.iter().find_map(|item| match item {
        syn::Item::Enum(item) if item.ident == "Kind" => Some(item),
        _ => None,
    });
    let kinds = kinds.unwrap();
    let (_, words) =
        docs(&kinds.attrs).split_once("\n\n").map(|(first, rest)| (first.to_owned(), rest.to_owned())).unwrap();
    compare_part("nodes", "words", &words);
    let mut text = String::new();
    for variant in &kinds.variants {
        let is_of = |kind: &&Kind| format!("{kind:?}").split('(').next() == Some(&variant.ident.to_string());
        let of: Vec<&Kind> = Kind::BUILTIN.iter().filter(is_of).collect();
        let Some(kind) = of.last() else {
            let outside = ["SubTree", "Condition", "Action"];
            assert!(outside.contains(&variant.ident.to_string().as_str()), "{} is not in BUILTIN", variant.ident);
            text += &format!("\n## `{}`\n\n{}\n", variant.ident, docs(&variant.attrs));
            continue;
        };
        let names: Vec<String> = of.iter().map(|kind| code(kind.name())).collect();
        let symbol = kind.symbol().map_or_else(String::new, |symbol| format!(", drawn as `{symbol}`"));
        text += &format!("\n## {}\n\n{}{symbol}.\n\n{}\n", names.join(", "), kind.category(), docs(&variant.attrs));
        let ports: Vec<[String; 3]> = builtin_ports(**kind)
            .map(|port| {
                let default =
                    if port.required { "required".to_owned() } else { port.default.map_or_else(String::new, code) };
                [code(port.name), port.takes.to_owned(), default]
            })
            .collect();
        if !ports.is_empty() {
            text += &format!("\n{}", table(["port", "takes", "default"], ports));
        }
    }
    compare_part("nodes", "kinds", &text);
}

/// Structs and enums that are written as JSON, with their fields and variants as in JSON.
#[derive(Default)]
struct Written {
    structs: BTreeMap<String, Vec<(String, syn::Type, String)>>,
    enums: BTreeMap<String, Vec<String>>,
}

impl Written {
    /// Reads them from these files.
    fn of(files: &[&str]) -> Self {
        let mut written = Self::default();
        for item in files.iter().flat_map(|file| syn::parse_file(&read(file)).unwrap().items) {
            match item {
                syn::Item::Struct(item) => {
                    let field = |field: syn::Field| {
                        if field.attrs.iter().any(is_not_written) {
                            return None;
                        }
                        let name = field.ident?.to_string().trim_start_matches("r#").to_owned();
                        Some((name, field.ty, docs(&field.attrs)))
                    };
                    written.structs.insert(item.ident.to_string(), item.fields.into_iter().filter_map(field).collect());
                }
                syn::Item::Enum(item) => {
                    let names = item.variants.iter().map(|variant| snake_case(&variant.ident.to_string()));
                    written.enums.insert(item.ident.to_string(), names.collect());
                }
                _ => {}
            }
        }
        written
    }

    /// A type's name in JSON and, if it contains a struct, that struct with the path from the field to it.
    fn type_in_words(&self, of: &syn::Type) -> (String, Option<(String, &'static str)>) {
        let syn::Type::Path(path) = of else {
            return match of {
                syn::Type::Reference(_) => ("string".to_owned(), None),
                _ => ("array of 3 numbers".to_owned(), None),
            };
        };
        let last = path.path.segments.last().unwrap();
        let inner = match &last.arguments {
            syn::PathArguments::AngleBracketed(arguments) => match arguments.args.first() {
                Some(syn::GenericArgument::Type(inner)) => Some(inner),
                _ => None,
            },
            _ => None,
        };
        let name = last.ident.to_string();
        match (name.as_str(), inner) {
            ("Option", Some(inner)) => {
                let (words, inside) = self.type_in_words(inner);
                (format!("{words} or null"), inside)
            }
            ("Vec", Some(inner)) => {
                let (words, inside) = self.type_in_words(inner);
                (format!("array of {words}s"), inside.map(|(name, _)| (name, "[]")))
            }
            ("String" | "Outcome" | "Certainty", _) => ("string".to_owned(), None),
            ("f64", _) => ("number".to_owned(), None),
            ("u64" | "usize", _) => ("integer".to_owned(), None),
            ("bool", _) => ("boolean".to_owned(), None),
            // A witness writes itself, as its documentation says.
            ("Map" | "Value" | "WitnessReport", _) => ("object".to_owned(), None),
            (name, _) if self.structs.contains_key(name) => ("object".to_owned(), Some((name.to_owned(), ""))),
            (name, _) => (self.enums.get(name).unwrap_or_else(|| panic!("what is {name}?")).join(" or "), None),
        }
    }

    /// The fields of a struct and of the structs in it, one section each; collects where each field is.
    fn sections(&self, root: &str, fields: &mut BTreeMap<String, BTreeSet<String>>) -> String {
        let mut text = String::new();
        let mut next = vec![(String::new(), root.to_owned())];
        while let Some((path, name)) = next.pop() {
            let mut below = Vec::new();
            let row = |(field, of, about): &(String, syn::Type, String)| {
                let (words, inside) = self.type_in_words(of);
                let at = if path.is_empty() { field.clone() } else { format!("{path}.{field}") };
                below.extend(inside.map(|(name, brackets)| (format!("{at}{brackets}"), name)));
                fields.entry(path.clone()).or_default().insert(field.clone());
                [code(field), words, about.clone()]
            };
            let rows: Vec<[String; 3]> = self.structs[&name].iter().map(row).collect();
            if !path.is_empty() {
                text += &format!("\n### `{path}`\n\n");
            }
            text += &table(["field", "type", "meaning"], rows);
            next.extend(below.into_iter().rev());
        }
        text
    }
}

/// Whether this is `serde(skip)`.
fn is_not_written(attribute: &syn::Attribute) -> bool {
    let is_skip = || attribute.parse_args::<syn::Ident>().is_ok_and(|what| what == "skip");
    attribute.path().is_ident("serde") && is_skip()
}

fn snake_case(name: &str) -> String {
    let letter = |(at, letter): (usize, char)| {
        let gap = if at > 0 && letter.is_uppercase() { "_" } else { "" };
        format!("{gap}{}", letter.to_lowercase())
    };
    name.char_indices().map(letter).collect()
}

/// Checks that the objects of a JSON file have exactly the fields that the reference lists.
fn check_fields(json: &Value, path: &str, fields: &BTreeMap<String, BTreeSet<String>>) {
    match json {
        Value::Array(items) => items.iter().for_each(|item| check_fields(item, &format!("{path}[]"), fields)),
        Value::Object(object) if fields.contains_key(path) => {
            assert_eq!(object.keys().cloned().collect::<BTreeSet<_>>(), fields[path], "the fields of `{path}`");
            for (name, value) in object {
                let at = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                check_fields(value, &at, fields);
            }
        }
        _ => {}
    }
}

#[test]
fn report_fields() {
    let mut fields = BTreeMap::new();
    let text = Written::of(&["scenarios/reports/src/report.rs", "scenarios/recording/src/provenance.rs"])
        .sections("Report", &mut fields);
    compare_part("report", "fields", &text);
    let folder = tempdir().unwrap();
    let short = ["--set", "execution.max_time_s=22", "--set", "snapshots.at=[\"start\"]"];
    check_fields(&report("battery_fault", folder.path(), &short), "", &fields);
}

#[test]
fn campaign_results() {
    let source = read("scenarios/campaigns/src/dataset.rs");
    let columns: Vec<&str> = source.lines().filter_map(|line| line.strip_prefix("//! |")).map(str::trim).collect();
    let columns: String = columns.iter().map(|line| format!("| {line}\n")).collect();
    compare_part("dataset", "columns", &columns);
    let statistics = "scenarios/campaigns/src/statistics";
    let files = [
        "scenarios/campaigns/src/summary.rs",
        "scenarios/recording/src/provenance.rs",
        &format!("{statistics}/count.rs"),
        &format!("{statistics}/sprt.rs"),
    ];
    let mut fields = BTreeMap::new();
    let text = Written::of(&files).sections("Summary", &mut fields);
    compare_part("dataset", "summary", &text);
    let folder = tempdir().unwrap();
    let file = folder.path().join("some.toml");
    let goal = "[goal]\nestimate = \"phi1\"\nhalf_width = 0.2\nconfidence = 0.6";
    std::fs::write(&file, format!("scenario = \"errand\"\nset = [\"execution.max_time_s=1\"]\nruns = 3\n{goal}"))
        .unwrap();
    let out = folder.path().join("out");
    steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    check_fields(&serde_json::from_str(&summary).unwrap(), "", &fields);
}

/// Each line of an event log has the fields of one row of its table.
#[test]
fn event_log() {
    let text = read("docs/src/reference/recordings.md");
    let fields = |row: &str| -> BTreeSet<String> {
        let cell = row.trim_start_matches('|').split('|').next().unwrap_or_default();
        cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let mut told: BTreeSet<BTreeSet<String>> =
        text.lines().filter(|line| line.starts_with("| `")).map(fields).collect();
    // A simulated run without nodes of ROS 2 loses no messages, so its log has no gaps.
    let of_gaps: BTreeSet<_> = told.extract_if(.., |row| row.contains("missing") || row.contains("resumed")).collect();
    assert_eq!(of_gaps.len(), 2);
    let folder = tempdir().unwrap();
    let log = folder.path().join("log.jsonl");
    let short = ["--no-snapshots", "--set", "execution.max_time_s=2", "--record", log.to_str().unwrap()];
    report("battery_fault", folder.path(), &short);
    let text = std::fs::read_to_string(&log).unwrap();
    let keys = |line: &str| serde_json::from_str::<serde_json::Map<_, Value>>(line).unwrap().keys().cloned().collect();
    assert_eq!(text.lines().map(keys).collect::<BTreeSet<BTreeSet<String>>>(), told);
}

/// Each topic of an MCAP file is a row of its table, with its type, and vice versa.
#[test]
fn topics() {
    let text = read("docs/src/reference/topics.md");
    let cells = |row: &str| row.split('`').skip(1).step_by(2).take(2).map(str::to_owned).collect::<Vec<_>>();
    let told: BTreeSet<Vec<String>> = text.lines().filter(|line| line.starts_with("| `")).map(cells).collect();
    let folder = tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let short = ["--no-snapshots", "--set", "execution.max_time_s=2", "--record", file.to_str().unwrap()];
    report("populated", folder.path(), &short);
    let summary = mcap::Summary::read(&std::fs::read(file).unwrap()).unwrap().unwrap();
    let found = summary.channels.values().map(|channel| {
        let [topic, schema] = [&channel.topic, &channel.schema.as_ref().unwrap().name].map(String::as_str);
        match topic.split('/').collect::<Vec<_>>()[..] {
            ["", "channels", from, to] => {
                assert_eq!(schema, format!("steward_msgs/msg/{from}To{to}"));
                ["/channels/SENDER/RECEIVER", "steward_msgs/msg/SENDERToRECEIVER"].map(str::to_owned).to_vec()
            }
            ["", laser, last] if laser.starts_with("laser_") => vec![format!("/laser_NAME/{last}"), schema.to_owned()],
            _ => vec![topic.to_owned(), schema.to_owned()],
        }
    });
    assert_eq!(found.collect::<BTreeSet<_>>(), told);
}
