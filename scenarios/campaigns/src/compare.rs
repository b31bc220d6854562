//! Compares two campaigns: is the new one better than the old one?
//!
//! Both must vary the same parameters in the same way, so that a difference comes from what was changed between them: a
//! tree, a machine, a fixed value of the scenario. Their numbers of runs may differ. If both have a run with the same
//! number, seed and parameters, these two runs are also compared with each other, which reveals smaller differences.

use std::fmt;
use std::path::{Path, PathBuf};

use monitors::Outcome;
use serde::Serialize;

use super::journal::SUMMARY;
use super::journal::{JournalReader, Layout, ParameterLayout};
use super::shard::Shard;
use super::statistics::{Comparison, Confidence, Count, Paired};
use super::summary::command;
use super::{RunOutcome, RunRecord};
use crate::Error;

/// How many differing runs are listed.
const NAMED: usize = 3;

/// The comparison of two campaigns.
#[derive(Clone, Debug, Serialize)]
pub struct CampaignComparison {
    /// The earlier one.
    pub before: ComparedCampaign,
    /// The later one.
    pub after: ComparedCampaign,
    /// The confidence of all intervals.
    pub confidence: Confidence,
    /// How many runs have the same number, seed and parameters in both.
    pub pairs: u64,
    /// One comparison per property that both watch, one for the expectation, and then one per property that was
    /// inconclusive in some run.
    pub comparisons: Vec<Compared>,
}

/// One of the two campaigns.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedCampaign {
    /// The folder of its results.
    pub folder: PathBuf,
    /// Its name on the command line.
    pub campaign: String,
    /// The command that runs it again.
    pub again: String,
    /// Its scenario.
    pub scenario: String,
    /// The version that ran it.
    pub version: String,
    /// How many runs it has.
    pub runs: u64,
    /// How many runs failed; they do not count for any property.
    pub failed: u64,
}

/// How often something happened before and after.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// The property, or `expectation`.
    pub of: String,
    /// What happened to it.
    pub what: ComparedWhat,
    /// The two counts and their comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// How many pairs of runs differ; null without pairs.
    pub paired: Option<Paired>,
    /// The p-value of the pairs, by McNemar's exact test.
    pub paired_p_value: Option<f64>,
    /// The first runs in which it happened only before.
    pub first_only_before: Vec<u64>,
    /// See [`first_only_before`](Self::first_only_before).
    pub first_only_after: Vec<u64>,
    /// Whether the rate is `lower` or `higher`, or has `no_difference` that is significant: by Fisher's test, or by
    /// McNemar's test if there are pairs, with a total error of 5 % for everything compared (Bonferroni).
    pub change: RateChange,
}

/// What can happen in a run, and is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ComparedWhat {
    /// The property was violated.
    Violated,
    /// Something that the property demands was still pending at the end.
    Inconclusive,
    /// The run was not as expected, or failed.
    NotAsExpected,
}

impl ComparedWhat {
    fn words(self) -> &'static str {
        match self {
            Self::Violated => "violated",
            Self::Inconclusive => "inconclusive",
            Self::NotAsExpected => "not as expected",
        }
    }
}

/// The change of a rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RateChange {
    /// It happens less often.
    Lower,
    /// It happens more often.
    Higher,
    /// The runs do not show that it differs.
    NoDifference,
}

