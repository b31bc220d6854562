//! SQLite files, rosbag2's first format.

use std::collections::BTreeMap;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags, params};
use tempfile::{NamedTempFile, TempPath};

use super::merge::{Block, Plan, UNIT, Unit};
use super::source::Wanted;
use super::survey::{Definition, Head, Survey, Topic, hash};
use crate::Error;

/// Adds the contents of a file. Returns where its messages are.
pub(super) fn survey(path: &Path, survey: &mut Survey) -> Result<Plan, Error> {
    let Opened { file, is_cut_off, _copy } = open(path)?;
    let refused = |error: rusqlite::Error| Error::Sqlite { path: path.to_owned(), problem: error.to_string() };
    // Since Humble, rosbag2 writes the distribution, or nothing if its environment does not name it.
    let distribution = file.query_row("SELECT ros_distro FROM schema", [], |row| row.get::<_, String>(0));
    survey.distributions.extend(distribution.ok().filter(|name| !name.is_empty()));
    let known = topics(&file).map_err(refused)?;
    let known: BTreeMap<i64, usize> = known.into_iter().map(|(id, topic)| (id, survey.add(topic))).collect();
    let mut plan = Plan::default();
    // Whatever can be read of a damaged file counts; what is lost will be reported when the messages are read.
    let mut unknown = 0_u64;
    let _ = divide(&file, &mut plan, |topic, time_ns| match known.get(&topic) {
        Some(topic) => survey.count(*topic, time_ns),
        None => {
            unknown += 1;
            survey.note_times(time_ns, time_ns);
        }
    });
    if unknown > 0 {
        let what = format!("{} has {unknown} messages of topics that it does not have", path.display());
        survey.lost.push(what);
    }
    if is_cut_off {
        plan.lost.push(breaks_off(path, plan.units.last().map(|unit| unit.last_ns), survey.first_ns(), ""));
    }
    Ok(plan)
}

/// Divides the messages into units, by the ids of their rows, which are in the order of recording.
fn divide(file: &Connection, plan: &mut Plan, mut counted: impl FnMut(i64, i64)) -> rusqlite::Result<()> {
    let mut unit = Unit::empty(i64::MIN);
    let mut size = 0;
    let mut rows = || -> rusqlite::Result<()> {
        // Only the heads of the rows are read.
        let mut query = file.prepare("SELECT id, topic_id, timestamp, LENGTH(data) FROM messages ORDER BY id")?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let (id, time_ns) = (row.get(0)?, row.get(2)?);
            if size >= UNIT {
                let next = Unit::empty(id);
                plan.units.push(Unit { end: id, ..std::mem::replace(&mut unit, next) });
                size = 0;
            }
            size += row.get::<_, Option<i64>>(3)?.unwrap_or(0).unsigned_abs() + 32;
            unit.note(time_ns);
            counted(row.get(1)?, time_ns);
        }
        Ok(())
    };
    let read = rows();
    if unit.is_empty() {
        unit.note(i64::MIN);
    }
    plan.units.push(unit);
    read
}

/// An open file; if it is cut off within a page, a copy of its whole pages.
struct Opened {
    file: Connection,
    is_cut_off: bool,
    _copy: Option<TempPath>,
}

fn open(path: &Path) -> Result<Opened, Error> {
    let length = std::fs::metadata(path).map_or(0, |found| found.len());
    let refused = |problem: String| Error::Sqlite { path: path.to_owned(), problem };
    let (page, pages) = pages_of(path).ok_or_else(|| refused("it ends within its first page".to_owned()))?;
    // SQLite reads the missing part of a page as zeros, and so would read messages that were never sent.
    let copy = if length.is_multiple_of(page) { None } else { Some(whole_pages(path, length - length % page)) };
    let copy = copy.transpose().map_err(|error| refused(error.to_string()))?;
    let opened: &Path = copy.as_deref().unwrap_or(path);
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let file = Connection::open_with_flags(opened, flags).map_err(|error| refused(error.to_string()))?;
    // Otherwise SQLite refuses a file that is shorter than its header states.
    file.pragma_update(None, "writable_schema", true).map_err(|error| refused(error.to_string()))?;
    Ok(Opened { file, is_cut_off: length < page * pages, _copy: copy })
}

/// The page size and the number of pages, according to the file's header.
fn pages_of(path: &Path) -> Option<(u64, u64)> {
    let mut head = [0; 32];
    diagnostics::open_regular(path).ok()?.read_exact(&mut head).ok()?;
    let page = match u16::from_be_bytes([head[16], head[17]]) {
        1 => 1 << 16,
        size => u64::from(size),
    };
    (page >= 512).then(|| (page, u64::from(u32::from_be_bytes([head[28], head[29], head[30], head[31]]))))
}

