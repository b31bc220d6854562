//! `steward prove`: checks all runs of a scenario against its properties.

mod finding;
mod mutants;
mod result;
mod table;
mod violation;
mod written;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use campaigns::Error;
use clap::{Args, ValueEnum};
use explorer::{Limits, Order, Outcome};
use proofs::{Proof, Question};
use reports::results::Suite;
use scenarios::scenario::{Found, Scenario};

use self::finding::{Finding, Findings, Unsearched};
use self::mutants::Mutants;
use self::table::FindingsTable;
use self::violation::Violation;
use crate::interrupt;
use crate::moment::moment;
use crate::names;
use crate::output::{Text, complain, note_elsewhere, print, print_json, print_wrapped};
use crate::progress::{ProgressForm, ProofProgress};
use crate::results::ResultsArgs;
use crate::run::select::{check_folders, select};

/// Why scenarios are left out after an error.
const ENDED: &str = "an error about another scenario ended the proofs";

/// What to prove, and how.
#[derive(Debug, Args)]
pub(crate) struct ProveArgs {
    /// Scenarios: names (see `steward list`), files, folders, or patterns of names
    #[arg(value_name = "NAME|FILE", required = true, value_parser = names::SCENARIOS, hide_possible_values = true)]
    scenarios: Vec<String>,
    /// Proves only this property; may be given more than once [default: those that `[prove]` names, or all]
    #[arg(long = "property", value_name = "NAME")]
    properties: Vec<String>,
    /// Changes a value of the scenario: `prove.trips.ticks=8`, `execution.tree=nodes`
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// How much memory the proof of a property may take, in MiB [default: what `[prove]` sets, or 2048]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    memory: Option<u64>,
    /// How many states the proof of a property may visit, over all its rounds [default: what `[prove]` sets, or
    /// 20000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    states: Option<u64>,
    /// Which state is explored next: `breadth` first finds shortest runs; `depth` first, on one thread, finds
    /// violations that take many steps sooner
    #[arg(long, value_enum, default_value = "breadth", conflicts_with = "mutants", hide_possible_values = true)]
    #[arg(value_name = "ORDER")]
    order: SearchOrder,
    /// How many threads explore; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
    /// Proves the properties for every single mistake in a skill or the tree, and lists the mistakes that no property
    /// detects
    #[arg(long, conflicts_with_all = ["messages", "unreached", "promela", "out", "replay"])]
    mutants: bool,
    /// Prints the machine that may answer anything in place of this component, as SCXML to begin with, and proves
    /// nothing
    #[arg(long, value_name = "COMPONENT")]
    #[arg(conflicts_with_all = ["mutants", "messages", "out", "replay", "unreached", "promela", "results", "junit"])]
    #[arg(conflicts_with = "json")]
    stand_in: Option<String>,
    /// Shows all messages of a run that violates a property, not only those that the property is about
    #[arg(long)]
    messages: bool,
    /// Writes each run that violates a property into a folder under this one: as a page with its sequence chart, as a
    /// schedule, and as a scenario that follows it
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Repeats in the simulation each run that violates a property, with levels and lost messages as faults at the
    /// same times; shows whether the property is violated there too, or what differs
    #[arg(long)]
    replay: bool,
    /// Lists the nodes, states and transitions that are reached in no run, instead of counting them
    #[arg(long)]
    unreached: bool,
    /// Writes the explored model in Promela, one file per property, so that SPIN can check the same properties
    #[arg(long, value_name = "FOLDER")]
    promela: Option<PathBuf>,
    #[command(flatten)]
    results: ResultsArgs,
    /// Prints the results as JSON instead of text; for several scenarios, an array
    #[arg(long)]
    json: bool,
    /// How stderr shows the progress: `text`, a line that changes (without a terminal, a line every 30 seconds), or
    /// `json`, an object per line every second
    #[arg(long, value_enum, default_value = "text", conflicts_with = "quiet", hide_possible_values = true)]
    #[arg(value_name = "FORM")]
    progress: ProgressForm,
    /// Shows no progress
    #[arg(long, short)]
    quiet: bool,
}

