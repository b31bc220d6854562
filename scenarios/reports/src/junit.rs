//! Results as JUnit XML.
//!
//! There are no times: the same results give the same bytes.

use std::fmt;

use diagnostics::markup::{attribute, text};

use crate::file_place::FilePlace;
use crate::results::{Case, CaseResult, Results, Suite};

/// How a file begins.
const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"steward\" ";

/// Whether a file that begins like this is one of ours.
#[must_use]
pub(crate) fn begins(text: &str) -> bool {
    text.starts_with(HEAD)
}

/// Results as JUnit XML.
#[must_use]
pub(crate) fn document(results: &Results) -> String {
    let counts = Counts::of(results.suites.iter().flat_map(|suite| &suite.cases));
    let suites: String = results.suites.iter().map(of_suite).collect();
    format!("{HEAD}{counts}>\n{suites}</testsuites>\n")
}

/// How many test cases there are, and how many failed, could not be carried out, or were skipped.
#[derive(Default)]
struct Counts {
    tests: usize,
    failures: usize,
    errors: usize,
    skipped: usize,
}

impl Counts {
    fn of<'c>(cases: impl IntoIterator<Item = &'c Case>) -> Self {
        let mut counts = Self::default();
        for case in cases {
            counts.tests += 1;
            counts.failures += usize::from(matches!(case.result, CaseResult::Failed { .. }));
            counts.errors += usize::from(matches!(case.result, CaseResult::Error(_)));
            counts.skipped += usize::from(matches!(case.result, CaseResult::Skipped(_)));
        }
        counts
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tests, failures, errors, skipped } = self;
        write!(f, "tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\"")
    }
}

fn of_suite(suite: &Suite) -> String {
    let Suite { name, notes, cases, .. } = suite;
    let name = attribute(name);
    let counts = Counts::of(cases);
    let fact = |name: &str, value: &str| {
        format!("      <property name=\"{}\" value=\"{}\"/>\n", attribute(name), attribute(value))
    };
    let facts: String = suite.all_facts().iter().map(|(name, value)| fact(name, value)).collect();
    let inputs: String =
        suite.inputs().iter().map(|input| fact(&format!("blake3 of {}", input.path), &input.blake3)).collect();
    let cases: String = cases.iter().map(|case| of_case(case, &name)).collect();
    let notes = match notes.as_slice() {
        [] => String::new(),
        notes => {
            let lines: Vec<String> = notes.iter().map(|note| text(note)).collect();
            format!("    <system-out>{}</system-out>\n", lines.join("\n"))
        }
    };
    format!(
        "  <testsuite name=\"{name}\" {counts}>\n    <properties>\n{facts}{inputs}    </properties>\n{cases}{notes}  </testsuite>\n"
    )
}

fn of_case(case: &Case, suite: &str) -> String {
    let Case { group, name, .. } = case;
    let place = case.place.as_ref().map_or_else(String::new, place);
    let head = format!("    <testcase classname=\"{suite}.{group}\" name=\"{}\"{place}", attribute(name));
    let (element, message, details) = match &case.result {
        CaseResult::Passed => return format!("{head}/>\n"),
        CaseResult::Skipped(why) => ("skipped", why, ""),
        CaseResult::Error(reason) => ("error", reason, ""),
        CaseResult::Failed { message, details } => ("failure", message, details.as_str()),
    };
    let message = attribute(message);
    let lines: Vec<_> = details.lines().map(text).collect();
    let end = if details.is_empty() { "/>".to_owned() } else { format!(">{}</{element}>", lines.join("\n")) };
    format!("{head}>\n      <{element} message=\"{message}\"{end}\n    </testcase>\n")
}

/// The attributes for the place of a case in a file on disk.
fn place(place: &FilePlace) -> String {
    let file = place.path().map(|path| format!(" file=\"{}\"", attribute(&path.display().to_string())));
    let line = place.region.as_ref().map(|region| format!(" line=\"{}\"", region.start_line));
    file.map_or_else(String::new, |file| file + &line.unwrap_or_default())
}
