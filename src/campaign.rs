//! `steward campaign`: from one run to a hundred thousand.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use campaigns::Error;
use campaigns::compare::CampaignComparison;
use campaigns::run_and_report;
use campaigns::statistics::{Confidence, Count};
use campaigns::{Named, Plan, Ran, Shard, Summary};
use clap::{Args, Subcommand};
use cockpit::{Board, Tally};
use diagnostics::counted;
use recording::Detail;
use reports::report::{OutcomeReport, Report};
use reports::results::{Suite, WrittenPlaces};
use reports::{Outputs, file_name};
use runs::Run;
use scenarios::scenario::Scenario;

use crate::live::BoardArgs;
use crate::names;
use crate::output::{BAD, GOOD, HEAD, Text, note, note_elsewhere, print_json, print_wrapped};
use crate::progress::CampaignProgress;
use crate::results::{ResultsArgs, file_of, on_disk, places};
use crate::{interrupt, summary};

/// The command's name in results.
const COMMAND: &str = "campaign";

/// The campaign, and how many of its runs to run.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct CampaignArgs {
    #[command(subcommand)]
    command: Option<CampaignCommand>,
    /// A campaign's name (see `steward list`) or file, or a RoAML model
    #[arg(value_name = "NAME|FILE", required = true, value_parser = names::CAMPAIGNS, hide_possible_values = true)]
    file: Option<String>,
    /// How many runs, instead of the number in the file
    #[arg(long, value_name = "N")]
    runs: Option<u64>,
    /// Runs only those k with k mod N = I [default: as given by the Slurm array or the indexed Kubernetes job]
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// Repeats only run K, with pictures and report; exit status 1 if it is not as expected
    #[arg(long, value_name = "K", conflicts_with = "shard")]
    only: Option<u64>,
    /// Where the results go; an interrupted campaign resumes there [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Starts over: first removes the results of an earlier campaign in that folder, and nothing else
    #[arg(long, conflicts_with = "only")]
    fresh: bool,
    /// Shows no progress and no summary
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    results: ResultsArgs,
    #[command(flatten)]
    board: BoardArgs,
}

#[derive(Debug, Subcommand)]
enum CampaignCommand {
    /// Merges the shards of a campaign
    Merge {
        /// The folders of the shards, or a folder that contains them
        #[arg(value_name = "DIR", required = true)]
        shards: Vec<PathBuf>,
        /// Where the results go: a new folder
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        #[command(flatten)]
        results: ResultsArgs,
    },
    /// Shows whether something happens more often in one campaign than in another
    Compare {
        /// The earlier results: a folder that a campaign wrote, or merged
        before: PathBuf,
        /// The later results
        after: PathBuf,
        /// Prints JSON instead of text
        #[arg(long)]
        json: bool,
    },
}

/// Reads `I/N`.
fn shard(text: &str) -> Result<Shard, String> {
    let shard = text.split_once('/').and_then(|(index, of)| Shard::new(index.parse().ok()?, of.parse().ok()?));
    shard.ok_or_else(|| format!("a shard is I/N, with I from 0 to N-1 and N at most {}", Shard::MOST))
}

/// The shard that a scheduler assigns to this process through its environment.
///
/// # Errors
/// If the environment names a shard that does not exist.
fn shard_of_job(variable: impl Fn(&str) -> Option<String>) -> Result<Option<Shard>, Error> {
    let (index, of) = if let Some(id) = variable("SLURM_ARRAY_TASK_ID") {
        let least = variable("SLURM_ARRAY_TASK_MIN").unwrap_or_else(|| "0".to_owned());
        let index = id.parse().ok().zip(least.parse().ok()).and_then(|(id, least): (u64, u64)| id.checked_sub(least));
        (index, variable("SLURM_ARRAY_TASK_COUNT"))
    } else if let Some(index) = variable("JOB_COMPLETION_INDEX") {
        (index.parse().ok(), variable("JOB_COMPLETIONS"))
    } else {
        return Ok(None);
    };
    let of = of.and_then(|of| of.parse().ok());
    let shard = index.zip(of).and_then(|(index, of)| Shard::new(index, of));
    shard.map(Some).ok_or_else(|| {
        Error::refused(
            "the job's environment does not determine which shard to run",
            "Slurm sets SLURM_ARRAY_TASK_ID, _MIN and _COUNT (number the tasks without gaps); Kubernetes sets \
             JOB_COMPLETION_INDEX, and you set JOB_COMPLETIONS; or give `--shard I/N`",
        )
    })
}

