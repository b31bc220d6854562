//! The table of results.

use proofs::{Assumption, Mistake, Proof, Question, Unreachable};
use scenarios::scenario::ProofOutcome;

use super::finding::{self, Finding, Findings};
use crate::output::{BAD, GOOD, HEAD, OPEN, Text};

/// The widest column of names that leaves room for the others in 80 columns.
const WIDEST: usize = 24;

/// The results, and their assumptions.
pub(super) fn head(proof: &Proof) -> Text {
    let mut text = Text::default();
    text.paint(HEAD, &proof.scenario().name, 0);
    text += "\n";
    for Assumption { words: assumption, .. } in proof.assumptions() {
        text += format!("  {assumption}\n");
    }
    text
}

/// The errors of the tree and of machines, one per line.
pub(super) fn mistakes(findings: &[Finding]) -> Text {
    let mut text = Text::default();
    let mistakes = Findings::mistakes(findings);
    if !mistakes.is_empty() {
        text += "\nsome of the runs contain errors; they are explored like the others:\n";
    }
    for Mistake { place, message } in mistakes {
        text += format!("  {place}: {message}\n");
    }
    text
}

/// Everything that never happens: a list with locations, or how many there are.
pub(super) fn unreached(findings: &[Finding], list: bool) -> Text {
    let mut text = Text::default();
    let Some((finding, unreached)) = findings.iter().find_map(|it| Some((it, it.answer.unreached.as_ref()?))) else {
        return text;
    };
    let count = |kind: Unreachable, one: &str, many: &str| {
        let count = unreached.iter().filter(|it| it.kind == kind).count();
        (count > 0).then(|| format!("{count} {}", if count == 1 { one } else { many }))
    };
    let counts = [
        count(Unreachable::Node, "answer of a node", "answers of nodes"),
        count(Unreachable::State, "state", "states"),
        count(Unreachable::Transition, "transition", "transitions"),
    ];
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    if counts.is_empty() {
        return text;
    }
    let end = if list { ":" } else { " (--unreached lists them)" };
    text += format!("\nnever reached: {}{end}\n", counts.join(", "));
    if list {
        text += finding::unreached(&finding.answer);
    }
    text
}

/// A table of properties.
pub(super) struct FindingsTable {
    width: usize,
}

impl FindingsTable {
    pub(super) fn of(questions: &[Question]) -> Self {
        let widths = questions.iter().map(|question| question.property.chars().count());
        Self { width: widths.fold(8, usize::max).min(WIDEST) }
    }

    pub(super) fn titles(&self) -> Text {
        let mut text = Text::from("\n  ");
        let titles = format!(
            "{:<width$}  {:<11}  {:>11}  {:>9}  {:>6}  {:>7}",
            "property",
            "result",
            "states",
            "quiet",
            "depth",
            "time",
            width = self.width
        );
        text.paint(HEAD, &titles, 0);
        text += "\n";
        text
    }

    pub(super) fn line(&self, finding: &Finding) -> Text {
        let explorer::Progress { states, quiet, depth, .. } = finding.answer.exploration.progress;
        let mut text = Text::from(format!("  {:<width$}  ", finding.question.property, width = self.width));
        let style = match finding.answer.outcome() {
            Some(ProofOutcome::Proved) => GOOD,
            Some(ProofOutcome::Violated) => BAD,
            None => OPEN,
        };
        text.paint(style, &finding.result().to_string(), 11);
        text += format!("  {states:>11}  {quiet:>9}  {depth:>6}  {:>5.1} s\n", finding.seconds);
        if let Some(difference) = finding.difference() {
            text += format!("  ! {difference}\n");
        }
        if let Some(vacuous) = finding.vacuous() {
            text += format!("  ! {vacuous}\n");
        }
        text
    }
}
