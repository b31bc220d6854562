//! The plan: each run of a campaign as a function of its number.

use std::path::Path;
use std::sync::Arc;

use diagnostics::document::Document;
use diagnostics::{Disk, FileProblems, Problem, Spanned, did_you_mean};
use runs::Run;
use scenarios::Complaints;
use scenarios::files::{shipped_campaigns, shipped_scenarios};
use scenarios::names::unknown;
use scenarios::scenario::{Found, Scenario, find};
use serde::Serialize;

use super::Shard;
use super::file::{CampaignFile, MAX_RUNS, Seeds};
use super::parameter::{Parameter, ParameterValue};
use super::sampling::{Dimension, Sampling};
use crate::Error;

/// A campaign, ready to run: its file, its scenario, and its runs.
///
/// ```
/// use campaigns::Plan;
///
/// let text = r#"
///     scenario = "errand"
///     sampling = "sobol"
///     runs = 1000
///     [[parameters]]
///     key = "battery.initial_pct"
///     from = 31
///     to = 80
/// "#;
/// let plan = Plan::parse("drain.toml", text)?;
/// let run = plan.run(7);
/// assert_eq!(run.seed, 8);
/// assert!(run.overrides(&plan)[0].starts_with("battery.initial_pct="));
/// assert_eq!(plan.run(7), run, "nothing but plan and number decides");
/// # Ok::<(), campaigns::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its name on the command line, and its text.
    name: String,
    text: String,
    file: CampaignFile,
    /// The requested number of runs, if it differs from the file's.
    pub(super) asked: Option<u64>,
    found: Found,
    /// A fingerprint of all files on disk that belong to the scenario.
    files: String,
    /// One dimension per parameter; none for a grid.
    dimensions: Vec<Dimension>,
    /// The scenario without the parameters' values; all runs share its files and map.
    base: Arc<Scenario>,
    /// The properties that the scenario watches.
    properties: Vec<String>,
}

/// One run of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedRun {
    /// Its number, from 0.
    pub k: u64,
    /// Its root seed.
    pub seed: u64,
    /// The parameters' values, in the order of the file.
    pub values: Vec<ParameterValue>,
}

