//! Turns journals into results, dataset and summary, for one campaign or its merged shards.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use diagnostics::{Staging, seconds};
use monitors::Outcome;

use super::dataset::DatasetWriter;
use super::journal::{self, DATASET, Header, JOURNAL, Journal, JournalReader, Layout, PAGE, SUMMARY, TimingReader};
use super::page::Survey;
use super::shard::Shard;
use super::statistics::{Confidence, Count};
use super::summary::{Estimate, Frequency, GoalReport, Named, Outcomes, Summary, Unmet, command};
use super::{Plan, RunOutcome, RunRecord, page};
use crate::Error;

/// How many runs of each kind the summary lists.
const NAMED: usize = 10;

/// Makes dataset, summary and page from a journal with all runs of a campaign.
///
/// # Errors
/// [`Error::Scenario`] if the journal is damaged, or if the results cannot be written; existing results then stay
/// unchanged.
pub(super) fn finish(journal: &Journal, goal: Option<GoalReport>) -> Result<Summary, Error> {
    let folder = &journal.folder;
    let mut records = journal.reader()?;
    let layout = records.header.layout.clone();
    let path = folder.join(DATASET);
    let failed = |source| Error::unwritten(&path, source);
    let mut dataset = DatasetWriter::begin(&path, &layout)?;
    let mut tally = Tally::new(&layout);
    while let Some(record) = records.next()? {
        tally.add(&record);
        dataset.push(record).map_err(failed)?;
    }
    let dataset = dataset.finish().map_err(failed)?;
    let survey = page::survey(&layout, || journal.reader())?;
    let summary = tally.summary(&layout, goal, &survey);
    let page = page::page(&summary, &layout, &survey);
    let text = serde_json::to_string_pretty(&summary).expect("a summary is always JSON") + "\n";
    let staging = Staging::begin(folder)?;
    staging.write(SUMMARY, text)?;
    staging.write(PAGE, page)?;
    staging.publish(&[SUMMARY, PAGE])?;
    dataset.finish()?;
    Ok(summary)
}

/// Removes what any campaign wrote to `folder`, and nothing else, before a shard of `plan` is run there.
///
/// # Errors
/// [`Error::Scenario`] if [`run`](super::run) would reject the shard, if another program is writing there, or if the
/// journal there does not belong to a campaign or cannot be written.
pub fn start_over(plan: &Plan, shard: Shard, folder: &Path) -> Result<(), Error> {
    plan.check_shard(shard)?;
    journal::start_over(folder)
}

/// The shard folders at a path: the path itself, or all folders in it.
fn shard_folders(path: &PathBuf) -> Vec<PathBuf> {
    let has_journal = |folder: &PathBuf| folder.join(JOURNAL).is_file();
    let inside = std::fs::read_dir(path).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let is_shard = |folder: &PathBuf| {
        folder.file_name().is_some_and(|name| name.to_string_lossy().starts_with("shard-")) && has_journal(folder)
    };
    let mut shards: Vec<PathBuf> = if has_journal(path) { Vec::new() } else { inside.filter(is_shard).collect() };
    shards.sort_unstable();
    if shards.is_empty() { vec![path.clone()] } else { shards }
}