/// Runs a campaign or a shard of it, repeats a run, or merges shards.
pub(crate) fn campaign(args: &CampaignArgs) -> Result<ExitCode, Error> {
    match &args.command {
        Some(CampaignCommand::Merge { shards, out, results }) => {
            results.begin()?;
            let names: Vec<String> = shards.iter().map(|shard| shard.display().to_string()).collect();
            let summary = results.or_refused(COMMAND, &names, campaigns::merge(shards, out))?;
            // Shards may be merged where the campaign's file is not.
            let plan = || Plan::load(Path::new(&summary.campaign)).ok();
            results.write(COMMAND, || vec![suite(&summary, out, plan().as_ref().map(Plan::base))])?;
            print_wrapped(in_words(&summary, out))?;
            Ok(status(&summary))
        }
        Some(CampaignCommand::Compare { before, after, json }) => {
            let comparison = CampaignComparison::of(before, after)?;
            if *json { print_json(&comparison) } else { print_wrapped(comparison.to_string()) }?;
            Ok(ExitCode::SUCCESS)
        }
        None => run(args),
    }
}

/// Runs a campaign or a shard of it, or repeats a run.
fn run(args: &CampaignArgs) -> Result<ExitCode, Error> {
    args.results.begin()?;
    let file = Path::new(args.file.as_deref().unwrap_or_default());
    let plan = Plan::load(file).and_then(|plan| args.runs.map_or(Ok(plan.clone()), |runs| plan.with_runs(runs)));
    let plan = args.results.or_refused(COMMAND, args.file.as_slice(), plan)?;
    note_elsewhere(plan.base());
    let name = file.file_stem().map_or_else(|| "campaign".into(), |stem| file_name(&stem.to_string_lossy()));
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
    let subject = args.file.as_slice();
    if let Some(k) = args.only {
        return only(&plan, k, &out.join(format!("run-{k}")), args);
    }
    let shard = args.shard.map_or_else(|| shard_of_job(|name| std::env::var(name).ok()), |shard| Ok(Some(shard)));
    let shard = args.results.or_refused(COMMAND, subject, shard)?;
    let folder = shard.map_or(out.clone(), |Shard { index, of }| out.join(format!("shard-{index}-of-{of}")));
    let part = shard.unwrap_or(Shard::ALL);
    let ran = args.results.or_refused(COMMAND, subject, run_part(args, &plan, part, &folder))?;
    if !ran.complete {
        let Ran { done, all, .. } = ran;
        note(&format!("interrupted after {done} of {}; the same command resumes it", counted(all, "run")));
        args.results.none_yet("the campaign");
        return Ok(ExitCode::from(interrupt::STATUS));
    }
    let (words, status) = match shard {
        Some(_) => {
            if args.results.are_wanted() {
                note(
                    "a shard has no results for CI systems: `steward campaign merge --results FILE` writes those of all",
                );
            }
            let words = format!("wrote {}; `steward campaign merge` merges the shards\n", folder.display());
            (Text::from(words), ExitCode::SUCCESS)
        }
        None => {
            let summary = args.results.or_refused(COMMAND, subject, ran.finish())?;
            args.results.write(COMMAND, || vec![suite(&summary, &folder, Some(plan.base()))])?;
            (in_words(&summary, &folder), status(&summary))
        }
    };
    if !args.quiet {
        print_wrapped(words)?;
    }
    Ok(status)
}

/// Runs a part of a campaign, and shows its progress on the terminal and on its page.
fn run_part(args: &CampaignArgs, plan: &Plan, part: Shard, folder: &Path) -> Result<Ran, Error> {
    if args.fresh {
        campaigns::start_over(plan, part, folder)?;
    }
    let mut bar = CampaignProgress::new(args.quiet);
    let board = args.board.open(&format!("campaign {}", args.file.as_deref().unwrap_or_default()))?;
    let interrupted = interrupt::listen();
    let ran = campaigns::run(plan, part, folder, batch::threads(), interrupted, |progress| {
        bar.show(progress);
        board.iter().for_each(|board| show(progress, board));
    });
    // Also after an error: it is reported below the bar, and the page shows that nothing more comes.
    drop(bar);
    board.into_iter().for_each(Board::finish);
    ran
}