impl Plan {
    /// Loads a campaign and its scenario, from a file, or by name if the campaign comes with the program.
    ///
    /// # Errors
    /// Everything that is wrong with them; see [`parse`](Self::parse).
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::load_on(&Disk::default(), path)
    }

    /// Loads a campaign like [`load`](Self::load), from this disk.
    ///
    /// # Errors
    /// As for [`load`](Self::load).
    pub fn load_on(disk: &Disk, path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let is_name = path.extension().is_none() && path.components().count() == 1 && !disk.is_file(path);
        let in_sources = name.strip_prefix("scenarios/campaigns/").and_then(|file| file.strip_suffix(".toml"));
        let shipped = if is_name { Some(&*name) } else { in_sources.filter(|_| !disk.exists(path)) };
        let shipped = shipped.and_then(|wanted| shipped_campaigns().find(|(known, _)| *known == wanted));
        match shipped {
            Some((name, text)) => return Self::parse_on(disk, name, text),
            None if is_name => return Err(no_campaign(&name)),
            None => {}
        }
        let text = disk.read_text(path).map_err(|error| {
            let message = format!("cannot read the campaign {name}: {error}");
            let help = "a campaign is a TOML file that names a scenario and the parameters to vary";
            Error::refused(message, format!("{help}, or one of {}", campaign_names()))
        })?;
        let text = if find::is_model(path, &text) { of_model(path) } else { text };
        Self::parse_on(disk, &name, &text)
    }

    /// Reads a campaign's text. A scenario given as a path is looked up relative to `name`.
    ///
    /// The scenario is loaded with the values at the ends and in the middle of each parameter's domain, and with all
    /// listed values, one parameter after the other. So a value that it would reject in the middle of a campaign is
    /// rejected now. Values that it accepts individually but not together may still be rejected in a run.
    ///
    /// # Errors
    /// [`Error::Scenario`] with everything that is wrong.
    pub fn parse(name: &str, text: &str) -> Result<Self, Error> {
        Self::parse_on(&Disk::default(), name, text)
    }

    fn parse_on(disk: &Disk, name: &str, text: &str) -> Result<Self, Error> {
        let mut complaints = Complaints::default();
        let file = complaints.note(CampaignFile::parse(name, text));
        // The scenario is looked up even if something else is wrong.
        let document = Document::parse_toml(name, text).ok();
        let named = document.as_ref().and_then(|document| document.peek_text("scenario"));
        let found = named.and_then(|named| complaints.note(scenario(disk, name, &named)));
        complaints.check()?;
        let (Some(file), Some(mut found)) = (file, found) else { unreachable!("what is missing has been reported") };
        // All runs must use the same files, even if the campaign resumes later.
        found.files = found.files.remembering();
        let set: Vec<String> = file.set.iter().map(|set| set.value.clone()).collect();
        let base = Scenario::load(&found, &set).map_err(|error| refused_settings(&found, &file.set, error))?;
        let base = Arc::new(base);
        let run = Run::prepare(Arc::clone(&base), file.seed, true)?;
        let properties = run.properties().map(str::to_owned).collect();
        let (name, text, dimensions) = (name.to_owned(), text.to_owned(), dimensions(&file));
        let mut plan =
            Self { name, text, file, asked: None, found, files: String::new(), dimensions, base, properties };
        plan.check(&set)?;
        plan.files = plan.found.files.fingerprint();
        Ok(plan)
    }

    /// The same campaign with another number of runs.
    ///
    /// # Errors
    /// If the number is zero, or exceeds the combinations of a grid or the maximum.
    pub fn with_runs(mut self, runs: u64) -> Result<Self, Error> {
        let most = if self.file.sampling == Sampling::Grid { self.file.runs } else { MAX_RUNS };
        if !(1..=most).contains(&runs) {
            let message = format!("the campaign cannot have {runs} runs");
            return Err(Error::refused(message, format!("it can have 1 to {most}")));
        }
        self.asked = (runs != self.file.runs).then_some(runs).or(self.asked);
        self.file.runs = runs;
        self.dimensions = dimensions(&self.file);
        Ok(self)
    }

    /// Rejects sharding of a campaign with a goal.
    pub(super) fn check_shard(&self, shard: Shard) -> Result<(), Error> {
        if shard == Shard::ALL || self.file.goal.is_none() {
            return Ok(());
        }
        let help = "shards do not know each other's results: leave out the `[goal]` and set `runs`";
        Err(Error::refused("a campaign that stops at a goal cannot be sharded", help))
    }

    /// The campaign's name on the command line.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The properties that every run watches.
    #[must_use]
    pub fn properties(&self) -> &[String] {
        &self.properties
    }

    /// The scenario without the parameters' values.
    #[must_use]
    pub fn base(&self) -> &Arc<Scenario> {
        &self.base
    }

    /// A fingerprint of the runs. It covers the texts of the campaign and its scenario, the number of runs, and all
    /// files on disk that belong to the scenario: its bases, map, places, tree, skills and properties. Files that come
    /// with the program are identified by its version.
    #[must_use]
    pub fn identity(&self) -> String {
        let mut hash = blake3::Hasher::new();
        for part in [&self.text, &self.found.text, &self.file.runs.to_string(), &self.files] {
            hash.update(&(part.len() as u64).to_le_bytes()).update(part.as_bytes());
        }
        hash.finalize().to_hex().to_string()
    }

    /// The contents of the file.
    #[must_use]
    pub fn file(&self) -> &CampaignFile {
        &self.file
    }

    /// The scenario that is varied.
    #[must_use]
    pub fn scenario(&self) -> &Found {
        &self.found
    }

    /// The maximum number of runs.
    #[must_use]
    pub fn runs(&self) -> u64 {
        self.file.runs
    }

    /// Run `k`: a function of the plan and the number, independent of all other runs.
    ///
    /// # Panics
    /// If there is no such run.
    #[must_use]
    pub fn run(&self, k: u64) -> PlannedRun {
        assert!(k < self.file.runs, "there is no run {k}: there are only {} runs", self.file.runs);
        let seed = match self.file.seeds {
            Seeds::Each => self.file.seed.wrapping_add(k),
            Seeds::Same => self.file.seed,
        };
        let values = match self.file.sampling {
            Sampling::Grid => self.grid_point(k),
            _ => {
                let placed = self.file.parameters.iter().zip(&self.dimensions);
                placed.map(|(parameter, dimension)| parameter.domain.at(dimension.at(k))).collect()
            }
        };
        PlannedRun { k, seed, values }
    }

    /// The combination of run `k`: the last parameter changes fastest, and after the last combination the first follows
    /// again.
    fn grid_point(&self, k: u64) -> Vec<ParameterValue> {
        let mut rest = k;
        let mut values: Vec<ParameterValue> = Vec::with_capacity(self.file.parameters.len());
        for parameter in self.file.parameters.iter().rev() {
            let count = parameter.domain.count().expect("a grid's parameters were checked to be countable");
            values.push(parameter.domain.nth(rest % count).expect("a remainder is below the count"));
            rest /= count;
        }
        values.reverse();
        values
    }

    /// Checks that the scenario accepts the parameters' values.
    fn check(&self, set: &[String]) -> Result<(), Error> {
        let mut complaints = Complaints::default();
        for problem in self.refusals(&self.run(0), set) {
            complaints.push(problem);
        }
        let names = self.properties.iter().map(String::as_str).chain(["expectation"]);
        let asked = self.file.goal.iter().map(|goal| &goal.of).chain(self.file.model.iter().map(|model| &model.of));
        for of in asked.filter(|of| !names.clone().any(|name| name == of.value)) {
            complaints.push(unknown("property", of, names.clone()));
        }
        for measure in self.file.measures.iter().filter(|_| self.base.premises.is_none()) {
            let problem =
                measure.span.problem(format!("there is no robot for which to measure `{}`", measure.value.name()));
            let help = "the scenario has no map, so it has no robot";
            complaints.push(problem.with_label("this measure").with_help(help));
        }
        Ok(complaints.check()?)
    }

    /// The values that the scenario rejects, once per parameter. Parameters are varied around the first run; if the
    /// scenario rejects even that run, each parameter is tried alone, so that every wrong one is found.
    fn refusals(&self, first: &PlannedRun, set: &[String]) -> Vec<Problem> {
        // If the first run is accepted, the others differ from it in one value each. If it is not, each value is set in
        // the scenario as it is, since the wrong one would also spoil the runs that vary the others.
        let together = Scenario::load(&self.found, &first.overrides(self)).err();
        let overrides = |place: usize, value: &ParameterValue| {
            if together.is_none() {
                let mut run = first.clone();
                run.values[place] = value.clone();
                return run.overrides(self);
            }
            let alone = format!("{}={value}", self.file.parameters[place].key.value);
            set.iter().cloned().chain([alone]).collect()
        };
        let refused = |(place, parameter): (usize, &Parameter)| {
            let refused = |value: ParameterValue| {
                let error = Scenario::load(&self.found, &overrides(place, &value)).err()?;
                Some(refusal(&parameter.key, &value, &error))
            };
            parameter.domain.extremes().into_iter().find_map(refused)
        };
        let mut problems: Vec<Problem> = self.file.parameters.iter().enumerate().filter_map(refused).collect();
        if let (Some(error), true, Some(parameter)) = (together, problems.is_empty(), self.file.parameters.first()) {
            let span = &parameter.key.span;
            let message =
                format!("the scenario does not accept the combination of the first run's values: {}", error.reasons());
            problems.push(span.problem(message).with_label("this parameter and the following ones"));
        }
        problems
    }
}