/// Merges the shards of a campaign: a journal in `out`, and then the results. Each of `shards` is the folder of one
/// shard, or a folder with several. An interrupted merge resumes.
///
/// # Errors
/// [`Error::Scenario`] if the shards do not all belong to one campaign or are incomplete, or if `out` already has
/// results or another campaign's journal, or cannot be written.
pub fn merge(shards: &[PathBuf], out: &Path) -> Result<Summary, Error> {
    let shards = &shards.iter().flat_map(shard_folders).collect::<Vec<_>>();
    let mut readers = shards.iter().map(|folder| JournalReader::open(folder)).collect::<Result<Vec<_>, _>>()?;
    let header = whole(shards, &readers)?;
    if out.join(DATASET).exists() {
        let message = format!("{} already has results", out.display());
        return Err(Error::refused(message, "choose a new folder for the merged results"));
    }
    // Everything is read once before anything is written, so that an incomplete merge leaves nothing behind.
    let mut complete = shards.iter().map(|folder| JournalReader::open(folder)).collect::<Result<Vec<_>, _>>()?;
    complete.sort_by_key(|reader| reader.header.shard.index);
    in_turn(&header, complete, |_| Ok(()))?;
    let mut timings: BTreeMap<u64, TimingReader> = BTreeMap::new();
    for (folder, reader) in shards.iter().zip(&readers) {
        timings.extend(TimingReader::open(folder).map(|timing| (reader.header.shard.index, timing)));
    }
    readers.sort_by_key(|reader| reader.header.shard.index);
    let mut done = 0;
    let count = |_| {
        done += 1;
        Ok(())
    };
    let mut journal = Journal::open(out, &header, count)?;
    let of = readers.len() as u64;
    in_turn(&header, readers, |record| {
        if record.k < done {
            return Ok(());
        }
        let wall_time_s = timings.get_mut(&(record.k % of)).and_then(|timing| timing.of(record.k));
        journal.append(&record, wall_time_s)
    })?;
    finish(&journal, None)
}

/// The common header of all shards, if they belong together.
fn whole(folders: &[PathBuf], readers: &[JournalReader]) -> Result<Header, Error> {
    let Some(first) = readers.first().map(|reader| &reader.header) else {
        return Err(Error::refused("there are no shards", "give the folders to which the shards were written"));
    };
    for (folder, reader) in folders.iter().zip(readers) {
        first.with_shard(reader.header.shard).check(&reader.header, folder)?;
        if reader.header.shard.of != first.shard.of {
            let message = format!(
                "{} is one of {} shards, but {} is one of {}",
                folders[0].display(),
                first.shard.of,
                folder.display(),
                reader.header.shard.of
            );
            return Err(Error::refused(message, "merge only shards of one campaign with the same number of shards"));
        }
    }
    // Sorted, so that a shard that is missing and one that is present twice are both found by one comparison.
    let mut there: Vec<u64> = readers.iter().map(|reader| reader.header.shard.index).collect();
    there.sort_unstable();
    if there != (0..first.shard.of).collect::<Vec<_>>() {
        let there: Vec<String> = there.iter().map(u64::to_string).collect();
        let message =
            format!("shards 0 to {} are needed, but the folders contain {}", first.shard.of - 1, there.join(", "));
        return Err(Error::refused(message, "each shard must be present exactly once"));
    }
    Ok(first.with_shard(Shard::ALL))
}

/// Passes on the runs of all shards, each of which is ordered, in the order of the runs.
fn in_turn(
    header: &Header,
    mut readers: Vec<JournalReader>,
    mut take: impl FnMut(RunRecord) -> Result<(), Error>,
) -> Result<(), Error> {
    let of = readers.len() as u64;
    for k in 0..header.runs {
        let record = readers[(k % of) as usize].next()?.filter(|record| record.k == k).ok_or_else(|| {
            let message = format!("shard {}/{of} is not complete: run {k} is missing", k % of);
            Error::refused(message, "run the same command again: it resumes where it stopped")
        })?;
        take(record)?;
    }
    Ok(())
}

/// Counts over the runs.
struct Tally {
    outcomes: Outcomes,
    properties: Vec<Count>,
    /// All violations of each property.
    violations: Vec<u64>,
    /// In how many runs each property was inconclusive.
    inconclusive: Vec<u64>,
    /// In how many runs each property was satisfied vacuously.
    vacuous: Vec<u64>,
    /// The simulated time of the runs that did not fail.
    simulated: Duration,
    expectation: Count,
    /// In how many runs an expectation of the scenario was not met.
    unmet: BTreeMap<String, u64>,
    failures: Vec<(u64, Option<String>)>,
    unexpected: Vec<(u64, Option<String>)>,
}

impl Tally {
    fn new(layout: &Layout) -> Self {
        let properties = vec![Count::default(); layout.properties.len()];
        let (failures, unexpected, unmet) = (Vec::new(), Vec::new(), BTreeMap::new());
        Self {
            outcomes: Outcomes::default(),
            violations: vec![0; properties.len()],
            inconclusive: vec![0; properties.len()],
            vacuous: vec![0; properties.len()],
            properties,
            simulated: Duration::ZERO,
            expectation: Count::default(),
            unmet,
            failures,
            unexpected,
        }
    }

