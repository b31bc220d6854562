//! The journal: each run's record as a line of text, written as soon as the run and all runs before it have ended.
//!
//! It makes a campaign survive interruptions: if the program is killed, all complete lines remain, and an incomplete
//! last line is cut off when the campaign resumes. Datasets are made only from journals, so a resumed or merged dataset
//! cannot differ from any other.

use std::borrow::Borrow;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use recording::Provenance;
use reports::REPORT;
use serde::{Deserialize, Serialize};

use super::file::MAX_RUNS;
use super::shard::Shard;
use super::{Measure, Model, Parameter, ParameterDomain, ParameterValue, Plan, RunRecord};
use crate::Error;

/// The format of journals and datasets.
const FORMAT: u32 = 4;
pub(super) const JOURNAL: &str = "journal.jsonl";
/// The dataset made from the journal.
pub(super) const DATASET: &str = "dataset.parquet";
/// The summary and the page made from it.
pub(super) const SUMMARY: &str = "summary.json";
pub(super) const PAGE: &str = "report.html";
/// The files that are made from a journal.
const MADE_OF_IT: [&str; 3] = [DATASET, SUMMARY, PAGE];
const TIMING: &str = "timing.csv";

/// Whether `folder` has the journal of a campaign.
pub(crate) fn has_journal(folder: &Path) -> bool {
    folder.join(JOURNAL).exists()
}

/// A journal's first line, which identifies the campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    format: u32,
    /// The version that wrote it.
    pub(super) version: String,
    plan: String,
    /// The number of the campaign's runs, in all shards together.
    pub(super) runs: u64,
    pub(super) shard: Shard,
    pub(super) layout: Layout,
}

/// The part of the first line that is the same in every format.
#[derive(Deserialize)]
struct Stamp {
    format: u32,
    version: String,
}

/// The meaning of a journal's records, so that results can be made without the campaign's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Layout {
    /// The campaign's name on the command line.
    pub(super) campaign: String,
    /// The number of runs requested on the command line, if it differs from the file's.
    pub(super) asked: Option<u64>,
    /// The scenario's name on the command line.
    pub(super) scenario: String,
    /// The question that the campaign answers.
    pub(super) about: String,
    pub(super) parameters: Vec<ParameterLayout>,
    pub(super) properties: Vec<String>,
    /// Whether the scenario expects anything of its runs.
    pub(super) expects: bool,
    /// The columns of the dataset that the report plots against the parameters.
    pub(super) measures: Vec<Measure>,
    /// The model with which the results are compared.
    pub(super) model: Option<ModelLayout>,
    /// Whether its runs are those of a RoAML model.
    pub(super) of_roaml: bool,
    /// What its runs are made from, apart from their parameters.
    #[serde(default)]
    pub(super) provenance: Provenance,
}

/// A campaign's model, as in [`Model`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ModelLayout {
    pub(super) of: String,
    pub(super) about: String,
    pub(super) quantity: String,
    pub(super) bound: f64,
}

impl From<&Model> for ModelLayout {
    fn from(model: &Model) -> Self {
        Self {
            of: model.of.value.clone(),
            about: model.about.clone(),
            quantity: model.quantity.value.to_string(),
            bound: model.bound,
        }
    }
}

impl Layout {
    /// The command that runs the campaign again.
    pub(super) fn again(&self) -> String {
        let plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
        let campaign = &self.campaign;
        let quoted = format!("'{}'", campaign.replace('\'', "'\\''"));
        let campaign = if campaign.chars().all(plain) { campaign } else { &quoted };
        let runs = self.asked.map_or(String::new(), |runs| format!(" --runs {runs}"));
        format!("steward campaign {campaign}{runs}")
    }
}

/// A parameter's key and the type of its values.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ParameterLayout {
    pub(super) key: String,
    pub(super) kind: ParameterKind,
    /// Its possible values, in words.
    pub(super) domain: String,
    /// Whether its scale is logarithmic.
    pub(super) logarithmic: bool,
    /// Its name in the model.
    pub(super) name: Option<String>,
    /// A description.
    pub(super) about: Option<String>,
}