/// Which state a proof explores next.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SearchOrder {
    Breadth,
    Depth,
}

impl From<SearchOrder> for Order {
    fn from(order: SearchOrder) -> Self {
        match order {
            SearchOrder::Breadth => Self::Breadth,
            SearchOrder::Depth => Self::Depth,
        }
    }
}

/// Proves what the arguments request. Exit status 1 if something is not as expected.
pub(crate) fn prove(args: &ProveArgs) -> Result<ExitCode, Error> {
    args.results.begin()?;
    let stop = interrupt::listen();
    let found = args.results.or_refused("prove", &args.scenarios, select(&args.scenarios, &[]))?;
    if let Some(component) = &args.stand_in {
        found.into_iter().try_for_each(|(_, found)| args.show_stand_in(&found?, component))?;
        return Ok(ExitCode::SUCCESS);
    }
    let arguments: Vec<String> = found.iter().map(|(argument, _)| argument.clone()).collect();
    let load = |found: Found| {
        let scenario = Scenario::load_for_proof(&found, &args.set)?;
        Ok((found, Proof::new(Arc::new(scenario), &args.properties)?))
    };
    let loaded = found.into_iter().map(|(argument, found)| (argument, found.and_then(load)));
    let Some(loaded) = args.results.all_or_refused("prove", loaded)? else { return Ok(ExitCode::from(2)) };
    let (found, proofs): (Vec<Found>, Vec<Proof>) = loaded.into_iter().unzip();
    proofs.iter().for_each(|proof| note_elsewhere(proof.scenario()));
    for folder in args.out.iter().chain(&args.promela) {
        let folders =
            proofs.iter().map(|proof| (proof.scenario().origin.argument.as_str(), of_scenario(folder, proof)));
        args.results.or_refused("prove", &arguments, check_folders(folders))?;
    }
    let mut files = proofs.iter().flat_map(|proof| args.files(proof, found.len() > 1));
    args.results.or_refused("prove", &arguments, files.try_for_each(|file| diagnostics::check_unread(&file)))?;
    if args.mutants {
        return mutants(args, proofs, stop);
    }
    let (mut all, mut refused) = (Vec::new(), None);
    for (found_here, proof) in found.iter().zip(proofs) {
        // What was found before an error is shown and written first, and what is left is named.
        if refused.is_some() {
            all.push(Findings::none(proof, ENDED));
            continue;
        }
        let (mut findings, error) = args.explore_all(&proof, found_here, &args.limits(&proof, stop))?;
        let unsearched = Unsearched::after(&findings, proof.questions(), error.as_ref());
        args.show(&findings)?;
        let folder = args.runs_folder(&proof, found.len() > 1);
        let written = folder.map_or(Ok(()), |folder| args.write_runs(&proof, &mut findings, &folder));
        let unwritten = written.as_ref().err().map(Error::reasons);
        all.push(Findings { proof, findings, unsearched, unwritten });
        refused = match written {
            Ok(()) => error,
            Err(unwritten) => Some(together(error, unwritten)),
        };
    }
    let is_as_expected = all.iter().flat_map(|it| &it.findings).all(Finding::is_as_expected);
    args.conclude(all.iter().map(|it| (it.suite(args.unreached), it.as_json())), refused, is_as_expected)
}

/// What a scenario writes to a folder that it shares with others is in this one, or begins like it.
fn of_scenario(folder: &Path, proof: &Proof) -> PathBuf {
    folder.join(&proof.scenario().name)
}

fn model_file(folder: &Path, proof: &Proof, question: &Question) -> PathBuf {
    let name = format!("{}-{}.pml", proof.scenario().name, question.property);
    folder.join(name.replace('/', "-"))
}

