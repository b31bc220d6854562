//! The matrix as results for CI systems.

use std::path::Path;
use std::sync::Arc;

use diagnostics::counted;
use monitors::Outcome;
use reports::results::{Case, CaseResult, Suite, WrittenPlaces};
use scenarios::scenario::Scenario;
use scenarios::scenario::find::on_disk;

use super::{AboutFault, Alarm, FaultFree, Matrix, Row};

impl Matrix {
    /// A suite per scenario: whether its run was as expected, and what the verdicts mean for its fault. The last one
    /// is about the runs without a fault. The `page` shows the matrix; `places` finds where a scenario's parts are
    /// written.
    #[must_use]
    pub fn suites(
        &self,
        page: Option<&Path>,
        scenarios: &[Arc<Scenario>],
        fault_free: &Scenario,
        places: impl Fn(&Scenario) -> WrittenPlaces,
    ) -> Vec<Suite> {
        let shown = |scenario: &Scenario, suite: Suite| {
            Suite { page: page.map(Path::to_owned), ..suite }.with_paths(on_disk(&[&scenario.origin.argument]))
        };
        let of = |(row, scenario)| shown(scenario, self.suite_of_row(row, scenario, &places(scenario)));
        let rows = self.rows.iter().zip(scenarios.iter().map(Arc::as_ref)).map(of);
        rows.chain([shown(fault_free, self.suite_without_fault(fault_free, &places(fault_free)))]).collect()
    }

    /// The run of a scenario with faults.
    fn suite_of_row(&self, row: &Row, scenario: &Scenario, places: &WrittenPlaces) -> Suite {
        let expected = scenario.expected();
        let verdict = |(property, words, about): (&str, String, AboutFault)| {
            let monitor = row.monitors.iter().find(|monitor| monitor.name == property)?;
            let case = Case::of_property(monitor, &expected, places);
            let result = match about {
                AboutFault::FalseAlarm => CaseResult::failed(format!("{property} is {words}"), monitor),
                _ if case.result.is_bad() => case.result,
                AboutFault::Something => CaseResult::Passed,
                AboutFault::Nothing => CaseResult::Skipped("it shows nothing about the fault".to_owned()),
            };
            Some(Case { result, found: words, ..case })
        };
        let result = match (row.as_expected, &row.fault) {
            (false, _) => CaseResult::Failed { message: row.differences.join("; "), details: String::new() },
            (true, Some(_)) => CaseResult::Passed,
            (true, None) => CaseResult::Skipped("no fault took effect".to_owned()),
        };
        let run = Case {
            group: "runs",
            name: "as expected".to_owned(),
            result,
            found: row.fault.clone().unwrap_or_else(|| "no fault took effect".to_owned()),
            is_repeated: !row.differs_otherwise,
            ..Case::default()
        };
        Suite {
            name: row.scenario.clone(),
            provenance: Some(row.provenance.clone()),
            facts: vec![("seed", row.seed.to_string())],
            cases: std::iter::once(run).chain(self.verdicts(row).filter_map(verdict)).collect(),
            file: places.file.clone(),
            ..Suite::default()
        }
    }

    /// The runs without a fault: whether there was a false alarm, and the first run in which each property gave one.
    fn suite_without_fault(&self, scenario: &Scenario, places: &WrittenPlaces) -> Suite {
        let FaultFree { scenario: name, provenance, runs, alarms, .. } = &self.fault_free;
        let expected = scenario.expected();
        let false_alarm = |property: &String| {
            let of = |alarm: &Alarm| {
                let monitor = alarm.monitors.iter().find(|monitor| monitor.name == *property)?;
                let case = Case::of_property(monitor, &expected, places);
                let message = format!("{property} is {} without a fault, with seed {}", monitor.verdict, alarm.seed);
                let is_alarm = monitor.verdict == Outcome::Violated || case.result.is_bad();
                is_alarm.then(|| Case { result: CaseResult::failed(message, monitor), ..case })
            };
            alarms.iter().find_map(of)
        };
        let details: Vec<String> =
            alarms.iter().map(|alarm| format!("seed {}: {}", alarm.seed, alarm.what.join("; "))).collect();
        let result = match alarms.len() {
            0 => CaseResult::Passed,
            count => {
                let message =
                    format!("in {count} of {}, something was violated or not as expected", counted(runs, "run"));
                CaseResult::Failed { message, details: details.join("\n") }
            }
        };
        let all = Case {
            group: "runs",
            name: format!("no false alarm in {} without a fault", counted(runs, "run")),
            result,
            is_repeated: !alarms.iter().any(|alarm| alarm.differs_otherwise),
            ..Case::default()
        };
        Suite {
            name: name.clone(),
            provenance: Some(provenance.clone()),
            notes: self.unnoticed().map(|row| format!("no property detects the fault of {}", row.scenario)).collect(),
            cases: std::iter::once(all).chain(self.properties.iter().filter_map(false_alarm)).collect(),
            file: places.file.clone(),
            ..Suite::default()
        }
    }
}