impl CampaignComparison {
    /// Compares the results in two folders.
    ///
    /// # Errors
    /// [`Error::Scenario`] if there are no results, if they are incomplete, or if the campaigns cannot be compared.
    pub fn of(before: &Path, after: &Path) -> Result<Self, Error> {
        let [mut old, mut new] = [open(before)?, open(after)?];
        check_alike(&old.header.layout, &new.header.layout)?;
        let events = ComparedEvent::shared(&old.header.layout, &new.header.layout)?;
        let mut tally = Tally::new(events);
        // Both journals are read side by side, so that neither campaign has to fit in memory.
        loop {
            let (old, new) = (old.next()?, new.next()?);
            if old.is_none() && new.is_none() {
                break;
            }
            tally.add(old.as_ref(), new.as_ref());
        }
        check_whole(before, tally.runs[0])?;
        check_whole(after, tally.runs[1])?;
        let side = |folder: &Path, journal: &JournalReader, place: usize| ComparedCampaign {
            folder: folder.to_owned(),
            campaign: journal.header.layout.campaign.clone(),
            again: journal.header.layout.again(),
            scenario: journal.header.layout.scenario.clone(),
            version: journal.header.version.clone(),
            runs: tally.runs[place],
            failed: tally.failed[place],
        };
        let (before, after) = (side(before, &old, 0), side(after, &new, 1));
        let confidence = Confidence::OF_RESULTS;
        Ok(Self { before, after, confidence, pairs: tally.pairs, comparisons: tally.compared() })
    }
}

/// Opens the results of a complete campaign that is not a shard.
fn open(folder: &Path) -> Result<JournalReader, Error> {
    let journal = JournalReader::open(folder)?;
    let shown = folder.display();
    if journal.header.shard != Shard::ALL {
        let Shard { index, of } = journal.header.shard;
        let message = format!("{shown} is shard {index}/{of} of a campaign");
        return Err(Error::refused(message, "merge the shards first: `steward campaign merge`"));
    }
    if !folder.join(SUMMARY).is_file() {
        let message = format!("the campaign in {shown} has not finished");
        return Err(Error::refused(message, "run its command again: it resumes where it stopped"));
    }
    Ok(journal)
}

/// Rejects a journal that lacks runs of its campaign.
fn check_whole(folder: &Path, runs: u64) -> Result<(), Error> {
    let summary = std::fs::read(folder.join(SUMMARY)).ok();
    let summary = summary.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok()).unwrap_or_default();
    if summary["runs"] == runs {
        return Ok(());
    }
    let message =
        format!("the journal in {} has {runs} runs, and {SUMMARY} counts {}", folder.display(), summary["runs"]);
    Err(Error::refused(message, "one of them was changed: run the campaign again"))
}

/// Rejects campaigns that vary different parameters.
fn check_alike(before: &Layout, after: &Layout) -> Result<(), Error> {
    let help = "two campaigns can be compared if they vary the same parameters in the same way";
    // Sorted, since the files may list the same parameters in different orders.
    let keys = |layout: &Layout| -> Vec<String> {
        let mut keys: Vec<_> = layout.parameters.iter().map(|parameter| parameter.key.clone()).collect();
        keys.sort_unstable();
        keys
    };
    let [old, new] = [before, after].map(keys);
    if old != new {
        let list =
            |keys: &[String]| if keys.is_empty() { "nothing".to_owned() } else { format!("`{}`", keys.join("`, `")) };
        let message = format!("the campaigns vary different parameters: {}; and {}", list(&old), list(&new));
        return Err(Error::refused(message, help));
    }
    let differs = |old: &&ParameterLayout| {
        let same = after.parameters.iter().find(|new| new.key == old.key);
        same.filter(|new| new.domain != old.domain).map(|new| (old.key.clone(), old.domain.clone(), new.domain.clone()))
    };
    match before.parameters.iter().find_map(|old| differs(&old)) {
        Some((key, old, new)) => {
            Err(Error::refused(format!("the campaigns vary `{key}` differently: {old}, and {new}"), help))
        }
        None => Ok(()),
    }
}

/// Something that can happen in runs of both campaigns.
struct ComparedEvent {
    name: String,
    what: ComparedWhat,
    /// The indices of its property in both campaigns; none for the expectation.
    places: Option<[usize; 2]>,
}

