//! The plan: what each run of a campaign is, as a function of its number.

use std::path::Path;
use std::sync::Arc;

use diagnostics::{Problem, Spanned};
use scenarios::Complaints;
use scenarios::files::shipped_campaigns;
use scenarios::live::Live;
use scenarios::names::unknown;
use scenarios::scenario::{Found, Scenario, find};
use serde::Serialize;

use super::Shard;
use super::file::{CampaignFile, MAX_RUNS, Seeds};
use super::parameter::{Parameter, Value};
use super::sampling::{Dimension, Sampling};
use crate::Error;

/// A campaign, ready to be run: its file, its scenario, and what each run is.
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
    /// How the command line calls it, and its text.
    name: String,
    text: String,
    file: CampaignFile,
    /// The number of runs, where another one than the file's was asked for.
    asked: Option<u64>,
    found: Found,
    /// A fingerprint of all files on disk that the scenario is made of.
    files: String,
    /// A dimension for each parameter; none for a grid.
    dimensions: Vec<Dimension>,
    /// The scenario without what varies, whose files and map all runs share.
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
    pub values: Vec<Value>,
}

impl Plan {
    /// Loads a campaign and its scenario: a file, or one that comes with the program, by its name.
    ///
    /// # Errors
    /// Everything that is wrong with them; see [`parse`](Self::parse).
    pub fn load(path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let is_name = path.extension().is_none() && path.components().count() == 1 && !path.is_file();
        if is_name {
            let text = shipped_campaigns().find(|(shipped, _)| *shipped == name).map(|(_, text)| text);
            return Self::parse(&name, text.ok_or_else(|| no_campaign(&name))?);
        }
        let text = diagnostics::text_from_disk(path).map_err(|error| {
            let message = format!("cannot read the campaign {name}: {error}");
            let help = "a campaign is a TOML file that names a scenario and what varies";
            Error::refused(message, format!("{help}, or one of {}", campaign_names()))
        })?;
        Self::parse(&name, &text)
    }

