//! What was required, and what came of it.

use drawing::Verdict;
use monitors::Outcome;
use recording::{MonitorEnd, RunView};

use super::evidence::Evidence;
use super::markup::{code, escape, pill, text, verdict_sign};
use super::words;
use crate::report::{ExpectationReport, OutcomeReport, Report};
use crate::timeline::Timeline;

/// The section of the verdicts: outcome, properties, expectations.
pub(super) fn section(view: &RunView, timeline: &Timeline, report: &Report) -> String {
    let evidence: Vec<Evidence<'_>> = timeline.episodes().iter().map(|episode| Evidence::of(episode, view)).collect();
    let cards: String = (0..view.monitors().len())
        .map(|index| card(view, report, index, evidence.iter().find(|evidence| evidence.episode.property == index)))
        .collect();
    let cards = match cards.is_empty() {
        true => "<p class=\"quiet\">No property was watched in this run.</p>\n".to_owned(),
        false => format!("<div class=\"cards\">\n{cards}</div>\n"),
    };
    format!("<section id=\"verdicts\">\n<h2>Verdicts</h2>\n{}{cards}</section>\n", outcome(report))
}

/// Whether the run was what it was to be, and what that was.
fn outcome(report: &Report) -> String {
    let (class, verdict, words) = match report.outcome {
        OutcomeReport::AsExpected => ("good", Verdict::Satisfied, "The run was what the scenario expects."),
        OutcomeReport::NotAsExpected => ("bad", Verdict::Violated, "The run was not what the scenario expects."),
    };
    let line = |expectation: &ExpectationReport| {
        let (verdict, words) = match &expectation.difference {
            None => (Verdict::Satisfied, &expectation.expected),
            Some(difference) => (Verdict::Violated, difference),
        };
        format!("<li>{}<span>{}</span></li>\n", verdict_sign(verdict, 16.0), text(words))
    };
    let lines: String = report.expectations.iter().map(line).collect();
    let lines = if lines.is_empty() { lines } else { format!("<ul>\n{lines}</ul>") };
    format!(
        "<div class=\"outcome {class}\">{}<div><strong>{words}</strong>{lines}</div></div>\n",
        verdict_sign(verdict, 22.0)
    )
}

fn card(view: &RunView, report: &Report, index: usize, evidence: Option<&Evidence<'_>>) -> String {
    let (monitor, said) = (view.monitor(index), &report.monitors[index]);
    let note = match view.header().expected.of(monitor.name()) {
        None => String::new(),
        Some(outcome) if outcome == said.verdict => "<span class=\"note\">as expected</span>".to_owned(),
        Some(outcome) => format!("<span class=\"note bad\">expected to be {outcome}</span>"),
    };
    let happened = match evidence {
        Some(evidence) => super::violations::in_short(evidence, view),
        None => not_violated(&monitor.ending(), view.ticks(), said.verdict),
    };
    format!(
        "<article class=\"card {0}\">\n<header>{1}<h3>{2}</h3>{note}</header>\n\
         <dl><dt>Required</dt><dd>{3}</dd><dt>What happened</dt><dd>{happened}</dd></dl>\n\
         <details><summary>The property as it is written</summary><pre><code>{4}</code></pre></details>\n</article>\n",
        said.verdict,
        pill(said.verdict),
        escape(monitor.name()),
        text(&words::sentence(&monitor.about.summary)),
        escape(&monitor.about.property),
    )
}

/// What happened to a property that was not violated in so many ticks.
fn not_violated(said: &MonitorEnd, ticks: u64, verdict: Outcome) -> String {
    let mut happened = match verdict {
        Outcome::Inconclusive => "The run ended while something was still owed.".to_owned(),
        _ => format!("It held throughout the run, over {}.", words::count(ticks, "tick")),
    };
    for owed in &said.open {
        let since = owed.since.map_or(String::new(), |since| format!(" since tick {}", since.tick));
        let until = owed.until_tick.map_or(String::new(), |tick| format!(", to be met by tick {tick}"));
        happened += &format!(" Owed{since}{until}: {}.", code(&owed.what));
    }
    for error in &said.errors {
        happened += &format!(" Its machine went wrong: {}.", text(error));
    }
    for clause in &said.vacuous {
        happened += &format!(
            " It was never put to the test: at none of {1} did {0} hold.",
            code(&clause.antecedent),
            words::count(clause.asked, "state"),
        );
    }
    happened
}