/// Shows the progress of the campaign on its page.
fn show(progress: &campaigns::Progress<'_>, board: &Board) {
    let run = progress.run.filter(|run| run.unexpected());
    let unexpected = run.map(|run| {
        let unmet = (!run.unmet.is_empty()).then(|| format!("unmet: {}", run.unmet.join("; ")));
        let why = run.failure.iter().cloned().chain(unmet).collect::<Vec<_>>().join("; ");
        format!("run {}: {why}", run.k)
    });
    let tally = |name: String, count: Count| {
        let interval = count.interval(Confidence::OF_RESULTS);
        Tally { name, happened: count.happened(), of: count.runs(), interval: Some([interval.low, interval.high]) }
    };
    let tallies = || {
        let violated = progress.properties.iter().zip(progress.violated);
        let violated = violated.map(|(name, count)| tally(format!("{name} violated"), *count));
        violated.chain([tally("not as expected".to_owned(), progress.unexpected)]).collect()
    };
    board.show(progress.done, progress.all, unexpected, tallies);
}

/// A campaign succeeds whatever the answer to its question is, unless no run finished.
fn status(summary: &Summary) -> ExitCode {
    ExitCode::from(u8::from(summary.outcomes.failed == summary.runs))
}

/// The results as test cases, with places in the files of the scenario, if that is known.
fn suite(summary: &Summary, folder: &Path, base: Option<&Arc<Scenario>>) -> Suite {
    let places = base.map(|scenario| places(scenario)).unwrap_or_default();
    let argument = base.map_or("", |scenario| &scenario.origin.argument);
    let places = WrittenPlaces { file: file_of(&summary.campaign), ..places };
    summary.suite(folder, &places).with_paths(on_disk(&[&summary.campaign, argument]))
}

/// Repeats one run alone, and writes and shows its results.
fn only(plan: &Plan, k: u64, folder: &Path, args: &CampaignArgs) -> Result<ExitCode, Error> {
    let (scenario, report) = args.results.or_refused(COMMAND, args.file.as_slice(), repeat(plan, k, folder))?;
    if report.outcome == OutcomeReport::Interrupted {
        args.results.none_yet("the run");
    } else {
        let suite = || {
            Suite::of_run(&scenario.expected(), &report, folder, &places(&scenario))
                .with_paths(on_disk(&[&scenario.origin.argument]))
        };
        args.results.write(COMMAND, || vec![suite()])?;
    }
    summary::print(&report, folder, args.quiet)
}

fn repeat(plan: &Plan, k: u64, folder: &Path) -> Result<(Arc<Scenario>, Report), Error> {
    if k >= plan.runs() {
        let help = format!("runs are counted from 0 to {}", plan.runs() - 1);
        return Err(Error::refused(format!("the campaign has no run {k}"), help));
    }
    let run = plan.run(k);
    let scenario = Arc::new(Scenario::load(plan.scenario(), &run.overrides(plan))?);
    let outputs = Outputs { folder: Some(folder.to_owned()), snapshots: true, ..Outputs::default() };
    outputs.check()?;
    let _ = interrupt::listen();
    let run = Run::new(Arc::clone(&scenario), run.seed, true)?;
    let report = run_and_report(run, Detail::Full, &outputs, None, |_| {}, |_| interrupt::flow())?;
    Ok((scenario, report))
}

/// The results of a campaign, for people.
fn in_words(summary: &Summary, folder: &Path) -> Text {
    let mut text = Text::default();
    write_outcomes(&mut text, summary);
    let names = summary.properties.iter().map(|estimate| estimate.of.chars().count());
    let widest = names.fold(8, usize::max).min(32);
    for (name, words) in findings(summary, folder) {
        text += format!("  {name:<widest$}  {words}\n");
    }
    text
}

