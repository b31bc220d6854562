//! The sections that list individual runs.

use maud::{Markup, html};
use monitors::Outcome;
use reports::html::{command, row, section, table, text};

use super::super::{MonitorFacts, Named, RunOutcome, RunRecord};
use super::instructive::pattern_words;
use super::plot::written;
use super::survey::{FEW_RUNS, Instructive, Pattern, Survey};
use super::target::Target;
use super::{Page, name, percent};

/// How many combinations of violations are listed.
const LISTED: usize = 24;

impl Page<'_> {
    /// Which violations occur together.
    pub(super) fn patterns(&self) -> Markup {
        let Survey { patterns, runs, .. } = self.survey;
        let line = |pattern: &Pattern| {
            let share = percent(pattern.runs as f64 / (*runs).max(1) as f64);
            row(
                text(&pattern_words(self.survey, pattern)),
                [pattern.runs.to_string(), share, pattern.first.to_string()],
            )
        };
        let lines = html! { @for pattern in patterns.iter().take(LISTED) { (line(pattern)) } };
        html! {
            @if patterns.len() >= 2 {
                div.panel {
                    h3 { "What happens together" }
                    (table("rates", ["together", "runs", "rate", "first run"], &lines))
                    @if patterns.len() > LISTED { p.quiet { "and " (patterns.len() - LISTED) " rarer combinations" } }
                }
            }
        }
    }

    /// The runs that are worth a look.
    pub(super) fn instructive(&self) -> Markup {
        let cards = html! {
            @if !self.survey.instructive.is_empty() {
                p { "Each command repeats only its run, step by step, with pictures and report." }
                div.cards { @for run in &self.survey.instructive { (self.card(run)) } }
            }
        };
        section("instructive", "Runs worth a look", cards)
    }

    fn card(&self, run: &Instructive) -> Markup {
        let well = run.record.outcome == RunOutcome::AsExpected;
        html! {
            article.card.(if !self.summary.expects { "" } else if well { "satisfied" } else { "violated" }) {
                header { h3 { "Run " (run.record.k) } }
                @for why in &run.why { p { (text(why)) } }
                p.note { (self.values(&run.record)) }
                p.note { (text(&self.verdicts(&run.record))) }
                pre { (command(&self.summary.command(run.record.k))) }
            }
        }
    }

    /// A run's parameters.
    fn values(&self, record: &RunRecord) -> String {
        let each = self.layout.parameters.iter().zip(&record.values);
        let values: Vec<String> = each
            .map(|(parameter, value)| format!("{} = {}", name(parameter), written(value)))
            .chain([format!("seed {}", record.seed)])
            .collect();
        values.join(" · ")
    }

    /// The result of a run.
    fn verdicts(&self, record: &RunRecord) -> String {
        if let Some(failure) = &record.failure {
            return failure.clone();
        }
        let violated = self
            .survey
            .targets
            .iter()
            .filter_map(|target: &Target| Some(format!("{} at {:.2} s", target.event(), target.time_s(record)?)));
        let mut words: Vec<String> = violated.collect();
        if self.shows_outcome(record) {
            words.push(record.outcome.name().replace('_', " "));
        }
        words.join(" · ")
    }

    /// Where nothing is expected, every run that does not fail is as expected.
    fn shows_outcome(&self, record: &RunRecord) -> bool {
        self.summary.expects || record.outcome != RunOutcome::AsExpected
    }

    /// The first runs that failed, and the first that were not as expected.
    pub(super) fn failures(&self) -> Markup {
        let list = |title: &str, runs: &[Named]| {
            html! {
                @if !runs.is_empty() {
                    div.panel {
                        h3 { (title) }
                        ul {
                            @for run in runs {
                                li {
                                    "run " (run.k) ": " (command(&run.command))
                                    @if let Some(why) = &run.why { br; (text(why)) }
                                }
                            }
                        }
                    }
                }
            }
        };
        let lists = html! {
            (list("The first runs that failed", &self.summary.failures))
            (list("The first runs that were not as expected", &self.summary.unexpected))
        };
        section("failures", "What went wrong", lists)
    }

    /// Every run, if there are few.
    pub(super) fn all_runs(&self) -> Markup {
        let parameters = self.layout.parameters.iter().map(name);
        let properties = self.layout.properties.iter().map(String::as_str);
        let shows_outcomes = self.survey.records.iter().any(|record| self.shows_outcome(record));
        let columns = ["run"].into_iter().chain(parameters).chain(properties);
        let columns = columns.chain(shows_outcomes.then_some("outcome"));
        let lines = html! { @for record in &self.survey.records { (self.line(record, shows_outcomes)) } };
        let content = html! {
            @if self.survey.runs <= FEW_RUNS {
                div.panel {
                    (table("matrix", columns, &lines))
                    p.quiet { "When each property was violated; –: it was not; ?: it was inconclusive at the end." }
                }
            }
        };
        section("runs", "All runs", content)
    }

    fn line(&self, record: &RunRecord, shows_outcome: bool) -> Markup {
        let words = |monitor: &MonitorFacts| match (monitor.verdict, monitor.time_s) {
            (Outcome::Violated, Some(time_s)) => format!("{time_s:.2} s"),
            (Outcome::Violated, None) => "violated".to_owned(),
            (Outcome::Satisfied, _) => "–".to_owned(),
            (Outcome::Inconclusive, _) => "?".to_owned(),
        };
        // A failed run has no facts, so the cells of its properties have no verdict to show.
        let well = record.outcome == RunOutcome::AsExpected;
        html! {
            tr {
                th scope="row" { (record.k) }
                @for (parameter, value) in self.layout.parameters.iter().zip(&record.values) {
                    td.value data-of=(name(parameter)) { (text(&written(value))) }
                }
                @for (place, property) in self.layout.properties.iter().enumerate() {
                    @match record.facts.as_ref().and_then(|facts| facts.monitors.get(place)) {
                        Some(monitor) => td.(monitor.verdict) data-of=(property) { (words(monitor)) }
                        None => td { "failed" }
                    }
                }
                @if shows_outcome {
                    td.(if well { "satisfied" } else { "violated" }) data-of="outcome" {
                        (record.outcome.name().replace('_', " "))
                    }
                }
            }
        }
    }
}
