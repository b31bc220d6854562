//! Results in files for CI systems: `--results FILE`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bt::Tree;
use campaigns::Error;
use campaigns::findings::place;
pub(crate) use campaigns::findings::{findings, findings_of, refused};
use clap::Args;
use judging::node_places;
use monitors::Property;
use recording::{Header, Origin};
use reports::file_place::FilePlace;
use reports::results::{FileFinding, Results, Suite, WrittenPlaces};
use reports::{ResultsFile, ResultsFormat};
use runs::topology;
use scenarios::files::shipped_campaigns;
pub(crate) use scenarios::scenario::find::on_disk;
use scenarios::scenario::{Monitoring, Scenario, find};

use crate::output::{complain, complain_of, note};

/// Where the results go besides the terminal.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ResultsArgs {
    /// Writes the results for CI systems: `FILE.xml` as JUnit XML, `FILE.sarif` as SARIF 2.1.0, `FILE.md` as a summary
    /// in Markdown; may be given more than once
    #[arg(long, value_name = "FILE", value_parser = results_file)]
    results: Vec<ResultsFile>,
    /// The older spelling of `--results` for JUnit XML
    #[arg(long, value_name = "FILE", hide = true, value_parser = junit_file)]
    junit: Option<ResultsFile>,
}

fn results_file(text: &str) -> Result<ResultsFile, &'static str> {
    ResultsFile::of_name(text)
        .ok_or("the name determines the format: it ends in .xml (JUnit), .sarif (SARIF) or .md (Markdown)")
        .and_then(free)
}

fn junit_file(text: &str) -> Result<ResultsFile, &'static str> {
    free(ResultsFile::new(PathBuf::from(text), ResultsFormat::Junit))
}

/// Refuses a file that steward did not write, or that cannot be written. As a part of the command line, it is refused
/// before anything runs.
fn free(file: ResultsFile) -> Result<ResultsFile, &'static str> {
    let taken = "it exists and contains no results of steward; name another file, or remove it first";
    if file.is_impossible() {
        return Err("there can be no such file: it is a folder, or below a file");
    }
    if file.is_free() { Ok(file) } else { Err(taken) }
}

impl ResultsArgs {
    /// Whether there is a file for them.
    pub(crate) fn are_wanted(&self) -> bool {
        self.files().next().is_some()
    }

    /// Whether one of them contains the stories of violations.
    pub(crate) fn have_stories(&self) -> bool {
        self.files().any(ResultsFile::has_stories)
    }

    fn files(&self) -> impl Iterator<Item = &ResultsFile> {
        self.results.iter().chain(&self.junit)
    }

    /// Removes earlier results, which could be taken for those of now, before work begins.
    pub(crate) fn begin(&self) -> Result<(), Error> {
        Ok(self.files().try_for_each(ResultsFile::remove)?)
    }

    /// Writes the results of a command, if they are wanted.
    pub(crate) fn write(&self, command: &'static str, suites: impl FnOnce() -> Vec<Suite>) -> Result<(), Error> {
        if !self.are_wanted() {
            return Ok(());
        }
        let results = Results::new(command, suites());
        // One that cannot be written keeps no other from being written.
        let mut outcome = Ok(());
        for file in self.files() {
            match file.write(&results) {
                Ok(left_out) => {
                    left_out.iter().for_each(|words| note(&format!("{}: {words}", file.path().display())));
                }
                Err(error) => outcome = outcome.and(Err(error)),
            }
        }
        Ok(outcome?)
    }

    /// Notes that there are none, because it was interrupted.
    pub(crate) fn none_yet(&self, what: &str) {
        self.files()
            .for_each(|file| note(&format!("{} was not written: {what} was interrupted", file.path().display())));
    }

    /// What was read of each argument, if all could be: otherwise, the problems of each are reported under its name,
    /// with places in its own files, and written.
    pub(crate) fn all_or_refused<T, E: Into<Error>>(
        &self,
        command: &'static str,
        read: impl IntoIterator<Item = (String, Result<T, E>)>,
    ) -> Result<Option<Vec<T>>, Error> {
        let (mut all, mut errors) = (Vec::new(), Vec::new());
        for (argument, result) in read {
            match result {
                Ok(one) => all.push(one),
                Err(error) => errors.push((argument, error.into())),
            }
        }
        if errors.is_empty() {
            return Ok(Some(all));
        }
        if all.is_empty() && errors.len() == 1 {
            let (argument, error) = errors.remove(0);
            return self.or_refused(command, &[argument], Err(error));
        }
        for (argument, error) in &errors {
            complain_of(format!("{argument}:\n"));
            complain(error);
        }
        let suite = |(argument, error): &(String, Error)| refused(argument, error, on_disk(&[argument]));
        self.write(command, || errors.iter().map(suite).collect())?;
        Ok(None)
    }