fn whole_pages(path: &Path, length: u64) -> io::Result<TempPath> {
    let mut copy = NamedTempFile::new()?;
    io::copy(&mut diagnostics::open_regular(path)?.take(length), &mut copy)?;
    Ok(copy.into_temp_path())
}

/// The topics of a file by their ids. Up to Humble, rosbag2 wrote neither definitions nor hashes.
fn topics(file: &Connection) -> rusqlite::Result<Vec<(i64, Topic)>> {
    let has_definitions =
        file.prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
    let mut definitions = BTreeMap::new();
    if let Ok(mut rows) = has_definitions {
        for row in rows.query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))? {
            let (kind, language, text): (String, String, String) = row?;
            if !language.is_empty() {
                definitions.insert(kind, Definition { language, text });
            }
        }
    }
    let columns =
        |hash| file.prepare(&format!("SELECT id, name, type, serialization_format, {hash} FROM topics ORDER BY id"));
    let mut rows = columns("type_description_hash").or_else(|_| columns("''"))?;
    let topics = rows.query_map([], |row| {
        let kind: String = row.get(2)?;
        let (definition, hash) = (definitions.get(&kind).cloned(), hash(&row.get::<_, String>(4)?));
        Ok((row.get(0)?, Topic { name: row.get(1)?, kind, encoding: row.get(3)?, definition, hash }))
    })?;
    topics.collect()
}

/// Reads the units of a file.
pub(super) struct SqliteReader {
    path: PathBuf,
    opened: Opened,
    /// The wanted topics by their ids in the file.
    topics: BTreeMap<i64, usize>,
    query: String,
    /// When the first message of the bag was recorded.
    first_ns: i64,
    /// When the last message that was read was recorded.
    last_ns: Option<i64>,
}

impl SqliteReader {
    pub(super) fn open(path: &Path, wanted: &Wanted, survey: &mut Survey) -> Result<Self, Error> {
        let opened = open(path)?;
        let known = topics(&opened.file)
            .map_err(|error| Error::Sqlite { path: path.to_owned(), problem: error.to_string() })?;
        let index = |(id, topic): &(i64, Topic)| Some((*id, wanted.index(topic, survey)?));
        let topics: BTreeMap<i64, usize> = known.iter().filter_map(index).collect();
        let ids: Vec<String> = topics.keys().map(i64::to_string).collect();
        let query = format!(
            "SELECT topic_id, timestamp, data FROM messages WHERE id >= ?1 AND id < ?2 AND topic_id IN ({}) ORDER BY id",
            ids.join(", ")
        );
        let first_ns = survey.first_ns();
        Ok(Self { path: path.to_owned(), opened, topics, query, first_ns, last_ns: None })
    }

    /// Reads the wanted messages of a unit.
    pub(super) fn load(&mut self, unit: &Unit, block: &mut Block, lost: &mut Vec<String>) {
        let read = self.read(unit, block);
        let is_last = unit.end == i64::MAX;
        let reason = read.err().map(|error| format!(" ({error})"));
        if reason.is_some() || is_last && self.opened.is_cut_off {
            lost.push(breaks_off(&self.path, self.last_ns, self.first_ns, &reason.unwrap_or_default()));
        }
    }

    fn read(&mut self, unit: &Unit, block: &mut Block) -> rusqlite::Result<()> {
        let mut query = self.opened.file.prepare_cached(&self.query)?;
        let mut rows = query.query(params![unit.start, unit.end])?;
        while let Some(row) = rows.next()? {
            let log_ns = row.get(1)?;
            self.last_ns = Some(log_ns);
            let Some(topic) = self.topics.get(&row.get(0)?) else { continue };
            let Some(number) = block.place(log_ns) else { continue };
            let (data, at) = (row.get_ref(2)?.as_blob()?, block.bytes.len());
            block.bytes.extend_from_slice(data);
            block.add(Head { topic: *topic, log_ns, publish_ns: log_ns }, number, at, data.len());
            if block.is_full(0) {
                block.shorten();
            }
        }
        Ok(())
    }
}

/// That the rest of a file is lost, in words.
fn breaks_off(path: &Path, last_ns: Option<i64>, first_ns: i64, reason: &str) -> String {
    let since =
        last_ns.map_or_else(|| "before its first message".to_owned(), |last| crate::after_first(last, first_ns));
    format!("{} breaks off {since}{reason}: the rest is lost", path.display())
}
