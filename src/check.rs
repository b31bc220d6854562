//! `steward check`: everything short of a run.

use std::path::Path;
use std::process::ExitCode;

use campaigns::Error;
use checks::{Checked, examine};
use clap::Args;
use diagnostics::{Disk, counted};
use reports::results::{Case, CaseResult, FileFinding, Suite};
use scenarios::files::shipped_campaigns;
use scenarios::scenario::find;
use serde_json::json;

use crate::output::{complain, print_json, print_wrapped, warn};
use crate::render::{Finding, findings};
use crate::results::{self, ResultsArgs};
use crate::run::select;

/// What to check.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Scenarios, campaigns, maps, places, trees, skills, interfaces, mappings and properties: files, or names (see
    /// `steward list`)
    #[arg(value_name = "NAME|FILE", required = true)]
    files: Vec<String>,
    /// The scenario with the processes of machines, the processes and channels of property files and the places of
    /// interfaces; for property files, also a mapping [default: nominal]
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<String>,
    #[command(flatten)]
    results: ResultsArgs,
    /// Prints the findings as JSON
    #[arg(long)]
    json: bool,
}

/// Checks every file according to its kind.
pub(crate) fn check(args: &CheckArgs) -> Result<ExitCode, Error> {
    args.results.begin()?;
    let files: Result<Vec<Vec<String>>, Error> = args.files.iter().map(|file| meant(file)).collect();
    let files = args.results.or_refused("check", &args.files, files)?;
    let examined = |file: &String| examine(&Disk::default(), file, args.scenario.as_deref());
    each(&files.concat(), args.json, &args.results, examined)
}

/// The files to which an argument refers: several for a folder or a pattern of scenarios, as in `steward run`.
fn meant(file: &str) -> Result<Vec<String>, Error> {
    let path = Path::new(file);
    let is_campaign = || find::shipped(file).is_none() && shipped_campaigns().any(|(name, _)| name == file);
    if !path.is_dir() && (path.extension().is_some() || is_campaign()) {
        return Ok(vec![file.to_owned()]);
    }
    match select::meant(file) {
        Ok(found) => Ok(found.into_iter().map(|one| one.argument).collect()),
        Err(error) if path.is_dir() => Err(error),
        // It is reported with the other files.
        Err(_) => Ok(vec![file.to_owned()]),
    }
}

/// Examines every file, and reports errors and warnings. Exit status 2 if anything is wrong.
pub(crate) fn each<F: AsRef<Path>>(
    files: &[F],
    json: bool,
    results: &ResultsArgs,
    examine: impl Fn(&F) -> Result<Checked, Error>,
) -> Result<ExitCode, Error> {
    let (mut refused, mut report, mut suites) = (0, Vec::new(), Vec::new());
    for file in files {
        let checked = examine(file);
        let file = file.as_ref().display();
        refused += usize::from(checked.is_err());
        if results.are_wanted() {
            suites.push(suite(&file.to_string(), &checked));
        }
        if json {
            report.push(as_json(&file.to_string(), &checked));
            continue;
        }
        let words = match &checked {
            Ok(checked) => {
                checked.concerns.iter().for_each(|concern| warn(concern.as_ref()));
                checked.words()
            }
            Err(error) => {
                complain(error);
                counted(results::findings_of(error).len(), "problem")
            }
        };
        print_wrapped(format!("{file}: {words}\n"))?;
        for line in checked.iter().flat_map(|checked| checked.elsewhere.iter().chain(&checked.programs)) {
            print_wrapped(format!("  {line}\n"))?;
        }
    }
    if json {
        print_json(&report)?;
    } else if files.len() > 1 {
        print_wrapped(format!("{} checked, {refused} with problems\n", counted(files.len(), "file")))?;
    }
    results.write("check", || suites)?;
    Ok(ExitCode::from(if refused > 0 { 2 } else { 0 }))
}

/// A file as a test case, with everything that was found in it. One that is missing was not checked.
fn suite(file: &str, checked: &Result<Checked, Error>) -> Suite {
    let place = results::file_of(file);
    let (result, found, findings) = match checked {
        Err(error) if place.is_none() => return results::refused(file, error, results::on_disk(&[file])),
        Ok(checked) => {
            let concerns = checked.concerns.iter().flat_map(|concern| results::findings(concern.as_ref()));
            (CaseResult::Passed, checked.words(), concerns.collect())
        }
        Err(error) => {
            let path = results::on_disk(&[file]);
            let findings = results::findings_of(error).into_iter().map(|finding| finding.with_path(&path));
            let findings: Vec<FileFinding> = findings.collect();
            let message = counted(findings.len(), "problem");
            let details = findings.iter().map(|finding| finding.one_line() + "\n").collect();
            (CaseResult::Failed { message, details }, String::new(), findings)
        }
    };
    Suite {
        name: file.to_owned(),
        cases: vec![Case { group: "files", name: file.to_owned(), result, found, ..Case::default() }],
        findings,
        notes: checked.as_ref().map_or_else(|_| Vec::new(), |checked| checked.elsewhere.clone()),
        file: place,
        ..Suite::default()
    }
    .with_paths(results::on_disk(&[file]))
}

fn as_json(file: &str, checked: &Result<Checked, Error>) -> serde_json::Value {
    let (sound, problems) = (checked.as_ref().ok(), checked.as_ref().err().map(problems).unwrap_or_default());
    let warnings = sound.iter().flat_map(|sound| &sound.concerns).flat_map(|concern| findings(concern.as_ref()));
    json!({
        "file": file,
        "ok": checked.is_ok(),
        "summary": sound.map(|sound| &sound.summary),
        "programs": sound.map_or(&[][..], |sound| &sound.programs),
        "elsewhere": sound.map_or(&[][..], |sound| &sound.elsewhere),
        "warnings": warnings.collect::<Vec<_>>(),
        "problems": problems,
    })
}

/// Everything that an error reports.
fn problems(error: &Error) -> Vec<Finding> {
    match error.diagnostics() {
        none if none.is_empty() => vec![Finding::of_message(error.to_string())],
        diagnostics => diagnostics.into_iter().flat_map(findings).collect(),
    }
}
