//! The requirements and their results.

use drawing::Verdict;
use maud::{Markup, html};
use monitors::Outcome;
use recording::{MonitorEnd, RunView};

use super::evidence::Evidence;
use super::markup::{self, pill, text, verdict_sign};
use super::words;
use crate::report::{ExpectationReport, OutcomeReport, Report, ViolationReport, ViolationsReport};
use crate::timeline::Timeline;

/// So many violations of a property are listed: more than a reader compares.
const SHOWN: usize = 20;

/// The section with the verdicts: outcome, properties, expectations.
pub(super) fn section(view: &RunView, timeline: &Timeline, report: &Report) -> Markup {
    let evidence: Vec<Evidence<'_>> = timeline.episodes().iter().map(|episode| Evidence::of(episode, view)).collect();
    let of = |index: usize| evidence.iter().find(|evidence| evidence.episode.property == index);
    // If there is more than one row of cards, violated properties come first.
    let mut order: Vec<usize> = (0..report.monitors.len()).collect();
    if order.len() > 3 {
        order.sort_by_key(|index| report.monitors[*index].verdict != Outcome::Violated);
    }
    let content = html! {
        // A recording has no expectations.
        @if view.header().origin.recorded.is_none() { (outcome(report)) }
        @if report.monitors.is_empty() {
            p.quiet { "No property was watched in this run." }
        } @else {
            div.cards { @for index in order { (card(view, report, index, of(index))) } }
            p.quiet {
                @if view.header().tree.is_empty() { "A tick is a unit of time: there is one every " }
                @else { "A tick is a moment at which the behavior tree is asked what to do, one every " }
                (words::time(view.header().tick)) ". A message such as " code { "[<ok>, 20]" }
                " is written with its fields in order, names between angle brackets; a state is one such message or tick."
            }
        }
    };
    markup::section("verdicts", "Verdicts", content)
}

/// Whether the run was as expected, and what was expected.
fn outcome(report: &Report) -> Markup {
    let (class, verdict, words) = match report.outcome {
        OutcomeReport::AsExpected => ("good", Verdict::Satisfied, "The run was as the scenario expects."),
        OutcomeReport::NotAsExpected => ("bad", Verdict::Violated, "The run was not as the scenario expects."),
        OutcomeReport::Interrupted => {
            ("", Verdict::Inconclusive, "The run was interrupted: this is the report of what happened until then.")
        }
    };
    // An expectation that was not met is replaced by the difference, which repeats it.
    let line = |expectation: &ExpectationReport| {
        let (verdict, words) = match &expectation.difference {
            None => (Verdict::Satisfied, format!("expected {}", expectation.expected)),
            Some(difference) => (Verdict::Violated, difference.clone()),
        };
        html! { li { (verdict_sign(verdict, 16.0)) span { (text(&words)) } } }
    };
    html! {
        div.outcome.(class) {
            (verdict_sign(verdict, 22.0))
            div {
                strong { (words) }
                @if !report.expectations.is_empty() {
                    ul { @for expectation in &report.expectations { (line(expectation)) } }
                }
            }
        }
    }
}

fn card(view: &RunView, report: &Report, index: usize, evidence: Option<&Evidence<'_>>) -> Markup {
    let (monitor, result) = (view.monitor(index), &report.monitors[index]);
    html! {
        article.card.(result.verdict) {
            header {
                (pill(result.verdict))
                h3 { (monitor.name()) }
                @match view.header().expected.of(monitor.name()) {
                    None => {}
                    Some(outcome) if outcome == result.verdict => span.note { "as expected" }
                    Some(outcome) => span.note.bad { "expected to be " (outcome) }
                }
            }
            dl {
                dt { "Required" }
                dd { (text(&words::sentence(&monitor.about.summary))) }
                dt { "What happened" }
                dd {
                    @match evidence {
                        Some(evidence) => {
                            (super::violations::in_short(evidence, view))
                            @if let Some(all) = &result.violations { (every_violation(all)) }
                        }
                        // What messages never reported cannot violate a property, however bad the truth was.
                        None => {
                            (not_violated(&monitor.ending(), view, result.verdict))
                            @if let Some(unheard) = &result.unheard { " But " (text(unheard)) "." }
                        }
                    }
                }
            }
            details {
                summary { "The property as written" }
                pre { code { (monitor.about.property) } }
            }
        }
    }
}

/// How often and how long a property was violated, if that is more than the first violation.
fn every_violation(all: &ViolationsReport) -> Markup {
    let Some(words) = &all.words else { return html! {} };
    let span = |violation: &ViolationReport| match violation.until_s {
        Some(until_s) => format!("{:.2} s to {until_s:.2} s", violation.from_s),
        None => format!("{:.2} s to the end", violation.from_s),
    };
    html! {
        " It was " (words) "."
        @if all.count > 1 {
            details {
                summary { "When" }
                ol { @for violation in all.first.iter().take(SHOWN) { li { (span(violation)) } } }
                @if all.count > SHOWN as u64 { "The others are in " code { "report.json" } "." }
            }
        }
    }
}

/// The result of a property that was not violated.
fn not_violated(end: &MonitorEnd, view: &RunView, verdict: Outcome) -> Markup {
    html! {
        @match verdict {
            _ if end.unsure.is_some() => "It is unsure: something is missing that could change the verdict.",
            Outcome::Inconclusive => "The run ended while something was still pending.",
            _ if view.ticks() + view.communications() == 0 => "There were no events, so nothing could violate it.",
            _ => { "It held throughout the run, over " (words::count(view.ticks(), "tick")) "." }
        }
        @if let Some(missing) = &end.unsure { " " (text(&format!("{missing}."))) }
        @for owed in &end.open {
            " Pending"
            @if let Some(since) = owed.since { " since tick " (since.tick) }
            @if let Some(tick) = owed.until_tick { ", due by tick " (tick) }
            ": " code { (owed.what) } "."
        }
        @for error in &end.errors { " Its machine had an error: " (text(error)) "." }
        // A property that only restricts what follows a condition holds, trivially, of a run without the condition.
        @for clause in &end.vacuous {
            " It is vacuously satisfied: its condition " code { (clause.antecedent) } " never occurred"
            @match clause.asked {
                0 => "; no state was checked for it.",
                1 => " in the one state that was checked for it.",
                states => { " in the " (states) " states that were checked for it." }
            }
        }
    }
}