/// The common type of a parameter's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum ParameterKind {
    Integer,
    Number,
    Boolean,
    /// Texts, or values of several kinds as TOML.
    Text,
}

impl ParameterKind {
    fn of(domain: &ParameterDomain) -> Self {
        let values = match domain {
            ParameterDomain::Values(values) => values,
            ParameterDomain::Whole { .. } => return Self::Integer,
            ParameterDomain::Range { .. } | ParameterDomain::Normal { .. } | ParameterDomain::Exponential { .. } => {
                return Self::Number;
            }
        };
        let all = |is: fn(&ParameterValue) -> bool| values.iter().all(is);
        if all(|value| matches!(value, ParameterValue::Integer(_))) {
            Self::Integer
        } else if all(|value| matches!(value, ParameterValue::Integer(_) | ParameterValue::Number(_))) {
            Self::Number
        } else if all(|value| matches!(value, ParameterValue::Boolean(_))) {
            Self::Boolean
        } else {
            Self::Text
        }
    }
}

impl Header {
    pub(super) fn of(plan: &Plan, shard: Shard) -> Self {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        let parameter = |parameter: &Parameter| ParameterLayout {
            key: parameter.key.value.clone(),
            kind: ParameterKind::of(&parameter.domain),
            domain: parameter.domain.to_string(),
            logarithmic: matches!(parameter.domain, ParameterDomain::Range { logarithmic: true, .. }),
            name: parameter.name.clone(),
            about: parameter.about.clone(),
        };
        let layout = Layout {
            campaign: plan.name().to_owned(),
            asked: plan.asked,
            scenario: plan.scenario().argument.clone(),
            about: plan.file().about.clone(),
            parameters: plan.file().parameters.iter().map(parameter).collect(),
            properties: plan.properties().to_vec(),
            expects: !plan.base().expected().is_empty(),
            measures: plan.file().measures.iter().map(|measure| measure.value).collect(),
            model: plan.file().model.as_ref().map(ModelLayout::from),
            of_roaml: plan.base().model().is_some(),
            provenance: plan.base().origin.provenance(recording::commit()),
        };
        Self { format: FORMAT, version, plan: plan.identity(), runs: plan.runs(), shard, layout }
    }

    /// The header of another shard of the same campaign.
    pub(super) fn with_shard(&self, shard: Shard) -> Self {
        Self { shard, ..self.clone() }
    }

    /// The error for a journal in `folder` that belongs to another campaign.
    pub(super) fn check(&self, found: &Self, folder: &Path) -> Result<(), Error> {
        let folder = folder.display();
        let commits = [self, found].map(|header| header.layout.provenance.commit.as_ref());
        let help = "results of different versions are not mixed: use that version or another folder, or start over with \
                    `--fresh`";
        let (message, help) = if found.version != self.version {
            (format!("{folder} has results of version {}, but this is {}", found.version, self.version), help)
        } else if let [Some(ours), Some(theirs)] = commits
            && ours != theirs
        {
            // One provenance stands for all runs.
            (format!("{folder} has results of commit {theirs}, but this is {ours}"), help)
        } else if (&found.plan, found.runs) != (&self.plan, self.runs) {
            let help = "its file, its number of runs, or a file of its scenario (map, tree, skill, property, …) has changed: use another folder, or start over with `--fresh`";
            (format!("{folder} has results of another campaign"), help)
        } else if found.shard != self.shard {
            let Shard { index, of } = found.shard;
            (format!("{folder} has shard {index}/{of} of this campaign"), "use another folder")
        } else {
            return Ok(());
        };
        Err(Error::refused(message, help))
    }
}

/// A journal that is being written, with the wall times. While it is open, no other program can write to the folder.
#[derive(Debug)]
pub(super) struct Journal {
    /// The folder of the campaign's results.
    pub(super) folder: PathBuf,
    journal: File,
    timing: File,
}

