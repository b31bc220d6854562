//! SQLite files, rosbag2's first format.

use std::collections::BTreeMap;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags, OptionalExtension as _, params};
use tempfile::{NamedTempFile, TempPath};

use super::source::Wanted;
use super::survey::{Definition, Head, Survey, Topic, hash};
use crate::Error;

/// Adds the contents of a file.
pub(super) fn survey(path: &Path, survey: &mut Survey) -> Result<(), Error> {
    let Opened { file, _copy, .. } = open(path)?;
    let refused = |error: rusqlite::Error| Error::Sqlite { path: path.to_owned(), problem: error.to_string() };
    // Since Humble, rosbag2 writes the distribution, or nothing if its environment does not name it.
    let distribution = file.query_row("SELECT ros_distro FROM schema", [], |row| row.get::<_, String>(0));
    survey.distributions.extend(distribution.ok().filter(|name| !name.is_empty()));
    for (id, topic) in topics(&file).map_err(refused)? {
        let index = survey.add(topic);
        let counted =
            file.query_row("SELECT COUNT(*) FROM messages WHERE topic_id = ?1", [id], |row| row.get::<_, i64>(0));
        // Whatever can be read of a damaged file counts.
        survey.counts[index] += counted.map_or(0, |count| count.max(0) as u64);
    }
    let span = file.query_row("SELECT MIN(timestamp), MAX(timestamp) FROM messages", [], |row| {
        Ok(row.get::<_, Option<i64>>(0)?.zip(row.get::<_, Option<i64>>(1)?))
    });
    if let Ok(Some((first, last))) = span {
        survey.note_times(first, last);
    }
    Ok(())
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
    // SQLite reads the missing part of a page as zeros, and so would read messages that nobody sent.
    let copy = if length.is_multiple_of(page) { None } else { Some(whole_pages(path, length - length % page)) };
    let copy = copy.transpose().map_err(|error| refused(error.to_string()))?;
    let opened: &Path = copy.as_deref().unwrap_or(path);
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let file = Connection::open_with_flags(opened, flags).map_err(|error| refused(error.to_string()))?;
    // Otherwise SQLite refuses a file that is shorter than its header says.
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

/// The wanted messages of a file.
pub(super) struct SqliteReader {
    path: PathBuf,
    opened: Opened,
    /// The wanted topics by their ids in the file.
    topics: BTreeMap<i64, usize>,
    query: String,
    /// When the first message of the bag was recorded.
    first_ns: i64,
    /// The last row read, and when its message was recorded.
    last: (i64, Option<i64>),
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
            "SELECT id, topic_id, timestamp, data FROM messages WHERE id > ?1 AND topic_id IN ({}) ORDER BY id LIMIT 1",
            ids.join(", ")
        );
        let first_ns = survey.first_ns();
        Ok(Self { path: path.to_owned(), opened, topics, query, first_ns, last: (i64::MIN, None) })
    }

    pub(super) fn next_into(&mut self, body: &mut Vec<u8>, lost: &mut Vec<String>) -> Option<Head> {
        // One query per row, found by its primary key: a statement that stays open would borrow from the connection
        // beside it.
        let row = self.opened.file.prepare_cached(&self.query).and_then(|mut query| {
            let read = |row: &rusqlite::Row<'_>| {
                body.clear();
                body.extend_from_slice(row.get_ref(3)?.as_blob()?);
                Ok((row.get(0)?, row.get::<_, i64>(1)?, row.get(2)?))
            };
            query.query_row(params![self.last.0], read).optional()
        });
        match row {
            Ok(None) => {
                if std::mem::take(&mut self.opened.is_cut_off) {
                    lost.push(self.breaks_off(""));
                }
                None
            }
            Ok(Some((id, topic, log_ns))) => {
                self.last = (id, Some(log_ns));
                Some(Head { topic: *self.topics.get(&topic)?, log_ns, publish_ns: log_ns })
            }
            Err(error) => {
                lost.push(self.breaks_off(&format!(" ({error})")));
                self.opened.is_cut_off = false;
                // From here on, no row is found, rather than the same error again.
                self.query = "SELECT 0, 0, 0, 0 WHERE ?1 IS NULL".to_owned();
                None
            }
        }
    }

    fn breaks_off(&self, reason: &str) -> String {
        let since = self
            .last
            .1
            .map_or_else(|| "before its first message".to_owned(), |last| crate::after_first(last, self.first_ns));
        format!("{} breaks off {since}{reason}: the rest is lost", self.path.display())
    }
}
