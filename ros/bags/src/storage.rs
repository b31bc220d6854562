//! The files of a bag: their topics, and their messages one after the other.

mod files;
mod following;
mod mcap;
mod merge;
mod metadata;
mod source;
#[cfg(feature = "sqlite")]
mod sqlite;
mod survey;
mod writer;
mod zstandard;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::Error;
use files::{Files, Format};
use merge::{Block, Merge, Plan, Unit};
use source::{Aside, Wanted};
use zstandard::Zstandard;

pub use files::{is_bag, parts};
pub use following::Following;
pub(crate) use source::is_note;
pub use source::{Account, Received, Source, Through};
pub use survey::{Definition, Head, Survey, Topic};
pub use writer::{BagWriter, Recorder};

/// A ROS 2 recording: a file, or a folder of files.
#[derive(Clone, Debug)]
pub struct Bag {
    files: Vec<BagFile>,
    survey: Survey,
}

#[derive(Clone, Debug)]
struct BagFile {
    path: PathBuf,
    format: Format,
    /// Where its messages are, if the whole file had to be read to know what is in it.
    plan: Option<Arc<Plan>>,
}

impl Bag {
    /// Finds the files of a bag and the topics in them. Reads the summaries of the files; a file that was not closed
    /// has none and is read once in full.
    ///
    /// # Errors
    /// If it is not a bag or cannot be read at all. Damage is not an error: everything before it is read.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let mut survey = Survey::of_recorder();
        let Files { found, are_listed, metadata } = files::of(path, &mut survey)?;
        let (mut files, mut parts) = (Vec::new(), Vec::new());
        for (path, format) in found {
            let mut part = Survey::default();
            let file = diagnostics::open_regular(&path);
            let file = file.map_err(|source| diagnostics::Error::Read { path: path.clone(), source })?;
            if file.metadata().is_ok_and(|found| found.len() == 0) {
                return Err(Error::Empty(path));
            }
            let plan = match format {
                Format::Mcap => mcap::survey(&path, &mut part)?,
                #[cfg(feature = "sqlite")]
                Format::Sqlite => Some(sqlite::survey(&path, &mut part)?),
                #[cfg(not(feature = "sqlite"))]
                Format::Sqlite => return Err(Error::NoSqlite(path)),
            };
            files.push(BagFile { path, format, plan: plan.map(Arc::new) });
            parts.push(part);
        }
        refuse_copies(path, &files, &parts, are_listed)?;
        if !are_listed {
            refuse_others(path, &files, &mut parts)?;
        }
        let counts = files.iter().zip(&parts).map(|(file, part)| (file.name(), part.counts.iter().sum()));
        let counts = counts.collect();
        parts.into_iter().for_each(|part| survey.merge(part));
        // Of a bag that lacks files, or has damaged ones, it is known that messages are missing.
        if survey.lost.is_empty() {
            metadata.compare(&counts, &mut survey);
        }
        Ok(Self { files, survey })
    }

    /// What the bag contains.
    #[must_use]
    pub fn survey(&self) -> &Survey {
        &self.survey
    }

    /// What is already known to be lost with damaged parts of files, in words: files without an index have been read.
    pub fn damage(&self) -> impl Iterator<Item = &String> {
        self.files.iter().filter_map(|file| file.plan.as_ref()).flat_map(|plan| &plan.lost)
    }

    /// Reads the messages of the topics with the indices `wanted`, in the order of the times at which they were
    /// recorded. Messages of one time are in the order in which they were recorded.
    #[must_use]
    pub fn messages(&self, wanted: &[usize]) -> Messages {
        let wanted = (0..self.survey.topics.len()).map(|topic| wanted.contains(&topic)).collect();
        self.messages_of(Wanted::Known(wanted))
    }

    /// The same for topics with these names.
    #[must_use]
    pub fn messages_on<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> Messages {
        self.messages_of(Wanted::Named(names.into_iter().map(str::to_owned).collect()))
    }

    fn messages_of(&self, wanted: Wanted) -> Messages {
        Messages {
            files: self.files.clone(),
            plans: Vec::new(),
            units: Vec::new(),
            read: vec![BTreeMap::new(); self.files.len()],
            merge: None,
            readers: BTreeMap::new(),
            survey: self.survey.clone(),
            counts_losses: self.survey.topics.iter().any(|topic| topic.name == source::MISSING),
            wanted,
            aside: Aside { notes: self.survey.notes.clone(), ..Aside::default() },
        }
    }
}

/// All pairs of so many files.
fn pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(|second| (0..second).map(move |first| [first, second]))
}

