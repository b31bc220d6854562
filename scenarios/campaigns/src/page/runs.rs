//! The sections that name single runs.

use monitors::Outcome;
use reports::html::{escape, text};

use super::super::{Named, RunOutcome, RunRecord};
use super::instructive::pattern_words;
use super::plot::written;
use super::survey::{FEW_RUNS, Instructive, Survey};
use super::target::Target;
use super::{Page, percent, section};

/// So many combinations of violations are listed.
const LISTED: usize = 24;

impl Page<'_> {
    /// Which violations occur together.
    pub(super) fn patterns(&self) -> String {
        let Survey { patterns, runs, .. } = self.survey;
        if patterns.len() < 2 {
            return String::new();
        }
        let rows: String = patterns
            .iter()
            .take(LISTED)
            .map(|pattern| {
                format!(
                    "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                    text(&pattern_words(self.survey, pattern)),
                    pattern.runs,
                    percent(pattern.runs as f64 / (*runs).max(1) as f64),
                    pattern.first,
                )
            })
            .collect();
        let more = match patterns.len().saturating_sub(LISTED) {
            0 => String::new(),
            more => format!("<p class=\"quiet\">and {more} rarer combinations</p>\n"),
        };
        format!(
            "<div class=\"panel\">\n<h3>What happens together</h3>\n<table class=\"rates\"><thead><tr><th scope=\"col\"></th>\
             <th scope=\"col\">runs</th><th scope=\"col\">rate</th><th scope=\"col\">first run</th></tr></thead><tbody>\n{rows}</tbody></table>\n{more}</div>\n"
        )
    }

    /// The runs that are worth a look.
    pub(super) fn instructive(&self) -> String {
        let runs: String = self.survey.instructive.iter().map(|run| self.card(run)).collect();
        if runs.is_empty() {
            return String::new();
        }
        let lead = "<p>Each command repeats its run alone, step by step, with pictures and report.</p>\n";
        section("instructive", "Runs worth a look", &format!("{lead}<div class=\"cards\">\n{runs}</div>\n"))
    }

    fn card(&self, run: &Instructive) -> String {
        let well = run.record.outcome == RunOutcome::AsExpected;
        let class = if well { "satisfied" } else { "violated" };
        let why: String = run.why.iter().map(|why| format!("<p>{}</p>\n", text(why))).collect();
        format!(
            "<article class=\"card {class}\">\n<header><h3>Run {}</h3></header>\n{why}<p class=\"note\">{}</p>\n<p class=\"note\">{}</p>\n<pre>{}</pre>\n</article>\n",
            run.record.k,
            self.values(&run.record),
            text(&self.verdicts(&run.record)),
            escape(&self.summary.command(run.record.k)),
        )
    }

    /// A run's parameters.
    fn values(&self, record: &RunRecord) -> String {
        let each = self.layout.parameters.iter().zip(&record.values);
        let values: Vec<String> = each
            .map(|(parameter, value)| {
                let name = parameter.name.as_deref().unwrap_or(&parameter.key);
                format!("{} = {}", escape(name), escape(&written(value)))
            })
            .chain([format!("seed {}", record.seed)])
            .collect();
        values.join(" · ")
    }

    /// What came of a run.
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
        words.push(record.outcome.name().replace('_', " "));
        words.join(" · ")
    }

    /// The runs that did not come to an end, and the first ones that were not as expected.
    pub(super) fn failures(&self) -> String {
        let list = |title: &str, runs: &[Named]| {
            let items: String = runs
                .iter()
                .map(|run| {
                    let why = run.why.as_deref().map_or(String::new(), |why| format!("<br>{}", text(why)));
                    format!("<li>run {}: <code>{}</code>{why}</li>\n", run.k, escape(&run.command))
                })
                .collect();
            if items.is_empty() {
                items
            } else {
                format!("<div class=\"panel\"><h3>{title}</h3><ul>\n{items}</ul></div>\n")
            }
        };
        let failed = list("The first runs that failed", &self.summary.failures);
        let unexpected = list("The first runs that were not as expected", &self.summary.unexpected);
        section("failures", "What went wrong", &format!("{failed}{unexpected}"))
    }

    /// Every run, if they are few.
    pub(super) fn all_runs(&self) -> String {
        if self.survey.runs > FEW_RUNS {
            return String::new();
        }
        let names = |parts: &mut dyn Iterator<Item = &str>| -> String {
            parts.map(|name| format!("<th scope=\"col\">{}</th>", escape(name))).collect()
        };
        let parameters = &self.layout.parameters;
        let keys = names(&mut parameters.iter().map(|parameter| parameter.name.as_deref().unwrap_or(&parameter.key)));
        let properties = names(&mut self.layout.properties.iter().map(String::as_str));
        let rows: String = self.survey.records.iter().map(|record| self.line(record)).collect();
        let table = format!(
            "<div class=\"panel\">\n<table class=\"matrix\"><thead><tr><th scope=\"col\">run</th>{keys}{properties}\
             <th scope=\"col\">outcome</th></tr></thead><tbody>\n{rows}</tbody></table>\n<p class=\"quiet\">When each property was \
             violated; –: it was not; ?: it was inconclusive at the end.</p>\n</div>\n"
        );
        section("runs", "All runs", &table)
    }

    fn line(&self, record: &RunRecord) -> String {
        let named = self.layout.parameters.iter().zip(&record.values);
        let values: String = named
            .map(|(parameter, value)| {
                let name = escape(parameter.name.as_deref().unwrap_or(&parameter.key));
                format!("<td class=\"value\" data-of=\"{name}\">{}</td>", text(&written(value)))
            })
            .collect();
        let monitors = record.facts.iter().flat_map(|facts| &facts.monitors);
        let verdicts: String = self
            .layout
            .properties
            .iter()
            .zip(monitors)
            .map(|(name, monitor)| {
                let words = match (monitor.verdict, monitor.time_s) {
                    (Outcome::Violated, Some(time_s)) => format!("{time_s:.2} s"),
                    (Outcome::Violated, None) => "violated".to_owned(),
                    (Outcome::Satisfied, _) => "–".to_owned(),
                    (Outcome::Inconclusive, _) => "?".to_owned(),
                };
                format!("<td class=\"{}\" data-of=\"{}\">{words}</td>", monitor.verdict, escape(name))
            })
            .collect();
        let none: String =
            if record.facts.is_none() { "<td>failed</td>".repeat(self.layout.properties.len()) } else { String::new() };
        let outcome = record.outcome.name().replace('_', " ");
        let class = if record.outcome == RunOutcome::AsExpected { "satisfied" } else { "violated" };
        format!(
            "<tr><th scope=\"row\">{}</th>{values}{verdicts}{none}<td class=\"{class}\" data-of=\"outcome\">{outcome}</td></tr>\n",
            record.k
        )
    }
}
