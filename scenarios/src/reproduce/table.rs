//! The results for the terminal.

use std::fmt::Write;

use super::Reproduction;

/// One table: what the paper says, where, and in how many runs it was so; then the runs in which it was not.
pub(crate) fn table(reproduction: &Reproduction) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_table(&mut text, reproduction);
    text
}

fn write_table(text: &mut String, reproduction: &Reproduction) -> std::fmt::Result {
    let widest = |of: fn(&super::ClaimResult) -> &str| {
        reproduction.claims().map(|claim| of(claim).chars().count()).max().unwrap_or(0)
    };
    let (says, source) = (widest(|claim| claim.says), widest(|claim| claim.source));
    for experiment in &reproduction.experiments {
        writeln!(text, "{} ({})", experiment.title, experiment.scenario)?;
        for claim in &experiment.claims {
            let sign = if claim.differences.is_empty() { ' ' } else { '!' };
            let runs = format!("{}/{}", claim.runs, reproduction.seeds);
            writeln!(text, "{sign} {:<says$}  {:<source$}  {runs:>7}", claim.says, claim.source)?;
            for difference in &claim.differences {
                writeln!(text, "    seed {}: {}", difference.seed, difference.found)?;
            }
        }
        writeln!(text)?;
    }
    let runs = reproduction.seeds * reproduction.experiments.len() as u64;
    match reproduction.is_as_printed() {
        true => writeln!(text, "All {runs} runs are as the paper says."),
        false => writeln!(text, "Not all of the {runs} runs are as the paper says."),
    }
}
