//! The requirements and their results.

use diagnostics::counted;
use drawing::Verdict;
use maud::{Markup, html};
use monitors::{EventTime, Outcome};
use recording::{Certainty, MonitorView, RunView, ShownVerdict};

use super::evidence::Evidence;
use super::markup::{self, pill, text, verdict_sign};
use super::words;
use crate::report::{MonitorReport, OutcomeReport, Report, ViolationReport, ViolationsReport};
use crate::timeline::Timeline;

/// So many violations of a property are listed: more than a reader compares.
const SHOWN: usize = 20;

/// Whether the run was as expected: first what was not.
pub(super) fn outcome(report: &Report) -> Markup {
    let (class, verdict) = match report.outcome {
        OutcomeReport::AsExpected => ("", None),
        OutcomeReport::NotAsExpected => ("bad", Some(Verdict::Violated)),
        OutcomeReport::Interrupted => ("", Some(Verdict::Inconclusive)),
    };
    let met = report.expectations.iter().filter(|expectation| expectation.difference.is_none());
    let met = expected_verdicts(report).into_iter().chain(met.filter_map(|expectation| expectation.met.clone()));
    let mut met: Vec<String> = met.collect();
    join(&mut met, "the robot came to rest at ");
    html! {
        div.outcome.(class) {
            @if let Some(verdict) = verdict { (verdict_sign(verdict, 22.0)) }
            div {
                @match report.outcome {
                    OutcomeReport::AsExpected if met.is_empty() => "The scenario expects nothing of the run.",
                    OutcomeReport::AsExpected => { strong { "As expected: " } (text(&met.join("; "))) "." },
                    OutcomeReport::Interrupted => {
                        strong { "The run was interrupted: " } "this is the report of what happened until then."
                    }
                    OutcomeReport::NotAsExpected => {
                        strong { "Not as expected:" }
                        ul { @for difference in &report.differences { li { (text(difference)) } } }
                        @if !met.is_empty() { "As expected: " (text(&met.join("; "))) "." }
                    }
                }
            }
        }
    }
}

/// Joins what begins with the same words: `the robot came to rest at Desk, Entrance`.
fn join(sentences: &mut Vec<String>, beginning: &str) {
    let ends: Vec<String> = sentences.iter().filter_map(|one| Some(one.strip_prefix(beginning)?.to_owned())).collect();
    let Some(first) = sentences.iter().position(|one| one.starts_with(beginning)) else { return };
    sentences.retain(|one| !one.starts_with(beginning));
    sentences.insert(first, format!("{beginning}{}", ends.join(", ")));
}

/// The properties that are as expected, in words: those that are satisfied together, the others by their names.
fn expected_verdicts(report: &Report) -> Vec<String> {
    let of = |outcome: Outcome| {
        let expected = move |monitor: &&MonitorReport| {
            monitor.found() == ShownVerdict::Of(outcome) && monitor.expected == Some(outcome)
        };
        let names: Vec<&str> = report.monitors.iter().filter(expected).map(|monitor| monitor.name.as_str()).collect();
        match names.len() {
            0 => None,
            4.. if outcome == Outcome::Satisfied => Some(format!("{} properties satisfied", names.len())),
            _ => Some(format!("{} {outcome}", names.join(", "))),
        }
    };
    [Outcome::Violated, Outcome::Inconclusive, Outcome::Satisfied].into_iter().filter_map(of).collect()
}

/// The section with the verdicts: a line for each property, which opens to what happened.
pub(super) fn section(view: &RunView, timeline: &Timeline, report: &Report) -> Markup {
    let evidence: Vec<Evidence<'_>> = timeline.episodes().iter().map(|episode| Evidence::of(episode, view)).collect();
    let of = |index: usize| evidence.iter().find(|evidence| evidence.episode.property == index);
    // What went wrong, then what is open.
    let mut order: Vec<usize> = (0..report.monitors.len()).collect();
    order.sort_by_key(|index| match &report.monitors[*index] {
        monitor if monitor.verdict == Outcome::Violated => 0,
        monitor if monitor.verdict == Outcome::Inconclusive || monitor.unsure.is_some() => 1,
        _ => 2,
    });
    let content = html! {
        @if report.monitors.is_empty() {
            p.quiet { "No property was watched in this run." }
        } @else {
            div.panel.lines { @for index in order { (line(view, report, index, of(index))) } }
            @if view.header().knows_ticks() { p.quiet {
                @if view.header().tree.is_empty() { "A tick is a unit of time: there is one every " }
                @else { "A tick is a moment at which the behavior tree is asked what to do, one every " }
                (words::time(view.header().tick)) ". A message such as " code { "[<ok>, 20]" }
                " is written with its fields in order, names between angle brackets; a state is one such message or tick."
            } }
        }
    };
    markup::section("verdicts", "Verdicts", content)
}