impl ComparedEvent {
    /// What both campaigns watch.
    fn shared(before: &Layout, after: &Layout) -> Result<Vec<Self>, Error> {
        let place = |layout: &Layout, name: &String| layout.properties.iter().position(|other| other == name);
        let shared =
            before.properties.iter().filter_map(|name| Some((name, [place(before, name)?, place(after, name)?])));
        let shared: Vec<(&String, [usize; 2])> = shared.collect();
        if shared.is_empty() && !(before.properties.is_empty() && after.properties.is_empty()) {
            let list = |layout: &Layout| layout.properties.join(", ");
            let message = format!("the campaigns have no property in common: {}; and {}", list(before), list(after));
            return Err(Error::refused(message, "compare campaigns whose scenarios have the same properties"));
        }
        let of =
            |what| shared.iter().map(move |(name, places)| Self { name: (*name).clone(), what, places: Some(*places) });
        let expectation = Self { name: "expectation".to_owned(), what: ComparedWhat::NotAsExpected, places: None };
        Ok(of(ComparedWhat::Violated).chain([expectation]).chain(of(ComparedWhat::Inconclusive)).collect())
    }

    /// Whether it happened in a run of the campaign with that index.
    fn happened(&self, record: &RunRecord, campaign: usize) -> Option<bool> {
        match self.places {
            Some(places) => {
                let wanted = match self.what {
                    ComparedWhat::Inconclusive => Outcome::Inconclusive,
                    ComparedWhat::Violated | ComparedWhat::NotAsExpected => Outcome::Violated,
                };
                Some(record.facts.as_ref()?.monitors.get(places[campaign])?.verdict == wanted)
            }
            None => Some(record.outcome != RunOutcome::AsExpected),
        }
    }
}

/// Counts over the runs of both campaigns.
struct Tally {
    runs: [u64; 2],
    failed: [u64; 2],
    pairs: u64,
    events: Vec<Counted>,
}

struct Counted {
    event: ComparedEvent,
    counts: [Count; 2],
    paired: Paired,
    only: [Vec<u64>; 2],
}

impl Tally {
    fn new(events: Vec<ComparedEvent>) -> Self {
        let counted =
            |event| Counted { event, counts: Default::default(), paired: Paired::default(), only: Default::default() };
        Self { runs: [0; 2], failed: [0; 2], pairs: 0, events: events.into_iter().map(counted).collect() }
    }

    /// Counts the two runs with the same number; either may be missing.
    fn add(&mut self, old: Option<&RunRecord>, new: Option<&RunRecord>) {
        let alike = old.zip(new).is_some_and(|(old, new)| (old.seed, &old.values) == (new.seed, &new.values));
        self.pairs += u64::from(alike);
        for (place, record) in [old, new].into_iter().enumerate() {
            let Some(record) = record else { continue };
            self.runs[place] += 1;
            self.failed[place] += u64::from(record.outcome == RunOutcome::Failed);
        }
        // A failed run counts for no property, and so is in no pair for it.
        for Counted { event, counts, paired, only } in &mut self.events {
            let [before, after] = [(old, 0), (new, 1)].map(|(record, place)| event.happened(record?, place));
            for (count, happened) in counts.iter_mut().zip([before, after]) {
                happened.into_iter().for_each(|happened| count.push(happened));
            }
            let Some((record, before, after)) =
                old.zip(before).zip(after).map(|((run, before), after)| (run, before, after))
            else {
                continue;
            };
            if alike && before != after {
                paired.only_before += u64::from(before);
                paired.only_after += u64::from(after);
                let named = &mut only[usize::from(after)];
                if named.len() < NAMED {
                    named.push(record.k);
                }
            }
        }
    }

    fn compared(mut self) -> Vec<Compared> {
        // What never was inconclusive need not be compared.
        self.events.retain(|Counted { event, counts, .. }| {
            event.what != ComparedWhat::Inconclusive || counts.iter().any(|count| count.happened() > 0)
        });
        // Bonferroni's correction: with n comparisons at a level of 5 % / n each, the probability that any of them
        // shows a difference by chance is at most 5 %.
        let enough = (1.0 - Confidence::OF_RESULTS.value()) / self.events.len().max(1) as f64;
        let pairs = self.pairs;
        let compared = |Counted {
                            event,
                            counts: [before, after],
                            paired,
                            only: [first_only_before, first_only_after],
                        }: Counted| {
            let comparison = Comparison::of(before, after, Confidence::OF_RESULTS);
            // McNemar's test detects smaller differences, but it ignores runs without a partner.
            let all_paired = pairs > 0 && pairs == before.runs().max(after.runs());
            let p_value = if all_paired { paired.p_value() } else { comparison.p_value };
            let change = match comparison.difference {
                Some(difference) if p_value < enough && difference < 0.0 => RateChange::Lower,
                Some(difference) if p_value < enough && difference > 0.0 => RateChange::Higher,
                _ => RateChange::NoDifference,
            };
            Compared {
                of: event.name,
                what: event.what,
                comparison,
                paired: (pairs > 0).then_some(paired),
                paired_p_value: (pairs > 0).then(|| paired.p_value()),
                first_only_before,
                first_only_after,
                change,
            }
        };
        self.events.into_iter().map(compared).collect()
    }
}

