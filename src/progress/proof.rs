//! The progress of a proof.

use std::io::IsTerminal;
use std::sync::LazyLock;
use std::time::Duration;

use clap::ValueEnum;
use proofs::Round;
use serde_json::json;

use super::{BETWEEN_LINES, NowAndThen, ProgressLine};
use crate::output::complain_of;

/// The time between two lines of progress for programs.
const BETWEEN_OBJECTS: Duration = Duration::from_secs(1);

/// When the next line for people is due. All proofs of a command share it: many short searches take long together.
static LINES: LazyLock<NowAndThen> = LazyLock::new(|| NowAndThen::new(BETWEEN_LINES));

/// The form in which a proof shows its progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressForm {
    Text,
    // An object at the beginning of each round, and then every second.
    Json,
}

/// The progress of a proof.
#[derive(Debug)]
pub(crate) struct ProofProgress {
    property: String,
    shown: Shown,
    /// The number of the round that was shown last.
    round: usize,
}

#[derive(Debug)]
enum Shown {
    Line(ProgressLine),
    Lines(&'static NowAndThen),
    Objects(NowAndThen),
}

impl ProofProgress {
    /// Of the proof of a property; not shown without a form.
    pub(crate) fn new(form: Option<ProgressForm>, property: &str) -> Self {
        let is_terminal = std::io::stderr().is_terminal();
        let shown = match form {
            Some(ProgressForm::Json) => Shown::Objects(NowAndThen::new(BETWEEN_OBJECTS)),
            Some(ProgressForm::Text) if !is_terminal => Shown::Lines(&LINES),
            form => {
                let template = "{spinner} {prefix}: {pos} states visited, {rate} per second, {wide_msg}";
                let line = ProgressLine::new(form.is_none(), template, 0);
                line.0.iter().for_each(|bar| bar.set_prefix(property.to_owned()));
                Shown::Line(line)
            }
        };
        Self { property: property.to_owned(), shown, round: 0 }
    }

    pub(crate) fn show(&mut self, round: &Round) {
        let is_new = std::mem::replace(&mut self.round, round.number) != round.number;
        let explorer::Progress { states, visited, quiet, depth, memory, is_reduced, is_complete } = round.progress;
        match &self.shown {
            Shown::Line(ProgressLine(bar)) => bar.iter().for_each(|bar| {
                bar.set_position(visited);
                bar.set_message(in_words(round));
            }),
            Shown::Lines(lines) if lines.is_due() => {
                complain_of(format!("{}: {visited} states visited, {}\n", self.property, in_words(round)));
            }
            Shown::Objects(objects) if objects.is_due() || is_new => {
                let object = json!({
                    "property": self.property,
                    "round": round.number,
                    "levels": round.levels,
                    "reduced": is_reduced,
                    "states": states,
                    "visited_states": visited,
                    "quiet_states": quiet,
                    "depth": depth,
                    "memory_bytes": memory,
                    "complete": is_complete,
                });
                complain_of(format!("{object}\n"));
            }
            Shown::Lines(_) | Shown::Objects(_) => {}
        }
    }
}

/// How far a round of a proof is, without the states.
fn in_words(Round { number, levels, progress }: &Round) -> String {
    let mut text = format!("depth {}, {} MiB", progress.depth, progress.memory >> 20);
    if *number > 1 {
        text += &format!(", round {number}");
        // The levels of the first round are the coarsest, and not shown.
        if let Some(levels) = levels {
            text += &format!(" with {levels} classes of levels");
        }
    }
    if progress.is_complete {
        text += ", looking for cycles";
    }
    text
}
