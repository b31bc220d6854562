//! The results as text for the terminal.

use std::fmt::{self, Formatter};

use super::{ClaimResult, Reproduction};

/// The paper's claims, their sources, the number of runs in which they were true, and the runs in which they were not;
/// then the claims that this project adds.
pub fn table(reproduction: &Reproduction) -> String {
    fmt::from_fn(|text| write_table(text, reproduction)).to_string()
}

fn write_table(text: &mut Formatter<'_>, reproduction: &Reproduction) -> fmt::Result {
    let seeds = reproduction.seeds;
    for experiment in &reproduction.experiments {
        writeln!(text, "{} ({})", experiment.title, experiment.scenario)?;
        experiment.claims.iter().try_for_each(|claim| write_claim(text, claim, seeds))?;
        writeln!(text)?;
    }
    writeln!(text, "Ours, not the paper's")?;
    for experiment in &reproduction.experiments {
        writeln!(text, " {}", experiment.scenario)?;
        experiment.ours.iter().try_for_each(|claim| write_claim(text, claim, seeds))?;
    }
    writeln!(text, "\n{}", reproduction.outcome())
}

fn write_claim(text: &mut Formatter<'_>, claim: &ClaimResult, seeds: u64) -> fmt::Result {
    let sign = if claim.holds() { ' ' } else { '!' };
    writeln!(text, "{sign} {:>7}  {}", format!("{}/{seeds}", claim.runs), claim.says)?;
    writeln!(text, "           [{}]", claim.source)?;
    for difference in &claim.differences {
        writeln!(text, "           seed {}: {}", difference.seed, difference.found)?;
    }
    Ok(())
}
