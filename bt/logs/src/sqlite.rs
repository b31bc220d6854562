//! `SqliteLogger`: a table of sessions with their trees, and one of all transitions.

use std::fs;
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags, OptionalExtension as _, params};
use tempfile::TempDir;

use crate::error::LogError;
use crate::status::LoggedTransition;
use crate::tree::MAX_XML_BYTES;

/// The transitions of a session.
#[derive(Debug)]
pub(crate) struct SqliteLog {
    file: Connection,
    session: i64,
    /// The time of the next transition, or one before it; none if there can be none. No two have the same.
    from_us: Option<i64>,
    _copy: Option<TempDir>,
}

/// Opens a session of a file: the last one if none is named. Returns its tree's XML, its number, how many sessions
/// there are, and its transitions.
pub(crate) fn open(path: &Path, session: Option<i64>) -> Result<(String, i64, u64, SqliteLog), LogError> {
    let damaged = |problem: String| LogError::Damaged { path: path.to_owned(), problem };
    let failed = |error: rusqlite::Error| damaged(error.to_string());
    let (file, copy) = connect(path)?;
    let tables = "SELECT COUNT(*) FROM sqlite_schema WHERE name IN ('Definitions', 'Transitions', 'Nodes')";
    if file.query_row(tables, [], |row| row.get::<_, i64>(0)).map_err(failed)? < 3 {
        return Err(LogError::Foreign(path.to_owned()));
    }
    let counted = "SELECT COUNT(*), MAX(session_id) FROM Definitions";
    let (of, last) = file
        .query_row(counted, [], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, Option<i64>>(1)?)))
        .map_err(failed)?;
    let last = last.ok_or_else(|| damaged("it has no session".to_owned()))?;
    let number = session.unwrap_or(last);
    let definition = "SELECT xml_tree FROM Definitions WHERE session_id = ?1 AND length(xml_tree) <= ?2";
    let limit = i64::try_from(MAX_XML_BYTES).unwrap_or(i64::MAX);
    let xml: Option<String> =
        file.query_row(definition, params![number, limit], |row| row.get(0)).optional().map_err(failed)?;
    let xml = xml.ok_or_else(|| {
        let known =
            format!("its sessions are numbered up to {last}, and at most {MAX_XML_BYTES} bytes of a tree are read");
        damaged(format!("it has no session {number} with a tree that can be read: {known}"))
    })?;
    // What an earlier session logged need not be passed by for every transition.
    let first = "SELECT MIN(timestamp) FROM Transitions WHERE session_id = ?1";
    let first: Option<i64> = file.query_row(first, [number], |row| row.get(0)).map_err(failed)?;
    Ok((xml, number, of.unsigned_abs(), SqliteLog { file, session: number, from_us: first, _copy: copy }))
}

/// Opens the file for reading. What a killed program was about to write is in a file beside it: SQLite undoes or
/// completes that, in copies of both.
fn connect(path: &Path) -> Result<(Connection, Option<TempDir>), LogError> {
    let read = |source| LogError::Read { path: path.to_owned(), source };
    let beside = ["-journal", "-wal"].map(|ending| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        (ending, PathBuf::from(name))
    });
    let (mut opened, mut flags, mut copy) = (path.to_owned(), OpenFlags::SQLITE_OPEN_READ_ONLY, None);
    if beside.iter().any(|(_, path)| path.is_file()) {
        let folder = tempfile::tempdir().map_err(read)?;
        opened = folder.path().join("log");
        fs::copy(path, &opened).map_err(read)?;
        for (ending, path) in beside.iter().filter(|(_, path)| path.is_file()) {
            fs::copy(path, folder.path().join(format!("log{ending}"))).map_err(read)?;
        }
        (flags, copy) = (OpenFlags::SQLITE_OPEN_READ_WRITE, Some(folder));
    }
    let file = Connection::open_with_flags(opened, flags | OpenFlags::SQLITE_OPEN_NO_MUTEX);
    let file = file.map_err(|error| LogError::Damaged { path: path.to_owned(), problem: error.to_string() })?;
    Ok((file, copy))
}

impl SqliteLog {
    pub(crate) fn next_transition(&mut self, path: &Path) -> Result<Option<LoggedTransition>, LogError> {
        let Some(from_us) = self.from_us else { return Ok(None) };
        // One query per row, found by its primary key: a statement that stays open would borrow from the connection
        // beside it.
        let query = "SELECT timestamp, node_uid, state FROM Transitions WHERE timestamp >= ?1 AND session_id = ?2 \
                     ORDER BY timestamp LIMIT 1";
        let read = |row: &rusqlite::Row<'_>| {
            Ok(LoggedTransition { at_us: row.get(0)?, uid: row.get(1)?, status: row.get(2)? })
        };
        let row: rusqlite::Result<Option<LoggedTransition>> = self
            .file
            .prepare_cached(query)
            .and_then(|mut query| query.query_row(params![from_us, self.session], read).optional());
        let damaged = |problem| LogError::Damaged { path: path.to_owned(), problem };
        let row = row.map_err(|error| damaged(error.to_string()))?;
        if let Some(LoggedTransition { at_us, .. }) = row {
            // SQLite does not check the order in which it finds rows. Without this, such a file would have no end.
            if at_us < from_us {
                return Err(damaged("its transitions are not in the order of their times".to_owned()));
            }
            self.from_us = at_us.checked_add(1);
        }
        Ok(row)
    }
}
