//! What was required, and what came of it.

use super::evidence::Evidence;
use super::markup::{code, escape, pill, text, verdict_sign};
use super::words;
use crate::draw::Verdict;
use crate::live::Live;
use crate::report::{ExpectationReport, OutcomeReport, Report};
use crate::timeline::Timeline;

/// The section of the verdicts: outcome, properties, expectations.
pub(super) fn section(live: &Live, timeline: &Timeline, report: &Report) -> String {
    let evidence: Vec<Evidence<'_>> = timeline.episodes().iter().map(|episode| Evidence::of(episode, live)).collect();
    let cards: String = (0..live.watched().len())
        .map(|index| card(live, report, index, evidence.iter().find(|evidence| evidence.episode.property == index)))
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

fn card(live: &Live, report: &Report, index: usize, evidence: Option<&Evidence<'_>>) -> String {
    let (watched, said) = (&live.watched()[index], &report.monitors[index]);
    let expected = live.scenario().file.expect.outcomes.iter().find(|(name, _)| name.value == watched.name);
    let note = match expected {
        None => String::new(),
        Some((_, outcome)) if outcome.name() == said.verdict => "<span class=\"note\">as expected</span>".to_owned(),
        Some((_, outcome)) => format!("<span class=\"note bad\">expected to be {outcome}</span>"),
    };
    let happened = match evidence {
        Some(evidence) => super::violations::in_short(evidence, live),
        None => not_violated(live, index, said.verdict),
    };
    format!(
        "<article class=\"card {0}\">\n<header>{1}<h3>{2}</h3>{note}</header>\n\
         <dl><dt>Required</dt><dd>{3}</dd><dt>What happened</dt><dd>{happened}</dd></dl>\n\
         <details><summary>The property as it is written</summary><pre><code>{4}</code></pre></details>\n</article>\n",
        said.verdict,
        pill(said.verdict),
        escape(&watched.name),
        text(&words::sentence(&watched.summary)),
        escape(&watched.formula),
    )
}

/// What happened to a property that was not violated.
fn not_violated(live: &Live, index: usize, verdict: &str) -> String {
    let attached = &live.system().monitors()[index];
    let monitor = monitors::scope_monitor(attached.monitor.as_ref());
    let open = monitor.map(monitors::ScopeMonitor::open_obligations).unwrap_or_default();
    let vacuous = monitor.map(monitors::ScopeMonitor::vacuous).unwrap_or_default();
    let ticks = words::count(live.system().ticks(), "tick");
    let mut happened = match verdict {
        "inconclusive" => "The run ended while something was still owed.".to_owned(),
        _ => format!("It held throughout the run, over {ticks}."),
    };
    for owed in &open {
        let since = owed.since.map_or(String::new(), |since| format!(" since tick {}", since.tick));
        let until = owed.until_tick.map_or(String::new(), |tick| format!(", to be met by tick {tick}"));
        happened += &format!(" Owed{since}{until}: {}.", code(&owed.what));
    }
    for clause in &vacuous {
        happened += &format!(
            " It was never put to the test: at none of {1} did {0} hold.",
            code(&clause.antecedent),
            words::count(clause.asked, "state"),
        );
    }
    happened
}