/// In words.
impl fmt::Display for CampaignComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, side) in [("before", &self.before), ("after", &self.after)] {
            let ComparedCampaign { folder, campaign, scenario, version, runs, failed, .. } = side;
            writeln!(
                f,
                "{name:<7} {}: {campaign} ({scenario}, steward {version}), {runs} runs, {failed} failed",
                folder.display()
            )?;
        }
        if self.pairs > 0 {
            writeln!(f, "{} runs have the same parameters and seed in both", self.pairs)?;
        }
        self.comparisons.iter().try_for_each(|compared| compared.write(f, self))
    }
}

impl Compared {
    fn write(&self, f: &mut fmt::Formatter<'_>, of: &CampaignComparison) -> fmt::Result {
        let what = self.what.words();
        let verdict = match self.change {
            RateChange::Lower => format!("less often {what} after"),
            RateChange::Higher => format!("more often {what} after"),
            RateChange::NoDifference => "no significant difference".to_owned(),
        };
        writeln!(f, "\n{}: {verdict}", self.of)?;
        self.write_rates(f, what)?;
        self.write_effect(f)?;
        self.write_pairs(f, of)
    }

    fn write_rates(&self, f: &mut fmt::Formatter<'_>, what: &str) -> fmt::Result {
        let words = |count: Count| {
            let percent = count.rate().map_or("–".to_owned(), |rate| format!("{:.2} %", 100.0 * rate));
            format!("{} of {} ({percent})", count.happened(), count.runs())
        };
        let [before, after] = [self.comparison.before, self.comparison.after].map(words);
        writeln!(f, "  {what} in {before} before, {after} after")
    }

    /// How large the difference is, and how likely it would be by chance.
    fn write_effect(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Comparison { p_value, difference, interval, odds_ratio, odds_interval, .. } = &self.comparison;
        let high = odds_interval.high.map_or("∞".to_owned(), |high| format!("{high:.3}"));
        let ratio = odds_ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.3}"));
        writeln!(
            f,
            "  difference {:+.2} points ({:+.2} to {:+.2}), odds ratio {ratio} ({:.3} to {high}), Fisher's exact test p = {}",
            100.0 * difference.unwrap_or(0.0),
            100.0 * interval.low,
            100.0 * interval.high,
            odds_interval.low,
            probability(*p_value)
        )
    }

    /// In which of the runs with a partner it happened only before or only after.
    fn write_pairs(&self, f: &mut fmt::Formatter<'_>, of: &CampaignComparison) -> fmt::Result {
        let Some((paired, p_value)) = self.paired.zip(self.paired_p_value) else { return Ok(()) };
        writeln!(
            f,
            "  in the same runs: {} only before, {} only after, McNemar's exact test p = {}",
            paired.only_before,
            paired.only_after,
            probability(p_value)
        )?;
        let only = [("before", &self.first_only_before, &of.before), ("after", &self.first_only_after, &of.after)];
        for (when, runs, campaign) in only {
            if let Some(k) = runs.first() {
                writeln!(f, "  only {when}: run {k}, {}", command(&campaign.again, *k))?;
            }
        }
        Ok(())
    }
}

fn probability(p: f64) -> String {
    if p >= 0.001 { format!("{p:.4}") } else { format!("{p:.1e}") }
}
