//! What a proof finds of a property, in a word or two, which the reference explains.

use std::fmt;

use clap::ValueEnum;

/// The result for a property. The reference has the names and comments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProofResult {
    /// No run violates it, however long; for `all_reached`, everything is reached
    Proved,
    /// The run in `run` violates it; for `all_reached`, something is never reached
    Violated,
    /// In the run in `run`, more than 32 messages or delayed events pile up in a process; what follows is not searched
    Endless,
    /// In the run in `run`, the tree never takes another tick, and nothing else ever happens
    Deadlock,
    /// In the run in `run`, processes communicate forever before the next tick
    Livelock,
    /// No battery can have the levels of the run that was found, so it is not decided
    Spurious,
    /// The search reached the limit in `limit` first
    #[value(name = "not decided")]
    Undecided,
    /// The search was interrupted
    Interrupted,
    /// An error ended the proof before its runs were searched, which `reason` explains
    #[value(name = "not searched")]
    Unsearched,
}

impl fmt::Display for ProofResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.to_possible_value().expect("none is hidden").get_name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_lists_every_result() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/src/reference/prove.md");
        let text = std::fs::read_to_string(file).expect("it is there");
        let (_, after) = text.split_once("\n| result | meaning |\n| --- | --- |\n").expect("it has the table");
        let (listed, _) = after.split_once("\n\n").expect("it goes on");
        let row = |result: &ProofResult| {
            let value = result.to_possible_value().expect("none is hidden");
            format!("| `{}` | {}. |", value.get_name(), value.get_help().expect("it is explained"))
        };
        let wanted: Vec<String> = ProofResult::value_variants().iter().map(row).collect();
        assert_eq!(listed.lines().collect::<Vec<_>>(), wanted, "{file}");
    }
}
