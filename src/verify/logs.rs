//! The summary of several logs: a line for each, an index page with links to their reports, and test cases.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use campaigns::Error;
use diagnostics::counted;
use judging::{NO_FORMULA, VerificationResult, check_no_bag, check_violations};
use monitors::{Outcome, Property};
use recording::{Certainty, Evidence, Provenance, ShownVerdict};
use reports::REPORT;
use reports::file_place::FilePlace;
use reports::html::{self, Day, LogRow};
use reports::results::{Case, CaseResult, Suite, TrailStep, WrittenPlaces, trail};
use serde_json::{Value, json};

use super::args::VerifyArgs;
use crate::results::{places_now, refused};

/// The name of the index page.
const INDEX: &str = "index.html";

/// The result for a log, as a line of the summary.
pub(super) struct Line {
    log: PathBuf,
    /// The folder of its report, if there is one.
    folder: Option<PathBuf>,
    result: Result<LogSummary, Refusal>,
}

/// Why a log could not be checked.
struct Refusal {
    reason: String,
    /// The reason with its places, as a test case.
    suite: Suite,
}

/// The part of a result that is kept. It is small, since there may be many logs.
struct LogSummary {
    start_ns: Option<i64>,
    end: Duration,
    messages: u64,
    verdicts: Vec<PropertyVerdict>,
    /// The properties that could not be judged.
    unjudged: Vec<Case>,
    notes: Vec<String>,
    provenance: Provenance,
}

struct PropertyVerdict {
    property: String,
    verdict: ShownVerdict,
    /// How often the property was violated, if its monitor continues after a violation.
    times: Option<u64>,
    /// The reason, for readers of a build log.
    why: String,
    /// Why the property is satisfied only weakly, if this is so.
    weakness: Option<String>,
    /// What the verdict leaves open: open obligations, conditions that never occurred, and levels that no message
    /// reported.
    open: Vec<String>,
    /// Where the property is written.
    place: Option<FilePlace>,
    /// The messages that violated it.
    trail: Vec<TrailStep>,
    /// The story of the violation.
    story: Vec<String>,
}

impl Line {
    pub(super) fn of(
        args: &VerifyArgs,
        log: &Path,
        folder: Option<PathBuf>,
        result: Result<&VerificationResult, &Error>,
    ) -> Self {
        let refusal = |error: &Error| {
            let suite = refused(&log.display().to_string(), error, args.on_disk());
            Refusal { reason: error.reasons(), suite }
        };
        let result = result.map(|result| LogSummary::of(result, written(args, result))).map_err(refusal);
        Self { log: log.to_owned(), folder, result }
    }

    /// The day on which the log begins, or else the day in its name: `2026-03-01`. rosbag2 writes names such as
    /// `rosbag2_2026_03_01-10_20_00`.
    fn day(&self) -> Option<String> {
        let begun = self.result.as_ref().ok().and_then(|summary| bags::date(summary.start_ns?));
        begun.map(|date| date.format("%Y-%m-%d").to_string()).or_else(|| day_in(&self.log.to_string_lossy()))
    }

    fn is_bad(&self) -> bool {
        self.result.as_ref().is_ok_and(|summary| summary.verdicts.iter().any(PropertyVerdict::is_bad))
    }

    fn is_undecided(&self) -> bool {
        self.result.as_ref().is_ok_and(|summary| summary.verdicts.iter().any(PropertyVerdict::is_undecided))
    }

    /// A log that was refused, as JSON.
    pub(super) fn refused(log: &Path, error: &Error) -> Value {
        json!({ "log": log.display().to_string(), "refused": error.reasons() })
    }

    /// The verdicts as test cases.
    pub(super) fn suite(&self) -> Suite {
        let name = self.log.display().to_string();
        // Standard input is no file.
        let file = self.log.exists().then(|| FilePlace::whole(&name));
        match &self.result {
            Ok(summary) => {
                let provenance = Some(summary.provenance.clone());
                let facts = vec![("messages", summary.messages.to_string()), ("seconds", seconds(summary.end))];
                Suite {
                    name,
                    provenance,
                    facts,
                    notes: summary
                        .notes
                        .iter()
                        .cloned()
                        .chain(summary.verdicts.iter().flat_map(PropertyVerdict::notes))
                        .collect(),
                    cases: summary
                        .verdicts
                        .iter()
                        .map(PropertyVerdict::case)
                        .chain(summary.unjudged.iter().cloned())
                        .collect(),
                    file,
                    page: self.folder.as_ref().map(|folder| folder.join(html::FILE)),
                    ..Suite::default()
                }
            }
            Err(Refusal { suite, .. }) => Suite { file, ..suite.clone() },
        }
    }
}