/// Refuses two files of a folder with the same messages: one is a copy of the other, perhaps in place of a third. Those
/// that are listed also have the same length then.
fn refuse_copies(folder: &Path, files: &[BagFile], parts: &[Survey], are_listed: bool) -> Result<(), Error> {
    let length = |index: usize| std::fs::metadata(&files[index].path).ok().map(|about| about.len());
    let is_copy = |pair: &[usize; 2]| {
        let [first, second] = pair.map(|index| &parts[index]);
        let is_span = |(begin, end): (i64, i64)| begin < end;
        let have_same = first.span_ns == second.span_ns && counts(first) == counts(second);
        let is_as_long = !are_listed || length(pair[0]) == length(pair[1]);
        have_same && first.span_ns.is_some_and(is_span) && is_as_long
    };
    let Some(pair) = pairs(parts.len()).find(is_copy) else { return Ok(()) };
    let (folder, files) = (folder.to_owned(), pair.map(|index| files[index].name()));
    Err(Error::Several { folder, files, why: "have the same messages" })
}

/// Refuses the files of a folder if they show that they are not one recording: the metadata does not list them.
fn refuse_others(folder: &Path, files: &[BagFile], parts: &mut [Survey]) -> Result<(), Error> {
    let names: Vec<String> = files.iter().map(BagFile::name).collect();
    let several = |[first, second]: [usize; 2], why| {
        let files = [first, second].map(|index| names[index].clone());
        Err(Error::Several { folder: folder.to_owned(), files, why })
    };
    let spans = |[first, second]: [usize; 2]| parts[first].span_ns.zip(parts[second].span_ns);
    let mut others = None;
    for pair in pairs(parts.len()) {
        let Some(spans) = spans(pair) else { continue };
        let [first, second] = pair.map(|index| &parts[index]);
        let [(stem, number), (other_stem, other)] = pair.map(|index| files::stem_and_number(&names[index]));
        let is_next = stem == other_stem && number.is_some() && other.is_some();
        if is_same_time(spans, is_next) {
            return several(pair, "have messages of the same time");
        }
        if is_next {
            continue;
        }
        let has_other_type = |topic: &Topic| {
            let mut same = second.topics.iter().filter(|other| other.name == topic.name).peekable();
            same.peek().is_some() && same.all(|other| other.kind != topic.kind)
        };
        if first.topics.iter().any(has_other_type) {
            return several(pair, "have other types on the same topic");
        }
        others.get_or_insert(pair);
    }
    let note = |[first, second]: [usize; 2], and: &str| {
        let (first, second) = (&names[first], &names[second]);
        format!("{first} {and} {second} are read as one recording: no {} lists its files", metadata::METADATA)
    };
    let note = match (others, names.len()) {
        (Some(pair), _) => note(pair, "and"),
        (None, 0 | 1) => return Ok(()),
        (None, count) => {
            note([0, count - 1], if count == 2 { "and" } else { "to" }) + ", so a later one may be missing"
        }
    };
    parts[0].notes.push(note);
    Ok(())
}

/// Whether two files have messages of the same time, by when their first and last messages were recorded. Those of one
/// recording may overlap a little; one that follows the other may also be that short.
fn is_same_time(((begin, end), (other_begin, other_end)): ((i64, i64), (i64, i64)), is_next: bool) -> bool {
    const LITTLE_NS: i64 = 1_000_000_000;
    let both = end.min(other_end).saturating_sub(begin.max(other_begin));
    let shorter = end.saturating_sub(begin).min(other_end.saturating_sub(other_begin));
    both > LITTLE_NS || both > 0 && both > shorter / 2 && !is_next
}

/// How many messages there are on each topic that has any.
fn counts(part: &Survey) -> BTreeMap<&str, u64> {
    let all = part.topics.iter().zip(&part.counts).filter(|(_, count)| **count > 0);
    all.map(|(topic, count)| (&*topic.name, *count)).collect()
}

/// No more files are open at the same time: a system limits their number.
const MOST_OPEN: usize = 16;

/// The messages of a bag, one after the other.
pub struct Messages {
    files: Vec<BagFile>,
    /// Where the messages of each file are, once the first message has been requested.
    plans: Vec<Arc<Plan>>,
    /// All units: the numbers of their files, and their own there.
    units: Vec<(usize, usize)>,
    /// How many messages of each channel have been read of each file.
    read: Vec<BTreeMap<u16, u64>>,
    merge: Option<Box<Merge>>,
    readers: BTreeMap<usize, StorageReader>,
    survey: Survey,
    counts_losses: bool,
    wanted: Wanted,
    aside: Aside,
}

enum StorageReader {
    Mcap(Box<mcap::McapReader>),
    #[cfg(feature = "sqlite")]
    Sqlite(Box<sqlite::SqliteReader>),
}

impl StorageReader {
    fn open(file: &BagFile, plan: &Plan, wanted: &Wanted, survey: &mut Survey) -> Result<Self, Error> {
        match file.format {
            Format::Mcap => mcap::McapReader::open(&file.path, plan).map(|reader| Self::Mcap(Box::new(reader))),
            #[cfg(feature = "sqlite")]
            Format::Sqlite => {
                sqlite::SqliteReader::open(&file.path, wanted, survey).map(|reader| Self::Sqlite(Box::new(reader)))
            }
            #[cfg(not(feature = "sqlite"))]
            Format::Sqlite => {
                let _ = (wanted, survey);
                Err(Error::NoSqlite(file.path.clone()))
            }
        }
    }
}