impl Journal {
    /// Starts a journal in `folder`, or resumes the existing one; `replay` gets the records that it already has.
    pub(super) fn open(
        folder: &Path,
        header: &Header,
        replay: impl FnMut(RunRecord) -> Result<(), Error>,
    ) -> Result<Self, Error> {
        let written = MADE_OF_IT.iter().chain([&JOURNAL, &TIMING]);
        written.map(|name| folder.join(name)).try_for_each(|path| diagnostics::check_unread(&path))?;
        refuse_other_results(folder)?;
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| Error::unwritten(path, source)
        };
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
        let open = |path: &Path| {
            diagnostics::writing(path)?;
            let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
            file.map_err(failed(path))
        };
        let path = folder.join(JOURNAL);
        let mut file = open(&path)?;
        // Nothing is read before the lock: the lines of a program that is still writing are not the last ones.
        lock(&file, folder)?;
        let (runs, end) = resume(folder, &file, header, replay)?;
        cut(&mut file, end).map_err(failed(&path))?;
        if end == 0 {
            write_line(&mut file, header).map_err(failed(&path))?;
        }
        let path = folder.join(TIMING);
        let mut timing = open(&path)?;
        // A run's wall time is written before its record, so a killed program leaves at most one that is superfluous:
        // below the heading, there are as many lines as runs.
        let end = end_of_lines(&timing, runs + 1).map_err(failed(&path))?;
        cut(&mut timing, end).map_err(failed(&path))?;
        if end == 0 {
            timing.write_all(b"k,wall_time_s\n").map_err(failed(&path))?;
        }
        Ok(Self { folder: folder.to_owned(), journal: file, timing })
    }

    /// Reads what was written.
    ///
    /// # Errors
    /// [`Error::Scenario`] if it is no longer there.
    pub(super) fn reader(&self) -> Result<JournalReader, Error> {
        let path = self.folder.join(JOURNAL);
        let file = File::open(&path).map_err(|source| Error::unwritten(path, source))?;
        JournalReader::of(file, &self.folder)
    }

    /// Writes the record of a run, with its wall time if known.
    pub(super) fn append(&mut self, record: &RunRecord, wall_time_s: impl Into<Option<f64>>) -> Result<(), Error> {
        let failed = |name: &str| {
            let path = self.folder.join(name);
            move |source| Error::unwritten(path, source)
        };
        let (timing, journal) = (failed(TIMING), failed(JOURNAL));
        if let Some(wall_time_s) = wall_time_s.into() {
            self.timing.write_all(format!("{},{wall_time_s:.6}\n", record.k).as_bytes()).map_err(timing)?;
        }
        write_line(&mut self.journal, record).map_err(journal)
    }
}

/// Empties the journal in `folder`, if there is one, after removing the files that were made from it.
pub(super) fn start_over(folder: &Path) -> Result<(), Error> {
    let path = folder.join(JOURNAL);
    let Ok(file) = OpenOptions::new().read(true).write(true).open(&path) else { return Ok(()) };
    lock(&file, folder)?;
    let mut lines = Lines::of(&file, folder).map_err(|_| damaged(folder))?;
    let is_header =
        |line: serde_json::Value| line["format"].is_u64() && line["version"].is_string() && !line["plan"].is_null();
    if !lines.next_as::<serde_json::Value>().is_ok_and(|line| line.is_none_or(is_header)) {
        let message = format!("{} is not the journal of a campaign", path.display());
        return Err(Error::refused(message, "only files that a campaign wrote are removed: use another folder"));
    }
    let paths: Vec<PathBuf> = MADE_OF_IT.iter().chain([&TIMING]).map(|name| folder.join(name)).collect();
    paths.iter().try_for_each(|path| diagnostics::check_unread(path))?;
    for path in paths {
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(Error::unwritten(path, source)),
            _ => {}
        }
    }
    file.set_len(0).map_err(|source| Error::unwritten(path, source))
}