impl LogSummary {
    fn of(result: &VerificationResult, (places, changed): (WrittenPlaces, Vec<String>)) -> Self {
        let verdicts = result.properties.iter().enumerate().map(|(index, property)| {
            let monitor = property.scope_monitor();
            let violations = monitor.and_then(|monitor| monitor.violations());
            let witness = monitor.and_then(|monitor| monitor.witness());
            let witness = witness.filter(|_| result.has_verdict(index));
            let trail = witness.map(|witness| trail(&property.name, witness, result.knows_ticks, &places));
            let trail = trail.unwrap_or_default();
            let vacuous = monitor.map(|monitor| monitor.vacuous()).unwrap_or_default();
            let vacuous = vacuous.into_iter().map(|vacuity| vacuity.to_string());
            let weaknesses: Vec<String> = vacuous.chain(result.unreported_levels[index].clone()).collect();
            let pending = monitor.map(|monitor| result.open(monitor)).unwrap_or_default();
            let words = witness.map(|witness| reports::witness_in_words(witness, result.knows_ticks));
            PropertyVerdict {
                property: property.name.clone(),
                verdict: result.verdict(index),
                times: violations.filter(|all| all.goes_on).map(|all| all.count),
                why: result.evidence[index].certainty().why().map(str::to_owned).or(words).unwrap_or_default(),
                weakness: unless(&result.evidence[index]).or(weaknesses.first().cloned()),
                open: pending.into_iter().chain(weaknesses).chain(open_questions(&result.evidence[index])).collect(),
                place: places.properties.get(&property.name).cloned(),
                trail,
                story: result.stories[index].clone(),
            }
        });
        Self {
            start_ns: result.start_ns,
            end: result.end_time(),
            messages: result.end.messages,
            verdicts: verdicts.collect(),
            unjudged: result.unjudged.iter().map(|name| Case::not_judged(name, NO_FORMULA, &places)).collect(),
            notes: result
                .empty_inputs()
                .map(str::to_owned)
                .chain(result.notes.iter().cloned())
                .chain(changed)
                .collect(),
            provenance: result.provenance(),
        }
    }

    /// When the log begins; empty if its clock does not count from 1970.
    fn begins(&self) -> String {
        self.start_ns.filter(|&ns| bags::date(ns).is_some()).map_or_else(String::new, bags::moment)
    }
}

impl PropertyVerdict {
    fn is_bad(&self) -> bool {
        !self.is_satisfied() && !self.is_undecided()
    }

    fn is_satisfied(&self) -> bool {
        self.verdict == ShownVerdict::Of(Outcome::Satisfied)
    }

    fn is_undecided(&self) -> bool {
        self.verdict == ShownVerdict::Of(Outcome::Inconclusive)
    }

    /// The verdict, and the number of violations if there are several.
    fn words(&self) -> String {
        match self.times {
            Some(times @ 2..) => format!("{} {times} times", self.verdict),
            _ => self.verdict.to_string(),
        }
    }

    /// What the verdict leaves open.
    fn notes(&self) -> impl Iterator<Item = String> {
        self.open.iter().map(|words| format!("{}: {words}", self.property))
    }

    fn case(&self) -> Case {
        let result = match self.verdict {
            ShownVerdict::Of(Outcome::Satisfied) => {
                self.weakness.clone().map_or(CaseResult::Passed, CaseResult::Skipped)
            }
            ShownVerdict::Of(Outcome::Inconclusive) => {
                CaseResult::Skipped("something was still pending when the log ended".to_owned())
            }
            ShownVerdict::Groundless => CaseResult::Error(format!("{} has no verdict: {}", self.property, self.why)),
            ShownVerdict::Of(Outcome::Violated) | ShownVerdict::Unsure => CaseResult::Failed {
                message: format!("{} is {}", self.property, self.words()),
                details: self.why.trim_end().to_owned(),
            },
        };
        Case {
            group: "properties",
            name: self.property.clone(),
            result,
            found: self.words(),
            place: self.place.clone(),
            trail: self.trail.clone(),
            story: self.story.clone(),
            ..Case::default()
        }
    }
}

/// What would change a verdict that is otherwise sure, in words.
fn unless(evidence: &Evidence) -> Option<String> {
    let Certainty::Unless(why) = evidence.certainty() else { return None };
    Some(format!("unless {why}"))
}

/// What a verdict leaves open because evidence is missing.
fn open_questions(evidence: &Evidence) -> Vec<String> {
    let silent = evidence.silent().iter().map(|channel| format!("no message {channel} in the whole run"));
    let assumed = evidence.assumptions().iter().map(|what| format!("it is assumed that {what}"));
    unless(evidence).into_iter().chain(silent).chain(assumed).collect()
}