/// Two errors as one: everything that is wrong. What does not fit into one is reported at once; but of files that
/// cannot be written, only the first is named, since the others often have the same reason.
fn together(first: Option<Error>, second: Error) -> Error {
    use scenarios::Error::BadInput;
    match (first, second) {
        (None, second) => second,
        (Some(Error::Scenario(BadInput(mut all))), Error::Scenario(BadInput(more))) => {
            all.extend(more);
            Error::Scenario(BadInput(all))
        }
        (Some(first), second) => {
            let is_unwritten = |error: &Error| error.exit_status() == 3;
            if !(is_unwritten(&first) && is_unwritten(&second)) {
                complain(&second);
            }
            first
        }
    }
}

/// Looks for mistakes that no property detects.
fn mutants(args: &ProveArgs, proofs: Vec<Proof>, stop: &'static AtomicBool) -> Result<ExitCode, Error> {
    let (mut all, mut refused) = (Vec::new(), None);
    for proof in proofs {
        if refused.is_some() {
            all.push(Mutants::none(proof, ENDED.to_owned()));
            continue;
        }
        let limits = args.limits(&proof, stop);
        args.print(table::head(&proof))?;
        let (mutants, error) = Mutants::of(proof, &limits, args.quiet);
        if error.is_none() {
            args.print(mutants.in_words())?;
        }
        all.push(mutants);
        refused = error;
    }
    args.conclude(all.iter().map(|it| (it.suite(), it.as_json())), refused, true)
}

impl ProveArgs {
    /// Prints text, unless the results are JSON.
    fn print(&self, text: impl Into<Text>) -> Result<(), Error> {
        if self.json { Ok(()) } else { print_wrapped(text) }
    }

    /// The folder for a scenario's runs that violate a property, if they are wanted.
    fn runs_folder(&self, proof: &Proof, is_of_several: bool) -> Option<PathBuf> {
        let out = self.out.as_ref()?;
        Some(if is_of_several { of_scenario(out, proof) } else { out.clone() })
    }

    /// All files that may be written about a scenario.
    fn files(&self, proof: &Proof, is_of_several: bool) -> Vec<PathBuf> {
        let folder = self.runs_folder(proof, is_of_several);
        let of_questions = proof.questions().iter().flat_map(|question| {
            let runs = folder.iter().flat_map(move |folder| written::files(folder, &question.property));
            let models = self.promela.iter().map(move |folder| model_file(folder, proof, question));
            runs.chain(models)
        });
        of_questions.collect()
    }

    /// Explores all questions about a scenario, and prints a table of the findings as they come. Returns them, and the
    /// error that ended the exploration, if one did.
    fn explore_all(
        &self,
        proof: &Proof,
        found: &Found,
        limits: &Limits,
    ) -> Result<(Vec<Finding>, Option<Error>), Error> {
        let table = FindingsTable::of(proof.questions());
        self.print(table::head(proof))?;
        self.print(table.titles())?;
        let mut findings = Vec::new();
        for question in proof.questions() {
            match self.explore(proof, question, found, limits) {
                Ok(finding) => {
                    self.print(table.line(&finding))?;
                    findings.push(finding);
                }
                Err(error) => return Ok((findings, Some(error))),
            }
        }
        Ok((findings, None))
    }

    /// Shows what was found besides the table: runs that violate a property, errors, and what is never reached.
    fn show(&self, findings: &[Finding]) -> Result<(), Error> {
        for (finding, violation) in findings.iter().filter_map(|it| Some((it, it.violation.as_ref()?))) {
            let simulated = finding.in_simulation().map_or_else(String::new, |words| format!("  {words}\n"));
            self.print(violation.in_words(&finding.question.property, self.messages) + &simulated)?;
        }
        self.print(table::mistakes(findings))?;
        self.print(table::unreached(findings, self.unreached))
    }