/// Rejects a folder without a journal that has other results, which must not be overwritten.
fn refuse_other_results(folder: &Path) -> Result<(), Error> {
    let shown = folder.display();
    let (message, help) = if folder.join(JOURNAL).exists() {
        return Ok(());
    } else if folder.join(DATASET).exists() {
        let help = "existing files are not overwritten: use another folder";
        (format!("{shown} contains a dataset without its journal"), help)
    } else if folder.join(REPORT).exists() {
        let help = "a campaign does not overwrite it: choose another folder with `--out`";
        (format!("{shown} contains the report of a run"), help)
    } else if let Some(name) = [SUMMARY, PAGE, TIMING].into_iter().find(|name| folder.join(name).exists()) {
        let help = "existing files are not overwritten: use another folder";
        (format!("{shown} contains {name} without the journal of its campaign"), help)
    } else {
        return Ok(());
    };
    Err(Error::refused(message, help))
}

/// Keeps other programs from writing to `folder` until the journal is closed.
fn lock(journal: &File, folder: &Path) -> Result<(), Error> {
    match journal.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let message = format!("another program is writing to {}", folder.display());
            Err(Error::refused(message, "wait for it to end, or use another folder"))
        }
        // Campaigns also work on file systems without locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// The number of runs in an existing journal, and where its last complete line ends.
fn resume(
    folder: &Path,
    file: &File,
    header: &Header,
    mut replay: impl FnMut(RunRecord) -> Result<(), Error>,
) -> Result<(u64, u64), Error> {
    let mut lines = Lines::of(file, folder).map_err(|_| damaged(folder))?;
    let Some(found) = lines.header()? else { return Ok((0, 0)) };
    header.check(&found, folder)?;
    let mut runs = 0;
    while let Some(record) = lines.next_as::<RunRecord>()? {
        if record.k != header.shard.run(runs) {
            return Err(damaged(folder));
        }
        runs += 1;
        replay(record)?;
    }
    Ok((runs, lines.end))
}

/// Where the first `count` complete lines end, or all of them if there are fewer.
fn end_of_lines(file: &File, count: u64) -> io::Result<u64> {
    let (mut reader, mut end, mut line) = (BufReader::new(file.take(file.metadata()?.len())), 0, Vec::new());
    for _ in 0..count {
        line.clear();
        let read = reader.read_until(b'\n', &mut line)?;
        if !line.ends_with(b"\n") {
            break;
        }
        end += read as u64;
    }
    Ok(end)
}

fn cut(file: &mut File, end: u64) -> io::Result<()> {
    if file.metadata()?.len() > end {
        file.set_len(end)?;
    }
    file.seek(SeekFrom::Start(end)).map(drop)
}

/// Writes a line in one call, so that all lines but the last are complete however the program ends.
fn write_line(file: &mut File, content: &impl Serialize) -> io::Result<()> {
    let mut line = serde_json::to_vec(content).expect("records are always JSON");
    line.push(b'\n');
    file.write_all(&line)
}

/// Reads a journal from start to end.
#[derive(Debug)]
pub(super) struct JournalReader {
    pub(super) header: Header,
    lines: Lines<io::Take<File>>,
    /// How many runs have been read.
    read: u64,
}

impl JournalReader {
    pub(super) fn open(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(JOURNAL);
        let file = diagnostics::open_regular(&path).map_err(|error| {
            let message = format!("cannot read {}: {error}", path.display());
            Error::refused(message, "a folder with results contains the journal of its campaign")
        })?;
        Self::of(file, folder)
    }

    fn of(file: File, folder: &Path) -> Result<Self, Error> {
        let mut lines = Lines::of(file, folder).map_err(|_| damaged(folder))?;
        let header = lines.header()?.ok_or_else(|| damaged(folder))?;
        Ok(Self { header, lines, read: 0 })
    }

    /// The next run; none after the last complete line.
    pub(super) fn next(&mut self) -> Result<Option<RunRecord>, Error> {
        let Some(record) = self.lines.next_as::<RunRecord>()? else { return Ok(None) };
        if record.k != self.header.shard.run(self.read) {
            return Err(damaged(&self.lines.folder));
        }
        self.read += 1;
        Ok(Some(record))
    }
}