/// Where the properties and the processes of a log are written, if results are wanted. Properties without a file belong
/// to its scenario, and so do the processes unless the command line names the tree. Also the changes since then, in
/// words.
fn written(args: &VerifyArgs, result: &VerificationResult) -> (WrittenPlaces, Vec<String>) {
    if !args.results.are_wanted() {
        return Default::default();
    }
    let named = |property: &Property| Some((property.name.clone(), FilePlace::of(property.place.as_ref()?)?));
    let properties = result.properties.iter().filter_map(named).collect();
    let given = WrittenPlaces { file: None, properties, processes: result.processes.clone() };
    let given = given.with_paths(args.on_disk());
    let (mut places, changed) = places_now(&result.header, &result.properties);
    places.properties.extend(given.properties);
    places.processes.extend(given.processes);
    (places, changed)
}

/// Sorts logs by their beginnings if all are known, or else by the days in their names.
pub(super) fn sort(lines: &mut [Line]) {
    let start = |line: &Line| line.result.as_ref().ok().and_then(|summary| summary.start_ns);
    if lines.iter().all(|line| line.result.is_err() || start(line).is_some()) {
        lines.sort_by_key(|line| (start(line).is_none(), start(line)));
    } else if lines.iter().all(|line| line.day().is_some()) {
        lines.sort_by_key(Line::day);
    }
}

