//! Results as SARIF 2.1.0 (OASIS), the format of static analysis, for code scanning.
//!
//! It has what went wrong and has a place in a file: findings in files, and cases that failed. A case whose subject is
//! written nowhere is at the first line of the file that its suite is about, and so is a step that led to it. What
//! passed is left out: GitHub ignores `kind`, and would raise an alert. What is about no file is a notification of the
//! invocation.
//!
//! Texts follow 3.11: braces are doubled, and what would be a link is escaped. Columns and offsets count Unicode code
//! points. Paths below the current folder are relative to `%SRCROOT%`. Fingerprints do not depend on lines.

use std::collections::{BTreeMap, HashMap};
use std::path::{Component, Path};

use recording::InputFile;
use serde_json::{Value, json};

use crate::file_place::{FilePlace, TextRegion};
use crate::results::{Case, CaseResult, FileFinding, FindingKind, Results, Suite, TrailStep};

/// GitHub refuses a file with more results.
const MOST_RESULTS: usize = 25_000;
/// GitHub shows no more steps of a result.
const MOST_STEPS: usize = 1000;
/// All results together have no more steps than this, so that the file stays below GitHub's 10 MB when compressed.
const MOST_STEPS_OF_ALL: usize = 100_000;
/// Longer messages are cut, in bytes.
const MOST_TEXT: usize = 4000;

/// What every file of ours has near its beginning: keys are in alphabetical order.
const OURS: &str = "\"properties\": {\n    \"madeBy\": \"steward\"";

/// How the name of every run begins.
const ID: &str = "steward ";

/// The base of paths below the current folder.
const ROOT: &str = "%SRCROOT%";
/// The base of files that are not on disk.
const SHIPPED: &str = "STEWARD";

/// Whether a file that begins like this is one of ours: no string in JSON has the end of a line.
#[must_use]
pub(crate) fn begins(text: &str) -> bool {
    text.starts_with('{') && text.contains(OURS)
}

/// Results as SARIF, and what is left out because of limits, in words.
#[must_use]
pub(crate) fn document(results: &Results) -> (String, Vec<String>) {
    let mut log = SarifLog::default();
    results.suites.iter().for_each(|suite| log.add(suite));
    log.document(results.command)
}

/// How bad a result is, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Error,
    Warning,
    Note,
}