    /// Reads a campaign's text; a scenario that it names by a path is looked for beside `name`.
    ///
    /// The scenario is loaded with the values that the parameters have at their ends and in the middle, and with all of
    /// those that are listed, one parameter after the other: what it would refuse in the middle of a campaign, it refuses
    /// now. Values that it takes each but not together may still be refused in a run.
    ///
    /// # Errors
    /// [`Error::Scenario`] with everything that is wrong.
    pub fn parse(name: &str, text: &str) -> Result<Self, Error> {
        let file = CampaignFile::parse(name, text).map_err(Error::bad_input)?;
        // All runs, and a campaign that goes on tomorrow, have to be of the same files.
        let mut found = scenario(name, &file)?;
        found.files = found.files.remembering();
        let set: Vec<String> = file.set.iter().map(|set| set.value.clone()).collect();
        let base = Arc::new(Scenario::load(&found, &set)?);
        let live = Live::new(Arc::clone(&base), file.seed, true)?;
        let properties = live.properties().map(str::to_owned).collect();
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
    /// If there are none, or more than its combinations allow for a grid, or than are possible.
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

    /// Refuses to shard a campaign with a goal.
    pub(super) fn check_shard(&self, shard: Shard) -> Result<(), Error> {
        if shard == Shard::ALL || self.file.goal.is_none() {
            return Ok(());
        }
        let help = "shards do not know of each other's results: leave out the `[goal]` and say `runs`";
        Err(Error::refused("a campaign that stops at a goal cannot be sharded", help))
    }

    /// How the command line calls the campaign.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The properties that every run watches.
    #[must_use]
    pub fn properties(&self) -> &[String] {
        &self.properties
    }

    /// The scenario without what varies.
    #[must_use]
    pub fn base(&self) -> &Arc<Scenario> {
        &self.base
    }

    /// What the command line adds to the campaign's name to repeat one of its runs: the number of runs, where it is not
    /// the file's.
    pub(super) fn asked(&self) -> Option<u64> {
        self.asked
    }

    /// A fingerprint of what the runs are: the texts of the campaign and its scenario, the number of runs, and all files
    /// on disk that the scenario is made of: its bases, map, places, tree, skills and properties. The files that come
    /// with the program are its version's.
    #[must_use]
    pub fn identity(&self) -> String {
        let mut hash = blake3::Hasher::new();
        for part in [&self.text, &self.found.text, &self.file.runs.to_string(), &self.files] {
            hash.update(&(part.len() as u64).to_le_bytes()).update(part.as_bytes());
        }
        hash.finalize().to_hex().to_string()
    }

    /// What the file says.
    #[must_use]
    pub fn file(&self) -> &CampaignFile {
        &self.file
    }

    /// The scenario that is varied.
    #[must_use]
    pub fn scenario(&self) -> &Found {
        &self.found
    }

    /// How many runs there are at most.
    #[must_use]
    pub fn runs(&self) -> u64 {
        self.file.runs
    }

    /// Run `k`: a function of plan and number, whatever ran before or runs elsewhere.
    ///
    /// # Panics
    /// If there is no such run.
    #[must_use]
    pub fn run(&self, k: u64) -> PlannedRun {
        assert!(k < self.file.runs, "there are only {} runs, and no run {k}", self.file.runs);
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

    /// The combination of run `k`: the last parameter changes fastest, and after the last combination comes the first
    /// again.
    fn grid_point(&self, k: u64) -> Vec<Value> {
        let mut rest = k;
        let mut values: Vec<Value> = Vec::with_capacity(self.file.parameters.len());
        for parameter in self.file.parameters.iter().rev() {
            let count = parameter.domain.count().expect("a grid's parameters were checked to be countable");
            values.push(parameter.domain.nth(rest % count).expect("a remainder is below the count"));
            rest /= count;
        }
        values.reverse();
        values
    }

    /// Tries what the scenario says to the parameters' values.
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
        Ok(complaints.check()?)
    }

    /// What the scenario does not take, once for each parameter. Parameters are varied around the first run; where the
    /// scenario refuses that already, each is tried alone, so that every one that is wrong is found.
    fn refusals(&self, first: &PlannedRun, set: &[String]) -> Vec<Problem> {
        let together = Scenario::load_like(&self.base, &self.found, &first.overrides(self)).err();
        let overrides = |place: usize, value: &Value| {
            if together.is_none() {
                let mut run = first.clone();
                run.values[place] = value.clone();
                return run.overrides(self);
            }
            let alone = format!("{}={value}", self.file.parameters[place].key.value);
            set.iter().cloned().chain([alone]).collect()
        };
        let refused = |(place, parameter): (usize, &Parameter)| {
            let refused = |value: Value| {
                let error = Scenario::load_like(&self.base, &self.found, &overrides(place, &value)).err()?;
                Some(refusal(&parameter.key, &value, &error))
            };
            parameter.domain.extremes().into_iter().find_map(refused)
        };
        let mut problems: Vec<Problem> = self.file.parameters.iter().enumerate().filter_map(refused).collect();
        if let (Some(error), true, Some(parameter)) = (together, problems.is_empty(), self.file.parameters.first()) {
            let span = &parameter.key.span;
            let message = format!("the scenario does not take the first run's values together: {}", error.reasons());
            problems.push(span.problem(message).with_label("this parameter and those after it"));
        }
        problems
    }
}

impl PlannedRun {
    /// What the scenario is loaded with for this run of `plan`, as `--set` takes it.
    #[must_use]
    pub fn overrides(&self, plan: &Plan) -> Vec<String> {
        let set = plan.file.set.iter().map(|set| set.value.clone());
        let varied = plan.file.parameters.iter().zip(&self.values);
        set.chain(varied.map(|(parameter, value)| format!("{}={value}", parameter.key.value))).collect()
    }
}

/// That no campaign of that name comes with the program, with the nearest name.
fn no_campaign(name: &str) -> Error {
    let meant = diagnostics::did_you_mean(name, shipped_campaigns().map(|(known, _)| known));
    let meant = meant.map_or_else(String::new, |meant| meant + " ");
    Error::refused(
        format!("there is no campaign `{name}`"),
        format!("{meant}There are {}, or the path of a file", campaign_names()),
    )
}

fn campaign_names() -> String {
    shipped_campaigns().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// A dimension for each parameter; none for a grid.
fn dimensions(file: &CampaignFile) -> Vec<Dimension> {
    let dimension = |(place, parameter): (usize, &Parameter)| {
        Dimension::new(file.sampling, place, &parameter.key.value, file.seed, file.runs)
    };
    file.parameters.iter().enumerate().filter_map(dimension).collect()
}

/// The scenario that a campaign names: beside its file, or one that comes with the program.
fn scenario(name: &str, file: &CampaignFile) -> Result<Found, Error> {
    let beside = Path::new(name).parent().unwrap_or(Path::new("")).join(&file.scenario.value);
    let found =
        if beside.is_file() { find::find(&beside.display().to_string()) } else { find::find(&file.scenario.value) };
    found.map_err(|error| {
        let problem = file.scenario.span.problem(error.to_string()).with_label("this scenario");
        let help = "a scenario is looked for beside the campaign's file, and then by its name (`steward list`)";
        Error::bad_input(problem.with_help(help))
    })
}

/// That the scenario does not take a value, said at the parameter.
fn refusal(key: &Spanned<String>, value: &Value, error: &scenarios::Error) -> Problem {
    let problem = key.span.problem(format!("the scenario does not take `{}={value}`: {}", key.value, error.reasons()));
    problem.with_label("this parameter")
}

#[cfg(test)]
mod tests;