/// The first date in a name: four digits, two and two, which may be separated by `-` or `_`.
fn day_in(name: &str) -> Option<String> {
    let letters: Vec<char> = name.chars().collect();
    let number = |from: usize, length: usize| {
        let digits: String = letters.get(from..from + length)?.iter().collect();
        digits.parse::<u32>().ok().filter(|_| digits.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let gap = |at: usize| usize::from(matches!(letters.get(at), Some('-' | '_')));
    (0..letters.len()).find_map(|start| {
        let month = start + 4 + gap(start + 4);
        let day = month + 2 + gap(month + 2);
        let (year, month, day) = (number(start, 4)?, number(month, 2)?, number(day, 2)?);
        let is_date = (2000..2100).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
        is_date.then(|| format!("{year}-{month:02}-{day:02}"))
    })
}

/// The verdicts of each day, if there are several days. Logs without a day are left out.
fn days(lines: &[Line]) -> Vec<Day> {
    let mut days: BTreeMap<String, Day> = BTreeMap::new();
    for line in lines {
        let (Some(date), Ok(summary)) = (line.day(), &line.result) else { continue };
        let day = days.entry(date.clone()).or_insert_with(|| Day { date, ..Day::default() });
        day.logs += 1;
        for verdict in &summary.verdicts {
            let [bad, of] = day.bad.entry(verdict.property.clone()).or_default();
            *bad += usize::from(verdict.is_bad());
            *of += 1;
        }
    }
    if days.len() < 2 { Vec::new() } else { days.into_values().collect() }
}

/// The summary, with a line for each log.
pub(super) fn in_words(lines: &[Line]) -> String {
    let refused = lines.iter().filter(|line| line.result.is_err()).count();
    let bad = lines.iter().filter(|line| line.is_bad()).count();
    let undecided = lines.iter().filter(|line| !line.is_bad() && line.is_undecided()).count();
    let satisfied = lines.len() - bad - undecided - refused;
    let mut text = format!("\n{}: {satisfied} with all properties satisfied", counted(lines.len(), "log"));
    let others = [
        (bad, "with a property violated, unsure or without a verdict"),
        (undecided, "with a property undecided"),
        (refused, "that could not be checked"),
    ];
    for (count, what) in others {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text.push('\n');
    for Line { log, result, .. } in lines {
        let words = match result {
            Ok(summary) => {
                let bad: Vec<String> = summary
                    .verdicts
                    .iter()
                    .filter(|verdict| !verdict.is_satisfied())
                    .map(|verdict| format!("{} {}", verdict.property, verdict.words()))
                    .collect();
                let satisfied = summary.verdicts.len() - bad.len();
                let rest = (satisfied > 0).then(|| format!("{satisfied} satisfied"));
                let words: Vec<String> = bad.into_iter().chain(rest).collect();
                let begins = summary.begins();
                let begins = if begins.is_empty() { begins } else { begins + ", " };
                format!("{begins}{} s: {}", seconds(summary.end), words.join(", "))
            }
            Err(refusal) => format!("not checked: {}", refusal.reason),
        };
        text += &format!("  {}  {words}\n", log.display());
    }
    for Day { date, logs, bad } in days(lines) {
        let bad = bad.iter().filter(|(_, [bad, _])| *bad > 0);
        let bad: Vec<String> = bad.map(|(name, [bad, of])| format!("{name} in {bad} of {of}")).collect();
        let words = if bad.is_empty() { "nothing".to_owned() } else { bad.join(", ") };
        text += &format!("  {date}: {}, violated or unsure: {words}\n", counted(logs, "log"));
    }
    text
}

/// Checks, before any log is judged, that none of them is overwritten, and that no report is written into a bag.
pub(super) fn check_outputs(args: &VerifyArgs, folders: &[Option<PathBuf>]) -> Result<(), Error> {
    let Some(out) = &args.out else { return Ok(()) };
    // A log that cannot be read is refused later, when it is read.
    args.logs.iter().try_for_each(|log| match diagnostics::reading(log) {
        Err(error) if diagnostics::would_be_overwritten(&error) => {
            Err(Error::refused(format!("{}: {error}", log.display()), "name another file to be written"))
        }
        _ => Ok(()),
    })?;
    let bags: Vec<&PathBuf> = args.logs.iter().filter(|log| args.map_channels.is_some() && bags::is_bag(log)).collect();
    for (log, folder) in args.logs.iter().zip(folders).filter_map(|(log, folder)| Some((log, folder.as_ref()?))) {
        [REPORT, html::FILE].iter().try_for_each(|name| diagnostics::check_unread(&folder.join(name)))?;
        if bags.contains(&log) {
            check_violations(folder)?;
            bags.iter().try_for_each(|bag| check_apart(folder, bag))?;
            check_no_bag(folder)?;
        }
    }
    if args.logs.len() > 1 {
        diagnostics::check_unread(&out.join(INDEX))?;
    }
    Ok(())
}

/// Refuses a folder of a bag for the report. The file with the violations has the same format as the bag, so later
/// readers would read it as a part of the bag: all files in the folder of a bag are one recording.
fn check_apart(folder: &Path, bag: &Path) -> Result<(), Error> {
    let real = |path: &Path| {
        let path = diagnostics::normal(path);
        // The folder may not exist yet.
        let there = path.ancestors().find_map(|there| Some((there, there.canonicalize().ok()?)));
        there.map_or_else(|| path.clone(), |(there, real)| real.join(path.strip_prefix(there).unwrap_or(&path)))
    };
    let (to, from) = (real(folder), real(bag));
    let is_within = if bag.is_dir() { to.starts_with(&from) } else { from.parent() == Some(to.as_path()) };
    if !is_within {
        return Ok(());
    }
    let message =
        format!("the report would be written into the folder of the bag {}: {}", bag.display(), folder.display());
    Err(Error::refused(message, "name another folder with `--out`"))
}

/// Writes the index page.
pub(super) fn write_index(lines: &[Line], folder: &Path) -> Result<(), Error> {
    let rows: Vec<LogRow> = lines.iter().map(|line| row(line, folder)).collect();
    Ok(diagnostics::write_whole(&folder.join(INDEX), html::logs(&rows, &days(lines)))?)
}

fn row(Line { log, folder: page, result, .. }: &Line, folder: &Path) -> LogRow {
    let page = page.as_ref().and_then(|page| page.strip_prefix(folder).ok());
    let row = LogRow { log: log.display().to_string(), ..LogRow::default() };
    match result {
        Ok(summary) => LogRow {
            page: page.map(|page| page.join(html::FILE).display().to_string()),
            begins: summary.begins(),
            lasts: format!("{} s", seconds(summary.end)),
            verdicts: summary
                .verdicts
                .iter()
                .map(|verdict| (verdict.property.clone(), verdict.verdict, verdict.words()))
                .collect(),
            notes: summary.notes.clone(),
            ..row
        },
        Err(refusal) => LogRow { refused: Some(refusal.reason.clone()), ..row },
    }
}

/// The folders of the reports of several logs. Each has the name of its log, with a number if the name is taken.
pub(super) fn folders(logs: &[PathBuf], out: &Path) -> Vec<PathBuf> {
    let mut taken = BTreeSet::new();
    let folder = |log: &PathBuf| {
        let name = reports::file_name(&log.file_stem().unwrap_or_default().to_string_lossy());
        let numbered = |number: usize| if number == 1 { name.clone() } else { format!("{name}-{number}") };
        let free = (1..).map(numbered).find(|name| taken.insert(name.clone()));
        out.join(free.expect("there are more numbers than logs"))
    };
    logs.iter().map(folder).collect()
}

fn seconds(time: Duration) -> String {
    format!("{:.1}", time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::day_in;

    #[test]
    fn a_day_is_found_in_the_name_of_a_log() {
        for name in ["rosbag2_2026_03_01-10_20_00", "a/run-20260301.mcap", "2026-03-01/morning.db3"] {
            assert_eq!(day_in(name).as_deref(), Some("2026-03-01"), "{name}");
        }
        for name in ["", "run_12.mcap", "2026_13_01", "1234567890.jsonl", "20260", "été-2026"] {
            assert_eq!(day_in(name), None, "{name}");
        }
    }
}