    /// Writes each run that violates a property into its own folder. One that cannot be written does not keep the
    /// others from being written.
    fn write_runs(&self, proof: &Proof, findings: &mut [Finding], folder: &Path) -> Result<(), Error> {
        let mut refused = None;
        for finding in findings {
            match written::write(proof, finding, folder) {
                Ok(run) => finding.written = run,
                Err(error) => refused = Some(together(refused, error)),
            }
            let files = finding.written.as_ref().map(|run| format!("  wrote {}\n", run.files));
            files.map_or(Ok(()), |words| self.print(words))?;
        }
        refused.map_or(Ok(()), Err)
    }

    /// Writes the results for CI systems and JSON, if they were requested. Returns the exit status, or the error that
    /// has ended the command.
    fn conclude(
        &self,
        results: impl Iterator<Item = (Suite, serde_json::Value)>,
        refused: Option<Error>,
        is_as_expected: bool,
    ) -> Result<ExitCode, Error> {
        let (suites, reports): (Vec<Suite>, Vec<serde_json::Value>) = results.unzip();
        if interrupt::flow().is_break() {
            self.results.none_yet("the proof");
        } else {
            self.results.write("prove", || suites)?;
        }
        match reports.as_slice() {
            _ if !self.json => {}
            [report] => print_json(report)?,
            reports => print_json(&reports)?,
        }
        match refused {
            Some(error) => Err(error),
            None if interrupt::flow().is_break() => Ok(ExitCode::from(interrupt::STATUS)),
            None => Ok(ExitCode::from(u8::from(!is_as_expected))),
        }
    }

    /// Prints the machine that may answer anything in place of a component.
    fn show_stand_in(&self, found: &Found, component: &str) -> Result<(), Error> {
        let anything = format!("prove.components.{component:?}={{answers=\"anything\"}}");
        let set = [self.set.as_slice(), &[anything]].concat();
        let scenario = Scenario::load_for_proof(found, &set)?;
        let machine = scenario.components.get(component).and_then(|component| component.machine());
        print(machine.map_or("", |skill| skill.machine.file().text()))
    }

    fn limits(&self, proof: &Proof, stop: &'static AtomicBool) -> Limits {
        let defaults = &proof.scenario().file.prove;
        let memory = self.memory.map_or(defaults.memory_bytes, |memory_mb| memory_mb << 20);
        let threads = self.threads.or(defaults.threads).and_then(|threads| usize::try_from(threads).ok());
        Limits {
            memory: usize::try_from(memory).unwrap_or(usize::MAX),
            visits: self.states.unwrap_or(defaults.states),
            threads: threads.unwrap_or_else(batch::threads),
            order: self.order.into(),
            stop: Some(stop),
            ..Limits::default()
        }
    }

    fn explore(&self, proof: &Proof, question: &Question, found: &Found, limits: &Limits) -> Result<Finding, Error> {
        let began = moment();
        let mut shown = ProofProgress::new((!self.quiet).then_some(self.progress), &question.property);
        let answer = proof.prove(question, limits, &mut |round| shown.show(round));
        drop(shown);
        let answer = answer?;
        if let Some(folder) = self.promela.as_ref().filter(|_| interrupt::flow().is_continue()) {
            let monitor = proof.monitor(question);
            let model = explorer::promela(&answer.model, monitor, limits, &mut |_| ());
            let help = "`--memory` gives it more memory; a larger `execution.tick_s` makes times shorter in ticks";
            let model = model.map_err(|error| Error::refused(error.to_string(), help))?;
            diagnostics::write_whole(&model_file(folder, proof, question), model.text)?;
        }
        // The time includes the replay of the run, which is part of the answer, but not the simulation.
        let violation = Violation::of(proof, question, &answer)?;
        let seconds = began.elapsed().as_secs_f64();
        let physical = match &answer.exploration.outcome {
            Outcome::Violated(run) if self.replay => proof.with_physics(question, &answer, run, found)?,
            _ => None,
        };
        Ok(Finding { question: question.clone(), seconds, answer, violation, physical, written: None })
    }
}
