//! Files with a run that was found.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use campaigns::{Error, run_and_report};
use explorer::Outcome;
use proofs::{COUNTEREXAMPLE, PHYSICS, Proof, SCHEDULE};
use recording::Detail;
use reports::report::OutcomeReport;
use reports::{Outputs, REPORT, file_name, html};
use runs::Run;
use scenarios::scenario::{Scenario, find};

use super::finding::{Finding, WrittenRun};

/// The files of a run that violates a property, all of which may be written.
pub(super) fn files(folder: &Path, property: &str) -> impl Iterator<Item = PathBuf> {
    let name = file_name(property);
    let charts = ["svg", "png"].map(|ending| format!("sequence-{name}.{ending}"));
    let files = [SCHEDULE, COUNTEREXAMPLE, PHYSICS, REPORT, html::FILE].map(str::to_owned);
    let folder = folder.join(name);
    files.into_iter().chain(charts).map(move |file| folder.join(file))
}

/// Writes a run that violates a property into its own folder, and then follows it; none if no such run was found.
pub(super) fn write(proof: &Proof, finding: &Finding, folder: &Path) -> Result<Option<WrittenRun>, Error> {
    let Outcome::Violated(run) = &finding.answer.exploration.outcome else { return Ok(None) };
    if finding.answer.is_spurious {
        return Ok(None);
    }
    let property = &finding.question.property;
    let folder = folder.join(file_name(property));
    let outputs = Outputs { folder: Some(folder.clone()), charts: true, ..Outputs::default() };
    campaigns::refuse_campaign(&outputs)?;
    let file = proof.write_run(&finding.question, &finding.answer, run, &folder)?;
    let scenario = Arc::new(Scenario::load(&find::find(&file.display().to_string())?, &[])?);
    let run = Run::new(Arc::clone(&scenario), scenario.file.seed, true)?;
    let report = run_and_report(run, Detail::Full, &outputs, None, |_| {}, |_| ControlFlow::Continue(()))?;
    // The files that were just written are run, not the proof's own data: so they are known to show the violation.
    if report.outcome != OutcomeReport::AsExpected {
        let help = "this is a bug in steward: please report it, with the scenario";
        let message = format!("{} does not violate {property} as it was found", file.display());
        return Err(Error::refused(message, help));
    }
    let name = file_name(property);
    let page = folder.join(html::FILE);
    let mut files = format!("{}, {SCHEDULE}, {COUNTEREXAMPLE}, sequence-{name}.svg and .png", page.display());
    if let Some(physical) = finding.physical.as_ref().filter(|physical| physical.tick.is_some()) {
        proof.write_physical(&finding.question, physical, &folder)?;
        files += &format!(", {PHYSICS}");
    }
    Ok(Some(WrittenRun { page, chart: folder.join(format!("sequence-{name}.png")), files }))
}