fn line(view: &RunView, report: &Report, index: usize, evidence: Option<&Evidence<'_>>) -> Markup {
    let (monitor, result) = (view.monitor(index), &report.monitors[index]);
    let how_often = result.violations.as_ref().and_then(|all| all.words.as_deref());
    html! {
        details.line.(result.verdict) {
            summary {
                (pill(result.verdict))
                h3 { (monitor.name()) }
                span.required { (text(&words::sentence(&monitor.about.summary))) }
                @if let Some(words) = how_often { span.note { (words) } }
                @if !result.vacuous.is_empty() { span.note { "its condition never occurred" } }
                @match monitor.ending().evidence.certainty() {
                    Certainty::Sure => {}
                    Certainty::Unless(_) => span.note.bad { "unless a message was lost" }
                    Certainty::Unsure(_) => span.note.bad { "unsure" }
                    Certainty::Groundless(_) => span.note.bad { "no verdict" }
                }
                @if result.unheard.is_some() { span.note.bad { "not told" } }
                @match result.expected {
                    None => {}
                    Some(outcome) if result.found() == ShownVerdict::Of(outcome) => span.note { "as expected" }
                    Some(outcome) => span.note.bad { "expected to be " (outcome) }
                }
            }
            div.what {
                @match evidence {
                    Some(evidence) => {
                        (super::violations::in_short(evidence, view))
                        @if let Some(all) = &result.violations { (every_violation(all)) }
                    }
                    // What messages never reported cannot violate a property, however bad the truth was.
                    None => {
                        (not_violated(&monitor, view, result.verdict))
                        @if let Some(unheard) = &result.unheard { " But " (text(unheard)) "." }
                    }
                }
                (rests_on(&monitor.ending().evidence))
            }
            pre { code { (monitor.about.property) } }
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

/// What a verdict rests on, where that is not what was computed.
fn rests_on(evidence: &recording::Evidence) -> Markup {
    html! {
        @if let Certainty::Unless(why) = evidence.certainty() { " This is so unless " (text(why)) "." }
        @for channel in evidence.silent() { " There was no message " (text(channel)) "." }
        @for assumption in evidence.assumptions() { " It is assumed that " (text(assumption)) "." }
    }
}

/// The result of a property that was not violated.
fn not_violated(monitor: &MonitorView<'_>, view: &RunView, verdict: Outcome) -> Markup {
    let (end, knows_ticks) = (monitor.ending(), view.header().knows_ticks());
    let settled = monitor.decision.filter(|decision| decision.verdict == channels::Verdict::True);
    let certainty = end.evidence.certainty();
    html! {
        @match verdict {
            _ if matches!(certainty, Certainty::Unsure(_)) => {
                "It is unsure: something is missing that could change the verdict."
            }
            _ if matches!(certainty, Certainty::Groundless(_)) => "There is no verdict: nothing could be judged.",
            Outcome::Inconclusive => "The run ended while something was still pending.",
            _ if view.ticks() + view.communications() == 0 => "There were no events, so nothing could violate it.",
            _ if settled.is_some_and(|settled| settled.event.step > 0) => {
                @if let Some(event) = settled.map(|settled| &settled.event) {
                    "It was satisfied for good at " (words::tick_and_time(knows_ticks, &EventTime::of(event))) "."
                }
            }
            _ if knows_ticks => { "It held throughout the run, over " (counted(view.ticks(), "tick")) "." }
            _ => "It held throughout the run.",
        }
        @if let Certainty::Unsure(why) | Certainty::Groundless(why) = certainty { " " (text(&format!("{why}."))) }
        @for owed in &end.open {
            " Pending"
            @if let Some(since) = &owed.since { " since " (words::tick(knows_ticks, since)) }
            @if let Some(tick) = owed.until_tick.filter(|_| knows_ticks) { ", due by tick " (tick) }
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
