//! The table of what was proved.

use std::fmt::Write;

use scenarios::prove::{Proof, Question};
use scenarios::scenario::ProofOutcome;

use super::finding::Finding;
use crate::output::{BAD, GOOD, HEAD, OPEN, Text};

/// The widest column of names that leaves room for the others in 80 columns.
const WIDEST: usize = 24;

/// What is proved under which assumptions.
pub(super) fn head(proof: &Proof) -> Text {
    let mut text = Text::default();
    text.paint(HEAD, &proof.scenario().name, 0);
    // Writing to a string cannot fail.
    let _ = writeln!(text);
    for assumption in proof.assumptions() {
        let _ = writeln!(text, "  {assumption}");
    }
    text
}

/// A table of properties.
pub(super) struct Table {
    width: usize,
}

impl Table {
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
        let _ = writeln!(text);
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
        text.paint(style, finding.word(), 11);
        let _ = writeln!(text, "  {states:>11}  {quiet:>9}  {depth:>6}  {:>5.1} s", finding.seconds);
        if let Some(difference) = finding.difference() {
            let _ = writeln!(text, "  ! {difference}");
        }
        text
    }
}
