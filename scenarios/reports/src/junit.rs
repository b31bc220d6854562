//! The results of runs as JUnit XML, for continuous integration.
//!
//! Each run is a suite with one test case per property and expectation. A property with an expectation passes if it is
//! met; any other property fails if it is violated (in a RoAML model, it is skipped), and is skipped if it is
//! inconclusive. No case fails if and only if the run was as expected. There are no times: the same run gives the same
//! bytes.

use std::fmt;
use std::path::Path;

use diagnostics::markup::{attribute, text};
use monitors::Outcome;
use recording::Expected;

use crate::Error;
use crate::report::{ExpectationReport, MonitorReport, Report};

/// Writes test cases to a file. Creates missing folders.
///
/// # Errors
/// [`Error::File`] if that is not possible.
pub fn write(path: &Path, suites: &[Suite]) -> Result<(), Error> {
    Ok(diagnostics::write_whole(path, document(suites))?)
}

/// Test cases as JUnit XML.
#[must_use]
pub fn document(suites: &[Suite]) -> String {
    let counts = Counts::of(suites.iter().flat_map(|suite| &suite.cases));
    let suites: String = suites.iter().map(Suite::element).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"steward\" {counts}>\n{suites}</testsuites>\n"
    )
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

/// Test cases that belong together: those of a run, or of the proofs of a scenario.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Its name, escaped for XML.
    name: String,
    facts: Vec<(&'static str, String)>,
    cases: Vec<Case>,
}

impl Suite {
    /// The test cases of a scenario, with facts about them.
    #[must_use]
    pub fn new(scenario: &str, facts: Vec<(&'static str, String)>, cases: Vec<Case>) -> Self {
        Self { name: attribute(scenario), facts, cases }
    }

    /// A scenario whose run could not be carried out, with the reason.
    #[must_use]
    pub fn of_error(scenario: &str, reason: String) -> Self {
        let case = Case { group: "runs", name: scenario.to_owned(), result: CaseResult::Error(reason) };
        Self::new(scenario, Vec::new(), vec![case])
    }

    /// The properties and expectations of a run.
    #[must_use]
    pub fn of_run(expected: &Expected, report: &Report) -> Self {
        let properties = report.monitors.iter().map(|monitor| of_property(monitor, expected));
        Self {
            name: attribute(&report.scenario),
            facts: vec![
                ("seed", report.seed.to_string()),
                ("version", report.version.clone()),
                ("sim_time_s", report.sim_time_s.to_string()),
                ("ticks", report.ticks.to_string()),
                ("trace_hash", report.trace_hash.clone()),
            ],
            cases: properties.chain(report.expectations.iter().map(of_expectation)).collect(),
        }
    }

    fn element(&self) -> String {
        let Self { name, facts, cases } = self;
        let counts = Counts::of(cases);
        let fact = |(name, value): &(&str, String)| {
            format!("      <property name=\"{name}\" value=\"{}\"/>\n", attribute(value))
        };
        let facts: String = facts.iter().map(fact).collect();
        let cases: String = cases.iter().map(|case| case.element(name)).collect();
        format!(
            "  <testsuite name=\"{name}\" {counts}>\n    <properties>\n{facts}    </properties>\n{cases}  </testsuite>\n"
        )
    }
}

/// A test case.
#[derive(Clone, Debug)]
pub struct Case {
    /// The subject: `properties`, `expectations`, `proofs`.
    pub group: &'static str,
    /// Its name.
    pub name: String,
    /// Its result.
    pub result: CaseResult,
}

/// The result of a test case.
#[derive(Clone, Debug)]
pub enum CaseResult {
    /// What was expected.
    Passed,
    /// Nothing, and why.
    Skipped(String),
    /// There is none, because of an error.
    Error(String),
    /// Something else.
    Failed {
        /// What went wrong, in one line.
        message: String,
        /// Details, line by line; may be empty.
        details: String,
    },
}

impl Case {
    fn element(&self, suite: &str) -> String {
        let head = format!("    <testcase classname=\"{suite}.{}\" name=\"{}\"", self.group, attribute(&self.name));
        match &self.result {
            CaseResult::Passed => format!("{head}/>\n"),
            CaseResult::Skipped(why) => {
                format!("{head}>\n      <skipped message=\"{}\"/>\n    </testcase>\n", attribute(why))
            }
            CaseResult::Error(reason) => {
                format!("{head}>\n      <error message=\"{}\"/>\n    </testcase>\n", attribute(reason))
            }
            CaseResult::Failed { message, details } if details.is_empty() => {
                format!("{head}>\n      <failure message=\"{}\"/>\n    </testcase>\n", attribute(message))
            }
            CaseResult::Failed { message, details } => format!(
                "{head}>\n      <failure message=\"{}\">{}</failure>\n    </testcase>\n",
                attribute(message),
                details.lines().map(text).collect::<Vec<_>>().join("\n")
            ),
        }
    }
}

fn of_property(monitor: &MonitorReport, expected: &Expected) -> Case {
    let failed = |message: String| CaseResult::Failed { message, details: details(monitor) };
    let result = match (expected.of(&monitor.name), monitor.verdict) {
        (Some(expected), found) if expected == found => CaseResult::Passed,
        (Some(expected), found) => failed(format!("{} was expected to be {expected} and is {found}", monitor.name)),
        (None, Outcome::Violated) if expected.others_may_be_violated => {
            CaseResult::Skipped("it is violated, and nothing is expected of it".to_owned())
        }
        (None, Outcome::Violated) => failed(format!("{} is violated", monitor.name)),
        (None, Outcome::Inconclusive) => {
            CaseResult::Skipped("something was still pending when the run ended".to_owned())
        }
        (None, Outcome::Satisfied) => CaseResult::Passed,
    };
    Case { group: "properties", name: monitor.name.clone(), result }
}

fn of_expectation(expectation: &ExpectationReport) -> Case {
    let failed = |message: &String| CaseResult::Failed { message: message.clone(), details: String::new() };
    let result = expectation.difference.as_ref().map_or(CaseResult::Passed, failed);
    Case { group: "expectations", name: expectation.expected.clone(), result }
}

/// When and why it happened, for readers of a build log.
fn details(monitor: &MonitorReport) -> String {
    let mut details = format!("{}\nmonitor in state {}", monitor.property, monitor.state);
    details.extend(monitor.moment().map(|moment| format!("\nat {moment}")));
    details.extend(monitor.witness.as_ref().map(|witness| format!("\n{}", witness.in_words().trim_end())));
    details
}