fn write_outcomes(text: &mut Text, summary: &Summary) {
    let Summary { runs, outcomes, .. } = summary;
    text.paint(HEAD, &counted(runs, "run"), 0);
    if summary.expects {
        *text += ": ";
        text.paint(GOOD, &format!("{} as expected", outcomes.as_expected), 0);
        if outcomes.not_as_expected > 0 {
            *text += ", ";
            text.paint(BAD, &format!("{} not", outcomes.not_as_expected), 0);
        }
    } else {
        *text += ", nothing expected of them";
    }
    if outcomes.failed > 0 {
        *text += ", ";
        text.paint(BAD, &format!("{} failed", outcomes.failed), 0);
        *text += " (which do not count for any property)";
    }
    *text += "\n";
}

/// One line per subject, with what there is to report about it.
fn findings(summary: &Summary, folder: &Path) -> Vec<(String, String)> {
    let mut lines = Vec::new();
    let mut line = |name: &str, words: String| lines.push((name.to_owned(), words));
    summary.often_unmet().iter().for_each(|unmet| line("not met", unmet.to_string()));
    match summary.unmet.len() - summary.often_unmet().len() {
        0 => {}
        more => line("", format!("and {more} more, each in fewer runs")),
    }
    let (listed, groups) = summary.by_rate();
    for estimate in listed {
        line(&estimate.of, estimate.in_words(summary.of_roaml));
        estimate.open_in_words().into_iter().for_each(|open| line("", open));
    }
    for group in groups {
        let names: Vec<&str> = group.iter().map(|estimate| estimate.of.as_str()).collect();
        line(
            &format!("{} properties", group.len()),
            format!("{}, each: {}", group[0].in_words(false), names.join(", ")),
        );
    }
    if let Some(goal) = &summary.goal {
        line("goal", goal.to_string());
    }
    for (place, part) in summary.frontier.iter().flat_map(|frontier| frontier.split("; ")).enumerate() {
        line(if place == 0 { "frontier" } else { "" }, part.to_owned());
    }
    let shown = instructive(summary);
    for Named { k, why, .. } in &shown {
        line(&format!("run {k}"), why.clone().unwrap_or_default());
    }
    shown.first().into_iter().for_each(|run| line("repeat", run.command.clone()));
    line("wrote", folder.join("report.html").display().to_string());
    lines
}

/// The runs to look at first: one that failed, then those that show most. A run may be among several of these.
fn instructive(summary: &Summary) -> Vec<&Named> {
    let mut shown: Vec<&Named> = Vec::new();
    for run in summary.failures.iter().take(1).chain(&summary.instructive).chain(&summary.unexpected) {
        if shown.len() < SHOWN && shown.iter().all(|other| other.k != run.k) {
            shown.push(run);
        }
    }
    shown
}

/// At most this many runs are named.
const SHOWN: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;

    fn job(variables: &[(&str, &str)]) -> Result<Option<Shard>, Error> {
        let value = |name: &str| variables.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned());
        shard_of_job(value)
    }

    #[test]
    fn a_scheduler_determines_which_shard_to_run() {
        let slurm = [("SLURM_ARRAY_TASK_ID", "5"), ("SLURM_ARRAY_TASK_MIN", "1"), ("SLURM_ARRAY_TASK_COUNT", "8")];
        assert_eq!(job(&slurm).unwrap(), Some(Shard { index: 4, of: 8 }));
        let kubernetes = [("JOB_COMPLETION_INDEX", "0"), ("JOB_COMPLETIONS", "3")];
        assert_eq!(job(&kubernetes).unwrap(), Some(Shard { index: 0, of: 3 }));
        assert_eq!(job(&[]).unwrap(), None);
        assert!(job(&kubernetes[..1]).is_err());
        assert!(job(&[("SLURM_ARRAY_TASK_ID", "8"), ("SLURM_ARRAY_TASK_COUNT", "8")]).is_err());
    }

    #[test]
    fn a_shard_is_written_as_a_fraction() {
        assert_eq!(shard("0/1"), Ok(Shard::ALL));
        assert_eq!(shard("7/8"), Ok(Shard { index: 7, of: 8 }));
        for wrong in ["8/8", "1", "-1/2", "a/b", "0/0", "0/1000001", "0/18446744073709551615"] {
            assert!(shard(wrong).is_err(), "{wrong}");
        }
    }
}
