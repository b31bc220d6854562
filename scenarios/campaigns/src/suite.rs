//! The results of a campaign as test cases.

use std::path::Path;

use diagnostics::counted;
use reports::results::{Case, CaseResult, FileFinding, FindingKind, Suite, WrittenPlaces};

use super::summary::{Estimate, Outcomes, Summary};

impl Summary {
    /// The results as test cases: that runs finished as expected, and for each property whether it was violated in any.
    /// A campaign counts violations, so a property that was violated is skipped. `folder` has the page.
    #[must_use]
    pub fn suite(&self, folder: &Path, places: &WrittenPlaces) -> Suite {
        let Summary { runs, outcomes, .. } = self;
        let mut words = format!(
            "{} as expected, {} not, {} failed",
            outcomes.as_expected, outcomes.not_as_expected, outcomes.failed
        );
        if let Some(named) = self.failures.first() {
            words += &format!("; run {}: {}", named.k, named.why.as_deref().unwrap_or_default());
        }
        if !self.expects {
            words += "; nothing was expected of them";
        }
        words.extend(self.often_unmet().iter().map(|unmet| format!("; not met {unmet}")));
        let result = match outcomes {
            Outcomes { failed, .. } if failed == runs => CaseResult::Error(words.clone()),
            Outcomes { failed: 0, not_as_expected: 0, .. } if self.expects => CaseResult::Passed,
            _ => CaseResult::Skipped(words.clone()),
        };
        let name = format!("{} of {}", counted(runs, "run"), self.scenario);
        let of_runs = Case { group: "campaign", name, result, found: words, ..Case::default() };
        let of_property = |estimate: &Estimate| {
            let found = [Some(estimate.in_words(self.of_roaml)), estimate.open_in_words()];
            let found = found.into_iter().flatten().collect::<Vec<_>>().join("; ");
            let result = if estimate.count.runs() == 0 {
                CaseResult::Skipped("no run has finished".to_owned())
            } else if estimate.is_fine() {
                CaseResult::Passed
            } else if estimate.count.happened() == 0 && estimate.inconclusive == Some(0) {
                CaseResult::Skipped("a condition in it never occurred".to_owned())
            } else {
                CaseResult::Skipped("a campaign only counts it".to_owned())
            };
            let place = places.properties.get(&estimate.of).cloned();
            Case { group: "campaign", name: estimate.of.clone(), result, found, place, ..Case::default() }
        };
        let of_goal = self.goal.as_ref().map(|goal| {
            let found = goal.to_string();
            let result = if goal.reached { CaseResult::Passed } else { CaseResult::Skipped(found.clone()) };
            Case { group: "campaign", name: "goal".to_owned(), result, found, ..Case::default() }
        });
        let violated = self.properties.iter().filter(|estimate| estimate.count.happened() > 0);
        let finding = |estimate: &Estimate| FileFinding {
            kind: FindingKind::Rate,
            message: format!("{}: {}", estimate.of, estimate.in_words(self.of_roaml)),
            help: None,
            place: places.properties.get(&estimate.of).cloned(),
        };
        Suite {
            name: self.campaign.clone(),
            provenance: Some(self.provenance.clone()),
            facts: vec![("runs", runs.to_string())],
            cases: std::iter::once(of_runs).chain(self.properties.iter().map(of_property)).chain(of_goal).collect(),
            findings: violated.map(finding).collect(),
            file: places.file.clone(),
            page: Some(folder.join("report.html")),
            ..Suite::default()
        }
    }
}