/// Reads the wall times of a journal from start to end.
#[derive(Debug)]
pub(super) struct TimingReader {
    lines: io::Lines<BufReader<File>>,
    /// The run that was read last, with its time.
    last: Option<(u64, f64)>,
}

impl TimingReader {
    /// Opens the wall times in `folder`; none if they are missing.
    pub(super) fn open(folder: &Path) -> Option<Self> {
        let file = File::open(folder.join(TIMING)).ok()?;
        let mut lines = BufReader::new(file).lines();
        lines.next()?.ok()?;
        Some(Self { lines, last: None })
    }

    /// How long run `k` took, in seconds, if known. Runs must be requested in order.
    pub(super) fn of(&mut self, k: u64) -> Option<f64> {
        while self.last.is_none_or(|(last, _)| last < k) {
            let line = self.lines.next()?.ok()?;
            let (run, seconds) = line.split_once(',')?;
            self.last = Some((run.parse().ok()?, seconds.parse().ok()?));
        }
        self.last.filter(|(last, _)| *last == k).map(|(_, seconds)| seconds)
    }
}

/// The complete lines of a journal.
#[derive(Debug)]
struct Lines<R> {
    folder: PathBuf,
    reader: BufReader<R>,
    /// Where the last complete line ended.
    end: u64,
}

impl<F: Read + Borrow<File>> Lines<io::Take<F>> {
    /// The lines of a file, up to the last complete one.
    fn of(file: F, folder: &Path) -> io::Result<Self> {
        let len = file.borrow().metadata()?.len();
        Ok(Self { folder: folder.to_owned(), reader: BufReader::new(file.take(len)), end: 0 })
    }
}

impl<R: Read> Lines<R> {
    /// The first line.
    fn header(&mut self) -> Result<Option<Header>, Error> {
        let Some(line) = self.next_line()? else { return Ok(None) };
        let stamp: Stamp = self.parsed(&line)?;
        if stamp.format != FORMAT {
            let (folder, version) = (self.folder.display(), env!("CARGO_PKG_VERSION"));
            let found = format!("{folder} has results of version {} in format {}", stamp.version, stamp.format);
            let message = format!("{found}; this program is version {version} and writes format {FORMAT}");
            return Err(Error::refused(
                message,
                "use the program that wrote them or another folder, or start over with `--fresh`",
            ));
        }
        let header: Header = self.parsed(&line)?;
        let Shard { index, of } = header.shard;
        if Shard::new(index, of).is_none() || header.runs > MAX_RUNS {
            return Err(damaged(&self.folder));
        }
        Ok(Some(header))
    }

    fn next_as<T: for<'d> Deserialize<'d>>(&mut self) -> Result<Option<T>, Error> {
        self.next_line()?.map(|line| self.parsed(&line)).transpose()
    }

    /// The next complete line.
    fn next_line(&mut self) -> Result<Option<Vec<u8>>, Error> {
        let mut line = Vec::new();
        let read = self.reader.read_until(b'\n', &mut line).map_err(|_| damaged(&self.folder))?;
        if !line.ends_with(b"\n") {
            // What remains will be cut off, so it must be what a killed program has left of its journal.
            return if self.end > 0 || begins_a_header(&line) { Ok(None) } else { Err(damaged(&self.folder)) };
        }
        self.end += read as u64;
        Ok(Some(line))
    }

    fn parsed<T: for<'d> Deserialize<'d>>(&self, line: &[u8]) -> Result<T, Error> {
        serde_json::from_slice(line).map_err(|_| damaged(&self.folder))
    }
}

/// Whether an incomplete first line is that of a header, as far as it goes.
fn begins_a_header(line: &[u8]) -> bool {
    let beginning = format!("{{\"format\":{FORMAT},\"version\":\"");
    line.iter().zip(beginning.as_bytes()).all(|(found, expected)| found == expected)
}

fn damaged(folder: &Path) -> Error {
    let message = format!("the journal in {} is damaged or from another version", folder.display());
    Error::refused(message, "it contains a line that no campaign of this version writes: use another folder")
}