impl BagFile {
    fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    fn plan(&self) -> Result<Arc<Plan>, Error> {
        match (&self.plan, self.format) {
            (Some(plan), _) => Ok(Arc::clone(plan)),
            (None, Format::Mcap) => mcap::plan(&self.path).map(Arc::new),
            (None, Format::Sqlite) => Err(Error::NoBag(self.path.clone())),
        }
    }
}

impl Messages {
    /// Reads the next message into `body`. Returns its time and topic; none at the end.
    pub fn next_into(&mut self, body: &mut Vec<u8>) -> Option<Head> {
        let mut merge = self.merge.take().unwrap_or_else(|| self.begin());
        let head = merge.next_into(body, |number, block| self.load(number, block));
        self.merge = Some(merge);
        match head {
            Some(_) => unpack(body, &mut self.aside.lost),
            None => self.compare(),
        }
        head
    }

    /// Compares how many messages have been read, now that it is all of them, with how many there should be.
    fn compare(&mut self) {
        for ((file, plan), read) in self.files.iter().zip(std::mem::take(&mut self.plans)).zip(&self.read) {
            if let Some(counts) = &plan.counts {
                self.wanted.compare(&file.path, &plan.topics, [counts, read], &mut self.survey);
            }
        }
    }

    /// Finds the units of all files.
    fn begin(&mut self) -> Box<Merge> {
        let mut merge = Box::<Merge>::default();
        for (number, file) in self.files.iter().enumerate() {
            let plan = file.plan().unwrap_or_else(|error| {
                self.aside.lost.push(error.to_string());
                Arc::default()
            });
            // What is lost at the end of a file in disorder may have come before what is left.
            if !plan.is_ascending() {
                self.aside.lost.extend(plan.lost.iter().cloned());
            }
            self.aside.lost.extend(plan.unfit.iter().cloned());
            for (index, unit) in plan.units.iter().enumerate() {
                if is_needed(unit, &plan, &self.wanted, &mut self.survey) {
                    merge.add(self.units.len(), unit);
                    self.units.push((number, index));
                }
            }
            self.plans.push(plan);
        }
        merge
    }

    /// Reads the wanted messages of a unit.
    fn load(&mut self, number: usize, block: &mut Block) {
        let (file, index) = self.units[number];
        let (plan, mut lost) = (Arc::clone(&self.plans[file]), Vec::new());
        if !self.readers.contains_key(&file) {
            if self.readers.len() >= MOST_OPEN {
                self.readers.pop_first();
            }
            match StorageReader::open(&self.files[file], &plan, &self.wanted, &mut self.survey) {
                Ok(reader) => drop(self.readers.insert(file, reader)),
                Err(error) => lost.push(error.to_string()),
            }
        }
        let unit = &plan.units[index];
        match self.readers.get_mut(&file) {
            Some(StorageReader::Mcap(reader)) => {
                reader.load(unit, block, &self.wanted, &mut self.survey, &mut self.read[file], &mut lost);
            }
            #[cfg(feature = "sqlite")]
            Some(StorageReader::Sqlite(reader)) => reader.load(unit, block, &mut lost),
            None => {}
        }
        // A unit may be read several times.
        lost.retain(|what| !self.aside.lost.contains(what));
        self.aside.lost.append(&mut lost);
    }

    /// Damaged or missing parts so far, in words.
    #[must_use]
    pub fn lost(&self) -> &[String] {
        &self.aside.lost
    }
}

/// Whether a unit may have wanted messages.
fn is_needed(unit: &Unit, plan: &Plan, wanted: &Wanted, survey: &mut Survey) -> bool {
    // An index without channels comes from a writer that indexes no messages: the chunk may have any.
    let Some(channels) = unit.channels.as_ref().filter(|channels| !channels.is_empty()) else { return true };
    channels.iter().any(|channel| plan.topics.get(channel).is_none_or(|topic| wanted.index(topic, survey).is_some()))
}

impl Source for Messages {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        while let Some(head) = self.next_into(body) {
            if let Some(received) = source::received(head, &mut self.survey, &self.wanted, body, &mut self.aside) {
                return received;
            }
        }
        Received::Over
    }

    fn account(&self) -> Account<'_> {
        self.aside.account(&self.survey, self.counts_losses)
    }
}

/// Unpacks a message that rosbag2 compressed individually. CDR never begins like Zstandard.
fn unpack(body: &mut Vec<u8>, lost: &mut Vec<String>) {
    const ZSTANDARD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
    if !body.starts_with(&ZSTANDARD) {
        return;
    }
    let mut plain = Vec::new();
    match Zstandard::new(body.as_slice()).and_then(|mut packed| packed.read_to_end(&mut plain)) {
        Ok(_) => *body = plain,
        Err(error) => {
            let what = format!("a compressed message is lost: {error}");
            lost.extend((!lost.contains(&what)).then_some(what));
        }
    }
}