impl PlannedRun {
    /// The overrides with which the scenario is loaded for this run of `plan`, in the syntax of `--set`.
    #[must_use]
    pub fn overrides(&self, plan: &Plan) -> Vec<String> {
        let set = plan.file.set.iter().map(|set| set.value.clone());
        let varied = plan.file.parameters.iter().zip(&self.values);
        set.chain(varied.map(|(parameter, value)| format!("{}={value}", parameter.key.value))).collect()
    }
}

/// The error that no campaign with this name comes with the program, with the most similar name.
fn no_campaign(name: &str) -> Error {
    let meant = diagnostics::did_you_mean(name, shipped_campaigns().map(|(known, _)| known));
    let meant = meant.map_or_else(String::new, |meant| meant + " ");
    Error::refused(
        format!("there is no campaign `{name}`"),
        format!("{meant}available are {}; or give the path of a file", campaign_names()),
    )
}

fn campaign_names() -> String {
    shipped_campaigns().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// The campaign that estimates the probabilities of a RoAML model: run k has the seed k, and ends when all properties
/// have their verdicts.
fn of_model(path: &Path) -> String {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    // JSON and TOML write strings in the same way.
    let file = serde_json::Value::from(file);
    format!("scenario = {file}\nruns = 1000\nseed = 0\nset = [\"stop.when_settled=true\"]\n")
}

/// One dimension per parameter; none for a grid.
fn dimensions(file: &CampaignFile) -> Vec<Dimension> {
    let dimension = |(place, parameter): (usize, &Parameter)| {
        Dimension::new(file.sampling, place, &parameter.key.value, file.seed, file.runs)
    };
    file.parameters.iter().enumerate().filter_map(dimension).collect()
}

/// The scenario that a campaign names: a file relative to the campaign's, or one that comes with the program.
fn scenario(disk: &Disk, name: &str, written: &Spanned<&str>) -> Result<Found, Problem> {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let beside = folder.join(written.value);
    let beside = if disk.is_file(&beside) { beside.display().to_string() } else { written.value.to_owned() };
    let found = find::find_on(disk, &beside);
    let with_files = |found: Found| Found { files: found.files.with_assignments_in(folder), ..found };
    found.map(with_files).map_err(|error| {
        let problem = written.span.problem(error.to_string()).with_label("this scenario");
        let place = "a scenario is looked up relative to the campaign's file, and then by its name (`steward list`)";
        let meant = did_you_mean(written.value, shipped_scenarios());
        problem.with_help(meant.unwrap_or_else(|| place.to_owned()))
    })
}

/// The error of a scenario with these settings, located at those that it does not accept beside the others; without
/// any, its own.
fn refused_settings(found: &Found, set: &[Spanned<String>], error: scenarios::Error) -> scenarios::Error {
    if Scenario::load(found, &[]).is_err() {
        return error;
    }
    let (mut accepted, mut problems) = (Vec::new(), Vec::new());
    for set in set {
        accepted.push(set.value.clone());
        if let Err(error) = Scenario::load(found, &accepted) {
            accepted.pop();
            let problem =
                set.span.problem(format!("the scenario does not accept `{}`: {}", set.value, error.reasons()));
            problems.push(problem.with_label("this setting"));
        }
    }
    FileProblems::none_of(problems).map_or_else(scenarios::Error::bad_input, |()| error)
}

/// The error that the scenario does not accept a value, located at the parameter.
fn refusal(key: &Spanned<String>, value: &ParameterValue, error: &scenarios::Error) -> Problem {
    let problem =
        key.span.problem(format!("the scenario does not accept `{}={value}`: {}", key.value, error.reasons()));
    problem.with_label("this parameter")
}

#[cfg(test)]
mod tests;