    fn add(&mut self, record: &RunRecord) {
        self.expectation.push(record.unexpected());
        for (property, count) in self.properties.iter_mut().enumerate() {
            if let Some(violated) = record.violated(property) {
                count.push(violated);
            }
        }
        if let Some(facts) = &record.facts {
            self.simulated += Duration::from_secs_f64(facts.sim_time_s);
            self.violations.iter_mut().zip(&facts.monitors).for_each(|(sum, monitor)| *sum += monitor.violations);
            for (sum, monitor) in self.inconclusive.iter_mut().zip(&facts.monitors) {
                *sum += u64::from(monitor.verdict == Outcome::Inconclusive);
            }
            let vacuous = self.vacuous.iter_mut().zip(&facts.monitors);
            vacuous.for_each(|(sum, monitor)| *sum += u64::from(monitor.vacuous));
        }
        for expected in &record.unmet {
            *self.unmet.entry(expected.clone()).or_default() += 1;
        }
        // A million runs may fail: only the first of them are named.
        let (named, why) = match record.outcome {
            RunOutcome::AsExpected => {
                self.outcomes.as_expected += 1;
                return;
            }
            RunOutcome::NotAsExpected => {
                self.outcomes.not_as_expected += 1;
                (&mut self.unexpected, Some(format!("expected {}", record.unmet.join("; "))))
            }
            RunOutcome::Failed => {
                self.outcomes.failed += 1;
                (&mut self.failures, record.failure.clone())
            }
        };
        if named.len() < NAMED {
            named.push((record.k, why));
        }
    }

    fn summary(self, layout: &Layout, goal: Option<GoalReport>, survey: &Survey) -> Summary {
        // These intervals assume a number of runs that was fixed in advance. After a goal, the interval that allows for
        // stopping is in `goal`.
        let estimate = |of: &str, count: Count| Estimate {
            of: of.to_owned(),
            count,
            rate: count.rate(),
            interval: count.interval(Confidence::OF_RESULTS),
            violations: None,
            inconclusive: None,
            inconclusive_rate: None,
            inconclusive_interval: None,
            vacuous: None,
        };
        let hours = seconds(self.simulated) / 3600.0;
        let of_property = |(index, name): (usize, &String)| {
            let count = self.properties[index];
            let open = Count::new(self.inconclusive[index], count.runs());
            Estimate {
                violations: Some(Frequency::of(self.violations[index], count.runs(), hours)),
                inconclusive: Some(open.happened()),
                inconclusive_rate: open.rate(),
                inconclusive_interval: Some(open.interval(Confidence::OF_RESULTS)),
                vacuous: Some(self.vacuous[index]),
                ..estimate(name, count)
            }
        };
        let again = layout.again();
        let named = |runs: Vec<(u64, Option<String>)>| {
            runs.into_iter().map(|(k, why)| Named { k, why, command: command(&again, k) }).collect()
        };
        let mut unmet: Vec<Unmet> = self.unmet.into_iter().map(|(expected, runs)| Unmet { expected, runs }).collect();
        unmet.sort_by_key(|unmet| std::cmp::Reverse(unmet.runs));
        let properties = layout.properties.iter().enumerate().map(of_property).collect();
        Summary {
            campaign: layout.campaign.clone(),
            again: layout.again(),
            scenario: layout.scenario.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            provenance: layout.provenance.clone(),
            runs: self.expectation.runs(),
            outcomes: self.outcomes,
            expects: layout.expects || self.outcomes.not_as_expected > 0,
            unmet,
            properties,
            of_roaml: layout.of_roaml,
            expectation: estimate("expectation", self.expectation),
            goal,
            frontier: survey.frontier_in_words(),
            instructive: named(survey.instructive_in_words()),
            failures: named(self.failures),
            unexpected: named(self.unexpected),
        }
    }
}