    /// The result of reading what the arguments name. An error is also written: it is the only result.
    pub(crate) fn or_refused<T, E: Into<Error>>(
        &self,
        command: &'static str,
        subjects: &[String],
        result: Result<T, E>,
    ) -> Result<T, Error> {
        result.map_err(Into::into).map_err(|error: Error| {
            let suite = || refused(&subjects.join(" "), &error, on_disk(subjects));
            match self.write(command, || vec![suite()]) {
                // The input is wrong, perhaps because it is the file for the results.
                Err(unwritten) if unwritten.exit_status() != error.exit_status() => unwritten,
                _ => error,
            }
        })
    }
}

/// The file that an argument names, as a whole: on disk, or one that comes with the program. A file that is missing is
/// no place.
pub(crate) fn file_of(argument: &str) -> Option<FilePlace> {
    let is_campaign = || shipped_campaigns().any(|(name, _)| name == argument);
    let campaign = || is_campaign().then(|| format!("scenarios/campaigns/{argument}.toml"));
    let shipped = find::shipped(argument).map(str::to_owned).or_else(campaign);
    shipped.or_else(|| Path::new(argument).exists().then(|| argument.to_owned())).map(FilePlace::whole)
}

/// Where the parts of the scenario of an earlier run are written now, as far as its texts are still the same, and a
/// note for each that is not. `judged` are the properties of that run.
pub(crate) fn places_now(run: &Header, judged: &[Property]) -> (WrittenPlaces, Vec<String>) {
    let Origin { argument, text, overrides, .. } = &run.origin;
    let Ok(scenario) = find::find(argument).and_then(|found| Scenario::load(&found, overrides)) else {
        return Default::default();
    };
    let changed = |what: &str| format!("{what} has changed since, so nothing shows where it is written");
    // An event log has no text of its scenario.
    if !text.is_empty() && *text != scenario.origin.text {
        return (WrittenPlaces::default(), vec![changed(argument)]);
    }
    let mut places = places(&scenario).with_paths(on_disk(&[argument]));
    let records = monitoring(&scenario).map(|monitoring| monitoring.records());
    let differs = |property: &&Property| {
        let mut now = records.iter().flat_map(|records| records.iter());
        property.place.is_none() && now.any(|now| now.name == property.name && now.property != property.formula)
    };
    let names: Vec<&str> = judged.iter().filter(differs).map(|property| property.name.as_str()).collect();
    places.properties.retain(|name, _| !names.contains(&name.as_str()));
    let tree = scenario.tree().filter(|tree| !text.is_empty() && !was_in(tree, run));
    if let Some(tree) = tree {
        places.processes.remove(recording::TREE);
        tree.leaves().for_each(|leaf| _ = places.processes.remove(leaf.process()));
    }
    let tree = tree.map(|tree| tree.source().name());
    (places, names.into_iter().chain(tree).map(changed).collect())
}

/// Whether this was the tree of an earlier run.
fn was_in(tree: &Tree, run: &Header) -> bool {
    let nodes = tree.nodes().iter().map(recording::Node::from);
    nodes.eq(run.tree.iter().cloned()) && run.tree_xml.as_ref().is_none_or(|xml| *xml == tree.to_instance_xml())
}

/// The properties of a scenario with their monitors, if they can be loaded.
fn monitoring(scenario: &Scenario) -> Option<Arc<Monitoring>> {
    topology(scenario).and_then(|topology| scenario.monitoring(&topology)).ok()
}

/// Where the parts of a scenario are written.
pub(crate) fn places(scenario: &Scenario) -> WrittenPlaces {
    let argument = scenario.origin.argument.as_str();
    let file = find::shipped(argument).unwrap_or(argument);
    let monitoring = monitoring(scenario);
    let watched = monitoring.iter().flat_map(|monitoring| monitoring.monitors());
    let properties = watched.filter_map(|(watched, _)| Some((watched.name.clone(), place(&watched.place)?)));
    let machines = scenario
        .machine_processes()
        .map(|(name, skill)| (name.to_owned(), FilePlace::whole(skill.machine.file().name())));
    let leaves = scenario.tree().into_iter().flat_map(|tree| {
        let places = tree.nodes().iter().zip(node_places(tree));
        places.filter(|(node, _)| node.kind().is_leaf()).map(|(leaf, place)| (leaf.process().to_owned(), place))
    });
    let tree = scenario.tree().map(|tree| (recording::TREE.to_owned(), FilePlace::whole(tree.source().name())));
    WrittenPlaces {
        file: Some(FilePlace::whole(file)),
        properties: properties.collect(),
        // A leaf is more specific than the machine that many leaves may run.
        processes: machines.chain(leaves).chain(tree).collect(),
    }
}

/// The warnings about a scenario and its files.
pub(crate) fn warnings(scenario: &Scenario) -> Vec<FileFinding> {
    let monitoring = monitoring(scenario);
    let of_properties =
        monitoring.iter().flat_map(|monitoring| monitoring.warnings().iter().flat_map(|it| findings(it)));
    scenario.concerns().iter().flat_map(|concern| findings(&**concern)).chain(of_properties).collect()
}