impl Level {
    fn of(kind: FindingKind) -> Self {
        match kind {
            FindingKind::Error => Self::Error,
            FindingKind::Warning => Self::Warning,
            FindingKind::Unreached | FindingKind::Rate => Self::Note,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// What is reported under one name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Rule {
    id: String,
    /// What it means, in a few words.
    short: String,
    /// The same in full.
    full: String,
    /// What to do about it.
    help: &'static str,
}

impl Rule {
    fn of_finding(kind: FindingKind) -> Self {
        let (id, short, help) = match kind {
            FindingKind::Error => {
                ("file-error", "Something in a file is wrong", "The message states what is accepted.")
            }
            FindingKind::Warning => {
                ("file-warning", "Something in a file looks wrong", "The message states what is unusual about it.")
            }
            FindingKind::Unreached => (
                "unreached",
                "No run reaches it",
                "Under the assumptions of the proof, it could be left out; or an assumption is too narrow.",
            ),
            FindingKind::Rate => (
                "violation-rate",
                "A property is violated in some runs",
                "The page of the campaign names runs in which it is violated.",
            ),
        };
        Self { id: id.to_owned(), short: short.to_owned(), full: short.to_owned(), help }
    }

    fn of_case(case: &Case) -> Self {
        let name = &case.name;
        let (id, short, help) = match case.group {
            "properties" | "proofs" => (
                format!("property/{name}"),
                format!("The property {name}"),
                "The steps lead from the first message that matters to the verdict.",
            ),
            group => {
                (group.to_owned(), format!("The {group} are not as they should be"), "The message states what differs.")
            }
        };
        let full = if case.about.is_empty() { short.clone() } else { format!("{name}: {}", case.about) };
        Self { id, short, full, help }
    }
}

/// A result before it is written.
struct SarifResult {
    level: Level,
    rule: Rule,
    message: String,
    place: FilePlace,
    /// What led to it, and where that is written.
    steps: Vec<(String, FilePlace)>,
    /// What identifies it beside its rule and file.
    identity: String,
}

#[derive(Default)]
struct SarifLog {
    found: Vec<SarifResult>,
    /// What is about no file.
    notifications: Vec<(Level, String)>,
    /// The files that the results were made from, with their hashes.
    inputs: Vec<InputFile>,
    has_error: bool,
    steps: usize,
}

impl SarifLog {
    fn add(&mut self, suite: &Suite) {
        let notes = suite.notes.iter().map(|note| (Level::Note, format!("{}: {note}", suite.name)));
        self.notifications.extend(notes);
        self.inputs.extend(suite.inputs().iter().cloned());
        for FileFinding { kind, message, help, place } in &suite.findings {
            let help = help.as_ref().map_or_else(String::new, |help| format!("\n\nHelp: {help}"));
            let marked = place.as_ref().and_then(|place| place.region.as_ref()).map_or("", |region| &region.text);
            let identity = format!("{message}\0{marked}");
            let (level, rule) = (Level::of(*kind), Rule::of_finding(*kind));
            self.put(suite, level, rule, (format!("{message}{help}"), identity), place.as_ref(), &[]);
        }
        for case in suite.cases.iter().filter(|case| case.result.is_bad()) {
            self.has_error |= matches!(case.result, CaseResult::Error(_));
            if suite.is_about_files() || case.is_repeated {
                continue;
            }
            let details = match &case.result {
                CaseResult::Failed { details, .. } if !details.is_empty() => format!("\n\n{details}"),
                _ => String::new(),
            };
            let message = format!("{}{details}", case.result.reason().unwrap_or_default());
            let texts = (format!("{}: {message}", suite.name), format!("{}\0{}", suite.name, case.name));
            self.put(suite, Level::Error, Rule::of_case(case), texts, case.place.as_ref(), &case.trail);
        }
    }

    fn put(
        &mut self,
        suite: &Suite,
        level: Level,
        rule: Rule,
        (message, identity): (String, String),
        place: Option<&FilePlace>,
        trail: &[TrailStep],
    ) {
        let Some(place) = place.or(suite.file.as_ref()).cloned() else {
            self.notifications.push((level, message));
            return;
        };
        let kept = trail.len().min(MOST_STEPS).min(MOST_STEPS_OF_ALL - self.steps);
        self.steps += kept;
        let left_out = match trail.len() - kept {
            0 => String::new(),
            first => format!("\n\nThe first {first} of {} steps are left out", trail.len()),
        };
        let place_of = |step: &TrailStep| step.place.as_ref().or(suite.file.as_ref()).unwrap_or(&place).clone();
        let steps = trail[trail.len() - kept..].iter().map(|step| (step.words.clone(), place_of(step))).collect();
        self.found.push(SarifResult { level, rule, message: message + &left_out, place, steps, identity });
    }

    fn document(mut self, command: &str) -> (String, Vec<String>) {
        // The worst come first: GitHub shows 5,000.
        self.found.sort_by_key(|found| found.level);
        let more = self.found.len().saturating_sub(MOST_RESULTS);
        self.found.truncate(MOST_RESULTS);
        let cut = (more > 0)
            .then(|| format!("{more} of {} results are left out: GitHub accepts {MOST_RESULTS}", more + MOST_RESULTS));
        self.notifications.extend(cut.iter().map(|words| (Level::Warning, words.clone())));
        let mut rules: BTreeMap<&Rule, usize> = self.found.iter().map(|found| (&found.rule, 0)).collect();
        rules.values_mut().enumerate().for_each(|(index, place)| *place = index);
        let rule = |Rule { id, short, full, help }: &&Rule| {
            json!({
                "id": id,
                "shortDescription": text(short),
                "fullDescription": text(full),
                "help": text(help),
            })
        };
        let mut seen: HashMap<String, usize> = HashMap::new();
        let mut result = |found: &SarifResult| {
            let mut result = json!({
                "ruleId": found.rule.id,
                "ruleIndex": rules[&found.rule],
                "level": found.level.name(),
                "message": text(&found.message),
                "locations": [location(&found.place)],
            });
            let address = address(&found.place).to_string();
            let identity = format!("{}\0{address}\0{}", found.rule.id, found.identity);
            let hash = blake3::hash(identity.as_bytes()).to_hex();
            // Equal ones are distinguished by their order.
            let number = seen.entry(identity).and_modify(|number| *number += 1).or_insert(1);
            result["partialFingerprints"] = json!({ "steward/v1": format!("{}:{number}", &hash[..32]) });
            if !found.steps.is_empty() {
                let steps: Vec<Value> = found.steps.iter().map(flow_step).collect();
                result["codeFlows"] = json!([{ "threadFlows": [{ "locations": steps }] }]);
            }
            result
        };
        let results: Vec<Value> = self.found.iter().map(&mut result).collect();
        self.inputs.sort_by(|one, other| (one.shipped, &one.path).cmp(&(other.shipped, &other.path)));
        self.inputs.dedup();
        let input = |InputFile { path, blake3, shipped }: &InputFile| {
            let place = FilePlace { is_shipped: *shipped, ..FilePlace::whole(path) };
            json!({ "location": address(&place), "hashes": { "blake3": blake3 } })
        };
        let commit = recording::commit().map_or_else(String::new, |commit| format!(" (commit {commit})"));
        let notification = |(level, words): &(Level, String)| json!({ "level": level.name(), "message": text(words) });
        let document = json!({
            "$schema": "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json",
            "version": "2.1.0",
            "properties": { "madeBy": "steward" },
            "runs": [{
                "tool": { "driver": {
                    "name": "steward",
                    "version": format!("{}{commit}", env!("CARGO_PKG_VERSION")),
                    "semanticVersion": env!("CARGO_PKG_VERSION"),
                    "rules": rules.keys().map(rule).collect::<Vec<_>>(),
                } },
                // GitHub keeps the results of several commands apart by it.
                "automationDetails": { "id": format!("{ID}{command}/") },
                "columnKind": "unicodeCodePoints",
                "originalUriBaseIds": {
                    ROOT: { "description": text("The folder in which steward ran") },
                    SHIPPED: { "description": text("Not on disk: files that come with steward, and texts made from others") },
                },
                "invocations": [{
                    "executionSuccessful": !self.has_error,
                    "toolExecutionNotifications": self.notifications.iter().map(notification).collect::<Vec<_>>(),
                }],
                "artifacts": self.inputs.iter().map(input).collect::<Vec<_>>(),
                "results": results,
            }],
        });
        let document = serde_json::to_string_pretty(&document).expect("a JSON value is always JSON") + "\n";
        (document, cut.into_iter().collect())
    }
}

fn flow_step((words, place): &(String, FilePlace)) -> Value {
    let mut location = location(place);
    location["message"] = text(words);
    json!({ "location": location })
}

/// A message (3.11), cut if it is very long.
fn text(words: &str) -> Value {
    let mut words = words.to_owned();
    if words.len() > MOST_TEXT {
        words.truncate(words.floor_char_boundary(MOST_TEXT));
        words.push('…');
    }
    json!({ "text": words.replace('{', "{{").replace('}', "}}").replace("](", "\\](") })
}

fn location(place: &FilePlace) -> Value {
    let region = match &place.region {
        Some(region) => {
            let TextRegion { start_line, start_column, end_line, end_column, char_offset, char_length, .. } = region;
            json!({
                "startLine": start_line,
                "startColumn": start_column,
                "endLine": end_line,
                "endColumn": end_column,
                "charOffset": char_offset,
                "charLength": char_length,
            })
        }
        // GitHub demands a line.
        None => json!({ "startLine": 1 }),
    };
    json!({ "physicalLocation": { "artifactLocation": address(place), "region": region } })
}

/// The address of a file: below the current folder, elsewhere on disk, or one that comes with the program.
fn address(place: &FilePlace) -> Value {
    match place.path() {
        None => json!({ "uri": encoded(Path::new(&place.file)), "uriBaseId": SHIPPED }),
        Some(path) if path.is_relative() => json!({ "uri": encoded(&path), "uriBaseId": ROOT }),
        Some(path) => json!({ "uri": format!("file://{}", encoded(&path)) }),
    }
}

/// A path as part of a URI (RFC 3986).
fn encoded(path: &Path) -> String {
    let part = |part: Component<'_>| {
        let mut encoded = String::new();
        for byte in part.as_os_str().to_string_lossy().bytes() {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => encoded.push(byte.into()),
                _ => encoded += &format!("%{byte:02X}"),
            }
        }
        encoded
    };
    let parts = path.components().filter(|part| !matches!(part, Component::RootDir | Component::CurDir));
    let start = if path.has_root() { "/" } else { "" };
    format!("{start}{}", parts.map(part).collect::<Vec<_>>().join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_neither_links_nor_placeholders() {
        assert_eq!(text("[a](b) {0}")["text"], "[a\\](b) {{0}}");
        let long = "é".repeat(MOST_TEXT);
        assert_eq!(text(&long)["text"].as_str().map(str::len), Some(MOST_TEXT + '…'.len_utf8()));
    }

    #[test]
    fn addresses_are_relative_below_the_current_folder() {
        let address = |file: &str| address(&FilePlace::whole(file));
        assert_eq!(address("./src/sarif.rs"), json!({ "uri": "src/sarif.rs", "uriBaseId": ROOT }));
        assert_eq!(address("src/../src/sarif.rs"), json!({ "uri": "src/sarif.rs", "uriBaseId": ROOT }));
        assert_eq!(address("no/such ü:file"), json!({ "uri": "no/such%20%C3%BC%3Afile", "uriBaseId": SHIPPED }));
        let elsewhere = tempfile::NamedTempFile::new().expect("a file");
        let uri = address(&elsewhere.path().to_string_lossy())["uri"].as_str().map(str::to_owned);
        assert!(uri.is_some_and(|uri| uri.starts_with("file:///")));
    }

    #[test]
    fn no_more_results_than_github_accepts_are_written_and_the_worst_come_first() {
        let finding = |kind| FileFinding {
            kind,
            message: "wrong".to_owned(),
            help: None,
            place: Some(FilePlace::whole("a.toml")),
        };
        let mut findings = vec![finding(FindingKind::Warning); MOST_RESULTS + 2];
        findings.push(finding(FindingKind::Error));
        let suite = Suite { findings, ..Suite::default() };
        let (document, cut) = document(&Results { command: "check", suites: vec![suite] });
        let run = &serde_json::from_str::<Value>(&document).expect("JSON")["runs"][0];
        let results = run["results"].as_array().expect("results");
        assert_eq!((results.len(), &results[0]["level"]), (MOST_RESULTS, &json!("error")));
        let words = "3 of 25003 results are left out: GitHub accepts 25000";
        assert_eq!(cut, [words]);
        assert_eq!(run["invocations"][0]["toolExecutionNotifications"][0]["message"]["text"], words);
        let fingerprints: std::collections::BTreeSet<_> =
            results.iter().map(|result| result["partialFingerprints"].to_string()).collect();
        assert_eq!(fingerprints.len(), MOST_RESULTS, "equal results are told apart");
    }

    #[test]
    fn a_long_trail_keeps_its_end_and_says_so() {
        let step = |number: usize| TrailStep { words: format!("step {number}"), place: None };
        let failed = CaseResult::Failed { message: "wrong".to_owned(), details: String::new() };
        let trail = (0..MOST_STEPS + 5).map(step).collect();
        let case = Case { group: "properties", name: "p".to_owned(), result: failed, trail, ..Case::default() };
        let suite = Suite { cases: vec![case], file: Some(FilePlace::whole("a.toml")), ..Suite::default() };
        let (document, _) = document(&Results { command: "run", suites: vec![suite] });
        let result = serde_json::from_str::<Value>(&document).expect("JSON")["runs"][0]["results"][0].clone();
        let steps = result["codeFlows"][0]["threadFlows"][0]["locations"].as_array().cloned().expect("steps");
        assert_eq!((steps.len(), &steps[0]["location"]["message"]["text"]), (MOST_STEPS, &json!("step 5")));
        assert!(result["message"]["text"].as_str().is_some_and(|text| text.contains("first 5 of 1005 steps")));
    }
}
